"""What the integration asks of a joint and of its laws; it knows no joint and no law by name.

A joint has *contacts*, places where its two surfaces can touch: a revolute joint has one, a spatial one several.  All
that the loop and the figures deal with is per contact, numbered through all joints: a mode, the rate at which the
present contact began, a root of penetration in the state vector, and the observables.

A joint is made of *parts*, its laws, each acting at one contact.  A part may have an internal state and guards,
functions of the motion that grow through zero where something changes: the loop locates that moment on the dense
output, changes the mode as the guard says and lets the part latch new values of its internal state.  An internal state
that has rates is integrated, in the state vector behind the roots of penetration; one without changes at events alone
and is constant, out of the integration, behind the onset rates of the contacts.

A new kind of joint is one file, and its choice in `registry.joint_term`: a NamedTuple with the fields `clearance` and
`side`, and members of the families

    contact_modes(joint)                   in which modes its contacts are apart and pressed: how many there are
    parts(joint)                           its laws, one at least, in the order of their internal states and guards
    load(joint, gap, place, present)       what it does to the bodies and what is seen of its contacts

and a new law is one file: a NamedTuple with members of the families of its force, and of these where it needs them:

    internal_state(law)                    error scale of each of its numbers, and whether a separation ends it
    internal_rates(law, contact)           their rates
    guards(law), guard_values(...)         what may happen in which mode, and where
    latched(law, event, contact, root)     what it keeps of an event

The last fields of a law that have a default are its internal state, the default being where it begins.  A member of
`internal_state` and `internal_rates` has it integrated; one of `latched` alone has it changed there and nowhere else.

The clock, 1/kappa, and what is summed, counted and maximised (`observe.totals`) follow from modes and Contacts alone: a
contact that touches has its share in the one, a contact that acts in the other.

A lubricated film is a joint whose contact is apart, and pressed, in the mode ACTS: it exerts a force from the start to
the end, is never searched for an onset, has no root to be integrated and no share in the clock.  Where a film gives way
to dry contact the mode apart is ACTS | MEETS, the mode pressed that of the dry joint.  A spatial joint returns several
modes and as many Contacts in its Load, each of which begins and ends by itself; its laws are in `parts` once for each
contact.  `test_joint_contract` has one of either, in a few lines.
"""

import math
from typing import NamedTuple

import numpy as np

from ..compiled.family import family, form_number, kernel

# A mode is a number below 63 whose bits say what the loop has to know; from LAWS_OWN on they distinguish a kind's own.
# ACTS: there is a force.  MEETS: surfaces are apart, an onset is looked for.  TOUCHES: they touch, a separation is.
ACTS, MEETS, TOUCHES, LAWS_OWN = 1, 2, 4, 8
FREE = MEETS  # apart and without force
PRESSED = ACTS | TOUCHES
# Modes of laws, listed here so that no number is given twice.
CLIPPED = PRESSED + LAWS_OWN  # penetrating, but the law of the normal force would pull
STUCK = PRESSED + 2 * LAWS_OWN  # pressed, and the surfaces stick
TOUCHING = tuple(mode for mode in range(63) if mode & TOUCHES)  # every mode of surfaces that touch
ENTERED, LEFT = -1, -2  # events of a contact as `latched` gets them; others are the law's own guards, from 0 on
SAME = -1  # of Guard.leads_to: the mode stays
ONSET_FLOOR = 1e-3  # m/s: laws divide by the onset rate; between 1e-6 and 1e-3 the choice changes nothing
NEVER = -math.inf  # value of a guard that cannot be passed as things are


class Offsets(NamedTuple):
    """Where the numbers of a joint, or of one of its parts, are."""

    contact: int  # its first contact
    internal: int  # its first number of internal state in the state vector
    latched: int  # its first number of those that are latched
    guard: int  # its first guard


class JointState(NamedTuple):
    """What the load of a joint depends on besides the motion of its bodies."""

    y: np.ndarray  # (n,) the state vector
    mode: np.ndarray  # (contacts,) int64
    latched: np.ndarray  # (contacts + l,) what changes at events alone: closing rate (m/s) of each onset; of laws
    roots: int  # where in `y` the roots of penetration begin


