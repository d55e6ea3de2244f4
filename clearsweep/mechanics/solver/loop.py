"""The integration loop: adaptive steps from event to event, and accumulation of figures, samples and events.

begin_case, then until the case ends or pauses:
    prepare_step        the length of the step, or the reason to stop
    take_step           stages by iteration, end, polynomial, error, sums        step, collocation, radau
    assess_step         its error, the length that it allows for the next        step_control
    if its error is too large:
        reject_step     try again with a shorter length
    find_first_event    the first zero of its event functions                    event_search, collocation
    if there is an event:
        take_step       up to the event; reject if the error is too large
        step_to_event   the end, corrected to the exact event                    step
        accept_step     sums, peaks, wear, samples up to there                   totals, slow_sums
        apply_event     modes, laws and states after it                          step
        restart         rates of the new equations
    else:
        accept_step     sums, peaks, wear, samples of the whole step             totals, slow_sums
        choose_method   explicit or implicit                                     step_control
        advance_start   its end is the next start
    set_next_length     after a rejection, a first step or an accepted one       step_control
"""

import math

import numpy as np

from ...tracing import objects
from ...tracing.compiled.choosing import rolled_range, total_of
from ...tracing.compiled.family import is_plain, kernel
from ...tracing.compiled.pinned import Pinned, layout_of, pinned_at
from ..observe import END, KAPPA, KINETIC, START
from . import integration, step_control
from .radau import FAILED
from .slow_sums import add_slow_sums, begin_window, record_start, write_sample
from .step import begin_step, find_first_event, pass_events, step_to_event, take_step
from .totals import HIGHEST_BIN, ContactTotals, accumulate_step

REVERSAL_TOLERANCE = 0.01 * 2.0 * math.pi  # rad, by which a free crank may turn back without a stall, as at an impact
STALL_ADVANCE = 1e-4  # rad, by which a free crank has to advance within Control.patience
NEAR_START = 1e-6  # fraction of an implicit step up to which an event is taken from its interpolant
SHORT_FRACTION = 1e-3  # fraction of a step up to which a step cut at an event is accepted whatever its error
LOG_ROWS = 512  # events in the log before the loop pauses so that the caller can read them


@kernel
def advance_start(pointer):
    """Make the end of a step the start of the next one, if no event has changed the state."""
    work = pointer[0]
    for i in range(work.y.size):
        work.y[i], work.k[i, START] = work.end[i], work.k[i, END]
    for column in range(work.o.shape[0]):
        work.o[column, START] = work.o[column, END]
    work.implicit.history.start_fraction, work.implicit.history.jacobian_length = 1.0, 0.0


@kernel
def accept_step(pointer):
    """Add an accepted step to the sums."""
    pointer[0].step.accepted = 1.0
    accumulate_step(pointer[0])


@kernel
def restart(pointer):
    """Begin a step at `work.end` after an event has changed the state or the equations."""
    work = pointer[0]
    for i in range(work.y.size):
        work.y[i] = work.end[i]
    work.method.current = work.method.next
    work.implicit.history.length, work.implicit.history.jacobian_length = 0.0, 0.0
    begin_step(pointer)


@kernel
def is_state_changed(pointer):
    """Return whether the caller changed the state after the end of the last step."""
    is_changed = False
    for i in range(pointer[0].y.size):
        is_changed = is_changed or pointer[0].y[i] != pointer[0].end[i]
    return is_changed


@kernel
def begin_case(pointer):
    """Prepare a case for its first step, or for the next after a pause; a pause does not change the motion."""
    work = pointer[0]
    totals, record, stepper, control = work.totals, work.record, work.stepper, work.control
    position, time = work.y[work.independent], work.y[work.time]
    stepper.begun, stepper.logged, stepper.rejections = 1.0, 0.0, 0.0
    stepper.in_window = 1.0 if control.window <= position else 0.0
    stepper.next_stop = next_stop(pointer, position)
    if stepper.next_length == 0.0 or is_state_changed(pointer):
        begin_step(pointer)
    stepper.pause_step = work.counts.steps + control.pause_steps
    if stepper.next_length > 0.0:
        return
    stepper.farthest, stepper.progress_angle, stepper.progress_time = position, position, time
    totals.mechanism.kinetic_start = work.o[KINETIC, START]
    if stepper.in_window != 0.0:
        begin_window(pointer)
    record_start(pointer)
    while work.counts.samples < record.times.size and record.times[work.counts.samples] <= work.y[record.independent]:
        write_sample(pointer, work.y, record.samples[work.counts.samples])
        work.counts.samples += 1
    step_control.set_next_length(pointer, step_control.BEGINNING)


