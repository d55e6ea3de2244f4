"""Formulas for the accelerations of a planar machine.

Newton's and Euler's equations of all bodies, multiplied by the derivatives of their positions and angles by the
coordinates (Kane 1961; Shabana 2010, "Computational Dynamics", 3rd ed., chapter 4): a symmetric mass matrix, solved by
its LDL factors.  Dependent coordinates contribute through the chain rule.
"""

from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import inlined
from ....tracing.compiled.formulas import ONE, ZERO, Expr, Program, sum_of
from ..contract import Motion
from ..programs import LDL, NO_VECTOR, PlaneVector, generated, vector_sum
from .bent_line import PlaneField
from .drives import drive_motion, integral_rate, torque_at
from .kinematics import BentVector, Bodies, Columns, Row, combination, vector_of
from .loops import Solver, loop_equations_of
from .structure import ANGLE, BEND, CUT, INTEGRAL, TRAVEL, Coordinate, MachineType, machine_type


class Dynamics(Bodies):
    """Mass matrix and generalised forces of the coordinates of the state and the crank's angle."""

    def __init__(self, machine: MachineType, parameters: int = 3):
        super().__init__(machine, parameters)
        self.crank = Coordinate(ANGLE, machine.spanning_tree.crank)
        self.unknown = [coordinate for coordinate in machine.state if coordinate.kind != INTEGRAL]
        cuts = [cut for kind in machine.bent.values() if self.cuts_links for cut in kind.cuts]
        self.independent = list(dict.fromkeys([self.crank, *self.unknown, *cuts]))
        self.dependent: dict[Coordinate, Row] = {}  # derivatives of dependent coordinates by independent ones
        self.dependent_bias: Row = {}  # accelerations of dependent coordinates from rates only
        if machine.dependent:
            self._differentiate_loops()
        self.bend_forces: dict[Coordinate, list[Expr]] = {}  # generalised forces of deformations, see `forces`
        self.paths = {body: self.path_to(body) for body in range(1, machine.bodies)}
        self.tree_columns = {body: self.columns(path) for body, path in self.paths.items()}
        self.reduced: dict[int, Columns] = {body: self.reduce(columns) for body, columns in self.tree_columns.items()}
        self.spins: dict[int, Row] = {
            g: self.dependent.get(Coordinate(ANGLE, g), {Coordinate(ANGLE, g): ONE}) for g in machine.groups
        }
        self.line_columns = {body: self._columns_of_line(body) for body in machine.bent}

    def _columns_of_line(self, body: int) -> dict[Coordinate, PlaneField]:
        """Return the derivatives of the line of a body that bends by the independent coordinates that move it."""
        line, columns = self.lines[body], self.reduced[body]
        spins = self.spins[self.spanning_tree.group[body]]
        own = (*line.kind.coordinates, *line.kind.cuts)
        moving = [c for c in self.independent if c in columns or c in spins or c in own]
        return {c: line.column(c, columns.get(c, NO_VECTOR), spins.get(c, ZERO)) for c in moving}

    def _differentiate_loops(self) -> None:
        """Derive the motion of dependent coordinates from the loop equations."""
        loop_equations = loop_equations_of(self)
        loop_rows = [equation.columns for equation in loop_equations]
        solver = Solver(loop_rows, self.machine.dependent, branches=self.machine.branches)
        slopes, curvatures = self.predicted_rates(self.angle(self.crank.owner))
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
            if body in self.line_columns:
                lines = self.line_columns[body]
                if row in lines and column in lines:
                    terms.append(mass * lines[row].dot(lines[column]))
                if row == column:
                    terms.append(self.lines[body].lumped_mass(row))
            elif row in columns and column in columns:
                terms.append(mass * self._column_product(body, row, column))
            spins = self.spins.get(self.spanning_tree.group[body], {})
            terms.append(inertia * spins.get(row, ZERO) * spins.get(column, ZERO))
        return sum_of(terms)

    def _column_product(self, body: int, first: Coordinate, second: Coordinate) -> Expr:
        """Return the scalar product of two derivatives of a body's position."""
        columns = self.reduced[body]
        is_deformation = first.kind in (BEND, CUT)  # whose column is no unit vector
        if first != second or is_deformation or columns[first] != self.tree_columns[body].get(first):
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
        machine, loads = self.machine, self.program.parameters[2]
        force: dict[int, list[PlaneVector]] = {body: [] for body in range(machine.bodies)}
        moment: dict[int, list[Expr]] = {body: [] for body in range(machine.bodies)}
        self.bend_forces = {}
        for body in range(1, machine.bodies):
            mass, _ = self.inertia_of(body)
            if body not in (*machine.bent, *machine.housings):  # gravity acts along a line that bends
                force[body].append(PlaneVector(ZERO, -(mass * self.mechanism.gravity)))
        for i, j in enumerate(machine.open):
            link, joint = machine.sites[j].link, self.joints[j]
            load = PlaneVector(loads[i].fx, loads[i].fy)
            endpoints = (
                (link.proximal, joint.near, -load, loads[i].moment_proximal),
                (link.distal, joint.far, load, loads[i].moment_distal),
            )
            for body, point, joint_force, couple in endpoints:
                force[body].append(joint_force)
                moment[body] += [couple, self.moment(body, point, joint_force)]
                self.bend_body(point, joint_force, couple)
        for applied in self.applied_loads():
            force[applied.body].append(applied.force)
            moment[applied.body] += [applied.torque, self.moment(applied.body, applied.point, applied.force)]
            self.bend_body(applied.point, applied.force, applied.torque)
        return force, moment

    def bend_body(self, point: PlaneVector, force: PlaneVector, couple: Expr) -> None:
        """Add what a force and a couple at a point do to the deformation of its body, if that bends."""
        if isinstance(point, BentVector):
            for coordinate, slope in point.slopes:
                products = self.to_fixed_frame(point.group, slope).products(force)
                self.bend_forces.setdefault(coordinate, []).extend(products)
            for coordinate, turn in point.turns:
                self.bend_forces.setdefault(coordinate, []).append(turn * couple)

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
            if body in self.line_columns:
                field = self.acceleration_of_line(body, acceleration, known_accelerations)
                for coordinate, line_column in self.line_columns[body].items():
                    terms[coordinate].append(-(mass * line_column.dot(field)))
                acceleration = NO_VECTOR
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
        for coordinate, deforming in self.bend_forces.items():
            terms[coordinate] += deforming
        for line in self.lines.values():
            for coordinate in line.kind.coordinates:
                terms[coordinate].append(-line.tension(coordinate))
        return {coordinate: sum_of(item_terms) for coordinate, item_terms in terms.items()}

    def acceleration_of_line(self, body: int, centre: PlaneVector, accelerations: Row) -> PlaneField:
        """Return the acceleration of a line minus that of gravity; `centre` is that of the centre of mass."""
        angle = Coordinate(ANGLE, self.spanning_tree.group[body])
        upward = PlaneVector(centre.x, sum_of([centre.y, self.mechanism.gravity]))
        spin_rate = accelerations.get(angle, ZERO)
        return self.lines[body].acceleration(upward, self.rate[angle], spin_rate, accelerations)

    # ------------------------------------------------------------------------------------------ motion

    def motion(self) -> tuple[Motion, Row]:
        """Return the Motion, and the accelerations of all coordinates."""
        machine, crank = self.machine, self.crank
        alpha = ZERO if machine.free or machine.steady else self._drive_acceleration()
        right_side = self.generalised_forces(alpha)
        if machine.free:
            motion = self.angle(crank.owner), self.rate[crank], self.pose.time, self.pose.integral
            torque = self.program.call(torque_at, self.mechanism.drive, *motion)
            solution = LDL(self.unknown, self.entry).solve(right_side | {crank: right_side[crank] + torque})
        else:
            solution = LDL(self.unknown, self.entry).solve(right_side)
            inertia_terms = [self.entry(crank, coordinate) * solution[coordinate] for coordinate in self.unknown]
            torque = sum_of([*inertia_terms, -right_side[crank]])
        accelerations = tuple(solution[coordinate] for coordinate in self.unknown)
        if machine.regulated:
            accelerations += (self.program.call(integral_rate, self.mechanism.drive, *motion),)
        extended = self.with_dependent(solution | ({} if machine.free else {crank: alpha}))
        return Motion(accelerations, self.output(extended), torque), extended

    def _drive_acceleration(self) -> Expr:
        """Return the angular acceleration of a crank whose speed varies as prescribed."""
        return self.program.call(drive_motion, self.mechanism.drive, self.pose.time)[2]

    def output(self, accelerations: Row) -> Expr:
        """Return the acceleration of the output."""
        body, point, direction = self.machine.aim
        if point is None:
            return accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)
        aim = self.mechanism.aim
        path = self.path_to(body, self.point_of(body, point, aim.point))
        return self.acceleration(path, accelerations).dot(vector_of(direction, aim.direction))


