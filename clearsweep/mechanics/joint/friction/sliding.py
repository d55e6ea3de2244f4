"""Friction that follows the sliding speed: none of these laws sticks."""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.family import kernel
from .contract import friction_force


class Tanh(NamedTuple):
    """T = -mu N tanh(slip / scale)."""

    coefficient: float  # 1
    velocity_scale: float  # m/s


@friction_force.member(Tanh)
def _tanh(friction, normal, slip):
    return -friction.coefficient * normal * math.tanh(slip / friction.velocity_scale)


class Ambrosio(NamedTuple):
    """T = -mu N sgn(slip) times 0 below v0, 1 above v1, linear between."""

    coefficient: float  # 1
    v0: float  # m/s
    v1: float  # m/s


@friction_force.member(Ambrosio)
def _ambrosio(friction, normal, slip):
    share = min(max((abs(slip) - friction.v0) / (friction.v1 - friction.v0), 0.0), 1.0)
    return -friction.coefficient * normal * math.copysign(share, slip)


class Threlfall(NamedTuple):
    """T = -mu N sgn(slip) times (1 - exp(-3 |slip| / scale)) / 0.95 up to the scale, 1 above it."""

    coefficient: float  # 1
    velocity_scale: float  # m/s


@friction_force.member(Threlfall)
def _threlfall(friction, normal, slip):
    x = abs(slip) / friction.velocity_scale
    share = -math.expm1(-3.0 * x) / 0.95 if x <= 1.0 else 1.0
    return -friction.coefficient * normal * math.copysign(share, slip)


class BengisuAkay(NamedTuple):
    """T = -N sgn(slip) times a parabola up to the static coefficient at the scale, then falling exponentially."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    velocity_scale: float  # m/s
    decay: float  # s/m


@friction_force.member(BengisuAkay)
def _bengisu_akay(friction, normal, slip):
    beyond = abs(slip) - friction.velocity_scale
    if beyond < 0.0:
        share = friction.static_coefficient * (1.0 - (beyond / friction.velocity_scale) ** 2)
    else:
        fall = math.exp(-friction.decay * beyond)
        share = friction.coefficient + (friction.static_coefficient - friction.coefficient) * fall
    return -normal * math.copysign(share, slip)


class Stribeck(NamedTuple):
    """T = -N (mu_d + (mu_s - mu_d) exp(-|slip / stribeck|^shape)) tanh(slip / scale) - N viscous slip."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    velocity_scale: float  # m/s


@kernel
def stribeck_coefficient(friction, slip):
    """Return mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape)."""
    fall = math.exp(-(abs(slip / friction.stribeck_velocity) ** friction.shape))
    return friction.coefficient + (friction.static_coefficient - friction.coefficient) * fall


@friction_force.member(Stribeck)
def _stribeck(friction, normal, slip):
    share = stribeck_coefficient(friction, slip)
    return -normal * (share * math.tanh(slip / friction.velocity_scale) + friction.viscous * slip)
