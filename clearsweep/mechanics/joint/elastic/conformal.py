"""Conformal contact: a journal that nearly fits its bearing."""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.family import kernel
from .contract import elastic_form


class Liu(NamedTuple):
    """F = K pen sqrt(pen / (2 (c + pen)))."""

    stiffness: float  # N/m
    clearance: float  # c, m


@elastic_form(Liu, odd=True)
def _liu(elastic, pen):
    return elastic.stiffness * pen * math.sqrt(0.5 * pen / (elastic.clearance + pen))


class LiuTangent(NamedTuple):
    """F = pen dF/dpen of Liu's force."""

    stiffness: float  # N/m
    clearance: float  # m


@elastic_form(LiuTangent, odd=True)
def _liu_tangent(elastic, pen):
    whole = elastic.clearance + pen
    share = (1.5 * elastic.clearance + pen) / whole
    return elastic.stiffness * pen * share * math.sqrt(0.5 * pen / whole)


class Foundation(NamedTuple):
    """F = K ((c + pen) theta - c sin theta), cos theta = c / (c + pen): a bed of radial springs (Winkler)."""

    stiffness: float  # N/m
    clearance: float  # c, m


@kernel
def arc_excess(angle):
    """Return angle - sin(angle) for an angle (rad) of at least 0, without cancellation where it is small."""
    if angle > 1.0:
        return angle - math.sin(angle)
    x = angle * angle
    series = 1.0 - x / 156.0 * (1.0 - x / 210.0)
    for terms in (110.0, 72.0, 42.0, 20.0):
        series = 1.0 - x / terms * series
    return angle * x / 6.0 * series


@elastic_form(Foundation, odd=True)
def _foundation(elastic, pen):
    angle = 2.0 * math.atan(math.sqrt(pen / (2.0 * elastic.clearance + pen)))
    return elastic.stiffness * (pen * angle + elastic.clearance * arc_excess(angle))


class Conformal(NamedTuple):
    """F = K b^2 (b^2 + 1) / (2 - ln(b^2 + 1) - 2 b^4), b = tan(theta / 2), cos theta = c / (c + pen) (Persson)."""

    stiffness: float  # N
    clearance: float  # c, m


#: Where the tangent of Persson's force over penetration is twice the secant, in clearances: a half-angle of 80.41
#: degrees.  The force grows without bound towards 84.83 degrees.
CONFORMAL_END = 5.004202079905


@kernel
def conformal_load(depth):
    """Return Persson's load in units of 2 pi E* clearance length, at a penetration of `depth` clearances."""
    b2 = depth / (2.0 + depth)
    return b2 * (b2 + 1.0) / (2.0 - math.log1p(b2) - 2.0 * b2 * b2)


@elastic_form(Conformal, odd=False)
def _conformal(elastic, pen):
    depth = pen / elastic.clearance
    if depth < CONFORMAL_END:
        return elastic.stiffness * conformal_load(depth)
    return elastic.stiffness * conformal_load(CONFORMAL_END) * (2.0 * depth / CONFORMAL_END - 1.0)
