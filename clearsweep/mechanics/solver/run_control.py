"""Settings of an integration, the state of the loop between steps, and how it ends: numbers of a Work."""

import math
from typing import NamedTuple

AUTO = 2  # of Control.method
OK, STEP_BUDGET, EVENT_BUDGET, NOT_FINITE, STEP_UNDERFLOW, PAUSED, TURNS_STIFF, TIME_LIMIT, STALLED = range(9)
LEFT_BEARING, GOING = range(9, 11)


class Control(NamedTuple):
    """When to stop, which method to use, and what to keep; Work.control has these numbers in this order."""

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


# Indices of Work.control: the fields of Control
(
    CONTROL_WINDOW,
    CONTROL_END,
    CONTROL_SEPARATIONS,
    CONTROL_STEP_BUDGET,
    CONTROL_EVENT_BUDGET,
    CONTROL_KEEP_EVENTS,
    CONTROL_METHOD,
    CONTROL_PAUSE,
    CONTROL_PAUSE_STEPS,
    CONTROL_TIME_LIMIT,
    CONTROL_PATIENCE,
) = range(11)

# Indices of Work.stepper
STEPPER_NEXT_LENGTH = 0  # length of the next step; 0 before the first
STEPPER_GROWTH = 1  # largest ratio of the next length to the length of this step
STEPPER_EXPECTED_ERROR = 2  # error that the next step is expected to have, over the tolerance
STEPPER_REJECTIONS = 3  # rejected steps in a row
STEPPER_EVALUATIONS = 4  # evaluations before this step
STEPPER_PAUSE_STEP = 5  # number of the step after which to return PAUSED
STEPPER_IN_WINDOW = 6  # 1 where figures are taken, else 0
STEPPER_LOGGED = 7  # events in the log
STEPPER_BEGUN = 8  # 1 once `begin_case` has run, else 0
STEPPER_NEXT_STOP = 9  # where the next step has to end: s, or rad of a free crank
STEPPER_FARTHEST = 10  # rad, largest angle of a free crank
STEPPER_PROGRESS_ANGLE = 11  # rad, angle at which a free crank last advanced by STALL_ADVANCE
STEPPER_PROGRESS_TIME = 12  # s, when it was there
STEPPER_STATUS = 13  # how the latest call of the loop ended
STEPPER_CONTACT = 14  # contact of the latest event
STEPPER_SIZE = 15  # length of Work.stepper
