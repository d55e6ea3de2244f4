"""A pin in a slot in which the worn shapes act on the contact (`wear.evolve`).

The wear of the wall is h(s) of the arc length s along it, see `slot`; the wear of the pin is h_j of its angle.  Near
the point of the wall that is closest to the pin's centre, the gap of the new surfaces increases by K t^2 / 2 with the
distance t along the wall.  K is 1 / R_j on a flat wall and c / (R_b R_j) at an end.  So the pin touches the worn wall
at

    g(s) = min over t of  K t^2 / 2 + h(s + t) ,

s being the closest point; the pin does not reach into a groove narrower than itself.  The penetration is the
eccentricity minus c + g(s) + h_j.  By virtual work the normal force also acts along the wall, with the slopes of g and
h_j, so the energy stored by a law over the depth is a potential.  The pin's own wear shifts the contact point by the
fraction h_j'' / K of the distance, which is neglected.
"""

from typing import NamedTuple

import numpy as np

from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import where
from ...tracing.compiled.direction import direction
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import inlined
from ..laws.contract import FREE, PRESSED, touches
from ..laws.friction import friction_force
from ..wear import arc_width, local_clearance
from ..wear.bins import record
from ..wear.shape import (
    KNOT_SPACING,
    KNOTS,
    POINT_MARGIN,
    SMOOTHING_WIDTH,
    WIDENING_FACTOR,
    Shape,
    point_profiles,
    shape_of,
    smooth_depths,
    spline_through,
    wear_depth_at,
)
from .contract import Contact, ContactModes, Load, Part, contact_modes, load, parts
from .dry import Clip, normal_forces
from .offsets import with_current_laws
from .slot import SlotJoint, is_on_flat_wall, load_at_pin, normal_of, record_slot_contact, unworn_local_clearance
from .worn.nearest import approximate_angle, with_angles

_FIELDS = [*SlotJoint.__annotations__.items(), ("bearing", Shape), ("journal", Shape)]
WornSlot = NamedTuple("WornSlot", _FIELDS)
WornSlot.__doc__ = "A pin in a slot with the worn shapes of both; the Shape of the slot is that of g."
NEWTON_STEPS = 50  # to the contact point of the pin; the function has one minimum, so the iteration converges


class TurnedSlotGap(NamedTuple):
    """A GuideGap, and the rotation of the body of the pin."""

    x: float  # m, of the pin from the middle of the slot, along it
    y: float  # m, across
    vx: float  # m/s, as seen from the slot
    vy: float
    spin_proximal: float  # rad/s
    spin_distal: float
    axis_x: float  # direction of the slot in the fixed frame
    axis_y: float
    angle_distal: float  # rad


class _WornContact(NamedTuple):
    """Contact of a pin in a worn slot."""

    normal: tuple  # of `normal_of`: of the new slot
    depth: float  # m
    rate: float  # m/s, of the depth
    wall_force_ratio: float  # 1, force along the wall divided by the normal force, against the direction of s
    couple_arm: float  # m, h_j': couple on the slot's body divided by the normal force


@with_angles.member(WornSlot)
def _with_angles_worn_slot(joint, gap, angles):
    return TurnedSlotGap(
        x=gap.x,
        y=gap.y,
        vx=gap.vx,
        vy=gap.vy,
        spin_proximal=gap.spin_proximal,
        spin_distal=gap.spin_distal,
        axis_x=gap.axis_x,
        axis_y=gap.axis_y,
        angle_distal=angles[1],
    )


@inlined
def _angle_of(x, y):
    """Return the angle (rad) of a unit vector, with its derivatives."""
    guess = approximate_angle(plain(y), plain(x))
    c, s = direction(guess)
    sine = y * c - x * s
    return guess + sine * (1.0 + sine * sine * (1.0 / 6.0))


@inlined
def _worn_contact(joint, gap):
    normal, half_length = normal_of(joint, gap), joint.half_length
    radius, nearest_x = joint.journal_radius + joint.clearance, min(max(gap.x, -half_length), half_length)
    angle = _angle_of(normal.x, normal.y)
    wall_distance = radius * angle + where(normal.y >= 0.0, half_length - nearest_x, nearest_x - half_length)
    is_at_end, inverse = abs(gap.x) > half_length, 1.0 / (normal.depth + joint.clearance)
    wall_wear, wall_slope, _, _ = wear_depth_at(joint.bearing.table, wall_distance / joint.bearing_radius)
    pin_angle = angle + _angle_of(gap.axis_x, gap.axis_y) - gap.angle_distal
    pin_wear, pin_slope, _, _ = wear_depth_at(joint.journal.table, pin_angle)
    wall_force_ratio = wall_slope / joint.bearing_radius * where(is_at_end, radius * inverse, 1.0) + where(
        is_at_end, pin_slope * inverse, 0.0
    )
    tangential_rate = gap.vy * normal.x - gap.vx * normal.y
    rate = normal.rate - wall_force_ratio * tangential_rate - pin_slope * (gap.spin_proximal - gap.spin_distal)
    return _WornContact(normal, normal.depth - (wall_wear + pin_wear), rate, wall_force_ratio, pin_slope)


