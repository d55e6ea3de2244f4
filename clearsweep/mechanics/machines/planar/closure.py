"""A planar machine without clearance in absolute coordinates, over a revolution of its crank.

The coordinates are x, y of the centre of mass and the angle of every body; the constraints those of all joints and the
angle of the crank, so that positions follow from Newton's method, velocities and accelerations from linear equations,
and the forces in the joints are the multipliers of the constraints (Haug 1989, "Computer Aided Kinematics and
Dynamics", chapters 3 and 6).  Derivatives are with respect to the crank's angle; speeds are applied afterwards.
"""

import math
from collections.abc import Iterator, Mapping
from itertools import compress
from typing import Any, NamedTuple

import numpy as np

from ....contracts.machine import GROUND, BodyPoint, Guide, Machine, Mesh, Slot, Stretch
from ....tracing.compiled.choosing import directions, rolled_range
from ....tracing.compiled.family import Routine, shaped
from . import constraints

# ---------------------------------------------------------------------------------------------- states


class Inverses(NamedTuple):
    """The inverses of the derivatives of the constraints by the coordinates; states may share them."""

    matrices: np.ndarray  # (M, 3 bodies, rows)
    index: np.ndarray  # (N,) int64, matrix of each state

    def chosen(self, states: np.ndarray) -> "Inverses":
        """Return the inverses of some states (N,)."""
        return Inverses(self.matrices, self.index[states])

    def replaced(self, where: np.ndarray, others: "Inverses") -> "Inverses":
        """Return inverses of which those at a mask (N,) are `others`."""
        index = self.index.copy()
        index[where] = len(self.matrices) + others.index
        return Inverses(np.concatenate([self.matrices, others.matrices]), index)

    def multipliers(self, forces: np.ndarray) -> np.ndarray:
        """Return the multipliers (N, rows) of the constraints for forces (N, 3 bodies) on the bodies."""
        forces, out = np.require(forces, float, "CW"), np.empty_like(forces, order="C")
        _write_multipliers((np.array(self.matrices.shape[:2]), self.matrices, self.index, forces, out), len(forces))
        return out


def _multipliers(settings, matrices, index, forces, multipliers, count):
    """Multiply forces (count, n) by the transposed matrices (M, n, n) of an `index`; arrays are bare pointers.

    settings : (2,) int64, M and n
    """
    settings = shaped(settings, (2,))
    n = settings[1]
    matrices, index = shaped(matrices, (settings[0], n, n)), shaped(index, (count,))
    forces, multipliers = shaped(forces, (count, n)), shaped(multipliers, (count, n))
    for k in rolled_range(count):
        for row in rolled_range(n):
            multipliers[k, row] = 0.0
        for i in rolled_range(n):
            force = forces[k, i]
            for row in rolled_range(n):
                multipliers[k, row] += matrices[index[k], i, row] * force


_write_multipliers = Routine(_multipliers, "ififf")


class MachineStates(NamedTuple):
    """The ideal machine at N crank angles; q : x, y (m), angle (rad) of moving bodies."""

    angles: np.ndarray  # (N,) rad
    q: np.ndarray  # (N, 3 bodies)
    derivative: np.ndarray  # of q by the crank's angle
    second_derivative: np.ndarray
    inverse: Inverses | None = None  # of states that were closed


def interpolate(stations: MachineStates, angles: np.ndarray) -> MachineStates:
    """Return the states at crank angles (N,) rad by quintic interpolation between those at stations."""
    step = 2.0 * math.pi / (len(stations.angles) - 1)
    revolutions = np.floor((angles - stations.angles[0]) / (2.0 * math.pi))
    position = (angles - stations.angles[0] - 2.0 * math.pi * revolutions) / step
    index = np.minimum(position.astype(int), len(stations.angles) - 2)
    t = (position - index)[:, None]
    f0, d0, s0, f1, d1, s1 = (
        array[index + i] for i in (0, 1) for array in (stations.q, stations.derivative, stations.second_derivative)
    )
    d0, d1, s0, s1 = step * d0, step * d1, step * step * s0, step * step * s1
    value_defect, slope_defect, curvature_defect = f1 - f0 - d0 - 0.5 * s0, d1 - d0 - s0, s1 - s0
    a = 10 * value_defect - 4 * slope_defect + 0.5 * curvature_defect
    b = -15 * value_defect + 7 * slope_defect - curvature_defect
    c = 6 * value_defect - 3 * slope_defect + 0.5 * curvature_defect
    growth = growth_per_revolution(stations)
    q = f0 + t * (d0 + t * (0.5 * s0 + t * (a + t * (b + t * c)))) + revolutions[:, None] * growth
    slope = (d0 + t * (s0 + t * (3 * a + t * (4 * b + t * 5 * c)))) / step
    return MachineStates(angles, q, slope, (s0 + t * (6 * a + t * (12 * b + t * 20 * c))) / step**2)


