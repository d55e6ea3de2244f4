"""Effects of the whole mechanism's inertia on its joints: effective mass of an impact, force of sticking surfaces."""

from ...tracing.compiled.choosing import none_of, replaced, where
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import family_with_default, inlined, kernel, known
from ..joints import contract
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
def _law_needs_mass(joint, offsets, state):
    """Return whether the law of a joint needs the effective mass in its current state."""
    return False


@_law_needs_mass.member(Joint, Lubricated, WornJoint, WornOnFoundation)
def _law_needs_mass_of_joint(joint, offsets, state):
    law = contract.with_current_state(joint.law, state.y, state.latched, offsets)
    return touches(state.mode[offsets.contact]) and needs_mass(law)


@_law_needs_mass.member(Mesh)
def _law_needs_mass_of_mesh(joint, offsets, state):
    is_needed = False
    for flank in range(2):
        at_flank = flank_offsets(joint, offsets, flank)
        law = contract.with_current_state(joint.law, state.y, state.latched, at_flank)
        is_needed = is_needed | (touches(state.mode[at_flank.contact]) and needs_mass(law))
    return is_needed


@family_with_default
def _with_mass(joint, mass):
    """Return the joint with the effective mass (kg) of its contact set in its law."""
    return joint


@_with_mass.member(Joint, WornJoint, WornOnFoundation, Lubricated, Mesh)
def _with_mass_in_law(joint, mass):
    return joint._replace(law=with_mass(joint.law, mass))


@inlined
def _joints_with(joints, masses):
    return tuple([_with_mass(joint, mass) for joint, mass in zip(joints, masses, strict=True)])


@kernel
def joints_with_mass(scene, pose, joint_gaps, state):
    """Return the joints of a scene; laws that need the effective mass in this JointState and pose get it."""
    if not _may_need_mass(scene.joints):
        return scene.joints
    is_needed = False
    for joint, offsets in zip(scene.joints, contract.offsets_of(scene.joints, state.roots), strict=True):
        is_needed = is_needed | _law_needs_mass(joint, offsets, state)
    if none_of(is_needed):
        return _joints_with(scene.joints, [as_type_of(0.0, gap.x) for gap in joint_gaps])
    masses = list(zip(impact_masses(scene.mechanism, pose, joint_gaps), joint_gaps, strict=True))
    return _joints_with(scene.joints, [as_type_of(mass, gap.x) for mass, gap in masses])


@kernel
def joints_at_event(scene, y):
    """Return the joints of a scene, with the effective mass at the state `y` set in every law that may need it."""
    if not _may_need_mass(scene.joints):
        return scene.joints
    pose = pose_at(scene.mechanism, y)
    return _joints_with(scene.joints, impact_masses(scene.mechanism, pose, gaps(scene.mechanism, pose)))


@known
def _may_need_mass(joints):
    """Return whether any law of the joints may need the effective mass of its contact."""
    return any(type(law) in with_mass.members for _, law in contract.every_part(joints))


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
def every_grip(joints, joint_gaps, loads, mode):
    """Return the grips of each joint of the tuple `joints` under the loads; joint_gaps : of the joints."""
    items = list(zip(joints, joint_gaps, loads, contract.offsets_of(joints, 0), strict=True))
    return tuple([contract.grips_of(joint, gap, load, mode, offsets.contact) for joint, gap, load, offsets in items])


@kernel
def _with_grip_forces(grips_of_joints, loads, forces, stopping_forces):
    """Return the Loads with the tangential forces (N) of all grips, and those that would stop the sliding."""
    first, changed_loads = 0, ()
    for grips, load in zip(grips_of_joints, loads, strict=True):
        changed_load = load
        for i, grip in enumerate(grips, first):
            changed_load = contract.with_tangential(grip, changed_load, forces[i], stopping_forces[i])
        first, changed_loads = first + len(grips), (*changed_loads, changed_load)
    return changed_loads


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
    items = list(zip(grips, gap_accelerations(scene.mechanism, y, motion), strict=True))
    return tuple(
        [contract.slip_rate(grip, acceleration) for grips_of_joint, acceleration in items for grip in grips_of_joint]
    )


