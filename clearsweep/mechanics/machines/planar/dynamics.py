"""Formulas for the accelerations of a planar machine.

Newton's and Euler's equations of all bodies, multiplied by the derivatives of their positions and angles by the
coordinates (Kane 1961; Shabana 2010, "Computational Dynamics", 3rd ed., chapter 4): a symmetric mass matrix, solved by
its LDL factors.  Dependent coordinates contribute through the chain rule.
"""

import math
from typing import NamedTuple

from ....tracing.compiled import calculus
from ....tracing.compiled.choosing import where
from ....tracing.compiled.dual import as_type_of, plain
from ....tracing.compiled.family import family, inlined, kernel, known
from ....tracing.compiled.formulas import ONE, ZERO, Expr, Program, sum_of
from ...laws.friction import friction_force, friction_in_pin, static_limit, static_limit_in_pin
from ..contract import Motion
from ..programs import LDL, generated, kinds_of
from .form import drive_motion, torque_at
from .kinematics import NO_VECTOR, Bodies, Columns, PlaneVector, combination, signed, vector_of, vector_sum
from .pose import Row, Solver, loop_equations_of
from .structure import ANGLE, TRAVEL, Coordinate, FrictionLoad, MachineType, machine_type

# ------------------------------------------------------------------------------------------- without friction in joints


class Dynamics(Bodies):
    """Mass matrix and generalised forces of the coordinates of the state and the crank's angle."""

    def __init__(self, machine: MachineType, parameters: int = 3):
        super().__init__(machine, parameters)
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
        machine, loads = self.machine, self.program.parameters[2]
        force: dict[int, list[PlaneVector]] = {body: [] for body in range(machine.bodies)}
        moment: dict[int, list[Expr]] = {body: [] for body in range(machine.bodies)}
        for body in range(1, machine.bodies):
            mass, _ = self.inertia_of(body)
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

    def motion(self) -> tuple[Motion, Row]:
        """Return the Motion, and the accelerations of all coordinates."""
        machine, crank = self.machine, self.crank
        alpha = ZERO
        if not (machine.free or machine.steady):
            alpha = self.program.call(drive_motion, self.mechanism.drive, self.pose.time)[2]
        right_side = self.generalised_forces(alpha)
        if machine.free:
            torque = self.program.call(torque_at, self.mechanism.drive, self.rate[crank], self.pose.time)
            solution = LDL(self.unknown, self.entry).solve(right_side | {crank: right_side[crank] + torque})
        else:
            solution = LDL(self.unknown, self.entry).solve(right_side)
            inertia_terms = [self.entry(crank, coordinate) * solution[coordinate] for coordinate in self.unknown]
            torque = sum_of([*inertia_terms, -right_side[crank]])
        accelerations = tuple(solution[coordinate] for coordinate in self.unknown)
        extended = self.with_dependent(solution | ({} if machine.free else {crank: alpha}))
        return Motion(accelerations, self.output(extended), torque), extended

    def output(self, accelerations: Row) -> Expr:
        """Return the acceleration of the output."""
        body, point, direction = self.machine.aim
        if point is None:
            return accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)
        aim = self.mechanism.aim
        path = self.path_to(body, vector_of(point, aim.point))
        return self.acceleration(path, accelerations).dot(vector_of(direction, aim.direction))


@generated(machine_type)
def motion_of(machine: MachineType) -> Program:
    """Return the program of `contract.accelerate` without friction loads."""
    dynamics = Dynamics(machine)
    return dynamics.program.returns(dynamics.motion()[0])


@generated(machine_type)
def impact_masses_of(machine: MachineType) -> Program:
    """Return the program of `contract.impact_masses`.

    The mass is 1 / (n^T J M^-1 J^T n); 0 if a gap has no direction, and for a guide, whose laws do not need it.
    Elastic links count as rigid: the mass at a pin would decrease indefinitely with the number of segments.
    """
    dynamics = Dynamics(machine)
    rigid = {Coordinate(TRAVEL, j) for j in machine.sprung}
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
    for group, share in dynamics.shares(j):
        for coordinate, derivative in dynamics.spins[group].items():
            row[coordinate] = row.get(coordinate, ZERO) + dynamics.mechanism.joints[j].arm * (share * derivative)
    return row


@inlined
def _mass(square, compliance):
    return square / compliance if compliance > 0.0 else as_type_of(0.0, compliance)


# --------------------------------------------------------------------------------- friction in joints without clearance

# Friction in joints without clearance, and friction of given size.
#
# The friction in a pin is a couple, in a guide a force, from a friction law and the reaction.  The reactions depend on
# all friction.  Both are iterated to convergence: the couples are small compared with the moments of reactions at the
# length of a body, so each iteration reduces the error tenfold or more.


