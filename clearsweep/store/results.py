"""Committed cases compared with their limits or another directory, gathered as a run, and the answers of a run."""

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import clearsweep

from ..answers.compose import Source, compose
from ..answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, UNDECIDED_COLUMN
from ..contracts.layout import Column
from ..contracts.results import TIMINGS
from ..contracts.search import CaseResults, Found, SearchTable
from ..grid import Grid
from ..grid.sections.variations import VARYING_SECTIONS
from ..language.errors import DirectoryError
from ..language.wording import is_missing
from ..searches import SEARCHES, base_laws, search_of
from . import durable
from .batch import GROUP_ROWS, ResultSchema, add_verdict_columns, open_table, summary_schema
from .blocks import sum_counts
from .dataset import BlockedRun, SampledRun
from .datasets import datasets, field_of, id_text, id_texts, values_of
from .directory import ANSWER_FILES, RunDirectory
from .merged import OrbitFiles, merge, summary_groups
from .read import StoredRun
from .record import read_record, utc_now

# ----------------------------------------------------------------------------------------------------------------------
# Committed cases compared with their limits, and the tables of searches.


def read_results(
    run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray, names: Sequence[str] = ()
) -> CaseResults:
    """Return committed cases (ROWS) compared with the limits of their grid, and the columns with these names."""
    status: list[str] = []
    unmet: list[str] = []
    requested: dict[str, list[np.ndarray]] = {name: [] for name in names}
    case_margins: list[np.ndarray] = []
    limits = result_schema.verdict.limits
    margins: dict[str, list[np.ndarray]] = {limit.column: [] for limit in limits}
    limited_columns = {name for limit in limits for name in limit.required_columns}
    for group in summary_groups(run, summary_schema(result_schema), rows):
        table = add_verdict_columns(result_schema.verdict, group)
        status += table["status"].to_pylist()
        unmet += _unmet_columns(table) if limits else [""] * len(table)
        if limits:
            case_margins.append(np.asarray(values_of(table[MARGIN_COLUMN].combine_chunks()), float))
        for name in names:
            requested[name].append(np.asarray(values_of(table[name].combine_chunks()), float))
        columns = {name: values_of(table[name].combine_chunks()) for name in limited_columns}
        group_margins: dict[str, np.ndarray] = {}
        for limit in limits:
            margin = limit.margin(columns)
            margin = np.where(np.isnan(margin), -limit.excess(columns), margin) if limit.value == 0.0 else margin
            is_unmet = limit.is_exceeded(columns) | limit.is_undecided(columns)
            margin = np.where(np.isnan(margin) & is_unmet, -np.inf, margin)
            group_margins[limit.column] = np.fmin(group_margins.get(limit.column, np.inf), margin)
        for name, values in group_margins.items():
            margins[name].append(values)
    margin = np.concatenate([[], *case_margins]) if case_margins else np.full(len(status), np.nan)
    return CaseResults(status, unmet, _concatenate_groups(margins), _concatenate_groups(requested), margin)


def _unmet_columns(table: pa.Table) -> list[str]:
    """Return the columns whose limits each case exceeds or leaves undecided, comma separated."""
    names = zip(table[EXCEEDED_COLUMN].to_pylist(), table[UNDECIDED_COLUMN].to_pylist(), strict=True)
    return [",".join(dict.fromkeys(name for part in pair if part for name in part.split(","))) for pair in names]


def _concatenate_groups(arrays: Mapping[str, Sequence[np.ndarray]]) -> dict[str, np.ndarray]:
    """Return name -> the values of all row groups."""
    return {name: np.concatenate([[], *groups]) for name, groups in arrays.items()}


def read_histories(
    run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray, names: Sequence[str]
) -> list[dict[str, np.ndarray]]:
    """Return channels of committed cases (ROWS), case by case."""
    results: list[dict[str, np.ndarray]] = [{} for _ in rows]
    with OrbitFiles(run, result_schema) as orbits:
        for dataset in datasets(result_schema.stored):
            if dataset.path in names:
                extents = orbits.extents(dataset.item, dataset.width, rows)
                for channels, number, start, count in zip(results, rows["batch"].tolist(), *extents, strict=True):
                    content = orbits.read(number, dataset, int(start), int(count))
                    channels[dataset.path] = np.frombuffer(content, dataset.dtype)
    return results


def write_search_table(
    run: RunDirectory, result_schema: ResultSchema, name: str, search_result: Found | None
) -> dict[str, str]:
    """Write the table of the search called `name`, and remove those of other searches.

    search_result : its answer; None if it has none yet
    Return the checksum of the table by name, as run.json contains it.
    """
    units = {column.name: column.unit for column in result_schema.layout.columns}
    units |= {figure.name: figure.unit for figure in result_schema.verdict.figures}
    axes = [Column(axis.path, axis.unit, "", "text" if axis.text else "float") for axis in result_schema.axes]
    table = search_result.table(axes, units) if search_result else None
    for file in (run.path / file for file in ANSWER_FILES):
        with durable.storing(file):
            if table is None or file.stem != name:
                durable.discard(file)
            else:
                durable.replace(file, _table_bytes(table), run.scratch)
                checksums = {file.name: durable.checksum(file)}
    return checksums if table else {}


