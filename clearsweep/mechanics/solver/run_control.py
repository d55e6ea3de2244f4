"""What the loop is given, what it goes on with, and how it ends: numbers of a Work."""

import math
from typing import NamedTuple

AUTO = 2  # of Control.method
OK, STEP_BUDGET, EVENT_BUDGET, NOT_FINITE, STEP_UNDERFLOW, PAUSED, TURNS_STIFF, TIME_LIMIT, STALLED = range(9)
LEFT_BEARING, GOING = range(9, 11)


class Control(NamedTuple):
    """When to stop, how accurate to be, and what to keep: numbers, that are in Work.control in this order."""

    window: float  # s, or rad of a free crank: where figures begin to be taken
    end: float  # the same: where to stop
    separations: int  # stop after so many; 0: never
    step_budget: int
    event_budget: int
    keep_events: bool
    method: int  # AUTO, or EXPLICIT or IMPLICIT throughout
    pause: float = math.inf  # the same: return PAUSED at the first step end from here on; called again, go on
    stretch: int = 1 << 16  # steps after which to return PAUSED, too, so that whoever called can look at the clock
    limit: float = math.inf  # s, after which to give up
    patience: float = math.inf  # s, within which a free crank has to move on; inf: it is not free


WINDOW, LAST, PARTINGS, MOST_STEPS, MOST_EVENTS, KEEP_EVENTS, METHOD, PAUSE, STRETCH, LIMIT, PATIENCE = range(11)
# Work.stepper: length of the next step, 0 before the first; how much it may grow; its expected error; rejections in a
# row; evaluations before it; the step after which to pause; whether figures are taken; events logged; whether begun;
# where along the run the next step has to end; of a free crank how far it was, from where it has to move on, and since
# when (s)
NEXT, GROWTH, EXPECTED, TRIES, SPENT, REST, WINDOWED, LOGGED, BEGUN, STOP_AT, FARTHEST, ANGLE, SINCE = range(13)
# then how the latest call of the loop ended, and the contact of the latest event
STATUS, CONTACT, AHEAD = 13, 14, 15
