"""Calm steps: those of which nothing is wanted beyond what `tally.enter` adds up, and after which nothing is due.

Most steps of most cases are.  `prospect.note_calm` tells which; they are counted when one comes that is not.
"""

import math

from ..compiled.family import kernel
from .choice import LEFT
from .dop853 import END
from .event import EVALUATIONS, IMPLICIT, REJECTED, SAMPLES, STEPS
from .plan import (
    AUTO,
    CALM_STEPS,
    CAN_BE_CALM,
    DUE,
    METHOD,
    MOST_CALM,
    MOST_STEPS,
    PATIENCE,
    PAUSE,
    REST,
    SPENT,
    UNASKED,
)


@kernel
def can_be_calm(at):
    """Return whether steps of a case can be calm: a free crank, films and wear are looked at in each."""
    work = at[0]
    watched = work.along != work.time or work.control[PATIENCE] < math.inf or work.wear.code != 0
    for j in range(work.mode.size):
        watched = watched or work.film[j, 1] < math.inf
    return work.takes_steps != 0 and not watched


@kernel
def limit_calm(at):
    """Note how many of the steps that follow may be calm, and up to where."""
    work = at[0]
    ahead, record, turns = work.ahead, work.record, work.turns
    due, sample, mark = work.control[PAUSE], work.counts[SAMPLES], turns.passed[0]
    if mark < turns.marks.size:
        due = min(due, turns.marks[mark])
    if sample < record.times.size:
        due = min(due, record.times[sample])
    most = min(ahead[REST] - work.counts[STEPS], work.control[MOST_STEPS] - work.counts[STEPS] - work.counts[REJECTED])
    plain = ahead[CAN_BE_CALM] != 0.0 and work.method[0] != IMPLICIT and work.method[1] == 0
    left = work.implicit.choice[LEFT] if work.control[METHOD] == AUTO else math.inf
    ahead[DUE], ahead[MOST_CALM], ahead[UNASKED] = due, most - 1.0 if plain else 0.0, left - 1.0


@kernel
def count_calm(at):
    """Count the calm steps that were taken since the last one that was not."""
    work = at[0]
    ahead, calm = work.ahead, int(work.ahead[CALM_STEPS])
    work.counts[STEPS] += calm
    work.counts[EVALUATIONS] += END * calm
    if calm > 0:
        ahead[SPENT] = work.counts[EVALUATIONS]
    work.implicit.choice[LEFT] -= ahead[CALM_STEPS]
    ahead[CALM_STEPS] = 0.0
