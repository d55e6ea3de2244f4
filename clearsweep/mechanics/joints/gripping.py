"""Grips: tangential forces of surfaces that stick, and the sliding speeds that these forces work on.

A force and its sliding speed belong together, so that their product is its power.  The pin in its bearing and the pin
in a slot touch at one point, which has one force.  The corners of a block on the same wall slide at one speed,
except for the spin of the block times its tilt.  They share one force in proportion to their normal forces, so that no
corner exceeds its limit.  The two walls have a force each, for a block that is jammed between them.
"""

from typing import NamedTuple

from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import plain
from ...tracing.compiled.family import family, inlined, kernel
from ..laws.contract import AT_LIMIT_DOWN, AT_LIMIT_UP, STICKING
from ..laws.friction import static_limit
from .contract import Contact, Load
from .dry import Joint
from .guide import CORNERS, Guide, corner_position, with_resultant
from .slot import SlotJoint, normal_of


@family
def grips_of(joint, gap, load, mode, first_contact):
    """Return the grips of a joint under its Load; () if it cannot stick.  first_contact : index of its first contact.

    mode : (contacts,) mode of each contact.  A grip has the fields `contacts`, the numbers of its contacts, `force`
    (N), the tangential force of the sticking ones, `limit` (N), its largest value, and `slip` (m/s).  Past a separation
    the limit of a single contact is negative, so that trial steps continue smoothly.
    """


@family
def slip_rate(grip, acceleration):
    """Return the rate (m/s^2) of the sliding speed of a grip, from the GapAcceleration of its joint."""


@family
def with_tangential(grip, load, force, stopping_force):
    """Return the Load of a joint with `force` (N) in place of the tangential force of one of its grips.

    stopping_force : N, force that would stop the sliding.
    """


@grips_of.member(None)
def _default_grips_of(joint, gap, load, mode, first_contact):
    return ()


@inlined
def _with_friction(contact, force, stopping_force):
    """Return a Contact with another tangential force (N), and the one that would stop the sliding."""
    return Contact(
        normal=contact.normal,
        tangential=force,
        slip=contact.slip,
        rate=contact.rate,
        depth=contact.depth,
        elastic=contact.elastic,
        raw=contact.raw,
        stopping_force=plain(stopping_force),
    )


# ---------------------------------------------------------------------------------------------- a pin in its bearing


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


@grips_of.member(Joint)
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


@slip_rate.member(BearingGrip)
def _slip_rate_bearing_grip(grip, acceleration):
    x, y, vx, vy = grip.x, grip.y, grip.vx, grip.vy
    squared = x * x + y * y
    transverse = x * acceleration.ay - y * acceleration.ax - (x * vy - y * vx) * (x * vx + y * vy) / squared
    relative_spin = acceleration.distal * grip.journal_radius - acceleration.proximal * grip.bearing_radius
    if grip.side < 0.0:
        relative_spin = acceleration.proximal * grip.journal_radius - acceleration.distal * grip.bearing_radius
    return transverse / squared**0.5 + relative_spin


@with_tangential.member(BearingGrip)
def _with_tangential_bearing_grip(grip, load, force, stopping_force):
    contact = load.contacts[0]
    force_change = force - contact.tangential
    force_per_distance = force_change / (grip.x * grip.x + grip.y * grip.y) ** 0.5
    bearing_moment, journal_moment = -grip.bearing_radius * force_change, grip.journal_radius * force_change
    if grip.side < 0.0:
        bearing_moment, journal_moment = journal_moment, bearing_moment
    return Load(
        fx=load.fx - force_per_distance * grip.y,
        fy=load.fy + force_per_distance * grip.x,
        moment_proximal=load.moment_proximal + bearing_moment,
        moment_distal=load.moment_distal + journal_moment,
        contacts=(_with_friction(contact, force, stopping_force),),
    )


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
    axial, transverse, pin_moment = (
        -force_change * grip.ny,
        force_change * grip.nx,
        grip.journal_radius * force_change,
    )
    return Load(
        fx=load.fx + (gap.axis_x * axial - gap.axis_y * transverse),
        fy=load.fy + (gap.axis_y * axial + gap.axis_x * transverse),
        moment_proximal=load.moment_proximal + (gap.y * axial - gap.x * transverse - pin_moment),
        moment_distal=load.moment_distal + pin_moment,
        contacts=(_with_friction(contact, force, stopping_force),),
    )


# ---------------------------------------------------------------------------------------------- a block in a guide


