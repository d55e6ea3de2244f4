"""Tangential contact force over sliding speed."""

import math
from typing import NamedTuple

from .family import family


@family
def friction_force(friction, normal, slip):
    """Return the tangential force (N) at normal force `normal` (N) and sliding speed `slip` (m/s); it opposes `slip`."""


class Frictionless(NamedTuple):
    """No tangential force; the sliding speed is never computed for it."""


class Tanh(NamedTuple):
    """T = -mu N tanh(slip / scale)."""

    coefficient: float  # 1
    velocity_scale: float  # m/s


class Ambrosio(NamedTuple):
    """T = -mu N sgn(slip) times 0 below v0, 1 above v1, linear between."""

    coefficient: float  # 1
    v0: float  # m/s
    v1: float  # m/s


@friction_force.member(Frictionless)
def _frictionless(friction, normal, slip):
    return 0.0


@friction_force.member(Tanh)
def _tanh(friction, normal, slip):
    return -friction.coefficient * normal * math.tanh(slip / friction.velocity_scale)


@friction_force.member(Ambrosio)
def _ambrosio(friction, normal, slip):
    share = min(max((abs(slip) - friction.v0) / (friction.v1 - friction.v0), 0.0), 1.0)
    return -friction.coefficient * normal * math.copysign(share, slip)
