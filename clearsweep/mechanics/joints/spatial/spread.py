"""Loads of walls with distributed stiffness: each slice of the length carries load by itself, see `strips`.

The joint stores the energy of its slices, an integral of the law's energy at their depth over the length.  With z from
-1 to 1 over the length, the shares s1 = (1 + z) / 2 and s2 = (1 - z) / 2 of both ends, and their distances from the
other axis, the clearance plus the depth there,

    distance(z)^2 = s1 distance1^2 + s2 distance2^2 - s1 s2 spread^2,

as the vector of the distance is linear along the pin.  `spread` is the length of its change between the ends: the
overlap times the sine of the tilt.  In the view along the bearing the circles of the journal are ellipses, which makes
it shorter across the load, by about radius tilt^2 / distance: with the slopes n1 and n2 of the normals of both ends,

    spread^2 = overlap (distance1 n1 - distance2 n2).

This is the exact distance of the circles' farthest points to first order in radius tilt^2 / distance.  The forces are
the derivatives of this energy: those of both ends act at their points, along their normals, as at `EndContacts`, and a
couple is conjugate to the spread.  Together they turn the normal along the length.

Each half of the length is the strip of its end: it has the onset rate and is clipped with the contact of this end.
"""

from typing import NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import where
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import family, inlined, kernel
from ....tracing.compiled.vector import Vector, cross, dot, minus, norm, plus, plus_scaled, times
from ...laws.contract import CLIPPED, touches
from ...laws.friction import friction_force
from ...laws.loss import lowest_force
from ..dry import separate_contact
from . import ContactForce, InBore, Overlapping, Point, SpreadContact, overlap_of, strips

#: Of the squared tilt times the length over the sum of the distances: below, normals do not resolve the ellipse.
SMALLEST_TILT_SQUARE = 1e-9
#: It is at most 1, and 1 where the tilt is in the plane of the load: a bound of 1 would be a kink there.
LARGEST_FLATTENING = 1.5


@kernel
def as_spread(contact, end_force):
    """Return a Contact, whose force acts at its point, as a SpreadContact with `end_force` (N)."""
    stored_power, lost_power = contact.elastic * contact.rate, (contact.normal - contact.elastic) * contact.rate
    return SpreadContact(*contact[:7], stored_power, lost_power, end_force)


# ---------------------------------------------------------------------------------------------- bearing length


class Overlap(NamedTuple):
    """The length on which journal and bore overlap."""

    half_length: float  # m, half of it
    stiffness_fraction: float  # 1, fraction of the full stiffness that acts on this overlap
    growth: float  # 1, rate of the length per velocity (m/s) of the journal along its axis, seen from the bearing
    middle: float  # m, position of its middle along the journal, from the journal's middle


@family
def bearing_length(end_type, joint, gap):
    """Return the Overlap of journal and bore."""


@bearing_length.member(InBore)
def _bearing_length_in_bore(end_type, joint, gap):
    zero = as_type_of(0.0, gap.middle.z)
    return Overlap(zero + joint.journal_half_length, zero + 1.0, zero, zero)


@bearing_length.member(Overlapping)
def _bearing_length_overlapping(end_type, joint, gap):
    full_length, length = 2.0 * min(joint.journal_half_length, joint.half_length), overlap_of(joint, gap)
    zero, shift = as_type_of(0.0, length), gap.middle.z
    high = min(zero + joint.journal_half_length, joint.half_length - shift)
    low = max(zero - joint.journal_half_length, -joint.half_length - shift)
    middle = 0.5 * (high + low)
    if length >= full_length:
        return Overlap(zero + 0.5 * full_length, zero + 1.0, zero, middle)
    length = max(length, 1e-9 * full_length)  # the run ends when it is 0
    return Overlap(0.5 * length, length / full_length, zero - math.copysign(1.0, shift), middle)


# ---------------------------------------------------------------------------------------------- one end


class EndState(NamedTuple):
    """One end of the walls."""

    point: Point
    mode: int
    root: float  # m^0.5, of the penetration; 0 if it does not touch
    onset_rate: float  # m/s
    velocity: Vector  # m/s, of the journal at the point, seen from the bearing
    rate: float  # m/s, of the depth


