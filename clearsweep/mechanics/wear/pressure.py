"""Distribution of the load of a contact over its arc."""

import math
from typing import NamedTuple

import numpy as np

from ...contracts.case import Joint
from ...contracts.catalogue import Field, Law
from ...tracing import portable
from ...tracing.compiled.family import inlined
from ..laws.conformal import angle_minus_sine
from ..laws.contract import register
from ..laws.elastic import SMALL_ARC, plane_strain_modulus, relative_radius
from .contract import cumulative_pressure, half_arc, peak_over_mean, pressure_integral_over_load, smooth_range


class HertzLine(NamedTuple):
    """A Hertzian line contact of half-width a = sqrt(4 f R / (pi E*)); its half-angle is a over the body's radius."""

    width_factor: float  # m (N/m)^-0.5, half-width divided by the root of the line load: sqrt(4 R / (pi E*))


@half_arc.member(HertzLine)
def _half_arc_hertz_line(pressure, joint, radius, sliding):
    load = sliding.line_load * (joint.clearance / sliding.clearance)  # R varies as the inverse of the clearance
    return min(pressure.width_factor * math.sqrt(load) / radius, 0.5 * math.pi)


def _tail_fraction(edge_distance):
    """Return the load fraction beyond 1 - d, 0 < d <= 1, divided by d^(3/2), which is smooth; d : `edge_distance`."""
    x = 1.0 - edge_distance
    return (0.5 - (x * np.sqrt(1.0 - x * x) + portable.asin(x)) / math.pi) / portable.power(edge_distance, 1.5)


#: Its coefficients by powers of the edge distance, to 1e-9: avoids an arcsine in the most frequent evaluation.
TAIL_COEFFICIENTS = portable.polynomial_through(_tail_fraction, 9)


@cumulative_pressure.member(HertzLine)
def _cumulative_pressure_hertz_line(pressure, x, half_angle):
    edge_distance = max(1.0 - abs(x), 0.0)
    tail = 0.0
    for i in range(TAIL_COEFFICIENTS.size - 1, -1, -1):
        tail = tail * edge_distance + TAIL_COEFFICIENTS[i]
    return 0.5 + math.copysign(0.5 - tail * edge_distance * math.sqrt(edge_distance), x)


@smooth_range.member(HertzLine)
def _smooth_range_hertz_line(pressure):
    return 0.95  # at the ends it varies as the power 3/2


@pressure_integral_over_load.member(HertzLine)
def _pressure_integral_over_load_hertz_line(pressure, half_angle):
    return 1.0  # half-spaces: all pressure has the direction of the load


@peak_over_mean.member(HertzLine)
def _peak_over_mean_hertz_line(pressure, half_angle):
    return 4.0 / math.pi


#: Keys needed by pressures from elasticity.
MODULUS = Field(
    "pressure_modulus",
    "Pa",
    "contact modulus E* of both bodies, 1/E* = (1 - nu_b^2)/E_b + (1 - nu_j^2)/E_j; default: from `material`",
    optional=True,
)


def modulus_of(joint: Joint) -> float:
    """Return E* (Pa), which determines the pressure distribution in a joint."""
    assert joint.wear is not None  # called only for joints with wear
    return joint.wear.values.get("pressure_modulus") or plane_strain_modulus(joint.contact.material)


def _make_hertz_line(joint: Joint) -> HertzLine:
    return HertzLine(math.sqrt(4.0 * relative_radius(joint) / (math.pi * modulus_of(joint))))


register(
    Law(
        "pressure",
        "hertz-line",
        "Hertzian line contact",
        "half-width a = sqrt(4 f R / (pi E*)), f = F / length",
        "Johnson 1985, Contact Mechanics, section 4.2(c)",
        (MODULUS,),
        needs=("modulus",),
        trusted=(SMALL_ARC,),
        notes="The default where `material` or `pressure_modulus` is given.  The arc is a / R_b on the bearing and a "
        "/ R_j on the journal.",
    ),
    (HertzLine,),
    _make_hertz_line,
)


def _arctangent(square):
    """Return arctan(x) / x, from the square of x."""
    return portable.atan(np.sqrt(square)) / np.sqrt(square)


#: Its coefficients by powers of the square, 0 to 1, to 1e-11: a library function takes one number per call.
ARCTANGENT_COEFFICIENTS = portable.polynomial_through(_arctangent, 14)


class UniformPressure(NamedTuple):
    """Uniform over the arc in which rigid circles overlap: cos theta0 = c / (c + pen)."""


class Winkler(NamedTuple):
    """Proportional to the overlap of rigid circles, over the same arc: p varies as cos phi - cos theta0."""


