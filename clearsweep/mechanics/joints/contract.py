"""The interface between integration and joints; the integration knows no joint by name.

A joint has *contacts*, places where its two surfaces can touch: a revolute joint has one, a spatial joint several.  All
quantities of the loop and the figures are per contact, numbered through all joints: a mode, the rate at which the
present contact began, a root of penetration in the state vector, and the observables.

A joint has *parts*, its laws, each acting at one contact; see `laws.contract` for what a law may have.  Internal state
with rates is integrated, after the roots of penetration; state without rates changes only at events and is stored after
the contacts' onset rates.

A new kind of joint is one file and a choice in `registry.compile_joint`: a NamedTuple with the fields `clearance` and
`side`, and members of the families

    contact_modes(joint)                   modes of its contacts when apart and pressed, one entry per contact
    parts(joint)                           its laws, at least one, in the order of their internal states and guards
    load(joint, gap, offsets, state)       its forces on the bodies and the observables of its contacts

The time scale kappa and all sums, counts and maxima (`accumulate.totals`) follow only from modes and Contacts: a
contact that touches contributes to the time scale, a contact that acts to the sums.

A lubricated film is a joint whose contact has the mode ACTS, apart or pressed: it exerts a force from start to end, is
never searched for an onset, integrates no root and does not contribute to the time scale.  With a transition to dry
contact the mode apart is ACTS | MEETS and the mode pressed that of the dry joint.  A spatial joint returns several
modes and as many Contacts in its Load, each of which begins and ends independently; `parts` has its laws once for each
contact.
`test_joint_contract` has short examples of both.
"""

from typing import NamedTuple

import numpy as np

from ...tracing.compiled.family import family, form_number
from ..laws.contract import guards, internal_state, is_integrated


class Offsets(NamedTuple):
    """Indices of the first numbers of a joint or of one of its parts."""

    contact: int  # its first contact
    internal: int  # its first number of internal state in the state vector
    latched: int  # its first latched number
    guard: int  # its first guard


class JointState(NamedTuple):
    """State on which a joint's load depends besides the motion of its bodies."""

    y: np.ndarray  # (n,) the state vector
    mode: np.ndarray  # (contacts,) int64
    latched: (
        np.ndarray
    )  # (contacts + l,) numbers that change only at events: closing rate (m/s) of each onset, then those of laws
    roots: int  # index of the first root of penetration in `y`


class Contact(NamedTuple):
    """Observables of a contact."""

    normal: float  # N, not below the least force of its law: 0 unless the law pulls
    tangential: float  # N, on the journal
    slip: float  # m/s, sliding speed of the journal on the bearing; in free flight a bound of the rate of the depth
    rate: float  # m/s, rate of the eccentricity
    depth: float  # m, eccentricity minus clearance; negative for a gap
    elastic: float  # N, the elastic part of the normal force
    raw: float  # N, normal force before clipping, minus the least force of its law
    stopping_force: float = 0.0  # N, tangential force that would stop the sliding of surfaces that stick


class Load(NamedTuple):
    """Forces of a joint on its bodies, and its contacts."""

    fx: float  # N, on the distal body
    fy: float  # N
    moment_proximal: float  # N m, on the proximal body about its pin
    moment_distal: float  # N m
    contacts: tuple  # of Contacts


class Part(NamedTuple):
    """A law of a joint and the index of its contact within the joint."""

    law: tuple
    contact: int


class ContactModes(NamedTuple):
    """The modes of a contact after a separation and after an onset."""

    apart: int
    pressed: int


# ---------------------------------------------------------------------------------------------- of a joint


@family
def contact_modes(joint):
    """Return a ContactModes for each contact of the joint; depends only on its type."""


@family
def parts(joint):
    """Return the Parts of the joint, at least one: fields of it, or laws without parameters."""


@family
def load(joint, gap, offsets, state):
    """Return the Load of a joint for the relative motion `gap`, at its Offsets `offsets` in the JointState `state`."""


@family
def extra_columns(joint):
    """Return the numbers of extra observables and extra time histories of a joint; depends only on its type."""


