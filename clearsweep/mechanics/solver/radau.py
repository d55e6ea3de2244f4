"""The implicit method for stiff stretches: Radau IIA of order 9, and the solution of its step.

Five stages, the last at the end of the step; L-stable, so stiff components decay at once.  Hairer & Wanner, "Solving
Ordinary Differential Equations II", 2nd ed., section IV.5: collocation at the zeros of the fourth derivative of
x^4 (x - 1)^5.  All other constants follow from the matrix.

Section IV.8 describes the simplified Newton iteration, its start values and its end, the reuse of the Jacobian, and
the error estimates (8.19) and (8.20).  The direction of a stiff contact
rotates along the step, and the stiff subspace with it.  The Jacobian is therefore evaluated at three of the stages and
interpolated to the others, and the stages are solved for as one system.  It is the exact derivative of the compiled
forces and motions (`dual`).  It only steers the iteration; the solution does not depend on it.
"""

import math

import numpy as np

from ...tracing.compiled.family import invoke, kernel
from ...tracing.portable import coefficients_through, exact, inverse, powers
from ..observe import END, FIRST_IMPLICIT_ROW, NODE_FRACTIONS, SCRATCH, START, whole_registers
from .collocation import RATES, basis_functions, dense_component, dense_state
from .integration import Choice, Implicit, StepHistory, evaluate
from .preconditioner import sweep_part

A = np.array(
    [
        [0.07299886431790333, -0.02673533110794557, 0.018676929763984353, -0.01287910609330644, 0.005042839233882015],
        [0.15377523147918246, 0.14621486784749352, -0.03644456890512809, 0.02123306311930472, -0.007935579902728777],
        [0.14006304568480987, 0.29896712949128346, 0.16758507013524895, -0.03396910168661774, 0.010944288744192253],
        [0.14489430810953477, 0.2765000687601592, 0.32579792291042103, 0.12875675325490976, -0.015708917378805327],
        [0.14371356079122594, 0.28135601514946207, 0.31182652297574126, 0.22310390108357075, 0.04],
    ]
)
STAGES = len(A)
C = np.append(A[:-1].sum(axis=1), 1.0)  # fractions of the step at the stages
ORDER = STAGES + 1  # of the error estimate: power of the step length with which it decreases

GAMMA = 6.286704751729277  # the real eigenvalue of the inverse of A


def _error_weights():
    """Return the weights of the stages in the error estimate, f(y) + GAMMA / h of their sum (IV.8.19).

    It is the difference from a quadrature of one order less than the stages, which also uses f(y) at 1 / GAMMA.
    """
    moments = 1.0 / np.arange(1.0, STAGES + 1.0)
    moments[0] -= 1.0 / GAMMA
    weights = (exact([moments]) @ coefficients_through(C)).rounded()[0]
    return (exact([weights - A[-1]]) @ inverse(exact(A))).rounded()[0]


E = _error_weights()
#: Error estimate without stiffness over the sixth derivative times h^6, from y' = t^5 / 5!.
ERROR_CONSTANT = abs(float((exact([E]) @ powers(C, ORDER + 1)).rounded()[0, ORDER])) / math.factorial(ORDER)
DENSE = inverse(
    exact(basis_functions(C)[:, :STAGES])
).rounded()  # from the stages to the first rows of the dense output
#: From start and stages to the stages of the explicit method, by the polynomial through all.
TO_EXPLICIT_STAGES = (powers(NODE_FRACTIONS[1 : 1 + END], ORDER) @ coefficients_through(np.append(0.0, C))).rounded()
LANES = np.array([*range(STAGES - 1), END])  # of a sweep: those of the stages, the last of which is the end of the step
ROWS = np.arange(FIRST_IMPLICIT_ROW, FIRST_IMPLICIT_ROW + STAGES)  # rows of the observables of the stages
STAGE_WEIGHTS = np.zeros(FIRST_IMPLICIT_ROW + STAGES)
STAGE_WEIGHTS[ROWS] = A[-1]
JACOBIAN_STAGES = np.array([0, 2, 4])  # stages at which Jacobians are evaluated
#: From these to all stages, by a parabola.
TO_ALL_STAGES = (powers(C, JACOBIAN_STAGES.size) @ coefficients_through(C[JACOBIAN_STAGES])).rounded()

