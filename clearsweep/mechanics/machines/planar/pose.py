"""Formulas for the pose of a planar machine from its state, with closed loops.

The joints outside the tree give equations for as many of its coordinates, which are `dependent`: not in the state, but
computed from the others by Newton's method, which starts from the ideal machine at the same angle of the
crank.  Their rates and accelerations follow from the differentiated equations.  So there is no drift and no
stabilisation.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ....tracing.compiled import calculus
from ....tracing.compiled.dual import Dual, plain, value
from ....tracing.compiled.family import kernel
from ....tracing.compiled.formulas import ONE, ZERO, Expr, Program, constant, sum_of
from ..programs import NO_VECTOR, PlaneVector, generated
from .drives import drive_motion
from .form import Orientation, Pose, evaluate_cycle
from .kinematics import Bodies, Kinematics, Row
from .structure import ANGLE, BEND, INTEGRAL, SHIFT_X, SHIFT_Y, TRAVEL, Coordinate, MachineType, machine_type

# ---------------------------------------------------------------------------------------------- loops


SINGULAR = 1e-6  # square of the determinant over the lengths of its rows, near which loops follow the ideal machine


class Equation(NamedTuple):
    """An equation of a loop: value = 0."""

    value: Expr
    columns: Row  # its derivatives
    bias: Expr  # its second derivative in time without accelerations


def loop_equations_of(kinematics: Kinematics, *, with_rates: bool = True) -> list[Equation]:
    """Return the equations of all loops; without their bias if rates are unknown."""
    loop_equations: list[Equation] = []
    for j in kinematics.spanning_tree.loop_joints:
        link = kinematics.machine.sites[j].link
        if link.geared:
            loop_equations.append(_gear_equation(kinematics, j))
        elif link.slides:
            loop_equations.append(_guide_equation(kinematics, j, with_rates))
        else:
            loop_equations += _pin_equations(kinematics, j, with_rates)
    return loop_equations


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


# ---------------------------------------------------------------------------------------------- the pose


ATTEMPTS = 30
CONVERGED = 1e-8  # rad or m, size of the last Newton step but one: the last step squares the error


class _PoseProgram(Kinematics):
    """The program of a pose, from values of the coordinates."""

    def __init__(self, machine: MachineType, parameters: int):
        super().__init__(machine, parameters)
        self.values: dict[Coordinate, Expr] = {}
        known = [Coordinate(ANGLE, g) for g in machine.groups]
        known += [coordinate for coordinate in machine.spanning_tree.coordinates if coordinate.kind == TRAVEL]
        known += [Coordinate(kind, body) for body in machine.spanning_tree.roots() for kind in (SHIFT_X, SHIFT_Y)]
        known += [coordinate for coordinate in machine.spanning_tree.coordinates if coordinate.kind == BEND]
        self.known = [coordinate for coordinate in known if coordinate not in machine.dependent]

    def take(self, coordinate: Coordinate, value: Expr) -> None:
        """Take the value of a coordinate."""
        self.values[coordinate] = value
        if coordinate.kind == ANGLE:
            self.turned[coordinate.owner] = value
            direction = self.program.call(calculus.direction, value)
            self.cosine[coordinate.owner], self.sine[coordinate.owner] = direction[0], direction[1]

    def take_dependent(self, dependent: Expr) -> None:
        """Take the values of the dependent coordinates from a tuple."""
        for i, coordinate in enumerate(self.machine.dependent):
            self.take(coordinate, dependent[i])

    def place(self) -> None:
        """Take the positions of all bodies from the values of the coordinates."""
        self.travel = {
            coordinate.owner: value for coordinate, value in self.values.items() if coordinate.kind == TRAVEL
        }
        for body in self.spanning_tree.roots():
            self.shift[body] = PlaneVector(*(self.values[Coordinate(kind, body)] for kind in (SHIFT_X, SHIFT_Y)))
        self.bend = {coordinate: value for coordinate, value in self.values.items() if coordinate.kind == BEND}

    def known_values(self) -> tuple[Expr, ...]:
        """Return the numbers with which the loops are closed: directions, then other coordinates."""
        angles = [coordinate.owner for coordinate in self.known if coordinate.kind == ANGLE]
        directions = [component for g in angles for component in (self.cosine[g], self.sine[g])]
        others = (coordinate for coordinate in self.known if coordinate.kind != ANGLE or self.closes_gears)
        return (*directions, *(self.values[coordinate] for coordinate in others))

    @property
    def closes_gears(self) -> bool:
        """Return whether a loop contains angles themselves, not only their directions."""
        return any(self.machine.sites[j].link.geared for j in self.spanning_tree.loop_joints)


@generated(machine_type)
def pose_of(machine: MachineType) -> Program:
    """Return the program of `contract.pose_at`."""
    writer, state = _PoseProgram(machine, 2), machine.state
    program, y = writer.program, writer.program.parameters[1]
    time, crank = y[2 * len(state)], Coordinate(ANGLE, machine.spanning_tree.crank)
    if not machine.free:
        motion = program.call(drive_motion, writer.mechanism.drive, time)
        writer.take(crank, motion[0])
        writer.rate[crank] = motion[1]
    for i, coordinate in enumerate(state):
        writer.take(coordinate, y[i])
        writer.rate[coordinate] = y[len(state) + i]
    if machine.dependent:
        _close(writer)
    writer.place()
    return program.returns(_pose(writer, time))


def _close(writer: _PoseProgram) -> None:
    """Solve for dependent coordinates and their rates."""
    machine, program, mechanism, known = writer.machine, writer.program, writer.mechanism, writer.known_values()
    crank_angle = program.call(plain, writer.values[Coordinate(ANGLE, machine.spanning_tree.crank)])
    guess = tuple(
        program.call(evaluate_cycle, mechanism.cycle, 1 + i, crank_angle)[0] for i in range(len(machine.dependent))
    )
    plain_values = tuple(program.call(plain, number) for number in known)
    dependent = program.call(close_loops, mechanism, plain_values, guess)
    dependent = program.call(newton_step, mechanism, known, dependent)
    writer.take_dependent(program.call(_extra_newton_step, mechanism, known, dependent))
    writer.place()
    loop_rows = [equation.columns for equation in loop_equations_of(writer, with_rates=False)]
    solver = Solver(loop_rows, machine.dependent, branches=machine.branches)
    crank = Coordinate(ANGLE, machine.spanning_tree.crank)
    slopes, _ = writer.predicted_rates(writer.values[crank])
    changes = [
        sum_of(
            entry * writer.rate[coordinate] for coordinate, entry in row.items() if coordinate not in machine.dependent
        )
        for row in loop_rows
    ]
    predicted = {coordinate: slope * writer.rate[crank] for coordinate, slope in slopes.items()}
    writer.rate |= solver.solve([-change for change in changes], predicted)


def _pose(writer: _PoseProgram, time: Expr) -> Pose:
    """Return the Pose."""
    machine, values, rate = writer.machine, writer.values, writer.rate
    orientations, roots = [], []
    for g in machine.groups:
        angle = Coordinate(ANGLE, g)
        orientations.append(Orientation(writer.cosine[g], writer.sine[g], values[angle], rate[angle]))
    travels = [
        (values[coordinate], rate[coordinate])
        for coordinate in machine.spanning_tree.coordinates
        if coordinate.kind == TRAVEL
    ]
    for body in machine.spanning_tree.roots():
        x, y = Coordinate(SHIFT_X, body), Coordinate(SHIFT_Y, body)
        roots.append((values[x], values[y], rate[x], rate[y]))
    bends = [(values[c], rate[c]) for c in machine.spanning_tree.coordinates if c.kind == BEND]
    integral = rate[Coordinate(INTEGRAL, 0)] if machine.regulated else ZERO
    return Pose(tuple(orientations), tuple(travels), tuple(roots), time, tuple(bends), integral)


@generated(machine_type)
def newton_step(machine: MachineType) -> Program:
    """Return the program of a Newton step towards closed loops, from a mechanism, known and dependent coordinates."""
    writer = _PoseProgram(machine, 3)
    _, known, dependent = writer.program.parameters
    numbers = map(known.__getitem__, itertools.count())
    for coordinate in writer.known:
        if coordinate.kind == ANGLE:
            writer.cosine[coordinate.owner], writer.sine[coordinate.owner] = next(numbers), next(numbers)
    for coordinate in writer.known:
        if coordinate.kind != ANGLE:
            writer.values[coordinate] = next(numbers)
        elif writer.closes_gears:
            writer.turned[coordinate.owner] = next(numbers)
    writer.take_dependent(dependent)
    writer.place()
    loop_equations = loop_equations_of(writer, with_rates=False)
    loop_rows = [equation.columns for equation in loop_equations]
    solver = Solver(loop_rows, machine.dependent, branches=machine.branches)
    change = solver.solve([equation.value for equation in loop_equations])
    return writer.program.returns(
        tuple(writer.values[coordinate] - change[coordinate] for coordinate in machine.dependent)
    )


@kernel
def close_loops(mechanism, known, dependent):
    """Return the dependent coordinates that close nearly closed loops; nan if that fails."""
    for _ in range(ATTEMPTS):
        updated = newton_step(mechanism, known, dependent)
        change = max(*[abs(updated[i] - dependent[i]) for i in range(len(dependent))], 0.0)
        dependent = updated
        if change < CONVERGED:
            return dependent
    return tuple([math.nan for _ in dependent])


@kernel
def _extra_newton_step(mechanism, known, dependent):
    """Return the dependent coordinates after another Newton step if they are differentiated twice."""
    return newton_step(mechanism, known, dependent) if any(isinstance(value(x), Dual) for x in dependent) else dependent


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