SWEEPS = 200  # over friction and reactions
MIN_COMPLIANCE = 1e-6  # rad/s^2 per N m, m/s^2 per N: a less compliant joint follows the crank and cannot stick
CONVERGED = 1e-15  # tolerance, relative to the largest friction
JAM_TOLERANCE = 1e-9  # the same after all sweeps: a larger change means that the joint jams


class FrictionMotion(NamedTuple):
    """Motion of a machine, with powers and sliding speeds of friction in joints without clearance or of given size."""

    accelerations: tuple
    output: float
    torque: float  # N m
    powers: tuple  # W, of each friction; nan without convergence
    slips: tuple  # at which its law is evaluated: m/s, or rad/s for a couple of a given size


@family
def friction_powers_of(motion):
    """Return the power (W) of each friction in joints without clearance, or of a given size."""


@friction_powers_of.member(Motion)
def _friction_powers_of_motion(motion):
    return ()


@friction_powers_of.member(FrictionMotion)
def _friction_powers_of_friction_motion(motion):
    return motion.powers


@family
def friction_slips_of(motion):
    """Return the sliding speed at which the law of each friction is evaluated."""


@friction_slips_of.member(Motion)
def _friction_slips_of_motion(motion):
    return ()


@friction_slips_of.member(FrictionMotion)
def _friction_slips_of_friction_motion(motion):
    return motion.slips


class FrictionDynamics(Dynamics):
    """Accelerations under given friction, and the corresponding reactions."""

    def forces(self) -> tuple[dict[int, list[PlaneVector]], dict[int, list[Expr]]]:
        """Return the terms of the forces on the bodies and of the moments about their centres of mass."""
        force, moment = super().forces()
        for i, friction_load in enumerate(self.machine.friction_loads):
            j, size = friction_load.joint, self.program.parameters[3][i]
            link, joint = self.machine.sites[j].link, self.joints[j]
            if not link.slides:
                moment[link.distal].append(size)
                moment[link.proximal].append(-size)
                continue
            for body, point, sign in ((link.distal, joint.far, 1), (link.proximal, joint.near, -1)):
                friction_force = signed(sign, size * self.axis(j))
                force[body].append(friction_force)
                moment[body].append(self.moment(body, point, friction_force))
            if j in self.machine.open:  # the walls are loaded at the position of the block
                moment[link.proximal].append(size * _guide_offset(self, j))
        return force, moment

    def normals(self, accelerations: Row) -> list[Expr]:
        """Return the magnitude of the reaction in each joint with friction, for the accelerations of all coordinates.

        It is that across a guide, and 0 for friction of given size.
        """
        friction_loads = self.machine.friction_loads
        if all(friction_load.is_given for friction_load in friction_loads):
            return [ZERO] * len(friction_loads)
        force, moment = self._joint_loads(accelerations)
        loop_reactions = self._loop_reactions(force, moment)
        for j, reaction in loop_reactions.items():
            link = self.machine.sites[j].link
            force[link.distal] -= reaction
            force[link.proximal] += reaction
        sizes = []
        for friction_load in friction_loads:
            j = friction_load.joint
            reaction = loop_reactions[j] if j in loop_reactions else self._tree_reaction(j, force)
            if friction_load.is_given:
                sizes.append(ZERO)
            elif self.machine.sites[j].link.slides:
                sizes.append(self.program.call(abs, self.axis(j).left().dot(reaction)))
            else:
                sizes.append(self.program.call(calculus.sqrt, reaction.dot(reaction)))
        return sizes

    def slip_rate(self, friction_load: FrictionLoad, accelerations: Row) -> Expr:
        """Return the derivative of a joint's slip (rad/s^2 or m/s^2), for the accelerations of all coordinates."""
        link = self.machine.sites[friction_load.joint].link
        if not link.slides:
            distal, proximal = (
                accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)
                for body in (link.distal, link.proximal)
            )
            return distal - proximal
        path, axis = self.gap(friction_load.joint), self.axis(friction_load.joint)
        acceleration = self.acceleration(path, accelerations)
        transverse = axis.left().dot(self.velocity(path))
        return sum_of([*axis.products(acceleration), self.spin(link.proximal) * transverse])

    def _joint_loads(self, accelerations: Row) -> tuple[dict[int, PlaneVector], dict[int, Expr]]:
        """Return force and moment of the joints without clearance on each body."""
        applied_force, applied_moment = self.forces()
        force: dict[int, PlaneVector] = {0: NO_VECTOR}
        moment: dict[int, Expr] = {0: ZERO}
        for body, path in self.paths.items():
            mass, inertia = self.inertia_of(body)
            acceleration = self.bias(path) + combination(self.tree_columns[body], accelerations)
            force[body] = vector_sum([mass * acceleration, *(-term for term in applied_force[body])])
            angular_acceleration = accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)
            moment[body] = sum_of([inertia * angular_acceleration, *(-term for term in applied_moment[body])])
        return force, moment

    def _loop_reactions(self, force: dict[int, PlaneVector], moment: dict[int, Expr]) -> dict[int, PlaneVector]:
        """Return the force on the distal body of each joint that closes a loop."""
        machine = self.machine
        if not machine.dependent:
            return {}
        right_side: Row = {}
        for coordinate in machine.dependent:
            terms: list[Expr] = []
            for body, columns in self.tree_columns.items():
                terms += columns[coordinate].products(force[body]) if coordinate in columns else ()
            if coordinate.kind == ANGLE:
                terms += [moment[body] for body in self.paths if self.spanning_tree.group[body] == coordinate.owner]
            right_side[coordinate] = sum_of(terms)
        loop_rows = [equation.columns for equation in loop_equations_of(self, with_rates=False)]
        multipliers = Solver(loop_rows, machine.dependent, branches=machine.branches).solve_transposed(right_side)
        reactions: dict[int, PlaneVector] = {}
        row = 0
        for j in self.spanning_tree.loop_joints:
            if machine.sites[j].link.slides:
                reactions[j] = multipliers[row] * self.axis(j).left()
                row += 1
            else:
                reactions[j] = PlaneVector(multipliers[row], multipliers[row + 1])
                row += 2
        return reactions

    def _tree_reaction(self, joint: int, force: dict[int, PlaneVector]) -> PlaneVector:
        """Return the force that a tree joint transmits to its subtree."""
        return vector_sum([force[body] for body in self.paths if self._in_subtree(body, joint)])

    def _in_subtree(self, body: int, joint: int) -> bool:
        """Return whether the path from the ground to a body passes a joint of the tree."""
        while self.spanning_tree.parents[body] is not None:
            body, passed_joint = self.spanning_tree.parents[body]
            if passed_joint == joint:
                return True
        return False


