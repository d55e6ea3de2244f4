"""Films of an infinitely long bearing, with circumferential flow only."""

from math import inf
from typing import NamedTuple

from ....contracts.catalogue import Law, Range
from ....tracing.compiled import calculus as math
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import kernel
from ...joints.recipe import register
from .contract import arc_from, film_force, film_pressure, maximum_over_arc
from .corners import has_reversal_corners

LONG_BEARING = Range(
    "length / diameter", 4.0, inf, "1", "it assumes flow around the pin only; a shorter bearing carries less"
)


class Long(NamedTuple):
    """Sommerfeld's pressure over the half circle with zero pressure at both ends."""

    force: float  # mu L R^3 / c^2, N s
    pressure: float  # 6 mu R^2 / c^2, Pa s


@film_force.member(Long)
def _film_force_long(law, motion):
    ratio, squeeze_rate, two_plus_square = motion.ratio, motion.squeeze_rate, 2.0 + motion.ratio * motion.ratio
    squeeze, wedge = squeeze_rate * two_plus_square, motion.spin * ratio
    if squeeze == 0.0 and wedge == 0.0:
        zero = as_type_of(0.0, squeeze * wedge)
        return zero, zero
    arc = arc_from(ratio, squeeze, wedge)
    c, s, d, one_minus_square, inverse_thickness = (
        arc.cosine,
        arc.sine,
        arc.end_product,
        arc.one_minus_square,
        arc.inverse_thickness,
    )
    start_thickness, ratio_cosine_square = 1.0 + ratio * c, ratio * c * c
    wedge_factor, end_term = (
        6.0 * law.force * wedge / two_plus_square,
        (2.0 + ratio * c) / (start_thickness * start_thickness),
    )
    # the pressure of the wedge, 0 at the beginning, plus that of the squeeze
    radial = wedge_factor * (2.0 * s * s * end_term - 2.0 * ratio_cosine_square * c / d)
    tangential = wedge_factor * (inverse_thickness - 2.0 * s * ratio_cosine_square / d - 2.0 * s * c * end_term)
    cosine_terms = 2.0 * c + ratio * (1.0 + 2.0 * c * c) - ratio * ratio * ratio_cosine_square
    radial -= (
        6.0
        * law.force
        * squeeze_rate
        * (inverse_thickness + 2.0 * s * cosine_terms / (start_thickness * start_thickness * d))
        / one_minus_square
    )
    tangential += 24.0 * law.force * squeeze_rate * c * c / (d * start_thickness)
    return radial, tangential


@kernel
def _pressure(law, motion, cosine, sine):
    ratio, two_plus_square = motion.ratio, 2.0 + motion.ratio * motion.ratio
    squeeze, wedge = motion.squeeze_rate * two_plus_square, motion.spin * ratio
    norm = math.sqrt(squeeze * squeeze + wedge * wedge)
    if norm == 0.0:
        return 0.0
    s, c = squeeze / norm, wedge / norm
    start_thickness, thickness = 1.0 + ratio * c, 1.0 + ratio * cosine
    wedge_term = sine * (1.0 + thickness) / (thickness * thickness) - s * (1.0 + start_thickness) / (
        start_thickness * start_thickness
    )
    squeeze_term = (c - cosine) * (start_thickness + thickness) / (start_thickness * thickness) ** 2
    return law.pressure * (wedge / two_plus_square * wedge_term + motion.squeeze_rate * squeeze_term)


@film_pressure.member(Long)
def _film_pressure_long(law, motion):
    two_plus_square = 2.0 + motion.ratio * motion.ratio
    return maximum_over_arc(
        law, motion, _pressure, math.atan2(motion.squeeze_rate * two_plus_square, motion.spin * motion.ratio)
    )


def _force_and_pressure_factors(joint):
    viscosity, length, radius = joint.film.viscosity, joint.length, joint.bearing_radius
    clearance_squared = joint.clearance * joint.clearance
    return viscosity * length * radius**3 / clearance_squared, 6.0 * viscosity * radius**2 / clearance_squared


