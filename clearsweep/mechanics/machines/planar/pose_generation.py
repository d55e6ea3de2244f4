"""Generates the code for the pose of a planar machine from its state."""

from .expressions import ZERO, FunctionCode, PlaneVector, sum_of, tuple_code
from .kinematics import Kinematics
from .loops import Solver, loop_equations_of
from .machine_type import MachineType
from .spanning_tree import ANGLE, SHIFT_X, SHIFT_Y, TRAVEL, Coordinate

_CLOSE_LOOPS = """def close_loops(mechanism, known, dependent):
    for _ in range({attempts}):
        updated = newton_step(mechanism, known, dependent)
        change = max({changes}, 0.0)
        dependent = updated
        if change < {tolerance}:
            return dependent
    return ({nan},)
"""
ATTEMPTS = 30
CONVERGED = 1e-8  # rad or m, size of the last Newton step but one: the last step squares the error


class _PoseCode(Kinematics):
    """Code generator of a pose."""

    def __init__(self, machine: MachineType, *arguments: str):
        super().__init__(machine, FunctionCode(*arguments))
        dependent = machine.dependent
        self.known_groups = [g for g in machine.groups if Coordinate(ANGLE, g) not in dependent]
        self.known_runs = [
            coordinate.owner
            for coordinate in machine.spanning_tree.coordinates
            if coordinate.kind == TRAVEL and coordinate not in dependent
        ]
        self.roots = [
            (kind, body)
            for body in machine.spanning_tree.roots()
            for kind in (SHIFT_X, SHIFT_Y)
            if Coordinate(kind, body) not in dependent
        ]

    def name(self, coordinate: Coordinate) -> str:
        """Return the name of a coordinate in the generated code."""
        return f"{('angle', 'travel', 'x', 'y')[coordinate.kind]}{coordinate.owner}"

    def known_names(self) -> list[str]:
        """Return the names of the initial values for closing the loops."""
        direction_names = [name for g in self.known_groups for name in (f"c{g}", f"s{g}")]
        coordinates = [Coordinate(TRAVEL, j) for j in self.known_runs] + [Coordinate(*root) for root in self.roots]
        return direction_names + [self.name(coordinate) for coordinate in coordinates]

    def use_names(self) -> None:
        """Take the positions of all bodies from the coordinates by their names."""
        variable = self.code.expression
        for g in self.machine.groups:
            self.cosine[g], self.sine[g] = variable(f"c{g}"), variable(f"s{g}")
        for coordinate in self.spanning_tree.coordinates:
            if coordinate.kind == TRAVEL:
                self.travel[coordinate.owner] = variable(self.name(coordinate))
        for body in self.spanning_tree.roots():
            self.shift[body] = PlaneVector(variable(f"x{body}"), variable(f"y{body}"))

    def name_dependent(self) -> None:
        """Name the items of the tuple `dependent`."""
        for i, coordinate in enumerate(self.machine.dependent):
            self.code.write(f"{self.name(coordinate)} = dependent[{i}]")
            if coordinate.kind == ANGLE:
                self.code.write(f"c{coordinate.owner}, s{coordinate.owner} = direction({self.name(coordinate)})")


def pose_code(machine: MachineType) -> str:
    """Return the code of the family member of that name."""
    pose_writer, state = _PoseCode(machine, "mechanism", "y"), machine.state
    code, crank = pose_writer.code, Coordinate(ANGLE, machine.spanning_tree.crank)
    code.write(f"time = y[{2 * len(state)}]")
    if not machine.free:
        code.write(f"{pose_writer.name(crank)}, rate, _ = drive_motion(mechanism.drive, time)")
        pose_writer.rate[crank] = code.expression("rate")
    for i, coordinate in enumerate(state):
        code.write(f"{pose_writer.name(coordinate)} = y[{i}]")
        pose_writer.rate[coordinate] = code.assign(f"y[{len(state) + i}]")
    for g in pose_writer.known_groups:
        code.write(f"c{g}, s{g} = direction({pose_writer.name(Coordinate(ANGLE, g))})")
    pose_writer.use_names()
    if machine.dependent:
        _write_closure(pose_writer)
    return code.function("pose_at", _pose_expression(pose_writer))


