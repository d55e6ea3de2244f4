"""Rolling bearings: elastic constants of their elements, rating life and passing frequencies.

The life is the basic reference rating life of ISO/TS 16281:2008: the load of every element counts, so clearance does.
The inner ring turns relative to the load, and the outer ring is at rest.  The rating loads of the rings follow from the
basic dynamic load rating of the bearing (ISO 281:2007).
"""

import math
from typing import NamedTuple

from ...contracts.case import Joint, Materials, Rolling
from .elastic import Power, PowerThreeHalves, plane_strain_modulus
from .loss import find_root

# ---------------------------------------------------------------------------------------------- elastic constants


ROLLER_STIFFNESS, ROLLER_LENGTH_EXPONENT, ROLLER_EXPONENT = 35948.0, 8.0 / 9.0, 10.0 / 9.0  # N and mm, ISO/TS 16281


def complete_elliptic(parameter: float) -> tuple[float, float]:
    """Return the complete elliptic integrals K and E of a parameter m = k^2 below 1.

    By the arithmetic-geometric mean (Abramowitz & Stegun 1964, 17.6.3 and 17.6.4).
    """
    a, b, c, total, weight = 1.0, math.sqrt(1.0 - parameter), math.sqrt(parameter), 0.5 * parameter, 0.5
    while abs(c) > 1e-9:  # the next one is its square, below rounding
        a, b, c, weight = 0.5 * (a + b), math.sqrt(a * b), 0.5 * (a - b), 2.0 * weight
        total += weight * c * c
    first = 0.5 * math.pi / a
    return first, first * (1.0 - total)


def point_stiffness(curvatures: tuple[float, float], modulus: float) -> float:
    """Return K (N/m^1.5) of Hertz's elliptical contact F = K pen^1.5 (Johnson 1985, Contact Mechanics, 4.26 to 4.32).

    curvatures : 1/m, sums of those of both bodies in the two principal planes, the larger first, above 0.
    modulus : E*, Pa.

    With A half the smaller sum, e^2 = 1 - k^2 and the axis ratio k, at which (E / k^2 - K) / (K - E) is the ratio of
    the curvatures, pen^3 = 9 F^2 K^3 e^2 A / (4 pi^2 E*^2 (K - E)).
    """
    if math.isclose(*curvatures, rel_tol=1e-9):
        return 4.0 / 3.0 * modulus / math.sqrt(0.5 * sum(curvatures))

    def residual(log_axis_ratio: float) -> float:
        square = math.exp(2.0 * log_axis_ratio)
        first, second = complete_elliptic(1.0 - square)
        return math.log((second / square - first) / (first - second)) - math.log(curvatures[0] / curvatures[1])

    square = math.exp(2.0 * find_root(residual, math.log(1e-7), -1e-7, 1e-16, 1e-15))
    first, second = complete_elliptic(1.0 - square)
    pen_cubed = 9.0 * first**3 * (1.0 - square) * 0.5 * curvatures[1] / (4.0 * math.pi**2 * (first - second))
    return modulus / math.sqrt(pen_cubed)


def ball_stiffness(diameter: float, pitch_diameter: float, groove: tuple[float, ...], modulus: float) -> float:
    """Return K (N/m^1.5) of a ball between both rings, whose contacts are in series: (K_i^-2/3 + K_e^-2/3)^-3/2.

    diameter, pitch_diameter : m.  groove : radii of the grooves of inner and outer ring over the ball's diameter.
    modulus : E*, Pa.
    """
    of_ball = 2.0 / diameter
    rings = 2.0 / (pitch_diameter - diameter), -2.0 / (pitch_diameter + diameter)
    compliance = 0.0
    for ring, radius in zip(rings, groove, strict=True):
        across = of_ball - 1.0 / (radius * diameter)
        sums = max(of_ball + ring, across), min(of_ball + ring, across)
        compliance += point_stiffness(sums, modulus) ** (-2.0 / 3.0)
    return float(compliance**-1.5)


def roller_stiffness(length: float) -> float:
    """Return K (N/m^(10/9)) of a steel roller of an effective length (m) between both rings (ISO/TS 16281:2008)."""
    return float(ROLLER_STIFFNESS * (1e3 * length) ** ROLLER_LENGTH_EXPONENT * 1e3**ROLLER_EXPONENT)


def elastic_of_elements(joint: Joint) -> PowerThreeHalves | Power:
    """Return the elastic law of an element of a joint that is a rolling bearing."""
    bearing = joint.rolling
    assert bearing is not None  # called only for rolling bearings
    if not bearing.has_balls:
        assert joint.length is not None  # the grid requires it
        return Power(roller_stiffness(joint.length), ROLLER_EXPONENT)
    modulus = plane_strain_modulus(Materials(bearing.material, bearing.material))
    sizes = bearing.element_diameter, bearing.pitch_diameter, bearing.groove
    return PowerThreeHalves(ball_stiffness(*sizes, modulus))


