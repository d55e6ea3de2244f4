"""Where a step meets an event: onset, separation, a guard of a joint's law, or a time at which to stop.

Free flight is searched, not only tested at the ends of a step: the journal's path through the step is followed on the
dense output, in parts as long as it cannot have arrived or a SPANS-th, each with its end values and end slopes, and a
rise and fall in between is bounded by its end tangents and, where these reach the bearing, maximised.
"""

from typing import NamedTuple

import numpy as np

from ..compiled.family import Entry, inlined, invoke, kernel
from ..joint.contract import meets, touches
from ..observe.observables import KAPPA, observed
from ..observe.stages import END, SCRATCH, START
from .accumulate.step_sums import FASTEST, TrialStep, sum_of
from .accumulate.totals import Accumulators
from .collocation import dense_component, dense_state
from .guarding import evaluate_guards, pass_guards
from .span import Span, cubic_onset, deepest_between, fold

NOTHING, ONSET, SEPARATION, STOP, GUARD = range(5)  # kinds of events; GUARD and beyond: the guards of joints
SPANS = 8  # parts of a step in free flight: the path of a journal within an eighth of a step is close to a cubic
MARGIN = 1.2  # on the largest speed seen at the stages: bounds the speed between them
FARTHEST = 8.0  # clearances that a journal in free flight may travel in a step, so that SPANS of it can be followed
FINE = 1e-12  # of a step: how closely events are located
HALVING = 16  # looks after which the rest is halved
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


@kernel
def fastest(at, j):
    """Return the largest speed of the journal of free contact `j`, m per unit of tau, at the stages."""
    return max(at[0].step[sum_of(j, FASTEST)], observed(at, END, j).slip * at[0].o[KAPPA, END])


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
def approach(at, j, h, x):
    """Return depth (m, negative in free flight) and its slope (m per unit of `x`) of contact `j` at the share `x`."""
    evaluate_dense(at, x)
    return approach_in_row(at, j, h, SCRATCH)


@kernel
def approach_in_row(at, j, h, row):
    """Return the same where the observables in row `row` are."""
    seen = observed(at, row, j)
    return seen.depth, seen.rate * at[0].o[KAPPA, row] * h


@kernel
def guard_value(at, g, x):
    """Return the value of guard `g` at the share `x` of the step."""
    work, guards = at[0], at[0].guards
    if guards.of_state[g]:
        dense_state(x, work.y, work.f, work.z)
    else:
        evaluate_dense(at, x)
    evaluate_guards(at, work.z, SCRATCH)
    return guards.value[0, g]


@kernel
def event_function(at, kind, j, stop, x):
    """Return the function of an event at the share `x` of the step: it grows through zero where the event is."""
    work = at[0]
    if kind == ONSET:
        evaluate_dense(at, x)
        return observed(at, SCRATCH, j).depth
    if kind == SEPARATION:
        return -dense_component(x, work.time + 1 + j, work.y, work.f)
    if kind == STOP:
        return dense_component(x, work.independent, work.y, work.f) - stop
    return guard_value(at, kind - GUARD, x)


@kernel
def crossing(at, event, a, b):
    """Return the share in [a, b] at which the event's function has grown through zero, by FINE at most beyond that.

    event : (kind, contact, place of a STOP along the run).
    """
    kind, j, stop = event
    return crossing_between(
        at, event, (a, event_function(at, kind, j, stop, a)), (b, event_function(at, kind, j, stop, b))
    )


@kernel
def crossing_between(at, event, begin, end):
    """Return the same where the function is known at both ends: (share, value) of each.

    Regula falsi as Anderson & Bjorck (1973, BIT 13:253) have it: of an end that stays, the value is scaled down by how
    much that at the other has changed.
    """
    kind, j, stop = event
    (a, fa), (b, fb) = begin, end
    if fa >= 0.0:
        return a
    side = 0
    for tried in range(64):
        x = (a * fb - b * fa) / (fb - fa)
        if tried > HALVING or not a < x < b:  # a jump, or a value that is not finite
            x = 0.5 * (a + b)
        x = min(max(x, a + 0.4 * FINE), b - 0.4 * FINE)  # so that the end that stays follows
        fx = event_function(at, kind, j, stop, x)
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
def stationary_point(at, j, h, between, sign):
    """Return the share between two at which the slope of the depth, times `sign`, turns from positive to negative."""
    a, b = between
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
def onset_in(at, j, h, span):
    """Return the share of the step at which free contact `j`, apart at the begin of the Span, reaches its bearing.

    Newton's method on the depth, kept in the bracket, to FINE, as the rate there says how hard the impact is.
    """
    a, b, x, before = span.begin, span.end, cubic_onset(span), 0.0
    for _ in range(60):
        depth, slope = approach(at, j, h, x)
        if depth >= 0.0:
            b = x
        else:
            a = x
        better = x - depth / slope if slope > 0.0 else -1.0
        inside = a <= better <= b
        if not inside:
            better = 0.5 * (a + b)
        move, x = abs(better - x), better
        if move <= FINE or (inside and move * move * move <= FINE * before * before):
            break  # what two steps of Newton's method leave
        before = move if inside else 0.0
    return x


