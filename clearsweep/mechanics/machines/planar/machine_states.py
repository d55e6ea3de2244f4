"""States of an ideal machine over a revolution of its crank, and their interpolation between stations."""

import math
from typing import NamedTuple

import numpy as np

from ....tracing.compiled.choosing import rolled_range
from ....tracing.compiled.family import Routine, shaped


class Inverses(NamedTuple):
    """The inverses of the derivatives of the constraints by the coordinates; states may share them."""

    matrices: np.ndarray  # (M, 3 bodies, rows)
    index: np.ndarray  # (N,) int64, matrix of each state

    def chosen(self, states: np.ndarray) -> "Inverses":
        """Return the inverses of some states (N,)."""
        return Inverses(self.matrices, self.index[states])

    def replaced(self, where: np.ndarray, others: "Inverses") -> "Inverses":
        """Return inverses of which those at a mask (N,) are `others`."""
        index = self.index.copy()
        index[where] = len(self.matrices) + others.index
        return Inverses(np.concatenate([self.matrices, others.matrices]), index)

    def multipliers(self, forces: np.ndarray) -> np.ndarray:
        """Return the multipliers (N, rows) of the constraints for forces (N, 3 bodies) on the bodies."""
        forces, out = np.require(forces, float, "CW"), np.empty_like(forces, order="C")
        _write_multipliers((np.array(self.matrices.shape[:2]), self.matrices, self.index, forces, out), len(forces))
        return out


def _multipliers(settings, matrices, index, forces, multipliers, count):
    """Multiply forces (count, n) by the transposed matrices (M, n, n) of an `index`; arrays are bare pointers.

    settings : (2,) int64, M and n
    """
    settings = shaped(settings, (2,))
    n = settings[1]
    matrices, index = shaped(matrices, (settings[0], n, n)), shaped(index, (count,))
    forces, multipliers = shaped(forces, (count, n)), shaped(multipliers, (count, n))
    for k in rolled_range(count):
        for row in rolled_range(n):
            multipliers[k, row] = 0.0
        for i in rolled_range(n):
            force = forces[k, i]
            for row in rolled_range(n):
                multipliers[k, row] += matrices[index[k], i, row] * force


_write_multipliers = Routine(_multipliers, "ififf")


class MachineStates(NamedTuple):
    """The ideal machine at N crank angles; q : x, y (m), angle (rad) of moving bodies."""

    angles: np.ndarray  # (N,) rad
    q: np.ndarray  # (N, 3 bodies)
    derivative: np.ndarray  # of q by the crank's angle
    second_derivative: np.ndarray
    inverse: Inverses | None = None  # of states that were closed


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
