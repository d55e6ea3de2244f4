"""The integration loop: adaptive steps from event to event, with all results accumulated from the steps."""

import math

from ..compiled.family import kernel
from ..compiled.pinned import Pinned, form_of, pinned_at
from ..compiled.plain import is_plain
from ..observe.observables import KAPPA, KINETIC
from ..observe.stages import END, START
from ..trace import objects
from .acceptance import assess_step
from .accumulate.record import write_sample
from .accumulate.slow_sums import note_step, open_window
from .accumulate.step_sums import ACCEPTED, ERROR, LENGTH
from .accumulate.totals import KINETIC_START, accumulate_step
from .accumulate.turns import take_start
from .choice import choose_method
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
)
from .event_actions import pass_events
from .newton import AFTER, FAILED, RENEWED
from .newton import LENGTH as PAST_LENGTH
from .run_control import (
    ANGLE,
    BEGUN,
    CONTACT,
    EXPECTED,
    FARTHEST,
    GOING,
    GROWTH,
    LAST,
    LIMIT,
    LOGGED,
    MOST_STEPS,
    NEXT,
    NOT_FINITE,
    OK,
    PATIENCE,
    PAUSE,
    PAUSED,
    REST,
    SINCE,
    SPENT,
    STALLED,
    STATUS,
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
from .step_control import MOST_TRIES, first_length, next_length, pace_of, proposal_of, shrinking

BACK = 0.01 * 2.0 * math.pi  # rad: permitted reverse rotation of a free crank, which occurs briefly when joints knock
HARDLY = 1e-4  # rad: rotation required within Control.patience
AFTER_EVENT = (
    0.8  # growth of the second step after an event: at the onset of a contact the motion bends less than later
)
SHORT = 1e-3  # share of a step, cut at an event, up to which its error is ignored
LOG = 512  # capacity of the log; the caller must read it when full


@kernel
def advance(at):
    """Make the end of a step the start of the next; no equation has changed there."""
    work = at[0]
    for i in range(work.y.size):
        work.y[i], work.k[i, START] = work.end[i], work.k[i, END]
    for column in range(work.o.shape[0]):
        work.o[column, START] = work.o[column, END]
    work.implicit.past[AFTER], work.implicit.past[RENEWED] = 1.0, 0.0


@kernel
def accept(at):
    """Add the accepted step to the totals."""
    at[0].step[ACCEPTED] = 1.0
    accumulate_step(accumulators_of(at), at[0].time)


@kernel
def restart(at):
    """Begin a step at `work.end`, where the equations have changed."""
    work = at[0]
    for i in range(work.y.size):
        work.y[i] = work.end[i]
    work.method[0] = work.method[2]
    work.implicit.past[PAST_LENGTH], work.implicit.past[RENEWED] = 0.0, 0.0
    begin_step(at)


@kernel
def moved_since(at):
    """Return whether the state differs from the end of the last step, because the run was moved."""
    moved = False
    for i in range(at[0].y.size):
        moved = moved or at[0].y[i] != at[0].end[i]
    return moved


@kernel
def begin(at):
    """Prepare a case for its first step, or for the next one after a pause, without effect on the results."""
    work = at[0]
    totals, record, stepper, control = work.totals, work.record, work.stepper, work.control
    here, moment = work.y[work.independent], work.y[work.time]
    stepper[BEGUN], stepper[LOGGED], stepper[TRIES] = 1.0, 0.0, 0.0
    stepper[WINDOWED] = 1.0 if control[WINDOW] <= here else 0.0
    stepper[STOP_AT] = next_stop(at, here)
    if stepper[NEXT] == 0.0 or moved_since(at):
        begin_step(at)
    stepper[REST] = work.counts[STEPS] + control[STRETCH]
    if stepper[NEXT] > 0.0:
        return
    stepper[FARTHEST], stepper[ANGLE], stepper[SINCE] = here, here, moment
    totals.whole[KINETIC_START] = work.o[KINETIC, START]
    if stepper[WINDOWED] != 0.0:
        open_window(at)
    take_start(at)
    while work.counts[SAMPLES] < record.times.size and record.times[work.counts[SAMPLES]] <= work.y[record.independent]:
        write_sample(at, work.y, record.samples[work.counts[SAMPLES]])
        work.counts[SAMPLES] += 1
    begin_anew(at)


@kernel
def begin_anew(at):
    """Set the length of the first step after a change of the equations, whose error is unknown."""
    stepper = at[0].stepper
    stepper[NEXT], stepper[GROWTH], stepper[EXPECTED] = (
        first_length(at, at[0].proposals, proposal_of(at)),
        AFTER_EVENT,
        0.0,
    )


@kernel
def target_of(at):
    """Return the place along the run where figures begin or, if they have begun, where the run ends."""
    return at[0].control[LAST if at[0].stepper[WINDOWED] != 0.0 else WINDOW]


@kernel
def next_stop(at, here):
    """Return the place along the run where the next step must end: the first knot beyond `here`, or the target."""
    target = target_of(at)
    for knot in at[0].knots:
        if knot > here:
            return min(knot, target)
    return target


@kernel
def interruption(at):
    """Return GOING if a case may take its next step, else the reason why not."""
    work = at[0]
    stepper, control = work.stepper, work.control
    moment, angle = work.y[work.time], work.y[work.independent]
    full = stepper[LOGGED] + work.mode.size >= work.log.shape[0]  # all contacts may separate at the same moment
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
    """Return GOING if a case is to take a step, whose length is then in `work.step`, else the reason why not."""
    work = at[0]
    stepper = work.stepper
    if stepper[BEGUN] == 0.0:
        begin(at)
    if work.counts[STEPS] + work.counts[REJECTED] >= work.control[MOST_STEPS]:
        return STEP_BUDGET
    reason = GOING
    if stepper[TRIES] == 0.0:
        reason, stepper[SPENT] = interruption(at), work.counts[EVALUATIONS]
    if reason == GOING:
        stepper[NEXT] = min(stepper[NEXT], work.longest / work.o[KAPPA, START])
        work.step[LENGTH] = stepper[NEXT]
    return reason


@kernel
def reject(at, h):
    """Shorten a step of length `h` with too large an error; return GOING, or why no shorter step is possible."""
    work = at[0]
    stepper, error = work.stepper, work.step[ERROR]
    work.counts[REJECTED] += 1
    stepper[NEXT], stepper[GROWTH], stepper[TRIES] = h * shrinking(error), 1.0, stepper[TRIES] + 1.0
    if stepper[TRIES] > MOST_TRIES:
        return STEP_UNDERFLOW if math.isfinite(error) else NOT_FINITE
    return GOING


@kernel
def cut_at_event(at, h, event):
    """End the step of length `h` at an event: (share of it, kind, contact); return GOING or the end of the run.

    The step is repeated up to the event, and rejected if its error is then too large.  All results before the event are
    accumulated; then its effects are applied.
    """
    work = at[0]
    stepper, windowed = work.stepper, work.stepper[WINDOWED] != 0.0
    share, kind, contact = event
    stepper[CONTACT] = contact
    before, work.step[LENGTH] = work.counts[EVALUATIONS], h * share
    take_step(at)
    work.counts[LOCATING] += work.counts[EVALUATIONS] - before
    # the longer step covered less of the motion before the event; the error of a very short step is rounding
    too_far = share > SHORT and work.method[0] != IMPLICIT
    if too_far and not work.step[ERROR] < 1.0 and work.step[ERROR] != FAILED:
        return reject(at, work.step[LENGTH])
    before = work.counts[EVALUATIONS]
    step_to_event(at, share, (kind, contact, stepper[STOP_AT]), work.step[LENGTH])
    work.counts[LOCATING] += work.counts[EVALUATIONS] - before
    choose_method(at, work.step[LENGTH], proposal_of(at))
    accept(at)
    note_step(at, work.step[LENGTH])
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
def go_on(at):
    """Take a step and accumulate its results, or reject it; return GOING or the end of the run."""
    work = at[0]
    stepper, step = work.stepper, work.step
    take_step(at)
    assess_step(accumulators_of(at), work.method[0])
    h = step[LENGTH]
    if not step[ERROR] < 1.0:
        return reject(at, h)
    pattern = proposal_of(at)
    work.proposals[pattern], work.paces[pattern] = stepper[NEXT], pace_of(at)
    share, kind, contact = find_first_event(at, h, stepper[STOP_AT])
    if kind != NOTHING:
        return cut_at_event(at, h, (share, kind, contact))
    accept(at)
    choose_method(at, h, pattern)
    note_step(at, h)
    advance(at)
    stepper[NEXT] = next_length(at, h, stepper[NEXT])
    return GOING


def compile_for(model: Pinned) -> objects.Code | None:
    """Return the machine code of `integrate` for a Work of this form."""
    if not _CODE:

        def integrate_at(address):
            integrate_case(pinned_at(model, address))

        made = objects.compiled_at(integrate_at, f"{form_of(model.value)}")
        if made is None:  # it was not compiled for this machine
            return None
        _CODE.append(made)
    return _CODE[0]


_CODE: list[objects.Code] = []  # of the loop, which is the same for all cases


def integrate(kept: Pinned) -> None:
    """Integrate a case, a pinned Work, from its current state to its next pause.  Never raises.

    The STATUS in its stepper is then OK or the reason why the case ended early.  PAUSED, or TURNS_STIFF where
    `work.slopes`
    is required, means: call again to continue.  Figures are in its `totals`, samples in its `record`, events in its
    `log`.
    """
    if is_plain():
        integrate_case((kept.value,))
    else:
        objects.function_at(compile_for(kept).address, 0)(kept.address, 0)


@kernel
def integrate_case(at):
    """Integrate a case, see `integrate`; `at` is a pointer to the Work."""
    reason = GOING
    while reason == GOING:
        reason = ready(at)
        if reason == GOING:
            reason = go_on(at)
    at[0].stepper[STATUS] = reason
