"""Everything that is wanted from a step, taken from it once it stands."""

import math

from ..compiled.family import invoke, kernel
from ..joint.dry import FREE
from ..rates import ACCELERATION, DEPTH, ERROR, ERROR_RATE, JOINT_WIDTH, JOINTS, KAPPA, NORMAL, TORQUE
from ..solver.dop853 import END
from ..solver.event import SAMPLES, STEPS
from ..solver.step import finish_dense
from .record import write_samples
from .tally import (
    ACCELERATION_MAX,
    CONTACT_TIME,
    DEPTH_MAX,
    ERROR_MAX,
    FORCE_MAX,
    NODES,
    PEAK,
    RESIDUAL,
    TORQUE_MAX,
    WHOLE,
    add_course,
    add_powers,
    may_peak,
    refined_peak,
    stage_peak,
)


@kernel
def located(at, h, made, best, column, sign, least):
    """Return the largest value of an observable times `sign` in the step, and whether the dense output is made now.

    `best` is the larger of the values at the ends; what lies between is located unless it stays below `least`.
    """
    work = at[0]
    if may_peak(work.o, column, sign):
        seen, node = stage_peak(work.o, column, sign)
        if seen > least:
            if not made:
                finish_dense(at, h)
            return max(best, refined_peak(at, column, sign, node)), True
    return best, made


@kernel
def note_contact(at, h, j, windowed, made):
    """Update the largest force and depth of joint `j`, in contact; return whether the dense output is made now."""
    work = at[0]
    tally = work.tally
    row, column = tally.joint[j], JOINTS + JOINT_WIDTH * j + NORMAL
    best = max(work.o[0, column], work.o[END, column])
    best, made = located(at, h, made, best, column, 1.0, 0.9 * row[PEAK])
    row[PEAK] = max(row[PEAK], best)
    if windowed:
        row[FORCE_MAX] = max(row[FORCE_MAX], best)
        column = JOINTS + JOINT_WIDTH * j + DEPTH
        best = max(work.o[0, column], work.o[END, column])
        best, made = located(at, h, made, best, column, 1.0, 0.98 * row[DEPTH_MAX])
        row[DEPTH_MAX] = max(row[DEPTH_MAX], best)
    return made


@kernel
def note_motion(at, h, made):
    """Update the largest slider acceleration, torque and slider error; return whether the dense output is made now."""
    work = at[0]
    tally = work.tally
    whole = tally.whole
    for column, place in ((ACCELERATION, ACCELERATION_MAX), (TORQUE, TORQUE_MAX)):
        best = max(abs(work.o[0, column]), abs(work.o[END, column]))
        sign = math.copysign(1.0, work.o[END, column])
        best, made = located(at, h, made, best, column, sign, 0.98 * whole[place])
        whole[place] = max(whole[place], best)
    best = max(abs(work.o[0, ERROR]), abs(work.o[END, ERROR]))
    sign = math.copysign(1.0, work.o[END, ERROR])
    rise, fall = sign * work.o[0, ERROR_RATE], sign * work.o[END, ERROR_RATE]
    highest = best + 0.25 * h * work.o[0, KAPPA] * min(rise, -fall)  # a parabola's rise above the higher end
    if rise > 0.0 > fall and highest > whole[ERROR_MAX]:
        if not made:
            finish_dense(at, h)
            made = True
        best = max(best, refined_peak(at, ERROR, sign, NODES.size // 2))
    whole[ERROR_MAX] = max(whole[ERROR_MAX], best)
    return made


@kernel
def enter(at, h, windowed, dense):
    """Take everything that is wanted from the step of length `h` just taken."""
    work = at[0]
    tally = work.tally
    record = work.record
    time = work.time
    duration = work.end[time] - work.y[time]
    work.counts[STEPS] += 1
    add_powers(at, h, windowed)
    made = dense
    for j in range(work.state.size):
        if work.state[j] != FREE:
            made = note_contact(at, h, j, windowed, made)
            if windowed:
                tally.joint[j, CONTACT_TIME] += duration
                add_course(at, j, duration)
        elif windowed:
            depth = work.o[END, JOINTS + JOINT_WIDTH * j + DEPTH]
            tally.joint[j, DEPTH_MAX] = max(tally.joint[j, DEPTH_MAX], depth)
    if windowed:
        made = note_motion(at, h, made)
        if work.wear.code != 0:
            tally.length[0] = h
            arrays = (work.y, work.end, work.state, tally.course, tally.length, tally.wear, tally.account)
            invoke(work.wear.code, work.wear.parameters, arrays, tally.wear.size // (2 * work.state.size))
    i = work.counts[SAMPLES]
    if i < record.times.size and record.times[i] <= work.end[time]:
        if not made:
            finish_dense(at, h)
        write_samples(at)


@kernel
def open_window(at):
    """Begin the figures anew; energies and the present contacts go on."""
    tally = at[0].tally
    for column in range(RESIDUAL + 1, WHOLE):
        tally.whole[column] = 0.0
    for j in range(tally.joint.shape[0]):
        for column in range(PEAK):
            tally.joint[j, column] = 0.0
        tally.joint[j, DEPTH_MAX] = -math.inf
