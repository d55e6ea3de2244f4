"""The integration loop: adaptive steps from event to event, everything that is wanted taken from them on the way."""

import math
from typing import NamedTuple

import numpy as np
from numba import config, njit, typeof
from numba.extending import register_jitable

from ..compiled.family import kernel, pointer_to
from ..joint.contract import ENTERED, LEFT, ONSET_FLOOR, touches
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
from ..observe.turns import take_start
from .choice import choose_method
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
    SEPARATION,
    SEPARATIONS,
    STEPS,
    STOP,
    travel_ratio,
)
from .newton import AFTER, LENGTH, RENEWED
from .step import begin_step, finish_ends, go_through, latch, meet, take_step
from .step_control import GROW, TRIES, change_of_length, first_length, next_length, proposal_of, shrinking

AUTO = 2  # of Control.method
OK, STEP_BUDGET, EVENT_BUDGET, NOT_FINITE, STEP_UNDERFLOW, PAUSED, TURNS_STIFF, TIME_LIMIT, STALLED = range(9)
GOING_ON = -1  # no status: there is no reason to end
BACK = 0.01 * 2.0 * math.pi  # rad: how far a free crank may turn back, as it does for a moment when joints knock
HARDLY = 1e-4  # rad: how far it has to come in the time that it is given
SEED = 1e-9  # of sigma: the root of penetration at an onset, so that it is never exactly zero


class Control(NamedTuple):
    """When to stop, how accurate to be, and what to keep."""

    window: float  # s, or rad of a free crank: where figures begin to be taken
    end: float  # the same: where to stop
    separations: int  # stop after so many; 0: never
    step_budget: int
    event_budget: int
    keep_events: bool
    method: int  # AUTO, or EXPLICIT or IMPLICIT throughout
    pause: float = math.inf  # the same: return PAUSED at the first step end from here on; called again, go on
    stretch: int = 1 << 16  # steps after which to return PAUSED, too, so that whoever called can look at the clock
    limit: float = math.inf  # s, after which to give up
    patience: float = math.inf  # s, within which a free crank has to move on; inf: it is not free


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


@register_jitable(error_model="numpy")
def log_event(events, count, event):
    """Return the event log with an Event behind its first `count` rows, unless it is the passage of a guard."""
    if event.kind >= GUARD:
        return events
    if count == events.shape[0]:
        longer = np.empty((2 * count, 5))
        for row in range(count):
            for column in range(5):
                longer[row, column] = events[row, column]
        events = longer
    events[count, 0], events[count, 1], events[count, 2] = event.time, event.contact, event.kind
    events[count, 3], events[count, 4] = event.rate, event.force_peak
    return events


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
def parting_too(at):
    """Return (SEPARATION, contact) of one that parts at the moment of an event, too, as corners of a block do.

    Its root of penetration is not above zero there, so no step could begin with it.  (NOTHING, 0) if there is none.
    """
    work = at[0]
    for j in range(work.mode.size):
        if touches(work.mode[j]) and work.end[work.time + 1 + j] <= 0.0:
            return SEPARATION, j
    return NOTHING, 0


@register_jitable(error_model="numpy")
def pass_events(at, control, found, log):
    """Apply the event that was found, (kind, contact, whether figures are taken), and what happens at its moment, too.

    log : (events, how many were counted before the first of them).  Returns the log's events and the reason to end.
    """
    kind, contact, windowed = found
    events, earlier = log
    work = at[0]
    while kind != NOTHING:
        count, event = work.counts[EVENTS] - earlier, apply_event(at, kind, contact, windowed)
        events = log_event(events, count, event) if control.keep_events else events
        if control.separations > 0 and work.counts[SEPARATIONS] >= control.separations:
            return events, OK
        if work.counts[EVENTS] >= control.event_budget:
            return events, EVENT_BUDGET
        kind, contact = parting_too(at)
    return events, GOING_ON


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
    work.implicit.past[LENGTH], work.implicit.past[RENEWED] = 0.0, 0.0
    begin_step(at)


@kernel
def begin(at, windowed):
    """Return the first step's length, growth and expected error: after a pause what was to come, else a guess."""
    work = at[0]
    tally, record = work.tally, work.record
    begin_step(at)  # after a pause the same again, unless the state was put elsewhere
    if work.ahead[0] > 0.0:
        return work.ahead[0], work.ahead[1], work.ahead[2]
    tally.whole[KINETIC_START] = work.o[0, KINETIC]
    if windowed:
        open_window(at)
    take_start(at)
    while work.counts[SAMPLES] < record.times.size and record.times[work.counts[SAMPLES]] <= work.y[record.along]:
        write_sample(at, work.y, record.samples[work.counts[SAMPLES]])
        work.counts[SAMPLES] += 1
    return first_length(at, work.proposals, proposal_of(at)), GROW, 0.0


