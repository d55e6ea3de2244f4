"""Whether a step is good, whether it can hold an event, how long the next may be, and whether it follows unseen.

All of one case or of several.

Free flight is short enough to be searched: a journal may travel so far in a step, see `event.FARTHEST`.
"""

import numpy as np

from ..compiled.choosing import none_of, where
from ..compiled.family import inlined
from ..joint.contract import meets, touches
from ..observe.observables import DEPTH, KAPPA, NODES, RATE, SHARES, SLIP, column_of
from .accumulate.step_sums import (
    ACCEPTED,
    CONTINUES,
    ERROR,
    FASTEST,
    LENGTH,
    NEEDS_PEAK_SEARCH,
    ON_FAST_PATH,
    RISE,
    RUN,
    STIFF,
    sum_of,
)
from .choice import FAST
from .dop853 import END
from .event import FARTHEST, MARGIN
from .guarding import highest_seen, is_looked_at
from .run_control import (
    ALONE,
    DUE,
    EXPECTED,
    FAST_STEPS,
    GROWTH,
    LONGEST,
    MOST_FAST_STEPS,
    NEXT,
    STOP_AT,
    TRIES,
    UNASKED,
)
from .span import deepest_between
from .step_control import GROW, change_of_length, eighth_power

STRAY = 2.0  # on how far depths at the stages are above a cubic: bounds how far they are between them


@inlined
def assess_step(accumulators, guards, independent, time):
    """Note whether trial steps are accepted as they are, and of good ones how long the next may be.

    guards : Guards, of the one case or, but for their values, of all; `independent`, `time` : places in the state.
    Steps of cases that go ALONE are not accepted yet.
    """
    step, stepper = accumulators.step, accumulators.stepper
    h = step[LENGTH]
    error = max(step[ERROR], eighth_power(travel_ratio(accumulators)))  # the step control takes the eighth root
    good = (error < 1.0) & (stepper[ALONE] == 0.0)
    step[ERROR] = where(stepper[ALONE] == 0.0, error, step[ERROR])
    stiff = where(good & (h * h * step[RISE] > FAST * FAST * step[RUN]), 1.0, 0.0)
    step[STIFF] = where(stepper[ALONE] == 0.0, stiff, step[STIFF])  # a step to an event is as the longer one was
    step[ACCEPTED] = where(good & holds_no_event(accumulators, guards, independent, time), 1.0, 0.0)
    change = min(stepper[GROWTH], change_of_length(error, stepper[EXPECTED]))
    stepper[NEXT] = where(good, h * change, stepper[NEXT])
    stepper[EXPECTED] = where(good, error * eighth_power(change), stepper[EXPECTED])
    stepper[GROWTH], stepper[TRIES] = where(good, GROW, stepper[GROWTH]), where(good, 0.0, stepper[TRIES])


@inlined
def note_fast_path(accumulators, independent):
    """Note which of the steps that were entered are fast, and how long the next is after these.

    Of such a step nothing is wanted but its entry into the histogram, and nothing is due before the next.
    """
    step, stepper = accumulators.step, accumulators.stepper
    settled = (step[ACCEPTED] != 0.0) & (step[NEEDS_PEAK_SEARCH] == 0.0)
    settled = settled & ((step[STIFF] == 0.0) | (stepper[FAST_STEPS] < stepper[UNASKED]))
    fast = settled & (accumulators.end[independent] < stepper[DUE]) & (stepper[FAST_STEPS] < stepper[MOST_FAST_STEPS])
    step[ON_FAST_PATH] = step[CONTINUES] = where(fast, 1.0, 0.0)
    stepper[FAST_STEPS] = stepper[FAST_STEPS] + step[ON_FAST_PATH]
    stepper[NEXT] = where(fast, min(stepper[NEXT], stepper[LONGEST] / accumulators.o[END, KAPPA]), stepper[NEXT])
    step[LENGTH] = where(fast, stepper[NEXT], step[LENGTH])