@half_arc.member(UniformPressure)
@half_arc.member(Winkler)
def _half_arc_of_rigid_circles(pressure, joint, radius, sliding):
    pen = max(sliding.depth, 0.0)
    square = pen / (
        2.0 * sliding.clearance + pen
    )  # of the tangent of half of it: the arc's cosine, without cancellation
    total = 0.0
    for i in range(ARCTANGENT_COEFFICIENTS.size - 1, -1, -1):
        total = total * square + ARCTANGENT_COEFFICIENTS[i]
    return 2.0 * total * math.sqrt(square)


@cumulative_pressure.member(UniformPressure)
def _cumulative_pressure_uniform(pressure, x, half_angle):
    return min(max(0.5 + 0.5 * x, 0.0), 1.0)


@smooth_range.member(UniformPressure)
@smooth_range.member(Winkler)
def _smooth_range_uniform_or_winkler(pressure):
    return 1.0


@pressure_integral_over_load.member(UniformPressure)
def _pressure_integral_over_load_uniform(pressure, half_angle):
    """Return theta0 / sin(theta0), from the balance of forces, integral p cos(psi) R dpsi = f."""
    return half_angle / math.sin(half_angle) if half_angle > 1e-3 else 1.0 + half_angle * half_angle / 6.0


@peak_over_mean.member(UniformPressure)
def _peak_over_mean_uniform(pressure, half_angle):
    return 1.0


register(
    Law(
        "pressure",
        "mean",
        "uniform over the contact arc",
        "p = f / (2 R sin theta0), cos theta0 = c / (c + pen), f = F / length, R the radius of the body",
        "geometry of rigid circles; that the pressure is uniform over their arc is an assumption",
        notes="The default where neither `material` nor `pressure_modulus` is given.  Needs no modulus: the arc "
        "follows only from the penetration.",
    ),
    (UniformPressure,),
    lambda joint: UniformPressure(),
)


#: Of sin(x t) - x t cos(t) over t^3, by powers of t^2: (-1)^k (LINEAR_TERMS[k] x - CUBIC_TERMS[k] x^(2 k + 3)).
LINEAR_TERMS = np.array([(-1.0) ** k / math.factorial(2 * k + 2) for k in range(10)])
CUBIC_TERMS = np.array([(-1.0) ** k / math.factorial(2 * k + 3) for k in range(10)])


@inlined
def _overlap_integral(x, half_angle):
    """Return (sin(x t) - x t cos(t)) / t^3 for a half-angle t of at most pi / 2, by its series without cancellation."""
    square, linear_sum, cubic_sum = half_angle * half_angle, 0.0, 0.0
    power = square * x * x
    for k in range(LINEAR_TERMS.size - 1, -1, -1):
        linear_sum = linear_sum * square + LINEAR_TERMS[k]
        cubic_sum = cubic_sum * power + CUBIC_TERMS[k]
    return x * linear_sum - x * x * x * cubic_sum


@cumulative_pressure.member(Winkler)
def _cumulative_pressure_winkler(pressure, x, half_angle):
    x = min(max(x, -1.0), 1.0)
    return 0.5 + 0.5 * _overlap_integral(x, half_angle) / _overlap_integral(1.0, half_angle)


@pressure_integral_over_load.member(Winkler)
def _pressure_integral_over_load_winkler(pressure, half_angle):
    """Return 2 (sin t - t cos t) / (t - sin t cos t), from the balance of forces."""
    return (
        4.0
        * half_angle
        * half_angle
        * half_angle
        * _overlap_integral(1.0, half_angle)
        / angle_minus_sine(2.0 * half_angle)
        if half_angle > 1e-6
        else 1.0
    )


@peak_over_mean.member(Winkler)
def _peak_over_mean_winkler(pressure, half_angle):
    """Return (1 - cos t) t / (sin t - t cos t)."""
    sine = math.sin(0.5 * half_angle)
    return (
        2.0 * sine * sine / (half_angle * half_angle * _overlap_integral(1.0, half_angle)) if half_angle > 1e-6 else 1.5
    )


register(
    Law(
        "pressure",
        "winkler",
        "proportional to the overlap of the circles",
        "p = f (cos phi - cos theta0) / (R (theta0 - sin theta0 cos theta0)), cos theta0 = c / (c + pen), "
        "f = F / length, R the radius of the body",
        "elastic foundation: Johnson 1985, Contact Mechanics, section 4.3; the scale from the balance of forces",
        notes="Needs no modulus: a thin layer on a stiff backing, which deforms only under the pressure on it.  The "
        "arc is that of rigid circles.",
    ),
    (Winkler,),
    lambda joint: Winkler(),
)
