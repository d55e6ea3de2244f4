"""Loads of walls with distributed stiffness: each slice of the length carries load by itself, see `strips`.

The joint stores the energy of its slices, an integral of the law's energy at their depth over the length.  Their
depth is that of the straight line between the exact depths of both ends, less the sag of the line of the distances
below its chord.  So the forces, the derivatives of this energy, are the ends' forces at their points, along their
normals, and those of the sag, which turn the normal along the length.

The distance of a circle of the journal from the axis of the bearing, at the position z on the pin, is that of the
vector p(z) = offset + z lean across the bearing, with the part along the lean shortened by the factor

    flattening = distance / (distance + radius lean^2),

as the circle is an ellipse in this view; the distance is the root mean square of those at both ends.  This is the
exact largest distance to first order in lean^2 radius / distance; the ends have the exact one.

Each half of the length is the strip of its end: it has the onset rate and is clipped with the contact of this end.
"""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.dual import as_type_of
from ...compiled.family import family, kernel
from ...compiled.vector import Vector, cross, dot, minus, plus, plus_scaled, times
from ..contract import Contact
from ..friction.contract import friction_force
from ..loss.contract import lowest_force
from ..modes import CLIPPED, touches
from .form import ContactForce, InBore, Overlapping, SpreadContact
from .points import Point, wall_point
from .strips import (
    Profile,
    SliceRates,
    Span,
    StripLoad,
    StripSums,
    depth_at,
    distance_at,
    energy_of,
    lifted_part,
    no_sums,
    root_at,
    with_span,
)


@kernel
def as_spread(contact, end_force):
    """Return a Contact, whose force acts at its point, as a SpreadContact with `end_force` (N)."""
    return SpreadContact(
        normal=contact.normal,
        tangential=contact.tangential,
        slip=contact.slip,
        rate=contact.rate,
        depth=contact.depth,
        elastic=contact.elastic,
        raw=contact.raw,
        stored_power=contact.elastic * contact.rate,
        lost_power=(contact.normal - contact.elastic) * contact.rate,
        end_force=end_force,
    )


# ---------------------------------------------------------------------------------------------- bearing length


class Overlap(NamedTuple):
    """The length on which journal and bore overlap, along the journal from its middle."""

    high: float  # m, position of its end of +z
    low: float  # m, of its end of -z
    high_slides: float  # 1 if it is the edge of the bore, which moves along the journal, else 0
    low_slides: float  # 1
    full_length: float  # m, of an overlap with the full stiffness
    circle_radius: float  # m, of the circles that are ellipses in the view along the other axis


@family
def bearing_length(end_type, joint, gap):
    """Return the Overlap of journal and bore."""


@bearing_length.member(InBore)
def _bearing_length_in_bore(end_type, joint, gap):
    zero = as_type_of(0.0, gap.middle.z)
    half_length = zero + joint.journal_half_length
    return Overlap(half_length, -half_length, zero, zero, 2.0 * joint.journal_half_length, joint.journal_radius)


@bearing_length.member(Overlapping)
def _bearing_length_overlapping(end_type, joint, gap):
    zero, half_length = as_type_of(0.0, gap.middle.z), joint.journal_half_length
    full_length = 2.0 * min(half_length, joint.half_length)
    high, low = zero + half_length, zero - half_length
    high_slides = low_slides = zero
    if joint.half_length - gap.middle.z < half_length:
        high, high_slides = joint.half_length - gap.middle.z, zero + 1.0
    if joint.half_length + gap.middle.z < half_length:
        low, low_slides = -joint.half_length - gap.middle.z, zero + 1.0
    if high - low < 1e-9 * full_length:  # the run ends when it is 0
        high = low + 1e-9 * full_length
    return Overlap(high, low, high_slides, low_slides, full_length, 0.0)  # the circles of bore and journal: one sags,
    # the other bulges


# ---------------------------------------------------------------------------------------------- one end