def growth_per_revolution(stations: MachineStates) -> np.ndarray:
    """Return the growth of the coordinates in each revolution; only angles of rotating bodies grow."""
    growth: np.ndarray = stations.q[-1] - stations.q[0]
    growth[0::3] = growth[1::3] = 0.0
    return growth


# ---------------------------------------------------------------------------------------------- closed loops


class Rivals(NamedTuple):
    """Other assemblies than the one taken at the start, which nothing in the grid rules out."""

    taken: dict[str, float]  # body -> angle (rad) as taken, of bodies whose angle differs in one of them
    ties: dict[str, tuple[float, float]]  # body -> angle as taken and in the nearest, unless that is RULED_OUT


STATIONS = 720  # of a revolution, at which the machine is closed
FIRST_STATIONS = 24  # of them, closed in sequence; interpolation between these gives guesses for the others
FINEST_STEP = 4**6  # most parts into which an interval between stations is divided
LARGEST_JUMP = 0.1  # rad, by which an angle may differ from the parabola through the last station
NEAR_SINGULAR = 1e-7  # least singular value of the constraints over the largest, lengths measured by the machine's size
CHANGE_POINT = 1e-3  # the same, below which a machine that passes a change point is interpolated
ATTEMPTS = 40
SAME_ANGLE = 1e-3  # rad, by which the angles of one assembly may differ between two attempts
RULED_OUT = 2.0  # times the distance from the given angles: an assembly so far away is no tie
ANGLE_BETWEEN = -1.0, 1.0, 0.0  # shares of both bodies in an angle between them, and no carrier
ROUNDING = 2.0**-30  # rad, and of the machine's size: to which the start is rounded before it is closed once more
SINGULAR = "it is in a singular position, in which it has more than one degree of freedom"


UNDRIVEN = (
    "; a body that moves freely needs `initial`, and one that turns on a pin a gear, a coupling or a torsion spring"
)


class ClosureError(ValueError):
    """The machine without clearance cannot be closed, or is singular, at an angle of its crank."""

    def __init__(self, text: str, body: str, angle: float, remedy: str = "change lengths"):
        super().__init__(text)
        self.body, self.angle, self.remedy = body, angle, remedy  # the angle in rad


class MobilityError(ValueError):
    """The machine does not have exactly one degree of freedom, that of its drive."""


class PointMotion(NamedTuple):
    """A point of a body, each field a number or (N,)."""

    x: Any  # m
    y: Any
    lever_x: Any  # derivative by the body's angle
    lever_y: Any
    dx: Any  # derivative by the crank's angle
    dy: Any


