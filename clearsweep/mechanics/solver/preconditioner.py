"""Preconditioning of the iteration of a step, for motion whose plain iteration contracts slowly.

A sweep multiplies an error of the velocities by h A K: h is the length of the step, A the matrix of the stages, K the
derivative of the rates of velocities by velocities, large with strong damping.  Through coordinates and roots of
penetration, which follow from the velocities within the sweep, comes h^2 A^2 Q, large with a stiff contact or link.
After the velocities of a sweep are updated, their change r is therefore replaced by the solution x of

    (I - h A K - h^2 A^2 Q) x = r,

a step of Newton's method for the velocities.  K and Q are those of the middle stage: they steer the iteration, and the
solution does not depend on them.  In the basis of the eigenvectors of A (Butcher 1976, BIT 16:237) the system falls
into one small complex system for each eigenvalue; a lane of a register solves one.

K and Q are difference quotients.  Eight lanes evaluate as many states at once: the middle stage and, for K, each
velocity changed.  The rates of coordinates and roots respond to this change too.  For Q, coordinates and roots are
changed in proportion to this response.  Both together cost as much as a sweep.

Internal states of laws are treated like velocities, both are the *unknowns* here.
"""

import functools
import math

import numpy as np

from ...tracing.compiled.choosing import lane_range
from ...tracing.compiled.family import inlined, invoke, kernel
from ...tracing.portable import exact, inverse
from ..observe import POINTS, STAGES
from .collocation import POSITIONS, RATES, VELOCITIES, sum_over_stages
from .integration import Preconditioner

#: The eigenvalues of the transpose of `collocation.A` above the real axis; the others are their conjugates.
EIGENVALUES = (
    (0.09581388421722299, 0.01553835183431958),
    (0.08311502047409457, 0.04390817534395189),
    (0.05954718974867207, 0.06441173606613618),
    (0.028190572226677032, 0.0722623991777717),
)
PAIRS = len(EIGENVALUES)
LARGEST = max(math.hypot(*eigenvalue) for eigenvalue in EIGENVALUES)
MIDDLE = 3  # stage at which the rates are differentiated
MAX_UNKNOWNS = STAGES - 1  # one lane for each, and one for the middle stage
#: Increments of the difference quotients: part of the number and of its rise since the start, plus part of the allowed
#: error.
RELATIVE_INCREMENT, INCREMENT_OF_ERROR = 1e-6, 0.01
#: Contraction of the plain iteration from which the next step is preconditioned, and below which it is not.
SLOW_CONTRACTION, FAST_CONTRACTION = 0.15, 0.1


def _eigenvector(eigenvalue):
    """Return the real and the imaginary parts at the stages of an eigenvector.

    It is the sum over k of eigenvalue^k times the k-th derivative of the polynomial whose zeros are the stages.  Its
    integral is eigenvalue times itself, plus a multiple of that polynomial, which is zero at the stages.
    """
    a, b = eigenvalue
    polynomial = [1.0]  # the constant first
    for point in POINTS:
        polynomial = [p - point * q for p, q in zip([0.0, *polynomial], [*polynomial, 0.0], strict=True)]
    power_real, power_imaginary, real, imaginary = 1.0, 0.0, [0.0] * STAGES, [0.0] * STAGES
    for _ in range(STAGES):
        polynomial = [k * c for k, c in enumerate(polynomial)][1:]
        power_real, power_imaginary = a * power_real - b * power_imaginary, a * power_imaginary + b * power_real
        for i, point in enumerate(POINTS):
            value = functools.reduce(lambda total, c, x=point: total * x + c, reversed(polynomial))
            real[i] += power_real * value
            imaginary[i] += power_imaginary * value
    return real, imaginary


_VECTORS = np.array([_eigenvector(eigenvalue) for eigenvalue in EIGENVALUES])  # (pair, side, stage)
#: (pair, stage): from the components along the eigenvectors to the stages.
FROM_REAL, FROM_IMAGINARY = np.ascontiguousarray(_VECTORS[:, 0]), np.ascontiguousarray(-_VECTORS[:, 1])
_TO_COMPONENTS = inverse(exact(np.concatenate([FROM_REAL, -FROM_IMAGINARY]).T)).rounded()
_PAIR_OF_LANE = np.arange(STAGES) % PAIRS  # every pair is in two lanes
#: (stage, lane): from the stages to the components along the eigenvectors.
TO_REAL = np.ascontiguousarray(_TO_COMPONENTS[_PAIR_OF_LANE].T)
TO_IMAGINARY = np.ascontiguousarray(-_TO_COMPONENTS[PAIRS + _PAIR_OF_LANE].T)
#: (lane): the eigenvalues and their squares.
REAL, IMAGINARY = np.array(EIGENVALUES)[_PAIR_OF_LANE].T.copy()
SQUARE_REAL, SQUARE_IMAGINARY = REAL * REAL - IMAGINARY * IMAGINARY, 2.0 * REAL * IMAGINARY


