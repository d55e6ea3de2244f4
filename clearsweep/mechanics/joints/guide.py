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
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import inlined, kernel, map_joints
from ..laws.contract import ACTS, CLIPPED, FREE, PRESSED
from ..laws.friction import friction_force
from ..laws.loss import contact_force, lowest_force, sign_past_separation
from .contract import Contact, ContactModes, Load, Offsets, Part, contact_modes, load, load_histories, parts
from .dry import Clip
from .offsets import after_law, after_number, with_current_state

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
    contact: Contact


class _Signs(NamedTuple):
    length: float
    height: float


class _BlockContext(NamedTuple):
    """Data that all corners share."""

    joint: tuple
    gap: GuideGap
    offsets: tuple  # Offsets of the joint
    state: tuple  # JointState


_SIGNS = tuple(_Signs(*corner) for corner in CORNERS)


@contact_modes.member(Guide)
def _contact_modes_guide(joint):
    return (
        ContactModes(FREE, PRESSED),
        ContactModes(FREE, PRESSED),
        ContactModes(FREE, PRESSED),
        ContactModes(FREE, PRESSED),
        ContactModes(ACTS, ACTS),
    )


@parts.member(Guide)
def _parts_guide(joint):
    return (
        Part(Clip(), 0),
        Part(joint.law, 0),
        Part(joint.friction, 0),
        Part(Clip(), 1),
        Part(joint.law, 1),
        Part(joint.friction, 1),
        Part(Clip(), 2),
        Part(joint.law, 2),
        Part(joint.friction, 2),
        Part(Clip(), 3),
        Part(joint.law, 3),
        Part(joint.friction, 3),
    )


@inlined
def corner_position(joint, gap, signs):
    """Return the position (m) of a corner from the block's point in the frame of the walls, by its signs (CORNERS)."""
    half_length, half_height = 0.5 * signs[0] * joint.length, 0.5 * signs[1] * joint.height
    return gap.cosine * half_length - gap.sine * half_height, gap.sine * half_length + gap.cosine * half_height


@kernel
def _corner_force(signs, _, corner_number, context):
    joint, gap, offsets, state = context
    x, y = corner_position(joint, gap, signs)
    relative_spin = gap.spin_distal - gap.spin_proximal
    depth = signs.height * (gap.y + y) - 0.5 * joint.height - joint.clearance
    rate = signs.height * (gap.vy + relative_spin * x)
    slip = -signs.height * (gap.vx - relative_spin * y)
    mode, contact_index = state.mode[offsets.contact + corner_number], offsets.contact + corner_number
    if mode == FREE:
        zero = as_type_of(0.0, depth)
        speed = abs(rate)  # of the gap: sliding along the wall does not change it
        no_contact = Contact(normal=zero, tangential=zero, slip=speed, rate=rate, depth=depth, elastic=zero, raw=zero)
        return Corner(zero, zero, x, y, no_contact)
    friction_offsets = after_law(
        after_law(offsets, joint.law), joint.friction
    )  # the same for each corner; clips have no numbers
    internal_count, latched_count = (
        friction_offsets.internal - offsets.internal,
        friction_offsets.latched - offsets.latched,
    )
    corner_offsets = Offsets(
        offsets.contact,
        offsets.internal + corner_number * internal_count,
        offsets.latched + corner_number * latched_count,
        offsets.guard,
    )
    law = with_current_state(joint.law, state.y, state.latched, corner_offsets)
    friction = with_current_state(joint.friction, state.y, state.latched, after_law(corner_offsets, joint.law))
    root = state.y[state.roots + contact_index]
    pen = root * abs(root)
    force, elastic = contact_force(law, joint.elastic, abs(pen), rate, state.latched[contact_index])
    lowest = lowest_force(law)
    unclipped = force - lowest
    if pen < 0.0:
        sign = sign_past_separation(law, joint.elastic)
        force, elastic = sign * force, sign * elastic
    normal = force if mode != CLIPPED else as_type_of(0.0, force)
    friction_load = normal if lowest == 0.0 else max(normal, 0.0)
    tangential = as_type_of(friction_force(friction, friction_load, slip), slip)
    contact = Contact(
        normal=normal, tangential=tangential, slip=slip, rate=rate, depth=depth, elastic=elastic, raw=unclipped
    )
    return Corner(-signs.height * tangential, -signs.height * normal, x, y, contact)


_corner_forces = map_joints(_corner_force, after_number)


@inlined
def with_resultant(a, b, c, d):
    """Return the Contacts of a guide, those of its corners and their resultant, from those of the corners."""
    transverse = a.normal + b.normal - c.normal - d.normal  # N, on the wall on the left
    axial = a.tangential + b.tangential - c.tangential - d.tangential
    zero = as_type_of(0.0, transverse)
    resultant = Contact(
        normal=where(transverse < 0.0, -transverse, transverse),
        tangential=where(transverse < 0.0, -axial, axial),
        slip=zero,
        rate=zero,
        depth=zero,
        elastic=zero,
        raw=zero,
    )
    return a, b, c, d, resultant


@load_histories.member(Guide)
def _load_histories_guide(joint, load):
    resultant = load.contacts[4]
    return resultant.normal, resultant.tangential


@load.member(Guide)
def _load_guide(joint, gap, offsets, state):
    a, b, c, d = _corner_forces(_SIGNS, _SIGNS, 0, _BlockContext(joint, gap, offsets, state))
    axial, transverse = a.fx + b.fx + c.fx + d.fx, a.fy + b.fy + c.fy + d.fy
    block_moment = _corner_moment(a) + _corner_moment(b) + _corner_moment(c) + _corner_moment(d)
    return Load(
        fx=gap.axis_x * axial - gap.axis_y * transverse,
        fy=gap.axis_y * axial + gap.axis_x * transverse,
        moment_proximal=-block_moment - gap.x * transverse + gap.y * axial,
        moment_distal=block_moment,
        contacts=with_resultant(a.contact, b.contact, c.contact, d.contact),
    )


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