class Closure:
    """The constraints of a machine, without clearance and with springs at rest except for `offsets`.

    offsets : m, of the distal point of some joints: (2,) in the fixed frame for a pin, the extension for a spring
    """

    def __init__(self, machine: Machine, offsets: Mapping | None = None):
        self.machine = machine
        self.names = [name for name in machine.bodies if name != GROUND]
        self.index = {name: i for i, name in enumerate(self.names)}
        self.size = math.fsum(extent(body) for body in machine.bodies.values()) or 1.0  # m
        driven = next(joint for joint in machine.joints if joint.name == machine.driven)
        self.crank = self.index[driven.distal.body]
        row_ends = np.cumsum([1 if isinstance(joint, Slot | Mesh) else 2 for joint in machine.joints])
        self.first_rows = np.concatenate([[0], row_ends])  # row of each joint, and of what comes behind them
        self.springs = [joint for joint in machine.joints if isinstance(joint, Stretch)]  # springs at rest
        rows, offsets = [], offsets or {}
        for joint in machine.joints:
            rows += self._rows_of(joint, offsets.get(joint.name, (0.0, 0.0)))
        for spring in self.springs:
            axis = math.cos(spring.axis), math.sin(spring.axis)
            rows.append(self._row(spring, axis, turns=1.0, offset=offsets.get(spring.name, 0.0)))
        crank_angle = [0.0, 0.0, 0.0, 1.0 + self.crank, 0.0, 0.0, *constraints.NO_DIRECTION, 0.0, 0.0, *ANGLE_BETWEEN]
        self.constraints = np.array([*rows, crank_angle])
        self.rows = len(self.constraints)
        if self.rows != 3 * len(self.names):
            freedoms = 3 * len(self.names) - self.rows + 1
            raise MobilityError(
                f"without clearance it has {freedoms} degrees of freedom (3 per moving body, minus 2 per joint); "
                "the drive needs exactly 1" + (UNDRIVEN if freedoms > 1 else "")
            )
        self._settings = np.array([self.size, float(self.rows)])

    def _rows_of(self, joint: Any, offset: Any) -> list[list[float]]:
        """Return the constraints of a joint, each as the numbers of a Constraint."""
        if isinstance(joint, Mesh):
            turned = joint.rest + (offset[0])
            shares = 1.0, joint.ratio, float(self._number(joint.carrier))
            return [[*self._row(joint, constraints.NO_DIRECTION, offset=turned)[: -len(shares)], *shares]]
        if isinstance(joint, Guide | Stretch | Slot):
            across = self._row(joint, (-math.sin(joint.axis), math.cos(joint.axis)), turns=1.0)
            return [across] if isinstance(joint, Slot) else [self._row(joint, constraints.NO_DIRECTION), across]
        return [self._row(joint, axis, offset=offset[i]) for i, axis in enumerate(((1.0, 0.0), (0.0, 1.0)))]

    def _row(self, joint: Any, axis: tuple[float, float], turns: float = 0.0, offset: float = 0.0) -> list[float]:
        """Return the numbers of a Constraint."""
        ends = [(float(self._number(end.body)), *self._arm(end)) for end in (joint.proximal, joint.distal)]
        return [*ends[0], *ends[1], *axis, turns, offset, *ANGLE_BETWEEN]

    def _number(self, body: str) -> int:
        """Return the number of a body, 0 for the ground."""
        return 0 if body == GROUND else 1 + self.index[body]

    def _arm(self, endpoint: BodyPoint) -> tuple[float, float]:
        """Return the position (m) of a point in the frame of its body, from the centre of mass."""
        x, y = self.machine.bodies[endpoint.body].points[endpoint.point]
        center = (0.0, 0.0) if endpoint.body == GROUND else self.machine.bodies[endpoint.body].center
        return float(x - center[0]), float(y - center[1])

    def point_motion(self, endpoint: BodyPoint, q: np.ndarray, q_rates: np.ndarray) -> PointMotion:
        """Return a point of a body; q, q_rates : (..., 3 bodies)."""
        x, y = self._arm(endpoint)
        if endpoint.body == GROUND:
            return PointMotion(x, y, 0.0, 0.0, 0.0, 0.0)
        i = 3 * self.index[endpoint.body]
        c, s = directions(q[..., i + 2])
        arm_x, arm_y, rate = c * x - s * y, s * x + c * y, q_rates[..., i + 2]
        return PointMotion(
            q[..., i] + arm_x,
            q[..., i + 1] + arm_y,
            -arm_y,
            arm_x,
            q_rates[..., i] - rate * arm_y,
            q_rates[..., i + 1] + rate * arm_x,
        )

    def evaluate(self, q: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return constraints (N, rows) and their derivatives (N, rows, 3 bodies); q : (N, 3 bodies); angles : rad."""
        count, n = q.shape
        values, jacobians = np.empty((count, n)), np.empty((count, n, n))
        arrays = self._settings, self.constraints, _contiguous(angles), _contiguous(q), values, jacobians
        constraints.evaluate((*arrays, np.zeros(constraints.scratch_size(n))), count)
        return values, jacobians

    def angle(self, body: str, q: np.ndarray) -> Any:
        """Return the angle (rad) of a body, or its rate, (...)."""
        return 0.0 if body == GROUND else q[..., 3 * self.index[body] + 2]

    # ------------------------------------------------------------------------------------------ positions

    def singularity(self, q: np.ndarray, angle: float) -> tuple[float, str]:
        """Return the least singular value over the largest, and the body that moves most in its direction."""
        scale, unit = self._units()
        _, values, right_vectors = np.linalg.svd(self.evaluate(q[None], np.array([angle]))[1][0] * scale / unit)
        body_motion = np.abs(right_vectors[-1]).reshape(-1, 3).max(axis=1)
        return values[-1] / values[0], self.names[int(np.argmax(body_motion))]

    def _units(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the unit of each coordinate (3 bodies,) and of each row (rows, 1), the machine's size for lengths."""
        is_angle = np.all(self.constraints[:, 6:8] == constraints.NO_DIRECTION, axis=1)
        return np.tile([self.size, self.size, 1.0], len(self.names)), np.where(is_angle, 1.0, self.size)[:, None]

    def close(self, q: np.ndarray, angles: np.ndarray) -> tuple[MachineStates, np.ndarray]:
        """Return the states near `q` that satisfy the constraints, and signs (N,) of the constraints' determinants.

        q : (N, 3 bodies); angles : (N,) rad, of the crank.  Where there is no such state, coordinates and sign are nan.
        """
        count, n = q.shape
        q = np.array(q, float, order="C")
        first = np.empty((count, n))
        second = np.empty((count, n))
        inverse = np.empty((count, n, n))
        signs = np.empty(count)
        arrays = self._settings, self.constraints, _contiguous(angles), q, first, second, inverse, signs
        constraints.close((*arrays, np.zeros(constraints.scratch_size(n))), count)
        return MachineStates(angles, q, first, second, Inverses(inverse, np.arange(count))), signs

    def close_at_start(self, angle: float) -> np.ndarray:
        """Return the machine closed at an angle of its crank, near the angles given for that.  Raises ClosureError."""
        solutions: list[tuple[float, np.ndarray]] = []
        given_angles, is_given = self._given_angles()
        for attempt, deviations, q in self._assemblies(angle):
            if attempt == 0 and np.max(np.abs(deviations)) < 0.5 * math.pi:
                return self._wrap_angles(q, given_angles)
            solutions.append((float(np.sum(deviations**2 * np.where(is_given, 100.0, 1.0))), q))
        if not solutions:
            raise ClosureError(
                "its loops cannot be closed at the initial crank angle with these lengths",
                self._most_open_body(given_angles, angle),
                angle,
            )
        return self._wrap_angles(min(solutions, key=lambda item: item[0])[1], given_angles)

    def _given_angles(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the angle (rad) of each body near which the loops are closed, and whether `start` gives it."""
        start = self.machine.start
        return np.array([start.get(name, 0.0) for name in self.names]), np.array([name in start for name in self.names])

    def _assemblies(self, angle: float) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
        """Yield the attempts that close the machine, the deviations (rad) from the given angles, and the bodies."""
        given_angles, is_given = self._given_angles()
        for attempt in range(ATTEMPTS):
            angles = given_angles.copy()
            if attempt:  # most machines need no random numbers, whose loading takes 14 ms
                spread = 0.1 + 3.0 * attempt / ATTEMPTS
                drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (attempt + 1, angles.size))[-1]
                angles += np.where(is_given, 0.2 * spread, spread) * drawn
            angles[self.crank] = angle
            q = self._close_roughly(self._assemble(angles), angle)
            if np.all(np.isfinite(q)):
                deviations = np.remainder(q[2::3] - given_angles + math.pi, 2.0 * math.pi) - math.pi
                deviations[self.crank] = 0.0
                yield attempt, deviations, q

    def rivals_of(self, q: np.ndarray, angle: float) -> "Rivals":
        """Return how else the loops of an assembly `q` close; `start` rules out what moves a body that it gives."""
        given_angles, is_given = self._given_angles()
        chosen = np.remainder(q[2::3] - given_angles + math.pi, 2.0 * math.pi) - math.pi
        chosen[self.crank] = 0.0
        rivals = []
        for _, deviations, _ in self._assemblies(angle):
            differs = np.abs(np.remainder(deviations - chosen + math.pi, 2.0 * math.pi) - math.pi) > SAME_ANGLE
            if differs.any() and not (differs & is_given).any():
                rivals.append((float(np.linalg.norm(deviations)), deviations, differs))
        if not rivals:
            return Rivals({}, {})
        distance, deviations, differs = min(rivals, key=lambda rival: rival[0])
        taken, other = (
            dict(zip(self.names, map(float, angles + given_angles), strict=True)) for angles in (chosen, deviations)
        )
        is_free = np.any([differs for _, _, differs in rivals], axis=0)
        nearest = compress(self.names, differs) if distance <= RULED_OUT * np.linalg.norm(chosen) else ()
        return Rivals(
            {name: taken[name] for name in compress(self.names, is_free)},
            {name: (taken[name], other[name]) for name in nearest},
        )

    def _wrap_angles(self, q, given_angles):
        """Return `q` with all angles, except the crank's, within half a revolution of the given ones."""
        q = q.copy()
        for i in range(len(self.names)):
            if i != self.crank:
                q[3 * i + 2] -= 2.0 * math.pi * np.round((q[3 * i + 2] - given_angles[i]) / (2.0 * math.pi))
        return q

    def _assemble(self, angles) -> np.ndarray:
        """Return the bodies at given angles, each attached to an already placed one, by a pin if there is one."""
        q = np.zeros(3 * len(self.names))
        q[2::3] = angles
        placed = {GROUND}
        while len(placed) <= len(self.names):
            for takes_guide in (False, True):
                joint = next(
                    (
                        joint
                        for joint in self.machine.joints
                        if not isinstance(joint, Mesh)
                        and isinstance(joint, (Guide, Stretch, Slot)) == takes_guide
                        and (joint.proximal.body in placed) != (joint.distal.body in placed)
                    ),
                    None,
                )
                if joint is not None:
                    break
            if joint is None:
                unplaced = next(name for name in self.names if name not in placed)
                raise MobilityError(f"body {unplaced!r} is not connected to the ground by joints")
            endpoints = (joint.proximal, joint.distal)
            placed_endpoint, free_endpoint = endpoints if joint.proximal.body in placed else endpoints[::-1]
            anchor, free_point = (
                self.point_motion(endpoint, q, np.zeros_like(q)) for endpoint in (placed_endpoint, free_endpoint)
            )
            i = 3 * self.index[free_endpoint.body]
            q[i : i + 2] += anchor.x - free_point.x, anchor.y - free_point.y
            placed.add(free_endpoint.body)
        return q

    def _close_roughly(self, q, angle) -> np.ndarray:
        """Return the machine closed from a rough guess by the Levenberg-Marquardt method; nan if it fails."""
        damping, angles = 1e-3, np.array([angle])
        (values,), (jacobian,) = self.evaluate(q[None], angles)
        cost = float(np.sum(values**2))
        for _ in range(200):
            gradient = jacobian.T @ values
            square = jacobian.T @ jacobian
            scale = np.tile([1.0, 1.0, self.size**2], len(self.names))
            step = np.linalg.solve(square + damping * np.diag(scale), -gradient)
            (trial,), (trial_jacobian,) = self.evaluate((q + step)[None], angles)
            if np.sum(trial**2) < cost:
                q, values, jacobian, cost = q + step, trial, trial_jacobian, float(np.sum(trial**2))
                damping = max(0.2 * damping, 1e-15)
            else:
                damping *= 5.0
            if cost < 1e-12 * self.size**2 or damping > 1e10:
                break
        if cost > 1e-8 * self.size**2:
            return np.full_like(q, math.nan)
        closed: np.ndarray = self.close(q[None], angles)[0].q[0]
        return closed

    def _most_open_body(self, given_angles, angle) -> str:
        """Return the body whose joint stays open if a machine does not close."""
        angles = given_angles.copy()
        angles[self.crank] = angle
        values, _ = self.evaluate(self._assemble(angles)[None], np.array([angle]))
        worst_row = int(np.argmax(np.abs(values[0, : self.first_rows[-1]])))
        joint = self.machine.joints[int(np.searchsorted(self.first_rows, worst_row, side="right")) - 1]
        return joint.distal.body if joint.distal.body != GROUND else joint.proximal.body

    # ------------------------------------------------------------------------------------------ one revolution

    def close_revolution(self, start: float) -> MachineStates:
        """Return a revolution of the crank from the angle `start` (rad), with both ends.  Raises ClosureError."""
        angles = start + 2.0 * math.pi * np.arange(STATIONS + 1) / STATIONS
        first = self.state_at_start(start)
        if first is None:
            return self._closed_elsewhere(start)
        coarse_angles, states = angles[:: STATIONS // FIRST_STATIONS], [first]
        try:
            for angle in coarse_angles[1:]:
                states.append(self.continue_to(states[-1], angle))
            coarse = (np.concatenate([state[k] for state in states]) for k in (1, 2, 3))
            closed, signs = self.close(interpolate(MachineStates(coarse_angles, *coarse), angles).q, angles)
            self._check_all(closed, signs)
        except ClosureError:
            passed = self._pass_change_points(states[0], angles)
            if passed is None:
                raise
            return passed
        return closed

    def state_at_start(self, start: float) -> MachineStates | None:
        """Return the machine closed at the start of a run, or None in a singular position.  Raises ClosureError."""
        first_position = self.close_at_start(start)
        if self.singularity(first_position, start)[0] < NEAR_SINGULAR:
            return None
        # rounded, because the bits of linear algebra depend on the processor
        unit = ROUNDING * self._units()[0]
        state = self.close((np.round(first_position / unit) * unit)[None], np.array([start]))[0]
        if not np.all(np.isfinite(state.q)):
            raise ClosureError(SINGULAR, self.singularity(first_position, start)[1], start)
        return state

    def _closed_elsewhere(self, start: float) -> MachineStates:
        """Return a revolution that starts at a change point, through which the machine goes straight on."""
        for part in (1, 2, 3):
            elsewhere, shift = start + 2.0 * math.pi * part / FIRST_STATIONS, part * STATIONS // FIRST_STATIONS
            try:
                if self.state_at_start(elsewhere) is not None:
                    return _rolled(self.close_revolution(elsewhere), shift, start)
            except ClosureError:
                continue
        raise ClosureError(SINGULAR, self.singularity(self.close_at_start(start), start)[1], start)

    def _pass_change_points(self, first: MachineStates, angles: np.ndarray) -> MachineStates | None:
        """Return a revolution that goes straight on where loops may branch; None if the machine cannot do this.

        A folded parallelogram may open as an antiparallelogram.  There the derivatives of the constraints are singular,
        so states near it are interpolated between both sides.  Their inverses are nan: the forces grow without limit.
        """
        known, stations = self._straight_on(first, angles)
        if stations[-1] < STATIONS or len(known) < STATIONS // 2:
            return None
        if self._moves(first, known[-1]).max() <= LARGEST_JUMP:
            return _filled(known, np.array(stations), angles)
        again, stations_again = self._straight_on(known[-1], angles + 2.0 * math.pi)
        if stations_again[-1] < STATIONS or self._moves(first, again[-1]).max() > LARGEST_JUMP:
            return None
        behind = next((k for k, station in enumerate(stations) if k != station), STATIONS)  # the first change point
        text = "its loops close only after two revolutions of the crank, as they pass into another assembly"
        body = self.names[int(np.argmax(self._moves(first, known[-1])))]
        change_point = float(0.5 * (angles[behind - 1] + angles[stations[behind]]))
        remedy = "the ideal machine is computed over one revolution; change lengths"
        raise ClosureError(text, body, change_point, remedy)

    def _straight_on(self, first: MachineStates, angles: np.ndarray) -> tuple[list[MachineStates], list[int]]:
        """Return states at those of a revolution's stations that are far from change points, and their numbers.

        The last of `angles` (rad) is missing if the machine is near a change point there, or does not turn on.
        """
        known, stations = [first], [0]
        for station, angle in enumerate(angles[1:], 1):
            guess = extrapolated(known[-1], angle)
            state = self.close(guess, np.array([angle]))[0]
            if not np.all(np.isfinite(state.q)) or self.singularity(state.q[0], angle)[0] < CHANGE_POINT:
                continue
            if np.max(np.abs((state.q - guess)[0, 2::3])) > LARGEST_JUMP / FIRST_STATIONS:
                break
            known.append(state)
            stations.append(station)
        return known, stations

    def _moves(self, first: MachineStates, last: MachineStates) -> np.ndarray:
        """Return how far each body is from where it was (bodies,): rad without whole turns, or machine sizes."""
        turns = (last.q - first.q)[0]
        turns[2::3] -= 2.0 * math.pi * np.round(turns[2::3] / (2.0 * math.pi))
        moves: np.ndarray = np.abs(turns / self._units()[0]).reshape(-1, 3).max(axis=1)
        return moves

    def continue_to(self, state: MachineStates, end_angle: float) -> MachineStates:
        """Return the machine at another angle of its crank, in as many steps as necessary."""
        step_count = 1
        while step_count <= FINEST_STEP:
            start_angle, latest, has_failed = state.angles[0], state, False
            for step_index in range(step_count):
                next_angle = start_angle + (end_angle - start_angle) * (step_index + 1) / step_count
                guess = extrapolated(latest, next_angle)
                next_state, _ = self.close(guess, np.array([next_angle]))
                has_failed = not np.max(np.abs((next_state.q - guess)[0, 2::3])) <= LARGEST_JUMP  # or nan
                if has_failed:
                    break
                latest = next_state
            if not has_failed:
                self._check(latest)
                return latest
            step_count, state = 4 * step_count, latest
        angle = float(state.angles[0])
        raise ClosureError("its lengths do not let the crank turn on", self.singularity(state.q[0], angle)[1], angle)

    def _check_all(self, states: MachineStates, signs: np.ndarray) -> None:
        """Raise ClosureError if a revolution passes a singular position between its stations."""
        is_steep = np.max(np.abs(states.derivative[:, 2::3]), axis=1) > 1.0 / NEAR_SINGULAR
        singular_stations = np.flatnonzero((signs != signs[0]) | is_steep | ~np.all(np.isfinite(states.q), axis=1))
        if singular_stations.size:
            angle, last_station = float(states.angles[singular_stations[0]]), max(singular_stations[0] - 1, 0)
            raise ClosureError(SINGULAR, self.singularity(states.q[last_station], angle)[1], angle)

    def _check(self, state: MachineStates) -> None:
        """Raise ClosureError if a position is singular, or so close to it that the inverse is very large."""
        assert state.inverse is not None  # of a position that was closed
        scale, unit = self._units()
        # the derivatives have at most six numbers in a row, up to 1 in these units
        largest_ratio = math.sqrt(6.0 * self.rows) * np.linalg.norm(state.inverse.matrices[0] * unit.T / scale[:, None])
        if not largest_ratio < 1.0 / NEAR_SINGULAR:
            self._check_position(state.q[0], float(state.angles[0]))

    def _check_position(self, q: np.ndarray, angle: float) -> None:
        """Raise ClosureError if a position `q` (3 bodies,) is singular."""
        ratio, body = self.singularity(q, angle)
        if ratio < NEAR_SINGULAR:
            raise ClosureError(SINGULAR, body, angle)


def _rolled(states: MachineStates, shift: int, start: float) -> MachineStates:
    """Return a revolution from the angle `start` (rad), `shift` stations before that of `states`."""
    order = (np.arange(len(states.angles)) - shift) % (len(states.angles) - 1)
    is_before = np.arange(len(order)) < shift
    q = states.q[order] - is_before[:, None] * growth_per_revolution(states)
    angles = start + 2.0 * math.pi * np.arange(STATIONS + 1) / STATIONS
    assert states.inverse is not None  # of states that were closed
    q[-1] = q[0] + growth_per_revolution(states)
    inverses = Inverses(states.inverse.matrices[states.inverse.index[order]], np.arange(len(order)))
    return MachineStates(angles, q, states.derivative[order], states.second_derivative[order], inverses)


def extrapolated(state: MachineStates, angle: float) -> np.ndarray:
    """Return the coordinates (1, 3 bodies) at a crank angle (rad) near that of one state."""
    step = angle - state.angles[0]
    return state.q + state.derivative * step + 0.5 * state.second_derivative * step**2


def _filled(known: list[MachineStates], stations: np.ndarray, angles: np.ndarray) -> MachineStates:
    """Return states at all `angles` (rad), quintic between those known at some stations; their inverses are nan."""
    from scipy.interpolate import BPoly

    values = [np.concatenate([state[k] for state in known]) for k in (1, 2, 3)]
    path = BPoly.from_derivatives(angles[stations], np.stack(values, axis=1))
    q, first, second = (path(angles, order) for order in range(3))
    inverses = np.full((len(angles), q.shape[1], q.shape[1]), math.nan)
    for array, exact in zip((q, first, second), values, strict=True):
        array[stations] = exact
    inverses[stations] = [state.inverse.matrices[0] for state in known if state.inverse is not None]
    return MachineStates(angles, q, first, second, Inverses(inverses, np.arange(len(angles))))


def _contiguous(array: np.ndarray) -> np.ndarray:
    """Return an array whose numbers a compiled routine can read."""
    return np.require(array, float, "CW")


def extent(body) -> float:
    """Return the largest distance (m) between two points of a body, its centre of mass among them."""
    points = np.array([body.center, *body.points.values()])
    return float(np.max(np.hypot(*(points[:, None] - points[None]).T)))