def preconditioner_of(unknowns, zeros=np.zeros) -> Preconditioner:
    """Return the arrays for a number of unknowns, empty if there are too many; `zeros` allocates them."""
    u = unknowns if unknowns <= MAX_UNKNOWNS else 0
    return Preconditioner(
        increment=zeros(u),
        base=zeros(u),
        linear=zeros((u, u)),
        quadratic=zeros((u, u)),
        factors_real=zeros((u, u, STAGES)),
        factors_imaginary=zeros((u, u, STAGES)),
        real=zeros((u, STAGES)),
        imaginary=zeros((u, STAGES)),
        before=zeros((u, STAGES)),
        product_real=zeros(STAGES),
        product_imaginary=zeros(STAGES),
    )


@kernel
def sweep_part(pointer, part):
    """Do a part of a sweep, see `collocation`."""
    work = pointer[0]
    work.step.part = part
    arguments = work.y, work.mode, work.latched, work.weight, work.k, work.nodes, work.step.numbers
    invoke(work.sweep.code, work.sweep.parameters, arguments, 0)


@kernel
def row_of(pointer, unknown):
    """Return the index in the state of an unknown: first the velocities, then the internal states."""
    count = pointer[0].time // 2
    return count + unknown if unknown < count else count + 1 + pointer[0].mode.size + unknown


