"""Friction whose formula changes at some sliding speeds, so that steps end there."""

from typing import NamedTuple

from ....tracing.compiled.family import family
from ...joints.kinks import UNKNOWN, current_piece, kinks, piece_at, register_pieces, slip_variable
from .contract import friction_force


class PiecewiseFriction(NamedTuple):
    """A friction law of a contact, with the piece of the law that applies."""

    law: tuple  # a member of `force_in_piece` and, over the sliding speed, of `kinks`
    piece: float = UNKNOWN


@family
def force_in_piece(law, piece, normal, slip):
    """Return the `friction_force` by the formula of a piece, counted from the lowest sliding speed."""


@friction_force.member(PiecewiseFriction)
def _friction_force_piecewise_friction(friction, normal, slip):
    law = friction.law
    return force_in_piece(law, current_piece(friction.piece, kinks(law), slip), normal, slip)


@kinks.member(PiecewiseFriction)
def _kinks_piecewise_friction(friction):
    return kinks(friction.law)


register_pieces(PiecewiseFriction, slip_variable)


def zero_slip_kink(friction):
    """Return the kink, at zero speed, of a law that has one there."""
    return (0.0,)


def _friction_force_by_slip(law, normal, slip):
    return force_in_piece(law, piece_at(kinks(law), slip), normal, slip)


def register_force_in_piece(law_type, kink_speeds):
    """Return the decorator that registers the `force_in_piece` of a type of law; kink_speeds : law -> its `kinks`."""

    def register(force_function):
        kinks.member(law_type)(kink_speeds)
        friction_force.member(law_type)(_friction_force_by_slip)
        return force_in_piece.member(law_type)(force_function)

    return register


def as_contact_friction(friction):
    """Return a compiled friction law in the form used by a contact, which stores the piece that applies."""
    return PiecewiseFriction(friction) if type(friction) in force_in_piece.members else friction
