"""Friction with sticking: below a sliding speed the surfaces stick."""

import math
from typing import NamedTuple

from ....contracts.catalogue import Field, Law, Order
from ..contract import PRESSED, STUCK, Guard, guard_values, guards
from ..recipe import register
from .contract import COEFFICIENT, KINETIC_FIRST, STATIC, STRIBECK, friction_force, from_values, static_limit
from .sliding import stribeck_coefficient

LOOSE = 1.001  # times the sticking speed: sliding speed at which surfaces are released


class Karnopp(NamedTuple):
    """Slides by Stribeck's law down to the sliding speed `band`; below it sticks, see `coupling.sticking`."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    band: float  # m/s


@friction_force.member(Karnopp)
def _friction_force_karnopp(friction, normal, slip):
    sign = min(max(slip / friction.band, -1.0), 1.0)  # continuous in a step that enters the band and is truncated there
    return -normal * (stribeck_coefficient(friction, slip) * sign + friction.viscous * slip)


@static_limit.member(Karnopp)
def _static_limit_karnopp(friction):
    edge = stribeck_coefficient(friction, friction.band) + friction.viscous * friction.band
    return max(friction.static_coefficient, edge)  # otherwise released surfaces would stick again at once


@guards.member(Karnopp)
def _guards_karnopp(friction):
    return Guard((PRESSED,), STUCK, at_start=True), Guard((STUCK,), PRESSED)


@guard_values.member(Karnopp)
def _guard_values_karnopp(friction, start, contact, root):
    slip = math.copysign(1.0, start.slip) * contact.slip
    return friction.band - slip, abs(slip) - LOOSE * friction.band


register(
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
        remembers=True,
        sticks=True,
        notes="T in the band follows from the motion: it makes the sliding speed decay at the crank's rate.  The "
        "remaining creep, below band, has no physical meaning.  The edge of the band is located; T jumps there.  "
        "Static friction is bounded by the load alone, so surfaces let go when the load on them falls.",
        orders=(
            KINETIC_FIRST,
            Order("band", "stribeck_velocity", "friction falls beyond what counts as sticking", equal=True),
        ),
    ),
    (Karnopp,),
    from_values(Karnopp),
)
