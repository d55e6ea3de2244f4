"""The answer of a run: composed from its stored cases, and committed with its summary."""

from typing import Any

import numpy as np

from ..answers.compose import Source, compose
from ..answers.verdict import is_null
from ..searches import base_laws, search_of
from .blocks import sum_counts
from .dataset import BlockedRun, SampledRun
from .directory import RunDirectory
from .read import StoredRun

MOST_READ = 500_000  # cases whose columns are read; of more, a random part with the extreme cases is
FAILED_TO_SEPARATE = 1e-3  # relative difference of the depths of both bodies below which neither limits a life alone


def answer_of(run: StoredRun) -> dict[str, Any]:
    """Return the answer of a run, with its sentences; that of more than MOST_READ cases is not complete."""
    whole = run.whole if isinstance(run, SampledRun) else run
    is_cut = isinstance(whole, BlockedRun) and len(whole) > MOST_READ
    source = SampledRun(whole) if isinstance(whole, BlockedRun) and is_cut else whole
    counts = run.grid.get("counts") or {}
    is_complete = not (is_cut or counts.get("missing", 0) or run.grid.get("shard") or not run.grid.get("end"))

    def column(name: str) -> np.ndarray:
        parts = [block[name] for block in source.blocks([name])]
        values: np.ndarray = np.concatenate(parts) if parts else np.zeros(0, object)
        return values

    order = np.argsort(column("case_id"))  # blocks have an order of their own

    def read(name: str) -> np.ndarray:
        return column(name)[order]

    return compose(
        Source(
            run.grid,
            run.layout,
            read,
            base_laws(run.grid),
            is_complete,
            search_rows(run),
            _counts(whole) if is_cut else None,
            lambda case_id: _worn_body(whole, case_id),
        )
    )


def _counts(run: StoredRun) -> dict[str, int]:
    """Return the number of cases of a run in blocks with each verdict."""
    counts = [mark["counts"] for mark in run.marks()]
    limits, statuses = sum_counts(counts, "limits"), sum_counts(counts, "statuses")
    failed = sum(statuses.values()) - statuses["ok"]
    met = limits["cases"] - limits["any"] - limits["unknown"]
    return {"met": met, "exceeded": limits["any"], "undecided": limits["unknown"] + failed, "added": 0}


def search_rows(run: StoredRun) -> list[dict[str, Any]]:
    """Return the rows of the table of a search as plain values, if they are its answers."""
    search = search_of(run.grid)
    table = run.search_table(search.name) if search and search.rows_answer else None
    if table is None:
        return []
    rows = table.to_dict("records")
    return [{name: None if is_null(value) else value for name, value in row.items()} for row in rows]


def _worn_body(run: StoredRun, case_id: str) -> str:
    """Return the body whose wear limits a life: 'the pin' or 'the bush'; '' if neither alone does."""
    section, joint = run.grid.get("life") or {}, run.layout.life
    if section.get("of") != "wear_depth_max" or isinstance(run, BlockedRun):
        return ""
    bearing, journal = (float(np.nanmax(depth)) for depth in run.wear(case_id)[joint])
    if not abs(bearing - journal) > FAILED_TO_SEPARATE * max(bearing, journal):
        return ""
    return "its bearing limits" if bearing > journal else "its journal limits"


def commit_answer(directory: RunDirectory, run: StoredRun) -> None:
    """Write answer.json of a finished run in its locked directory; DamagedError for what no run writes.

    Of a run in blocks the samples are read, too, which the closing table needs.
    """
    if isinstance(run, BlockedRun):
        _ = run.samples
    directory.write_answer(answer_of(run))
