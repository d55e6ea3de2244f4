"""One step: its stages by iteration, and its repetition where an event shortens it."""

import math
from typing import NamedTuple

from ...tracing.compiled.family import invoke, kernel
from ..laws.contract import ENTERED, LEFT, ONSET_FLOOR, SAME, touches
from ..observe import END, KAPPA, STAGES, START, contact_observables_in
from . import collocation, integration, preconditioner
from .event_search import SINGLE_STATE, evaluate_guards, fit_guard, is_guard_active, locate_first_event
from .radau import FAILED, STAGE_WEIGHTS, implicit_step, shorten_implicit_step
from .radau import observe_stages as observe_implicit_stages
from .totals import write_sums

MAX_SWEEPS = 16
SWEEP_TOLERANCE = 0.1  # of the allowed error: expected distance at which the iteration ends
#: Least contraction assumed of further sweeps; the first sweeps reduce large distances and say little about the rest.
MIN_CONTRACTION = 0.05
#: Of a step that ends at an event: distances between which it is repeated with another length, and up to which its end
#: is corrected.
CLOSE_TO_EVENT, FAR_FROM_EVENT, NEXT_TO_EVENT = 1e-6, 0.1, 1e-3
MAX_REPEATS = 3
MAX_CONTRACTION = 0.8  # contraction at which the iteration is abandoned


@kernel
def latch(pointer, y, contact, guard, row):
    """Latch the internal states of a contact's laws at an event: ENTERED, LEFT or the index of a passed guard."""
    work, guards = pointer[0], pointer[0].guards
    if guards.latch.code != 0:
        guards.event[0], guards.event[1] = contact, guard
        invoke(guards.latch.code, guards.latch.parameters, (y, work.latched, work.o, guards.event), row)


@kernel
def pass_guard(pointer, g, y, row):
    """Apply the passage of guard `g` at the state `y`, whose observables are in row `row`."""
    work, guards = pointer[0], pointer[0].guards
    contact = guards.contact[g]
    if guards.next_mode[g] != SAME:
        work.mode[contact] = guards.next_mode[g]
    latch(pointer, y, contact, g, row)


@kernel
def begin_step(pointer):
    """Evaluate the start of a step after a change of the equations, and apply the guards that are passed there."""
    work, guards = pointer[0], pointer[0].guards
    integration.evaluate(pointer, work.y, START)
    is_changed, is_outdated = False, True
    for g in range(guards.contact.size):
        if guards.at_start[g] and is_guard_active(pointer, g):
            if is_outdated:
                evaluate_guards(pointer, work.y, START)
                is_outdated = False
            if guards.value[g, SINGLE_STATE] > 0.0:
                pass_guard(pointer, g, work.y, START)
                is_changed = True
    if is_changed:
        integration.evaluate(pointer, work.y, START)


@kernel
def guess_stages(pointer, h):
    """Write a guess of the stages of a step of length `h` to `work.nodes`."""
    work = pointer[0]
    history = work.implicit.history
    if history.length > 0.0:
        collocation.continue_stages(h / history.length, history.start_fraction, work.y, work.f, work.nodes)
    else:
        collocation.begin_stages(h, work.y, work.k, work.nodes)


@kernel
def sweep(pointer):
    """Update all stages once; return the change over the allowed error."""
    work = pointer[0]
    if work.step.preconditioned != 0.0:
        preconditioner.sweep_preconditioned(pointer)
    else:
        preconditioner.sweep_part(pointer, collocation.WHOLE_SWEEP)
    work.counts.evaluations += STAGES
    return math.sqrt(work.step.change)


@kernel
def observe_stages(pointer):
    """Write the observables of all stages."""
    work = pointer[0]
    invoke(work.observe_stages.code, work.observe_stages.parameters, (work.nodes, work.mode, work.latched, work.o), 0)
    work.counts.evaluations += STAGES


@kernel
def solve_stages(pointer):
    """Update the stages until they fulfil their equations; return whether they do.

    The iteration has converged when the remaining distance, estimated from the contraction, is at most SWEEP_TOLERANCE.
    """
    step, last_change, last_contraction = pointer[0].step, sweep(pointer), 0.0
    if not last_change < math.inf:
        return False
    for count in range(1, MAX_SWEEPS):
        largest_change = sweep(pointer)
        if not largest_change < math.inf:
            return False
        contraction = largest_change / last_change if last_change > 0.0 else 0.0
        rate = max(contraction, MIN_CONTRACTION)
        if largest_change * rate <= SWEEP_TOLERANCE * (1.0 - rate):
            step.contraction = (
                max(contraction, last_contraction) if count < 3 else math.sqrt(contraction * last_contraction)
            )
            step.sweeps = count + 1.0
            return True
        if not (contraction < MAX_CONTRACTION or count < 3):
            return False
        last_change, last_contraction = largest_change, contraction
    return False


