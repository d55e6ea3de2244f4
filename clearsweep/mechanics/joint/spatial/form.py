"""The compiled form of a spatial joint, how its bodies are, and which contacts and laws it has."""

from typing import NamedTuple

from ...compiled.vector import Vector
from ...observe.observables import RAW
from ..contract import (
    ACTS,
    FREE,
    MEETS,
    PRESSED,
    ContactModes,
    Guard,
    Part,
    contact_modes,
    guards,
    parts,
    power_lost,
    power_stored,
)
from ..dry import Clip


class InBore(NamedTuple):
    """The end circles of the journal bear on the wall of the bore."""


class AtEdges(NamedTuple):
    """The edges of the bore bear on the wall of the journal."""


class Overlapping(NamedTuple):
    """Without flanges: at each end the journal's end circle bears or, where it is beyond the bore, the bore's edge."""


class EndContacts(NamedTuple):
    """Each wall contact has half of the stiffness, at its end."""


class Few(NamedTuple):
    """Gauss's rule of few nodes, exact for forces that go with the depth or with its power 3/2."""


class Many(NamedTuple):
    """Gauss's rule of many nodes."""


class Spread(NamedTuple):
    """The stiffness is spread evenly over the length on which journal and bore overlap."""

    rule: tuple  # Few or Many


class Leaving(NamedTuple):
    """The part of a joint without flanges that ends the run when the journal leaves the bore."""


class Through(NamedTuple):
    """A spatial joint without flanges."""

    clearance: float  # m, radial
    side: float  # +1: that of a gap, journal less bearing
    bearing_radius: float  # m
    journal_radius: float  # m
    half_length: float  # m, of the bearing
    half_journal: float  # m
    offset: Vector  # m, of the bearing's middle from the nominal one, in the frame of its body
    axis: Vector  # unit vector along the bearing, likewise
    ends: tuple  # Overlapping
    walls: tuple  # Ends or Spread
    law: tuple  # contact_force of the whole joint
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force
    wear: tuple  # wear_rate
    across: Vector  # unit vector of the bearing's own x axis, in the frame of its body
    wear_rows: float  # bins of wear along the length


Flanged = NamedTuple(
    "Flanged",
    [
        *Through.__annotations__.items(),
        ("axial_clearance", float),  # m, on each side
        ("axial_law", tuple),  # contact_force of a flange
        ("axial_elastic", tuple),
    ],
)
Flanged.__doc__ = "A spatial joint between flanges."

KINDS: tuple[type, ...] = (Through, Flanged)


class SpatialGap(NamedTuple):
    """The journal in its bearing: all in the frame of the journal, but `frame`."""

    middle: Vector  # m, of the journal, from the middle of the bearing
    velocity: Vector  # m/s, of the journal's middle less that of the bearing's
    axis: Vector  # unit vector along the bearing
    on_bearing: Vector  # rad/s, angular velocity of the bearing
    on_journal: Vector  # rad/s, of the journal
    frame: tuple  # attitude.Frame of the journal


class SpatialLoad(NamedTuple):
    """What a spatial joint does to the bodies, in the frame of the journal."""

    force: Vector  # N, on the journal
    on_journal: Vector  # N m, moment about the journal's middle
    on_bearing: Vector  # N m, moment on the bearing about its middle
    contacts: tuple  # of Contacts


class Touch(NamedTuple):
    """What a contact does."""

    normal: Vector  # N, normal force on the journal
    force: Vector  # N, with friction
    moment: Vector  # N m, on the journal about its middle
    twist: Vector  # N m, of the friction on the bearing's surface about the same place on the journal's
    contact: tuple  # Contact or SpreadContact


class SpreadContact(NamedTuple):
    """What is seen of a contact of a joint whose walls are spread: as of a Contact, with powers of its own."""

    normal: float  # N, of a wall that of its strip
    tangential: float  # N
    slip: float  # m/s
    rate: float  # m/s, at the end
    depth: float  # m, at the end
    elastic: float  # N
    raw: float  # N
    stored: float  # W
    lost: float  # W
    at_end: (
        float  # N, of a wall: of two forces at both ends, with the sum and the moment of the strips', that at its end
    )


@power_stored.member(SpreadContact)
def _power_stored_spread_contact(contact):
    return contact.stored


@power_lost.member(SpreadContact)
def _power_lost_spread_contact(contact):
    return contact.lost


#: Of a wall contact in `Spread`: what is pressed may reach the half of an end that is apart.
APART = ACTS | MEETS
_WALLS = (ContactModes(FREE, PRESSED), ContactModes(FREE, PRESSED))
_SPREAD_WALLS = (ContactModes(APART, PRESSED), ContactModes(APART, PRESSED))
_TELLING = (ContactModes(ACTS, ACTS), ContactModes(ACTS, ACTS))


def _walls_of(joint):
    return _SPREAD_WALLS if joint is not None and isinstance(joint.walls, Spread) else _WALLS


@contact_modes.member(Through)
def _contact_modes_through(joint):
    return (*_walls_of(joint), *_TELLING)


@contact_modes.member(Flanged)
def _contact_modes_flanged(joint):
    return (*_walls_of(joint), *_WALLS, *_TELLING)


@guards.member(Leaving)
def _guards_leaving(leaving):
    return (Guard((ACTS,), observable=RAW, ends_run=True),)


@parts.member(Through)
def _parts_through(joint):
    return (
        Part(Clip(), 0),
        Part(joint.law, 0),
        Part(joint.friction, 0),
        Part(Clip(), 1),
        Part(joint.law, 1),
        Part(joint.friction, 1),
        Part(Leaving(), 3),
    )


@parts.member(Flanged)
def _parts_flanged(joint):
    return (
        Part(Clip(), 0),
        Part(joint.law, 0),
        Part(joint.friction, 0),
        Part(Clip(), 1),
        Part(joint.law, 1),
        Part(joint.friction, 1),
        Part(Clip(), 2),
        Part(joint.axial_law, 2),
        Part(joint.friction, 2),
        Part(Clip(), 3),
        Part(joint.axial_law, 3),
        Part(joint.friction, 3),
    )
