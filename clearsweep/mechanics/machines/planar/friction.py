"""Friction in joints without clearance, and friction of given size.

The friction in a pin is a couple, in a guide a force, from a friction law and the reaction.  The reactions depend on
all friction.  Both are iterated to convergence: the couples are small compared with the moments of reactions at the
length of a body, so each iteration reduces the error tenfold or more.
"""

import math
from typing import NamedTuple

from ....tracing.compiled import calculus
from ....tracing.compiled.choosing import replaced, where
from ....tracing.compiled.dual import plain
from ....tracing.compiled.family import inlined, kernel, known
from ....tracing.compiled.formulas import ZERO, Expr, Program, sum_of
from ...laws.friction import friction_force, friction_in_pin, static_limit, static_limit_in_pin
from ..programs import NO_VECTOR, PlaneVector, generated, vector_sum
from .dynamics import Dynamics
from .kinematics import Bodies, Row, combination, section_turns, signed
from .loops import Solver, loop_equations_of
from .structure import ANGLE, Coordinate, FrictionLoad, MachineType, machine_type

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
                self.bend_body(joint.far, NO_VECTOR, size)
                self.bend_body(joint.near, NO_VECTOR, -size)
                continue
            for body, point, sign in ((link.distal, joint.far, 1), (link.proximal, joint.near, -1)):
                friction_force = signed(sign, size * self.axis(j))
                self.bend_body(point, friction_force, ZERO)
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
            reaction = loop_reactions.get(j)
            if reaction is None:  # of a joint of the tree, which carries its subtree
                reaction = vector_sum([force[body] for body in self.paths if self._in_subtree(body, j)])
            if friction_load.is_given:
                sizes.append(ZERO)
            elif self.machine.sites[j].link.slides:
                sizes.append(self.program.call(abs, self.axis(j).left().dot(reaction)))
            else:
                sizes.append(self.program.call(calculus.sqrt, reaction.dot(reaction)))
        return sizes

    def slip_rate(self, friction_load: FrictionLoad, accelerations: Row) -> Expr:
        """Return the derivative of a joint's slip (rad/s^2 or m/s^2), for the accelerations of all coordinates."""
        link, joint = self.machine.sites[friction_load.joint].link, self.joints[friction_load.joint]
        if not link.slides:
            distal, proximal = (
                sum_of(
                    [
                        accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO),
                        *section_turns(point, accelerations),
                    ]
                )
                for body, point in ((link.distal, joint.far), (link.proximal, joint.near))
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
            angular_acceleration = accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)
            moments = [inertia * angular_acceleration]
            if body in self.lines:
                field = self.acceleration_of_line(body, acceleration, accelerations)
                acceleration = self.lines[body].mean(field)
                moments.append(mass * self.lines[body].mean_moment(field))
            force[body] = vector_sum([mass * acceleration, *(-term for term in applied_force[body])])
            moment[body] = sum_of([*moments, *(-term for term in applied_moment[body])])
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
    machine, contacts = machine_type(mechanism), []
    for friction_load in machine.friction_loads:
        load, is_pin = mechanism.loads[friction_load.load], not machine.sites[friction_load.joint].link.slides
        arm, normal = load.radius if is_pin else 1.0, load.normal if friction_load.is_given else 0.0
        contacts.append(_Contact(load.friction, arm, normal, friction_load.is_given, is_pin, friction_load.sticks))
    return tuple(contacts)


@known
def _crank_orientation(mechanism, pose):
    """Return the Orientation of the crank."""
    machine = machine_type(mechanism)
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
            under_friction(mechanism, pose, loads, replaced(friction, i, friction[i] + 1.0))[2][k] - slip_rates[k]
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
        friction = replaced(friction, i, where(stuck[i], bounded, friction[i]))
    return friction, normals


@inlined
def _sticking(contacts):
    """Return the indices of the surfaces that can stick."""
    return [i for i in range(len(contacts)) if contacts[i].sticks]


def _slip(bodies: Bodies, friction_load: FrictionLoad) -> Expr:
    """Return the rate at which the distal body rotates or slides on the proximal one."""
    j = friction_load.joint
    link, joint = bodies.machine.sites[j].link, bodies.joints[j]
    if not link.slides:
        return bodies.spin_at(link.distal, joint.far) - bodies.spin_at(link.proximal, joint.near)
    terms = [*bodies.axis(j).products(bodies.velocity(bodies.gap(j)))]
    if j in bodies.machine.open:
        terms.append(bodies.spin(link.proximal) * _guide_offset(bodies, j))
    return sum_of(terms)


def _guide_offset(bodies: Bodies, joint: int) -> Expr:
    """Return the offset (m) of a block from the middle of its guide, normal to the walls."""
    return bodies.axis(joint).left().dot(bodies.position(bodies.gap(joint)).assigned())
