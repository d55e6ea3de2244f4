"""Bodies, joints and loads of a mechanism in its initial position, for drawings."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import Case, Joint
from ...contracts.machine import (
    GROUND,
    Braking,
    Guide,
    Machine,
    Mesh,
    Push,
    Rubbing,
    Slot,
    Spring,
    Stops,
    TorsionSpring,
)
from ...language.errors import InputError
from ...mechanics.machines import planar
from ...mechanics.machines.described import without_own_forces
from ...mechanics.machines.planar.ideal import ideal_of
from .ideal import mechanism_of


class SketchedBody(NamedTuple):
    """A body; positions in m, in the fixed frame."""

    name: str
    points: np.ndarray  # (n, 2) positions of its joints
    center: np.ndarray  # (2,) centre of mass; for the ground, its first point
    angle: float  # rad, of its frame
    elastic_ends: np.ndarray | None = None  # (2, 2) ends of the elastic link; None: rigid
    rims: tuple[np.ndarray, ...] = ()  # (n, 2) of each gear of the body: its pitch circle, closed, then its centre


class SketchedJoint(NamedTuple):
    """A joint; position in m, in the fixed frame."""

    name: str
    position: np.ndarray  # (2,)
    guide: float | None  # rad, direction of a guide; None: a pin
    has_clearance: bool  # it has clearance
    driven: bool
    grounded: bool  # one of its bodies is the ground
    guiding_body: str = ""  # the body with the walls of a guide or a slot
    sliding_body: str = ""  # the body in a guide or a slot
    slot: np.ndarray | None = None  # (n, 2) m, the wall of a slot; None for another joint


class SketchedLoad(NamedTuple):
    """A load; positions in m, in the fixed frame."""

    name: str
    position: np.ndarray  # (2,)
    direction: np.ndarray | None  # (2,) unit vector of a force; None: no fixed direction
    anchor: np.ndarray | None = None  # (2,) the other end of a spring


class Sketch(NamedTuple):
    """A mechanism in its initial position, without clearance."""

    bodies: tuple[SketchedBody, ...]
    joints: tuple[SketchedJoint, ...]
    loads: tuple[SketchedLoad, ...]
    angle: float  # rad, of the crank


def sketch(case: Case) -> Sketch | None:
    """Return the initial position of a case's machine, or None without machine.

    Raises InputError if it cannot close.
    """
    mechanism = mechanism_of(case)
    if mechanism.machine is None:
        return None
    machine = mechanism.machine(without_own_forces(case))
    frames = _frames(machine)

    def position_of(body: str, point: str) -> np.ndarray:
        return _placed(frames[body], machine.bodies[body].points[point])

    clearance_joints = {joint.name: joint for joint in case.joints}
    joints: list[SketchedJoint] = []
    carried_points: dict[str, list[np.ndarray]] = {name: [] for name in machine.bodies}
    body_rims: dict[str, list[np.ndarray]] = {name: [] for name in machine.bodies}
    for joint in machine.joints:
        if isinstance(joint, Stops):
            continue
        endpoints, has_clearance = (joint.proximal, joint.distal), joint.name in clearance_joints
        first, second = (position_of(*endpoint) for endpoint in endpoints)
        if isinstance(joint, Mesh):
            for endpoint, rim in zip(endpoints, _rims(joint, first, second), strict=False):
                body_rims[endpoint.body].append(rim)
            touching = _pitch_point(joint, first, second)
            joints.append(SketchedJoint(joint.name, touching, None, has_clearance, driven=False, grounded=False))
            continue
        slides = isinstance(joint, Guide | Slot)
        direction = joint.axis + frames[joint.proximal.body][1] if isinstance(joint, Guide | Slot) else 0.0
        joints.append(
            SketchedJoint(
                joint.name,
                second,
                direction if isinstance(joint, Guide) else None,
                has_clearance,
                joint.name == machine.driven,
                GROUND in (joint.proximal.body, joint.distal.body),
                joint.proximal.body if slides else "",
                joint.distal.body if slides else "",
                _slot_wall(first, direction, clearance_joints[joint.name]) if isinstance(joint, Slot) else None,
            )
        )
        for endpoint, position in zip(endpoints, (first, second), strict=True):
            carried_points[endpoint.body].append(position)
    bodies = tuple(
        SketchedBody(
            name,
            np.unique(np.round(carried_points[name], 12), axis=0),
            _placed(frames[name], machine.bodies[name].center),
            frames[name][1],
            np.array([position_of(name, point) for point in body.elastic[:2]]) if body.elastic else None,
            tuple(body_rims[name]),
        )
        for name, body in machine.bodies.items()
        if carried_points[name]
    )
    loads = tuple(_sketched_load(load, position_of, joints) for load in machine.loads)
    drive: Any = machine.drive  # mypy takes it for a tuple of anything
    return Sketch(bodies, tuple(joints), loads, float(drive.start_angle))


def _frames(machine: Machine) -> dict[str, tuple[np.ndarray, float]]:
    """Return the origin (2,) m and the angle (rad) of every body's frame at the start."""
    try:
        ideal_machine = ideal_of(planar.without_forces(machine))
    except (planar.ClosureError, planar.MobilityError) as error:
        raise InputError(f"mechanism: {error}") from error
    frames = {GROUND: (np.zeros(2), 0.0)}
    poses = dict(zip(ideal_machine.closure.names, ideal_machine.revolution.q[0].reshape(-1, 3), strict=True))
    poses |= {name: body.initial[:3] for name, body in machine.bodies.items() if body.initial and name not in poses}
    for name, (x, y, angle) in poses.items():
        c, s = math.cos(angle), math.sin(angle)
        cx, cy = machine.bodies[name].center
        frames[name] = (np.array([x - (c * cx - s * cy), y - (s * cx + c * cy)]), angle)
    return frames


