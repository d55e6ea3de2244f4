"""A contact that forgets how it began once it has proved lasting: `contact.onset: renewed`.

A law F = F_elastic (1 + chi rate / onset_rate) is made for an impact: the rate at which it began says how hard it is.
A contact that stays has no such rate; kept all the same, that of the first touch decides for ever how much is lost.
With the energy W of the elastic force and the mass m that takes part, let v = sqrt(2 W / m), the rate of the free,
lossless impact that would come to a stop at this depth.  Then

    impact     F_elastic (1 + chi rate / v0), from the onset on; where v passes 2 v0, which no free impact comes near,
               with v / 2 for v0: something else than the impact presses
    lasting    max(0, F_elastic (1 + 2 zeta rate / v)), from where the rate is zero, so that the force has no jump: the
               deepest point of a contact that is pressed, else the first point from which it deepens anew

sqrt(2 W) and sqrt(m) rate move, in a lasting contact that is left alone, like deflection and speed of a linear
oscillator of damping ratio zeta (see `rebound`), so it loses per cycle what an impact of the same restitution does: the
force is F_elastic + 2 zeta sqrt(S m) rate with S = F_elastic^2 / (2 W), the stiffness of that oscillator.
"""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.choosing import either
from ...compiled.family import kernel
from ..contract import (
    ENTERED,
    LEFT,
    NEVER,
    ONSET_FLOOR,
    TOUCHING,
    Guard,
    guard_values,
    guards,
    latched,
)
from ..elastic.contract import elastic_energy, elastic_force, energy_stiffness
from ..rebound import damping_ratio
from .contract import awaits_mass, contact_force, keeps_onset, loss_form, with_mass

PRESSED_ON, TURNED = 0, 1  # guards: v passes 2 v0; the rate passes zero
APART = 1.0  # J, of no account but that side by side all that are apart go by the rule of an impact


class Renewed(NamedTuple):
    """A law of an impact until the contact proves lasting, then a damper without memory."""

    impact: tuple  # the law until then
    elastic: tuple  # of the joint: its energy gives when
    damping: float  # 2 zeta, 1
    mass: float  # kg, that takes part as the bodies are; told in every state
    doubling_energy: float = 0.0  # J, > 0: energy at which v is 2 v0; < 0: it has passed that, its negative; 0: lasting


def renewed(impact: tuple, elastic: tuple, restitution: float) -> Renewed:
    """Return the compiled form of an impact's law, which gives back `restitution`, for lasting contacts too."""
    return Renewed(impact, elastic, 2.0 * damping_ratio(restitution), 0.0)


@loss_form(Renewed, pulls=False, times_elastic=True)
def _renewed(law, elastic, pen, rate, onset_rate):
    return _by_phase(law.doubling_energy > 0.0, (law, elastic, pen, rate, onset_rate))


@kernel
def _impact(law, elastic, pen, rate, onset_rate):
    return contact_force(law.impact, elastic, pen, rate, onset_rate)


@kernel
def _after_impact(law, elastic, pen, rate, onset_rate):
    return _by_later_phase(law.doubling_energy < 0.0, (law, elastic, pen, rate, onset_rate))


@kernel
def _pressed_on(law, elastic, pen, rate, onset_rate):
    share = elastic_energy(elastic, pen) / -law.doubling_energy  # of the energy at which v / 2 was the onset rate
    return contact_force(law.impact, elastic, pen, rate, onset_rate * math.sqrt(share))


@kernel
def _lasting(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    damping = law.damping * law.damping * energy_stiffness(elastic, pen)  # the mass is known last
    return force + math.sqrt(damping * law.mass) * rate, force


_by_phase, _by_later_phase = either(_impact, _after_impact), either(_pressed_on, _lasting)


@with_mass.member(Renewed)
def _with_mass_renewed(law, mass):
    return Renewed(law.impact, law.elastic, law.damping, mass, law.doubling_energy)


@awaits_mass.member(Renewed)
def _awaits_mass_renewed(law):
    return law.doubling_energy == 0.0


@keeps_onset.member(Renewed)
def _keeps_onset_renewed(law):
    return law.doubling_energy > 0.0


@guards.member(Renewed)
def _guards_renewed(law):
    return Guard(TOUCHING, of_state=True), Guard(TOUCHING)


@guard_values.member(Renewed)
def _guard_values_renewed(law, start, contact, root):
    if law.doubling_energy > 0.0:
        return elastic_energy(
            law.elastic, root * root
        ) - law.doubling_energy, contact.rate if start.rate < 0.0 else NEVER
    return NEVER, -contact.rate if law.doubling_energy < 0.0 else NEVER


@latched.member(Renewed)
def _latched_renewed(law, event, contact, root):
    if event == ENTERED:
        rate = max(contact.rate, ONSET_FLOOR)
        return (2.0 * law.mass * rate * rate,)
    if event == LEFT:
        return (APART,)
    return (-law.doubling_energy if event == PRESSED_ON else 0.0,)
