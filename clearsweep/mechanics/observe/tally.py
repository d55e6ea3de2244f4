"""What is summed, counted and maximised along the motion; all of it from the steps themselves, none from samples."""

import math
from typing import NamedTuple

import numpy as np

from ..compiled.family import invoke, kernel
from ..joint.contract import acts, touches
from ..solver.dop853 import END, WEIGHTS
from ..solver.event import IMPLICIT, SAMPLES, STEPS
from ..solver.radau import STAGE_WEIGHTS
from ..solver.step import finish_dense
from .along import (
    HIGHEST_ACCELERATION,
    HIGHEST_DEPTH,
    HIGHEST_FORCE,
    HIGHEST_TORQUE,
    SUM_ACCELERATION,
    SUM_DRIVE,
    SUM_FORCE,
    SUM_FORCE_SQUARE,
    SUM_GRAVITY,
    SUM_LOST,
    SUM_RUBBED,
    SUM_STORED,
    course_of,
    highest_inside,
    integral_of,
    sum_of,
)
from .between import look_between
from .histogram import (
    DEPTH_COURSE,
    FORCE,
    KAPPA_COURSE,
    PARTS,
    RUBBED_COURSE,
    SLIP_COURSE,
    fill_ramp,
    follow,
    share_beyond,
)
from .observables import (
    ACCELERATION,
    DEPTH,
    DRAINED,
    DRY,
    DRY_RUBBED,
    ERROR,
    ERROR_RATE,
    KAPPA,
    KINETIC,
    LOAD,
    NODES,
    NORMAL,
    PRESSURE,
    RUBBED,
    SLIP,
    SPEED,
    TORQUE,
    column_of,
    film_column,
    observed,
    put_load,
    put_rubbed,
)
from .peaks import Peak, located, refined_peak
from .record import write_samples
from .turns import note_turns

# Columns of Tally.whole: five integrals of power since the start (J), the balance they make, figures of the window.
WORK_DRIVE, WORK_GRAVITY, ENERGY_STORED, ENERGY_LOST, ENERGY_RUBBED, KINETIC_START, KINETIC_MAX, RESIDUAL = range(8)
ACCELERATION_SQUARE, ACCELERATION_MAX, TORQUE_MAX, ERROR_MAX = range(8, 12)
OPENED, SPEED_MIN, SPEED_MAX, WHOLE = range(12, 16)  # s, when the window began; rad/s, of a free crank
# Columns of Tally.joint: figures of the window, LOAD_MAX in N^2 and taken where there is friction; then PEAK (N) and
# APPROACH (m/s) of the present contact.
(
    FORCE_SQUARE,
    CONTACT_TIME,
    FORCE_MAX,
    LOAD_MAX,
    DEPTH_MAX,
    ONSET_MAX,
    ONSETS,
    CLIPS,
    RESTITUTION,
    REBOUNDS,
    BEYOND_TIME,
    FORCE_TIME,
    FILM_TIME,
    DRY_TIME,
    HELD_TIME,
    DRAINED_ENERGY,
    HEAT,
    DRY_MAX,
    PRESSURE_MAX,
    SPEED_MOST,
    PEAK,
    APPROACH,
    JOINT,
) = range(23)


class Tally(NamedTuple):
    """Sums and maxima of one integration."""

    whole: np.ndarray  # (WHOLE,) of the mechanism
    joint: np.ndarray  # (contacts, JOINT)
    time: np.ndarray  # (contacts, BINS) s, time at a force within each bin, from the ends of ramps
    ramp: np.ndarray  # (contacts, BINS) s/N, changes of the time per force, from ramps that cross a whole bin
    course: np.ndarray  # (contacts, COURSES, PARTS + 1) see histogram, at even places of the step
    length: np.ndarray  # (1,) its length
    between: np.ndarray  # (BETWEEN, 2 coordinates + 1) the state within the step, where there is wear
    room: np.ndarray  # for the wear of a step, see joint.wear.step
    wear: np.ndarray  # (2 contacts bins,) m, wear depth of bearing and journal of every joint
    account: np.ndarray  # (contacts, ACCOUNT) see joint.wear.contract


