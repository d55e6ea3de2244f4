"""Compiled evaluation of the right-hand side, for one state or for all stages of a step in one sweep of the iteration.

A sweep processes one stage in each lane of a register.  On processors with narrower registers it processes the lanes in
groups, with the same bits.
"""

from ..compiled.choosing import lane_range, total_of
from ..compiled.family import Entry, entry, inlined, shaped
from ..joint.contract import JointState
from ..joint.modes import touches
from ..joint.offsets import total_counts
from ..mechanism.contract import gaps, pose_at
from ..observe.stages import END, FIRST_IMPLICIT_ROW, ROW_COUNT, STAGES
from ..solver.accumulate.step_sums import Step
from ..solver.collocation import POSITIONS, VELOCITIES, WHOLE_SWEEP, A
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


@inlined
def _update_components(scene, begin, end, arguments):
    """Update components `begin` to `end` of all stages from their rates; sum squared relative changes."""
    y, weight, k, nodes, h = arguments
    n = nodes.shape[0] - 1
    for c in range(begin, end):
        initial, inverse_scale = y[c], weight[c]
        for i in lane_range(STAGES):
            early_terms = (A[0, i] * k[c, 0] + A[1, i] * k[c, 1]) + (A[2, i] * k[c, 2] + A[3, i] * k[c, 3])
            late_terms = (A[4, i] * k[c, 4] + A[5, i] * k[c, 5]) + (A[6, i] * k[c, 6] + A[7, i] * k[c, 7])
            predicted = initial + h * (early_terms + late_terms)
            scaled_change = (predicted - nodes[c, i]) * inverse_scale
            nodes[c, i] = predicted
            nodes[n, i] = nodes[n, i] + scaled_change * scaled_change


@inlined
def _update_roots(scene, mode, latched, arguments):
    """Update the roots of penetration of all stages from the new velocities, if a contact touches."""
    _, _, k, nodes, _ = arguments
    first_root, contacts, touching = 2 * len(scene.coordinates) + 1, total_counts(scene.joints).contact, False
    for c in range(contacts):
        touching = touching | touches(mode[c])
    if touching:
        for i in lane_range(STAGES):
            state = nodes[:, i]
            joint_gaps = gaps_with_angles(scene, state, gaps(scene.mechanism, pose_at(scene.mechanism, state)))
            kappa = time_scale(scene, state, mode)
            put_root_rates(scene, joint_gaps, JointState(state, mode, latched, first_root), kappa, k, i)
        _update_components(scene, first_root, first_root + contacts, arguments)


def sweep_entry(scene, y, mode, latched, weight, k, nodes, step, _):
    """Evaluate and update all stages of a step, or do the part of it in `step.part`, see `solver.collocation`."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    coordinate_count = len(parameters.coordinates)
    y, weight, step = shaped(y, (n,)), shaped(weight, (n,)), Step(shaped(step, (Step.SIZE,)))
    mode, latched = shaped(mode, (contacts,)), shaped(latched, (latched_count,))
    k, nodes = shaped(k, (n, ROW_COUNT)), shaped(nodes, (n + 1, STAGES))
    arguments = y, weight, k, nodes, step.length
    time_index, part = 2 * coordinate_count, step.part
    if part != POSITIONS:
        for i in lane_range(STAGES):
            rates(parameters, nodes[:, i], mode, latched, k, None, i, False)
            nodes[n, i] = 0.0
    if part in (WHOLE_SWEEP, VELOCITIES):
        _update_components(parameters, coordinate_count, time_index, arguments)
        _update_components(parameters, time_index + 1 + contacts, n, arguments)
    if part in (WHOLE_SWEEP, POSITIONS):
        _update_roots(parameters, mode, latched, arguments)
        for i in lane_range(STAGES):
            kappa = time_scale(parameters, nodes[:, i], mode)
            for c in range(coordinate_count):
                k[c, i] = kappa * nodes[coordinate_count + c, i]
            k[time_index, i] = kappa
        _update_components(parameters, 0, coordinate_count, arguments)
        _update_components(parameters, time_index, time_index + 1, arguments)
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
