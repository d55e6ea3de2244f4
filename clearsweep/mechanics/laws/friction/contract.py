"""The interface of friction laws."""

import math
from collections.abc import Callable
from typing import NamedTuple

from ....contracts.catalogue import Field, Order
from ....tracing.compiled.family import family, kernel


@family
def friction_force(friction, normal, slip):
    """Return the tangential force (N) at normal force `normal` (N) and sliding speed `slip` (m/s); it opposes `slip`.

    `normal` is at least 0, except in trial steps past the end of a contact.
    """


@family
def static_limit(friction):
    """Return the static limit of tangential over normal force while sticking, 0 if the law does not stick.

    If a friction law of a scene is a member, contacts in the mode STUCK carry the force that keeps their surfaces from
    sliding.
    """


@static_limit.member(None)
def _default_static_limit(friction):
    return 0.0


@kernel
def friction_in_pin(friction, reaction, slip):
    """Return the tangential force (N) in a pin without clearance, from its `reaction` R (N).

    R is the resultant of normal force N and friction T, so T = R sin(atan(T/N)): the couple of T is that of R at the
    friction circle.  T/N is that of a normal force of 1 N, as laws are proportional to it.
    """
    ratio = friction_force(friction, 1.0, slip)
    return reaction * ratio / math.sqrt(1.0 + ratio * ratio)


@kernel
def static_limit_in_pin(friction, reaction):
    """Return the largest tangential force (N) of a pin that sticks, from its reaction (N), see `friction_in_pin`."""
    limit = static_limit(friction)
    return reaction * limit / math.sqrt(1.0 + limit * limit)


@family
def settled_state(friction, slip):
    """Return the internal state of a law after long sliding at `slip` (m/s), one number per field of state."""


class Settled(NamedTuple):
    """A friction law whose internal state is the settled one at any sliding speed, as for a machine without history."""

    law: tuple


@friction_force.member(Settled)
def _friction_force_settled(friction, normal, slip):
    law = friction.law
    parameter_count = len(law) - len(law._field_defaults)
    return friction_force(type(law)(*law[:parameter_count], *settled_state(law, slip)), normal, slip)


def without_history(friction):
    """Return a law without history: itself, or Settled where its state is integrated."""
    return Settled(friction) if type(friction) in settled_state.members else friction


FAMILIES = (friction_force,)  # every type must be a member of these families


class Frictionless(NamedTuple):
    """No tangential force; the sliding speed is never computed for it."""


@friction_force.member(Frictionless)
def _friction_force_frictionless(friction, normal, slip):
    return 0.0


# ---------------------------------------------------------------------------------------------- fields of several laws

COEFFICIENT = Field("coefficient", "1", "coefficient of kinetic friction, mu", low_open=False)
STATIC = Field("static_coefficient", "1", "coefficient of static friction, mu_s", low_open=False)
VISCOUS = Field("viscous", "s/m", "increase of the coefficient per sliding speed", low_open=False, default=0.0)
STRIBECK = (
    Field("stribeck_velocity", "m/s", "sliding speed over which friction falls from static to kinetic"),
    Field(
        "shape", "1", "exponent of the fall from static to kinetic friction; 2: Gaussian, 1: exponential", default=2.0
    ),
    VISCOUS,
)
KINETIC_FIRST = Order("coefficient", "static_coefficient", "friction falls once surfaces slide", equal=True)


def maker_from_values(law_type) -> Callable:
    """Return a function that creates a law of type `form` from the parameters of a joint."""
    names = [name for name in law_type._fields if name not in law_type._field_defaults]
    return lambda joint: law_type(*(joint.friction.values[name] for name in names))
