"""The size of a scene's state, and the internal states of its friction loads, which come last in the state vector.

Friction loads act in joints without clearance, have a given size, or come from a preload.  No separation resets their
states, as these surfaces never part.
"""

from typing import NamedTuple

import numpy as np

from ...tracing.compiled.dual import rate_or_slope
from ...tracing.compiled.family import form_number, inlined, kernel, known, map_joints
from ..joints.contract import (
    after_number,
    every_internal_state,
    state_kinds_of,
    total_counts,
    type_of,
    with_internal_state,
)
from ..laws.contract import internal_rates, internal_state, is_integrated
from ..machines.contract import friction_laws, friction_slips, with_friction_laws

NEVER_RESET = -1  # in place of the index of the contact whose separation resets a number


class Sliding(NamedTuple):
    """Quantities that determine the internal state of a law if the surfaces always touch."""

    slip: float  # m/s


@known
def _state_size(law):
    """Return the number of a friction load's internal states in the state vector."""
    law_type = type_of(law)
    return len(law_type._field_defaults) if is_integrated(law_type) else 0


def _offset_after(offset, law):
    return offset + _state_size(law)


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
    counts = total_counts(scene.joints)
    count = 2 * len(scene.coordinates) + 1 + counts.contact + counts.internal + friction_state_count(scene)
    return counts.contact, count, counts.contact + counts.latched


def every_state(scene) -> list[tuple]:
    """Return (index of its contact or NEVER_RESET, InternalState, initial value) of every integrated number."""
    scene_form = form_number(scene)
    if scene_form in _STATELESS:
        return []
    joint_states = every_internal_state(scene.joints) if state_kinds_of(scene).integrated else []
    states = joint_states + [
        (NEVER_RESET, declared, initial)
        for law in friction_laws(scene.mechanism)
        if is_integrated(type(law))
        for declared, initial in zip(internal_state(law), law[len(law) - len(internal_state(law)) :], strict=True)
    ]
    if not states:
        _STATELESS.add(scene_form)
    return states


_STATELESS: set[int] = set()  # form numbers of scenes whose laws have no integrated state, as of most


def _first_friction_state(scene):
    counts = total_counts(scene.joints)
    return 2 * len(scene.coordinates) + 1 + counts.contact + counts.internal


@kernel
def _with_state(law, _, offset, y):
    return with_internal_state(law, y, offset) if _state_size(law) else law


_with_states = map_joints(_with_state, _offset_after)


@inlined
def with_friction_states(scene, y):
    """Return the scene with the internal states of its friction loads from the state `y`."""
    if not friction_state_count(scene):
        return scene
    laws = friction_laws(scene.mechanism)
    laws = _with_states(laws, laws, _first_friction_state(scene), y)
    return scene._replace(mechanism=with_friction_laws(scene.mechanism, laws))


class _RatesContext(NamedTuple):
    """Destination of the rates of internal states, or of their slopes."""

    kappa: float  # s
    out: np.ndarray  # (n,)


@kernel
def _put_rate(rate, _, offset, destination):
    destination.out[offset] = rate_or_slope(destination.kappa * rate)


_put_rates = map_joints(_put_rate, after_number)


@kernel
def _put_law_rates(law, slip, offset, destination):
    if _state_size(law):
        rates = internal_rates(law, Sliding(slip))
        _put_rates(rates, rates, offset, destination)


_put_rates_of_laws = map_joints(_put_law_rates, _offset_after)


@inlined
def put_friction_rates(scene, y, motion, kappa, out):
    """Write the rates of the internal states of friction loads with respect to tau to `out`, or their slopes."""
    if friction_state_count(scene):
        laws = friction_laws(with_friction_states(scene, y).mechanism)
        _put_rates_of_laws(
            laws, friction_slips(scene.mechanism, motion), _first_friction_state(scene), _RatesContext(kappa, out)
        )
