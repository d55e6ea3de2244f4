"""How well a run has settled its figures: 95 % intervals from blocks of revolutions.

A figure is taken over blocks of equally many revolutions, from what its sums grow by in each; Student's interval of the
mean of the blocks is that of the figure.  As a run grows, two blocks are made one whenever there are more than MOST, so
that what is left of their dependence fades; what shows of it between neighbours (lag 1, if positive) widens the
interval by sqrt((1 + r) / (1 - r)), as for a first-order autoregressive process.
"""

import math
from typing import NamedTuple

import numpy as np

from ..mechanics.observe import tally as tallies

LEAST, MOST = 8, 32  # blocks: with fewer the interval itself is a guess; with more they need be no shorter
CONFIDENCE = 0.95
EXCEEDED = 0.01  # share of the time during which a force is above its p99
STRONGEST = 0.9  # correlation allowed for


class Interval(NamedTuple):
    """A figure over the blocks, and its interval."""

    value: float
    half_width: float  # of the 95 % interval, in the unit of the figure; inf from fewer than two blocks
    blocks: int

    def within(self, relative: float) -> bool:
        """Return whether the interval is narrower than this share of the value to either side."""
        return self.blocks >= LEAST and self.half_width <= relative * abs(self.value)


class Blocks:
    """What some figures of a scene sum up to, at the ends of the blocks of a run that is under way."""

    def __init__(self, layout, figures):
        self.sums = {name: _sums(layout, name) for name in figures}
        self.ends = []  # (time in s, figure -> its sums) at the start of the first block and the end of every one
        self.turns, self.stride = 0, 1  # revolutions noted, and those of a block

    def note(self, work) -> bool:
        """Take down the sums at the end of a revolution of a run (event.Work); return whether a block ends here."""
        ends = self.turns % self.stride == 0
        self.turns += 1
        if ends:
            held = {name: take(work.tally) for name, (take, _) in self.sums.items()}
            self.ends.append((float(work.y[work.time]), held))
            if len(self.ends) > MOST + 1:
                del self.ends[1::2]
                self.stride *= 2
        return ends

    def interval(self, name: str) -> Interval:
        """Return a figure over all blocks, and its interval."""
        if len(self.ends) < 2:
            return Interval(math.nan, math.inf, 0)
        times = np.array([time for time, _ in self.ends])
        value, half_width = self.sums[name][1](times, [held[name] for _, held in self.ends], self.stride)
        return Interval(float(value), float(half_width), len(times) - 1)


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
    together = min(max(float(off[1:] @ off[:-1]) / squares, 0.0), STRONGEST)
    widened = (1.0 + together) / (1.0 - together)
    return float(stdtrit(count - 1, 0.5 + 0.5 * CONFIDENCE)) * math.sqrt(squares / (count * (count - 1)) * widened)


def _sums(layout, name: str) -> tuple:
    """Return what to take of a Tally for a figure, and how the figure and its interval follow from that.

    The latter is called with the times (s) at the ends of the blocks, what was taken there, and the revolutions of one.
    """
    if name == "slider_acceleration_rms":
        return (lambda tally: tally.whole[tallies.ACCELERATION_SQUARE]), _root_mean
    place, figure = next(
        (place, name.removeprefix(f"{part.name}_"))
        for place, part in enumerate(layout.joints)
        if name.startswith(f"{part.name}_")
    )
    if figure == "force_p99":
        return (lambda tally: (tally.time[place].copy(), tally.ramp[place].copy())), _force_exceeded
    if figure == "wear_rate_max":
        return (lambda tally: tally.wear.reshape(len(layout.joints), -1)[place].copy()), _deepest
    column, settle = _COLUMNS[figure]
    return (lambda tally: tally.joint[place, column]), settle


def _mean(times, sums, _revolutions):
    """Return a mean over time."""
    return (sums[-1] - sums[0]) / (times[-1] - times[0]), half_width(np.diff(sums) / np.diff(times))


def _root_mean(times, sums, _revolutions):
    """Return a root mean square; its interval follows from that of the square."""
    square, width = _mean(times, sums, _revolutions)
    value = math.sqrt(square)
    return value, 0.5 * width / value if value else 0.0


def _per_revolution(_times, sums, revolutions):
    """Return a mean over revolutions."""
    return (sums[-1] - sums[0]) / (revolutions * (len(sums) - 1)), half_width(np.diff(sums) / revolutions)


def _deepest(times, depths, _revolutions):
    """Return how fast the deepest bin (of either body) wears."""
    bin_ = int(np.argmax(depths[-1] - depths[0]))
    return _mean(times, [depth[bin_] for depth in depths], _revolutions)


def _force_exceeded(times, histograms, _revolutions):
    """Return the force that is exceeded during EXCEEDED of the time.

    Its interval is that of the share of time above it, block by block, read as forces (Woodruff 1952).
    """
    time, ramp = histograms[-1][0] - histograms[0][0], histograms[-1][1] - histograms[0][1]
    duration = times[-1] - times[0]

    def force(share):
        return tallies.force_exceeded(time, ramp, min(max(share, 0.0), 1.0) * duration)

    value = force(EXCEEDED)
    above = np.array([_time_above(value, time, ramp) for time, ramp in histograms])
    width = half_width(np.diff(above) / np.diff(times))
    return value, 0.5 * (force(EXCEEDED - width) - force(EXCEEDED + width))


def _time_above(force: float, time: np.ndarray, ramp: np.ndarray) -> float:
    """Return the time (s) at a higher force than `force` (N) in a histogram."""
    bins = np.max(np.flatnonzero((time != 0.0) | (ramp != 0.0)), initial=-1) + 1
    spent = time[:bins] + np.cumsum(ramp[:bins]) * np.diff(tallies.EDGES[: bins + 1])
    place = int(np.searchsorted(tallies.EDGES, force, side="right")) - 1
    if place < 0 or place >= bins:
        return float(spent.sum()) if place < 0 else 0.0
    low, high = tallies.EDGES[place], tallies.EDGES[place + 1]
    return float(spent[place + 1 :].sum() + spent[place] * (high - force) / (high - low))


_COLUMNS = {
    "force_rms": (tallies.FORCE_SQUARE, _root_mean),
    "impacts_per_rev": (tallies.ONSETS, _per_revolution),
    "contact_fraction": (tallies.CONTACT_TIME, _mean),
    "law_limit_fraction": (tallies.BEYOND_TIME, _mean),
}
