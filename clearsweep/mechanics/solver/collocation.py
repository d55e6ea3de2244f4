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
from collections.abc import Iterable
from fractions import Fraction

import numpy as np

from ...tracing.compiled.choosing import lane_range
from ...tracing.compiled.family import inlined, kernel
from ..observe import POINTS, STAGES, START


def lagrange_polynomials(points: Iterable[float]) -> list[list[Fraction]]:
    """Return the Lagrange polynomials of points, as coefficients with the constant first."""
    nodes, polynomials = [Fraction(x) for x in points], []
    for j, node in enumerate(nodes):
        coefficients, value_at_node = [Fraction(1)], Fraction(1)
        for other_node in nodes[:j] + nodes[j + 1 :]:
            lower, upper = [-other_node * c for c in coefficients] + [Fraction(0)], [Fraction(0), *coefficients]
            coefficients = [a + b for a, b in zip(lower, upper, strict=True)]
            value_at_node *= node - other_node
        polynomials.append([c / value_at_node for c in coefficients])
    return polynomials


def _centred_coefficients(coefficients: list[Fraction]) -> list[Fraction]:
    """Return the coefficients in u = 2 x - 1 of a polynomial in x."""
    polynomials = [Fraction(0)] * len(coefficients)
    for c in reversed(coefficients):  # Horner's scheme with x = (1 + u) / 2
        halves = [a / 2 for a in polynomials]
        polynomials = [a + b for a, b in zip(halves, [Fraction(0), *halves[:-1]], strict=True)]
        polynomials[0] += c
    return polynomials


_INTEGRALS = [
    [c / (k + 1) for k, c in enumerate(part)] for part in lagrange_polynomials(POINTS)
]  # over x, divided by x
C = np.array(POINTS)
#: (stage of the rate, stage of the state): the integral up to each stage.
A = np.array(
    [[float(sum(c * Fraction(x) ** (k + 1) for k, c in enumerate(part))) for x in POINTS] for part in _INTEGRALS]
)
#: (stage, power): from h times the rates at the stages to the coefficients of the interpolant, see `dense_component`.
DENSE = np.array([[float(c) for c in _centred_coefficients(part)] for part in _INTEGRALS])
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
