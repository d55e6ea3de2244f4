"""The compiled form of a spatial tree: types define the topology, values the dimensions.

Bodies are numbered after their parents, by the number of empty tuples in a tuple; the ground is 0.  All
points are in the frame of their body, which is the planar machine's, z along the pins.
"""

from typing import NamedTuple

from ....tracing.compiled.vector import Vector


class RigidBody(NamedTuple):
    """A body that moves."""

    mass: float  # kg
    inertia: Vector  # kg m^2, principal, about the centre of mass, on the axes of its frame
    center: Vector  # m, centre of mass


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


class PointAim(NamedTuple):
    """The output is the position of a point along a direction of the fixed frame."""

    body: tuple
    point: Vector  # m
    direction: Vector  # unit vector


class AngleAim(NamedTuple):
    """The output is the angle of a body that rotates only about z."""

    body: tuple


class Tree(NamedTuple):
    """The compiled form of a machine in space."""

    parts: tuple  # of Part
    attachments: tuple  # the attachment of each body
    openings: tuple  # of Opening, in the order of the joints with clearance
    reported: tuple  # numbers of the bodies in the order of the channels
    aim: tuple  # PointAim or AngleAim
    speed: float  # rad/s, of the crank
    gravity: Vector  # m/s^2
    cycle: tuple  # planar.cycle.Cycle of the output of the machine without clearance