register(
    Law(
        "film",
        "long",
        "a long bearing: the oil flows around the pin",
        "p = (6 mu R^2 / c^2) (w eps sin(theta) (2 + eps cos(theta)) / ((2 + eps^2) H^2) + eps' / (eps H^2) + p_0), "
        "H = 1 + eps cos(theta), over the half circle from tan(theta_1) = eps' (2 + eps^2) / (w eps) at whose ends it "
        "is 0; w = w_j + w_b - 2 gamma'; force in closed form",
        "Sommerfeld 1904's pressure over half the circumference, as in Pinkus & Sternlicht 1961; integrated "
        "independently",
        needs=("length",),
        trusted=(LONG_BEARING,),
        notes="Pressure counts only over the half circle; near its ends it can be negative while the film opens.",
    ),
    (Long,),
    lambda joint: Long(*_force_and_pressure_factors(joint)),
)


class PinkusSternlicht(NamedTuple):
    """The long bearing's half film in Pinkus and Sternlicht's approximation."""

    force: float  # mu L R^3 / c^2, N s


has_reversal_corners.member(PinkusSternlicht)(None)


@film_force.member(PinkusSternlicht)
def _film_force_pinkus_sternlicht(law, motion):
    ratio, squeeze_rate, entrainment = motion.ratio, motion.squeeze_rate, motion.spin
    ratio_squared = ratio * ratio
    one_minus_square, two_plus_square, squeeze_speed = 1.0 - ratio_squared, 2.0 + ratio_squared, abs(squeeze_rate)
    half_wedge = 0.5 * entrainment * ratio
    scaled_k = math.sqrt(one_minus_square * (half_wedge * half_wedge + squeeze_rate * squeeze_rate))  # eps |eps'| k
    denominator = scaled_k + 1.5 * ratio * squeeze_speed
    if denominator == 0.0:
        zero = as_type_of(0.0, denominator)
        return zero, zero
    q = (scaled_k + 3.0 * ratio * squeeze_speed if squeeze_rate > 0.0 else scaled_k) / denominator
    sign = 1.0 if squeeze_rate > 0.0 else -1.0
    radial = -6.0 * law.force / (two_plus_square * one_minus_square * math.sqrt(one_minus_square))
    radial *= 4.0 * scaled_k * ratio + sign * squeeze_speed * two_plus_square * math.pi * q
    tangential = 6.0 * math.pi * law.force * ratio * entrainment / (two_plus_square * math.sqrt(one_minus_square)) * q
    return radial, tangential


register(
    Law(
        "film",
        "pinkus-sternlicht",
        "a long bearing, in the form used in multibody dynamics",
        "F_r = -6 mu L R^3 / c^2 |eps'| (4 k eps^2 +- (2 + eps^2) pi q) / ((2 + eps^2) (1 - eps^2)^(3/2)), F_t = 6 pi "
        "mu L R^3 / c^2 eps w q / ((2 + eps^2) (1 - eps^2)^(1/2)), k^2 = (1 - eps^2) (w^2 / (4 eps'^2) + 1 / eps^2), q "
        "= (k + 3) / (k + 3/2) and + for eps' > 0, q = k / (k + 3/2) and - for eps' < 0; w = w_j + w_b - 2 gamma'",
        "after Pinkus & Sternlicht 1961, Theory of Hydrodynamic Lubrication, as reported by Ravn 1998 and Flores, "
        "Ambrosio, Claro & Lankarani 2006; printed signs and brackets corrected so that F is continuous at eps' = 0",
        needs=("length",),
        trusted=(LONG_BEARING,),
        notes="Approximates the law `long`: within 11 % while the film closes, off by 8 to 26 % while it opens and "
        "more near eps = 1.  It gives no pressure.",
    ),
    (PinkusSternlicht,),
    lambda joint: PinkusSternlicht(_force_and_pressure_factors(joint)[0]),
)
