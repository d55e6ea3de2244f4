"""Formulas for the accelerations of a tree.

Newton's and Euler's equations of all bodies, multiplied by the derivatives of their velocities by the speeds of the
tree (Kane & Levinson 1985, "Dynamics: Theory and Applications", chapter 6): a symmetric mass matrix, solved by LDL
factors.  The speeds are the rates of the coordinates; for a quaternion they are the body's angular velocity in its
own frame, as is its inertia.
"""

from typing import NamedTuple

from ....tracing.compiled.formulas import ZERO, Expr, Program, sum_of
from ....tracing.compiled.vector import Vector, quaternion_accelerations, to_fixed_frame
from .. import contract
from ..planar.form import evaluate_cycle
from ..programs import LDL, generated
from . import form
from .kinematics import (
    NO_VECTOR,
    PosedBodies,
    SpatialVector,
    bearing_axes_of,
    body_motions_of,
    energy_of,
    gaps_of,
    histories_of,
    output_of,
    pose_of,
    vector_sum,
)

# ---------------------------------------------------------------------------------------------- equations of motion


Vectors = dict[int, SpatialVector]  # by the number of a speed
AXES_OF_FRAME = (form.axis_x, form.axis_y, form.axis_z)


class BodyAxis(NamedTuple):
    """A unit vector along an axis of a body's own frame."""

    axis: int


