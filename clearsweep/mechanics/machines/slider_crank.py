"""The slider-crank: crank, rod and slider, and clearance in any of its three revolute joints or in its guide."""

import math
from collections.abc import Mapping

from ...contracts.case import Case
from ...contracts.catalogue import (
    CHOICE,
    FULL_OUTLINE,
    Field,
    JointSite,
    Keys,
    Mechanism,
    Order,
    Outline,
    Output,
    ranged,
)
from ...contracts.machine import Aim, Body, BodyPoint, Guide, Machine, Pin
from . import described
from .described import vibration_keys
from .loads import LoadPoints
from .spatial import build as spatial

# ---------------------------------------------------------------------------------------------- in space


PINS = ("crank-rod", "rod-slider")


def _center() -> tuple[Field, ...]:
    along_rod, *other_axes = spatial.along_axes("m", "centre of mass from the first pin")
    return along_rod._replace(default=None, optional=True), *other_axes


def _keys(outline: Outline) -> tuple[Keys, ...]:
    mass = Field("mass", "kg", "mass of the body")
    center_text = (
        "position of the centre of mass relative to the first pin; a single quantity is a distance along the line of "
        "the pins; default: half the length"
    )
    inertia = spatial.along_axes("kg*m^2", "inertia", 0.0, None)
    return (
        Keys("mechanism.crank", "the crank", (_LENGTH, mass._replace(low_open=False)), role=CHOICE),
        Keys("mechanism.crank.inertia", spatial.INERTIA_TEXT, inertia, scalar_factors=(1, 1, 1), role=CHOICE),
        Keys("mechanism.crank.center", center_text, _center(), "implied", scalar_factors=(1, 0, 0), role=CHOICE),
        Keys("mechanism.rod", "the rod", (_LENGTH, mass), role=CHOICE),
        Keys(
            "mechanism.rod.inertia",
            spatial.INERTIA_TEXT,
            tuple(field._replace(low_open=True) for field in inertia),
            role=CHOICE,
        ),
        Keys("mechanism.rod.center", center_text, _center(), "implied", scalar_factors=(1, 0, 0), role=CHOICE),
        Keys("mechanism.slider", "the slider", (mass,), role=CHOICE),
        Keys("mechanism", "", flags=(spatial.SPATIAL_FLAG,)),
        spatial.gravity_keys(),
        spatial.freedom_keys(outline, PINS),
        spatial.speed_keys(),
        *vibration_keys(outline, _BODIES),
    )


def mechanism(outline: Outline, planar_mechanism: Mechanism) -> Mechanism:
    """Return the spatial form of the slider-crank `planar_mechanism`."""
    assert planar_mechanism.output is not None  # the slider
    return spatial.in_space(
        planar_mechanism,
        outline,
        _assembly,
        joints=(
            JointSite(PINS[0], "crank", "rod", spatial.site_kind_of(outline, PINS[0])),
            JointSite(PINS[1], "rod", "slider", spatial.site_kind_of(outline, PINS[1]), journal="rod"),
        ),
        keys=_keys(outline),
        channels=(
            *described.channels_of(("crank",), planar_mechanism.output, ("place", "v", "a"))[:5],
            *spatial.body_channels(("crank", "rod", "slider")),
        ),
        refusal=refusal,
    )


def _assembly(outline: Outline, values: Mapping, speed: float) -> spatial.Assembly:
    """Return the spatial machine of a case."""
    no_vector = (0.0, 0.0, 0.0)
    solids = {
        "ground": spatial.Solid(0.0, no_vector, no_vector, {"pivot": no_vector}),
        **{name: spatial.solid_of(values, name, _pins_of(values[f"{name}.length"], 3)) for name in ("crank", "rod")},
        "slider": spatial.Solid(values["slider.mass"], no_vector, no_vector, {"pin": no_vector}),
    }
    parts = solids, _joints("pivot"), "ground-crank", Aim("slider", "pin", 0.0), {}
    return spatial.assembly_of(values, speed, *parts)._replace(journals=dict.fromkeys(PINS, "rod"))


def _pins_of(length: float, dimensions: int) -> dict[str, tuple[float, ...]]:
    """Return the two pins of a link (m), in its frame."""
    return {"near": (0.0,) * dimensions, "far": (length,) + (0.0,) * (dimensions - 1)}


