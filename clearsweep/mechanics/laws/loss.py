"""The interface of laws of the normal force, the restitution of a free impact, and contacts that become lasting.

For a law F = F_elastic(pen) (1 + chi rate / onset_rate) the phase curve of m pen'' = -F gives the restitution whatever
the elastic force, the mass and the speed.  For F = F_elastic + 2 zeta sqrt(m) F_elastic / sqrt(2 U) rate, U the elastic
energy, sqrt(2 U) and sqrt(m) rate move like the deflection and the speed of a linear oscillator of damping ratio zeta
(Antypov & Elliott 2011, EPL 94:50004, for the exponent 3/2); for a power n the damping is that of the root of F / pen
with the factor sqrt(2 (n + 1)) zeta.

A contact may stop using its onset rate when it becomes lasting (`contact.onset: renewed`).  A law F = F_elastic (1 +
chi rate / onset_rate) is designed for an impact, whose severity is its onset rate.  A lasting contact has no such rate:
that of its first touch must not determine all its later losses.  With the elastic energy W and the effective mass m,
let v = sqrt(2 W / m), the onset rate of the free, lossless impact that would stop at this depth.  Then

    impact     F_elastic (1 + chi rate / v0), from the onset on; with v / 2 in place of v0 when v exceeds 2 v0: no free
               impact approaches this value, so another force presses
    lasting    max(0, F_elastic (1 + 2 zeta rate / v)), from a zero of the rate, so that the force is continuous: the
               deepest point of a contact that is pressed, else the first point of renewed loading

In an undisturbed lasting contact sqrt(2 W) and sqrt(m) rate behave like deflection and speed of a linear oscillator of
damping ratio zeta, so its loss per cycle is that of an impact of the same restitution: the force is
F_elastic + 2 zeta sqrt(S m) rate with S = F_elastic^2 / (2 W), the stiffness of that oscillator.
"""

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

from ...contracts.catalogue import ranged
from ...tracing.compiled import calculus
from ...tracing.compiled.choosing import cond, where
from ...tracing.compiled.family import family, family_with_default, kernel
from . import contract
from .elastic import elastic_energy, force_and_stiffness, root_parity


@family
def contact_force(law, elastic, pen, rate, onset_rate):
    """Return (force, elastic part) in N, the force not yet clipped at `lowest_force`.

    `pen` : penetration, m; `rate` : its rate, m/s, closing positive; `onset_rate` : the closing rate when this
    contact began, m/s, positive.
    """


@family
def lowest_force(law):
    """Return the force (N) below which the law is clipped: 0, or -inf if it may pull until separation."""


@family
def sign_past_separation(law, elastic):
    """Return the sign that continues the force smoothly in a trial step past the separation.

    The force is a function of the root of penetration, which crosses zero linearly: an odd
    power, such as Hertz's third, changes sign there, an even power does not.  Only trial steps go that far.
    """


@family_with_default
def with_mass(law, mass):
    """Return the law with the present effective mass (kg) of an impact at its contact.

    Only laws that are members use it; see `coupling.inertia`.
    """
    return law


@family_with_default
def needs_mass(law):
    """Return whether the force of a law depends on the mass in its present internal state."""
    return False


@family_with_default
def needs_onset_rate(law):
    """Return whether the force of a law depends on the onset rate in its present internal state."""
    return False


def always_needs_onset_rate(law):
    """Return True: the law depends on the onset rate to the end of the contact."""
    return True


contract.require("law", contact_force, lowest_force, sign_past_separation)


def register_contact_force(law_type, *, pulls: bool, times_elastic: bool):
    """Return the decorator that registers `contact_force`, `lowest_force` and `sign_past_separation` of a type.

    `pulls` : the force may be negative until separation, otherwise it is clipped at 0; `times_elastic` : it is the
    elastic force times a factor, so it continues past the separation with that sign, otherwise with its own.
    """

    def register(force_function):
        lowest_force.member(law_type)(lambda law: -calculus.inf if pulls else 0.0)
        sign_past_separation.member(law_type)(lambda law, elastic: root_parity(elastic) if times_elastic else 1.0)
        return contact_force.member(law_type)(force_function)

    return register


