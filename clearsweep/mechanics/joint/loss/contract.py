"""What a law of the normal force declares."""

from ....contracts.catalogue import Field
from ...compiled import calculus as math
from ...compiled.family import family
from ..elastic.contract import parity


@family
def contact_force(law, elastic, pen, rate, onset_rate):
    """Return (force, elastic part) in N, the force not yet clipped at `lowest_force`.

    `pen` : penetration, m; `rate` : its rate, m/s, closing positive; `onset_rate` : the closing rate at which this
    contact began, m/s, positive.
    """


@family
def lowest_force(law):
    """Return the force (N) below which the law is clipped: 0, or -inf where it may pull until the surfaces part."""


@family
def sign_beyond(law, elastic):
    """Return the sign with which the force goes on smoothly where a trial step passes the separation.

    The force is a function of the root of the penetration, which goes through zero like a straight line: one of its odd
    powers, such as Hertz's third, changes sign there, an even one does not.  Only trial steps go that far.
    """


@family
def with_mass(law, mass):
    """Return the law, given the mass (kg) that takes part in an impact at its contact as the bodies are.

    Only a law with a member asks for it; see `joint.impact_mass`.
    """


@family
def awaits_mass(law):
    """Return whether the force of the law, which knows its internal state, depends on the mass as things are."""


@with_mass.member(None)
def _default_with_mass(law, mass):
    return law


@awaits_mass.member(None)
def _default_awaits_mass(law):
    return False


@family
def keeps_onset(law):
    """Return whether the force of the law, which knows its internal state, depends on the rate of the onset."""


@keeps_onset.member(None)
def _default_keeps_onset(law):
    return False


def kept_always(law):
    """Return True: a law depends on the rate of the onset to the end of the contact."""
    return True


FAMILIES = (contact_force, lowest_force, sign_beyond)  # a type of this kind is a member of each


def loss_form(form, *, pulls: bool, times_elastic: bool):
    """Return the decorator that enters the `contact_force` of a type, and the two answers that go with it.

    `pulls` : the force may be negative until the surfaces part, else it is clipped at 0; `times_elastic` : it is the
    elastic force times a factor, so that it goes on past the separation with the sign of that, else with its own.
    """

    def register(body):
        lowest_force.member(form)(_unbounded if pulls else _zero)
        sign_beyond.member(form)(_of_elastic if times_elastic else _its_own)
        return contact_force.member(form)(body)

    return register


def _zero(law):
    return 0.0


def _unbounded(law):
    return -math.inf


def _of_elastic(law, elastic):
    return parity(elastic)


def _its_own(law, elastic):
    return 1.0


ANY_RESTITUTION = Field("restitution", "1", "wanted ratio of rebound to approach speed", 0.0, 1.0, False, False)
RESTITUTION = ANY_RESTITUTION._replace(low_open=True)  # of laws that cannot be asked for none
