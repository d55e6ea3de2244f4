"""Tangential contact force over sliding speed."""

from typing import NamedTuple

from . import calculus as math
from .family import family


@family
def friction_force(friction, normal, slip):
    """Return the tangential force (N) at normal force `normal` (N) and sliding speed `slip` (m/s); it opposes `slip`.

    `normal` is at least 0.
    """


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


class Threlfall(NamedTuple):
    """T = -mu N sgn(slip) times (1 - exp(-3 |slip| / scale)) / 0.95 up to the scale, 1 above it."""

    coefficient: float  # 1
    velocity_scale: float  # m/s


class BengisuAkay(NamedTuple):
    """T = -N sgn(slip) times a parabola up to the static coefficient at the scale, then falling exponentially."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    velocity_scale: float  # m/s
    decay: float  # s/m


class Stribeck(NamedTuple):
    """T = -N (mu_d + (mu_s - mu_d) exp(-|slip / stribeck|^shape)) tanh(slip / scale) - N viscous slip."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    velocity_scale: float  # m/s


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


@friction_force.member(Threlfall)
def _threlfall(friction, normal, slip):
    x = abs(slip) / friction.velocity_scale
    share = -math.expm1(-3.0 * x) / 0.95 if x <= 1.0 else 1.0
    return -friction.coefficient * normal * math.copysign(share, slip)


@friction_force.member(BengisuAkay)
def _bengisu_akay(friction, normal, slip):
    beyond = abs(slip) - friction.velocity_scale
    if beyond < 0.0:
        share = friction.static_coefficient * (1.0 - (beyond / friction.velocity_scale) ** 2)
    else:
        fall = math.exp(-friction.decay * beyond)
        share = friction.coefficient + (friction.static_coefficient - friction.coefficient) * fall
    return -normal * math.copysign(share, slip)


@friction_force.member(Stribeck)
def _stribeck(friction, normal, slip):
    fall = math.exp(-(abs(slip / friction.stribeck_velocity) ** friction.shape))
    share = friction.coefficient + (friction.static_coefficient - friction.coefficient) * fall
    return -normal * (share * math.tanh(slip / friction.velocity_scale) + friction.viscous * slip)
