"""How figures follow from sums along the motion: over the whole window, and over its blocks, with an interval.

Each kind has three functions.  `take(tally, place)` returns what has been summed so far, of a joint or, where `place`
is None, of the mechanism; `value(window, place)` the figure over the window; `over_blocks(times, sums, revolutions)`
the figure over all blocks and the half-width of its 95 % interval, from the times (s) at the ends of the blocks, what
was taken there, and the revolutions of a block.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.observe import histogram
from ..mechanics.observe.tally import Tally
from .spread import CONFIDENCE, dependence
from .window import RARELY, Summed, Window


def half_width(values: np.ndarray) -> float:
    """Return half the width of the 95 % interval of the mean of what follows each other."""
    from scipy.special import stdtrit

    count = len(values)
    if count < 2:
        return math.inf
    off = values - values.mean()
    squares = float(off @ off)
    if squares == 0.0:
        return 0.0
    variance = squares / (count * (count - 1)) * dependence(values)
    return float(stdtrit(count - 1, 0.5 + 0.5 * CONFIDENCE)) * math.sqrt(variance)


def _sum(tally: Tally | Summed, place: int | None, column: int) -> Any:
    return tally.whole[column] if place is None else tally.joint[place, column]


def _mean(times: np.ndarray, sums: Sequence[Any]) -> tuple[float, float]:
    """Return a mean over time, and its half-width."""
    return (sums[-1] - sums[0]) / (times[-1] - times[0]), half_width(np.diff(sums) / np.diff(times))


class Mean(NamedTuple):
    """A mean over time, from an integral over time."""

    column: int  # of Tally.joint or Tally.whole

    def take(self, tally: Tally | Summed, place: int | None) -> Any:
        """Return the integral."""
        return _sum(tally, place, self.column)

    def value(self, window: Window, place: int | None) -> Any:
        """Return the mean over the window."""
        return self.take(window.tally, place) / window.duration

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the mean and its half-width."""
        return _mean(times, sums)


class RootMean(NamedTuple):
    """A root mean square, from the integral of the square over time."""

    column: int  # of Tally.joint or Tally.whole

    def take(self, tally: Tally | Summed, place: int | None) -> Any:
        """Return the integral of the square."""
        return _sum(tally, place, self.column)

    def value(self, window: Window, place: int | None) -> Any:
        """Return the root mean square over the window."""
        return math.sqrt(self.take(window.tally, place) / window.duration)

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the root mean square; its half-width follows from that of the square."""
        square, width = _mean(times, sums)
        value = math.sqrt(square)
        return value, 0.5 * width / value if value else 0.0


class PerRevolution(NamedTuple):
    """A mean over revolutions, from a count."""

    column: int  # of Tally.joint or Tally.whole

    def take(self, tally: Tally | Summed, place: int | None) -> Any:
        """Return the count."""
        return _sum(tally, place, self.column)

    def value(self, window: Window, place: int | None) -> Any:
        """Return the mean over the window's revolutions."""
        return self.take(window.tally, place) / window.turns

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the mean over revolutions and its half-width."""
        return (sums[-1] - sums[0]) / (revolutions * (len(sums) - 1)), half_width(np.diff(sums) / revolutions)


class DepthRate(NamedTuple):
    """How fast the deepest wear bin of a joint, of either body, wears (m/s)."""

    def take(self, tally: Tally | Summed, place: int | None) -> Any:
        """Return the depths (m) of all bins of both bodies."""
        return tally.wear.reshape(len(tally.joint), -1)[place].copy()

    def value(self, window: Window, place: int | None) -> Any:
        """Return the largest depth over the window's time."""
        return self.take(window.tally, place).max() / window.duration

    def over_blocks(self, times: np.ndarray, depths: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the rate of the bin that is deepest in the end, and its half-width."""
        deepest = int(np.argmax(depths[-1] - depths[0]))
        return _mean(times, [depth[deepest] for depth in depths])


class ForceExceeded(NamedTuple):
    """The normal force (N) of a joint that is exceeded during RARELY of the time."""

    def take(self, tally: Tally, place: int | None) -> Any:
        """Return the joint's histogram of the force over time."""
        return tally.histogram[place].copy()

    def value(self, window: Window, place: int) -> Any:
        """Return the force over the window."""
        return window.exceeded[place]

    def over_blocks(self, times: np.ndarray, histograms: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the force and its half-width.

        Its interval is that of the share of time above it, block by block, read as forces (Woodruff 1952).
        """
        whole, duration = histograms[-1] - histograms[0], times[-1] - times[0]

        def force(share: float) -> float:
            return float(histogram.force_exceeded(whole, min(max(share, 0.0), 1.0) * duration))

        value = force(RARELY)
        above = np.array([_time_above(value, each) for each in histograms])
        width = half_width(np.diff(above) / np.diff(times))
        return value, 0.5 * (force(RARELY - width) - force(RARELY + width))


def _time_above(force: float, filled: np.ndarray) -> float:
    """Return the time (s) at a higher force than `force` (N) in a histogram, (BINS, 2)."""
    bins = np.max(np.flatnonzero(filled.any(axis=1)), initial=-1) + 1
    time, change = filled[:bins].T
    spent = time + (np.cumsum(change) - change) * np.diff(histogram.EDGES[: bins + 1])
    place = int(np.searchsorted(histogram.EDGES, force, side="right")) - 1
    if place < 0 or place >= bins:
        return float(spent.sum()) if place < 0 else 0.0
    low, high = histogram.EDGES[place], histogram.EDGES[place + 1]
    return float(spent[place + 1 :].sum() + spent[place] * (high - force) / (high - low))
