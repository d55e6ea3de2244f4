"""Writes `summary.parquet`: the rows of all batches in case_id order, in bounded memory."""

import contextlib
import itertools
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from . import durable
from .batch import GROUP_ROWS, ResultSchema, add_verdict_columns, read_summary, summary_schema
from .columns import array_of, field_of
from .directory import RunDirectory

ROWS_IN_MEMORY = 4096  # rows in memory at a time, from whole batches: so the memory of a merge does not grow


def write_summary(
    path: Path,
    run: RunDirectory,
    result_schema: ResultSchema,
    rows: np.ndarray,
    content_hash: str,
    on_group: Callable[[pa.Table, int], None] = lambda *_: None,
) -> None:
    """Write the given rows of the summary; `on_group` receives every group and the number of rows before it."""
    schema = summary_schema(result_schema)
    verdict_fields = [field_of(column) for column in result_schema.verdict.columns]
    full_schema = pa.schema([*schema, *verdict_fields], {"clearsweep": content_hash})
    with (
        os.fdopen(durable.create_file(path), "wb") as file,
        pq.ParquetWriter(
            file, full_schema, write_page_checksum=True, use_dictionary=repetitive_columns(full_schema)
        ) as writer,
    ):
        for number, group in enumerate(summary_groups(run, schema, rows)):
            table = add_verdict_columns(result_schema.verdict, group)
            on_group(table, number * GROUP_ROWS)
            writer.write_table(table.replace_schema_metadata(full_schema.metadata))


def repetitive_columns(schema: pa.Schema) -> list[str]:
    """Return the columns with few distinct values; building dictionaries of the others takes most of the time."""
    return [field.name for field in schema if field.type == pa.string() and field.name != "case_id"]


def summary_groups(run: RunDirectory, schema: pa.Schema, rows: np.ndarray) -> Iterator[pa.Table]:
    """Yield the given rows of the summary, GROUP_ROWS at a time; every batch is read once.

    Up to ROWS_IN_MEMORY rows are kept in memory.  Otherwise rows of a few batches at a time are sorted into an unnamed
    file, and each group is merged from these files.  They have Arrow's stream format, since its file format is read in
    advance by other threads (see `batch.open_table`).
    """
    row_sets = indices_by_value((np.cumsum(np.bincount(rows["batch"]))[rows["batch"]] - 1) // ROWS_IN_MEMORY)
    if len(row_sets) < 2:
        yield from _groups(*_rows_of_batches(run, schema, rows), schema)
        return
    group_bounds = np.arange(0, len(rows) + GROUP_ROWS, GROUP_ROWS)
    with contextlib.ExitStack() as files:
        sorted_rows = []
        for positions in row_sets:
            file = files.enter_context(tempfile.TemporaryFile(dir=run.scratch if run.scratch.is_dir() else None))
            bounds = np.searchsorted(positions, group_bounds)
            columns, order = _rows_of_batches(run, schema, rows[positions])
            with pa.ipc.new_stream(file, schema) as writer:
                in_memory = list(columns)
                for first, last in itertools.pairwise(bounds.tolist()):
                    positions_in_batches = _index_array(order[first:last])
                    writer.write_batch(
                        pa.RecordBatch.from_arrays(
                            [column.take(positions_in_batches) for column in in_memory], schema=schema
                        )
                    )
            file.seek(0)
            sorted_rows.append((positions, bounds, pa.ipc.open_stream(file)))
        for k in range(len(group_bounds) - 1):
            group = pa.Table.from_batches([reader.read_next_batch() for *_, reader in sorted_rows], schema)
            order = np.argsort(
                np.concatenate([positions[bounds[k] : bounds[k + 1]] for positions, bounds, _ in sorted_rows])
            )
            yield group.take(_index_array(order)).combine_chunks()


def _groups(columns: Iterable[pa.Array], order: np.ndarray, schema: pa.Schema) -> Iterator[pa.Table]:
    """Yield rows in an order, GROUP_ROWS at a time."""
    positions = _index_array(order)
    # column by column: one of them fits into the processor's cache, all of them do not
    ordered = pa.Table.from_arrays([column.take(positions) for column in columns], schema=schema)
    for first in range(0, len(order), GROUP_ROWS):
        yield ordered.slice(first, GROUP_ROWS)


def indices_by_value(numbers: np.ndarray) -> list[np.ndarray]:
    """Return the indices of equal values, ascending, for each distinct value; the values are small."""
    if not len(numbers):
        return []
    narrow = np.ascontiguousarray(numbers, "u2" if numbers.max() < 2**16 else "u4")  # of two bytes: sorted by counting
    order = np.argsort(narrow, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(narrow[order])) + 1)


def _rows_of_batches(run: RunDirectory, schema: pa.Schema, rows: np.ndarray) -> tuple[Iterator[pa.Array], np.ndarray]:
    """Return the columns of all batches with the given rows of the summary, and where each row is in them.

    A column is put together, and its parts are released, when it is asked for.
    """
    tables, starts, count = [], np.zeros(len(run.batches), int), 0
    for number in np.flatnonzero(np.bincount(rows["batch"])).tolist():
        batch = run.batches[number]
        table = read_summary(batch.summary, schema.names)
        selected = table.select(schema.names)
        tables.append((selected if selected.schema.equals(schema) else selected.cast(schema)).columns)
        starts[number], count = count, count + len(table)
    return _join_columns(tables, schema), starts[rows["batch"]] + rows["row"]


def _join_columns(tables: list[list[pa.ChunkedArray]], schema: pa.Schema) -> Iterator[pa.Array]:
    """Yield the columns of some tables, one below the other; the parts of a column are released with it."""
    for number, field in enumerate(schema, 1):
        chunks = (part for table in tables for part in table.pop(0).chunks)
        yield pa.chunked_array(chunks, field.type).combine_chunks()
        if number % 4 == 0:  # now and then, as it takes 1 ms
            pa.default_memory_pool().release_unused()  # the parts are small: malloc would keep the gaps they leave


def _index_array(values: np.ndarray) -> pa.Array:
    return array_of([None, np.ascontiguousarray(values, "i8")], pa.int64(), len(values))
