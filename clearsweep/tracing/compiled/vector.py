"""Vectors of three numbers, with or without a slope, and the orientation of a body in space."""

from typing import NamedTuple

from . import calculus as math
from .family import inlined

# ----------------------------------------------------------------------------------------------------------------------
# Vectors of three numbers, with or without a slope.


class Vector(NamedTuple):
    """Three numbers along the axes of a frame."""

    x: float
    y: float
    z: float


@inlined
def plus(a, b):
    """Return a + b."""
    return Vector(a.x + b.x, a.y + b.y, a.z + b.z)


@inlined
def minus(a, b):
    """Return a - b."""
    return Vector(a.x - b.x, a.y - b.y, a.z - b.z)


@inlined
def times(factor, a):
    """Return a number times a vector."""
    return Vector(factor * a.x, factor * a.y, factor * a.z)


@inlined
def plus_scaled(a, factor, b):
    """Return a + factor b."""
    return Vector(a.x + factor * b.x, a.y + factor * b.y, a.z + factor * b.z)


@inlined
def dot(a, b):
    """Return the product a . b."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@inlined
def cross(a, b):
    """Return the product a x b."""
    return Vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@inlined
def norm(a):
    """Return the length of a vector."""
    return math.sqrt(a.x * a.x + a.y * a.y + a.z * a.z)


# ----------------------------------------------------------------------------------------------------------------------
# Orientation of a body in space by four coordinates, a quaternion of any length.
#
# The rotation is that of the quaternion over its length, so that rounding and errors of integration cannot deform a
# body.
# The length has no meaning; its own dynamics return it to 1 (critically damped): with
#
#     dq/dt = q (0, omega) / 2 + sigma q,    sigma = q . dq/dt / q^2,
#
# omega being in the frame of the body, the rates of q are those of this rotation exactly, whatever sigma is, if
#
#     d2q/dt2 = q (0, alpha) / 2 - omega^2 q / 4 + sigma q (0, omega) + (sigma^2 + dsigma/dt) q,
#
# and dsigma/dt = -2 beta sigma - beta^2 (q^2 - 1) / 2, which can be chosen freely.


class Frame(NamedTuple):
    """A body's frame: the axes of the fixed frame, each in the frame of the body; the rows of its rotation matrix."""

    x: Vector
    y: Vector
    z: Vector


@inlined
def to_body_frame(frame, a):
    """Return a vector of the fixed frame in the frame of the body."""
    x, y, z = frame
    return Vector(
        a.x * x.x + a.y * y.x + a.z * z.x, a.x * x.y + a.y * y.y + a.z * z.y, a.x * x.z + a.y * y.z + a.z * z.z
    )


@inlined
def to_fixed_frame(frame, a):
    """Return a vector of the body's frame in the fixed frame."""
    return Vector(dot(frame.x, a), dot(frame.y, a), dot(frame.z, a))


@inlined
def frame_of(w, x, y, z):
    """Return the Frame that a quaternion of any length represents."""
    factor = 2.0 / (w * w + x * x + y * y + z * z)
    return Frame(
        Vector(1.0 - factor * (y * y + z * z), factor * (x * y - w * z), factor * (x * z + w * y)),
        Vector(factor * (x * y + w * z), 1.0 - factor * (x * x + z * z), factor * (y * z - w * x)),
        Vector(factor * (x * z - w * y), factor * (y * z + w * x), 1.0 - factor * (x * x + y * y)),
    )


class QuaternionMotion(NamedTuple):
    """A quaternion and its rates."""

    w: float
    x: float
    y: float
    z: float
    dw: float  # 1/s
    dx: float
    dy: float
    dz: float


@inlined
def spin_of(q):
    """Return the angular velocity (rad/s) of a rotating body in its own frame."""
    factor = 2.0 / (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z)
    return Vector(
        factor * (q.w * q.dx - q.x * q.dw - q.y * q.dz + q.z * q.dy),
        factor * (q.w * q.dy - q.y * q.dw - q.z * q.dx + q.x * q.dz),
        factor * (q.w * q.dz - q.z * q.dw - q.x * q.dy + q.y * q.dx),
    )


@inlined
def quaternion_accelerations(q, spin, alpha, damping):
    """Return the accelerations (1/s^2) of the quaternion of a rotating body with angular acceleration `alpha`, rad/s^2.

    spin, alpha : in the frame of the body; damping : 1/s, rate at which the quaternion's length returns to 1.
    """
    square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z
    factor = 2.0 / square  # as in `frame_of` and `spin_of`, which code computes once
    sigma = 0.5 * factor * (q.w * q.dw + q.x * q.dx + q.y * q.dy + q.z * q.dz)
    scalar_term = (
        sigma * sigma - 2.0 * damping * sigma - 0.5 * damping * damping * (square - 1.0) - 0.25 * dot(spin, spin)
    )
    ax = 0.5 * alpha.x + sigma * spin.x
    ay = 0.5 * alpha.y + sigma * spin.y
    az = 0.5 * alpha.z + sigma * spin.z
    return (
        scalar_term * q.w - q.x * ax - q.y * ay - q.z * az,
        scalar_term * q.x + q.w * ax + q.y * az - q.z * ay,
        scalar_term * q.y + q.w * ay + q.z * ax - q.x * az,
        scalar_term * q.z + q.w * az + q.x * ay - q.y * ax,
    )