@generated(machine_type)
def _under_friction(machine: MachineType) -> Program:
    """Return the program of the Motion under given friction, the magnitudes of the reactions and the slips' rates."""
    dynamics = FrictionDynamics(machine, 4)
    motion, accelerations = dynamics.motion()
    normals = dynamics.normals(accelerations)
    slip_rates = [dynamics.slip_rate(load, accelerations) for load in machine.friction_loads if load.sticks]
    return dynamics.program.returns((motion, tuple(normals), tuple(slip_rates)))


@kernel
def under_friction(mechanism, pose, loads, friction):
    """Return the Motion under given friction, the magnitude of each reaction (N), and the rate of each sticking slip.

    friction : torque (N m) of each friction load in a pin, force (N) in a guide.
    """
    return _under_friction(mechanism, pose, loads, friction)


@generated(machine_type)
def _slips_of(machine: MachineType) -> Program:
    """Return the program of the rates at which the distal bodies turn (rad/s) or slide (m/s) on the proximal ones."""
    bodies = Bodies(machine)
    return bodies.program.returns(tuple(_slip(bodies, friction_load) for friction_load in machine.friction_loads))


class _Contact(NamedTuple):
    """The surfaces of a friction load."""

    law: tuple
    arm: float  # m, of the couple; 1 in a guide, where friction is a force
    normal: float  # N, if it is given
    is_given: bool  # whether the normal force is given
    is_pin: bool
    sticks: bool


@known
def _contacts_of(mechanism):
    """Return the _Contact of each friction load."""
    machine, contacts = machine_type(kinds_of(mechanism)), []
    for friction_load in machine.friction_loads:
        load, is_pin = mechanism.loads[friction_load.load], not machine.sites[friction_load.joint].link.slides
        arm, normal = load.radius if is_pin else 1.0, load.normal if friction_load.is_given else 0.0
        contacts.append(_Contact(load.friction, arm, normal, friction_load.is_given, is_pin, friction_load.sticks))
    return tuple(contacts)


@known
def _crank_orientation(mechanism, pose):
    """Return the Orientation of the crank."""
    machine = machine_type(kinds_of(mechanism))
    return pose.orientations[machine.groups.index(machine.spanning_tree.crank)]


@inlined
def _force(contact, normal, speed):
    """Return the friction (N) at a sliding speed; in a pin the normal force is its reaction, unless it is given."""
    if contact.is_given:
        return friction_force(contact.law, contact.normal, speed)
    law = friction_in_pin if contact.is_pin else friction_force
    return law(contact.law, normal, speed)


