"""Play in rotation: teeth of two wheels between two flanks, or the halves of a coupling.

The position x is that of the first body relative to the second along the line of action, from the middle of the play
(Kahraman & Singh 1990, "Non-linear dynamics of a spur gear pair", Journal of Sound and Vibration 142).  The teeth press
on the drive flank where x exceeds half of the play, on the coast flank where -x does: two contacts, each with its own
mode, root of penetration and onset rate.  Of a coupling x is an angle and a force a torque, both at an arm of 1 m.

Where a wheel moves in its bearing, x and the play change with its displacement, to first order: the line of action
keeps its direction.  Force and moments are the derivatives of the depths, so the powers of the forces on both bodies
add up to force times rate of depth.  A viscous drag also acts without contact.
"""

from typing import NamedTuple

from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import inlined, kernel, map_joints
from ..laws.contract import ACTS, MEETS, PRESSED, touches
from ..wear.bins import never_wears
from .contract import (
    CONTACT_FIELDS,
    ContactModes,
    Load,
    Offsets,
    after_law,
    after_number,
    contact_modes,
    gap_histories,
    load,
    load_histories,
    parts,
    power_lost,
)
from .dry import SurfaceMotion, dry_parts, pressed_contact_at

DRIVE, COAST = 1.0, -1.0  # sides of the play
FLANKS = ("drive", "coast")  # their names, in the order of the contacts


class Mesh(NamedTuple):
    """Play between two flanks."""

    clearance: float  # m, half of the play along the line of action; rad for a coupling; of stops a small part of it
    side: float  # 1; other joints have a journal
    arm_proximal: float  # m, by which the angle of the first body adds to x; 1 for a coupling
    arm_distal: float  # m, likewise of the second body; below 0 if both turn in the same sense
    drag: float  # N s/m, along the line of action
    reach: float  # m or rad, half of the play
    middle: float  # m or rad, position of its middle
    law: tuple  # contact_force, of each flank
    elastic: tuple  # elastic_force
    friction: tuple  # Frictionless


class MeshGap(NamedTuple):
    """Position of the teeth, and the forces on the second centre for a unit of force on a flank, in the fixed frame."""

    x: float  # m, along the line of action
    v: float  # m/s
    wider: float  # m, by which the displacement of the centres widens both sides of the play
    widening: float  # m/s, its rate
    across_x: float  # 1, across the line of centres, of the drive flank; the coast flank has the opposite
    across_y: float
    apart_x: float  # 1, along the line of centres, of both flanks
    apart_y: float


FlankContact = NamedTuple("FlankContact", [*CONTACT_FIELDS, ("drag_power", float)])
FlankContact.__doc__ = "The observables of a flank; that of the drive flank also contains the drag, W."


class _Flank(NamedTuple):
    side: float


class _FlankContext(NamedTuple):
    """Data that both flanks share."""

    joint: tuple
    gap: MeshGap
    offsets: tuple  # Offsets of the joint
    state: tuple  # JointState


_FLANKS = _Flank(DRIVE), _Flank(COAST)


@contact_modes.member(Mesh)
def _contact_modes_mesh(joint):
    # an acting contact has located maxima: also of the position in the play, and of the power of the drag
    return ContactModes(ACTS | MEETS, PRESSED), ContactModes(ACTS | MEETS, PRESSED)


@parts.member(Mesh)
def _parts_mesh(joint):
    law, friction = joint.law, joint.friction
    return *dry_parts(0, law, friction), *dry_parts(1, law, friction)


@power_lost.member(FlankContact)
def _power_lost_at_flank(contact):
    return (contact.normal - contact.elastic) * contact.rate + contact.drag_power


@inlined
def flank_offsets(joint, offsets, flank):
    """Return the Offsets of flank number `flank`, from those of the joint."""
    following = after_law(after_law(offsets, joint.law), joint.friction)  # clips have no numbers
    return Offsets(
        offsets.contact + flank,
        offsets.internal + flank * (following.internal - offsets.internal),
        offsets.latched + flank * (following.latched - offsets.latched),
        offsets.guard,
    )


@kernel
def _flank_contact(flank, _, number, context):
    joint, gap, offsets, state = context
    depth = flank.side * (gap.x - joint.middle) - gap.wider - joint.reach
    rate = flank.side * gap.v - gap.widening
    drag_power = joint.drag * gap.v * gap.v if number == 0 else as_type_of(0.0, depth)
    zero, speed = as_type_of(0.0, depth), abs(rate)
    if not touches(state.mode[offsets.contact + number]):
        return FlankContact(zero, zero, speed, rate, depth, zero, zero, drag_power)
    contact = pressed_contact_at(joint, SurfaceMotion(depth, rate, zero), flank_offsets(joint, offsets, number), state)
    return FlankContact(contact.normal, zero, zero, rate, depth, contact.elastic, contact.raw, drag_power)


_flank_contacts = map_joints(_flank_contact, after_number)


@load.member(Mesh)
def _load_mesh(joint, gap, offsets, state):
    drive, coast = _flank_contacts(_FLANKS, _FLANKS, 0, _FlankContext(joint, gap, offsets, state))
    driving, parting = drive.normal - coast.normal + joint.drag * gap.v, drive.normal + coast.normal
    return Load(
        fx=driving * gap.across_x + parting * gap.apart_x,
        fy=driving * gap.across_y + parting * gap.apart_y,
        moment_proximal=-joint.arm_proximal * driving,
        moment_distal=-joint.arm_distal * driving,
        contacts=(drive, coast),
    )


@gap_histories.member(Mesh)
def _gap_histories_mesh(joint, gap, side):
    zero = as_type_of(0.0, gap.x)
    return gap.x, zero, gap.v, zero


@load_histories.member(Mesh)
def _load_histories_mesh(joint, load):
    drive, coast = load.contacts
    return drive.normal + coast.normal, as_type_of(0.0, drive.normal)


never_wears(Mesh)
