"""Settings of an integration, the state of the loop between steps, and how it ends: numbers of a Work."""

import math
from typing import TYPE_CHECKING, NamedTuple

from ..trace.fields import Fields

AUTO = 2  # of Control.method
OK, STEP_BUDGET, EVENT_BUDGET, NOT_FINITE, STEP_UNDERFLOW, PAUSED, TURNS_STIFF, TIME_LIMIT, STALLED = range(9)
LEFT_BEARING, GOING = range(9, 11)


class Control(NamedTuple):
    """When to stop, which method to use, and what to keep."""

    window: float  # s, or rad of a free crank: start of the window in which figures are taken
    end: float  # s, or rad of a free crank: end of the run
    separations: int  # number of separations after which to stop; 0: no limit
    step_budget: int
    event_budget: int
    keep_events: bool
    method: int  # AUTO, or EXPLICIT or IMPLICIT throughout
    pause: float = math.inf  # s, or rad of a free crank: return PAUSED at the first step that ends here or later
    pause_steps: int = 1 << 16  # steps after which to return PAUSED, so that the caller can check the time used
    time_limit: float = math.inf  # s of motion of a free crank, after which to return TIME_LIMIT
    patience: float = math.inf  # s, within which a free crank has to advance; inf: the crank is not free


class ControlNumbers(Fields, like=Control):
    """The numbers of a Control, in memory."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> float: ...


class Stepper(Fields):
    """State of the loop between steps."""

    next_length: float  # length of the next step; 0 before the first
    growth: float  # largest ratio of the next length to the length of this step
    expected_error: float  # error that the next step is expected to have, over the tolerance
    rejections: float  # rejected steps in a row
    evaluations: float  # evaluations before this step
    pause_step: float  # number of the step after which to return PAUSED
    in_window: float  # 1 where figures are taken, else 0
    logged: float  # events in the log
    begun: float  # 1 once `begin_case` has run, else 0
    next_stop: float  # where the next step has to end: s, or rad of a free crank
    farthest: float  # rad, largest angle of a free crank
    progress_angle: float  # rad, angle at which a free crank last advanced by STALL_ADVANCE
    progress_time: float  # s, when it was there
    status: float  # how the latest call of the loop ended
    contact: float  # contact of the latest event
