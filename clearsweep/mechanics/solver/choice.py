"""Choice of the method of the next step: the one with the lower cost for the same time.

An explicit step costs a few sweeps, however many numbers the state has.  An implicit step costs evaluations and
matrices that grow with the number of unknowns.  Its price in evaluations was measured on the cases of `verify.stiff`,
with 6, 11 and 16 numbers in the state; with films on those of `configs/pump.yaml`.

If the motion is stiff, an explicit step is short although the motion hardly curves within it.  The rate at which
small errors change follows from the contraction of the iteration.  The curvature of the motion follows from states as
far apart as those within an implicit step.  Contraction alone is not sufficient: a motion that is not stiff may
contract as slowly.

Counts of evaluations decide, never a clock, and only evaluations of the motion count, not those of extra outputs.
"""

import math

from ...tracing.compiled.family import kernel
from ..observe import STAGES
from . import radau
from .integration import AUTO, EXPLICIT, IMPLICIT
from .radau import ERROR_CONSTANT, ORDER

#: Of an evaluation in an implicit step, for each number in the state, mostly for the matrices.  The evaluation of a
#: film takes longer, so the share of the matrices is smaller.
PRICE_PER_NUMBER, PRICE_WITH_FILM = 0.62, 0.15
#: Length over which the curvature of the motion is measured, divided by an implicit step that is worth its price.
TRIAL_LENGTH = 2.0
SMALL_ERROR = 0.5  # error over the allowed one, expected of an implicit step worth its price where it is tried
TYPICAL_SWEEPS = 6.0  # in a typical step of the explicit method; their cost is the unit of cost
EVALUATIONS_PER_STEP = 12.0  # sequential evaluations that take as long as a typical explicit step
PAUSE_FACTOR = 2.0  # pause after a failed measurement, divided by its length
MAX_LOSS = 4.0  # loss in prices of implicit steps from which the implicit method is given up,
SAVINGS_FRACTION = 0.1  # plus this fraction of its earlier savings
RECOVERY_FRACTION = 0.1  # of explicit evaluations: number that must offset the loss before the bend is measured again
REUSE_GROWTH = 1.2  # growth of the step that is forgone because the factors of the matrices can be reused
STEP_COST = TYPICAL_SWEEPS * STAGES
OBSERVATION_EVALUATIONS = (
    radau.STAGES - 1
)  # evaluations of an implicit step for its observables, which need no matrices


@kernel
def reused_length(pointer, h, proposal):
    """Return the length of the step after one of length `h`: the proposal, or `h` again if that saves work."""
    return h if pointer[0].method.current == IMPLICIT and h <= proposal <= REUSE_GROWTH * h else proposal


@kernel
def choose_method(pointer, h, pattern):
    """Change the method if the latest step, of length `h`, shows that the other method is cheaper.

    pattern : result of `step_control.contact_pattern`.  The change takes effect with the next step.
    """
    work, choice = pointer[0], pointer[0].implicit.choice
    if work.method.current == EXPLICIT:
        choice.steps_to_trial -= 1.0
        if work.step.stiff == 0.0:
            work.method.favouring_steps = 0
            return
    if work.control.method != AUTO:
        return
    cost, implicit_bit = work.counts.evaluations - work.stepper.evaluations, work.proposals.size >> 1
    if work.method.current == IMPLICIT:
        explicit_length = max(
            work.proposals[pattern & ~implicit_bit], choice.explicit_length
        )  # the last one with the same contacts
        if is_unprofitable(pointer, EVALUATIONS_PER_STEP * h / explicit_length, cost - OBSERVATION_EVALUATIONS):
            work.method.next = EXPLICIT
    elif choice.steps_to_trial <= 0.0 and is_stiff(pointer, h, cost):
        work.method.next = IMPLICIT
        work.proposals[pattern] = choice.explicit_length
        work.proposals[pattern | implicit_bit] = TRIAL_LENGTH * price_of_step(pointer) * choice.explicit_length
        work.onset_rates[pattern | implicit_bit] = work.onset_rates[pattern]


@kernel
def price_of_evaluation(pointer):
    """Return the cost of an evaluation in an implicit step, in evaluations of an explicit step."""
    work, has_film = pointer[0], False
    for j in range(work.mode.size):
        has_film = has_film or work.film[j, 1] < math.inf
    return (PRICE_WITH_FILM if has_film else PRICE_PER_NUMBER) * work.y.size


