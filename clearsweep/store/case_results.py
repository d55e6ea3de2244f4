"""Committed cases compared with their limits, and the tables of searches."""

import io
from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, UNDECIDED_COLUMN
from ..contracts.layout import Column
from ..contracts.search import CaseResults, Found, SearchTable
from . import durable
from .batch import ResultSchema, add_verdict_columns, summary_schema
from .columns import field_of, values_of
from .datasets import datasets
from .directory import ANSWER_FILES, RunDirectory
from .orbits import OrbitFiles
from .summary import summary_groups


def read_results(
    run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray, names: Sequence[str] = ()
) -> CaseResults:
    """Return committed cases (ROWS) compared with the limits of their grid, and the columns with these names."""
    status: list[str] = []
    unmet: list[str] = []
    requested: dict[str, list[np.ndarray]] = {name: [] for name in names}
    case_margins: list[np.ndarray] = []
    margins: dict[str, list[np.ndarray]] = {limit.column: [] for limit in result_schema.verdict.limits}
    for group in summary_groups(run, summary_schema(result_schema), rows):
        table = add_verdict_columns(result_schema.verdict, group)
        status += table["status"].to_pylist()
        unmet += _unmet_columns(table) if result_schema.verdict.limits else [""] * len(table)
        if result_schema.verdict.limits:
            case_margins.append(np.asarray(values_of(table[MARGIN_COLUMN].combine_chunks()), float))
        for name in names:
            requested[name].append(np.asarray(values_of(table[name].combine_chunks()), float))
        limited_columns = {
            name for limit in result_schema.verdict.limits for name in (limit.column, limit.times) if name
        }
        columns = {name: values_of(table[name].combine_chunks()) for name in limited_columns}
        group_margins: dict[str, np.ndarray] = {}
        for limit in result_schema.verdict.limits:
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
        for dataset in datasets(result_schema):
            if dataset.path in names:
                extents = orbits.extents(dataset.item, dataset.width, rows)
                for channels, number, start, count in zip(results, rows["batch"].tolist(), *extents, strict=True):
                    content = orbits.read(number, dataset, int(start), int(count))
                    channels[dataset.path] = np.frombuffer(content, dataset.dtype)
    return results


def write_search_table(
    run: RunDirectory, result_schema: ResultSchema, name: str, found: Found | None
) -> dict[str, str]:
    """Write the table of the search called `name`, and remove those of other searches.

    found : its answer; None if it has none yet
    Return the checksum of the table by name, as run.json contains it.
    """
    units = {column.name: column.unit for column in result_schema.layout.columns}
    units |= {figure.name: figure.unit for figure in result_schema.verdict.figures}
    axes = [Column(axis.path, axis.unit, "", "text" if axis.text else "float") for axis in result_schema.axes]
    table = found.table(axes, units) if found else None
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