@generated(machine_type)
def motion_of(machine: MachineType) -> Program:
    """Return the program of `contract.accelerate` without friction loads."""
    dynamics = Dynamics(machine)
    return dynamics.program.returns(dynamics.motion()[0])


class LinkForces(Dynamics):
    """Normal forces of links that bend, from the accelerations of the machine."""

    cuts_links = True

    def normal_forces(self, accelerations: Expr) -> list[list[Expr]]:
        """Return the normal force (N, of tension) at the stations of each link, for the accelerations of a Motion.

        It is what keeps a cut closed; with axial segments, the elastic force of the segment.  The friction of ideal
        joints counts through the accelerations only.
        """
        alpha = ZERO if self.machine.free or self.machine.steady else self._drive_acceleration()
        right_side, forces = self.generalised_forces(alpha), []
        for line in self.lines.values():
            if line.stretches:
                forces.append(line.tensions_of_segments())
                continue
            inertia_terms = [
                [-(self.entry(cut, c) * accelerations[i]) for i, c in enumerate(self.unknown)] for cut in line.kind.cuts
            ]
            forces.append(
                [sum_of([right_side[cut], *terms]) for cut, terms in zip(line.kind.cuts, inertia_terms, strict=True)]
            )
        return forces


@generated(machine_type)
def link_signals_of(machine: MachineType) -> Program:
    """Return the program of `contract.link_signals`."""
    dynamics = LinkForces(machine, 4)
    forces = dynamics.normal_forces(dynamics.program.parameters[3].accelerations)
    signals = [dynamics.angle(machine.spanning_tree.crank)]
    for line, normal_forces in zip(dynamics.lines.values(), forces, strict=True):
        signals += [*(line.values[mode] for mode in line.modes), *normal_forces]
    signals += dynamics.mount_motions()
    return dynamics.program.returns(tuple(signals))


