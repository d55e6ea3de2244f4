"""The normal force as a power of the penetration."""

from typing import NamedTuple

from ...compiled import calculus as math
from .contract import elastic_form


class Power(NamedTuple):
    """F = K pen^n."""

    stiffness: float  # N m^-n
    exponent: float  # 1


@elastic_form(Power, odd=False)
def _power(elastic, pen):
    return elastic.stiffness * pen**elastic.exponent


class PowerThreeHalves(NamedTuple):
    """F = K pen^(3/2), Hertz's exponent: a square root in place of a general power."""

    stiffness: float  # N m^-1.5


@elastic_form(PowerThreeHalves, odd=True)
def _power_three_halves(elastic, pen):
    return elastic.stiffness * pen * math.sqrt(pen)


class Linear(NamedTuple):
    """F = K pen."""

    stiffness: float  # N/m


@elastic_form(Linear, odd=False)
def _linear(elastic, pen):
    return elastic.stiffness * pen
