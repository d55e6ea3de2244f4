"""The film of a bearing of finite length: solutions of the two-dimensional Reynolds equation as an expansion.

With the squeeze S = 2 eps' and the wedge W = w eps (1/s), the pressure dissipates P = c / 2 (-S F_r + W F_t) (W).  The
forces (N) follow from its gradient: F_r = -dP/dS / c, F_t = dP/dW / c.  P is that of the short film times exp(g): it is
positive for any g, so the film is passive.
`clearsweep.verify.film_table` solves the equation and writes the file of the coefficients of g.
"""

import functools
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ....contracts.catalogue import Law, Range
from ....tracing import portable
from ....tracing.compiled import calculus as math
from ....tracing.compiled.array_handle import array_handle, load_item
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import kernel
from ...joints.recipe import RECIPES, register
from .contract import film_force, film_pressure
from .short import Short

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


def _make_reynolds(joint):
    short_bearing = RECIPES["film", "short"].make(joint)
    return Reynolds(short_bearing, *tables_at(0.5 * joint.length / joint.bearing_radius))


register(
    Law(
        "film",
        "reynolds",
        "a bearing of finite length: Reynolds' equation in two dimensions, with a cavity",
        "p >= 0, d/dx (h^3 dp/dx) + d/dz (h^3 dp/dz) = 6 mu (w dh/dphi + 2 dh/dt) where p > 0, w = w_j + w_b - 2 "
        "gamma'; P = P_short exp(g(eps, s)), s = S / (S^2 + (1 - eps^2)^(1/2) W^2)^(1/2), S = 2 eps', W = w eps; F_r = "
        "-dP/dS / c, F_t = dP/dW / c; g = sum of c_km t^m T_k(s), t = artanh(eps), for the joint's length / diameter",
        "Reynolds 1886, Phil. Trans. R. Soc. 177:157, with the boundary condition of Swift 1932 and Stieber 1933; "
        "solved and tabulated by clearsweep.verify.film_table",
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
        notes="Within 1 % of the equation's solution up to an eccentricity ratio of 0.97, in every direction of "
        "motion, and within 2 % at 0.998; its largest pressure within 3 %, within a tenth while the film opens.  The "
        "pressure dissipates energy in any motion.  The film begins wherever pressure can be above 0.  In published "
        "tables it begins where it is thickest, which turns a light load on a long bearing by up to 5 deg.",
    ),
    (Reynolds,),
    _make_reynolds,
)
