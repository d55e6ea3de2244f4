"""Generates the code for the accelerations of a planar machine.

Newton's and Euler's equations of all bodies, multiplied by the derivatives of their positions and angles by the
coordinates (Kane 1961; Shabana 2010, "Computational Dynamics", 3rd ed., chapter 4): a symmetric mass matrix, solved by
its LDL factors, which are also generated.  Dependent coordinates contribute through the chain rule.
"""

from .expressions import NO_VECTOR, ONE, ZERO, Expr, PlaneVector, sum_of, tuple_code, vector_sum
from .kinematics import Bodies, Columns, combination
from .ldl import LDL
from .loops import Row, Solver, loop_equations_of
from .machine_type import MachineType
from .spanning_tree import ANGLE, TRAVEL, Coordinate


class Dynamics(Bodies):
    """Mass matrix and generalised forces of the coordinates of the state and the crank's angle."""

    def __init__(self, machine: MachineType, *arguments: str):
        super().__init__(machine, *arguments)
        self.crank = Coordinate(ANGLE, machine.spanning_tree.crank)
        self.unknown = list(machine.state)
        self.independent = list(dict.fromkeys([self.crank, *self.unknown]))
        self.dependent: dict[Coordinate, Row] = {}  # derivatives of dependent coordinates by independent ones
        self.dependent_bias: Row = {}  # accelerations of dependent coordinates from rates only
        if machine.dependent:
            self._differentiate_loops()
        self.paths = {body: self.path_to(body) for body in range(1, machine.bodies)}
        self.tree_columns = {body: self.columns(path) for body, path in self.paths.items()}
        self.reduced: dict[int, Columns] = {body: self.reduce(columns) for body, columns in self.tree_columns.items()}
        self.spins: dict[int, Row] = {
            g: self.dependent.get(Coordinate(ANGLE, g), {Coordinate(ANGLE, g): ONE}) for g in machine.groups
        }

    def _differentiate_loops(self) -> None:
        """Derive the motion of dependent coordinates from the loop equations."""
        loop_equations = loop_equations_of(self)
        loop_rows = [equation.columns for equation in loop_equations]
        solver = Solver(loop_rows, self.machine.dependent, branches=self.machine.branches)
        slopes, curvatures = self.predicted_rates(
            f"pose.orientations[{self.machine.groups.index(self.crank.owner)}].angle"
        )
        self.dependent = {coordinate: {} for coordinate in self.machine.dependent}
        for coordinate in self.independent:
            if any(coordinate in row for row in loop_rows):
                changes = [-row.get(coordinate, ZERO) for row in loop_rows]
                derivatives = solver.solve(changes, slopes if coordinate == self.crank else None)
                for dependent, derivative in derivatives.items():
                    self.dependent[dependent][coordinate] = derivative
        square = self.rate[self.crank] * self.rate[self.crank] if curvatures else ZERO
        predicted = {dependent: curvature * square for dependent, curvature in curvatures.items()}
        self.dependent_bias = solver.solve([-equation.bias for equation in loop_equations], predicted)

    def reduce(self, columns: Columns) -> Columns:
        """Return derivatives by the independent coordinates."""
        reduced = {coordinate: vector for coordinate, vector in columns.items() if coordinate not in self.dependent}
        for dependent in columns:
            for coordinate, derivative in self.dependent.get(dependent, {}).items():
                reduced[coordinate] = reduced.get(coordinate, NO_VECTOR) + derivative * columns[dependent]
        return reduced

    # ------------------------------------------------------------------------------------------ mass matrix

    def entry(self, row: Coordinate, column: Coordinate) -> Expr:
        """Return an entry of the mass matrix."""
        terms = []
        for body, columns in self.reduced.items():
            mass, inertia = self.inertia_of(body)
            if row in columns and column in columns:
                terms.append(mass * self._column_product(body, row, column))
            spins = self.spins.get(self.spanning_tree.group[body], {})
            terms.append(inertia * spins.get(row, ZERO) * spins.get(column, ZERO))
        return sum_of(terms)

    def _column_product(self, body: int, first: Coordinate, second: Coordinate) -> Expr:
        """Return the scalar product of two derivatives of a body's position."""
        columns = self.reduced[body]
        if first != second or columns[first] != self.tree_columns[body].get(first):
            return columns[first].dot(columns[second])
        if first.kind != ANGLE:
            return ONE
        arm = self.paths[body].arms[first.owner]  # its length is independent of its direction
        return arm.dot(arm)

    def with_dependent(self, accelerations: Row) -> Row:
        """Return the accelerations, extended by those of dependent coordinates."""
        extended = dict(accelerations)
        for dependent, row in self.dependent.items():
            terms = [derivative * accelerations.get(coordinate, ZERO) for coordinate, derivative in row.items()]
            extended[dependent] = sum_of([self.dependent_bias[dependent], *terms])
        return extended

    # ------------------------------------------------------------------------------------------ forces

    def forces(self) -> tuple[dict[int, list[PlaneVector]], dict[int, list[Expr]]]:
        """Return the terms of the forces on the bodies and of the moments about their centres of mass."""
        assign, machine = self.code.assign, self.machine
        force: dict[int, list[PlaneVector]] = {body: [] for body in range(machine.bodies)}
        moment: dict[int, list[Expr]] = {body: [] for body in range(machine.bodies)}
        for body in range(1, machine.bodies):
            mass, _ = self.inertia_of(body)
            force[body].append(PlaneVector(ZERO, -(mass * self.code.expression("mechanism.gravity"))))
        for i, j in enumerate(machine.open):
            link, joint = machine.sites[j].link, self.joints[j]
            load = PlaneVector(assign(f"loads[{i}].fx"), assign(f"loads[{i}].fy"))
            endpoints = (
                (link.proximal, joint.near, -load, "moment_proximal"),
                (link.distal, joint.far, load, "moment_distal"),
            )
            for body, point, joint_force, couple in endpoints:
                force[body].append(joint_force)
                moment[body] += [assign(f"loads[{i}].{couple}"), self.moment(body, point, joint_force)]
        for applied in self.applied_loads():
            force[applied.body].append(applied.force)
            moment[applied.body] += [applied.torque, self.moment(applied.body, applied.point, applied.force)]
        return force, moment

    def moment(self, body: int, point: PlaneVector, force: PlaneVector) -> Expr:
        """Return the moment about its centre of mass of a force at a point of a body."""
        return self.to_fixed_frame(self.spanning_tree.group[body], point).cross(force)

    def generalised_forces(self, crank_acceleration: Expr) -> Row:
        """Return the generalised forces of all coordinates, minus inertia terms from rates and from a driven crank."""
        known_accelerations = self.with_dependent(
            {self.crank: crank_acceleration}
        )  # accelerations before those of the coordinates
        force, moment = self.forces()
        terms: dict[Coordinate, list[Expr]] = {coordinate: [] for coordinate in self.independent}
        for body, columns in self.reduced.items():
            mass, inertia = self.inertia_of(body)
            acceleration = self.bias(self.paths[body]) + combination(self.tree_columns[body], known_accelerations)
            net_force = vector_sum([*force[body], -(mass * acceleration)])
            for coordinate, column in columns.items():
                terms[coordinate] += column.products(net_force)
            group = self.spanning_tree.group[body]
            if group != 0:
                net_moment = sum_of(
                    [*moment[body], -(inertia * known_accelerations.get(Coordinate(ANGLE, group), ZERO))]
                )
                for coordinate, derivative in self.spins[group].items():
                    terms[coordinate].append(derivative * net_moment)
        for j in self.machine.sprung:
            terms[Coordinate(TRAVEL, j)].append(-self.tension(j))
        return {coordinate: sum_of(item_terms) for coordinate, item_terms in terms.items()}

    # ------------------------------------------------------------------------------------------ motion

    def motion(self) -> tuple[str, Row]:
        """Return the code of a Motion, and the accelerations of all coordinates."""
        machine, crank = self.machine, self.crank
        alpha = ZERO
        if not (machine.free or machine.steady):
            self.code.write("_, _, alpha = drive_motion(mechanism.drive, pose.time)")
            alpha = self.code.expression("alpha")
        right_side = self.generalised_forces(alpha)
        if machine.free:
            torque = self.code.call("torque_at", "mechanism.drive", self.rate[crank])
            solution = LDL(self.unknown, self.entry).solve(right_side | {crank: right_side[crank] + torque})
        else:
            solution = LDL(self.unknown, self.entry).solve(right_side)
            inertia_terms = [self.entry(crank, coordinate) * solution[coordinate] for coordinate in self.unknown]
            torque = sum_of([*inertia_terms, -right_side[crank]])
        accelerations = tuple_code(solution[coordinate] for coordinate in self.unknown)
        extended = self.with_dependent(solution | ({} if machine.free else {crank: alpha}))
        return f"Motion({accelerations}, {self.output(extended)}, {torque})", extended

    def output(self, accelerations: Row) -> Expr:
        """Return the acceleration of the output."""
        body, point, direction = self.machine.aim
        if point is None:
            return accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)
        path = self.path_to(body, self.code.vector(point))
        return self.acceleration(path, accelerations).dot(self.code.vector(direction))