class Dynamics(PosedBodies):
    """The equations of motion; the last speed is that of the crank, which the drive prescribes."""

    def __init__(self, tree: form.MachineType):
        super().__init__(tree, 3)
        self.known = tree.speeds  # the crank's speed
        #: Derivatives by the speeds, for each body; the ground is body 0.
        self.own_angular: list[dict[int, BodyAxis | SpatialVector]] = [{}]  # angular velocity in its own frame
        self.angular: list[Vectors] = [{}]  # the same in the fixed frame
        self.linear: list[Vectors] = [{}]  # velocity of its centre of mass
        self.angular_bias: list[SpatialVector] = [NO_VECTOR]  # angular acceleration without those of the speeds
        self.bias: list[SpatialVector] = [NO_VECTOR]  # acceleration of its centre of mass without those of the speeds
        for body in range(1, len(tree.parts) + 1):
            self._derive_loose(body) if tree.part(body).form is form.Loose else self._derive_attached(body)
        self.force: list[list[SpatialVector]] = [[] for _ in range(len(tree.parts) + 1)]
        self.moment: list[list[SpatialVector]] = [[] for _ in range(len(tree.parts) + 1)]
        self._add_inertia_and_gravity()
        self._add_joint_loads()

    def _derive_loose(self, body: int) -> None:
        """Derive the motion of a body without attachment from the speeds."""
        first_speed = self.tree.part(body).speed
        self.angular.append({first_speed + i: self.call(AXES_OF_FRAME[i], self.frame(body)) for i in range(3)})
        self.own_angular.append({first_speed + i: BodyAxis(i) for i in range(3)})
        units = [self.program.known(Vector(*(1.0 if i == k else 0.0 for k in range(3)))) for i in range(3)]
        self.linear.append({first_speed + 3 + i: SpatialVector(unit) for i, unit in enumerate(units)})
        self.angular_bias.append(NO_VECTOR)
        self.bias.append(NO_VECTOR)

    def _derive_attached(self, body: int) -> None:
        """Derive the motion of a body from the speeds and from the motion of its parent."""
        part, parent = self.tree.part(body), self.tree.part(body).parent
        own_arm, slide = self.own_arm(body), self.along_axis(body, self.pose.q)
        arm = self.near_arm(body) + slide
        linear, angular = dict(self.linear[parent]), {} if part.turns_freely else dict(self.angular[parent])
        for u, spin in self.angular[parent].items():
            linear[u] = linear.get(u, NO_VECTOR) + spin.cross(arm)
        attachment_bias = self._point_bias(parent, arm)
        slide_rate = self.along_axis(body, self.pose.rates)
        if slide_rate != NO_VECTOR and parent:
            attachment_bias += 2.0 * self.spin(parent).cross(slide_rate)
        own_axes = self._add_own_speeds(body, linear, angular)
        for u, spin in angular.items():
            linear[u] = linear.get(u, NO_VECTOR) + spin.cross(own_arm)
        self.angular.append(angular)
        self.linear.append({u: velocity for u, velocity in linear.items() if velocity != NO_VECTOR})
        self.own_angular.append({u: own_axes.get(u) or self.to_body_frame(body, spin) for u, spin in angular.items()})
        angular_bias = self._angular_bias(body)
        self.angular_bias.append(angular_bias)
        if part.form is form.Slide and not parent:
            self.bias.append(attachment_bias)
        else:
            self.bias.append(self.call(form.transported, attachment_bias, angular_bias, self.spin(body), own_arm))

    def _point_bias(self, body: int, arm: SpatialVector) -> SpatialVector:
        """Return the acceleration of a point of a body, without the accelerations of the speeds."""
        if self.is_nonrotating(body):
            return self.bias[body]
        return self.call(form.transported, self.bias[body], self.angular_bias[body], self.spin(body), arm)

    def _angular_bias(self, body: int) -> SpatialVector:
        """Return the angular acceleration of an attached body, without the accelerations of the speeds."""
        part, parent = self.tree.part(body), self.tree.part(body).parent
        if part.turns_freely:
            return NO_VECTOR
        bias = self.angular_bias[parent]
        if part.form in (form.Hinge, form.Sleeve) and not self.tree.is_vertical(parent):
            rate = self.pose.rates[part.coordinate + (part.form is form.Sleeve)]
            bias += self.spin(parent).cross(rate * self.z_axis(parent))
        return bias

    def is_nonrotating(self, body: int) -> bool:
        """Return whether a body, or the ground, never rotates."""
        while body and self.tree.part(body).form is form.Slide:
            body = self.tree.part(body).parent
        return body == 0

    def _add_own_speeds(self, body: int, linear: Vectors, angular: Vectors) -> dict[int, BodyAxis]:
        """Add a body's own speeds at its attachment; return angular velocities that are axes of its frame."""
        part, parent = self.tree.part(body), self.tree.part(body).parent
        first_speed, axes = part.speed, {}
        if part.form is form.Driven:
            angular[self.known], axes[self.known] = self.vertical, BodyAxis(2)
        elif part.form is form.Slide:
            linear[first_speed] = self.axis(body)
        elif part.form is form.Ball:
            for i in range(3):
                angular[first_speed + i] = self.call(AXES_OF_FRAME[i], self.frame(body))
                axes[first_speed + i] = BodyAxis(i)
        else:
            if part.form is form.Sleeve:
                linear[first_speed] = self.axis(body)
            rotation_speed = first_speed + (part.form is form.Sleeve)
            angular[rotation_speed], axes[rotation_speed] = self.z_axis(parent), BodyAxis(2)
        if not part.turns_freely:  # it shares its z axis with its parent
            axes |= {u: axis for u, axis in self.own_angular[parent].items() if axis == BodyAxis(2)}
        return axes

    # ------------------------------------------------------------------------------------------ forces

    def _add_inertia_and_gravity(self) -> None:
        """Add gravity and the inertia of known accelerations to the forces and moments."""
        for body in range(1, len(self.tree.parts) + 1):
            mass, inertia = self.inertia_of(body)
            self.force[body].append(mass * (SpatialVector(self.mechanism.gravity) - self.bias[body]))
            if self.is_nonrotating(body):
                continue
            spin = self.to_body_frame(body, self.spin(body))
            self.moment[body].append(inertia.componentwise(spin).cross(spin))
            if self.angular_bias[body] != NO_VECTOR:
                self.moment[body].append(-inertia.componentwise(self.to_body_frame(body, self.angular_bias[body])))

    def _add_joint_loads(self) -> None:
        """Add the loads of the joints with clearance."""
        for j, (bearing, journal) in enumerate(self.tree.openings):
            opening, load, frame = self.mechanism.openings[j], self.program.parameters[2][j], self.frame(journal)
            force = self.call(to_fixed_frame, frame, load.force)
            for body, point, joint_force, couple in (
                (journal, opening.at_journal, force, load.journal_moment),
                (bearing, opening.at_bearing, -force, load.bearing_moment),
            ):
                if body:
                    self.force[body].append(joint_force)
                    moment = self.call(to_fixed_frame, frame, couple)
                    moment += self.arm(body, point).cross(joint_force)
                    self.moment[body].append(self.to_body_frame(body, moment))

    def inertia_of(self, body: int) -> tuple[Expr, SpatialVector]:
        """Return mass and principal moments of inertia of a body."""
        part = self.mechanism.parts[body - 1]
        return part.mass, SpatialVector(part.inertia)

    def generalised(self, speed: int) -> Expr:
        """Return the generalised force of a speed."""
        terms = []
        for body in range(1, len(self.tree.parts) + 1):
            force, moment = vector_sum(self.force[body]), vector_sum(self.moment[body])
            if speed in self.linear[body]:
                terms.append(self.linear[body][speed].dot(force))
            if speed in self.own_angular[body] and moment != NO_VECTOR:
                spin = self.own_angular[body][speed]
                terms.append(moment[spin.axis] if isinstance(spin, BodyAxis) else spin.dot(moment))
        return sum_of(terms)

    # ------------------------------------------------------------------------------------------ mass matrix

    def entry(self, row: int, column: int) -> Expr:
        """Return an entry of the mass matrix."""
        terms = []
        for body in range(1, len(self.tree.parts) + 1):
            mass, inertia = self.inertia_of(body)
            linear, angular = self.linear[body], self.own_angular[body]
            if row in linear and column in linear:
                terms.append(mass * linear[row].dot(linear[column]))
            if row in angular and column in angular:
                terms.append(_inertia_product(inertia, angular[row], angular[column]))
        return sum_of(terms)

    # ------------------------------------------------------------------------------------------ motion

    def coordinates(self, accelerations: dict[int, Expr]) -> list[Expr]:
        """Return the accelerations of the coordinates from those of the speeds."""
        values: list[Expr] = []
        for i, part in enumerate(self.tree.parts):
            own_values = [accelerations[part.speed + k] for k in range(form.SPEEDS[part.form])]
            if part.turns_freely:
                spin = self.to_body_frame(i + 1, self.spin(i + 1)).value
                motion, angular = self.pose.quaternion_motions[i], Vector(*own_values[:3])
                quaternion = self.program.call(quaternion_accelerations, motion, spin, angular, self.mechanism.speed)
                values += [quaternion[k] for k in range(4)]
                own_values = own_values[3:]
            values += own_values
        return values

    def output(self, accelerations: dict[int, Expr]) -> Expr:
        """Return the acceleration of the output."""
        tree, body = self.tree, self.tree.aimed
        if not tree.has_point_aim:
            return sum_of(accelerations[u] for u in self.angular[body] if u != self.known)
        arm, direction = self.arm(body, self.mechanism.aim.point), SpatialVector(self.mechanism.aim.direction)
        bias = self._point_bias(body, arm)
        terms = [ZERO if bias == NO_VECTOR else direction.dot(bias)]
        for u in {**self.linear[body], **self.angular[body]}:
            if u != self.known:
                column = self.linear[body].get(u, NO_VECTOR) + self.angular[body].get(u, NO_VECTOR).cross(arm)
                terms.append(accelerations[u] * direction.dot(column))
        return sum_of(terms)


