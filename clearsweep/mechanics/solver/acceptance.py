"""Whether a step is good, whether it can hold an event, and how long the next may be.

Free flight is short enough to be searched: a journal may travel so far in a step, see `event.FARTHEST`.
"""

import math

import numpy as np

from ..compiled.family import inlined
from ..joint.contract import meets, touches
from ..observe.observables import DEPTH, KAPPA, RATE, SLIP, column_of
from ..observe.stages import END, NODES, SHARES, STAGES, START
from .accumulate.step_sums import ACCEPTED, CONTRACTION, ERROR, FASTEST, LENGTH, STIFF, SWEEPS, sum_of
from .event import FARTHEST, IMPLICIT, MARGIN
from .guarding import highest_seen, is_looked_at
from .run_control import EXPECTED, GROWTH, NEXT, STOP_AT, TRIES
from .span import deepest_between
from .step_control import GROW, change_of_length, twelfth_power

FEWEST = 0.22  # contraction, which goes with the square of the length, at which a way costs least
#: Sweeps up to which a step costs little, however slowly they contract, and the contraction that may then be.
FEW, MOST = 4.0, 0.35
FAST = 0.03  # contraction from which on a step may be short for what is stiff
STRAY = 2.0  # on how far depths at the stages are above a cubic: bounds how far they are between them


@inlined
def assess_step(accumulators, guards, independent, time, method):
    """Decide whether the trial step is accepted as it is and, if it is accurate, how long the next may be.

    guards : Guards; `independent`, `time` : places in the state.
    """
    step, stepper = accumulators.step, accumulators.stepper
    h, error = step[LENGTH], max(step[ERROR], twelfth_power(travel_ratio(accumulators)))  # the twelfth root is taken
    step[ERROR], step[ACCEPTED], step[STIFF] = error, 0.0, 0.0
    if not error < 1.0:
        return
    change = min(stepper[GROWTH], change_of_length(error, stepper[EXPECTED]))
    stepper[EXPECTED] = error * twelfth_power(change)
    if method != IMPLICIT and step[CONTRACTION] > FAST:
        best = FEWEST if step[SWEEPS] > FEW else MOST
        step[STIFF], change = 1.0, min(change, math.sqrt(best / step[CONTRACTION]))
    stepper[NEXT], stepper[GROWTH], stepper[TRIES] = h * change, GROW, 0.0
    if holds_no_event(accumulators, guards, independent, time):
        step[ACCEPTED] = 1.0


@inlined
def holds_no_event(accumulators, guards, independent, time):
    """Return whether a step contains no event for certain; guards whose values laws give are left out."""
    y, end, k, o, mode = accumulators.y, accumulators.end, accumulators.k, accumulators.o, accumulators.mode
    h = accumulators.step[LENGTH]
    if not end[independent] < accumulators.stepper[STOP_AT]:
        return False
    for j in range(mode.size):
        if meets(mode[j]) and not least_bound(accumulators, j) < 0.0:
            return False
        # a root of penetration that falls and rises dips by at most a quarter of what either slope makes of it
        root = time + 1 + j
        lowest, fall, rise = min(y[root], end[root]), k[root, START], k[root, END]
        if touches(mode[j]) and not lowest - (0.25 * h * min(-fall, rise) if fall < 0.0 < rise else 0.0) > 0.0:
            return False
    for g in range(guards.contact.size):
        seen = guards.column[g] >= 0 and is_looked_at(guards, g, mode[guards.contact[g]])
        if seen and highest_seen(o, guards.column[g], guards.sign[g], guards.at_stages[g]) > 0.0:
            return False
    return True


@inlined
def least_bound(accumulators, j):
    """Return the least depth (m) that is known to be above all depths of contact `j`, in free flight, on its way."""
    o, h, there = accumulators.o, accumulators.step[LENGTH], column_of(j, DEPTH)
    fastest = max(accumulators.step[sum_of(j, FASTEST)], o[column_of(j, SLIP), END] * o[KAPPA, END])
    return min(deepest_between(o[there, START], o[there, END], MARGIN * h * fastest), highest_control(o, j, h))


@inlined
def highest_control(o, j, h):
    """Return the highest control point (m), but the first, of a curve above the depths of contact `j` in the step.

    The curve, of the fourth degree over the share x: the cubic through depths and slopes at both ends, and
    x^2 (1 - x)^2 times STRAY times the most by which stages between are above it, as such a curve is.  Where all these
    points are below zero the surfaces do not meet, also where they have just parted, the first point being about zero:
    by Descartes' rule, in Bernstein's form, the curve then goes through zero once at most, and falls there.
    """
    there, speed = column_of(j, DEPTH), column_of(j, RATE)
    begin, end = o[there, START], o[there, END]
    rise, fall = h * (o[speed, START] * o[KAPPA, START]), h * (o[speed, END] * o[KAPPA, END])
    above = 0.0
    for m in range(2, STAGES):  # not so close to an end that rounding would count
        cubic = CUBIC[m, 0] * begin + CUBIC[m, 1] * rise + CUBIC[m, 2] * end + CUBIC[m, 3] * fall
        above = max(above, (o[there, NODES[m]] - cubic) * BUMP[m])
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
    farthest = 0.0
    for j in range(mode.size):
        if meets(mode[j]):
            ratio = step[LENGTH] * step[sum_of(j, FASTEST)] / (FARTHEST * accumulators.clearance[j])
            farthest = max(farthest, ratio)
    return farthest
