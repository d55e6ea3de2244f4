"""The compiled guards and latched quantities of the laws of a scene, which the loop calls by address.

Code is compiled only for scenes whose laws evaluate guards themselves, and only for laws that latch a quantity.
"""

from typing import NamedTuple

import numpy as np

from ...tracing.compiled.choosing import rolled_range
from ...tracing.compiled.family import NO_ENTRY, Entry, entry, form_number, kernel, map_joints, shaped
from ..joints.contract import (
    after_joint,
    after_number,
    after_part,
    every_guard,
    every_part,
    first_offsets,
    internal_state_location,
    parts,
    total_counts,
    with_current_state,
)
from ..laws.contract import StepStart, guard_values, latched
from ..observe import END, ROW_COUNT, STAGES, START, column_of, contact_observables_in
from ..solver.event_search import SINGLE_STATE
from .impact_mass import joints_at_event
from .rates import observed_width
from .state import size_of


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
    value: np.ndarray  # (g, SINGLE_STATE + 1) guards at the nodes of the current step; last at any other state
    event: np.ndarray  # (2,) int64, arguments of `latch`: the contact, and ENTERED, LEFT or the guard's number


# ---------------------------------------------------------------------------------------------- values of guards


class _GuardContext(NamedTuple):
    """Inputs and results of the evaluation of guards."""

    start: np.ndarray  # (n,) state at the start of the step
    y: np.ndarray  # (n,) state
    latched: np.ndarray  # (contacts + l,)
    o: np.ndarray  # (columns, ROW_COUNT) observables
    row: int  # row of `o` with the observables of this state
    roots: int  # index of the first root of penetration in `y`
    value: np.ndarray  # (g,) results


@kernel
def _write_value(value, _, offsets, out):
    out[offsets] = value


_write_values = map_joints(_write_value, after_number)


@kernel
def _evaluate_part(part, _, offsets, context):
    if type(part.law) not in guard_values.members:
        return
    start_state, y, latched, o, row, roots, value = context
    contact = offsets.contact + part.contact
    law, root = with_current_state(part.law, y, latched, offsets), y[roots + contact]
    law_at_start = with_current_state(part.law, start_state, latched, offsets)
    start = StepStart(law_at_start, contact_observables_in(o, START, contact))
    values = guard_values(law, start, contact_observables_in(o, row, contact), root)
    _write_values(values, values, offsets.guard, value)


_evaluate_parts = map_joints(_evaluate_part, after_part)


@kernel
def _evaluate_joint(joint, _, offsets, context):
    joint_parts = parts(joint)
    _evaluate_parts(joint_parts, joint_parts, offsets, context)


_evaluate_joints = map_joints(_evaluate_joint, after_joint)


def guards_entry(scene, start, y, nodes, latched, o, value, row):
    """Write the guards that laws evaluate to `value`, see `solver.event_search.evaluate_guards`.

    Arrays are bare pointers; `scene` is a pointer to the Scene.
    """
    parameters = scene[0]
    roots, counts = 2 * len(parameters.coordinates) + 1, total_counts(parameters.joints)
    _, n, _ = size_of(parameters)
    start, y, nodes = shaped(start, (n,)), shaped(y, (n,)), shaped(nodes, (n + 1, STAGES))
    latched, o = shaped(latched, (counts.contact + counts.latched,)), shaped(o, (observed_width(parameters), ROW_COUNT))
    value, offsets = shaped(value, (counts.guard, SINGLE_STATE + 1)), first_offsets(parameters.joints, roots)
    if row != END:
        _evaluate_joints(
            parameters.joints,
            parameters.joints,
            offsets,
            _GuardContext(start, y, latched, o, row, roots, value[:, SINGLE_STATE]),
        )
        return
    _evaluate_joints(
        parameters.joints, parameters.joints, offsets, _GuardContext(start, y, latched, o, START, roots, value[:, 0])
    )
    for i in rolled_range(STAGES):
        at_stage = _GuardContext(start, nodes[:, i], latched, o, i, roots, value[:, 1 + i])
        _evaluate_joints(parameters.joints, parameters.joints, offsets, at_stage)


# ---------------------------------------------------------------------------------------------- latching


class _LatchContext(NamedTuple):
    """The state at an event and the arrays that latching changes."""

    y: np.ndarray  # (n,) state, changed
    latched: np.ndarray  # (contacts + l,) changed
    o: np.ndarray  # (columns, ROW_COUNT) observables
    row: int  # row of `o` with the observables of this state
    roots: int
    contact: int
    guard: int  # ENTERED, LEFT or the guard's number


@kernel
def _store_value(value, _, offsets, latched_values):
    latched_values[offsets] = value


_store_values = map_joints(_store_value, after_number)


@kernel
def _latch_part(part, _, offsets, context):
    if type(part.law) not in latched.members:
        return
    y, latched_values, o, row, roots, contact, guard = context
    is_guard_of_part = 0 <= guard - offsets.guard < after_part(offsets, part).guard - offsets.guard
    if offsets.contact + part.contact == contact and (guard < 0 or is_guard_of_part):
        law = with_current_state(part.law, y, latched_values, offsets)
        event = guard - offsets.guard if is_guard_of_part else guard
        values = latched(law, event, contact_observables_in(o, row, contact), y[roots + contact])
        destination, start = internal_state_location(part.law, y, latched_values, offsets)
        _store_values(values, values, start, destination)


_latch_parts = map_joints(_latch_part, after_part)


@kernel
def _latch_joint(joint, _, offsets, context):
    joint_parts = parts(joint)
    _latch_parts(joint_parts, joint_parts, offsets, context)


_latch_joints = map_joints(_latch_joint, after_joint)


def latch_entry(scene, y, latched, o, event, row):
    """Latch the laws' internal states at an event: change `y` and `latched`; observables are in row `row` of `o`.

    event : (2,) int64, the contact, and ENTERED, LEFT or the guard's number.
    """
    parameters = scene[0]
    roots, counts = 2 * len(parameters.coordinates) + 1, total_counts(parameters.joints)
    event_values = shaped(event, (2,))
    context = _LatchContext(
        shaped(y, (size_of(parameters)[1],)),
        shaped(latched, (counts.contact + counts.latched,)),
        shaped(o, (observed_width(parameters), ROW_COUNT)),
        row,
        roots,
        event_values[0],
        event_values[1],
    )
    joints = joints_at_event(parameters, context.y)
    _latch_joints(joints, joints, first_offsets(joints, roots), context)


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
    contact_guards = every_guard(joints)
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
    return arrays, any(type(law) in latched.members for _, law in every_part(joints))