@extra_columns.member(None)
def _default_extra_columns(joint):
    return 0, 0


# ---------------------------------------------------------------------------------------------- of a Contact


@family
def power_lost(contact):
    """Return the power (W) dissipated at a contact, without friction, -tangential x slip, and without stored power."""


@power_lost.member(None)
def _default_power_lost(contact):
    return (contact.normal - contact.elastic) * contact.rate


@family
def power_stored(contact):
    """Return the power (W) stored in the elastic deformation at a contact."""


@power_stored.member(None)
def _default_power_stored(contact):
    return contact.elastic * contact.rate


@family
def guard_quantity(contact):
    """Return a further quantity of a contact, which only guards use, 0 if they use none.

    For a dry contact it is the tangential force (N) that would stop the sliding of sticking surfaces; for a film its
    spin times the square of its eccentricity ratio (rad/s).
    """


@guard_quantity.member(None)
def _default_guard_quantity(contact):
    return 0.0


@guard_quantity.member(Contact)
def _guard_quantity_of_contact(contact):
    return contact.stopping_force


@family
def extra_observables(contact, is_converged):
    """Return the extra observables of a contact, () by default.

    is_converged : whether the state is converged, not an iterate.
    """


@extra_observables.member(None)
def _default_extra_observables(contact, is_converged):
    return ()


@family
def extra_channels(contact):
    """Return the values of a contact's extra time histories."""


@extra_channels.member(None)
def _default_extra_channels(contact):
    return ()


@family
def history_count(joint):
    """Return the number of time histories of a joint; depends only on its type."""


@family
def gap_histories(joint, gap, side):
    """Return the values of the first time histories, which follow from the gap; side : as in Work."""


@family
def load_histories(joint, load):
    """Return the values of the other time histories, which follow from the load."""


@history_count.member(None)
def _default_histories(joint):
    return 6


@gap_histories.member(None)
def _default_gap_histories(joint, gap, side):
    return side * gap.x, side * gap.y, side * gap.vx, side * gap.vy


@load_histories.member(None)
def _default_load_histories(joint, load):
    contact = load.contacts[0]
    return contact.normal, contact.tangential


# ---------------------------------------------------------------------------------------------- tables of a scene


def every_part(joints):
    """Return (index of its contact, law) of every part of the joints, in the order of internal states and guards."""
    parts_of_scene, first_contact = [], 0
    for joint in joints:
        parts_of_scene += [(first_contact + joint_part.contact, joint_part.law) for joint_part in parts(joint)]
        first_contact += len(contact_modes(joint))
    return parts_of_scene


def every_contact(joints):
    """Return (joint, its ContactModes) of every contact."""
    return [(joint, modes) for joint in joints for modes in contact_modes(joint)]


class StateKinds(NamedTuple):
    """Whether the laws of a scene have an internal state."""

    integrated: bool
    latched: bool


def state_kinds_of(scene):
    """Return the StateKinds of a compiled scene; they depend only on types, so they are cached."""
    number = form_number(scene)
    if number not in _STATE_KINDS:
        _STATE_KINDS[number] = StateKinds(bool(every_internal_state(scene.joints)), bool(every_latched(scene.joints)))
    return _STATE_KINDS[number]


_STATE_KINDS: dict[int, StateKinds] = {}  # form number of a scene -> StateKinds


def every_internal_state(joints):
    """Return (index of its contact, InternalState, initial value) of every integrated number."""
    return [
        (contact, declared, initial)
        for contact, law in every_part(joints)
        if law._field_defaults
        for declared, initial in zip(internal_state(law), law[len(law) - len(internal_state(law)) :], strict=True)
    ]


def every_latched(joints):
    """Return (law, initial value) of every latched number of internal state."""
    return [
        (law, initial)
        for _, law in every_part(joints)
        for initial in law[len(law) - len(law._field_defaults) :]
        if not is_integrated(type(law))
    ]


def every_guard(joints):
    """Return (index of its contact, Guard) of every guard."""
    return [(contact, guard) for contact, law in every_part(joints) for guard in guards(law)]
