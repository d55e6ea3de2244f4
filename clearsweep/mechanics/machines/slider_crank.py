"""The slider-crank: crank, rod and slider, and clearance in any of its three revolute joints or in its guide."""

import math

from ...contracts.case import Case
from ...contracts.catalogue import CHOICE, CONDITION, Field, JointSite, Keys, Mechanism, Order, Outline, Output
from ...contracts.machine import Aim, Body, BodyPoint, Guide, Machine, Pin
from . import described, slider_crank_in_space
from .drives import make_drive
from .loads import LoadPoints, make_loads
from .spatial.described import SPATIAL_FLAG

_LENGTH = Field("length", "m", "distance between the two pins of the body")
_CENTER = Field(
    "center",
    "m",
    "distance of the centre of mass from the pin nearer the drive; default: half the length",
    -math.inf,
    optional=True,
)
_CRANK = (
    _LENGTH,
    Field("mass", "kg", "mass of the body", low_open=False),
    Field("inertia", "kg*m^2", "moment of inertia about the centre of mass", low_open=False),
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
    Field("offset", "m", "offset of the slider's line of motion along y; default: 0", -math.inf, optional=True),
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
_KEYS = (
    Keys("mechanism.crank", "the crank", _CRANK, role=CHOICE),
    *described.elastic_keys("mechanism.crank"),
    Keys("mechanism.rod", "the rod", _ROD, role=CHOICE),
    *described.elastic_keys("mechanism.rod"),
    Keys("mechanism.slider", "the slider", _SLIDER, role=CHOICE),
    Keys(
        "mechanism",
        "",
        (Field("gravity", "m/s^2", "acceleration of gravity, along -y", -math.inf, default=0.0, role=CONDITION),),
        flags=(SPATIAL_FLAG,),
        role=CHOICE,
    ),
)


def with_outline(outline: Outline) -> Mechanism:
    """Return the slider-crank with the drive and the loads of a grid."""
    if outline.spatial:
        return slider_crank_in_space.mechanism(outline, MECHANISM)
    joints = tuple(site.name for site in MECHANISM.joints)
    sections = described.keys_of(outline, dict.fromkeys(_BODIES, ()), joints)
    channels = described.channels_of(_BODIES, _OUTPUT, _OUTPUT_CHANNELS, outline.elastic)
    return MECHANISM._replace(keys=(*_KEYS, *sections), channels=channels, free=outline.free)


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
    joints = (
        Pin("ground-crank", BodyPoint("ground", "pivot"), BodyPoint("crank", "near")),
        Pin("crank-rod", BodyPoint("crank", "far"), BodyPoint("rod", "near")),
        Pin("rod-slider", BodyPoint("rod", "far"), BodyPoint("slider", "pin")),
        Guide("slider-ground", BodyPoint("ground", "line"), BodyPoint("slider", "pin"), 0.0),
    )
    sine = (offset - radius * math.sin(angle)) / length
    start = {"rod": math.asin(min(max(sine, -1.0), 1.0))}
    loads = make_loads(case.loads, LoadPoints(bodies, {"slider": "pin"}))
    drive, aim = make_drive(case.drive, case.outline), Aim("slider", "pin", 0.0)
    return Machine(bodies, joints, "ground-crank", drive, values["gravity"], aim, start, loads)


def _link(values, name: str, length: float) -> Body:
    center = (values[f"{name}.center"], 0.0)
    points = {"near": (0.0, 0.0), "far": (length, 0.0)}
    elastic = described.elastic_of(values, name, ("near", "far"))
    return Body(values[f"{name}.mass"], values[f"{name}.inertia"], center, points, elastic)


MECHANISM = Mechanism(
    "slider-crank",
    "crank, rod and slider; clearance in any of its three revolute joints, or in its guide",
    "Newton-Euler; ideal: x = r cos(t) + sqrt(l^2 - r^2 sin^2(t))",
    "Newton-Euler of rigid bodies in a plane, see mechanics/machines/planar",
    "The rod is longer than the crank; the slider moves along the x axis, past the crank's pivot by its offset.",
    bodies=_BODIES,
    joints=(*_SITES, _GUIDE),
    keys=_KEYS,
    channels=described.channels_of(_BODIES, _OUTPUT, _OUTPUT_CHANNELS),
    turns=True,
    build=None,
    output=_OUTPUT,
    orders=(Order("mechanism.crank.length", "mechanism.rod.length", "the crank turns fully only with a longer rod"),),
    with_outline=with_outline,
    machine=machine,
    refusal=described.refusal,
)
