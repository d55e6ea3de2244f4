"""Vectors of three numbers, with or without a slope."""

from typing import NamedTuple

from . import calculus as math
from .family import inlined


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


class Symmetric(NamedTuple):
    """A symmetric matrix of three rows."""

    xx: float
    yy: float
    zz: float
    xy: float
    xz: float
    yz: float


@inlined
def matrix_product(matrix, a):
    """Return a Symmetric matrix times a vector."""
    return Vector(
        matrix.xx * a.x + matrix.xy * a.y + matrix.xz * a.z,
        matrix.xy * a.x + matrix.yy * a.y + matrix.yz * a.z,
        matrix.xz * a.x + matrix.yz * a.y + matrix.zz * a.z,
    )
