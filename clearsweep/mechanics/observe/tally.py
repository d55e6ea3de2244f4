"""What is summed, counted and maximised along the motion; all of it from the steps themselves, none from samples."""

import math
from typing import NamedTuple

import numpy as np

from ..compiled.family import kernel
from ..joint.dry import FREE
from ..rates import (
    ACCELERATION,
    DEPTH,
    DRIVE,
    GRAVITY,
    JOINT_WIDTH,
    JOINTS,
    KAPPA,
    KINETIC,
    LOST,
    NORMAL,
    RUBBED,
    SPEED,
    STORED,
)
from ..solver.dop853 import END, SCRATCH, WEIGHTS
from ..solver.event import IMPLICIT, evaluate_dense
from ..solver.radau import STAGE_WEIGHTS

# Columns of Tally.whole: five integrals of power since the start (J), the balance they make, figures of the window.
WORK_DRIVE, WORK_GRAVITY, ENERGY_STORED, ENERGY_LOST, ENERGY_RUBBED, KINETIC_START, KINETIC_MAX, RESIDUAL = range(8)
ACCELERATION_SQUARE, ACCELERATION_MAX, TORQUE_MAX, ERROR_MAX, WHOLE = range(8, 13)
# Columns of Tally.joint: figures of the window, then PEAK (N) and APPROACH (m/s) of the present contact.
(
    FORCE_SQUARE,
    CONTACT_TIME,
    FORCE_MAX,
    DEPTH_MAX,
    ONSET_MAX,
    ONSETS,
    CLIPS,
    RESTITUTION,
    REBOUNDS,
    BEYOND_TIME,
    PEAK,
    APPROACH,
    JOINT,
) = range(13)
# Histogram of the normal force over time: bins of equal ratio within a factor of two of being so, from the bits of the
# number: BIN_BITS of the mantissa, so a bin is at most 2^-BIN_BITS wide relative to its lower edge.
BIN_BITS = 8
LOWEST = -20  # exponent of 2 of the lowest force told apart, N
BINS = 62 << BIN_BITS
FIRST_BIN = (1023 + LOWEST) << BIN_BITS  # the bits of 2^LOWEST
EDGES = ((np.arange(BINS + 1) + FIRST_BIN) << (52 - BIN_BITS)).view(np.float64)  # N
WIDTHS = np.diff(EDGES)  # N
PARTS = 8  # of a step, into which the course of the force is divided for the histogram and for wear
FORCE, KAPPA_COURSE, SLIP, DEPTH_COURSE, COURSES = range(5)  # rows of Tally.course
NODES = np.array([0, 6, 5, 9, 8, 10, 12])  # rows of o whose stages lie at the distinct times SHARES
SHARES = np.array([0.0, 0.25, 1.0 / 3.0, 0.6, 0.6512820512820513, 0.8571428571428571, 1.0])


def _lagrange(nodes, points):
    """Return the (points, nodes) matrix of the polynomial through values at `nodes`, evaluated at `points`."""
    matrix = np.ones((points.size, nodes.size))
    for i in range(nodes.size):
        for m in range(nodes.size):
            if m != i:
                matrix[:, i] *= (points - nodes[m]) / (nodes[i] - nodes[m])
    return matrix


COURSE = np.ascontiguousarray(_lagrange(SHARES, np.arange(PARTS + 1) / PARTS).T)  # (stages, places)


class Tally(NamedTuple):
    """Sums and maxima of one integration."""

    whole: np.ndarray  # (WHOLE,) of the mechanism
    joint: np.ndarray  # (joints, JOINT)
    time: np.ndarray  # (joints, BINS) s, time at a force within each bin, from the ends of ramps
    ramp: np.ndarray  # (joints, BINS) s/N, changes of the time per force, from ramps that cross a whole bin
    course: np.ndarray  # (joints, COURSES, PARTS + 1) force, dt/dtau, slip and depth at even places of the step in hand
    length: np.ndarray  # (1,) its length
    wear: np.ndarray  # (2 joints bins,) m, wear depth of bearing and journal of every joint
    account: np.ndarray  # (joints, 2) see joint.wear.contract


@kernel
def force_bin(force):
    """Return the histogram bin of `force` (N): the leading bits of its exponent and mantissa, from LOWEST on."""
    place = (np.float64(force).view(np.int64) >> (52 - BIN_BITS)) - FIRST_BIN
    return min(max(place, 0), BINS - 1)


