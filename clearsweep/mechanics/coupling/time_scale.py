"""The time scale kappa = dt/dtau of the independent variable tau: see `rates`."""

from ..compiled.choosing import where
from ..compiled.dual import as_type_of
from ..compiled.family import kernel
from ..joint.modes import touches
from ..joint.offsets import extent


@kernel
def time_scale(scene, y, mode):
    """Return kappa = dt/dtau (s) at the state `y`.  Contacts that do not touch contribute nothing to 1/kappa."""
    first_root, contacts = 2 * len(scene.coordinates) + 1, extent(scene.joints).contact
    if contacts == 1:
        return where(touches(mode[0]), y[first_root] * (1.0 / scene.sigma), 1.0)
    return _clock_of_several(scene, y, mode)


@kernel
def roots_beside(scene, y, mode, contact):
    """Return the product of the roots of penetration (m^0.5 each) of all touching contacts except `contact`."""
    first_root = 2 * len(scene.coordinates) + 1
    product = as_type_of(1.0, y[first_root])
    for c in range(extent(scene.joints).contact):
        if c != contact:
            product = product * where(touches(mode[c]), y[first_root + c], 1.0)
    return product


@kernel
def per_root(scene, y, mode):
    """Return the factor on `roots_beside` that gives kappa over the root if contacts separate one by one."""
    total = as_type_of(0.0, y[2 * len(scene.coordinates) + 1])
    for c in range(extent(scene.joints).contact):
        total = total + where(touches(mode[c]), roots_beside(scene, y, mode, c), 0.0)
    return 1.0 / where(total != 0.0, scene.sigma * total, 1.0)


@kernel
def _clock_of_joints(scene, y, mode):
    """Return kappa (s) if contacts separate one by one."""
    return roots_beside(scene, y, mode, -1) * per_root(scene, y, mode)


@kernel
def _haste_of_joints(scene, y, mode, kappa, contact):
    """Return kappa over the root of a touching contact, s/m^0.5, also where the root is zero."""
    return roots_beside(scene, y, mode, contact) * per_root(scene, y, mode)


@kernel
def _haste_of_corners(scene, y, mode, kappa, contact):
    return kappa / y[2 * len(scene.coordinates) + 1 + contact]


@kernel
def clock_of_corners(scene, y, mode):
    """Return kappa (s) if contacts may separate at the same moment, such as the corners of a block.

    Trial steps beyond that moment reach roots of opposite signs, between which 1/kappa crosses zero.  If a root is
    as far below zero as half of another root is above zero, kappa continues along its tangent.
    """
    first_root, contacts, nearest_corner = 2 * len(scene.coordinates) + 1, extent(scene.joints).contact, -1
    for c in range(contacts):
        if touches(mode[c]) and (nearest_corner < 0 or abs(y[first_root + c]) < abs(y[first_root + nearest_corner])):
            nearest_corner = c
    if nearest_corner < 0:
        return 1.0
    root, other_roots = y[first_root + nearest_corner], 0.0
    for c in range(contacts):
        if touches(mode[c]) and c != nearest_corner:
            other_roots += root / y[first_root + c]
    share = 1.0 / (1.0 + other_roots) if other_roots > -0.5 else -4.0 * other_roots
    return root * share / scene.sigma


@kernel
def _clock_of_several(scene, y, mode):
    corners = extent(scene.joints).contact > len(scene.joints)
    return clock_of_corners(scene, y, mode) if corners else _clock_of_joints(scene, y, mode)


@kernel
def kappa_over_root(scene, y, mode, kappa, contact):
    """Return kappa over the root of penetration of a touching contact, one of several, s/m^0.5."""
    corners = extent(scene.joints).contact > len(scene.joints)
    return (_haste_of_corners if corners else _haste_of_joints)(scene, y, mode, kappa, contact)
