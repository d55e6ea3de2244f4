"""A revolute joint with clearance: from the relative motion of two pins to the forces between the bodies.

Bearing and journal are circles; the journal surface touches the bearing where the eccentricity exceeds the clearance.
Each body has its own contact point, as is usual (Flores, Ambrosio, Claro & Lankarani 2008): the bearing's at its
radius, the journal's at its own, both along the normal, so their distance is the penetration.  Force, moments and
sliding speed all belong to these points, and the powers of the forces on both bodies add up to tangential force times
sliding speed.  There are two approximations: the tangential forces leave a couple of force times penetration, and a
pair that rotates as a rigid body slides at penetration times angular speed.
"""

from typing import NamedTuple

from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import cond, where
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import inlined, kernel, known
from ..laws.contract import CLIPPED, FREE, PRESSED, STICKING, Guard, guards
from ..laws.friction import friction_force, static_limit
from ..laws.loss import contact_force, lowest_force, sign_past_separation
from ..observe import RAW
from . import contract


class Joint(NamedTuple):
    """A revolute joint with clearance between a proximal body (towards the drive) and a distal one."""

    clearance: float  # m, radial
    bearing_radius: float  # m
    journal_radius: float  # m
    side: float  # +1: the journal sits on the distal body, -1: on the proximal one
    law: tuple  # contact_force
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force
    wear: tuple  # wear_rate


class Gap(NamedTuple):
    """Motion of the distal pin relative to the proximal one in the fixed frame, and spins of both bodies."""

    x: float  # m
    y: float  # m
    vx: float  # m/s
    vy: float  # m/s
    spin_proximal: float  # rad/s
    spin_distal: float  # rad/s


class Clip(NamedTuple):
    """The part of a dry joint that clips a pulling force."""


@guards.member(Clip)
def _guards_clip(clip):
    pulls = Guard((PRESSED, *STICKING), CLIPPED, counted=True, observable=RAW, sign=-1.0)
    return pulls, Guard((CLIPPED,), PRESSED, observable=RAW)


def dry_parts(friction, *laws):
    """Return the Parts of dry contacts of a joint that have these laws, in the order of their numbers."""
    laws_of_contacts = [(contact, (Clip(), law, friction)) for contact, law in enumerate(laws)]
    return tuple([contract.Part(law, contact) for contact, laws in laws_of_contacts for law in laws])


@known
def elastic_parts(joint):
    """Return the Part of a joint's elastic law if it has guards, as one of one's own with kinks has."""
    elastic = getattr(joint, "elastic", ())
    return (contract.Part(elastic, 0),) if type(elastic) in guards.members else ()


def register_single_contact(joint_type):
    """Register a type of joint that has one dry contact, with its `law` and `friction`."""
    contract.contact_modes.member(joint_type)(lambda joint: (contract.ContactModes(FREE, PRESSED),))
    contract.parts.member(joint_type)(lambda joint: (*dry_parts(joint.friction, joint.law), *elastic_parts(joint)))


register_single_contact(Joint)


@contract.load.member(Joint)
def _load_joint(joint, gap, offsets, state):
    root = state.y[state.roots + offsets.contact]
    current = contract.with_current_laws(joint, offsets, state)
    return joint_load(current, gap, state.mode[offsets.contact], root * abs(root), state.latched[offsets.contact])


@kernel
def surface_speed(joint, gap, tx, ty):
    """Return the speed (m/s) of the journal surface over the bearing surface along the unit tangent (tx, ty)."""
    distal_spin_speed = gap.spin_distal * joint.journal_radius - gap.spin_proximal * joint.bearing_radius
    proximal_spin_speed = gap.spin_proximal * joint.journal_radius - gap.spin_distal * joint.bearing_radius
    spin_speed = where(joint.side < 0.0, proximal_spin_speed, distal_spin_speed)
    return joint.side * (gap.vx * tx + gap.vy * ty) + spin_speed


