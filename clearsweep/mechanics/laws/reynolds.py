"""Films: solutions of Reynolds' equation for a short bearing, a long one, and one of finite length.

The law `reynolds` expands the solutions of the two-dimensional equation.  With the squeeze S = 2 eps' and the wedge
W = w eps (1/s), the pressure dissipates P = c / 2 (-S F_r + W F_t) (W).  The forces (N) follow from its gradient:
F_r = -dP/dS / c, F_t = dP/dW / c.  P is that of the short film times exp(g): it is positive for any g, so the film is
passive.
`docs/tools/film_table.py` solves the equation and writes the file of the coefficients of g.
"""

import functools
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...contracts.catalogue import Range
from ...tracing import portable
from ...tracing.compiled import calculus as math
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import kernel
from ...tracing.compiled.pinned import array_handle, load_item
from .contract import RECIPES, register
from .film import arc_from, film_force, film_pressure, has_reversal_corners

#: Of the search for the largest pressure of a short film: steps at most, and accuracy of its place (rad).
MAX_STEPS, ANGLE_TOLERANCE = 40, 1e-8


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
    c, s, d, one_minus_square, inverse_thickness = arc_from(ratio, squeeze, wedge)
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
def _short_pressure(law, motion, cosine, sine):
    thickness = 1.0 + motion.ratio * cosine
    return law.pressure * (motion.spin * motion.ratio * sine - 2.0 * motion.squeeze_rate * cosine) / thickness**3


@film_pressure.member(Short)
def _film_pressure_short(law, motion):
    """Return the largest pressure (Pa), by Newton's method along Sommerfeld's angle psi.

    With W = w eps (1 - eps^2)^(1/2), S = 2 eps' and cos(theta) = (cos(psi) - eps) / (1 - eps cos(psi)) the pressure is
    proportional to (W sin(psi) - S (cos(psi) - eps)) (1 - eps cos(psi))^2: even where the film is thin, smooth.
    """
    ratio, squeeze, wedge = motion.ratio, 2.0 * motion.squeeze_rate, motion.spin * motion.ratio
    speed, root = math.sqrt(squeeze * squeeze + wedge * wedge), math.sqrt(1.0 - ratio * ratio)
    low = math.atan2(root * squeeze, ratio * speed + wedge)  # where the pressure begins, and where it ends
    high = math.atan2(-root * squeeze, ratio * speed - wedge)
    high = high + 2.0 * math.pi if high <= low else high
    wedge *= root
    angle = 0.5 * (low + high)
    for _ in range(MAX_STEPS):
        cosine, sine = math.direction(angle)
        rise = (wedge * cosine + squeeze * sine) * (1.0 - ratio * cosine) + 2.0 * ratio * sine * (
            wedge * sine - squeeze * (cosine - ratio)
        )
        bend = (
            (1.0 + 2.0 * ratio * ratio) * squeeze * cosine
            - wedge * sine
            + 3.0 * ratio * (2.0 * wedge * sine * cosine - squeeze * (cosine * cosine - sine * sine))
        )
        low, high = (angle, high) if rise > 0.0 else (low, angle)
        newton = angle - rise / bend if bend < 0.0 else high
        before, angle = angle, newton if low <= newton < high else 0.5 * (low + high)
        if abs(angle - before) <= ANGLE_TOLERANCE:
            break
    cosine, sine = math.direction(angle)
    thickness = 1.0 - ratio * cosine
    return _short_pressure(law, motion, (cosine - ratio) / thickness, root * sine / thickness)


def _make_short(joint):
    viscosity, length, radius = joint.film.viscosity, joint.length, joint.bearing_radius
    clearance_squared = joint.clearance * joint.clearance
    return Short(viscosity * radius * length**3 / clearance_squared, 0.75 * viscosity * length**2 / clearance_squared)


register(
    "film short: a short bearing: the oil flows along the pin",
    "p = (3 mu / c^2) (L^2 / 4 - z^2) (w eps sin(theta) - 2 eps' cos(theta)) / (1 + eps cos(theta))^3 over the half "
    "circle where p > 0, w = w_j + w_b - 2 gamma'; force in closed form",
    "after Ocvirk 1952, NACA TN 2808, and Booker 1965, J. Basic Eng. 87:537; the integrals derived independently",
    types=(Short,),
    make=_make_short,
    needs=("length",),
    trusted=(
        Range("length / diameter", 0.0, 0.5, "1", "it assumes flow along the pin only; a longer bearing carries less"),
    ),
    notes="At length / diameter 1 and eps = 0.8 its load is 3.2 times too large.  Pressure is 0 outside the half "
    "circle: no suction.",
)


