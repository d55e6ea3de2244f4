"""Laws whose formula changes at *kinks*: steps end there, and within a step one formula applies.

A method of high order loses its order at a kink, and an iteration hardly converges there.  So a law of this kind
stores the number of the piece that applies, counted over the variable of its kinks.  A trial step beyond the end of
the piece continues with its formula and is cut at the end.
"""

import math

from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import plain
from ...tracing.compiled.family import family, kernel
from .contract import ENTERED, LEFT, NEVER, Guard, guard_values, guards, latched
from .modes import TOUCHING

UNKNOWN = -1.0  # number of the piece until the first step of a contact
#: A step that begins closer to a kink than this has just passed it: relative to the kink, and its least value.
RELATIVE_CLOSENESS, ABSOLUTE_CLOSENESS = 1e-6, 1e-9
#: Guards: the end of the piece is passed; its beginning is passed; the first step, with an unknown piece.
END_PASSED, BEGIN_PASSED, FIRST_STEP = 0, 1, 2


@family
def kinks(law):
    """Return the values of its variable (a tuple, increasing) at which the formula of a law changes."""


@kernel
def piece_at(kink_values, x):
    """Return the number of the piece that contains `x`."""
    number = 0.0
    for kink in kink_values:
        number = number + where(plain(x) > kink, 1.0, 0.0)
    return number


@kernel
def current_piece(piece, kink_values, x):
    """Return the number of the piece that applies: the `piece` of a law or, if that is UNKNOWN, the piece of `x`."""
    return where(piece >= 0.0, piece, piece_at(kink_values, x))


@kernel
def _distances_past_ends(kink_values, piece, x):
    """Return the distances of `x` past the end and before the beginning of a piece.

    A piece without end or beginning gives NEVER.
    """
    above_kink = below_kink = NEVER
    for i in range(len(kink_values)):
        above_kink = where(piece == i, x - kink_values[i], above_kink)
        below_kink = where(piece == i + 1.0, kink_values[i] - x, below_kink)
    return above_kink, below_kink


@kernel
def _next_piece(kink_values, piece, event):
    """Return the next piece after END_PASSED or BEGIN_PASSED; pieces without width are skipped."""
    number, passed_kink = 0.0, 0.0
    for i in range(len(kink_values)):
        passed_kink = where(piece == (i if event == END_PASSED else i + 1.0), kink_values[i], passed_kink)
    for i in range(len(kink_values)):
        is_passed = kink_values[i] <= passed_kink if event == END_PASSED else kink_values[i] < passed_kink
        number = number + where(is_passed, 1.0, 0.0)
    return number


@family
def kink_variable(law, contact, root):
    """Return the variable over which a law has its kinks.

    contact : Observed; root : m^0.5, of the penetration.
    """


def _guards_of_pieces(law):
    return Guard(TOUCHING), Guard(TOUCHING), Guard(TOUCHING, at_start=True)


def _guard_values_of_pieces(law, start, contact, root):
    if law.piece < 0.0:
        return NEVER, NEVER, 1.0
    above_kink, below_kink = _distances_past_ends(kinks(law), law.piece, kink_variable(law, contact, root))
    return above_kink, below_kink, NEVER


def _latched_piece(law, event, contact, root):
    if event in (ENTERED, LEFT):
        return (UNKNOWN,)
    if event == FIRST_STEP:
        return (piece_at(kinks(law), kink_variable(law, contact, root)),)
    return (_next_piece(kinks(law), law.piece, event),)


def register_pieces(law_type, variable):
    """Register a type of law whose contacts end steps at its kinks over a `variable`, see `kink_variable`.

    The last field of the type is its `piece`, UNKNOWN at first.
    """
    kink_variable.member(law_type)(variable)
    guards.member(law_type)(_guards_of_pieces)
    guard_values.member(law_type)(_guard_values_of_pieces)
    latched.member(law_type)(_latched_piece)


# ---------------------------------------------------------------------------------------------- stateless laws


@kernel
def _closeness(kink):
    return max(RELATIVE_CLOSENESS * abs(kink), ABSOLUTE_CLOSENESS)


def _guards_of_kinks(law):
    return Guard(TOUCHING), Guard(TOUCHING)


@kernel
def distances_past_kinks(kink_values, start_value, value):
    """Return how far a variable at `value` is above the next kink and below the previous one of the step's start."""
    next_above, next_below = math.inf, -math.inf
    for kink in kink_values:
        next_above = where((start_value < kink - _closeness(kink)) & (kink < next_above), kink, next_above)
        next_below = where((start_value > kink + _closeness(kink)) & (kink > next_below), kink, next_below)
    return value - next_above, next_below - value


def _guard_values_of_kinks(law, start, contact, root):
    start_value = kink_variable(start.law, start.contact, root)
    return distances_past_kinks(kinks(law), start_value, kink_variable(law, contact, root))


def register_kinks(law_type, variable):
    """Register a type of law whose contacts end steps at its kinks, without a stored number of the piece.

    This is for laws with another state, or whose formula covers all pieces; the `variable` may not depend on the root.
    """
    kink_variable.member(law_type)(variable)
    guards.member(law_type)(_guards_of_kinks)
    guard_values.member(law_type)(_guard_values_of_kinks)


def slip_variable(law, contact, root):
    """Return the sliding speed, m/s."""
    return contact.slip


def depth_variable(law, contact, root):
    """Return the penetration from the coordinates, m."""
    return contact.depth


def rate_variable(law, contact, root):
    """Return the rate of the penetration, m/s."""
    return contact.rate


def penetration_variable(law, contact, root):
    """Return the penetration, m."""
    return root * root
