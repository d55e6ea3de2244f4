"""Formulas for positions, velocities and observables of a tree's bodies."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from ....tracing.compiled import vector as vectors
from ....tracing.compiled.calculus import direction as direction_of
from ....tracing.compiled.formulas import ONE, Expr, Program, constant, sum_of
from ....tracing.compiled.vector import QuaternionMotion, Vector, frame_of, spin_of, to_body_frame, to_fixed_frame
from ...joints.spatial import SpatialGap
from ..contract import BodyMotion
from ..programs import generated
from . import form

# ---------------------------------------------------------------------------------------------- vectors


AXES = "xyz"


@dataclass(frozen=True)
class SpatialVector:
    """A vector of a program."""

    value: Expr

    def __add__(self, other: "SpatialVector") -> "SpatialVector":
        if NO_VECTOR in (self, other):
            return other if self == NO_VECTOR else self
        return self._call(vectors.plus, self, other)

    def __sub__(self, other: "SpatialVector") -> "SpatialVector":
        return self if other == NO_VECTOR else other._call(vectors.minus, self, other)

    def __neg__(self) -> "SpatialVector":
        return -1.0 * self

    def __rmul__(self, factor: Expr | float) -> "SpatialVector":
        return NO_VECTOR if self == NO_VECTOR else self._call(vectors.times, factor, self)

    def __getitem__(self, axis: int) -> Expr:
        """Return the component number `axis`."""
        component: Expr = getattr(self.value, AXES[axis])
        return component

    def cross(self, other: "SpatialVector") -> "SpatialVector":
        """Return the vector product."""
        return NO_VECTOR if NO_VECTOR in (self, other) else self._call(vectors.cross, self, other)

    def dot(self, other: "SpatialVector") -> Expr:
        """Return the scalar product."""
        return self._call(vectors.dot, self, other).value

    def componentwise(self, other: "SpatialVector") -> "SpatialVector":
        """Return the vector of the products of the components."""
        return self._call(form.elementwise_product, self, other)

    def _call(self, function: Any, *arguments: Any) -> "SpatialVector":
        program = next(x.value.program for x in arguments if isinstance(x, SpatialVector) and x.value.program)
        values = (x.value if isinstance(x, SpatialVector) else x for x in arguments)
        return SpatialVector(program.call(function, *values))


NO_VECTOR = SpatialVector(constant(Vector(0.0, 0.0, 0.0)))


def vector_sum(addends: Iterable[SpatialVector]) -> SpatialVector:
    """Return the sum of vectors, added from left to right."""
    total = NO_VECTOR
    for vector in addends:
        total += vector
    return total


# ---------------------------------------------------------------------------------------------- bodies


class Bodies:
    """The bodies of a tree in a program whose first parameter is the Tree; subclasses define their frames."""

    def __init__(self, tree: form.MachineType, parameters: int):
        self.tree, self.program = tree, Program(parameters)
        self.mechanism = self.program.parameters[0]
        self.vertical = SpatialVector(self.program.known(Vector(0.0, 0.0, 1.0)))

    def call(self, function: Callable, *arguments: Any) -> SpatialVector:
        """Return the vector that a function returns; arguments : SpatialVectors, Exprs, or nested tuples of Exprs."""
        values = (x.value if isinstance(x, SpatialVector) else x for x in arguments)
        return SpatialVector(self.program.call(function, *values))

    def frame(self, body: int) -> Expr:
        """Return the Frame of a body."""
        raise NotImplementedError

    def to_fixed_frame(self, body: int, vector: SpatialVector) -> SpatialVector:
        """Return a vector of a body's frame, or of the ground's, in the fixed frame."""
        return self.call(to_fixed_frame, self.frame(body), vector) if body else vector

    def to_body_frame(self, body: int, vector: SpatialVector) -> SpatialVector:
        """Return a vector of the fixed frame in that of a body."""
        return self.call(to_body_frame, self.frame(body), vector)

    def z_axis(self, body: int) -> SpatialVector:
        """Return the z axis of a body or the ground."""
        return self.vertical if self.tree.is_vertical(body) else self.call(form.axis_z, self.frame(body))

    def arm(self, body: int, point: Expr) -> SpatialVector:
        """Return a point, given in the frame of its body, from the centre of mass."""
        vector = SpatialVector(point)
        return self.to_fixed_frame(body, vector - self._center(body)) if body else vector

    def near_arm(self, body: int) -> SpatialVector:
        """Return the attachment point of a body from the centre of mass of its parent."""
        return self.arm(self.tree.part(body).parent, self.mechanism.attachments[body - 1].near)

    def own_arm(self, body: int) -> SpatialVector:
        """Return the centre of mass of a body from its attachment point."""
        far_end = SpatialVector(self.mechanism.attachments[body - 1].far)
        return self.to_fixed_frame(body, self._center(body) - far_end)

    def _center(self, body: int) -> SpatialVector:
        return SpatialVector(self.mechanism.parts[body - 1].center)

    def slides(self, body: int) -> bool:
        """Return whether a body slides along an axis."""
        return self.tree.part(body).form in (form.Slide, form.Sleeve)

    def along_axis(self, body: int, amounts: Expr) -> SpatialVector:
        """Return the vector of an amount along the axis on which a body slides; zero for one that does not.

        amounts : of all coordinates
        """
        return amounts[self.tree.part(body).coordinate] * self.axis(body) if self.slides(body) else NO_VECTOR

    def axis(self, body: int) -> SpatialVector:
        """Return the axis along which a body slides."""
        part = self.tree.part(body)
        if part.form is form.Sleeve:
            return self.z_axis(part.parent)
        return self.to_fixed_frame(part.parent, SpatialVector(self.mechanism.attachments[body - 1].axis))


class PosedBodies(Bodies):
    """The bodies of a tree in a program whose second parameter is their Pose."""

    def __init__(self, tree: form.MachineType, parameters: int = 2):
        super().__init__(tree, parameters)
        self.pose = self.program.parameters[1]

    def frame(self, body: int) -> Expr:
        """Return the Frame of a body or the ground."""
        frame: Expr = self.pose.frames[body - 1] if body else self.program.call(form.on_ground, 1.0, 0.0)
        return frame

    def spin(self, body: int) -> SpatialVector:
        """Return the angular velocity of a body."""
        return self._quantity(self.pose.spins, body)

    def centre(self, body: int) -> SpatialVector:
        """Return the position of a body's centre of mass."""
        return self._quantity(self.pose.centres_of_mass, body)

    def velocity(self, body: int) -> SpatialVector:
        """Return the velocity of a body's centre of mass."""
        return self._quantity(self.pose.velocities, body)

    def _quantity(self, vectors: Expr, body: int) -> SpatialVector:
        """Return a vector of a body from the pose; it is zero for the ground."""
        return SpatialVector(vectors[body - 1]) if body else NO_VECTOR


