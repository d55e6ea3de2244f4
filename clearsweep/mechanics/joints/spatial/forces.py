"""Forces of the contacts of a spatial joint on its bodies, and its time histories."""

from typing import NamedTuple

from ....contracts.catalogue import Channel
from ....tracing.compiled import calculus as math
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import family, kernel
from ....tracing.compiled.vector import Vector, cross, dot, minus, plus, plus_scaled, times, to_fixed_frame
from ...laws.contract import FREE
from ...laws.friction import friction_force
from .. import contract, spatial
from ..dry import normal_forces, separate_contact
from .spread import as_spread, spread_walls

WALL_FRACTION = 0.5  # fraction of the stiffness at each wall


class _RelativeMotion(NamedTuple):
    """Motion of the journal relative to the bearing, about its centre."""

    velocity: Vector  # m/s
    spin: Vector  # rad/s


@kernel
def _contact_force(context, number, law, elastic, stiffness_fraction, law_offsets):
    """Return the ContactForce of contact `number` of the joint, with a fraction of its laws' stiffness.

    law_offsets : Offsets of the laws of this contact.
    """
    position, normal, depth = context.points[number]
    gap, relative_motion, state = context.gap, context.relative_motion, context.state
    index = context.offsets.contact + number
    arm = minus(position, gap.middle)
    relative_velocity = plus(
        relative_motion.velocity, cross(relative_motion.spin, arm)
    )  # neglects the rotation of the bearing over the depth
    rate = dot(relative_velocity, normal)
    if state.mode[index] == FREE:
        no_force = Vector(as_type_of(0.0, depth), as_type_of(0.0, depth), as_type_of(0.0, depth))
        speed = math.sqrt(dot(relative_velocity, relative_velocity))
        return spatial.ContactForce(no_force, no_force, no_force, no_force, separate_contact(depth, rate, speed))
    root = state.y[state.roots + index]
    pen = root * abs(root)
    current = contract.with_current_laws(context.joint._replace(law=law, elastic=elastic), law_offsets, state)
    forces = normal_forces(current, state.mode[index], pen, rate, state.latched[index])
    normal_magnitude, friction_load, elastic_part, unclipped = (stiffness_fraction * force for force in forces)
    sliding = plus_scaled(plus_scaled(relative_velocity, -rate, normal), depth, cross(gap.bearing_spin, normal))
    square, circumferential = dot(sliding, sliding), normal.x * sliding.y - normal.y * sliding.x
    slip = math.copysign(math.sqrt(square), circumferential) if square > 0.0 else as_type_of(0.0, square)
    tangential = as_type_of(friction_force(current.friction, friction_load, slip), slip)
    friction_per_slip = tangential / slip if square > 0.0 else as_type_of(0.0, slip)
    normal_force, friction = times(-normal_magnitude, normal), times(friction_per_slip, sliding)
    resultant_force = plus(normal_force, friction)
    contact = contract.Contact(
        normal=normal_magnitude,
        tangential=tangential,
        slip=slip,
        rate=rate,
        depth=pen,
        elastic=elastic_part,
        raw=unclipped,
    )
    return spatial.ContactForce(
        normal_force, resultant_force, cross(arm, resultant_force), times(depth, cross(normal, friction)), contact
    )


class _JointContext(NamedTuple):
    """Data that all contacts of a joint share."""

    joint: tuple
    gap: spatial.SpatialGap
    points: tuple  # see `spatial.points_of`
    relative_motion: _RelativeMotion
    offsets: contract.Offsets  # of the joint
    state: tuple  # JointState


@kernel
def _wall_force(context, number, law_offsets):
    joint = context.joint
    return _contact_force(context, number, joint.law, joint.elastic, WALL_FRACTION, law_offsets)


@kernel
def _flange_force(context, number, law_offsets):
    joint = context.joint
    return _contact_force(context, number, joint.axial_law, joint.axial_elastic, 1.0, law_offsets)


@family
def _in_wall_form(walls, contact):
    """Return a Contact in the form of a joint with these walls."""


_in_wall_form.member(spatial.EndContacts)(lambda walls, contact: contact)
_in_wall_form.member(spatial.Spread)(lambda walls, contact: as_spread(contact, contact.normal))


@family
def _wall_forces(walls, context, second_offsets):
    """Return the ContactForces of both walls; second_offsets : Offsets of the laws of the second wall."""


@_wall_forces.member(spatial.EndContacts)
def _wall_forces_end_contacts(walls, context, second_offsets):
    return _wall_force(context, 0, context.offsets), _wall_force(context, 1, second_offsets)


_wall_forces.member(spatial.Spread)(lambda walls, context, second_offsets: spread_walls(context))


@family
def force_at_end(contact):
    """Return the reported normal force (N) of a wall at its end."""


force_at_end.member(contract.Contact)(lambda contact: contact.normal)
force_at_end.member(spatial.SpreadContact)(lambda contact: contact.end_force)


