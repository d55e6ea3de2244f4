"""The guards of a scene's laws, and what the laws keep of events, as the loop calls them: by address.

Only a scene whose laws give the values of guards has code for them, and only one whose laws keep something has code for
that.
"""

from typing import NamedTuple

import numpy as np

from ..compiled.choosing import turns
from ..compiled.family import NO_ENTRY, Entry, entry, form_number, kernel, map_joints, shaped
from ..joint.contract import every_guard, every_part, guard_values, latched, parts
from ..joint.places import (
    after_joint,
    after_number,
    after_part,
    extent,
    first_place,
    where_internal,
    with_current_state,
)
from ..observe.observables import column_of, observed_in
from ..observe.stages import END, PLACES, STAGES, START
from ..solver.guarding import ELSEWHERE
from .impact_mass import joints_at_event
from .rates import observed_width


class Guards(NamedTuple):
    """The guards of all joints of a scene, g of them, in the order of their parts; see `contract.Guard`."""

    evaluate: Entry  # puts the values of guards that laws give into `value`; NO_ENTRY where there is none
    latch: Entry  # lets laws latch what they keep of an event; NO_ENTRY where none keeps anything
    contact: np.ndarray  # (g,) int64, at which it acts
    modes: np.ndarray  # (g,) int64, bit m: it is looked at in mode m
    leads_to: np.ndarray  # (g,) int64
    at_start: np.ndarray  # (g,) bool, likewise the next two
    counted: np.ndarray
    ends_run: np.ndarray
    column: np.ndarray  # (g,) int64, that of the observable that it is, -1 where its law gives the value
    sign: np.ndarray  # (g,) by which that is multiplied
    value: np.ndarray  # (g, ELSEWHERE + 1) values of the guards at the nodes of the step in hand, and at another state
    event: np.ndarray  # (2,) int64, what `latch` is called for: the contact and ENTERED, LEFT or the number of a guard


# ---------------------------------------------------------------------------------------------- the values


class _Values(NamedTuple):
    """What the values of guards are made of."""

    y: np.ndarray  # (n,) state
    latched: np.ndarray  # (contacts + l,)
    o: np.ndarray  # (columns, PLACES) observables
    row: int  # the row of `o` at the state
    roots: int  # where the roots of penetration begin in `y`
    value: np.ndarray  # (g,) for the results


@kernel
def _put(value, _, place, out):
    out[place] = value


_put_each = map_joints(_put, after_number)


@kernel
def _evaluate_part(part, _, place, shared):
    if type(part.law) not in guard_values.members:
        return
    y, latched, o, row, roots, value = shared
    contact = place.contact + part.contact
    law, root = with_current_state(part.law, y, latched, place), y[roots + contact]
    values = guard_values(law, observed_in(o, START, contact), observed_in(o, row, contact), root)
    _put_each(values, values, place.guard, value)


_evaluate_parts = map_joints(_evaluate_part, after_part)


@kernel
def _evaluate_joint(joint, _, place, shared):
    every = parts(joint)
    _evaluate_parts(every, every, place, shared)


_evaluate_joints = map_joints(_evaluate_joint, after_joint)


def guards_entry(scene, y, nodes, latched, o, value, row):
    """Put the values of guards that laws give into `value`, see `solver.guarding.evaluate_guards`.

    Arrays are bare pointers; `scene` points at the Scene.
    """
    here = scene[0]
    roots, size = 2 * len(here.coordinates) + 1, extent(here.joints)
    n = roots + size.contact + size.internal
    y, nodes = shaped(y, (n,)), shaped(nodes, (n + 1, STAGES))
    latched, o = shaped(latched, (size.contact + size.latched,)), shaped(o, (observed_width(here), PLACES))
    value, first = shaped(value, (size.guard, ELSEWHERE + 1)), first_place(here.joints, roots)
    if row != END:
        _evaluate_joints(here.joints, here.joints, first, _Values(y, latched, o, row, roots, value[:, ELSEWHERE]))
        return
    _evaluate_joints(here.joints, here.joints, first, _Values(y, latched, o, START, roots, value[:, 0]))
    for i in turns(STAGES):
        at_stage = _Values(nodes[:, i], latched, o, i, roots, value[:, 1 + i])
        _evaluate_joints(here.joints, here.joints, first, at_stage)


