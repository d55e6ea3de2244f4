"""Acceptance of a step, and the length of the next one: after an accepted step, after a rejected one, at the start.

The error of a smooth motion varies as the twelfth power of the length: its size as the eighth power, the square of its
decay as the fourth, see `collocation.error_norm`.
"""

import math

from ...tracing.compiled.choosing import bits_of, number_of
from ...tracing.compiled.family import inlined, kernel
from ..laws.contract import meets, touches
from .choice import reused_length
from .integration import IMPLICIT, MAX_TRAVEL

SAFETY, MIN_SHRINK, MAX_GROWTH = (
    0.8,
    0.2,
    1.5,
)  # of the step size; the error estimate is erratic: up to 9 % of steps are rejected
MAX_REJECTIONS = 60  # rejections in a row, after which a shorter step would not help
#: Rejections in a row from which the length is far off, such as that of the first step next to a slow shaft: its error
#: says nothing about the right length.
FAR_OFF = 40.0
THIRD_ROOT_BITS = 2 * (1023 << 52) // 3 - (200 << 40)  # of 1; minus half the error of the root
# Growth of the second step after an event: at the onset of a contact the motion bends less than later
GROWTH_AFTER_EVENT = 0.8
MIN_ERROR = 1e-10  # over the allowed one: a smaller error does not predict how much longer a step may be
BEST_CONTRACTION = 0.22  # contraction at which a step is cheapest per length; it varies as the square of the length
#: Sweeps up to which a step is cheap regardless of its contraction, and the largest contraction that allows.
CHEAP_SWEEPS, MAX_CONTRACTION = 4.0, 0.35
STIFF_CONTRACTION = 0.03  # contraction from which a stiff component may limit the step

MAX_CONTACT_BITS = 12  # contacts whose sets have lengths of their own
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
    third = number_of(bits_of(error) // 3 + THIRD_ROOT_BITS)
    return math.sqrt(math.sqrt(third))


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
    """Return the length of a first step: the previous one with the same touching contacts, else a guess.

    A contact lasts longer along tau the slower it begins: about as one over the root of that rate.
    """
    work = pointer[0]
    if work.proposals[pattern] > 0.0:
        return work.proposals[pattern] * math.sqrt(work.onset_rates[pattern] / onset_rate_of(pointer))
    length = 0.01 / work.reference_rate
    for j in range(work.mode.size):
        if touches(work.mode[j]):  # until the penetration is a hundredth of the clearance
            length = min(length, 0.2 * work.sigma * math.sqrt(work.clearance[j]) / work.latched[j])
    return length


@kernel
def contact_pattern(pointer):
    """Return the index in `Work.proposals`: its bits are the touching contacts, then the method.

    Of more contacts than MAX_CONTACT_BITS the index is a hash: now and then, sets of contacts share a first length.
    """
    work, pattern = pointer[0], 0
    size = work.proposals.size >> 1  # of a method
    for j in range(work.mode.size):
        if touches(work.mode[j]):
            pattern += 1 << j if j < MAX_CONTACT_BITS else (j * j * j * HASH_FACTOR & HASH_BITS) >> HASH_SHIFT
    return work.method.current * size + (pattern & (size - 1))


@kernel
def onset_rate_of(pointer):
    """Return the onset rate, m/s, of the fastest touching contact; 1 without contact."""
    work, fastest = pointer[0], 0.0
    for j in range(work.mode.size):
        if touches(work.mode[j]):
            fastest = max(fastest, work.latched[j])
    return fastest if fastest > 0.0 else 1.0


@inlined
def assess_step(accumulators, method):
    """Set the error of the trial step and, if it is accurate, the length that it proposes for the next step."""
    step, stepper = accumulators.step, accumulators.stepper
    h, error = step.length, max(step.error, twelfth_power(travel_ratio(accumulators)))  # the twelfth root is taken
    step.error, step.accepted, step.stiff = error, 0.0, 0.0
    if not error < 1.0:
        return
    length_ratio = min(stepper.growth, growth_factor(error, stepper.expected_error))
    stepper.expected_error = error * twelfth_power(length_ratio)
    if method != IMPLICIT and (step.contraction > STIFF_CONTRACTION or step.preconditioned != 0.0):
        best_contraction = BEST_CONTRACTION if step.sweeps > CHEAP_SWEEPS else MAX_CONTRACTION
        contraction = max(step.contraction, STIFF_CONTRACTION)
        step.stiff, length_ratio = 1.0, min(length_ratio, math.sqrt(best_contraction / contraction))
    step.proposal, stepper.rejections = h * length_ratio, 0.0


@inlined
def travel_ratio(accumulators):
    """Return the travel of journals in free flight over the step, divided by the allowed travel."""
    step, mode = accumulators.step, accumulators.mode
    farthest = 0.0
    for j in range(mode.size):
        if meets(mode[j]):
            ratio = step.length * accumulators.contact_steps[j].fastest / (MAX_TRAVEL * accumulators.clearance[j])
            farthest = max(farthest, ratio)
    return farthest


@kernel
def set_next_length(pointer, cause):
    """Set the length of the next step; no other function does.

    cause : the step is the first with these equations (BEGINNING), or follows a step by its REJECTION or ACCEPTANCE.
    """
    work, stepper = pointer[0], pointer[0].stepper
    if cause == BEGINNING:  # the error is unknown
        length, stepper.growth, stepper.expected_error = (
            first_length(pointer, contact_pattern(pointer)),
            GROWTH_AFTER_EVENT,
            0.0,
        )
    elif cause == REJECTION:
        factor = shrink_factor(work.step.error) if stepper.rejections < FAR_OFF else MIN_SHRINK
        length, stepper.growth = work.step.length * factor, 1.0
    else:
        length, stepper.growth = length_after_acceptance(pointer), MAX_GROWTH
    stepper.next_length = length


@kernel
def length_after_acceptance(pointer):
    """Apply a decided change of method; return the length of the step after an accepted one."""
    work = pointer[0]
    if work.method.next == work.method.current:
        return reused_length(pointer, work.step.length, work.step.proposal)
    work.method.current = work.method.next
    work.implicit.history.length = 0.0
    length = work.proposals[contact_pattern(pointer)]
    return length if length > 0.0 else work.implicit.choice.explicit_length  # these contacts never touched explicitly
