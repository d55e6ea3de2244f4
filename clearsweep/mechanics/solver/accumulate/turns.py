"""State once per revolution, and the largest force of every contact since the previous mark."""

from typing import NamedTuple

import numpy as np

from ...compiled.family import kernel
from ...observe.observables import NORMAL, column_of
from ...observe.stages import END, SCRATCH
from ..collocation import dense_state
from ..event import evaluate_dense
from .peaks import observable_at
from .record import share_at

BESIDE = 1e-4  # of a step: distance from a mark at which a rising force is detected


class Turns(NamedTuple):
    """States and force peaks at marks along the motion."""

    marks: np.ndarray  # (marks,) s, or rad of a free crank, increasing
    states: np.ndarray  # (marks, n) the state at each mark
    peaks: np.ndarray  # (marks, contacts) N, largest normal force since the mark before
    highest: np.ndarray  # (contacts,) N, largest normal force of the current step, 0 if none acts
    since: np.ndarray  # (contacts,) N, largest of the steps before it since the last mark
    passed: np.ndarray  # (1,) int64, number of marks passed


@kernel
def take_start(at):
    """Record the state at a mark at the start of the run."""
    work = at[0]
    revolutions, i = work.turns, work.turns.passed[0]
    if i < revolutions.marks.size and revolutions.marks[i] <= work.y[work.independent]:
        for c in range(revolutions.states.shape[1]):
            revolutions.states[i, c] = work.y[c]
        revolutions.passed[0] = i + 1


@kernel
def take_peaks(at, i, x):
    """Split the largest forces of the step into those before and after mark `i`, at the share `x` of the step."""
    work = at[0]
    revolutions, row = work.turns, END
    if x < 1.0:
        evaluate_dense(at, x)
        row = SCRATCH
    for j in range(work.mode.size):
        column, highest = column_of(j, NORMAL), revolutions.highest[j]
        begin_bin = work.o[column, row] if highest > 0.0 else 0.0
        after = max(begin_bin, work.o[column, END]) if highest > 0.0 else 0.0
        before = begin_bin
        if highest > after:
            rises = x < 1.0 and observable_at(at, min(x + BESIDE, 1.0), column) > begin_bin
            before, after = (begin_bin, highest) if rises else (highest, after)
            if x < 1.0:
                evaluate_dense(at, x)
        revolutions.peaks[i, j] = max(revolutions.since[j], before)
        revolutions.since[j], revolutions.highest[j] = 0.0, after


@kernel
def note_turns(at):
    """Record and pass the marks within the current step."""
    work = at[0]
    revolutions = work.turns
    i = revolutions.passed[0]
    while i < revolutions.marks.size and revolutions.marks[i] <= work.end[work.independent]:
        x = 1.0
        if revolutions.marks[i] < work.end[work.independent]:
            x = share_at(at, work.independent, revolutions.marks[i])
        take_peaks(at, i, x)
        if x < 1.0:
            dense_state(x, work.y, work.f, work.z)
        for c in range(revolutions.states.shape[1]):
            revolutions.states[i, c] = work.z[c] if x < 1.0 else work.end[c]
        i += 1
    revolutions.passed[0] = i