# ---------------------------------------------------------------------------------------------- latching


class _Event(NamedTuple):
    """An event at which laws latch."""

    y: np.ndarray  # (n,) state, changed
    latched: np.ndarray  # (contacts + l,) changed
    o: np.ndarray  # (columns, PLACES) observables
    row: int  # the row of `o` at the state
    roots: int
    contact: int
    guard: int  # ENTERED, LEFT or the number of the guard


@kernel
def _set(value, _, place, numbers):
    numbers[place] = value


_set_each = map_joints(_set, after_number)


@kernel
def _latch_part(part, _, place, shared):
    if type(part.law) not in latched.members:
        return
    y, numbers, o, row, roots, contact, guard = shared
    mine = 0 <= guard - place.guard < after_part(place, part).guard - place.guard
    if place.contact + part.contact == contact and (guard < 0 or mine):
        law = with_current_state(part.law, y, numbers, place)
        kind = guard - place.guard if mine else guard
        values = latched(law, kind, observed_in(o, row, contact), y[roots + contact])
        where, first = where_internal(part.law, y, numbers, place)
        _set_each(values, values, first, where)


_latch_parts = map_joints(_latch_part, after_part)


@kernel
def _latch_joint(joint, _, place, shared):
    every = parts(joint)
    _latch_parts(every, every, place, shared)


_latch_joints = map_joints(_latch_joint, after_joint)


def latch_entry(scene, y, latched, o, event, row):
    """Let the laws latch what they keep of an event, from and into `y` and `latched`; observables in row `row` of `o`.

    event : (2,) int64, the contact and ENTERED, LEFT or the number of the guard.
    """
    here = scene[0]
    roots, size = 2 * len(here.coordinates) + 1, extent(here.joints)
    which = shaped(event, (2,))
    shared = _Event(
        shaped(y, (roots + size.contact + size.internal,)),
        shaped(latched, (size.contact + size.latched,)),
        shaped(o, (observed_width(here), PLACES)),
        row,
        roots,
        which[0],
        which[1],
    )
    joints = joints_at_event(here, shared.y)
    _latch_joints(joints, joints, first_place(joints, roots), shared)


# ---------------------------------------------------------------------------------------------- for a scene


def guards_of(scene, parameters, zeros=np.zeros) -> Guards:
    """Return the Guards of the compiled `scene`; `parameters` : what `flatten(scene)` gave; `zeros` makes arrays."""
    key = form_number(scene)
    if key not in _LISTED:
        _LISTED[key] = _listed(scene.joints)
    listed, latching = _LISTED[key]
    count = listed["contact"].size
    return Guards(
        evaluate=entry(guards_entry, scene, "fffff", parameters) if -1 in listed["column"] else NO_ENTRY,
        latch=entry(latch_entry, scene, "fffi", parameters) if latching else NO_ENTRY,
        value=zeros((count, ELSEWHERE + 1)),
        event=zeros(2, dtype=np.int64),
        **listed,
    )


_LISTED: dict[int, tuple[dict[str, np.ndarray], bool]] = {}  # number of the form of a scene -> what `_listed` returns


def _listed(joints) -> tuple[dict[str, np.ndarray], bool]:
    """Return what Guards says of each guard, and whether a law keeps anything: the types of the laws decide that."""
    listed = every_guard(joints)
    each = [guard for _, guard in listed]
    flags = ("at_start", "counted", "ends_run")
    arrays = {
        "contact": np.array([contact for contact, _ in listed], dtype=np.int64),
        "modes": np.array([sum(1 << mode for mode in guard.modes) for guard in each], dtype=np.int64),
        "leads_to": np.array([guard.leads_to for guard in each], dtype=np.int64),
    }
    arrays["column"] = np.array(
        [column_of(contact, guard.observable) if guard.observable >= 0 else -1 for contact, guard in listed], np.int64
    )
    arrays["sign"] = np.array([guard.sign for guard in each], dtype=np.float64)
    arrays |= {name: np.array([getattr(guard, name) for guard in each], dtype=np.int64) for name in flags}
    return arrays, any(type(law) in latched.members for _, law in every_part(joints))
