"""Where a step meets an event: onset, separation, a guard of a joint's law, or a time at which to stop.

Every function that an event is the crossing of is a polynomial over the step, through its values at the start and the
stages; its coefficients in Bernstein's form bound it, so that no rise and fall between two stages is missed, and nothing
is evaluated to find where it crosses zero, see `bernstein`.
"""

import math
from typing import NamedTuple

import numpy as np

from ..compiled.family import Entry, inlined, invoke, kernel
from ..joint.contract import meets, touches
from ..observe.observables import DEPTH, KAPPA, RATE, column_of
from ..observe.stages import END, NODES, SCRATCH, SHARES, STAGES, START
from .accumulate.step_sums import TrialStep
from .accumulate.totals import Accumulators
from .bernstein import (
    COEFFICIENTS,
    DEGREE,
    FINE,
    NOWHERE,
    VALUES,
    WHOLE,
    first_crossing,
    from_interpolant,
    from_values,
    highest,
    lower,
    lowest_place,
    tail,
    turn_sign,
    value_and_slope,
)
from .collocation import dense_state
from .guarding import ELSEWHERE, evaluate_guards, looked_at

# Kinds of events; LIMIT: a penetration passes that up to which its elastic law holds, which changes nothing; GUARD and
# beyond: the guards of joints
NOTHING, ONSET, SEPARATION, STOP, LIMIT, GUARD = range(6)
FARTHEST = 8.0  # clearances that a journal in free flight may travel in a step
ROUGH = 1e-3  # tail of a gap's polynomial, over its size, from which on the step is looked at in parts,
RIGHT = 1e-12  # of the size of a guard: so close to zero its polynomial's crossing is taken for its own
NEXT_TO_ROOT, ENOUGH = 0.05, 1e-7  # of a step: how far Newton's method may move an onset, and when it ends
HALVING = 16  # looks after which the rest is halved
LEAST_PART = 1.0 / 16.0  # of a step, at the shortest
PASSED = 1e-9  # of the root of a penetration: a step that begins as close to a limit has just passed it
NEXT_TO_START = 0.125  # share of a step at which a guard that was passed at its start has still to be
EXPLICIT, IMPLICIT = 0, 1  # methods
# Counters in Work.counts; LOCATING: evaluations spent on finding events and stepping to them
STEPS, REJECTED, EVALUATIONS, LOCATING, EVENTS, SEPARATIONS, SAMPLES, COUNTS = range(8)


class Work(NamedTuple):
    """The arrays and constants of one integration: n numbers in the state, m of them of laws, l latched; c contacts.

    Functions get it as `at`, a pointer: handed over by value, its arrays would cost more than what is done with them.
    """

    rates: Entry  # the right-hand side
    sweep: Entry  # a sweep of the iteration of a step, see `collocation`
    observed: Entry  # the observables of all stages
    sample: Entry  # the time histories
    wear: Entry  # the wear; NO_ENTRY where there is none
    time: int  # place of the time in the state; the roots of penetration, then the internal states follow it
    independent: int  # place in the state of what the run is measured along: the time, or the angle of a free crank
    knots: np.ndarray  # (k,) where along it a step has to end, as an acceleration jumps there
    reference_rate: float  # rad/s, Scene.reference_rate
    sigma: float  # m^0.5, Scene.sigma
    longest: float  # s, a step spans no more

    y: np.ndarray  # (n,) state at the start of the step
    end: np.ndarray  # (n,) state at its end
    z: np.ndarray  # (n,) state of a stage or on the dense output
    k: np.ndarray  # (n, PLACES) rates
    o: np.ndarray  # (columns, PLACES) observables
    nodes: np.ndarray  # (n + 1, STAGES) states at the stages; last how far the latest sweep moved each of them
    weight: np.ndarray  # (n,) 1 / allowed error
    mode: np.ndarray  # (c,) int64, what each contact does: contract.FREE, PRESSED or another of its joint's modes
    latched: np.ndarray  # (c + l,) what changes at events alone: closing rate (m/s) of each onset, floored; of laws
    step: np.ndarray  # (step_width,) the length of a step that is tried and what it comes to, see observe.along
    clearance: np.ndarray  # (c,) m
    rubs: np.ndarray  # (c,) int64, whether there is friction: 1, else 0
    film: np.ndarray  # (c, 2) m, depth beyond which a film bears not alone, and its formula is kept; inf: never
    stepper: np.ndarray  # (AHEAD,) what the loop goes on with, see plan
    f: np.ndarray  # (n, STAGES) the interpolant, see `collocation.dense_component`
    polynomials: np.ndarray  # (ROWS, COEFFICIENTS) of the function in hand, see `bernstein`
    apart: np.ndarray  # (c,) int64, the mode to which a separation leads
    pressed: np.ndarray  # (c,) int64, the mode to which an onset leads
    side: np.ndarray  # (c,) Joint.side
    limit_depth: np.ndarray  # (c,) m, penetration up to which the elastic law is meant to hold; inf: any
    ended_by: np.ndarray  # (m,) int64, the contact whose separation ends a number of internal state; -1: it is kept
    began: np.ndarray  # (m,) where the number begins
    counts: np.ndarray  # (COUNTS,) int64
    method: np.ndarray  # (3,) int64: method in use, steps in a row that speak for the other, method of the next step
    slopes: np.ndarray  # (2,) int64, the Entry of the rates' derivatives; zeros until the motion turns out to be stiff
    proposals: np.ndarray  # (2^(1+c),) step length by method and contacts that touch, 0: none yet
    paces: np.ndarray  # (2^(1+c),) m/s, the rate at which the fastest of these contacts began
    control: np.ndarray  # (len(Control),) what ends the motion, see plan.Control
    log: np.ndarray  # (LOG, 5) events since the motion was last looked at, see passing.Event
    guards: tuple  # joint.guards.Guards
    implicit: tuple  # newton.Implicit
    totals: tuple  # totals.Totals
    record: tuple  # record.Record
    turns: tuple  # turns.Turns