@kernel
def add_powers(at, h, windowed):
    """Integrate powers and squares over the step of length `h` by the weights of the method, whose order it has."""
    work = at[0]
    tally = work.tally
    o, whole, step = work.o, tally.whole, work.step
    whole[WORK_DRIVE] += h * step[SUM_DRIVE]
    whole[WORK_GRAVITY] += h * step[SUM_GRAVITY]
    if windowed:
        whole[ACCELERATION_SQUARE] += h * step[SUM_ACCELERATION]
    for j in range(work.mode.size):
        if acts(work.mode[j]):
            lost, rubbed = h * step[sum_of(j, SUM_LOST)], h * step[sum_of(j, SUM_RUBBED)]
            whole[ENERGY_STORED] += h * step[sum_of(j, SUM_STORED)]
            whole[ENERGY_LOST] += lost
            whole[ENERGY_RUBBED] += rubbed
            if windowed:
                tally.joint[j, FORCE_SQUARE] += h * step[sum_of(j, SUM_FORCE_SQUARE)]
                tally.joint[j, FORCE_TIME] += h * step[sum_of(j, SUM_FORCE)]
                if work.film[j, 1] < math.inf:
                    tally.joint[j, HEAT] += lost + rubbed
                    weights = STAGE_WEIGHTS if work.method[0] == IMPLICIT else WEIGHTS
                    drained = film_column(work.mode.size, j, DRAINED)
                    tally.joint[j, DRAINED_ENERGY] += h * integral_of(o, drained, weights)
    kinetic = o[END, KINETIC]
    gain = kinetic - whole[KINETIC_START] + whole[ENERGY_STORED] + whole[ENERGY_LOST] + whole[ENERGY_RUBBED]
    whole[RESIDUAL] = max(whole[RESIDUAL], abs(whole[WORK_DRIVE] + whole[WORK_GRAVITY] - gain))
    whole[KINETIC_MAX] = max(whole[KINETIC_MAX], kinetic)


@kernel
def add_course(at, j, duration):
    """Enter the course of contact `j`'s force over a step that lasts `duration` (s) into its histogram."""
    work = at[0]
    tally = work.tally
    course, step = tally.course[j], work.step
    force, kappa = course_of(work.mode.size, j), course_of(work.mode.size, -1)
    limited, worn, film = work.limit_depth[j] < math.inf, work.wear.code != 0, work.film[j, 1] < math.inf
    if worn or limited or film:
        for i in range(PARTS + 1):
            course[FORCE, i], course[KAPPA_COURSE, i] = step[force + i], max(step[kappa + i], 0.0)
        follow(work.o, column_of(j, DEPTH), course, DEPTH_COURSE)
    if worn:
        follow(work.o, column_of(j, SLIP), course, SLIP_COURSE)
        for m in range(NODES.size):
            put_rubbed(work.o, NODES[m], j)
        follow(work.o, column_of(j, RUBBED), course, RUBBED_COURSE)
    total = 0.0
    for i in range(PARTS):
        total += max(step[kappa + i], 0.0) + max(step[kappa + i + 1], 0.0)
    for i in range(PARTS):
        begin, end = step[force + i], step[force + i + 1]
        lasting = (max(step[kappa + i], 0.0) + max(step[kappa + i + 1], 0.0)) * (duration / total)
        if film and begin * end < 0.0:  # the force of a film is negative for a part of the time, not merely close to 0
            positive = max(begin, end) / abs(end - begin)
            tally.time[j, 0] += (1.0 - positive) * lasting
            begin, end, lasting = 0.0, max(begin, end), positive * lasting
        fill_ramp(tally.time[j], tally.ramp[j], begin, end, lasting)
    if limited:
        tally.joint[j, BEYOND_TIME] += share_beyond(course, work.limit_depth[j]) * duration
    if film:
        dry = 1.0 if touches(work.mode[j]) else 0.0
        if work.film[j, 0] != 0.0:
            dry = share_beyond(course, work.film[j, 0])
        tally.joint[j, DRY_TIME] += dry * duration
        tally.joint[j, FILM_TIME] += (1.0 - dry) * duration
        tally.joint[j, HELD_TIME] += share_beyond(course, work.film[j, 1]) * duration
        if worn:
            follow(work.o, film_column(work.mode.size, j, DRY), course, FORCE)  # the film wears nothing off
            follow(work.o, film_column(work.mode.size, j, DRY_RUBBED), course, RUBBED_COURSE)


