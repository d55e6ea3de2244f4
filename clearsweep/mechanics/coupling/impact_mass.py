"""The effective mass (kg) of an impact at a contact, for the laws that use it."""

from ...tracing.compiled.choosing import none_of
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import family, inlined, kernel, known, map_joints
from ..joints.contract import after_joint, after_number, every_part, first_offsets, with_current_state
from ..joints.dry import Joint
from ..joints.lubricated import Lubricated
from ..joints.worn import WornJoint, WornOnFoundation
from ..laws.contract import touches
from ..laws.loss import needs_mass, with_mass
from ..machines.contract import gaps, impact_masses, pose_at


@family
def _joint_law_needs_mass(joint, gap, offsets, state):
    """Return whether the law of a joint needs the effective mass in its current state."""


@_joint_law_needs_mass.member(None)
def _default_joint_law_needs_mass(joint, gap, offsets, state):
    return False


@_joint_law_needs_mass.member(Joint)
@_joint_law_needs_mass.member(Lubricated)
@_joint_law_needs_mass.member(WornJoint)
@_joint_law_needs_mass.member(WornOnFoundation)
def _joint_law_needs_mass_of_joint(joint, gap, offsets, state):
    law = with_current_state(joint.law, state.y, state.latched, offsets)
    return touches(state.mode[offsets.contact]) and needs_mass(law)


@family
def _with_mass(joint, mass, offsets, shared):
    """Return the joint with the effective mass (kg) of its contact set in its law."""


@_with_mass.member(None)
def _default_with_mass(joint, mass, offsets, shared):
    return joint


@_with_mass.member(Joint)
@_with_mass.member(WornJoint)
@_with_mass.member(WornOnFoundation)
@_with_mass.member(Lubricated)
def _with_mass_in_law(joint, mass, offsets, shared):
    return joint._replace(law=with_mass(joint.law, mass))


@inlined
def _joint_needs_mass(joint, gap, offsets, state):
    return _joint_law_needs_mass(joint, gap, offsets, state)


@inlined
def _joint_with_mass(joint, mass, offsets, shared):
    return _with_mass(joint, mass, offsets, shared)


@inlined
def _mass_like(mass, gap, offsets, shared):
    return as_type_of(mass, gap.x)


@inlined
def _zero_mass(gap, _, offsets, shared):
    return as_type_of(0.0, gap.x)


_all_need_mass = map_joints(_joint_needs_mass, after_joint)
_all_with_mass = map_joints(_joint_with_mass, after_number)
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
