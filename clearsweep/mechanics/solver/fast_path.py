"""Steps of the fast path: only the sums of `totals.accumulate_step` are wanted, and nothing is due after them.

Most steps of most cases are.  `acceptance.note_fast_path` decides which; they are counted when one comes that is not.
"""

import math

from ..compiled.family import kernel
from .choice import LEFT
from .dop853 import END
from .event import EVALUATIONS, IMPLICIT, REJECTED, SAMPLES, STEPS
from .run_control import (
    AUTO,
    CAN_TAKE_FAST_PATH,
    DUE,
    FAST_STEPS,
    METHOD,
    MOST_FAST_STEPS,
    MOST_STEPS,
    PATIENCE,
    PAUSE,
    REST,
    SPENT,
    UNASKED,
)


@kernel
def can_take_fast_path(at):
    """Return whether steps of a case can be fast: each is looked at of a free crank, films, wear, friction loads."""
    work = at[0]
    watched = work.independent != work.time or work.control[PATIENCE] < math.inf or work.wear.code != 0
    watched = watched or work.totals.friction.size > 0
    for j in range(work.mode.size):
        watched = watched or work.film[j, 1] < math.inf
    return work.takes_steps != 0 and not watched


@kernel
def limit_fast_steps(at):
    """Note how many of the steps that follow may be fast, and up to where."""
    work = at[0]
    stepper, record, turns = work.stepper, work.record, work.turns
    due, sample, mark = work.control[PAUSE], work.counts[SAMPLES], turns.passed[0]
    if mark < turns.marks.size:
        due = min(due, turns.marks[mark])
    if sample < record.times.size:
        due = min(due, record.times[sample])
    most = min(
        stepper[REST] - work.counts[STEPS], work.control[MOST_STEPS] - work.counts[STEPS] - work.counts[REJECTED]
    )
    plain = stepper[CAN_TAKE_FAST_PATH] != 0.0 and work.method[0] != IMPLICIT and work.method[1] == 0
    left = work.implicit.choice[LEFT] if work.control[METHOD] == AUTO else math.inf
    stepper[DUE], stepper[MOST_FAST_STEPS], stepper[UNASKED] = due, most - 1.0 if plain else 0.0, left - 1.0


@kernel
def count_fast_steps(at):
    """Count the fast steps that were taken since the last one that was not."""
    work = at[0]
    stepper, fast = work.stepper, int(work.stepper[FAST_STEPS])
    work.counts[STEPS] += fast
    work.counts[EVALUATIONS] += END * fast
    if fast > 0:
        stepper[SPENT] = work.counts[EVALUATIONS]
    work.implicit.choice[LEFT] -= stepper[FAST_STEPS]
    stepper[FAST_STEPS] = 0.0
