"""Loads of walls with distributed stiffness: a strip from each end, see `strips`.

The energy stored in a strip is a function of depth and slope at its end and of the length on which journal and bore
overlap.  Its force acts along the normal at its end; the couple of the slope moves it inwards, to the centre of load.
Friction acts at the centre of the strip's load.
"""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.dual import as_type_of
from ...compiled.family import family, kernel
from ...compiled.vector import Vector, cross, dot, minus, plus, plus_scaled, times
from ..contract import Contact
from ..elastic.contract import elastic_energy
from ..friction.contract import friction_force
from ..loss.contract import lowest_force
from ..modes import CLIPPED, touches
from .form import ContactForce, InBore, Overlapping, SpreadContact
from .inclination import Inclination, inclination_of
from .points import Point, overlap_of, wall_point
from .strips import Strip, is_pressed, nodes_of, pressed_part, strip_load_of


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
    """The length on which journal and bore overlap."""

    half_length: float  # m, overlap
    stiffness_fraction: float  # 1, fraction of the full stiffness that acts on this overlap
    growth: float  # 1, rate of the length per velocity (m/s) of the journal along its axis, seen from the bearing


@family
def bearing_length(end_type, joint, gap):
    """Return the Overlap of journal and bore."""


@bearing_length.member(InBore)
def _bearing_length_in_bore(end_type, joint, gap):
    zero = as_type_of(0.0, gap.middle.z)
    return Overlap(zero + joint.journal_half_length, zero + 1.0, zero)


@bearing_length.member(Overlapping)
def _bearing_length_overlapping(end_type, joint, gap):
    full_length, length = 2.0 * min(joint.journal_half_length, joint.half_length), overlap_of(joint, gap)
    zero = as_type_of(0.0, length)
    if length >= full_length:
        return Overlap(zero + 0.5 * full_length, zero + 1.0, zero)
    length = max(length, 1e-9 * full_length)  # the run ends when it is 0
    return Overlap(0.5 * length, length / full_length, zero - math.copysign(1.0, gap.middle.z))


# ---------------------------------------------------------------------------------------------- one end


class EndState(NamedTuple):
    """One end of the walls."""

    point: Point
    mode: int
    root: float  # m^0.5, of the penetration
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
    rate = dot(velocity, point.normal)
    return EndState(
        point,
        state.mode[contact_index],
        state.y[state.roots + contact_index],
        state.latched[contact_index],
        velocity,
        rate,
    )


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


class _LoadedStrip(NamedTuple):
    """Geometry of the strip of an end."""

    end: float  # one of the ENDS
    inclination: Inclination
    overlap: Overlap
    length_rate: float  # m/s, of the overlap's length
    strip: Strip


@kernel
def _loaded_strip(context, end_state, end, overlap):
    """Return the geometry of the strip of an EndState, one of the ENDS."""
    gap, relative_motion = context.gap, context.relative_motion
    inclination = inclination_of(context.joint.end_type, context.joint, gap, end)
    velocity = plus(relative_motion.velocity, cross(relative_motion.spin, minus(inclination.center, gap.middle)))
    slope_rate = dot(velocity, inclination.velocity_factor) + dot(relative_motion.spin, inclination.spin_factor)
    along_axis = (
        relative_motion.velocity.z + relative_motion.spin.y * gap.middle.x - relative_motion.spin.x * gap.middle.y
    )
    length_rate = overlap.growth * along_axis
    depth = end_state.root * end_state.root if touches(end_state.mode) else end_state.point.depth
    fall_rate = overlap.half_length * slope_rate + 0.5 * length_rate * inclination.slope
    strip = Strip(
        end_state.root,
        depth,
        depth - overlap.half_length * inclination.slope,
        end_state.rate,
        end_state.rate - fall_rate,
    )
    return _LoadedStrip(end, inclination, overlap, length_rate, strip)


class StripForce(NamedTuple):
    """Load of a strip."""

    force: float  # N, 0 where it is clipped
    inner_moment: (
        float  # N, first moment of the force over the fraction of the strip from its end, between 0 and the force
    )
    elastic: float  # N, the elastic part of the force, clipped or not
    elastic_inner_moment: float  # N
    raw: float  # N, force before clipping, minus the least force of its law
    lengthening: float  # N, derivative of the stored energy by the overlap, clipped like the force
    elastic_lengthening: float  # N, the same, clipped or not


@kernel
def _strip_load(context, end_state, other_end, loaded_strip):
    """Return the StripForce of the strip of an EndState.

    The law uses the onset rate of this end if it touches, else that of the other end.
    """
    joint, is_touching, strip, overlap = (
        context.joint,
        touches(end_state.mode),
        loaded_strip.strip,
        loaded_strip.overlap,
    )
    zero = as_type_of(0.0, strip.depth)
    if not is_pressed(strip):
        return StripForce(zero, zero, zero, zero, zero, zero, zero)
    pressed_range = pressed_part(strip, not touches(other_end.mode) or other_end.root < 0.0)
    onset_rate = end_state.onset_rate if is_touching else other_end.onset_rate
    moments = strip_load_of(strip, pressed_range, (joint.law, joint.elastic), joint.walls.rule, onset_rate)
    stiffness_fraction = 0.5 * overlap.stiffness_fraction
    force, inner_moment = stiffness_fraction * (moments.outer + moments.inner), stiffness_fraction * moments.inner
    elastic, elastic_inner_moment = (
        stiffness_fraction * (moments.elastic_outer + moments.elastic_inner),
        stiffness_fraction * moments.elastic_inner,
    )
    lowest = lowest_force(joint.law)
    unclipped = force - lowest
    if (
        lowest == 0.0
    ):  # forces are continuous where clipping begins or ends; otherwise these events would alternate endlessly
        force = max(force, 0.0) if end_state.mode != CLIPPED else zero
        inner_moment = min(max(inner_moment, 0.0), force)
    if overlap.growth == 0.0 or elastic <= 0.0:
        return StripForce(force, inner_moment, elastic, elastic_inner_moment, unclipped, zero, zero)
    lengthening = _energy_per_length(joint, strip, pressed_range, overlap)
    return StripForce(
        force, inner_moment, elastic, elastic_inner_moment, unclipped, lengthening * (force / elastic), lengthening
    )