class WallGrip(NamedTuple):
    """The grip of the corners of a block on one wall."""

    contacts: tuple
    force: float  # N
    limit: float  # N
    slip: float  # m/s
    corners: tuple  # their numbers in the joint
    fractions: tuple  # of the force on each corner: 0 on one that does not stick
    heights: tuple  # m, of the corners across the walls, from the block's point
    sign: float  # +1: the wall on the left of the direction of the guide
    drift: float  # m/s^2, rate of the sliding speed as the block turns
    stuck: tuple  # whether each corner sticks
    gap: tuple  # GuideGap


@grips_of.member(Guide)
def _grips_of_guide(joint, gap, load, mode, first_contact):
    if type(joint.friction) not in static_limit.members:
        return ()
    return _wall_grip(joint, gap, load, mode, first_contact, (0, 1)), _wall_grip(
        joint, gap, load, mode, first_contact, (2, 3)
    )


@inlined
def _wall_grip(joint, gap, load, mode, first_contact, corners):
    sign, (a, b) = CORNERS[corners[0]][1], (load.contacts[corner] for corner in corners)
    contacts = first_contact + corners[0], first_contact + corners[1]
    stuck = is_sticking(mode[contacts[0]]), is_sticking(mode[contacts[1]])
    loads = where(stuck[0], max(a.normal, 0.0), 0.0), where(stuck[1], max(b.normal, 0.0), 0.0)
    total_load = loads[0] + loads[1]
    inverse_load = 1.0 / where(total_load > 0.0, total_load, 1.0)
    fractions = loads[0] * inverse_load, loads[1] * inverse_load
    (ax, ay), (bx, by) = (corner_position(joint, gap, CORNERS[corner]) for corner in corners)
    relative_spin, height = gap.spin_distal - gap.spin_proximal, fractions[0] * ay + fractions[1] * by
    return WallGrip(
        contacts=contacts,
        force=where(stuck[0], a.tangential, 0.0) + where(stuck[1], b.tangential, 0.0),
        limit=static_limit(joint.friction) * total_load,
        slip=-sign * (gap.vx - relative_spin * height),
        corners=corners,
        fractions=fractions,
        heights=(ay, by),
        sign=sign,
        drift=sign * relative_spin * relative_spin * (fractions[0] * ax + fractions[1] * bx),
        stuck=stuck,
        gap=gap,
    )


@slip_rate.member(WallGrip)
def _slip_rate_wall_grip(grip, acceleration):
    height = grip.fractions[0] * grip.heights[0] + grip.fractions[1] * grip.heights[1]
    return grip.drift - grip.sign * (acceleration.ax - height * (acceleration.distal - acceleration.proximal))


@with_tangential.member(WallGrip)
def _with_tangential_wall_grip(grip, load, force, stopping_force):
    contacts, force_change, moment = load.contacts, 0.0, 0.0
    for i in range(2):
        corner, corner_contact = grip.corners[i], contacts[grip.corners[i]]
        tangential = where(grip.stuck[i], grip.fractions[i] * force, corner_contact.tangential)
        force_change += tangential - corner_contact.tangential
        moment += grip.heights[i] * (tangential - corner_contact.tangential)
        corner_stopping_force = where(grip.stuck[i], grip.fractions[i] * stopping_force, 0.0)
        contacts = (
            *contacts[:corner],
            _with_friction(corner_contact, tangential, corner_stopping_force),
            *contacts[corner + 1 :],
        )
    gap, axial, block_moment = grip.gap, -grip.sign * force_change, grip.sign * moment
    return Load(
        fx=load.fx + gap.axis_x * axial,
        fy=load.fy + gap.axis_y * axial,
        moment_proximal=load.moment_proximal + (gap.y * axial - block_moment),
        moment_distal=load.moment_distal + block_moment,
        contacts=with_resultant(contacts[0], contacts[1], contacts[2], contacts[3]),
    )


# ---------------------------------------------------------------------------------------------- modes


@kernel
def is_sticking(mode):
    """Return whether the surfaces of a contact in this mode stick."""
    any_sticking = False
    for sticking_mode in STICKING:
        any_sticking = any_sticking | (mode == sticking_mode)
    return any_sticking


@kernel
def is_grip_sticking(grip, mode):
    """Return whether a contact of a grip sticks."""
    any_sticking = False
    for contact in grip.contacts:
        any_sticking = any_sticking | is_sticking(mode[contact])
    return any_sticking


@kernel
def limit_sign(grip, mode):
    """Return 1 or -1 if the force of a grip is at its upper or lower limit, or 0 if it follows from the motion.

    Corners on one wall share their force, so they reach its limit together.
    """
    sign = 0.0
    for contact in grip.contacts:
        sign += where(mode[contact] == AT_LIMIT_UP, 1.0, 0.0) - where(mode[contact] == AT_LIMIT_DOWN, 1.0, 0.0)
    return min(max(sign, -1.0), 1.0)
