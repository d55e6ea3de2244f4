"""A planar machine without clearance: what its joints determine, and the stations of a revolution where it is closed.

A position repeats with every revolution of the crank, so angles at stations of later revolutions need no new closure.
Stations hold quantities of the geometry alone.
"""

import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np

from ....contracts.machine import (
    GROUND,
    BodyPoint,
    Constant,
    Initial,
    Machine,
    Mesh,
    Slot,
    Stops,
    Stretch,
    TorsionSpring,
    ends_of,
)
from ..programs import shared_by
from .closure import (
    SINGULAR,
    STATIONS,
    Closure,
    ClosureError,
    Inverses,
    MachineStates,
    MobilityError,
    extrapolated,
    growth_per_revolution,
)
from .structure import ANGLE, SHIFT_X, SHIFT_Y


def determined(machine: Machine) -> Machine:
    """Return a machine whose joints determine it: without stops, with rigid torsion springs or without free bodies."""
    machine = machine._replace(joints=tuple(joint for joint in machine.joints if not isinstance(joint, Stops)))
    rigid = with_rigid_springs(machine)
    return rigid if _constraints(rigid) == 3 * (len(rigid.bodies) - 1) else without_free_bodies(machine)


def without_free_bodies(machine: Machine) -> Machine:
    """Return a machine without the free bodies that its joints do not determine; raise MobilityError.

    A free body has a given initial state.  Its joints and the loads on it are also removed.
    """
    free = {name for name, body in machine.bodies.items() if body.initial is not None}
    if not free or _constraints(machine) == 3 * (len(machine.bodies) - 1):
        return machine
    if machine.aim.body in free:
        raise MobilityError(
            f"the output cannot be the free body {machine.aim.body!r}: without clearance its motion is undetermined; "
            "choose a body whose motion ideal joints determine, such as the driven body"
        )
    joints = tuple(joint for joint in machine.joints if not free & _bodies_of(joint))
    kept = {None, *(joint.name for joint in joints)}  # joints of friction; other loads have none
    loads = tuple(x for x in machine.loads if not free & _bodies_of(x) and getattr(x, "joint", None) in kept)
    bodies = {name: body for name, body in machine.bodies.items() if name not in free}
    return machine._replace(bodies=bodies, joints=joints, loads=loads)


def without_forces(machine: Machine) -> Machine:
    """Return a machine at a constant speed without loads except the torsion springs that determine its position."""
    springs = tuple(load for load in machine.loads if isinstance(load, TorsionSpring))
    return machine._replace(drive=Constant(1.0, machine.drive.start_angle), loads=springs)


def with_rigid_springs(machine: Machine) -> Machine:
    """Return a machine in which torsion springs stay at their free angles where only they determine how a body turns.

    The first springs count, as many as degrees of freedom are left.
    """
    missing = 3 * (len(machine.bodies) - 1) - _constraints(machine)
    springs = [load for load in machine.loads if isinstance(load, TorsionSpring)][: max(missing, 0)]
    couplings = (
        Mesh(spring.name, spring.second, spring.first, GROUND, -1.0, rest=spring.free_angle) for spring in springs
    )
    loads = tuple(load for load in machine.loads if load not in springs)
    return machine._replace(joints=(*machine.joints, *couplings), loads=loads) if springs else machine


def _constraints(machine: Machine) -> int:
    """Return the number of equations of joints and drive, with springs at rest."""
    return 1 + sum({Slot: 1, Mesh: 1, Stretch: 3}.get(type(joint), 2) for joint in machine.joints)


def _bodies_of(record: Any) -> set[str]:
    """Return the bodies that a joint connects or a load acts on; none for friction, which is in a joint."""
    return {end.body for end in ends_of(record).values()}


def initial_coordinate(initial: Initial, kind: int) -> tuple[float, float]:
    """Return the initial coordinate of a free body and its rate."""
    return {ANGLE: (initial.angle, initial.rate), SHIFT_X: (initial.x, initial.vx), SHIFT_Y: (initial.y, initial.vy)}[
        kind
    ]


# --------------------------------------------------------------------------------------------- stations of a revolution


MARGIN = 2  # stations beyond the visited angles, as far as the machine can go


