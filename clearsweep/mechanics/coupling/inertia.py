"""Effects of the whole mechanism's inertia on its joints: effective mass of an impact, force of sticking surfaces."""

from typing import NamedTuple

from ...tracing.compiled.choosing import none_of, where
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import family_with_default, inlined, kernel, known, map_joints
from ..joints.contract import (
    after_joint,
    after_number,
    every_part,
    first_offsets,
    grips_of,
    slip_rate,
    total_counts,
    with_current_state,
    with_tangential,
)
from ..joints.dry import Joint
from ..joints.lubricated import Lubricated
from ..joints.mesh import Mesh, flank_offsets
from ..joints.worn import WornJoint, WornOnFoundation
from ..laws.contract import AT_LIMIT_DOWN, AT_LIMIT_UP, is_sticking, touches
from ..laws.friction import static_limit
from ..laws.loss import needs_mass, with_mass
from ..machines.contract import accelerate, gap_accelerations, gaps, impact_masses, pose_at

# ---------------------------------------------------------------------------------------------- effective mass


@family_with_default
def _joint_law_needs_mass(joint, gap, offsets, state):
    """Return whether the law of a joint needs the effective mass in its current state."""
    return False


@_joint_law_needs_mass.member(Joint, Lubricated, WornJoint, WornOnFoundation)
def _joint_law_needs_mass_of_joint(joint, gap, offsets, state):
    law = with_current_state(joint.law, state.y, state.latched, offsets)
    return touches(state.mode[offsets.contact]) and needs_mass(law)


@_joint_law_needs_mass.member(Mesh)
def _joint_law_needs_mass_of_mesh(joint, gap, offsets, state):
    is_needed = False
    for flank in range(2):
        at_flank = flank_offsets(joint, offsets, flank)
        law = with_current_state(joint.law, state.y, state.latched, at_flank)
        is_needed = is_needed | (touches(state.mode[at_flank.contact]) and needs_mass(law))
    return is_needed


@family_with_default
def _with_mass(joint, mass, offsets, shared):
    """Return the joint with the effective mass (kg) of its contact set in its law."""
    return joint


@_with_mass.member(Joint, WornJoint, WornOnFoundation, Lubricated, Mesh)
def _with_mass_in_law(joint, mass, offsets, shared):
    return joint._replace(law=with_mass(joint.law, mass))


@inlined
def _mass_like(mass, gap, offsets, shared):
    return as_type_of(mass, gap.x)


@inlined
def _zero_mass(gap, _, offsets, shared):
    return as_type_of(0.0, gap.x)


_all_need_mass = map_joints(_joint_law_needs_mass, after_joint)
_all_with_mass = map_joints(_with_mass, after_number)
_masses_like = map_joints(_mass_like, after_number)
_zero_masses = map_joints(_zero_mass, after_number)


@inlined
def _joints_with_needed_mass(scene, pose, joint_gaps, state):
    is_needed = False
    for joint_needs_mass in _all_need_mass(scene.joints, joint_gaps, first_offsets(scene.joints, state.roots), state):
        is_needed = is_needed | joint_needs_mass
    if none_of(is_needed):
        return _all_with_mass(scene.joints, _zero_masses(joint_gaps, joint_gaps, 0, 0), 0, 0)
    masses = _masses_like(impact_masses(scene.mechanism, pose, joint_gaps), joint_gaps, 0, 0)
    return _all_with_mass(scene.joints, masses, 0, 0)


@inlined
def _joints_at_event(scene, y):
    pose = pose_at(scene.mechanism, y)
    return _all_with_mass(scene.joints, impact_masses(scene.mechanism, pose, gaps(scene.mechanism, pose)), 0, 0)


@kernel
def joints_with_mass(scene, pose, joint_gaps, state):
    """Return the joints of a scene; laws that need the effective mass in this JointState and pose get it."""
    return _joints_with_needed_mass(scene, pose, joint_gaps, state) if _may_need_mass(scene.joints) else scene.joints


