"""Fatigue: rainflow cycles of a history, and the damage that they do."""

import math

import numpy as np

END_POINTS = 3  # turning points between which the last two ranges lie


class Rainflow:
    """Rainflow counting of a history that comes in pieces: the rules of ASTM E1049-85, section 5.4.4.

    A range that the next one covers is a full cycle, or half a cycle if it begins at the first turning point that is
    left.  What is left at the end counts as half cycles.
    """

    def __init__(self) -> None:
        self._points: list[float] = []  # turning points that are left, the last of them not yet known to be one

    def add(self, values: np.ndarray) -> np.ndarray:
        """Return the cycles (n, 2) that `values`, the next part of the history, close: range and count, 1 or 0.5."""
        closed: list[tuple[float, float]] = []
        for value in turning_points(np.asarray(values)).tolist():
            self._append(value, closed)
        return np.array(closed).reshape(-1, 2)

    def _append(self, value: float, closed: list[tuple[float, float]]) -> None:
        """Add a value; put the cycles that it closes to `closed`."""
        points = self._points
        if len(points) >= 2 and (value - points[-1]) * (points[-1] - points[-2]) >= 0.0:
            points.pop()  # the last point was no turning point
        elif points == [value]:
            return
        points.append(value)
        while len(points) >= END_POINTS and abs(points[-1] - points[-2]) >= abs(points[-2] - points[-3]):
            closed.append((abs(points[-2] - points[-3]), 0.5 if len(points) == END_POINTS else 1.0))
            if len(points) == END_POINTS:
                del points[0]
            else:
                del points[-3:-1]

    def left(self) -> np.ndarray:
        """Return the half cycles (n, 2) of the turning points that are left: range and count."""
        ranges = np.abs(np.diff(self._points))
        return np.stack([ranges, np.full(len(ranges), 0.5)], -1)


def turning_points(values: np.ndarray) -> np.ndarray:
    """Return the first value of a history (n,), those where it turns, and the last one."""
    values = values[np.append(True, np.diff(values) != 0.0)] if len(values) else values
    if len(values) < END_POINTS:
        return values
    slopes = np.sign(np.diff(values))
    points: np.ndarray = values[np.concatenate([[True], slopes[1:] != slopes[:-1], [True]])]
    return points


def damage(cycles: np.ndarray, strength: float, exponent: float, life: float) -> float:
    """Return the share of a life that cycles (n, 2), ranges (Pa) and counts, use up: the sum of Palmgren and Miner.

    A stress amplitude S breaks after `life` (strength / S)^exponent cycles, whatever the mean stress.
    """
    ranges, counts = cycles.T
    return math.fsum(counts * (0.5 * ranges / strength) ** exponent) / life