class EndState(NamedTuple):
    """One end of the walls."""

    point: Point
    mode: int
    root: float  # m^0.5, of the penetration; 0 if it does not touch
    onset_rate: float  # m/s
    velocity: Vector  # m/s, of the journal at the point, seen from the bearing
    rate: float  # m/s, of the depth


@kernel
def end_state_of(context, contact_number, end):
    """Return the EndState at one of the ENDS, contact `number` of the joint of a context."""
    joint, gap, relative_motion, state = context.joint, context.gap, context.relative_motion, context.state
    contact_index = context.offsets.contact + contact_number
    point = wall_point(joint.end_type, joint, gap, end)
    velocity = plus(relative_motion.velocity, cross(relative_motion.spin, minus(point.position, gap.middle)))
    rate, mode = dot(velocity, point.normal), state.mode[contact_index]
    root = state.y[state.roots + contact_index]
    if not touches(mode):
        root = as_type_of(0.0, root)
    return EndState(point, mode, root, state.latched[contact_index], velocity, rate)


@kernel
def _unloaded_contact(end_state, end_force):
    """Return the ContactForce of an unloaded end; end_force : N, from the other end's strip."""
    zero = as_type_of(0.0, end_state.rate)
    no_force, slip = Vector(zero, zero, zero), math.sqrt(dot(end_state.velocity, end_state.velocity))
    contact = Contact(
        normal=zero,
        tangential=zero,
        slip=slip,
        rate=end_state.rate,
        depth=end_state.point.depth,
        elastic=zero,
        raw=zero,
    )
    return ContactForce(no_force, no_force, no_force, no_force, as_spread(contact, end_force))


# ---------------------------------------------------------------------------------------------- geometry


class _Line(NamedTuple):
    """The axis of the journal, seen along that of the bearing, with the factor of the circles' ellipses."""

    offset: Vector  # m, across the bearing at the journal's middle
    lean: Vector  # 1, its increase per length
    arm_offset: float  # m, at the journal's middle: position at which the lever of a slice acts, along the pin
    flattening: float  # 1, increase of that position per length


@kernel
def _line_of(joint, gap, overlap):
    """Return the _Line of a gap."""
    middle, axis, zero = gap.middle, gap.axis, as_type_of(0.0, gap.middle.z)
    lean = Vector(-axis.z * axis.x, -axis.z * axis.y, axis.x * axis.x + axis.y * axis.y)
    offset = plus_scaled(middle, -dot(middle, axis), axis)
    square = lean.z  # of the lean
    distance = math.sqrt(dot(offset, offset) + square * overlap.high * overlap.high)
    distance = max(distance, 0.5 * joint.clearance)
    shortening = overlap.circle_radius / (distance + overlap.circle_radius * square)
    arm_offset, flattening = -shortening * dot(offset, lean), zero + (1.0 - shortening * square)
    return _Line(plus_scaled(offset, arm_offset, lean), times(flattening, lean), arm_offset, flattening)


@kernel
def _direction_at(line, z, distance):
    """Return the gradient of the distance of the axes with the offset, at the position z (m)."""
    return times(1.0 / distance, plus_scaled(line.offset, z, line.lean))


class _End(NamedTuple):
    """An end of the overlap: how the exact depth there moves relative to the distance of the axes."""

    z: float  # m, position
    distance: float  # m, of the axes
    force_factor: Vector  # 1, force per force of the end, in addition to that of the distance
    moment_factor: Vector  # m, moment likewise, about the journal's middle
    rate: float  # m/s, of the exact depth less the distance


@kernel
def _end_of(context, profile, line, rates, end_state, z, slides):
    """Return the _End of an EndState; slides : 1 if it moves along the journal as the bore does, else 0."""
    gap, distance = context.gap, distance_at(profile, z)
    middle = gap.middle
    direction = _direction_at(line, z, distance)
    along = slides * (profile.product + profile.tilt_square * z) / distance
    normal, arm = end_state.point.normal, minus(end_state.point.position, middle)
    lever = line.arm_offset + line.flattening * z
    force_factor = minus(normal, direction)
    moment = cross(arm, normal)
    moment_factor = Vector(
        moment.x + lever * direction.y - along * middle.y, moment.y - lever * direction.x + along * middle.x, moment.z
    )
    rate = end_state.rate - (rates.first + z * (rates.second + rates.third * z)) / distance
    return _End(
        z, distance, Vector(force_factor.x, force_factor.y, force_factor.z + along), moment_factor, rate
    )


