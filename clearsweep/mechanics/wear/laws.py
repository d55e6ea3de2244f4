"""Wear laws, and distributions of the load of a contact over its arc, one block per law.

Wear is proportional to pressure and sliding distance, or to the work of friction, and decreases during running-in.

Persson's pressure is that between a journal and a bearing of like materials, for any contact arc.  The theory gives the
pressure over an arc, and the load of that arc, in closed form.  Wear needs the arc at a load and integrals of the
pressure over the arc and over parts of it.  These are smooth functions without a closed form, so they are represented
by polynomials through their values, with the stated accuracy.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from ...contracts.case import Joint
from ...contracts.catalogue import Field, Law
from ...language.errors import InputError
from ...tracing import portable
from ...tracing.compiled.family import inlined
from ...tracing.portable import coefficients_through, exact, polynomial_through
from ..laws import elastic
from ..laws.contract import Recipe, compile_law, register
from ..laws.own import Own, maker
from ..laws.sampled import attempted, checked
from . import (
    MAX_BINS,
    cumulative_pressure,
    half_arc,
    peak_over_mean,
    pressure_integral_over_load,
    smooth_range,
    wear_rate,
)


class Archard(NamedTuple):
    """dh = k p |v| dt."""

    bearing_coefficient: float  # m^2/N
    journal_coefficient: float  # m^2/N
    bins: float  # of each body
    length: float  # m, of the joint along its pin
    pressure: tuple  # half_arc, cumulative_pressure
    pv_limit: float  # W/m^2, inf: none


@wear_rate.member(Archard)
def _wear_rate_archard(law, sliding):
    pressure_times_speed = sliding.pressure_integral * sliding.sliding_speed
    return law.bearing_coefficient * pressure_times_speed, law.journal_coefficient * pressure_times_speed


Energy = NamedTuple("Energy", [*Archard.__annotations__.items()])  # with coefficients in m^3/J
Energy.__doc__ = "dh = alpha tau |v| dt, with the work of friction distributed like the pressure."


@wear_rate.member(Energy)
def _wear_rate_energy(law, sliding):
    return law.bearing_coefficient * sliding.friction_power, law.journal_coefficient * sliding.friction_power


class RunningIn(NamedTuple):
    """k = steady + (initial - steady) exp(-s / distance), s the sliding distance in contact."""

    law: tuple  # with coefficients of 1
    bearing_coefficients: tuple  # steady, initial: m^2/N or m^3/J
    journal_coefficients: tuple
    distance: float  # m
    bins: float  # of each body
    length: float  # m, of the joint along its pin
    pressure: tuple  # half_arc, cumulative_pressure
    pv_limit: float  # W/m^2


@wear_rate.member(RunningIn)
def _wear_rate_running_in(law, sliding):
    bearing_rate, journal_rate = wear_rate(law.law, sliding)
    fresh_fraction = math.exp(-sliding.sliding_distance / law.distance)
    (steady, initial), (steady_journal, initial_journal) = law.bearing_coefficients, law.journal_coefficients
    return (
        (steady + (initial - steady) * fresh_fraction) * bearing_rate,
        (steady_journal + (initial_journal - steady_journal) * fresh_fraction) * journal_rate,
    )


def _make_wear_law(law_type, joint: Joint):
    """Return the compiled wear law of a joint, within RunningIn if the coefficient changes during running-in."""
    wear = joint.wear
    pressure, bins = compile_law("pressure", wear.pressure, joint), float(min(wear.bins, MAX_BINS))
    common_fields = bins, joint.length, pressure, wear.values.get("pv_limit", math.inf)
    bearing, journal = wear.coefficients().values()
    if wear.running_in is None:
        return law_type(*bearing, *journal, *common_fields)
    return RunningIn(law_type(1.0, 1.0, *common_fields), bearing, journal, wear.running_in["distance"], *common_fields)


register(
    "wear archard: depth proportional to pressure and sliding distance",
    "dh = k p |slip| dt",
    "Archard 1953, J. Appl. Phys. 24:981",
    types=(Archard, RunningIn),
    make=lambda joint: _make_wear_law(Archard, joint),
    notes="k in m^2/N; 1 mm^3/(N m) = 1e-9 m^2/N.  k times the hardness must be far below 1.  A coefficient without a "
    "unit, with a hardness, is that product, K = k H.",
)


register(
    "wear energy: depth proportional to the work of friction",
    "dh = alpha tau |slip| dt, tau = p T / N the friction on the area",
    "Fouvry, Liskiewicz, Kapsa, Hannel & Sauger 2003, Wear 255:287, worn volume over dissipated energy; that the work "
    "is spread like the pressure is an assumption",
    types=(Energy, RunningIn),
    make=lambda joint: _make_wear_law(Energy, joint),
    needs=("friction",),
    notes="`coefficient` is alpha in m^3/J, the volume worn off a body per work of friction: with Coulomb friction mu "
    "that of archard is mu alpha.  Energy in bristles counts as work until they return it.",
)


@maker("wear")
def _own_wear_recipe(own: Own, description: Law) -> Recipe:
    """Return the recipe of a recorded wear law, for both bodies alike.

    A law that is proportional to the pressure is exact for any pressure over the arc; any other is evaluated at the
    mean pressure on the bearing.
    """
    kinds = [own.type_of(role, ("p", *Archard._fields[2:], "radius")) for role in ("linear", "law")]
    evaluate = own.evaluate

    @wear_rate.member(kinds[0])
    def rate_of_sum(wear, sliding):
        rate = evaluate(wear.p, sliding.pressure_integral, sliding.sliding_speed)
        return rate, rate

    @wear_rate.member(kinds[1])
    def rate_of_mean(wear, sliding):
        width = 2.0 * wear.radius * max(sliding.half_angle, LEAST_HALF_ANGLE)
        rate = width * evaluate(wear.p, sliding.pressure_integral / width, sliding.sliding_speed)
        return rate, rate

    def make(joint):
        wear, p = joint.wear, own.parameters(joint.wear.values)

        def largest_deviation():
            pairs = [(evaluate(p, 3.0 * x, v), 3.0 * evaluate(p, x, v)) for x in PRESSURES for v in SPEEDS]
            return max(abs(a - b) / (abs(b) or 1.0) for a, b in pairs)

        is_linear = attempted(largest_deviation, 1.0) <= 1e-12
        pressure, bins = compile_law("pressure", wear.pressure, joint), float(min(wear.bins, MAX_BINS))
        fields = bins, joint.length, pressure, wear.values.get("pv_limit", math.inf), joint.bearing_radius
        return kinds[0 if is_linear else 1](p, *fields)

    def check(joint):
        p = own.parameters(joint.wear.values)
        own.check_traced(p, 1e6, 0.1)
        sampled_rate = checked(functools.partial(evaluate, p), ("pressure", "slip"), own.place)
        for pressure in (0.0, *PRESSURES):
            for slip in (0.0, *SPEEDS):
                if sampled_rate(pressure, slip) < 0.0:
                    raise InputError(f"{own.place}: is below 0 at {pressure:g} Pa and {slip:g} m/s; wear adds nothing")
        return ()

    return Recipe(description, tuple(kinds), make, check=check)


PRESSURES, SPEEDS = (1e3, 1e5, 1e7, 1e9), (1e-4, 1e-2, 1.0, 10.0)  # Pa, m/s, at which wear laws are sampled
LEAST_HALF_ANGLE = 1e-9  # rad


# ---------------------------------------------------------------------------------------------- pressures


class HertzLine(NamedTuple):
    """A Hertzian line contact of half-width a = sqrt(4 f R / (pi E*)); its half-angle is a over the body's radius."""

    width_factor: float  # m (N/m)^-0.5, half-width divided by the root of the line load: sqrt(4 R / (pi E*))


