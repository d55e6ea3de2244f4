"""An ideal machine over a turn of its crank, interpolated between the angles at which it was closed."""

import math
from typing import NamedTuple

import numpy as np


class Turn(NamedTuple):
    """The ideal machine at one or N crank angles; q : x, y (m), angle (rad) of moving bodies."""

    angles: np.ndarray  # () or (N,) rad
    q: np.ndarray  # (..., 3 bodies)
    first: np.ndarray  # derivative by the crank's angle
    second: np.ndarray


def between(turn: Turn, angles: np.ndarray) -> Turn:
    """Return a machine at crank angles (N,) from its Turn, by quintic interpolation between stations."""
    step = 2.0 * math.pi / (len(turn.angles) - 1)
    total = np.floor((angles - turn.angles[0]) / (2.0 * math.pi))
    position = (angles - turn.angles[0] - 2.0 * math.pi * total) / step
    k = np.minimum(position.astype(int), len(turn.angles) - 2)
    t = (position - k)[:, None]
    f0, d0, s0, f1, d1, s1 = (array[k + i] for i in (0, 1) for array in (turn.q, turn.first, turn.second))
    d0, d1, s0, s1 = step * d0, step * d1, step * step * s0, step * step * s1
    value_defect, slope_defect, curvature_defect = f1 - f0 - d0 - 0.5 * s0, d1 - d0 - s0, s1 - s0
    a, b, c = (
        10 * value_defect - 4 * slope_defect + 0.5 * curvature_defect,
        -15 * value_defect + 7 * slope_defect - curvature_defect,
        6 * value_defect - 3 * slope_defect + 0.5 * curvature_defect,
    )
    winding = winding_of(turn)
    q = f0 + t * (d0 + t * (0.5 * s0 + t * (a + t * (b + t * c)))) + total[:, None] * winding
    slope = (d0 + t * (s0 + t * (3 * a + t * (4 * b + t * 5 * c)))) / step
    return Turn(angles, q, slope, (s0 + t * (6 * a + t * (12 * b + t * 20 * c))) / step**2)


def winding_of(turn: Turn) -> np.ndarray:
    """Return the growth of the coordinates with each turn; only angles of rotating bodies grow."""
    winding: np.ndarray = turn.q[-1] - turn.q[0]
    winding[0::3] = winding[1::3] = 0.0
    return winding
