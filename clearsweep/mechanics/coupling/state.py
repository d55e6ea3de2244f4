"""The size of a scene's state, and the internal states of its friction loads, which come last in the state vector.

Friction loads act in joints without clearance, have a given size, or come from a preload.  No separation resets their
states, as these surfaces never part.
"""

import itertools

from ...tracing.compiled import calculus
from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import as_type_of, rate_or_slope
from ...tracing.compiled.family import inlined, kernel, known
from ..joints import contract
from ..laws.contract import TOUCHES, internal_rates, internal_state, is_integrated, touches
from ..laws.friction import Sliding
from ..machines.contract import friction_laws, friction_slips, with_friction_laws

# ---------------------------------------------------------------------------------------------- size and states


LEAST_ROOT = 1e-100  # m^0.5, in place of a root of penetration that is zero
NEVER_RESET = -1  # in place of the index of the contact whose separation resets a number


@known
def _state_size(law):
    """Return the number of a friction load's internal states in the state vector."""
    return len(law._field_defaults) if is_integrated(type(law)) else 0


@inlined
def friction_state_count(scene):
    """Return the number of all friction loads' internal states in the state vector."""
    count = 0
    for law in friction_laws(scene.mechanism):
        count += _state_size(law)
    return count


@kernel
def size_of(scene):
    """Return the number of contacts, the length of the state vector, and the number of latched values."""
    counts = contract.total_counts(scene.joints)
    count = 2 * len(scene.coordinates) + 1 + counts.contact + counts.internal + friction_state_count(scene)
    return counts.contact, count, counts.contact + counts.latched


def every_state(scene) -> list[tuple]:
    """Return (index of its contact or NEVER_RESET, InternalState, initial value) of every integrated number."""
    joint_states = contract.every_internal_state(scene.joints) if contract.state_kinds_of(scene).integrated else []
    return joint_states + [
        (NEVER_RESET, declared, initial)
        for law in friction_laws(scene.mechanism)
        if is_integrated(type(law))
        for declared, initial in zip(internal_state(law), law[len(law) - len(internal_state(law)) :], strict=True)
    ]


@known
def _first_states(scene):
    """Return the index of the first internal state of each friction load in the state vector."""
    counts, sizes = contract.total_counts(scene.joints), map(_state_size, friction_laws(scene.mechanism))
    first = 2 * len(scene.coordinates) + 1 + counts.contact + counts.internal
    return tuple(itertools.accumulate(sizes, initial=first))[:-1]


@inlined
def with_friction_states(scene, y):
    """Return the scene with the internal states of its friction loads from the state `y`."""
    if not friction_state_count(scene):
        return scene
    laws = list(zip(friction_laws(scene.mechanism), _first_states(scene), strict=True))
    current = [contract.with_internal_state(law, y, start) if _state_size(law) else law for law, start in laws]
    return scene._replace(mechanism=with_friction_laws(scene.mechanism, tuple(current)))


@inlined
def put_friction_rates(scene, y, motion, kappa, out):
    """Write the rates of the internal states of friction loads with respect to tau to `out`, or their slopes."""
    if friction_state_count(scene):
        laws, slips = friction_laws(with_friction_states(scene, y).mechanism), friction_slips(scene.mechanism, motion)
        for law, slip, start in zip(laws, slips, _first_states(scene), strict=True):
            if _state_size(law):
                for i, rate in enumerate(internal_rates(law, Sliding(slip=slip)), start):
                    out[i] = rate_or_slope(kappa * rate)


# ---------------------------------------------------------------------------------------------- the time scale


@kernel
def time_scale(scene, y, mode):
    """Return kappa = dt/dtau (s) at the state `y`.  Contacts that do not touch contribute nothing to 1/kappa."""
    first_root, contacts = 2 * len(scene.coordinates) + 1, contract.total_counts(scene.joints).contact
    if contacts == 0:
        return as_type_of(1.0, y[0])
    if contacts == 1:
        return where(touches(mode[0]), y[first_root] * (1.0 / scene.sigma), 1.0)
    if _has_elements(scene.joints):
        return _kappa_of_elements(scene, y, mode)
    if _has_walls(scene.joints):
        return _kappa_of_walls(scene, y, mode)
    if contacts > len(scene.joints):
        return kappa_of_corners(scene, y, mode)
    # contacts separate one by one
    return product_of_other_roots(scene, y, mode, -1) * kappa_per_root_product(scene, y, mode)


@kernel
def product_of_other_roots(scene, y, mode, contact):
    """Return the product of the roots of penetration (m^0.5 each) of all touching contacts except `contact`."""
    first_root = 2 * len(scene.coordinates) + 1
    product = as_type_of(1.0, y[first_root])
    for c in range(contract.total_counts(scene.joints).contact):
        if c != contact:
            product = product * where(touches(mode[c]), y[first_root + c], 1.0)
    return product


