"""The integration loop: adaptive steps from event to event, everything that is wanted taken from them on the way."""

import math
from typing import NamedTuple

import numpy as np

from ..compiled.family import WIDTH, Entry, inlined, invoke, kernel
from ..compiled.kept import Kept, form_of, found
from ..compiled.plain import is_plain
from ..compiled.rows import in_rows
from ..observe.observables import KAPPA, KINETIC
from ..trace import objects
from .accumulate.along import CALM, ERROR, GOES_ON, LENGTH, STANDS, WHOLE, Attempt, advance, sum_up
from .accumulate.noting import add_courses, note_step, open_window
from .accumulate.record import write_sample
from .accumulate.tally import KINETIC_START, Ledger, enter
from .accumulate.turns import take_start
from .calm import can_be_calm, count_calm, limit_calm
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
    attempt_to,
    ledger_of,
)
from .guarding import may_pass_by_law
from .newton import AFTER, RENEWED
from .newton import LENGTH as PAST_LENGTH
from .passing import pass_events
from .plan import (
    ALONE,
    ANGLE,
    BEFORE,
    BEGUN,
    CAN_BE_CALM,
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
from .prospect import judge, note_calm
from .step import begin_step, land, meet, take_step
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
    """Enter the step, which stands."""
    at[0].step[STANDS] = 1.0
    enter(in_rows(ledger_of(at), 1), at[0].time)


@kernel
def note_calm_alone(at):
    """Note whether a step is calm."""
    note_calm(in_rows(ledger_of(at), 1), at[0].along)


@kernel
def look_at_guards(at):
    """Let a step not stand that may pass a guard which is not an observable: those are judged."""
    if at[0].step[STANDS] != 0.0 and may_pass_by_law(at):
        at[0].step[STANDS] = 0.0


@kernel
def settle_alone(at):
    """Judge a step by itself, and enter it if it stands; one to an event is not judged."""
    work = at[0]
    if work.ahead[LANDING] != 0.0:
        return
    work.ahead[ALONE] = 0.0
    judge(in_rows(ledger_of(at), 1), work.guards, work.along, work.time)
    look_at_guards(at)
    if work.step[STANDS] != 0.0:
        enter_alone(at)
    note_calm_alone(at)


@inlined
def settle_beside(model, addresses, tried, ledger):
    """Do what `settle_alone` does of the steps of all cases, which lie side by side; those that go ALONE wait."""
    at = found(model, addresses[0])
    sum_up(in_rows(tried, WIDTH))
    judge(in_rows(ledger, WIDTH), at[0].guards, at[0].along, at[0].time)
    if at[0].guards.evaluate.code != 0:
        for c in range(addresses.size):
            look_at_guards(found(model, addresses[c]))
    enter(in_rows(ledger, WIDTH), at[0].time)
    note_calm(in_rows(ledger, WIDTH), at[0].along)


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
    tally, record, ahead, control = work.tally, work.record, work.ahead, work.control
    here, moment = work.y[work.along], work.y[work.time]
    ahead[BEGUN], ahead[LOGGED], ahead[TRIES] = 1.0, 0.0, 0.0
    ahead[WINDOWED] = 1.0 if control[WINDOW] <= here else 0.0
    ahead[STOP_AT] = next_stop(at, here)
    ahead[LONGEST], ahead[CAN_BE_CALM] = work.longest, 1.0 if can_be_calm(at) else 0.0
    begin_step(at)  # after a pause the same again, unless the state was put elsewhere
    ahead[REST] = work.counts[STEPS] + control[STRETCH]
    if ahead[NEXT] > 0.0:
        return
    ahead[FARTHEST], ahead[ANGLE], ahead[SINCE] = here, here, moment
    tally.whole[KINETIC_START] = work.o[0, KINETIC]
    if ahead[WINDOWED] != 0.0:
        open_window(at)
    take_start(at)
    while work.counts[SAMPLES] < record.times.size and record.times[work.counts[SAMPLES]] <= work.y[record.along]:
        write_sample(at, work.y, record.samples[work.counts[SAMPLES]])
        work.counts[SAMPLES] += 1
    begin_anew(at)


@kernel
def begin_anew(at):
    """Note the length of the first step after something has changed; nothing is known of its error."""
    ahead = at[0].ahead
    ahead[NEXT], ahead[GROWTH], ahead[EXPECTED] = first_length(at, at[0].proposals, proposal_of(at)), GROW, 0.0


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
    count_calm(at)
    if ahead[BEGUN] == 0.0:
        begin(at)
    if ahead[LANDING] != 0.0:
        return GOING
    if work.counts[STEPS] + work.counts[REJECTED] >= work.control[MOST_STEPS]:
        return STEP_BUDGET
    reason = GOING
    if ahead[TRIES] == 0.0:
        reason, ahead[SPENT] = interruption(at), work.counts[EVALUATIONS]
    if reason == GOING:
        ahead[NEXT] = min(ahead[NEXT], work.longest / work.o[0, KAPPA])
        work.step[LENGTH] = ahead[NEXT]
        ahead[ALONE] = 1.0 if work.method[0] == IMPLICIT else 0.0
        limit_calm(at)
    return reason


@kernel
def reject(at, h):
    """Shorten a step of length `h` whose error was too large; return GOING, or why that helps no more."""
    work = at[0]
    ahead, error = work.ahead, work.step[ERROR]
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
    choose_method(at, h, proposal_of(at))
    enter_alone(at)
    note_step(at, h, dense=False)
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
    begin_anew(at)
    return GOING


@kernel
def conclude(at):
    """Take from the step that was tried and judged all that is wanted, or reject it; return GOING or the end."""
    work = at[0]
    ahead, step = work.ahead, work.step
    count_calm(at)
    if work.method[0] != IMPLICIT and work.takes_steps != 0:
        work.counts[EVALUATIONS] += END
    h, step[GOES_ON] = step[LENGTH], 0.0
    if ahead[LANDING] != 0.0:
        return conclude_landing(at, h)
    if not step[ERROR] < 1.0:
        return reject(at, h)
    pattern, dense = proposal_of(at), step[STANDS] == 0.0
    work.proposals[pattern] = ahead[NEXT]
    if dense:
        share, kind, contact = meet(at, h, ahead[STOP_AT])
        if kind != NOTHING:
            ahead[LANDING], ahead[SHARE], ahead[KIND], ahead[CONTACT] = 1.0, share, kind, contact
            ahead[BEFORE], step[LENGTH], ahead[ALONE] = work.counts[EVALUATIONS], h * share, 1.0
            return GOING
        enter_alone(at)
    choose_method(at, h, pattern)
    note_step(at, h, dense)
    if work.method[0] == IMPLICIT:
        work.implicit.past[AFTER], work.implicit.past[RENEWED] = 1.0, 0.0
    step[GOES_ON], ahead[NEXT] = 1.0, next_length(at, h, ahead[NEXT])
    return GOING


class Lot(NamedTuple):
    """Cases that are integrated side by side, c of them."""

    addresses: np.ndarray  # (c,) int64, of their Works, which are kept, each in a lane of one Board
    status: np.ndarray  # (c,) int64, filled: see `integrate`
    together: Entry  # takes a step in every lane of the Board, see `attempt`; NO_ENTRY for one after the other
    tried: Attempt  # the arrays of the Board that a step works on, those of its first lane
    ledger: Ledger  # and those by which it is judged and in which it is entered


def compile_for(model: Kept, lot: Kept) -> objects.Code | None:
    """Return the machine code of `integrate` for a Work and a Lot of these forms."""
    if not _CODE:
        told = f"{form_of(model.value)} {form_of(lot.value)}"

        def integrate_at(address):
            integrate_lot(model, found(lot, address))

        made = objects.compiled_at(integrate_at, told)
        if made is None:  # it was not made to be run here
            return None
        _CODE.append(made)
    return _CODE[0]


_CODE: list[objects.Code] = []  # of the loop, which is the same for all cases


def integrate(model: Kept, lot: Kept) -> None:
    """Integrate cases from where they stand until one of them is to be looked at.  Never raises.

    Parameters
    ----------
    model : a Work that is kept; of what form all cases are.
    lot : a Lot that is kept.  Its `status` is filled: GOING, OK or the reason why a case ended early; PAUSED, or
        TURNS_STIFF, its `work.slopes` being needed: call again to go on.

    Figures are in the `tally` of each Work, samples in its `record`, events in its `log`.  Which cases go side by side
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
    tried, ledger = lot[0].tried, lot[0].ledger
    waits = False
    while not waits:
        explicit = 0
        for c in range(addresses.size):
            at = found(model, addresses[c])
            if at[0].step[CALM] != 0.0:
                status[c] = GOING
                explicit += 1
                continue
            status[c] = ready(at)
            waits = waits or status[c] != GOING
            explicit += at[0].method[0] != IMPLICIT
        if waits:
            return
        beside = together.code != 0 and explicit >= WORTH
        if beside:
            invoke(together.code, together.parameters, tried, WHOLE)
            settle_beside(model, addresses, tried, ledger)
        for c in range(addresses.size):
            at = found(model, addresses[c])
            if not beside or at[0].ahead[ALONE] != 0.0:
                if not beside or at[0].method[0] == IMPLICIT:
                    take_step(at)
                settle_alone(at)
            if at[0].step[CALM] == 0.0:
                status[c] = conclude(at)
                waits = waits or status[c] != GOING
            elif at[0].ahead[WINDOWED] != 0.0:
                add_courses(at)
            if not beside:
                advance_alone(at)
        if beside:
            advance(in_rows(tried, WIDTH))
