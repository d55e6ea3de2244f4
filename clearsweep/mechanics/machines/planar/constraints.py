"""The constraints of a planar machine without clearance in absolute coordinates, and the positions that satisfy them.

Joints are described by numbers, so one compiled code serves all machines.  The coordinates are x, y of the centre of
mass and the angle of every moving body; there are as many constraints.  The last one is the crank's angle.
"""

import math
from typing import NamedTuple

import numpy as np

from ....tracing.compiled.choosing import direction, lane_range, rolled_range
from ....tracing.compiled.family import Routine, inlined, kernel, shaped
from ....tracing.memory import Fields

NO_DIRECTION = (0.0, 0.0)
LANES = 8  # numbers of a row that are processed together
MAX_ITERATIONS = 30  # of Newton's method
QUADRATIC_STEP = 1e-9  # of the machine's size, by which the last step of Newton's method moves
ACCURACY = 1e-11  # of the machine's size: largest constraint at a solution
ROUNDING = 1e-16  # of the machine's size: constraints that a step of Newton's method does not reduce


class Constraint(Fields):
    """The distance of two points along a direction, or a sum of angles, minus an offset.

    The ground is body 0.
    """

    proximal: float  # number of a body
    near_x: float  # m, its point, in its frame from the centre of mass
    near_y: float
    distal: float  # the other body
    far_x: float
    far_y: float
    along_x: float  # direction of the distance, or NO_DIRECTION of an angle
    along_y: float
    turns: float  # 1: the direction is in the frame of the proximal body; 0: fixed
    offset: float  # m or rad
    proximal_share: float  # of an angle: factors on the angles of both bodies; minus their sum is that of the carrier
    distal_share: float
    carrier: float  # a third body


class Workspace(NamedTuple):
    """Constraints, and one position of a machine."""

    constraints: Constraint  # (n,)
    position: np.ndarray  # (3 + n,) m, m, rad of all bodies, the ground first
    rates: np.ndarray  # (3 + n,) their derivatives by the crank's angle
    directions: np.ndarray  # (bodies, 2) cosine and sine of the angles of all bodies
    values: np.ndarray  # (n,) the constraints
    matrix: np.ndarray  # (n, width) their derivatives by the coordinates, then a unit matrix, then zeros


@inlined
def row_width(size):
    """Return the length of a row of `Workspace.matrix` for `size` coordinates."""
    return (2 * size + LANES - 1) // LANES * LANES


@kernel
def _constraint_at(work, row):
    """Return both ends of a constraint from its proximal body, its direction and the levers (x, y) of its points."""
    constraint = work.constraints[row]
    proximal, distal = int(constraint.proximal), int(constraint.distal)
    c, s = work.directions[proximal, 0], work.directions[proximal, 1]
    near_x, near_y = c * constraint.near_x - s * constraint.near_y, s * constraint.near_x + c * constraint.near_y
    along_x, along_y = constraint.along_x, constraint.along_y
    if constraint.turns != 0.0:
        along_x, along_y = c * along_x - s * along_y, s * along_x + c * along_y
    c, s = work.directions[distal, 0], work.directions[distal, 1]
    far_x, far_y = c * constraint.far_x - s * constraint.far_y, s * constraint.far_x + c * constraint.far_y
    return (proximal, distal), (along_x, along_y), (near_x, near_y), (far_x, far_y)


@inlined
def _put_derivatives(work, row, body, derivatives):
    """Write the derivatives of a constraint by the coordinates of a body, unless that is the ground."""
    if body > 0:
        for i in range(3):
            work.matrix[row, 3 * body - 3 + i] = derivatives[i]


