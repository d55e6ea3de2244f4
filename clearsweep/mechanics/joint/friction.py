"""Tangential contact force over sliding speed."""

from typing import NamedTuple

from ..compiled import calculus as math
from ..compiled.family import family, kernel
from .internal_state import memory, memory_rate, recalled


@family
def friction_force(friction, normal, slip):
    """Return the tangential force (N) at normal force `normal` (N) and sliding speed `slip` (m/s); it opposes `slip`.

    `normal` is at least 0, but in trial steps past the end of a contact.
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


class Karnopp(NamedTuple):
    """Slides as Stribeck's law down to the sliding speed `band`; below it sticks, which `stick.held` sees to."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    band: float  # m/s


class Dahl(NamedTuple):
    """T = -N sigma0 z with bristles bent by z: z' = slip (1 - x)^shape, x = sigma0 z sgn(slip) / mu.

    In the ledger of energies the work of T is rubbed off, what bristles store included, until they give it back.
    """

    coefficient: float  # mu, 1
    bristle_stiffness: float  # sigma0, 1/m, per load
    shape: float  # 1
    bend: float = 0.0  # z, m


class LuGre(NamedTuple):
    """T = -N (sigma0 z + sigma1(slip) z' + viscous slip) with z' = slip - sigma0 |slip| z / g(slip); ledger as Dahl."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    bristle_stiffness: float  # sigma0, 1/m, per load
    bristle_damping: float  # sigma1 at rest, s/m, per load
    damping_velocity: float  # m/s, sigma1 falls with exp(-(slip / damping_velocity)^2)
    bend: float = 0.0  # z, m


@kernel
def stribeck_coefficient(friction, slip):
    """Return mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape)."""
    fall = math.exp(-(abs(slip / friction.stribeck_velocity) ** friction.shape))
    return friction.coefficient + (friction.static_coefficient - friction.coefficient) * fall


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
    share = stribeck_coefficient(friction, slip)
    return -normal * (share * math.tanh(slip / friction.velocity_scale) + friction.viscous * slip)


@friction_force.member(Karnopp)
def _karnopp(friction, normal, slip):
    sign = min(max(slip / friction.band, -1.0), 1.0)  # no jump in a step that runs into the band and is cut there
    return -normal * (stribeck_coefficient(friction, slip) * sign + friction.viscous * slip)


# ---------------------------------------------------------------------------------------------- with bristles


@friction_force.member(Dahl)
def _dahl(friction, normal, slip):
    return -normal * friction.bristle_stiffness * friction.bend


@friction_force.member(LuGre)
def _lugre(friction, normal, slip):
    fall = math.exp(-((slip / friction.damping_velocity) ** 2))
    share = friction.bristle_stiffness * friction.bend
    share += friction.bristle_damping * fall * memory_rate(friction, slip)
    return -normal * (share + friction.viscous * slip)


@memory_rate.member(Dahl)
def _dahl_rate(friction, slip):
    rest = 1.0 - friction.bristle_stiffness * friction.bend * math.copysign(1.0, slip) / friction.coefficient
    return slip * math.copysign(abs(rest) ** friction.shape, rest)


@memory_rate.member(LuGre)
def _lugre_rate(friction, slip):
    return slip - friction.bristle_stiffness * abs(slip) * friction.bend / stribeck_coefficient(friction, slip)


@recalled.member(Dahl)
def _dahl_recalled(friction, y, place):
    return Dahl(friction.coefficient, friction.bristle_stiffness, friction.shape, y[place])


@recalled.member(LuGre)
def _lugre_recalled(friction, y, place):
    return LuGre(
        friction.coefficient,
        friction.static_coefficient,
        friction.stribeck_velocity,
        friction.shape,
        friction.viscous,
        friction.bristle_stiffness,
        friction.bristle_damping,
        friction.damping_velocity,
        y[place],
    )


@memory.member(Dahl)
@memory.member(LuGre)
def _bend_of_sliding(friction):
    return (friction.coefficient / friction.bristle_stiffness,)