@inlined
def trial_of(at):
    """Return the TrialStep of a case."""
    work = at[0]
    return TrialStep(work.y, work.mode, work.k, work.o, work.end, work.step)


@inlined
def accumulators_of(at):
    """Return the Accumulators of a case."""
    work, totals, turns = at[0], at[0].totals, at[0].turns
    given = (work.y, work.mode, work.k, work.o, work.end, work.step, work.stepper, work.clearance, work.film, work.rubs)
    return Accumulators(*given, totals.whole, totals.joint, totals.bins, totals.spent, turns.highest, turns.since)


@kernel
def evaluate(at, y, row):
    """Put the rates of the state `y` into row `row` of `work.k` and its observables into that of `work.o`."""
    work = at[0]
    work.counts[EVALUATIONS] += 1
    invoke(work.rates.code, work.rates.parameters, (y, work.mode, work.latched, work.k, work.o), row)


@kernel
def evaluate_dense(at, x):
    """Put the rates and observables at the share `x` of the step into the SCRATCH rows, from the dense output."""
    work = at[0]
    dense_state(x, work.y, work.f, work.z)
    evaluate(at, work.z, SCRATCH)


@kernel
def take_gap(at, j, h):
    """Make the polynomial of contact `j` in free flight, above zero where it touches, from the depths at the nodes.

    It is d (d + 2 s) of the depth d (m) and its largest size s, of a journal in a bearing the square of the eccentricity
    less that of the clearance: smooth also where the path passes the middle, where the depth has a kink.
    """
    work, there = at[0], column_of(j, DEPTH)
    p, size = work.polynomials, work.clearance[j]
    for m in range(COEFFICIENTS):
        size = max(size, -work.o[there, NODES[m]])
    for m in range(COEFFICIENTS):
        depth = work.o[there, NODES[m]]
        p[VALUES, m] = depth * (depth + 2.0 * size)
    from_values(p)
    rise = work.o[column_of(j, RATE), START] * work.o[KAPPA, START] * h
    p[WHOLE, 1] = p[WHOLE, 0] + 2.0 * (work.o[there, START] + size) * rise / DEGREE  # its slope is known at the start


@kernel
def take_part_of_gap(at, j, begin, width):
    """Make the same over a part of the step, of the interpolant."""
    work, there = at[0], column_of(j, DEPTH)
    p, size = work.polynomials, work.clearance[j]
    for m in range(COEFFICIENTS):
        evaluate_dense(at, begin + width * SHARES[m])
        p[VALUES, m] = work.o[there, SCRATCH]
        size = max(size, -p[VALUES, m])
    for m in range(COEFFICIENTS):
        p[VALUES, m] *= p[VALUES, m] + 2.0 * size
    from_values(p)


@kernel
def is_rough(p):
    """Return whether WHOLE, which may come to zero, may be far from what it stands for."""
    size = 0.0
    for i in range(COEFFICIENTS):
        size = max(size, abs(p[VALUES, i]))
    far = tail(p)
    return far > ROUGH * size and highest(p) + far >= 0.0


