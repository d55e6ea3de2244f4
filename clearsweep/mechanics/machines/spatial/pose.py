"""The pose of a tree, and functions that the generated code calls."""

from typing import NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.family import inlined
from ....tracing.compiled.vector import Frame, Vector


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
