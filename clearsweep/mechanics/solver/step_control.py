"""Step length after an accepted step, after a rejected one, and at the start.

The error of a smooth motion varies as the twelfth power of the length: its size as the eighth power, the square of its
decay as the fourth, see `collocation.error_norm`.
"""

import math

from ..compiled.choosing import bits_of, number_of
from ..compiled.family import inlined, kernel
from ..joint.contract import touches
from .choice import steady

SAFETY, SHRINK, GROW = 0.8, 0.2, 1.5  # of the step size; the error estimate is erratic: up to 9 % of steps are rejected
MOST_TRIES = 60  # rejections in a row: each shortens the step by at least a fifth, so a shorter step would not help
THIRD_ROOT_BITS = 2 * (1023 << 52) // 3 - (200 << 40)  # of 1; minus half the error of the root
LEAST_ERROR = 1e-10  # over the allowed one: a smaller error does not predict how much longer a step may be


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
def shrinking(error):
    """Return the factor on the length of a step whose `error`, over the allowed one, was too large."""
    return max(SHRINK, SAFETY / twelfth_root(error)) if error < 1e300 else SHRINK


@inlined
def change_of_length(error, expected):
    """Return the factor on the length of the next step, from this step's error and its expected error.

    The larger of the two counts, as the estimate crosses zero now and then.
    """
    larger = max(error, expected)
    return SAFETY / twelfth_root(max(larger, LEAST_ERROR))


@kernel
def first_length(at, proposals, pattern):
    """Return the length of a first step: the last one with the same touching contacts, else a guess.

    A contact lasts longer along tau the slower it begins: about as one over the root of that rate.
    """
    work = at[0]
    if proposals[pattern] > 0.0:
        return proposals[pattern] * math.sqrt(work.paces[pattern] / pace_of(at))
    length = 0.01 / work.reference_rate
    for j in range(work.mode.size):
        if touches(work.mode[j]):  # until the penetration is a hundredth of the clearance
            length = min(length, 0.2 * work.sigma * math.sqrt(work.clearance[j]) / work.latched[j])
    return length


@kernel
def proposal_of(at):
    """Return the place of the step length for this method and these touching contacts: the bits of a number."""
    work = at[0]
    pattern = work.method.current << work.mode.size
    for j in range(work.mode.size):
        if touches(work.mode[j]):
            pattern |= 1 << j
    return pattern


@kernel
def pace_of(at):
    """Return the onset rate, m/s, of the fastest touching contact; 1 without contact."""
    work, fastest = at[0], 0.0
    for j in range(work.mode.size):
        if touches(work.mode[j]):
            fastest = max(fastest, work.latched[j])
    return fastest if fastest > 0.0 else 1.0


@kernel
def next_length(at, h, proposal):
    """Apply a decided change of method; return the length of the step after one of length `h`."""
    work = at[0]
    if work.method.next == work.method.current:
        return steady(at, h, proposal)
    work.method.current = work.method.next
    work.implicit.past.length = 0.0
    length = work.proposals[proposal_of(at)]
    return length if length > 0.0 else work.implicit.choice.limit  # these contacts never touched explicitly
