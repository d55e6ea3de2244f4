"""Adds cases to a running sweep, round by round: the results of a round decide which cases come next.

Added cases are ordinary cases.  So stored ones are not run again, and the same results lead to the same
cases however often the run was interrupted.
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from .. import store
from ..grid import Grid

Point = dict[str, Any]  # dotted path -> value
#: Runs the missing cases of a grid and returns results from an index on, or None if it was stopped.
ReadResults = Callable[[Grid, int], store.CaseResults | None]


class Search(Protocol):
    """A search that chooses the next cases."""

    def learn(self, grid: Grid, first_index: int, results: store.CaseResults) -> None:
        """Record how the cases of a grid, from the index `first_index` on, compare with its limits."""

    def next_points(self) -> Sequence[Point]:
        """Return the points of the next cases; none if no more are needed."""


def run(grid: Grid, search: Search, read_results: ReadResults) -> tuple[Grid, bool]:
    """Run a grid and the cases that a search adds; return the extended grid, and whether it completed."""
    grid, begin = grid.without_added(), 0
    while results := read_results(grid, begin):
        search.learn(grid, begin, results)
        begin = len(grid)
        points = search.next_points()
        if not points:
            return grid, True
        grid = grid.with_added(points)
    return grid, False
