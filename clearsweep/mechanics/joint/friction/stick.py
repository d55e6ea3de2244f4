"""Friction that sticks: below a sliding speed the surfaces hold each other."""

from typing import NamedTuple

from ....catalogue import Field, Law
from ..recipe import enter
from .contract import COEFFICIENT, STATIC, STRIBECK, friction_force, from_values, holding
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


enter(
    Law(
        "friction",
        "karnopp",
        "sticks: below a sliding speed the surfaces hold each other",
        "above band: T = -N sgn(slip) (mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape) + viscous |slip|); "
        "below: T is what stops the sliding, at most mu_s N either way, or what slides at the edge of the band if "
        "that is more",
        "after Karnopp 1985, J. Dyn. Syst. Meas. Control 107:100; with Stribeck's fall",
        (
            COEFFICIENT,
            STATIC,
            *STRIBECK,
            Field("band", "m/s", "sliding speed below which the surfaces stick; well below stribeck_velocity"),
        ),
        notes="T in the band follows from the motion: it makes the sliding speed die away with the crank's rate, so "
        "what is left of it, less than band, is a creep of no meaning.  The edge of the band is located; T jumps "
        "there.  Static friction is bounded by the load alone, so surfaces let go when the load on them falls.",
    ),
    (Karnopp,),
    from_values(Karnopp),
)
