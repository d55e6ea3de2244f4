"""Which method the next step takes: the one that costs less for the same time.

An explicit step costs some sweeps, however many numbers the state has.  An implicit one costs evaluations and
matrices that grow with the number of unknowns.  The price of all this in evaluations was measured on the cases of
`verify.stiff`, with 6, 11 and 16 numbers in the state.

Where the motion is stiff, an explicit step is short for a motion that hardly bends within it.  How fast small errors
change is seen from how the iteration of a step contracts; how the motion bends, from states as far apart as within an
implicit step.  The contraction alone says nothing: that of a motion that is not stiff is as slow now and then.

Counts of evaluations decide, never a clock, and of these only what the motion takes: not what is asked besides it.
"""

from ..compiled.family import kernel
from ..observe.stages import STAGES
from .accumulate.step_sums import STIFF
from .event import EVALUATIONS, EXPLICIT, IMPLICIT
from .radau import ERROR, ORDER
from .run_control import AUTO, CONTROL_METHOD, STEPPER_EVALUATIONS

PRICE = 0.62  # of an evaluation in an implicit step, for each number in the state: most of it goes into the matrices
LOOK = 2.0  # over an implicit step that is worth its price: how far the motion is looked at, and the first such step
SMALL = 0.5  # error, over the allowed one, that is expected of an implicit step worth its price where it is tried
SWEEPS = 6.0  # in a step of the explicit method, as a rule: what one of them costs is counted in these
PER_STEP = 12.0  # evaluations, one after the other, that take as long as such a step
REST = 2.0  # times as long as the motion was looked at in vain it is not looked at, which costs a lane a few per cent
LOSS = 4.0  # implicit steps whose price the implicit method may lose before it is left,
GAINED = 0.1  # and this share of what it has saved before
BACK = 0.1  # of explicit evaluations: so many have to make up for what was lost before the motion is looked at again
STEADY = 1.2  # growth of the step that is forgone, as the factors of the matrices can be used again
STEP_COST = SWEEPS * STAGES
# Places in Implicit.choice: length of an explicit step before the method changed; explicit evaluations that the
# implicit one has SAVED since then, and those that it has LOST of them; how many explicit steps are LEFT until the
# motion is looked at again; of the steps that may be short for what is stiff, length and evaluations, and these without
# the last of ORDER parts; then the length at the beginning and at the end of each part
LIMIT, SAVED, LOST, LEFT, SPAN, COST, EARLY, MARKS = range(8)
CHOICE = MARKS + ORDER + 1


@kernel
def steady(at, h, proposal):
    """Return the length of the step after one of length `h`: the proposal, or `h` again where that saves work."""
    return h if at[0].method[0] == IMPLICIT and h <= proposal <= STEADY * h else proposal


@kernel
def choose_method(at, h, pattern):
    """Change the method where the step just taken, of length `h`, shows that the other one serves better.

    pattern : that of `step_control.proposal_of`.  The change takes effect with the next step.
    """
    work, choice = at[0], at[0].implicit.choice
    if work.method[0] == EXPLICIT:
        choice[LEFT] -= 1.0
        if work.step[STIFF] == 0.0:
            work.method[1] = 0
            return
    if work.control[CONTROL_METHOD] != AUTO:
        return
    cost, implicit = work.counts[EVALUATIONS] - work.stepper[STEPPER_EVALUATIONS], 1 << work.mode.size
    if work.method[0] == IMPLICIT:
        explicit = max(work.proposals[pattern & ~implicit], choice[LIMIT])  # the last one with the same contacts
        if loses(at, PER_STEP * h / explicit, cost):
            work.method[2] = EXPLICIT
    elif choice[LEFT] <= 0.0 and is_stiff(at, h, cost):
        work.method[2] = IMPLICIT
        work.proposals[pattern] = choice[LIMIT]
        work.proposals[pattern | implicit] = LOOK * price_of_step(work.y.size) * choice[LIMIT]
        work.paces[pattern | implicit] = work.paces[pattern]


