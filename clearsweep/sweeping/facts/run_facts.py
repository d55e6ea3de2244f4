"""Counts of the cases of a run and its extreme cases; counts of blocks add up."""

import functools
import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...answers import validity
from ...answers.questions import largest_expected_peak, required_columns
from ...answers.ranking import ranking_of
from ...answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, UNDECIDED_COLUMN, limits_and_figures_of, units_of
from ...answers.words import case_margin_text
from ...contracts.layout import Layout
from ...searches import own_rows
from ...store import StoredRun, sum_counts
from .lives import LifeExtremes
from .slowest_case import SlowestCase
from .worst_cases import WorstCases

LISTED_FAILURES = 3  # number of cases with each status


class RunFacts:
    """Facts for the summary table of a run, collected some rows at a time."""

    def __init__(self, record: Mapping[str, Any], layout: Layout):
        """Prepare from run.json and the layout."""
        joints = [joint.name for joint in layout.joints]
        self.failures: list[dict[str, Any]] = []
        self.statuses: Counter[str] = Counter()
        self.remarks, self.limits = validity.Remarks(joints), _LimitCounts(record)
        self.lives, self.slowest_case = LifeExtremes(layout, record.get("life") or {}), SlowestCase(record, layout)
        self.ranking = ranking_of(layout, self.limits.verdict.limits, record)
        self.own = own_rows(record, self.ranking)
        self.swept = [path for path in record["units"] if path not in self.own.columns]
        self.worst = WorstCases(self.ranking, joints, self.limits.verdict.limits)
        self.expected: dict[str, Any] | None = None  # the largest force peak to expect in many revolutions
        self._joints = joints
        columns = ["status", *record["units"], *self.worst.columns]
        columns += validity.required_columns(joints, {column.name for column in layout.columns})
        columns += [name for name in required_columns(joints) if name in {column.name for column in layout.columns}]
        self.columns = list(
            dict.fromkeys([*columns, *self.limits.columns, *self.lives.columns, *self.slowest_case.columns])
        )

    def read(self, run: StoredRun) -> None:
        """Add a run; of a run in blocks, the extreme rows of its blocks and the sums of their counts."""
        for block in run.sample_and_extremes(self.columns):
            self.add(block)
        if marks := run.marks():
            self._replace_counts([mark["counts"] for mark in marks])

    def add(self, block: dict[str, np.ndarray]) -> None:
        """Add some cases, with at least the columns of `required_columns`."""
        is_ok, is_of_grid = block["status"] == "ok", self.own.of_grid(block)
        if not is_of_grid.all():
            self.own.add({name: values[is_ok & ~is_of_grid] for name, values in block.items()})
        for index in np.flatnonzero(~is_ok).tolist():
            status = block["status"][index]
            self.statuses[status] += 1
            if sum(entry["status"] == status for entry in self.failures) < LISTED_FAILURES:
                description = _case_description(block, index, self.swept)
                self.failures.append(description | {"status": status, "message": block["message"][index]})
        if is_ok.any():
            self.statuses["ok"] += int(np.count_nonzero(is_ok))
            is_counted = is_ok & is_of_grid
            finished = block if is_counted.all() else {name: values[is_counted] for name, values in block.items()}
            self.remarks.add(finished)
            self.limits.add(finished, self.swept)
            describe = functools.partial(_case_description, finished, swept=self.swept)
            self.lives.add(finished, describe)
            self.slowest_case.add(finished, describe)
            self.worst.add(finished, describe)
            largest = largest_expected_peak(finished, self._joints)
            if largest and (self.expected is None or largest.value > self.expected["value"]):
                index = finished["case_id"].tolist().index(largest.case_id)
                self.expected = largest._asdict() | describe(index)

    def case_ids(self) -> set[str]:
        """Return the identities of the cases in the facts so far."""
        entries = [
            *self.failures,
            *self.worst.entries,
            *self.lives.extremes.values(),
            self.slowest_case.slowest,
            self.limits.worst,
        ]
        case_ids = {entry["case_id"] for entry in entries if entry}
        return case_ids | self.remarks.case_ids()

    def counts(self) -> dict[str, Any]:
        """Return the counts for JSON."""
        return {
            "statuses": dict(self.statuses),
            "remarks": {"cases": self.remarks.cases, **self.remarks.counts},
            "limits": {"cases": self.limits.cases, "any": self.limits.any, "unknown": self.limits.any_unknown},
            "exceeded": dict(self.limits.exceeded),
            "unknown": dict(self.limits.unknown),
            "fails": dict(self.limits.fails),
            "unjudged": dict(self.limits.unjudged),
            "unreached": self.lives.unreached,
        }

    def _replace_counts(self, counts: list[dict[str, Any]]) -> None:
        """Replace the counts of the rows read by the sums over all blocks."""
        limits, self.statuses = sum_counts(counts, "limits"), sum_counts(counts, "statuses")
        self.limits.exceeded, self.limits.unknown = sum_counts(counts, "exceeded"), sum_counts(counts, "unknown")
        self.limits.cases, self.limits.any, self.limits.any_unknown = limits["cases"], limits["any"], limits["unknown"]
        self.remarks.replace_counts(sum_counts(counts, "remarks"))
        self.lives.unreached = sum(count["unreached"] for count in counts)


