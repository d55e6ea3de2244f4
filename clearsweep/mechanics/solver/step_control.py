"""Acceptance of a step, and the length of the next one: after an accepted step, after a rejected one, at the start.

The error of a smooth motion varies as the twelfth power of the length: its size as the eighth power, the square of its
decay as the fourth, see `collocation.error_norm`.
"""

import math

from ...tracing.compiled.choosing import rough_cube_root
from ...tracing.compiled.family import inlined, kernel
from ..laws.contract import meets, touches
from ..observe import STAGES
from . import radau
from .integration import AUTO, EXPLICIT, IMPLICIT, MAX_TRAVEL
from .radau import ERROR_CONSTANT, FAILED, ORDER

# ----------------------------------------------------------------------------------------------------------------------
# Choice of the method of the next step: the one with the lower cost for the same time.
#
# An explicit step costs a few sweeps, however many numbers the state has.  An implicit step costs evaluations and
# matrices that grow with the number of unknowns.  Its price in evaluations was measured on the cases of `verify.stiff`,
# with 6, 11 and 16 numbers in the state; with films on those of `configs/pump.yaml`.
#
# If the motion is stiff, an explicit step is short although the motion hardly curves within it.  The rate at which
# small errors change follows from the contraction of the iteration.  The curvature of the motion follows from states as
# far apart as those within an implicit step.  Contraction alone is not sufficient: a motion that is not stiff may
# contract as slowly.
#
# Counts of evaluations decide, never a clock, and only evaluations of the motion count, not those of extra outputs.


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


# ----------------------------------------------------------------------------------------------------------------------


# of the step size; the error estimate is erratic: up to 9 % of steps are rejected
SAFETY = 0.8
MIN_SHRINK = 0.2
MAX_GROWTH = 1.5
MAX_REJECTIONS = 60  # rejections in a row, after which a shorter step would not help
#: Rejections in a row from which the length is far off, such as that of the first step next to a slow shaft: its error
#: says nothing about the right length.
FAR_OFF = 40.0
# Growth of the second step after an event: at the onset of a contact the motion bends less than later
GROWTH_AFTER_EVENT = 0.8
# Of the length last right on a piece of a law: fewer first steps fail, at as many evaluations and with less error
FIRST_SHARE = 0.8
MIN_ERROR = 1e-10  # over the allowed one: a smaller error does not predict how much longer a step may be
BEST_CONTRACTION = 0.22  # contraction at which a step is cheapest per length; it varies as the square of the length
#: Sweeps up to which a step is cheap regardless of its contraction, and the largest contraction that allows.
CHEAP_SWEEPS, MAX_CONTRACTION = 4.0, 0.35
STIFF_CONTRACTION = 0.03  # contraction from which a stiff component may limit the step

#: Bits of an index of lengths at most, and those of the piece among them.
MAX_PATTERN_BITS, PIECE_BITS = 12, 3
HASH_FACTOR, HASH_BITS, HASH_SHIFT = 2654435769, 2**32 - 1, 20  # 2^32 over the golden ratio (Knuth 1998, vol. 3, 6.4)

# What the next step follows, see `set_next_length`
BEGINNING, REJECTION, ACCEPTANCE = range(3)


@inlined
def twelfth_power(x):
    """Return the twelfth power, in a fraction of the time of `pow`."""
    fourth = (x * x) * (x * x)
    return fourth * fourth * fourth


@inlined
def twelfth_root(error):
    """Return the twelfth root within 2 %, in a fraction of the time of `pow`."""
    return math.sqrt(math.sqrt(rough_cube_root(error)))


@kernel
def shrink_factor(error):
    """Return the factor on the length of a step whose `error`, over the allowed one, was too large."""
    return max(MIN_SHRINK, SAFETY / twelfth_root(error)) if error < 1e300 else MIN_SHRINK


@inlined
def growth_factor(error, expected):
    """Return the factor on the length of the next step, from this step's error and its expected error.

    The larger of the two counts, as the estimate crosses zero now and then.
    """
    larger = max(error, expected)
    return SAFETY / twelfth_root(max(larger, MIN_ERROR))


@kernel
def first_length(pointer, pattern):
    """Return the length of a first step: the previous one on these pieces, or with these contacts, else a guess.

    A contact lasts longer along tau the slower it begins: about as one over the root of that rate.
    """
    work, usual = pointer[0], contact_set(pointer)
    is_of_piece = work.proposals[pattern] > 0.0 and work.proposals[pattern] != work.proposals[usual]
    known, share = (pattern, FIRST_SHARE) if is_of_piece else (usual, 1.0)
    if work.proposals[known] > 0.0:
        return share * work.proposals[known] * math.sqrt(work.onset_rates[known] / onset_rate_of(pointer))
    length = 0.01 / work.reference_rate
    for j in range(work.mode.size):
        if touches(work.mode[j]):  # until the penetration is a hundredth of the clearance
            length = min(length, 0.2 * work.sigma * math.sqrt(work.clearance[j]) / work.latched[j])
    return length