@inlined
def _limit(contact, normal):
    """Return the largest sticking friction, a torque (N m) or a force (N)."""
    if contact.is_pin and not contact.is_given:
        return contact.arm * static_limit_in_pin(contact.law, normal)
    return contact.arm * static_limit(contact.law) * (contact.normal if contact.is_given else normal)


@inlined
def accelerate_with_friction(mechanism, pose, loads):
    """Return the FrictionMotion of a machine with friction loads."""
    contacts, slips = _contacts_of(mechanism), _slips_of(mechanism, pose)
    sticks, is_given = any(contact.sticks for contact in contacts), all(contact.is_given for contact in contacts)
    speeds = tuple([contact.arm * slip for contact, slip in zip(contacts, slips, strict=True)])
    normals = tuple([0.0 for _ in contacts])
    if sticks or not is_given:
        _, normals, slip_rates = under_friction(mechanism, pose, loads, normals)
    friction = tuple([c.arm * _force(c, n, v) for c, n, v in zip(contacts, normals, speeds, strict=True)])
    stuck = tuple([abs(v) < c.law.band if c.sticks else False for c, v in zip(contacts, speeds, strict=True)])
    if sticks:
        _, normals, slip_rates = under_friction(mechanism, pose, loads, friction)
        compliances = [
            under_friction(mechanism, pose, loads, _replaced(friction, i, friction[i] + 1.0))[2][k] - slip_rates[k]
            for k, i in enumerate(_sticking(contacts))
        ]
    valid = 1.0
    if sticks or not is_given:
        change, largest = 0.0, 0.0
        for _ in range(SWEEPS):
            if not sticks:
                normals = under_friction(mechanism, pose, loads, friction)[1]
            before = friction
            friction = tuple(
                [
                    where(is_stuck, size, c.arm * _force(c, n, v))
                    for is_stuck, size, c, n, v in zip(stuck, before, contacts, normals, speeds, strict=True)
                ]
            )
            if sticks:
                friction, normals = _slowed(mechanism, pose, loads, contacts, slips, compliances, stuck, friction)
            change, largest = 0.0, 0.0
            for i in range(len(contacts)):
                change = max(change, abs(plain(friction[i]) - plain(before[i])))
                largest = max(largest, abs(plain(friction[i])))
            if change <= CONVERGED * largest:
                break
        valid = 1.0 if change <= JAM_TOLERANCE * largest else math.nan
    motion = under_friction(mechanism, pose, loads, friction)[0]
    powers = tuple([valid * (size * slip) for size, slip in zip(friction, slips, strict=True)])
    return FrictionMotion(motion.accelerations, motion.output, motion.torque, powers, speeds)


@inlined
def _slowed(mechanism, pose, loads, contacts, slips, compliances, stuck, friction):
    """Return the friction after one sweep over the joints that can stick, and the reactions before its last change.

    Karnopp 1985: while the slip is below the band, each couple or force makes it decay at the rate of the crank, within
    its limits, which may depend on reactions; several are iterated (projected Gauss-Seidel).
    compliances : of each joint that can stick
    """
    normals, decay = (), abs(_crank_orientation(mechanism, pose).rate)
    for k, i in enumerate(_sticking(contacts)):
        _, normals, slip_rates = under_friction(mechanism, pose, loads, friction)
        can_stick = compliances[k] > MIN_COMPLIANCE
        limit = _limit(contacts[i], normals[i])
        stopping_force = friction[i] - (slip_rates[k] + decay * slips[i]) / where(can_stick, compliances[k], 1.0)
        stopping_force = min(max(stopping_force, -limit), limit)
        bounded = where(can_stick, stopping_force, friction[i])
        friction = _replaced(friction, i, where(stuck[i], bounded, friction[i]))
    return friction, normals


@inlined
def _sticking(contacts):
    """Return the indices of the surfaces that can stick."""
    return [i for i in range(len(contacts)) if contacts[i].sticks]


@inlined
def _replaced(items, i, item):
    """Return a tuple with another item number `i`."""
    return (*items[:i], item, *items[i + 1 :])


def _slip(bodies: Bodies, friction_load: FrictionLoad) -> Expr:
    """Return the rate at which the distal body rotates or slides on the proximal one."""
    j = friction_load.joint
    link = bodies.machine.sites[j].link
    if not link.slides:
        return bodies.spin(link.distal) - bodies.spin(link.proximal)
    terms = [*bodies.axis(j).products(bodies.velocity(bodies.gap(j)))]
    if j in bodies.machine.open:
        terms.append(bodies.spin(link.proximal) * _guide_offset(bodies, j))
    return sum_of(terms)


def _guide_offset(bodies: Bodies, joint: int) -> Expr:
    """Return the offset (m) of a block from the middle of its guide, normal to the walls."""
    return bodies.axis(joint).left().dot(bodies.position(bodies.gap(joint)).assigned())
