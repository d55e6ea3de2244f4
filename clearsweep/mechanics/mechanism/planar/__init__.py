"""Planar machines: rigid bodies with revolute and prismatic joints in any topology, each joint ideal or open."""

import functools
import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ....contracts.catalogue import Channel
from ....contracts.machine import GROUND, Aim, At, Guide, Machine, Motor, Schedule, Slot, Stretch
from ...joint.contract import Load
from ..contract import Built, IdealMotion, Open
from ..contract import Ideal as Closed
from . import members  # noqa: F401 - registers the equations of motion
from .binding import bound_of
from .closure import ClosureError, MobilityError, extent
from .cycle import cycle_of
from .drive import drive_of, driven
from .equations import function_of
from .form import AngleAim, Hinge, Planar, PointAim, Slide, Sprung, direction_of, numbered, point_of
from .ideal import Ideal, ideal_of, key_of, masses_of, start_of
from .loads import loads_of, stops_of
from .machine_type import kinds_of, machine_type
from .segments import in_segments
from .spanning_tree import ANGLE, RUN, Coordinate
from .stations import Alike, geometry_of

__all__ = ["Alike", "ClosureError", "MobilityError", "build", "channels", "ideal", "ideal_of", "key_of", "stops"]


def channels(machine: Machine) -> tuple[Channel, ...]:
    """Return the time histories of a machine, in the order of `describe`."""
    unit = "m" if machine.aim.point else "rad"
    channels = [
        Channel("crank_angle", "rad", "crank angle, unwrapped"),
        Channel("crank/torque", "N*m", "drive torque on the crank"),
        Channel("output/place", unit, "place of the output"),
        Channel("output/rate", f"{unit}/s", "its rate"),
        Channel("output/acceleration", f"{unit}/s^2", "its acceleration"),
    ]
    for body in machine.bodies:
        name = body.replace("-", "_")
        if body != GROUND:
            channels += [
                Channel(f"{name}/x", "m", f"centre of mass of {body}, x"),
                Channel(f"{name}/y", "m", f"centre of mass of {body}, y"),
                Channel(f"{name}/vx", "m/s", f"velocity of the centre of mass of {body}, x"),
                Channel(f"{name}/vy", "m/s", f"velocity of the centre of mass of {body}, y"),
                Channel(f"{name}/angle", "rad", f"angle of {body}, counter-clockwise"),
                Channel(f"{name}/rate", "rad/s", "its rate"),
            ]
            if machine.bodies[body].elastic:
                channels.append(Channel(f"{name}/extension", "m", f"by which {body} is longer than unloaded"))
    return tuple(channels)


def build(machine: Machine, joints: Mapping, offsets: Mapping) -> Built:
    """Return the compiled form of a machine and its initial state.

    joints : compiled form of each joint with clearance, by name; offsets : (2,) m, of the distal point of each from the
    proximal one at the start, without relative velocity.  Raises ClosureError, MobilityError.
    """
    machine = in_segments(machine)
    known, names = ideal_of(machine), frozenset(joints)
    if names not in known.opened:
        known.opened[names] = _opened(machine, names)
    opened = known.opened[names]
    if opened.light:
        raise MobilityError(
            f"with these joints open, something moves that has no mass or moment of inertia: {', '.join(opened.light)}"
        )
    apart = any(map(any, offsets.values()))
    start = _start(known, opened.state, offsets) if apart else opened.start
    return Built(opened.value, start, opened.lengths, known.closure.size, known.rate())


def ideal(machine: Machine, angles) -> IdealMotion:
    """Return the motion of the output and the reactions without clearance at angles (rad, any shape) of the crank."""
    shape = np.shape(angles)
    known = ideal_of(machine)
    motion = known.motion(np.asarray(angles, dtype=float).ravel(), lambda: _opened(known.machine, frozenset()).value)
    reactions = {name: force.reshape((*shape, 2)) for name, force in motion.reactions.items()}
    torque = np.reshape(motion.torque, shape)
    return IdealMotion(*(np.reshape(part, shape) for part in motion[:3]), reactions, torque)


class _Opened(NamedTuple):
    """A machine with some of its joints open, for any clearances and laws: cases of a sweep share it."""

    value: Planar
    state: list[Coordinate]
    lengths: np.ndarray  # m, as of Built
    start: np.ndarray  # as in Built, with zero offsets
    light: list[str]  # moving bodies without mass or inertia


def _opened(machine: Machine, names: frozenset[str]) -> _Opened:
    """Return the compiled form of a machine with open joints of these names, and its coordinates."""
    known, value = ideal_of(machine), _value(machine, names)
    tree = machine_type(kinds_of(value))
    paths = [known.course_of(item) for item in tree.hang.coordinates]
    value = value._replace(turn=cycle_of([known.aimed(known.turn)], machine.drive.start_angle))
    dependent = _dependent(known, value, paths) if tree.hang.loop_joints else ()
    columns = [known.aimed(known.turn), *(paths[i] for i in dependent)]
    value = value._replace(
        dependent=tuple(map(numbered, dependent)), turn=cycle_of([*columns], machine.drive.start_angle)
    )
    state = machine_type(kinds_of(value)).state
    start = _start(known, state, {})
    lengths = np.array([_length(machine, item) for item in state])
    return _Opened(value, state, lengths, start, _light(machine, value, start))


