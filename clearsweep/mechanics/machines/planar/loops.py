"""Equations of the closed loops of a planar machine, and their solution for the dependent coordinates."""

import itertools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ....tracing.compiled.formulas import ONE, ZERO, Expr, Program, constant, sum_of
from ..programs import NO_VECTOR, generated
from .kinematics import Bodies, Kinematics, Row
from .structure import ANGLE, Coordinate, MachineType, machine_type

SINGULAR = 1e-6  # square of the determinant over the lengths of its rows, near which loops follow the ideal machine


class Equation(NamedTuple):
    """An equation of a loop: value = 0."""

    value: Expr
    columns: Row  # its derivatives
    bias: Expr  # its second derivative in time without accelerations


def loop_equations_of(kinematics: Kinematics, *, with_rates: bool = True) -> list[Equation]:
    """Return the equations of all loops; without their bias if rates are unknown."""
    joints = kinematics.spanning_tree.loop_joints
    return [equation for j in joints for equation in equations_of_joint(kinematics, j, with_rates=with_rates)]


def equations_of_joint(kinematics: Kinematics, j: int, *, with_rates: bool) -> list[Equation]:
    """Return the equations of a joint that closes a loop."""
    link = kinematics.machine.sites[j].link
    if link.geared:
        return [_gear_equation(kinematics, j)]
    if link.slides:
        return [_guide_equation(kinematics, j, with_rates)]
    return _pin_equations(kinematics, j, with_rates)


def _pin_equations(kinematics: Kinematics, j: int, with_rates: bool) -> list[Equation]:
    """Return the equations of a pin: both of its points are at the same position."""
    path = kinematics.gap(j)
    position, columns = kinematics.position(path), kinematics.columns(path)
    bias = kinematics.bias(path) if with_rates else NO_VECTOR
    rows = ({coordinate: getattr(column, axis) for coordinate, column in columns.items()} for axis in "xy")
    return [
        Equation(value, {coordinate: entry for coordinate, entry in row.items() if entry != ZERO}, bias_term)
        for value, row, bias_term in zip(position, rows, bias, strict=True)
    ]


def _guide_equation(kinematics: Kinematics, j: int, with_rates: bool) -> Equation:
    """Return the equation of a guide: the distal point is on the line through the proximal one."""
    path, group = kinematics.gap(j), kinematics.spanning_tree.group[kinematics.machine.sites[j].link.proximal]
    position, columns = kinematics.position(path), kinematics.columns(path)
    bias = kinematics.bias(path) if with_rates else NO_VECTOR
    direction = kinematics.axis(j)
    normal = direction.left()
    row = {coordinate: normal.dot(column) for coordinate, column in columns.items()}
    terms = [*normal.products(bias)]
    if group != 0:
        angle = Coordinate(ANGLE, group)
        row[angle] = row.get(angle, ZERO) - direction.dot(position)
        if with_rates:
            sliding_rate = direction.dot(kinematics.velocity(path))
            terms.append(-(2.0 * kinematics.rate[angle] * sliding_rate))
    return Equation(normal.dot(position), row, sum_of(terms))


def _gear_equation(kinematics: Kinematics, j: int) -> Equation:
    """Return the equation of a gear: the sum of the angles of its bodies, each times its share, is constant."""
    shares = kinematics.shares(j)
    angles = [share * kinematics.turned[group] for group, share in shares]
    row: Row = {}
    for group, share in shares:
        coordinate = Coordinate(ANGLE, group)
        row[coordinate] = row.get(coordinate, ZERO) + share
    return Equation(sum_of([*angles, -kinematics.mechanism.joints[j].rest]), row, ZERO)