@kernel
def note_contact(at, h, j, windowed, dense):
    """Update the largest force and depth of contact `j`, under force; return whether the dense output is made now."""
    row, start, end, step = at[0].tally.joint[j], observed(at, 0, j), observed(at, END, j), at[0].step
    least = 0.9 * min(row[PEAK], at[0].turns.since[j])
    peak = Peak(column_of(j, NORMAL), 1.0, least, step[sum_of(j, HIGHEST_FORCE)])
    best, dense = located(at, h, peak, max(start.normal, end.normal), dense)
    row[PEAK], at[0].turns.step[j] = max(row[PEAK], best), best
    if windowed:
        row[FORCE_MAX] = max(row[FORCE_MAX], best)
        film = at[0].film[j, 1] < math.inf
        least = 0.98 * row[DEPTH_MAX]
        if film:  # of the eccentricity, as its least distance from the bearing is wanted, too
            least -= 0.02 * at[0].clearance[j]
        peak = Peak(column_of(j, DEPTH), 1.0, least, step[sum_of(j, HIGHEST_DEPTH)])
        best, dense = located(at, h, peak, max(start.depth, end.depth), dense)
        row[DEPTH_MAX] = max(row[DEPTH_MAX], best)
        if at[0].rubs[j]:
            dense = note_load(at, h, j, dense)
        if film:
            dense = note_film(at, h, j, dense)
    return dense


@kernel
def note_load(at, h, j, dense):
    """Update the largest resultant force of contact `j`, which rubs; return whether the dense output is made now."""
    o, row, column = at[0].o, at[0].tally.joint[j], column_of(j, LOAD)
    for stage in range(END + 1):
        put_load(o, stage, j)
    peak = Peak(column, 1.0, 0.96 * row[LOAD_MAX], highest_inside(o, column, 1.0))
    best, dense = located(at, h, peak, max(o[0, column], o[END, column]), dense)
    row[LOAD_MAX] = max(row[LOAD_MAX], best)
    return dense


