"""The finished cases of an unfinished run, as a separate run to read."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import clearsweep

from ..grid import Grid
from ..grid.sections.variations import VARYING_SECTIONS
from ..language.errors import DirectoryError
from ..searches import SEARCHES, search_of
from .assemble import merge
from .batch import ResultSchema, open_table
from .directory import RunDirectory
from .record import read_record, utc_now


def _searches() -> list[str]:
    return [search.name for search in SEARCHES]


def is_unfinished(directory: Path) -> bool:
    """Return whether the run in a directory is unfinished; raise DirectoryError if there is none."""
    return "merged" not in read_record(directory)


def keys_so_far(record: Mapping[str, Any], source: RunDirectory) -> dict[str, Any]:
    """Return the keys of a grid of the finished cases: those of run.json, unless the run adds cases."""
    if search_of(record):
        return keys_of_all(record, source)
    return {key: record[key] for key in record["keys"]}


def keys_of_all(record: Mapping[str, Any], source: RunDirectory) -> dict[str, Any]:
    """Return the keys of a grid of all cases in a directory: their values as axes if possible, else case by case."""
    unvaried = {key: record[key] for key in record["keys"] if key not in (*VARYING_SECTIONS, *_searches())}
    paths = list(record["units"])  # in the order of the columns
    if not paths:
        return unvaried
    columns: dict[str, list[Any]] = {path: [] for path in paths}
    for batch in source.batches:
        with open_table(batch.summary) as table:
            rows = table.read(paths, use_threads=False)
        for path in paths:
            columns[path] += rows.column(path).to_pylist()
    swept = {path: record.get("sweep", {}).get(path, []) for path in paths}
    axes = {path: list(dict.fromkeys(_present([*swept[path], *columns[path]]))) for path in paths}
    if (
        "sweep" in record
        and not {*VARYING_SECTIONS[1:], *_searches()} & record.keys()
        and math.prod(map(len, axes.values())) < 1_000_000
    ):
        return unvaried | {"sweep": axes}
    different = dict.fromkeys(zip(*columns.values(), strict=True))
    return unvaried | {"cases": dict(zip(columns, map(list, zip(*different, strict=True)), strict=True))}


def _present(values: list[Any]) -> list[Any]:
    """Return the values that are not None, numbers in ascending order."""
    values_in_use = [value for value in values if value is not None]
    return values_in_use if any(isinstance(value, str) for value in values_in_use) else sorted(values_in_use)


def check_version(directory: Path, record: Mapping[str, Any], grid: Grid) -> None:
    """Raise DirectoryError if this version would give the cases of a run other columns."""
    stored_names, version = [column["name"] for column in record["layout"]["columns"]], record.get("model_version")
    if stored_names != [column.name for column in grid.layout.columns] or version != clearsweep.MODEL_VERSION:
        raise DirectoryError(
            f"{directory}: another version wrote its cases (model version {version}, this one has "
            f"{clearsweep.MODEL_VERSION}), so they cannot be combined; use that version"
        )


def gather(source: RunDirectory, grid: Grid, requested: np.ndarray, path: Path) -> None:
    """Write the `requested` cases (identities, ascending) of a directory to `path`, a new directory, as a run.

    The batches are not moved.  Peak revolutions are left out, since they would have to be computed.
    """
    record, target, result_schema = read_record(source.path), RunDirectory(path), ResultSchema.of(grid)
    with target.open_for(grid):
        target.batches = source.batches
        rows = target.rows()
        rows = rows[np.isin(rows["id"], requested)]
        failed = int(np.count_nonzero(rows["failed"]))
        cases = max(record.get("counts", {}).get("cases", 0), len(rows))  # for a shard, its own cases
        counts = {"cases": cases, "ok": len(rows) - failed, "failed": failed, "missing": cases - len(rows)}
        merged = merge(target, result_schema, rows)
        facts = {key: record[key] for key in ("source", "start", "derived", "warnings", "shard") if key in record}
        target.write_record(grid, **facts, end=utc_now(), counts=counts, merged=merged)
