"""The four-bar linkage: crank, coupler and rocker, and clearance in any of its four revolute joints."""

import math

from ...contracts.case import Case
from ...contracts.catalogue import (
    CHOICE,
    FULL_OUTLINE,
    Choice,
    Field,
    JointSite,
    Keys,
    Mechanism,
    Outline,
    Output,
    ranged,
)
from ...contracts.machine import Aim, Body, BodyPoint, Machine, Pin
from . import described
from .loads import LoadPoints

_LENGTH = Field("length", "m", "distance between the two pins of the body")
_LINK = (
    _LENGTH,
    ranged("mass", "kg", "mass of the body", "[0, inf)"),
    ranged("inertia", "kg*m^2", "moment of inertia about the centre of mass", "[0, inf)"),
    ranged(
        "center",
        "m",
        "distance from the first pin (of the rocker: its ground pivot) to the centre of mass; default: half the length",
        "(-inf, inf)",
        optional=True,
    ),
)
_SITES = (
    JointSite("ground-crank", "ground", "crank"),
    JointSite("crank-coupler", "crank", "coupler"),
    JointSite("coupler-rocker", "coupler", "rocker", journal="coupler"),
    JointSite("rocker-ground", "rocker", "ground", journal="rocker"),
)
_BODIES = ("ground", "crank", "coupler", "rocker")
_OUTPUT = Output("rocker", "rad")
_OUTPUT_CHANNELS = ("place", "speed", "acceleration")
_BRANCH = Choice(
    "branch",
    ("open", "crossed"),
    "side of the line from crank pin to rocker pivot on which the coupler's pin is; open: left, crossed: right",
    "open",
)


def _keys(outline: Outline) -> tuple[Keys, ...]:
    return (
        Keys(
            "mechanism.ground",
            "fixed link, with the crank's pivot at the origin and the rocker's pivot at (length, 0)",
            (_LENGTH,),
            role=CHOICE,
        ),
        *(
            section
            for body in _BODIES[1:]
            for section in (
                Keys(f"mechanism.{body}", f"the {body}", _LINK, role=CHOICE),
                *described.elastic_keys(f"mechanism.{body}", outline),
            )
        ),
        described.gravity_section(outline),
        Keys("mechanism", "", words=(_BRANCH,), role=CHOICE),
    )


def with_outline(outline: Outline) -> Mechanism:
    """Return the four-bar with the drive and the loads of a grid."""
    return described.with_outline(
        MECHANISM, outline, _keys(outline), (_SITES[0].name, _SITES[-1].name), _OUTPUT_CHANNELS
    )


def closed_angles(values, angle: float) -> tuple[float, float]:
    """Return the angles (rad) of coupler and rocker that close the linkage, or nearly close it, at a crank angle."""
    ground, crank, coupler, rocker = (values[f"{body}.length"] for body in _BODIES)
    x, y = ground - crank * math.cos(angle), -crank * math.sin(angle)  # from the crank pin to the rocker pivot
    span = math.hypot(x, y) or ground
    foot = (coupler**2 - rocker**2 + span**2) / (2.0 * span)
    pin_offset = math.sqrt(max(coupler**2 - foot**2, 0.0)) * (1.0 if values["branch"] == "open" else -1.0)
    # from the crank pin to the coupler's
    px = (foot * x - pin_offset * y) / span
    py = (foot * y + pin_offset * x) / span
    return math.atan2(py, px), math.atan2(py - y, px - x)


def machine(case: Case) -> Machine:
    """Return the four-bar of a case as a machine."""
    values = case.mechanism.values
    bodies = {"ground": Body(0.0, 0.0, (0.0, 0.0), {"first": (0.0, 0.0), "second": (values["ground.length"], 0.0)})}
    for name in _BODIES[1:]:
        length, mass, inertia, center = (values[f"{name}.{key}"] for key in ("length", "mass", "inertia", "center"))
        points = {"first": (0.0, 0.0), "second": (length, 0.0)}
        elastic = described.elastic_of(values, name, points, ("first", "second"))
        bodies[name] = Body(mass, inertia, (center, 0.0), points, elastic)
    pins = (
        Pin("ground-crank", BodyPoint("ground", "first"), BodyPoint("crank", "first")),
        Pin("crank-coupler", BodyPoint("crank", "second"), BodyPoint("coupler", "first")),
        Pin("coupler-rocker", BodyPoint("coupler", "second"), BodyPoint("rocker", "second")),
        Pin("rocker-ground", BodyPoint("rocker", "first"), BodyPoint("ground", "second")),
    )
    coupler, rocker = closed_angles(values, case.drive.start_angle)
    start = {"coupler": coupler, "rocker": rocker}
    return described.machine_of(case, LoadPoints(bodies, {}), pins, "ground-crank", Aim("rocker"), start)


MECHANISM = Mechanism(
    "four-bar",
    "crank, coupler and rocker; clearance in any of its four revolute joints",
    "Newton-Euler; ideal: the triangle of coupler, rocker and the line from crank pin to rocker pivot",
    "Newton-Euler of rigid bodies in a plane, see mechanics/machines/planar",
    "The crank turns fully where ground, crank, coupler and rocker let it (Grashof).",
    bodies=_BODIES,
    joints=_SITES,
    keys=_keys(FULL_OUTLINE),
    channels=described.channels_of(_BODIES, _OUTPUT, _OUTPUT_CHANNELS),
    turns=True,
    build=None,
    output=_OUTPUT,
    with_outline=with_outline,
    machine=machine,
    refusal=described.refusal,
)