@kernel
def write_constraints(work, angle):
    """Write the constraints at a position and their derivatives; angle : rad, of the crank."""
    position, matrix, size = work.position, work.matrix, work.values.size
    for body in rolled_range(work.directions.shape[0]):
        work.directions[body, 0], work.directions[body, 1] = direction(position[3 * body + 2])
    for row in rolled_range(size):
        for block in rolled_range(matrix.shape[1] // LANES):
            for i in lane_range(LANES):
                matrix[row, LANES * block + i] = 0.0
        matrix[row, size + row] = 1.0
        (proximal, distal), (c, s), near, far = _constraint_at(work, row)
        x = (position[3 * distal] + far[0]) - (position[3 * proximal] + near[0])
        y = (position[3 * distal + 1] + far[1]) - (position[3 * proximal + 1] + near[1])
        value = c * x + s * y
        if c == 0.0 and s == 0.0:
            near_share, far_share = work.constraints[row].proximal_share, work.constraints[row].distal_share
            carrier = int(work.constraints[row].carrier)
            value = far_share * position[3 * distal + 2] + near_share * position[3 * proximal + 2]
            value -= (near_share + far_share) * position[3 * carrier + 2]
            _put_derivatives(work, row, carrier, (0.0, 0.0, -(near_share + far_share)))
            _put_derivatives(work, row, proximal, (0.0, 0.0, near_share))
            _put_derivatives(work, row, distal, (0.0, 0.0, far_share))
        else:
            rotation_term = work.constraints[row].turns * (c * y - s * x)
            _put_derivatives(work, row, proximal, (-c, -s, rotation_term - (s * near[0] - c * near[1])))
            _put_derivatives(work, row, distal, (c, s, s * far[0] - c * far[1]))
        work.values[row] = value - work.constraints[row].offset
    work.values[size - 1] -= angle


@kernel
def write_curvature(work):
    """Write the terms without accelerations of the second derivatives of the constraints to their values."""
    position, rates = work.position, work.rates
    for row in rolled_range(work.values.size):
        (proximal, distal), (c, s), near, far = _constraint_at(work, row)
        proximal_rate, distal_rate = rates[3 * proximal + 2], rates[3 * distal + 2]
        ddx = proximal_rate * proximal_rate * near[0] - distal_rate * distal_rate * far[0]
        ddy = proximal_rate * proximal_rate * near[1] - distal_rate * distal_rate * far[1]
        curvature = c * ddx + s * ddy
        if work.constraints[row].turns != 0.0:
            x = (position[3 * distal] + far[0]) - (position[3 * proximal] + near[0])
            y = (position[3 * distal + 1] + far[1]) - (position[3 * proximal + 1] + near[1])
            dx = (rates[3 * distal] - distal_rate * far[1]) - (rates[3 * proximal] - proximal_rate * near[1])
            dy = (rates[3 * distal + 1] + distal_rate * far[0]) - (rates[3 * proximal + 1] + proximal_rate * near[0])
            curvature += 2.0 * proximal_rate * (c * dy - s * dx) - proximal_rate * proximal_rate * (c * x + s * y)
        work.values[row] = curvature


@kernel
def invert(work):
    """Replace the unit matrix by the inverse of the derivatives; return the sign of their determinant, 0 if singular.

    Elimination by Gauss and Jordan with row pivoting.
    """
    matrix, size, blocks, sign = work.matrix, work.values.size, work.matrix.shape[1] // LANES, 1.0
    for k in rolled_range(size):
        pivot_row, pivot = k, matrix[k, k]
        for row in rolled_range(k + 1, size):
            if abs(matrix[row, k]) > abs(pivot):
                pivot_row, pivot = row, matrix[row, k]
        sign *= math.copysign(1.0, pivot if pivot_row == k else -pivot)
        if not abs(pivot) > 0.0:
            return 0.0
        inverse_pivot = 1.0 / pivot
        for block in rolled_range(blocks):
            for i in lane_range(LANES):
                exchanged = matrix[k, LANES * block + i]
                matrix[k, LANES * block + i] = matrix[pivot_row, LANES * block + i] * inverse_pivot
                if pivot_row != k:
                    matrix[pivot_row, LANES * block + i] = exchanged
        for row in rolled_range(size):
            factor = matrix[row, k]
            if row != k and factor != 0.0:
                for block in rolled_range(blocks):
                    for i in lane_range(LANES):
                        column = LANES * block + i
                        matrix[row, column] = matrix[row, column] - factor * matrix[k, column]
    return sign


@kernel
def product_with_values(work, row):
    """Return the product of a row of the inverse and the values of the constraints."""
    size, value = work.values.size, 0.0
    for k in rolled_range(size):
        value += work.matrix[row, size + k] * work.values[k]
    return value


@kernel
def largest_constraint(work):
    """Return the size of the largest constraint (m or rad), inf if one is nan."""
    largest = 0.0
    for row in rolled_range(work.values.size):
        size = abs(work.values[row])
        largest = max(largest, size) if size < math.inf else math.inf
    return largest


@kernel
def close_position(work, angle, size):
    """Satisfy the constraints at a crank `angle` (rad) by Newton's method from a close position.

    size : m, of the machine.  Return the sign of the determinant of the derivatives, nan if there is no solution.
    The position stays where the derivatives are singular, or the constraints as small as their rounding.
    """
    count = work.values.size
    for _ in rolled_range(MAX_ITERATIONS):
        write_constraints(work, angle)
        if largest_constraint(work) <= ROUNDING * size or invert(work) == 0.0:
            break
        step = 0.0
        for row in rolled_range(count):
            change = product_with_values(work, row)
            work.position[3 + row] -= change
            step = max(step, abs(change)) if abs(change) < math.inf else math.inf
        # the error after a step of Newton's method is of the order of its square
        if step < QUADRATIC_STEP * min(size, 1.0) or step == math.inf:
            break
    write_constraints(work, angle)
    sign = invert(work)
    return sign if largest_constraint(work) < ACCURACY * max(size, 1.0) else math.nan


def _close(settings, constraints, angles, q, first, second, inverse, signs, scratch, count):
    """Close a machine at `count` crank angles and differentiate its position; arrays are bare pointers.

    settings : size of the machine (m), number n of coordinates; constraints : (n, Constraint.SIZE); angles : (count,)
    rad; q : (count, n) guesses, then positions, nan where there are none; first, second : (count, n) their derivatives
    by the crank's angle; inverse : (count, n, n) of the derivatives of the constraints by the coordinates; signs :
    (count,) of the determinants of these; scratch : (scratch_size(n),) zeros.
    """
    settings = shaped(settings, (2,))
    size, n = settings[0], int(settings[1])
    angles, signs = shaped(angles, (count,)), shaped(signs, (count,))
    q, first, second = shaped(q, (count, n)), shaped(first, (count, n)), shaped(second, (count, n))
    inverse, work = shaped(inverse, (count, n, n)), _workspace(constraints, scratch, n)
    for k in rolled_range(count):
        for i in rolled_range(n):
            work.position[3 + i] = q[k, i]
        signs[k] = close_position(work, angles[k], size)
        for i in rolled_range(n):
            q[k, i] = work.position[3 + i] if abs(signs[k]) <= 1.0 else math.nan
            first[k, i] = work.rates[3 + i] = work.matrix[i, 2 * n - 1]
            for j in rolled_range(n):
                inverse[k, i, j] = work.matrix[i, n + j]
        write_curvature(work)
        for i in rolled_range(n):
            second[k, i] = -product_with_values(work, i)


def _evaluate(settings, constraints, angles, q, values, jacobians, scratch, count):
    """Write the constraints, `values` (count, n), and their derivatives, (count, n, n), at positions `q` (count, n).

    The other arguments are those of `_close`.
    """
    n = int(shaped(settings, (2,))[1])
    angles, q, values = shaped(angles, (count,)), shaped(q, (count, n)), shaped(values, (count, n))
    jacobians, work = shaped(jacobians, (count, n, n)), _workspace(constraints, scratch, n)
    for k in rolled_range(count):
        for i in rolled_range(n):
            work.position[3 + i] = q[k, i]
        write_constraints(work, angles[k])
        for i in rolled_range(n):
            values[k, i] = work.values[i]
            for j in rolled_range(n):
                jacobians[k, i, j] = work.matrix[i, j]


@inlined
def _workspace(constraints, scratch, n):
    """Return the Workspace for `n` coordinates in two arrays; the coordinates of the ground remain 0."""
    width, bodies = row_width(n), n // 3 + 1
    scratch = shaped(scratch, (scratch_size(n),))
    rates, values, directions, matrix = n + 3, 2 * (n + 3), 3 * n + 6, 3 * n + 6 + 2 * bodies
    return Workspace(
        Constraint(shaped(constraints, (n, Constraint.SIZE))),
        scratch[0:rates],
        scratch[rates:values],
        scratch[directions:matrix].reshape(bodies, 2),
        scratch[values:directions],
        scratch[matrix : matrix + n * width].reshape(n, width),
    )


@inlined
def scratch_size(n):
    """Return the size of the scratch for `n` coordinates."""
    return 3 * n + 6 + 2 * (n // 3 + 1) + n * row_width(n)


close = Routine(_close, "fffffffff")
evaluate = Routine(_evaluate, "fffffff")