@kernel
def crossing_for_certain(p):
    """Return where WHOLE first grows through zero; NOWHERE where it comes no higher than it may be off by."""
    if highest(p) < 0.0:
        return NOWHERE
    seen = False
    for m in range(1, COEFFICIENTS):
        seen = seen or p[VALUES, m] > 0.0
    if not seen:
        far = tail(p)
        lower(p, far)
        if first_crossing(p) == NOWHERE:
            return NOWHERE
        lower(p, -far)
    return first_crossing(p)


@kernel
def first_onset(at, j, h):
    """Return the share of the step at which free contact `j` first touches its bearing, closing; NOWHERE if not."""
    work = at[0]
    p, begin = work.polynomials, work.o[column_of(j, DEPTH), START]
    if begin >= 0.0 and work.o[column_of(j, RATE), START] >= 0.0:
        return 0.0
    take_gap(at, j, h)
    if is_rough(p):
        return first_onset_in_parts(at, j, h)
    x = crossing_for_certain(p)
    if x == NOWHERE and begin >= 0.0 and p[VALUES, DEGREE] >= 0.0:  # never quite left
        return lowest_place(p)
    return x if x == NOWHERE else true_onset(at, j, h, x)


@kernel
def true_onset(at, j, h, x):
    """Return where contact `j` touches its bearing, the polynomial of its gap saying at the share `x`: Newton's method."""
    work = at[0]
    for _ in range(4):
        evaluate_dense(at, x)
        slope = work.o[column_of(j, RATE), SCRATCH] * work.o[KAPPA, SCRATCH] * h
        move = work.o[column_of(j, DEPTH), SCRATCH] / slope if slope != 0.0 else 1.0
        if not abs(move) < NEXT_TO_ROOT:  # all but tangential
            break
        x = min(max(x - move, 0.0), 1.0)
        if abs(move) <= ENOUGH:
            break
    return x


@kernel
def first_onset_in_parts(at, j, h):
    """Return the same where the gap is no smooth function over the step, such as that of worn surfaces."""
    p, begin, width = at[0].polynomials, 0.0, 0.5
    while begin < 1.0:
        take_part_of_gap(at, j, begin, width)
        if width > LEAST_PART and is_rough(p):
            width *= 0.5
        else:
            x = crossing_for_certain(p)
            if x != NOWHERE:
                return true_onset(at, j, h, begin + width * x)
            begin += width
            width = min(2.0 * width, 1.0 - begin)
    return NOWHERE


@kernel
def first_separation(at, j):
    """Return the share of the step at which contact `j` separates; NOWHERE if it does not: exactly on the interpolant."""
    work, root = at[0], at[0].time + 1 + j
    from_interpolant(work.polynomials, work.y[root], work.f, root)
    turn_sign(work.polynomials)
    return first_crossing(work.polynomials) if highest(work.polynomials) >= 0.0 else NOWHERE


@kernel
def first_limit(at, j):
    """Return the share at which the penetration of contact `j` passes the limit of its elastic law; NOWHERE if not."""
    work, root = at[0], at[0].time + 1 + j
    limit = math.sqrt(work.limit_depth[j])
    from_interpolant(work.polynomials, work.y[root] - limit, work.f, root)
    off = work.y[root] - limit
    if off > PASSED * limit or (off > -PASSED * limit and work.k[root, START] > 0.0):
        turn_sign(work.polynomials)
    return first_crossing(work.polynomials) if highest(work.polynomials) >= 0.0 else NOWHERE


@kernel
def take_guard(at, g):
    """Make the polynomial of guard `g`, whose values were evaluated; return whether it can be passed as things are."""
    p, value = at[0].polynomials, at[0].guards.value
    if not (value[g, 0] > -math.inf and value[g, DEGREE] > -math.inf):
        return False
    for m in range(COEFFICIENTS):
        p[VALUES, m] = value[g, m]
    from_values(p)
    return True


@kernel
def guard_value(at, g, x):
    """Return the value of guard `g` at the share `x` of the step, of the interpolant."""
    evaluate_dense(at, x)
    evaluate_guards(at, at[0].z, SCRATCH)
    return at[0].guards.value[g, ELSEWHERE]


@kernel
def first_passage(at, g):
    """Return the share of the step at which guard `g` turns positive; NOWHERE if it does not."""
    p = at[0].polynomials
    if not take_guard(at, g):
        return NOWHERE
    if p[VALUES, 0] >= 0.0 and value_and_slope(p, WHOLE, NEXT_TO_START)[0] > 0.0:
        return 0.0
    x = crossing_for_certain(p)
    return x if x == NOWHERE else true_passage(at, g, x)