@kernel
def joints_at_event(scene, y):
    """Return the joints of a scene, with the effective mass at the state `y` set in every law that may need it."""
    return _joints_at_event(scene, y) if _may_need_mass(scene.joints) else scene.joints


@known
def _may_need_mass(joints):
    """Return whether any law of the joints may need the effective mass of its contact."""
    return any(type(law) in with_mass.members for _, law in every_part(joints))


# ---------------------------------------------------------------------------------------------- sticking surfaces

# Sticking surfaces: the tangential force that stops sliding, computed from the mechanism.
#
# Accelerations are affine in the tangential forces.  One evaluation of the motion, and one more for each grip of the
# joints, give the change of all sliding speeds with all tangential forces.  Each force is then solved for in turn until
# nothing changes: Gauss-Seidel.  The matrix is symmetric and positive definite because these forces do work on exactly
# these sliding speeds.
#
# If a force reaches its static limit, an event (`laws.friction`) changes the mode of its contact.  From then on
# the limit acts, until the force that would stop the sliding is smaller again.  So within a step nothing is clipped.


MAX_SWEEPS = 100  # over the grips that stick; coupling between joints is weak, so a dozen suffice
MIN_FORCE_INCREMENT = 1.0  # N, least additional force with which rates per force are computed
FORCE_TOLERANCE = 1e-15  # of the largest force of the surfaces


@kernel
def _gap_and_load(gap, load, index, shared):
    return gap, load


@kernel
def _grips_of_joint(joint, gap_and_load, index, mode):
    return grips_of(joint, gap_and_load[0], gap_and_load[1], mode, index.contact)


_gaps_and_loads = map_joints(_gap_and_load, after_number)  # of two tuples, item by item
_grips_of_joints = map_joints(_grips_of_joint, after_joint)


@kernel
def every_grip(joints, joint_gaps, loads, mode):
    """Return the grips of each joint of the tuple `joints` under the loads; joint_gaps : of the joints."""
    return _grips_of_joints(joints, _gaps_and_loads(joint_gaps, loads, 0, 0), first_offsets(joints, 0), mode)


@kernel
def _after_grips(index, grips):
    return index + len(grips)


@kernel
def _with_grip_forces(grips, load, index, shared):
    forces, stopping_forces = shared
    for i in range(len(grips)):
        load = with_tangential(grips[i], load, forces[index + i], stopping_forces[index + i])
    return load


@kernel
def _slip_rates_of_joint(grips, acceleration, index, shared):
    rates = ()
    for i in range(len(grips)):
        rates = (*rates, slip_rate(grips[i], acceleration))
    return rates


_loads_with_grip_forces = map_joints(_with_grip_forces, _after_grips)
_slip_rates_of_joints = map_joints(_slip_rates_of_joint, after_number)


@kernel
def flatten_once(tuples):
    """Return the items of a tuple of tuples as one tuple."""
    items = ()
    for group in tuples:
        items = (*items, *group)
    return items


@kernel
def slip_rates(scene, y, pose, grips, loads):
    """Return the rate (m/s^2) of the sliding speed of every grip under the loads; grips : per joint."""
    motion = accelerate(scene.mechanism, pose, loads)
    return flatten_once(_slip_rates_of_joints(grips, gap_accelerations(scene.mechanism, y, motion), 0, 0))


@kernel
def _limit_sign(grip, _, index, mode):
    return limit_sign(grip, mode)


@kernel
def _force(grip, limit_sign, index, shared):
    return where(limit_sign != 0.0, limit_sign * grip.limit, grip.force)


@kernel
def _limit(grip, _, index, mode):
    return grip.limit if is_grip_sticking(grip, mode) else as_type_of(0.0, grip.limit)


@kernel
def _slip(grip, _, index, shared):
    return grip.slip


@kernel
def _per_force(loaded_rate, base_rate, index, force):
    return (loaded_rate - base_rate) / force


@kernel
def _zero_rate(_, base, index, shared):
    return as_type_of(0.0, base)


@kernel
def _changed_rate(rate, gain, index, change):
    return rate + gain * change


