"""Where the numbers of joints and laws are, and laws with their internal state from there.

How much room a joint takes follows from its type and is computed where code is compiled: the compiler would take
longer over it than over the forces.
"""

from ..compiled.family import inlined, kernel, kinds, map_joints
from ..observe.observables import FILM_WIDTH, columns
from .contract import Offsets, contact_modes, extra_columns, guards, histories, integrated, parts


class _Fields:
    """The fields of a tuple or, of the compiler's type of one, their types."""

    def __init__(self, named):
        self._named = named

    def __getattr__(self, name):
        named = self._named
        return named.types[named.fields.index(name)] if hasattr(named, "instance_class") else getattr(named, name)


def form_of(value):
    """Return the class of a tuple or, of the compiler's type of one, the class that it represents."""
    return getattr(value, "instance_class", type(value))


def _room_of_law(law):
    """Return how many numbers of internal state and guards a law, or the compiler's type of one, has: a Place."""
    form = form_of(law)
    numbers = len(form._field_defaults)
    internal = numbers if integrated(form) else 0
    return Offsets(0, internal, numbers - internal, len(guards.body_for(form)(None)))


def room_of_part(part):
    """Return the same of a Part, or of the compiler's type of one."""
    return _room_of_law(_Fields(part).law)


def room_of(joint):
    """Return how many contacts, numbers of internal state and guards a joint, or the compiler's type of one, has."""
    kind = kinds(joint) if isinstance(joint, tuple) else joint
    if kind not in _ROOMS:
        form = form_of(joint)
        contacts = Offsets(len(contact_modes.body_for(form)(None)), 0, 0, 0)
        _ROOMS[kind] = _sum([contacts, *map(room_of_part, parts.body_for(form)(_Fields(joint)))])
    return _ROOMS[kind]


_ROOMS: dict[object, Offsets] = {}  # what `room_of` found, by the types in a joint


def room_of_all(joints):
    """Return the sum of what `room_of` returns of each of the joints."""
    return _sum(map(room_of, joints))


def _sum(places):
    return Offsets(*map(sum, zip(*places, strict=True)))


@kernel
def after_number(place, number):
    """Return the place after a number."""
    return place + 1


def _after(room_of_one):
    """Return a function that returns the Place after a Place and what takes the room that `room_of_one` gives."""

    def after(place, joint_part):
        contacts, internal, latching, guarded = room_of_one(joint_part)
        return Offsets(
            place.contact + contacts, place.internal + internal, place.latched + latching, place.guard + guarded
        )

    return after


after_law, after_part, after_joint = _after(_room_of_law), _after(room_of_part), _after(room_of)


def extent(joints):
    """Return how many contacts, numbers of internal state and guards the joints have, as a Place."""
    return room_of_all(joints)


def histories_of(joint):
    """Return how many time histories a joint, or the compiler's type of one, has."""
    return histories.body_for(form_of(joint))(None)


@kernel
def first_place(joints, roots):
    """Return the Place of the first joint, the roots of penetration beginning at `roots` in the state vector."""
    contacts = extent(joints).contact
    return Offsets(0, roots + contacts, contacts, 0)


def _beside(joint):
    return extra_columns.body_for(form_of(joint))(None)


def observed_columns(joints):
    """Return how many observables a scene of these joints has: those of films are behind those of all contacts."""
    contacts = room_of_all(joints).contact
    return columns(contacts) + (FILM_WIDTH * contacts if any(_beside(joint)[0] for joint in joints) else 0)


def channels_beside_those(joint):
    """Return how many time histories a joint has besides those of every joint."""
    return _beside(joint)[1]


# ---------------------------------------------------------------------------------------------- internal states


@kernel
def _number(old, _, place, numbers):
    return numbers[place]


_numbers = map_joints(_number, after_number)


@kernel
def with_internal_state(law, numbers, first):
    """Return the law with its internal state, which is in `numbers` from `first` on."""
    cls, own = type(law), len(law) - len(law._field_defaults)
    return cls(*law[:own], *_numbers(law[own:], law[own:], first, numbers))


@kernel
def where_internal(law, y, latched, place):
    """Return the array in which the internal state of a law is, and where: the state vector or what is latched."""
    return (y, place.internal) if integrated(type(law)) else (latched, place.latched)


@kernel
def with_current_state(law, y, latched, place):
    """Return the law, which has its Place, with its internal state."""
    numbers, first = where_internal(law, y, latched, place)
    return with_internal_state(law, numbers, first)


@inlined
def with_laws_as_they_are(joint, place, present):
    """Return a joint of one contact, its law and its friction with their internal state at `present`."""
    law = with_current_state(joint.law, present.y, present.latched, place)
    friction = with_current_state(joint.friction, present.y, present.latched, after_law(place, joint.law))
    return joint._replace(law=law, friction=friction)