class _Geometry(NamedTuple):
    """The walls in a pose."""

    overlap: Overlap
    line: _Line
    profile: Profile
    middle: float  # m, position of the middle of the overlap
    half_length: float  # m, half of the overlap
    first: _End  # of +z
    second: _End
    rates: SliceRates
    along: float  # m/s, velocity of the journal along its axis, seen from the bearing
    shift: float  # 1, velocity of a slice at the journal's middle along the pin, per `along`
    stretch: float  # 1/m, its increase per length


@kernel
def _geometry_of(context, first_end, second_end):
    """Return the _Geometry of the EndStates of both walls."""
    joint, gap, motion = context.joint, context.gap, context.relative_motion
    overlap = bearing_length(joint.end_type, joint, gap)
    line = _line_of(joint, gap, overlap)
    zero = as_type_of(0.0, gap.middle.z)
    # the square of the flattened vector, along the pin
    offset, lean = plus_scaled(gap.middle, -dot(gap.middle, gap.axis), gap.axis), line.lean
    square, product = dot(offset, line.offset), dot(offset, lean)
    tilt_square = line.flattening * (gap.axis.x * gap.axis.x + gap.axis.y * gap.axis.y)
    profile = Profile(square, product, tilt_square, zero + joint.clearance, zero)

    turning = Vector(motion.spin.y, -motion.spin.x, zero)  # rate of the journal's axis, seen from the bearing
    along = motion.velocity.z + motion.spin.y * gap.middle.x - motion.spin.x * gap.middle.y
    half_length, middle = 0.5 * (overlap.high - overlap.low), 0.5 * (overlap.high + overlap.low)
    stretch = (overlap.low_slides - overlap.high_slides) / (overlap.high - overlap.low)
    shift = -overlap.high_slides - stretch * overlap.high
    rates = SliceRates(
        zero,
        zero,
        dot(line.offset, motion.velocity) + line.arm_offset * dot(line.offset, turning) + product * shift * along,
        dot(lean, motion.velocity)
        + line.flattening * dot(line.offset, turning)
        + line.arm_offset * dot(lean, turning)
        + (product * stretch + tilt_square * shift) * along,
        line.flattening * dot(lean, turning) + tilt_square * stretch * along,
    )
    first = _end_of(context, profile, line, rates, first_end, overlap.high, overlap.high_slides)
    second = _end_of(context, profile, line, rates, second_end, overlap.low, overlap.low_slides)
    inverse = 1.0 / (first.z - second.z)
    first_excess = _depth_at_end(first_end) - first.distance
    slope = (first_excess - (_depth_at_end(second_end) - second.distance)) * inverse
    profile = Profile(square, product, tilt_square, first_excess - slope * first.z, slope)
    rate_slope = (first.rate - second.rate) * inverse
    rates = SliceRates(first.rate - rate_slope * first.z, rate_slope, rates.first, rates.second, rates.third)
    return _Geometry(overlap, line, profile, middle, half_length, first, second, rates, along, shift, stretch)


@kernel
def _depth_at_end(end_state):
    """Return the depth (m) at an end that the slices see: that of the root if it touches, else at most 0."""
    if touches(end_state.mode):
        return end_state.root * end_state.root
    return min(end_state.point.depth, 0.0)


# ---------------------------------------------------------------------------------------------- load


class _Spans(NamedTuple):
    """The pressed spans of a strip."""

    outer: Span  # from its end inwards
    inner: Span  # another one, if the journal is lifted in between; it reaches the middle of the overlap


