"""Friction with sticking: below a sliding speed the surfaces stick."""

from typing import NamedTuple

from ....contracts.catalogue import Field, Law, Order
from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import where
from ...joints.contract import Guard, guard_values, guards, latched
from ...joints.modes import AT_LIMIT_DOWN, AT_LIMIT_UP, CLIPPED, PRESSED, STICKING, STUCK
from ...joints.recipe import register
from .contract import COEFFICIENT, KINETIC_FIRST, STATIC, STRIBECK, friction_force, maker_from_values, static_limit
from .sliding import stribeck_coefficient

#: Guards: the sliding speed enters the band, or leaves it; its sign is not known yet; it changes sign while the force
#: is clipped; the force needed to stop the sliding passes its upper or lower limit, outwards or back.
STICKS, SLIPS, DIRECTION_UNKNOWN, REVERSES, REACHES_UPPER, REACHES_LOWER, BELOW_UPPER, ABOVE_LOWER = range(8)
RELEASE_FACTOR = 1.001  # times the sticking speed: sliding speed at which surfaces are released


class Karnopp(NamedTuple):
    """Slides by Stribeck's law down to the sliding speed `band`; below it sticks, see `coupling.sticking`."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    band: float  # m/s
    sliding_sign: float = 0.0  # sign of the sliding speed as it began to slide; 0: not known yet


@friction_force.member(Karnopp)
def _friction_force_karnopp(friction, normal, slip):
    sign = where(friction.sliding_sign != 0.0, friction.sliding_sign, min(max(slip / friction.band, -1.0), 1.0))
    return -normal * (stribeck_coefficient(friction, slip) * sign + friction.viscous * slip)


@static_limit.member(Karnopp)
def _static_limit_karnopp(friction):
    edge_coefficient = stribeck_coefficient(friction, friction.band) + friction.viscous * friction.band
    return max(friction.static_coefficient, edge_coefficient)  # otherwise released surfaces would stick again at once


@guards.member(Karnopp)
def _guards_karnopp(friction):
    return (
        Guard((PRESSED,), STUCK, at_start=True),
        Guard(STICKING, PRESSED),
        Guard((PRESSED,), at_start=True),
        Guard((CLIPPED,)),
        Guard((STUCK,), AT_LIMIT_UP),
        Guard((STUCK,), AT_LIMIT_DOWN),
        Guard((AT_LIMIT_UP,), STUCK),
        Guard((AT_LIMIT_DOWN,), STUCK),
    )


@guard_values.member(Karnopp)
def _guard_values_karnopp(friction, start, contact, root):
    slip_sign = where(friction.sliding_sign != 0.0, friction.sliding_sign, math.copysign(1.0, start.contact.slip))
    limit = static_limit(friction) * contact.normal
    return (
        friction.band - slip_sign * contact.slip,
        abs(contact.slip) - RELEASE_FACTOR * friction.band,
        abs(slip_sign) - abs(friction.sliding_sign),
        -slip_sign * contact.slip,
        contact.guard_quantity - limit,
        -contact.guard_quantity - limit,
        limit - contact.guard_quantity,
        limit + contact.guard_quantity,
    )


@latched.member(Karnopp)
def _latched_karnopp(friction, event, contact, root):
    if event == REVERSES:
        return (-friction.sliding_sign,)
    return (math.copysign(1.0, contact.slip) if event in (SLIPS, DIRECTION_UNKNOWN) else 0.0,)


register(
    Law(
        "friction",
        "karnopp",
        "stick-slip: below a sliding speed the surfaces stick",
        "above band: T = -N sgn(slip) (mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape) + viscous |slip|); "
        "below: T stops the sliding, at most mu_s N either way, or the friction at the edge of the band if that is "
        "larger",
        "after Karnopp 1985, J. Dyn. Syst. Meas. Control 107:100; with the Stribeck effect",
        (
            COEFFICIENT,
            STATIC,
            *STRIBECK,
            Field(
                "band", "m/s", "sliding speed below which the surfaces stick; choose it well below stribeck_velocity"
            ),
        ),
        has_state=True,
        sticks=True,
        notes="T in the band follows from the motion: it makes the sliding speed decay at the crank's rate.  The "
        "remaining creep, below band, has no physical meaning.  The edge of the band is located; T jumps there.  "
        "Static friction is bounded by the load alone, so surfaces start to slide when their load falls.",
        orders=(
            KINETIC_FIRST,
            Order("band", "stribeck_velocity", "friction falls beyond what counts as sticking", equal=True),
        ),
    ),
    (Karnopp,),
    maker_from_values(Karnopp),
)
