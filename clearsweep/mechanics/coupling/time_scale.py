"""The time scale kappa = dt/dtau of the independent variable tau: see `rates`."""

from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import kernel
from ..joints.contract import total_counts
from ..laws.contract import touches


@kernel
def time_scale(scene, y, mode):
    """Return kappa = dt/dtau (s) at the state `y`.  Contacts that do not touch contribute nothing to 1/kappa."""
    first_root, contacts = 2 * len(scene.coordinates) + 1, total_counts(scene.joints).contact
    if contacts == 1:
        return where(touches(mode[0]), y[first_root] * (1.0 / scene.sigma), 1.0)
    return _kappa_of_several(scene, y, mode)


@kernel
def product_of_other_roots(scene, y, mode, contact):
    """Return the product of the roots of penetration (m^0.5 each) of all touching contacts except `contact`."""
    first_root = 2 * len(scene.coordinates) + 1
    product = as_type_of(1.0, y[first_root])
    for c in range(total_counts(scene.joints).contact):
        if c != contact:
            product = product * where(touches(mode[c]), y[first_root + c], 1.0)
    return product


@kernel
def kappa_per_root_product(scene, y, mode):
    """Return the factor on `product_of_other_roots` that gives kappa over the root if contacts separate one by one."""
    total = as_type_of(0.0, y[2 * len(scene.coordinates) + 1])
    for c in range(total_counts(scene.joints).contact):
        total = total + where(touches(mode[c]), product_of_other_roots(scene, y, mode, c), 0.0)
    return 1.0 / where(total != 0.0, scene.sigma * total, 1.0)


@kernel
def _kappa_of_joints(scene, y, mode):
    """Return kappa (s) if contacts separate one by one."""
    return product_of_other_roots(scene, y, mode, -1) * kappa_per_root_product(scene, y, mode)


@kernel
def _kappa_over_root_of_joints(scene, y, mode, kappa, contact):
    """Return kappa over the root of a touching contact, s/m^0.5, also where the root is zero."""
    return product_of_other_roots(scene, y, mode, contact) * kappa_per_root_product(scene, y, mode)


@kernel
def _kappa_over_root_of_corners(scene, y, mode, kappa, contact):
    return kappa / y[2 * len(scene.coordinates) + 1 + contact]


@kernel
def kappa_of_corners(scene, y, mode):
    """Return kappa (s) if contacts may separate at the same moment, such as the corners of a block.

    Trial steps beyond that moment reach roots of opposite signs, between which 1/kappa crosses zero.  If a root is
    as far below zero as half of another root is above zero, kappa continues along its tangent.
    """
    first_root, contacts, nearest_corner = 2 * len(scene.coordinates) + 1, total_counts(scene.joints).contact, -1
    for c in range(contacts):
        if touches(mode[c]) and (nearest_corner < 0 or abs(y[first_root + c]) < abs(y[first_root + nearest_corner])):
            nearest_corner = c
    if nearest_corner < 0:
        return 1.0
    root, root_ratios = y[first_root + nearest_corner], 0.0
    for c in range(contacts):
        if touches(mode[c]) and c != nearest_corner:
            root_ratios += root / y[first_root + c]
    factor = 1.0 / (1.0 + root_ratios) if root_ratios > -0.5 else -4.0 * root_ratios
    return root * factor / scene.sigma


@kernel
def _kappa_of_several(scene, y, mode):
    has_corners = total_counts(scene.joints).contact > len(scene.joints)
    return kappa_of_corners(scene, y, mode) if has_corners else _kappa_of_joints(scene, y, mode)


@kernel
def kappa_over_root(scene, y, mode, kappa, contact):
    """Return kappa over the root of penetration of a touching contact, one of several, s/m^0.5."""
    has_corners = total_counts(scene.joints).contact > len(scene.joints)
    return (_kappa_over_root_of_corners if has_corners else _kappa_over_root_of_joints)(scene, y, mode, kappa, contact)
