"""What a friction law declares."""

from typing import NamedTuple

from ...compiled.family import family


@family
def friction_force(friction, normal, slip):
    """Return the tangential force (N) at normal force `normal` (N) and sliding speed `slip` (m/s); it opposes `slip`.

    `normal` is at least 0, but in trial steps past the end of a contact.
    """


@family
def holding(friction):
    """Return the tangential force over the normal one that a law holds while it sticks, 0 if it does not stick."""


@holding.member(None)
def _slides(friction):
    return 0.0


FAMILIES = (friction_force,)  # a type of this kind is a member of each


class Frictionless(NamedTuple):
    """No tangential force; the sliding speed is never computed for it."""


@friction_force.member(Frictionless)
def _frictionless(friction, normal, slip):
    return 0.0