ITERATIONS = 5  # with the same Jacobians
NEWTON_TOLERANCE = 0.03  # of the allowed error: expected distance to the solution at which the iteration ends
KEEP_CONVERGENCE = 1e-3  # convergence per iteration up to which the Jacobians are kept for the next step
FAILED = 10.0  # error of a step whose iteration did not converge; the step control then tries 0.6 of its length


def implicit_of(n, zeros=np.zeros) -> Implicit:
    """Return the arrays for a state of `n` numbers; `zeros` allocates them."""
    unknowns = STAGES * n
    return Implicit(
        jacobian=zeros((JACOBIAN_STAGES.size, n, whole_registers(n))),
        newton=zeros((unknowns, unknowns)),
        pivots=zeros(unknowns, dtype=np.int64),
        error_matrix=zeros((n, n)),
        error_pivots=zeros(n, dtype=np.int64),
        stages=zeros(unknowns),
        update=zeros(unknowns),
        offset=zeros(n),
        marks=zeros((ORDER + 1, n)),
        spans=zeros(ORDER + 1),
        choice=Choice.zeros(zeros=zeros),
        history=StepHistory.zeros(zeros=zeros),
    )


@kernel
def exchange_pivot_row(columns, i):
    """Exchange row `i` for the row below with the largest entry in column `i`; return its index."""
    n, pivot = columns.shape[0], i
    for row in range(i + 1, n):
        if abs(columns[i, row]) > abs(columns[i, pivot]):
            pivot = row
    if pivot != i:
        for column in range(n):
            columns[column, i], columns[column, pivot] = columns[column, pivot], columns[column, i]
    return pivot


@kernel
def factorise(columns, pivots, fixed):
    """Replace a square matrix, given by its `columns` (n, n), by its LU factors; return whether it is regular.

    Pivoting is partial, except for the first `fixed` unknowns, whose rows are sparse and remain so.
    """
    n = pivots.size
    for i in range(n):
        pivots[i] = exchange_pivot_row(columns, i) if i >= fixed else i
        if not abs(columns[i, i]) > 0.0:
            return False
        inverse = 1.0 / columns[i, i]
        for row in range(i + 1, n):
            columns[i, row] *= inverse
        for column in range(i + 1, n):
            factor = columns[column, i]
            if factor != 0.0:
                for row in range(i + 1, n):
                    columns[column, row] -= columns[i, row] * factor
    return True


@kernel
def substitute(columns, pivots, b):
    """Replace `b` by the solution of the system whose factors are in `columns`."""
    n = pivots.size
    for i in range(n):
        b[i], b[pivots[i]] = b[pivots[i]], b[i]
    for i in range(n):
        factor = b[i]
        for row in range(i + 1, n):
            b[row] -= columns[i, row] * factor
    for i in range(n - 1, -1, -1):
        factor = b[i] / columns[i, i]
        b[i] = factor
        for row in range(i):
            b[row] -= columns[i, row] * factor


@kernel
def differentiate(pointer, y, stage):
    """Write the derivatives of the rates at `y` to a Jacobian; each column counts as an evaluation."""
    work = pointer[0]
    work.counts.evaluations += y.size
    invoke(work.slopes.code, work.slopes.parameters, (y, work.mode, work.latched, work.implicit.jacobian), stage)


@kernel
def renew_jacobians(pointer, h):
    """Evaluate the Jacobians at three current stages and factorise the matrices; return whether they are regular.

    Contact rotates the stiff direction along the step: with one Jacobian for all stages the iteration would fail long
    before the error requires shorter steps.
    """
    work = pointer[0]
    n, history, stages = work.y.size, work.implicit.history, work.implicit.stages
    for stage in range(JACOBIAN_STAGES.size):
        for i in range(n):
            work.z[i] = work.y[i] + stages[JACOBIAN_STAGES[stage] * n + i]
        differentiate(pointer, work.z, stage)
    history.jacobian_length, history.matrix_length, history.convergence = h, 0.0, KEEP_CONVERGENCE
    return factorise_matrices(pointer, h)


