"""Contacts that yield: they spring back from an indentation, which they keep until the surfaces part."""

from typing import NamedTuple

from ....catalogue import Field, Law
from ...compiled import calculus as math
from ..contract import (
    NEVER,
    TOUCHING,
    Guard,
    InternalState,
    guard_values,
    guards,
    internal_rates,
    internal_state,
    latched,
)
from ..elastic.contract import elastic_force
from ..recipe import enter
from .contract import RESTITUTION, loss_form

SHALLOW = 1e-12  # m, the least depth that a contact which yields remembers
BEYOND = 1.0 + 1e-12  # times the root of the deepest penetration: not reached again by rounding
UNLOADING, RELOADING = 0, 1  # guards: the contact begins to part; comes back to the deepest point it has been to


class Plastic(NamedTuple):
    """F = F_elastic(pen) while it deepens, then along the same curve shrunk towards the deepest point.

    Back and forth below the deepest point: F = F_elastic((pen - left) / e^2), left = (1 - e^2) deepest being the
    indentation that stays.  The share e^2 of the work done while it deepens comes back.
    """

    returned_share: float  # e^2, 1
    yield_rate: float  # m/s, onset rate up to which all is elastic
    deepest: float = 0.0  # m, where the contact last turned from deepening to parting; 0 while it deepens


@loss_form(Plastic, pulls=False, times_elastic=True)
def _plastic(law, elastic, pen, rate, onset_rate):
    share = law.returned_share if onset_rate > law.yield_rate else 1.0
    if law.deepest < SHALLOW:
        force = elastic_force(elastic, pen)
        return force, share * force
    rest = (pen - (1.0 - share) * law.deepest) / share
    force = math.copysign(elastic_force(elastic, abs(rest)), rest)  # below 0 where the indentation is clear
    return force, max(force, 0.0)


@internal_state.member(Plastic)
def _depth(law):  # changes at events alone; below what the law tells apart, so that no derivative spans the change
    return (InternalState(SHALLOW, False),)


@internal_rates.member(Plastic)
def _stays(law, contact):
    return (0.0,)


@guards.member(Plastic)
def _turns_back_and_comes_again(law):
    return Guard(TOUCHING), Guard(TOUCHING, of_state=True)


@guard_values.member(Plastic)
def _parts_and_is_deepest(law, start, contact, root):
    if law.deepest == 0.0:
        return -contact.rate, NEVER
    return NEVER, root - BEYOND * math.sqrt(law.deepest)


@latched.member(Plastic)
def _deepest(law, event, contact, root):
    if event == UNLOADING:
        return (max(root * root, SHALLOW),)
    return (0.0,)


enter(
    Law(
        "law",
        "lankarani-nikravesh-plastic",
        "yields while it deepens, springs back from an indentation",
        "F = F_elastic(pen) while pen deepens; below the deepest, pen_m, where it last turned back: "
        "F = F_elastic((pen - pen_p) / e^2), pen_p = (1 - e^2) pen_m, 0 below pen_p; for a power n that is "
        "F = F_m ((pen - pen_p) / (pen_m - pen_p))^n, F_m = K pen_m^n",
        "after Lankarani & Nikravesh 1994, Nonlinear Dyn. 5:193; pen_p such that a free impact loses (1 - e^2) m v0^2 "
        "/ 2",
        (
            RESTITUTION,
            Field("yield_rate", "m/s", "onset rate up to which the contact is elastic", low_open=False, default=0.0),
        ),
        notes="For impacts that leave the elastic range.  Left out, yield_rate is 0: every contact yields; for steel "
        "about 0.05 m/s is where it begins.  pen_m is forgotten when the surfaces part (pen < 0): the next contact "
        "meets a fresh surface, but a journal that wanders within one contact takes its indentation along.  There pen "
        "< pen_p counts as contact without force, each entry into it as a clip.  A contact that stays shakes down to "
        "an elastic one.",
    ),
    (Plastic,),
    lambda joint: Plastic(joint.contact.values["restitution"] ** 2, joint.contact.values["yield_rate"]),
    returned=lambda e: e,
)