@kernel
def _spans_of(geometry, lifted, middle_root, end_state, end_z):
    """Return the _Spans of the strip from `end_z` (m); middle_root : m^0.5, of the depth in the middle."""
    middle, profile = geometry.middle, geometry.profile
    low, high, near, far = middle, end_z, lifted.end, lifted.begin
    if end_z < middle:
        low, high, near, far = end_z, middle, lifted.begin, lifted.end
    near, far = min(max(near, low), high), min(max(far, low), high)
    boundary_root = as_type_of(0.0, middle_root)
    if not lifted.is_lifted and low < near < high:
        boundary_root = math.copysign(root_at(profile, near), middle_root)
    outer = Span(end_z, near, end_state.root, middle_root if near == middle else boundary_root)
    inner = Span(far, middle, end_state.root if far == end_z else boundary_root, middle_root)
    return _Spans(outer, inner)


@kernel
def _middle_root(geometry, lifted, first_end, second_end):
    """Return the root (m^0.5) of the depth in the middle, negative if both ends are apart or past their separation."""
    root = as_type_of(0.0, geometry.middle)
    if not (lifted.is_lifted and lifted.begin <= geometry.middle <= lifted.end):
        root = root_at(geometry.profile, geometry.middle)
    is_first_past = first_end.root < 0.0 or not touches(first_end.mode)
    if is_first_past and (second_end.root < 0.0 or not touches(second_end.mode)):
        root = -root
    return root


class StripForce(NamedTuple):
    """Load of a strip."""

    is_pressed: bool
    total: StripSums  # clipped
    elastic: StripSums  # clipped or not
    raw: float  # N, force before clipping, minus the least force of its law
    energy: float  # J, if the overlap varies
    energy_force: float  # J, the same, clipped like the force


@kernel
def _clipped(sums, is_clipped, least_distance):
    """Return StripSums, continuously clipped to those of forces that do not pull."""
    force = max(sums.force, 0.0) if not is_clipped else as_type_of(0.0, sums.force)
    over_distance = force / least_distance
    return StripSums(
        force,
        min(max(sums.outward, 0.0), force),
        min(max(sums.over_distance, 0.0), over_distance),
        min(max(sums.outward_over_distance, 0.0), over_distance),
        min(max(sums.square_over_distance, 0.0), over_distance),
    )


@kernel
def _strip_force(context, geometry, spans, end_state, other_end, end):
    """Return the StripForce of the strip of an EndState at an _End.

    The law uses the onset rate of this end if it touches, else that of the other end.
    """
    joint, zero = context.joint, as_type_of(0.0, geometry.middle)
    outer, inner = spans
    if outer.start == outer.stop and inner.start == inner.stop:
        return StripForce(False, no_sums(zero), no_sums(zero), zero, zero, zero)
    onset_rate = end_state.onset_rate if touches(end_state.mode) else other_end.onset_rate
    per_length = 1.0 / geometry.overlap.full_length
    strip, laws = (geometry.middle, 1.0 / (end.z - geometry.middle), per_length), (joint.law, joint.elastic)
    load = StripLoad(no_sums(zero), no_sums(zero), end.distance)
    for span in spans:
        load = with_span(load, geometry.profile, span, laws, joint.walls.rule, geometry.rates, onset_rate, strip)
    lowest = lowest_force(joint.law)
    unclipped, total, energy, energy_force = load.total.force - lowest, load.total, zero, zero
    if lowest == 0.0:  # without a jump where clipping begins or ends; otherwise these events would alternate endlessly
        total = _clipped(total, end_state.mode == CLIPPED, load.least_distance)
    if geometry.stretch != 0.0 and load.elastic.force > 0.0:
        for span in spans:
            energy = energy + per_length * energy_of(geometry.profile, span, joint.elastic, joint.walls.rule)
        energy_force = energy * (total.force / load.elastic.force)
    return StripForce(True, total, load.elastic, unclipped, energy, energy_force)