@kernel
def contact_set(pointer):
    """Return the index in `Work.proposals` of the touching contacts, whatever the pieces of their laws.

    Of many contacts the index is a hash: now and then, sets of contacts share a first length.
    """
    work, pattern = pointer[0], 0
    size = work.proposals.size >> 1  # of a method
    for j in range(work.mode.size):
        if touches(work.mode[j]):
            pattern += 1 << j if j < MAX_PATTERN_BITS else (j * j * j * HASH_FACTOR & HASH_BITS) >> HASH_SHIFT
    return work.method.current * size + (pattern & (size - 1))


@kernel
def contact_pattern(pointer):
    """Return the index in `Work.proposals` of the touching contacts and the pieces of their laws.

    The piece of a law, or its direction of sliding, is a small whole number that it latches; of latched onset rates the
    nearest whole number counts.
    """
    work, piece = pointer[0], 0
    for i in range(work.mode.size, work.latched.size):
        if abs(work.latched[i]) < 1 << PIECE_BITS:
            piece = 3 * piece + int(work.latched[i] + 1.5)
    return contact_set(pointer) ^ piece % (1 << PIECE_BITS) * (work.proposals.size >> 1 + PIECE_BITS)


@kernel
def remember_length(pointer, pattern):
    """Keep the length that the latest step proposes for the next one, for its `contact_pattern` and its contacts."""
    work, onset_rate = pointer[0], onset_rate_of(pointer)
    for known in (pattern, contact_set(pointer)):
        work.proposals[known], work.onset_rates[known] = work.step.proposal, onset_rate


@kernel
def onset_rate_of(pointer):
    """Return the onset rate, m/s, of the fastest touching contact; 1 without contact."""
    work, fastest = pointer[0], 0.0
    for j in range(work.mode.size):
        if touches(work.mode[j]):
            fastest = max(fastest, work.latched[j])
    return fastest if fastest > 0.0 else 1.0


@inlined
def assess_step(work):
    """Set the error of the trial step and, if it is accurate, the length that it proposes for the next step."""
    step, stepper = work.step, work.stepper
    h, error = step.length, max(step.error, twelfth_power(travel_ratio(work)))  # the twelfth root is taken
    step.error, step.accepted, step.stiff = error, 0.0, 0.0
    if not error < 1.0:
        return
    length_ratio = min(stepper.growth, growth_factor(error, stepper.expected_error))
    stepper.expected_error = error * twelfth_power(length_ratio)
    if work.method.current != IMPLICIT and (step.contraction > STIFF_CONTRACTION or step.preconditioned != 0.0):
        best_contraction = BEST_CONTRACTION if step.sweeps > CHEAP_SWEEPS else MAX_CONTRACTION
        contraction = max(step.contraction, STIFF_CONTRACTION)
        step.stiff, length_ratio = 1.0, min(length_ratio, math.sqrt(best_contraction / contraction))
    step.proposal, stepper.rejections = h * length_ratio, 0.0


@inlined
def travel_ratio(work):
    """Return the travel of journals in free flight over the step, divided by the allowed travel."""
    step, mode = work.step, work.mode
    farthest = 0.0
    for j in range(mode.size):
        if meets(mode[j]):
            ratio = step.length * work.contact_steps[j].fastest / (MAX_TRAVEL * work.clearance[j])
            farthest = max(farthest, ratio)
    return farthest


@kernel
def set_next_length(pointer, cause):
    """Set the length of the next step; no other function does.

    cause : the step is the first with these equations (BEGINNING), or follows a step by its REJECTION or ACCEPTANCE.
    """
    work, stepper = pointer[0], pointer[0].stepper
    if cause == BEGINNING:  # the error is unknown
        length = first_length(pointer, contact_pattern(pointer))
        stepper.growth = GROWTH_AFTER_EVENT
        stepper.expected_error = 0.0
    elif cause == REJECTION:
        factor = shrink_factor(work.step.error) if stepper.rejections < FAR_OFF else MIN_SHRINK
        if work.step.error == FAILED and work.method.current == EXPLICIT and stepper.rejections > 1.0:
            factor = factor * factor if stepper.rejections == 2.0 else MIN_SHRINK
        length, stepper.growth = work.step.length * factor, 1.0
    else:
        length, stepper.growth = length_after_acceptance(pointer), MAX_GROWTH
    stepper.next_length = length


@kernel
def length_after_acceptance(pointer):
    """Apply a decided change of method; return the length of the step after an accepted one."""
    work, h, proposal = pointer[0], pointer[0].step.length, pointer[0].step.proposal
    if work.method.next == work.method.current:
        is_reused = work.method.current == IMPLICIT and h <= proposal <= REUSE_GROWTH * h  # the matrices, too
        return h if is_reused else proposal
    work.method.current = work.method.next
    work.implicit.history.length = 0.0
    length = work.proposals[contact_pattern(pointer)]
    return length if length > 0.0 else work.implicit.choice.explicit_length  # these contacts never touched explicitly
