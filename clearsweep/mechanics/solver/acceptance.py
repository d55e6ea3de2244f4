"""Acceptance of a step, and the largest length of the next step."""

import math

from ..compiled.family import inlined
from ..joint.contract import meets
from .event import FARTHEST, IMPLICIT
from .step_control import GROW, change_of_length, twelfth_power

FEWEST = 0.22  # contraction at which a step is cheapest per length; it varies as the square of the length
#: Sweeps up to which a step is cheap regardless of its contraction, and the largest contraction that allows.
FEW, MOST = 4.0, 0.35
FAST = 0.03  # contraction from which a stiff component may limit the step


@inlined
def assess_step(accumulators, method):
    """Set the error of the trial step and, if it is accurate, the largest length of the next step."""
    step, stepper = accumulators.step, accumulators.stepper
    h, error = step.length, max(step.error, twelfth_power(travel_ratio(accumulators)))  # the twelfth root is taken
    step.error, step.accepted, step.stiff = error, 0.0, 0.0
    if not error < 1.0:
        return
    change = min(stepper.growth, change_of_length(error, stepper.expected_error))
    stepper.expected_error = error * twelfth_power(change)
    if method != IMPLICIT and step.contraction > FAST:
        largest = FEWEST if step.sweeps > FEW else MOST
        step.stiff, change = 1.0, min(change, math.sqrt(largest / step.contraction))
    stepper.next_length, stepper.growth, stepper.rejections = h * change, GROW, 0.0


@inlined
def travel_ratio(accumulators):
    """Return the travel of journals in free flight over the step, divided by the allowed travel."""
    step, mode = accumulators.step, accumulators.mode
    farthest = 0.0
    for j in range(mode.size):
        if meets(mode[j]):
            ratio = step.length * accumulators.contact_steps[j].fastest / (FARTHEST * accumulators.clearance[j])
            farthest = max(farthest, ratio)
    return farthest
