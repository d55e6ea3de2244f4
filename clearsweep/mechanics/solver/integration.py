"""The arrays, settings, statuses and kinds of events of an integration, and the evaluation of its right-hand side."""

import math
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from ...tracing.compiled.family import Entry, invoke, kernel
from ...tracing.memory import Fields
from ..observe import PARTS, ROW_COUNT, SCRATCH, STAGES
from .collocation import COEFFICIENTS, ROWS, dense_state
from .totals import ContactStep, Step

# Kinds of events; LIMIT: a penetration passes the limit of its elastic law, without effect; GUARD and above: the guards
# of joints
NOTHING, ONSET, SEPARATION, STOP, LIMIT, GUARD = range(6)
MAX_TRAVEL = 8.0  # clearances: largest travel of a journal in free flight in a step
EXPLICIT, IMPLICIT, AUTO = range(3)  # methods; AUTO: chosen from step to step
# Status with which the loop returns; GOING: it has not ended
OK, STEP_BUDGET, EVENT_BUDGET, NOT_FINITE, STEP_UNDERFLOW, PAUSED, TURNS_STIFF, TIME_LIMIT, STALLED = range(9)
LEFT_BEARING, SUMS_NOT_FINITE, GOING = range(9, 12)


class Control(NamedTuple):
    """Settings of a run: its window, end, method and budgets."""

    window: float  # s, or rad of a free crank: start of the window in which figures are taken
    end: float  # s, or rad of a free crank: end of the run
    separations: int  # number of separations after which to stop; 0: no limit
    step_budget: int
    event_budget: int
    keep_events: bool
    method: int  # AUTO, or EXPLICIT or IMPLICIT throughout
    pause: float = math.inf  # s, or rad of a free crank: return PAUSED at the first step that ends here or later
    pause_steps: int = 1 << 16  # steps after which to return PAUSED, so that the caller can check the time used
    time_limit: float = math.inf  # s of motion of a free crank, after which to return TIME_LIMIT
    patience: float = math.inf  # s, within which a free crank has to advance; inf: the crank is not free
    early: float = 0.0  # s, by which a step ends before a stop, where the acceleration of the crank jumps


class ControlNumbers(Fields, like=Control):
    """The numbers of a Control, in memory."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> float: ...


class Stepper(Fields):
    """State of the loop between steps."""

    next_length: float  # length of the next step; 0 before the first
    growth: float  # largest ratio of the next length to the length of this step
    expected_error: float  # error that the next step is expected to have, over the tolerance
    rejections: float  # rejected steps in a row
    slow: float  # 1 if the plain iteration of the next step is expected to contract slowly, else 0
    evaluations: float  # evaluations before this step
    pause_step: float  # number of the step after which to return PAUSED
    in_window: float  # 1 where figures are taken, else 0
    logged: float  # events in the log
    begun: float  # 1 after `begin_case`, else 0
    next_stop: float  # where the next step has to end: s, or rad of a free crank
    farthest: float  # rad, largest angle of a free crank
    progress_angle: float  # rad, angle at which a free crank last advanced by STALL_ADVANCE
    progress_time: float  # s, when it was there
    status: float  # how the latest call of the loop ended
    contact: float  # contact of the latest event
    recorded: float  # steps whose signals are in `Work.recording`


class Counts(Fields):
    """Counts of the work of an integration so far."""

    steps: int  # accepted
    rejected: int
    evaluations: int  # of the right-hand side
    locating: int  # evaluations for locating events and stepping to them
    events: int  # of contacts
    separations: int
    passages: int  # of guards and limits, which do not count as events of contacts
    samples: int  # written


class Method(Fields):
    """The method of a step: EXPLICIT or IMPLICIT."""

    current: int
    favouring_steps: int  # consecutive steps that favour the other method
    next: int  # method of the next step


class Slopes(Fields):
    """The Entry of the rates' derivatives; zeros until the motion becomes stiff."""

    code: int
    parameters: int


