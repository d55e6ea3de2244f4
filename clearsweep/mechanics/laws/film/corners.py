"""Kinks of the force of a film. Steps end at them, so no step crosses one.

All films have corners at some depths.  Laws that treat a closing and an opening film, or both directions of rotation,
by different formulas also have corners where the rate or the spin changes its sign: they are members of
`has_reversal_corners`.
"""

from typing import NamedTuple

from ....tracing.compiled.family import family
from ...joints.contract import NEVER, Guard, guard_values, guards
from ...joints.kinks import distances_past_kinks
from ...joints.modes import ACTS, MEETS, TOUCHING

AFLOAT = ACTS | MEETS  # apart: the film carries load, an onset is searched for
MARGIN = 1e-9  # of the clearance: a step that begins this close to a corner has just passed it


class Corners(NamedTuple):
    """The part of a joint with a film that ends steps at corners of the film's force."""

    clamped: float  # m, depth beyond which the film's formula is kept constant
    begin: float  # m, depth from which the dry contact carries load; inf: never
    end: float  # m, depth from which only the dry contact carries load; inf: never
    margin: float  # m


@guards.member(Corners)
def _guards_corners(corners):
    return (
        Guard((ACTS, AFLOAT)),
        Guard((ACTS, AFLOAT)),
        Guard(TOUCHING),
        Guard(TOUCHING),
        Guard(TOUCHING),
        Guard(TOUCHING),
    )


@guard_values.member(Corners)
def _guard_values_corners(corners, start, contact, root):
    depth_before, depth_now, margin = start.contact.depth, contact.depth, corners.margin
    return (
        depth_now - corners.clamped if depth_before < corners.clamped - margin else NEVER,
        corners.clamped - depth_now if depth_before > corners.clamped + margin else NEVER,
        depth_now - corners.begin if depth_before < corners.begin - margin else NEVER,
        corners.begin - depth_now if depth_before > corners.begin + margin else NEVER,
        depth_now - corners.end if depth_before < corners.end - margin else NEVER,
        corners.end - depth_now if depth_before > corners.end + margin else NEVER,
    )


@family
def has_reversal_corners(law):
    """Declare that a film's force has corners where the rate of the eccentricity or the spin changes its sign."""


class Reversals(NamedTuple):
    """The part of a joint with such a film that ends steps where the rate or the spin changes its sign."""

    end: float  # m, depth from which only the dry contact carries load; inf: never


@guards.member(Reversals)
def _guards_reversals(reversals):
    modes = (ACTS, AFLOAT, *TOUCHING)
    return Guard(modes), Guard(modes), Guard(modes), Guard(modes)


@guard_values.member(Reversals)
def _guard_values_reversals(reversals, start, contact, root):
    above_zero_rate, below_zero_rate = distances_past_kinks((0.0,), start.contact.rate, contact.rate)
    above_zero_spin, below_zero_spin = distances_past_kinks(
        (0.0,), start.contact.guard_quantity, contact.guard_quantity
    )
    if start.contact.depth < reversals.end:
        return above_zero_rate, below_zero_rate, above_zero_spin, below_zero_spin
    return NEVER, NEVER, NEVER, NEVER
