"""A pin with clearance in a straight slot: two parallel walls and two rounded ends, new or worn.

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

The worn shapes may act on the contact (`wear.evolve`).  The wear of the wall is h(s); the wear of the pin is h_j of its
angle.  Near the point of the wall that is closest to the pin's centre, the gap of the new surfaces increases by K t^2 /
2 with the distance t along the wall.  K is 1 / R_j on a flat wall and c / (R_b R_j) at an end.  So the pin touches the
worn wall at

    g(s) = min over t of  K t^2 / 2 + h(s + t) ,

s being the closest point; the pin does not reach into a groove narrower than itself.  The penetration is the
eccentricity minus c + g(s) + h_j.  By virtual work the normal force also acts along the wall, with the slopes of g and
h_j, so the energy stored by a law over the depth is a potential.  The pin's own wear shifts the contact point by the
fraction h_j'' / K of the distance, which is neglected.
"""

from typing import NamedTuple

import numpy as np

from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import direction, where
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import inlined, kernel
from ..laws.contract import FREE, touches
from ..laws.friction import static_limit
from ..wear import arc_width, local_clearance, shape
from ..wear.bins import SLOPES, record
from .contract import Load, grips_of, load, slip_rate, with_tangential
from .dry import SurfaceMotion, load_along_axis, no_load, pressed_contact_at, register_single_contact, separate_contact
from .worn import approximate_angle, with_angles


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


register_single_contact(SlotJoint)


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
    normal = normal_of(joint, gap)
    if state.mode[offsets.contact] == FREE:
        zero, speed = as_type_of(0.0, normal.depth), math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy)
        return zero, zero, zero, (separate_contact(normal.depth, normal.rate, speed),)
    contact = pressed_contact_at(joint, normal, offsets, state)
    axial = -contact.normal * normal.x - contact.tangential * normal.y
    transverse = -contact.normal * normal.y + contact.tangential * normal.x
    return axial, transverse, joint.journal_radius * contact.tangential, (contact,)


load.member(SlotJoint)(
    lambda joint, gap, offsets, state: load_along_axis(gap, *_contact_load(joint, gap, offsets, state))
)


# ---------------------------------------------------------------------------------------------- wear


def _record_slot(joint, gap, body_angles, j, instant):
    step, i = instant.step, instant.number
    if not touches(step.mode[j]):
        return
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


record.member(SlotJoint)(_record_slot)
local_clearance.member(SlotJoint)(lambda joint, wall_angle, pin_angle: unworn_local_clearance(joint, wall_angle))


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


def _wide_arc(joint, workspace, i):
    """Return an arc wide enough for the bins: the pin moves along the wall, so its wear is even within a bin."""
    return 2.0 * math.pi


arc_width.member(SlotJoint)(_wide_arc)


# ---------------------------------------------------------------------------------------------- a pin in a slot


class SlotGrip(NamedTuple):
    """The grip of a pin in a slot."""

    contacts: tuple
    force: float  # N
    limit: float  # N
    slip: float  # m/s
    journal_radius: float  # m
    nx: float  # normal, in the frame of the slot
    ny: float
    drift: float  # m/s^2, rate of the sliding speed as the normal turns
    gap: tuple  # GuideGap


@grips_of.member(SlotJoint)
def _grips_of_slot_joint(joint, gap, load, mode, first_contact):
    if type(joint.friction) not in static_limit.members:
        return ()
    contact, normal = load.contacts[0], normal_of(joint, gap)
    is_at_end = abs(gap.x) > joint.half_length
    axial, transverse = where(is_at_end, gap.vx, 0.0), gap.vy
    inverse_eccentricity = 1.0 / (contact.depth + joint.clearance)
    approach = normal.x * axial + normal.y * transverse
    normal_rate = (
        (axial - normal.x * approach) * inverse_eccentricity,
        (transverse - normal.y * approach) * inverse_eccentricity,
    )
    return (
        SlotGrip(
            contacts=(first_contact,),
            force=contact.tangential,
            limit=static_limit(joint.friction) * contact.normal,
            slip=contact.slip,
            journal_radius=joint.journal_radius,
            nx=normal.x,
            ny=normal.y,
            drift=gap.vy * normal_rate[0] - gap.vx * normal_rate[1],
            gap=gap,
        ),
    )


@slip_rate.member(SlotGrip)
def _slip_rate_slot_grip(grip, acceleration):
    relative_spin = grip.journal_radius * (acceleration.distal - acceleration.proximal)
    return grip.nx * acceleration.ay - grip.ny * acceleration.ax + relative_spin + grip.drift


@with_tangential.member(SlotGrip)
def _with_tangential_slot_grip(grip, load, force, stopping_force):
    contact, gap = load.contacts[0], grip.gap
    force_change = force - contact.tangential
    axial = -force_change * grip.ny
    transverse = force_change * grip.nx
    pin_moment = grip.journal_radius * force_change
    return Load(
        fx=load.fx + (gap.axis_x * axial - gap.axis_y * transverse),
        fy=load.fy + (gap.axis_y * axial + gap.axis_x * transverse),
        moment_proximal=load.moment_proximal + (gap.y * axial - gap.x * transverse - pin_moment),
        moment_distal=load.moment_distal + pin_moment,
        contacts=(contact._replace(tangential=force, stopping_force=plain(stopping_force)),),
    )


# ---------------------------------------------------------------------------------------------- worn surfaces