@inlined
def end_state_of(context, contact_number):
    """Return the EndState of a wall, contact `number` of the joint of a context."""
    gap, relative_motion, state = context.gap, context.relative_motion, context.state
    contact_index = context.offsets.contact + contact_number
    point = context.points[contact_number]
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
    no_force = Vector(zero, zero, zero)
    contact = separate_contact(end_state.point.depth, end_state.rate, norm(end_state.velocity))
    return ContactForce(no_force, no_force, no_force, no_force, as_spread(contact, end_force))


# ---------------------------------------------------------------------------------------------- geometry


class _Geometry(NamedTuple):
    """The walls in a pose; positions z along the length are from -1 to 1."""

    overlap: Overlap
    profile: strips.Profile
    first_distance: float  # m, clearance plus depth at the end of +z
    second_distance: float  # m, at the other end
    rates: strips.SliceRates
    spread_rate: float  # m^2/s, rate of the squared spread
    spin_factor: Vector  # m^2, rate of the squared spread per angular velocity (rad/s) of the journal
    axial_factor: float  # m, per velocity (m/s) of the journal along its axis
    length_rate: float  # 1/s, relative rate of the overlap's length


@family
def _flattening(end_type, ends, tilt_length):
    """Return the squared spread over its value for circles that stay circles in the view along the other axis.

    ends : of both, the distance (m) and the slope along the pin of the normal; tilt_length : m, length of the overlap
    times the squared sine of the tilt.
    """


@_flattening.member(InBore)
def _flattening_in_bore(end_type, ends, tilt_length):
    (first, first_slope), (second, second_slope) = ends
    if tilt_length <= SMALLEST_TILT_SQUARE * (abs(first) + abs(second)):
        return as_type_of(1.0, tilt_length)
    return min(max((first * first_slope - second * second_slope) / tilt_length, 0.5), LARGEST_FLATTENING)


_flattening.member(Overlapping)(lambda end_type, ends, tilt_length: as_type_of(1.0, tilt_length))


@inlined
def _geometry_of(context, first_end, second_end):
    """Return the _Geometry of the EndStates of both walls."""
    joint, gap, motion = context.joint, context.gap, context.relative_motion
    overlap = bearing_length(joint.end_type, joint, gap)
    axis, clearance = gap.axis, joint.clearance
    first_depth, second_depth = _depth_at_end(first_end), _depth_at_end(second_end)
    first_distance, second_distance = clearance + first_depth, clearance + second_depth
    sine_square, length = axis.x * axis.x + axis.y * axis.y, 2.0 * overlap.half_length
    ends = (first_distance, first_end.point.normal.z), (second_distance, second_end.point.normal.z)
    flattening = _flattening(joint.end_type, ends, length * sine_square)
    length_square = length * length * flattening
    spread_square = length_square * sine_square
    spin_factor = 2.0 * length_square * flattening * axis.z
    spin_factor = Vector(spin_factor * axis.y, -spin_factor * axis.x, as_type_of(0.0, axis.z))
    axial_velocity = motion.velocity.z + motion.spin.y * gap.middle.x - motion.spin.x * gap.middle.y
    axial_factor = 4.0 * overlap.half_length * overlap.growth * flattening * sine_square
    spread_rate = dot(motion.spin, spin_factor) + axial_factor * axial_velocity

    first_square = first_depth * (clearance + first_distance)  # past the squared clearance
    second_square = second_depth * (clearance + second_distance)
    constant, product = 0.5 * (first_square + second_square), 0.25 * (first_square - second_square)
    profile = strips.Profile(clearance, constant - 0.25 * spread_square, product, 0.25 * spread_square)
    first_rate, second_rate = 0.5 * first_distance * first_end.rate, 0.5 * second_distance * second_end.rate
    curvature = 0.125 * spread_rate
    rates = strips.SliceRates(first_rate + second_rate - curvature, first_rate - second_rate, curvature)
    length_rate = as_type_of(0.0, axial_velocity)
    if overlap.growth != 0.0:
        length_rate = 0.5 * overlap.growth * axial_velocity / overlap.half_length
    return _Geometry(
        overlap, profile, first_distance, second_distance, rates, spread_rate, spin_factor, axial_factor, length_rate
    )