@kernel
def _energy_per_length(joint, strip, pressed_range, overlap):
    """Return the derivative (N) of a strip's stored energy by its length, at constant depths."""
    total, inverse = as_type_of(0.0, strip.depth), pressed_range.begin + pressed_range.end
    inverse = 1.0 / inverse if inverse > 0.0 else as_type_of(0.0, inverse)
    for node, weight in nodes_of(joint.walls.rule):
        x = pressed_range.begin + (pressed_range.end - pressed_range.begin) * node
        total = total + 2.0 * weight * pressed_range.length_fraction * (x * inverse) * elastic_energy(
            joint.elastic, x * x
        )
    return 0.5 * overlap.stiffness_fraction * total / (2.0 * overlap.half_length)


@kernel
def _strip_resultant(context, end_state, loaded_strip, load):
    """Return the normal force (N) of a strip on the journal, and its moment (N m) about the journal's middle.

    It acts along the normal at the end; the slope has a force and a couple; stored energy separates the bodies along
    the axis if that shortens the overlap.
    """
    midpoint, inclination, moment_arm_product = (
        context.gap.middle,
        loaded_strip.inclination,
        load.inner_moment * loaded_strip.overlap.half_length,
    )
    pressing, couple = (
        times(-load.force, end_state.point.normal),
        times(moment_arm_product, inclination.velocity_factor),
    )
    axial_force = (0.5 * load.inner_moment * inclination.slope - load.lengthening) * loaded_strip.overlap.growth
    force = plus(pressing, couple)
    moment = plus(
        cross(minus(end_state.point.position, midpoint), pressing), cross(minus(inclination.center, midpoint), couple)
    )
    moment = plus_scaled(moment, moment_arm_product, inclination.spin_factor)
    return (
        Vector(force.x, force.y, force.z + axial_force),
        Vector(moment.x - axial_force * midpoint.y, moment.y + axial_force * midpoint.x, moment.z),
    )


class _StripFriction(NamedTuple):
    """The friction of a strip."""

    force: Vector  # N, on the journal
    arm: Vector  # m, its point of action, from the journal's centre
    twist: Vector  # N m, see ContactForce
    tangential: float  # N
    slip: float  # m/s


@kernel
def _strip_friction(context, end_state, loaded_strip, load):
    """Return the friction of a strip, at the centre of its elastic load."""
    joint, gap, relative_motion, half_overlap = (
        context.joint,
        context.gap,
        context.relative_motion,
        loaded_strip.overlap.half_length,
    )
    friction_load = load.force if lowest_force(joint.law) == 0.0 else max(load.force, 0.0)
    weight = load.elastic if load.elastic > 0.0 else as_type_of(1.0, load.elastic)
    center_distance = min(max(load.elastic_inner_moment / weight, 0.0), 1.0) * half_overlap
    normal, arm_point = end_state.point.normal, minus(end_state.point.position, gap.middle)
    arm, depth = (
        Vector(arm_point.x, arm_point.y, arm_point.z - loaded_strip.end * center_distance),
        end_state.point.depth - center_distance * loaded_strip.inclination.slope,
    )
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


@kernel
def _strip_contact_force(context, end_state, loaded_strip, load, end_force):
    """Return the ContactForce of an EndState with the StripForce `load`; end_force : N, as in a SpreadContact."""
    strip = loaded_strip.strip
    if not is_pressed(strip):
        return _unloaded_contact(end_state, end_force)
    fall_rate = strip.rate - strip.inner_rate
    length_rate = loaded_strip.length_rate
    stored = (
        load.elastic * end_state.rate - load.elastic_inner_moment * fall_rate + load.elastic_lengthening * length_rate
    )
    total_power = load.force * end_state.rate - load.inner_moment * fall_rate + load.lengthening * length_rate
    normal_force, moment = _strip_resultant(context, end_state, loaded_strip, load)
    friction = _strip_friction(context, end_state, loaded_strip, load)
    contact = SpreadContact(
        normal=load.force,
        tangential=friction.tangential,
        slip=friction.slip,
        rate=end_state.rate,
        depth=end_state.point.depth,
        elastic=load.elastic,
        raw=load.raw,
        stored_power=stored,
        lost_power=total_power - stored,
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
    overlap = bearing_length(context.joint.end_type, context.joint, context.gap)
    a, b = _loaded_strip(context, first_end, 1.0, overlap), _loaded_strip(context, second_end, -1.0, overlap)
    load_a, load_b = _strip_load(context, first_end, second_end, a), _strip_load(context, second_end, first_end, b)
    end_force_a, end_force_b = (
        load_a.force - 0.5 * load_a.inner_moment + 0.5 * load_b.inner_moment,
        load_b.force - 0.5 * load_b.inner_moment + 0.5 * load_a.inner_moment,
    )
    return _strip_contact_force(context, first_end, a, load_a, end_force_a), _strip_contact_force(
        context, second_end, b, load_b, end_force_b
    )
