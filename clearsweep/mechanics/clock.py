"""How fast time goes along tau, the independent variable: see `rates`."""

import math

from numba.extending import overload

from .compiled.choosing import where
from .compiled.dual import as_type_of
from .compiled.family import OPTIONS, kernel
from .joint.contract import touches
from .joint.places import extent, room_of_all


@kernel
def clock(scene, y, mode):
    """Return kappa = dt/dtau at the state `y`, s.  A contact that does not touch has no share in 1/kappa."""
    first, contacts = 2 * len(scene.coordinates) + 1, extent(scene.joints).contact
    if contacts == 1:
        return where(touches(mode[0]), y[first] / scene.sigma, 1.0)
    return _clock_of_several(scene, y, mode)


@kernel
def _clock_of_joints(scene, y, mode):
    """Return the same where each contact parts by itself."""
    first, contacts = 2 * len(scene.coordinates) + 1, extent(scene.joints).contact
    slowness = as_type_of(0.0, y[first])
    for c in range(contacts):
        slowness = slowness + 1.0 / where(touches(mode[c]), y[first + c], math.inf)
    return 1.0 / where(slowness != 0.0, scene.sigma * slowness, 1.0)


@kernel
def clock_of_corners(scene, y, mode):
    """Return the same where contacts may part at one moment, as corners of a block do.

    Trial steps past that moment come to roots of opposite signs, between which 1/kappa goes through zero: where a root
    is as far below zero as half of another is above it, kappa goes on along its tangent.
    """
    first, contacts, nearest = 2 * len(scene.coordinates) + 1, extent(scene.joints).contact, -1
    for c in range(contacts):
        if touches(mode[c]) and (nearest < 0 or abs(y[first + c]) < abs(y[first + nearest])):
            nearest = c
    if nearest < 0:
        return 1.0
    root, others = y[first + nearest], 0.0
    for c in range(contacts):
        if touches(mode[c]) and c != nearest:
            others += root / y[first + c]
    share = 1.0 / (1.0 + others) if others > -0.5 else -4.0 * others
    return root * share / scene.sigma


def _clock_of_several(scene, y, mode):
    corners = extent(scene.joints).contact > len(scene.joints)
    return clock_of_corners(scene, y, mode) if corners else _clock_of_joints(scene, y, mode)


@overload(_clock_of_several, strict=False, jit_options=dict(OPTIONS))
def _compiled_clock_of_several(scene, y, mode):
    joints = scene.types[scene.fields.index("joints")]
    return clock_of_corners if room_of_all(joints).contact > len(joints) else _clock_of_joints
