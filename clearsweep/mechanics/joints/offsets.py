"""Offsets of the numbers of joints and laws, and laws with their internal state from these arrays.

The number of values per joint follows from its type and is computed before compiling: the compiler would take
longer for it than for the forces.
"""

from ...tracing.compiled.family import inlined, kernel, kinds, map_joints
from ..laws.contract import guards, is_integrated
from ..observe import FILM_WIDTH, column_count
from .contract import Offsets, contact_modes, extra_columns, history_count, parts


class _Fields:
    """Access to the fields of a tuple or, for a compiler type, to their types."""

    def __init__(self, fields):
        self._named = fields

    def __getattr__(self, name):
        fields = self._named
        return fields.types[fields.fields.index(name)] if hasattr(fields, "instance_class") else getattr(fields, name)


def type_of(value):
    """Return the class of a tuple, or the class that a compiler type represents."""
    return getattr(value, "instance_class", type(value))


def _counts_of_law(law):
    """Return the numbers of internal state and guards of a law or its compiler type, as Offsets."""
    law_type = type_of(law)
    state_count = len(law_type._field_defaults)
    internal = state_count if is_integrated(law_type) else 0
    return Offsets(0, internal, state_count - internal, len(guards.body_for(law_type)(None)))


def counts_of_part(part):
    """Return the numbers of internal state and guards of a Part or its compiler type, as Offsets."""
    return _counts_of_law(_Fields(part).law)


def counts_of_joint(joint):
    """Return the numbers of contacts, internal state and guards of a joint or its compiler type."""
    kind = kinds(joint) if isinstance(joint, tuple) else joint
    if kind not in _COUNTS:
        joint_type = type_of(joint)
        contacts = Offsets(len(contact_modes.body_for(joint_type)(None)), 0, 0, 0)
        _COUNTS[kind] = _sum_counts([contacts, *map(counts_of_part, parts.body_for(joint_type)(_Fields(joint)))])
    return _COUNTS[kind]


_COUNTS: dict[object, Offsets] = {}  # types in a joint -> result of `counts_of_joint`


def counts_of_joints(joints):
    """Return the sum of `counts_of_joint` over the joints."""
    return _sum_counts(map(counts_of_joint, joints))


def _sum_counts(all_counts):
    return Offsets(*map(sum, zip(*all_counts, strict=True)))


@kernel
def after_number(offsets, number):
    """Return the Offsets after a number."""
    return offsets + 1


def _advance_by(counts_of_one):
    """Return a function that advances Offsets past a joint or part of the size `counts_of_one`."""

    def offsets_after(offsets, joint_part):
        contact_count, internal_count, latched_count, guard_count = counts_of_one(joint_part)
        return Offsets(
            offsets.contact + contact_count,
            offsets.internal + internal_count,
            offsets.latched + latched_count,
            offsets.guard + guard_count,
        )

    return offsets_after


after_law, after_part, after_joint = (
    _advance_by(_counts_of_law),
    _advance_by(counts_of_part),
    _advance_by(counts_of_joint),
)


def total_counts(joints):
    """Return the numbers of contacts, internal state and guards of the joints, as Offsets."""
    return counts_of_joints(joints)


def history_count_of(joint):
    """Return the number of time histories of a joint or its compiler type."""
    return history_count.body_for(type_of(joint))(None)


@kernel
def first_offsets(joints, roots):
    """Return the Offsets of the first joint; the roots of penetration begin at `roots` in the state vector."""
    contacts = total_counts(joints).contact
    return Offsets(0, roots + contacts, contacts, 0)


def _extra_counts(joint):
    return extra_columns.body_for(type_of(joint))(None)


def observable_count(joints):
    """Return the number of observables of a scene: those of films follow those of all contacts."""
    contacts = counts_of_joints(joints).contact
    return column_count(contacts) + (FILM_WIDTH * contacts if any(_extra_counts(joint)[0] for joint in joints) else 0)


def extra_channel_count(joint):
    """Return the number of extra time histories of a joint."""
    return _extra_counts(joint)[1]


# ---------------------------------------------------------------------------------------------- internal states


@kernel
def _state_item(default, _, offsets, numbers):
    return numbers[offsets]


_state_items = map_joints(_state_item, after_number)


@kernel
def with_internal_state(law, numbers, start):
    """Return the law with its internal state from `numbers`, starting at `start`."""
    law_type, parameter_count = type(law), len(law) - len(law._field_defaults)
    return law_type(*law[:parameter_count], *_state_items(law[parameter_count:], law[parameter_count:], start, numbers))


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