@inlined
def normal_forces(joint, mode, pen, rate, onset_rate):
    """Return (normal force, load of the friction, elastic part, force before clipping) of a pressed joint, N."""
    force, elastic = contact_force(joint.law, joint.elastic, abs(pen), rate, onset_rate)
    lowest = lowest_force(joint.law)
    unclipped = force - lowest
    sign = where(pen < 0.0, sign_past_separation(joint.law, joint.elastic), 1.0)
    force, elastic = sign * force, sign * elastic
    normal = where(mode != CLIPPED, force, 0.0)
    friction_load = normal if lowest == 0.0 else max(normal, 0.0)  # smooth where an event is located
    return normal, friction_load, elastic, unclipped


class SurfaceMotion(NamedTuple):
    """Motion of the surfaces of a contact."""

    depth: float  # m, penetration from the coordinates
    rate: float  # m/s, of the penetration
    slip: float  # m/s


@inlined
def pressed_contact(joint, motion, mode, pen, onset_rate):
    """Return the Contact of pressed surfaces in a SurfaceMotion, under the laws of `joint`, which have their state.

    pen : m, from the root of penetration; a negative one occurs in trial steps past the separation.
    """
    normal, friction_load, elastic, unclipped = normal_forces(joint, mode, pen, motion.rate, onset_rate)
    return contract.Contact(
        normal=normal,
        tangential=as_type_of(friction_force(joint.friction, friction_load, motion.slip), motion.slip),
        slip=motion.slip,
        rate=motion.rate,
        depth=motion.depth,
        elastic=elastic,
        raw=unclipped,
    )


@inlined
def pressed_contact_at(joint, motion, offsets, state):
    """Return the Contact of pressed surfaces in a SurfaceMotion, at the Offsets of the contact in the JointState."""
    root, current = state.y[state.roots + offsets.contact], contract.with_current_laws(joint, offsets, state)
    mode, onset_rate = state.mode[offsets.contact], state.latched[offsets.contact]
    return pressed_contact(current, motion, mode, root * abs(root), onset_rate)


@inlined
def separate_contact(depth, rate, speed):
    """Return the Contact of separate surfaces; speed : m/s, a bound of the rate of the depth."""
    zero = as_type_of(0.0, depth)
    return contract.Contact(normal=zero, tangential=zero, slip=speed, rate=rate, depth=depth, elastic=zero, raw=zero)


@inlined
def reported_contact(normal, depth, zero):
    """Return a Contact that only reports."""
    return contract.Contact(normal=normal, tangential=zero, slip=zero, rate=zero, depth=depth, elastic=zero, raw=zero)


@inlined
def no_load(contact):
    """Return the Load of a separate joint with this Contact."""
    zero = as_type_of(0.0, contact.depth)
    return contract.Load(fx=zero, fy=zero, moment_proximal=zero, moment_distal=zero, contacts=(contact,))


@inlined
def load_on_journal(joint, fx, fy, moments, contacts):
    """Return the Load of a force (N) on the journal; moments : N m, of bearing and journal."""
    is_journal_proximal, (bearing_moment, journal_moment) = joint.side < 0.0, moments
    return contract.Load(
        fx=joint.side * fx,
        fy=joint.side * fy,
        moment_proximal=where(is_journal_proximal, journal_moment, bearing_moment),
        moment_distal=where(is_journal_proximal, bearing_moment, journal_moment),
        contacts=contacts,
    )


@inlined
def load_along_axis(gap, axial, transverse, couple, contacts):
    """Return the Load of a force (N) on the distal body along and across the axis of a gap, and of a couple (N m)."""
    return contract.Load(
        fx=gap.axis_x * axial - gap.axis_y * transverse,
        fy=gap.axis_y * axial + gap.axis_x * transverse,
        moment_proximal=-couple - gap.x * transverse + gap.y * axial,
        moment_distal=couple,
        contacts=contacts,
    )


@inlined
def joint_load(joint, gap, mode, pen, onset_rate):
    """Return the Load of a joint in a mode whose contact has penetration `pen` (m) and began at `onset_rate` (m/s).

    A negative `pen` occurs in trial steps past the separation.
    """
    return _load_by_mode(mode == FREE, (joint, gap, mode, pen, onset_rate))