@kernel
def begin_iteration(pointer, h):
    """Guess the stages of a step of length `h`; decide whether their iteration is preconditioned, and prepare it."""
    work, step, stepper = pointer[0], pointer[0].step, pointer[0].stepper
    guess_stages(pointer, h)
    step.preconditioned = 0.0
    if stepper.slow == 0.0 or work.preconditioner.increment.size == 0:
        return
    preconditioner.linearise(pointer, h)
    guess_stages(pointer, h)
    stepper.slow = 0.0
    if preconditioner.predicted_contraction(pointer) >= preconditioner.FAST_CONTRACTION:
        preconditioner.factorise_pairs(work.preconditioner)
        preconditioner.sweep_part(pointer, collocation.POSITIONS)  # from the guessed velocities, as after every sweep
        step.preconditioned, stepper.slow = 1.0, 1.0


@kernel
def note_contraction(pointer, is_solved):
    """Decide from the latest iteration whether the next one may be preconditioned.

    If a preconditioned iteration fails in a step that was already repeated, the next one is plain.
    """
    step, stepper = pointer[0].step, pointer[0].stepper
    if step.preconditioned == 0.0:
        stepper.slow = 0.0 if is_solved and step.contraction < preconditioner.SLOW_CONTRACTION else 1.0
    elif not is_solved and stepper.rejections > 0.0:
        stepper.slow = 0.0


@kernel
def collocate(pointer, h):
    """Solve for the stages of a step of length `h`; set its end, interpolant and error."""
    work = pointer[0]
    history = work.implicit.history
    begin_iteration(pointer, h)
    is_solved = solve_stages(pointer)
    note_contraction(pointer, is_solved)
    if not is_solved:
        work.step.error = FAILED
        return
    if work.step.preconditioned != 0.0:
        preconditioner.complete_rates(pointer, h)
    for i in range(work.y.size):
        work.end[i] = work.nodes[i, END]
    collocation.interpolate(h, work.k, work.f)
    history.length, history.start_fraction = h, 0.0
    work.step.error = collocation.error_norm(work.f, work.weight)


@kernel
def sum_step(pointer):
    """Compute the sums, profiles and maxima of the current step, which is accurate or ends at an event."""
    if pointer[0].method.current == integration.IMPLICIT:
        observe_implicit_stages(pointer)
        write_sums(pointer[0], STAGE_WEIGHTS)
    else:
        observe_stages(pointer)
        write_sums(pointer[0], collocation.WEIGHTS)


@kernel
def take_step(pointer):
    """Take the step whose length is in `work.step`: set `work.end`, the stages and the results of the step."""
    work, h = pointer[0], pointer[0].step.length
    if work.method.current == integration.IMPLICIT:
        work.step.error = implicit_step(pointer, h)
    else:
        collocate(pointer, h)
    if work.step.error < 1.0:
        sum_step(pointer)
    else:
        for j in range(work.mode.size):  # the interpolant belongs to an earlier step
            work.contact_steps[j].fastest = 0.0


@kernel
def shorten_step(pointer, fraction):
    """Replace the latest step by a `fraction` of it, from its interpolant."""
    work = pointer[0]
    if work.method.current == integration.IMPLICIT:
        shorten_implicit_step(pointer, fraction)
    else:
        collocation.continue_stages(fraction, 0.0, work.y, work.f, work.nodes)
        work.step.preconditioned = 0.0
        sweep(pointer)  # for the rates; it may move the stages away from each other
        collocation.continue_stages(fraction, 0.0, work.y, work.f, work.nodes)
        collocation.dense_state(fraction, work.y, work.f, work.end)


@kernel
def overshoot_of(pointer, event):
    """Return the distance along tau of the end of the latest step beyond an event, or 0 if its function has no slope.

    event : as in `step_to_event`
    """
    work = pointer[0]
    kind, contact, stop = event
    distance, slope = 0.0, 0.0
    if kind == integration.ONSET:
        contact_values = contact_observables_in(work.o, END, contact)
        distance, slope = contact_values.depth, contact_values.rate * work.o[KAPPA, END]
    elif kind == integration.SEPARATION:
        distance, slope = work.end[work.time + 1 + contact], work.k[work.time + 1 + contact, END]
    elif kind == integration.LIMIT:
        root = work.time + 1 + contact
        distance, slope = work.end[root] - math.sqrt(work.limit_depth[contact]), work.k[root, END]
    elif kind == integration.STOP:
        distance, slope = work.end[work.independent] - stop, work.k[work.independent, END]
    elif kind >= integration.GUARD and work.step.length > 0.0:
        evaluate_guards(pointer, work.y, END)
        if fit_guard(pointer, kind - integration.GUARD):
            distance, change = collocation.value_and_slope(work.polynomials, collocation.WHOLE, 1.0)
            slope = change / work.step.length
    return distance / slope if slope != 0.0 else 0.0


