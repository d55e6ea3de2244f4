"""Collocation at eight Radau points: all stages of a step are in the lanes of a vector register and solved together.

The state over a step of length h is a polynomial whose rates at the points C equal the right-hand side there: Radau IIA
with eight stages and order 15 (Hairer, Wanner, "Solving Ordinary Differential Equations II", 2nd ed., IV.5), whose last
stage is the end of the step.  Its equations are solved by fixed-point iteration, every sweep of which evaluates the
right-hand side at all stages at once (van der Houwen & Sommeijer 1990, J. Comput. Appl. Math. 29:111):

    guess the stages from the polynomial of the step before, or from the rates at the start
    repeat until the change of a sweep is negligible:
        rates of the velocities and internal states at all stages; update these: Y = y + h A K
        if plain sweeps contract slowly: replace their change by a step of Newton's method, see `preconditioner`
        rates of the roots of penetration with the new velocities; update these
        rates of coordinates and time with the new values; update these
    the step's polynomial, its error from the decay of its coefficients, the next length

All constants follow from the points by exact rational arithmetic.
"""

import math
from math import comb

import numpy as np

from ...tracing.compiled.choosing import lane_range
from ...tracing.compiled.family import inlined, kernel
from ...tracing.portable import Exact, coefficients_through, integrals_through, powers
from ..observe import NODE_FRACTIONS, POINTS, STAGES, START


def centred_powers(count: int) -> Exact:
    """Return the first `count` powers of x, from 0 on, as coefficients in u = 2 x - 1."""
    rows = [[comb(k, m) * 2 ** (count - 1 - k) for m in range(count)] for k in range(count)]  # x = (1 + u) / 2
    return Exact(rows, 2 ** (count - 1))


C = np.array(POINTS)
_INTEGRALS = integrals_through(POINTS)
_POWERS = powers(POINTS, STAGES + 1)
#: (stage of the rate, stage of the state): the integral up to each stage.
A = (_INTEGRALS @ Exact([row[1:] for row in _POWERS.rows], _POWERS.denominator).transposed).rounded()
#: (stage, power): from h times the rates at the stages to the coefficients of the interpolant, see `dense_component`.
DENSE = (_INTEGRALS @ centred_powers(STAGES)).rounded()
WEIGHTS = np.ascontiguousarray(A[:, -1])
HUGE = 1e300
#: Parts of a sweep: all, only the rates, up to the velocities and internal states, the roots and coordinates.
WHOLE_SWEEP, RATES, VELOCITIES, POSITIONS = range(4)


@inlined
def sum_over_stages(matrix, values, i):
    """Return the sum over the stages of column `i` of a matrix times values (STAGES or more,), in pairs."""
    early_terms = (matrix[0, i] * values[0] + matrix[1, i] * values[1]) + (
        matrix[2, i] * values[2] + matrix[3, i] * values[3]
    )
    late_terms = (matrix[4, i] * values[4] + matrix[5, i] * values[5]) + (
        matrix[6, i] * values[6] + matrix[7, i] * values[7]
    )
    return early_terms + late_terms


@kernel
def dense_component(x, i, y, f):
    """Return component `i` of the interpolant at the fraction `x` (0 to 1) of the step that starts at `y`.

    f : (n, STAGES), coefficients of the powers of u = 2 x - 1 in its rise over x.
    """
    u = 2.0 * x - 1.0
    total = f[i, STAGES - 1]
    for m in range(STAGES - 2, -1, -1):
        total = total * u + f[i, m]
    return y[i] + x * total


@kernel
def dense_state(x, y, f, state):
    """Write the interpolant at the fraction `x` (0 to 1) of the step that starts at `y` (n,) to `state` (n,)."""
    for i in range(y.size):
        state[i] = dense_component(x, i, y, f)


def basis_functions(x):
    """Return the basis functions (points, STAGES) of the coefficients `f` at the fractions `x` (points,)."""
    return np.asarray(x)[:, None] * np.vander(2.0 * np.asarray(x) - 1.0, STAGES, increasing=True)


@kernel
def interpolate(h, k, f):
    """Write the coefficients of the interpolant over a step of length `h` to `f`; k : (n, ROWS)."""
    for i in range(f.shape[0]):
        for m in lane_range(STAGES):
            total = DENSE[0, m] * k[i, 0]
            for j in range(1, STAGES):
                total += DENSE[j, m] * k[i, j]
            f[i, m] = h * total


@kernel
def continue_stages(length_ratio, start, y, f, nodes):
    """Write the stages according to the interpolant `f` to `nodes` (n + 1, STAGES).

    The new step begins at the fraction `start` of the interpolant's step, with the state `y`; its length is
    `length_ratio` times that of the interpolant's step.
    """
    for i in range(y.size):
        position = 0.0
        if start != 0.0:
            for m in range(STAGES):
                position += f[i, m]
        for m in lane_range(STAGES):
            x = start + length_ratio * C[m]
            u = 2.0 * x - 1.0
            total = f[i, STAGES - 1]
            for power in range(STAGES - 2, -1, -1):
                total = total * u + f[i, power]
            nodes[i, m] = y[i] + (x * total - position)