@kernel
def note_film(at, h, j, dense):
    """Update the largest dry force and pressure of contact `j`, which has a film; return as `note_contact`."""
    work = at[0]
    row, dry = work.tally.joint[j], film_column(work.mode.size, j, DRY)
    peak = Peak(dry, 1.0, 0.9 * row[DRY_MAX], highest_inside(work.o, dry, 1.0))
    best, dense = located(at, h, peak, max(work.o[0, dry], work.o[END, dry]), dense)
    row[DRY_MAX] = max(row[DRY_MAX], best)
    pressure = film_column(work.mode.size, j, PRESSURE)
    best = max(work.o[0, pressure], work.o[END, pressure])
    if best > 0.95 * row[PRESSURE_MAX]:  # between the ends of a step it is known on the interpolant alone
        if not dense:
            finish_dense(at, h)
            dense = True
        best = max(best, refined_peak(at, pressure, 1.0, NODES.size // 2))
    row[PRESSURE_MAX] = max(row[PRESSURE_MAX], best)
    row[SPEED_MOST] = max(row[SPEED_MOST], work.o[END, film_column(work.mode.size, j, SPEED)])
    return dense


@kernel
def note_motion(at, h, dense):
    """Update the largest slider acceleration, torque and slider error; return whether the dense output is made now."""
    work = at[0]
    whole = work.tally.whole
    for column, place, within in (
        (ACCELERATION, ACCELERATION_MAX, HIGHEST_ACCELERATION),
        (TORQUE, TORQUE_MAX, HIGHEST_TORQUE),
    ):
        best = max(abs(work.o[0, column]), abs(work.o[END, column]))
        sign = math.copysign(1.0, work.o[END, column])
        peak = Peak(column, sign, 0.98 * whole[place], work.step[within])
        best, dense = located(at, h, peak, best, dense)
        whole[place] = max(whole[place], best)
    best = max(abs(work.o[0, ERROR]), abs(work.o[END, ERROR]))
    sign = math.copysign(1.0, work.o[END, ERROR])
    rise, fall = sign * work.o[0, ERROR_RATE], sign * work.o[END, ERROR_RATE]
    highest = best + 0.25 * h * work.o[0, KAPPA] * min(rise, -fall)  # a parabola's rise above the higher end
    if rise > 0.0 > fall and highest > whole[ERROR_MAX]:
        if not dense:
            finish_dense(at, h)
            dense = True
        best = max(best, refined_peak(at, ERROR, sign, NODES.size // 2))
    whole[ERROR_MAX] = max(whole[ERROR_MAX], best)
    return dense


@kernel
def note_speed(at, h):
    """Update the least and the largest speed of a free crank: of the cubic through the ends of the step."""
    work = at[0]
    whole, place = work.tally.whole, work.along + work.time // 2
    begin, end = work.y[place], work.end[place]
    first, last = h * work.k[0, place], h * work.k[END, place]
    lean, bend = 3.0 * (end - begin) - 2.0 * first - last, first + last - 2.0 * (end - begin)
    low, high = min(begin, end), max(begin, end)
    root = lean * lean - 3.0 * bend * first
    if root >= 0.0:
        away = lean + math.copysign(math.sqrt(root), lean)  # both turning points without cancellation
        for u in (-away / (3.0 * bend) if bend != 0.0 else 2.0, -first / away if away != 0.0 else 2.0):
            if 0.0 < u < 1.0:
                value = begin + u * (first + u * (lean + u * bend))
                low, high = min(low, value), max(high, value)
    whole[SPEED_MIN], whole[SPEED_MAX] = min(whole[SPEED_MIN], low), max(whole[SPEED_MAX], high)


@kernel
def note_wear(at, h):
    """Enter the wear of the step of length `h`."""
    work = at[0]
    tally = work.tally
    tally.length[0] = h
    look_between(at, h, tally.between)
    step = (work.y, work.end, tally.between, work.mode, tally.course, tally.length, tally.room)
    invoke(
        work.wear.code,
        work.wear.parameters,
        (*step, tally.wear, tally.account),
        tally.wear.size // (2 * work.mode.size),
    )


@kernel
def note_step(at, h, windowed, dense):
    """Take everything that is wanted from the step of length `h` just taken; `dense`: its dense output is made."""
    work = at[0]
    tally, record, time = work.tally, work.record, work.time
    duration = work.end[time] - work.y[time]
    work.counts[STEPS] += 1
    add_powers(at, h, windowed)
    touching = False
    for j in range(work.mode.size):
        work.turns.step[j] = 0.0
        touching = touching or touches(work.mode[j])
        if acts(work.mode[j]):
            dense = note_contact(at, h, j, windowed, dense)
            if windowed:
                if touches(work.mode[j]):
                    tally.joint[j, CONTACT_TIME] += duration
                add_course(at, j, duration)
        elif windowed:
            tally.joint[j, DEPTH_MAX] = max(tally.joint[j, DEPTH_MAX], observed(at, END, j).depth)
    if windowed:
        dense = note_motion(at, h, dense)
        if work.along != time:
            note_speed(at, h)
        if work.wear.code != 0 and touching:
            note_wear(at, h)
    dense = note_turns(at, h, dense)
    i = work.counts[SAMPLES]
    if i < record.times.size and record.times[i] <= work.end[record.along]:
        if not dense:
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
    tally.whole[OPENED] = at[0].end[at[0].time] if at[0].counts[STEPS] else at[0].y[at[0].time]
    tally.whole[SPEED_MIN], tally.whole[SPEED_MAX] = math.inf, -math.inf