class _LineSums(NamedTuple):
    """StripSums over positions z along the journal."""

    first: float  # N, the part of the force at the end of +z, of two end forces with the sum and moment
    second: float  # N, at the other end
    over_distance: float  # N/m
    z_over_distance: float  # N
    square_over_distance: float  # N m


@kernel
def _line_sums(geometry, sums, end):
    """Return the _LineSums of the StripSums of an _End."""
    reach, middle = end.z - geometry.middle, geometry.middle
    outward = math.copysign(0.5, reach) * sums.outward
    return _LineSums(
        0.5 * sums.force + outward,
        0.5 * sums.force - outward,
        sums.over_distance,
        middle * sums.over_distance + reach * sums.outward_over_distance,
        middle * middle * sums.over_distance
        + reach * (2.0 * middle * sums.outward_over_distance + reach * sums.square_over_distance),
    )


@kernel
def _axial_force(geometry, sums, energy):
    """Return the force (N) on the journal along its axis, of _LineSums, as its ends slide; energy : J, of the strip."""
    profile, shift, stretch = geometry.profile, geometry.shift, geometry.stretch
    return -(
        energy * stretch
        + profile.product * shift * sums.over_distance
        + (profile.product * stretch + profile.tilt_square * shift) * sums.z_over_distance
        + profile.tilt_square * stretch * sums.square_over_distance
    )


@kernel
def _strip_resultant(context, geometry, sums, energy):
    """Return the normal force (N) of _LineSums on the journal, and its moment (N m) about the journal's middle."""
    line, first, second, middle = geometry.line, geometry.first, geometry.second, context.gap.middle
    pressing = plus(times(sums.over_distance, line.offset), times(sums.z_over_distance, line.lean))
    turning = plus(times(sums.z_over_distance, line.offset), times(sums.square_over_distance, line.lean))
    turning = plus_scaled(times(line.flattening, turning), line.arm_offset, pressing)
    axial_force = _axial_force(geometry, sums, energy)
    force = plus_scaled(
        plus_scaled(pressing, sums.first, first.force_factor), sums.second, second.force_factor
    )
    moment = plus(times(sums.first, first.moment_factor), times(sums.second, second.moment_factor))
    return (
        Vector(-force.x, -force.y, axial_force - force.z),
        Vector(
            turning.y - moment.x - axial_force * middle.y, -turning.x - moment.y + axial_force * middle.x, -moment.z
        ),
    )


@kernel
def _power_of(geometry, sums, energy):
    """Return the power (W) of _LineSums in the rates of depth of their slices."""
    rates, first, second = geometry.rates, geometry.first, geometry.second
    slices = rates.first * sums.over_distance + rates.second * sums.z_over_distance
    slices = slices + rates.third * sums.square_over_distance + energy * geometry.stretch * geometry.along
    return sums.first * first.rate + sums.second * second.rate + slices


# ---------------------------------------------------------------------------------------------- friction


class _StripFriction(NamedTuple):
    """The friction of a strip."""

    force: Vector  # N, on the journal
    arm: Vector  # m, its point of action, from the journal's centre
    twist: Vector  # N m, see ContactForce
    tangential: float  # N
    slip: float  # m/s