_FIELDS = [*SlotJoint.__annotations__.items(), ("bearing", shape.Shape), ("journal", shape.Shape)]
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


with_angles.member(WornSlot)(lambda joint, gap, angles: TurnedSlotGap(*gap[:8], angles[1]))


@inlined
def _angle_of(x, y):
    """Return the angle (rad) of a unit vector, with its derivatives."""
    guess = approximate_angle(plain(y), plain(x))
    c, s = direction(guess)
    sine = y * c - x * s
    return guess + sine * (1.0 + sine * sine * (1.0 / 6.0))


register_single_contact(WornSlot)


@load.member(WornSlot)
def _load_worn_slot(joint, gap, offsets, state):
    normal, half_length = normal_of(joint, gap), joint.half_length
    radius, nearest_x = joint.journal_radius + joint.clearance, min(max(gap.x, -half_length), half_length)
    angle = _angle_of(normal.x, normal.y)
    wall_distance = radius * angle + where(normal.y >= 0.0, half_length - nearest_x, nearest_x - half_length)
    is_at_end, inverse = abs(gap.x) > half_length, 1.0 / (normal.depth + joint.clearance)
    wall_wear, wall_slope, _, _ = shape.wear_depth_at(joint.bearing.table, wall_distance / joint.bearing_radius)
    pin_angle = angle + _angle_of(gap.axis_x, gap.axis_y) - gap.angle_distal
    pin_wear, pin_slope, _, _ = shape.wear_depth_at(joint.journal.table, pin_angle)
    # of the force along the wall, against the direction of s, over the normal force
    wall_force_ratio = wall_slope / joint.bearing_radius * where(is_at_end, radius * inverse, 1.0) + where(
        is_at_end, pin_slope * inverse, 0.0
    )
    tangential_rate = gap.vy * normal.x - gap.vx * normal.y
    rate = normal.rate - wall_force_ratio * tangential_rate - pin_slope * (gap.spin_proximal - gap.spin_distal)
    depth = normal.depth - (wall_wear + pin_wear)
    if state.mode[offsets.contact] == FREE:
        speed_factor = 1.0 + (joint.bearing.max_slope + joint.journal.max_slope) / joint.clearance
        speed = math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy) * speed_factor
        surface_speed = speed + joint.journal.max_slope * abs(gap.spin_proximal - gap.spin_distal)
        return no_load(separate_contact(depth, rate, as_type_of(surface_speed, depth)))
    contact = pressed_contact_at(joint, SurfaceMotion(depth, rate, normal.slip), offsets, state)
    force, tangential = contact.normal, contact.tangential
    tangential_load = tangential + force * wall_force_ratio  # along the normal turned by +90 degrees
    axial, transverse = -force * normal.x - tangential_load * normal.y, -force * normal.y + tangential_load * normal.x
    pin_couple = joint.journal_radius * tangential - force * pin_slope
    return load_along_axis(gap, axial, transverse, pin_couple, (contact,))


# ---------------------------------------------------------------------------------------------- wear


@local_clearance.member(WornSlot)
def _local_clearance_worn_slot(joint, wall_angle, pin_angle):
    """Return the local clearance (m): new surfaces' times (K + h'') / K, with K + h'' = K^2 / (K - g'')."""
    clearance = unworn_local_clearance(joint, wall_angle)
    _, _, curvature, _ = shape.wear_depth_at(joint.bearing.table, wall_angle)
    radii = (joint.journal_radius + joint.clearance) * joint.journal_radius
    difference = clearance - radii / (joint.bearing_radius * joint.bearing_radius) * curvature
    return clearance * clearance / max(difference, shape.POINT_MARGIN * clearance)


record.member(WornSlot)(_record_slot)
arc_width.member(WornSlot)(_wide_arc)


# ---------------------------------------------------------------------------------------------- worn shapes


def slot_shapes(joint: SlotJoint, bearing: np.ndarray, journal: np.ndarray) -> tuple[shape.Shape, shape.Shape, float]:
    """Return the shapes of slot (g) and pin from the mean depths of their bins (m), and the Gaussian's width (rad).

    The Gaussian smooths the wall enough for the pin to touch it at one point.
    """
    mean_radius, radii = joint.bearing_radius, (joint.journal_radius + joint.clearance) * joint.journal_radius
    positions, width = np.arange(shape.KNOTS) * shape.KNOT_SPACING, shape.SMOOTHING_WIDTH
    is_flat = np.array([is_on_flat_wall(joint, position) for position in positions])
    curvature = np.where(is_flat, 1.0 / joint.journal_radius, joint.clearance / radii) * mean_radius**2  # per rad^2
    while True:
        smooth_wear = shape.spline_through(shape.smooth_depths(bearing, width))
        if np.all(curvature + smooth_wear(positions, 2) >= shape.POINT_MARGIN * curvature):
            break
        width *= shape.WIDENING_FACTOR
    shift = np.zeros(shape.KNOTS)
    for _ in range(NEWTON_STEPS):
        shift -= (curvature * shift + smooth_wear(positions + shift, 1)) / (
            curvature + np.maximum(smooth_wear(positions + shift, 2), 0.0)
        )
    effective_wear = 0.5 * curvature * shift**2 + smooth_wear(positions + shift)
    (_, pin), pin_width = shape.point_profiles(np.zeros_like(journal), journal, joint.clearance)
    return shape.shape_of(effective_wear), shape.shape_of(pin), max(width, pin_width)
