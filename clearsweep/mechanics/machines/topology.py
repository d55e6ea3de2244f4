"""The mechanism of any topology, with user-defined bodies, points and joints, in the plane or in space."""

from collections.abc import Iterable, Mapping

from ...contracts.case import SUFFIX_WITH_CLEARANCE, Case
from ...contracts.catalogue import (
    ANY,
    CHOICE,
    CONDITION,
    FULL_OUTLINE,
    GROUND,
    Choice,
    Field,
    JointSite,
    Keys,
    Mechanism,
    Outline,
    Output,
    ranged,
)
from ...contracts.machine import Aim, Body, Initial, Machine, Pin
from . import described
from .described import POSITION, joint_keys, joint_of, output_keys, pair_at, vibration_keys
from .gears import FLANKED, mesh_of, stops_of
from .loads import LoadPoints
from .spatial import build as spatial

DRIVEN_TEXT = "the revolute joint that the drive turns; it connects the ground and the crank, or a wheel of its own"

# ---------------------------------------------------------------------------------------------- in space


def mechanism(outline: Outline, planar_mechanism: Mechanism) -> Mechanism:
    """Return the spatial form of the planar mechanism `planar_mechanism` in a grid."""
    output = Output("output", "rad" if outline.rotary else "m")
    moving_names = tuple(described.column_name(body.name) for body in outline.bodies if body.name != GROUND)
    output_channels = described.channels_of((), output, ("place", "rate", "acceleration"))
    torque = "crank/torque" if "crank" in moving_names else "drive/torque"
    return spatial.in_space(
        planar_mechanism,
        outline,
        _assembly,
        bodies=tuple(body.name for body in outline.bodies),
        joints=tuple(
            JointSite(joint.name, *joint.bodies, spatial.site_kind_of(outline, joint.name), joint.journal)
            for joint in outline.joints
            if joint.type != "prismatic"
        ),
        keys=(*_keys(outline), *vibration_keys(outline, (body.name for body in outline.bodies))),
        channels=(
            *(channel._replace(name=torque) if "torque" in channel.name else channel for channel in output_channels),
            *spatial.body_channels(moving_names),
        ),
        output=output,
        refusal=refusal,
    )


# ---------------------------------------------------------------------------------------------- a case