class Solver:
    """Solution of the linear loop equations for dependent coordinates, by blocks of coupled equations.

    branches : the equations pass singular positions, near which the solution tends to a predicted one
    """

    def __init__(self, rows: Sequence[Row], dependent: tuple[Coordinate, ...], *, branches: bool = False):
        self.rows, self.branches = rows, branches
        self.blocks = [(block, unknown, self._inverse(block, unknown)) for block, unknown in _blocks(rows, dependent)]

    def _inverse(self, block: tuple[int, ...], unknown: tuple[Coordinate, ...]) -> dict:
        """Return the inverse of the matrix of some equations and unknowns, by minors: entries (unknown, equation)."""
        minors: dict[tuple, Expr] = {}

        def minor(rows: tuple[int, ...], columns: tuple[Coordinate, ...]) -> Expr:
            if not rows:
                return ONE
            if (rows, columns) not in minors:
                terms = []
                for k, coordinate in enumerate(columns):
                    entry, cofactor = self._entry(rows[0], coordinate), minor(rows[1:], columns[:k] + columns[k + 1 :])
                    terms.append(entry * cofactor if k % 2 == 0 else -(entry * cofactor))
                minors[rows, columns] = sum_of(terms)
            return minors[rows, columns]

        determinant = minor(block, unknown)
        scale = 1.0 / determinant
        if self.branches:
            entries = [self._entry(row, coordinate) for row, coordinate in itertools.product(block, unknown)]
            square = sum_of(entry * entry for entry in entries)
            size = constant(SINGULAR)
            for _ in block:
                size = size * square
            scale = (determinant * (1.0 / sum_of([determinant * determinant, size]))).assigned()
        inverse = {}
        for (i, row), (k, coordinate) in itertools.product(enumerate(block), enumerate(unknown)):
            entry = minor(block[:i] + block[i + 1 :], unknown[:k] + unknown[k + 1 :]) * scale
            inverse[coordinate, row] = (entry if (i + k) % 2 == 0 else -entry).assigned()
        return inverse

    def _entry(self, row: int, coordinate: Coordinate) -> Expr:
        """Return the derivative of an equation by a coordinate."""
        return self.rows[row].get(coordinate, ZERO)

    def solve(self, right_side: Sequence[Expr], predicted: Row | None = None) -> Row:
        """Return the unknowns for right-hand sides, one for each equation, and predicted unknowns, 0 unless given."""
        predicted = predicted or {}
        solution: Row = {}
        for block, unknown, inverse in self.blocks:
            residual = {}
            for row in block:
                known = solution | {coordinate: predicted[coordinate] for coordinate in unknown if predicted}
                eliminated = [-(self._entry(row, coordinate) * value) for coordinate, value in known.items()]
                residual[row] = sum_of([right_side[row], *eliminated])
            for coordinate in unknown:
                terms = [inverse[coordinate, row] * residual[row] for row in block]
                solution[coordinate] = sum_of([predicted.get(coordinate, ZERO), *terms])
        return solution

    def solve_transposed(self, right_side: Mapping[Coordinate, Expr]) -> list[Expr]:
        """Return the multipliers, one for each equation, from the transposed equations."""
        solution: dict[int, Expr] = {}
        for block, unknown, inverse in reversed(self.blocks):
            residual = {}
            for coordinate in unknown:
                eliminated = [-(self._entry(row, coordinate) * value) for row, value in solution.items()]
                residual[coordinate] = sum_of([right_side[coordinate], *eliminated])
            for row in block:
                solution[row] = sum_of(inverse[coordinate, row] * residual[coordinate] for coordinate in unknown)
        return [solution[row] for row in range(len(self.rows))]


def _blocks(
    rows: Sequence[Row], dependent: tuple[Coordinate, ...]
) -> list[tuple[tuple[int, ...], tuple[Coordinate, ...]]]:
    """Return blocks of equations with as many new unknowns as equations, smallest first."""
    open_rows, solved, blocks = list(range(len(rows))), set(), []
    while open_rows:
        for candidate in (
            subset for size in range(1, len(open_rows) + 1) for subset in itertools.combinations(open_rows, size)
        ):
            unknown = {
                coordinate
                for row in candidate
                for coordinate in rows[row]
                if coordinate in dependent and coordinate not in solved
            }
            if len(unknown) == len(candidate):
                break
        blocks.append((candidate, tuple(coordinate for coordinate in dependent if coordinate in unknown)))
        solved |= unknown
        open_rows = [row for row in open_rows if row not in candidate]
    return blocks


@generated(machine_type)
def loop_jacobian(machine: MachineType) -> Program:
    """Return the program of the derivatives of all loop equations by the coordinates, from a mechanism and its pose."""
    bodies = Bodies(machine)
    return bodies.program.returns(
        tuple(
            tuple(equation.columns.get(coordinate, ZERO) for coordinate in machine.spanning_tree.coordinates)
            for equation in loop_equations_of(bodies)
        )
    )