@kernel
def true_passage(at, g, x):
    """Return where guard `g` itself passes zero, its polynomial doing so at the share `x`; NOWHERE if it does not.

    Many are smooth, and a look shows that the polynomial is right.  Others are not, such as the force of a contact that
    leaves its indentation, which goes with a power of 3/2 there.
    """
    p, size = at[0].polynomials, 0.0
    for m in range(COEFFICIENTS):
        size = max(size, abs(p[VALUES, m]))
    for _ in range(3):
        value = guard_value(at, g, x)
        if abs(value) <= RIGHT * size:
            return x
        _, slope = value_and_slope(p, WHOLE, x)
        better = x - value / slope if slope > 0.0 else -1.0
        if not 0.0 <= better <= 1.0:
            break
        x = better
    value = guard_value(at, g, x)
    (a, fa), (b, fb) = (0.0, p[VALUES, 0]), (1.0, p[VALUES, DEGREE])
    for m in range(1, COEFFICIENTS):
        if SHARES[m] <= x and p[VALUES, m] < 0.0:
            a, fa = SHARES[m], p[VALUES, m]
    for m in range(DEGREE, 0, -1):
        if SHARES[m] > a and p[VALUES, m] > 0.0:
            b, fb = SHARES[m], p[VALUES, m]
    if a < x < b and value < 0.0:
        a, fa = x, value
    elif a < x < b:
        b, fb = x, value
    if fb <= 0.0:  # it rises and falls between two stages
        b = top_behind(p, x)
        fb = guard_value(at, g, b)
        if fb <= 0.0:
            return NOWHERE
    return crossing_between(at, g, (a, fa), (b, fb))


@kernel
def top_behind(p, x):
    """Return where WHOLE is highest, of some places behind `x` up to where it is below zero again."""
    best, top, step = x, 0.0, 0.02 * (1.0 - x)
    for i in range(1, 51):
        value, _ = value_and_slope(p, WHOLE, x + i * step)
        if value <= 0.0:
            break
        if value > top:
            best, top = x + i * step, value
    return best


@kernel
def crossing_between(at, g, begin, end):
    """Return the share at which guard `g` passes zero, known at both ends: (share, value) of each; from behind.

    Regula falsi as Anderson & Bjorck (1973, BIT 13:253) have it: of an end that stays, the value is scaled down by how
    much that at the other has changed.
    """
    (a, fa), (b, fb) = begin, end
    if fa >= 0.0:
        return a
    side = 0
    for tried in range(64):
        x = (a * fb - b * fa) / (fb - fa)
        if tried > HALVING or not a < x < b:  # a jump, or a value that is not finite
            x = 0.5 * (a + b)
        x = min(max(x, a + 0.4 * FINE), b - 0.4 * FINE)  # so that the end that stays follows
        fx = guard_value(at, g, x)
        if fx >= 0.0:
            if side == 1:
                fa *= 1.0 - fx / fb if fx < fb else 0.5
            b, fb, side = x, fx, 1
        else:
            if side == -1:
                fb *= 1.0 - fx / fa if fx > fa else 0.5
            a, fa, side = x, fx, -1
        if b - a <= FINE or fx == 0.0:
            break
    return b


@kernel
def first_stop(at, stop):
    """Return the share of the step at which the run comes to `stop`, which is not beyond its end."""
    work = at[0]
    from_interpolant(work.polynomials, work.y[work.independent] - stop, work.f, work.independent)
    return min(first_crossing(work.polynomials), 1.0)


@kernel
def first_event(at, h, stop):
    """Return (share of the step, kind, contact) of the first event in it; kind NOTHING: there is none."""
    work, guards = at[0], at[0].guards
    best, kind, contact = NOWHERE, NOTHING, 0
    if work.end[work.independent] >= stop:
        best, kind = first_stop(at, stop), STOP
    for j in range(work.mode.size):
        x, what = NOWHERE, NOTHING
        if meets(work.mode[j]):
            x, what = first_onset(at, j, h), ONSET
        elif touches(work.mode[j]):
            x, what = first_separation(at, j), SEPARATION
            if work.limit_depth[j] < math.inf:
                y = first_limit(at, j)
                if y < x:
                    x, what = y, LIMIT
        if x < best:
            best, kind, contact = x, what, j
    if guards.contact.size > 0:
        evaluate_guards(at, work.y, END)
        for g in range(guards.contact.size):
            if looked_at(at, g):
                x = first_passage(at, g)
                if x < best:
                    best, kind, contact = x, GUARD + g, guards.contact[g]
    return best, kind, contact
