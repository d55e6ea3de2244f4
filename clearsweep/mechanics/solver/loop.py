"""The integration loop: adaptive steps from event to event, everything that is wanted taken from them on the way."""

import math
from typing import NamedTuple

import numpy as np

from ..compiled.family import WIDTH, Entry, inlined, invoke, kernel
from ..compiled.pinned import Pinned, form_of, pinned_at
from ..compiled.plain import is_plain
from ..compiled.rows import in_rows
from ..observe.observables import KAPPA, KINETIC
from ..trace import objects
from .acceptance import assess_step, note_fast_path
from .accumulate.record import write_sample
from .accumulate.slow_sums import add_courses, note_step, open_window
from .accumulate.step_sums import ACCEPTED, CONTINUES, ERROR, LENGTH, ON_FAST_PATH, WHOLE, TrialStep, advance, sum_up
from .accumulate.totals import KINETIC_START, Accumulators, accumulate_step
from .accumulate.turns import take_start
from .choice import choose_method
from .dop853 import END
from .event import (
    EVALUATIONS,
    IMPLICIT,
    LOCATING,
    NOTHING,
    REJECTED,
    SAMPLES,
    STEPS,
    STOP,
    accumulators_of,
    attempt_to,
)
from .event_actions import pass_events
from .fast_path import can_take_fast_path, count_fast_steps, limit_fast_steps
from .guarding import may_pass_by_law
from .newton import AFTER, RENEWED
from .newton import LENGTH as PAST_LENGTH
from .run_control import (
    ALONE,
    ANGLE,
    BEFORE,
    BEGUN,
    CAN_TAKE_FAST_PATH,
    CONTACT,
    EXPECTED,
    FARTHEST,
    GOING,
    GROWTH,
    KIND,
    LANDING,
    LAST,
    LIMIT,
    LOGGED,
    LONGEST,
    MOST_STEPS,
    NEXT,
    NOT_FINITE,
    OK,
    PATIENCE,
    PAUSE,
    PAUSED,
    REST,
    SHARE,
    SINCE,
    SPENT,
    STALLED,
    STEP_BUDGET,
    STEP_UNDERFLOW,
    STOP_AT,
    STRETCH,
    TIME_LIMIT,
    TRIES,
    TURNS_STIFF,
    WINDOW,
    WINDOWED,
)
from .step import begin_step, find_first_event, step_to_event, take_step
from .step_control import GROW, MOST_TRIES, first_length, next_length, proposal_of, shrinking

BACK = 0.01 * 2.0 * math.pi  # rad: how far a free crank may turn back, as it does for a moment when joints knock
HARDLY = 1e-4  # rad: how far it has to come in the time that it is given
LOG = 512  # events that are logged before whoever called has to take them away
WORTH = 3  # cases: fewer take their steps one after the other, as that is faster


@kernel
def advance_alone(at):
    """Go on from the end of a step where nothing has changed."""
    advance(in_rows(attempt_to(at, at[0].end), 1))


@kernel
def enter_alone(at):
    """Enter the step, which is accepted."""
    at[0].step[ACCEPTED] = 1.0
    accumulate_step(in_rows(accumulators_of(at), 1), at[0].time)


@kernel
def note_calm_alone(at):
    """Note whether a step is fast."""
    note_fast_path(in_rows(accumulators_of(at), 1), at[0].independent)


@kernel
def look_at_guards(at):
    """Let a step not be accepted that may pass a guard which is not an observable: those are judged."""
    if at[0].step[ACCEPTED] != 0.0 and may_pass_by_law(at):
        at[0].step[ACCEPTED] = 0.0


@kernel
def finish_step(at):
    """Judge a step by itself, and enter it if it is accepted; one to an event is not judged."""
    work = at[0]
    if work.stepper[LANDING] != 0.0:
        return
    work.stepper[ALONE] = 0.0
    assess_step(in_rows(accumulators_of(at), 1), work.guards, work.independent, work.time)
    look_at_guards(at)
    if work.step[ACCEPTED] != 0.0:
        enter_alone(at)
    note_calm_alone(at)


@inlined
def finish_steps_batch(model, addresses, tried, accumulators):
    """Do what `finish_step` does of the steps of all cases, which lie side by side; those that go ALONE wait."""
    at = pinned_at(model, addresses[0])
    sum_up(in_rows(tried, WIDTH))
    assess_step(in_rows(accumulators, WIDTH), at[0].guards, at[0].independent, at[0].time)
    if at[0].guards.evaluate.code != 0:
        for c in range(addresses.size):
            look_at_guards(pinned_at(model, addresses[c]))
    accumulate_step(in_rows(accumulators, WIDTH), at[0].time)
    note_fast_path(in_rows(accumulators, WIDTH), at[0].independent)


@kernel
def restart(at):
    """Begin a step at `work.end`, where something has changed."""
    work = at[0]
    for i in range(work.y.size):
        work.y[i] = work.end[i]
    work.method[0] = work.method[2]
    work.implicit.past[PAST_LENGTH], work.implicit.past[RENEWED] = 0.0, 0.0
    begin_step(at)