def _assembly(outline: Outline, values: Mapping, speed: float) -> spatial.Assembly:
    """Return the spatial machine of a case."""
    solids, no_vector = {}, (0.0, 0.0, 0.0)
    for body in outline.bodies:
        prefix = f"bodies.{body.name}"
        points = {point: spatial.vector_at(values, f"{prefix}.points.{point}") for point in body.points}
        is_fixed = body.name == GROUND
        solids[body.name] = (
            spatial.Solid(0.0, no_vector, no_vector, points) if is_fixed else spatial.solid_of(values, prefix, points)
        )
    joints = tuple(joint_of(values, joint) for joint in outline.joints)
    start = {key.removeprefix("start."): angle for key, angle in values.items() if key.startswith("start.")}
    aim = Aim(values["output.body"], values.get("output.point", ""), values.get("output.along", 0.0))
    journals = {joint.name: joint.journal or joint.bodies[1] for joint in outline.joints}
    return spatial.assembly_of(values, speed, solids, joints, values["driven"], aim, start)._replace(journals=journals)


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` at fault, and a sentence, if a case's machine is impossible in space."""
    driven = case.mechanism.values["driven"]
    freedom = case.mechanism.values.get(f"ideal.{driven}", spatial.REVOLUTE)
    if freedom != spatial.REVOLUTE:
        return f"ideal.{driven}", f"is {freedom}, but the drive turns a revolute joint; leave it out"
    return spatial.refusal(mechanism, case)


# ---------------------------------------------------------------------------------------------- in the plane


_BODY = (
    ranged("mass", "kg", "mass of the body", "[0, inf)"),
    ranged("inertia", "kg*m^2", "moment of inertia about the centre of mass", "[0, inf)"),
)
_INITIAL = tuple(
    ranged(name, unit, text, "(-inf, inf)", default=0.0)
    for name, unit, text in (
        ("x", "m", "x coordinate of the centre of mass in the fixed frame"),
        ("y", "m", "y coordinate of the centre of mass in the fixed frame"),
        ("angle", "rad", "angle of the body frame, counter-clockwise"),
        ("vx", "m/s", "x component of the velocity of the centre of mass"),
        ("vy", "m/s", "y component of the velocity of the centre of mass"),
        ("rate", "rad/s", "angular velocity of the body, counter-clockwise"),
    )
)


def with_outline(outline: Outline) -> Mechanism:
    """Return the mechanism that a grid describes."""
    if outline.spatial:
        return mechanism(outline, MECHANISM)
    bodies = tuple(body.name for body in outline.bodies)
    points = {body.name: body.points for body in outline.bodies}
    output = Output("output", "rad" if outline.rotary else "m")
    grounded = [joint.name for joint in outline.joints if GROUND in joint.bodies and joint.type not in FLANKED]
    names = tuple(joint.name for joint in outline.joints)
    sections = described.keys_of(outline, points, names, [ANY] if names == (ANY,) else grounded)
    return MECHANISM._replace(
        bodies=bodies,
        joints=outline.sites(tuple(_sites(outline))),
        keys=(*_keys(outline), *sections),
        channels=described.channels_of(bodies, output, ("place", "rate", "acceleration"), outline),
        output=output,
        free=outline.free,
        length=outline.length,
    )


def _sites(outline: Outline) -> Iterable[JointSite]:
    """Yield the joints, and the stops of those that also have a clearance."""
    for joint in outline.joints:
        kind = {"prismatic": "guide"}.get(joint.type, joint.type)
        stops, is_open = {"guide": "guide_stops", "revolute": "stops"}.get(kind, ""), joint.name in outline.clearances
        yield JointSite(joint.name, *joint.bodies, stops if joint.stops and not is_open else kind, joint.journal)
        if joint.stops and is_open:
            yield JointSite(f"{joint.name}{SUFFIX_WITH_CLEARANCE}", *joint.bodies, stops, stopped=joint.name)


def _keys(outline: Outline) -> Iterable[Keys]:
    """Yield the sections of the bodies, the joints and the other parts of a mechanism, in the plane or in space."""
    in_space = outline.spatial
    pins = tuple(
        joint.name
        for joint in outline.joints
        if (joint.type != "prismatic" if in_space else joint.type in ("revolute", ANY))
    )
    driven = Keys("mechanism", "", words=(Choice("driven", pins, DRIVEN_TEXT),), flags=(spatial.SPATIAL_FLAG,))
    yield from (driven, spatial.gravity_keys()) if in_space else (described.gravity_section(outline), driven)
    frames = "; their frames are as in the plane" if in_space else ""
    yield Keys("mechanism.bodies", f"the bodies by name, `ground` among them{frames}")
    for body in outline.bodies:
        path = f"mechanism.bodies.{body.name}"
        if body.name == GROUND:
            yield Keys(path, "the fixed body", role=CHOICE)
        else:
            yield from _body_keys_in_space(path) if in_space else _body_keys(path)
        yield Keys(f"{path}.points", "points of the body, by name", need="implied")
        if body.name != GROUND and not in_space:
            yield from described.elastic_keys(path, outline, body.points)
        position = spatial.along_axes("m", "of the body's frame", default=None) if in_space else POSITION
        text = "position of the point in the frame of its body" + ("; z is along the pins" if in_space else "")
        yield from (Keys(f"{path}.points.{point}", text, position, role=CHOICE) for point in body.points)
    yield Keys("mechanism.joints", "the joints between the bodies, by name")
    endpoints = tuple(f"{body.name}.{point}" for body in outline.bodies for point in body.points)
    for joint in outline.joints:
        yield from joint_keys(joint, endpoints)
    if in_space:
        yield spatial.freedom_keys(outline, pins)
    yield from output_keys(outline)
    if in_space:
        yield spatial.speed_keys()


_BODY_TEXT, _CENTER_TEXT = "a body of the mechanism", "centre of mass in the frame of the body"


def _body_keys(path: str) -> Iterable[Keys]:
    """Yield the sections of a moving body in the plane."""
    yield Keys(path, _BODY_TEXT, _BODY, role=CHOICE)
    center = tuple(field._replace(default=0.0) for field in POSITION)
    yield Keys(f"{path}.center", _CENTER_TEXT, center, "implied", role=CHOICE)
    text = (
        "initial state of a body that has no ideal joint; of one on an ideal pin only angle and rate. Without this "
        "section, the body starts as in the ideal mechanism"
    )
    yield Keys(f"{path}.initial", text, _INITIAL, "optional", role=CONDITION)


def _body_keys_in_space(path: str) -> Iterable[Keys]:
    """Yield the sections of a moving body in space."""
    yield Keys(path, _BODY_TEXT, (Field("mass", "kg", "mass of the body"),), role=CHOICE)
    inertia = spatial.along_axes("kg*m^2", "inertia", 0.0, None)
    yield Keys(f"{path}.inertia", spatial.INERTIA_TEXT, inertia, role=CHOICE)
    center = spatial.along_axes("m", "of its frame")
    yield Keys(f"{path}.center", _CENTER_TEXT, center, "implied", role=CHOICE)


def machine(case: Case) -> Machine:
    """Return the machine of a case."""
    values, outline = case.mechanism.values, case.outline
    bodies = {}
    for body in outline.bodies:
        prefix, is_fixed = f"bodies.{body.name}", body.name == GROUND
        mass, inertia = (0.0, 0.0) if is_fixed else (values[f"{prefix}.mass"], values[f"{prefix}.inertia"])
        center = (0.0, 0.0) if is_fixed else pair_at(values, f"{prefix}.center")
        points = {point: pair_at(values, f"{prefix}.points.{point}") for point in body.points}
        has_initial_state = f"{prefix}.initial.x" in values
        initial = (
            Initial(*(values[f"{prefix}.initial.{name}"] for name in Initial._fields)) if has_initial_state else None
        )
        bodies[body.name] = Body(mass, inertia, center, points, described.elastic_of(values, prefix, points), initial)
    load_points = LoadPoints(bodies, {})
    plain_joints = {joint.name: joint_of(values, joint) for joint in outline.joints if joint.type not in FLANKED}
    pins = [joint for joint in plain_joints.values() if isinstance(joint, Pin)]
    joints = tuple(
        plain_joints[joint.name] if joint.name in plain_joints else mesh_of(values, joint, pins, load_points)
        for joint in outline.joints
    )
    stopped = (plain_joints[joint.name] for joint in outline.joints if joint.stops)
    joints = (*joints, *map(stops_of, stopped))
    start = {key.removeprefix("start."): angle for key, angle in values.items() if key.startswith("start.")}
    aim = Aim(values["output.body"], values.get("output.point", ""), values.get("output.along", 0.0))
    return described.machine_of(case, load_points, joints, values["driven"], aim, start)


MECHANISM = Mechanism(
    "planar",
    "any mechanism of bodies in a plane with revolute and prismatic joints and slots, each of which may have clearance",
    "Newton-Euler; the ideal joints are eliminated, their loops closed to rounding",
    "Newton-Euler of rigid bodies in a plane, see mechanics/machines/planar",
    "Bodies, points and joints have the names that the grid gives them.",
    bodies=(GROUND,),
    joints=(),
    keys=tuple(_keys(FULL_OUTLINE)),
    channels=(),
    turns=True,
    build=None,
    output=Output("output", "m"),
    with_outline=with_outline,
    machine=machine,
    refusal=described.refusal,
)
