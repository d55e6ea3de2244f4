"""Normal contact force: the elastic part over penetration, and the laws that add a loss to it."""

import math
from typing import NamedTuple

from .family import family

# ---------------------------------------------------------------------------------------------- elastic part


@family
def elastic_force(elastic, pen):
    """Return the elastic force (N) at penetration `pen` (m, at least 0)."""


class Power(NamedTuple):
    """F = K pen^n."""

    stiffness: float  # N m^-n
    exponent: float  # 1


class PowerThreeHalves(NamedTuple):
    """F = K pen^(3/2), Hertz's exponent: a square root in place of a general power."""

    stiffness: float  # N m^-1.5


class Linear(NamedTuple):
    """F = K pen."""

    stiffness: float  # N/m


@elastic_force.member(Power)
def _power(elastic, pen):
    return elastic.stiffness * pen**elastic.exponent


@elastic_force.member(PowerThreeHalves)
def _power_three_halves(elastic, pen):
    return elastic.stiffness * pen * math.sqrt(pen)


@elastic_force.member(Linear)
def _linear(elastic, pen):
    return elastic.stiffness * pen


# ---------------------------------------------------------------------------------------------- laws with a loss


@family
def contact_force(law, elastic, pen, rate, onset_rate):
    """Return (force, elastic part) in N, the force not yet clipped at zero.

    `pen` : penetration, m; `rate` : its rate, m/s, closing positive; `onset_rate` : the closing rate at which this
    contact began, m/s, positive.
    """


class Lossless(NamedTuple):
    """The elastic force alone."""


class Hysteresis(NamedTuple):
    """F = F_elastic (1 + chi rate / onset_rate); the laws of this form differ only in chi(restitution)."""

    factor: float  # chi, 1


class ViscousSpring(NamedTuple):
    """F = F_elastic + c rate (Kelvin-Voigt)."""

    damping: float  # N s/m


@contact_force.member(Lossless)
def _lossless(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force, force


@contact_force.member(Hysteresis)
def _hysteresis(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force * (1.0 + law.factor * rate / onset_rate), force


@contact_force.member(ViscousSpring)
def _viscous_spring(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * rate, force
