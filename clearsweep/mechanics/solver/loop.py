"""The integration loop: adaptive steps from event to event, everything that is wanted taken from them on the way."""

import math
from typing import NamedTuple

import numpy as np
from numba import config, njit, typeof

from ..compiled.family import NO_ENTRY, WIDTH, invoke, kernel
from ..compiled.kept import found
from ..compiled.rows import in_rows
from ..joint.contract import ENTERED, LEFT, ONSET_FLOOR, touches
from ..observe.along import ERROR, GOES_ON, LENGTH, WHOLE, advance, sum_up
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
    LOCATING,
    NOTHING,
    ONSET,
    REJECTED,
    SAMPLES,
    SEPARATION,
    SEPARATIONS,
    STEPS,
    STOP,
    attempt_to,
    travel_ratio,
)
from .newton import AFTER, RENEWED
from .newton import LENGTH as PAST_LENGTH
from .step import begin_step, finish_ends, go_through, land, latch, meet, take_step
from .step_control import GROW, MOST_TRIES, change_of_length, first_length, next_length, proposal_of, shrinking

AUTO = 2  # of Control.method
OK, STEP_BUDGET, EVENT_BUDGET, NOT_FINITE, STEP_UNDERFLOW, PAUSED, TURNS_STIFF, TIME_LIMIT, STALLED, GOING = range(10)
BACK = 0.01 * 2.0 * math.pi  # rad: how far a free crank may turn back, as it does for a moment when joints knock
HARDLY = 1e-4  # rad: how far it has to come in the time that it is given
SEED = 1e-9  # of sigma: the root of penetration at an onset, so that it is never exactly zero


class Control(NamedTuple):
    """When to stop, how accurate to be, and what to keep: numbers, that stand in Work.control in this order."""

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


WINDOW, LAST, PARTINGS, MOST_STEPS, MOST_EVENTS, KEEP_EVENTS, METHOD, PAUSE, STRETCH, LIMIT, PATIENCE = range(11)
# Work.ahead: length of the next step, 0 before the first; how much it may grow; its expected error; rejections in a
# row; evaluations before it; the step after which to pause; whether figures are taken; events logged; whether begun;
# where along the run the next step has to end; of a free crank how far it was, from where it has to move on, and since
# when (s)
NEXT, GROWTH, EXPECTED, TRIES, SPENT, REST, WINDOWED, LOGGED, BEGUN, STOP_AT, FARTHEST, ANGLE, SINCE = range(13)
# then whether a step is being taken again to end at an event; the share of the longer step, what event, of which
# contact, and evaluations before it
LANDING, SHARE, KIND, CONTACT, BEFORE, AHEAD = range(13, 19)
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
    if event.kind >= GUARD or work.control[KEEP_EVENTS] == 0.0:
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
def parting_too(at):
    """Return (SEPARATION, contact) of one that parts at the moment of an event, too, as corners of a block do.

    Its root of penetration is not above zero there, so no step could begin with it.  (NOTHING, 0) if there is none.
    """
    work = at[0]
    for j in range(work.mode.size):
        if touches(work.mode[j]) and work.end[work.time + 1 + j] <= 0.0:
            return SEPARATION, j
    return NOTHING, 0


@kernel
def pass_events(at, kind, contact, windowed):
    """Apply the event that was found and what happens at its moment, too; return GOING or the reason to end."""
    work = at[0]
    while kind != NOTHING:
        log_event(at, apply_event(at, kind, contact, windowed))
        if work.control[PARTINGS] > 0.0 and work.counts[SEPARATIONS] >= work.control[PARTINGS]:
            return OK
        if work.counts[EVENTS] >= work.control[MOST_EVENTS]:
            return EVENT_BUDGET
        kind, contact = parting_too(at)
    return GOING


@kernel
def advance_alone(at):
    """Go on from the end of a step where nothing has changed."""
    advance(in_rows(attempt_to(at, at[0].end), 1))


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
    here, moment = work.y[work.along], work.y[work.time]
    ahead[BEGUN], ahead[LOGGED], ahead[TRIES] = 1.0, 0.0, 0.0
    ahead[WINDOWED] = 1.0 if control[WINDOW] <= here else 0.0
    ahead[STOP_AT] = next_stop(at, here)
    ahead[FARTHEST], ahead[ANGLE], ahead[SINCE] = here, here, moment
    begin_step(at)  # after a pause the same again, unless the state was put elsewhere
    ahead[SPENT], ahead[REST] = work.counts[EVALUATIONS], work.counts[STEPS] + control[STRETCH]
    if ahead[NEXT] > 0.0:
        return
    tally.whole[KINETIC_START] = work.o[0, KINETIC]
    if ahead[WINDOWED] != 0.0:
        open_window(at)
    take_start(at)
    while work.counts[SAMPLES] < record.times.size and record.times[work.counts[SAMPLES]] <= work.y[record.along]:
        write_sample(at, work.y, record.samples[work.counts[SAMPLES]])
        work.counts[SAMPLES] += 1
    look_ahead(at, first_length(at, work.proposals, proposal_of(at)), 0.0)


@kernel
def look_ahead(at, length, expected):
    """Note the length of the next step and the error that is expected of it."""
    ahead = at[0].ahead
    ahead[NEXT], ahead[GROWTH], ahead[EXPECTED] = length, GROW, expected
    ahead[SPENT] = at[0].counts[EVALUATIONS]


@kernel
def target_of(at):
    """Return where along the run figures begin to be taken or, if they are, the run ends."""
    return at[0].control[LAST if at[0].ahead[WINDOWED] != 0.0 else WINDOW]


