"""The planar mechanism of any topology: the bodies, points and joints that a grid names."""

import math
from collections.abc import Iterable

from ...case import Case
from ...catalogue import Choice, Field, JointSite, Keys, Mechanism, Output
from ...machine import Aim, At, Body, Guide, Machine, Pin
from ...outline import ANY, EVERYTHING, GROUND, JointOutline, Outline
from . import described
from .drives import drive_of
from .loads import Places, loads_of

_PLACE = tuple(Field(str(k), "m", f"{axis}, in the frame of the body", -math.inf) for k, axis in enumerate("xy"))
_BODY = (
    Field("mass", "kg", "mass", low_open=False),
    Field("inertia", "kg*m^2", "moment of inertia about the centre of mass", low_open=False),
)
_GRAVITY = Field("gravity", "m/s^2", "gravity, along -y", -math.inf, default=0.0)
_AXIS = Field(
    "axis", "rad", "of the line through the proximal point, in its body's frame; not of a pin", -math.inf, default=0.0
)
_ALONG = Field("along", "rad", "the direction in which the point is followed", -math.inf, default=0.0)


def outlined(outline: Outline) -> Mechanism:
    """Return the mechanism that a grid describes."""
    bodies = tuple(body.name for body in outline.bodies)
    points = {body.name: body.points for body in outline.bodies}
    output = Output("output", "rad" if outline.turning else "m")
    sections = described.keys_of(outline, points, tuple(joint.name for joint in outline.joints))
    return MECHANISM._replace(
        bodies=bodies,
        joints=tuple(map(_site, outline.joints)),
        keys=(*_keys(outline), *sections),
        channels=described.channels_of(bodies, output, ("place", "rate", "acceleration")),
        output=output,
        free=outline.free,
    )


def _site(joint: JointOutline) -> JointSite:
    kind = {"prismatic": "guide", ANY: ANY}.get(joint.type, "revolute")
    return JointSite(joint.name, *joint.bodies, kind, joint.journal)


def _keys(outline: Outline) -> Iterable[Keys]:
    """Yield the sections of the bodies, the joints and what else describes a mechanism."""
    moving = tuple(body.name for body in outline.bodies if body.name != GROUND)
    pins = tuple(joint.name for joint in outline.joints if joint.type != "prismatic")
    driven = Choice("driven", pins, "the revolute joint that the drive turns, from the ground to the crank")
    yield Keys("mechanism", "", (_GRAVITY,), words=(driven,))
    yield Keys("mechanism.bodies", "the bodies by name, `ground` among them")
    for body in outline.bodies:
        path = f"mechanism.bodies.{body.name}"
        fixed = body.name == GROUND
        yield Keys(path, "what does not move" if fixed else "a body", () if fixed else _BODY)
        if not fixed:
            center = tuple(field._replace(default=0.0) for field in _PLACE)
            yield Keys(f"{path}.center", "centre of mass; default: the frame's origin", center, "implied")
        yield Keys(f"{path}.points", "its points by name", need="implied")
        for point in body.points:
            yield Keys(f"{path}.points.{point}", "a point", _PLACE)
    yield Keys("mechanism.joints", "how the bodies hang together, by name")
    ends = tuple(f"{body.name}.{point}" for body in outline.bodies for point in body.points)
    for joint in outline.joints:
        yield from _joint_keys(joint, ends)
    start = tuple(
        Field(body, "rad", "angle near which its loops are closed at the start; default 0", -math.inf, optional=True)
        for body in moving
    )
    yield Keys(
        "mechanism.start", "angles of bodies at the start, where there are two ways to close a loop", start, "implied"
    )
    body = Choice("body", moving, "the body by whose motion the mechanism is judged")
    every = tuple(dict.fromkeys(point for body in outline.bodies for point in body.points))
    point = Choice("point", every, "its point; left out: its angle")
    followed = not outline.turning
    yield Keys(
        "mechanism.output", "the output", (_ALONG,) if followed else (), words=(body, point) if followed else (body,)
    )


def _joint_keys(joint: JointOutline, ends: tuple[str, ...]) -> Iterable[Keys]:
    """Yield the sections of a joint, `ends` being the points that it can join."""
    path = f"mechanism.joints.{joint.name}"
    kind = Choice("type", ("revolute", "prismatic"), "a pin or a guide")
    bodies = tuple(filter(None, joint.bodies))
    journal = (Choice("journal", bodies, "the body that its journal sits on", bodies[-1] if bodies else ANY),)
    words = (kind,) if joint.type == "prismatic" else (kind, *journal)
    yield Keys(path, "a joint", () if joint.type == "revolute" else (_AXIS,), words=words)
    texts = ("the proximal point, body.point", "the distal point")
    between = tuple(Choice(str(k), ends, text) for k, text in enumerate(texts))
    yield Keys(f"{path}.between", "the points that it joins, proximal and distal", words=between)


def machine(case: Case) -> Machine:
    """Return the mechanism of a case as a machine."""
    values, outline = case.mechanism.values, case.outline
    bodies = {}
    for body in outline.bodies:
        at, fixed = f"bodies.{body.name}", body.name == GROUND
        mass, inertia = (0.0, 0.0) if fixed else (values[f"{at}.mass"], values[f"{at}.inertia"])
        center = (0.0, 0.0) if fixed else _pair(values, f"{at}.center")
        points = {point: _pair(values, f"{at}.points.{point}") for point in body.points}
        bodies[body.name] = Body(mass, inertia, center, points)
    joints = tuple(_joint(values, joint) for joint in outline.joints)
    start = {key.removeprefix("start."): angle for key, angle in values.items() if key.startswith("start.")}
    aim = Aim(values["output.body"], values.get("output.point", ""), values.get("output.along", 0.0))
    loads = loads_of(case.loads, Places(bodies, {}))
    drive = drive_of(case.drive, outline)
    return Machine(bodies, joints, values["driven"], drive, values["gravity"], aim, start, loads)


def _pair(values, path: str) -> tuple[float, float]:
    return values[f"{path}.0"], values[f"{path}.1"]


def _joint(values, joint: JointOutline) -> Pin | Guide:
    ends = [At(*end.split(".", 1)) for end in (joint.proximal, joint.distal)]
    if joint.type == "revolute":
        return Pin(joint.name, *ends)
    return Guide(joint.name, *ends, values[f"joints.{joint.name}.axis"])


MECHANISM = Mechanism(
    "planar",
    "any mechanism of rigid bodies in a plane with revolute and prismatic joints, each of which may have clearance",
    "Newton-Euler; the ideal joints are eliminated, their loops closed to rounding",
    "Newton-Euler of rigid bodies in a plane, see mechanics/mechanism/planar",
    "Bodies, points and joints have the names that the grid gives them.",
    bodies=(GROUND,),
    joints=(),
    keys=tuple(_keys(EVERYTHING)),
    channels=(),
    turns=True,
    build=None,
    output=Output("output", "m"),
    outlined=outlined,
    machine=machine,
    refusal=described.refusal,
)