@kernel
def approach_rate(piece, rate):
    """Return the rate (m/s) during approach, or 0 during rebound, by the piece of such a law."""
    return where(contract.current_piece(piece, (0.0,), rate) == 1.0, rate, 0.0)


ANY_RESTITUTION = ranged("restitution", "1", "specified ratio of rebound speed to approach speed", "[0, 1]")
RESTITUTION = ANY_RESTITUTION._replace(low_open=True)  # for laws that cannot be lossless


# ---------------------------------------------------------------------------------------------- free impacts


MAX_ITERATIONS = 100  # of a search for a root


def exact_factor(restitution: float) -> float:
    """Return the chi for which a free impact has exactly `restitution`, for any exponent, stiffness and mass.

    The root of ln((1 + chi) / (1 - e chi)) = chi (1 + e) in (0, 1/e), from the phase curve of
    m x'' = -K x^n (1 + chi u) integrated from u = 1 to u = -e.
    """
    if restitution == 1.0:
        return 0.0
    if 1.0 - restitution < 1e-5:  # the root is lost in rounding; two terms of the series are accurate to 1e-15
        return 1.5 * (1.0 - restitution) * (2.0 - restitution)

    def residual(s):  # the substitution 1 - e chi = exp(-s) avoids the singular end
        chi = -math.expm1(-s) / restitution
        return math.log1p(chi) + s - chi * (1.0 + restitution)

    return -math.expm1(-find_root(residual, 1e-9, 800.0, 1e-15, 1e-15)) / restitution


def find_root(function: Callable[[float], float], low: float, high: float, xtol: float, rtol: float) -> float:
    """Return a root of a function with opposite signs at `low` and `high`, within 2 (xtol + rtol |root|).

    Brent 1973, Algorithms for Minimization without Derivatives, ch. 4, step by step as in `scipy.optimize.brentq`,
    which gives the same bits but takes a third of a second to import.
    """
    previous, current = low, high
    f_previous, f_current = function(previous), function(current)
    if f_previous == 0.0 or f_current == 0.0:
        return previous if f_previous == 0.0 else current
    if (f_previous < 0.0) == (f_current < 0.0):
        raise ValueError(f"the function has one sign at {low:g} and {high:g}")
    opposite, f_opposite, step, previous_step = previous, f_previous, current - previous, current - previous
    for _ in range(MAX_ITERATIONS):
        if (f_previous < 0.0) != (f_current < 0.0):
            opposite, f_opposite, step, previous_step = previous, f_previous, current - previous, current - previous
        if abs(f_opposite) < abs(f_current):
            previous, current, opposite = current, opposite, current
            f_previous, f_current, f_opposite = f_current, f_opposite, f_current
        tolerance, half_interval = 0.5 * (xtol + rtol * abs(current)), 0.5 * (opposite - current)
        if f_current == 0.0 or abs(half_interval) < tolerance:
            return current
        last_steps = previous_step, step
        previous_step = step = half_interval
        if abs(last_steps[0]) > tolerance and abs(f_current) < abs(f_previous):
            if previous == opposite:  # secant
                trial = -f_current * (current - previous) / (f_current - f_previous)
            else:  # inverse quadratic interpolation
                previous_slope = (f_previous - f_current) / (previous - current)
                opposite_slope = (f_opposite - f_current) / (opposite - current)
                trial = (
                    -f_current
                    * (f_opposite * opposite_slope - f_previous * previous_slope)
                    / (opposite_slope * previous_slope * (f_opposite - f_previous))
                )
            if 2.0 * abs(trial) < min(abs(last_steps[0]), 3.0 * abs(half_interval) - tolerance):
                previous_step, step = last_steps[1], trial
        previous, f_previous = current, f_current
        current += step if abs(step) > tolerance else math.copysign(tolerance, half_interval)
        f_current = function(current)
    raise ValueError("the search for a root did not converge")


