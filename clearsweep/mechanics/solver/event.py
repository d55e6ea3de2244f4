"""Where a step meets an event: onset, separation, clipped force, yielding, sticking, or a time at which to stop.

Free flight is searched, not only tested at the ends of a step: the journal's path through the step is followed on the
dense output, in parts as long as it cannot have arrived or a SPANS-th, each with its end values and end slopes, and a
rise and fall in between is bounded by its end tangents and, where these reach the bearing, maximised.
"""

import math
from typing import NamedTuple

import numpy as np

from ..compiled.family import Entry, invoke, kernel
from ..joint.dry import CLIPPED, FREE, STUCK
from ..rates import DEPTH, JOINT_WIDTH, JOINTS, KAPPA, RATE, RAW, SPEED
from .dop853 import END, SCRATCH, dense_component, dense_state

# TURN, REACH: a contact that yields begins to part; comes back to the deepest point it has been to
# STICK, SLIP: sliding slows down to where surfaces stick; is beyond it again
NOTHING, ONSET, SEPARATION, CLIP, UNCLIP, STOP, TURN, REACH, STICK, SLIP = range(10)
SPANS = 8  # parts of a step in free flight: the path of a journal within an eighth of a step is close to a cubic
MARGIN = 1.2  # on the largest speed seen at the stages: bounds the speed between them
FARTHEST = 8.0  # clearances that a journal in free flight may travel in a step, so that SPANS of it can be followed
ROUNDING = 4.0e-16
CLOSE_ENOUGH = 1e-9  # of a step: the step that ends at an onset corrects what is left
LOOSE = 1.001  # times the sliding speed at which surfaces stick: there they are loose again
BEYOND = 1.0 + 1e-12  # times the root of the deepest penetration: not reached again by rounding
EXPLICIT, IMPLICIT = 0, 1  # methods
# Counters in Work.counts; LOCATING: evaluations spent on finding events and stepping to them
STEPS, REJECTED, EVALUATIONS, LOCATING, EVENTS, SEPARATIONS, SAMPLES, COUNTS = range(8)


class Work(NamedTuple):
    """The arrays and constants of one integration; n numbers in the state, j joints.

    Functions get it as `at`, a pointer: handed over by value, its arrays would cost more than what is done with them.
    """

    rates: Entry  # the right-hand side
    sample: Entry  # the time histories
    wear: Entry  # the wear; NO_ENTRY where there is none
    time: int  # place of the time in the state; the roots of penetration follow it
    pace: float  # rad/s, Scene.pace
    sigma: float  # m^0.5, Scene.sigma
    longest: float  # s, a step spans no more

    y: np.ndarray  # (n,) state at the start of the step
    end: np.ndarray  # (n,) state at its end
    z: np.ndarray  # (n,) state of a stage or on the dense output
    k: np.ndarray  # (16, n) rates
    o: np.ndarray  # (16, columns) observables
    f: np.ndarray  # (7, n) dense output
    scale: np.ndarray  # (n,) allowed error
    state: np.ndarray  # (j,) FREE, PRESSED, CLIPPED or STUCK
    onset: np.ndarray  # (j,) m/s, closing rate at which the present contact began, floored
    clearance: np.ndarray  # (j,) m
    side: np.ndarray  # (j,) Joint.side
    band: np.ndarray  # (j,) m/s, sliding speed below which the surfaces stick; 0 where they do not
    deepest: np.ndarray  # (j,) int64, place in the state of Plastic.deepest; 0 where the law does not yield
    owner: np.ndarray  # (memories,) int64, the joint of each number that laws remember, which follow the roots in `y`
    limit_depth: np.ndarray  # (j,) m, penetration up to which the elastic law is meant to hold; inf: any
    counts: np.ndarray  # (COUNTS,) int64
    mode: np.ndarray  # (3,) int64: method in use, steps in a row that speak for the other, method of the next step
    slopes: np.ndarray  # (2,) int64, the Entry of the rates' derivatives; zeros until the motion turns out to be stiff
    proposals: np.ndarray  # (2^(1+j),) step length by method and joints in contact, 0: none yet
    ahead: np.ndarray  # (3,) length of the next step, how much it may grow and its expected error; 0: not begun
    implicit: tuple  # stiff.Implicit
    tally: tuple  # tally.Tally
    record: tuple  # record.Record