@inlined
def _depth_at_end(end_state):
    """Return the depth (m) at an end that slices see: that of the root if it touches; apart, above 0 past its onset."""
    return end_state.root * end_state.root if touches(end_state.mode) else end_state.point.depth


# ---------------------------------------------------------------------------------------------- load


class _Division(NamedTuple):
    """Where the spans of both strips end."""

    lifted: strips.Lifted
    root: float  # m^0.5, of the depth where spans are divided, 0 if the journal is lifted
    distance: float  # m, of the axes there
    middle_root: float  # m^0.5, of the depth in the middle, negative if both ends are apart or past their separation
    middle_distance: float  # m, of the axes there


@inlined
def _division_of(geometry, first_end, second_end):
    """Return the _Division of a _Geometry."""
    profile, zero = geometry.profile, as_type_of(0.0, geometry.first_distance)
    lifted, distance = strips.lifted_part(profile, 2.0, 1.0), zero + profile.clearance
    middle_distance, middle_root, root = distance, zero, zero
    if profile.constant > 0.0:
        middle_distance = strips.distance_at(profile, zero)
        middle_root = math.sqrt(profile.constant / (profile.clearance + middle_distance))
    is_first_past = first_end.root < 0.0 or not touches(first_end.mode)
    if is_first_past and (second_end.root < 0.0 or not touches(second_end.mode)):
        middle_root = -middle_root
    if not lifted.is_lifted and lifted.begin != 0.0:
        distance = strips.distance_at(profile, lifted.begin)
        root = math.copysign(math.sqrt(max(distance - profile.clearance, 0.0)), middle_root)
    return _Division(lifted, root, distance, middle_root, middle_distance)


class _Spans(NamedTuple):
    """The pressed spans of a strip."""

    first: strips.Span  # from its end inwards, or if it is apart there the one that reaches the middle
    second: strips.Span  # another one that reaches the middle, if the spans are divided in between; it is rare


@inlined
def _spans_of(division, end, end_state, end_distance):
    """Return the _Spans of the strip of an EndState at one of the ENDS; end_distance : m, of the axes there.

    A trial step past the onset of an end continues: the span that reaches the middle grows beyond the end.
    """
    lifted, zero = division.lifted, as_type_of(0.0, division.root)
    near, far = (lifted.end, lifted.begin) if end > 0.0 else (-lifted.begin, -lifted.end)
    near, far = min(max(near, 0.0), 1.0), max(far, 0.0)
    near_root = far_root = division.root
    near_distance = far_distance = division.distance
    end_root, depth = end_state.root, end_state.point.depth
    if not touches(end_state.mode):
        end_root = math.sqrt(depth) if depth > 0.0 else zero
        near = zero + 1.0 if lifted.is_lifted else near
    elif far >= 1.0:
        far, far_root, far_distance = zero + 1.0, end_root, end_distance
    if near == 0.0:
        near_root, near_distance = division.middle_root, division.middle_distance
    outer = strips.Span(zero + end, end * near, end_root, near_root, end_distance, near_distance)
    inner = strips.Span(end * far, zero, far_root, division.middle_root, far_distance, division.middle_distance)
    if near < 1.0:
        return _Spans(outer, inner)
    return _Spans(inner, strips.Span(zero, zero, zero, zero, zero, zero))


class StripForce(NamedTuple):
    """Load of a strip."""

    is_pressed: bool
    total: strips.StripSums  # clipped
    elastic: float  # N, elastic part of the force, clipped or not
    elastic_outward: float  # N, see StripLoad
    stored_power: float  # W
    raw: float  # N, force before clipping, minus the least force of its law
    energy: float  # J, if the overlap varies, clipped like the force


@inlined
def _excess(total, force):
    """Return the part of a sum beyond what slices that do not pull can have with this sum of forces."""
    return where(total > max(force, 0.0), total - force, min(total, 0.0))


@inlined
def _limited(total, excess, force):
    """Return a sum whose excess is limited to the size of the force, smoothly up to the fourth derivative."""
    force_square, excess_square = force * force, excess * excess
    root = math.sqrt(math.sqrt(force_square * force_square + excess_square * excess_square))
    return total - excess + force * (excess / root) if root > 0.0 else total