@inlined
def _load_apart(joint, gap, mode, pen, onset_rate):
    eccentricity = math.sqrt(gap.x * gap.x + gap.y * gap.y)
    speed = math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy)
    radial = gap.x * gap.vx + gap.y * gap.vy
    rate = where(eccentricity > 0.0, radial / where(eccentricity > 0.0, eccentricity, 1.0), speed)
    return no_load(separate_contact(eccentricity - joint.clearance, rate, speed))


@inlined
def _load_pressed(joint, gap, mode, pen, onset_rate):
    square = gap.x * gap.x + gap.y * gap.y
    x, y, vx, vy = joint.side * gap.x, joint.side * gap.y, joint.side * gap.vx, joint.side * gap.vy
    # The root of penetration determines the eccentricity and its inverse before the gap is known; one
    # Newton step squares the remaining difference.  Everything after this waits only for the gap,
    # not for a root and a division.
    first_inverse = 1.0 / (joint.clearance + pen)
    inverse = first_inverse * (1.5 - 0.5 * square * first_inverse * first_inverse)
    nx, ny = x * inverse, y * inverse
    rate = vx * nx + vy * ny
    motion = SurfaceMotion(square * inverse - joint.clearance, rate, surface_speed(joint, gap, -ny, nx))
    contact = pressed_contact(joint, motion, mode, pen, onset_rate)
    fx = -contact.normal * nx - contact.tangential * ny
    fy = -contact.normal * ny + contact.tangential * nx
    moments = -joint.bearing_radius * contact.tangential, joint.journal_radius * contact.tangential
    return load_on_journal(joint, fx, fy, moments, (contact,))


_load_by_mode = cond(_load_apart, _load_pressed)


# ---------------------------------------------------------------------------------------------- the grip of a pin


class BearingGrip(NamedTuple):
    """The grip of a pin in its bearing."""

    contacts: tuple
    force: float  # N
    limit: float  # N
    slip: float  # m/s
    bearing_radius: float  # m
    journal_radius: float  # m
    side: float
    x: float  # m
    y: float
    vx: float  # m/s
    vy: float


@contract.grips_of.member(Joint)
def _grips_of_joint(joint, gap, load, mode, first_contact):
    if type(joint.friction) not in static_limit.members:
        return ()
    contact = load.contacts[0]
    return (
        BearingGrip(
            contacts=(first_contact,),
            force=contact.tangential,
            limit=static_limit(joint.friction) * contact.normal,
            slip=contact.slip,
            bearing_radius=joint.bearing_radius,
            journal_radius=joint.journal_radius,
            side=joint.side,
            x=gap.x,
            y=gap.y,
            vx=gap.vx,
            vy=gap.vy,
        ),
    )


@contract.slip_rate.member(BearingGrip)
def _slip_rate_bearing_grip(grip, acceleration):
    x, y, vx, vy = grip.x, grip.y, grip.vx, grip.vy
    squared = x * x + y * y
    transverse = x * acceleration.ay - y * acceleration.ax - (x * vy - y * vx) * (x * vx + y * vy) / squared
    relative_spin = acceleration.distal * grip.journal_radius - acceleration.proximal * grip.bearing_radius
    if grip.side < 0.0:
        relative_spin = acceleration.proximal * grip.journal_radius - acceleration.distal * grip.bearing_radius
    return transverse / squared**0.5 + relative_spin


@contract.with_tangential.member(BearingGrip)
def _with_tangential_bearing_grip(grip, load, force, stopping_force):
    contact = load.contacts[0]
    force_change = force - contact.tangential
    force_per_distance = force_change / (grip.x * grip.x + grip.y * grip.y) ** 0.5
    bearing_moment, journal_moment = -grip.bearing_radius * force_change, grip.journal_radius * force_change
    if grip.side < 0.0:
        bearing_moment, journal_moment = journal_moment, bearing_moment
    return contract.Load(
        fx=load.fx - force_per_distance * grip.y,
        fy=load.fy + force_per_distance * grip.x,
        moment_proximal=load.moment_proximal + bearing_moment,
        moment_distal=load.moment_distal + journal_moment,
        contacts=(contact._replace(tangential=force, stopping_force=plain(stopping_force)),),
    )
