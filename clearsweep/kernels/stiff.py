"""The implicit method for stiff stretches: Radau IIA of order 5, L-stable, and how stiffness is noticed.

Hairer & Wanner, "Solving Ordinary Differential Equations II", 2nd ed.: coefficients IV.5, simplified Newton iteration
with its start values and the error estimate (8.19), (8.20) of IV.8, detection of stiffness by the explicit pair IV.2
and program DOP853.  The three stages are solved as one system of 3 n equations: n is at most 16 here.  The Jacobian, by
forward differences of the compiled right-hand side, only steers the iteration; the solution does not depend on it.
"""

import math

import numpy as np

from .event import EXPLICIT, IMPLICIT, evaluate
from .family import kernel
from .method import END, NODE_SHARES, dense_state

ROOT6 = math.sqrt(6.0)
A = np.array(
    [
        [(88.0 - 7.0 * ROOT6) / 360.0, (296.0 - 169.0 * ROOT6) / 1800.0, (-2.0 + 3.0 * ROOT6) / 225.0],
        [(296.0 + 169.0 * ROOT6) / 1800.0, (88.0 + 7.0 * ROOT6) / 360.0, (-2.0 - 3.0 * ROOT6) / 225.0],
        [(16.0 - ROOT6) / 36.0, (16.0 + ROOT6) / 36.0, 1.0 / 9.0],
    ]
)
C = ((4.0 - ROOT6) / 10.0, (4.0 + ROOT6) / 10.0)
GAMMA = 3.6378342527444957  # the real eigenvalue of the inverse of A
E = ((-13.0 - 7.0 * ROOT6) / 3.0, (-13.0 + 7.0 * ROOT6) / 3.0, -1.0 / 3.0)
ITERATIONS = 12
CLOSE = 0.01  # of the allowed error: the Newton iteration stops there
FAILED = 256.0  # error of a step whose iteration did not converge: the step control then takes 0.4 of its length
STIFF = 3.5  # h times the largest eigenvalue; the explicit pair is at its limit at 6.1, its error control before
PATIENCE = 15  # steps in a row at that limit before the method is changed
NOT_WORTH = 4.0  # steps of the explicit method that one implicit step must span to be worth its price


@kernel
def factorise(a, pivots):
    """Replace the square matrix `a` by its LU factors with partial pivoting; return whether it is regular."""
    n = pivots.size
    for i in range(n):
        top = i
        for row in range(i + 1, n):
            if abs(a[row, i]) > abs(a[top, i]):
                top = row
        pivots[i] = top
        if not abs(a[top, i]) > 0.0:
            return False
        if top != i:
            for column in range(n):
                a[i, column], a[top, column] = a[top, column], a[i, column]
        inverse = 1.0 / a[i, i]
        for row in range(i + 1, n):
            factor = a[row, i] * inverse
            a[row, i] = factor
            if factor != 0.0:
                for column in range(i + 1, n):
                    a[row, column] -= factor * a[i, column]
    return True


@kernel
def substitute(a, pivots, b):
    """Replace `b` by the solution of the system whose factors are in `a`."""
    n = pivots.size
    for i in range(n):
        b[i], b[pivots[i]] = b[pivots[i]], b[i]
    for i in range(n):
        for row in range(i + 1, n):
            b[row] -= a[row, i] * b[i]
    for i in range(n - 1, -1, -1):
        for column in range(i + 1, n):
            b[i] -= a[i, column] * b[column]
        b[i] /= a[i, i]


@kernel
def find_jacobian(at):
    """Put the derivatives of the rates at `work.y` into `work.jacobian`: forward differences."""
    work = at[0]
    n = work.y.size
    for i in range(n):
        work.z[i] = work.y[i]
    for column in range(n):
        step = max(1.5e-8 * abs(work.y[column]), work.scale[column])
        work.z[column] = work.y[column] + step
        step = work.z[column] - work.y[column]
        evaluate(at, work.z, 1)
        work.z[column] = work.y[column]
        for row in range(n):
            work.jacobian[row, column] = (work.k[1, row] - work.k[0, row]) / step


@kernel
def begin_stages(at, h):
    """Put into `work.stages` what the interpolant of the step before, or of a rejected one from here, says of them.

    work.history : its length, 0 where there is none; 1 if this step follows it, 0 if it begins where it began.
    """
    work = at[0]
    n = work.y.size
    for s in range(3):
        for i in range(n):
            work.stages[s * n + i] = 0.0
    if work.history[0] == 0.0:
        return
    for s in range(3):
        x = work.history[1] + (C[s] if s < 2 else 1.0) * h / work.history[0]
        rest = 1.0 - x
        for i in range(n):
            here = x * (work.f[0, i] + rest * (work.f[1, i] + x * work.f[2, i]))
            work.stages[s * n + i] = here - work.history[1] * work.f[0, i]