# ---------------------------------------------------------------------------------------------- tabulated


FILE = Path(__file__).with_name("reynolds.npy")  # (lengths, 2, TERMS, POWERS), of power and of largest pressure
LENGTHS = 10  # length / diameter at which the equation is solved
SHORTEST, LONGEST = 0.2, 2.0  # length / diameter
TERMS, POWERS = 18, 12  # terms of the expansion over directions and eccentricities; TERMS is even
MAX_ARTANH = float(np.arctanh(0.999))  # artanh of the largest eccentricity ratio


class Reynolds(NamedTuple):
    """The short film of the same bearing, with correction factors for finite length."""

    short: Short
    power: float  # array (TERMS, POWERS): logarithm of power over that of the short film
    peak: float  # the same for the largest pressure


def tabulated_lengths() -> np.ndarray:
    """Return the (LENGTHS,) length / diameter of the file: Chebyshev nodes on a logarithmic scale."""
    nodes = portable.cos(np.pi * (np.arange(LENGTHS) + 0.5) / LENGTHS)
    low, high = math.log(SHORTEST), math.log(LONGEST)
    return portable.exp(0.5 * (low + high) + 0.5 * (high - low) * nodes)


@functools.cache
def _load_table() -> np.ndarray:
    """Return the content of the file, (lengths, 2, TERMS, POWERS)."""
    return np.load(FILE).astype(float)


@functools.cache
def _chebyshev_powers() -> np.ndarray:
    """Return (POWERS, POWERS): row i has the power coefficients of the Chebyshev polynomial T_i."""
    coefficients = np.zeros((POWERS, POWERS))
    for degree in range(POWERS):
        coefficients[degree, : degree + 1] = np.polynomial.chebyshev.cheb2poly(np.eye(POWERS)[degree])[: degree + 1]
    return coefficients


@functools.lru_cache(maxsize=256)  # most sweeps have few lengths
def tables_at(slenderness: float) -> tuple[float, float]:
    """Return array handles of power and of largest pressure for a length / diameter."""
    nodes = portable.log(tabulated_lengths())
    # barycentric Lagrange interpolation with the weights of Chebyshev nodes
    weights = (-1.0) ** np.arange(LENGTHS) * portable.sin(np.pi * (np.arange(LENGTHS) + 0.5) / LENGTHS)
    distance = math.log(slenderness) - nodes
    at_node = np.flatnonzero(distance == 0.0)
    node_weights = np.eye(LENGTHS)[at_node[0]] if at_node.size else weights / distance / (weights / distance).sum()
    series = sum(node_weight * table for node_weight, table in zip(node_weights, _load_table(), strict=True))
    power, peak = sum(series[..., i, None] * row for i, row in enumerate(_chebyshev_powers()))
    return array_handle(power), array_handle(peak)


