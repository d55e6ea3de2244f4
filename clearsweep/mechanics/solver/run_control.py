"""Settings, state and end conditions of the loop: numbers of a Work."""

import math
from typing import NamedTuple

AUTO = 2  # of Control.method
OK, STEP_BUDGET, EVENT_BUDGET, NOT_FINITE, STEP_UNDERFLOW, PAUSED, TURNS_STIFF, TIME_LIMIT, STALLED = range(9)
LEFT_BEARING, GOING = range(9, 11)


class Control(NamedTuple):
    """End conditions, tolerances and outputs, as numbers of Work.control in this order."""

    window: float  # s, or rad of a free crank: start of the figures
    end: float  # as window: end of the run
    separations: int  # stop after this number; 0: never
    step_budget: int
    event_budget: int
    keep_events: bool
    method: int  # AUTO, or EXPLICIT or IMPLICIT throughout
    pause: float = math.inf  # as window: return PAUSED at the first step end from here on; call again to continue
    stretch: int = 1 << 16  # steps after which to return PAUSED, so that the caller can check the clock
    limit: float = math.inf  # s, time limit of the run
    patience: float = math.inf  # s, within which a free crank must advance; inf: not free


WINDOW, LAST, PARTINGS, MOST_STEPS, MOST_EVENTS, KEEP_EVENTS, METHOD, PAUSE, STRETCH, LIMIT, PATIENCE = range(11)
# Work.stepper: length of the next step, 0 before the first; its largest growth; its expected error; rejections in a
# row;
# evaluations before it; the step at which to pause; whether figures are accumulated; events logged; whether the run has
# begun; place along the run where the next step must end; of a free crank its largest angle, the angle from which it
# must
# advance, and the time (s) since when
NEXT, GROWTH, EXPECTED, TRIES, SPENT, REST, WINDOWED, LOGGED, BEGUN, STOP_AT, FARTHEST, ANGLE, SINCE = range(13)
# then the STATUS of the latest call of the loop, and the contact of the latest event
STATUS, CONTACT, AHEAD = 13, 14, 15
