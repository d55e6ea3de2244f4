"""95 % intervals of figures from blocks of revolutions (batch means).

A figure is computed for blocks of equal numbers of revolutions, from the growth of its sums in each. Its interval is
Student's interval for the mean of the blocks. As a run grows, blocks are merged in pairs whenever there are more than
MAX_BLOCKS, which reduces their dependence. A remaining correlation between neighbours (lag 1, r if positive) widens
the interval by sqrt((1 + r) / (1 - r)), as for a first-order autoregressive process.
"""

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..mechanics.solver.integration import Work
from .figures.catalogue import column_of
from .window import by_joint

MIN_BLOCKS, MAX_BLOCKS = 8, 32  # blocks: fewer make the interval unreliable, more do not improve it


class Interval(NamedTuple):
    """Mean of a figure over the blocks, and its interval."""

    value: float
    half_width: float  # half-width of the 95 % interval, in the unit of the figure; inf for fewer than two blocks
    blocks: int

    def within(self, relative: float) -> bool:
        """Return whether the half-width is at most `relative` times the value; False for too few blocks."""
        return self.blocks >= MIN_BLOCKS and self.half_width <= relative * abs(self.value)


class Blocks:
    """Sums of some figures of a scene at the ends of the blocks of a run."""

    def __init__(self, layout: Layout, figures: Iterable[str]):
        self.layout = layout
        self.figures = {name: column_of(layout, name) for name in figures}
        # time (s) and figure -> its sums, at the start of the first block and the end of every one
        self.sums_at_ends: list[tuple[float, dict[str, Any]]] = []
        self.turns, self.stride = 0, 1  # revolutions recorded, and revolutions in a block

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
            return Interval(math.nan, math.inf, 0)
        times = np.array([time for time, _ in self.sums_at_ends])
        sums = self.figures[name][0].sums
        value, half_width = sums.over_blocks(
            times, [sums_at_end[name] for _, sums_at_end in self.sums_at_ends], self.stride
        )
        return Interval(float(value), float(half_width), len(times) - 1)