@kernel
def _strip_friction(context, geometry, load, end_state, end):
    """Return the friction of a strip with a StripForce, at the centre of its elastic load, across the normal there."""
    joint, gap, relative_motion = context.joint, context.gap, context.relative_motion
    friction_load = load.total.force if lowest_force(joint.law) == 0.0 else max(load.total.force, 0.0)
    weight = load.elastic.force if load.elastic.force > 0.0 else as_type_of(1.0, load.elastic.force)
    fraction = min(max(load.elastic.outward / weight, 0.0), 1.0)
    z = geometry.middle + fraction * (end.z - geometry.middle)
    first, second, profile = geometry.first, geometry.second, geometry.profile
    share = (z - second.z) / (first.z - second.z)
    direction = _direction_at(geometry.line, z, distance_at(profile, z))
    direction = plus_scaled(
        plus_scaled(direction, share, first.force_factor), 1.0 - share, second.force_factor
    )
    normal = times(1.0 / math.sqrt(dot(direction, direction)), direction)
    radial = joint.journal_radius / math.sqrt(normal.x * normal.x + normal.y * normal.y)
    arm, depth = Vector(radial * normal.x, radial * normal.y, z), depth_at(profile, z)
    velocity = plus_scaled(
        plus(relative_motion.velocity, cross(relative_motion.spin, arm)), depth, cross(gap.bearing_spin, normal)
    )
    sliding = plus_scaled(velocity, -dot(velocity, normal), normal)
    square, circumferential = dot(sliding, sliding), normal.x * sliding.y - normal.y * sliding.x
    slip = math.copysign(math.sqrt(square), circumferential) if square > 0.0 else as_type_of(0.0, square)
    tangential = as_type_of(friction_force(joint.friction, friction_load, slip), slip)
    force = times(tangential / slip if square > 0.0 else as_type_of(0.0, slip), sliding)
    twist = times(depth, cross(normal, force))
    if touches(end_state.mode):
        return _StripFriction(force, arm, twist, tangential, slip)
    speed = math.sqrt(dot(end_state.velocity, end_state.velocity))  # of a separate end: it bounds the time to the onset
    tangential = tangential * slip / speed if speed > 0.0 else as_type_of(0.0, speed)
    return _StripFriction(force, arm, twist, tangential, speed)


# ---------------------------------------------------------------------------------------------- both walls


@kernel
def _strip_contact_force(context, geometry, load, end_state, end, end_force):
    """Return the ContactForce of an EndState with the StripForce `load`; end_force : N, as in a SpreadContact."""
    if not load.is_pressed:
        return _unloaded_contact(end_state, end_force)
    sums, elastic_sums = _line_sums(geometry, load.total, end), _line_sums(geometry, load.elastic, end)
    stored = _power_of(geometry, elastic_sums, load.energy)
    normal_force, moment = _strip_resultant(context, geometry, sums, load.energy_force)
    friction = _strip_friction(context, geometry, load, end_state, end)
    contact = SpreadContact(
        normal=load.total.force,
        tangential=friction.tangential,
        slip=friction.slip,
        rate=end_state.rate,
        depth=end_state.point.depth,
        elastic=load.elastic.force,
        raw=load.raw,
        stored_power=stored,
        lost_power=_power_of(geometry, sums, load.energy_force) - stored,
        end_force=end_force,
    )
    moment = plus(moment, cross(friction.arm, friction.force))
    return ContactForce(normal_force, plus(normal_force, friction.force), moment, friction.twist, contact)


@kernel
def spread_walls(context):
    """Return the ContactForces of both walls."""
    first_end, second_end = end_state_of(context, 0, 1.0), end_state_of(context, 1, -1.0)
    if not (touches(first_end.mode) or touches(second_end.mode)):
        zero = as_type_of(0.0, first_end.rate)
        return _unloaded_contact(first_end, zero), _unloaded_contact(second_end, zero)
    geometry = _geometry_of(context, first_end, second_end)
    first, second = geometry.first, geometry.second
    lifted = lifted_part(geometry.profile, 2.0 * max(abs(first.z), abs(second.z)))
    middle_root = _middle_root(geometry, lifted, first_end, second_end)
    spans = _spans_of(geometry, lifted, middle_root, first_end, first.z)
    load = _strip_force(context, geometry, spans, first_end, second_end, first)
    other_spans = _spans_of(geometry, lifted, middle_root, second_end, second.z)
    other_load = _strip_force(context, geometry, other_spans, second_end, first_end, second)
    inner, other_inner = 0.5 * load.total.outward, 0.5 * other_load.total.outward
    end_force = 0.5 * load.total.force + inner + 0.5 * other_load.total.force - other_inner
    other_end_force = 0.5 * load.total.force - inner + 0.5 * other_load.total.force + other_inner
    return _strip_contact_force(context, geometry, load, first_end, first, end_force), _strip_contact_force(
        context, geometry, other_load, second_end, second, other_end_force
    )
