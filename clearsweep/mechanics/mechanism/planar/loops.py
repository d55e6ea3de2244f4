"""Closed loops of a planar machine, solved to rounding accuracy at every evaluation.

The joints outside the tree give equations for as many of its coordinates, which are `dependent`: not in the state, but
computed from the others by Newton's method, which starts from the ideal machine at the same angle of the
crank.  Their rates and accelerations follow from the differentiated equations.  So there is no drift and no
stabilisation.
"""

import itertools
from typing import NamedTuple

from .kinematics import Kinematics
from .spanning_tree import ANGLE, Coordinate
from .writer import Lines

Row = dict[Coordinate, str | None]


class Equation(NamedTuple):
    """An equation of a loop: value = 0."""

    value: str | None
    columns: Row  # its derivatives
    bias: str | None  # its second derivative in time without accelerations


def equations(write: Kinematics, *, with_rates: bool = True) -> list[Equation]:
    """Return the equations of all loops; without their bias where rates are not known."""
    lines, closing_rows = write.lines, []
    for j in write.spanning_tree.loop_joints:
        link = write.machine.sites[j].link
        path = write.between(*write.site(j))
        position, columns = write.place(path), write.columns(path)
        bias = write.bias(path) if with_rates else (None, None)
        if not link.slides:
            for k in range(2):
                row = {item: column[k] for item, column in columns.items() if column[k] is not None}
                closing_rows.append(Equation(position[k], row, bias[k]))
            continue
        group, direction = write.spanning_tree.group[link.proximal], write.axis(j)
        normal = write.left(direction)
        row = {item: lines.total(*lines.dot(normal, column)) for item, column in columns.items()}
        terms = [*lines.dot(normal, bias)]
        if group != 0:
            angle = Coordinate(ANGLE, group)
            axial = lines.minus(lines.total(*lines.dot(direction, position)))
            row[angle] = lines.total(row.get(angle), axial)
            if with_rates:
                rate = lines.total(*lines.dot(direction, write.combination(columns, write.rate)))
                terms.append(lines.minus(lines.product("2.0", write.rate[angle], rate)))
        closing_rows.append(Equation(lines.total(*lines.dot(normal, position)), row, lines.total(*terms)))
    return closing_rows


class Solver:
    """Solution of the linear loop equations for dependent coordinates, by blocks of coupled equations."""

    def __init__(self, lines: Lines, rows: list[Row], dependent: tuple[Coordinate, ...]):
        self.lines, self.rows = lines, rows
        self.blocks = [(block, unknown, self._inverse(block, unknown)) for block, unknown in _blocks(rows, dependent)]

    def _inverse(self, block: tuple[int, ...], unknown: tuple[Coordinate, ...]) -> dict:
        """Return the inverse of the matrix of some equations and unknowns, by minors: entries (unknown, equation)."""
        lines, minors = self.lines, {}

        def minor(rows: tuple[int, ...], among: tuple[Coordinate, ...]) -> str | None:
            if not rows:
                return "1.0"
            if (rows, among) not in minors:
                terms = []
                for k, item in enumerate(among):
                    remainder = minor(rows[1:], among[:k] + among[k + 1 :])
                    term = lines.product(self.rows[rows[0]].get(item), remainder)
                    terms.append(term if k % 2 == 0 else lines.minus(term))
                minors[rows, among] = lines.total(*terms)
            return minors[rows, among]

        scale = lines.let(f"1.0 / {minor(block, unknown)}")
        inverse = {}
        for (i, row), (k, item) in itertools.product(enumerate(block), enumerate(unknown)):
            cofactor = lines.product(minor(block[:i] + block[i + 1 :], unknown[:k] + unknown[k + 1 :]), scale)
            inverse[item, row] = lines.let(cofactor if (i + k) % 2 == 0 else lines.minus(cofactor))
        return inverse

    def solved(self, right_side: list[str | None]) -> dict[Coordinate, str | None]:
        """Return the unknowns for right-hand sides, one for each equation."""
        lines = self.lines
        solution: dict[Coordinate, str | None] = {}
        for block, unknown, inverse in self.blocks:
            left_side = {}
            for row in block:
                known_values = (lines.product(self.rows[row].get(item), value) for item, value in solution.items())
                left_side[row] = lines.total(right_side[row], *map(lines.minus, known_values))
            for item in unknown:
                solution[item] = lines.total(*(lines.product(inverse[item, row], left_side[row]) for row in block))
        return solution

    def transposed(self, right_side: dict[Coordinate, str | None]) -> list[str | None]:
        """Return the multipliers, one for each equation, from the transposed equations."""
        lines = self.lines
        solution: dict[int, str | None] = {}
        for block, unknown, inverse in reversed(self.blocks):
            left_side = {}
            for item in unknown:
                known_values = (lines.product(self.rows[row].get(item), value) for row, value in solution.items())
                left_side[item] = lines.total(right_side[item], *map(lines.minus, known_values))
            for row in block:
                solution[row] = lines.total(*(lines.product(inverse[item, row], left_side[item]) for item in unknown))
        return [solution[row] for row in range(len(self.rows))]


def _blocks(rows: list[Row], dependent: tuple[Coordinate, ...]) -> list[tuple[tuple[int, ...], tuple[Coordinate, ...]]]:
    """Return blocks of equations with as many new unknowns as equations, smallest first."""
    left_side, known_values, blocks = list(range(len(rows))), set(), []
    while left_side:
        for candidate in (
            subset for size in range(1, len(left_side) + 1) for subset in itertools.combinations(left_side, size)
        ):
            unknown = {
                item for row in candidate for item in rows[row] if item in dependent and item not in known_values
            }
            if len(unknown) == len(candidate):
                break
        blocks.append((candidate, tuple(item for item in dependent if item in unknown)))
        known_values |= unknown
        left_side = [row for row in left_side if row not in candidate]
    return blocks
