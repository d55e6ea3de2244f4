"""Laws whose formula changes at some places, its *kinks*: steps end there, and within a step one formula applies.

A method of high order keeps its order across no kink, and an iteration hardly converges on one.  So a law of this kind
keeps which of its pieces applies, numbered over the variable of its kinks; a trial step that runs beyond the
end of the piece goes on by its formula and is cut there.
"""

import math

from ..compiled.choosing import where
from ..compiled.dual import plain
from ..compiled.family import family, kernel
from .contract import ENTERED, LEFT, NEVER, Guard, guard_values, guards, latched
from .modes import TOUCHING

UNKNOWN = -1.0  # number of the piece until the first step of a contact; then the value says which it is
NEAR, NEAREST = 1e-6, 1e-9  # of a kink, or m/s where that is zero: a step that begins as close to it has just passed it
UP, DOWN, BEGUN = 0, 1, 2  # guards: the end of the piece, its beginning; the piece is not known yet


@family
def kinks(law):
    """Return the places (a tuple, rising) over its variable at which the formula of a law changes."""


@kernel
def piece_at(places, x):
    """Return the number of the piece in which `x` is, of those that the places part."""
    number = 0.0
    for kink in places:
        number = number + where(plain(x) > kink, 1.0, 0.0)
    return number


@kernel
def piece_of(piece, places, x):
    """Return the number of the piece that applies: the `piece` of a law or, where that is UNKNOWN, that of `x`."""
    return where(piece >= 0.0, piece, piece_at(places, x))


@kernel
def _distances(places, piece, x):
    """Return how far `x` is beyond the end and before the beginning of a piece, NEVER where it has none."""
    above_kink = below_kink = NEVER
    for i in range(len(places)):
        above_kink = where(piece == i, x - places[i], above_kink)
        below_kink = where(piece == i + 1.0, places[i] - x, below_kink)
    return above_kink, below_kink


@kernel
def _piece_behind(places, piece, event):
    """Return the piece behind the end (UP) or the beginning (DOWN) of a piece; pieces without width are left out."""
    number, kink_passed = 0.0, 0.0
    for i in range(len(places)):
        kink_passed = where(piece == (i if event == UP else i + 1.0), places[i], kink_passed)
    for i in range(len(places)):
        inside = places[i] <= kink_passed if event == UP else places[i] < kink_passed
        number = number + where(inside, 1.0, 0.0)
    return number


@family
def kink_variable(law, contact, root):
    """Return the number that the kinks of a law are places of.

    contact : Observed; root : m^0.5, of the penetration.
    """


def _guards_of_pieces(law):
    return Guard(TOUCHING), Guard(TOUCHING), Guard(TOUCHING, at_start=True)


def _guard_values_of_pieces(law, start, contact, root):
    if law.piece < 0.0:
        return NEVER, NEVER, 1.0
    above_kink, below_kink = _distances(kinks(law), law.piece, kink_variable(law, contact, root))
    return above_kink, below_kink, NEVER


def _latched_piece(law, event, contact, root):
    if event in (ENTERED, LEFT):
        return (UNKNOWN,)
    if event == BEGUN:
        return (piece_at(kinks(law), kink_variable(law, contact, root)),)
    return (_piece_behind(kinks(law), law.piece, event),)


def in_pieces(form, variable):
    """Let contacts end steps at the kinks over a `variable`, see `kink_variable`, of a type of law.

    The last field of the type is its `piece`, UNKNOWN at first.
    """
    kink_variable.member(form)(variable)
    guards.member(form)(_guards_of_pieces)
    guard_values.member(form)(_guard_values_of_pieces)
    latched.member(form)(_latched_piece)


# ---------------------------------------------------------------------------------------------- without a piece


@kernel
def _near(kink):
    return max(NEAR * abs(kink), NEAREST)


def _guards_of_kinks(law):
    return Guard(TOUCHING), Guard(TOUCHING)


@kernel
def from_next_kinks(places, was, position):
    """Return how far a variable at `position` is above the next kink and below the previous one of the step's start."""
    next_above, next_below = math.inf, -math.inf
    for kink in places:
        next_above = where((was < kink - _near(kink)) & (kink < next_above), kink, next_above)
        next_below = where((was > kink + _near(kink)) & (kink > next_below), kink, next_below)
    return position - next_above, next_below - position


def _guard_values_of_kinks(law, start, contact, root):
    return from_next_kinks(kinks(law), kink_variable(law, start, root), kink_variable(law, contact, root))


def with_kinks(form, variable):
    """Let contacts end steps at the kinks over a `variable`, which does not use the root, of a type of law.

    For laws that keep another state, or whose formula knows by itself what applies.
    """
    kink_variable.member(form)(variable)
    guards.member(form)(_guards_of_kinks)
    guard_values.member(form)(_guard_values_of_kinks)


def over_slip(law, contact, root):
    """Return the sliding speed, m/s."""
    return contact.slip


def over_depth(law, contact, root):
    """Return the penetration as the coordinates have it, m."""
    return contact.depth


def over_rate(law, contact, root):
    """Return the rate of the penetration, m/s."""
    return contact.rate


def over_penetration(law, contact, root):
    """Return the penetration, m."""
    return root * root
