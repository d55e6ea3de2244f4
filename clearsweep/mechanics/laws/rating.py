"""Rating life and passing frequencies of rolling bearings.

The life is the basic reference rating life of ISO/TS 16281:2008: the load of every element counts, so clearance does.
The inner ring turns relative to the load, and the outer ring is at rest.  The rating loads of the rings follow from the
basic dynamic load rating of the bearing (ISO 281:2007).
"""

from typing import NamedTuple

from ...contracts.case import Rolling


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
