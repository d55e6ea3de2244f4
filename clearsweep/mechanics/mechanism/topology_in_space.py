"""The planar mechanism of any topology whose bodies move in space: what a grid may write of it, and what it gives."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from ...contracts.case import Case
from ...contracts.catalogue import Channel, Choice, Field, JointSite, Keys, Mechanism, Output
from ...contracts.machine import Aim, At, Body, Constant, Machine, Push
from ...contracts.outline import ANY, GROUND, JointOutline, Outline
from . import described, planar
from .contract import Built, IdealMotion
from .named import joint_keys, joint_of, output_keys, pair_of
from .spatial import BODY, FLAG
from .spatial.tree import UntiedError, build, hanging
from .spatial.tree.build import Assembly, Solid
from .spatial.tree.hanging import CYLINDRICAL, REVOLUTE, SPHERICAL

_AXES = ("x", "y", "z")
_CENTRE = "its centre of mass"  # a point of every body, beside those that the grid names


def _list(unit: str, text: str, low: float = -math.inf, default: float | None = 0.0) -> tuple[Field, ...]:
    """Return the items of a list along the axes of a frame."""
    return tuple(
        Field(str(k), unit, f"{text}, {axis}", low, low_open=low < 0.0, default=default) for k, axis in enumerate(_AXES)
    )


def _keys(outline: Outline) -> tuple[Keys, ...]:
    pins = tuple(joint.name for joint in outline.joints if joint.type != "prismatic")
    ends = tuple(f"{body.name}.{point}" for body in outline.bodies for point in body.points)
    allowed = tuple(
        Choice(name, (SPHERICAL, CYLINDRICAL, REVOLUTE), "of this pin, which has no clearance", REVOLUTE)
        for name in pins
        if name not in outline.clearances
    )
    driven = Choice("driven", pins, "the revolute joint that the drive turns, from the ground to the crank")
    found = [
        Keys("mechanism", "", words=(driven,), flags=(FLAG,)),
        Keys(
            "mechanism.gravity",
            "acceleration of gravity; one quantity: along -y",
            _list("m/s^2", "gravity"),
            "implied",
            alone=(0, -1, 0),
        ),
        Keys("mechanism.bodies", "the bodies by name, `ground` among them; their frames are as in the plane"),
    ]
    for body in outline.bodies:
        path, fixed = f"mechanism.bodies.{body.name}", body.name == GROUND
        mass = Field("mass", "kg", "mass")
        found.append(Keys(path, "what does not move" if fixed else "a body", () if fixed else (mass,)))
        if not fixed:
            about = "principal moments of inertia about the centre of mass, on the axes of its frame"
            found += [
                Keys(f"{path}.inertia", about, _list("kg*m^2", "inertia", 0.0, None)),
                Keys(
                    f"{path}.center",
                    "centre of mass; default: the frame's origin",
                    _list("m", "of its frame"),
                    "implied",
                ),
            ]
        found.append(Keys(f"{path}.points", "its points by name", need="implied"))
        found += [
            Keys(f"{path}.points.{point}", "a point; z along the pins", _list("m", "of the body's frame", default=None))
            for point in body.points
        ]
    found.append(Keys("mechanism.joints", "how the bodies hang together, by name"))
    for joint in outline.joints:
        found += joint_keys(joint, ends)
    text = "what a pin without clearance allows: a ball, turning and sliding along it, or turning alone"
    found.append(Keys("mechanism.ideal", text, words=allowed, need="implied"))
    found += output_keys(outline)
    found.append(Keys("drive", "the drive", (Field("speed", "rad/s", "constant crank speed"),), "implied"))
    return tuple(found)


def _site(outline: Outline, joint: JointOutline) -> JointSite:
    kind = "spatial" if {joint.name, ANY} & outline.axial else "through"
    return JointSite(joint.name, *joint.bodies, kind, joint.journal)


def mechanism(outline: Outline, plain: Mechanism) -> Mechanism:
    """Return the planar mechanism `plain`, as a grid describes it, as one whose bodies move in space."""
    output = Output("output", "rad" if outline.turning else "m")
    moving = [described.column_name(body.name) for body in outline.bodies if body.name != GROUND]
    heading = described.channels_of((), output, ("place", "rate", "acceleration"))
    torque = "crank/torque" if "crank" in moving else "drive/torque"
    return plain._replace(
        bodies=tuple(body.name for body in outline.bodies),
        joints=tuple(_site(outline, joint) for joint in outline.joints if joint.type != "prismatic"),
        keys=_keys(outline),
        channels=(
            *(channel._replace(name=torque) if "torque" in channel.name else channel for channel in heading),
            *(Channel(f"{body}/{name}", unit, text.format(body)) for body in moving for name, unit, text in BODY),
        ),
        output=output,
        build=_Building(outline),
        ideal=_Nominal(outline),
        machine=machine,
        refusal=refusal,
        spatial=True,
    )


# ---------------------------------------------------------------------------------------------- a case in these words


def machine(case: Case) -> Machine:
    """Return the planar machine of a case: what pictures and comparisons are with."""
    return _machine(case.outline, case.mechanism.values, case.drive.speed if case.drive else 0.0)


def _machine(outline: Outline, values: Mapping, speed: float) -> Machine:
    bodies, loads = {}, []
    for body in outline.bodies:
        at, fixed = f"bodies.{body.name}", body.name == GROUND
        mass, inertia = (0.0, 0.0) if fixed else (values[f"{at}.mass"], values[f"{at}.inertia.2"])
        center = (0.0, 0.0) if fixed else pair_of(values, f"{at}.center")
        points = {point: pair_of(values, f"{at}.points.{point}") for point in body.points}
        bodies[body.name] = Body(mass, inertia, center, points | {_CENTRE: center})
        if not fixed and values["gravity.0"] != 0.0:
            loads.append(Push(body.name, At(body.name, _CENTRE), mass * values["gravity.0"], 0.0, 0.0))
    joints = tuple(joint_of(values, joint) for joint in outline.joints)
    start = {key.removeprefix("start."): angle for key, angle in values.items() if key.startswith("start.")}
    aim = Aim(values["output.body"], values.get("output.point", ""), values.get("output.along", 0.0))
    return Machine(bodies, joints, values["driven"], Constant(speed), -values["gravity.1"], aim, start, tuple(loads))


def _assembly(outline: Outline, values: Mapping, speed: float) -> Assembly:
    """Return the machine of a case in space."""
    solids = {}
    for body in outline.bodies:
        at, fixed = f"bodies.{body.name}", body.name == GROUND
        points = {point: _three(values, f"{at}.points.{point}") for point in body.points}
        still = (0.0, 0.0, 0.0)
        solids[body.name] = (
            Solid(0.0, still, still, points)
            if fixed
            else Solid(values[f"{at}.mass"], _three(values, f"{at}.inertia"), _three(values, f"{at}.center"), points)
        )
    journals = {joint.name: joint.journal or joint.bodies[1] for joint in outline.joints}
    return Assembly(
        _machine(outline, values, speed), solids, _allowed(outline, values), _three(values, "gravity"), journals
    )


def _three(values: Mapping, path: str) -> tuple[float, ...]:
    return tuple(values[f"{path}.{k}"] for k in range(3))


def _allowed(outline: Outline, values: Mapping) -> dict[str, str]:
    """Return what the pins without clearance allow."""
    return {joint.name: values[f"ideal.{joint.name}"] for joint in outline.joints if f"ideal.{joint.name}" in values}


class _Building(NamedTuple):
    """Builds a case's machine, of whose grid the outline is."""

    outline: Outline

    def __call__(self, bodies: Mapping, drive: float, joints: Mapping, offsets: Mapping) -> Built:
        """Return the machine at crank angle 0; bodies : numbers and words by key; drive : rad/s; joints : compiled."""
        return build(_assembly(self.outline, bodies, drive), joints)