def _dependent(known: Ideal, value: Planar, paths: list) -> tuple[int, ...]:
    """Return the indices of the dependent coordinates: machines that differ in masses and loads share them."""
    kinds = kinds_of(value)
    return _shared_dependent(geometry_of(known.whole), kinds, Alike((value, machine_type(kinds), paths)))


@functools.lru_cache(maxsize=64)
def _shared_dependent(key: bytes, kinds: tuple, given: Alike) -> tuple[int, ...]:
    return tuple(bound_of(*given.value))


def _light(machine: Machine, value: Planar, start: np.ndarray) -> list[str]:
    """Return the moving bodies without mass or moment of inertia."""
    none = tuple(Load(0.0, 0.0, 0.0, 0.0, ()) for joint in value.joints if isinstance(joint.site, Open))
    try:
        with np.errstate(all="ignore"):
            accelerations = function_of(value, "accelerate")(value, function_of(value, "place")(value, start), none)
        sound = bool(np.all(np.isfinite([*accelerations.accelerations, accelerations.torque])))
    except ZeroDivisionError:
        sound = False
    if sound:
        return []
    moving = _moving(machine)
    return [name for name in moving if 0.0 in (machine.bodies[name].mass, machine.bodies[name].inertia)] or moving


def _start(known: Ideal, state: list[Coordinate], offsets: Mapping) -> np.ndarray:
    """Return coordinates, their rates and time."""
    machine, angle = known.whole, known.machine.drive.start_angle
    there = known.apart(offsets, angle)
    if not np.all(np.isfinite(there.q)):
        raise ClosureError("its joints cannot begin as far apart as asked for", _moving(machine)[0], angle)
    values = [known.read(item, there) for item in state]
    speed = crank_speed(machine)
    places, rates = [float(place) for place, _ in values], [speed * float(slope) for _, slope in values]
    for i, item in enumerate(state):
        initial = None if item.kind == RUN else machine.bodies[_moving(machine)[item.of - 1]].initial
        if initial is not None:
            places[i], rates[i] = start_of(initial, item.kind)
    return np.array([*places, *rates, 0.0])


def crank_speed(machine: Machine) -> float:
    """Return the initial speed (rad/s) of the crank."""
    if isinstance(machine.drive, Motor):
        return machine.drive.initial_speed
    return driven(drive_of(machine.drive), 0.0)[1]


def stops(machine: Machine) -> list[float]:
    """Return the times (s) at which an acceleration or the slope of a load jumps, where steps should end."""
    times = {time for load in machine.loads for time in stops_of(load)}
    if isinstance(machine.drive, Schedule):
        times |= set(map(float, machine.drive.times))
    return sorted(time for time in times if time > 0.0)


def _value(machine: Machine, opened: frozenset[str]) -> Planar:
    """Return the compiled form with open joints of these names, without dependent coordinates."""
    numbers = {name: numbered(i) for i, name in enumerate([GROUND, *_moving(machine)])}
    placed = []
    for joint in machine.joints:
        site: tuple = Open() if joint.name in opened else Closed()
        ends = (numbers[joint.proximal.body], numbers[joint.distal.body])
        points = (_point(machine, joint.proximal), _point(machine, joint.distal))
        if isinstance(joint, (Guide, Stretch, Slot)):
            is_spring = isinstance(joint, Stretch)
            site = Sprung(joint.stiffness, joint.damping) if is_spring else site
            axis = direction_of(math.cos(joint.axis), math.sin(joint.axis))
            placed.append(Slide(site, *ends, *points, axis))
        else:
            placed.append(Hinge(site, *ends, *points))
    crank = next(joint.distal.body for joint in machine.joints if joint.name == machine.driven)
    return Planar(
        bodies=tuple(masses_of(machine)),
        joints=tuple(placed),
        dependent=(),
        crank=numbers[crank],
        drive=drive_of(machine.drive),
        gravity=machine.gravity,
        loads=loads_of(
            machine.loads,
            lambda at: (numbers[at.body], _point(machine, at)),
            lambda name: numbered([joint.name for joint in machine.joints].index(name)),
        ),
        aim=_aim(machine, machine.aim, numbers),
        turn=(),
    )


def _moving(machine: Machine) -> list[str]:
    return [name for name in machine.bodies if name != GROUND]


def _point(machine: Machine, at: At) -> tuple:
    body = machine.bodies[at.body]
    center = (0.0, 0.0) if at.body == GROUND else body.center
    x, y = np.subtract(body.points[at.point], center)
    return point_of(float(x), float(y))


def _aim(machine: Machine, aim: Aim, numbers: Mapping) -> tuple:
    if not aim.point:
        return AngleAim(numbers[aim.body])
    direction = direction_of(math.cos(aim.direction), math.sin(aim.direction))
    return PointAim(numbers[aim.body], _point(machine, At(aim.body, aim.point)), direction)


def _length(machine: Machine, item: Coordinate) -> float:
    """Return the displacement (m) of bodies for a unit of a coordinate."""
    if item.kind != ANGLE:
        return 1.0
    return extent(machine.bodies[_moving(machine)[item.of - 1]]) or 1.0
