"""Whether a step can hold an event at all, and whether it is short enough to be searched for one."""

from ..compiled.family import kernel
from ..joint.contract import meets, touches
from ..observe.along import FASTEST, sum_of
from ..observe.observables import observed
from .dop853 import END
from .event import FARTHEST, MARGIN, fastest, pass_guards


@kernel
def may_meet(at, h, stop):
    """Return whether the step from `work.y` to `work.end` can hold an event; True wherever that is not excluded."""
    work = at[0]
    if work.end[work.along] >= stop:
        return True
    for j in range(work.mode.size):
        if meets(work.mode[j]):
            # a path from one end to the other strays from the farther end by at most half its length
            reach = max(observed(at, 0, j).depth, observed(at, END, j).depth)
            reach += 0.5 * MARGIN * h * fastest(at, j)
            if reach >= 0.0:
                return True
        elif touches(work.mode[j]):
            start, end = work.k[0, work.time + 1 + j], work.k[END, work.time + 1 + j]
            lowest = min(work.y[work.time + 1 + j], work.end[work.time + 1 + j])
            if lowest <= 0.0 or (start < 0.0 < end and lowest < 0.25 * h * min(-start, end)):
                return True
    return pass_guards(at)


@kernel
def travel_ratio(at, h):
    """Return how far journals in free flight go in a step of length `h`, over what they may."""
    work, farthest = at[0], 0.0
    for j in range(work.mode.size):
        if meets(work.mode[j]):
            farthest = max(farthest, h * work.step[sum_of(j, FASTEST)] / (FARTHEST * work.clearance[j]))
    return farthest
