"""The compiled form of a planar machine: types define the topology, values the dimensions.

The number of a body is the length of a tuple of empty tuples, which needs no memory; the ground is 0.  Points are
measured from the centre of mass of their body in its own frame, and those on its x axis or at the centre have types of
their own, which avoids multiplications by zero.
"""

from typing import NamedTuple


class Mass(NamedTuple):
    """A body that moves."""

    mass: float  # kg
    inertia: float  # kg m^2, about the centre of mass


class Segment(NamedTuple):
    """A further mass of the preceding elastic link, attached by a spring."""

    mass: float  # kg
    inertia: float  # kg m^2, about its centre of mass


class ElasticGuide(NamedTuple):
    """A guide between two masses of an elastic link, with a spring and damper along it."""

    stiffness: float  # N/m
    damping: float  # N s/m


class Centre(NamedTuple):
    """The centre of mass of a body, or the origin of the ground."""


class OnAxis(NamedTuple):
    """A point on the line through the centre of mass along the body's x axis."""

    x: float  # m


class OffAxis(NamedTuple):
    """A point anywhere."""

    x: float  # m
    y: float


class AlongX(NamedTuple):
    """The direction of a frame's x axis."""


class Along(NamedTuple):
    """A direction in a frame."""

    x: float
    y: float


class Hinge(NamedTuple):
    """A revolute joint."""

    site: tuple  # Ideal() or Open()
    proximal: tuple  # number of the body
    distal: tuple
    near: tuple  # Centre, OnAxis or Off, on the proximal body
    far: tuple  # on the distal body


class Slide(NamedTuple):
    """A prismatic joint."""

    site: tuple  # Ideal(), Open() or Sprung
    proximal: tuple
    distal: tuple
    near: tuple
    far: tuple
    axis: tuple  # AlongX or Along, in the frame of the proximal body


class PointAim(NamedTuple):
    """The output is the position of a point along a direction of the fixed frame."""

    body: tuple
    point: tuple
    direction: tuple  # AlongX or Along


class AngleAim(NamedTuple):
    """The output is the angle of a body."""

    body: tuple


class Planar(NamedTuple):
    """The compiled form of a planar machine."""

    bodies: tuple  # of Mass and Segment, without the ground
    joints: tuple  # of Hinge and Slide, in the order of the grid
    dependent: tuple  # indices of the dependent coordinates
    crank: tuple  # number of the driven body
    drive: tuple  # of `drive`
    gravity: float  # m/s^2, along -y
    loads: tuple  # of `loads`
    aim: tuple  # PointAim or AngleAim
    cycle: tuple  # Cycle of the ideal machine: its output, then the dependent coordinates


def as_empty_tuples(count: int) -> tuple:
    """Return a number as a tuple of empty tuples."""
    return ((),) * count


def compile_point(x: float, y: float) -> tuple:
    """Return a point (m, from the centre of mass) in the form without zeros."""
    if y != 0.0:
        return OffAxis(x, y)
    return OnAxis(x) if x != 0.0 else Centre()


def compile_direction(x: float, y: float) -> tuple:
    """Return a unit vector in the form without zeros."""
    return AlongX() if (x, y) == (1.0, 0.0) else Along(x, y)