def accelerate_code(machine: MachineType) -> str:
    """Return the code of the family member of that name."""
    dynamics = Dynamics(machine, "mechanism", "pose", "loads")
    motion, _ = dynamics.motion()
    return dynamics.code.function("accelerate", motion)


def impact_masses_code(machine: MachineType) -> str:
    """Return the code of the family member of that name.

    The mass is 1 / (n^T J M^-1 J^T n), see `contract.impact_masses`; 0 if a gap has no direction.
    Elastic links count as rigid: the mass at a pin would decrease indefinitely with the number of segments.
    """
    dynamics = Dynamics(machine, "mechanism", "pose", "joint_gaps")
    rigid = {Coordinate(TRAVEL, j) for j in machine.sprung}
    unknown = [coordinate for coordinate in dynamics.unknown if coordinate not in rigid]
    mass_matrix = LDL(unknown, dynamics.entry)
    masses = []
    for i, j in enumerate(machine.open):
        if machine.sites[j].link.slides:
            masses.append("0.0")  # no law of a guide needs it
            continue
        gap = PlaneVector(*(dynamics.code.assign(f"joint_gaps[{i}].{axis}") for axis in "xy"))
        columns = dynamics.reduce(dynamics.columns(dynamics.gap(j)))
        impulse = mass_matrix.forward({coordinate: column.dot(gap) for coordinate, column in columns.items()})
        compliance = sum_of(
            impulse[coordinate] * impulse[coordinate] * mass_matrix.inverse[coordinate] for coordinate in unknown
        )
        square = gap.dot(gap)
        masses.append(f"({square} / {compliance} if {compliance} > 0.0 else as_type_of(0.0, {compliance}))")
    return dynamics.code.function("impact_masses", tuple_code(masses))
