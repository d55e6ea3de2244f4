"""Counts on the page of a run: always of all cases, even if the page shows a sample."""

from collections import Counter
from typing import NamedTuple

import numpy as np

from ...answers.verdict import Limit
from ...store import sum_counts
from ..blocks.section import Note, Section
from ..data.study import Study

#: Sections with counts of all cases, and their other contents; sections without counts have no note.
_NOTES = {
    "verdict": "Counts include all cases. Maps and shares come from the sample, {}.",
    "failures": "The numbers include all cases. The list contains those of the sample, {}.",
    "trust": "Counts of failed cases, and of those beyond the range of a law, include all cases. "
    "The rest comes from the sample, {}.",
    "mechanism": "",
    "setup": "",
}


class LimitCounts(NamedTuple):
    """Counts of finished cases by limits."""

    cases: int
    exceeding: int  # at least one limit
    unknown: int  # cases among them without the figure of a limit
    by_limit: list[tuple[int, int]]  # for each limit: cases that exceed it, and cases among them without its figure


def finished_and_failed(study: Study) -> tuple[int, int]:
    """Return the numbers of finished and of failed cases."""
    marks = study.run.marks()
    if not marks:
        return len(study.cases), len(study.failed)
    return sum(mark["ok"] for mark in marks), sum(mark["failed"] for mark in marks)


def failures_by_status(study: Study) -> Counter[str]:
    """Return the number of failed cases by status."""
    if study.run.marks():
        statuses = _summed(study, "statuses")
        del statuses["ok"]
        return statuses
    return Counter({str(status): int(number) for status, number in study.failed["status"].value_counts().items()})


def limit_counts(study: Study) -> LimitCounts:
    """Return the counts of finished cases that meet the limits of the grid."""
    if study.run.marks():
        total, fails, unjudged = (_summed(study, part) for part in ("limits", "fails", "unjudged"))
        exceeding_and_unknown = [
            (fails[str(limit_index)], unjudged[str(limit_index)]) for limit_index in range(len(study.limits))
        ]
        return LimitCounts(total["cases"], total["any"], total["unknown"], exceeding_and_unknown)
    if not study.limits:
        return LimitCounts(len(study.cases), 0, 0, [])
    columns_by_limit = [limit_columns(study, limit) for limit in study.limits]
    is_exceeding, is_undecided = (
        [getattr(limit, method)(values) for limit, values in zip(study.limits, columns_by_limit, strict=True)]
        for method in ("is_exceeded", "is_undecided")
    )
    return LimitCounts(
        len(study.cases),
        int(np.any(is_exceeding, axis=0).sum()),
        int(np.any(is_undecided, axis=0).sum()),
        [
            (int(cases.sum()), int(exceeding_and_unknown.sum()))
            for cases, exceeding_and_unknown in zip(is_exceeding, is_undecided, strict=True)
        ],
    )


def remark_counts(study: Study) -> Counter[str] | None:
    """Return the counts of remarks on all cases, with their number under `cases`; None if the page shows all cases."""
    return _summed(study, "remarks") if study.run.marks() else None


def limit_columns(study: Study, limit: Limit) -> dict[str, np.ndarray]:
    """Return the columns that a limit uses."""
    return {name: study.cases[name].to_numpy(float) for name in (limit.column, limit.times) if name}


def with_note(study: Study, section: Section) -> Section:
    """Return a section with a note on the cases that its counts cover, if the page shows a sample."""
    if not section.title or not study.run.marks():
        return section
    shown = f"{len(study.cases) + len(study.failed):,} of {sum(finished_and_failed(study)):,} cases"
    text = _NOTES.get(section.key, "Counts and shares come from the sample, {}.").format(shown)
    return section._replace(blocks=[Note(text), *section.blocks]) if text else section


def _summed(study: Study, part: str) -> Counter[str]:
    return sum_counts([mark["counts"] for mark in study.run.marks()], part)
