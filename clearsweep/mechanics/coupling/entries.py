"""The compiled functions of a scene that the loop calls by address: sweeps, observables, guards and wear."""

from typing import Annotated, NamedTuple

import numpy as np

from ...tracing.compiled.choosing import lane_range, rolled_range, total_of
from ...tracing.compiled.family import (
    NO_ENTRY,
    Entry,
    entries_of,
    entry,
    form_number,
    inlined,
    is_plain,
    kernel,
    shaped,
)
from ..joints import contract
from ..joints.worn import with_body_angles
from ..laws.contract import StepStart, guard_values, latched, touches
from ..machines.contract import body_angles, gaps, pose_at, put_signals
from ..observe import (
    END,
    FIRST_IMPLICIT_ROW,
    PARTS,
    ROW_COUNT,
    SCRATCH,
    STAGES,
    START,
    STATE_POINTS,
    STEP_VALUE_ROWS,
    column_of,
    contact_observables_in,
)
from ..solver.collocation import POSITIONS, VELOCITIES, WHOLE_SWEEP, A, sum_over_stages
from ..solver.event_search import SINGLE_STATE
from ..solver.totals import Step
from ..wear import ACCOUNT_SIZE, Account
from ..wear.arc import WORKSPACE_SIZE, workspace_of
from ..wear.bins import (
    BUFFER_ROWS,
    RECORDED_SIZE,
    SLOPES,
    AxialRows,
    Instant,
    StripRows,
    WearTotals,
    record,
    update_joint_wear,
)
from ..wear.bins import POSITIONS as POSITION_ROWS
from ..wear.bins import Step as WearStep
from .inertia import joints_at_event
from .rates import (
    first_signal,
    gaps_with_angles,
    observed_width,
    put_error,
    put_link_signals,
    put_root_rates,
    rates,
    scene_signal_count,
)
from .state import size_of, time_scale, touchable_contacts

# What a loop over the stages leaves is that of all lanes; in plain Python it is that of the last stage alone.
IN_LANES = not is_plain()

# ---------------------------------------------------------------------------------------------- rates and stages

# Compiled evaluation of the right-hand side, for one state or for all stages of a step in one sweep of the iteration.
#
# A sweep processes one stage in each lane of a register.  On processors with narrower registers it processes the lanes
# in groups, with the same bits.