@contact_modes.member(WornSlot)
def _contact_modes_worn_slot(joint):
    return (ContactModes(FREE, PRESSED),)


@parts.member(WornSlot)
def _parts_worn_slot(joint):
    return Part(Clip(), 0), Part(joint.law, 0), Part(joint.friction, 0)


@load.member(WornSlot)
def _load_worn_slot(joint, gap, offsets, state):
    pin_contact, mode = _worn_contact(joint, gap), state.mode[offsets.contact]
    if mode == FREE:
        zero = as_type_of(0.0, pin_contact.depth)
        speed_factor = 1.0 + (joint.bearing.max_slope + joint.journal.max_slope) / joint.clearance
        speed = math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy) * speed_factor
        surface_speed = speed + joint.journal.max_slope * abs(gap.spin_proximal - gap.spin_distal)
        no_contact = Contact(
            zero, zero, as_type_of(surface_speed, pin_contact.depth), pin_contact.rate, pin_contact.depth, zero, zero
        )
        return Load(fx=zero, fy=zero, moment_proximal=zero, moment_distal=zero, contacts=(no_contact,))
    root, normal = state.y[state.roots + offsets.contact], pin_contact.normal
    current = with_current_laws(joint, offsets, state)
    force, friction_load, elastic, unclipped = normal_forces(
        current, mode, root * abs(root), pin_contact.rate, state.latched[offsets.contact]
    )
    tangential = as_type_of(friction_force(current.friction, friction_load, normal.slip), normal.slip)
    contact = Contact(force, tangential, normal.slip, pin_contact.rate, pin_contact.depth, elastic, unclipped)
    tangential_load = tangential + force * pin_contact.wall_force_ratio  # along the normal turned by +90 degrees
    axial, transverse = -force * normal.x - tangential_load * normal.y, -force * normal.y + tangential_load * normal.x
    pin_couple = joint.journal_radius * tangential - force * pin_contact.couple_arm
    return load_at_pin(gap, axial, transverse, pin_couple, contact)


# ---------------------------------------------------------------------------------------------- wear


@record.member(WornSlot)
def _record_worn_slot(joint, gap, body_angles, j, instant):
    if touches(instant.step.mode[j]):
        record_slot_contact(joint, gap, body_angles, j, instant)


@local_clearance.member(WornSlot)
def _local_clearance_worn_slot(joint, wall_angle, pin_angle):
    """Return the local clearance (m): new surfaces' times (K + h'') / K, with K + h'' = K^2 / (K - g'')."""
    clearance = unworn_local_clearance(joint, wall_angle)
    _, _, curvature, _ = wear_depth_at(joint.bearing.table, wall_angle)
    radii = (joint.journal_radius + joint.clearance) * joint.journal_radius
    difference = clearance - radii / (joint.bearing_radius * joint.bearing_radius) * curvature
    return clearance * clearance / max(difference, POINT_MARGIN * clearance)


@arc_width.member(WornSlot)
def _arc_width_worn_slot(joint, workspace):
    return 2.0 * math.pi


# ---------------------------------------------------------------------------------------------- worn shapes


def slot_shapes(joint: SlotJoint, bearing: np.ndarray, journal: np.ndarray) -> tuple[Shape, Shape, float]:
    """Return the shapes of slot (g) and pin from the mean depths of their bins (m), and the Gaussian's width (rad).

    The Gaussian smooths the wall enough for the pin to touch it at one point.
    """
    mean_radius, radii = joint.bearing_radius, (joint.journal_radius + joint.clearance) * joint.journal_radius
    positions, width = np.arange(KNOTS) * KNOT_SPACING, SMOOTHING_WIDTH
    is_flat = np.array([is_on_flat_wall(joint, position) for position in positions])
    curvature = np.where(is_flat, 1.0 / joint.journal_radius, joint.clearance / radii) * mean_radius**2  # per rad^2
    while True:
        smooth_wear = spline_through(smooth_depths(bearing, width))
        if np.all(curvature + smooth_wear(positions, 2) >= POINT_MARGIN * curvature):
            break
        width *= WIDENING_FACTOR
    shift = np.zeros(KNOTS)
    for _ in range(NEWTON_STEPS):
        shift -= (curvature * shift + smooth_wear(positions + shift, 1)) / (
            curvature + np.maximum(smooth_wear(positions + shift, 2), 0.0)
        )
    effective_wear = 0.5 * curvature * shift**2 + smooth_wear(positions + shift)
    (_, pin), pin_width = point_profiles(np.zeros_like(journal), journal, joint.clearance)
    return shape_of(effective_wear), shape_of(pin), max(width, pin_width)
