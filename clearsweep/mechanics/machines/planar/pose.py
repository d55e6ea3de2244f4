"""The pose of a planar machine: positions and velocities of its bodies."""

from typing import NamedTuple


class Orientation(NamedTuple):
    """Orientation of the bodies in a group."""

    c: float  # cosine of their angle
    s: float
    angle: float  # rad
    rate: float  # rad/s


class Pose(NamedTuple):
    """Positions and velocities of the bodies."""

    orientations: tuple  # an Orientation for each group except the ground's
    travels: tuple  # (m, m/s) along each guide of the tree
    roots: tuple  # (x m, y m, vx m/s, vy m/s) of each floating body's centre of mass
    time: float  # s
