"""Where journals, blocks and flanks are at the start of a run, and whether they can be there."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...contracts.case import STOPS_SUFFIX, Case
from ...contracts.machine import Machine
from ...language.errors import InputError
from ...language.wording import quantity_text
from ...mechanics.joints.contract import contact_modes, every_contact
from ...mechanics.joints.guide import Guide as GuideTerm
from ...mechanics.joints.guide import deepest_corner
from ...mechanics.joints.mesh import COAST, DRIVE, Mesh
from ...mechanics.joints.rolling import Rolling, cage_angle, element_approaches, static_position
from ...mechanics.joints.slot import SlotJoint, WornSlot
from ...mechanics.joints.slot import normal_of as slot_normal_of
from ...mechanics.joints.worn import with_body_angles
from ...mechanics.laws.elastic import static_penetration
from ...mechanics.machines import planar
from ...mechanics.machines.contract import Built, body_angles, gaps, pose_at
from ...mechanics.machines.spatial import initial_seats

SLOT_ROUNDING = 1e-9  # of its length: rounding of a stroke that just fits
TOUCHING = 1e-14  # of the mechanism's size: rounding of the penetration of bodies that touch at the start
LARGEST_TWIST = 0.1  # rad, by which flanks may overlap at the start: more is an angle of another tooth


def with_elements_at_start(case: Case, built: Built, terms: tuple, depth_roots: np.ndarray) -> tuple[tuple, np.ndarray]:
    """Return the joints with the phases of rolling bearings, and the roots of penetrations with those of elements.

    The first element of a bearing starts where the grid says.
    """
    phased, roots, first = list(terms), depth_roots.copy(), 0
    relative = with_body_angles(
        terms, gaps(built.value, pose_at(built.value, built.start)), body_angles(built.value, built.start)
    )
    for index, (term, joint, gap) in enumerate(zip(terms, case.joints, relative, strict=True)):
        count = len(contact_modes(term))
        if joint.rolling:
            angle, side = joint.rolling.phase, term.side
            phased[index] = term._replace(phase=angle - float(cage_angle(term, gap) - term.phase))
            approaches = element_approaches(term, side * gap.x, side * gap.y, angle)
            touching = np.where(approaches > TOUCHING * built.size, approaches, 0.0)
            roots[first : first + joint.rolling.elements] = np.sqrt(touching)
        first += count
    return tuple(phased), roots


def check_spatial_start(built: Built, joints: Mapping[str, Any]) -> None:
    """Raise InputError if a spatial journal starts outside its bearing or penetrates it."""
    for name, contact in initial_seats(built, joints).items():
        if contact.overlap <= 0.0:
            raise InputError(
                f"joints.{name}: the journal is {-1e3 * contact.overlap:.6g} mm outside its bearing along the axis at "
                "the start; reduce offset.2, or give bearing or journal more length"
            )
        if contact.depth > 0.0:
            raise InputError(
                f"joints.{name}: the journal penetrates its bearing by {1e6 * contact.depth:.6g} um at the start; "
                "reduce tilt or offset, or widen the clearances"
            )


def check_planar_start(built: Built, joints: Mapping[str, Any]) -> None:
    """Raise InputError if the bodies of a planar joint penetrate at the start."""
    relative = gaps(built.value, pose_at(built.value, built.start))
    for (name, joint), gap in zip(joints.items(), relative, strict=True):
        if isinstance(joint, GuideTerm):
            depth = deepest_corner(joint, gap)
        elif isinstance(joint, Rolling):
            approaches = element_approaches(joint, joint.side * gap.x, joint.side * gap.y, joint.phase)
            depth = float(approaches.max()) + min(joint.radial_clearance, 0.0)
        elif isinstance(joint, (SlotJoint, WornSlot)):
            depth = slot_normal_of(joint, gap).depth
        elif isinstance(joint, Mesh):
            continue
        else:
            depth = math.hypot(gap.x, gap.y) - joint.clearance
        if depth > TOUCHING * built.size:
            raise InputError(
                f"joints.{name}: its bodies penetrate each other by {1e6 * depth:.6g} um at the start; change "
                "`initial` of a body that it joins, or widen the clearance"
            )


def press_flanks(built: Built, joints: Mapping[str, Any], depth_roots: np.ndarray) -> None:
    """Write the roots of the depths of flanks that touch at the start; raise InputError if they are far too deep."""
    relative, contact = gaps(built.value, pose_at(built.value, built.start)), 0
    for (name, joint), gap in zip(joints.items(), relative, strict=True):
        if isinstance(joint, Mesh):
            for side in (DRIVE, COAST):
                depth = side * (gap.x - joint.middle) - gap.wider - joint.reach
                if name.endswith(STOPS_SUFFIX) and depth > TOUCHING * built.size:
                    raise InputError(
                        f"joints.{name.removesuffix(STOPS_SUFFIX)}.stops.at: the joint starts at {gap.x:.6g}, "
                        f"{depth:.6g} beyond a stop (rad or m); move the stop, or change where the motion starts"
                    )
                if depth > LARGEST_TWIST * min(joint.arm_proximal, abs(joint.arm_distal)):
                    angles = quantity_text(gap.x / joint.arm_distal, "rad", 4)
                    raise InputError(
                        f"joints.{name}: its flanks overlap at the start, where the second body is {angles} from the "
                        "middle of the play; change `initial` of a body that it joins. The middle is where the "
                        "first angle plus ratio times the second is 0; in a coupling both angles are equal there"
                    )
                depth_roots[contact + (side == COAST)] = math.sqrt(max(depth, 0.0))
        contact += len(contact_modes(joint))


def check_slot_lengths(case: Case, machine: Machine) -> None:
    """Raise InputError if a drive of prescribed speed takes a pin beyond the ends of its slot; a free crank stops."""
    if case.outline.free:
        return
    for joint in case.joints:
        if joint.slot_length is None:
            continue
        travel = planar.slot_travel(machine, joint.name)
        reach = float(np.max(np.abs(travel), initial=0.0))
        if 2.0 * reach > (joint.slot_length + 2.0 * joint.clearance) * (1.0 + SLOT_ROUNDING):
            lengths = float(np.ptp(travel)), reach, 2.0 * reach, joint.slot_length
            stroke, reach_text, needed, given = (quantity_text(length, "m", 4) for length in lengths)
            raise InputError(
                f"joints.{joint.name}.slot_length: found {given}, but the pin's stroke is {stroke}, up to {reach_text} "
                f"from the slot's middle; write at least {needed}, or shorten the stroke"
            )


def seated_offsets(reactions: Mapping[str, np.ndarray], joints: Mapping[str, Any]) -> tuple[dict, np.ndarray]:
    """Return the initial offset (m) of each joint's distal pin and the roots of the penetrations.

    The pin is displaced along the load (N) of the ideal mechanism to static penetration; the roots of the elements of
    a rolling bearing are left 0.
    """
    offsets: dict[str, Any] = {}
    depth_roots, first = np.zeros(len(every_contact(joints.values()))), 0
    for name, joint in joints.items():
        first += len(contact_modes(joint))
        if name.endswith(STOPS_SUFFIX):
            offsets[name] = (0.0, 0.0)
            continue
        force = reactions[name]
        load = float(np.hypot(*force))
        if load == 0.0:
            raise InputError(f"simulate.start: seated needs a load, but {name} carries none at t = 0; use centred")
        if isinstance(joint, Rolling):
            offsets[name] = joint.side * np.array(static_position(joint, tuple(-joint.side * force), joint.phase))
        elif isinstance(joint, Mesh):  # its roots follow from the angles
            offsets[name] = (joint.clearance + static_penetration(joint.elastic, load)) * force / joint.arm_proximal
            offsets[name] /= load
        else:
            depth = static_penetration(joint.elastic, load)
            depth_roots[first - len(contact_modes(joint))] = math.sqrt(depth)
            offsets[name] = -(joint.clearance + depth) * force / load
    return offsets, depth_roots
