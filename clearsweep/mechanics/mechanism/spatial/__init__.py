"""The slider-crank whose rod moves in space: what a grid may write of it, and what it gives."""

import math

from ....contracts.case import Case
from ....contracts.catalogue import Channel, Choice, Field, JointSite, Keys, Mechanism, Output
from ....contracts.outline import ANY, Outline
from .build import PINS, build
from .ideal import ideal

__all__ = ["BODY", "FLAG", "mechanism"]

#: The key of a slider-crank that has it move in space.
FLAG = ("spatial", "the rod moves in space, between spatial joints")
SPHERICAL, CYLINDRICAL, REVOLUTE = "spherical", "cylindrical", "revolute"
_AXES = ("x", "y", "z")
_LENGTH = Field("length", "m", "distance between its pins")
_OUTPUT = Output("slider", "m")
_IDEAL = "what a joint without clearance allows: a ball, turning and sliding along its pin, or turning alone"
#: The time histories of every moving body.
BODY = (
    *((axis, "m", f"{{}}'s centre of mass, {axis}") for axis in _AXES),
    *((f"v{axis}", "m/s", f"velocity of the {{}}'s centre of mass, {axis}") for axis in _AXES),
    *((f"q{k}", "1", f"quaternion from the {{}}'s frame to the fixed one, {k}") for k in "wxyz"),
    *((f"w{axis}", "rad/s", f"angular velocity of the {{}} in the fixed frame, {axis}") for axis in _AXES),
)


def _list(name: str, unit: str, low: float = -math.inf, default: float | None = 0.0) -> tuple[Field, ...]:
    """Return the items of a list along the axes of a frame."""
    return tuple(
        Field(str(k), unit, f"{name}, {axis}", low, low_open=low < 0.0, default=default) for k, axis in enumerate(_AXES)
    )


def _center() -> tuple[Field, ...]:
    first, *rest = _list("centre of mass from the first pin", "m")
    return first._replace(default=None, optional=True), *rest


def _keys(outline: Outline) -> tuple[Keys, ...]:
    mass = Field("mass", "kg", "mass")
    about = "principal moments of inertia about the centre of mass, on the axes of its frame"
    closed = tuple(
        Choice(name, (SPHERICAL, CYLINDRICAL, REVOLUTE), "of this joint, which has no clearance", REVOLUTE)
        for name in PINS
        if name not in outline.clearances
    )
    where = "centre of mass; one quantity: along the line of the pins; default: half the length"
    return (
        Keys("mechanism.crank", "the crank", (_LENGTH, mass._replace(low_open=False))),
        Keys("mechanism.crank.inertia", about, _list("inertia", "kg*m^2", 0.0, None), alone=(1, 1, 1)),
        Keys("mechanism.crank.center", where, _center(), "implied", alone=(1, 0, 0)),
        Keys("mechanism.rod", "the rod", (_LENGTH, mass)),
        Keys(
            "mechanism.rod.inertia",
            about,
            tuple(f._replace(low_open=True) for f in _list("inertia", "kg*m^2", 0.0, None)),
        ),
        Keys("mechanism.rod.center", where, _center(), "implied", alone=(1, 0, 0)),
        Keys("mechanism.slider", "the slider", (mass,)),
        Keys("mechanism", "", flags=(FLAG,)),
        Keys(
            "mechanism.gravity",
            "acceleration of gravity; one quantity: along -y",
            _list("gravity", "m/s^2"),
            "implied",
            alone=(0, -1, 0),
        ),
        Keys("mechanism.ideal", _IDEAL, words=closed, need="implied"),
        Keys("drive", "the drive", (Field("speed", "rad/s", "constant crank speed"),), "implied"),
    )


def mechanism(outline: Outline, plain: Mechanism) -> Mechanism:
    """Return the slider-crank `plain` as one that moves in space."""
    bodies = ("crank", "rod", "slider")
    every = (Channel(f"{body}/{name}", unit, text.format(body)) for body in bodies for name, unit, text in BODY)
    kinds = ["spatial" if {name, ANY} & outline.axial else "through" for name in PINS]
    return plain._replace(
        joints=(
            JointSite(PINS[0], "crank", "rod", kinds[0]),
            JointSite(PINS[1], "rod", "slider", kinds[1], journal="rod"),
        ),
        keys=_keys(outline),
        channels=(
            Channel("crank_angle", "rad", "crank angle, unwrapped"),
            Channel("crank/torque", "N*m", "drive torque on the crank"),
            Channel("slider/x", "m", "position of the slider"),
            Channel("slider/v", "m/s", "velocity of the slider"),
            Channel("slider/a", "m/s^2", "acceleration of the slider"),
            *(channel for channel in every if channel.name != "slider/x"),
        ),
        build=build,
        ideal=ideal,
        machine=None,
        refusal=refusal,
        spatial=True,
    )


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` that is to blame, and a sentence, where a case's rod could not tilt or be."""
    values = case.mechanism.values
    for name in PINS:
        if values.get(f"ideal.{name}") == REVOLUTE:
            return "ideal", (
                f"{name} is a revolute joint, as ground-crank is: two revolute joints forbid the rod every tilt and "
                f"shift, so that it moves as in the plane; write ideal: {{{name}: spherical}} or cylindrical, or leave "
                "`spatial` out"
            )
    for body in ("crank", "rod"):
        moments = [values[f"{body}.inertia.{k}"] for k in range(3)]
        largest, others = max(moments), sum(moments) - max(moments)
        if largest > others * (1.0 + 1e-12):
            return f"{body}.inertia", (
                f"found {', '.join(f'{moment:.6g}' for moment in moments)} kg*m^2; no body has a principal moment "
                f"({largest:.6g}) above the sum of the two others ({others:.6g}): correct the largest one"
            )
    return None