def _pitch_point(mesh: Mesh, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the point (2,) m where the pitch circles of two wheels touch; of a coupling the second centre."""
    if not mesh.pins:
        return second
    point: np.ndarray = first + (second - first) / (1.0 + mesh.ratio)
    return point


def _rims(mesh: Mesh, first: np.ndarray, second: np.ndarray) -> list[np.ndarray]:
    """Return the pitch circles (n, 2) m of both wheels, each followed by its centre; [] for a coupling."""
    if not mesh.pins:
        return []
    touching, turn = _pitch_point(mesh, first, second), np.linspace(0.0, 2.0 * math.pi, 49)
    rims = []
    for centre in (first, second):
        x, y = touching - centre
        circle = np.stack([x * np.cos(turn) - y * np.sin(turn), y * np.cos(turn) + x * np.sin(turn)], -1)
        rims.append(centre + np.concatenate([circle, np.zeros((1, 2))]))
    return rims


def _slot_wall(middle: np.ndarray, direction: float, joint: Joint) -> np.ndarray:
    """Return the wall (n, 2) m of a slot: two half circles, their centres the length of the slot apart, joined."""
    length, radius = joint.slot_length or 0.0, joint.bearing_radius or 0.0
    turn = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 13)
    end = np.stack([0.5 * length + radius * np.cos(turn), radius * np.sin(turn)], -1)
    x, y = np.concatenate([end, -end, end[:1]]).T
    c, s = math.cos(direction), math.sin(direction)
    wall: np.ndarray = middle + np.stack([c * x - s * y, s * x + c * y], -1)
    return wall


def _placed(frame: tuple[np.ndarray, float], point: Sequence[float]) -> np.ndarray:
    """Return the place (2,) m of a point of a body in the fixed frame; frame : origin (2,) m and angle (rad)."""
    (origin, angle), (x, y) = frame, point
    c, s = math.cos(angle), math.sin(angle)
    position: np.ndarray = origin + np.array([c * x - s * y, s * x + c * y])
    return position


def _sketched_load(
    load: Any, position_of: Callable[[str, str], np.ndarray], joints: list[SketchedJoint]
) -> SketchedLoad:
    if isinstance(load, (Rubbing, Braking)):
        return SketchedLoad(load.name, next(joint.position for joint in joints if joint.name == load.joint), None)
    if isinstance(load, TorsionSpring):
        return SketchedLoad(load.name, position_of(*load.second), None)
    if isinstance(load, Spring):
        return SketchedLoad(load.name, position_of(*load.second), None, position_of(*load.first))
    force = np.array([load.fx, load.fy]) if isinstance(load, Push) else np.zeros(2)
    magnitude = float(np.hypot(*force))
    return SketchedLoad(load.name, position_of(*load.at), force / magnitude if magnitude else None)
