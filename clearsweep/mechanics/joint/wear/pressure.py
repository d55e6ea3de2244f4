"""How the load of a contact is spread over its arc."""

import math
from typing import NamedTuple

from ....case import Joint
from ....catalogue import Law
from ..material import plane_strain_modulus, relative_radius
from ..recipe import enter
from .contract import half_arc, share_before


class HertzLine(NamedTuple):
    """A Hertzian line contact: half-width a = sqrt(4 f R / (pi E*))."""

    modulus: float  # Pa, E* of both bodies
    radius: float  # m, R_b R_j / (R_b - R_j)


@half_arc.member(HertzLine)
def _hertzian_arc(pressure, joint, line_load, depth):
    half_width = math.sqrt(4.0 * line_load * pressure.radius / (math.pi * pressure.modulus))
    return min(half_width / joint.bearing_radius, 0.5 * math.pi)


@share_before.member(HertzLine)
def _elliptic(pressure, x):
    if x <= -1.0:
        return 0.0
    if x >= 1.0:
        return 1.0
    return 0.5 + (x * math.sqrt(1.0 - x * x) + math.asin(x)) / math.pi


def _make_hertz_line(joint: Joint) -> HertzLine:
    contact, radius = joint.contact, relative_radius(joint)
    if contact.material:
        return HertzLine(plane_strain_modulus(contact.material), radius)
    return HertzLine(3.0 * contact.values["stiffness"] / (4.0 * math.sqrt(radius)), radius)


enter(
    Law(
        "pressure",
        "hertz-line",
        "Hertzian line contact",
        "half-width a = sqrt(4 f R / (pi E*)), f = F / length",
        "Johnson 1985, Contact Mechanics, section 4.2(c)",
        needs=("modulus",),
        notes="E* from `material`; without it from the stiffness of the power law, E* = 3 K / (4 sqrt(R)).",
    ),
    (HertzLine,),
    _make_hertz_line,
)


class Mean(NamedTuple):
    """Uniform over the arc in which rigid circles overlap: cos theta0 = c / (c + pen)."""


@half_arc.member(Mean)
def _geometric_arc(pressure, joint, line_load, depth):
    pen = max(depth, 0.0)
    return 2.0 * math.atan(math.sqrt(pen / (2.0 * joint.clearance + pen)))  # the arc's cosine, without cancellation


@share_before.member(Mean)
def _even(pressure, x):
    return min(max(0.5 + 0.5 * x, 0.0), 1.0)


enter(
    Law(
        "pressure",
        "mean",
        "even over the contact arc",
        "p = f / (2 R theta0), cos theta0 = c / (c + pen), f = F / length, R the radius of the body",
        "geometry of rigid circles; that the pressure is even over their arc is an assumption",
        notes="Needs no modulus.  The arc follows from the penetration alone.",
    ),
    (Mean,),
    lambda joint: Mean(),
)
