"""One step: its stages, its dense output, and the step again where an event cuts it short."""

from ..compiled.family import kernel
from ..joint.dry import PRESSED, STUCK
from ..rates import DEPTH, JOINT_WIDTH, JOINTS, KAPPA, RATE, SPEED
from .dop853 import END, ROWS, dense_coefficients, error_norm, stage_state
from .event import EVALUATIONS, IMPLICIT, LOCATING, NOTHING, ONSET, SEPARATION, STOP, evaluate, first_event, may_meet
from .newton import FAILED, fall_back, implicit_step


@kernel
def begin_step(at):
    """Evaluate the start of a step at which something has changed; surfaces that hardly slide now stick."""
    work = at[0]
    evaluate(at, work.y, 0)
    before = work.state.sum()
    for j in range(work.state.size):
        if work.state[j] == PRESSED and abs(work.o[0, JOINTS + JOINT_WIDTH * j + SPEED]) < work.band[j]:
            work.state[j] = STUCK
    if work.state.sum() != before:
        evaluate(at, work.y, 0)


@kernel
def run_stages(at, h, first, last):
    """Fill rows `first` to `last` - 1 of rates and observables; row 0 is there already."""
    work = at[0]
    for row in range(first, last):
        stage_state(row, h, work.y, work.k, work.z)
        evaluate(at, work.z, row)


@kernel
def finish_dense(at, h):
    """Make the dense output of the step that has just been taken."""
    work = at[0]
    if work.mode[0] == IMPLICIT:
        return  # the implicit step made it
    run_stages(at, h, END + 1, ROWS)
    dense_coefficients(h, work.y, work.end, work.k, work.f)


@kernel
def take_step(at, h):
    """Put the state at the end of a step of length `h` into `work.end` and return its error over the allowed one."""
    work = at[0]
    if work.mode[0] == IMPLICIT:
        return implicit_step(at, h)
    run_stages(at, h, 1, END)
    stage_state(END, h, work.y, work.k, work.end)
    return error_norm(h, work.k, work.scale)


@kernel
def finish_ends(at):
    """Evaluate the rates and observables at the end of a step."""
    evaluate(at, at[0].end, END)


@kernel
def land(at, share, kind, joint, h, stop):
    """Take the step again with the length at which the event was found, put it exactly there; return the length."""
    work = at[0]
    h *= share
    if take_step(at, h) == FAILED:  # the interpolant of the longer step has to do
        fall_back(at, share)
    finish_ends(at)
    block = JOINTS + JOINT_WIDTH * joint
    miss, slope = 0.0, 0.0
    if kind == ONSET:
        miss, slope = work.o[END, block + DEPTH], work.o[END, block + RATE] * work.o[END, KAPPA]
    elif kind == SEPARATION:
        miss, slope = work.end[work.time + 1 + joint], work.k[END, work.time + 1 + joint]
    elif kind == STOP:
        miss, slope = work.end[work.time] - stop, work.o[END, KAPPA]
    if slope != 0.0 and abs(miss) <= 1e-3 * h * abs(slope):  # Newton, once; not where the event is all but tangential
        for i in range(work.end.size):
            work.end[i] -= work.k[END, i] * miss / slope
    if kind == STOP:
        work.end[work.time] = stop
    return h


@kernel
def meet(at, h, stop):
    """Look for events in the step just taken and cut it at the first; `stop` (s) is a time at which to stop.

    Return what was met, by which joint, the step's length now, and whether its dense output is made.
    """
    work = at[0]
    if not may_meet(at, h, stop):
        return NOTHING, 0, h, False
    before = work.counts[EVALUATIONS]
    finish_dense(at, h)
    share, kind, joint = first_event(at, h, stop)
    if kind != NOTHING:
        h = land(at, share, kind, joint, h, stop)
    work.counts[LOCATING] += work.counts[EVALUATIONS] - before
    return kind, joint, h, kind == NOTHING
