"""The answer of a run in its closing lines: sentences that the report also has."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import grid as grids
from ..judging import answer, sampled
from ..judging.order import Lead
from ..judging.validity import THOUSAND_HOURS
from ..language import wording
from ..store import BlockedRun, SampledRun, StoredRun
from .law_checks import LawChecks
from .settings import grid_texts, number_of_joints, setting_text

SPREADS = 2  # limited figures of a sample whose spread is printed
MOST_READ = 500_000  # cases whose columns are read; 4 MB a column


class _Columns:
    """Columns of the finished cases of a grid, read on demand."""

    def __init__(self, run: StoredRun, checks: LawChecks):
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


def sentences(run: StoredRun, lead: Lead, checks: LawChecks, facts: dict[str, Any]) -> list[str]:
    """Return the answer to the question of a grid, [] for questions with lines of their own.

    Of a run in blocks with more than MOST_READ cases, only the sentences on extremes: its sample has their cases.
    facts : as for `setting_text`
    """
    if lead.question not in ("life", "limits", "film", "force") or not len(run):
        return []
    sample = SampledRun(run) if isinstance(run, BlockedRun) and len(run) > MOST_READ else None
    columns = _Columns(sample or run, checks)
    if not len(columns.rows):
        return []
    cases = _cases(run, lead, columns, facts)
    if sample:
        return [*answer.extremes(cases), *answer.wear(cases)]
    if sampled.is_one_sample(cases.record):
        return [*answer.sentences(cases), *_of_sample(cases)]
    return [*answer.sentences(cases), *answer.wear(cases)]


def _cases(run: StoredRun, lead: Lead, columns: _Columns, facts: dict[str, Any]) -> answer.Cases:
    units = {column.name: column.unit for column in run.layout.columns} | run.units

    def varies(path: str) -> bool:
        values = columns(path).tolist()
        return any(not wording.missing(value) and value != values[0] for value in values)

    def setting(index: int, paths: Sequence[str]) -> str:
        values = {path: columns(path)[index : index + 1].tolist()[0] for path in paths}
        return setting_text({path: None if wording.missing(value) else value for path, value in values.items()}, facts)

    checked = grids.base_laws(run.grid)
    axes = tuple(path for path in run.grid["units"] if path not in checked and varies(path))
    return answer.Cases(
        run.grid,
        run.layout,
        lead,
        axes,
        columns("case_id").tolist(),
        columns,
        lambda name, values: grid_texts(values, units.get(name, "1"), speed="speed" in name),
        setting,
    )


def _of_sample(cases: answer.Cases) -> list[str]:
    """Return what drives the first limited figure of a random sample, and the spread of limited figures and of wear."""
    limited = [name for name in cases.record.get("limits") or {} if cases.has(name)]
    names = {path: wording.axis_name(path, number_of_joints(cases.axes)) for path in cases.axes}
    drawn = {path: cases.column(path).astype(float) for path in names}
    lines = [sampled.causes(name, known, names) for name in limited[:1] if (known := _known(cases, drawn, name))]
    for name in limited[:SPREADS]:
        lines.append(_spread(cases, name, name, cases.column(name)))
    for joint in cases.layout.joints:
        rate, depth = f"{joint.name}_wear_rate_max", f"{joint.name}_wear_depth_max"
        if joint.wear_bins and cases.has(rate):
            lines.append(_spread(cases, f"{depth} per 1000 h", depth, THOUSAND_HOURS * cases.column(rate)))
    return lines


def _known(cases: answer.Cases, drawn: dict[str, np.ndarray], name: str) -> list:
    return sampled.correlations(drawn, cases.column(name).astype(float))


def _spread(cases: answer.Cases, name: str, column: str, values: np.ndarray) -> str:
    """Return the sentence on the spread of a figure."""
    ends = np.nanquantile(values[np.isfinite(values)], sampled.QUANTILES).tolist()
    return sampled.spread(name, cases.texts(column, ends))