@kernel
def next_stop(at, here):
    """Return where along the run the next step has to end: the first knot beyond `here`, or the target."""
    target = target_of(at)
    for knot in at[0].knots:
        if knot > here:
            return min(knot, target)
    return target


@kernel
def interruption(at):
    """Return GOING where nothing keeps a case from its next step, else why it is not to be taken."""
    work = at[0]
    ahead, control = work.ahead, work.control
    moment, angle = work.y[work.time], work.y[work.along]
    full = ahead[LOGGED] + work.mode.size >= work.log.shape[0]  # all contacts may part at once
    if angle >= control[PAUSE] or work.counts[STEPS] >= ahead[REST] or full:
        return PAUSED
    if work.method[0] == IMPLICIT and work.slopes[0] == 0:
        return TURNS_STIFF
    if control[PATIENCE] == math.inf:
        return GOING
    if moment >= control[LIMIT]:
        return TIME_LIMIT
    ahead[FARTHEST] = max(ahead[FARTHEST], angle)
    if angle > ahead[ANGLE] + HARDLY:
        ahead[ANGLE], ahead[SINCE] = angle, moment
    stalled = ahead[FARTHEST] - angle > BACK or moment - ahead[SINCE] > control[PATIENCE]
    return STALLED if stalled else GOING


@kernel
def ready(at):
    """Return GOING where a case is to take a step, whose length then stands in `work.step`, else why not."""
    work = at[0]
    ahead = work.ahead
    if ahead[BEGUN] == 0.0:
        begin(at)
    if ahead[LANDING] != 0.0:
        return GOING
    if work.counts[STEPS] + work.counts[REJECTED] >= work.control[MOST_STEPS]:
        return STEP_BUDGET
    reason = interruption(at) if ahead[TRIES] == 0.0 else GOING
    if reason == GOING:
        ahead[NEXT] = min(ahead[NEXT], work.longest / work.o[0, KAPPA])
        work.step[LENGTH] = ahead[NEXT]
    return reason


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
def conclude_landing(at, h):
    """Take from the step to an event all that is wanted, and change what the event changes; return as `conclude`."""
    work = at[0]
    ahead, windowed = work.ahead, work.ahead[WINDOWED] != 0.0
    share, kind, contact = ahead[SHARE], int(ahead[KIND]), int(ahead[CONTACT])
    ahead[LANDING] = 0.0
    land(at, share, (kind, contact, ahead[STOP_AT]), h)
    work.counts[LOCATING] += work.counts[EVALUATIONS] - int(ahead[BEFORE])
    note_step(at, h, windowed, dense=False)
    if kind == STOP:
        if ahead[STOP_AT] == target_of(at):
            if windowed:
                return OK
            ahead[WINDOWED] = 1.0
            open_window(at)
        ahead[STOP_AT] = next_stop(at, work.end[work.along])
    else:
        reason = pass_events(at, kind, contact, windowed)
        if reason != GOING:
            return reason
    restart(at)
    look_ahead(at, first_length(at, work.proposals, proposal_of(at)), 0.0)
    return GOING


@kernel
def conclude(at):
    """Take from the step that was tried, see `work.step`, all that is wanted, or reject it; return GOING or the end."""
    work = at[0]
    ahead, control, proposals = work.ahead, work.control, work.proposals
    h, work.step[GOES_ON] = work.step[LENGTH], 0.0
    if ahead[LANDING] != 0.0:
        return conclude_landing(at, h)
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
    proposals[pattern] = h * change
    share, kind, contact, dense = meet(at, h, ahead[STOP_AT])
    if kind == NOTHING:
        note_step(at, h, windowed, dense)
        work.implicit.past[AFTER], work.implicit.past[RENEWED] = 1.0, 0.0
        work.step[GOES_ON] = 1.0
        look_ahead(at, next_length(at, h, proposals[pattern]), error * change**8)
        return GOING
    ahead[LANDING], ahead[SHARE], ahead[KIND], ahead[CONTACT] = 1.0, share, kind, contact
    ahead[BEFORE], work.step[LENGTH] = work.counts[EVALUATIONS], h * share
    return GOING


def compile_for(model, lanes):
    """Compile `integrate` for a Kept and arrays of these types, or load it from the cache."""
    cases = np.zeros(0, dtype=np.int64)
    if not config.DISABLE_JIT:
        integrate.compile(tuple(map(typeof, (model, cases, cases, NO_ENTRY, lanes))))


@njit(error_model="numpy", cache=True, nogil=True)  # so that a dask worker can tell that it is alive
def integrate(model, addresses, status, together, lanes):
    """Integrate cases from where they stand until one of them is to be looked at.  Never raises.

    Parameters
    ----------
    model : Kept, a Work; of what form all cases are.
    addresses : (cases,) int64, of their Works, kept as well, each in a lane of one Board.
    status : (cases,) int64, filled: GOING, OK or the reason why a case ended early; PAUSED, or TURNS_STIFF, its
        `work.slopes` being needed: call again to go on.
    together : the Entry that takes a step in every lane of the Board, see `attempt`; NO_ENTRY for one after the other.
    lanes : the arrays of the Board that it works on, those of its first lane.

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
            invoke(together.code, together.parameters, lanes, WHOLE)
            sum_up(in_rows(lanes, WIDTH))
        for c in range(addresses.size):
            at = found(model, addresses[c])
            if not beside or at[0].method[0] == IMPLICIT:
                take_step(at, at[0].step[LENGTH])
            else:
                at[0].counts[EVALUATIONS] += END
            status[c] = conclude(at)
            waits = waits or status[c] != GOING
            if not beside:
                advance_alone(at)
        if beside:
            advance(in_rows(lanes, WIDTH))
