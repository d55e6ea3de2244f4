"""Formulas for the pose of a planar machine from its state, with closed loops.

The joints outside the tree give equations for as many of its coordinates, which are `dependent`: not in the state, but
computed from the others, of dyads in closed form, else by Newton's method, which starts from the ideal machine at the
same angle of the crank.  Their rates and accelerations follow from the differentiated equations.  So there is no drift
and no stabilisation.
"""

import itertools
import math

from ....tracing.compiled.dual import Dual, plain, value
from ....tracing.compiled.family import kernel
from ....tracing.compiled.formulas import ZERO, Expr, Program, sum_of
from ..programs import generated
from .drives import drive_motion
from .dyads import Closing
from .form import Orientation, Pose, evaluate_cycle
from .kinematics import PoseProgram
from .loops import Solver, loop_equations_of
from .structure import ANGLE, BEND, INTEGRAL, SHIFT_X, SHIFT_Y, TRAVEL, Coordinate, MachineType, machine_type

ATTEMPTS = 30
CONVERGED = 1e-8  # rad or m, size of the last Newton step but one: the last step squares the error


@generated(machine_type)
def pose_of(machine: MachineType) -> Program:
    """Return the program of `contract.pose_at`."""
    writer, state = PoseProgram(machine, 2), machine.state
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


def _close(writer: PoseProgram) -> None:
    """Solve for dependent coordinates and their rates."""
    machine, program, mechanism = writer.machine, writer.program, writer.mechanism
    crank_angle = program.call(plain, writer.values[Coordinate(ANGLE, machine.spanning_tree.crank)])
    guess = tuple(
        program.call(evaluate_cycle, mechanism.cycle, 1 + i, crank_angle)[0] for i in range(len(machine.dependent))
    )
    if machine.of_dyads:
        Closing(writer, {c: angle for c, angle in zip(machine.dependent, guess, strict=True) if c.kind == ANGLE})
    else:
        known = writer.known_values()
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


def _pose(writer: PoseProgram, time: Expr) -> Pose:
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
    writer = PoseProgram(machine, 3)
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
