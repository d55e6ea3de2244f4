"""The integration loop: adaptive steps from event to event, everything that is wanted taken from them on the way."""

import math
from typing import NamedTuple

from numba import njit

from ..compiled.family import invoke, kernel
from ..compiled.kept import found
from ..joint.contract import ENTERED, LEFT, ONSET_FLOOR
from ..observe.along import ERROR, LENGTH
from ..observe.observables import KAPPA, KINETIC, observed
from ..observe.record import write_sample
from ..observe.tally import (
    APPROACH,
    CLIPS,
    KINETIC_START,
    ONSET_MAX,
    ONSETS,
    PEAK,
    REBOUNDS,
    RESTITUTION,
    note_step,
    open_window,
)
from .dop853 import END
from .event import (
    EVALUATIONS,
    EVENTS,
    GUARD,
    IMPLICIT,
    NOTHING,
    ONSET,
    REJECTED,
    SAMPLES,
    SEPARATIONS,
    STEPS,
    STOP,
    travel_ratio,
)
from .newton import AFTER, RENEWED, choose_method
from .newton import LENGTH as PAST_LENGTH
from .step import begin_step, finish_ends, go_through, latch, meet, take_step
from .step_control import GROW, MOST_TRIES, change_of_length, first_length, next_length, proposal_of, shrinking

AUTO = 2  # of Control.method
OK, STEP_BUDGET, EVENT_BUDGET, NOT_FINITE, STEP_UNDERFLOW, PAUSED, TURNS_STIFF, GOING = range(8)
SEED = 1e-9  # of sigma: the root of penetration at an onset, so that it is never exactly zero


class Control(NamedTuple):
    """When to stop, how accurate to be, and what to keep: numbers, that stand in Work.control in this order."""

    window: float  # s, where figures begin to be taken
    end: float  # s
    separations: int  # stop after so many; 0: never
    step_budget: int
    event_budget: int
    keep_events: bool
    method: int  # AUTO, or EXPLICIT or IMPLICIT throughout
    pause: float = math.inf  # s, return PAUSED at the first step end from here on; called again, go on undisturbed
    stretch: int = 1 << 16  # steps after which to return PAUSED, too, so that whoever called can look at the clock


WINDOW, END_AT, SEPARATIONS_AT, STEP_BUDGET_AT, EVENT_BUDGET_AT, KEEP_EVENTS, METHOD, PAUSE, STRETCH = range(9)
# Work.ahead: length of the next step, 0 before the first; how much it may grow; its expected error; rejections in a
# row; evaluations before it; the step after which to pause; whether figures are taken; events logged; whether begun
NEXT, GROWTH, EXPECTED, TRIES, SPENT, REST, WINDOWED, LOGGED, BEGUN, AHEAD = range(10)
LOG = 512  # events that are logged before whoever called has to take them away
WORTH = 3  # cases: fewer take their steps one after the other, as that is faster


@kernel
def begin_contact(at, j, windowed):
    """Latch the onset rate of contact `j` at `work.end` and start its root of penetration."""
    work = at[0]
    tally, seen = work.tally, observed(at, END, j)
    rate = max(seen.rate, 0.0)
    work.mode[j] = work.pressed[j]
    work.latched[j] = max(rate, ONSET_FLOOR)
    depth = max(seen.depth, 0.0)
    work.end[work.time + 1 + j] = max(math.sqrt(depth), SEED * work.sigma)
    latch(at, work.end, j, ENTERED, END)
    tally.joint[j, PEAK], tally.joint[j, APPROACH] = 0.0, rate
    if windowed:
        tally.joint[j, ONSETS] += 1.0
        tally.joint[j, ONSET_MAX] = max(tally.joint[j, ONSET_MAX], rate)
    return rate


@kernel
def end_contact(at, j):
    """Release contact `j` at `work.end`, its laws forgetting; return the rate of its gap, m/s, closing positive."""
    work = at[0]
    tally = work.tally
    rate = observed(at, END, j).rate
    work.mode[j] = work.apart[j]
    latch(at, work.end, j, LEFT, END)
    work.end[work.time + 1 + j] = 0.0
    for i in range(work.ended_by.size):
        if work.ended_by[i] == j:
            work.end[work.time + 1 + work.mode.size + i] = work.began[i]
    work.counts[SEPARATIONS] += 1
    if tally.joint[j, APPROACH] > ONSET_FLOOR:  # below, laws work with the floor and give back something else
        tally.joint[j, RESTITUTION] -= rate / tally.joint[j, APPROACH]
        tally.joint[j, REBOUNDS] += 1.0
    return rate


