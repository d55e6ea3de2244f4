"""`check_laws`: runs the deciding case of a grid again under the other laws that are suitable for its joints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..answers.questions import LawResult, law_results
from ..answers.ranking import CaseRanking, ranking_of
from ..answers.verdict import EXCEEDED_COLUMN, UNDECIDED_COLUMN
from ..contracts.search import CaseResults, Found, Point, Search
from ..grid import Grid, leaves
from ..grid.keys import Word
from ..grid.sections import ADDED, Reader
from ..grid.written import MistakeError, WrittenValue
from ..language.errors import quoted

CHECK_LAWS = "check_laws"
_CHECKED_SUFFIXES = (".contact.elastic", ".contact.law")


@dataclass(frozen=True)
class CheckLaws(Search):
    """The key `check_laws`."""

    name: ClassVar[str] = CHECK_LAWS
    example: ClassVar[str] = "check_laws: true"
    answer_key: ClassVar[str] = "law_check"
    has_table: ClassVar[bool] = False
    judges: ClassVar[bool] = False
    refusal_of_shards: ClassVar[str] = "check_laws needs the worst of all cases; run the shards without it"
    laws: tuple[str, ...]  # paths of the laws that are checked

    @classmethod
    def schema(cls) -> dict[str, Any]:
        """Return the JSON Schema of the key."""
        text = "true: the deciding case runs again with each other elastic and contact law that is valid in its joints"
        added = {"type": "object", "additionalProperties": False, "properties": {ADDED: {"type": "object"}}}
        return {"description": text, "anyOf": [{"type": "boolean"}, added]}

    @classmethod
    def axes(cls, reader: Reader, root: WrittenValue) -> dict[str, tuple[WrittenValue, WrittenValue]]:
        """Record whether laws are checked: the key is true, or has the added cases as in run.json."""
        written = root.value.get(CHECK_LAWS) if isinstance(root.value, dict) else None
        if written is None or written.value is False:
            return {}
        is_added_section = isinstance(written.value, dict) and set(written.value) <= {ADDED}
        if written.value is not True and not is_added_section:
            raise MistakeError(written, CHECK_LAWS, f"found {quoted(written.value)}; expected true or false")
        for conflict in reader.searches:
            if conflict in root.value and conflict != CHECK_LAWS:
                message = (
                    f"conflicts with `{conflict}`, which adds cases, too; run its answer as a grid with `{CHECK_LAWS}`"
                )
                reader.problems.add(written, CHECK_LAWS, message)
        reader.search = cls(())
        return {}

    @classmethod
    def varies_word(cls, reader: Reader, path: str) -> bool:
        """Return whether other laws are tried at a path."""
        return isinstance(reader.search, cls) and path.endswith(_CHECKED_SUFFIXES)

    @classmethod
    def read(cls, reader: Reader, root: WrittenValue) -> "CheckLaws | None":
        """Return the key with the paths of the laws that are checked, or None if there are none."""
        laws = tuple(
            path
            for path, key in reader.keys_in_use.items()
            if isinstance(key, Word) and path.endswith(_CHECKED_SUFFIXES) and len(reader.axes.get(path, ())) == 1
        )
        return cls(laws) if isinstance(reader.search, cls) and laws else None

    def resolved(self) -> dict[str, Any]:
        """Return that the key is true."""
        return {}

    def result_columns(self, grid: Grid) -> list[str]:
        """Return the columns that rank the cases."""
        ranked = ranking_of(grid.layout, grid.verdict.limits).columns
        return [name for name in ranked if name not in (EXCEEDED_COLUMN, UNDECIDED_COLUMN)]

    def begin(self, grid: Grid, simulator: Any) -> "LawCheck":
        """Return the search at work."""
        return LawCheck(grid, self, simulator)


class LawCheck:
    """The search that adds these cases: one round, after all cases of the grid."""

    def __init__(self, grid: Grid, check: CheckLaws, simulator: Any):
        self.check, self.simulator, self.points, self.is_done = check, simulator, list[Point](), False
        self.ranking = ranking_of(grid.layout, grid.verdict.limits)

    def record(self, grid: Grid, first_index: int, results: CaseResults) -> None:
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
            variants = [point | {path: law} for law in laws if path in self.check.laws]
            self.points += [variant for variant in variants if _used_paths(grid, point) <= _used_paths(grid, variant)]

    def ask(self) -> Sequence[Point]:
        """Return the points of the deciding case under each other law; [] in every later round."""
        return self.points

    def result(self) -> Found:
        """Return the answer, which is in the rows of the summary."""
        return Found()


def _used_paths(grid: Grid, point: Point) -> set[str]:
    """Return the varied paths whose values the laws at a point use; some values have other names under these laws."""
    return point.keys() & dict(leaves(grid.case_tree(point))).keys()


class OwnRows:
    """Separates the cases that check laws from those of the grid, and keeps the results of these checks."""

    def __init__(self, record: Mapping[str, Any], ranking: CaseRanking):
        """Prepare from run.json and the ranking of the cases."""
        self.base, self.ranking = base_laws(record), ranking
        self.columns = tuple(self.base)  # of the summary
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

    def facts(self, deciding: Mapping[str, Any] | None) -> dict[str, Any] | None:
        """Return the results of the law checks and of the deciding case, or None if no check ran."""
        if not self.rows or deciding is None:
            return None
        figure = deciding["figures"][0]
        rows = [row._asdict() for row in self.rows]
        return {"case_id": deciding["case_id"], "column": figure["column"], "value": figure["value"], "rows": rows}


def base_laws(record: Mapping[str, Any]) -> dict[str, str]:
    """Return path -> law of the grid for the laws that a run checks, from its run.json; {} if it checks none."""
    if not record.get(CHECK_LAWS):
        return {}
    sweep = record.get("sweep") or {}
    return {path: laws[0] for path, laws in sweep.items() if path.endswith(_CHECKED_SUFFIXES) and len(laws) == 1}