@kernel
def end_of_force(at, j):
    """Return how the force law of joint `j`, in contact, turns to traction within the step: CLIP, UNCLIP or NOTHING."""
    work = at[0]
    block = JOINTS + JOINT_WIDTH * j
    if work.state[j] == CLIPPED:
        return UNCLIP if work.o[END, block + RAW] > 0.0 else NOTHING
    least = 0.0
    for row in range(5, END + 1):  # the stages before are too inaccurate to tell, and close to the start
        least = min(least, work.o[row, block + RAW])
    return CLIP if least < 0.0 else NOTHING


@kernel
def end_of_yield(at, j):
    """Return which end of yielding the step can hold for joint `j`, in contact: TURN, REACH or NOTHING."""
    work = at[0]
    place = work.deepest[j]
    if place > 0 and work.y[place] == 0.0:
        return TURN if work.o[END, JOINTS + JOINT_WIDTH * j + RATE] < 0.0 else NOTHING
    reached = place > 0 and work.end[work.time + 1 + j] > BEYOND * math.sqrt(work.y[place])
    return REACH if reached else NOTHING


@kernel
def end_of_sliding(at, j):
    """Return whether joint `j`, in contact, begins or ceases to stick within the step: STICK, SLIP or NOTHING."""
    work = at[0]
    band = work.band[j]
    if band == 0.0 or work.state[j] == CLIPPED:
        return NOTHING
    column = JOINTS + JOINT_WIDTH * j + SPEED
    start, end = work.o[0, column], work.o[END, column]
    if work.state[j] == STUCK:
        return SLIP if abs(end) > LOOSE * band else NOTHING
    return STICK if abs(end) < band or start * end < 0.0 else NOTHING


@kernel
def changes(at, j):
    """Return the events, but for separation, that the step can hold for joint `j`, in contact."""
    return end_of_force(at, j), end_of_yield(at, j), end_of_sliding(at, j)


@kernel
def fastest(at, j, last):
    """Return the largest speed of the journal of free joint `j`, m per unit of tau, at the stages up to row `last`."""
    work = at[0]
    speed = 0.0
    for row in range(last + 1):
        speed = max(speed, work.o[row, JOINTS + JOINT_WIDTH * j + SPEED] * work.o[row, KAPPA])
    return speed


@kernel
def may_meet(at, h, stop):
    """Return whether the step from `work.y` to `work.end` can hold an event; True wherever that is not excluded."""
    work = at[0]
    if work.end[work.time] >= stop:
        return True
    for j in range(work.state.size):
        block = JOINTS + JOINT_WIDTH * j
        if work.state[j] == FREE:
            # a path from one end to the other strays from the farther end by at most half its length
            reach = max(work.o[0, block + DEPTH], work.o[END, block + DEPTH])
            reach += 0.5 * MARGIN * h * fastest(at, j, END)
            if reach >= 0.0:
                return True
            continue
        start, end = work.k[0, work.time + 1 + j], work.k[END, work.time + 1 + j]
        lowest = min(work.y[work.time + 1 + j], work.end[work.time + 1 + j])
        if lowest <= 0.0 or (start < 0.0 < end and lowest < 0.25 * h * min(-start, end)):
            return True
        for kind in changes(at, j):
            if kind != NOTHING:
                return True
    return False


@kernel
def way(at, h):
    """Return how far journals in free flight go in a step of length `h`, over what they may."""
    work = at[0]
    farthest = 0.0
    for j in range(work.state.size):
        if work.state[j] == FREE:
            farthest = max(farthest, h * fastest(at, j, END - 1) / (FARTHEST * work.clearance[j]))
    return farthest