@kernel
def price_of_step(n):
    """Return what an implicit step costs, in explicit ones: two iterations, and Jacobians now and then."""
    return PRICE * n * (5.0 + 4.0 * n) / PER_STEP


@kernel
def is_stiff(at, h, cost):
    """Return whether an implicit step will be so much longer than one of length `h` that it is worth its price.

    It is asked after LOOK times as many explicit steps in a row as that, each of which may be short for what is stiff.
    """
    work = at[0]
    n, choice = work.y.size, work.implicit.choice
    if h == 0.0:  # two events at one time: what is seen there is of either side
        choice[COST] += cost
        return False
    if work.method[1] == 0:
        choice[SPAN], choice[COST] = 0.0, 0.0
        mark(at, 0, work.y)
    choice[SPAN] += h
    choice[COST] += cost
    work.method[1] += 1
    part = int(LOOK * price_of_step(n) / ORDER) + 1
    if work.method[1] % part != 0:
        return False
    mark(at, work.method[1] // part, work.end)
    if work.method[1] == (ORDER - 1) * part:
        choice[EARLY] = choice[COST]
    if work.method[1] < ORDER * part:
        return False
    work.method[1] = 0
    if is_longer(at):
        return True
    choice[LEFT] = REST * choice[COST] / PER_STEP
    return False


@kernel
def mark(at, place, y):
    """Keep the state `y` and how far the steps have come."""
    choice, marks = at[0].implicit.choice, at[0].implicit.marks
    choice[MARKS + place] = choice[SPAN]
    for i in range(y.size):
        marks[place, i] = y[i]


@kernel
def is_longer(at):
    """Return whether an implicit step worth its price in explicit steps has a SMALL error.

    Such explicit steps are as long as the last ones or, where these jitter at the limit of stability, as all are.
    """
    n, choice = at[0].y.size, at[0].implicit.choice
    late = (choice[SPAN] - choice[MARKS + ORDER - 1]) / (choice[COST] - choice[EARLY])
    choice[LIMIT], choice[SAVED], choice[LOST] = STEP_COST * max(choice[SPAN] / choice[COST], late), 0.0, 0.0
    return ERROR**2 * squared_bend(at, price_of_step(n) * choice[LIMIT]) <= SMALL**2


@kernel
def squared_bend(at, h):
    """Return the mean square, over the allowed error, of the sixth derivative of the state times h^6.

    The derivative is that of the polynomial through the marks.
    """
    n, choice, marks = at[0].y.size, at[0].implicit.choice, at[0].implicit.marks
    bend = at[0].implicit.offset
    for i in range(n):
        bend[i] = 0.0
    for m in range(1, ORDER + 1):
        weight = 720.0  # 6!
        for other in range(ORDER + 1):
            if other != m:
                weight *= h / (choice[MARKS + m] - choice[MARKS + other])
        for i in range(n):
            bend[i] += weight * (marks[m, i] - marks[0, i])
    total = 0.0
    for i in range(n):
        total += (bend[i] * at[0].weight[i]) ** 2
    return total / n


@kernel
def loses(at, saved, cost):
    """Return whether the implicit method has lost too much, a step having `saved` explicit evaluations at some `cost`.

    What it may lose grows with what it has saved: where explicit steps are a hundred times shorter, to be without it
    until it is tried again costs more than a stretch on which it is dear.
    """
    work = at[0]
    n, choice = work.y.size, work.implicit.choice
    gain = saved - PRICE * n * cost
    choice[SAVED] += gain
    choice[LOST] = max(choice[LOST] - gain, 0.0)
    if choice[LOST] < LOSS * PER_STEP * price_of_step(n) + GAINED * max(choice[SAVED], 0.0):
        return False
    choice[LEFT] = -min(choice[SAVED], 0.0) / (BACK * PER_STEP)
    return True
