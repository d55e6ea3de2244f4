"""Which method the next step takes: the one that costs less for the same time.

An explicit step costs END evaluations, however many numbers the state has.  An implicit one costs evaluations, too, and
matrices that grow with the number of unknowns.  The price of all this in evaluations was measured on the cases of
`verify.stiff`, with 6, 11 and 16 numbers in the state.

Where the motion is stiff, an explicit step is short for a motion that hardly bends within it.  How fast small errors
change is seen from two stages at the end of the step (Hairer & Wanner, "Solving Ordinary Differential Equations II",
2nd ed., IV.2); how fast the motion turns, from the steps before.  The eigenvalue alone says nothing: where the
tolerance is tight, errors of what is stiff keep the steps within a third of the limit of stability.
"""

import math

from ..compiled.family import kernel
from ..observe.along import RISE, RUN
from .dop853 import END
from .event import EXPLICIT, IMPLICIT

FAST = 0.5  # h times the largest eigenvalue, from which on a step may be short for what is stiff
PATIENCE = 15  # such steps in a row before the motion is looked at
WAIT, LONGEST_WAIT = 2, 16  # times more of them after each time that the implicit method was not worth it; at most
ERROR = 0.005  # see `is_longer`; from steps that the implicit method took
PRICE = 0.62  # of an evaluation in an implicit step, for each number in the state: most of it goes into the matrices
TRIAL = 40  # evaluations for each number in the state, after which it is asked what the implicit method has saved
STEADY = 1.2  # growth of the step that is forgone, as the factors of the matrices can be used again
# Places in Implicit.choice: length of the last explicit step and of the first implicit one; what PATIENCE is times;
# of a trial, the evaluations that explicit steps would have taken and those that were; how long the steps together are
# that speak for the implicit method, and half of them
LIMIT, FIRST, GROWN, SAVED, SPENT, SPAN, HALF = range(7)


@kernel
def steady(at, h, proposal):
    """Return the length of the step after one of length `h`: the proposal, or `h` again where that saves work."""
    return h if at[0].method[0] == IMPLICIT and h <= proposal <= STEADY * h else proposal


@kernel
def choose_method(at, h, explicit, cost):
    """Change the method where the step just taken, of length `h`, shows that the other one serves better.

    `explicit` : length of the last explicit step with the same joints in contact, 0 where there is none; `cost` :
    evaluations that this step took, so that what a run is asked beside its motion has no part in the choice.

    It takes effect with the next step.
    """
    work = at[0]
    if work.method[0] == IMPLICIT:
        if costs_too_much(at, h, explicit, cost):
            work.method[2] = EXPLICIT
    elif is_stiff(at, h):
        work.method[2] = IMPLICIT


@kernel
def price_of_step(n):
    """Return what an implicit step costs, in explicit ones: two iterations, and Jacobians now and then."""
    return PRICE * n * (5.0 + 4.0 * n) / END


@kernel
def is_stiff(at, h):
    """Return whether an implicit step will be so much longer than one of length `h` that it is worth its price.

    It is asked after PATIENCE steps in a row that may be short for what is stiff.  Mean rates over the first and the
    second half of them tell how the motion turns: what is stiff, and jitters at the limit of stability, is not in them.
    """
    work = at[0]
    n, choice, since = work.y.size, work.implicit.choice, work.implicit.since
    if not h**2 * work.step[RISE] > FAST**2 * work.step[RUN]:
        work.method[1] = 0
        return False
    if work.method[1] == 0:
        choice[SPAN] = 0.0
        for i in range(n):
            since[0, i] = work.y[i]
    work.method[1] += 1
    choice[SPAN] += h
    wanted = PATIENCE * max(choice[GROWN], 1.0)
    if work.method[1] == wanted // 2:
        choice[HALF] = choice[SPAN]
        for i in range(n):
            since[1, i] = work.end[i]
    if work.method[1] < wanted or not is_longer(at, h):
        return False
    choice[LIMIT], choice[FIRST], choice[SAVED], choice[SPENT] = h, h * math.sqrt(price_of_step(n)), 0.0, 0.0
    return True


@kernel
def is_longer(at, h):
    """Return whether an implicit step may be as many times as long as one of length `h` as it costs more.

    The error of an implicit step in which the motion turns by `bend` of itself is ERROR bend^6 of its size.
    """
    work = at[0]
    n, choice, since = work.y.size, work.implicit.choice, work.implicit.since
    work.method[1] = 0
    first, second = choice[HALF], choice[SPAN] - choice[HALF]
    turned, moved = 0.0, 0.0
    for i in range(n):
        before, after = (since[1, i] - since[0, i]) / first, (work.end[i] - since[1, i]) / second
        turned += ((after - before) / work.scale[i]) ** 2
        moved += ((work.end[i] - since[0, i]) / work.scale[i]) ** 2
    bend = 2.0 * h * math.sqrt(turned / moved)  # in a step of length h
    size = math.sqrt(moved / n) * h / choice[SPAN]  # times bend, over the allowed error
    return ERROR * bend**5 * price_of_step(n) ** 6 * size < 1.0


@kernel
def costs_too_much(at, h, explicit, cost):
    """Return whether the implicit steps of a TRIAL, this one being the last, cost more than explicit ones would have.

    Those are as long as the last one with the same contacts, or as the last before the method changed.
    """
    work = at[0]
    n, choice = work.y.size, work.implicit.choice
    choice[SAVED] += END * h / max(explicit, choice[LIMIT])
    choice[SPENT] += cost
    if choice[SPENT] < TRIAL * n:
        return False
    worth = choice[SAVED] > PRICE * n * choice[SPENT]
    choice[GROWN] = 1.0 if worth else min(WAIT * max(choice[GROWN], 1.0), LONGEST_WAIT)
    choice[SAVED], choice[SPENT] = 0.0, 0.0
    return not worth