@generated(machine_type)
def impact_masses_of(machine: MachineType) -> Program:
    """Return the program of `contract.impact_masses`.

    The mass is 1 / (n^T J M^-1 J^T n); 0 if a gap has no direction, and for a guide, whose laws do not need it.
    Elastic links count as rigid: the mass at a pin would decrease indefinitely with the number of segments.
    """
    dynamics = Dynamics(machine)
    rigid = {Coordinate(TRAVEL, j) for j in machine.sprung if machine.sites[j].link.distal not in machine.housings}
    rigid |= {coordinate for coordinate in dynamics.unknown if coordinate.kind == BEND}
    unknown = [coordinate for coordinate in dynamics.unknown if coordinate not in rigid]
    mass_matrix, joint_gaps = LDL(unknown, dynamics.entry), dynamics.program.parameters[2]
    squares_and_compliances: list[tuple[Expr, Expr] | None] = []
    for i, j in enumerate(machine.open):
        if machine.sites[j].link.slides:
            squares_and_compliances.append(None)
            continue
        if machine.sites[j].link.geared:
            square, row = ONE, _mesh_row(dynamics, j)
        else:
            gap = PlaneVector(joint_gaps[i].x, joint_gaps[i].y)
            columns = dynamics.reduce(dynamics.columns(dynamics.gap(j)))
            square, row = gap.dot(gap), {coordinate: column.dot(gap) for coordinate, column in columns.items()}
        impulse = mass_matrix.forward(row)
        compliance = sum_of(
            impulse[coordinate] * impulse[coordinate] * mass_matrix.inverse[coordinate] for coordinate in unknown
        )
        squares_and_compliances.append((square, compliance))
    masses = [pair and dynamics.program.call(_mass, *pair) for pair in squares_and_compliances]
    return dynamics.program.returns(tuple(mass or ZERO for mass in masses))


def _mesh_row(dynamics: Dynamics, j: int) -> Row:
    """Return the derivatives of the position along a gear's line of action, whose centres count as fixed."""
    row: Row = {}
    guide = dynamics.machine.sites[j].guide
    if guide is not None:
        axis, columns = dynamics.axis(guide), dynamics.reduce(dynamics.columns(dynamics.gap(j)))
        return {coordinate: axis.dot(column) for coordinate, column in columns.items()}
    for group, share in dynamics.shares(j):
        for coordinate, derivative in dynamics.spins[group].items():
            row[coordinate] = row.get(coordinate, ZERO) + dynamics.mechanism.joints[j].arm * (share * derivative)
    return row


@inlined
def _mass(square, compliance):
    return square / compliance if compliance > 0.0 else as_type_of(0.0, compliance)