@kernel
def evaluate(at, y, row):
    """Put the rates of the state `y` into row `row` of `work.k` and its observables into that of `work.o`."""
    work = at[0]
    work.counts[EVALUATIONS] += 1
    invoke(work.rates.code, work.rates.parameters, (y, work.state, work.onset, work.k, work.o), row)


@kernel
def evaluate_dense(at, x):
    """Put the rates and observables at the share `x` of the step into the SCRATCH rows, from the dense output."""
    work = at[0]
    dense_state(x, work.y, work.f, work.z)
    evaluate(at, work.z, SCRATCH)


@kernel
def approach(at, j, h, x):
    """Return depth (m, negative in free flight) and its slope (m per unit of `x`) of joint `j` at the share `x`."""
    work = at[0]
    evaluate_dense(at, x)
    block = JOINTS + JOINT_WIDTH * j
    return work.o[SCRATCH, block + DEPTH], work.o[SCRATCH, block + RATE] * work.o[SCRATCH, KAPPA] * h


@kernel
def excess(at, kind, j, h, stop, x):
    """Return the function of an event at the share `x` of the step: it grows through zero where the event is."""
    work = at[0]
    if kind == ONSET:
        return approach(at, j, h, x)[0]
    if kind == SEPARATION:
        return -dense_component(x, work.time + 1 + j, work.y, work.f)
    if kind == STOP:
        return dense_component(x, work.time, work.y, work.f) - stop
    if kind == REACH:
        return dense_component(x, work.time + 1 + j, work.y, work.f) - BEYOND * math.sqrt(work.y[work.deepest[j]])
    evaluate_dense(at, x)
    if kind == TURN:
        return -work.o[SCRATCH, JOINTS + JOINT_WIDTH * j + RATE]
    if kind in (STICK, SLIP):
        column = JOINTS + JOINT_WIDTH * j + SPEED
        slip = math.copysign(1.0, work.o[0, column]) * work.o[SCRATCH, column]
        return work.band[j] - slip if kind == STICK else abs(slip) - LOOSE * work.band[j]
    raw = work.o[SCRATCH, JOINTS + JOINT_WIDTH * j + RAW]
    return raw if kind == UNCLIP else -raw


@kernel
def crossing(at, kind, j, h, stop, a, b):
    """Return the share in [a, b] at which the event's function grows through zero, to rounding (Illinois)."""
    fa, fb = excess(at, kind, j, h, stop, a), excess(at, kind, j, h, stop, b)
    if fa >= 0.0:
        return a
    side = 0
    for _ in range(100):
        x = (a * fb - b * fa) / (fb - fa)
        if not a < x < b:
            x = 0.5 * (a + b)
        fx = excess(at, kind, j, h, stop, x)
        if fx >= 0.0:
            b, fb = x, fx
            if side == 1:
                fa *= 0.5
            side = 1
        else:
            a, fa = x, fx
            if side == -1:
                fb *= 0.5
            side = -1
        if b - a <= ROUNDING or fx == 0.0:
            break
    return b


@kernel
def turning(at, j, h, a, b, sign):
    """Return the share in [a, b] at which the slope of the depth, times `sign`, turns from positive to negative."""
    for _ in range(60):
        x = 0.5 * (a + b)
        _, slope = approach(at, j, h, x)
        if sign * slope > 0.0:
            a = x
        else:
            b = x
        if b - a <= 1e-12:
            break
    return b


@kernel
def reached(at, j, h, a, da, sa, b, db, sb):
    """Return the share in [a, b] at which free joint `j` reaches its bearing; depths and slopes at both ends are given.

    Newton's method on the depth, kept in the bracket, from where the cubic through the ends crosses zero.  To 1e-9 of
    the step: where it is taken again for the event, the rest is corrected.
    """
    wide, rise = b - a, db - da
    bend, lean = wide * (sa + sb) - 2.0 * rise, 3.0 * rise - wide * (2.0 * sa + sb)
    x = a - wide * da / rise if sa > 0.0 else b  # where it has just left, the depth at `a` is all but 0, too
    for _ in range(3):
        u = (x - a) / wide
        value = da + u * (wide * sa + u * (lean + u * bend))
        slope = sa + u * (2.0 * lean + 3.0 * u * bend) / wide
        better = x - value / slope if slope > 0.0 else b
        x = better if a < better < b else x
    for _ in range(60):
        depth, slope = approach(at, j, h, x)
        if depth >= 0.0:
            b = x
        else:
            a = x
        better = x - depth / slope if slope > 0.0 else -1.0
        if not a <= better <= b:
            better = 0.5 * (a + b)
        move, x = abs(better - x), better
        if move <= CLOSE_ENOUGH:
            break
    return x


