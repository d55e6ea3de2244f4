"""States of an ideal machine over a revolution of its crank, and their interpolation between stations."""

import math
from typing import NamedTuple

import numpy as np


class MachineStates(NamedTuple):
    """The ideal machine at one or N crank angles; q : x, y (m), angle (rad) of moving bodies."""

    angles: np.ndarray  # () or (N,) rad
    q: np.ndarray  # (..., 3 bodies)
    derivative: np.ndarray  # of q by the crank's angle
    second_derivative: np.ndarray


def interpolate(stations: MachineStates, angles: np.ndarray) -> MachineStates:
    """Return the states at crank angles (N,) rad by quintic interpolation between those at stations."""
    step = 2.0 * math.pi / (len(stations.angles) - 1)
    revolutions = np.floor((angles - stations.angles[0]) / (2.0 * math.pi))
    position = (angles - stations.angles[0] - 2.0 * math.pi * revolutions) / step
    index = np.minimum(position.astype(int), len(stations.angles) - 2)
    t = (position - index)[:, None]
    f0, d0, s0, f1, d1, s1 = (
        array[index + i] for i in (0, 1) for array in (stations.q, stations.derivative, stations.second_derivative)
    )
    d0, d1, s0, s1 = step * d0, step * d1, step * step * s0, step * step * s1
    value_defect, slope_defect, curvature_defect = f1 - f0 - d0 - 0.5 * s0, d1 - d0 - s0, s1 - s0
    a, b, c = (
        10 * value_defect - 4 * slope_defect + 0.5 * curvature_defect,
        -15 * value_defect + 7 * slope_defect - curvature_defect,
        6 * value_defect - 3 * slope_defect + 0.5 * curvature_defect,
    )
    growth = growth_per_revolution(stations)
    q = f0 + t * (d0 + t * (0.5 * s0 + t * (a + t * (b + t * c)))) + revolutions[:, None] * growth
    slope = (d0 + t * (s0 + t * (3 * a + t * (4 * b + t * 5 * c)))) / step
    return MachineStates(angles, q, slope, (s0 + t * (6 * a + t * (12 * b + t * 20 * c))) / step**2)


def growth_per_revolution(stations: MachineStates) -> np.ndarray:
    """Return the growth of the coordinates in each revolution; only angles of rotating bodies grow."""
    growth: np.ndarray = stations.q[-1] - stations.q[0]
    growth[0::3] = growth[1::3] = 0.0
    return growth