def rates_entry(scene, y, mode, latched, k, o, row):
    """Write rates and observables of a state to a `row`; arrays are bare pointers, `scene` points to the Scene."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    y, o = shaped(y, (n,)), shaped(o, (observed_width(parameters), ROW_COUNT))
    mode, latched = shaped(mode, (contacts,)), shaped(latched, (latched_count,))
    k = shaped(k, (n, ROW_COUNT))
    pose, loads, motion = rates(parameters, y, mode, latched, k, o, row, row < FIRST_IMPLICIT_ROW)
    if scene_signal_count(parameters) and row != SCRATCH:  # that only the search for a peak needs
        _put_all_signals(parameters, y, pose, loads, motion, o, row)
    put_error(parameters, pose_at(parameters.mechanism, y), o, row)


class _Sweep(NamedTuple):
    """Arrays of a sweep, see `integration.Work`, and the length of the step."""

    y: np.ndarray
    weight: np.ndarray
    mode: np.ndarray
    latched: np.ndarray
    k: np.ndarray
    nodes: np.ndarray
    deepest_angles: np.ndarray
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
    """Evaluate the rates of all stages; return the Loads of the joints."""
    for i in lane_range(STAGES):
        nodes, deepest_angles = sweep.nodes[:, i], sweep.deepest_angles[:, i]
        _, loads, _ = rates(scene, nodes, sweep.mode, sweep.latched, sweep.k, None, i, False, deepest_angles)
        sweep.nodes[sweep.nodes.shape[0] - 1, i] = 0.0
    return loads


@inlined
def _update_velocities(scene, sweep):
    """Update the velocities and internal states of all stages."""
    count, n = len(scene.coordinates), sweep.nodes.shape[0] - 1
    _update_components(sweep, count, 2 * count)
    _update_components(sweep, 2 * count + 1 + contract.total_counts(scene.joints).contact, n)


@inlined
def _update_positions(scene, sweep, loads):
    """Update the roots of penetration of all stages from the new velocities, then coordinates and time.

    loads : of the joints, at these coordinates; None if they are not known
    """
    mode, latched, k, nodes = sweep.mode, sweep.latched, sweep.k, sweep.nodes
    count, contacts, touching = len(scene.coordinates), contract.total_counts(scene.joints).contact, False
    first_root = 2 * count + 1
    for c in range(contacts):
        touching = touching | touches(mode[c])
    if touching:
        for i in lane_range(STAGES):
            state = nodes[:, i]
            joint_gaps = gaps_with_angles(scene, state, gaps(scene.mechanism, pose_at(scene.mechanism, state)))
            kappa = time_scale(scene, state, mode)
            joint_state = contract.JointState(state, mode, latched, first_root, sweep.deepest_angles[:, i])
            put_root_rates(scene, joint_gaps, loads, joint_state, kappa, k, i)
        for c in touchable_contacts(scene.joints):
            if touches(mode[c]):  # all other roots are constant
                _update_components(sweep, first_root + c, first_root + c + 1)
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
    k, nodes = shaped(k, (n, ROW_COUNT)), shaped(nodes, (n + 1 + contacts, STAGES))
    nodes, deepest_angles = nodes[: n + 1], nodes[n + 1 :]
    sweep = _Sweep(y, weight, mode, latched, k, nodes, deepest_angles, step.length)
    if step.part == WHOLE_SWEEP:  # in one piece, so that the compiler evaluates the pose once
        loads = _evaluate_rates(parameters, sweep)
        _update_velocities(parameters, sweep)
        _update_positions(parameters, sweep, loads if IN_LANES else None)
    elif step.part == POSITIONS:
        _update_positions(parameters, sweep, None)
    else:
        _evaluate_rates(parameters, sweep)
        if step.part == VELOCITIES:
            _update_velocities(parameters, sweep)
    step.change = total_of(nodes[n]) * (1.0 / n)


def observe_entry(scene, nodes, mode, latched, o, _):
    """Write the observables of all stages of a step."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    nodes, mode = shaped(nodes, (n + 1 + contacts, STAGES)), shaped(mode, (contacts,))
    o, latched = shaped(o, (observed_width(parameters), ROW_COUNT)), shaped(latched, (latched_count,))
    nodes, deepest_angles = nodes[: n + 1], nodes[n + 1 :]
    for i in lane_range(STAGES):
        pose, loads, motion = rates(parameters, nodes[:, i], mode, latched, None, o, i, True, deepest_angles[:, i])
        _put_all_signals(parameters, nodes[:, i], pose, loads, motion, o, i)
    put_error(parameters, pose_at(parameters.mechanism, nodes[:, END]), o, END)


@inlined
def _put_all_signals(scene, y, pose, loads, motion, o, row):
    """Write the signals to a row of `o`."""
    if scene.shaking:
        put_signals(scene, y, pose, motion, o, row, first_signal(scene))
    put_link_signals(scene, pose, loads, motion, o, row)


#: Functions that give Entries of a scene: the right-hand side at one state, a sweep of the iteration, the observables
#: of all stages of a step.
rates_of, sweep_of = entries_of(rates_entry, "fifff"), entries_of(sweep_entry, "fifffff")
stage_observables_of = entries_of(observe_entry, "fiff")


# ---------------------------------------------------------------------------------------------- guards

# The compiled guards and latched quantities of the laws of a scene, which the loop calls by address.
#
# Code is compiled only for scenes whose laws evaluate guards themselves, and only for laws that latch a quantity.


class Guards(NamedTuple):
    """The guards of all joints of a scene, g of them, in the order of their parts; see `contract.Guard`."""

    evaluate: Entry  # computes the guards that laws evaluate and writes them to `value`; NO_ENTRY without such guards
    latch: Entry  # latches the internal states of laws at an event; NO_ENTRY if no law has a latched state
    contact: np.ndarray  # (g,) int64, index of the contact of each guard
    modes: np.ndarray  # (g,) int64, bit m is set if the guard is active in mode m
    next_mode: np.ndarray  # (g,) int64, mode after the passage
    at_start: np.ndarray  # (g,) bool, as the next two; see `contract.Guard`
    counted: np.ndarray
    ends_run: np.ndarray
    column: np.ndarray  # (g,) int64, column of the observable used as guard; -1 if the law evaluates the guard
    sign: np.ndarray  # (g,) factor on that observable, 1 or -1
    value: Annotated[np.ndarray, SINGLE_STATE + 1]  # (g,) guards at the nodes of the current step; last at any state
    event: np.ndarray  # (2,) int64, arguments of `latch`: the contact, and ENTERED, LEFT or the guard's number