@kernel
def evaluate_expansion(table, ratio, direction):
    """Return the sum of c_k(ratio) T_k(direction) over the TERMS of an array, and its derivative by direction.

    With t = artanh(ratio) / MAX_ARTANH, c_k is a polynomial of 2 t^2 - 1, times t for odd terms: the film is the same
    if the ratio and both velocities change sign.
    """
    t = 0.5 * math.log((1.0 + ratio) / (1.0 - ratio)) / MAX_ARTANH
    x = 2.0 * t * t - 1.0
    total = derivative = as_type_of(0.0, x)
    previous, current = as_type_of(1.0, x), as_type_of(direction, x)  # T_k and T_(k + 1)
    previous_slope, current_slope = as_type_of(0.0, x), as_type_of(1.0, x)  # their derivatives over k and k + 1
    for pair in range(TERMS // 2):
        offset = 2 * pair * POWERS
        a = as_type_of(load_item(table, offset + POWERS - 1), x)
        b = as_type_of(load_item(table, offset + 2 * POWERS - 1), x)
        for power in range(POWERS - 2, -1, -1):
            a = a * x + load_item(table, offset + power)
            b = b * x + load_item(table, offset + POWERS + power)
        b = b * t
        total = total + a * previous + b * current
        derivative = derivative + 2.0 * pair * a * previous_slope + (2.0 * pair + 1.0) * b * current_slope
        previous = 2.0 * direction * current - previous
        current = 2.0 * direction * previous - current
        previous_slope = 2.0 * direction * current_slope - previous_slope
        current_slope = 2.0 * direction * previous_slope - current_slope
    return total, derivative


@kernel
def _scaled_velocities(motion):
    """Return S and the scaled W (1/s), their magnitude (1/s), and the scale factor (1 - eps^2)^(1/4) of W (1)."""
    wedge_scale = math.sqrt(math.sqrt(1.0 - motion.ratio * motion.ratio))
    squeeze, wedge = 2.0 * motion.squeeze_rate, motion.spin * motion.ratio * wedge_scale
    speed = math.sqrt(squeeze * squeeze + wedge * wedge)
    return squeeze, wedge, speed, wedge_scale


@film_force.member(Reynolds)
def _film_force_reynolds(law, motion):
    squeeze, wedge, speed, wedge_scale = _scaled_velocities(motion)
    if speed == 0.0:
        zero = as_type_of(0.0, speed)
        return zero, zero
    sine, cosine = squeeze / speed, wedge / speed
    log_factor, slope = evaluate_expansion(law.power, motion.ratio, sine)
    radial, tangential = film_force(law.short, motion)
    factor = math.exp(log_factor)
    # P / c = (-S F_r + W F_t) / 2 of the short film, times the derivative of exp(g); W = wedge / wedge_scale
    direction_term = 0.5 * slope * cosine * (wedge / wedge_scale * tangential - squeeze * radial) / speed
    return factor * (radial - direction_term * cosine), factor * (tangential - direction_term * sine * wedge_scale)


@film_pressure.member(Reynolds)
def _film_pressure_reynolds(law, motion):
    squeeze, _, speed, _ = _scaled_velocities(motion)
    if speed == 0.0:
        return 0.0
    return math.exp(evaluate_expansion(law.peak, motion.ratio, squeeze / speed)[0]) * film_pressure(law.short, motion)


register(
    "film reynolds: a bearing of finite length: Reynolds' equation in two dimensions, with a cavity",
    "p >= 0, d/dx (h^3 dp/dx) + d/dz (h^3 dp/dz) = 6 mu (w dh/dphi + 2 dh/dt) where p > 0, w = w_j + w_b - 2 gamma'; "
    "P = P_short exp(g(eps, s)), s = S / (S^2 + (1 - eps^2)^(1/2) W^2)^(1/2), S = 2 eps', W = w eps; F_r = -dP/dS / "
    "c, F_t = dP/dW / c; g = sum of c_km t^m T_k(s), t = artanh(eps), for the joint's length / diameter",
    "Reynolds 1886, Phil. Trans. R. Soc. 177:157, with the boundary condition of Swift 1932 and Stieber 1933; solved "
    "and tabulated by docs/tools/film_table.py",
    types=(Reynolds,),
    make=lambda joint: Reynolds(
        RECIPES["film", "short"].make(joint), *tables_at(0.5 * joint.length / joint.bearing_radius)
    ),
    needs=("length",),
    ranges=(
        Range(
            "length / diameter",
            SHORTEST,
            LONGEST,
            "1",
            "the equation is tabulated there; choose the law short for a shorter bearing, long for a longer one",
        ),
    ),
    notes="Within 1 % of the equation's solution up to an eccentricity ratio of 0.97, in every direction of motion, "
    "and within 2 % at 0.998; its largest pressure within 3 %, within a tenth while the film opens.  The pressure "
    "dissipates energy in any motion.  The film begins wherever pressure can be above 0.  In published tables it "
    "begins where it is thickest, which turns a light load on a long bearing by up to 5 deg.",
)


# ---------------------------------------------------------------------------------------------- finite length, fitted


class Finite(NamedTuple):
    """Butenschoen's fits; a1 to a9 depend only on length / diameter."""

    force: float  # L D mu / psi^2, N s
    slenderness: float  # b, length / diameter, 1
    a1: float
    a2: float
    a3: float
    a4: float
    a5: float
    a6: float
    a7: float
    a8: float
    a9: float


def make_butenschoen(force: float, b: float) -> Finite:
    """Return the compiled law with the factor `force` (N s) for a length / diameter `b`."""
    return Finite(
        force,
        b,
        a1=1.1642 - 1.9456 * b + 7.1161 * b**2 - 10.1073 * b**3 + 5.0141 * b**4,
        a2=-1.000026 - 0.023634 * b - 0.4215 * b**2 - 0.038817 * b**3 - 0.090551 * b**4,
        a3=1.152624 - 0.104565 * b,
        a4=-2.5905 + 0.798745 * b,
        a5=8.73393 - 2.3291 * b,
        a6=-13.3414 + 3.424337 * b,
        a7=6.6294 - 1.591732 * b,
        a8=0.70038 + 3.2415 * b - 12.2486 * b**2 + 18.895 * b**3 - 9.3561 * b**4,
        a9=-0.999935 + 0.0157434 * b - 0.74224 * b**2 + 0.42278 * b**3 - 0.368928 * b**4,
    )


@kernel
def wedge_number(law, ratio):
    """Return the Sommerfeld number of the wedge and sine and cosine of the attitude."""
    one_minus_square = 1.0 - ratio * ratio
    b, root = law.slenderness, math.sqrt(one_minus_square)
    number = (
        0.5
        * b
        * b
        * ratio
        / (one_minus_square * one_minus_square)
        * math.sqrt(math.pi**2 * one_minus_square + 16.0 * ratio * ratio)
    )
    number *= law.a1 * (ratio - 1.0) / (law.a2 + ratio)
    attitude_factor = law.a3 + ratio * (law.a4 + ratio * (law.a5 + ratio * (law.a6 + ratio * law.a7)))
    # arctan(pi root / (2 ratio)), also for a ratio of 0
    attitude = (0.5 * math.pi - math.atan(2.0 * ratio / (math.pi * root))) * attitude_factor
    return number, math.sin(attitude), math.cos(attitude)


@kernel
def squeeze_number(law, ratio):
    """Return the Sommerfeld number of the squeeze; the ratio has the sign of its rate."""
    one_minus_square = 1.0 - ratio * ratio
    b, root = law.slenderness, math.sqrt(one_minus_square)
    arc = 0.25 * math.pi + 0.5 * math.atan(ratio / root)  # pi / 2 - arccos(ratio) / 2
    number = (
        4.0
        * b
        * b
        / (one_minus_square * one_minus_square * root)
        * (arc * (1.0 + 2.0 * ratio * ratio) + 1.5 * ratio * root)
    )
    return number * law.a8 * (1.0 - ratio) / (-law.a9 - ratio)


has_reversal_corners.member(Finite)(None)


@film_force.member(Finite)
def _film_force_finite(law, motion):
    ratio, squeeze_rate, entrainment = motion.ratio, motion.squeeze_rate, motion.spin
    wedge, sine, cosine = wedge_number(law, ratio)
    squeeze = squeeze_number(law, ratio if squeeze_rate >= 0.0 else -ratio)
    radial = -law.force * (wedge * cosine * abs(entrainment) + squeeze * squeeze_rate)
    return radial, law.force * wedge * sine * entrainment


def _make_finite(joint):
    slenderness = 0.5 * joint.length / joint.bearing_radius
    psi = joint.clearance / joint.bearing_radius
    return make_butenschoen(joint.length * 2.0 * joint.bearing_radius * joint.film.viscosity / (psi * psi), slenderness)


register(
    "film finite: a bearing of finite length, fitted to solutions of Reynolds' equation",
    "F_r = -(L D mu / psi^2) (So_D |w| cos(beta) + So_V eps'), F_t = (L D mu / psi^2) So_D w sin(beta), psi = c / R, "
    "w = w_j + w_b - 2 gamma'; So_D = b^2 eps (pi^2 (1 - eps^2) + 16 eps^2)^(1/2) / (2 (1 - eps^2)^2) a1 (eps - 1) / "
    "(a2 + eps), So_V = 4 b^2 (1 - eps^2)^(-5/2) ((pi / 2 - arccos(eps) / 2) (1 + 2 eps^2) + 1.5 eps (1 - "
    "eps^2)^(1/2)) a8 (1 - eps) / (-a9 - eps) with eps of the sign of eps', beta = arctan(pi (1 - eps^2)^(1/2) / (2 "
    "eps)) (a3 + a4 eps + a5 eps^2 + a6 eps^3 + a7 eps^4), b = L / D, a1 to a9 polynomials of b",
    "after Butenschoen 1976, Das hydrodynamische, zylindrische Gleitlager endlicher Breite unter instationaerer "
    "Belastung, Karlsruhe; fits as in the public multibody program MBDyn",
    types=(Finite,),
    make=_make_finite,
    needs=("length",),
    ranges=(
        Range(
            "length / diameter",
            0.0,
            1.2,
            "1",
            "beyond, its fit of the squeeze changes sign and generates energy; choose the law reynolds, or long",
        ),
    ),
    trusted=(
        Range(
            "length / diameter",
            0.125,
            1.0,
            "1",
            "its fits of a steady wedge and of a pure squeeze are accurate within 7 %",
        ),
    ),
    notes="It adds a wedge and a squeeze that were fitted separately.  With both, a closing film is up to a third "
    "off.  From an eccentricity ratio of 0.6 on, an opening film may push where it should pull and so generate "
    "energy; the message of such a case says so.  The law reynolds generates none.  This law gives no pressure.",
)


# ---------------------------------------------------------------------------------------------- a long bearing


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
    c, s, d, one_minus_square, inverse_thickness = arc_from(ratio, squeeze, wedge)
    start_thickness, ratio_cosine_square = 1.0 + ratio * c, ratio * c * c
    wedge_factor = 6.0 * law.force * wedge / two_plus_square
    end_term = (2.0 + ratio * c) / (start_thickness * start_thickness)
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
def _long_pressure(law, motion, cosine, sine):
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
    """Return the largest pressure (Pa): the flow is then that of the shear, W (cos(theta) + k) + S sin(theta) = 0."""
    squeeze, wedge = 2.0 * motion.squeeze_rate, motion.spin * motion.ratio
    speed = math.sqrt(squeeze * squeeze + wedge * wedge)
    if speed == 0.0:
        return 0.0
    squeeze, wedge = squeeze / speed, wedge / speed
    cosine = -3.0 * motion.ratio / (2.0 + motion.ratio * motion.ratio) * wedge  # from the direction of W and S
    sine = math.sqrt(1.0 - cosine * cosine)
    return _long_pressure(law, motion, wedge * cosine - squeeze * sine, squeeze * cosine + wedge * sine)


def _force_and_pressure_factors(joint):
    viscosity, length, radius = joint.film.viscosity, joint.length, joint.bearing_radius
    clearance_squared = joint.clearance * joint.clearance
    return viscosity * length * radius**3 / clearance_squared, 6.0 * viscosity * radius**2 / clearance_squared


register(
    "film long: a long bearing: the oil flows around the pin",
    "p = (6 mu R^2 / c^2) (w eps sin(theta) (2 + eps cos(theta)) / ((2 + eps^2) H^2) + eps' / (eps H^2) + p_0), H = 1 "
    "+ eps cos(theta), over the half circle from tan(theta_1) = eps' (2 + eps^2) / (w eps) at whose ends it is 0; w = "
    "w_j + w_b - 2 gamma'; force in closed form",
    "Sommerfeld 1904's pressure over half the circumference, as in Pinkus & Sternlicht 1961; integrated independently",
    types=(Long,),
    make=lambda joint: Long(*_force_and_pressure_factors(joint)),
    needs=("length",),
    trusted=(LONG_BEARING,),
    notes="Pressure counts only over the half circle; near its ends it can be negative while the film opens.",
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
    "film pinkus-sternlicht: a long bearing, in the form used in multibody dynamics",
    "F_r = -6 mu L R^3 / c^2 |eps'| (4 k eps^2 +- (2 + eps^2) pi q) / ((2 + eps^2) (1 - eps^2)^(3/2)), F_t = 6 pi mu "
    "L R^3 / c^2 eps w q / ((2 + eps^2) (1 - eps^2)^(1/2)), k^2 = (1 - eps^2) (w^2 / (4 eps'^2) + 1 / eps^2), q = (k "
    "+ 3) / (k + 3/2) and + for eps' > 0, q = k / (k + 3/2) and - for eps' < 0; w = w_j + w_b - 2 gamma'",
    "after Pinkus & Sternlicht 1961, Theory of Hydrodynamic Lubrication, as reported by Ravn 1998 and Flores, "
    "Ambrosio, Claro & Lankarani 2006; printed signs and brackets corrected so that F is continuous at eps' = 0",
    types=(PinkusSternlicht,),
    make=lambda joint: PinkusSternlicht(_force_and_pressure_factors(joint)[0]),
    needs=("length",),
    trusted=(LONG_BEARING,),
    notes="Approximates the law `long`: within 11 % while the film closes, off by 8 to 26 % while it opens and more "
    "near eps = 1.  It gives no pressure.",
)