@kernel
def kappa_per_root_product(scene, y, mode):
    """Return the factor on `product_of_other_roots` that gives kappa over the root if contacts separate one by one."""
    total = as_type_of(0.0, y[2 * len(scene.coordinates) + 1])
    for c in range(contract.total_counts(scene.joints).contact):
        total = total + where(touches(mode[c]), product_of_other_roots(scene, y, mode, c), 0.0)
    return 1.0 / where(total != 0.0, scene.sigma * total, 1.0)


@kernel
def _share_of_corner(scene, y, mode, nearest_corner):
    """Return kappa over the root nearest to zero, times sigma; corners whose roots are both zero separate together."""
    first_root, root_ratios = 2 * len(scene.coordinates) + 1, 0.0
    root = y[first_root + nearest_corner]
    for c in range(contract.total_counts(scene.joints).contact):
        if touches(mode[c]) and c != nearest_corner:
            other_root = y[first_root + c]
            root_ratios += root / other_root if other_root != 0.0 else as_type_of(1.0, other_root)
    return 1.0 / (1.0 + root_ratios) if root_ratios > -0.5 else -4.0 * root_ratios


@kernel
def kappa_of_corners(scene, y, mode):
    """Return kappa (s) if contacts may separate at the same moment, such as the corners of a block.

    Trial steps beyond that moment reach roots of opposite signs, between which 1/kappa crosses zero.  If a root is
    as far below zero as half of another root is above zero, kappa continues along its tangent.
    """
    first_root, contacts, nearest_corner = (
        2 * len(scene.coordinates) + 1,
        contract.total_counts(scene.joints).contact,
        -1,
    )
    for c in range(contacts):
        if touches(mode[c]) and (nearest_corner < 0 or abs(y[first_root + c]) < abs(y[first_root + nearest_corner])):
            nearest_corner = c
    if nearest_corner < 0:
        return 1.0
    return y[first_root + nearest_corner] * _share_of_corner(scene, y, mode, nearest_corner) / scene.sigma


@kernel
def _nonzero_root(y, index):
    """Return a root of penetration, or if it is zero a number that counts as zero."""
    return where(y[index] != 0.0, y[index], LEAST_ROOT)


@kernel
def _inverse_root(y, index):
    """Return one over a root of penetration; of a root that is zero a number whose inverse counts as zero."""
    return 1.0 / _nonzero_root(y, index)


@kernel
def _kappa_of_elements(scene, y, mode):
    """Return what `kappa_of_corners` returns, with one division for each touching contact of many."""
    first_root, total, largest = 2 * len(scene.coordinates) + 1, 0.0, 0.0
    for c in touchable_contacts(scene.joints):
        if touches(mode[c]):
            inverse = _inverse_root(y, first_root + c)
            total, largest = total + inverse, where(abs(inverse) > abs(largest), inverse, largest)
    if largest == 0.0:
        return as_type_of(1.0, y[first_root])
    ratio = total / largest
    return where(ratio > 0.5, 1.0 / where(ratio > 0.5, total, largest), 4.0 * (1.0 - ratio) / largest) / scene.sigma


@kernel
def _kappa_of_walls(scene, y, mode):
    """Return kappa (s) of joints in space: 1/kappa = sigma times the root of the sum of 1/s^2 over all that touch.

    A trial step past a separation has roots of opposite signs: this sum never crosses zero, that of 1/s does.
    """
    first_root, total, product = 2 * len(scene.coordinates) + 1, 0.0, 1.0
    for c in touchable_contacts(scene.joints):
        if touches(mode[c]):
            root = _nonzero_root(y, first_root + c)
            total, product = total * (root * root) + product * product, product * root
    if total == 0.0:
        return as_type_of(1.0, y[first_root])
    return product / (scene.sigma * calculus.sqrt(total))


@known
def touchable_contacts(joints):
    """Return the numbers of all contacts except those that only report."""
    modes = [modes for joint in joints for modes in contract.contact_modes(joint)]
    return tuple(c for c, contact in enumerate(modes) if contact.pressed & TOUCHES)


@known
def _has_elements(joints):
    """Return whether a joint has many contacts that begin and end all the time, as a rolling bearing."""
    return any(hasattr(joint, "elements") for joint in joints)


@known
def _has_walls(joints):
    """Return whether a joint is in space, where two walls and two flanges may touch."""
    return any(hasattr(joint, "walls") for joint in joints)


@kernel
def kappa_over_root(scene, y, mode, kappa, contact):
    """Return kappa over the root of penetration of a touching contact, one of several, s/m^0.5, also of a root 0."""
    root_index = 2 * len(scene.coordinates) + 1 + contact
    if _has_elements(scene.joints) or _has_walls(scene.joints):
        return kappa * _inverse_root(y, root_index)
    if contract.total_counts(scene.joints).contact == len(scene.joints):
        return product_of_other_roots(scene, y, mode, contact) * kappa_per_root_product(scene, y, mode)
    if y[root_index] != 0.0:
        return kappa / y[root_index]
    return _share_of_corner(scene, y, mode, contact) / scene.sigma