@kernel
def bin_edge(place):
    """Return the lower edge (N) of the histogram bin `place`."""
    return np.int64((place + FIRST_BIN) << (52 - BIN_BITS)).view(np.float64)


@kernel
def fill_ramp(time, ramp, a, b, duration):
    """Enter a force that goes from `a` to `b` (N) at an even rate during `duration` (s)."""
    low, high = max(min(a, b), 0.0), max(a, b, 0.0)
    i, k = force_bin(low), force_bin(high)
    if i == k:
        time[i] += duration
        return
    density = duration / (high - low)
    time[i] += density * (bin_edge(i + 1) - low)
    time[k] += density * (high - bin_edge(k))
    if k > i + 1:  # whole bins between: else a huge density would come and go, and leave its rounding
        ramp[i + 1] += density
        ramp[k] -= density


def force_exceeded(time, ramp, duration):
    """Return the force (N) that is exceeded during `duration` (s); 0 where contact lasted less than that.

    time, ramp : (BINS,) rows of the Tally.
    """
    for count in (4 << BIN_BITS, BINS):  # the highest bins mostly suffice
        entered = (time != 0.0) | (ramp != 0.0)
        top = BINS - int(entered[::-1].argmax())  # above, nothing was
        low = max(top - count, 0)
        density = -np.cumsum(ramp[low:top][::-1])  # of the bins from the top down, each without its own change
        density[1:], density[0] = density[:-1].copy(), 0.0
        spent = time[low:top][::-1] + density * WIDTHS[low:top][::-1]
        above = np.cumsum(spent)  # time at a force of each bin or higher
        if above[-1] >= duration:
            place = int((above >= duration).argmax())
            edge = top - 1 - place
            return EDGES[edge] + (above[place] - duration) / spent[place] * WIDTHS[edge]
    return 0.0


@kernel
def add_powers(at, h, windowed):
    """Integrate powers and squares over the step of length `h` by the weights of the method, whose order it has."""
    work = at[0]
    tally = work.tally
    o, whole = work.o, tally.whole
    implicit = work.mode[0] == IMPLICIT
    for row in range(SCRATCH if implicit else END):
        share = h * (STAGE_WEIGHTS[row] if implicit else WEIGHTS[row]) * o[row, KAPPA]
        if share == 0.0:
            continue
        whole[WORK_DRIVE] += share * o[row, DRIVE]
        whole[WORK_GRAVITY] += share * o[row, GRAVITY]
        if windowed:
            whole[ACCELERATION_SQUARE] += share * o[row, ACCELERATION] ** 2
        for j in range(work.state.size):
            if work.state[j] != FREE:
                block = JOINTS + JOINT_WIDTH * j
                whole[ENERGY_STORED] += share * o[row, block + STORED]
                whole[ENERGY_LOST] += share * o[row, block + LOST]
                whole[ENERGY_RUBBED] += share * o[row, block + RUBBED]
                if windowed:
                    tally.joint[j, FORCE_SQUARE] += share * o[row, block + NORMAL] ** 2
    kinetic = o[END, KINETIC]
    gain = kinetic - whole[KINETIC_START] + whole[ENERGY_STORED] + whole[ENERGY_LOST] + whole[ENERGY_RUBBED]
    whole[RESIDUAL] = max(whole[RESIDUAL], abs(whole[WORK_DRIVE] + whole[WORK_GRAVITY] - gain))
    whole[KINETIC_MAX] = max(whole[KINETIC_MAX], kinetic)


@kernel
def follow(o, column, course, row):
    """Put an observable's course over the step, at PARTS + 1 even places, into row `row` of `course`.

    It is the polynomial through the values at the stages.
    """
    for i in range(PARTS + 1):
        course[row, i] = 0.0
    for m in range(NODES.size):
        here = o[NODES[m], column]
        for i in range(PARTS + 1):
            course[row, i] += COURSE[m, i] * here