@kernel
def fill_newton(newton, jacobian, h):
    """Put I - h A x J into `newton` (3 n, 3 n), the matrix of the simplified Newton iteration."""
    n = jacobian.shape[0]
    for s in range(3):
        for m in range(3):
            for row in range(n):
                for column in range(n):
                    unit = 1.0 if s == m and row == column else 0.0
                    newton[s * n + row, m * n + column] = unit - h * A[s, m] * jacobian[row, column]


@kernel
def iterate(at, h):
    """Solve for the three stages, whose distances from `work.y` come into `work.stages`; return if it converged."""
    work = at[0]
    n = work.y.size
    fill_newton(work.newton, work.jacobian, h)
    if not factorise(work.newton, work.newton_pivots):
        return False
    begin_stages(at, h)
    before = math.inf
    for _ in range(ITERATIONS):
        for s in range(3):
            for i in range(n):
                work.z[i] = work.y[i] + work.stages[s * n + i]
            evaluate(at, work.z, 1 + s)
        for s in range(3):
            for i in range(n):
                slope = A[s, 0] * work.k[1, i] + A[s, 1] * work.k[2, i] + A[s, 2] * work.k[3, i]
                work.change[s * n + i] = h * slope - work.stages[s * n + i]
        substitute(work.newton, work.newton_pivots, work.change)
        size = 0.0
        for s in range(3):
            for i in range(n):
                work.stages[s * n + i] += work.change[s * n + i]
                size += (work.change[s * n + i] / work.scale[i]) ** 2
        size = math.sqrt(size / (3 * n))
        if size < CLOSE:
            return True
        if not size < 2.0 * before:
            return False
        before = size
    return False


@kernel
def filtered_error(at, h, offset):
    """Return the error over the allowed one by (IV.8.19), or (IV.8.20) where `offset` is what that gave, not zeros."""
    work = at[0]
    n = work.y.size
    for i in range(n):
        work.z[i] = work.y[i] + offset[i]
    evaluate(at, work.z, 1)
    size = 0.0
    for i in range(n):
        stages = E[0] * work.stages[i] + E[1] * work.stages[n + i] + E[2] * work.stages[2 * n + i]
        offset[i] = work.k[1, i] + stages / h
    substitute(work.small, work.small_pivots, offset)
    for i in range(n):
        size += (offset[i] / work.scale[i]) ** 2
    return math.sqrt(size / n)


@kernel
def implicit_step(at, h):
    """Put the state after an implicit step into `work.end`, its dense output into `work.f`; return its error.

    The error is squared, so that the step control, made for order 8, takes the fourth root of it.
    """
    work = at[0]
    n = work.y.size
    find_jacobian(at)
    if not iterate(at, h):
        return FAILED
    for row in range(n):
        for column in range(n):
            work.small[row, column] = (GAMMA / h if row == column else 0.0) - work.jacobian[row, column]
    if not factorise(work.small, work.small_pivots):
        return FAILED
    for i in range(n):
        work.end[i] = work.y[i] + work.stages[2 * n + i]
        work.f[0, i] = work.stages[2 * n + i]
        first = (work.stages[i] - C[0] * work.f[0, i]) / (C[0] * (1.0 - C[0]))
        second = (work.stages[n + i] - C[1] * work.f[0, i]) / (C[1] * (1.0 - C[1]))
        work.f[2, i] = (second - first) / (C[1] - C[0])
        work.f[1, i] = first - C[0] * work.f[2, i]
        for row in range(3, 7):
            work.f[row, i] = 0.0
    work.history[0], work.history[1] = h, 0.0
    for i in range(n):
        work.offset[i] = 0.0
    error = filtered_error(at, h, work.offset)
    if error >= 1.0:
        error = filtered_error(at, h, work.offset)
    return error * error


@kernel
def look_along(at):
    """Evaluate the observables of an implicit step where the explicit method has its stages, for sums and maxima."""
    work = at[0]
    for row in range(3, END):
        if row != 4:
            dense_state(NODE_SHARES[row], work.y, work.f, work.z)
            evaluate(at, work.z, row)


@kernel
def choose_method(at, h):
    """Change the method where the step just taken, of length `h`, shows that the other one serves better.

    It takes effect with the next step.  work.limit keeps the length at which the explicit method was left.
    """
    work = at[0]
    if work.mode[0] == IMPLICIT:
        work.mode[1] = work.mode[1] + 1 if h < NOT_WORTH * work.limit[0] else 0
    else:
        rise, run = 0.0, 0.0
        for i in range(work.y.size):  # work.z is still the state of the last stage, which lies at the end of the step
            rise += ((work.k[END, i] - work.k[END - 1, i]) / work.scale[i]) ** 2
            run += ((work.end[i] - work.z[i]) / work.scale[i]) ** 2
        work.mode[1] = work.mode[1] + 1 if h * math.sqrt(rise) > STIFF * math.sqrt(run) else 0
    if work.mode[1] >= PATIENCE:
        work.mode[2] = EXPLICIT if work.mode[0] == IMPLICIT else IMPLICIT
        work.mode[1] = 0
        work.limit[0] = h