@kernel
def repeat_near_event(pointer, event):
    """Repeat a step to an event while it ends too far from it; return the distance along tau beyond the event.

    The interpolant of a longer step over a kink of the right-hand side locates the kink only roughly.
    """
    work = pointer[0]
    distance = overshoot_of(pointer, event)
    for _ in range(MAX_REPEATS):
        h = work.step.length
        is_off = CLOSE_TO_EVENT * h < abs(distance) < FAR_FROM_EVENT * h
        if (
            work.control.early > 0.0 and event[0] == integration.STOP
        ):  # the last stage may not see the acceleration behind the jump
            is_off = is_off or work.end[work.independent] >= work.stepper.next_stop
        if not (work.step.error < 1.0 and is_off):
            break
        work.step.length = h - distance
        take_step(pointer)
        if not work.step.error < 1.0:  # as before
            work.step.length = h
            take_step(pointer)
            break
        distance = overshoot_of(pointer, event)
    return distance


@kernel
def step_to_event(pointer, event):
    """Finish a step that was repeated with a shorter length to end at an event.

    event : (kind, contact, stop), `stop` in s, or rad of a free crank.  The end is corrected to the exact event, since
    the interpolant between the stages is less accurate than the end of a step.
    """
    work = pointer[0]
    if work.step.error == FAILED:  # keep the interpolant of the longer step
        shorten_step(pointer, work.step.length / work.implicit.history.length)
    if not work.step.error < 1.0:
        sum_step(pointer)
    distance = repeat_near_event(pointer, event)
    if abs(distance) <= NEXT_TO_EVENT * work.step.length:  # one Newton step, unless the event is nearly tangential
        for i in range(work.end.size):
            work.end[i] -= work.k[i, END] * distance


@kernel
def find_first_event(pointer, h, stop):
    """Search for events in the latest step, which must end at `stop` (s, or rad of a free crank).

    Return the fraction of the step at the first event, its kind, and its contact.
    """
    work = pointer[0]
    evaluations_before = work.counts.evaluations
    fraction, kind, contact = locate_first_event(pointer, h, stop)
    work.counts.locating += work.counts.evaluations - evaluations_before
    return fraction, kind, contact


# ----------------------------------------------------------------------------------------------------------------------
# Effects of an event: contacts begin and end, guards are passed; every event is logged.


ONSET_ROOT = 1e-9  # of sigma: the root of penetration at an onset, so that it is never exactly zero


@kernel
def begin_contact(pointer, j, in_window):
    """Latch the onset rate of contact `j` at `work.end` and start its root of penetration."""
    work = pointer[0]
    totals, contact = work.totals, contact_observables_in(work.o, END, j)
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
    rate = contact_observables_in(work.o, END, j).rate
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
    if event.kind >= integration.LIMIT or work.control.keep_events == 0.0:
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
    if kind >= integration.GUARD:
        g = kind - integration.GUARD
        if in_window and work.guards.counted[g]:
            work.totals.joint[j].clips += 1.0
        pass_guard(pointer, g, work.end, END)
    if kind >= integration.LIMIT:
        work.counts.passages += 1
        return Event(time, j, kind, 0.0, 0.0)
    work.counts.events += 1
    if kind == integration.ONSET:
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
            return integration.SEPARATION, j
    return integration.NOTHING, 0


@kernel
def pass_events(pointer, kind, contact, in_window):
    """Apply an event and all others at the same time; return GOING or the reason to end the run."""
    work = pointer[0]
    while kind != integration.NOTHING:
        log_event(pointer, apply_event(pointer, kind, contact, in_window))
        if work.control.separations > 0.0 and work.counts.separations >= work.control.separations:
            return integration.OK
        if work.counts.events >= work.control.event_budget:
            return integration.EVENT_BUDGET
        if kind >= integration.GUARD and work.guards.ends_run[kind - integration.GUARD]:
            return integration.LEFT_BEARING
        kind, contact = simultaneous_separation(pointer)
    return integration.GOING