class Choice(Fields):
    """Basis of the choice of the method: the cost of both methods on the latest stretches of the motion."""

    explicit_length: float  # length of an explicit step before the method became implicit
    saved: float  # explicit evaluations saved by the implicit method since then
    lost: float  # evaluations by which it cost more than the explicit method
    steps_to_trial: float  # explicit steps until the curvature of the motion is measured again
    span: float  # length of the steps that a stiff component may limit
    cost: float  # evaluations in these steps
    early_cost: float  # evaluations in all but the last of their ORDER parts


class StepHistory(Fields):
    """Data from earlier steps; lengths are 0 if there is no earlier step."""

    length: float  # of the step whose interpolant is in `Work.f`
    start_fraction: float  # fraction of that step at which this step begins: 1 after it, 0 at the same start
    jacobian_length: float  # length of a step from this start for which the Jacobians were evaluated
    matrix_length: float  # length of the step for which the matrices are factorised
    convergence: float  # of the last iteration


class Implicit(NamedTuple):
    """Workspace of the implicit method; n numbers in the state."""

    jacobian: np.ndarray  # (3, n, whole_registers(n)) derivatives of the rates at the stages JACOBIAN_STAGES
    newton: np.ndarray  # (STAGES n, STAGES n) columns of the factors of the matrix of the iteration
    pivots: np.ndarray  # (STAGES n,) int64
    error_matrix: np.ndarray  # (n, n) columns of the factors of the matrix of the error estimate
    error_pivots: np.ndarray  # (n,) int64
    stages: np.ndarray  # (STAGES n,) differences of the stages from the start of the step
    update: np.ndarray  # (STAGES n,)
    offset: np.ndarray  # (n,)
    marks: np.ndarray  # (ORDER + 1, n) states along explicit steps, see `choice`
    spans: np.ndarray  # (ORDER + 1,) length of the steps up to each mark
    choice: Choice
    history: StepHistory


class Preconditioner(NamedTuple):
    """Workspace of `preconditioner` for u unknowns, 0 if there are too many; each lane contains an eigenvalue."""

    increment: np.ndarray  # (u,) changes for the difference quotients
    base: np.ndarray  # (u,) rates without change
    linear: np.ndarray  # (u, u) step length times derivatives of the rates by the unknowns
    quadratic: np.ndarray  # (u, u) its square times derivatives through coordinates and roots
    factors_real: Annotated[np.ndarray, STAGES]  # (u, u) factors of the matrix of each eigenvalue
    factors_imaginary: Annotated[np.ndarray, STAGES]  # (u, u)
    real: Annotated[np.ndarray, STAGES]  # (u,) components of the changes along the eigenvectors
    imaginary: Annotated[np.ndarray, STAGES]  # (u,)
    before: Annotated[np.ndarray, STAGES]  # (u,) unknowns before a sweep
    product_real: Annotated[np.ndarray, STAGES]  # (STAGES,) components of a row of the derivatives times the changes
    product_imaginary: Annotated[np.ndarray, STAGES]  # (STAGES,)