@kernel
def _auxiliary_contacts(joint, gap, a, b):
    """Return the auxiliary Contacts from the ContactForces of both walls."""
    force, resultant_force = plus(a.normal, b.normal), plus(a.force, b.force)
    square = dot(force, force)
    zero = as_type_of(0.0, square)
    resultant = math.sqrt(square) if square > 0.0 else zero
    friction_square = (
        dot(resultant_force, resultant_force) - square
    )  # contribution of friction to the square of the resultant
    friction_magnitude = math.sqrt(friction_square) if friction_square > 0.0 else zero
    difference = abs(force_at_end(a.contact) - force_at_end(b.contact))
    depth = max(a.contact.depth, b.contact.depth)
    sine, flange_gap = spatial.sine_of_tilt(gap.axis), -spatial.overlap_of(joint, gap)
    resultant_contact = contract.Contact(
        normal=resultant, tangential=friction_magnitude, slip=zero, rate=zero, depth=depth, elastic=zero, raw=zero
    )
    difference_contact = contract.Contact(
        normal=difference, tangential=zero, slip=zero, rate=zero, depth=sine, elastic=zero, raw=flange_gap
    )
    return _in_wall_form(joint.walls, resultant_contact), _in_wall_form(joint.walls, difference_contact)


@kernel
def _relative_motion_of(gap):
    """Return the _RelativeMotion of a SpatialGap."""
    velocity = minus(gap.velocity, cross(gap.bearing_spin, gap.middle))
    return _RelativeMotion(velocity, minus(gap.journal_spin, gap.bearing_spin))


@contract.load.member(spatial.Through, spatial.Flanged)
def _load_through_or_flanged(joint, gap, offsets, state):
    points = spatial.points_of(joint, gap)
    context = _JointContext(joint, gap, points, _relative_motion_of(gap), offsets, state)
    second_offsets = contract.after_law(contract.after_law(offsets, joint.law), joint.friction)
    a, b = _wall_forces(joint.walls, context, second_offsets)
    force, moment, twist, flanges = plus(a.force, b.force), plus(a.moment, b.moment), plus(a.twist, b.twist), ()
    if isinstance(joint, spatial.Flanged):
        third_offsets = contract.after_law(contract.after_law(second_offsets, joint.law), joint.friction)
        fourth_offsets = contract.after_law(contract.after_law(third_offsets, joint.axial_law), joint.friction)
        c, d = _flange_force(context, 2, third_offsets), _flange_force(context, 3, fourth_offsets)
        force, moment = plus(force, plus(c.force, d.force)), plus(moment, plus(c.moment, d.moment))
        twist = plus(twist, plus(c.twist, d.twist))
        flanges = _in_wall_form(joint.walls, c.contact), _in_wall_form(joint.walls, d.contact)
    # the opposite forces act on the bearing's surface, at the penetration along the normal from the journal's
    bearing_moment = minus(twist, plus(moment, cross(gap.middle, force)))
    contacts = (a.contact, b.contact, *flanges, *_auxiliary_contacts(joint, gap, a, b))
    return spatial.SpatialLoad(force, moment, bearing_moment, contacts, points)


@contract.contacts_at_speed.member(spatial.Through, spatial.Flanged)
def _contacts_at_speed_through_or_flanged(joint, gap, offsets, state, before):
    motion, points, moved = _relative_motion_of(gap), before.points, ()
    for i in range(len(points)):
        velocity = plus(motion.velocity, cross(motion.spin, minus(points[i].position, gap.middle)))
        moved = (*moved, before.contacts[i]._replace(rate=dot(velocity, points[i].normal)))
    return (*moved, *before.contacts[len(points) :])  # the auxiliary contacts have no rates


#: The time histories of a spatial joint.
CHANNELS = (
    *(Channel(axis, "m", f"journal's middle relative to the bearing's, fixed frame, {axis}") for axis in "xyz"),
    *(Channel(f"v{axis}", "m/s", f"its rate, {axis}") for axis in "xyz"),
    Channel("tilt", "rad", "angle between the axes of bearing and journal"),
    Channel("force_normal", "N", "sum of the normal forces at the walls, as vectors"),
)
#: Then the time histories of each contact point: 1 and 2 at the walls, 3 and 4 at the flanges.
POINT_CHANNELS = (
    Channel("force_normal_{}", "N", "normal force at contact point {}"),
    Channel("force_friction_{}", "N", "friction at contact point {}, its size"),
)


@contract.gap_histories.member(spatial.Through, spatial.Flanged)
def _gap_histories_through_or_flanged(joint, gap, side):
    position, velocity = to_fixed_frame(gap.frame, gap.middle), to_fixed_frame(gap.frame, gap.velocity)
    return position.x, position.y, position.z, velocity.x, velocity.y, velocity.z, spatial.tilt_of(gap.axis)


@contract.load_histories.member(spatial.Through, spatial.Flanged)
def _load_histories_through_or_flanged(joint, load):
    (a, b), flanges, resultant_force = load.contacts[:2], load.contacts[2:-2], load.contacts[-2]
    walls = (resultant_force.normal, force_at_end(a), abs(a.tangential), force_at_end(b), abs(b.tangential))
    return (*walls, *[number for flange in flanges for number in (flange.normal, abs(flange.tangential))])