@kernel
def add_course(at, j, duration):
    """Enter the course of joint `j`'s force over a step that lasts `duration` (s) into its histogram."""
    work = at[0]
    tally = work.tally
    block = JOINTS + JOINT_WIDTH * j
    course = tally.course[j]
    follow(work.o, block + NORMAL, course, FORCE)
    follow(work.o, KAPPA, course, KAPPA_COURSE)
    limited, worn = work.limit_depth[j] < math.inf, work.wear.code != 0
    if worn:
        follow(work.o, block + SPEED, course, SLIP)
    if worn or limited:
        follow(work.o, block + DEPTH, course, DEPTH_COURSE)
    total = 0.0
    for i in range(PARTS + 1):
        course[KAPPA_COURSE, i] = max(course[KAPPA_COURSE, i], 0.0)
        total += course[KAPPA_COURSE, i]
    total -= 0.5 * (course[KAPPA_COURSE, 0] + course[KAPPA_COURSE, PARTS])
    for i in range(PARTS):
        part = 0.5 * (course[KAPPA_COURSE, i] + course[KAPPA_COURSE, i + 1]) / total
        fill_ramp(tally.time[j], tally.ramp[j], course[FORCE, i], course[FORCE, i + 1], part * duration)
    if limited:
        add_beyond(at, j, duration)


@kernel
def add_beyond(at, j, duration):
    """Add the time (s) of a step of `duration` in which joint `j` is deeper than its elastic law is meant for."""
    work = at[0]
    course = work.tally.course[j]
    beyond, total = 0.0, 0.0
    for i in range(PARTS + 1):
        total += course[KAPPA_COURSE, i]
        if course[DEPTH_COURSE, i] > work.limit_depth[j]:
            beyond += course[KAPPA_COURSE, i]
    work.tally.joint[j, BEYOND_TIME] += beyond / total * duration


@kernel
def may_peak(o, column, sign):
    """Return whether the observable, times `sign`, rises at the start of the step and falls at its end, or nearly so.

    Slopes of the parabolas through three stages at either end, a tenth of the step outside: a peak close to an end
    counts in both steps that meet there.
    """
    rise = START[0] * o[0, column] + START[1] * o[3, column] + START[2] * o[6, column]
    fall = FINISH[0] * o[8, column] + FINISH[1] * o[10, column] + FINISH[2] * o[END, column]
    return sign * rise > 0.0 and sign * fall < 0.0


def _slope(nodes, point):
    """Return the weights that give the slope at `point` of the parabola through values at three `nodes`."""
    a, b, c = nodes
    return np.array(
        [
            (2 * point - b - c) / ((a - b) * (a - c)),
            (2 * point - a - c) / ((b - a) * (b - c)),
            (2 * point - a - b) / ((c - a) * (c - b)),
        ]
    )


START = _slope((0.0, 0.11835034190722739, 0.25), -0.1)
FINISH = _slope((0.6512820512820513, 0.8571428571428571, 1.0), 1.1)


@kernel
def stage_peak(o, column, sign):
    """Return the largest value of the observable, times `sign`, at the distinct stages, and the node where it is."""
    best = 0
    for m in range(1, NODES.size):
        if sign * o[NODES[m], column] > sign * o[NODES[best], column]:
            best = m
    return sign * o[NODES[best], column], best


@kernel
def observe(at, x, column):
    """Return the observable at the share `x` of the step, from the dense output in `work.f`."""
    work = at[0]
    evaluate_dense(at, x)
    return work.o[SCRATCH, column]


@kernel
def refined_peak(at, column, sign, node):
    """Return the largest value of the observable, times `sign`, near the stage `node`: successive parabolas."""
    m = min(max(node, 1), NODES.size - 2)
    a, b, c = SHARES[m - 1], SHARES[m], SHARES[m + 1]
    fa = sign * observe(at, a, column)
    fb = sign * observe(at, b, column)
    fc = sign * observe(at, c, column)
    best = max(fa, fb, fc)
    for _ in range(3):
        bend = (fa - fb) / (a - b) - (fb - fc) / (b - c)
        if bend * (a - c) >= 0.0:  # not concave: the peak is at an end
            break
        x = 0.5 * (a + b) - 0.5 * (a - c) * (fa - fb) / ((a - b) * bend)
        x = min(max(x, 0.0), 1.0)
        if x in (a, b, c):
            break
        fx = sign * observe(at, x, column)
        best = max(best, fx)
        if abs(x - a) > abs(x - c):  # drop the farther end
            a, fa, b, fb = b, fb, x, fx
        else:
            b, fb, c, fc = x, fx, b, fb
    return best
