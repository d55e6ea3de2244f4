"""Builds the tree of a spatial machine and its initial state from the planar machine, its solids and clearances."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ....contracts.case import Case
from ....contracts.catalogue import (
    ANY,
    CONDITION,
    Channel,
    Choice,
    Field,
    Keys,
    Mechanism,
    Outline,
)
from ....contracts.machine import GROUND, Aim, Body, BodyPoint, Constant, Guide, Initial, Machine, Push
from ....tracing import portable
from ....tracing.compiled.vector import Vector
from ...joints.spatial import SpatialLoad, deepest_of, overlap_of
from .. import described
from ..contract import Built, gaps, has_finite_accelerations, pose_at
from ..drives import CRANK_SPEED
from ..planar.closure import MobilityError, extent
from ..planar.form import as_empty_tuples, make_cycle
from ..planar.ideal import ideal_of
from . import dynamics  # noqa: F401 - registers the equations of motion
from .form import Ball, Driven, Hinge, Loose, Opening, Sleeve, Slide, Solid, Tree

# ---------------------------------------------------------------------------------------------- the spanning tree


REVOLUTE, SPHERICAL, CYLINDRICAL = "revolute", "spherical", "cylindrical"
FORMS = {SPHERICAL: Ball, CYLINDRICAL: Sleeve}  # of pins that are no hinges


class Attachment(NamedTuple):
    """Attachment of a body."""

    body: str
    form: type = Loose  # of `form`
    joint: Any = None  # of the machine
    near: Any = None  # BodyPoint of the joint on the parent
    far: Any = None  # on the body


def _attached(machine: Machine, joint: Any, body: str, ideal: Mapping[str, str]) -> Attachment:
    """Return the attachment of a body by a joint."""
    form = Slide if isinstance(joint, Guide) else FORMS.get(ideal.get(joint.name, ""), Hinge)
    endpoints = (joint.proximal, joint.distal) if joint.distal.body == body else (joint.distal, joint.proximal)
    return Attachment(body, Driven if joint.name == machine.driven else form, joint, *endpoints)


class SpanningTreeError(ValueError):
    """A machine that is not a tree, or that cannot leave the plane; `joint` is at fault."""

    def __init__(self, joint: str, text: str):
        super().__init__(text)
        self.joint = joint


def spanning_tree(machine: Machine, open_joints: Collection[str], ideal: Mapping[str, str]) -> list[Attachment]:
    """Return the attachments of the moving bodies, parents first, beginning with the crank.

    open_joints : those with clearance; ideal : freedom of each other pin.  Raises SpanningTreeError.
    """
    ideal_joints = [joint for joint in machine.joints if joint.name not in open_joints]
    crank = next(joint for joint in ideal_joints if joint.name == machine.driven)
    attachments = [_attached(machine, crank, crank.distal.body, ideal)]
    used_joints, placed = {crank.name}, {GROUND, crank.distal.body}
    while len(placed) < len(machine.bodies):
        for joint in ideal_joints:
            unplaced = [end.body for end in (joint.proximal, joint.distal) if end.body not in placed]
            if len(unplaced) == 1:
                attachments.append(_attached(machine, joint, unplaced[0], ideal))
                used_joints.add(joint.name)
                break
        else:
            attachments.append(Attachment(next(body for body in machine.bodies if body not in placed)))
        placed.add(attachments[-1].body)
    for joint in ideal_joints:
        if joint.name not in used_joints:
            raise SpanningTreeError(
                joint.name,
                "closes a loop of joints without clearance, which is not known in space: give clearance to "
                f"{joint.name} or to another joint of that loop",
            )
    _check_mobility(machine, open_joints, attachments)
    return attachments


def _check_mobility(machine: Machine, open_joints: Collection[str], attachments: list[Attachment]) -> None:
    """Raise SpanningTreeError if pins keep both bodies of an open joint in the plane."""
    flat = {GROUND}
    for attachment in attachments:
        if attachment.form in (Driven, Hinge, Slide) and attachment.near.body in flat:
            flat.add(attachment.body)
    for joint in machine.joints:
        if joint.name in open_joints and {joint.proximal.body, joint.distal.body} <= flat:
            pins = [each.joint.name for each in attachments if each.form is Hinge and each.body in flat]
            raise SpanningTreeError(
                joint.name,
                f"cannot tilt or shift: {' and '.join([machine.driven, *pins])} are revolute joints, which keep its "
                "bodies in the plane" + (f"; write ideal: {{{pins[-1]}: spherical}} or cylindrical" if pins else ""),
            )


def joint_named(machine: Machine, name: str):
    """Return the joint of this name."""
    return next(joint for joint in machine.joints if joint.name == name)


# ---------------------------------------------------------------------------------------------- the compiled form


ZERO_VECTOR = Vector(0.0, 0.0, 0.0)


class Assembly(NamedTuple):
    """A spatial machine: the planar machine, its bodies, the freedom of its ideal pins, and gravity."""

    machine: Machine
    solids: Mapping[str, Solid]
    ideal: Mapping[str, str]  # pin -> 'spherical', 'cylindrical'; default: revolute
    gravity: tuple[float, ...]  # m/s^2
    journals: Mapping[str, str] = {}  # joint -> the body that carries the journal


def build(assembly: Assembly, joints: Mapping) -> Built:
    """Return a tree at crank angle 0, with positions and velocities of the ideal planar machine.

    joints : compiled form of each joint with clearance, in the order of the machine's.  Raises ClosureError,
    MobilityError, SpanningTreeError.
    """
    machine, ideal_machine = assembly.machine, ideal_of(assembly.machine)
    attachments = spanning_tree(machine, joints, assembly.ideal)
    numbers = {GROUND: ()} | {attachment.body: as_empty_tuples(i + 1) for i, attachment in enumerate(attachments)}
    reported = tuple(numbers[name] for name in machine.bodies if name != GROUND)
    speed, solids = machine.drive.speed, [assembly.solids[attachment.body] for attachment in attachments]
    value = Tree(
        parts=tuple(Solid(each.mass, Vector(*each.inertia), Vector(*each.center), ()) for each in solids),
        attachments=tuple(_compile_attachment(assembly, attachment, numbers) for attachment in attachments),
        openings=tuple(_compile_opening(assembly, name, joint, numbers) for name, joint in joints.items()),
        reported=reported,
        aim=_compile_aim(assembly, numbers),
        speed=speed,
        gravity=Vector(*assembly.gravity),
        cycle=make_cycle([ideal_machine.output_over_revolution()], 0.0),
    )
    body_poses, by_body = _planar_positions(assembly), {attachment.body: attachment for attachment in attachments}
    values = [_coordinates(assembly, attachment, body_poses, (joints, by_body)) for attachment in attachments]
    start = np.array([*(q for qs, _ in values for q in qs), *(rate for _, rates in values for rate in rates), 0.0])
    lengths = np.array([length for attachment in attachments for length in _lengths_per_unit(assembly, attachment)])
    _check_masses(value, start)
    return Built(value, start, lengths, ideal_machine.closure.size, abs(speed))


class Seat(NamedTuple):
    """Position of a journal in its bearing."""

    depth: float  # m, largest penetration, negative if separate
    overlap: float  # m, overlap of journal and bore along the journal's axis; 0 or less: outside the bearing


def initial_seats(built: Built, joints: Mapping) -> dict[str, Seat]:
    """Return the initial position of each journal in its bearing.

    joints : compiled forms in the order of the mechanism's sites.
    """
    joint_gaps = gaps(built.value, pose_at(built.value, built.start))
    pairs = zip(joints.items(), joint_gaps, strict=True)
    return {name: Seat(deepest_of(joint, gap), float(overlap_of(joint, gap))) for (name, joint), gap in pairs}


def _point(assembly: Assembly, endpoint: BodyPoint) -> Vector:
    return Vector(*assembly.solids[endpoint.body].points[endpoint.point])


def _compile_attachment(assembly: Assembly, attachment: Attachment, numbers: Mapping) -> tuple:
    """Return the attachment of a body in compiled form."""
    form, joint = attachment.form, attachment.joint
    if form is Loose:
        return Loose()
    points = [_point(assembly, endpoint) for endpoint in (attachment.near, attachment.far)]
    if form is Driven:
        return Driven(*points)
    axis = [Vector(math.cos(joint.axis), math.sin(joint.axis), 0.0)] if form is Slide else []
    compiled: tuple = form(numbers[attachment.near.body], *points, *axis)
    return compiled


def _compile_opening(assembly: Assembly, name: str, joint, numbers: Mapping) -> Opening:
    """Return a joint with clearance in compiled form."""
    site = joint_named(assembly.machine, name)
    bearing, journal = site.proximal, site.distal
    if assembly.journals[name] == bearing.body:
        bearing, journal = journal, bearing
    midpoint = np.add(_point(assembly, bearing), joint.offset)
    return Opening(
        numbers[bearing.body],
        numbers[journal.body],
        Vector(*map(float, midpoint)),
        _point(assembly, journal),
        joint.axis,
        joint.across,
    )


def _compile_aim(assembly: Assembly, numbers: Mapping) -> tuple:
    aim: Any = assembly.machine.aim
    if not aim.point:
        return Aim(numbers[aim.body], (), ())
    direction = Vector(math.cos(aim.direction), math.sin(aim.direction), 0.0)
    return Aim(numbers[aim.body], _point(assembly, BodyPoint(aim.body, aim.point)), direction)


# ---------------------------------------------------------------------------------------------- the start


def _planar_positions(assembly: Assembly) -> dict[str, Initial]:
    """Return the positions and velocities of the bodies at crank angle 0, from their planar motion."""
    machine, ideal_machine = assembly.machine, ideal_of(assembly.machine)
    states, speed = ideal_machine.states_at(np.array([0.0])), machine.drive.speed
    poses = {GROUND: Initial(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)}
    for name, i in ideal_machine.closure.index.items():
        q, derivative = (values[0, 3 * i : 3 * i + 3] for values in (states.q, states.derivative))
        poses[name] = Initial(*map(float, q), *(float(speed * slope) for slope in derivative))
    return poses


def _coordinates(assembly: Assembly, attachment: Attachment, body_poses: Mapping, opened: tuple) -> tuple[list, list]:
    """Return the coordinates of a body and their rates; opened : see `_height_of_loose_body`."""
    form, pose = attachment.form, body_poses[attachment.body]
    if form is Driven:
        return [], []
    if form is Slide:
        return _sliding_coordinates(assembly, attachment, body_poses)
    if form is Ball:
        return _quaternion(pose)
    if form is Loose:
        coordinates, angular_rates = _quaternion(pose)
        height = _height_of_loose_body(assembly, attachment.body, *opened)
        return [*coordinates, pose.x, pose.y, height], [*angular_rates, pose.vx, pose.vy, 0.0]
    parent_pose, shift = body_poses[attachment.near.body], [0.0] if form is Sleeve else []
    return [*shift, pose.angle - parent_pose.angle], [*shift, pose.rate - parent_pose.rate]


def _quaternion(pose: Initial) -> tuple[list, list]:
    c, s, half_spin = math.cos(0.5 * pose.angle), math.sin(0.5 * pose.angle), 0.5 * pose.rate
    return [c, 0.0, 0.0, s], [-half_spin * s, 0.0, 0.0, half_spin * c]


def _sliding_coordinates(assembly: Assembly, attachment: Attachment, body_poses: Mapping) -> tuple[list, list]:
    """Return displacement and speed of a sliding body."""
    parent_pose = body_poses[attachment.near.body]
    axis = parent_pose.angle + attachment.joint.axis
    direction = np.array([math.cos(axis), math.sin(axis)])
    (near_end, near_velocity), (far_end, far_velocity) = (
        _planar_point(assembly, endpoint, body_poses) for endpoint in (attachment.near, attachment.far)
    )
    axis_rate = parent_pose.rate * np.array([-direction[1], direction[0]])
    return [float(portable.product(direction, far_end - near_end))], [
        float(
            portable.product(direction, far_velocity - near_velocity) + portable.product(axis_rate, far_end - near_end)
        )
    ]


def _planar_point(assembly: Assembly, endpoint: BodyPoint, body_poses: Mapping) -> tuple[np.ndarray, np.ndarray]:
    """Return position and velocity of a point in the plane."""
    pose, solid = body_poses[endpoint.body], assembly.solids[endpoint.body]
    x, y = np.subtract(solid.points[endpoint.point], solid.center)[:2]
    c, s = math.cos(pose.angle), math.sin(pose.angle)
    arm = np.array([c * x - s * y, s * x + c * y])
    return np.array([pose.x, pose.y]) + arm, np.array([pose.vx, pose.vy]) + pose.rate * np.array([-arm[1], arm[0]])


def _height_of_loose_body(
    assembly: Assembly, body: str, joints: Mapping, attachments: Mapping[str, Attachment]
) -> float:
    """Return the height (m) of a loose body's centre of mass, with the first of its open joints centred.

    joints : open ones by name; attachments : by body
    """
    ends = next(
        (joint.proximal, joint.distal) if joint.proximal.body == body else (joint.distal, joint.proximal)
        for joint in assembly.machine.joints
        if joint.name in joints and body in (joint.proximal.body, joint.distal.body)
    )
    own_height, center = _point(assembly, ends[0]).z, assembly.solids[body].center[2]
    return _height_of_point(assembly, ends[1], attachments) - own_height + center


def _height_of_point(assembly: Assembly, endpoint: BodyPoint, attachments: Mapping[str, Attachment]) -> float:
    """Return the height (m) of a point; for a loose body, in its own frame."""
    height = _point(assembly, endpoint).z
    if endpoint.body == GROUND or attachments[endpoint.body].form is Loose:
        return height
    near, far = attachments[endpoint.body][3:]
    return height - _point(assembly, far).z + _height_of_point(assembly, near, attachments)


def _lengths_per_unit(assembly: Assembly, attachment: Attachment) -> list[float]:
    """Return the displacement (m) of a body for a unit of each of its coordinates."""
    bodies = assembly.machine.bodies
    size = extent(bodies[attachment.body]) or max(map(extent, bodies.values())) or 1.0
    rotations = [2.0 * size] * 4
    lengths = {Slide: [1.0], Hinge: [size], Sleeve: [1.0, size], Ball: rotations, Loose: [*rotations, 1.0, 1.0, 1.0]}
    return lengths.get(attachment.form, [])


def _check_masses(value: Tree, start: np.ndarray) -> None:
    """Raise MobilityError if a turning body has no moment of inertia."""
    no_loads = tuple(SpatialLoad(ZERO_VECTOR, ZERO_VECTOR, ZERO_VECTOR, ()) for _ in value.openings)
    if not has_finite_accelerations(value, start, no_loads):
        raise MobilityError("with these joints open, something turns that has no moment of inertia")


# ---------------------------------------------------------------------------------------------- keys and channels


AXES = ("x", "y", "z")
_CENTRE = "its centre of mass"  # a point of every body, besides user-defined points

INERTIA_TEXT = "principal moments of inertia about the centre of mass, along the axes of the body frame"
#: The key that makes a mechanism spatial.
SPATIAL_FLAG = ("spatial", "whether the bodies move in space, connected by spatial joints")
#: The time histories of every moving body.
BODY = (
    *((axis, "m", f"{{}}'s centre of mass, {axis}") for axis in AXES),
    *((f"v{axis}", "m/s", f"velocity of the {{}}'s centre of mass, {axis}") for axis in AXES),
    *((f"q{k}", "1", f"quaternion from the {{}}'s frame to the fixed one, {k}") for k in "wxyz"),
    *((f"w{axis}", "rad/s", f"angular velocity of the {{}} in the fixed frame, {axis}") for axis in AXES),
)


def along_axes(unit: str, text: str, low: float = -math.inf, default: float | None = 0.0) -> tuple[Field, ...]:
    """Return the items of a list along the axes of a frame."""
    return tuple(
        Field(str(k), unit, f"{text}, {axis}", low, low_open=low < 0.0, default=default) for k, axis in enumerate(AXES)
    )


def gravity_keys() -> Keys:
    """Return the section of gravity."""
    text = "acceleration of gravity; a single quantity acts along -y"
    return Keys(
        "mechanism.gravity", text, along_axes("m/s^2", "gravity"), "implied", scalar_factors=(0, -1, 0), role=CONDITION
    )


def freedom_keys(outline: Outline, pins: Iterable[str]) -> Keys:
    """Return the section of the motion that pins allow where they have no clearance."""
    text = (
        "motion that a pin without clearance allows; spherical: all rotations; cylindrical: rotation about the pin and "
        "sliding along it; revolute: rotation about the pin"
    )
    freedoms, of_pin = (SPHERICAL, CYLINDRICAL, REVOLUTE), "type of this pin without clearance"
    choices = tuple(Choice(pin, freedoms, of_pin, REVOLUTE) for pin in pins if pin not in outline.clearances)
    return Keys("mechanism.ideal", text, words=choices, need="implied")


def speed_keys() -> Keys:
    """Return the section of the drive."""
    return Keys("drive", "the drive", (CRANK_SPEED,), "implied", role=CONDITION)


def site_kind_of(outline: Outline, joint: str) -> str:
    """Return the kind of a joint's site."""
    return "spatial" if {joint, ANY} & outline.axial else "through"


