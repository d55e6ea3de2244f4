"""The motion of a planar machine without clearance and the forces in its joints."""

import functools
import math
import pickle
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ....contracts.machine import (
    GROUND,
    BodyPoint,
    Braking,
    Constant,
    Guide,
    Machine,
    Mesh,
    Motor,
    OwnPush,
    Path,
    Push,
    Rubbing,
    Schedule,
    Slot,
    Spring,
    Stretch,
    TabledPush,
    TorsionSpring,
)
from ....tracing.compiled.choosing import directions
from ....tracing.compiled.family import Identity
from ...laws.friction import friction_force, friction_in_pin, without_history
from ..contract import IdealMotion
from ..programs import shared_by
from .closure import STATIONS, Closure, MachineStates, Rivals, interpolate
from .drives import compile_drive, motion_at, motion_table, passage_time, scheduled_passage, torque_at
from .form import Bent, Housing, Mass, Segment, compile_bent
from .free_crank import CrankHistory, CrankPassage
from .load_forms import applied_load, compile_table, evaluate_table
from .stations import determined, geometry_of, initial_coordinate, stations_of
from .structure import ANGLE, BEND, INTEGRAL, SHIFT_X, SHIFT_Y, TRAVEL, Coordinate

# ---------------------------------------------------------------------------------------------- motion and forces


LARGEST_BLOCK = 2 * STATIONS  # angles evaluated together: larger arrays would be new memory each time
SWEEPS = 200  # iterations over reactions and the friction that they cause
CONVERGED = 1e-14  # of the largest of these