class Event(NamedTuple):
    """What changed at a contact: onsets and separations are logged like this."""

    time: float  # s
    contact: int
    kind: int  # ONSET, SEPARATION, or GUARD and the number of the guard
    rate: float  # m/s, closing positive
    force_peak: float  # N, of the contact that ends


@kernel
def log_event(at, event):
    """Enter an Event into the log, unless it is the passage of a guard."""
    work = at[0]
    if event.kind >= GUARD:
        return
    row = int(work.ahead[LOGGED])
    work.log[row, 0], work.log[row, 1], work.log[row, 2] = event.time, event.contact, event.kind
    work.log[row, 3], work.log[row, 4] = event.rate, event.force_peak
    work.ahead[LOGGED] += 1.0


@kernel
def apply_event(at, kind, j, windowed):
    """Change what an event at contact `j` changes at `work.end`; return the Event."""
    work = at[0]
    moment, peak = work.end[work.time], work.tally.joint[j, PEAK]
    if kind >= GUARD:
        g = kind - GUARD
        if windowed and work.guards.counted[g]:
            work.tally.joint[j, CLIPS] += 1.0
        go_through(at, g, work.end, END)
        return Event(moment, j, kind, 0.0, 0.0)
    work.counts[EVENTS] += 1
    if kind == ONSET:
        return Event(moment, j, kind, begin_contact(at, j, windowed), 0.0)
    return Event(moment, j, kind, end_contact(at, j), peak)


@kernel
def go_on(at):
    """Make the end of a step the start of the next."""
    work = at[0]
    work.implicit.past[AFTER], work.implicit.past[RENEWED] = 1.0, 0.0
    for i in range(work.y.size):
        work.y[i], work.k[0, i] = work.end[i], work.k[END, i]
    for column in range(work.o.shape[1]):
        work.o[0, column] = work.o[END, column]


@kernel
def restart(at):
    """Begin a step at `work.end`, where something has changed."""
    work = at[0]
    for i in range(work.y.size):
        work.y[i] = work.end[i]
    work.method[0], work.method[1] = work.method[2], 0
    work.implicit.past[PAST_LENGTH], work.implicit.past[RENEWED] = 0.0, 0.0
    begin_step(at)


@kernel
def begin(at):
    """Make a case ready for its first step, or for the next after a pause: as if there had been none."""
    work = at[0]
    tally, record, ahead, control = work.tally, work.record, work.ahead, work.control
    ahead[BEGUN], ahead[LOGGED], ahead[TRIES] = 1.0, 0.0, 0.0
    ahead[WINDOWED] = 1.0 if control[WINDOW] <= work.y[work.time] else 0.0
    begin_step(at)  # after a pause the same again, unless the state was put elsewhere
    ahead[SPENT], ahead[REST] = work.counts[EVALUATIONS], work.counts[STEPS] + control[STRETCH]
    if ahead[NEXT] > 0.0:
        return
    tally.whole[KINETIC_START] = work.o[0, KINETIC]
    if ahead[WINDOWED] != 0.0:
        open_window(at)
    while work.counts[SAMPLES] < record.times.size and record.times[work.counts[SAMPLES]] <= work.y[work.time]:
        write_sample(at, work.y, record.samples[work.counts[SAMPLES]])
        work.counts[SAMPLES] += 1
    ahead[NEXT], ahead[GROWTH], ahead[EXPECTED] = first_length(at, work.proposals, proposal_of(at)), GROW, 0.0


@kernel
def ready(at):
    """Return GOING where a case is to take a step, whose length then stands in `work.step`, else why not."""
    work = at[0]
    ahead, control = work.ahead, work.control
    if ahead[BEGUN] == 0.0:
        begin(at)
    if work.counts[STEPS] + work.counts[REJECTED] >= control[STEP_BUDGET_AT]:
        return STEP_BUDGET
    if ahead[TRIES] == 0.0:
        waits = work.y[work.time] >= control[PAUSE] or work.counts[STEPS] >= ahead[REST]
        if waits or ahead[LOGGED] >= work.log.shape[0]:
            return PAUSED
    if work.method[0] == IMPLICIT and work.slopes[0] == 0:
        return TURNS_STIFF
    ahead[NEXT] = min(ahead[NEXT], work.longest / work.o[0, KAPPA])
    work.step[LENGTH] = ahead[NEXT]
    return GOING


@kernel
def begin_again(at):
    """Make ready for the first step after something has changed at the end of the one before."""
    work = at[0]
    restart(at)
    work.ahead[NEXT], work.ahead[GROWTH], work.ahead[EXPECTED] = (
        first_length(at, work.proposals, proposal_of(at)),
        GROW,
        0.0,
    )
    work.ahead[SPENT] = work.counts[EVALUATIONS]


