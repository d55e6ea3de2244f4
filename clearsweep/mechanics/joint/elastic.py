"""Elastic part of the normal force over penetration: powers, and the laws of cylinders that nearly fit each other.

A law that folds back, or grows without bound, at some penetration is followed up to where its tangent stiffness is
twice the secant one, and along that tangent from there on: the force always grows, and never ends.
"""

from typing import NamedTuple

from ..compiled import calculus as math
from ..compiled.family import family, kernel


@family
def elastic_force(elastic, pen):
    """Return the elastic force (N) at penetration `pen` (m, at least 0)."""


@family
def parity(elastic):
    """Return -1 where the force is, at small penetration, an odd power of the root of the penetration; else 1."""


class Power(NamedTuple):
    """F = K pen^n."""

    stiffness: float  # N m^-n
    exponent: float  # 1


class PowerThreeHalves(NamedTuple):
    """F = K pen^(3/2), Hertz's exponent: a square root in place of a general power."""

    stiffness: float  # N m^-1.5


class Linear(NamedTuple):
    """F = K pen."""

    stiffness: float  # N/m


@elastic_force.member(Power)
def _power(elastic, pen):
    return elastic.stiffness * pen**elastic.exponent


@elastic_force.member(PowerThreeHalves)
def _power_three_halves(elastic, pen):
    return elastic.stiffness * pen * math.sqrt(pen)


@elastic_force.member(Linear)
def _linear(elastic, pen):
    return elastic.stiffness * pen


# ---------------------------------------------------------------------------------------------- line contact

#: Where the tangent of pen = g F ln(S / F) is twice the secant, in units of g S.  It folds back at exp(-1).
LOGARITHMIC_END = 2.0 * math.exp(-2.0)


class Logarithmic(NamedTuple):
    """pen = g F ln(S / F), the approach of two cylinders: the laws of this form differ only in their g and S."""

    stiffness: float  # 1 / g, N/m
    depth: float  # g S, m; the law folds back at exp(-1) of it


@kernel
def inverse_lambert(w):
    """Return 1 / v, v = -W(-w) of the lower branch of Lambert's function, the root v >= 2 of v exp(-v) = w.

    `w` : above 0, at most LOGARITHMIC_END.  Relative error below 1e-15: a fraction in the distance from the
    branch point good to 4e-4, then one step of fourth order (Fritsch, Shafer & Crowley 1973, Commun. ACM 16:123).
    """
    q = -math.log(w)  # v - ln v = q
    r = math.sqrt(q - 1.0)
    v = 1.0 + r * (1.41612896 + r * (1.02969292 + r * 0.26107797)) / (1.0 + 0.26129776 * r)
    z = v - q - math.log(v)
    base = 1.0 - v
    second = 2.0 * base * (base + 2.0 / 3.0 * z)
    below = base * (second - 2.0 * z)  # v (1 + z (second - z) / below) is the root; inverted, it takes one division
    return below / (v * (below + z * (second - z)))


@elastic_force.member(Logarithmic)
def _logarithmic(elastic, pen):
    if pen <= 0.0:
        return 0.0
    w = pen / elastic.depth
    if w < LOGARITHMIC_END:
        return elastic.stiffness * pen * inverse_lambert(w)
    return elastic.stiffness * elastic.depth * (w - 0.5 * LOGARITHMIC_END)


# ---------------------------------------------------------------------------------------------- conformal contact


class Liu(NamedTuple):
    """F = K pen sqrt(pen / (2 (c + pen)))."""

    stiffness: float  # N/m
    clearance: float  # c, m


class LiuTangent(NamedTuple):
    """F = pen dF/dpen of Liu's force."""

    stiffness: float  # N/m
    clearance: float  # m


class Foundation(NamedTuple):
    """F = K ((c + pen) theta - c sin theta), cos theta = c / (c + pen): a bed of radial springs (Winkler)."""

    stiffness: float  # N/m
    clearance: float  # c, m


class Conformal(NamedTuple):
    """F = K b^2 (b^2 + 1) / (2 - ln(b^2 + 1) - 2 b^4), b = tan(theta / 2), cos theta = c / (c + pen) (Persson)."""

    stiffness: float  # N
    clearance: float  # c, m


@elastic_force.member(Liu)
def _liu(elastic, pen):
    return elastic.stiffness * pen * math.sqrt(0.5 * pen / (elastic.clearance + pen))


@elastic_force.member(LiuTangent)
def _liu_tangent(elastic, pen):
    whole = elastic.clearance + pen
    share = (1.5 * elastic.clearance + pen) / whole
    return elastic.stiffness * pen * share * math.sqrt(0.5 * pen / whole)


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


@elastic_force.member(Foundation)
def _foundation(elastic, pen):
    angle = 2.0 * math.atan(math.sqrt(pen / (2.0 * elastic.clearance + pen)))
    return elastic.stiffness * (pen * angle + elastic.clearance * arc_excess(angle))


#: Where the tangent of Persson's force over penetration is twice the secant, in clearances: a half-angle of 80.41
#: degrees.  The force grows without bound towards 84.83 degrees.
CONFORMAL_END = 5.004202079905


@kernel
def conformal_load(depth):
    """Return Persson's load in units of 2 pi E* clearance length, at a penetration of `depth` clearances."""
    b2 = depth / (2.0 + depth)
    return b2 * (b2 + 1.0) / (2.0 - math.log1p(b2) - 2.0 * b2 * b2)


@elastic_force.member(Conformal)
def _conformal(elastic, pen):
    depth = pen / elastic.clearance
    if depth < CONFORMAL_END:
        return elastic.stiffness * conformal_load(depth)
    return elastic.stiffness * conformal_load(CONFORMAL_END) * (2.0 * depth / CONFORMAL_END - 1.0)


def _odd(elastic):
    return -1.0


def _even(elastic):
    return 1.0


for _elastic in elastic_force.members:
    _is_odd = _elastic in (PowerThreeHalves, Liu, LiuTangent, Foundation)
    parity.member(_elastic)(_odd if _is_odd else _even)