@kernel
def unknown_index(stage, i, time):
    """Return the index of component `i` of a stage among the unknowns of the iteration; time : index of the time.

    Coordinates and time come first: their rates depend on no other coordinates or time, so their elimination is cheap
    and leaves a system of half the size.
    """
    second_half = time // 2
    if i >= second_half:
        i = second_half if i == time else i + 1 if i < time else i
    return STAGES * i + stage


@kernel
def factorise_matrices(pointer, h):
    """Compute the factors for a step of length `h` unless they are current; return whether the matrix is regular."""
    implicit, time = pointer[0].implicit, pointer[0].time
    n, jacobian = implicit.offset.size, implicit.jacobian
    if implicit.history.matrix_length == h:
        return True
    for row in range(n):
        for column in range(n):
            row_start, column_start = unknown_index(0, row, time), unknown_index(0, column, time)
            for m in range(STAGES):
                slope = 0.0
                for stage in range(JACOBIAN_STAGES.size):
                    slope += TO_ALL_STAGES[m, stage] * jacobian[stage, row, column]
                for s in range(STAGES):
                    implicit.newton[column_start + m, row_start + s] = -h * A[s, m] * slope
    for i in range(implicit.update.size):
        implicit.newton[i, i] += 1.0
    for row in range(n):
        for column in range(n):
            implicit.error_matrix[column, row] = -jacobian[0, row, column]
        implicit.error_matrix[row, row] += GAMMA / h
    is_factorised = factorise(implicit.newton, implicit.pivots, STAGES * (time // 2 + 1)) and factorise(
        implicit.error_matrix, implicit.error_pivots, 0
    )
    implicit.history.matrix_length = h if is_factorised else 0.0
    return is_factorised


@kernel
def begin_stages(pointer, h):
    """Initialise the stages from the interpolant of the previous step, or of a rejected one from the same start."""
    work = pointer[0]
    n, history, stages = work.y.size, work.implicit.history, work.implicit.stages
    for i in range(n):
        for s in range(STAGES):
            stages[s * n + i] = 0.0
        if history.length > 0.0:
            origin = dense_component(history.start_fraction, i, work.y, work.f)
            for s in range(STAGES):
                position = history.start_fraction + C[s] * h / history.length
                stages[s * n + i] = dense_component(position, i, work.y, work.f) - origin


@kernel
def evaluate_stages(pointer):
    """Write the stages to `work.nodes` and their rates to `work.k`, at LANES; the lanes between are as the last."""
    work = pointer[0]
    n, stages = work.y.size, work.implicit.stages
    for i in range(n):
        for lane in range(END + 1):
            work.nodes[i, lane] = work.y[i] + stages[min(lane, STAGES - 1) * n + i]
    sweep_part(pointer, RATES)
    work.counts.evaluations += STAGES


@kernel
def newton_iteration(pointer, h):
    """Do one iteration; return the change of the stages over the allowed error."""
    work = pointer[0]
    n, stages, update = work.y.size, work.implicit.stages, work.implicit.update
    evaluate_stages(pointer)
    for s in range(STAGES):
        for i in range(n):
            increment = 0.0
            for m in range(STAGES):
                increment += A[s, m] * work.k[i, LANES[m]]
            update[unknown_index(s, i, work.time)] = h * increment - stages[s * n + i]
    substitute(work.implicit.newton, work.implicit.pivots, update)
    square_sum = 0.0
    for s in range(STAGES):
        for i in range(n):
            correction = update[unknown_index(s, i, work.time)]
            stages[s * n + i] += correction
            square_sum += (correction * work.weight[i]) ** 2
    return math.sqrt(square_sum / (STAGES * n))


@kernel
def iterate(pointer, h):
    """Iterate until the stages fulfil their equations; return whether they do within ITERATIONS.

    The iteration ends when the remaining distance, estimated from the last convergence, is NEWTON_TOLERANCE (IV.8.10).
    """
    history = pointer[0].implicit.history
    last_change = 0.0
    for iteration in range(ITERATIONS):
        change = newton_iteration(pointer, h)
        if iteration > 0:
            history.convergence = change / last_change if last_change > 0.0 else 0.0
        convergence = history.convergence
        if (
            convergence < 1.0
            and change * convergence <= NEWTON_TOLERANCE * (1.0 - convergence)
            and (iteration > 0 or change < 1.0)
        ):
            return True
        if iteration > 0 and not convergence < 1.0:
            return False
        last_change = change
    return False


@kernel
def solve(pointer, h):
    """Solve for the stages of a step of length `h`; return whether the iteration converged."""
    history = pointer[0].implicit.history
    begin_stages(pointer, h)
    is_kept = history.jacobian_length == h or (history.length > 0.0 and history.convergence <= KEEP_CONVERGENCE)
    if not (factorise_matrices(pointer, h) if is_kept else renew_jacobians(pointer, h)):
        return False
    return iterate(pointer, h) or (renew_jacobians(pointer, h) and iterate(pointer, h))


@kernel
def filtered_error(pointer, h, row):
    """Return the error over the allowed one: (IV.8.19), or (IV.8.20) if `row` contains the rates at its result."""
    work = pointer[0]
    n, offset, stages = work.y.size, work.implicit.offset, work.implicit.stages
    for i in range(n):
        total = 0.0
        for s in range(STAGES):
            total += E[s] * stages[s * n + i]
        offset[i] = work.k[i, row] + GAMMA / h * total
    substitute(work.implicit.error_matrix, work.implicit.error_pivots, offset)
    size = 0.0
    for i in range(n):
        size += (offset[i] * work.weight[i]) ** 2
    return math.sqrt(size / n)


@kernel
def implicit_step(pointer, h):
    """Write the state after an implicit step to `work.end`, its dense output to `work.f`; return its error.

    The step control assumes order 8, so the error is raised to the power that makes its root correct for this method.
    """
    work = pointer[0]
    n, history, stages = work.y.size, work.implicit.history, work.implicit.stages
    if not solve(pointer, h):
        history.convergence = 1.0
        return FAILED
    for i in range(n):
        work.end[i] = work.y[i] + stages[(STAGES - 1) * n + i]
        for row in range(STAGES):
            total = 0.0
            for s in range(STAGES):
                total += DENSE[row, s] * stages[s * n + i]
            work.f[i, row] = total
        for row in range(STAGES, work.f.shape[1]):
            work.f[i, row] = 0.0
    history.length, history.start_fraction = h, 0.0
    error = filtered_error(pointer, h, START)
    if error >= 1.0:
        for i in range(n):
            work.z[i] = work.y[i] + work.implicit.offset[i]
        evaluate(pointer, work.z, SCRATCH)
        error = filtered_error(pointer, h, SCRATCH)
    return error ** (8.0 / ORDER)


@kernel
def observe_stages(pointer):
    """Write the observables of the stages; interpolate states and observables to the stages of the explicit method.

    The observables of the last iteration belong to stages before its correction.  With stiff contacts and films, a
    change of the stages changes forces many times as much, relative to the allowed error.
    """
    work = pointer[0]
    evaluate_stages(pointer)
    invoke(work.observe_stages.code, work.observe_stages.parameters, (work.nodes, work.mode, work.latched, work.o), 0)
    for column in range(work.o.shape[0]):
        for s in range(STAGES):
            work.o[column, ROWS[s]] = work.o[column, LANES[s]]
        for row in range(END):
            total = TO_EXPLICIT_STAGES[row, 0] * work.o[column, START]
            for s in range(STAGES):
                total += TO_EXPLICIT_STAGES[row, 1 + s] * work.o[column, ROWS[s]]
            work.o[column, row] = total
    fraction = work.step.length / work.implicit.history.length  # below 1 up to an event
    for i in range(work.y.size):
        for stage in range(NODE_FRACTIONS.size - 1):
            work.nodes[i, stage] = dense_component(fraction * NODE_FRACTIONS[1 + stage], i, work.y, work.f)


@kernel
def shorten_implicit_step(pointer, fraction):
    """Shorten a step to a fraction of its length; take its end and stages from the longer interpolant."""
    work = pointer[0]
    n, stages = work.y.size, work.implicit.stages
    for i in range(n):
        for s in range(STAGES):
            stages[s * n + i] = dense_component(fraction * C[s], i, work.y, work.f) - work.y[i]
    dense_state(fraction, work.y, work.f, work.end)
