"""A contact that stops using its onset rate when it becomes lasting (`contact.onset: renewed`).

A law F = F_elastic (1 + chi rate / onset_rate) is designed for an impact, whose severity is its onset rate.
A lasting contact has no such rate: that of its first touch must not determine all its later losses.
With the elastic energy W and the effective mass m, let v = sqrt(2 W / m), the onset rate of the free,
lossless impact that would stop at this depth.  Then

    impact     F_elastic (1 + chi rate / v0), from the onset on; with v / 2 in place of v0 when v exceeds 2 v0: no free
               impact approaches this value, so another force presses
    lasting    max(0, F_elastic (1 + 2 zeta rate / v)), from a zero of the rate, so that the force is continuous: the
               deepest point of a contact that is pressed, else the first point of renewed loading

In an undisturbed lasting contact sqrt(2 W) and sqrt(m) rate behave like deflection and speed of a linear
oscillator of damping ratio zeta (see `rebound`), so its loss per cycle is that of an impact of the same restitution:
the force is F_elastic + 2 zeta sqrt(S m) rate with S = F_elastic^2 / (2 W), the stiffness of that oscillator.
"""

from typing import NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import cond
from ....tracing.compiled.family import kernel
from ...joints.contract import ENTERED, LEFT, NEVER, ONSET_FLOOR, Guard, guard_values, guards, latched
from ...joints.modes import TOUCHING
from ...joints.rebound import damping_ratio
from ..elastic.contract import elastic_energy, elastic_force, energy_stiffness
from .contract import contact_force, needs_mass, needs_onset_rate, register_contact_force, with_mass

ENERGY_EXCEEDED, RATE_ZERO = 0, 1  # guards: v exceeds 2 v0; the rate crosses zero
INITIAL_ENERGY = 1.0  # J, any positive value: separate contacts follow the law of an impact


class Renewed(NamedTuple):
    """An impact law until the contact is lasting, then a damper without memory."""

    impact: tuple  # the impact law
    elastic: tuple  # elastic law of the joint: its energy decides when
    damping: float  # 2 zeta, 1
    mass: float  # kg, present effective mass
    doubling_energy: float = 0.0  # J, > 0: energy at which v is 2 v0; < 0: its negative after that; 0: lasting


def renewed_law(impact: tuple, elastic: tuple, restitution: float) -> Renewed:
    """Return an impact law with `restitution`, extended to lasting contacts."""
    return Renewed(impact, elastic, 2.0 * damping_ratio(restitution), 0.0)


@register_contact_force(Renewed, pulls=False, times_elastic=True)
def _renewed(law, elastic, pen, rate, onset_rate):
    return _by_phase(law.doubling_energy > 0.0, (law, elastic, pen, rate, onset_rate))


@kernel
def _impact(law, elastic, pen, rate, onset_rate):
    return contact_force(law.impact, elastic, pen, rate, onset_rate)


@kernel
def _after_impact(law, elastic, pen, rate, onset_rate):
    return _by_later_phase(law.doubling_energy < 0.0, (law, elastic, pen, rate, onset_rate))


@kernel
def _prolonged_impact(law, elastic, pen, rate, onset_rate):
    energy_ratio = elastic_energy(elastic, pen) / -law.doubling_energy  # energy at which v / 2 was the onset rate
    return contact_force(law.impact, elastic, pen, rate, onset_rate * math.sqrt(energy_ratio))


@kernel
def _lasting(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    damping = law.damping * law.damping * energy_stiffness(elastic, pen)  # the mass is known last
    return force + math.sqrt(damping * law.mass) * rate, force


_by_phase, _by_later_phase = cond(_impact, _after_impact), cond(_prolonged_impact, _lasting)


@with_mass.member(Renewed)
def _with_mass_renewed(law, mass):
    return Renewed(law.impact, law.elastic, law.damping, mass, law.doubling_energy)


@needs_mass.member(Renewed)
def _needs_mass_renewed(law):
    return law.doubling_energy == 0.0


@needs_onset_rate.member(Renewed)
def _needs_onset_rate_renewed(law):
    return law.doubling_energy > 0.0


@guards.member(Renewed)
def _guards_renewed(law):
    return Guard(TOUCHING), Guard(TOUCHING)


@guard_values.member(Renewed)
def _guard_values_renewed(law, start, contact, root):
    if law.doubling_energy > 0.0:
        return elastic_energy(
            law.elastic, root * root
        ) - law.doubling_energy, contact.rate if start.contact.rate < 0.0 else NEVER
    return NEVER, -contact.rate if law.doubling_energy < 0.0 else NEVER


@latched.member(Renewed)
def _latched_renewed(law, event, contact, root):
    if event == ENTERED:
        rate = max(contact.rate, ONSET_FLOOR)
        return (2.0 * law.mass * rate * rate,)
    if event == LEFT:
        return (INITIAL_ENERGY,)
    return (-law.doubling_energy if event == ENERGY_EXCEEDED else 0.0,)