# ---------------------------------------------------------------------------------------------- rating life


class _Fatigue(NamedTuple):
    """Numbers of the life of one kind of contact."""

    slope: float  # Weibull's, of the lives of both rings: 10/9 of points, 9/8 of lines
    exponent: float  # of the load, that of the life of a ring times the slope: 10/3 and 9/2
    inner_mean: float  # exponent of the mean load of the ring that turns relative to the load: 3 and 4
    inner_share: float  # of the rating, divided by Z, in the rating load of the inner ring
    outer_share: float


_POINT = _Fatigue(10.0 / 9.0, 10.0 / 3.0, 3.0, 0.407, 0.389)
_LINE = _Fatigue(9.0 / 8.0, 9.0 / 2.0, 4.0, 0.83 * 0.378, 0.83 * 0.364)


class RingLoads(NamedTuple):
    """A number of each ring, such as its load (N)."""

    inner: float
    outer: float


def rating_loads(bearing: Rolling) -> RingLoads:
    """Return the dynamic load ratings (N) of an element at both rings.

    Raises ValueError without `capacity.dynamic`.
    """
    rating = bearing.capacity.dynamic
    if rating is None:
        raise ValueError("the rating life needs capacity.dynamic")
    fatigue = _fatigue_of(bearing)
    ratio = _ratio_of_rings(bearing)
    power = fatigue.exponent
    inner = rating / (fatigue.inner_share * bearing.elements) * (1.0 + ratio**power) ** (1.0 / power)
    outer = rating / (fatigue.outer_share * bearing.elements) * (1.0 + ratio**-power) ** (1.0 / power)
    return RingLoads(inner, outer)


def _fatigue_of(bearing: Rolling) -> _Fatigue:
    return _POINT if bearing.has_balls else _LINE


def _ratio_of_rings(bearing: Rolling) -> float:
    """Return the ratio of the ratings of the inner and the outer ring."""
    ratio = bearing.element_diameter / bearing.pitch_diameter
    shrinkage = (1.0 - ratio) / (1.0 + ratio)
    if not bearing.has_balls:
        return float(1.038 * shrinkage ** (143.0 / 108.0))
    inner, outer = bearing.groove
    conformity = inner / outer * (2.0 * outer - 1.0) / (2.0 * inner - 1.0)
    return float(1.044 * shrinkage**1.72 * conformity**0.41)


def load_powers(bearing: Rolling) -> RingLoads:
    """Return the powers to which the loads of elements count for the rings: 3 and 10/3 of balls, else 4 and 9/2."""
    fatigue = _fatigue_of(bearing)
    return RingLoads(fatigue.inner_mean, fatigue.exponent)


def equivalent_loads(bearing: Rolling, inner_mean: float, outer_mean: float) -> RingLoads:
    """Return the equivalent loads (N) of an element at both rings.

    inner_mean, outer_mean : means over elements and motion of the load (N) to the `load_powers`.
    """
    powers = load_powers(bearing)
    return RingLoads(inner_mean ** (1.0 / powers.inner), outer_mean ** (1.0 / powers.outer))


def rating_life(bearing: Rolling, loads: RingLoads) -> float:
    """Return the basic reference rating life (1e6 revolutions) under equivalent `loads`, of which one is above 0.

    Raises ValueError without `capacity.dynamic`.
    """
    fatigue, ratings = _fatigue_of(bearing), rating_loads(bearing)
    uses = (load / rating for load, rating in zip(loads, ratings, strict=True))
    return float(sum(use**fatigue.exponent for use in uses) ** (-1.0 / fatigue.slope))


class PassingRates(NamedTuple):
    """Rates in a bearing for one turn of its inner ring relative to the outer one, at a contact angle of 0."""

    cage: float  # turns of the cage relative to the outer ring
    element: float  # turns of an element about itself, relative to the cage
    inner: float  # elements that pass a point of the inner ring
    outer: float  # elements that pass a point of the outer ring


def passing_rates(bearing: Rolling) -> PassingRates:
    """Return the passing rates of a bearing in pure rolling (Harris & Kotzalas 2006, 5th ed., chapter 10)."""
    ratio = bearing.element_diameter / bearing.pitch_diameter
    return PassingRates(
        cage=0.5 * (1.0 - ratio),
        element=0.5 * (1.0 - ratio**2) / ratio,
        inner=0.5 * bearing.elements * (1.0 + ratio),
        outer=0.5 * bearing.elements * (1.0 - ratio),
    )
