"""A pin with clearance in a straight slot: two parallel walls and two rounded ends.

The slot is all that is within bearing_radius of a line of `length` between the centres of its ends.  So the pin touches
where it is farther from the nearest point of that line than the clearance, and the normal points from there to the
pin: across the walls, or radially at the ends, without a jump between them.  The proximal body has the slot, the distal
one the pin.  All is in the frame of the slot: x along it, y across.  Force and friction act on both bodies at the
pin's surface, so that their powers add up to normal force times rate of penetration and friction times sliding speed
exactly, as in a guide.
"""

from typing import NamedTuple

from ..compiled import calculus as math
from ..compiled.choosing import where
from ..compiled.dual import as_type_of
from ..compiled.family import inlined, kernel
from .contract import FREE, PRESSED, Contact, ContactModes, Load, Part, contact_modes, load, parts
from .dry import Clip, normal_forces
from .friction.contract import friction_force
from .places import after_law, with_current_state


class SlotJoint(NamedTuple):
    """A clearance joint between a slot and a pin."""

    clearance: float  # m, on each side
    journal_radius: float  # m, of the pin
    side: float  # +1: the pin is on the distal body
    half_length: float  # m, between the middle and the centre of an end
    law: tuple  # contact_force
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force


@contact_modes.member(SlotJoint)
def _one_contact(joint):
    return (ContactModes(FREE, PRESSED),)


@parts.member(SlotJoint)
def _clip_and_laws(joint):
    return Part(Clip(), 0), Part(joint.law, 0), Part(joint.friction, 0)


class _Normal(NamedTuple):
    """Where the pin is from the nearest point of the slot's line."""

    x: float  # unit vector
    y: float
    depth: float  # m
    rate: float  # m/s
    slip: float  # m/s, of the pin's surface over the slot's, along the normal turned by +90 degrees


@inlined
def _normal(joint, gap):
    beyond = gap.x - min(max(gap.x, -joint.half_length), joint.half_length)
    eccentricity = math.sqrt(beyond * beyond + gap.y * gap.y)
    centred = eccentricity <= 0.0
    inverse = 1.0 / where(centred, 1.0, eccentricity)
    nx, ny = beyond * inverse, where(centred, 1.0, gap.y * inverse)
    rate = gap.vx * nx + gap.vy * ny
    slip = gap.vy * nx - gap.vx * ny + joint.journal_radius * (gap.spin_distal - gap.spin_proximal)
    return _Normal(nx, ny, eccentricity - joint.clearance, rate, slip)


@kernel
def _pressed(joint, gap, place, present):
    normal, c = _normal(joint, gap), place.contact
    mode = present.mode[c]
    if mode == FREE:
        zero = as_type_of(0.0, normal.depth)
        apart = Contact(zero, zero, normal.slip, normal.rate, normal.depth, zero, zero)
        return zero, zero, zero, apart
    law = with_current_state(joint.law, present.y, present.latched, place)
    friction = with_current_state(joint.friction, present.y, present.latched, after_law(place, joint.law))
    root = present.y[present.roots + c]
    here = SlotJoint(
        clearance=joint.clearance,
        journal_radius=joint.journal_radius,
        side=joint.side,
        half_length=joint.half_length,
        law=law,
        elastic=joint.elastic,
        friction=friction,
    )
    force, rubbing, elastic, raw = normal_forces(here, mode, root * abs(root), normal.rate, present.latched[c])
    tangential = as_type_of(friction_force(friction, rubbing, normal.slip), normal.slip)
    contact = Contact(force, tangential, normal.slip, normal.rate, normal.depth, elastic, raw)
    axial, across = -force * normal.x - tangential * normal.y, -force * normal.y + tangential * normal.x
    return axial, across, joint.journal_radius * tangential, contact


@load.member(SlotJoint)
def _load_at_the_pin(joint, gap, place, present):
    axial, across, on_pin, contact = _pressed(joint, gap, place, present)
    return Load(
        fx=gap.axis_x * axial - gap.axis_y * across,
        fy=gap.axis_y * axial + gap.axis_x * across,
        moment_proximal=-on_pin - gap.x * across + gap.y * axial,
        moment_distal=on_pin,
        contacts=(contact,),
    )