# ---------------------------------------------------------------------------------------------- values of guards


@kernel
def _evaluate_part(part, offsets, start_state, y, latched, o, row, roots, value):
    contact = offsets.contact + part.contact
    law, root = contract.with_current_state(part.law, y, latched, offsets), y[roots + contact]
    law_at_start = contract.with_current_state(part.law, start_state, latched, offsets)
    start = StepStart(law_at_start, contact_observables_in(o, START, contact))
    for i, number in enumerate(guard_values(law, start, contact_observables_in(o, row, contact), root)):
        value[offsets.guard + i] = number


@kernel
def _evaluate_guards(joints, start, y, latched, o, row, roots, value):
    """Write the guards at the state `y` to `value`; row : of `o`, with the observables of this state."""
    for _, part, offsets in contract.located_parts(joints, roots):
        if type(part.law) in guard_values.members:
            _evaluate_part(part, offsets, start, y, latched, o, row, roots, value)


def guards_entry(scene, start, y, nodes, latched, o, value, row):
    """Write the guards that laws evaluate to `value`, see `solver.event_search.evaluate_guards`.

    Arrays are bare pointers; `scene` is a pointer to the Scene.
    """
    parameters = scene[0]
    roots, counts = 2 * len(parameters.coordinates) + 1, contract.total_counts(parameters.joints)
    _, n, _ = size_of(parameters)
    start, y, nodes = shaped(start, (n,)), shaped(y, (n,)), shaped(nodes, (n + 1, STAGES))
    latched, o = shaped(latched, (counts.contact + counts.latched,)), shaped(o, (observed_width(parameters), ROW_COUNT))
    value, joints = shaped(value, (counts.guard, SINGLE_STATE + 1)), parameters.joints
    if row != END:
        _evaluate_guards(joints, start, y, latched, o, row, roots, value[:, SINGLE_STATE])
        return
    _evaluate_guards(joints, start, y, latched, o, START, roots, value[:, 0])
    for i in rolled_range(STAGES):
        _evaluate_guards(joints, start, nodes[:, i], latched, o, i, roots, value[:, 1 + i])


# ---------------------------------------------------------------------------------------------- latching


@kernel
def _latch_part(part, offsets, y, latched_values, o, row, roots, contact, guard):
    is_guard_of_part = 0 <= guard - offsets.guard < contract.counts_of(part.law).guard
    if offsets.contact + part.contact == contact and (guard < 0 or is_guard_of_part):
        law = contract.with_current_state(part.law, y, latched_values, offsets)
        event = guard - offsets.guard if is_guard_of_part else guard
        values = latched(law, event, contact_observables_in(o, row, contact), y[roots + contact])
        destination, start = contract.internal_state_location(part.law, y, latched_values, offsets)
        for i, number in enumerate(values, start):
            destination[i] = number


def latch_entry(scene, y, latched_values, o, event, row):
    """Latch the laws' internal states at an event: change `y` and `latched_values`; observables are in a `row` of `o`.

    event : (2,) int64, the contact, and ENTERED, LEFT or the guard's number.
    """
    parameters = scene[0]
    roots, counts = 2 * len(parameters.coordinates) + 1, contract.total_counts(parameters.joints)
    y, latched_values = shaped(y, (size_of(parameters)[1],)), shaped(latched_values, (counts.contact + counts.latched,))
    o, event = shaped(o, (observed_width(parameters), ROW_COUNT)), shaped(event, (2,))
    for _, part, offsets in contract.located_parts(joints_at_event(parameters, y), roots):
        if type(part.law) in latched.members:
            _latch_part(part, offsets, y, latched_values, o, row, roots, event[0], event[1])


# ---------------------------------------------------------------------------------------------- for a scene


def guards_of(scene, parameters, zeros=np.zeros) -> Guards:
    """Return the Guards of the compiled `scene`; `parameters` : of `flatten(scene)`; `zeros` allocates arrays."""
    key = form_number(scene)
    if key not in _GUARD_TABLES:
        _GUARD_TABLES[key] = _guard_table(scene.joints)
    table, has_latching_law = _GUARD_TABLES[key]
    count = table["contact"].size
    return Guards(
        evaluate=entry(guards_entry, scene, "ffffff", parameters) if -1 in table["column"] else NO_ENTRY,
        latch=entry(latch_entry, scene, "fffi", parameters) if has_latching_law else NO_ENTRY,
        value=zeros((count, SINGLE_STATE + 1)),
        event=zeros(2, dtype=np.int64),
        **table,
    )