@kernel
def linearise(pointer, h):
    """Write the derivatives for a step of length `h`, at the middle of its stages, which are overwritten."""
    work, arrays = pointer[0], pointer[0].preconditioner
    nodes, k, count = work.nodes, work.k, arrays.increment.size
    for r in range(work.y.size):
        base = nodes[r, MIDDLE]
        for i in lane_range(STAGES):
            nodes[r, i] = base
    for j in range(count):
        r = row_of(pointer, j)
        size = abs(nodes[r, 0]) + abs(nodes[r, 0] - work.y[r])
        arrays.increment[j] = RELATIVE_INCREMENT * size + INCREMENT_OF_ERROR / work.weight[r]
        nodes[r, j + 1] += arrays.increment[j]
    sweep_part(pointer, RATES)
    for j in range(count):
        nodes[row_of(pointer, j), j + 1] -= arrays.increment[j]
        arrays.base[j] = k[row_of(pointer, j), 0]
        for i in range(count):
            r = row_of(pointer, i)
            arrays.linear[i, j] = (k[r, j + 1] - k[r, 0]) * h / arrays.increment[j]
        for i in range(work.time // 2):
            nodes[i, j + 1] += (k[i, j + 1] - k[i, 0]) * h
        for i in range(work.time + 1, work.time + 1 + work.mode.size):
            nodes[i, j + 1] += (k[i, j + 1] - k[i, 0]) * h
    sweep_part(pointer, RATES)
    for i in range(count):
        for j in range(count):
            arrays.quadratic[i, j] = (k[row_of(pointer, i), j + 1] - arrays.base[i]) * h / arrays.increment[j]
    work.counts.evaluations += 2 * STAGES


@kernel
def predicted_contraction(pointer):
    """Return about the contraction of the plain iteration, from the traces of the derivatives."""
    arrays, linear, quadratic = pointer[0].preconditioner, 0.0, 0.0
    for i in range(arrays.increment.size):
        linear += arrays.linear[i, i]
        quadratic += arrays.quadratic[i, i]
    return LARGEST * abs(linear) + LARGEST**2 * abs(quadratic)


@kernel
def write_entry(arrays, r, c, terms):
    """Write an entry of the factors: that of the matrix minus the product of the first `terms` entries before it."""
    a, b = arrays.factors_real, arrays.factors_imaginary
    linear, quadratic, unit = arrays.linear[r, c], arrays.quadratic[r, c], 1.0 if r == c else 0.0
    for i in lane_range(STAGES):
        real = unit - (REAL[i] * linear + SQUARE_REAL[i] * quadratic)
        imaginary = -(IMAGINARY[i] * linear + SQUARE_IMAGINARY[i] * quadratic)
        for p in range(terms):
            real = real - (a[r, p, i] * a[p, c, i] - b[r, p, i] * b[p, c, i])
            imaginary = imaginary - (a[r, p, i] * b[p, c, i] + b[r, p, i] * a[p, c, i])
        a[r, c, i], b[r, c, i] = real, imaginary


@kernel
def factorise_pairs(arrays):
    """Factorise the matrix of every eigenvalue without pivoting; its diagonal then contains the inverse pivots.

    Pivots differ between lanes.  A pivot that is nearly zero makes the iteration fail, which repeats the step.
    """
    a, b, count = arrays.factors_real, arrays.factors_imaginary, arrays.increment.size
    for r in range(count):
        for c in range(r):
            write_entry(arrays, r, c, c)
            for i in lane_range(STAGES):
                real, imaginary = a[r, c, i], b[r, c, i]
                a[r, c, i] = real * a[c, c, i] - imaginary * b[c, c, i]
                b[r, c, i] = real * b[c, c, i] + imaginary * a[c, c, i]
        for c in range(r, count):
            write_entry(arrays, r, c, r)
        for i in lane_range(STAGES):
            real, imaginary = a[r, r, i], b[r, r, i]
            inverse_square = 1.0 / (real * real + imaginary * imaginary)
            a[r, r, i], b[r, r, i] = real * inverse_square, -imaginary * inverse_square


@kernel
def eliminate(pointer):
    """Replace the changes of the unknowns in a sweep by their components, and eliminate below the diagonal."""
    arrays, nodes = pointer[0].preconditioner, pointer[0].nodes
    a, b, x, y = arrays.factors_real, arrays.factors_imaginary, arrays.real, arrays.imaginary
    for j in range(arrays.increment.size):
        r = row_of(pointer, j)
        for i in lane_range(STAGES):
            nodes[r, i] = nodes[r, i] - arrays.before[j, i]
        for i in lane_range(STAGES):
            real = sum_over_stages(TO_REAL, nodes[r], i)
            imaginary = sum_over_stages(TO_IMAGINARY, nodes[r], i)
            for c in range(j):
                real = real - (a[j, c, i] * x[c, i] - b[j, c, i] * y[c, i])
                imaginary = imaginary - (a[j, c, i] * y[c, i] + b[j, c, i] * x[c, i])
            x[j, i], y[j, i] = real, imaginary


@inlined
def _at_stages(x, y, i):
    """Return the value at stage `i` of components (STAGES,) along the eigenvectors."""
    real = (FROM_REAL[0, i] * x[0] + FROM_REAL[1, i] * x[1]) + (FROM_REAL[2, i] * x[2] + FROM_REAL[3, i] * x[3])
    early = FROM_IMAGINARY[0, i] * y[0] + FROM_IMAGINARY[1, i] * y[1]
    late = FROM_IMAGINARY[2, i] * y[2] + FROM_IMAGINARY[3, i] * y[3]
    return real + (early + late)


@kernel
def substitute_back(pointer):
    """Solve for the components of the changes; set the unknowns, and the squares of their changes."""
    work, arrays = pointer[0], pointer[0].preconditioner
    nodes, n, count = work.nodes, work.y.size, arrays.increment.size
    a, b, x, y = arrays.factors_real, arrays.factors_imaginary, arrays.real, arrays.imaginary
    for i in lane_range(STAGES):
        nodes[n, i] = 0.0
    for j in range(count - 1, -1, -1):
        r = row_of(pointer, j)
        inverse_scale = work.weight[r]
        for i in lane_range(STAGES):
            real, imaginary = x[j, i], y[j, i]
            for c in range(j + 1, count):
                real = real - (a[j, c, i] * x[c, i] - b[j, c, i] * y[c, i])
                imaginary = imaginary - (a[j, c, i] * y[c, i] + b[j, c, i] * x[c, i])
            x[j, i] = real * a[j, j, i] - imaginary * b[j, j, i]
            y[j, i] = real * b[j, j, i] + imaginary * a[j, j, i]
        for i in lane_range(STAGES):
            change = _at_stages(x[j], y[j], i)
            nodes[r, i] = arrays.before[j, i] + change
            scaled_change = change * inverse_scale
            nodes[n, i] = nodes[n, i] + scaled_change * scaled_change


@kernel
def complete_rates(pointer, h):
    """Make the rates of the unknowns in a step of length `h` those from which the latest sweep follows.

    A plain sweep leaves the rates at the stages before it.
    """
    arrays, k = pointer[0].preconditioner, pointer[0].k
    x, y, count = arrays.real, arrays.imaginary, arrays.increment.size
    for j in range(count):
        r = row_of(pointer, j)
        for i in lane_range(STAGES):
            real = imaginary = 0.0
            for c in range(count):
                a = arrays.linear[j, c] + REAL[i] * arrays.quadratic[j, c]
                b = IMAGINARY[i] * arrays.quadratic[j, c]
                real = real + (a * x[c, i] - b * y[c, i])
                imaginary = imaginary + (a * y[c, i] + b * x[c, i])
            arrays.product_real[i], arrays.product_imaginary[i] = real, imaginary
        for i in lane_range(STAGES):
            k[r, i] = k[r, i] + _at_stages(arrays.product_real, arrays.product_imaginary, i) / h


@kernel
def sweep_preconditioned(pointer):
    """Update all stages once, with the change of the unknowns according to the factors."""
    work, arrays = pointer[0], pointer[0].preconditioner
    for j in range(arrays.increment.size):
        r = row_of(pointer, j)
        for i in lane_range(STAGES):
            arrays.before[j, i] = work.nodes[r, i]
    sweep_part(pointer, VELOCITIES)
    eliminate(pointer)
    substitute_back(pointer)
    sweep_part(pointer, POSITIONS)