def _inertia_product(inertia: SpatialVector, a: BodyAxis | SpatialVector, b: BodyAxis | SpatialVector) -> Expr:
    """Return first . I second for two angular velocities in the frame of the principal moments I."""
    if isinstance(a, BodyAxis) and isinstance(b, BodyAxis):
        return inertia[a.axis] if a == b else ZERO
    if isinstance(a, BodyAxis):
        return inertia[a.axis] * b[a.axis]
    if isinstance(b, BodyAxis):
        return inertia[b.axis] * a[b.axis]
    return a.dot(inertia.componentwise(b))


@generated(form.MachineType)
def motion_of(tree: form.MachineType) -> Program:
    """Return the program of `contract.accelerate`."""
    dynamics, speeds = Dynamics(tree), range(tree.speeds)
    solution = LDL(speeds, dynamics.entry).solve({u: dynamics.generalised(u) for u in speeds})
    inertia_terms = [dynamics.entry(dynamics.known, u) * solution[u] for u in speeds]
    torque = sum_of([*inertia_terms, -dynamics.generalised(dynamics.known)])
    return dynamics.program.returns(
        contract.Motion(tuple(dynamics.coordinates(solution)), dynamics.output(solution), torque)
    )


# ---------------------------------------------------------------------------------------------- members of families


contract.pose_at.member(form.Tree)(pose_of)
contract.gaps.member(form.Tree)(gaps_of)
contract.accelerate.member(form.Tree)(motion_of)
contract.energy.member(form.Tree)(energy_of)
contract.body_motions.member(form.Tree)(body_motions_of)
contract.gravity_of.member(form.Tree)(lambda mechanism: (mechanism.gravity.x, mechanism.gravity.y))
contract.body_angles.member(form.Tree)(lambda mechanism, y: bearing_axes_of(mechanism, pose_of(mechanism, y)))


@contract.output_error.member(form.Tree)
def _output_error_tree(mechanism, pose):
    output, output_rate = output_of(mechanism, pose)
    ideal_output, slope = evaluate_cycle(mechanism.cycle, 0, pose.angle)
    return output - ideal_output, output_rate - slope * mechanism.speed


contract.describe.member(form.Tree)(lambda mechanism, y, pose, motion: histories_of(mechanism, pose, y, motion))