class IdealMachine:
    """A machine without clearance, closed at stations of a revolution of its crank."""

    def __init__(self, machine: Machine):
        self.full_machine, self.machine = machine, _without_history(determined(machine))
        self.closure = Closure(self.machine)
        self.stations = stations_of(self.machine)
        self.revolution = self.stations.states
        is_singular = np.isnan(self.revolution.inverse.matrices[:, 0, 0])
        self._near_change_points = is_singular[:-1] | is_singular[1:]  # (STATIONS,) intervals
        runs = np.split(np.flatnonzero(is_singular), 1 + np.flatnonzero(np.diff(np.flatnonzero(is_singular)) > 1))
        self.change_points = [float(np.mean(self.revolution.angles[run])) for run in runs if run.size]  # rad
        if is_singular[0] and len(self.change_points) > 1:  # the first and the last are one
            self.change_points[0] = float(self.revolution.angles[0])
            del self.change_points[-1]
        masses = masses_of(rigid(self.machine))
        self.inertia = np.concatenate([[body.mass, body.mass, body.inertia] for body in masses])
        self.heavy = np.array([0.0 if isinstance(body, Housing) else body.mass for body in masses])  # kg, with weight
        self.friction_loads = [load for load in self.machine.loads if isinstance(load, (Rubbing, Braking))]
        self.tables = {load.name: compile_table(load) for load in machine.loads if isinstance(load, TabledPush)}
        self.compiled_by_open_joints: dict[frozenset[str], Any] = {}  # compiled machine by the names of its open joints
        self._passage: CrankPassage | None = None  # motion of a free crank, as far as requested
        self._history: CrankHistory | None = None  # the same over time

    def states_at(self, angles: np.ndarray) -> MachineStates:
        """Return the machine at crank angles (N,) rad, unwrapped from its start."""
        return self._close(angles) if len(angles) < STATIONS else self.stations.states_at(angles, self._close)

    def _close(self, angles: np.ndarray) -> MachineStates:
        """Return the machine closed anew at crank angles (N,) rad."""
        states = interpolate(self.revolution, angles)
        closed = self.closure.close(states.q, angles)[0]
        if self.change_points:
            turns = (angles - self.revolution.angles[0]) / (2.0 * math.pi)
            is_near = self._near_change_points[(STATIONS * (turns - np.floor(turns))).astype(int)]
            for values, interpolated in zip(closed[1:4], states[1:4], strict=True):
                values[is_near] = interpolated[is_near]
            closed.inverse.matrices[is_near] = math.nan
        return closed

    def is_near_change_point(self, station: int) -> bool:
        """Return whether the machine is interpolated at a station, or next to it, because its loops may branch."""
        return bool(self._near_change_points[station % STATIONS])

    def output_at(self, states: MachineStates) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the output and its first two derivatives by the crank's angle."""
        aim, q, derivative, second_derivative = self.machine.aim, states.q, states.derivative, states.second_derivative
        i = 3 * self.closure.index[aim.body]
        if not aim.point:
            return q[:, i + 2], derivative[:, i + 2], second_derivative[:, i + 2]
        body = self.machine.bodies[aim.body]
        x, y = np.subtract(body.points[aim.point], body.center)
        c, s = math.cos(aim.direction), math.sin(aim.direction)
        cosine, sine = directions(q[:, i + 2])
        axial = c * (x * cosine - y * sine) + s * (x * sine + y * cosine)  # of the arm, along and across the direction
        transverse = c * (-x * sine - y * cosine) + s * (x * cosine - y * sine)
        angle_derivative, angle_second = derivative[:, i + 2], second_derivative[:, i + 2]
        return (
            c * q[:, i] + s * q[:, i + 1] + axial,
            c * derivative[:, i] + s * derivative[:, i + 1] + transverse * angle_derivative,
            c * second_derivative[:, i]
            + s * second_derivative[:, i + 1]
            + transverse * angle_second
            - axial * angle_derivative**2,
        )

    def displaced_states(self, offsets: Mapping, angle: float) -> MachineStates:
        """Return the machine at a crank angle with joints displaced by `offsets`; nan if that is impossible."""
        nearest_station = int(np.argmin(np.abs(self.revolution.angles - angle)))
        if not offsets and self.is_near_change_point(nearest_station):
            return self._close(np.array([angle]))
        displaced = Closure(self.machine, offsets)
        return displaced.close(self.revolution.q[nearest_station][None], np.array([angle]))[0]

    def coordinate(self, coordinate: Coordinate, states: MachineStates) -> tuple[np.ndarray, np.ndarray]:
        """Return a coordinate of the whole machine and its derivative by the crank's angle, each (...).

        A coordinate that the ideal machine does not determine keeps its initial value; a link that bends is straight.
        """
        if coordinate.kind in (BEND, INTEGRAL):
            return np.zeros(states.q.shape[:-1]), np.zeros(states.q.shape[:-1])
        if coordinate.kind != TRAVEL:
            name = [name for name in self.full_machine.bodies if name != GROUND][coordinate.owner - 1]
            if name not in self.closure.index:
                initial = self.full_machine.bodies[name].initial
                return np.full(states.q.shape[:-1], initial_coordinate(initial, coordinate.kind)[0]), np.zeros(
                    states.q.shape[:-1]
                )
            i = 3 * self.closure.index[name] + {ANGLE: 2, SHIFT_X: 0, SHIFT_Y: 1}[coordinate.kind]
            return states.q[..., i], states.derivative[..., i]
        joint = self.full_machine.joints[coordinate.owner]
        direction = joint.axis + self.closure.angle(joint.proximal.body, states.q)
        spin = self.closure.angle(joint.proximal.body, states.derivative)
        c, s = directions(direction)
        proximal, distal = (
            self.closure.point_motion(endpoint, states.q, states.derivative)
            for endpoint in (joint.proximal, joint.distal)
        )
        x, y, dx, dy = (distal.x - proximal.x, distal.y - proximal.y, distal.dx - proximal.dx, distal.dy - proximal.dy)
        return c * x + s * y, c * dx + s * dy + spin * (c * y - s * x)

    @shared_by(lambda ideal, coordinate: (geometry_of(ideal.full_machine), coordinate), 256)
    def coordinate_over_revolution(self, coordinate: Coordinate) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return a coordinate at the stations and its derivatives by the crank's angle, the second approximately.

        Machines that differ in masses, loads and speeds share these arrays.
        """
        values, slopes = self.coordinate(coordinate, self.revolution)
        return values, slopes, np.gradient(slopes, self.revolution.angles, edge_order=2)

    @shared_by(lambda ideal: (geometry_of(ideal.full_machine), ideal.machine.aim))
    def output_over_revolution(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the output at the stations and its first two derivatives by the crank's angle, shared likewise."""
        return self.output_at(self.revolution)

    def motion(self, at: np.ndarray, compiled_form: Callable[[], tuple], *, over_time: bool = False) -> IdealMotion:
        """Return the motion of the output and the reactions at crank angles (N,) rad from its start on.

        compiled_form : returns the compiled form of the machine, for a free crank.  over_time : `at` are times (s).
        """
        angles, time, rate = self.passage_at(at, compiled_form, over_time)
        states = self.states_at(angles)
        position, derivative, second_derivative = self.output_at(states)
        acceleration, reactions, effective_forces = self.balance(states, rate, time)
        return IdealMotion(
            position,
            derivative * rate,
            second_derivative * rate**2 + derivative * acceleration,
            reactions,
            # the drive's on the crank, by virtual work: joints do none as the crank turns
            -np.sum(states.derivative * effective_forces, -1),
        )

    def reactions(
        self, at: np.ndarray, compiled_form: Callable[[], tuple], *, over_time: bool = False
    ) -> dict[str, np.ndarray]:
        """Return the force (N, 2) N on each joint's distal body, as `motion` does."""
        motion = np.stack(self.passage_at(at, compiled_form, over_time))
        parts = np.array_split(motion, max(len(at) // LARGEST_BLOCK, 1), axis=1)
        reactions = [self.balance(self.states_at(angles), rate, time)[1] for angles, time, rate in parts]
        return {name: np.concatenate([part[name] for part in reactions]) for name in reactions[0]}

    def passage_at(self, at: np.ndarray, compiled_form: Callable[[], tuple], over_time: bool) -> tuple:
        """Return crank angles (N,) rad, times (N,) s and rates (N,) rad/s at angles, or at times if `over_time`."""
        if not over_time:
            return at, *self.crank_passage(at, compiled_form)
        if not isinstance(self.machine.drive, Motor):
            angles, rates, _ = motion_at(self.machine.drive, at)
            return angles, at, rates
        last_time = float(np.max(at))
        if self._history is None or self._history.end < last_time:
            self._history = CrankHistory(self.machine.drive, compiled_form(), self.reference_rate(), last_time)
        angles, rates, _ = self._history.motion_at(at)
        return np.where(np.isnan(angles), self.revolution.angles[0], angles), at, rates  # unknown where the rate is nan

    def crank_passage(self, angles: np.ndarray, compiled_form: Callable[[], tuple]) -> tuple[np.ndarray, np.ndarray]:
        """Return the times (s) at which the crank passes angles (rad), and its rates (rad/s); nan if it never passes.

        compiled_form : as for `motion`
        """
        drive = self.machine.drive
        if isinstance(drive, Constant):
            return (angles - drive.start_angle) / drive.speed, np.full(len(angles), drive.speed)
        if isinstance(drive, Schedule):
            return scheduled_passage(drive, angles)[:2]
        if isinstance(drive, Path):
            times = np.array([passage_time(drive, angle) for angle in angles.tolist()])
            return times, motion_at(drive, times)[1]
        last_angle = float(np.max(angles))
        if self._passage is None or self._passage.end < last_angle:
            self._passage = CrankPassage(drive, compiled_form(), self.reference_rate(), last_angle)
        return self._passage.passage_at(angles)

    # ------------------------------------------------------------------------------------------ forces

    def static_extensions(self, angle: float, rate: float) -> dict[str, float]:
        """Return the extension (m) of each spring of a link under the forces of the ideal motion at the start.

        angle : of the crank, rad; rate : its rate, rad/s
        """
        states = self._close(np.array([angle]))
        _, _, effective_forces = self.balance(states, np.array([rate]), np.zeros(1))
        assert states.inverse is not None  # of states that were closed
        tensions = states.inverse.multipliers(effective_forces)[0, self.closure.first_rows[-1] :]
        return {
            spring.name: float(tension) / spring.stiffness
            for spring, tension in zip(self.closure.springs, tensions, strict=False)
            if not self.machine.bodies[spring.distal.body].mounted  # a housing starts where its springs are at rest
        }

    def balance(self, states: MachineStates, rate: np.ndarray, time: np.ndarray) -> tuple:
        """Return the angular acceleration (N,) of the crank, the reactions, and the effective forces (N, 3 bodies).

        Reactions are the forces (N, 2) N on each joint's distal body; effective forces are those applied to the bodies
        minus their inertia.
        """
        applied_forces = self.applied_forces(states, rate, time)
        assert states.inverse is not None  # of states that were closed
        multipliers_of = states.inverse.multipliers
        first_rows = self.closure.first_rows

        def solve(friction):
            forces = applied_forces + friction if self.friction_loads else applied_forces
            acceleration = self.crank_acceleration(states, rate, time, forces)
            effective_forces = states.derivative * acceleration[:, None]
            effective_forces += states.second_derivative * (rate**2)[:, None]
            effective_forces *= -self.inertia
            effective_forces += forces
            multipliers = multipliers_of(effective_forces)
            reactions = {
                joint.name: self.reaction_of(joint, states, multipliers[:, first_row:last_row])
                for joint, first_row, last_row in zip(self.machine.joints, first_rows, first_rows[1:], strict=False)
            }
            self.add_tooth_forces(reactions, states)
            return reactions, acceleration, effective_forces

        reactions, acceleration, effective_forces = self.with_friction(states, rate, solve)
        return acceleration, reactions, effective_forces

    def with_friction(self, states: MachineStates, rate: np.ndarray, solve: Callable[[np.ndarray], tuple]) -> tuple:
        """Iterate over reactions and the friction that they cause; return the last result of `solve`.

        solve : returns the reactions by joint, and further results, from forces of friction (N, 3 bodies)
        """
        friction = np.zeros_like(states.q)
        for _ in range(SWEEPS):
            result = solve(friction)
            if not self.friction_loads:
                break
            last_friction, friction = friction, self.friction_forces(self.friction_loads, states, rate, result[0])
            if np.max(np.abs(friction - last_friction)) <= CONVERGED * np.max(np.abs(friction)):
                break
        return result

    def applied_forces(self, states: MachineStates, rate: np.ndarray, time: np.ndarray) -> np.ndarray:
        """Return the forces (N, 3 bodies) of gravity and of all loads except friction, about the centres of mass."""
        force = np.zeros_like(states.q)
        force[:, 1::3] -= self.heavy * self.machine.gravity
        for load in self.machine.loads:
            if isinstance(load, Spring):
                self._add_spring(load, states, rate, force)
            elif isinstance(load, TorsionSpring):
                self._add_torsion_spring(load, states, rate, force)
            elif isinstance(load, TabledPush):
                load_values = evaluate_table(self.tables[load.name], states.angles if load.over == "angle" else time)
                self.add_force(force, states, load.at, load_values[:, :2], load_values[:, 2])
            elif isinstance(load, OwnPush):
                values = self._own_load(load, states, rate, time)
                self.add_force(force, states, load.at, values[:, :2], values[:, 2])
            elif isinstance(load, Push):
                load_force = np.tile([load.fx, load.fy], (len(states.q), 1))
                self.add_force(force, states, load.at, load_force, np.full(len(states.q), load.torque))
        return force

    def _own_load(self, load: OwnPush, states: MachineStates, rate: np.ndarray, time: np.ndarray) -> np.ndarray:
        """Return force x, y (N) and torque (N m) of a load of one's own, (N, 3)."""
        motion = self.closure.point_motion(load.at, states.q, states.derivative)
        columns = time, states.angles, motion.x, motion.y, rate * motion.dx, rate * motion.dy
        rows = np.stack(np.broadcast_arrays(*columns, np.zeros(len(states.q)))[:-1], -1).tolist()
        return np.array([applied_load(load.law, t, angle, (x, y), (vx, vy)) for t, angle, x, y, vx, vy in rows])

    def crank_acceleration(self, states: MachineStates, rate, time, force: np.ndarray) -> np.ndarray:
        """Return the crank's angular acceleration (rad/s^2): generalised force over generalised inertia."""
        drive = self.machine.drive
        if isinstance(drive, Constant):
            return np.zeros(len(rate))
        if isinstance(drive, (Schedule, Path)):
            return motion_at(drive, time)[2]
        momentum = self.inertia * states.derivative  # per rate of the crank
        generalised_inertia = np.einsum("ni,ni->n", momentum, states.derivative)
        centripetal = np.einsum("ni,ni->n", momentum, states.second_derivative) * rate**2
        load_torque = np.einsum("ni,ni->n", states.derivative, force) - centripetal
        integral = self._history.motion_at(time)[2] if self._history else np.zeros(len(rate))
        torques = np.vectorize(functools.partial(torque_at, compile_drive(drive)), otypes=[float])(
            states.angles, rate, time, integral
        )
        return (torques + load_torque) / generalised_inertia

    def add_force(self, force, states: MachineStates, endpoint: BodyPoint, applied: np.ndarray, torque) -> None:
        """Add a force (N, 2) at a point of a body, and a torque (N,), to the forces on all bodies."""
        if endpoint.body == GROUND:
            return
        i = 3 * self.closure.index[endpoint.body]
        motion = self.closure.point_motion(endpoint, states.q, states.derivative)
        force[:, i : i + 2] += applied
        force[:, i + 2] += motion.lever_x * applied[:, 0] + motion.lever_y * applied[:, 1] + torque

    def _add_spring(self, load: Spring, states: MachineStates, rate, forces) -> None:
        first_point, second_point = (
            self.closure.point_motion(endpoint, states.q, states.derivative) for endpoint in (load.first, load.second)
        )
        x, y = second_point.x - first_point.x, second_point.y - first_point.y
        length = np.hypot(x, y)
        divisor = np.where((length > 0.0) | (load.free_length > 0.0), length, 1.0)  # see `kinematics.Bodies`
        direction = np.stack([x, y], -1) / divisor[:, None]
        extension_rate = (x * (second_point.dx - first_point.dx) + y * (second_point.dy - first_point.dy)) / divisor
        tension = load.stiffness * (length - load.free_length) + load.damping * rate * extension_rate
        self.add_force(forces, states, load.first, tension[:, None] * direction, 0.0)
        self.add_force(forces, states, load.second, -tension[:, None] * direction, 0.0)

    def _add_torsion_spring(self, load: TorsionSpring, states: MachineStates, rate, forces) -> None:
        twist, twist_rate = (
            self.closure.angle(load.second.body, q) - self.closure.angle(load.first.body, q)
            for q in (states.q, states.derivative)
        )
        torque = load.stiffness * (twist - load.free_angle) + load.damping * rate * twist_rate
        no_force = np.zeros((len(states.q), 2))
        self.add_force(forces, states, load.first, no_force, torque)
        self.add_force(forces, states, load.second, no_force, -torque)

    def friction_forces(self, friction_loads: list, states: MachineStates, rate, reactions) -> np.ndarray:
        """Return the forces (N, 3 bodies) of friction in joints under their reactions."""
        forces_on_bodies = np.zeros_like(states.q)
        for load in friction_loads:
            joint = next(joint for joint in self.machine.joints if joint.name == load.joint)
            normal = np.hypot(*reactions[joint.name].T)
            if isinstance(load, Braking):
                normal = np.full(len(rate), load.normal)
            turning_rates = [
                self.closure.angle(endpoint.body, states.derivative) * rate
                for endpoint in (joint.distal, joint.proximal)
            ]
            slip = load.radius * (turning_rates[0] - turning_rates[1])
            if isinstance(joint, Guide):
                slip = self.coordinate(Coordinate(TRAVEL, self.machine.joints.index(joint)), states)[1] * rate
            in_pin = isinstance(load, Rubbing) and not isinstance(joint, Guide)
            law = friction_in_pin if in_pin else friction_force
            friction = np.array([law(load.friction, n, v) for n, v in zip(normal, slip, strict=True)])
            direction = (
                joint.axis + self.closure.angle(joint.proximal.body, states.q) if isinstance(joint, Guide) else 0.0
            )
            friction_vector = (
                friction[:, None] * np.stack(directions(direction), -1) if isinstance(joint, Guide) else 0.0
            )
            for endpoint, sign in ((joint.distal, 1.0), (joint.proximal, -1.0)):
                zero = np.zeros((len(rate), 2))
                torque = 0.0 if isinstance(joint, Guide) else sign * load.radius * friction
                self.add_force(forces_on_bodies, states, endpoint, zero + sign * friction_vector, torque)
        return forces_on_bodies

    def reaction_of(self, joint, states: MachineStates, multipliers: np.ndarray) -> np.ndarray:
        """Return the force (N, 2) N on a joint's distal body from the multipliers of its constraints.

        Of a gear it is the force on the drive flank minus that on the coast flank, of a coupling the torque, and 0.
        """
        if isinstance(joint, Mesh):
            return np.stack([-multipliers[:, 0] / joint.arm, np.zeros(len(multipliers))], -1)
        if isinstance(joint, Guide | Stretch | Slot):
            c, s = directions(joint.axis + self.closure.angle(joint.proximal.body, states.q))
            return -multipliers[:, -1:] * np.stack([-s, c], -1)
        return -multipliers

    def tooth_forces(self, mesh: Mesh, driving: np.ndarray, states: MachineStates) -> np.ndarray:
        """Return the force (N, 2) N on the second wheel, from that on the drive flank minus that on the coast flank."""
        c, s = directions(mesh.centres + self.closure.angle(mesh.carrier, states.q))
        radial, tangential = mesh.apart * np.abs(driving), mesh.across * driving
        return np.stack([radial * c - tangential * s, radial * s + tangential * c], -1)

    def add_tooth_forces(self, reactions: dict[str, np.ndarray], states: MachineStates) -> None:
        """Add to the reactions in the pins of wheels what carries the forces of their teeth.

        The constraint of a mesh contains angles only, so its multiplier is the moment of these forces on each wheel.
        """
        joints = {joint.name: joint for joint in self.machine.joints}
        for mesh in [joints[name] for name in reactions if isinstance(joints[name], Mesh)]:
            teeth = self.tooth_forces(mesh, reactions[mesh.name][:, 0], states) if mesh.pins else np.empty(0)
            for pin, sign in zip(mesh.pins, (1.0, -1.0), strict=False):
                if pin in reactions:
                    carries_wheel = joints[pin].proximal.body == mesh.carrier
                    reactions[pin] = reactions[pin] + (sign if carries_wheel else -sign) * teeth

    def reference_rate(self) -> float:
        """Return the reference rate (rad/s): speed of the crank, or one that it reaches."""
        drive, states = self.machine.drive, self.revolution
        if isinstance(drive, Constant):
            return abs(drive.speed)
        if isinstance(drive, (Schedule, Path)):
            return float(np.max(np.abs(motion_table(drive)[:, 2]))) or 1.0
        given_speed = max(
            abs(drive.initial_speed), abs(drive.no_load_speed) if math.isfinite(drive.no_load_speed) else 0.0
        )
        if given_speed > 0.0:
            return given_speed
        generalised_inertia = float(np.mean(np.sum(self.inertia * states.derivative**2, -1)))
        if drive.servo is not None:
            target_rate = float(np.max(np.abs(motion_table(drive.servo.target)[:, 2])))
            return max(target_rate, math.sqrt(drive.servo.stiffness / generalised_inertia))
        return math.sqrt(4.0 * math.pi * abs(drive.stall_torque) / generalised_inertia) or 1.0


def rigid(machine: Machine) -> Machine:
    """Return a machine whose links do not deform."""
    bodies = {name: body._replace(elastic=None) for name, body in machine.bodies.items()}
    return machine._replace(bodies=bodies)


def _without_history(machine: Machine) -> Machine:
    """Return a machine whose bristles are bent as after long sliding, since a crank angle has no earlier motion."""
    loads = (
        load._replace(friction=without_history(load.friction)) if isinstance(load, Rubbing | Braking) else load
        for load in machine.loads
    )
    return machine._replace(loads=tuple(loads))


def masses_of(machine: Machine) -> list[Mass | Segment | Housing | Bent]:
    """Return mass and moment of inertia of every moving body; a flywheel turns with the crank."""
    crank = next(joint.distal.body for joint in machine.joints if joint.name == machine.driven)
    flywheel_inertia = machine.drive.inertia if isinstance(machine.drive, Motor) else 0.0
    elastic = {joint.distal.body for joint in machine.joints if isinstance(joint, Stretch)}
    masses: list[Mass | Segment | Housing | Bent] = []
    for name, body in machine.bodies.items():
        if body.elastic and body.elastic.bending:
            masses.append(compile_bent(body, body.elastic, body.elastic.bending))
        elif name != GROUND:
            form = Housing if body.mounted else Segment if name in elastic else Mass
            masses.append(form(body.mass, body.inertia + (flywheel_inertia if name == crank else 0.0)))
    return masses


def machine_key(machine: Machine) -> bytes:
    """Return a key that equal machines share; a machine is pickled only once."""
    return _pickled(Identity(machine))


@functools.lru_cache(maxsize=256)
def _pickled(machine: Identity) -> bytes:
    return pickle.dumps(machine.value)


@shared_by(machine_key)
def ideal_of(machine: Machine) -> IdealMachine:
    """Return the Ideal of a machine; the cases of a sweep share few of them."""
    return IdealMachine(machine)


def slot_travel(machine: Machine, slot: str) -> np.ndarray:
    """Return the places (N,) m of a pin along its slot, from the slot's middle, at the angles that a run visits.

    Empty if the joint moves with free bodies, which the ideal machine does not have.
    """
    ideal_machine = ideal_of(machine)
    if all(joint.name != slot for joint in ideal_machine.machine.joints):
        return np.empty(0)
    number = next(k for k, joint in enumerate(machine.joints) if joint.name == slot)
    travel = ideal_machine.coordinate_over_revolution(Coordinate(TRAVEL, number))[0]
    if machine.visited is None or not all(map(math.isfinite, machine.visited)):
        return travel[ideal_machine.stations.is_closed]
    low, high = (bound / (2.0 * math.pi) * STATIONS for bound in machine.visited)
    return travel[np.arange(math.floor(low), math.ceil(high) + 1) % STATIONS]


@shared_by(geometry_of)
def rival_assemblies(machine: Machine) -> Rivals:
    """Return how else the loops of a machine close at its start."""
    ideal_machine = ideal_of(machine)
    return ideal_machine.closure.rivals_of(ideal_machine.revolution.q[0], float(ideal_machine.revolution.angles[0]))