@kernel
def _limit(grip, mode):
    any_sticking = False
    for contact in grip.contacts:
        any_sticking = any_sticking | is_sticking(mode[contact])
    return grip.limit if any_sticking else as_type_of(0.0, grip.limit)


@kernel
def _gains_of(limit, i, scene, y, pose, grips, loads, forces, rates):
    """Return the change of the rate of every sliding speed per force of grip `i`; zeros if that does not stick.

    grips : per joint; forces : N, of every grip; rates : m/s^2, under these loads.
    """
    if limit == 0.0:
        return tuple([as_type_of(0.0, rate) for rate in rates])
    force_increment = abs(plain(limit)) + MIN_FORCE_INCREMENT
    more_forces = replaced(forces, i, forces[i] + force_increment)
    more_loads = _with_grip_forces(grips, loads, more_forces, more_forces)
    loaded_rates = slip_rates(scene, y, pose, grips, more_loads)
    return tuple([(loaded - base) / force_increment for loaded, base in zip(loaded_rates, rates, strict=True)])


@kernel
def with_sticking_forces(scene, y, pose, joint_gaps, loads, mode):
    """Return the loads with tangential forces that let the sliding speed of sticking joints decay.

    The decay rate is `scene.reference_rate`, because the remaining speed is within the band and negligible.  Grips in
    a mode at their limit have that force; their contacts also contain the force that would stop the sliding.
    """
    if not any(type(joint.friction) in static_limit.members for joint in scene.joints if hasattr(joint, "friction")):
        return loads
    grips_of_joints, sticking_count = every_grip(scene.joints, joint_gaps, loads, mode), 0
    for j in range(contract.total_counts(scene.joints).contact):
        sticking_count += is_sticking(mode[j])
    if sticking_count == 0:
        return loads
    grips = flatten_once(grips_of_joints)
    limit_signs = [limit_sign(grip, mode) for grip in grips]
    limits, slips = [_limit(grip, mode) for grip in grips], [grip.slip for grip in grips]
    signs_and_grips = list(zip(limit_signs, grips, strict=True))
    forces = tuple([where(sign != 0.0, sign * grip.limit, grip.force) for sign, grip in signs_and_grips])
    loads = _with_grip_forces(grips_of_joints, loads, forces, forces)
    rates = slip_rates(scene, y, pose, grips_of_joints, loads)
    inputs = scene, y, pose, grips_of_joints, loads, forces, rates
    gains = [_gains_of(limit, i, *inputs) for i, limit in enumerate(limits)]
    for _ in range(MAX_SWEEPS if sticking_count > 1 else 1):
        largest_change = 0.0
        for j in range(len(limits)):
            if (limits[j] != 0.0) & (limit_signs[j] == 0.0):
                force_change = (-scene.reference_rate * slips[j] - rates[j]) / gains[j][j]
                largest_change = max(largest_change, abs(force_change / limits[j]))
                rates = tuple([rate + gain * force_change for rate, gain in zip(rates, gains[j], strict=True)])
                forces = replaced(forces, j, forces[j] + force_change)
        if largest_change < FORCE_TOLERANCE:
            break
    stopping_forces = forces
    for j in range(len(limits)):
        if limits[j] != 0.0:
            stopping_change = (-scene.reference_rate * slips[j] - rates[j]) / gains[j][j]
            stopping_forces = replaced(stopping_forces, j, forces[j] + stopping_change)
    return _with_grip_forces(grips_of_joints, loads, forces, stopping_forces)


@kernel
def limit_sign(grip, mode):
    """Return 1 or -1 if the force of a grip is at its upper or lower limit, or 0 if it follows from the motion.

    Corners on one wall share their force, so they reach its limit together.
    """
    sign = 0.0
    for contact in grip.contacts:
        sign += where(mode[contact] == AT_LIMIT_UP, 1.0, 0.0) - where(mode[contact] == AT_LIMIT_DOWN, 1.0, 0.0)
    return min(max(sign, -1.0), 1.0)
