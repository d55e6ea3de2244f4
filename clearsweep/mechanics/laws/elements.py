"""Elastic laws of the elements of rolling bearings, each between both rings."""

import math

from ...contracts.case import Joint, Materials
from .elastic import Power, PowerThreeHalves, plane_strain_modulus
from .loss import find_root

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
