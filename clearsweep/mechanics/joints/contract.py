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

The time scale kappa and all sums, counts and maxima (`solver.totals`) follow only from modes and Contacts: a
contact that touches contributes to the time scale, a contact that acts to the sums.

A lubricated film is a joint whose contact has the mode ACTS, apart or pressed: it exerts a force from start to end, is
never searched for an onset, integrates no root and does not contribute to the time scale.  With a transition to dry
contact the mode apart is ACTS | MEETS and the mode pressed that of the dry joint.  A spatial joint returns several
modes and as many Contacts in its Load, each of which begins and ends independently; `parts` has its laws once for each
contact.
tests/test_joint_contract.py has short examples of both.
"""

import functools
import itertools
import operator
from typing import NamedTuple

import numpy as np

from ...tracing.compiled.family import family, family_with_default, form_number, inlined, kernel, kinds, known
from ..laws.contract import guards, internal_state, is_integrated
from ..observe import FILM_WIDTH, column_count


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
    #: (contacts,) rad, of a stage: angles at which the deepest points of worn surfaces were found last
    deepest_angles: np.ndarray | None = None


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


#: Name and type of the fields with which the observables of every kind of contact begin.
CONTACT_FIELDS = [*Contact.__annotations__.items()][: Contact._fields.index("stopping_force")]


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


@family_with_default
def contacts_at_speed(joint, gap, offsets, state, before):
    """Return the contacts of a joint with the rates of their depths; before : its Load, at other velocities."""
    return load(joint, gap, offsets, state).contacts


@family_with_default
def extra_columns(joint):
    """Return the number of extra observables of a joint; depends only on its type."""
    return 0


# ---------------------------------------------------------------------------------------------- of a Contact


@family_with_default
def power_lost(contact):
    """Return the power (W) dissipated at a contact, without friction, -tangential x slip, and without stored power."""
    return (contact.normal - contact.elastic) * contact.rate


@family_with_default
def power_stored(contact):
    """Return the power (W) stored in the elastic deformation at a contact."""
    return contact.elastic * contact.rate


@family_with_default
def guard_quantity(contact):
    """Return a further quantity of a contact, which only guards use, 0 if they use none.

    For a dry contact it is the tangential force (N) that would stop the sliding of sticking surfaces; for a film its
    spin times the square of its eccentricity ratio (rad/s).
    """
    return 0.0


guard_quantity.member(Contact)(lambda contact: contact.stopping_force)


@family_with_default
def extra_observables(contact, is_converged):
    """Return the extra observables of a contact, () by default.

    is_converged : whether the state is converged, not an iterate.
    """
    return ()


@family_with_default
def extra_channels(contact):
    """Return the values of a contact's extra time histories."""
    return ()


@family_with_default
def gap_histories(joint, gap, side):
    """Return the values of the first time histories, which follow from the gap; side : as in Work."""
    return side * gap.x, side * gap.y, side * gap.vx, side * gap.vy


@family_with_default
def load_histories(joint, load):
    """Return the values of the other time histories, which follow from the load."""
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


# ---------------------------------------------------------------------------------------------- offsets


@known
def counts_of(law):
    """Return the numbers of internal state and guards of a law, as Offsets; they depend only on its type."""
    state_count = len(law._field_defaults)
    internal = state_count if is_integrated(type(law)) else 0
    return Offsets(0, internal, state_count - internal, len(guards(law)))


def _counts_of_joint(joint):
    """Return the numbers of contacts, internal state and guards of a joint."""
    kind = kinds(joint)
    if kind not in _COUNTS:
        contacts = Offsets(len(contact_modes(joint)), 0, 0, 0)
        _COUNTS[kind] = functools.reduce(_after, [counts_of(part.law) for part in parts(joint)], contacts)
    return _COUNTS[kind]


_COUNTS: dict[object, Offsets] = {}  # types in a joint -> result of `_counts_of_joint`


def _after(offsets, counts):
    return Offsets(*map(operator.add, offsets, counts))


