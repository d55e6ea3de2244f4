"""Committed cases compared with their limits, and the result files of searches."""

import io
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, UNDECIDED_COLUMN
from ..contracts.layout import Column
from . import durable
from .batch import ResultSchema, add_verdict_columns, summary_schema
from .columns import field_of, values_of
from .datasets import datasets
from .directory import IDENTIFY_FILE, OPTIMISE_FILE, SEEK_FILE, RunDirectory
from .orbits import OrbitFiles
from .summary import summary_groups


class CaseResults(NamedTuple):
    """Cases compared with their limits."""

    status: list[str]
    unmet: list[str]  # columns whose limits are exceeded or undecided, comma separated; '': all limits are met
    margins: dict[str, np.ndarray]  # by limited column; of a bound of 0 minus the excess, minus infinity if undecided
    columns: dict[str, np.ndarray]  # requested columns, NaN for null
    margin: np.ndarray  # of each case, as in the summary; NaN for null
    histories: tuple[dict[str, np.ndarray], ...] = ()  # requested channels of each case; empty for a failed case


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


def write_answers(
    run: RunDirectory, result_schema: ResultSchema, paths: Sequence[str], answers: Sequence[Any]
) -> dict[str, str]:
    """Write seek.parquet, a row for each answer (`searches.seeking.Answer`) on `paths`; remove it if there are none.

    Return the checksums of the answer files, by name, as run.json contains them.
    """
    file = run.path / SEEK_FILE
    with durable.storing(file):
        if not answers:
            durable.discard(file)
            return {}
        durable.replace(file, _answers_bytes(result_schema, paths, answers), run.scratch)
        return {file.name: durable.checksum(file)}


def write_best(
    run: RunDirectory, result_schema: ResultSchema, objectives: Sequence[str], best: Sequence[Any]
) -> dict[str, str]:
    """Write optimise.parquet, a row for each of the best cases; remove it if there are none.

    Each has the fields of `searches.optimising.Best`.  Return its checksum by name, as run.json contains it.
    """
    file = run.path / OPTIMISE_FILE
    with durable.storing(file):
        if not best:
            durable.discard(file)
            return {}
        units = {column.name: column.unit for column in result_schema.layout.columns}
        units |= {figure.name: figure.unit for figure in result_schema.verdict.figures}
        columns = [Column("case_id", "", "identity of the case", "text")]
        columns += [
            Column(axis.path, axis.unit, "its value", "text" if axis.text else "float") for axis in result_schema.axes
        ]
        columns += [Column(name, units[name], "objective") for name in objectives]
        columns += [
            Column("margin", "1", "smallest margin of its limits; null without limits"),
            Column("limiting", "", "the columns whose limits are exceeded, or the one nearest to its limit", "text"),
        ]
        values = [[case.case_id for case in best]]
        values += [[case.point[axis.path] for case in best] for axis in result_schema.axes]
        values += [[case.values.get(name) for case in best] for name in objectives]
        values += [[case.margin for case in best], [case.limiting for case in best]]
        durable.replace(file, _table_bytes(columns, values), run.scratch)
        return {file.name: durable.checksum(file)}


def write_sample(run: RunDirectory, result_schema: ResultSchema, sample: Mapping[str, np.ndarray]) -> dict[str, str]:
    """Write identify.parquet, a weighted sample of the swept keys; remove it if there are none.

    Return its checksum by name, as run.json contains it.
    """
    file = run.path / IDENTIFY_FILE
    with durable.storing(file):
        if not sample:
            durable.discard(file)
            return {}
        columns = [Column(axis.path, axis.unit, "value that it may have") for axis in result_schema.axes]
        columns += [Column("weight", "1", "probability of the row, 1 in all")]
        values = [sample[column.name].tolist() for column in columns]
        durable.replace(file, _table_bytes(columns, values), run.scratch)
        return {file.name: durable.checksum(file)}


def _answers_bytes(result_schema: ResultSchema, paths: Sequence[str], answers: Sequence[Any]) -> bytes:
    """Return seek.parquet; the columns' metadata hold `unit` and `description`."""
    unit = next(axis.unit for axis in result_schema.axes if axis.path == paths[0])
    columns = [
        Column(axis.path, axis.unit, "swept value", "text" if axis.text else "float")
        for axis in result_schema.axes
        if axis.path not in paths
    ]
    values = [[answer.point[column.name] for answer in answers] for column in columns]
    fits = any(answer.fits for answer in answers)
    columns += [
        *(Column(f"seek.{path}", unit, _VALUE_TEXT) for path in paths),
        *([Column("seek_fit", "", "the answer as a fit, assessed at its largest clearance", "text")] if fits else []),
        *([Column("seek_beyond", "", "fits beyond the border that meet the limits", "text")] if fits else []),
        Column("seek_low", unit, "lower end of the interval that contains the border"),
        Column("seek_high", unit, "upper end of the interval that contains the border"),
        Column("limiting", "", _LIMITING_TEXT, "text"),
        Column("probes", "1", "cases that the search used", "int"),
    ]
    values += [[answer.value for answer in answers]] * len(paths)
    if fits:
        values += [[answer.fit for answer in answers], [", ".join(answer.beyond) or None for answer in answers]]
    values += [[getattr(answer, name) for answer in answers] for name in ("low", "high", "limiting", "probes")]
    return _table_bytes(columns, values)


def _table_bytes(columns: Sequence[Column], values: Sequence[Sequence[Any]]) -> bytes:
    """Return a Parquet file of these columns, whose metadata hold `unit` and `description`."""
    fields = [field_of(column) for column in columns]
    arrays = [pa.array(value, field.type) for value, field in zip(values, fields, strict=True)]
    content = io.BytesIO()
    pq.write_table(pa.table(arrays, pa.schema(fields)), content, write_page_checksum=True)
    return content.getvalue()


_VALUE_TEXT = "the answer: this value and all tried values on its safe side meet the limits; null: none does"
_LIMITING_TEXT = (
    "column whose limit is exceeded first beyond the answer, or the status of a failed case there; null: none"
)