@kernel
def next_stop(at, here, target):
    """Return where along the run the next step has to end: the first knot beyond `here`, or the `target`."""
    for knot in at[0].knots:
        if knot > here:
            return min(knot, target)
    return target


@kernel
def interruption(at, control, rest, progress):
    """Return why not to take the next step, OK if to take it; `rest`: a number of steps after which to pause.

    progress : (3,) farthest angle (rad) of a free crank, angle from which it has to move on and time (s) it began to.
    """
    work = at[0]
    moment, angle = work.y[work.time], work.y[work.along]
    if angle >= control.pause or work.counts[STEPS] >= rest:
        return PAUSED
    if work.method[0] == IMPLICIT and work.slopes[0] == 0:
        return TURNS_STIFF
    if control.patience == math.inf:
        return OK
    if moment >= control.limit:
        return TIME_LIMIT
    progress[0] = max(progress[0], angle)
    if angle > progress[1] + HARDLY:
        progress[1], progress[2] = angle, moment
    return STALLED if progress[0] - angle > BACK or moment - progress[2] > control.patience else OK


def compile_for(control, work):
    """Compile `integrate` for values of these types, or load it from the cache."""
    if not config.DISABLE_JIT:
        integrate.compile((typeof(control), typeof(work)))


@njit(error_model="numpy", cache=True, nogil=True)  # so that a dask worker can tell that it is alive
def integrate(control, work):
    """Integrate from the state in `work.y` to the end that `control` sets.  Every other function works on `at[0]`.

    Returns
    -------
    status : int, OK or the reason why it ended early; PAUSED, or
        TURNS_STIFF, `work.slopes` being needed: call again to go on
    events : (events, 5) float64, rows of time (s), contact, 1 onset or 2 separation, rate (m/s), force peak (N)

    The figures are in `work.tally`, the samples in `work.record`.  Never raises; a failure is a status.
    """
    at, along, proposals = pointer_to(work), work.along, work.proposals
    events, earlier = np.empty((64 if control.keep_events else 0, 5)), work.counts[EVENTS]
    windowed = control.window <= work.y[along]
    target = control.end if windowed else control.window
    stop, progress = next_stop(at, work.y[along], target), np.array([work.y[along], work.y[along], work.y[work.time]])
    h, grow, expected = begin(at, windowed)
    tries, spent, rest = 0, work.counts[EVALUATIONS], work.counts[STEPS] + control.stretch
    while work.counts[STEPS] + work.counts[REJECTED] < control.step_budget:
        reason = OK if tries else interruption(at, control, rest, progress)
        if reason != OK:
            work.ahead[0], work.ahead[1], work.ahead[2] = h, grow, expected
            return reason, events[: work.counts[EVENTS] - earlier]
        h = min(h, work.longest / work.o[0, KAPPA])
        error = take_step(at, h)
        error = max(error, travel_ratio(at, h) ** 8)  # the step control takes the eighth root
        if not error < 1.0:
            work.counts[REJECTED] += 1
            h *= shrinking(error)
            grow, tries = 1.0, tries + 1
            if tries > TRIES:
                return (STEP_UNDERFLOW if math.isfinite(error) else NOT_FINITE), events[: work.counts[EVENTS] - earlier]
            continue
        tries = 0
        finish_ends(at)
        pattern = proposal_of(at)
        if control.method == AUTO:
            choose_method(at, h, proposals[pattern & ~(1 << work.mode.size)], work.counts[EVALUATIONS] - spent)
        change = min(grow, change_of_length(error, expected))
        proposals[pattern], expected = h * change, error * change**8
        kind, contact, taken, dense = meet(at, h, stop)
        note_step(at, taken, windowed, dense)
        if kind == NOTHING:
            go_on(at)
            h, grow = next_length(at, h, proposals[pattern]), GROW
            spent = work.counts[EVALUATIONS]
            continue
        if kind == STOP:
            if stop == target:
                if windowed:
                    return OK, events[: work.counts[EVENTS] - earlier]
                windowed, target = True, control.end
                open_window(at)
            stop = next_stop(at, work.end[along], target)
        else:
            events, reason = pass_events(at, control, (kind, contact, windowed), (events, earlier))
            if reason != GOING_ON:
                return reason, events[: work.counts[EVENTS] - earlier]
        restart(at)
        h, grow, expected = first_length(at, proposals, proposal_of(at)), GROW, 0.0
        spent = work.counts[EVALUATIONS]
    return STEP_BUDGET, events[: work.counts[EVENTS] - earlier]