@kernel
def first_onset(at, j, h):
    """Return the share of the step at which free joint `j` first touches its bearing, closing; 2 if it does not.

    From each place on the way the next is as far as the journal cannot have come to the bearing, or a SPANS-th.
    """
    work = at[0]
    block = JOINTS + JOINT_WIDTH * j
    xa, da = 0.0, work.o[0, block + DEPTH]
    sa = work.o[0, block + RATE] * work.o[0, KAPPA] * h
    if da >= 0.0 and sa >= 0.0:
        return 0.0
    reach = MARGIN * h * fastest(at, j, END)
    while xa < 1.0:
        xb = min(xa + max(-da / reach if reach > 0.0 else 1.0, 1.0 / SPANS), 1.0)
        if xb < 1.0:
            db, sb = approach(at, j, h, xb)
        else:
            db, sb = work.o[END, block + DEPTH], work.o[END, block + RATE] * work.o[END, KAPPA] * h
        if da < 0.0 <= db:
            return reached(at, j, h, xa, da, sa, xb, db, sb)
        if da >= 0.0 and db >= 0.0 and sa < 0.0 <= sb:  # leaves and comes back, or never quite left
            x = turning(at, j, h, xa, xb, -1.0)
            return x if approach(at, j, h, x)[0] >= 0.0 else crossing(at, ONSET, j, h, 0.0, x, xb)
        peaks = da < 0.0 and db < 0.0 and sa > 0.0 > sb
        if peaks and (da * sb - db * sa + sa * sb * (xb - xa)) / (sb - sa) >= 0.0:  # where the two end tangents meet
            x = turning(at, j, h, xa, xb, 1.0)
            if approach(at, j, h, x)[0] >= 0.0:
                return crossing(at, ONSET, j, h, 0.0, xa, x)
        xa, da, sa = xb, db, sb
    return 2.0


@kernel
def first_separation(at, j, h):
    """Return the share of the step at which joint `j` separates; 2 if it does not."""
    work = at[0]
    xa = 0.0
    for i in range(SPANS):
        xb = (i + 1.0) / SPANS
        if dense_component(xb, work.time + 1 + j, work.y, work.f) <= 0.0:
            return crossing(at, SEPARATION, j, h, 0.0, xa, xb)
        xa = xb
    return 2.0


@kernel
def first_change(at, j, h, kind):
    """Return the share of the step at which the function of an event of joint `j` turns positive; 2 if it does not."""
    xa = 0.0
    for i in range(SPANS):
        xb = (i + 1.0) / SPANS
        if excess(at, kind, j, h, 0.0, xb) > 0.0:
            return crossing(at, kind, j, h, 0.0, xa, xb)
        xa = xb
    return 2.0


@kernel
def first_event(at, h, stop):
    """Return (share of the step, kind, joint) of the first event in it; needs the dense output in `work.f`."""
    work = at[0]
    best, kind, joint = 2.0, NOTHING, 0
    if work.end[work.time] >= stop:
        best, kind = crossing(at, STOP, 0, h, stop, 0.0, 1.0), STOP
    for j in range(work.state.size):
        if work.state[j] == FREE:
            x, what = first_onset(at, j, h), ONSET
        else:
            x, what = first_separation(at, j, h), SEPARATION
            for change in changes(at, j):
                touch = first_change(at, j, h, change) if change != NOTHING else 2.0
                if touch < x:
                    x, what = touch, change
        if x < best:
            best, kind, joint = x, what, j
    return best, kind, joint
