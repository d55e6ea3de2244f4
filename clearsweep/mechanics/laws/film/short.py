"""The film of a short bearing, in which the oil flows along the pin."""

from typing import NamedTuple

from ....contracts.catalogue import Law, Range
from ....tracing.compiled import calculus as math
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import kernel
from ...joints.recipe import register
from .contract import arc_from, film_force, film_pressure, maximum_over_arc


class Short(NamedTuple):
    """p = (3 mu / c^2) (L^2 / 4 - z^2) (spin eps sin - 2 eps' cos) / H^3, where it is above 0."""

    force: float  # mu R L^3 / c^2, N s
    pressure: float  # 0.75 mu L^2 / c^2, Pa s


@film_force.member(Short)
def _film_force_short(law, motion):
    ratio, squeeze, wedge = motion.ratio, 2.0 * motion.squeeze_rate, motion.spin * motion.ratio
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
    ratio_cosine_squared = (ratio * c) ** 2
    # integrals over the arc of sin^2, sin cos, 1 over H^3 (Booker 1965)
    squeeze_integral = 0.5 * inverse_thickness / one_minus_square + s * ratio * (
        1.0 - 2.0 * c * c + ratio_cosine_squared
    ) / (d * d * one_minus_square)
    wedge_integral = -2.0 * ratio * c * c * c / (d * d)
    square_integral = (inverse_thickness + 2.0 * ratio * s / d) / one_minus_square
    cube_integral = (
        0.5
        * (3.0 * square_integral - inverse_thickness + 2.0 * ratio * s * (1.0 + ratio_cosine_squared) / (d * d))
        / one_minus_square
    )
    radial = 0.5 * law.force * (wedge * wedge_integral - squeeze * (cube_integral - squeeze_integral))
    tangential = 0.5 * law.force * (wedge * squeeze_integral - squeeze * wedge_integral)
    return radial, tangential


@kernel
def _pressure(law, motion, cosine, sine):
    thickness = 1.0 + motion.ratio * cosine
    return law.pressure * (motion.spin * motion.ratio * sine - 2.0 * motion.squeeze_rate * cosine) / thickness**3


@film_pressure.member(Short)
def _film_pressure_short(law, motion):
    return maximum_over_arc(law, motion, _pressure, math.atan2(2.0 * motion.squeeze_rate, motion.spin * motion.ratio))


def _make_short(joint):
    viscosity, length, radius = joint.film.viscosity, joint.length, joint.bearing_radius
    clearance_squared = joint.clearance * joint.clearance
    return Short(viscosity * radius * length**3 / clearance_squared, 0.75 * viscosity * length**2 / clearance_squared)


register(
    Law(
        "film",
        "short",
        "a short bearing: the oil flows along the pin",
        "p = (3 mu / c^2) (L^2 / 4 - z^2) (w eps sin(theta) - 2 eps' cos(theta)) / (1 + eps cos(theta))^3 over the "
        "half circle where p > 0, w = w_j + w_b - 2 gamma'; force in closed form",
        "after Ocvirk 1952, NACA TN 2808, and Booker 1965, J. Basic Eng. 87:537; the integrals derived independently",
        needs=("length",),
        trusted=(
            Range(
                "length / diameter", 0.0, 0.5, "1", "it assumes flow along the pin only; a longer bearing carries less"
            ),
        ),
        notes="At length / diameter 1 and eps = 0.8 its load is 3.2 times too large.  Pressure is 0 outside the half "
        "circle: no suction.",
    ),
    (Short,),
    _make_short,
)