class Work(NamedTuple):
    """The arrays and constants of an integration: n numbers in the state, m of them of laws, l latched; c contacts.

    Functions get it as a `pointer`: passing its arrays by value would cost more than the functions themselves.  An
    annotation has the last lengths of an array, which are the same in all runs, its comment those before them.
    """

    rates: Entry  # the right-hand side
    sweep: Entry  # a sweep of the iteration of a step, see `collocation`
    observe_stages: Entry  # the observables of all stages
    sample: Entry  # the time histories
    wear: Entry  # the wear; NO_ENTRY without wear
    time: int  # index of the time in the state; the roots of penetration, then the internal states follow it
    independent: int  # index in the state of the independent quantity of the run: time, or the angle of a free crank
    crank: int  # index in the state of the angle of a free crank; -1: the motion of the crank is given
    knots: np.ndarray  # (k,) values of this quantity at which a step must end because an acceleration jumps
    reference_rate: float  # rad/s, Scene.reference_rate
    sigma: float  # m^0.5, Scene.sigma
    max_duration: float  # s, largest duration of a step

    y: np.ndarray  # (n,) state at the start of the step
    end: np.ndarray  # (n,) state at its end
    z: np.ndarray  # (n,) state of a stage or on the dense output
    k: Annotated[np.ndarray, ROW_COUNT]  # (n,) rates
    o: Annotated[np.ndarray, ROW_COUNT]  # (columns,) observables
    nodes: Annotated[np.ndarray, STAGES]  # (n + 1,) states at the stages; last row: change of each in the latest sweep
    weight: np.ndarray  # (n,) 1 / allowed error
    mode: np.ndarray  # (c,) int64, modes.FREE, PRESSED or another of the joint's modes
    latched: np.ndarray  # (c + l,) values set at events only: closing rate (m/s) of each onset, floored; of laws
    step: Step
    contact_steps: ContactStep  # (c,)
    profiles: Annotated[np.ndarray, PARTS + 1]  # (1 + c,) dt/dtau and every contact's force (N) at equidistant places
    clearance: np.ndarray  # (c,) m
    has_friction: np.ndarray  # (c,) int64, whether there is friction: 1, else 0
    has_histogram: np.ndarray  # (c,) int64, whether its force has a histogram: 1, else 0
    resultant: np.ndarray  # (c,) int64, contact that is the resultant of this and others; -1: none
    film: Annotated[np.ndarray, 2]  # (c,) m, depth beyond which a film takes load, and limit of its formula; inf: never
    stepper: Stepper
    f: Annotated[np.ndarray, STAGES]  # (n,) the interpolant, see `collocation.dense_component`
    polynomials: Annotated[np.ndarray, ROWS, COEFFICIENTS]  # of the current event function, see `collocation`
    apart: np.ndarray  # (c,) int64, mode after a separation
    pressed: np.ndarray  # (c,) int64, mode after an onset
    journal_sides: np.ndarray  # (c,) Joint.side: +1: the journal is on the distal body, -1: on the proximal one
    limit_depth: np.ndarray  # (c,) m, penetration up to which the elastic law is valid; inf: any
    reset_by: np.ndarray  # (m,) int64, contact whose separation resets this internal state; -1: never reset
    initial_internal: np.ndarray  # (m,) initial value of each internal state
    counts: Counts
    method: Method
    slopes: Slopes
    proposals: np.ndarray  # (2^(1+b),) step length by `step_control.contact_pattern`, 0: none; b: c + 3 bits at most
    onset_rates: np.ndarray  # (2^(1+b),) m/s, largest onset rate of these contacts
    control: ControlNumbers
    log: Annotated[np.ndarray, 5]  # (LOG_ROWS,) events since the latest pause, see step.Event
    guards: tuple  # coupling.entries.Guards
    implicit: Implicit
    preconditioner: Preconditioner
    totals: tuple  # totals.Totals
    record: tuple  # slow_sums.Record
    revolutions: tuple  # slow_sums.RevolutionMarks
    recording: np.ndarray  # (steps, slow_sums.SIGNALS + s, NODES) signals of steps in the window; no steps: none
    signals: int  # the first of the s columns with signals in `o`


@kernel
def evaluate(pointer, y, row):
    """Write the rates of the state `y` to row `row` of `work.k` and its observables to row `row` of `work.o`."""
    work = pointer[0]
    work.counts.evaluations += 1
    invoke(work.rates.code, work.rates.parameters, (y, work.mode, work.latched, work.k, work.o), row)


@kernel
def evaluate_dense(pointer, x):
    """Write the rates and observables at the fraction `x` of the step to the SCRATCH rows, from the dense output."""
    work = pointer[0]
    dense_state(x, work.y, work.f, work.z)
    evaluate(pointer, work.z, SCRATCH)
