"""Generates the code for the pose of a planar machine from its state."""

from .kinematics import Kinematics
from .loops import Solver, equations
from .machine_type import MachineType
from .spanning_tree import ANGLE, RUN, SHIFT_X, SHIFT_Y, Coordinate
from .writer import Lines, number, packed, tupled

_CLOSED = """def closed(mechanism, known, dependent):
    for _ in range({attempts}):
        updated = step(mechanism, known, dependent)
        change = max({changes}, 0.0)
        dependent = updated
        if change < {near}:
            return dependent
    return ({nan},)
"""
ATTEMPTS = 30
NEAR = 1e-8  # rad or m, size of the last Newton step but one: the last step squares the error


class _Placing(Kinematics):
    """Code generator of a pose."""

    def __init__(self, machine: MachineType, *arguments: str):
        super().__init__(machine, Lines(*arguments))
        dependent = machine.dependent
        self.known_groups = [g for g in machine.groups if Coordinate(ANGLE, g) not in dependent]
        self.known_runs = [
            item.of for item in machine.spanning_tree.coordinates if item.kind == RUN and item not in dependent
        ]
        self.roots = [
            (kind, body)
            for body in machine.spanning_tree.roots()
            for kind in (SHIFT_X, SHIFT_Y)
            if Coordinate(kind, body) not in dependent
        ]

    def name(self, item: Coordinate) -> str:
        """Return the name of a coordinate in the generated code."""
        return f"{('angle', 'run', 'x', 'y')[item.kind]}{item.of}"

    def known(self) -> list[str]:
        """Return the names of the initial values for closing the loops."""
        direction_names = [name for g in self.known_groups for name in (f"c{g}", f"s{g}")]
        coordinates = [Coordinate(RUN, j) for j in self.known_runs] + [Coordinate(*root) for root in self.roots]
        return direction_names + [self.name(item) for item in coordinates]

    def place_all(self) -> None:
        """Use the named coordinates as positions."""
        for g in self.machine.groups:
            self.cosine[g], self.sine[g] = f"c{g}", f"s{g}"
        for item in self.spanning_tree.coordinates:
            if item.kind == RUN:
                self.run[item.of] = self.name(item)
        for body in self.spanning_tree.roots():
            self.shift[body] = (f"x{body}", f"y{body}")

    def take_dependent(self) -> None:
        """Name the items of the tuple `dependent`."""
        for i, item in enumerate(self.machine.dependent):
            self.lines.text.append(f"{self.name(item)} = dependent[{i}]")
            if item.kind == ANGLE:
                self.lines.text.append(f"c{item.of}, s{item.of} = direction({self.name(item)})")


def place(machine: MachineType) -> str:
    """Return the code of the family member of that name."""
    write, state = _Placing(machine, "mechanism", "y"), machine.state
    lines, crank = write.lines, Coordinate(ANGLE, machine.spanning_tree.crank)
    lines.text.append(f"time = y[{2 * len(state)}]")
    if not machine.free:
        lines.text.append(f"{write.name(crank)}, rate, _ = driven(mechanism.drive, time)")
        write.rate[crank] = "rate"
    for i, item in enumerate(state):
        lines.text.append(f"{write.name(item)} = y[{i}]")
        write.rate[item] = lines.let(f"y[{len(state) + i}]")
    for g in write.known_groups:
        lines.text.append(f"c{g}, s{g} = direction({write.name(Coordinate(ANGLE, g))})")
    write.place_all()
    if machine.dependent:
        _close(write)
    return lines.function("place", _pose(write))


def _close(write: _Placing) -> None:
    """Write the solution for dependent coordinates and their rates."""
    machine, lines, known_values = write.machine, write.lines, write.known()
    plain_values = tupled([f"plain({name})" for name in known_values])
    angle = lines.let(f"plain({write.name(Coordinate(ANGLE, machine.spanning_tree.crank))})")
    guess = tupled([f"at_angle(mechanism.turn, {1 + i}, {angle})[0]" for i in range(len(machine.dependent))])
    lines.text += [
        f"dependent = closed(mechanism, {plain_values}, {guess})",
        f"dependent = step(mechanism, {tupled(known_values)}, dependent)",
        f"dependent = again(mechanism, {tupled(known_values)}, dependent)",
    ]
    write.take_dependent()
    rows = [equation.columns for equation in equations(write, with_rates=False)]
    solver, right_side = Solver(lines, rows, machine.dependent), []
    for row in rows:
        change = (
            lines.product(value, write.rate[item]) for item, value in row.items() if item not in machine.dependent
        )
        right_side.append(lines.minus(lines.total(*change)))
    write.rate |= solver.solved(right_side)


def _pose(write: _Placing) -> str:
    machine, turns, runs, roots = write.machine, [], [], []
    for g in machine.groups:
        item = Coordinate(ANGLE, g)
        turns.append(f"Turn(c{g}, s{g}, {write.name(item)}, {number(write.rate[item])})")
    for item in machine.spanning_tree.coordinates:
        if item.kind == RUN:
            runs.append(f"({write.name(item)}, {number(write.rate[item])})")
    for body in machine.spanning_tree.roots():
        x, y = Coordinate(SHIFT_X, body), Coordinate(SHIFT_Y, body)
        roots.append(f"(x{body}, y{body}, {number(write.rate[x])}, {number(write.rate[y])})")
    return f"Pose({tupled(turns)}, {tupled(runs)}, {tupled(roots)}, time)"


def step(machine: MachineType) -> str:
    """Return the code of a Newton step towards closed loops."""
    write = _Placing(machine, "mechanism", "known", "dependent")
    lines = write.lines
    for i, name in enumerate(write.known()):
        lines.text.append(f"{name} = known[{i}]")
    write.take_dependent()
    write.place_all()
    loops = equations(write, with_rates=False)
    solver = Solver(lines, [equation.columns for equation in loops], machine.dependent)
    change = solver.solved([equation.value for equation in loops])
    values = [lines.total(write.name(item), lines.minus(change[item])) for item in machine.dependent]
    return lines.function("step", packed(values))


def closed(machine: MachineType) -> str:
    """Return the code that closes nearly closed loops; nan if that fails."""
    count = len(machine.dependent)
    changes = ", ".join(f"abs(updated[{i}] - dependent[{i}])" for i in range(count))
    nan = ", ".join(["math.nan"] * count)
    return _CLOSED.format(attempts=ATTEMPTS, changes=changes, near=NEAR, nan=nan)


def loops(machine: MachineType) -> str:
    """Return the code of the derivatives of all loop equations by the coordinates."""
    write = Kinematics(machine, Lines("mechanism", "pose"))
    write.from_pose()
    rows = [packed([e.columns.get(item) for item in machine.spanning_tree.coordinates]) for e in equations(write)]
    return write.lines.function("loops", tupled(rows))