@kernel
def next_boundary(pointer):
    """Return the start of the window of figures (s, or rad of a free crank); within the window the end of the run."""
    work = pointer[0]
    return work.control.end if work.stepper.in_window != 0.0 else work.control.window


@kernel
def next_stop(pointer, position):
    """Return the end of the next step (s, or rad): the first knot beyond `position`, or `next_boundary`."""
    boundary = next_boundary(pointer)
    for knot in pointer[0].knots:
        if knot > position:
            return min(knot, boundary)
    return boundary


@kernel
def aim_of(pointer):
    """Return where a step to the next stop ends: before a jump of an acceleration, which its last stage may not see."""
    return pointer[0].stepper.next_stop - pointer[0].control.early


@kernel
def status_before_step(pointer):
    """Return GOING if a case may take its next step, else the status with which the loop returns."""
    work = pointer[0]
    stepper, control = work.stepper, work.control
    time, angle = work.y[work.time], work.y[work.independent]
    is_full = stepper.logged + work.mode.size >= work.log.shape[0]  # all contacts may part at once
    is_full = is_full or (work.recording.shape[0] > 0 and stepper.recorded >= work.recording.shape[0])
    if angle >= control.pause or work.counts.steps >= stepper.pause_step or is_full:
        return integration.PAUSED
    if work.method.current == integration.IMPLICIT and work.slopes.code == 0:
        return integration.TURNS_STIFF
    if control.patience == math.inf:
        return integration.GOING
    if time >= control.time_limit:
        return integration.TIME_LIMIT
    stepper.farthest = max(stepper.farthest, angle)
    if angle > stepper.progress_angle + STALL_ADVANCE:
        stepper.progress_angle, stepper.progress_time = angle, time
    is_stalled = stepper.farthest - angle > REVERSAL_TOLERANCE or time - stepper.progress_time > control.patience
    return integration.STALLED if is_stalled else integration.GOING


@kernel
def prepare_step(pointer):
    """Return GOING and set the length of the next step in `work.step`, or return the status of a case that stops."""
    work = pointer[0]
    stepper = work.stepper
    if stepper.begun == 0.0:
        begin_case(pointer)
    if work.counts.steps + work.counts.rejected >= work.control.step_budget:
        return integration.STEP_BUDGET
    status = integration.GOING
    if stepper.rejections == 0.0:
        status, stepper.evaluations = status_before_step(pointer), work.counts.evaluations
    if status == integration.GOING:
        work.step.length = min(stepper.next_length, work.max_duration / work.o[KAPPA, START])
    return status


@kernel
def reject_step(pointer):
    """Reject a step and shorten the next; return GOING, or a failure after MAX_REJECTIONS rejections."""
    work = pointer[0]
    stepper, error = work.stepper, work.step.error
    work.counts.rejected += 1
    stepper.rejections += 1.0
    step_control.set_next_length(pointer, step_control.REJECTION)
    if stepper.rejections > step_control.MAX_REJECTIONS:
        return integration.STEP_UNDERFLOW if math.isfinite(error) else integration.NOT_FINITE
    return integration.GOING


@kernel
def repeat_up_to(pointer, h, fraction):
    """Take the step of length `h` again with a `fraction` of its length; return whether its error is too large.

    The shorter step resolves the motion before the event better.  The error of a very short step is rounding, so it
    does not count.
    """
    work = pointer[0]
    evaluations_before, work.step.length = work.counts.evaluations, h * fraction
    if fraction > NEAR_START or work.method.current != integration.IMPLICIT:
        take_step(pointer)
    else:  # the matrices of an implicit step without length are singular
        work.step.error = FAILED
    work.counts.locating += work.counts.evaluations - evaluations_before
    error_counts = fraction > SHORT_FRACTION and work.method.current != integration.IMPLICIT
    return error_counts and not work.step.error < 1.0


