"""The arrays of an integration, the kinds of its events, and the evaluation of its right-hand side."""

from typing import NamedTuple

import numpy as np

from ..compiled.family import Entry, inlined, invoke, kernel
from ..observe.stages import SCRATCH
from .accumulate.step_sums import TrialStep
from .accumulate.totals import Accumulators
from .collocation import dense_state

# Kinds of events; LIMIT: a penetration passes the limit of its elastic law, which changes nothing; GUARD and
# beyond: the guards of joints
NOTHING, ONSET, SEPARATION, STOP, LIMIT, GUARD = range(6)
FARTHEST = 8.0  # clearances that a journal in free flight may travel in a step
EXPLICIT, IMPLICIT = 0, 1  # methods
# Counters in Work.counts; LOCATING: evaluations spent on finding events and stepping to them; PASSAGES: of guards and
# limits, which are no EVENTS of contacts
STEPS, REJECTED, EVALUATIONS, LOCATING, EVENTS, SEPARATIONS, PASSAGES, SAMPLES, COUNTS = range(9)


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
    stepper: np.ndarray  # (STEPPER_SIZE,) state of the loop between steps, see run_control
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