class _LimitCounts:
    """How many cases meet the limits of a grid, as `run` reports it."""

    def __init__(self, record: Mapping[str, Any]):
        self.verdict = limits_and_figures_of(record)
        self.units = units_of(record)
        limited = {name for limit in self.verdict.limits for name in (limit.column, limit.times) if name}
        self.columns = [EXCEEDED_COLUMN, UNDECIDED_COLUMN, MARGIN_COLUMN, *sorted(limited)] if limited else []
        self.cases = 0
        self.exceeded: Counter[str] = Counter()  # column -> number of cases beyond its limit
        self.unknown: Counter[str] = Counter()  # column -> number of cases whose limit is undecided
        self.fails: Counter[str] = Counter()  # index of a limit -> number of cases beyond it
        self.unjudged: Counter[str] = Counter()  # index of a limit -> number of cases that leave it undecided
        self.any = self.any_unknown = 0
        self.worst: dict[str, Any] | None = None  # the case with the smallest margin

    def add(self, block: dict[str, np.ndarray], swept: list[str]) -> None:
        """Add some finished cases."""
        if not self.columns:
            return
        self.cases += len(block["status"])
        self.any += sum(map(bool, block[EXCEEDED_COLUMN]))
        self.any_unknown += sum(
            bool(undecided) and not exceeded
            for exceeded, undecided in zip(block[EXCEEDED_COLUMN], block[UNDECIDED_COLUMN], strict=True)
        )
        for counter, column in ((self.exceeded, EXCEEDED_COLUMN), (self.unknown, UNDECIDED_COLUMN)):
            counter.update(name for names in block[column] if names for name in names.split(","))
        for index, limit in enumerate(self.verdict.limits):
            self.fails[str(index)] += int(np.count_nonzero(limit.is_exceeded(block)))
            self.unjudged[str(index)] += int(np.count_nonzero(limit.is_undecided(block)))
        margins = block[MARGIN_COLUMN]
        if np.isfinite(margins).any():
            index = int(np.nanargmin(margins))
            margin = float(margins[index])
            if self.worst is None or (margin, block["case_id"][index]) < (self.worst["margin"], self.worst["case_id"]):
                words = case_margin_text(margin, self.verdict.limits, block[EXCEEDED_COLUMN][index] or "")
                self.worst = _case_description(block, index, swept) | {"margin": margin, "margin_words": words}

    def facts(self) -> dict[str, Any] | None:
        """Return the counts for JSON, or None if there are no limits."""
        if not self.columns:
            return None
        bounds: dict[str, list[str]] = {limit.column: [] for limit in self.verdict.limits}
        for limit in self.verdict.limits:
            bounds[limit.column].append(limit.bound_text(self.units.get(limit.column, "1")))
        return {
            "cases": self.cases,
            "exceeding": self.any,
            "unknown": self.any_unknown,
            "each": {
                name: {"limit": ", ".join(text), "cases": self.exceeded[name], "unknown": self.unknown[name]}
                for name, text in bounds.items()
            },
            "worst": self.worst,
        }


def _case_description(block: dict[str, np.ndarray], index: int, swept: list[str]) -> dict[str, Any]:
    """Return the description of the case at an index of a block; None for values that it does not use."""
    values = {path: block[path][index : index + 1].tolist()[0] for path in swept}
    in_use = {path: None if isinstance(value, float) and math.isnan(value) else value for path, value in values.items()}
    return {"case_id": block["case_id"][index], "swept": in_use}
