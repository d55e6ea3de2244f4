"""Runs the deciding case of a grid again under the other laws that are suitable for its joints (`check_laws`)."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .. import store
from ..answers.questions import LawResult, law_results
from ..answers.ranking import CaseRanking, ranking_of
from ..answers.verdict import EXCEEDED_COLUMN, UNDECIDED_COLUMN
from ..grid import Grid, leaves
from ..sweeping.pool.worker import Simulator
from .adaptive import Point


class LawCheckSearch:
    """The search that adds these cases: one round, after all cases of the grid."""

    def __init__(self, grid: Grid, simulator: Simulator):
        self.simulator, self.points, self.is_done = simulator, list[Point](), False
        self.ranking = ranking_of(grid.layout, grid.verdict.limits)

    def learn(self, grid: Grid, first_index: int, results: store.CaseResults) -> None:
        """Find the worst case of the grid, which decides, and the other laws that are suitable for its joints."""
        if self.is_done or not self.ranking.candidates or not len(results.status):
            self.points = []
            return
        self.is_done = True
        columns = results.columns | dict.fromkeys((EXCEEDED_COLUMN, UNDECIDED_COLUMN), np.array(results.unmet, object))
        values, _ = self.ranking.worst_values(columns)
        severity = self.ranking.severity(values, columns)
        if np.isneginf(severity).all():
            return
        index = first_index + int(np.flatnonzero(severity == severity.max())[-1])
        point, case = grid.point(index), grid.case(index)
        for path, laws in self.simulator.alternatives(case).items():
            variants = [point | {path: law} for law in laws if path in grid.checked_laws]
            self.points += [variant for variant in variants if _used_paths(grid, point) <= _used_paths(grid, variant)]

    def next_points(self) -> Sequence[Point]:
        """Return the points of the deciding case under each other law; [] in every later round."""
        return self.points


def _used_paths(grid: Grid, point: Point) -> set[str]:
    """Return the varied paths whose values the laws at a point use; some values have other names under these laws."""
    return point.keys() & dict(leaves(grid.case_tree(point))).keys()


class LawCheckResults:
    """Separates the cases that check laws from those of the grid, and keeps the results of these checks."""

    def __init__(self, base: dict[str, str], ranking: CaseRanking):
        """Prepare with the law of the grid by path (`base`, {} if no law is checked) and the ranking of the cases."""
        self.base, self.ranking = base, ranking
        self.rows: list[LawResult] = []

    def of_grid(self, block: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return a mask of the cases of a block that belong to the grid and do not check a law."""
        is_of_grid = np.ones(len(block["status"]), bool)
        for path, law in self.base.items():
            is_of_grid &= np.array([value is None or value == law for value in block[path].tolist()], bool)
        return is_of_grid

    def add(self, block: Mapping[str, np.ndarray]) -> None:
        """Add the finished cases of a block that check laws."""
        self.rows += law_results(block, self.base, self.ranking)

    def facts(self, deciding: dict[str, Any] | None) -> dict[str, Any] | None:
        """Return the results of the law checks and of the deciding case, or None if no check ran.

        deciding : entry of the deciding case in the summary table
        """
        if not self.rows or deciding is None:
            return None
        figure = deciding["figures"][0]
        rows = [row._asdict() for row in self.rows]
        return {"case_id": deciding["case_id"], "column": figure["column"], "value": figure["value"], "rows": rows}
