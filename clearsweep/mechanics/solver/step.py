"""One step: its stages, its dense output, and the step again where an event cuts it short."""

from ..compiled.family import inlined, invoke, kernel
from ..compiled.rows import in_rows
from ..joint.contract import SAME
from ..observe.observables import KAPPA, observed
from .accumulate.step_sums import (
    ERROR,
    FASTEST,
    LENGTH,
    WHOLE,
    follow_along,
    keep_last_stage,
    look_for_peaks,
    look_for_speeds,
    sum_along,
    sum_of,
    sum_up,
)
from .dop853 import END, dense_coefficients, stage_state
from .event import (
    EVALUATIONS,
    IMPLICIT,
    LOCATING,
    ONSET,
    SEPARATION,
    STOP,
    attempt_to,
    evaluate,
    first_event,
)
from .guarding import evaluate_guards, looked_at
from .newton import FAILED, fall_back, implicit_step
from .radau import STAGE_WEIGHTS


@kernel
def latch(at, y, contact, guard, row):
    """Let the laws of a contact latch what they keep of an event: ENTERED, LEFT or the passage of a guard."""
    work, guards = at[0], at[0].guards
    if guards.latch.code != 0:
        guards.event[0], guards.event[1] = contact, guard
        invoke(guards.latch.code, guards.latch.parameters, (y, work.latched, work.o, guards.event), row)


@kernel
def go_through(at, g, y, row):
    """Change what the passage of guard `g` changes, at the state `y` whose observables are in row `row`."""
    work, guards = at[0], at[0].guards
    contact = guards.contact[g]
    if guards.leads_to[g] != SAME:
        work.mode[contact] = guards.leads_to[g]
    latch(at, y, contact, g, row)


@kernel
def begin_step(at):
    """Evaluate the start of a step at which something has changed, and pass the guards that are passed there."""
    work, guards = at[0], at[0].guards
    evaluate(at, work.y, 0)
    changed, waiting = False, True
    for g in range(guards.contact.size):
        if guards.at_start[g] and looked_at(at, g):
            if waiting:
                evaluate_guards(at, work.y, 0)
                waiting = False
            if guards.value[0, g] > 0.0:
                go_through(at, g, work.y, 0)
                changed = True
    if changed:
        evaluate(at, work.y, 0)


@inlined
def take_stage(at, h, row):
    """Fill a row of rates and observables; those below are there already."""
    stage_state(row, h, at[0].y, at[0].k, at[0].z)
    evaluate(at, at[0].z, row)


@kernel
def run_stages(at, h, first, last):
    """Fill rows `first` to `last` - 1 of rates and observables; row 0 is there already."""
    for row in range(first, last):
        take_stage(at, h, row)


@kernel
def finish_dense(at, h):
    """Make the dense output of the step that has just been taken."""
    work = at[0]
    if work.method[0] == IMPLICIT:
        return  # the implicit step made it
    take_stage(at, h, END + 1)  # one by one: of each row alone its formula is compiled
    take_stage(at, h, END + 2)
    take_stage(at, h, END + 3)
    dense_coefficients(h, work.y, work.end, work.k, work.f)


@kernel
def with_dense(at, h, dense):
    """Make the dense output unless it is there; return that it is."""
    if not dense:
        finish_dense(at, h)
    return True


@kernel
def finish_ends(at):
    """Evaluate the rates and observables at the end of a step and sum up; an explicit one has done so."""
    work = at[0]
    if work.method[0] == IMPLICIT:
        evaluate(at, work.end, END)
        tried = in_rows(attempt_to(at, work.end), 1)
        sum_along(tried, STAGE_WEIGHTS)
        follow_along(tried)
        look_for_peaks(tried)


@kernel
def take_step(at):
    """Take the step whose length is in `work.step`: fill `work.end`, row END and what the step comes to."""
    work, h = at[0], at[0].step[LENGTH]
    tried = attempt_to(at, work.end)
    if work.method[0] == IMPLICIT:
        work.step[ERROR] = implicit_step(at, h)
        if work.step[ERROR] == FAILED:  # what is seen at its stages is that of some step before
            for j in range(work.mode.size):
                work.step[sum_of(j, FASTEST)] = 0.0
        else:
            look_for_speeds(in_rows(tried, 1))
        if work.step[ERROR] < 1.0:
            finish_ends(at)
        return
    if work.takes_steps != 0:  # whose evaluations the loop counts
        invoke(work.rates.code, work.rates.parameters, tried, WHOLE)
    else:
        run_stages(at, h, 1, END)
        stage_state(END, h, work.y, work.k, work.end)
        keep_last_stage(tried, work.z)
        evaluate(at, work.end, END)
    sum_up(in_rows(tried, 1))


@kernel
def step_to_event(at, share, event, h):
    """Finish a step of length `h` that was taken again, with a `share` of its length, to end at an event.

    event : (kind, contact, place of a STOP along the run).  An onset, a separation or a stop is put exactly at the end.
    """
    work = at[0]
    kind, contact, stop = event
    if work.step[ERROR] == FAILED:  # the interpolant of the longer step has to do
        fall_back(at, share)
    if not work.step[ERROR] < 1.0:
        finish_ends(at)
    miss, slope = 0.0, 0.0
    if kind == ONSET:
        seen = observed(at, END, contact)
        miss, slope = seen.depth, seen.rate * work.o[END, KAPPA]
    elif kind == SEPARATION:
        miss, slope = work.end[work.time + 1 + contact], work.k[END, work.time + 1 + contact]
    elif kind == STOP:
        miss, slope = work.end[work.independent] - stop, work.k[END, work.independent]
    if slope != 0.0 and abs(miss) <= 1e-3 * h * abs(slope):  # Newton, once; not where the event is all but tangential
        for i in range(work.end.size):
            work.end[i] -= work.k[END, i] * miss / slope
    if kind == STOP:
        work.end[work.independent] = stop


@kernel
def find_first_event(at, h, stop):
    """Look for events in the step just taken; `stop` is where along the run to stop.

    Return the share of the step at which the first was met, what it was, and by which contact.
    """
    work = at[0]
    before = work.counts[EVALUATIONS]
    finish_dense(at, h)
    share, kind, contact = first_event(at, h, stop)
    work.counts[LOCATING] += work.counts[EVALUATIONS] - before
    return share, kind, contact
