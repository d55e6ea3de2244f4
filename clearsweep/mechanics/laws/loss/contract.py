"""The interface of laws of the normal force."""

from ....contracts.catalogue import Field
from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import where
from ....tracing.compiled.family import family, kernel
from ...joints.kinks import current_piece
from ..elastic.contract import root_parity


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


@family
def with_mass(law, mass):
    """Return the law with the present effective mass (kg) of an impact at its contact.

    Only laws that are members use it; see `coupling.impact_mass`.
    """


@family
def needs_mass(law):
    """Return whether the force of a law depends on the mass in its present internal state."""


@with_mass.member(None)
def _default_with_mass(law, mass):
    return law


@needs_mass.member(None)
def _default_needs_mass(law):
    return False


@family
def needs_onset_rate(law):
    """Return whether the force of a law depends on the onset rate in its present internal state."""


@needs_onset_rate.member(None)
def _default_needs_onset_rate(law):
    return False


def always_needs_onset_rate(law):
    """Return True: the law depends on the onset rate to the end of the contact."""
    return True


FAMILIES = (contact_force, lowest_force, sign_past_separation)  # every type must be a member of these families


def register_contact_force(law_type, *, pulls: bool, times_elastic: bool):
    """Return the decorator that registers `contact_force`, `lowest_force` and `sign_past_separation` of a type.

    `pulls` : the force may be negative until separation, otherwise it is clipped at 0; `times_elastic` : it is the
    elastic force times a factor, so it continues past the separation with that sign, otherwise with its own.
    """

    def register(force_function):
        lowest_force.member(law_type)(_unbounded if pulls else _clipped_at_zero)
        sign_past_separation.member(law_type)(_sign_of_elastic if times_elastic else _positive_sign)
        return contact_force.member(law_type)(force_function)

    return register


def _clipped_at_zero(law):
    return 0.0


def _unbounded(law):
    return -math.inf


def _sign_of_elastic(law, elastic):
    return root_parity(elastic)


def _positive_sign(law, elastic):
    return 1.0


def zero_rate_kink(law):
    """Return the kink, over the rate, of a law that is damped only during approach."""
    return (0.0,)


@kernel
def approach_rate(piece, rate):
    """Return the rate (m/s) during approach, or 0 during rebound, by the piece of such a law."""
    return where(current_piece(piece, (0.0,), rate) == 1.0, rate, 0.0)


ANY_RESTITUTION = Field(
    "restitution", "1", "specified ratio of rebound speed to approach speed", 0.0, 1.0, False, False
)
RESTITUTION = ANY_RESTITUTION._replace(low_open=True)  # for laws that cannot be lossless
