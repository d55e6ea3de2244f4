"""The compiled form of a spatial tree: types define the topology, values the dimensions.

Bodies are numbered after their parents, by the number of empty tuples in a tuple; the ground is 0.  All
points are in the frame of their body, which is the planar machine's, z along the pins.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.family import inlined
from ....tracing.compiled.vector import Frame, Vector

# ---------------------------------------------------------------------------------------------- the compiled form


class Solid(NamedTuple):
    """A body in space, in its own frame; compiled, it has Vectors in place of tuples, and no points."""

    mass: float  # kg
    inertia: tuple[float, ...]  # kg m^2, principal, about the centre of mass, on the axes of its frame
    center: tuple[float, ...]  # m, centre of mass
    points: Mapping[str, tuple[float, ...]]  # m


class Driven(NamedTuple):
    """The crank, which rotates on the ground at constant speed."""

    near: Vector  # m, pin on the ground
    far: Vector  # m, on the crank


class Hinge(NamedTuple):
    """Rotates about the z axis of its parent."""

    parent: tuple  # number of the body
    near: Vector  # m, the pin on it
    far: Vector  # m, on the body that hangs


class Slide(NamedTuple):
    """Slides along an axis of its parent without rotation."""

    parent: tuple
    near: Vector
    far: Vector
    axis: Vector  # unit vector, in the frame of the parent


class Ball(NamedTuple):
    """Rotates freely about a point."""

    parent: tuple
    near: Vector
    far: Vector


class Sleeve(NamedTuple):
    """Rotates about the z axis of its parent and slides along it."""

    parent: tuple
    near: Vector
    far: Vector


class Loose(NamedTuple):
    """Not attached: all its joints have clearance."""


class Opening(NamedTuple):
    """A joint with clearance."""

    bearing: tuple  # number of the body
    journal: tuple
    at_bearing: Vector  # m, nominal middle, in the frame of the bearing's body
    at_journal: Vector  # m, middle of the journal
    axis: Vector  # unit vector along the bearing, in the frame of its body
    across: Vector  # unit vector of its own x axis


class Tree(NamedTuple):
    """The compiled form of a machine in space."""

    parts: tuple  # of Solid
    attachments: tuple  # the attachment of each body
    openings: tuple  # of Opening, in the order of the joints with clearance
    reported: tuple  # numbers of the bodies in the order of the channels
    aim: tuple  # Aim, with a point and a unit vector, or () for both where the angle about z is the output
    speed: float  # rad/s, of the crank
    gravity: Vector  # m/s^2
    cycle: tuple  # planar.cycle.Cycle of the output of the machine without clearance


# ---------------------------------------------------------------------------------------------- its structure


COORDINATES = {Driven: 0, Hinge: 1, Slide: 1, Sleeve: 2, Ball: 4, Loose: 7}
SPEEDS = {Driven: 0, Hinge: 1, Slide: 1, Sleeve: 2, Ball: 3, Loose: 6}


class BodyNode:
    """A body in the type of a tree: attachment, parent, first coordinate and first speed."""

    def __init__(self, form: type, parent: int, coordinate: int, speed: int):
        self.form, self.parent, self.coordinate, self.speed = form, parent, coordinate, speed

    @property
    def turns_freely(self) -> bool:
        """Return whether the body has a quaternion."""
        return self.form in (Ball, Loose)


class MachineType:
    """The structure of a Tree."""

    def __init__(self, tree: Tree):
        self.parts: list[BodyNode] = []
        coordinate = speed = 0
        for attachment in tree.attachments:
            form, parent = type(attachment), len(getattr(attachment, "parent", ()))
            self.parts.append(BodyNode(form, parent, coordinate, speed))
            coordinate, speed = coordinate + COORDINATES[form], speed + SPEEDS[form]
        self.coordinates, self.speeds = coordinate, speed
        self.openings = [(len(opening.bearing), len(opening.journal)) for opening in tree.openings]
        self.reported = [len(number) for number in tree.reported]
        aim: Any = tree.aim  # mypy takes it for a tuple of anything
        self.has_point_aim, self.aimed = isinstance(aim.point, Vector), len(aim.body)
        self.crank = 1 + next(i for i, part in enumerate(self.parts) if part.form is Driven)

    def part(self, body: int) -> BodyNode:
        """Return a body that moves by its number."""
        return self.parts[body - 1]

    def is_vertical(self, body: int) -> bool:
        """Return whether the z axis of a body is that of the fixed frame."""
        while body and self.part(body).form in (Driven, Hinge, Slide, Sleeve):
            body = self.part(body).parent
        return body == 0


# ---------------------------------------------------------------------------------------------- the pose


class Pose(NamedTuple):
    """Positions and velocities of the bodies; index: number of the body minus one."""

    angle: float  # rad, of the crank
    q: tuple  # coordinates
    rates: tuple  # their rates
    frames: tuple  # Frame of each body
    spins: tuple  # rad/s, Vector in the fixed frame
    centres_of_mass: tuple  # m, Vector in the fixed frame
    velocities: tuple  # m/s
    quaternion_motions: tuple  # QuaternionMotion of each body with a quaternion, () for the others


@inlined
def on_ground(c, s):
    """Return the Frame of a body rotated about z by the angle of this cosine and sine."""
    zero, unit = 0.0 * c, 0.0 * c + 1.0  # of the type of c: a number, with or without slopes
    return Frame(Vector(c, -s, zero), Vector(s, c, zero), Vector(zero, zero, unit))


@inlined
def turned_about_z(frame, c, s):
    """Return a Frame rotated about its own z axis."""
    return Frame(_row(frame.x, c, s), _row(frame.y, c, s), _row(frame.z, c, s))


@inlined
def _row(row, c, s):
    return Vector(row.x * c + row.y * s, row.y * c - row.x * s, row.z)


@inlined
def axis_x(frame):
    """Return the x axis of a body in the fixed frame."""
    return Vector(frame.x.x, frame.y.x, frame.z.x)


@inlined
def axis_y(frame):
    """Return the y axis of a body in the fixed frame."""
    return Vector(frame.x.y, frame.y.y, frame.z.y)


@inlined
def axis_z(frame):
    """Return the z axis of a body in the fixed frame."""
    return Vector(frame.x.z, frame.y.z, frame.z.z)


@inlined
def elementwise_product(a, b):
    """Return the element-wise product of two vectors."""
    return Vector(a.x * b.x, a.y * b.y, a.z * b.z)


@inlined
def transported(acceleration, alpha, spin, arm):
    """Return the acceleration of a point at `arm` (m) from a point with `acceleration`, on a rotating body."""
    wx, wy, wz = spin.y * arm.z - spin.z * arm.y, spin.z * arm.x - spin.x * arm.z, spin.x * arm.y - spin.y * arm.x
    return Vector(
        acceleration.x + alpha.y * arm.z - alpha.z * arm.y + spin.y * wz - spin.z * wy,
        acceleration.y + alpha.z * arm.x - alpha.x * arm.z + spin.z * wx - spin.x * wz,
        acceleration.z + alpha.x * arm.y - alpha.y * arm.x + spin.x * wy - spin.y * wx,
    )


@inlined
def quaternion_of(orientation):
    """Return the quaternion of a QuaternionMotion, w x y z, of length 1."""
    w, x, y, z = orientation.w, orientation.x, orientation.y, orientation.z
    inverse = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * inverse, x * inverse, y * inverse, z * inverse


@inlined
def turned_quaternion(quaternion, angle):
    """Return a quaternion rotated by an angle (rad) about the z axis of its body."""
    w, x, y, z = quaternion
    c, s = math.cos(0.5 * angle), math.sin(0.5 * angle)
    return w * c - z * s, x * c + y * s, y * c - x * s, w * s + z * c