class Contact(NamedTuple):
    """What is seen of a contact."""

    normal: float  # N, at least what its law allows: 0 but where the law pulls
    tangential: float  # N, on the journal
    slip: float  # m/s, sliding speed of the journal surface on the bearing; in free flight the relative speed
    rate: float  # m/s, rate of the eccentricity
    depth: float  # m, eccentricity less clearance; negative where there is a gap
    elastic: float  # N, the elastic part of the normal force
    raw: float  # N, the normal force before it is clipped, above the least that its law allows


class Load(NamedTuple):
    """What a joint does to the bodies, and its contacts."""

    fx: float  # N, on the distal body
    fy: float  # N
    moment_proximal: float  # N m, on the proximal body about its pin
    moment_distal: float  # N m
    contacts: tuple  # of Contacts


class Part(NamedTuple):
    """A law of a joint and the contact, counted in the joint, at which it acts."""

    law: tuple
    contact: int


class ContactModes(NamedTuple):
    """The mode to which the separation of a contact leads, and that to which its onset leads."""

    apart: int
    pressed: int


class InternalState(NamedTuple):
    """What is to be known of one number of a law's internal state; its rate is of the same unit per second."""

    scale: float  # size by which its error is measured
    kept: bool  # over separations; else it goes back to where it began, and has no rate out of contact


class Guard(NamedTuple):
    """When a function of the motion that grows through zero changes something."""

    modes: tuple  # in which it is looked at
    leads_to: int = SAME  # the mode behind it
    at_stages: bool = False  # looked for at the stages of a step too, not only at its end
    at_start: bool = False  # passed, too, where it is above zero when a motion begins anew
    of_state: bool = False  # a function of root and internal state alone, so that no forces are evaluated to locate it
    counted: bool = False  # in the figure `force_clips`
    observable: int = -1  # of the contact, see `observables`, that is its value, so that nothing is evaluated; -1: none
    sign: float = 1.0  # by which that is multiplied
    ends_run: bool = False  # as the journal has left its bearing


# ---------------------------------------------------------------------------------------------- of a joint


@family
def contact_modes(joint):
    """Return one ContactModes per contact of the joint, by its type alone."""


@family
def parts(joint):
    """Return the Parts of the joint, at least one: fields of it, or laws without parameters."""


@family
def load(joint, gap, place, present):
    """Return the Load of the joint whose bodies are and move as `gap` says, at its Offsets in the JointState."""


@family
def extra_columns(joint):
    """Return how many observables and time histories a joint has besides those of every joint, by its type alone."""


@extra_columns.member(None)
def _default_extra_columns(joint):
    return 0, 0


# ---------------------------------------------------------------------------------------------- of a Contact


@family
def power_lost(contact):
    """Return the power (W) that a contact takes besides what it stores and besides -tangential times slip."""


@power_lost.member(None)
def _default_power_lost(contact):
    return (contact.normal - contact.elastic) * contact.rate


@family
def power_stored(contact):
    """Return the power (W) that goes into the elastic deformation at a contact."""


@power_stored.member(None)
def _default_power_stored(contact):
    return contact.elastic * contact.rate


@family
def extra_observables(contact, accurate):
    """Return what is seen of a contact besides a Contact's fields, observables of its own, or () if there is nothing.

    accurate : the state is one of the motion, none that an iteration passes.
    """


@extra_observables.member(None)
def _default_extra_observables(contact, accurate):
    return ()


@family
def extra_channels(contact):
    """Return the values of the time histories that a contact has besides those of every joint."""


@extra_channels.member(None)
def _default_extra_channels(contact):
    return ()


@family
def histories(joint):
    """Return how many time histories a joint has, by its type alone."""


@family
def gap_histories(joint, gap, side):
    """Return the values of the first of them, which follow from its gap; side : as in Work."""


@family
def load_histories(joint, load):
    """Return the values of the others, which follow from its load."""


@histories.member(None)
def _default_histories(joint):
    return 6


@gap_histories.member(None)
def _default_gap_histories(joint, gap, side):
    return side * gap.x, side * gap.y, side * gap.vx, side * gap.vy


