"""A guide with clearance: a block between two straight walls, which it can touch with each of its four corners.

The proximal body has the walls, the distal one the block (Flores, Leine & Glocker 2010, "Modeling and analysis of
planar rigid multibody systems with translational clearance joints based on the non-smooth dynamics approach", Multibody
System Dynamics 23).  Everything is in the frame of the walls: x along them, y across, from the middle between them.  A
corner presses on the wall at its own position, and friction acts there too, so the powers of the forces on both bodies
add up to normal force times rate of penetration and friction times sliding speed exactly.

The corners are numbered from 1 to 4: in front and on the left of the direction of the guide, then behind on the left,
behind on the right, in front on the right.  An auxiliary contact follows, which only reports: the resultant of the
corners across the walls and along them.
"""

from typing import NamedTuple

from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import inlined, kernel
from ..laws.contract import ACTS, FREE, PRESSED, is_sticking
from ..laws.friction import static_limit
from ..wear.bins import never_wears
from . import contract
from .dry import SurfaceMotion, dry_parts, load_along_axis, pressed_contact_at, reported_contact, separate_contact

CORNERS = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))  # signs of half the length and half the height


class Guide(NamedTuple):
    """A clearance joint between walls and a block."""

    clearance: float  # m, on each side
    side: float  # +1: the block is on the distal body
    length: float  # m, of the block, along the walls
    height: float  # m, across them
    law: tuple  # contact_force, of each corner
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force


class GuideGap(NamedTuple):
    """The block in the frame of the walls, and the spins of both bodies."""

    x: float  # m, of the distal point from the proximal one, along the walls
    y: float  # m, across
    vx: float  # m/s, as seen from the walls
    vy: float  # m/s
    spin_proximal: float  # rad/s
    spin_distal: float  # rad/s
    axis_x: float  # direction of the walls in the fixed frame
    axis_y: float
    cosine: float  # of the angle of the block relative to the walls
    sine: float


class Corner(NamedTuple):
    """Force of a corner and its position, in the frame of the walls, from the block's point."""

    fx: float  # N, on the block
    fy: float
    x: float  # m
    y: float
    contact: contract.Contact


_MODES = (*((contract.ContactModes(FREE, PRESSED),) * 4), contract.ContactModes(ACTS, ACTS))
contract.contact_modes.member(Guide)(lambda joint: _MODES)
contract.parts.member(Guide)(lambda joint: dry_parts(joint.friction, joint.law, joint.law, joint.law, joint.law))


@inlined
def corner_position(joint, gap, signs):
    """Return the position (m) of a corner from the block's point in the frame of the walls, by its signs (CORNERS)."""
    half_length, half_height = 0.5 * signs[0] * joint.length, 0.5 * signs[1] * joint.height
    return gap.cosine * half_length - gap.sine * half_height, gap.sine * half_length + gap.cosine * half_height


@kernel
def _corner(joint, gap, offsets, state, number):
    x, y = corner_position(joint, gap, CORNERS[number])
    relative_spin, side = gap.spin_distal - gap.spin_proximal, CORNERS[number][1]
    depth = side * (gap.y + y) - 0.5 * joint.height - joint.clearance
    rate = side * (gap.vy + relative_spin * x)
    slip = -side * (gap.vx - relative_spin * y)
    if state.mode[offsets.contact + number] == FREE:
        zero = as_type_of(0.0, depth)  # the speed is that of the gap: sliding along the wall does not change it
        return Corner(zero, zero, x, y, separate_contact(depth, rate, abs(rate)))
    corner_offsets = contract.repeated_offsets(offsets, number, (joint.law, joint.friction))
    contact = pressed_contact_at(joint, SurfaceMotion(depth, rate, slip), corner_offsets, state)
    return Corner(-side * contact.tangential, -side * contact.normal, x, y, contact)


@inlined
def with_resultant(a, b, c, d):
    """Return the Contacts of a guide, those of its corners and their resultant, from those of the corners."""
    transverse = a.normal + b.normal - c.normal - d.normal  # N, on the wall on the left
    axial = a.tangential + b.tangential - c.tangential - d.tangential
    zero = as_type_of(0.0, transverse)
    resultant = reported_contact(where(transverse < 0.0, -transverse, transverse), zero, zero)
    return a, b, c, d, resultant._replace(tangential=where(transverse < 0.0, -axial, axial))


@contract.load_histories.member(Guide)
def _load_histories_guide(joint, load):
    resultant = load.contacts[4]
    return resultant.normal, resultant.tangential


@contract.load.member(Guide)
def _load_guide(joint, gap, offsets, state):
    a, b, c, d = [_corner(joint, gap, offsets, state, number) for number in range(4)]
    axial, transverse = a.fx + b.fx + c.fx + d.fx, a.fy + b.fy + c.fy + d.fy
    block_moment = _corner_moment(a) + _corner_moment(b) + _corner_moment(c) + _corner_moment(d)
    contacts = with_resultant(a.contact, b.contact, c.contact, d.contact)
    return load_along_axis(gap, axial, transverse, block_moment, contacts)


def deepest_corner(joint: Guide, gap: GuideGap) -> float:
    """Return the largest penetration (m) of a block's corners, negative if none touches."""
    return max(
        sign * (gap.y + 0.5 * (gap.sine * axial * joint.length + gap.cosine * sign * joint.height))
        - 0.5 * joint.height
        - joint.clearance
        for axial, sign in CORNERS
    )


@inlined
def _corner_moment(corner):
    return corner.x * corner.fy - corner.y * corner.fx


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


@contract.grips_of.member(Guide)
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


@contract.slip_rate.member(WallGrip)
def _slip_rate_wall_grip(grip, acceleration):
    height = grip.fractions[0] * grip.heights[0] + grip.fractions[1] * grip.heights[1]
    return grip.drift - grip.sign * (acceleration.ax - height * (acceleration.distal - acceleration.proximal))


@contract.with_tangential.member(WallGrip)
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
            corner_contact._replace(tangential=tangential, stopping_force=plain(corner_stopping_force)),
            *contacts[corner + 1 :],
        )
    gap, axial, block_moment = grip.gap, -grip.sign * force_change, grip.sign * moment
    return contract.Load(
        fx=load.fx + gap.axis_x * axial,
        fy=load.fy + gap.axis_y * axial,
        moment_proximal=load.moment_proximal + (gap.y * axial - block_moment),
        moment_distal=load.moment_distal + block_moment,
        contacts=with_resultant(contacts[0], contacts[1], contacts[2], contacts[3]),
    )


never_wears(Guide)