# ---------------------------------------------------------------------------------------------- pose and observables


class _MovedBodies(Bodies):
    """The bodies of a tree in a program whose second parameter is its state."""

    def __init__(self, tree: form.MachineType):
        super().__init__(tree, 2)
        y, n = self.program.parameters[1], tree.coordinates
        self.q, self.rates, self.time = [y[i] for i in range(n)], [y[n + i] for i in range(n)], y[2 * n]
        self.angle = (self.mechanism.speed * self.time).assigned()
        #: Of each body, by its number; the ground is body 0.
        self.frames: list[Expr] = [self.program.call(form.on_ground, 1.0, 0.0)]
        self.spins, self.centres, self.velocities = [NO_VECTOR], [NO_VECTOR], [NO_VECTOR]
        self.quaternion_motions: list[tuple] = [()]

    def frame(self, body: int) -> Expr:
        """Return the Frame of a body."""
        return self.frames[body]

    def turn(self, body: int) -> None:
        """Add frame, angular velocity and QuaternionMotion of a body."""
        part = self.tree.part(body)
        k, parent, motion = part.coordinate, part.parent, ()
        if part.form is form.Driven:
            cosine_and_sine = self.program.call(direction_of, self.angle)
            frame = self.program.call(form.on_ground, cosine_and_sine[0], cosine_and_sine[1])
            spin = self.call(Vector, 0.0, 0.0, self.mechanism.speed)
        elif part.turns_freely:
            motion = QuaternionMotion(*self.q[k : k + 4], *self.rates[k : k + 4])
            frame = self.program.call(frame_of, *self.q[k : k + 4])
            spin = self.call(to_fixed_frame, frame, self.program.call(spin_of, motion))
        elif part.form is form.Slide:
            frame, spin = self.frames[parent], self.spins[parent]
        else:
            k += part.form is form.Sleeve
            cosine_and_sine = self.program.call(direction_of, self.q[k])
            components = cosine_and_sine[0], cosine_and_sine[1]
            frame = (
                self.program.call(form.turned_about_z, self.frames[parent], *components)
                if parent
                else self.program.call(form.on_ground, *components)
            )
            spin = self.spins[parent] + self.rates[k] * self.z_axis(parent)
        self.frames.append(frame)
        self.spins.append(spin)
        self.quaternion_motions.append(motion)

    def move(self, body: int) -> None:
        """Add position and velocity of a body's centre of mass, whose frame has been added."""
        part = self.tree.part(body)
        k, parent = part.coordinate, part.parent
        if part.form is form.Loose:
            self.centres.append(self.call(Vector, *self.q[k + 4 : k + 7]))
            self.velocities.append(self.call(Vector, *self.rates[k + 4 : k + 7]))
            return
        own_arm = self.own_arm(body)
        arm = self.near_arm(body) + self.along_axis(body, self.q)
        self.centres.append(self.centres[parent] + arm + own_arm)
        velocity = self.velocities[parent] + self.spins[parent].cross(arm) + self.along_axis(body, self.rates)
        self.velocities.append(velocity + self.spins[body].cross(own_arm))


