"""The loads of all joints of a scene, and the rates of their laws' internal states."""

from typing import NamedTuple

import numpy as np

from ...tracing.compiled.dual import as_type_of, rate_or_slope
from ...tracing.compiled.family import inlined, kernel, map_joints
from ..laws.contract import internal_rates, internal_state, touches
from .contract import Load, load, parts
from .offsets import after_joint, after_number, after_part, counts_of_part, first_offsets, with_current_state


@kernel
def _load(joint, gap, offsets, state):
    return load(joint, gap, offsets, state)


_loads = map_joints(_load, after_joint)


@inlined
def loads_of(joints, gaps, state):
    """Return a Load for each joint of the tuple `joints`, with their Gaps."""
    return _loads(joints, gaps, first_offsets(joints, state.roots), state)


# ---------------------------------------------------------------------------------------------- internal states


class _RatesContext(NamedTuple):
    """Data for the rates of internal states."""

    load: Load
    state: tuple  # JointState
    kappa: float  # s
    out: np.ndarray  # (n,) rates of the state vector, or their slopes


class _RateContext(NamedTuple):
    """Data for the rate of one number."""

    touching: bool
    kappa: float  # s
    out: np.ndarray


@kernel
def _put_rate(rate, declared, index, context):
    rate = rate if context.touching or declared.survives_separation else as_type_of(0.0, rate)
    context.out[index] = rate_or_slope(context.kappa * rate)


@kernel
def _put_zero(declared, _, index, out):
    out[index] = 0.0


@kernel
def _survives(declared, _, index, context):
    return declared.survives_separation


_put_rates, _put_all_zeros, _survival_of_each = (
    map_joints(function, after_number) for function in (_put_rate, _put_zero, _survives)
)


@kernel
def _put_part_rates(part, _, offsets, context):
    if not counts_of_part(part).internal:
        return
    declared, touching = internal_state(part.law), touches(context.state.mode[offsets.contact + part.contact])
    if touching or True in _survival_of_each(declared, declared, 0, 0):
        law = with_current_state(part.law, context.state.y, context.state.latched, offsets)
        rates = internal_rates(law, context.load.contacts[part.contact])
        _put_rates(rates, declared, offsets.internal, _RateContext(touching, context.kappa, context.out))
    else:
        _put_all_zeros(declared, declared, offsets.internal, context.out)


_put_rates_of_parts = map_joints(_put_part_rates, after_part)


@kernel
def _put_joint_rates(joint, load, offsets, context):
    state, kappa, out = context
    joint_parts = parts(joint)
    _put_rates_of_parts(joint_parts, joint_parts, offsets, _RatesContext(load, state, kappa, out))


_put_rates_of_joints = map_joints(_put_joint_rates, after_joint)


@kernel
def put_internal_rates(joints, loads, state, kappa, out):
    """Put the rates of all internal states with respect to tau into `out`, or their slopes.

    Out of contact only numbers that are kept over separations have a rate.
    """
    _put_rates_of_joints(joints, loads, first_offsets(joints, state.roots), (state, kappa, out))
