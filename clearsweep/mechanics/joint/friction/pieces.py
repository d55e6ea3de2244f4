"""Friction whose formula changes at some sliding speeds, so that steps end there."""

from typing import NamedTuple

from ...compiled.family import family
from ..pieces import UNKNOWN, in_pieces, kinks, over_slip, piece_at, piece_of
from .contract import friction_force


class InPieces(NamedTuple):
    """A friction law in a contact, which knows the piece of the law that applies."""

    law: tuple  # a member of `force_in_piece` and, over the sliding speed, of `kinks`
    piece: float = UNKNOWN


@family
def force_in_piece(law, piece, normal, slip):
    """Return the `friction_force` by the formula of a piece, counted from the lowest sliding speed."""


@friction_force.member(InPieces)
def _friction_force_in_pieces(friction, normal, slip):
    law = friction.law
    return force_in_piece(law, piece_of(friction.piece, kinks(law), slip), normal, slip)


@kinks.member(InPieces)
def _kinks_in_pieces(friction):
    return kinks(friction.law)


in_pieces(InPieces, over_slip)


def at_rest(friction):
    """Return the kink of a law that has one where the surfaces are at rest."""
    return (0.0,)


def _friction_force_by_value(law, normal, slip):
    return force_in_piece(law, piece_at(kinks(law), slip), normal, slip)


def piecewise(form, places):
    """Return the decorator that enters the `force_in_piece` of a type; places : of a law, its `kinks`."""

    def register(body):
        kinks.member(form)(places)
        friction_force.member(form)(_friction_force_by_value)
        return force_in_piece.member(form)(body)

    return register


def at_contact(friction):
    """Return a compiled friction law as a contact has it, which knows how it slides."""
    return InPieces(friction) if type(friction) in force_in_piece.members else friction
