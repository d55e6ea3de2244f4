"""Generates the code for the accelerations of a planar machine.

Newton's and Euler's equations of all bodies, multiplied by the derivatives of their places and angles by the
coordinates (Kane 1961; Shabana 2010, "Computational Dynamics", 3rd ed., chapter 4): a symmetric mass matrix, solved by
its LDL factors, which are also generated.  Dependent coordinates contribute through the chain rule.
"""

from .kinematics import Bodies, Columns
from .loops import Solver, equations
from .machine_type import MachineType, Vector
from .spanning_tree import ANGLE, RUN, Coordinate
from .writer import Lines, number, packed, tupled

Matrix = dict[tuple[Coordinate, Coordinate], str | None]
Row = dict[Coordinate, str | None]


def mass_of(lines: Lines, body: int) -> tuple[str, str]:
    """Return mass and moment of inertia of a body."""
    mass, inertia = (lines.let(f"mechanism.bodies[{body - 1}].{key}") for key in ("mass", "inertia"))
    return mass, inertia


class Dynamics(Bodies):
    """Mass matrix and generalised forces of the coordinates of the state and the crank's angle."""

    def __init__(self, machine: MachineType, *arguments: str):
        super().__init__(machine, *arguments)
        self.crank = Coordinate(ANGLE, machine.spanning_tree.crank)
        self.unknown = list(machine.state)
        self.every = list(dict.fromkeys([self.crank, *self.unknown]))
        self.dependent: dict[Coordinate, Row] = {}  # derivatives of dependent coordinates by independent ones
        self.bound_bias: Row = {}
        if machine.dependent:
            self._bind()
        self.paths = {body: self.path_to(body) for body in range(1, machine.bodies)}
        self.tree = {body: self.columns(path) for body, path in self.paths.items()}
        self.moved: dict[int, Columns] = {body: self.unbound(columns) for body, columns in self.tree.items()}
        self.spins: dict[int, Row] = {
            g: self.dependent.get(Coordinate(ANGLE, g), {Coordinate(ANGLE, g): "1.0"}) for g in machine.groups
        }

    def _bind(self) -> None:
        """Derive the motion of dependent coordinates."""
        loops = equations(self)
        rows = [equation.columns for equation in loops]
        solver = Solver(self.lines, rows, self.machine.dependent)
        self.dependent = {item: {} for item in self.machine.dependent}
        for item in self.every:
            if any(item in row for row in rows):
                change = solver.solved([self.lines.minus(row.get(item)) for row in rows])
                for other_item, value in change.items():
                    self.dependent[other_item][item] = value
        self.bound_bias = solver.solved([self.lines.minus(equation.bias) for equation in loops])

    def unbound(self, columns: Columns) -> Columns:
        """Return derivatives by the independent coordinates."""
        independent = {item: vector for item, vector in columns.items() if item not in self.dependent}
        for item in columns:
            for other_item, value in self.dependent.get(item, {}).items():
                independent[other_item] = self.sum(
                    independent.get(other_item, (None, None)), self.scaled(value, columns[item])
                )
        return independent

    def entry(self, first: Coordinate, second: Coordinate) -> str | None:
        """Return an entry of the mass matrix."""
        lines, terms = self.lines, []
        for body, columns in self.moved.items():
            mass, inertia = mass_of(lines, body)
            if first in columns and second in columns:
                squares = lines.dot(columns[first], columns[second])
                if first == second and columns[first] == self.tree[body].get(first):
                    if first.kind == ANGLE:  # the length of an arm is independent of its direction
                        arm = self.paths[body].arms[first.of]
                        squares = lines.dot(arm, arm)
                    else:
                        squares = ("1.0",)
                terms.append(lines.product(mass, lines.total(*squares)))
            spins = self.spins.get(self.spanning_tree.group[body], {})
            terms.append(lines.product(inertia, spins.get(first), spins.get(second)))
        return lines.total(*terms)

    def factored(self) -> tuple[Matrix, dict[Coordinate, str]]:
        """Return the LDL factors of the mass matrix: the part of L below the diagonal, and 1 / D."""
        lines, unknown = self.lines, self.unknown
        lower: Matrix = {}
        scaled: Matrix = {}  # L D
        inverse: dict[Coordinate, str] = {}
        for j, b in enumerate(unknown):
            eliminated = [lines.minus(lines.product(scaled[b, k], lower[b, k])) for k in unknown[:j]]
            inverse[b] = lines.let(f"1.0 / {number(lines.total(self.entry(b, b), *eliminated))}")
            for a in unknown[j + 1 :]:
                eliminated = [lines.minus(lines.product(scaled[a, k], lower[b, k])) for k in unknown[:j]]
                scaled[a, b] = lines.total(self.entry(a, b), *eliminated)
                lower[a, b] = lines.let(lines.product(scaled[a, b], inverse[b]))
        return lower, inverse

    def forward(self, lower: Matrix, right_side: Row) -> Row:
        """Return L^-1 times a column."""
        lines = self.lines
        solution: Row = {}
        for i, a in enumerate(self.unknown):
            eliminated = [lines.minus(lines.product(lower[a, k], solution[k])) for k in self.unknown[:i]]
            solution[a] = lines.total(right_side.get(a), *eliminated)
        return solution

    def solved(self, right_side: Row) -> Row:
        """Return the accelerations of the coordinates for generalised forces."""
        lines = self.lines
        lower, inverse = self.factored()
        left_side = self.forward(lower, right_side)
        accelerations: Row = {}
        for i in range(len(self.unknown) - 1, -1, -1):
            a = self.unknown[i]
            eliminated = [lines.minus(lines.product(lower[k, a], accelerations[k])) for k in self.unknown[i + 1 :]]
            accelerations[a] = lines.total(lines.product(left_side[a], inverse[a]), *eliminated)
        return accelerations

    def with_bound(self, accelerations: Row) -> Row:
        """Return the accelerations, extended by those of dependent coordinates."""
        lines, all_items = self.lines, dict(accelerations)
        for item, row in self.dependent.items():
            parts = (lines.product(value, accelerations.get(other_item)) for other_item, value in row.items())
            all_items[item] = lines.total(self.bound_bias[item], *parts)
        return all_items

    def forces(self) -> tuple[dict[int, list[Vector]], dict[int, list]]:
        """Return the terms of the forces on the bodies and of the moments about their centres of mass."""
        lines, machine = self.lines, self.machine
        force: dict[int, list[Vector]] = {body: [] for body in range(machine.bodies)}
        moment: dict[int, list] = {body: [] for body in range(machine.bodies)}
        for body in range(1, machine.bodies):
            weight = lines.product(mass_of(lines, body)[0], "mechanism.gravity")
            force[body].append((None, lines.minus(weight)))
        for i, j in enumerate(machine.open):
            site = machine.sites[j]
            load = tuple(lines.let(f"loads[{i}].{component}") for component in ("fx", "fy"))
            spring_ends = (
                (site.link.proximal, site.near, self.minus(load), "moment_proximal"),
                (site.link.distal, site.far, load, "moment_distal"),
            )
            for body, point, pull_term, own_values in spring_ends:
                force[body].append(pull_term)
                moment[body] += [lines.let(f"loads[{i}].{own_values}"), self.moment(body, point, pull_term)]
        for body, point, pull_term, torque in self.applied():
            force[body].append(pull_term)
            moment[body] += [torque, self.moment(body, point, pull_term)]
        return force, moment

    def moment(self, body: int, point: Vector, force: Vector) -> str | None:
        """Return the moment about its centre of mass of a force at a point of a body."""
        lines, arm = self.lines, self.turned(self.spanning_tree.group[body], point)
        return lines.total(lines.product(arm[0], force[1]), lines.minus(lines.product(arm[1], force[0])))

    def generalised(self, driven: str | None) -> Row:
        """Return the generalised forces of all coordinates, minus inertia terms from rates and from a driven crank."""
        lines = self.lines
        known_values = self.with_bound(
            {self.crank: driven}
        )  # accelerations that are known before those of the coordinates
        force, moment = self.forces()
        terms: dict[Coordinate, list] = {item: [] for item in self.every}
        for body, columns in self.moved.items():
            mass, inertia = mass_of(lines, body)
            tree = self.tree[body]
            change = self.sum(
                self.bias(self.paths[body]),
                self.combination({i: tree[i] for i in tree if i in known_values}, known_values),
            )
            left_side = self.sum((None, None), *force[body], self.minus(self.scaled(mass, change)))
            for item, column in columns.items():
                terms[item] += lines.dot(column, left_side)
            group = self.spanning_tree.group[body]
            if group != 0:
                spun = lines.minus(lines.product(inertia, known_values.get(Coordinate(ANGLE, group))))
                spins = lines.total(*moment[body], spun)
                for item, value in self.spins[group].items():
                    terms[item].append(lines.product(value, spins))
        for j in self.machine.sprung:
            terms[Coordinate(RUN, j)].append(lines.minus(self.tension(j)))
        return {item: lines.total(*parts) for item, parts in terms.items()}

    def motion(self) -> tuple[str, Row]:
        """Return the code of a Motion, and the accelerations of all coordinates."""
        lines, machine, crank = self.lines, self.machine, self.crank
        alpha = None
        if not (machine.free or machine.steady):
            lines.text.append("_, _, alpha = driven(mechanism.drive, pose.time)")
            alpha = "alpha"
        right_side = self.generalised(alpha)
        if machine.free:
            torque = lines.let(f"torque_at(mechanism.drive, {self.rate[crank]})")
            solution = self.solved(right_side | {crank: lines.total(right_side[crank], torque)})
        else:
            solution = self.solved(right_side)
            coupling_terms = (lines.product(self.entry(crank, item), solution[item]) for item in self.unknown)
            torque = lines.total(*coupling_terms, lines.minus(right_side[crank]))
        accelerations = packed([solution[item] for item in self.unknown])
        all_items = self.with_bound(solution | ({} if machine.free else {crank: alpha}))
        return f"Motion({accelerations}, {number(self.output(all_items))}, {number(torque)})", all_items

    def output(self, accelerations: Row) -> str | None:
        """Return the acceleration of the output."""
        body, point, direction = self.machine.aim
        if point is None:
            return accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]))
        path = self.path_to(body, point)
        acceleration = self.sum(self.bias(path), self.combination(self.columns(path), accelerations))
        return self.lines.total(*self.lines.dot(acceleration, direction))


