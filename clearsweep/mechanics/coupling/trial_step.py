"""Compiled evaluation of the right-hand side, for one state or for all stages of a step in one sweep of the iteration.

A sweep processes one stage in each lane of a register.  On processors with narrower registers it processes the lanes in
groups, with the same bits.
"""

from typing import NamedTuple

import numpy as np

from ...tracing.compiled.choosing import lane_range, total_of
from ...tracing.compiled.family import Entry, entry, inlined, shaped
from ..joints.contract import JointState, total_counts
from ..laws.contract import touches
from ..machines.contract import gaps, pose_at
from ..observe import END, FIRST_IMPLICIT_ROW, ROW_COUNT, STAGES
from ..solver.collocation import POSITIONS, VELOCITIES, WHOLE_SWEEP, A, sum_over_stages
from ..solver.totals import Step
from .rates import gaps_with_angles, observed_width, put_error, put_root_rates, rates
from .state import size_of
from .time_scale import time_scale


def rates_entry(scene, y, mode, latched, k, o, row):
    """Write rates and observables of a state to a `row`; arrays are bare pointers, `scene` points to the Scene."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    y, o = shaped(y, (n,)), shaped(o, (observed_width(parameters), ROW_COUNT))
    mode, latched = shaped(mode, (contacts,)), shaped(latched, (latched_count,))
    rates(parameters, y, mode, latched, shaped(k, (n, ROW_COUNT)), o, row, row < FIRST_IMPLICIT_ROW)
    put_error(parameters, pose_at(parameters.mechanism, y), o, row)


class _Sweep(NamedTuple):
    """Arrays of a sweep, see `integration.Work`, and the length of the step."""

    y: np.ndarray
    weight: np.ndarray
    mode: np.ndarray
    latched: np.ndarray
    k: np.ndarray
    nodes: np.ndarray
    length: float


@inlined
def _update_components(sweep, begin, end):
    """Update components `begin` to `end` of all stages from their rates; sum squared relative changes."""
    k, nodes, h = sweep.k, sweep.nodes, sweep.length
    n = nodes.shape[0] - 1
    for c in range(begin, end):
        initial, inverse_scale = sweep.y[c], sweep.weight[c]
        for i in lane_range(STAGES):
            predicted = initial + h * sum_over_stages(A, k[c], i)
            scaled_change = (predicted - nodes[c, i]) * inverse_scale
            nodes[c, i] = predicted
            nodes[n, i] = nodes[n, i] + scaled_change * scaled_change


@inlined
def _evaluate_rates(scene, sweep):
    """Evaluate the rates of all stages."""
    for i in lane_range(STAGES):
        rates(scene, sweep.nodes[:, i], sweep.mode, sweep.latched, sweep.k, None, i, False)
        sweep.nodes[sweep.nodes.shape[0] - 1, i] = 0.0


@inlined
def _update_velocities(scene, sweep):
    """Update the velocities and internal states of all stages."""
    count, n = len(scene.coordinates), sweep.nodes.shape[0] - 1
    _update_components(sweep, count, 2 * count)
    _update_components(sweep, 2 * count + 1 + total_counts(scene.joints).contact, n)


@inlined
def _update_positions(scene, sweep):
    """Update the roots of penetration of all stages from the new velocities, then coordinates and time."""
    mode, latched, k, nodes = sweep.mode, sweep.latched, sweep.k, sweep.nodes
    count, contacts, touching = len(scene.coordinates), total_counts(scene.joints).contact, False
    first_root = 2 * count + 1
    for c in range(contacts):
        touching = touching | touches(mode[c])
    if touching:
        for i in lane_range(STAGES):
            state = nodes[:, i]
            joint_gaps = gaps_with_angles(scene, state, gaps(scene.mechanism, pose_at(scene.mechanism, state)))
            kappa = time_scale(scene, state, mode)
            put_root_rates(scene, joint_gaps, JointState(state, mode, latched, first_root), kappa, k, i)
        _update_components(sweep, first_root, first_root + contacts)
    for i in lane_range(STAGES):
        kappa = time_scale(scene, nodes[:, i], mode)
        for c in range(count):
            k[c, i] = kappa * nodes[count + c, i]
        k[2 * count, i] = kappa
    _update_components(sweep, 0, count)
    _update_components(sweep, 2 * count, first_root)


def sweep_entry(scene, y, mode, latched, weight, k, nodes, step, _):
    """Evaluate and update all stages of a step, or do the part of it in `step.part`, see `solver.collocation`."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    y, weight, step = shaped(y, (n,)), shaped(weight, (n,)), Step(shaped(step, (Step.SIZE,)))
    mode, latched = shaped(mode, (contacts,)), shaped(latched, (latched_count,))
    k, nodes = shaped(k, (n, ROW_COUNT)), shaped(nodes, (n + 1, STAGES))
    sweep = _Sweep(y, weight, mode, latched, k, nodes, step.length)
    if step.part == WHOLE_SWEEP:  # in one piece, so that the compiler evaluates the pose once
        _evaluate_rates(parameters, sweep)
        _update_velocities(parameters, sweep)
        _update_positions(parameters, sweep)
    elif step.part == POSITIONS:
        _update_positions(parameters, sweep)
    else:
        _evaluate_rates(parameters, sweep)
        if step.part == VELOCITIES:
            _update_velocities(parameters, sweep)
    step.change = total_of(nodes[n]) * (1.0 / n)


def observe_entry(scene, nodes, mode, latched, o, _):
    """Write the observables of all stages of a step."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    nodes, mode, latched = shaped(nodes, (n + 1, STAGES)), shaped(mode, (contacts,)), shaped(latched, (latched_count,))
    o = shaped(o, (observed_width(parameters), ROW_COUNT))
    for i in lane_range(STAGES):
        rates(parameters, nodes[:, i], mode, latched, None, o, i)
    put_error(parameters, pose_at(parameters.mechanism, nodes[:, END]), o, END)


def rates_of(scene, parameters) -> Entry:
    """Return the Entry of the right-hand side of `scene` at one state."""
    return entry(rates_entry, scene, "fifff", parameters)


def sweep_of(scene, parameters) -> Entry:
    """Return the Entry of one sweep of the iteration for `scene`."""
    return entry(sweep_entry, scene, "fifffff", parameters)


def stage_observables_of(scene, parameters) -> Entry:
    """Return the Entry of the observables of all stages of a step of `scene`."""
    return entry(observe_entry, scene, "fiff", parameters)
