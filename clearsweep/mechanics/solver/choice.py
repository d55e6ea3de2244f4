"""Choice of the method of the next step: the one with the lower cost for the same time.

An explicit step costs a few sweeps, however many numbers the state has.  An implicit step costs evaluations and
matrices that grow with the number of unknowns.  Its price in evaluations was measured on the cases of `verify.stiff`,
with 6, 11 and 16 numbers in the state.

If the motion is stiff, an explicit step is short although the motion hardly bends within it.  The rate at which
small errors change follows from the contraction of the iteration.  The bend of the motion follows from states as far
apart as those within an implicit step.  Contraction alone is not sufficient: a motion that is not stiff contracts as
slowly now and then.

Counts of evaluations decide, never a clock, and only evaluations of the motion count, not those of extra outputs.
"""

from ..compiled.family import kernel
from ..observe.stages import STAGES
from . import radau
from .integration import AUTO, EXPLICIT, IMPLICIT
from .radau import ERROR, ORDER

PRICE_PER_NUMBER = 0.62  # of an evaluation in an implicit step, for each number in the state, mostly for the matrices
#: Over an implicit step worth its price: the stretch over which the bend is measured, and the first such step.
TRIAL_STRETCH = 2.0
SMALL_ERROR = 0.5  # error over the allowed one, expected of an implicit step worth its price where it is tried
SWEEPS = 6.0  # in a typical step of the explicit method; their cost is the unit of cost
PER_STEP = 12.0  # sequential evaluations that take as long as such a step
PAUSE_FACTOR = 2.0  # pause after a measurement without result, over its stretch; it costs a lane a few per cent
MAX_LOSS = 4.0  # implicit steps whose price the implicit method may lose before it is left,
SAVINGS_SHARE = 0.1  # plus this share of its earlier savings
RECOVERY_SHARE = 0.1  # of explicit evaluations: number that must offset the loss before the bend is measured again
STEADY = 1.2  # growth of the step that is forgone because the factors of the matrices can be reused
STEP_COST = SWEEPS * STAGES
OBSERVATIONS = radau.STAGES - 1  # evaluations of an implicit step for its observables, which need no matrices


@kernel
def reused_length(pointer, h, proposal):
    """Return the length of the step after one of length `h`: the proposal, or `h` again if that saves work."""
    return h if pointer[0].method.current == IMPLICIT and h <= proposal <= STEADY * h else proposal


@kernel
def choose_method(pointer, h, pattern):
    """Change the method if the latest step, of length `h`, shows that the other method is cheaper.

    pattern : result of `step_control.proposal_of`.  The change takes effect with the next step.
    """
    work, choice = pointer[0], pointer[0].implicit.choice
    if work.method.current == EXPLICIT:
        choice.left -= 1.0
        if work.step.stiff == 0.0:
            work.method.in_favour = 0
            return
    if work.control.method != AUTO:
        return
    cost, implicit = work.counts.evaluations - work.stepper.evaluations, 1 << work.mode.size
    if work.method.current == IMPLICIT:
        explicit = max(work.proposals[pattern & ~implicit], choice.limit)  # the last one with the same contacts
        if has_lost(pointer, PER_STEP * h / explicit, cost - OBSERVATIONS):
            work.method.next = EXPLICIT
    elif choice.left <= 0.0 and is_stiff(pointer, h, cost):
        work.method.next = IMPLICIT
        work.proposals[pattern] = choice.limit
        work.proposals[pattern | implicit] = TRIAL_STRETCH * price_of_step(work.y.size) * choice.limit
        work.paces[pattern | implicit] = work.paces[pattern]


@kernel
def price_of_step(n):
    """Return the cost of an implicit step in explicit steps: two iterations, and Jacobians now and then."""
    return PRICE_PER_NUMBER * n * (5.0 + 4.0 * n) / PER_STEP


@kernel
def is_stiff(pointer, h, cost):
    """Return whether an implicit step would be long enough, compared with one of length `h`, to be worth its price.

    It is called after TRIAL_STRETCH times as many explicit steps in a row, each perhaps limited by a stiff component.
    """
    work = pointer[0]
    n, choice = work.y.size, work.implicit.choice
    if h == 0.0:  # two events at one time: the observed states belong to both sides
        choice.cost += cost
        return False
    if work.method.in_favour == 0:
        choice.span, choice.cost = 0.0, 0.0
        store_mark(pointer, 0, work.y)
    choice.span += h
    choice.cost += cost
    work.method.in_favour += 1
    evaluations_used = int(TRIAL_STRETCH * price_of_step(n) / ORDER) + 1
    if work.method.in_favour % evaluations_used != 0:
        return False
    store_mark(pointer, work.method.in_favour // evaluations_used, work.end)
    if work.method.in_favour == (ORDER - 1) * evaluations_used:
        choice.early = choice.cost
    if work.method.in_favour < ORDER * evaluations_used:
        return False
    work.method.in_favour = 0
    if is_error_small(pointer):
        return True
    choice.left = PAUSE_FACTOR * choice.cost / PER_STEP
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

    The length of these explicit steps is that of the last ones or, if they jitter at the limit of stability, the mean.
    """
    n, choice, spans = pointer[0].y.size, pointer[0].implicit.choice, pointer[0].implicit.spans
    late_span = (choice.span - spans[ORDER - 1]) / (choice.cost - choice.early)
    choice.limit, choice.saved, choice.lost = STEP_COST * max(choice.span / choice.cost, late_span), 0.0, 0.0
    return ERROR**2 * squared_sixth_derivative(pointer, price_of_step(n) * choice.limit) <= SMALL_ERROR**2


@kernel
def squared_sixth_derivative(pointer, h):
    """Return the mean square, over the allowed error, of the sixth derivative of the state times h^6.

    The derivative is that of the polynomial through the marks.
    """
    n, spans, marks = pointer[0].y.size, pointer[0].implicit.spans, pointer[0].implicit.marks
    defect = pointer[0].implicit.offset
    for i in range(n):
        defect[i] = 0.0
    for m in range(1, ORDER + 1):
        weight = 720.0  # 6!
        for node in range(ORDER + 1):
            if node != m:
                weight *= h / (spans[m] - spans[node])
        for i in range(n):
            defect[i] += weight * (marks[m, i] - marks[0, i])
    total = 0.0
    for i in range(n):
        total += (defect[i] * pointer[0].weight[i]) ** 2
    return total / n


@kernel
def has_lost(pointer, saved, cost):
    """Return whether the implicit method has lost too much; a step saved `saved` explicit evaluations at a cost of
    `cost`.

    The permitted loss grows with the savings: if explicit steps are a hundred times shorter, doing without the
    implicit
    method until the next trial costs more than a stretch on which it is expensive.
    """
    work = pointer[0]
    n, choice = work.y.size, work.implicit.choice
    gain = saved - PRICE_PER_NUMBER * n * cost
    choice.saved += gain
    choice.lost = max(choice.lost - gain, 0.0)
    if choice.lost < MAX_LOSS * PER_STEP * price_of_step(n) + SAVINGS_SHARE * max(choice.saved, 0.0):
        return False
    choice.left = -min(choice.saved, 0.0) / (RECOVERY_SHARE * PER_STEP)
    return True
