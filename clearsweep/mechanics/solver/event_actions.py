"""Effects of an event: contacts begin and end, guards are passed; every event is logged."""

import math
from typing import NamedTuple

from ...tracing.compiled.family import kernel
from ..laws.contract import ENTERED, LEFT, ONSET_FLOOR, touches
from ..observe import END, contact_observables
from .integration import EVENT_BUDGET, GOING, GUARD, LEFT_BEARING, LIMIT, NOTHING, OK, ONSET, SEPARATION
from .step import latch, pass_guard

ONSET_ROOT = 1e-9  # of sigma: the root of penetration at an onset, so that it is never exactly zero


@kernel
def begin_contact(pointer, j, in_window):
    """Latch the onset rate of contact `j` at `work.end` and start its root of penetration."""
    work = pointer[0]
    totals, contact = work.totals, contact_observables(pointer, END, j)
    rate = max(contact.rate, 0.0)
    work.mode[j] = work.pressed[j]
    work.latched[j] = max(rate, ONSET_FLOOR)
    depth = max(contact.depth, 0.0)
    work.end[work.time + 1 + j] = max(math.sqrt(depth), ONSET_ROOT * work.sigma)
    latch(pointer, work.end, j, ENTERED, END)
    totals.joint[j].peak, totals.joint[j].approach = 0.0, rate
    if in_window:
        totals.joint[j].onsets += 1.0
        totals.joint[j].onset_max = max(totals.joint[j].onset_max, rate)
    return rate


@kernel
def end_contact(pointer, j):
    """Release contact `j` at `work.end` and reset its laws; return the rate of its gap, m/s, closing positive."""
    work = pointer[0]
    totals = work.totals
    rate = contact_observables(pointer, END, j).rate
    work.mode[j] = work.apart[j]
    latch(pointer, work.end, j, LEFT, END)
    work.end[work.time + 1 + j] = 0.0
    for i in range(work.reset_by.size):
        if work.reset_by[i] == j:
            work.end[work.time + 1 + work.mode.size + i] = work.initial_internal[i]
    work.counts.separations += 1
    if totals.joint[j].approach > ONSET_FLOOR:  # below, laws use the floor: the ratio is not theirs
        totals.joint[j].restitution -= rate / totals.joint[j].approach
        totals.joint[j].rebounds += 1.0
    return rate


class Event(NamedTuple):
    """An event of a contact in the log."""

    time: float  # s
    contact: int
    kind: int  # ONSET, SEPARATION, or GUARD plus the number of the guard
    rate: float  # m/s, closing positive
    force_peak: float  # N, largest force of the contact that ends


@kernel
def log_event(pointer, event):
    """Add an Event to the log, unless it is the passage of a guard or a limit."""
    work = pointer[0]
    if event.kind >= LIMIT or work.control.keep_events == 0.0:
        return
    row = int(work.stepper.logged)
    work.log[row, 0], work.log[row, 1], work.log[row, 2] = event.time, event.contact, event.kind
    work.log[row, 3], work.log[row, 4] = event.rate, event.force_peak
    work.stepper.logged += 1.0


@kernel
def apply_event(pointer, kind, j, in_window):
    """Apply the effects of an event at contact `j` at `work.end`; return the Event."""
    work = pointer[0]
    time, peak = work.end[work.time], work.totals.joint[j].peak
    if kind >= GUARD:
        g = kind - GUARD
        if in_window and work.guards.counted[g]:
            work.totals.joint[j].clips += 1.0
        pass_guard(pointer, g, work.end, END)
    if kind >= LIMIT:
        work.counts.passages += 1
        return Event(time, j, kind, 0.0, 0.0)
    work.counts.events += 1
    if kind == ONSET:
        return Event(time, j, kind, begin_contact(pointer, j, in_window), 0.0)
    return Event(time, j, kind, end_contact(pointer, j), peak)


@kernel
def simultaneous_separation(pointer):
    """Return (SEPARATION, contact) of a contact that separates at the time of another event, or (NOTHING, 0).

    An example is a corner of a block.  No step could begin with its root of penetration, which is not positive.
    """
    work = pointer[0]
    for j in range(work.mode.size):
        if touches(work.mode[j]) and work.end[work.time + 1 + j] <= 0.0:
            return SEPARATION, j
    return NOTHING, 0


@kernel
def pass_events(pointer, kind, contact, in_window):
    """Apply an event and all others at the same time; return GOING or the reason to end the run."""
    work = pointer[0]
    while kind != NOTHING:
        log_event(pointer, apply_event(pointer, kind, contact, in_window))
        if work.control.separations > 0.0 and work.counts.separations >= work.control.separations:
            return OK
        if work.counts.events >= work.control.event_budget:
            return EVENT_BUDGET
        if kind >= GUARD and work.guards.ends_run[kind - GUARD]:
            return LEFT_BEARING
        kind, contact = simultaneous_separation(pointer)
    return GOING
