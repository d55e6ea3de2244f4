"""Friction that sticks: below a sliding speed the surfaces hold each other."""

from typing import NamedTuple

from .contract import friction_force, holding
from .sliding import stribeck_coefficient


class Karnopp(NamedTuple):
    """Slides as Stribeck's law down to the sliding speed `band`; below it sticks, which `joint.stick.held` sees to."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    band: float  # m/s


@friction_force.member(Karnopp)
def _karnopp(friction, normal, slip):
    sign = min(max(slip / friction.band, -1.0), 1.0)  # no jump in a step that runs into the band and is cut there
    return -normal * (stribeck_coefficient(friction, slip) * sign + friction.viscous * slip)


@holding.member(Karnopp)
def _sticks(friction):
    edge = stribeck_coefficient(friction, friction.band) + friction.viscous * friction.band
    return max(friction.static_coefficient, edge)  # else surfaces that let go would be caught again at once