def accelerate(machine: MachineType) -> str:
    """Return the code of the family member of that name."""
    write = Dynamics(machine, "mechanism", "pose", "loads")
    motion, _ = write.motion()
    return write.lines.function("accelerate", motion)


def impact_masses(machine: MachineType) -> str:
    """Return the code of the family member of that name.

    The mass is 1 / (n^T J M^-1 J^T n), see `contract.impact_masses`; 0 if a gap has no direction.
    Elastic links count as rigid: the mass at a pin would decrease indefinitely with the number of segments.
    """
    write = Dynamics(machine, "mechanism", "pose", "relative")
    prescribed = {Coordinate(RUN, j) for j in machine.sprung}
    write.unknown = [item for item in write.unknown if item not in prescribed]
    lines, masses = write.lines, []
    lower, inverse = write.factored()
    for i, j in enumerate(machine.open):
        if machine.sites[j].link.slides:
            masses.append("0.0")  # no law of a guide needs it
            continue
        gap = tuple(lines.let(f"relative[{i}].{component}") for component in ("x", "y"))
        columns = write.unbound(write.columns(write.between(*write.site(j))))
        right_side = {item: lines.total(*lines.dot(column, gap)) for item, column in columns.items()}
        left_side = write.forward(lower, right_side)
        yielded = lines.total(
            *(lines.product(left_side[item], left_side[item], inverse[item]) for item in write.unknown)
        )
        square = lines.total(*lines.dot(gap, gap))
        masses.append(f"({square} / {yielded} if {yielded} > 0.0 else as_type_of(0.0, {yielded}))")
    return lines.function("impact_masses", tupled(masses))
