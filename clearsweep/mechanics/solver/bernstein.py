"""Polynomials over a step in Bernstein form, which bounds them, so that no event within a step is missed.

A polynomial of degree n over the fractions x of a step is the sum of b_i B_i(x), B_i = C(n, i) x^i (1 - x)^(n - i).  It
lies between the least and the largest coefficient.  The number of its zeros is at most the number of sign changes of
successive coefficients, and differs from it by an even number (Farouki 2012, Comput. Aided Geom. Des. 29:379,
section 3).  So the first crossing is isolated by cutting the step until one sign change is left, however close
crossings are.

A function of the motion is represented by the polynomial of degree 8 through its values at the start and the eight
stages.  The last two coefficients of its Legendre series, the *tail*, estimate its error.
"""

from collections.abc import Sequence
from fractions import Fraction
from math import comb

import numpy as np

from ...tracing.compiled.choosing import lane_range
from ...tracing.compiled.family import kernel
from ..observe import NODE_FRACTIONS, STAGES
from .collocation import lagrange_polynomials

DEGREE = STAGES
COEFFICIENTS = DEGREE + 1
NO_CROSSING = 2.0  # fraction of a step that means: no crossing
MIN_WIDTH = 2.0**-40  # of a step: crossings closer to each other are ignored
CROSSING_TOLERANCE = 1e-12  # of a step: accuracy of the location of a crossing
#: Rows of `Work.polynomials`: values at the nodes, the coefficients of the whole step, those of a part of the step.
VALUES, WHOLE, PART, ROWS = range(4)


def _of_powers(coefficients: Sequence[Fraction | int]) -> list[Fraction]:
    """Return the Bernstein coefficients of a polynomial from those of its powers, the constant first."""
    return [
        sum((Fraction(comb(i, k) * c) / comb(DEGREE, k) for k, c in enumerate(coefficients[: i + 1])), Fraction(0))
        for i in range(COEFFICIENTS)
    ]


def _tail_weights() -> list[list[float]]:
    """Return the weights of the coefficients that give the last two coefficients of the Legendre series."""
    n = DEGREE
    next_to_last_power, last_power = (
        [Fraction(comb(n, k) * comb(k, i) * (-1) ** (k - i)) for i in range(COEFFICIENTS)] for k in (n - 1, n)
    )  # of x^(n - 1) and x^n; x^k leads P_k, shifted to (0, 1), with C(2 k, k), and P_n has -n / 2 as much of x^(n - 1)
    next_to_last_weights = [a + b * Fraction(n, 2) for a, b in zip(next_to_last_power, last_power, strict=True)]
    return [
        [float(x / comb(2 * k, k)) for x in weights] for k, weights in ((n - 1, next_to_last_weights), (n, last_power))
    ]


#: (node, coefficient except the first): from values at the nodes.
FROM_VALUES = np.array([list(map(float, _of_powers(part)[1:])) for part in lagrange_polynomials(NODE_FRACTIONS)])
#: (power, coefficient except the first): from the interpolant, see `collocation.dense_component`, minus the state at
#: START; its power m is x (2 x - 1)^m.
FROM_INTERPOLANT = np.array(
    [
        list(map(float, _of_powers([0, *[comb(m, k) * 2**k * (-1) ** (m - k) for k in range(m + 1)]])[1:]))
        for m in range(STAGES)
    ]
)
TAIL_WEIGHTS = np.array(_tail_weights())


@kernel
def set_from_values(p):
    """Write the coefficients of the polynomial through VALUES at the nodes to row WHOLE of `p` (ROWS, COEFFICIENTS)."""
    p[WHOLE, 0] = p[VALUES, 0]
    for i in lane_range(STAGES):
        total = FROM_VALUES[0, i] * p[VALUES, 0]
        for m in range(1, COEFFICIENTS):
            total += FROM_VALUES[m, i] * p[VALUES, m]
        p[WHOLE, 1 + i] = total
    p[WHOLE, DEGREE] = p[VALUES, DEGREE]


@kernel
def set_from_interpolant(p, start, f, c):
    """Write component `c` of the interpolant `f` (n, STAGES) to row WHOLE of `p`; `start` is its value at the start."""
    p[WHOLE, 0] = start
    for i in lane_range(STAGES):
        total = FROM_INTERPOLANT[0, i] * f[c, 0]
        for m in range(1, STAGES):
            total += FROM_INTERPOLANT[m, i] * f[c, m]
        p[WHOLE, 1 + i] = start + total


@kernel
def negate(p):
    """Negate the polynomial WHOLE."""
    for i in range(COEFFICIENTS):
        p[WHOLE, i] = -p[WHOLE, i]


@kernel
def subtract(p, number):
    """Subtract a number from the polynomial WHOLE."""
    for i in range(COEFFICIENTS):
        p[WHOLE, i] -= number