@kernel
def begin_stages(h, y, k, nodes):
    """Write the stages according to the rates at the start of a step of length `h` to `nodes`."""
    for i in range(y.size):
        increment = h * k[i, START]
        for m in lane_range(STAGES):
            nodes[i, m] = y[i] + increment * C[m]


@kernel
def error_norm(f, weight):
    """Return the error of a step with the interpolant `f` over the tolerance: the step is accurate below 1.

    weight : (n,) 1 / allowed error of each component.  The error follows from the last four coefficients of the
    Legendre series of the rates, in pairs, as every other one may be small.  The squared ratio of the last pair to the
    earlier one distinguishes a smooth motion, whose end is far more accurate than its interior, from a motion with a
    kink.  Norms are root mean squares.
    """
    last_pair = earlier_pair = 0.0
    for i in range(weight.size):
        a, b, c, d = f[i, 7], f[i, 6], f[i, 5], f[i, 4]
        seventh, sixth = (16.0 / 429.0 * 8.0) * a, (16.0 / 231.0 * 7.0) * (a + b)
        fifth = 8.0 / 63.0 * (6.0 * (b + c) + 693.0 / 16.0 * seventh)
        fourth = 8.0 / 35.0 * (5.0 * (c + d) + 315.0 / 16.0 * sixth)
        square = weight[i] * weight[i]
        last_pair = last_pair + square * (seventh * seventh + sixth * sixth)
        earlier_pair = earlier_pair + square * (fifth * fifth + fourth * fourth)
    if not last_pair + earlier_pair < HUGE:
        return math.inf
    return 0.5 * math.sqrt(last_pair / weight.size) * (last_pair / earlier_pair if last_pair < earlier_pair else 1.0)


# ----------------------------------------------------------------------------------------------------------------------
# Polynomials over a step in Bernstein form, which bounds them, so that no event within a step is missed.
#
# A polynomial of degree n over the fractions x of a step is the sum of b_i B_i(x), with
# B_i = C(n, i) x^i (1 - x)^(n - i).  It lies between the least and the largest coefficient.  The number of its zeros is
# at most the number of sign changes of successive coefficients, and differs from it by an even number (Farouki 2012,
# Comput. Aided Geom. Des. 29:379, section 3).  So the first crossing is isolated by cutting the step until one sign
# change is left, however close crossings are.
#
# A function of the motion is represented by the polynomial of degree 8 through its values at the start and the eight
# stages.  The last two coefficients of its Legendre series, the *tail*, estimate its error.


DEGREE = STAGES
COEFFICIENTS = DEGREE + 1
NO_CROSSING = 2.0  # fraction of a step that means: no crossing
MIN_WIDTH = 2.0**-40  # of a step: crossings closer to each other are ignored
CROSSING_TOLERANCE = 1e-12  # of a step: accuracy of the location of a crossing
#: Rows of `Work.polynomials`: values at the nodes, the coefficients of the whole step, those of a part of the step.
VALUES, WHOLE, PART, ROWS = range(4)


def _of_powers() -> Exact:
    """Return the Bernstein coefficients, except the first, of the powers from 0 on, a row for each."""
    multiple = math.lcm(*(comb(DEGREE, k) for k in range(COEFFICIENTS)))
    rows = [[comb(i, k) * multiple // comb(DEGREE, k) for i in range(1, COEFFICIENTS)] for k in range(COEFFICIENTS)]
    return Exact(rows, multiple)


def _tail_weights() -> list[list[float]]:
    """Return the weights of the coefficients that give the last two coefficients of the Legendre series."""
    n = DEGREE
    next_to_last_power, last_power = (
        [comb(n, k) * comb(k, i) * (-1) ** (k - i) for i in range(COEFFICIENTS)] for k in (n - 1, n)
    )  # of x^(n - 1) and x^n; x^k leads P_k, shifted to (0, 1), with C(2 k, k), and P_n has -n / 2 as much of x^(n - 1)
    return [
        [(2 * a + b * n) / (2 * comb(2 * n - 2, n - 1)) for a, b in zip(next_to_last_power, last_power, strict=True)],
        [b / comb(2 * n, n) for b in last_power],
    ]


_FROM_POWERS = _of_powers()
#: (node, coefficient except the first): from values at the nodes.
FROM_VALUES = (coefficients_through(NODE_FRACTIONS).transposed @ _FROM_POWERS).rounded()
#: (power, coefficient except the first): from the interpolant, see `collocation.dense_component`, minus the state at
#: START; its power m is x (2 x - 1)^m.
FROM_INTERPOLANT = (
    Exact([[0, *(comb(m, k) * 2**k * (-1) ** (m + k) for k in range(STAGES))] for m in range(STAGES)], 1) @ _FROM_POWERS
).rounded()
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