@kernel
def has_finite_sums(totals):
    """Return whether figures can follow from the sums; some maxima are infinite before their first value."""
    is_finite = totals.mechanism.residual < math.inf
    for column in range(totals.mechanism.numbers.size):
        is_finite = is_finite and abs(totals.mechanism.numbers[column]) <= math.inf
    for j in range(totals.account.shape[0]):
        for column in range(ContactTotals.SIZE):
            is_finite = is_finite and abs(totals.joint.numbers[j, column]) <= math.inf
        for column in range(totals.account.shape[1]):
            is_finite = is_finite and abs(totals.account[j, column]) < math.inf
        for histogram in (totals.histogram, totals.dry):
            if j < histogram.shape[0]:
                rows = histogram[j].reshape(histogram.shape[1] // 16, 4, 8)  # whole registers at once
                for row in rolled_range(totals.bins[j, HIGHEST_BIN] // 16 + 1):
                    numbers = [total_of(rows[row, k]) for k in range(4)]
                    is_finite = is_finite and abs((numbers[0] + numbers[1]) + (numbers[2] + numbers[3])) < math.inf
    for sums in (totals.wear, totals.friction):
        for index in range(sums.size):
            is_finite = is_finite and abs(sums[index]) < math.inf
    return is_finite


@kernel
def pass_stop(pointer):
    """Pass a stop, where a step had to end and the window may open; return GOING, or OK at the end of the run."""
    work = pointer[0]
    stepper = work.stepper
    if stepper.next_stop == next_boundary(pointer):
        if stepper.in_window != 0.0:
            return integration.OK
        stepper.in_window = 1.0
        begin_window(pointer)
    stepper.next_stop = next_stop(pointer, work.end[work.independent])
    return integration.GOING


@kernel
def apply_event_or_stop(pointer, kind, contact):
    """Apply an event or a stop to the state at the end of the step; return GOING or the status at the end."""
    if kind == integration.STOP:
        return pass_stop(pointer)
    return pass_events(pointer, kind, contact, pointer[0].stepper.in_window != 0.0)


@kernel
def cut_at_event(pointer, h, event):
    """End the step of length `h` at an event, (fraction, kind, contact); return GOING or the status at the end."""
    work = pointer[0]
    fraction, kind, contact = event
    work.stepper.contact = contact
    if repeat_up_to(pointer, h, fraction):
        return reject_step(pointer)
    evaluations_before = work.counts.evaluations
    step_to_event(pointer, (kind, contact, aim_of(pointer)))
    if kind == integration.STOP:
        work.end[work.independent] = work.stepper.next_stop
    work.counts.locating += work.counts.evaluations - evaluations_before
    step_control.choose_method(pointer, work.step.length, step_control.contact_pattern(pointer))
    accept_step(pointer)
    add_slow_sums(pointer, work.step.length)
    status = apply_event_or_stop(pointer, kind, contact)
    if status != integration.GOING:
        return status
    restart(pointer)
    step_control.set_next_length(pointer, step_control.BEGINNING)
    return integration.GOING


@kernel
def take_or_reject_step(pointer):
    """Take a step with its figures, samples and events, or reject it; return GOING or the status at the end."""
    work = pointer[0]
    step = work.step
    take_step(pointer)
    step_control.assess_step(work)
    h = step.length
    if not step.error < 1.0:
        return reject_step(pointer)
    pattern = step_control.contact_pattern(pointer)
    step_control.remember_length(pointer, pattern)
    fraction, kind, contact = find_first_event(pointer, h, aim_of(pointer))
    if kind != integration.NOTHING:
        return cut_at_event(pointer, h, (fraction, kind, contact))
    accept_step(pointer)
    step_control.choose_method(pointer, h, pattern)
    add_slow_sums(pointer, h)
    advance_start(pointer)
    step_control.set_next_length(pointer, step_control.ACCEPTANCE)
    return integration.GOING


def compile_for(model: Pinned) -> objects.Code | None:
    """Return the machine code of `integrate` for this type of Work, or None if it was not compiled for this machine."""
    if not _CODE:

        def integrate_at(address):
            integrate_case(pinned_at(model, address))

        code = objects.compiled_code_at(integrate_at, f"{layout_of(model.value)}")
        if code is None:  # it was not compiled for this machine
            return None
        _CODE.append(code)
    return _CODE[0]


_CODE: list[objects.Code] = []  # of the loop, which is the same for all cases


def integrate(pinned: Pinned) -> None:
    """Integrate a case, a pinned Work, until it ends or pauses.  Never raises.

    `stepper.status` is then OK or the reason why the case ended early.  After PAUSED call again to continue;
    after TURNS_STIFF first compile the slopes (`work.slopes`).  Figures are in `totals`, samples in `record`, events
    in `log`.
    """
    if is_plain():
        with np.errstate(all="ignore"):  # a trial step may overflow: it is rejected
            integrate_case((pinned.value,))
    else:
        objects.function_at(compile_for(pinned).address, 0)(pinned.address, 0)


@kernel
def integrate_case(pointer):
    """Integrate one case; `pointer[0]` is its Work."""
    status = integration.GOING
    while status == integration.GOING:
        status = prepare_step(pointer)
        if status == integration.GOING:
            status = take_or_reject_step(pointer)
    if status == integration.OK and not has_finite_sums(pointer[0].totals):
        status = integration.SUMS_NOT_FINITE
    pointer[0].stepper.status = status
