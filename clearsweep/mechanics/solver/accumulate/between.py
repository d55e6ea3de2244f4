"""Positions of the bodies within a step."""

import numpy as np

from ...compiled.choosing import abreast
from ...compiled.family import kernel
from ...observe.histogram import BETWEEN, MOMENTS
from ...observe.stages import STAGES

PLACES = np.minimum(np.arange(MOMENTS) / (BETWEEN + 1), 1.0)


@kernel
def look_between(at, between):
    """Write coordinates, their rates and the time at the moments of the step to `between`.

    between : (2 coordinates + 1, MOMENTS), at every quarter from the start to the end of the step, then the end again.
    """
    y, end_value, f = at[0].y, at[0].end, at[0].f
    for i in range(between.shape[0]):
        for index in abreast(MOMENTS):
            x = PLACES[index]
            u = 2.0 * x - 1.0
            total = f[i, STAGES - 1]
            for m in range(STAGES - 2, -1, -1):
                total = total * u + f[i, m]
            between[i, index] = y[i] + x * total
        for index in range(BETWEEN + 1, MOMENTS):
            between[i, index] = end_value[i]
