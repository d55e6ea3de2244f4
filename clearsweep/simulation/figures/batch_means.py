"""95 % intervals of figures from blocks of revolutions (batch means).

A figure is computed for blocks of equal numbers of revolutions, from the growth of its sums in each. Its interval is
that of the mean of the blocks, see `sums.half_width`. As a run grows, blocks are merged in pairs whenever there are
more than MAX_BLOCKS, which reduces their dependence. In a periodic motion every block is a period.

A figure that is the same in all blocks is not known for that reason: the event that changes it may still come. Its
interval is that of what was not observed.
"""

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ...contracts.layout import Layout
from ...mechanics.solver.integration import Work
from .catalogue import column_of
from .window import by_joint

MIN_REVOLUTIONS = 30  # fewer revolutions of a chaotic motion make the interval unreliable
MAX_BLOCKS = 32  # more do not improve the interval
UNOBSERVED = 3.0  # divided by the revolutions: upper end of the 95 % interval of the rate of an unobserved event
EQUAL_TOLERANCE = 1e-9  # relative: figures of blocks that differ by less, the rounding of their sums, are equal


class Interval(NamedTuple):
    """Mean of a figure over the blocks, and its interval."""

    value: float
    half_width: float  # half-width of the 95 % interval, in the unit of the figure; inf if unknown
    blocks: int
    revolutions: int  # in all blocks

    def within(self, relative: float) -> bool:
        """Return whether the half-width is at most `relative` times the value."""
        return self.half_width <= relative * abs(self.value)


class Blocks:
    """Sums of some figures of a scene at the ends of the blocks of a run."""

    def __init__(self, layout: Layout, figures: Iterable[str], period: int | None = None):
        """Prepare for the start of a window; `period` : revolutions of a periodic motion, whose blocks are periods."""
        self.layout = layout
        self.figures = {name: column_of(layout, name) for name in figures}
        # time (s) and figure -> its sums, at the start of the first block and the end of every one
        self.sums_at_ends: list[tuple[float, dict[str, Any]]] = []
        self.turns, self.stride = 0, period or 1  # revolutions recorded, and revolutions in a block
        self.period = period

    def record(self, work: Work) -> bool:
        """Record the sums at the end of a revolution of a run (integration.Work); return whether a block ends here."""
        is_block_end = self.turns % self.stride == 0
        self.turns += 1
        if is_block_end:
            contact_totals: Any = work.totals  # mypy takes it for a tuple of anything
            totals = by_joint(contact_totals, self.layout)
            sums = {name: figure.sums.take(totals, index) for name, (figure, index) in self.figures.items()}
            self.sums_at_ends.append((float(work.y[work.time]), sums))
            if len(self.sums_at_ends) > MAX_BLOCKS + 1:
                del self.sums_at_ends[1::2]
                self.stride *= 2
        return is_block_end

    def interval(self, name: str) -> Interval:
        """Return the mean of a figure over all blocks, and its interval."""
        if len(self.sums_at_ends) < 2:
            return Interval(math.nan, math.inf, 0, 0)
        times = np.array([time for time, _ in self.sums_at_ends])
        figure, _ = self.figures[name]
        value, half_width = figure.sums.over_blocks(
            times, [sums_at_end[name] for _, sums_at_end in self.sums_at_ends], self.stride
        )
        blocks = len(times) - 1
        revolutions = blocks * self.stride
        if self.period is None and half_width <= EQUAL_TOLERANCE * abs(value):
            half_width = _half_width_of_equal_blocks(figure.unit, revolutions)
        return Interval(float(value), float(half_width), blocks, revolutions)


def _half_width_of_equal_blocks(unit: str, revolutions: int) -> float:
    """Return the half-width of the interval of a figure that was the same in every revolution.

    An event of probability p in each revolution is not observed in n of them with the probability (1 - p)^n, which is
    5 % at p = 3 / n (rule of three: Hanley & Lippman-Hand 1983, JAMA 249:1743). It changes a count per revolution or a
    share of the time, of unit 1, by about one; by how much it changes a force or a wear rate is unknown.
    """
    return UNOBSERVED / revolutions if unit == "1" else math.inf