@kernel
def first_onset(at, j, h, until):
    """Return the share of the step at which free contact `j` first touches its bearing, closing; 2 if it does not.

    From each place on the way the next is as far as the journal cannot have come to the bearing, or a SPANS-th.
    What is behind the share `until` is not wanted.
    """
    xa = 0.0
    da, sa = approach_in_row(at, j, h, START)
    if da >= 0.0 and sa >= 0.0:
        return 0.0
    reach = MARGIN * h * fastest(at, j)
    last, _ = approach_in_row(at, j, h, END)
    while xa < until and deepest_between(da, last, reach * (1.0 - xa)) >= 0.0:
        safe = -da / reach if reach > 0.0 else 1.0
        xb = min(xa + max(safe, 1.0 / SPANS), 1.0)
        db, sb = approach(at, j, h, xb) if xb < 1.0 else approach_in_row(at, j, h, END)
        if sa * sb > 0.0 and safe < xb - xa:
            x = fold(Span(xa, da, sa, xb, db, sb))
            if x < xb:
                xb = x
                db, sb = approach(at, j, h, xb)
        if da < 0.0 <= db:
            return onset_in(at, j, h, Span(xa, da, sa, xb, db, sb))
        if da >= 0.0 and db >= 0.0 and sa < 0.0 <= sb:  # leaves and comes back, or never quite left
            x = stationary_point(at, j, h, (xa, xb), -1.0)
            return x if approach(at, j, h, x)[0] >= 0.0 else crossing(at, (ONSET, j, 0.0), x, xb)
        peaks = da < 0.0 and db < 0.0 and sa > 0.0 > sb
        if peaks and (da * sb - db * sa + sa * sb * (xb - xa)) / (sb - sa) >= 0.0:  # where the two end tangents meet
            x = stationary_point(at, j, h, (xa, xb), 1.0)
            if approach(at, j, h, x)[0] >= 0.0:
                return crossing(at, (ONSET, j, 0.0), xa, x)
        xa, da, sa = xb, db, sb
    return 2.0


@kernel
def first_separation(at, j, until):
    """Return the share of the step at which contact `j` separates; 2 if it does not, up to the share `until`."""
    work, xa = at[0], 0.0
    for i in range(SPANS):
        if xa >= until:
            break
        xb = (i + 1.0) / SPANS
        if dense_component(xb, work.time + 1 + j, work.y, work.f) <= 0.0:
            return crossing(at, (SEPARATION, j, 0.0), xa, xb)
        xa = xb
    return 2.0


@kernel
def first_passage(at, g, until):
    """Return the share of the step at which guard `g` turns positive; 2 if it does not, up to the share `until`."""
    event = GUARD + g, at[0].guards.contact[g], 0.0
    xa, fa = 0.0, guard_value(at, g, 0.0)
    for i in range(SPANS):
        if xa >= until:
            break
        xb = (i + 1.0) / SPANS
        fb = guard_value(at, g, xb)
        if fb > 0.0:
            return crossing_between(at, event, (xa, fa), (xb, fb))
        xa, fa = xb, fb
    return 2.0


@kernel
def first_event(at, h, stop):
    """Return (share of the step, kind, contact) of the first event in it; needs the dense output in `work.f`."""
    work, guards = at[0], at[0].guards
    best, kind, contact = 2.0, NOTHING, 0  # what is behind the best so far is not looked for
    if work.end[work.independent] >= stop:
        best, kind = crossing(at, (STOP, 0, stop), 0.0, 1.0), STOP
    pass_guards(at)
    for j in range(work.mode.size):
        x, what = 2.0, NOTHING
        if meets(work.mode[j]):
            x, what = first_onset(at, j, h, min(best, 1.0)), ONSET
        elif touches(work.mode[j]):
            x, what = first_separation(at, j, min(best, 1.0)), SEPARATION
        if x < best:
            best, kind, contact = x, what, j
        for g in range(guards.contact.size):
            if guards.passed[g] and guards.contact[g] == j:
                x = first_passage(at, g, min(best, 1.0))
                if x < best:
                    best, kind, contact = x, GUARD + g, j
    return best, kind, contact