@kernel
def price_of_step(pointer):
    """Return the cost of an implicit step in explicit steps: two iterations, occasional Jacobians."""
    return price_of_evaluation(pointer) * (5.0 + 4.0 * pointer[0].y.size) / EVALUATIONS_PER_STEP


@kernel
def is_stiff(pointer, h, cost):
    """Return whether an implicit step would be worth its price, compared with explicit steps of length `h`.

    It is called after TRIAL_LENGTH times as many explicit steps in a row, each perhaps limited by a stiff component.
    """
    work = pointer[0]
    choice = work.implicit.choice
    if h == 0.0:  # two events at one time: the observed states belong to both sides
        choice.cost += cost
        return False
    if work.method.favouring_steps == 0:
        choice.span, choice.cost = 0.0, 0.0
        store_mark(pointer, 0, work.y)
    choice.span += h
    choice.cost += cost
    work.method.favouring_steps += 1
    steps_per_mark = int(TRIAL_LENGTH * price_of_step(pointer) / ORDER) + 1
    if work.method.favouring_steps % steps_per_mark != 0:
        return False
    store_mark(pointer, work.method.favouring_steps // steps_per_mark, work.end)
    if work.method.favouring_steps == (ORDER - 1) * steps_per_mark:
        choice.early_cost = choice.cost
    if work.method.favouring_steps < ORDER * steps_per_mark:
        return False
    work.method.favouring_steps = 0
    if is_error_small(pointer):
        return True
    choice.steps_to_trial = PAUSE_FACTOR * choice.cost / EVALUATIONS_PER_STEP
    return False


@kernel
def store_mark(pointer, index, y):
    """Store the state `y` and the length of the steps so far."""
    choice, marks = pointer[0].implicit.choice, pointer[0].implicit.marks
    pointer[0].implicit.spans[index] = choice.span
    for i in range(y.size):
        marks[index, i] = y[i]


@kernel
def is_error_small(pointer):
    """Return whether an implicit step worth its price in explicit steps has an error of at most SMALL_ERROR.

    The length of these explicit steps is the larger of the mean and that of the latest ones.
    """
    choice, spans = pointer[0].implicit.choice, pointer[0].implicit.spans
    late_span = (choice.span - spans[ORDER - 1]) / (choice.cost - choice.early_cost)
    choice.explicit_length, choice.saved, choice.lost = STEP_COST * max(choice.span / choice.cost, late_span), 0.0, 0.0
    return (
        ERROR_CONSTANT**2 * squared_sixth_derivative(pointer, price_of_step(pointer) * choice.explicit_length)
        <= SMALL_ERROR**2
    )


@kernel
def squared_sixth_derivative(pointer, h):
    """Return the mean square of the sixth derivative of the state times h^6, divided by the allowed error.

    The derivative is that of the polynomial through the marks.
    """
    n, spans, marks = pointer[0].y.size, pointer[0].implicit.spans, pointer[0].implicit.marks
    derivative = pointer[0].implicit.offset
    for i in range(n):
        derivative[i] = 0.0
    for m in range(1, ORDER + 1):
        weight = 720.0  # 6!
        for node in range(ORDER + 1):
            if node != m:
                weight *= h / (spans[m] - spans[node])
        for i in range(n):
            derivative[i] += weight * (marks[m, i] - marks[0, i])
    total = 0.0
    for i in range(n):
        total += (derivative[i] * pointer[0].weight[i]) ** 2
    return total / n


@kernel
def is_unprofitable(pointer, saved, cost):
    """Return whether the implicit method has cost too much; the latest step replaced `saved` evaluations by `cost`.

    The permitted loss grows with the savings.  Where explicit steps are a hundred times shorter, a few expensive
    implicit steps cost less than explicit steps up to the next trial.
    """
    choice = pointer[0].implicit.choice
    gain = saved - price_of_evaluation(pointer) * cost
    choice.saved += gain
    choice.lost = max(choice.lost - gain, 0.0)
    permitted_loss = MAX_LOSS * EVALUATIONS_PER_STEP * price_of_step(pointer)
    if choice.lost < permitted_loss + SAVINGS_FRACTION * max(choice.saved, 0.0):
        return False
    choice.steps_to_trial = -min(choice.saved, 0.0) / (RECOVERY_FRACTION * EVALUATIONS_PER_STEP)
    return True
