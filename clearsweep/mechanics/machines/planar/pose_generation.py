"""Formulas for the pose of a planar machine from its state, whose loops are closed by Newton's method."""

import itertools
import math

from ....tracing.compiled import calculus
from ....tracing.compiled.dual import Dual, plain, value
from ....tracing.compiled.family import kernel
from ....tracing.compiled.formulas import ZERO, Expr, Program, sum_of
from ..programs import generated
from .cycle import evaluate_cycle
from .drive import drive_motion
from .expressions import PlaneVector
from .kinematics import Bodies, Kinematics
from .loops import Solver, loop_equations_of
from .machine_type import MachineType, machine_type
from .pose import Orientation, Pose
from .spanning_tree import ANGLE, SHIFT_X, SHIFT_Y, TRAVEL, Coordinate

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
        self.known = [coordinate for coordinate in known if coordinate not in machine.dependent]

    def take(self, coordinate: Coordinate, value: Expr) -> None:
        """Take the value of a coordinate."""
        self.values[coordinate] = value
        if coordinate.kind == ANGLE:
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

    def known_values(self) -> tuple[Expr, ...]:
        """Return the numbers with which the loops are closed: directions, then other coordinates."""
        angles = [coordinate.owner for coordinate in self.known if coordinate.kind == ANGLE]
        directions = [component for g in angles for component in (self.cosine[g], self.sine[g])]
        return (*directions, *(self.values[coordinate] for coordinate in self.known if coordinate.kind != ANGLE))


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
    return Pose(tuple(orientations), tuple(travels), tuple(roots), time)


@generated(machine_type)
def newton_step(machine: MachineType) -> Program:
    """Return the program of a Newton step towards closed loops, from a mechanism, known and dependent coordinates."""
    writer = _PoseProgram(machine, 3)
    _, known, dependent = writer.program.parameters
    numbers = map(known.__getitem__, itertools.count())
    for coordinate in writer.known:
        if coordinate.kind == ANGLE:
            writer.cosine[coordinate.owner], writer.sine[coordinate.owner] = next(numbers), next(numbers)
        else:
            writer.values[coordinate] = next(numbers)
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