@inlined
def _clipped(sums, end_state, clearance):
    """Return StripSums without pull, continuously clipped; distances exceed the clearance.

    Before the event of clipping nothing has a kink: a trial step past it continues with a negative force.
    """
    force = sums.force
    if end_state.mode == CLIPPED:
        force = as_type_of(0.0, force)
    elif not touches(end_state.mode):
        force = max(force, 0.0)
    over_distance = force * (1.0 / clearance)
    totals = sums.outward, sums.over_distance, sums.outward_over_distance, sums.square_over_distance
    bounds = force, over_distance, over_distance, over_distance
    excesses = [_excess(total, bound) for total, bound in zip(totals, bounds, strict=True)]
    if (excesses[0] != 0.0) | (excesses[1] != 0.0) | (excesses[2] != 0.0) | (excesses[3] != 0.0):
        totals = tuple([_limited(*each) for each in zip(totals, excesses, bounds, strict=True)])
    return strips.StripSums(force, *totals)


@inlined
def _strip_force(context, geometry, spans, end_state, other_end):
    """Return the StripForce of the strip of an EndState.

    The law uses the onset rate of this end if it touches, else that of the other end.
    """
    joint, zero = context.joint, as_type_of(0.0, geometry.first_distance)
    first, second = spans
    if first.start == first.stop:
        return StripForce(False, strips.no_sums(zero), zero, zero, zero, zero, zero)
    onset_rate = end_state.onset_rate if touches(end_state.mode) else other_end.onset_rate
    laws, rule, scale = (joint.law, joint.elastic), joint.walls.rule, 0.5 * geometry.overlap.stiffness_fraction
    load = strips.StripLoad(strips.no_sums(zero), zero, zero, zero)
    load = strips.with_span(load, geometry.profile, first, laws, rule, geometry.rates, onset_rate, scale)
    load = strips.with_second_span(load, geometry.profile, second, laws, rule, geometry.rates, onset_rate, scale)
    lowest = lowest_force(joint.law)
    unclipped, total, stored_power, energy = load.total.force - lowest, load.total, load.stored_power, zero
    if lowest == 0.0:  # without a jump where clipping begins or ends; otherwise these events would alternate endlessly
        total = _clipped(total, end_state, joint.clearance)
    if geometry.overlap.growth != 0.0 and load.elastic > 0.0:
        for span in spans:
            energy = energy + scale * strips.energy_of(geometry.profile, span, joint.elastic, rule)
        stored_power = stored_power + energy * geometry.length_rate
        energy = energy * (total.force / load.elastic)
    return StripForce(True, total, load.elastic, load.elastic_outward, stored_power, unclipped, energy)


class _EndSums(NamedTuple):
    """The StripSums of a strip as forces on both ends, and the force conjugate to the squared spread."""

    first: float  # N, along the normal of the end of +z
    second: float  # N, of the other end
    spread: float  # N/m


@inlined
def _end_sums(geometry, sums, end):
    """Return the _EndSums of the strip at one of the ENDS."""
    outward = end * sums.outward_over_distance
    return _EndSums(
        0.5 * geometry.first_distance * (sums.over_distance + outward),
        0.5 * geometry.second_distance * (sums.over_distance - outward),
        0.125 * (sums.over_distance - sums.square_over_distance),
    )


@inlined
def _strip_resultant(context, geometry, walls, sums, energy):
    """Return the normal force (N) of a strip on the journal, and its moment (N m) about the journal's middle.

    walls : the EndStates of both; sums : _EndSums; energy : J, of the strip.
    """
    middle, overlap = context.gap.middle, geometry.overlap
    first, second = times(sums.first, walls[0].point.normal), times(sums.second, walls[1].point.normal)
    axial_force = as_type_of(0.0, energy)
    if overlap.growth != 0.0:
        axial_force = sums.spread * geometry.axial_factor - 0.5 * energy * overlap.growth / overlap.half_length
    moment = plus(
        cross(minus(walls[0].point.position, middle), first), cross(minus(walls[1].point.position, middle), second)
    )
    moment = minus(times(sums.spread, geometry.spin_factor), moment)
    return (
        Vector(-first.x - second.x, -first.y - second.y, axial_force - first.z - second.z),
        Vector(moment.x - axial_force * middle.y, moment.y + axial_force * middle.x, moment.z),
    )


