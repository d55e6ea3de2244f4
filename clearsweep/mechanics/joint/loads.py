"""The loads of all joints of a scene, and the rates of what their laws remember."""

from numba.extending import overload

from ..compiled.dual import alike, told
from ..compiled.family import OPTIONS
from .dry import FREE, joint_load, remembering, remembers, width
from .internal_state import memory, memory_rate, recalled


def loads_of(joints, relative, y, first, place, state, onset, j):
    """Return one Load per joint of the tuple `joints`.

    `first`, `place` : where in `y` the roots of penetration begin, and what the laws of the first of them remember.
    """
    if len(joints) == 0:
        return ()
    root, joint = y[first + j], remembering(joints[0], y, place)
    load = joint_load(joint, relative[0], state[j], root * abs(root), onset[j])
    return (load, *loads_of(joints[1:], relative[1:], y, first, place + width(joint), state, onset, j + 1))


@overload(loads_of, strict=False, jit_options=dict(OPTIONS))
def _loads_of(joints, relative, y, first, place, state, onset, j):
    if len(joints) == 1:

        def last(joints, relative, y, first, place, state, onset, j):
            root = y[first + j]
            joint = remembering(joints[0], y, place)
            return (joint_load(joint, relative[0], state[j], root * abs(root), onset[j]),)

        return last

    def more(joints, relative, y, first, place, state, onset, j):
        root = y[first + j]
        joint = remembering(joints[0], y, place)
        load = joint_load(joint, relative[0], state[j], root * abs(root), onset[j])
        rest = loads_of(joints[1:], relative[1:], y, first, place + width(joint), state, onset, j + 1)
        return (load,) + rest  # noqa: RUF005

    return more


def remember(joints, loads, y, kappa, state, out, place, j):
    """Put the rates of what the laws of `joints` remember into `out`, from `place` on, or their slopes."""
    if len(joints) > 0:
        joint, friction = joints[0], place + len(memory(joints[0].law))
        slip = loads[0].slip if state[j] != FREE else alike(0.0, loads[0].slip)  # at rest nothing changes
        if friction > place:
            out[place] = told(kappa * memory_rate(recalled(joint.law, y, place), slip))
        if place + width(joint) > friction:
            out[friction] = told(kappa * memory_rate(recalled(joint.friction, y, friction), slip))
        remember(joints[1:], loads[1:], y, kappa, state, out, place + width(joint), j + 1)


@overload(remember, strict=False, jit_options=dict(OPTIONS))
def _remember(joints, loads, y, kappa, state, out, place, j):
    if any(map(remembers, joints)):
        return remember
    return lambda joints, loads, y, kappa, state, out, place, j: None