@kernel
def reject(at, h, error):
    """Shorten a step of length `h` whose error was too large; return GOING, or why that helps no more."""
    work = at[0]
    ahead = work.ahead
    work.counts[REJECTED] += 1
    ahead[NEXT], ahead[GROWTH], ahead[TRIES] = h * shrinking(error), 1.0, ahead[TRIES] + 1.0
    if ahead[TRIES] > MOST_TRIES:
        return STEP_UNDERFLOW if math.isfinite(error) else NOT_FINITE
    return GOING


@kernel
def conclude(at):
    """Take from the step that was tried, see `work.step`, all that is wanted, or reject it; return GOING or the end."""
    work = at[0]
    ahead, control, proposals = work.ahead, work.control, work.proposals
    h = work.step[LENGTH]
    error = max(work.step[ERROR], travel_ratio(at, h) ** 8)  # the step control takes the eighth root
    if not error < 1.0:
        return reject(at, h, error)
    ahead[TRIES] = 0.0
    finish_ends(at)
    pattern, windowed = proposal_of(at), ahead[WINDOWED] != 0.0
    if control[METHOD] == AUTO:
        cost = work.counts[EVALUATIONS] - int(ahead[SPENT])
        choose_method(at, h, proposals[pattern & ~(1 << work.mode.size)], cost)
    change = min(ahead[GROWTH], change_of_length(error, ahead[EXPECTED]))
    proposals[pattern], ahead[EXPECTED] = h * change, error * change**8
    kind, contact, taken, dense = meet(at, h, control[END_AT] if windowed else control[WINDOW])
    note_step(at, taken, windowed, dense)
    if kind == NOTHING:
        go_on(at)
        ahead[NEXT], ahead[GROWTH] = next_length(at, h, proposals[pattern]), GROW
        ahead[SPENT] = work.counts[EVALUATIONS]
        return GOING
    if kind == STOP:
        if windowed:
            return OK
        ahead[WINDOWED] = 1.0
        open_window(at)
    else:
        event = apply_event(at, kind, contact, windowed)
        if control[KEEP_EVENTS] != 0.0:
            log_event(at, event)
        if control[SEPARATIONS_AT] > 0.0 and work.counts[SEPARATIONS] >= control[SEPARATIONS_AT]:
            return OK
        if work.counts[EVENTS] >= control[EVENT_BUDGET_AT]:
            return EVENT_BUDGET
    begin_again(at)
    return GOING


@njit(error_model="numpy", cache=True, nogil=True)  # so that a dask worker can tell that it is alive
def integrate(model, addresses, status, together, table):
    """Integrate cases from where they stand until one of them is to be looked at.  Never raises.

    Parameters
    ----------
    model : Kept, a Work; of what form all cases are.
    addresses : (cases,) int64, of their Works, kept as well.
    status : (cases,) int64, filled: GOING, OK or the reason why a case ended early; PAUSED, or TURNS_STIFF, its
        `work.slopes` being needed: call again to go on.
    together : the Entry that takes steps side by side, see `attempt`; NO_ENTRY for one after the other.
    table : (width, arrays) int64, room for the addresses that it reads.

    Figures are in the `tally` of each Work, samples in its `record`, events in its `log`.  Which cases go side by side
    has no part in what comes out: see `attempt`.
    """
    waits = False
    while not waits:
        explicit = 0
        for c in range(addresses.size):
            at = found(model, addresses[c])
            status[c] = ready(at)
            waits = waits or status[c] != GOING
            explicit += at[0].method[0] != IMPLICIT
        if waits:
            return
        beside = together.code != 0 and explicit >= WORTH
        if beside:
            side_by_side(model, addresses, together, table)
        for c in range(addresses.size):
            at = found(model, addresses[c])
            if not beside or at[0].method[0] == IMPLICIT:
                at[0].step[ERROR] = take_step(at, at[0].step[LENGTH])
            status[c] = conclude(at)
            waits = waits or status[c] != GOING


@kernel
def side_by_side(model, addresses, together, table):
    """Take a step of every case that is integrated by the explicit method; idle lanes do again what another does."""
    lane, last = 0, 0
    for c in range(addresses.size):
        at = found(model, addresses[c])
        if at[0].method[0] != IMPLICIT:
            for which in range(table.shape[1]):
                table[lane, which] = at[0].addresses[which]
            at[0].counts[EVALUATIONS] += END
            lane, last = lane + 1, lane
    for idle in range(lane, table.shape[0]):
        for which in range(table.shape[1]):
            table[idle, which] = table[last, which]
    invoke(together.code, together.parameters, (table,), 0)
