"""The answer of a run in its last lines: sentences that the report also has."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .. import grid as grids
from ..answers import advice, answer, sampled, wear
from ..answers.case_ranking import CONTENT_QUESTIONS, CaseRanking
from ..answers.cases import FinishedCases, column_texts
from ..answers.verdict import units_of
from ..language import wording
from ..store import BlockedRun, SampledRun, StoredRun
from .law_checks import LawCheckResults
from .settings import setting_name, value_text

MOST_READ = 500_000  # cases whose columns are read; 4 MB a column


class _Columns:
    """Columns of the finished cases of a grid, read on demand."""

    def __init__(self, run: StoredRun, checks: LawCheckResults):
        self.run, self.known = run, dict[str, np.ndarray]()
        block = {name: self._all(name) for name in ("case_id", "status", *checks.base)}
        rows = np.flatnonzero((block["status"] == "ok") & checks.of_grid(block))
        self.rows = rows[np.argsort(block["case_id"][rows])]  # as in one piece; blocks have an order of their own

    def _all(self, name: str) -> np.ndarray:
        return np.concatenate([block[name] for block in self.run.blocks([name])])

    def __call__(self, name: str) -> np.ndarray:
        """Return a column of the finished cases."""
        if name not in self.known:
            self.known[name] = self._all(name)[self.rows]
        return self.known[name]


class Answer(NamedTuple):
    """What the last lines of a run say on the question of its grid."""

    sentences: list[str]
    no_limits: str = ""  # suggested limit for a grid without limits, or ''


def of_run(run: StoredRun, ranking: CaseRanking, checks: LawCheckResults, facts: dict[str, Any]) -> Answer:
    """Return the answer to the question of a grid; it is empty if the question has last lines of its own.

    For a run in blocks with more than MOST_READ cases, only the sentences on extremes are returned, since its sample
    contains the extreme cases.
    facts : as for `setting_text`
    """
    if ranking.question not in ("life", "limits", *CONTENT_QUESTIONS) or not len(run):
        return Answer([])
    sample = SampledRun(run) if isinstance(run, BlockedRun) and len(run) > MOST_READ else None
    columns = _Columns(sample or run, checks)
    if not len(columns.rows):
        return Answer([])
    cases = _cases(run, ranking, columns, facts)
    cases = cases._replace(is_complete=sample is None)
    worn = [] if sampled.is_one_sample(cases.record) else wear.sentences(cases)
    answer_sentences = answer.extreme_sentences(cases) if sample else answer.sentences(cases)
    return Answer(
        [*answer_sentences, *worn], advice.suggest_limit(cases) if ranking.question in CONTENT_QUESTIONS else ""
    )


def _cases(run: StoredRun, ranking: CaseRanking, columns: _Columns, facts: dict[str, Any]) -> FinishedCases:
    units = {column.name: column.unit for column in run.layout.columns} | units_of(run.grid)

    def varies(path: str) -> bool:
        values = columns(path).tolist()
        return any(not wording.is_missing(value) and value != values[0] for value in values)

    def describe_value(index: int, path: str) -> tuple[str, str] | None:
        value = columns(path)[index : index + 1].tolist()[0]
        if wording.is_missing(value):
            return None
        return setting_name(path, varied_paths, facts), value_text(path, value, facts)

    def texts(name: str, values: Sequence[float]) -> list[str]:
        return column_texts(name, units.get(name, "1"), columns(name), values)

    checked = grids.base_laws(run.grid)
    varied_paths = tuple(path for path in run.grid["units"] if path not in checked and varies(path))
    return FinishedCases(
        run.grid, run.layout, ranking, varied_paths, columns("case_id").tolist(), columns, texts, describe_value
    )