def _joints(line: str) -> tuple[Pin | Guide, ...]:
    """Return the joints; line : point of the ground on the line of the slider."""
    return (
        Pin("ground-crank", BodyPoint("ground", "pivot"), BodyPoint("crank", "near")),
        Pin("crank-rod", BodyPoint("crank", "far"), BodyPoint("rod", "near")),
        Pin("rod-slider", BodyPoint("rod", "far"), BodyPoint("slider", "pin")),
        Guide("slider-ground", BodyPoint("ground", line), BodyPoint("slider", "pin"), 0.0),
    )


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` at fault, and a sentence, if a case's rod is impossible or cannot tilt."""
    for name in PINS:
        if case.mechanism.values.get(f"ideal.{name}") == spatial.REVOLUTE:
            return "ideal", (
                f"{name} is a revolute joint, as ground-crank is; two revolute joints forbid the rod every tilt and "
                f"shift, so that it moves as in the plane; write ideal: {{{name}: spherical}} or cylindrical, or leave "
                "`spatial` out"
            )
    return spatial.refusal(mechanism, case)


# ---------------------------------------------------------------------------------------------- in the plane


_LENGTH = Field("length", "m", "distance between the two pins of the body")
_CENTER = ranged(
    "center",
    "m",
    "distance of the centre of mass from the pin nearer the drive; default: half the length",
    "(-inf, inf)",
    optional=True,
)
_CRANK = (
    _LENGTH,
    ranged("mass", "kg", "mass of the body", "[0, inf)"),
    ranged("inertia", "kg*m^2", "moment of inertia about the centre of mass", "[0, inf)"),
    _CENTER,
)
_ROD = (
    _LENGTH,
    Field("mass", "kg", "mass of the body"),
    Field("inertia", "kg*m^2", "moment of inertia about the centre of mass"),
    _CENTER,
)
_SLIDER = (
    Field("mass", "kg", "mass of the body"),
    ranged("offset", "m", "offset of the slider's line of motion along y; default: 0", "(-inf, inf)", optional=True),
    Field("inertia", "kg*m^2", "moment of inertia; required if slider-ground has clearance", optional=True),
)
_SITES = (
    JointSite("ground-crank", "ground", "crank"),
    JointSite("crank-rod", "crank", "rod"),
    JointSite("rod-slider", "rod", "slider", journal="rod"),
)
_GUIDE = JointSite("slider-ground", "ground", "slider", "guide")
_BODIES = ("ground", "crank", "rod", "slider")
_OUTPUT = Output("slider", "m")
_OUTPUT_CHANNELS = ("place", "v", "a")


def _planar_keys(outline: Outline) -> tuple[Keys, ...]:
    return (
        Keys("mechanism.crank", "the crank", _CRANK, role=CHOICE),
        *described.elastic_keys("mechanism.crank", outline),
        Keys("mechanism.rod", "the rod", _ROD, role=CHOICE),
        *described.elastic_keys("mechanism.rod", outline),
        Keys("mechanism.slider", "the slider", _SLIDER, role=CHOICE),
        described.gravity_section(outline),
        Keys("mechanism", "", flags=(spatial.SPATIAL_FLAG,), role=CHOICE),
    )


def with_outline(outline: Outline) -> Mechanism:
    """Return the slider-crank with the drive and the loads of a grid."""
    if outline.spatial:
        return mechanism(outline, MECHANISM)
    grounded = "ground-crank", "slider-ground"
    made = described.with_outline(MECHANISM, outline, _planar_keys(outline), grounded, _OUTPUT_CHANNELS)
    return made if outline.length == "revolutions" else made._replace(orders=())  # else it need not turn fully


def machine(case: Case) -> Machine:
    """Return the slider-crank of a case as a planar machine."""
    values = case.mechanism.values
    radius, length = values["crank.length"], values["rod.length"]
    offset, angle = values.get("slider.offset", 0.0), case.drive.start_angle
    bodies = {
        "ground": Body(0.0, 0.0, (0.0, 0.0), {"pivot": (0.0, 0.0), "line": (0.0, offset)}),
        "crank": _link(values, "crank", radius),
        "rod": _link(values, "rod", length),
        "slider": Body(values["slider.mass"], values.get("slider.inertia", 0.0), (0.0, 0.0), {"pin": (0.0, 0.0)}),
    }
    sine = (offset - radius * math.sin(angle)) / length
    start = {"rod": math.asin(min(max(sine, -1.0), 1.0))}
    points, aim = LoadPoints(bodies, {"slider": "pin"}), Aim("slider", "pin", 0.0)
    return described.machine_of(case, points, _joints("line"), "ground-crank", aim, start)


def _link(values, name: str, length: float) -> Body:
    center = (values[f"{name}.center"], 0.0)
    points = _pins_of(length, 2)
    elastic = described.elastic_of(values, name, points, ("near", "far"))
    return Body(values[f"{name}.mass"], values[f"{name}.inertia"], center, points, elastic)


MECHANISM = Mechanism(
    "slider-crank",
    "crank, rod and slider; clearance in any of its three revolute joints, or in its guide",
    "Newton-Euler; ideal: x = r cos(t) + sqrt(l^2 - r^2 sin^2(t))",
    "Newton-Euler of rigid bodies in a plane, see mechanics/machines/planar",
    "The rod is longer than the crank; the slider moves along the x axis, past the crank's pivot by its offset.",
    bodies=_BODIES,
    joints=(*_SITES, _GUIDE),
    keys=_planar_keys(FULL_OUTLINE),
    channels=described.channels_of(_BODIES, _OUTPUT, _OUTPUT_CHANNELS),
    turns=True,
    build=None,
    output=_OUTPUT,
    orders=(Order("mechanism.crank.length", "mechanism.rod.length", "the crank turns fully only with a longer rod"),),
    with_outline=with_outline,
    machine=machine,
    refusal=described.refusal,
)