@kernel
def upper_bound(p):
    """Return the largest coefficient of WHOLE except the first, an upper bound of its values within the step."""
    largest = p[WHOLE, 1]
    for i in range(2, COEFFICIENTS):
        largest = max(largest, p[WHOLE, i])
    return largest


@kernel
def lower_bound(p):
    """Return the least coefficient of WHOLE except the first, a lower bound of its values within the step."""
    least = p[WHOLE, 1]
    for i in range(2, COEFFICIENTS):
        least = min(least, p[WHOLE, i])
    return least


@kernel
def error_bound(p):
    """Return the error bound of WHOLE: the sum of the sizes of the last two coefficients of its Legendre series."""
    next_to_last = last = 0.0
    for i in range(COEFFICIENTS):
        next_to_last += TAIL_WEIGHTS[0, i] * p[WHOLE, i]
        last += TAIL_WEIGHTS[1, i] * p[WHOLE, i]
    return abs(next_to_last) + abs(last)


@kernel
def value_and_slope(p, row, x):
    """Return the polynomial in a row of `p` and its slope at the fraction `x` of its interval (de Casteljau's sums)."""
    complement, power, count = 1.0 - x, 1.0, 1.0
    value, slope = p[row, 0] * complement, p[row, 1] - p[row, 0]
    for i in range(1, DEGREE):
        power *= x
        next_count = count * (DEGREE - i) / i  # C(n - 1, i)
        value = (value + power * (count + next_count) * p[row, i]) * complement
        slope = slope * complement + power * next_count * (p[row, i + 1] - p[row, i])
        count = next_count
    return value + power * x * p[row, DEGREE], DEGREE * slope


@kernel
def extract_part(p, start, width):
    """Write the coefficients of WHOLE over [start, start + width] to PART, by de Casteljau's algorithm."""
    for i in range(COEFFICIENTS):
        p[PART, i] = p[WHOLE, i]
    if start > 0.0:
        for r in range(1, COEFFICIENTS):
            for i in range(COEFFICIENTS - r):
                p[PART, i] += start * (p[PART, i + 1] - p[PART, i])
    ratio = width / (1.0 - start)
    if ratio < 1.0:
        for r in range(1, COEFFICIENTS):
            for i in range(DEGREE, r - 1, -1):
                p[PART, i] = p[PART, i - 1] + ratio * (p[PART, i] - p[PART, i - 1])


@kernel
def count_sign_changes(p):
    """Return the number of sign changes of the coefficients of PART; zero counts as positive."""
    changes = 0
    for i in range(DEGREE):
        if (p[PART, i] >= 0.0) != (p[PART, i + 1] >= 0.0):
            changes += 1
    return changes


@kernel
def find_only_crossing(p):
    """Return the fraction of its interval of the only zero of PART, which begins negative and ends positive.

    Newton's method, safeguarded by bisection.
    """
    a, b = 0.0, 1.0
    x = p[PART, 0] / (p[PART, 0] - p[PART, DEGREE])
    for _ in range(60):
        value, slope = value_and_slope(p, PART, x)
        if value >= 0.0:
            b = x
        else:
            a = x
        newton = x - value / slope if slope > 0.0 else -1.0
        if not a <= newton <= b:
            newton = 0.5 * (a + b)
        correction, x = abs(newton - x), newton
        if correction <= CROSSING_TOLERANCE:
            break
    return x


@kernel
def find_first_crossing(p):
    """Return the fraction of the step at which WHOLE first crosses zero upwards, or NO_CROSSING."""
    start, width = 0.0, 1.0
    while start < 1.0:
        extract_part(p, start, width)
        changes = count_sign_changes(p)
        if changes > 1 and width > MIN_WIDTH:
            width *= 0.5
        elif changes == 1 and p[PART, 0] < 0.0:
            return start + width * find_only_crossing(p)
        else:
            start += width
            width = min(2.0 * width, 1.0 - start)
    return NO_CROSSING


@kernel
def find_certain_crossing(p, noise):
    """Return the fraction where WHOLE first crosses zero upwards, or NO_CROSSING if it stays within its error bound.

    noise : error bound of the values at the nodes.
    """
    if upper_bound(p) < noise:
        return NO_CROSSING
    is_crossed = False
    for m in range(1, COEFFICIENTS):
        is_crossed = is_crossed or p[VALUES, m] > noise
    if not is_crossed:
        error = max(error_bound(p), noise)
        subtract(p, error)
        if find_first_crossing(p) == NO_CROSSING:
            return NO_CROSSING
        subtract(p, -error)
    return find_first_crossing(p)


@kernel
def find_minimum(p):
    """Return the fraction at which the slope of WHOLE, negative first, crosses zero upwards, or NO_CROSSING."""
    _, end_slope = value_and_slope(p, WHOLE, 1.0)
    if end_slope < 0.0:
        return NO_CROSSING
    a, b = 0.0, 1.0
    for _ in range(40):
        x = 0.5 * (a + b)
        _, slope = value_and_slope(p, WHOLE, x)
        if slope < 0.0:
            a = x
        else:
            b = x
    return b