@inlined
def holds_no_event(accumulators, guards, independent, time):
    """Return whether a step contains no event for certain; guards whose values laws give are left out."""
    y, end, k, o, mode, h = (
        accumulators.y,
        accumulators.end,
        accumulators.k,
        accumulators.o,
        accumulators.mode,
        accumulators.step[LENGTH],
    )
    none = end[independent] < accumulators.stepper[STOP_AT]
    for j in range(mode.size):
        if not none_of(meets(mode[j])):
            none = none & (where(meets(mode[j]), least_bound(accumulators, j), -1.0) < 0.0)
        # a root of penetration that falls and rises dips by at most a quarter of what either slope makes of it
        root = time + 1 + j
        lowest, fall, rise = min(y[root], end[root]), k[0, root], k[END, root]
        dip = where((fall < 0.0) & (rise > 0.0), 0.25 * h * min(-fall, rise), 0.0)
        none = none & (where(touches(mode[j]), lowest - dip, 1.0) > 0.0)
    for g in range(guards.contact.size):
        if guards.column[g] >= 0:
            highest = highest_seen(o, guards.column[g], guards.sign[g], guards.at_stages[g])
            none = none & (where(is_looked_at(guards, g, mode[guards.contact[g]]), highest, -1.0) <= 0.0)
    return none


@inlined
def least_bound(accumulators, j):
    """Return the least depth (m) that is known to be above all depths of contact `j`, in free flight, on its way."""
    o, h, there = accumulators.o, accumulators.step[LENGTH], column_of(j, DEPTH)
    fastest = max(accumulators.step[sum_of(j, FASTEST)], o[END, column_of(j, SLIP)] * o[END, KAPPA])
    return min(deepest_between(o[0, there], o[END, there], MARGIN * h * fastest), highest_control(o, j, h))


@inlined
def highest_control(o, j, h):
    """Return the highest control point (m), but the first, of a curve above the depths of contact `j` in the step.

    The curve, of the fourth degree over the share x: the cubic through depths and slopes at both ends, and
    x^2 (1 - x)^2 times STRAY times the most by which stages between are above it, as such a curve is.  Where all these
    points are below zero the surfaces do not meet, also where they have just parted, the first point being about zero:
    by Descartes' rule, in Bernstein's form, the curve then goes through zero once at most, and falls there.
    """
    there, speed = column_of(j, DEPTH), column_of(j, RATE)
    begin, end = o[0, there], o[END, there]
    rise, fall = h * (o[0, speed] * o[0, KAPPA]), h * (o[END, speed] * o[END, KAPPA])
    above = 0.0 * begin
    for m in range(1, NODES.size - 1):
        cubic = CUBIC[m, 0] * begin + CUBIC[m, 1] * rise + CUBIC[m, 2] * end + CUBIC[m, 3] * fall
        above = max(above, (o[NODES[m], there] - cubic) * BUMP[m])
    second, third = begin + rise / 3.0, end - fall / 3.0  # of the cubic's own
    middle = 0.5 * (second + third) + (STRAY / 6.0) * above
    of_begin, of_end = 0.25 * begin + 0.75 * second, max(0.75 * third + 0.25 * end, end)
    return max(max(of_begin, of_end), middle)  # noqa: PLW3301 - numbers in lanes know the larger of two


def _cubic(x):
    """Return the weights of value and slope at 0, then at 1, that give the cubic through them at `x`."""
    return np.stack([(1 - x) ** 2 * (1 + 2 * x), x * (1 - x) ** 2, x**2 * (3 - 2 * x), x**2 * (x - 1)], axis=1)


CUBIC = _cubic(SHARES)
BUMP = np.array([0.0, *(1.0 / (SHARES * (1.0 - SHARES))[1:-1] ** 2), 0.0])  # over x^2 (1 - x)^2


@inlined
def travel_ratio(accumulators):
    """Return how far journals in free flight go in the step, over what they may."""
    step, mode = accumulators.step, accumulators.mode
    farthest = 0.0 * step[LENGTH]
    for j in range(mode.size):
        ratio = step[LENGTH] * step[sum_of(j, FASTEST)] / (FARTHEST * accumulators.clearance[j])
        farthest = max(farthest, where(meets(mode[j]), ratio, 0.0))
    return farthest