_GUARD_TABLES: dict[int, tuple[dict[str, np.ndarray], bool]] = {}  # key: id of the form of a scene


def _guard_table(joints) -> tuple[dict[str, np.ndarray], bool]:
    """Return the fields of Guards, and whether any law latches a quantity; both depend on the types of laws only."""
    contact_guards = contract.every_guard(joints)
    guards_of_laws = [guard for _, guard in contact_guards]
    flags = ("at_start", "counted", "ends_run")
    arrays = {
        "contact": np.array([contact for contact, _ in contact_guards], dtype=np.int64),
        "modes": np.array([sum(1 << mode for mode in guard.modes) for guard in guards_of_laws], dtype=np.int64),
        "next_mode": np.array([guard.next_mode for guard in guards_of_laws], dtype=np.int64),
    }
    arrays["column"] = np.array(
        [column_of(contact, guard.observable) if guard.observable >= 0 else -1 for contact, guard in contact_guards],
        np.int64,
    )
    arrays["sign"] = np.array([guard.sign for guard in guards_of_laws], dtype=np.float64)
    arrays |= {name: np.array([getattr(guard, name) for guard in guards_of_laws], dtype=np.int64) for name in flags}
    return arrays, any(type(law) in latched.members for _, law in contract.every_part(joints))


# ---------------------------------------------------------------------------------------------- wear


@kernel
def _record_step_positions(scene, dense_states, step):
    """Record the contact positions of all joints on their bodies at the STATE_POINTS points of a step."""
    for i in lane_range(STATE_POINTS):
        y = dense_states[:, i]
        pose = pose_at(scene.mechanism, y)
        angles = body_angles(scene.mechanism, y)
        joint_gaps = with_body_angles(scene.joints, gaps(scene.mechanism, pose), angles)
        instant = Instant(joint_gaps, angles, i, step)
        for number, (joint, offsets) in enumerate(zip(scene.joints, contract.offsets_of(scene.joints, 0), strict=True)):
            record(joint, joint_gaps[number], angles[number], offsets.contact, instant)


def wear_entry(scene, dense_states, mode, step_values, length, workspace, depths, account, stride):
    """Add the wear of a step; arrays are bare pointers; `scene` is a pointer to the Scene.

    dense_states : (2 coordinates + 1, STATE_POINTS) the state within the step; length : of the step, in tau;
    workspace : of the size that `workspace_size` returns.
    """
    parameters = scene[0]
    contacts, state_size = contract.total_counts(parameters.joints).contact, 2 * len(parameters.coordinates) + 1
    workspace_array = shaped(workspace, (workspace_size(contacts, stride),))
    axial_offset = WORKSPACE_SIZE + contacts * (POSITION_ROWS + SLOPES) * STATE_POINTS
    strip_offset = axial_offset + contacts * AxialRows.SIZE * STATE_POINTS
    buffer_offset = strip_offset + StripRows.SIZE * (PARTS + 1)
    step = WearStep(
        shaped(step_values, (contacts, STEP_VALUE_ROWS, PARTS + 1)),
        shaped(length, (1,))[0],
        shaped(mode, (contacts,)),
        workspace_array[WORKSPACE_SIZE:axial_offset].reshape(contacts, POSITION_ROWS + SLOPES, STATE_POINTS),
        AxialRows(workspace_array[axial_offset:strip_offset].reshape(contacts, AxialRows.SIZE, STATE_POINTS)),
        StripRows(workspace_array[strip_offset:buffer_offset].reshape(StripRows.SIZE, PARTS + 1)),
        workspace_of(workspace_array),
        workspace_array[buffer_offset:],
    )
    _record_step_positions(parameters, shaped(dense_states, (state_size, STATE_POINTS)), step)
    totals = WearTotals(
        shaped(depths, (2 * contacts * stride,)), stride, Account(shaped(account, (contacts, ACCOUNT_SIZE)))
    )
    for joint, offsets in zip(parameters.joints, contract.offsets_of(parameters.joints, 0), strict=True):
        update_joint_wear(joint, offsets.contact, (step, totals))


@kernel
def workspace_size(contacts, stride):
    """Return the size of the workspace for the wear of `contacts`; stride : largest number of bins of a body."""
    return WORKSPACE_SIZE + contacts * RECORDED_SIZE + StripRows.SIZE * (PARTS + 1) + BUFFER_ROWS * stride


wear_of = entries_of(wear_entry, "fifffff")  # of a scene, the Entry that computes its wear
