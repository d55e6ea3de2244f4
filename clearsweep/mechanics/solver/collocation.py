"""Collocation at eight Radau points: all stages of a step lie in the lanes of one register and are found together.

The state over a step of length h is a polynomial whose rates, at the points C, are those of the states there: Radau IIA
of eight stages and order 15 (Hairer, Wanner, "Solving Ordinary Differential Equations II", 2nd ed., IV.5), whose last
stage is the end of the step.  Its equations are solved by fixed-point iteration, every sweep of which evaluates the
right-hand side at all stages at once (van der Houwen & Sommeijer 1990, J. Comput. Appl. Math. 29:111):

    guess the stages from the polynomial of the step before, or from the rates at the start
    until a sweep moves them too little to count:
        rates of the velocities and of internal states at all stages; move these: Y = y + h A K
        rates of the roots of penetration with the new velocities; move these
        rates of coordinates and time from what is new; move these
    the step's polynomial, its error from how its coefficients decay, the next length

Everything else here follows from the points, by exact rational arithmetic.
"""

import math
from fractions import Fraction

import numpy as np

from ..compiled.choosing import abreast
from ..compiled.family import kernel
from ..observe.stages import POINTS, STAGES, START


def _lagrange() -> list[list[Fraction]]:
    """Return the coefficients, constant first, of the polynomials that are 1 at one point and 0 at the others."""
    points, made = [Fraction(x) for x in POINTS], []
    for j, point in enumerate(points):
        coefficients = [Fraction(1)]
        for other in points[:j] + points[j + 1 :]:
            lower, upper = [-other * c for c in coefficients] + [Fraction(0)], [Fraction(0), *coefficients]
            coefficients = [(a + b) / (point - other) for a, b in zip(lower, upper, strict=True)]
        made.append(coefficients)
    return made


def _about_middle(coefficients: list[Fraction]) -> list[Fraction]:
    """Return the coefficients in u = 2 x - 1 of a polynomial in x."""
    made = [Fraction(0)] * len(coefficients)
    for c in reversed(coefficients):  # Horner's scheme with x = (1 + u) / 2
        halves = [a / 2 for a in made]
        made = [a + b for a, b in zip(halves, [Fraction(0), *halves[:-1]], strict=True)]
        made[0] += c
    return made


_INTEGRALS = [[c / (k + 1) for k, c in enumerate(part)] for part in _lagrange()]  # over x, divided by x
C = np.array(POINTS)
#: (of the stage that gives, of the stage that gets): the integral up to each stage.
A = np.array(
    [[float(sum(c * Fraction(x) ** (k + 1) for k, c in enumerate(part))) for x in POINTS] for part in _INTEGRALS]
)
#: (stage, power): from h times the rates at the stages to the coefficients of the interpolant, see `dense_component`.
DENSE = np.array([[float(c) for c in _about_middle(part)] for part in _INTEGRALS])
WEIGHTS = np.ascontiguousarray(A[:, -1])
HUGE = 1e300


@kernel
def dense_component(x, i, y, f):
    """Return component `i` of the interpolant at the share `x` (0 to 1) of the step that starts at `y`.

    f : (n, STAGES), coefficients of the powers of u = 2 x - 1 in its rise over x.
    """
    u = 2.0 * x - 1.0
    total = f[i, STAGES - 1]
    for m in range(STAGES - 2, -1, -1):
        total = total * u + f[i, m]
    return y[i] + x * total


@kernel
def dense_state(x, y, f, w):
    """Put into `w` (n,) the interpolant at the share `x` (0 to 1) of the step that starts at `y` (n,)."""
    for i in range(y.size):
        w[i] = dense_component(x, i, y, f)


def shapes(x):
    """Return the (places, STAGES) values at the shares `x` of what the coefficients `f` are multiplied by."""
    return np.asarray(x)[:, None] * (2.0 * np.asarray(x)[:, None] - 1.0) ** np.arange(STAGES)


@kernel
def interpolate(h, k, f):
    """Put the coefficients of the interpolant over a step of length `h` into `f`; k : (n, ROWS)."""
    for i in range(f.shape[0]):
        for m in abreast(STAGES):
            total = DENSE[0, m] * k[i, 0]
            for j in range(1, STAGES):
                total += DENSE[j, m] * k[i, j]
            f[i, m] = h * total


@kernel
def continue_stages(theta, first, y, f, nodes):
    """Put into `nodes` (n + 1, STAGES) the stages as the interpolant `f` has them.

    It is that of a step from whose share `first`, at which the state is `y`, a step of `theta` times its length begins.
    """
    for i in range(y.size):
        here = 0.0
        if first != 0.0:
            for m in range(STAGES):
                here += f[i, m]
        for m in abreast(STAGES):
            x = first + theta * C[m]
            u = 2.0 * x - 1.0
            total = f[i, STAGES - 1]
            for power in range(STAGES - 2, -1, -1):
                total = total * u + f[i, power]
            nodes[i, m] = y[i] + (x * total - here)


@kernel
def begin_stages(h, y, k, nodes):
    """Put into `nodes` the stages as the rates at the start of a step of length `h` have them."""
    for i in range(y.size):
        rise = h * k[i, START]
        for m in abreast(STAGES):
            nodes[i, m] = y[i] + rise * C[m]


@kernel
def error_norm(f, weight):
    """Return the error over the tolerance of a step with the interpolant `f`: the step is good below 1.

    weight : (n,) 1 / allowed error of each component.  Of the rates' series in Legendre's polynomials the last four
    coefficients are looked at, in pairs, as every other one may be small.  By how much the last pair is smaller than
    the one before, squared, tells a smooth motion, whose end is far more accurate than its interior, from one with a
    kink.  Root mean squares.
    """
    last = before = 0.0
    for i in range(weight.size):
        a, b, c, d = f[i, 7], f[i, 6], f[i, 5], f[i, 4]
        seventh, sixth = (16.0 / 429.0 * 8.0) * a, (16.0 / 231.0 * 7.0) * (a + b)
        fifth = 8.0 / 63.0 * (6.0 * (b + c) + 693.0 / 16.0 * seventh)
        fourth = 8.0 / 35.0 * (5.0 * (c + d) + 315.0 / 16.0 * sixth)
        square = weight[i] * weight[i]
        last = last + square * (seventh * seventh + sixth * sixth)
        before = before + square * (fifth * fifth + fourth * fourth)
    if not last + before < HUGE:
        return math.inf
    return 0.5 * math.sqrt(last / weight.size) * (last / before if last < before else 1.0)
