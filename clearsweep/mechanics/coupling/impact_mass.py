"""The effective mass (kg) of an impact at a contact, for the laws that use it."""

from ..compiled.choosing import none_of
from ..compiled.dual import as_type_of
from ..compiled.family import family, inlined, kernel, map_joints
from ..joint.contract import every_part
from ..joint.dry import Joint
from ..joint.loss.contract import awaits_mass, with_mass
from ..joint.lubricated import Lubricated
from ..joint.modes import touches
from ..joint.offsets import after_joint, after_number, first_place, with_current_state
from ..joint.worn import WornJoint, WornOnFoundation
from ..mechanism.contract import gaps, impact_masses, place


@family
def _awaits(joint, gap, offsets, state):
    """Return whether the law of a joint needs the effective mass in its current state."""


@_awaits.member(None)
def _never(joint, gap, offsets, state):
    return False


@_awaits.member(Joint)
@_awaits.member(Lubricated)
@_awaits.member(WornJoint)
@_awaits.member(WornOnFoundation)
def _law_awaits(joint, gap, offsets, state):
    law = with_current_state(joint.law, state.y, state.latched, offsets)
    return touches(state.mode[offsets.contact]) and awaits_mass(law)


@family
def _tell(joint, mass, offsets, shared):
    """Return the joint with the effective mass (kg) of its contact set in its law."""


@_tell.member(None)
def _as_it_is(joint, mass, offsets, shared):
    return joint


@_tell.member(Joint)
@_tell.member(WornJoint)
@_tell.member(WornOnFoundation)
@_tell.member(Lubricated)
def _with_its_law(joint, mass, offsets, shared):
    return joint._replace(law=with_mass(joint.law, mass))


@inlined
def _asks(joint, gap, offsets, state):
    return _awaits(joint, gap, offsets, state)


@inlined
def _told(joint, mass, offsets, shared):
    return _tell(joint, mass, offsets, shared)


@inlined
def _like(mass, gap, offsets, shared):
    return as_type_of(mass, gap.x)


@inlined
def _none(gap, _, offsets, shared):
    return as_type_of(0.0, gap.x)


_ask_all = map_joints(_asks, after_joint)
_tell_all = map_joints(_told, after_number)
_all_like = map_joints(_like, after_number)
_none_known = map_joints(_none, after_number)


@inlined
def _joints_told(scene, pose, relative, state):
    is_awaited = False
    for asks in _ask_all(scene.joints, relative, first_place(scene.joints, state.roots), state):
        is_awaited = is_awaited | asks
    if none_of(is_awaited):
        return _tell_all(scene.joints, _none_known(relative, relative, 0, 0), 0, 0)
    masses = _all_like(impact_masses(scene.mechanism, pose, relative), relative, 0, 0)
    return _tell_all(scene.joints, masses, 0, 0)


@inlined
def _joints_at_event(scene, y):
    pose = place(scene.mechanism, y)
    return _tell_all(scene.joints, impact_masses(scene.mechanism, pose, gaps(scene.mechanism, pose)), 0, 0)


@kernel
def joints_now(scene, pose, relative, state):
    """Return the joints of a scene; laws that need the effective mass in this JointState and pose get it."""
    return _joints_told(scene, pose, relative, state) if _ask(scene.joints) else scene.joints


@kernel
def joints_at_event(scene, y):
    """Return the joints of a scene, with the effective mass at the state `y` set in every law that may need it."""
    return _joints_at_event(scene, y) if _ask(scene.joints) else scene.joints


def _ask(joints):
    """Return whether any law of the joints may need the effective mass of its contact."""
    return any(type(law) in with_mass.members for _, law in every_part(joints))