@known
def total_counts(joints):
    """Return the numbers of contacts, internal state and guards of the joints, as Offsets."""
    return functools.reduce(_after, map(_counts_of_joint, joints), Offsets(0, 0, 0, 0))


@known
def after_law(offsets, law):
    """Return the Offsets after a law."""
    return _after(offsets, counts_of(law))


@kernel
def first_offsets(joints, roots):
    """Return the Offsets of the first joint; the roots of penetration begin at `roots` in the state vector."""
    contacts = total_counts(joints).contact
    return Offsets(0, roots + contacts, contacts, 0)


@inlined
def repeated_offsets(offsets, number, laws):
    """Return the Offsets of `laws` at contact `number` of a joint that repeats them at each; clips have no numbers."""
    following = offsets
    for law in laws:
        following = after_law(following, law)
    return Offsets(
        offsets.contact + number,
        offsets.internal + number * (following.internal - offsets.internal),
        offsets.latched + number * (following.latched - offsets.latched),
        offsets.guard,
    )


@known
def offsets_of(joints, roots):
    """Return the Offsets of each joint; the roots of penetration begin at `roots` in the state vector."""
    counts = map(_counts_of_joint, joints)
    return tuple(itertools.accumulate(counts, _after, initial=first_offsets(joints, roots)))[:-1]


@inlined
def located_parts(joints, roots):
    """Return (index of its joint, Part, its Offsets) of every part of the joints; roots : as for `offsets_of`."""
    located = ()
    for number, (joint, offsets) in enumerate(zip(joints, offsets_of(joints, roots), strict=True)):
        part_offsets = offsets
        for part in parts(joint):
            located = (*located, (number, part, part_offsets))
            part_offsets = after_law(part_offsets, part.law)
    return located


@known
def observable_count(joints):
    """Return the number of observables of a scene: those of films follow those of all contacts."""
    contacts = total_counts(joints).contact
    return column_count(contacts) + (FILM_WIDTH * contacts if any(extra_columns(joint) for joint in joints) else 0)


# ---------------------------------------------------------------------------------------------- internal states


@kernel
def with_internal_state(law, numbers, start):
    """Return the law with its internal state from `numbers`, starting at `start`."""
    law_type, parameter_count = type(law), len(law) - len(law._field_defaults)
    return law_type(*law[:parameter_count], *[numbers[start + i] for i in range(len(law) - parameter_count)])


@kernel
def internal_state_location(law, y, latched, offsets):
    """Return the array of a law's internal state, the state vector or the latched numbers, and its index there."""
    return (y, offsets.internal) if is_integrated(type(law)) else (latched, offsets.latched)


@kernel
def with_current_state(law, y, latched, offsets):
    """Return the law with its internal state at its Offsets `offsets`."""
    numbers, start = internal_state_location(law, y, latched, offsets)
    return with_internal_state(law, numbers, start)


@inlined
def with_current_laws(joint, offsets, state):
    """Return a joint of one contact, its law and its friction with their internal state at `state`."""
    law = with_current_state(joint.law, state.y, state.latched, offsets)
    friction = with_current_state(joint.friction, state.y, state.latched, after_law(offsets, joint.law))
    return joint._replace(law=law, friction=friction)


# ---------------------------------------------------------------------------------------------- grips


@family_with_default
def grips_of(joint, gap, load, mode, first_contact):
    """Return the grips of a joint under its Load; () if it cannot stick.  first_contact : index of its first contact.

    mode : (contacts,) mode of each contact.  A grip has the fields `contacts`, the numbers of its contacts, `force`
    (N), the tangential force of the sticking ones, `limit` (N), its largest value, and `slip` (m/s).  Past a separation
    the limit of a single contact is negative, so that trial steps continue smoothly.
    """
    return ()


@family
def slip_rate(grip, acceleration):
    """Return the rate (m/s^2) of the sliding speed of a grip, from the GapAcceleration of its joint."""


@family
def with_tangential(grip, load, force, stopping_force):
    """Return the Load of a joint with `force` (N) in place of the tangential force of one of its grips.

    stopping_force : N, force that would stop the sliding.
    """
