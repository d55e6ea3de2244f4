"""A pin with clearance in a straight slot: two parallel walls and two rounded ends.

The slot is the set of points within bearing_radius of a line of `length` between the centres of its ends.  So the pin
touches where its distance from the nearest point of that line exceeds the clearance.  The normal points from there to
the pin: across the walls, or radially at the ends, without a jump between them.  The slot is on the proximal body, the
pin on the distal one.  All vectors are in the frame of the slot: x along it, y across.  Force and friction act on both
bodies at the pin's surface.  So, as in a guide, their powers add up exactly to normal force times rate of penetration
plus friction times sliding speed.

Wear of the wall depends on the arc length s along it, counter-clockwise from the middle of the end that lies in the
direction of the slot.  With the angle a (0 to 2 pi) of the normal, the radius R of the ends and half the length l, x
within +-l,

    s = R a + (l - x where a <= pi, else 3 l + x).

"""

from typing import NamedTuple

from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import inlined, kernel
from ..laws.contract import FREE, PRESSED, touches
from ..laws.friction import friction_force
from ..wear import arc_width, local_clearance
from ..wear.bins import SLOPES, record
from .contract import Contact, ContactModes, Load, Part, contact_modes, load, parts
from .dry import Clip, normal_forces
from .offsets import after_law, with_current_state


class SlotJoint(NamedTuple):
    """A clearance joint between a slot and a pin."""

    clearance: float  # m, on each side
    journal_radius: float  # m, of the pin
    side: float  # +1: the pin is on the distal body
    half_length: float  # m, between the middle and the centre of an end
    law: tuple  # contact_force
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force
    bearing_radius: float  # m, of a circle with the circumference of the wall: its angle indexes the wear of the wall
    wear: tuple  # wear_rate, or NoWear


@contact_modes.member(SlotJoint)
def _contact_modes_slot_joint(joint):
    return (ContactModes(FREE, PRESSED),)


@parts.member(SlotJoint)
def _parts_slot_joint(joint):
    return Part(Clip(), 0), Part(joint.law, 0), Part(joint.friction, 0)


class _Normal(NamedTuple):
    """Normal and motion of the pin relative to the nearest point of the slot's line."""

    x: float  # unit vector
    y: float
    depth: float  # m
    rate: float  # m/s
    slip: float  # m/s, of the pin's surface over the slot's, along the normal turned by +90 degrees


@inlined
def normal_of(joint, gap):
    """Return the normal of a pin in a slot, from its GuideGap."""
    overshoot = gap.x - min(max(gap.x, -joint.half_length), joint.half_length)
    eccentricity = math.sqrt(overshoot * overshoot + gap.y * gap.y)
    is_centred = eccentricity <= 0.0
    inverse = 1.0 / where(is_centred, 1.0, eccentricity)
    nx, ny = overshoot * inverse, where(is_centred, 1.0, gap.y * inverse)
    rate = gap.vx * nx + gap.vy * ny
    slip = gap.vy * nx - gap.vx * ny + joint.journal_radius * (gap.spin_distal - gap.spin_proximal)
    return _Normal(nx, ny, eccentricity - joint.clearance, rate, slip)


@kernel
def _contact_load(joint, gap, offsets, state):
    normal, contact_index = normal_of(joint, gap), offsets.contact
    mode = state.mode[contact_index]
    if mode == FREE:
        zero = as_type_of(0.0, normal.depth)
        speed = math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy)
        no_contact = Contact(zero, zero, speed, normal.rate, normal.depth, zero, zero)
        return zero, zero, zero, no_contact
    law = with_current_state(joint.law, state.y, state.latched, offsets)
    friction = with_current_state(joint.friction, state.y, state.latched, after_law(offsets, joint.law))
    root = state.y[state.roots + contact_index]
    current = SlotJoint(
        clearance=joint.clearance,
        journal_radius=joint.journal_radius,
        side=joint.side,
        half_length=joint.half_length,
        law=law,
        elastic=joint.elastic,
        friction=friction,
        bearing_radius=joint.bearing_radius,
        wear=joint.wear,
    )
    force, friction_load, elastic, unclipped = normal_forces(
        current, mode, root * abs(root), normal.rate, state.latched[contact_index]
    )
    tangential = as_type_of(friction_force(friction, friction_load, normal.slip), normal.slip)
    contact = Contact(force, tangential, normal.slip, normal.rate, normal.depth, elastic, unclipped)
    axial, transverse = -force * normal.x - tangential * normal.y, -force * normal.y + tangential * normal.x
    return axial, transverse, joint.journal_radius * tangential, contact