def body_channels(bodies: tuple[str, ...]) -> tuple[Channel, ...]:
    """Return the time histories of moving bodies, by their names in channels."""
    return tuple(Channel(f"{body}/{name}", unit, text.format(body)) for body in bodies for name, unit, text in BODY)


def vector_at(values: Mapping, path: str) -> tuple[float, ...]:
    """Return the numbers of a list."""
    return tuple(values[f"{path}.{k}"] for k in range(3))


def solid_of(values: Mapping, path: str, points: Mapping[str, tuple[float, ...]]) -> Solid:
    """Return a moving body of a case."""
    inertia, center = (vector_at(values, f"{path}.{key}") for key in ("inertia", "center"))
    return Solid(values[f"{path}.mass"], inertia, center, points)


def assembly_of(
    values: Mapping, speed: float, solids: Mapping[str, Solid], joints: tuple, driven: str, aim: Aim, start: Mapping
) -> Assembly:
    """Return the spatial machine of a case; in its planar machine gravity along x is a load."""
    gravity, bodies, loads = vector_at(values, "gravity"), {}, []
    for name, solid in solids.items():
        center = solid.center[:2]
        points = {point: position[:2] for point, position in solid.points.items()} | {_CENTRE: center}
        bodies[name] = Body(solid.mass, solid.inertia[2], center, points)
        if name != GROUND and gravity[0] != 0.0:
            loads.append(Push(name, BodyPoint(name, _CENTRE), solid.mass * gravity[0], 0.0, 0.0))
    machine = Machine(bodies, joints, driven, Constant(speed), -gravity[1], aim, start, tuple(loads))
    ideal = {key.removeprefix("ideal."): freedom for key, freedom in values.items() if key.startswith("ideal.")}
    return Assembly(machine, solids, ideal, gravity)


