"""Generates the code for the pose of a planar machine from its state."""

from .expressions import ZERO, FunctionCode, PlaneVector, sum_of, tuple_code
from .kinematics import Kinematics
from .loops import Solver, equations
from .machine_type import MachineType
from .spanning_tree import ANGLE, RUN, SHIFT_X, SHIFT_Y, Coordinate

_CLOSED = """def closed(mechanism, known, dependent):
    for _ in range({attempts}):
        updated = step(mechanism, known, dependent)
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
            item.owner for item in machine.spanning_tree.coordinates if item.kind == RUN and item not in dependent
        ]
        self.roots = [
            (kind, body)
            for body in machine.spanning_tree.roots()
            for kind in (SHIFT_X, SHIFT_Y)
            if Coordinate(kind, body) not in dependent
        ]

    def name(self, item: Coordinate) -> str:
        """Return the name of a coordinate in the generated code."""
        return f"{('angle', 'run', 'x', 'y')[item.kind]}{item.owner}"

    def known_names(self) -> list[str]:
        """Return the names of the initial values for closing the loops."""
        direction_names = [name for g in self.known_groups for name in (f"c{g}", f"s{g}")]
        coordinates = [Coordinate(RUN, j) for j in self.known_runs] + [Coordinate(*root) for root in self.roots]
        return direction_names + [self.name(item) for item in coordinates]

    def use_names(self) -> None:
        """Take the positions of all bodies from the coordinates by their names."""
        variable = self.code.expression
        for g in self.machine.groups:
            self.cosine[g], self.sine[g] = variable(f"c{g}"), variable(f"s{g}")
        for item in self.spanning_tree.coordinates:
            if item.kind == RUN:
                self.run[item.owner] = variable(self.name(item))
        for body in self.spanning_tree.roots():
            self.shift[body] = PlaneVector(variable(f"x{body}"), variable(f"y{body}"))

    def name_dependent(self) -> None:
        """Name the items of the tuple `dependent`."""
        for i, item in enumerate(self.machine.dependent):
            self.code.write(f"{self.name(item)} = dependent[{i}]")
            if item.kind == ANGLE:
                self.code.write(f"c{item.owner}, s{item.owner} = direction({self.name(item)})")


def place(machine: MachineType) -> str:
    """Return the code of the family member of that name."""
    placing, state = _PoseCode(machine, "mechanism", "y"), machine.state
    code, crank = placing.code, Coordinate(ANGLE, machine.spanning_tree.crank)
    code.write(f"time = y[{2 * len(state)}]")
    if not machine.free:
        code.write(f"{placing.name(crank)}, rate, _ = driven(mechanism.drive, time)")
        placing.rate[crank] = code.expression("rate")
    for i, item in enumerate(state):
        code.write(f"{placing.name(item)} = y[{i}]")
        placing.rate[item] = code.assign(f"y[{len(state) + i}]")
    for g in placing.known_groups:
        code.write(f"c{g}, s{g} = direction({placing.name(Coordinate(ANGLE, g))})")
    placing.use_names()
    if machine.dependent:
        _write_closure(placing)
    return code.function("place", _pose(placing))


def _write_closure(placing: _PoseCode) -> None:
    """Write the solution for dependent coordinates and their rates."""
    machine, code, known_names = placing.machine, placing.code, placing.known_names()
    plain_values = tuple_code(f"plain({name})" for name in known_names)
    crank_angle = code.call("plain", placing.name(Coordinate(ANGLE, machine.spanning_tree.crank)))
    guess = tuple_code(f"at_angle(mechanism.turn, {1 + i}, {crank_angle})[0]" for i in range(len(machine.dependent)))
    code.write(f"dependent = closed(mechanism, {plain_values}, {guess})")
    code.write(f"dependent = step(mechanism, {tuple_code(known_names)}, dependent)")
    code.write(f"dependent = again(mechanism, {tuple_code(known_names)}, dependent)")
    placing.name_dependent()
    loop_rows = [equation.columns for equation in equations(placing, with_rates=False)]
    solver = Solver(loop_rows, machine.dependent)
    changes = [
        sum_of(entry * placing.rate[item] for item, entry in row.items() if item not in machine.dependent)
        for row in loop_rows
    ]
    placing.rate |= solver.solve([-change for change in changes])


def _pose(placing: _PoseCode) -> str:
    """Return the code of the Pose."""
    machine, rate, turns, runs, roots = placing.machine, placing.rate, [], [], []
    for g in machine.groups:
        item = Coordinate(ANGLE, g)
        turns.append(f"Turn(c{g}, s{g}, {placing.name(item)}, {rate[item]})")
    for item in machine.spanning_tree.coordinates:
        if item.kind == RUN:
            runs.append(f"({placing.name(item)}, {rate[item]})")
    for body in machine.spanning_tree.roots():
        x, y = Coordinate(SHIFT_X, body), Coordinate(SHIFT_Y, body)
        roots.append(f"(x{body}, y{body}, {rate[x]}, {rate[y]})")
    return f"Pose({tuple_code(turns)}, {tuple_code(runs)}, {tuple_code(roots)}, time)"


def step(machine: MachineType) -> str:
    """Return the code of a Newton step towards closed loops."""
    placing = _PoseCode(machine, "mechanism", "known", "dependent")
    for i, name in enumerate(placing.known_names()):
        placing.code.write(f"{name} = known[{i}]")
    placing.name_dependent()
    placing.use_names()
    loop_equations = equations(placing, with_rates=False)
    solver = Solver([equation.columns for equation in loop_equations], machine.dependent)
    change = solver.solve([equation.value for equation in loop_equations])
    updated = [placing.code.expression(placing.name(item)) - change[item] for item in machine.dependent]
    return placing.code.function("step", tuple_code(updated))


def closed(machine: MachineType) -> str:
    """Return the code that closes nearly closed loops; nan if that fails."""
    count = len(machine.dependent)
    changes = ", ".join(f"abs(updated[{i}] - dependent[{i}])" for i in range(count))
    nan = ", ".join(["math.nan"] * count)
    return _CLOSED.format(attempts=ATTEMPTS, changes=changes, tolerance=CONVERGED, nan=nan)


def loops(machine: MachineType) -> str:
    """Return the code of the derivatives of all loop equations by the coordinates."""
    kinematics = Kinematics(machine, FunctionCode("mechanism", "pose"))
    kinematics.from_pose()
    coordinates = machine.spanning_tree.coordinates
    loop_rows = [
        tuple_code(equation.columns.get(item, ZERO) for item in coordinates) for equation in equations(kinematics)
    ]
    return kinematics.code.function("loops", tuple_code(loop_rows))