@kernel
def begin(at):
    """Make a case ready for its first step, or for the next after a pause: as if there had been none."""
    work = at[0]
    totals, record, stepper, control = work.totals, work.record, work.stepper, work.control
    here, moment = work.y[work.independent], work.y[work.time]
    stepper[BEGUN], stepper[LOGGED], stepper[TRIES] = 1.0, 0.0, 0.0
    stepper[WINDOWED] = 1.0 if control[WINDOW] <= here else 0.0
    stepper[STOP_AT] = next_stop(at, here)
    stepper[LONGEST], stepper[CAN_TAKE_FAST_PATH] = work.longest, 1.0 if can_take_fast_path(at) else 0.0
    begin_step(at)  # after a pause the same again, unless the state was put elsewhere
    stepper[REST] = work.counts[STEPS] + control[STRETCH]
    if stepper[NEXT] > 0.0:
        return
    stepper[FARTHEST], stepper[ANGLE], stepper[SINCE] = here, here, moment
    totals.whole[KINETIC_START] = work.o[0, KINETIC]
    if stepper[WINDOWED] != 0.0:
        open_window(at)
    take_start(at)
    while work.counts[SAMPLES] < record.times.size and record.times[work.counts[SAMPLES]] <= work.y[record.independent]:
        write_sample(at, work.y, record.samples[work.counts[SAMPLES]])
        work.counts[SAMPLES] += 1
    begin_anew(at)


@kernel
def begin_anew(at):
    """Note the length of the first step after something has changed; nothing is known of its error."""
    stepper = at[0].stepper
    stepper[NEXT], stepper[GROWTH], stepper[EXPECTED] = first_length(at, at[0].proposals, proposal_of(at)), GROW, 0.0


@kernel
def target_of(at):
    """Return where along the run figures begin to be taken or, if they are, the run ends."""
    return at[0].control[LAST if at[0].stepper[WINDOWED] != 0.0 else WINDOW]


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
    stepper, control = work.stepper, work.control
    moment, angle = work.y[work.time], work.y[work.independent]
    full = stepper[LOGGED] + work.mode.size >= work.log.shape[0]  # all contacts may part at once
    if angle >= control[PAUSE] or work.counts[STEPS] >= stepper[REST] or full:
        return PAUSED
    if work.method[0] == IMPLICIT and work.slopes[0] == 0:
        return TURNS_STIFF
    if control[PATIENCE] == math.inf:
        return GOING
    if moment >= control[LIMIT]:
        return TIME_LIMIT
    stepper[FARTHEST] = max(stepper[FARTHEST], angle)
    if angle > stepper[ANGLE] + HARDLY:
        stepper[ANGLE], stepper[SINCE] = angle, moment
    stalled = stepper[FARTHEST] - angle > BACK or moment - stepper[SINCE] > control[PATIENCE]
    return STALLED if stalled else GOING


@kernel
def ready(at):
    """Return GOING where a case is to take a step, whose length then is in `work.step`, else why not."""
    work = at[0]
    stepper = work.stepper
    count_fast_steps(at)
    if stepper[BEGUN] == 0.0:
        begin(at)
    if stepper[LANDING] != 0.0:
        return GOING
    if work.counts[STEPS] + work.counts[REJECTED] >= work.control[MOST_STEPS]:
        return STEP_BUDGET
    reason = GOING
    if stepper[TRIES] == 0.0:
        reason, stepper[SPENT] = interruption(at), work.counts[EVALUATIONS]
    if reason == GOING:
        stepper[NEXT] = min(stepper[NEXT], work.longest / work.o[0, KAPPA])
        work.step[LENGTH] = stepper[NEXT]
        stepper[ALONE] = 1.0 if work.method[0] == IMPLICIT else 0.0
        limit_fast_steps(at)
    return reason


@kernel
def reject(at, h):
    """Shorten a step of length `h` whose error was too large; return GOING, or why that helps no more."""
    work = at[0]
    stepper, error = work.stepper, work.step[ERROR]
    work.counts[REJECTED] += 1
    stepper[NEXT], stepper[GROWTH], stepper[TRIES] = h * shrinking(error), 1.0, stepper[TRIES] + 1.0
    if stepper[TRIES] > MOST_TRIES:
        return STEP_UNDERFLOW if math.isfinite(error) else NOT_FINITE
    return GOING


@kernel
def conclude_landing(at, h):
    """Take from the step to an event all that is wanted, and change what the event changes; return as `conclude`."""
    work = at[0]
    stepper, windowed = work.stepper, work.stepper[WINDOWED] != 0.0
    share, kind, contact = stepper[SHARE], int(stepper[KIND]), int(stepper[CONTACT])
    stepper[LANDING] = 0.0
    step_to_event(at, share, (kind, contact, stepper[STOP_AT]), h)
    work.counts[LOCATING] += work.counts[EVALUATIONS] - int(stepper[BEFORE])
    choose_method(at, h, proposal_of(at))
    enter_alone(at)
    note_step(at, h, dense=False)
    if kind == STOP:
        if stepper[STOP_AT] == target_of(at):
            if windowed:
                return OK
            stepper[WINDOWED] = 1.0
            open_window(at)
        stepper[STOP_AT] = next_stop(at, work.end[work.independent])
    else:
        reason = pass_events(at, kind, contact, windowed)
        if reason != GOING:
            return reason
    restart(at)
    begin_anew(at)
    return GOING


