"""Types of a spatial joint: compiled form, relative motion, contacts and laws."""

from typing import NamedTuple

from ....tracing.compiled.vector import Vector
from ...laws.contract import ACTS, FREE, MEETS, PRESSED, Guard, guards
from ...observe import RAW
from ..contract import ContactModes, Part, contact_modes, parts, power_lost, power_stored
from ..dry import dry_parts


class InBore(NamedTuple):
    """The end circles of the journal touch the wall of the bore."""


class AtEdges(NamedTuple):
    """The edges of the bore touch the wall of the journal."""


class Overlapping(NamedTuple):
    """Without flanges: at each end the journal's end circle touches or, if it is beyond the bore, the bore's edge."""


class EndContacts(NamedTuple):
    """Each wall contact has half of the stiffness, at its end."""


class FewNodes(NamedTuple):
    """Gauss rule with few nodes, exact for forces in proportion to depth or depth^(3/2)."""


class ManyNodes(NamedTuple):
    """Gauss rule with many nodes."""


class Spread(NamedTuple):
    """The stiffness is distributed uniformly over the overlap of journal and bore."""

    rule: tuple  # FewNodes or ManyNodes


class Leaving(NamedTuple):
    """The part of a joint without flanges that ends the run when the journal leaves the bore."""


class Through(NamedTuple):
    """A spatial joint without flanges."""

    clearance: float  # m, radial
    side: float  # +1: sign of a gap, journal minus bearing
    bearing_radius: float  # m
    journal_radius: float  # m
    half_length: float  # m, of the bearing
    journal_half_length: float  # m
    offset: Vector  # m, offset of the bearing's centre, in the frame of its body
    axis: Vector  # unit vector along the bearing, likewise
    end_type: tuple  # Overlapping
    walls: tuple  # EndContacts or Spread
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

SPATIAL_JOINT_TYPES: tuple[type, ...] = (Through, Flanged)


class SpatialGap(NamedTuple):
    """Motion of the journal in its bearing; everything but `frame` is in the frame of the journal."""

    middle: Vector  # m, of the journal, from the centre of the bearing
    velocity: Vector  # m/s, of the journal's middle less that of the bearing's
    axis: Vector  # unit vector along the bearing
    bearing_spin: Vector  # rad/s, angular velocity of the bearing
    journal_spin: Vector  # rad/s, of the journal
    frame: tuple  # attitude.Frame of the journal


class SpatialLoad(NamedTuple):
    """Forces of a spatial joint on its bodies, in the frame of the journal."""

    force: Vector  # N, on the journal
    journal_moment: Vector  # N m, moment about the journal's middle
    bearing_moment: Vector  # N m, moment on the bearing about its middle
    contacts: tuple  # of Contacts


class ContactForce(NamedTuple):
    """Force of a contact."""

    normal: Vector  # N, normal force on the journal
    force: Vector  # N, with friction
    moment: Vector  # N m, on the journal about its middle
    twist: Vector  # N m, of friction on the bearing's surface about the opposite point of the journal
    contact: tuple  # Contact or SpreadContact


class SpreadContact(NamedTuple):
    """Observables of a contact of spread walls: those of a Contact, plus powers."""

    normal: float  # N, for a wall that of its strip
    tangential: float  # N
    slip: float  # m/s
    rate: float  # m/s, at the end
    depth: float  # m, at the end
    elastic: float  # N
    raw: float  # N
    stored_power: float  # W
    lost_power: float  # W
    end_force: float  # N, for a wall: force at its end, of the two end forces with the strips' sum and moment


@power_stored.member(SpreadContact)
def _power_stored_spread_contact(contact):
    return contact.stored_power


@power_lost.member(SpreadContact)
def _power_lost_spread_contact(contact):
    return contact.lost_power


#: Mode of a wall contact in `Spread`: the pressed length may reach the half of an end that is apart.
APART = ACTS | MEETS
_WALLS = (ContactModes(FREE, PRESSED), ContactModes(FREE, PRESSED))
_SPREAD_WALLS = (ContactModes(APART, PRESSED), ContactModes(APART, PRESSED))
_AUXILIARY = (ContactModes(ACTS, ACTS), ContactModes(ACTS, ACTS))


def _wall_modes_of(joint):
    return _SPREAD_WALLS if joint is not None and isinstance(joint.walls, Spread) else _WALLS


@contact_modes.member(Through)
def _contact_modes_through(joint):
    return (*_wall_modes_of(joint), *_AUXILIARY)


@contact_modes.member(Flanged)
def _contact_modes_flanged(joint):
    return (*_wall_modes_of(joint), *_WALLS, *_AUXILIARY)


@guards.member(Leaving)
def _guards_leaving(leaving):
    return (Guard((ACTS,), observable=RAW, ends_run=True),)


@parts.member(Through)
def _parts_through(joint):
    return (
        *dry_parts(0, joint.law, joint.friction),
        *dry_parts(1, joint.law, joint.friction),
        Part(Leaving(), 3),
    )


@parts.member(Flanged)
def _parts_flanged(joint):
    return (
        *dry_parts(0, joint.law, joint.friction),
        *dry_parts(1, joint.law, joint.friction),
        *dry_parts(2, joint.axial_law, joint.friction),
        *dry_parts(3, joint.axial_law, joint.friction),
    )