class _Nominal(NamedTuple):
    """The motion of the planar machine without clearance."""

    outline: Outline

    def __call__(self, bodies: Mapping, drive: float, angles) -> IdealMotion:
        """Return the motion of the output and the reactions at crank angles (rad)."""
        return planar.ideal(_machine(self.outline, bodies, drive), angles)


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` that is to blame, and a sentence, where a case's machine cannot be in space."""
    values, allowed = case.mechanism.values, _allowed(case.outline, case.mechanism.values)
    driven = values["driven"]
    if allowed.get(driven, REVOLUTE) != REVOLUTE:
        return f"ideal.{driven}", f"is {allowed[driven]}, but the drive turns a revolute joint; leave it out"
    for body in (body.name for body in case.outline.bodies if body.name != GROUND):
        moments = _three(values, f"bodies.{body}.inertia")
        largest, others = max(moments), sum(moments) - max(moments)
        if largest > others * (1.0 + 1e-12):
            return f"bodies.{body}.inertia", (
                f"found {', '.join(f'{moment:.6g}' for moment in moments)} kg*m^2; no body has a principal moment "
                f"({largest:.6g}) above the sum of the two others ({others:.6g}): correct the largest one"
            )
    unsound = described.refusal(mechanism, case)
    if unsound:
        return unsound
    try:
        hanging(machine(case), [joint.name for joint in case.joints], allowed)
    except UntiedError as error:
        return f"joints.{error.joint}", str(error)
    return None