SAME_PLACE, SAME_TURN = 1e-9, 1e-9  # of the machine's size, and turns: rounding
ROUNDINGS = 4.0  # roundings of an angle, by which it may differ from that of a station


class Stations:
    """The states of a machine over a revolution, or over the part of it that a run visits.

    A part counts where the machine cannot make the whole revolution, or passes change points outside the part.
    """

    def __init__(self, closure: Closure, start: float, visited: tuple[float, float] | None = None):
        """Close the machine; visited : rad from the start, the angles of the run, infinite where unknown."""
        self.is_closed = np.ones(STATIONS + 1, bool)
        if visited is None:
            self.states = closure.close_revolution(start)
            if body := _unrepeated(closure, self.states):
                raise MobilityError(
                    f"{body} has something attached off its centre and makes no whole number of turns in a revolution "
                    "of the crank. The ideal machine must repeat; choose a ratio of which 1/ratio is whole, attach it "
                    "at the centre, or simulate less than a revolution"
                )
            return
        try:
            self.states = closure.close_revolution(start)
            is_whole = not self._change_points_outside(visited) and not _unrepeated(closure, self.states)
        except ClosureError:
            is_whole = False
        if not is_whole:
            self.states, self.is_closed = _part_of_revolution(closure, start, *visited)

    def reach(self) -> tuple[float, float] | None:
        """Return the angles (rad from the start) between which the machine is closed; None for a whole revolution."""
        if self.is_closed.all():
            return None
        forward, behind = (int(np.argmin(closed)) - 1 for closed in (self.is_closed, self.is_closed[::-1]))
        step = 2.0 * math.pi / STATIONS
        return -behind * step, forward * step

    def _change_points_outside(self, visited: tuple[float, float]) -> bool:
        """Return whether all change points, of which there are some, are outside the visited angles."""
        inverses = self.states.inverse
        assert inverses is not None  # of stations
        angles = self.states.angles[np.isnan(inverses.matrices[inverses.index, 0, 0])] - self.states.angles[0]
        is_visited = [(angles + turn > visited[0]) & (angles + turn < visited[1]) for turn in (0.0, -2.0 * math.pi)]
        return bool(angles.size) and not np.any(is_visited)

    def states_at(self, angles: np.ndarray, close: Callable[[np.ndarray], MachineStates]) -> MachineStates:
        """Return the machine at crank angles (N,) rad; `close` computes those that are not stations."""
        station, revolutions, off_station = self._nearest_stations(angles)
        q = self.states.q[station] + revolutions[:, None] * growth_per_revolution(self.states)
        inverses = self.states.inverse
        assert inverses is not None  # of stations
        states = MachineStates(
            angles, q, self.states.derivative[station], self.states.second_derivative[station], inverses.chosen(station)
        )
        if not off_station.any():
            return states
        closed = close(angles[off_station])
        for values, computed in zip(states[1:4], closed[1:4], strict=True):
            values[off_station] = computed
        return states._replace(inverse=states.inverse.replaced(off_station, closed.inverse))

    def _nearest_stations(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the stations (N,) nearest to angles (N,) rad, revolutions before them, and a mask of other angles."""
        start, step = self.states.angles[0], 2.0 * math.pi / STATIONS
        nearest_station = np.rint((angles - start) / step)
        off_station = np.abs(start + nearest_station * step - angles) > ROUNDINGS * np.spacing(np.max(np.abs(angles)))
        revolutions = np.floor(nearest_station / STATIONS)
        return (nearest_station - STATIONS * revolutions).astype(int), revolutions, off_station


def _unrepeated(closure: Closure, states: MachineStates) -> str:
    """Return a geared body that is elsewhere after a revolution of the crank, '' if there is none.

    A wheel may make any part of a turn if all that is attached to it is at its centre of mass.
    """
    machine = closure.machine
    used = _points_in_use(machine)
    if not used:
        return ""
    turns = growth_per_revolution(states)[2::3] / (2.0 * math.pi)
    for name, turn in zip(closure.names, turns, strict=True):
        body = machine.bodies[name]
        points = [body.points[end.point] for end in used if end.body == name]
        is_off_centre = any(math.dist(point, body.center) > SAME_PLACE * closure.size for point in points)
        if is_off_centre and abs(turn - round(turn)) > SAME_TURN:
            return name
    return ""


def _points_in_use(machine: Machine) -> list[BodyPoint]:
    """Return the points of a geared machine to which something is attached; none for a machine without gears."""
    if not any(isinstance(joint, Mesh) for joint in machine.joints):
        return []
    constrained = [joint for joint in machine.joints if not isinstance(joint, Mesh)]  # of a gear only angles are
    used = [end for record in (*constrained, *machine.loads) for end in ends_of(record).values()]
    return [*used, BodyPoint(machine.aim.body, machine.aim.point)] if machine.aim.point else used


def geometry_of(machine: Machine) -> bytes:
    """Return the key of everything that determines the positions of a machine, without masses, loads and speeds."""
    bodies = {name: (tuple(body.center), dict(body.points), body.initial) for name, body in machine.bodies.items()}
    joints = [
        joint._replace(stiffness=0.0, damping=0.0) if isinstance(joint, Stretch) else joint for joint in machine.joints
    ]
    springs = [load._replace(stiffness=0.0, damping=0.0) for load in machine.loads if isinstance(load, TorsionSpring)]
    start = dict(machine.start), machine.drive.start_angle, machine.visited
    return pickle.dumps((bodies, joints, springs, machine.driven, _points_in_use(machine), *start))


@shared_by(geometry_of)
def stations_of(machine: Machine) -> Stations:
    """Return the Stations of a machine; cases that differ in masses and loads share them."""
    return Stations(Closure(machine), machine.drive.start_angle, machine.visited)


def _part_of_revolution(closure: Closure, start: float, low: float, high: float) -> tuple[MachineStates, np.ndarray]:
    """Return the stations of a revolution of which the angles from `low` to `high` (rad from the start) are closed.

    Those before the start are at the end of the revolution.  Infinite angles: as far as the machine can go.  Others
    continue the last closed one, and are never visited.  The mask (STATIONS + 1,) says which are closed.  Raises
    ClosureError.
    """
    first = closure.state_at_start(start)
    if first is None:
        raise ClosureError(SINGULAR, closure.names[0], start)
    forward = _walk(closure, first, high, 1.0, STATIONS - 1)
    behind = _walk(closure, first, -low, -1.0, STATIONS - len(forward))
    angles = start + 2.0 * math.pi * np.arange(STATIONS + 1) / STATIONS
    gap = STATIONS + 1 - len(forward) - len(behind)  # stations between them, which are not closed
    states = [*forward, *[forward[-1]] * gap, *behind[::-1]]
    assert all(state.inverse is not None for state in states)
    q, *slopes = (np.concatenate([state[k] for state in states]) for k in (1, 2, 3))
    q[len(forward) + gap :, 3 * closure.crank + 2] += 2.0 * math.pi
    if gap > 1:  # the quintic to the next station continues the motion
        step = 2.0 * math.pi / STATIONS
        q[len(forward)] = extrapolated(forward[-1], float(forward[-1].angles[0]) + step)[0]
    inverses = np.concatenate([state.inverse.matrices for state in states if state.inverse is not None])
    is_closed = np.ones(STATIONS + 1, bool)
    is_closed[len(forward) : len(forward) + gap] = False
    return MachineStates(angles, q, *slopes, Inverses(inverses, np.arange(STATIONS + 1))), is_closed


def _walk(closure: Closure, first: MachineStates, reach: float, sign: float, most: int) -> list[MachineStates]:
    """Return the machine at the start and at the stations on one side of it, up to `reach` (rad) and a margin.

    sign : 1 or -1, side; most : largest number of stations.  Raises ClosureError if the machine cannot reach so far.
    """
    step, states = 2.0 * math.pi / STATIONS, [first]
    needed = math.ceil(max(reach, 0.0) / step) if math.isfinite(reach) else 0
    last = min(needed + MARGIN, most) if math.isfinite(reach) else most
    start = float(first.angles[0])
    while len(states) <= last:
        station = len(states)
        try:
            states.append(closure.continue_to(states[-1], start + sign * station * step))
        except ClosureError:
            if station < needed:
                raise
            if station == needed:  # the machine may reach the angle but not the station behind it
                closure.continue_to(states[-1], start + sign * reach)
            break
    return states