def _table_bytes(table: SearchTable) -> bytes:
    """Return a Parquet file of these columns, whose metadata hold `unit` and `description`."""
    fields = [field_of(column) for column in table.columns]
    arrays = [pa.array(value, field.type) for value, field in zip(table.values, fields, strict=True)]
    content = io.BytesIO()
    pq.write_table(pa.table(arrays, pa.schema(fields)), content, write_page_checksum=True)
    return content.getvalue()


# ----------------------------------------------------------------------------------------------------------------------
# Compares the results of the same cases in two directories.


Difference = tuple[str, str, Any, Any]  # case_id, name of a column or dataset, value here, value there


def difference(
    result_schema: ResultSchema,
    first: RunDirectory,
    first_rows: np.ndarray,
    second: RunDirectory,
    second_rows: np.ndarray,
) -> Difference | None:
    """Return the first difference of two directories, or None.

    `first_rows` and `second_rows` (ROWS) locate the same cases in the same order.  Timings are ignored.
    """
    names = [np.array([batch.name for batch in run.batches], "S") for run in (first, second)]
    is_different = names[0][first_rows["batch"]] != names[1][second_rows["batch"]]  # batches are named by their content
    sides = ((first, first_rows[is_different]), (second, second_rows[is_different]))
    return _summary_difference(result_schema, sides) or _orbits_difference(result_schema, sides)


#: Both directories, each with the rows (ROWS) of the same cases in the same order.
Sides = tuple[tuple[RunDirectory, np.ndarray], tuple[RunDirectory, np.ndarray]]


def _summary_difference(result_schema: ResultSchema, sides: Sides) -> Difference | None:
    schema, ids = summary_schema(result_schema), sides[0][1]["id"]
    groups = (summary_groups(run, schema, rows) for run, rows in sides)
    for number, tables in enumerate(zip(*groups, strict=True)):
        for name in schema.names:
            if name in TIMINGS or tables[0][name].equals(tables[1][name]):
                continue
            pairs = zip(*(table[name].to_pylist() for table in tables), strict=True)
            offset, (first_value, second_value) = next((k, pair) for k, pair in enumerate(pairs) if pair[0] != pair[1])
            return id_text(int(ids[number * GROUP_ROWS + offset])), name, first_value, second_value
    return None


def _orbits_difference(result_schema: ResultSchema, sides: Sides) -> Difference | None:
    (first, first_rows), (second, second_rows) = sides
    with OrbitFiles(first, result_schema) as first_orbits, OrbitFiles(second, result_schema) as second_orbits:
        located = ((first_orbits, first_rows), (second_orbits, second_rows))
        for dataset in datasets(result_schema.stored):
            extents = [orbits.extents(dataset.item, dataset.width, rows) for orbits, rows in located]
            for k, case_id in enumerate(first_rows["id"].tolist()):
                values = [
                    orbits.read(int(rows["batch"][k]), dataset, int(starts[k]), int(count[k]))
                    for (orbits, rows), (starts, count) in zip(located, extents, strict=True)
                ]
                if values[0] != values[1]:
                    first_size, second_size = (f"{len(value):,} bytes" for value in values)
                    return id_text(case_id), dataset.path, first_size, second_size
    return None


# ----------------------------------------------------------------------------------------------------------------------
# The finished cases of an unfinished run, as a separate run to read.


_SEARCHES = [search.name for search in SEARCHES]


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
    unvaried = {key: record[key] for key in record["keys"] if key not in (*VARYING_SECTIONS, *_SEARCHES)}
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
    is_product = "sweep" in record and not {*VARYING_SECTIONS[1:], *_SEARCHES} & record.keys()
    if is_product and math.prod(map(len, axes.values())) < 1_000_000:
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


# ----------------------------------------------------------------------------------------------------------------------
# The answer of a run: composed from its stored cases, and committed with its summary.


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
        if name == "case_id" and not isinstance(source, SampledRun):  # as texts they take five times the memory
            return id_texts(np.concatenate([part.ids for part in source.parts]))
        return source.column(name)

    # blocks have an order of their own
    order = np.argsort(column("case_id")) if isinstance(whole, BlockedRun) else slice(None)

    return compose(
        Source(
            run.grid,
            run.layout,
            lambda name: column(name)[order],
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
    return [{name: None if is_missing(value) else value for name, value in row.items()} for row in rows]


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
