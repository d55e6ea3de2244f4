"""Friction over bristles that remember how far they are bent."""

from typing import NamedTuple

from ...compiled import calculus as math
from ..internal_state import memory, memory_rate, recalled
from .contract import friction_force
from .sliding import stribeck_coefficient


def _bend_of_sliding(friction):
    return (friction.coefficient / friction.bristle_stiffness,)


class Dahl(NamedTuple):
    """T = -N sigma0 z with bristles bent by z: z' = slip (1 - x)^shape, x = sigma0 z sgn(slip) / mu.

    In the ledger of energies the work of T is rubbed off, what bristles store included, until they give it back.
    """

    coefficient: float  # mu, 1
    bristle_stiffness: float  # sigma0, 1/m, per load
    shape: float  # 1
    bend: float = 0.0  # z, m


@friction_force.member(Dahl)
def _dahl(friction, normal, slip):
    return -normal * friction.bristle_stiffness * friction.bend


memory.member(Dahl)(_bend_of_sliding)


@recalled.member(Dahl)
def _dahl_recalled(friction, y, place):
    return Dahl(friction.coefficient, friction.bristle_stiffness, friction.shape, y[place])


@memory_rate.member(Dahl)
def _dahl_rate(friction, slip):
    rest = 1.0 - friction.bristle_stiffness * friction.bend * math.copysign(1.0, slip) / friction.coefficient
    return slip * math.copysign(abs(rest) ** friction.shape, rest)


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


@friction_force.member(LuGre)
def _lugre(friction, normal, slip):
    fall = math.exp(-((slip / friction.damping_velocity) ** 2))
    share = friction.bristle_stiffness * friction.bend
    share += friction.bristle_damping * fall * memory_rate(friction, slip)
    return -normal * (share + friction.viscous * slip)


memory.member(LuGre)(_bend_of_sliding)


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


@memory_rate.member(LuGre)
def _lugre_rate(friction, slip):
    return slip - friction.bristle_stiffness * abs(slip) * friction.bend / stribeck_coefficient(friction, slip)