@inlined
def load_at_pin(gap, axial, transverse, pin_couple, contact):
    """Return the Load and Contact of a force (N) on the pin, in the frame of the slot, and a couple (N m)."""
    return Load(
        fx=gap.axis_x * axial - gap.axis_y * transverse,
        fy=gap.axis_y * axial + gap.axis_x * transverse,
        moment_proximal=-pin_couple - gap.x * transverse + gap.y * axial,
        moment_distal=pin_couple,
        contacts=(contact,),
    )


@load.member(SlotJoint)
def _load_slot_joint(joint, gap, offsets, state):
    return load_at_pin(gap, *_contact_load(joint, gap, offsets, state))


# ---------------------------------------------------------------------------------------------- wear


@record.member(SlotJoint)
def _record_slot_joint(joint, gap, body_angles, j, instant):
    if touches(instant.step.mode[j]):
        record_slot_contact(joint, gap, body_angles, j, instant)


@inlined
def record_slot_contact(joint, gap, body_angles, j, instant):
    """Record the position of touching contact `j` on wall and pin at an Instant."""
    step, i = instant.step, instant.number
    half_length, radius = joint.half_length, joint.journal_radius + joint.clearance
    nearest_x = min(max(gap.x, -half_length), half_length)
    overshoot = gap.x - nearest_x
    eccentricity = math.sqrt(overshoot * overshoot + gap.y * gap.y)
    nx, ny = overshoot / eccentricity, gap.y / eccentricity
    angle, tangential_rate = math.atan2(ny, nx), gap.vy * nx - gap.vx * ny
    wall_distance = radius * angle + (half_length - nearest_x if ny >= 0.0 else nearest_x - half_length)
    normal_spin = tangential_rate / eccentricity if abs(gap.x) > half_length else 0.0  # of the normal, from the slot
    wall_rate = radius * normal_spin if abs(gap.x) > half_length else tangential_rate
    _, distal = body_angles
    step.positions[j, 0, i] = wall_distance / joint.bearing_radius
    step.positions[j, 1, i] = angle + math.atan2(gap.axis_y, gap.axis_x) - distal
    step.positions[j, 2, i] = 0.0
    step.positions[j, SLOPES, i] = wall_rate / joint.bearing_radius
    step.positions[j, SLOPES + 1, i] = normal_spin + gap.spin_proximal - gap.spin_distal
    step.positions[j, SLOPES + 2, i] = 0.0


@local_clearance.member(SlotJoint)
def _local_clearance_slot_joint(joint, wall_angle, pin_angle):
    return unworn_local_clearance(joint, wall_angle)


@inlined
def is_on_flat_wall(joint, wall_angle):
    """Return whether the wall is flat at `wall_angle`, the arc length over the radius of the equivalent circle."""
    radius, full_turn = joint.journal_radius + joint.clearance, 2.0 * math.pi
    wall_distance = (wall_angle - full_turn * math.floor(wall_angle / full_turn)) * joint.bearing_radius
    quarter_arc, wall_length = 0.5 * math.pi * radius, 2.0 * joint.half_length
    half_circumference = math.pi * joint.bearing_radius
    distance_in_half = where(
        wall_distance > half_circumference, wall_distance - half_circumference, wall_distance
    )  # both halves are alike
    return (distance_in_half > quarter_arc) & (distance_in_half < quarter_arc + wall_length)


@inlined
def unworn_local_clearance(joint, wall_angle):
    """Return the difference (m) of the radii of curvature of new surfaces; wall_angle : as in `is_on_flat_wall`.

    On a flat wall the relevant radius is that of the pin: R_b R_j / c for c = R_b.
    """
    return where(is_on_flat_wall(joint, wall_angle), joint.journal_radius + joint.clearance, joint.clearance)


@arc_width.member(SlotJoint)
def _arc_width_slot_joint(joint, workspace):
    """Return an arc wide enough for the bins: the pin moves along the wall, so its wear is even within a bin."""
    return 2.0 * math.pi