# ---------------------------------------------------------------------------------------------- friction


class _StripFriction(NamedTuple):
    """The friction of a strip."""

    force: Vector  # N, on the journal
    arm: Vector  # m, its point of action, from the journal's centre
    twist: Vector  # N m, see ContactForce
    tangential: float  # N
    slip: float  # m/s


@inlined
def _strip_friction(context, geometry, walls, load, end):
    """Return the friction of a strip with a StripForce at one of the ENDS, at the centre of its elastic load.

    walls : the EndStates of both.
    """
    joint, gap, relative_motion = context.joint, context.gap, context.relative_motion
    end_state = walls[0] if end > 0.0 else walls[1]
    friction_load = load.total.force if lowest_force(joint.law) == 0.0 else max(load.total.force, 0.0)
    weight = load.elastic if load.elastic > 0.0 else as_type_of(1.0, load.elastic)
    z, radial = end * min(max(load.elastic_outward / weight, 0.0), 1.0), joint.journal_radius
    first, second = 0.5 * (1.0 + z) * geometry.first_distance, 0.5 * (1.0 - z) * geometry.second_distance
    offset = plus_scaled(times(first, walls[0].point.normal), second, walls[1].point.normal)
    distance = norm(offset)
    # of a jammed journal without load the axes may meet there, in no direction
    inverse = 1.0 / distance if distance > 0.0 else as_type_of(0.0, distance)
    normal, depth = times(inverse, offset), distance - joint.clearance
    arm = Vector(radial * normal.x, radial * normal.y, geometry.overlap.middle + z * geometry.overlap.half_length)
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


@inlined
def _strip_contact_force(context, geometry, walls, load, end, end_force):
    """Return the ContactForce of the strip at one of the ENDS with the StripForce `load`.

    walls : the EndStates of both; end_force : N, as in a SpreadContact.
    """
    end_state = walls[0] if end > 0.0 else walls[1]
    if not load.is_pressed:
        return _unloaded_contact(end_state, end_force)
    sums = _end_sums(geometry, load.total, end)
    normal_force, moment = _strip_resultant(context, geometry, walls, sums, load.energy)
    friction = _strip_friction(context, geometry, walls, load, end)
    power_at_ends = sums.first * walls[0].rate + sums.second * walls[1].rate
    contact = SpreadContact(
        normal=load.total.force,
        tangential=friction.tangential,
        slip=friction.slip,
        rate=end_state.rate,
        depth=end_state.root * abs(end_state.root) if touches(end_state.mode) else end_state.point.depth,
        elastic=load.elastic,
        raw=load.raw,
        stored_power=load.stored_power,
        lost_power=power_at_ends
        - sums.spread * geometry.spread_rate
        + load.energy * geometry.length_rate
        - load.stored_power,
        end_force=end_force,
    )
    moment = plus(moment, cross(friction.arm, friction.force))
    return ContactForce(normal_force, plus(normal_force, friction.force), moment, friction.twist, contact)


@inlined
def spread_walls(context):
    """Return the ContactForces of both walls."""
    first_end, second_end = end_state_of(context, 0), end_state_of(context, 1)
    if not (touches(first_end.mode) or touches(second_end.mode)):
        zero = as_type_of(0.0, first_end.rate)
        return _unloaded_contact(first_end, zero), _unloaded_contact(second_end, zero)
    walls, geometry = (first_end, second_end), _geometry_of(context, first_end, second_end)
    division = _division_of(geometry, first_end, second_end)
    spans = _spans_of(division, 1.0, first_end, geometry.first_distance)
    load = _strip_force(context, geometry, spans, first_end, second_end)
    other_spans = _spans_of(division, -1.0, second_end, geometry.second_distance)
    other_load = _strip_force(context, geometry, other_spans, second_end, first_end)
    inward, other_inward = load.total.force - load.total.outward, other_load.total.force - other_load.total.outward
    end_force = load.total.force - 0.5 * inward + 0.5 * other_inward
    other_end_force = other_load.total.force - 0.5 * other_inward + 0.5 * inward
    return _strip_contact_force(context, geometry, walls, load, 1.0, end_force), _strip_contact_force(
        context, geometry, walls, other_load, -1.0, other_end_force
    )