class MechanismBuilder(NamedTuple):
    """Builds a case's mechanism from its Assembly."""

    assembly: Callable[[Outline, Mapping, float], Assembly]  # of the numbers and words by key, drive : rad/s
    outline: Outline

    def __call__(self, bodies: Mapping, drive: float, joints: Mapping, offsets: Mapping) -> Built:
        """Return the mechanism at crank angle 0; joints : compiled; offsets : unused, spatial joints start centred."""
        return build(self.assembly(self.outline, bodies, drive), joints)


def in_space(planar: Mechanism, outline: Outline, assembly: Callable, **changes: Any) -> Mechanism:
    """Return a mechanism in space from its form in the plane; assembly : as of MechanismBuilder; changes : its fields.

    Its machine, for pictures and comparisons, is that in the plane.
    """

    def machine(case: Case) -> Machine:
        speed = case.drive.speed if case.drive else 0.0
        in_plane: Machine = assembly(case.outline, case.mechanism.values, speed).machine
        return in_plane

    changes |= {"length": outline.length, "spatial": True}
    return planar._replace(build=MechanismBuilder(assembly, outline), machine=machine, **changes)


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` at fault, and a sentence, if bodies are impossible or cannot be attached."""
    assert isinstance(mechanism.build, MechanismBuilder)  # spatial mechanisms are built in this way
    assembly = mechanism.build.assembly(case.outline, case.mechanism.values, case.drive.speed if case.drive else 0.0)
    for body, solid in assembly.solids.items():
        largest, sum_of_others = max(solid.inertia), sum(solid.inertia) - max(solid.inertia)
        if largest > sum_of_others * (1.0 + 1e-12):
            path = f"bodies.{body}.inertia" if case.outline.bodies else f"{body}.inertia"
            return path, (
                f"found {', '.join(f'{moment:.6g}' for moment in solid.inertia)} kg*m^2; no body has a principal "
                f"moment ({largest:.6g}) above the sum of the two others ({sum_of_others:.6g}): correct the largest one"
            )
    unsound = described.refusal(mechanism, case)
    if unsound:
        return unsound
    try:
        spanning_tree(assembly.machine, [joint.name for joint in case.joints], assembly.ideal)
    except SpanningTreeError as error:
        return f"joints.{error.joint}", str(error)
    return None
