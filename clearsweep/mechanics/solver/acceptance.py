"""Whether a step is good, and how long the next may be."""

import math

from ..compiled.family import inlined
from ..joint.contract import meets
from .accumulate.step_sums import ACCEPTED, CONTRACTION, ERROR, FASTEST, LENGTH, STIFF, SWEEPS, sum_of
from .event import FARTHEST, IMPLICIT
from .run_control import STEPPER_EXPECTED_ERROR, STEPPER_GROWTH, STEPPER_NEXT_LENGTH, STEPPER_REJECTIONS
from .step_control import GROW, change_of_length, twelfth_power

FEWEST = 0.22  # contraction, which goes with the square of the length, at which a way costs least
#: Sweeps up to which a step costs little, however slowly they contract, and the contraction that may then be.
FEW, MOST = 4.0, 0.35
FAST = 0.03  # contraction from which on a step may be short for what is stiff


@inlined
def assess_step(accumulators, method):
    """Note how large the error of the trial step is and, if it is accurate, how long the next may be."""
    step, stepper = accumulators.step, accumulators.stepper
    h, error = step[LENGTH], max(step[ERROR], twelfth_power(travel_ratio(accumulators)))  # the twelfth root is taken
    step[ERROR], step[ACCEPTED], step[STIFF] = error, 0.0, 0.0
    if not error < 1.0:
        return
    change = min(stepper[STEPPER_GROWTH], change_of_length(error, stepper[STEPPER_EXPECTED_ERROR]))
    stepper[STEPPER_EXPECTED_ERROR] = error * twelfth_power(change)
    if method != IMPLICIT and step[CONTRACTION] > FAST:
        best = FEWEST if step[SWEEPS] > FEW else MOST
        step[STIFF], change = 1.0, min(change, math.sqrt(best / step[CONTRACTION]))
    stepper[STEPPER_NEXT_LENGTH], stepper[STEPPER_GROWTH], stepper[STEPPER_REJECTIONS] = h * change, GROW, 0.0


@inlined
def travel_ratio(accumulators):
    """Return how far journals in free flight go in the step, over what they may."""
    step, mode = accumulators.step, accumulators.mode
    farthest = 0.0
    for j in range(mode.size):
        if meets(mode[j]):
            ratio = step[LENGTH] * step[sum_of(j, FASTEST)] / (FARTHEST * accumulators.clearance[j])
            farthest = max(farthest, ratio)
    return farthest
