"""A step of the explicit method as one piece of compiled code: its stages and its end.

The right-hand side is in it once, so that the same code evaluates it alone, too.

The same function makes it for one case and, where no formula takes a decision on numbers, for as many as lie side by
side.  Every operation and its rounding is fixed by it: by which of the two a step was taken cannot be told from its
bits.
"""

from ..compiled.family import WIDTH, Entry, entry, in_lane, inlined
from ..solver.accumulate.step_sums import LENGTH, WHOLE, TrialStep, keep_last_stage, step_width
from ..solver.dop853 import END, ROWS, stage_state
from .rates import observed_width, rates, size_of

ARRAYS = "fiffffff"  # the fields of TrialStep: float64 or int64


@inlined
def _take(scene, tried, only):
    """Fill rows 1 to END of rates and observables, `end` getting the state of each.

    `only` : the row that is filled for the state that `end` has, or WHOLE.
    """
    first, last = (1, END) if only == WHOLE else (only, only)
    for row in range(first, last + 1):
        if only == WHOLE:
            if row == END:
                keep_last_stage(tried, tried.end)
            stage_state(row, tried.step[LENGTH], tried.y, tried.k, tried.end)
        rates(scene, tried.end, tried.mode, tried.latched, tried.k, tried.o, row)


def trial_step_entry(scene, y, mode, latched, weight, k, o, end, step, row):
    """Take a step, or fill a `row`, with parameters and arrays from bare pointers; `scene` points at the Scene."""
    here = scene[0]
    contacts, n, latching = size_of(here)
    tried = TrialStep(
        in_lane(y, (n,)),
        in_lane(mode, (contacts,)),
        in_lane(latched, (latching,)),
        in_lane(weight, (n,)),
        in_lane(k, (ROWS, n)),
        in_lane(o, (ROWS, observed_width(here))),
        in_lane(end, (n,)),
        in_lane(step, (step_width(contacts, n),)),
    )
    _take(here, tried, row)


def attempt_of(scene, parameters) -> Entry:
    """Return the Entry that evaluates and takes steps of `scene`, whose parameters are in a lane."""
    return entry(trial_step_entry, scene, ARRAYS, parameters, in_lanes=True)


def together_of(scene, parameters) -> Entry:
    """Return the Entry that takes a step of WIDTH scenes of the type of `scene`, `parameters` being the first's.

    NO_ENTRY where a formula of theirs takes a decision on numbers, which lanes cannot: these cases go one by one.
    """
    return entry(trial_step_entry, scene, ARRAYS, parameters, in_lanes=True, width=WIDTH)