@inlined
def polynomial(coefficients, x):
    """Return the polynomial of an array of coefficients, by powers from 0 on, at `x`."""
    total = 0.0
    for i in range(coefficients.size - 1, -1, -1):
        total = total * x + coefficients[i]
    return total


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
    tail = polynomial(TAIL_COEFFICIENTS, edge_distance)
    return 0.5 + math.copysign(0.5 - tail * edge_distance * math.sqrt(edge_distance), x)


smooth_range.member(HertzLine)(lambda pressure: 0.95)  # at the ends it varies as the power 3/2


@pressure_integral_over_load.member(HertzLine)
def _pressure_integral_over_load_hertz_line(pressure, half_angle):
    return 1.0  # half-spaces: all pressure has the direction of the load


peak_over_mean.member(HertzLine)(lambda pressure, half_angle: 4.0 / math.pi)


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
    return joint.wear.values.get("pressure_modulus") or elastic.plane_strain_modulus(joint.contact.material)


register(
    "pressure hertz-line: Hertzian line contact",
    "half-width a = sqrt(4 f R / (pi E*)), f = F / length",
    "Johnson 1985, Contact Mechanics, section 4.2(c)",
    (MODULUS,),
    types=(HertzLine,),
    make=lambda joint: HertzLine(math.sqrt(4.0 * elastic.relative_radius(joint) / (math.pi * modulus_of(joint)))),
    needs=("modulus",),
    trusted=(elastic.SMALL_ARC,),
    notes="The default where `material` or `pressure_modulus` is given.  The arc is a / R_b on the bearing and a / "
    "R_j on the journal.",
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


@half_arc.member(UniformPressure, Winkler)
def _half_arc_of_rigid_circles(pressure, joint, radius, sliding):
    pen = max(sliding.depth, 0.0)
    square = pen / (
        2.0 * sliding.clearance + pen
    )  # of the tangent of half of it: the arc's cosine, without cancellation
    return 2.0 * polynomial(ARCTANGENT_COEFFICIENTS, square) * math.sqrt(square)


cumulative_pressure.member(UniformPressure)(lambda pressure, x, half_angle: min(max(0.5 + 0.5 * x, 0.0), 1.0))
smooth_range.member(UniformPressure, Winkler)(lambda pressure: 1.0)


@pressure_integral_over_load.member(UniformPressure)
def _pressure_integral_over_load_uniform(pressure, half_angle):
    """Return theta0 / sin(theta0), from the balance of forces, integral p cos(psi) R dpsi = f."""
    return half_angle / math.sin(half_angle) if half_angle > 1e-3 else 1.0 + half_angle * half_angle / 6.0


peak_over_mean.member(UniformPressure)(lambda pressure, half_angle: 1.0)


register(
    "pressure mean: uniform over the contact arc",
    "p = f / (2 R sin theta0), cos theta0 = c / (c + pen), f = F / length, R the radius of the body",
    "geometry of rigid circles; that the pressure is uniform over their arc is an assumption",
    types=(UniformPressure,),
    notes="The default where neither `material` nor `pressure_modulus` is given.  Needs no modulus: the arc follows "
    "only from the penetration.",
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
        / elastic.angle_minus_sine(2.0 * half_angle)
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
    "pressure winkler: proportional to the overlap of the circles",
    "p = f (cos phi - cos theta0) / (R (theta0 - sin theta0 cos theta0)), cos theta0 = c / (c + pen), f = F / length, "
    "R the radius of the body",
    "elastic foundation: Johnson 1985, Contact Mechanics, section 4.3; the scale from the balance of forces",
    types=(Winkler,),
    notes="Needs no modulus: a thin layer on a stiff backing, which deforms only under the pressure on it.  The arc "
    "is that of rigid circles.",
)


# ---------------------------------------------------------------------------------------------- Persson's pressure


MAX_HALF_ANGLE = 2.0 * math.atan(math.sqrt(elastic.MAX_B2))  # rad: half of the arc at an infinite load
HALFWAY_LOAD = 2.0  # E* c: load mapped to half of the interval of `_half_angle_over_root`, chosen for the closest fit
_GAUSS_NODES, _GAUSS_WEIGHTS = portable.gauss_rule(40)


class Persson(NamedTuple):
    """Conformal cylinders of like materials."""

    modulus: float  # E*, Pa


def pressure_over_load(angle, half_angle):
    """Return p R / f at `angle` (rad) from the middle of an arc of half-angle `half_angle` (rad).

    Ciavarella & Decuzzi 2001, with b = tan(half / 2), y = tan(angle / 2); the scale follows from the balance of forces.
    """
    b2, y2 = portable.tan(0.5 * half_angle) ** 2, portable.tan(0.5 * angle) ** 2
    root, root_of_sum = np.sqrt(np.maximum(b2 - y2, 0.0)), np.sqrt(1.0 + b2)
    return 2.0 * root / (math.pi * root_of_sum * (1.0 + y2)) + portable.atanh(root / root_of_sum) / (
        math.pi * b2 * (1.0 + b2)
    )


def _pressure_beyond(x, half_angle):
    """Return the integral of p R / f over the arc beyond `x` (-1 to 1), by Gauss's rule over the arcsine of `x`."""
    low, quarter = math.asin(x), 0.5 * math.pi
    t = low + 0.5 * (quarter - low) * (_GAUSS_NODES + 1.0)
    values = pressure_over_load(half_angle * portable.sin(t), half_angle) * half_angle * portable.cos(t)
    return 0.5 * (quarter - low) * np.sum(_GAUSS_WEIGHTS * values)


def _by_squared_half_angle(function):
    """Return a function of squared half-angles (array, over MAX_HALF_ANGLE squared) from one of a half-angle (rad)."""
    return lambda squares: np.array([function(MAX_HALF_ANGLE * math.sqrt(max(square, 1e-9))) for square in squares])


def _half_angle_over_root(z):
    """Return the half-angle (rad) over the root of z at a load q (in E* c), with z = q / (q + HALFWAY_LOAD)."""
    z = np.clip(z, 1e-12, 1.0 - 1e-12)
    return elastic.half_angle_at_load(HALFWAY_LOAD * z / (1.0 - z)) / np.sqrt(z)


def _tail_fractions(edge_distances, squares):
    """Return the load fractions beyond 1 - d, divided by d^(3/2), for all edge distances d and squared half-angles."""
    half_angles = MAX_HALF_ANGLE * np.sqrt(squares)
    return np.array(
        [
            [
                _pressure_beyond(1.0 - edge_distance, half_angle)
                / (2.0 * _pressure_beyond(0.0, half_angle))
                / edge_distance**1.5
                for half_angle in half_angles
            ]
            for edge_distance in edge_distances
        ]
    )


def _tail_coefficients(degree, square_degree):
    """Return the coefficients of the tail fractions by powers of the edge distance and of the squared half-angle."""
    edge_distances, squares = (portable.chebyshev_points(count + 1) for count in (degree, square_degree))
    rows, columns = (coefficients_through(points) for points in (edge_distances, squares))
    return (rows @ exact(_tail_fractions(edge_distances, squares)) @ columns.transposed).rounded()


ARC_COEFFICIENTS = polynomial_through(_half_angle_over_root, 14)  # by powers of z, to 2e-11
INTEGRAL_COEFFICIENTS = polynomial_through(
    _by_squared_half_angle(lambda half_angle: 2.0 * _pressure_beyond(0.0, half_angle)), 8
)  # by powers of the squared half-angle, to 1e-13
PEAK_COEFFICIENTS = polynomial_through(
    _by_squared_half_angle(
        lambda half_angle: pressure_over_load(0.0, half_angle) * half_angle / _pressure_beyond(0.0, half_angle)
    ),
    10,
)  # to 2e-12
PERSSON_TAIL_COEFFICIENTS = _tail_coefficients(8, 7)  # (9, 8), to 1e-9


@half_arc.member(Persson)
def _half_arc_persson(pressure, joint, radius, sliding):
    q = sliding.line_load / (pressure.modulus * sliding.clearance)
    z = q / (q + HALFWAY_LOAD)
    return polynomial(ARC_COEFFICIENTS, z) * math.sqrt(z)


@inlined
def _relative_square(half_angle):
    """Return the square of a half-angle over that of MAX_HALF_ANGLE."""
    return half_angle * half_angle * (1.0 / (MAX_HALF_ANGLE * MAX_HALF_ANGLE))


@cumulative_pressure.member(Persson)
def _cumulative_pressure_persson(pressure, x, half_angle):
    edge_distance = max(1.0 - abs(x), 0.0)
    square, tail = _relative_square(half_angle), 0.0
    for i in range(PERSSON_TAIL_COEFFICIENTS.shape[0] - 1, -1, -1):
        tail = tail * edge_distance + polynomial(PERSSON_TAIL_COEFFICIENTS[i], square)
    return 0.5 + math.copysign(0.5 - tail * edge_distance * math.sqrt(edge_distance), x)


smooth_range.member(Persson)(lambda pressure: 0.95)  # at the ends it varies as the power 3/2


pressure_integral_over_load.member(Persson)(
    lambda pressure, half_angle: polynomial(INTEGRAL_COEFFICIENTS, _relative_square(half_angle))
)
peak_over_mean.member(Persson)(lambda pressure, half_angle: polynomial(PEAK_COEFFICIENTS, _relative_square(half_angle)))


register(
    "pressure persson: conformal contact of like materials, over any arc up to its limiting angle",
    "p R / f = 2 sqrt(b^2 - y^2) / (pi sqrt(1 + b^2) (1 + y^2)) + ln((w + r) / (w - r)) / (2 pi b^2 (1 + b^2)), r = "
    "sqrt(b^2 - y^2), w = sqrt(b^2 + 1), b = tan(theta / 2), y = tan(phi / 2); f = 2 pi E* c b^2 (b^2 + 1) / (2 - "
    "ln(b^2 + 1) - 2 b^4), f = F / length",
    "after Persson 1964 (thesis, Chalmers) and Ciavarella & Decuzzi 2001, Int. J. Solids Struct. 38:4507, like "
    "materials; the scale from the balance of forces",
    (MODULUS,),
    types=(Persson,),
    make=lambda joint: Persson(modulus_of(joint)),
    needs=("modulus",),
    notes="The arc follows from the load, not from the penetration; a small one is that of Hertz.  The half-angle "
    "cannot pass 84.83 degrees.  Bearing and journal have the same arc.",
)