@kernel
def _force_or_replacement(_, force, index, shared):
    j, value = shared
    return value if index == j else force


_limit_signs = map_joints(_limit_sign, after_number)
_forces = map_joints(_force, after_number)  # of grips, and their sides
_limits, _slips = map_joints(_limit, after_number), map_joints(_slip, after_number)
_rates_per_force = map_joints(_per_force, after_number)  # of rates with and without an additional force, and that force
_zero_rates = map_joints(_zero_rate, after_number)
_changed_rates = map_joints(_changed_rate, after_number)  # of rates, rates per force, and the additional force
_replace_one_force = map_joints(_force_or_replacement, after_number)  # of grips, forces, and (the grip, its force)


class GainInputs(NamedTuple):
    """Inputs of the rates per force of the grips."""

    scene: tuple
    y: tuple  # state vector
    pose: tuple
    grips: tuple  # per joint
    loads: tuple
    forces: tuple  # N, of every grip
    rates: tuple  # m/s^2, under these loads


@kernel
def _gain(limit, force, index, inputs):
    if limit == 0.0:
        return _zero_rates(inputs.rates, inputs.rates, 0, 0)
    force_increment = abs(plain(limit)) + MIN_FORCE_INCREMENT
    changed_forces = _replace_one_force(inputs.forces, inputs.forces, 0, (index, force + force_increment))
    loads = _loads_with_grip_forces(inputs.grips, inputs.loads, 0, (changed_forces, changed_forces))
    rates = slip_rates(inputs.scene, inputs.y, inputs.pose, inputs.grips, loads)
    return _rates_per_force(rates, inputs.rates, 0, force_increment)


_gains = map_joints(_gain, after_number)


@kernel
def with_sticking_forces(scene, y, pose, joint_gaps, loads, mode):
    """Return the loads with tangential forces that let the sliding speed of sticking joints decay.

    The decay rate is `scene.reference_rate`, because the remaining speed is within the band and negligible.  Grips in
    a mode at their limit have that force; their contacts also contain the force that would stop the sliding.
    """
    if not any(type(joint.friction) in static_limit.members for joint in scene.joints if hasattr(joint, "friction")):
        return loads
    grips_of_joints, sticking_count = every_grip(scene.joints, joint_gaps, loads, mode), 0
    for j in range(total_counts(scene.joints).contact):
        sticking_count += is_sticking(mode[j])
    if sticking_count == 0:
        return loads
    grips = flatten_once(grips_of_joints)
    limit_signs = _limit_signs(grips, grips, 0, mode)
    limits = _limits(grips, grips, 0, mode)
    slips = _slips(grips, grips, 0, 0)
    forces = _forces(grips, limit_signs, 0, 0)
    loads = _loads_with_grip_forces(grips_of_joints, loads, 0, (forces, forces))
    rates = slip_rates(scene, y, pose, grips_of_joints, loads)
    gains = _gains(limits, forces, 0, GainInputs(scene, y, pose, grips_of_joints, loads, forces, rates))
    for _ in range(MAX_SWEEPS if sticking_count > 1 else 1):
        largest_change = 0.0
        for j in range(len(limits)):
            if (limits[j] == 0.0) | (limit_signs[j] != 0.0):
                continue
            force_change = (-scene.reference_rate * slips[j] - rates[j]) / gains[j][j]
            largest_change = max(largest_change, abs(force_change / limits[j]))
            rates = _changed_rates(rates, gains[j], 0, force_change)
            forces = _replace_one_force(forces, forces, 0, (j, forces[j] + force_change))
        if largest_change < FORCE_TOLERANCE:
            break
    stopping_forces = forces
    for j in range(len(limits)):
        if limits[j] != 0.0:
            stopping_change = (-scene.reference_rate * slips[j] - rates[j]) / gains[j][j]
            stopping_forces = _replace_one_force(stopping_forces, stopping_forces, 0, (j, forces[j] + stopping_change))
    return _loads_with_grip_forces(grips_of_joints, loads, 0, (forces, stopping_forces))


# ---------------------------------------------------------------------------------------------- grips


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