def approach_loss(chi: float) -> float:
    """Return chi - ln(1 + chi), without cancellation for small chi."""
    if chi > 0.1:
        return chi - math.log1p(chi)
    return chi * chi * math.fsum((-chi) ** k / (k + 2) for k in range(16))


@functools.lru_cache(1024)
def hysteresis_rebound(chi: float) -> float:
    """Return the restitution of a free impact with the hysteresis factor `chi`.

    The root of chi e + ln(1 - chi e) = -(chi - ln(1 + chi)); the closed form is (1 + W0(-(1+chi) exp(-(1+chi)))) / chi.
    """
    if chi < 1e-4:
        return 1.0 - chi * (2.0 / 3.0 - chi * (4.0 / 9.0 - chi * 44.0 / 135.0))
    loss = approach_loss(chi)
    # with 1 - chi e = exp(-s) the root s of expm1(-s) + s = loss is below loss + 1; the left side is convex, so that
    # Newton's method falls towards the root
    s, previous_s = loss + 1.0, math.inf
    while s < previous_s:
        s, previous_s = s + (math.expm1(-s) + s - loss) / math.expm1(-s), s
    return -math.expm1(-previous_s) / chi


def approach_hysteresis_rebound(chi: float) -> float:
    """Return the restitution of a free impact with the hysteresis factor `chi` acting on the approach only."""
    return math.sqrt(2.0 * approach_loss(chi)) / chi if chi > 0.0 else 1.0


def damping_ratio(restitution: float) -> float:
    """Return the zeta of a linear oscillator that returns to zero with `restitution` times its speed."""
    loss = -math.log(restitution)
    return loss / math.hypot(math.pi, loss)


def approach_damping_rebound(zeta: float) -> float:
    """Return the restitution with a damping ratio `zeta` that acts on the approach only."""
    root_term = math.sqrt(abs(1.0 - zeta * zeta))
    if zeta < 1.0:
        return math.exp(-zeta / root_term * math.atan2(root_term, zeta))
    if root_term < 1e-6:
        return math.exp(-1.0)
    return ((zeta + root_term) / (zeta - root_term)) ** (-0.5 * zeta / root_term)


# ---------------------------------------------------------------------------------------------- lasting contacts


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
    return contact_force(law.impact, elastic, pen, rate, onset_rate * calculus.sqrt(energy_ratio))


@kernel
def _lasting(law, elastic, pen, rate, onset_rate):
    force, stiffness = force_and_stiffness(elastic, pen)
    damping = law.damping * law.damping * stiffness  # the mass is known last
    return force + calculus.sqrt(damping * law.mass) * rate, force


_by_phase, _by_later_phase = cond(_impact, _after_impact), cond(_prolonged_impact, _lasting)


with_mass.member(Renewed)(lambda law, mass: law._replace(mass=mass))
needs_mass.member(Renewed)(lambda law: law.doubling_energy == 0.0)
needs_onset_rate.member(Renewed)(lambda law: law.doubling_energy > 0.0)
contract.guards.member(Renewed)(lambda law: (contract.Guard(contract.TOUCHING), contract.Guard(contract.TOUCHING)))


@contract.guard_values.member(Renewed)
def _guard_values_renewed(law, start, contact, root):
    if law.doubling_energy > 0.0:
        return elastic_energy(
            law.elastic, root * root
        ) - law.doubling_energy, contact.rate if start.contact.rate < 0.0 else contract.NEVER
    return contract.NEVER, -contact.rate if law.doubling_energy < 0.0 else contract.NEVER


@contract.latched.member(Renewed)
def _latched_renewed(law, event, contact, root):
    if event == contract.ENTERED:
        rate = max(contact.rate, contract.ONSET_FLOOR)
        return (2.0 * law.mass * rate * rate,)
    if event == contract.LEFT:
        return (INITIAL_ENERGY,)
    return (-law.doubling_energy if event == ENERGY_EXCEEDED else 0.0,)