@generated(form.MachineType)
def pose_of(tree: form.MachineType) -> Program:
    """Return the program of `contract.pose_at`."""
    bodies = _MovedBodies(tree)
    for body in range(1, len(tree.parts) + 1):
        bodies.turn(body)
        bodies.move(body)
    spins, centres, velocities = (
        tuple(vector.value for vector in vectors[1:]) for vectors in (bodies.spins, bodies.centres, bodies.velocities)
    )
    return bodies.program.returns(
        form.Pose(
            bodies.angle,
            tuple(bodies.q),
            tuple(bodies.rates),
            tuple(bodies.frames[1:]),
            spins,
            centres,
            velocities,
            tuple(bodies.quaternion_motions[1:]),
        )
    )


@generated(form.MachineType)
def gaps_of(tree: form.MachineType) -> Program:
    """Return the program of `contract.gaps`."""
    bodies, joint_gaps = PosedBodies(tree), []
    for j, (bearing, journal) in enumerate(tree.openings):
        opening = bodies.mechanism.openings[j]
        bearing_position, bearing_velocity = _point_motion(bodies, bearing, opening.at_bearing)
        journal_position, journal_velocity = _point_motion(bodies, journal, opening.at_journal)
        observed = (
            journal_position - bearing_position,
            journal_velocity - bearing_velocity,
            bodies.to_fixed_frame(bearing, SpatialVector(opening.axis)),
            bodies.spin(bearing),
            bodies.spin(journal),
        )
        in_journal = (bodies.to_body_frame(journal, vector).value for vector in observed)
        joint_gaps.append(SpatialGap(*in_journal, bodies.frame(journal)))
    return bodies.program.returns(tuple(joint_gaps))


def _point_motion(bodies: PosedBodies, body: int, point: Expr) -> tuple[SpatialVector, SpatialVector]:
    """Return position and velocity of a point of a body."""
    arm = bodies.arm(body, point)
    return bodies.centre(body) + arm, bodies.velocity(body) + bodies.spin(body).cross(arm)


@generated(form.MachineType)
def bearing_axes_of(tree: form.MachineType) -> Program:
    """Return the program of a pose's bearing axes: their own x axes in the frames of the journals."""
    bodies, axes = PosedBodies(tree), []
    for j, (bearing, journal) in enumerate(tree.openings):
        across = bodies.to_fixed_frame(bearing, SpatialVector(bodies.mechanism.openings[j].across))
        axes.append(bodies.to_body_frame(journal, across).value)
    return bodies.program.returns(tuple(axes))