@kernel
def conclude(at):
    """Take from the step that was tried and judged all that is wanted, or reject it; return GOING or the end."""
    work = at[0]
    stepper, step = work.stepper, work.step
    count_fast_steps(at)
    if work.method[0] != IMPLICIT and work.takes_steps != 0:
        work.counts[EVALUATIONS] += END
    h, step[CONTINUES] = step[LENGTH], 0.0
    if stepper[LANDING] != 0.0:
        return conclude_landing(at, h)
    if not step[ERROR] < 1.0:
        return reject(at, h)
    pattern, dense = proposal_of(at), step[ACCEPTED] == 0.0
    work.proposals[pattern] = stepper[NEXT]
    if dense:
        share, kind, contact = find_first_event(at, h, stepper[STOP_AT])
        if kind != NOTHING:
            stepper[LANDING], stepper[SHARE], stepper[KIND], stepper[CONTACT] = 1.0, share, kind, contact
            stepper[BEFORE], step[LENGTH], stepper[ALONE] = work.counts[EVALUATIONS], h * share, 1.0
            return GOING
        enter_alone(at)
    choose_method(at, h, pattern)
    note_step(at, h, dense)
    if work.method[0] == IMPLICIT:
        work.implicit.past[AFTER], work.implicit.past[RENEWED] = 1.0, 0.0
    step[CONTINUES], stepper[NEXT] = 1.0, next_length(at, h, stepper[NEXT])
    return GOING


class Lot(NamedTuple):
    """Cases that are integrated side by side, c of them."""

    addresses: np.ndarray  # (c,) int64, of their Works, which are kept, each in a lane of one Board
    status: np.ndarray  # (c,) int64, filled: see `integrate`
    together: Entry  # takes a step in every lane of the Board, see `attempt`; NO_ENTRY for one after the other
    tried: TrialStep  # the arrays of the Board that a step works on, those of its first lane
    accumulators: Accumulators  # and those by which it is judged and in which it is entered


def compile_for(model: Pinned, lot: Pinned) -> objects.Code | None:
    """Return the machine code of `integrate` for a Work and a Lot of these forms."""
    if not _CODE:
        cache_key = f"{form_of(model.value)} {form_of(lot.value)}"

        def integrate_at(address):
            integrate_lot(model, pinned_at(lot, address))

        made = objects.compiled_at(integrate_at, cache_key)
        if made is None:  # it was not made to be run here
            return None
        _CODE.append(made)
    return _CODE[0]


_CODE: list[objects.Code] = []  # of the loop, which is the same for all cases


def integrate(model: Pinned, lot: Pinned) -> None:
    """Integrate cases from where they are until one of them is to be looked at.  Never raises.

    Parameters
    ----------
    model : a Work that is kept; of what form all cases are.
    lot : a Lot that is kept.  Its `status` is filled: GOING, OK or the reason why a case ended early; PAUSED, or
        TURNS_STIFF, its `work.slopes` being needed: call again to go on.

    Figures are in the `totals` of each Work, samples in its `record`, events in its `log`.  Which cases go side by side
    has no part in what comes out: see `attempt`.
    """
    if is_plain():
        integrate_lot(model, (lot.value,))
    else:
        objects.function_at(compile_for(model, lot).address, 0)(lot.address, 0)


@kernel
def integrate_lot(model, lot):
    """Do the same; `lot` is a pointer to the Lot."""
    addresses, status, together = lot[0].addresses, lot[0].status, lot[0].together
    tried, accumulators = lot[0].tried, lot[0].accumulators
    waits = False
    while not waits:
        explicit = 0
        for c in range(addresses.size):
            at = pinned_at(model, addresses[c])
            if at[0].step[ON_FAST_PATH] != 0.0:
                status[c] = GOING
                explicit += 1
                continue
            status[c] = ready(at)
            waits = waits or status[c] != GOING
            explicit += at[0].method[0] != IMPLICIT
        if waits:
            return
        in_batch = together.code != 0 and explicit >= WORTH
        if in_batch:
            invoke(together.code, together.parameters, tried, WHOLE)
            finish_steps_batch(model, addresses, tried, accumulators)
        for c in range(addresses.size):
            at = pinned_at(model, addresses[c])
            if not in_batch or at[0].stepper[ALONE] != 0.0:
                if not in_batch or at[0].method[0] == IMPLICIT:
                    take_step(at)
                finish_step(at)
            if at[0].step[ON_FAST_PATH] == 0.0:
                status[c] = conclude(at)
                waits = waits or status[c] != GOING
            elif at[0].stepper[WINDOWED] != 0.0:
                add_courses(at)
            if not in_batch:
                advance_alone(at)
        if in_batch:
            advance(in_rows(tried, WIDTH))
