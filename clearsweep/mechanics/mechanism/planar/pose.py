"""Where the bodies of a planar machine are and how they move: what everything else follows from."""

from typing import NamedTuple


class Turn(NamedTuple):
    """How the bodies of a group are turned."""

    c: float  # cosine of their angle
    s: float
    angle: float  # rad
    rate: float  # rad/s


class Pose(NamedTuple):
    """Where the bodies are and how they move."""

    turns: tuple  # a Turn for each group but the ground's
    runs: tuple  # (m, m/s) along each guide of the tree
    roots: tuple  # (x m, y m, vx m/s, vy m/s) of the centre of mass of each body that floats
    time: float  # s
