"""The planar mechanism of any topology, with user-defined bodies, points and joints."""

import math
from collections.abc import Iterable

from ...contracts.case import Case
from ...contracts.catalogue import (
    ANY,
    CHOICE,
    CONDITION,
    FULL_OUTLINE,
    GROUND,
    Choice,
    Field,
    JointOutline,
    JointSite,
    Keys,
    Mechanism,
    Outline,
    Output,
)
from ...contracts.machine import Aim, Body, Initial, Machine
from . import described, topology_in_space
from .drives import make_drive
from .loads import LoadPoints, make_loads
from .named import joint_keys, joint_of, output_keys, pair_at
from .spatial.described import SPATIAL_FLAG

_POSITION = tuple(
    Field(str(k), "m", f"{axis} coordinate in the frame of the body", -math.inf) for k, axis in enumerate("xy")
)
_BODY = (
    Field("mass", "kg", "mass of the body", low_open=False),
    Field("inertia", "kg*m^2", "moment of inertia about the centre of mass", low_open=False),
)
_INITIAL = tuple(
    Field(name, unit, text, -math.inf, default=0.0)
    for name, unit, text in (
        ("x", "m", "x coordinate of the centre of mass in the fixed frame"),
        ("y", "m", "y coordinate of the centre of mass in the fixed frame"),
        ("angle", "rad", "angle of the body frame, counter-clockwise"),
        ("vx", "m/s", "x component of the velocity of the centre of mass"),
        ("vy", "m/s", "y component of the velocity of the centre of mass"),
        ("rate", "rad/s", "angular velocity of the body, counter-clockwise"),
    )
)
_GRAVITY = Field("gravity", "m/s^2", "acceleration of gravity, along -y", -math.inf, default=0.0, role=CONDITION)


def with_outline(outline: Outline) -> Mechanism:
    """Return the mechanism that a grid describes."""
    if outline.spatial:
        return topology_in_space.mechanism(outline, MECHANISM)
    bodies = tuple(body.name for body in outline.bodies)
    points = {body.name: body.points for body in outline.bodies}
    output = Output("output", "rad" if outline.rotary else "m")
    sections = described.keys_of(outline, points, tuple(joint.name for joint in outline.joints))
    return MECHANISM._replace(
        bodies=bodies,
        joints=tuple(map(_site, outline.joints)),
        keys=(*_keys(outline), *sections),
        channels=described.channels_of(bodies, output, ("place", "rate", "acceleration"), outline.elastic),
        output=output,
        free=outline.free,
    )


def _site(joint: JointOutline) -> JointSite:
    kind = {"prismatic": "guide", "slot": "slot", ANY: ANY}.get(joint.type, "revolute")
    return JointSite(joint.name, *joint.bodies, kind, joint.journal)


def _keys(outline: Outline) -> Iterable[Keys]:
    """Yield the sections of the bodies, the joints and the other parts of a mechanism."""
    pins = tuple(joint.name for joint in outline.joints if joint.type not in ("prismatic", "slot"))
    driven = Choice("driven", pins, "the revolute joint that the drive turns; it connects the ground and the crank")
    yield Keys("mechanism", "", (_GRAVITY,), words=(driven,), flags=(SPATIAL_FLAG,), role=CHOICE)
    yield Keys("mechanism.bodies", "the bodies by name, `ground` among them")
    for body in outline.bodies:
        path = f"mechanism.bodies.{body.name}"
        is_fixed = body.name == GROUND
        yield Keys(
            path, "the fixed body" if is_fixed else "a body of the mechanism", () if is_fixed else _BODY, role=CHOICE
        )
        if not is_fixed:
            center = tuple(field._replace(default=0.0) for field in _POSITION)
            yield Keys(f"{path}.center", "centre of mass in the frame of the body", center, "implied", role=CHOICE)
            text = (
                "initial state of a body that has no ideal joint. Without this section, the body starts as in the "
                "ideal mechanism"
            )
            yield Keys(f"{path}.initial", text, _INITIAL, "optional", role=CONDITION)
        yield Keys(f"{path}.points", "points of the body, by name", need="implied")
        if not is_fixed:
            yield from described.elastic_keys(path, body.points)
        for point in body.points:
            yield Keys(
                f"{path}.points.{point}", "position of the point in the frame of its body", _POSITION, role=CHOICE
            )
    yield Keys("mechanism.joints", "the joints between the bodies, by name")
    endpoints = tuple(f"{body.name}.{point}" for body in outline.bodies for point in body.points)
    for joint in outline.joints:
        yield from joint_keys(joint, endpoints)
    yield from output_keys(outline)


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
        bodies[body.name] = Body(mass, inertia, center, points, described.elastic_of(values, prefix), initial)
    joints = tuple(joint_of(values, joint) for joint in outline.joints)
    start = {key.removeprefix("start."): angle for key, angle in values.items() if key.startswith("start.")}
    aim = Aim(values["output.body"], values.get("output.point", ""), values.get("output.along", 0.0))
    loads = make_loads(case.loads, LoadPoints(bodies, {}))
    drive = make_drive(case.drive, outline)
    return Machine(bodies, joints, values["driven"], drive, values["gravity"], aim, start, loads)


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