@load_histories.member(None)
def _default_load_histories(joint, load):
    contact = load.contacts[0]
    for i in range(1, len(load.contacts)):
        if load.contacts[i].normal > contact.normal:
            contact = load.contacts[i]
    return contact.normal, contact.tangential


# ---------------------------------------------------------------------------------------------- of a law


@family
def internal_state(law):
    """Return one InternalState per number of the law's internal state, which is integrated."""


@family
def internal_rates(law, contact):
    """Return the rates (1/s) of the law's internal state at its Contact."""


@family
def guards(law):
    """Return the Guards of the law, which depend on its type alone: compiled code is made for their number."""


@family
def guard_values(law, start, contact, root):
    """Return the values of the law's guards.

    start, contact : Observed, of the contact at the start of the step and now; root : m^0.5, of the penetration now.
    """


@family
def latched(law, event, contact, root):
    """Return the law's internal state after an event: ENTERED, LEFT or the number of its guard.

    contact : Observed, where the event is; root : m^0.5, of the penetration.  What is integrated begins anew after a
    separation as `internal_state` says, whatever this returns.
    """


@internal_state.member(None)
@guards.member(None)
def _has_none(law):
    return ()


@internal_rates.member(None)
def _default_internal_rates(law, contact):
    return ()


@guard_values.member(None)
def _default_guard_values(law, start, contact, root):
    return ()


@latched.member(None)
def _default_latched(law, event, contact, root):
    return ()


TOGETHER = ((internal_state, internal_rates), (guards, guard_values))  # a law is a member of both or of neither


def undeclared(form):
    """Yield, in words, what the type of a law leaves out of what belongs together."""
    for first, second in TOGETHER:
        if (form in first.members) != (form in second.members):
            yield f"declares one of {first.__name__} and {second.__name__}; a law has both or neither"
    if (integrated(form) or form in latched.members) != bool(form._field_defaults):
        yield (
            "has to declare an internal_state with rates, or what is latched, if fields have defaults, and only then: "
            "these fields are the state"
        )


def integrated(form):
    """Return whether the internal state of a type of law is integrated, not latched at events alone."""
    return form in internal_state.members


# ---------------------------------------------------------------------------------------------- modes


@kernel
def acts(mode):
    """Return whether a contact in this mode exerts a force."""
    return mode & ACTS != 0


@kernel
def meets(mode):
    """Return whether the surfaces of a contact in this mode are apart and may come to touch."""
    return mode & MEETS != 0


@kernel
def touches(mode):
    """Return whether the surfaces of a contact in this mode touch."""
    return mode & TOUCHES != 0


# ---------------------------------------------------------------------------------------------- tables of a scene


def every_part(joints):
    """Return (number of its contact, law) of every part of the joints, in the order of internal states and guards."""
    listed, first = [], 0
    for joint in joints:
        listed += [(first + part.contact, part.law) for part in parts(joint)]
        first += len(contact_modes(joint))
    return listed


def every_contact(joints):
    """Return (joint, its ContactModes) of every contact."""
    return [(joint, modes) for joint in joints for modes in contact_modes(joint)]


class States(NamedTuple):
    """Whether laws have an internal state."""

    integrated: bool
    latched: bool


def states_of(scene):
    """Return the States of a compiled scene; the types of its laws decide them, so they are looked up."""
    number = form_number(scene)
    if number not in _STATES:
        _STATES[number] = States(bool(every_internal_state(scene.joints)), bool(every_latched(scene.joints)))
    return _STATES[number]


_STATES: dict[int, States] = {}  # by the number of the form of a scene


def every_internal_state(joints):
    """Return (number of its contact, InternalState, where it begins) of every number that is integrated."""
    return [
        (contact, declared, began)
        for contact, law in every_part(joints)
        if law._field_defaults
        for declared, began in zip(internal_state(law), law[len(law) - len(internal_state(law)) :], strict=True)
    ]


def every_latched(joints):
    """Return (law, where it begins) of every number of internal state that is latched."""
    return [
        (law, began)
        for _, law in every_part(joints)
        for began in law[len(law) - len(law._field_defaults) :]
        if not integrated(type(law))
    ]


def every_guard(joints):
    """Return (number of its contact, Guard) of every guard."""
    return [(contact, guard) for contact, law in every_part(joints) for guard in guards(law)]