@generated(form.MachineType)
def energy_of(tree: form.MachineType) -> Program:
    """Return the program of `contract.energy`."""
    bodies, twice_kinetic, gravity_powers = PosedBodies(tree), [], []
    for body in range(1, len(tree.parts) + 1):
        part, velocity = bodies.mechanism.parts[body - 1], bodies.velocity(body)
        spin = bodies.to_body_frame(body, bodies.spin(body))
        momentum = SpatialVector(part.inertia).componentwise(spin)
        twice_kinetic += [part.mass * velocity.dot(velocity), spin.dot(momentum)]
        gravity_powers.append(part.mass * velocity.dot(SpatialVector(bodies.mechanism.gravity)))
    return bodies.program.returns((0.5 * sum_of(twice_kinetic), sum_of(gravity_powers)))


@generated(form.MachineType)
def body_motions_of(tree: form.MachineType) -> Program:
    """Return the program of `contract.body_motions`: the motion in the plane x, y."""
    bodies, motions = PosedBodies(tree), []
    for body in range(1, len(tree.parts) + 1):
        part, frame, spin = bodies.mechanism.parts[body - 1], bodies.frame(body), bodies.spin(body)
        principal = SpatialVector(part.inertia).componentwise(bodies.to_body_frame(body, spin))
        vectors_in_plane = (bodies.centre(body), bodies.velocity(body))
        vectors_in_plane += tuple(spin.cross(bodies.call(axis, frame)) for axis in (form.axis_x, form.axis_y))
        components = [vector[k] for vector in vectors_in_plane for k in range(2)]
        motions.append(BodyMotion(part.mass, bodies.to_fixed_frame(body, principal)[2], *components, ONE))
    return bodies.program.returns(tuple(motions))


@generated(form.MachineType)
def histories_of(tree: form.MachineType) -> Program:
    """Return the program of the time histories that `contract.describe` returns: (mechanism, pose, y, motion)."""
    bodies = PosedBodies(tree, 4)
    _, pose, y, motion = bodies.program.parameters
    output, rate = _output_motion(bodies)
    values = [y[2 * tree.coordinates], pose.angle, motion.torque, output, rate, motion.output]
    for body in tree.reported:
        position, velocity, spin = bodies.centre(body), bodies.velocity(body), bodies.spin(body)
        values += [vector[axis] for vector in (position, velocity) for axis in range(3)]
        quaternion = _quaternion(bodies, body)
        values += [quaternion[k] for k in range(4)]
        values += [spin[axis] for axis in range(3)]
    return bodies.program.returns(tuple(values))


def _quaternion(bodies: PosedBodies, body: int) -> Expr:
    """Return a body's unit quaternion; for an attached body, from its rotation about its own z axis."""
    part = bodies.tree.part(body)
    if part.turns_freely:
        return bodies.program.call(form.quaternion_of, bodies.pose.quaternion_motions[body - 1])
    parent_quaternion = _quaternion(bodies, part.parent) if part.parent else bodies.program.known((1.0, 0.0, 0.0, 0.0))
    if part.form is form.Slide:
        return parent_quaternion
    rotation = (
        bodies.pose.angle if part.form is form.Driven else bodies.pose.q[part.coordinate + (part.form is form.Sleeve)]
    )
    return bodies.program.call(form.turned_quaternion, parent_quaternion, rotation)


def _output_motion(bodies: PosedBodies) -> tuple[Expr, Expr]:
    """Return the output's position and its rate."""
    tree, body, mechanism, pose = bodies.tree, bodies.tree.aimed, bodies.mechanism, bodies.pose
    if not tree.has_point_aim:
        angles, rates = [], []
        while body:
            part = tree.part(body)
            if part.form is form.Driven:
                angles.append(pose.angle)
                rates.append(mechanism.speed)
            elif part.form is not form.Slide:
                rotation_index = part.coordinate + (part.form is form.Sleeve)
                angles.append(pose.q[rotation_index])
                rates.append(pose.rates[rotation_index])
            body = part.parent
        return sum_of(angles), sum_of(rates)
    position, velocity = _point_motion(bodies, body, mechanism.aim.point)
    direction = SpatialVector(mechanism.aim.direction)
    return direction.dot(position), direction.dot(velocity)


@generated(form.MachineType)
def output_of(tree: form.MachineType) -> Program:
    """Return the program of a pose's output: position and rate."""
    bodies = PosedBodies(tree)
    return bodies.program.returns(_output_motion(bodies))