def _write_closure(pose_writer: _PoseCode) -> None:
    """Write the solution for dependent coordinates and their rates."""
    machine, code, known_names = pose_writer.machine, pose_writer.code, pose_writer.known_names()
    plain_values = tuple_code(f"plain({name})" for name in known_names)
    crank_angle = code.call("plain", pose_writer.name(Coordinate(ANGLE, machine.spanning_tree.crank)))
    guess = tuple_code(
        f"evaluate_cycle(mechanism.cycle, {1 + i}, {crank_angle})[0]" for i in range(len(machine.dependent))
    )
    code.write(f"dependent = close_loops(mechanism, {plain_values}, {guess})")
    code.write(f"dependent = newton_step(mechanism, {tuple_code(known_names)}, dependent)")
    code.write(f"dependent = extra_newton_step(mechanism, {tuple_code(known_names)}, dependent)")
    pose_writer.name_dependent()
    loop_rows = [equation.columns for equation in loop_equations_of(pose_writer, with_rates=False)]
    solver = Solver(loop_rows, machine.dependent, branches=machine.branches)
    crank = Coordinate(ANGLE, machine.spanning_tree.crank)
    slopes, _ = pose_writer.predicted_rates(pose_writer.name(crank))
    changes = [
        sum_of(
            entry * pose_writer.rate[coordinate]
            for coordinate, entry in row.items()
            if coordinate not in machine.dependent
        )
        for row in loop_rows
    ]
    predicted = {coordinate: slope * pose_writer.rate[crank] for coordinate, slope in slopes.items()}
    pose_writer.rate |= solver.solve([-change for change in changes], predicted)


def _pose_expression(pose_writer: _PoseCode) -> str:
    """Return the code of the Pose."""
    machine, rate, turns, runs, roots = pose_writer.machine, pose_writer.rate, [], [], []
    for g in machine.groups:
        coordinate = Coordinate(ANGLE, g)
        turns.append(f"Orientation(c{g}, s{g}, {pose_writer.name(coordinate)}, {rate[coordinate]})")
    for coordinate in machine.spanning_tree.coordinates:
        if coordinate.kind == TRAVEL:
            runs.append(f"({pose_writer.name(coordinate)}, {rate[coordinate]})")
    for body in machine.spanning_tree.roots():
        x, y = Coordinate(SHIFT_X, body), Coordinate(SHIFT_Y, body)
        roots.append(f"(x{body}, y{body}, {rate[x]}, {rate[y]})")
    return f"Pose({tuple_code(turns)}, {tuple_code(runs)}, {tuple_code(roots)}, time)"


def newton_step_code(machine: MachineType) -> str:
    """Return the code of a Newton step towards closed loops."""
    pose_writer = _PoseCode(machine, "mechanism", "known", "dependent")
    for i, name in enumerate(pose_writer.known_names()):
        pose_writer.code.write(f"{name} = known[{i}]")
    pose_writer.name_dependent()
    pose_writer.use_names()
    loop_equations = loop_equations_of(pose_writer, with_rates=False)
    loop_rows = [equation.columns for equation in loop_equations]
    solver = Solver(loop_rows, machine.dependent, branches=machine.branches)
    change = solver.solve([equation.value for equation in loop_equations])
    updated = [
        pose_writer.code.expression(pose_writer.name(coordinate)) - change[coordinate]
        for coordinate in machine.dependent
    ]
    return pose_writer.code.function("newton_step", tuple_code(updated))


def close_loops_code(machine: MachineType) -> str:
    """Return the code that closes nearly closed loops; nan if that fails."""
    count = len(machine.dependent)
    changes = ", ".join(f"abs(updated[{i}] - dependent[{i}])" for i in range(count))
    nan = ", ".join(["math.nan"] * count)
    return _CLOSE_LOOPS.format(attempts=ATTEMPTS, changes=changes, tolerance=CONVERGED, nan=nan)


def loop_jacobian_code(machine: MachineType) -> str:
    """Return the code of the derivatives of all loop equations by the coordinates."""
    kinematics = Kinematics(machine, FunctionCode("mechanism", "pose"))
    kinematics.from_pose()
    coordinates = machine.spanning_tree.coordinates
    loop_rows = [
        tuple_code(equation.columns.get(coordinate, ZERO) for coordinate in coordinates)
        for equation in loop_equations_of(kinematics)
    ]
    return kinematics.code.function("loop_jacobian", tuple_code(loop_rows))
