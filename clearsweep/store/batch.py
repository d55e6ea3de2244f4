"""Schema of results: columns of the summary, datasets of the orbits, and the two files of a batch of cases."""

import contextlib
import ctypes
import hashlib
import io
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..answers.verdict import LimitsAndFigures
from ..contracts import results
from ..contracts.layout import Column, Layout
from ..grid import CaseLabels, Grid
from ..language.errors import error_line
from . import durable
from .datasets import (
    CASE_ID,
    EVENT,
    ID_LENGTH,
    LARGEST,
    NODE,
    SAMPLE,
    SECTION,
    Dataset,
    Hdf5,
    Stored,
    column_of,
    datasets,
    field_of,
    h5py,
    ids_of_texts,
    is_plausible,
    largest_of,
    offset_datasets,
    values_of,
    words_of,
)
from .record import MisshapenError, check_facts, kind_of_axis

COLUMNS_AT_ONCE = 16  # of the summary of a batch that is checked
GROUP_ROWS = 2048  # rows of a group of the summary, and of what is worked at in one go
ORBITS, SUMMARIES = "shards", "parts"  # folders of a run directory; their names predate the present terms
DATASET_BYTES = 4096  # bytes of a file for the description of a dataset, more than HDF5 needs
MAX_ROWS = 2**17  # cases of a batch, as many as of a block
LARGE_BLOCK = 2**17  # bytes of a block of memory that is not kept for reuse
_MMAP_THRESHOLD = -3  # of malloc.h
HASH_LENGTH = 16  # hexadecimal digits of a checksum in a name
_VERIFIED: Any = {"pre_buffer": False, "page_checksum_verification": True}  # options of a reader of Parquet
_NAME = re.compile(r"[0-9a-f]{16}-([0-9a-f]{16})\.(h5|parquet)")


class Axis(NamedTuple):
    """One swept path: a column of numbers in `unit`, or of words."""

    path: str
    unit: str
    text: bool | None  # None: not known
    labels: str = ""  # JSON of label -> value, SI; '' for none


class ResultSchema(NamedTuple):
    """Columns and datasets of a run, the same for all its cases."""

    layout: Layout
    axes: tuple[Axis, ...]
    histories: bool  # False: neither samples nor events are stored
    frame: str  # hash of everything that the cases of a run share
    verdict: LimitsAndFigures = LimitsAndFigures()  # user-defined figures and limits: only in the merged summary
    worst: int = 0  # number of cases whose peak revolution is in the merged orbits
    labels: CaseLabels = CaseLabels((), (), {})  # texts of the table of cases: only in the merged summary

    @classmethod
    def of(cls, grid: Grid) -> "ResultSchema":
        """Return the schema of the results of `grid`."""
        axes = tuple(
            Axis(path, grid.unit(path), all(isinstance(value, str) for value in values), _labels(grid, path))
            for path, values in grid.axes.items()
        )
        frame = grid.fixed_settings()
        stored = (has_histories(frame), _frame_hash(frame))
        return cls(grid.layout, axes, *stored, grid.verdict, grid.worst_count, grid.labels_by_row)

    @classmethod
    def of_record(cls, record: Mapping[str, Any]) -> "ResultSchema":
        """Return the schema of the batches of a run from its run.json."""
        kinds = {path: kind_of_axis(record, path) for path in record["units"]}
        axes = tuple(
            Axis(path, unit, None if not kinds[path] else kinds[path] == "text")
            for path, unit in record["units"].items()
        )
        frame = record["frame"]
        return cls(Layout.read(record["layout"]), axes, has_histories(frame), _frame_hash(frame))

    @property
    def stored(self) -> Stored:
        """Return what determines the datasets of the orbits."""
        return Stored(self.layout, self.histories)

    @property
    def content(self) -> str:
        """Return a text of everything that determines the values in the files; descriptions of columns do not."""
        columns, channels = (
            tuple(column._replace(description="") for column in group)
            for group in (self.layout.columns, self.layout.channels)
        )
        return repr(self._replace(layout=self.layout._replace(columns=columns, channels=channels)))


def has_histories(frame: Mapping[str, Any]) -> bool:
    """Return whether a run with these fixed settings stores samples and events."""
    return frame.get("save.orbits") != "none"


def _frame_hash(frame: Mapping[str, Any]) -> str:
    text = json.dumps(frame, default=lambda value: value.item())
    text = json.dumps(json.loads(text, parse_int=float), sort_keys=True)  # 1 and 1.0 are the same value
    return hashlib.sha256(text.encode()).hexdigest()


class Row(NamedTuple):
    """A row of the summary: identity, swept values and results of a case."""

    case_id: str
    point: dict  # swept path -> value in SI
    trajectory: results.Trajectory


def summary_schema(result_schema: ResultSchema) -> pa.Schema:
    """Return the schema of the summary of a batch; every field's metadata hold `unit` and `description`.

    Those of an axis with labels also hold `labels`: JSON of label -> value, SI.
    """
    columns = [Column("case_id", "", "identity of the case: hash of all that decides its numbers", "text")]
    columns += [
        Column(axis.path, axis.unit, "swept value", "text" if axis.text else "float") for axis in result_schema.axes
    ]
    columns += [
        Column("status", "", "'ok', or the way in which the case failed", "text"),
        Column("message", "", "description of the failure; for an ok case, remarks", "text"),
    ]
    fields = [field_of(column) for column in (*columns, *result_schema.layout.columns)]
    labels = {axis.path: axis.labels for axis in result_schema.axes if axis.labels}
    for number, field in enumerate(fields):
        if field.name in labels:
            fields[number] = field.with_metadata({**field.metadata, "labels": labels[field.name]})
    return pa.schema(fields)


def _labels(grid: Grid, path: str) -> str:
    return json.dumps(grid.labels[path], default=lambda value: value.item()) if path in grid.labels else ""


def add_verdict_columns(verdict: LimitsAndFigures, table: pa.Table) -> pa.Table:
    """Return rows of a summary with user-defined figures and limits added; of failed cases all limits are undecided."""
    if not verdict.columns:
        return table
    columns = {name: values_of(table[name].combine_chunks()) for name in verdict.required_columns()}
    verdict_columns = verdict.evaluate(columns, values_of(table["status"].combine_chunks()) == "ok")
    for column in verdict.columns:
        field, values = field_of(column), verdict_columns[column.name].astype(object)
        table = table.append_column(field, column_of(values.tolist(), field.type))
    return table


def add_label_columns(labels: CaseLabels, table: pa.Table) -> pa.Table:
    """Return rows of a summary with the texts of the table of cases added; those of other rows are empty."""
    rows = zip(*(table[path].to_pylist() for path in labels.paths), strict=True)
    texts = [labels.texts.get(row, ("",) * len(labels.names)) for row in rows]
    for position, field in enumerate(label_fields(labels)):
        table = table.append_column(field, pa.array([row[position] for row in texts], pa.string()))
    return table


def label_fields(labels: CaseLabels) -> list[pa.Field]:
    """Return the fields of the texts of the table of cases."""
    return [field_of(Column(name, "", "text of the table of cases", "text")) for name in labels.names]


def summary_table(result_schema: ResultSchema, rows: list[Row]) -> pa.Table:
    """Return the summary of `rows`; missing values are null."""
    schema = summary_schema(result_schema)
    columns = {
        "case_id": [row.case_id for row in rows],
        "status": [row.trajectory.status for row in rows],
        "message": [row.trajectory.message for row in rows],
    }
    layout, trajectories = result_schema.layout, [row.trajectory for row in rows]
    columns |= _values_by_column([axis.path for axis in result_schema.axes], [row.point for row in rows])
    columns |= _values_by_column([column.name for column in layout.columns], [path.summary for path in trajectories])
    arrays = [column_of(columns[field.name], field.type, largest_of(field.name)) for field in schema]
    return pa.Table.from_arrays(arrays, schema=schema)


def _values_by_column(names: list[str], rows: list[dict]) -> dict[str, list]:
    """Return the values of names in dicts, by name, or None."""
    return dict(zip(names, map(list, zip(*(map(row.get, names) for row in rows), strict=True)), strict=True))


def write_dataset(file: Hdf5, dataset: Dataset, values: np.ndarray, **options: Any) -> None:
    """Write `values` as one dataset with its unit and description."""
    describe_dataset(file.create_dataset(dataset.path, data=values, **options), dataset)


def describe_dataset(target: Hdf5, dataset: Dataset) -> None:
    """Attach unit and description to a dataset of the file."""
    target.attrs["units"] = dataset.unit
    target.attrs["description"] = dataset.description


def orbits_bytes(schema: ResultSchema, rows: list[Row]) -> bytes:
    """Return the HDF5 file of a batch, plain so that a merge can read it by offsets; units are in the merged file."""
    parts = [(dataset, [_values_in(row.trajectory, dataset) for row in rows]) for dataset in datasets(schema.stored)]
    counts = {dataset.item: list(map(len, values)) for dataset, values in parts}
    arrays = [(CASE_ID, np.array([row.case_id.encode() for row in rows], CASE_ID.dtype))]
    for item, dataset in offset_datasets(schema.stored).items():
        arrays.append((dataset, np.cumsum([0, *counts.get(item, [0] * len(rows))]).astype("i8")))
    arrays += [(dataset, _joined(dataset, values)) for dataset, values in parts]
    size = sum(values.nbytes + DATASET_BYTES for _, values in arrays)  # in one block, since growing takes longer
    with_groups = h5py.h5p.create(h5py.h5p.LINK_CREATE)  # a dataset is created with the groups of its path
    with_groups.set_create_intermediate_group(True)
    with h5py.File("batch", "w", driver="core", backing_store=False, block_size=size) as file:
        for dataset, values in arrays:  # some fifty of them: by `create_dataset` they take twice as long
            kind, space = h5py.h5t.py_create(values.dtype, logical=True), h5py.h5s.create_simple(values.shape)
            target = h5py.h5d.create(file.id, dataset.path.encode(), kind, space, lcpl=with_groups)
            if values.size:
                target.write(h5py.h5s.ALL, h5py.h5s.ALL, np.ascontiguousarray(values))
        file.flush()
        return bytes(file.id.get_file_image())


def _values_in(trajectory: results.Trajectory, dataset: Dataset) -> np.ndarray:
    """Return the values of a dataset in the result of a case; one that failed has none but events and some samples."""
    is_finished, nothing = trajectory.status == "ok", np.empty((0, *dataset.shape), dataset.dtype)
    if dataset.item == EVENT:
        return trajectory.events[dataset.path.removeprefix("events/")]
    if dataset.item == SAMPLE:
        is_kept = len(trajectory.t) and trajectory.status in ("ok", *results.PARTIAL_STATUSES)
        return trajectory.samples(dataset.path) if is_kept else nothing
    if dataset.item == SECTION:
        return trajectory.poincare.get(dataset.path, nothing) if is_finished else nothing
    if dataset.item == NODE:
        return trajectory.history[dataset.path.removeprefix(results.HISTORY)] if is_finished else nothing
    _, joint, body = dataset.path.split("/")
    depths = trajectory.wear[joint][body == "journal"] if is_finished else np.full(dataset.shape, np.nan)
    return depths[np.newaxis]


def _joined(dataset: Dataset, parts: list[np.ndarray]) -> np.ndarray:
    """Return the values of a dataset for all cases as a file has them: words as codes, NaN for what readers refuse."""
    codes = h5py.check_enum_dtype(dataset.dtype)
    values = np.concatenate([np.empty((0, *dataset.shape), "U1" if codes else dataset.dtype), *parts])
    if codes:
        numbers = np.full(len(values), -1, dataset.dtype)
        for word, code in codes.items():
            numbers[values == word] = code
        return numbers
    if dataset.dtype.kind == "f" and (is_huge := np.abs(values) > LARGEST).any():
        return np.where(is_huge, np.nan, values)
    return values


def table_bytes(table: pa.Table, facts: dict) -> bytes:
    """Return the Parquet file of a batch with these rows."""
    table = table.replace_schema_metadata({"clearsweep": json.dumps(facts)})
    sink = io.BytesIO()
    # read once, as a whole: dictionaries and statistics would double the time of writing
    options: dict[str, Any] = {"use_dictionary": False, "write_statistics": False, "compression": "lz4"}
    pq.write_table(table, sink, write_page_checksum=True, **options)
    return sink.getvalue()


class BatchFiles(NamedTuple):
    """The two files of a committed batch."""

    summary: Path  # Parquet; written last, which commits the batch
    orbits: Path | None  # HDF5, or None if nothing is stored
    sha256: str  # of `orbits`
    written: int  # ns since 1970
    frame: str  # `ResultSchema.frame` of its cases
    ids: np.ndarray  # identities of its cases, uint64
    failed: np.ndarray  # bool, of each case
    first: int = 0  # its first case in `orbits`
    cases: int | None = None  # of `orbits`, if it is a name of the merged histories; None: a file of its own

    @property
    def name(self) -> str:
        """Return the name of the summary, which contains a hash of its content."""
        return self.summary.name


def file_name(batch: str, checksum: str, ending: str) -> str:
    """Return the name of a file of a batch, which contains a part of the SHA-256 of its content."""
    return f"{batch}-{checksum[:HASH_LENGTH]}.{ending}"


def hash_in_name(path: Path) -> str | None:
    """Return the hash in the name of a file of a batch, or None for other names."""
    match = _NAME.fullmatch(path.name)
    return match and match.group(1)


def batch_files(path: Path, content: bytes, result_schema: ResultSchema | None = None) -> BatchFiles:
    """Return the files of the batch whose summary at `path` has this content.

    The checksum of the content has been verified; this does not prove that a run wrote it.  MisshapenError for content
    that no run writes: facts, identities and, for a batch of the cases of `result_schema`, all columns are checked.
    """
    try:
        with pq.ParquetFile(pa.BufferReader(content), pre_buffer=False) as file:
            facts = json.loads((file.metadata.metadata or {}).get(b"clearsweep", b"null"))
            check_facts(facts)
            if file.metadata.num_rows > MAX_ROWS:
                raise MisshapenError(f"it has {file.metadata.num_rows:,} rows")
            known = result_schema if result_schema and facts["frame"] == result_schema.frame else None
            if known:
                check_rows(file, known)
            table = file.read(["case_id", "status"], use_threads=False)
    except (pa.ArrowException, OSError, ValueError, RecursionError) as error:
        raise MisshapenError(error_line(error)) from error
    ids, failed = _finished_ids(table)
    name = facts["shard"]
    if name is not None and name[:ID_LENGTH] != path.name[:ID_LENGTH]:
        raise MisshapenError(f"its histories are those of another batch, {name}")
    orbits = None if name is None else path.parent.parent / ORBITS / name
    first, cases = facts.get("span", (0, None))
    if cases is not None and (orbits is None or first + len(ids) > cases):
        raise MisshapenError("its cases are beyond the end of its histories")
    return BatchFiles(path, orbits, facts["sha256"], facts["written"], facts["frame"], ids, failed, first, cases)


def check_rows(file: pq.ParquetFile, result_schema: ResultSchema) -> None:
    """Raise MisshapenError unless the rows of a batch have the columns of `result_schema`, with plausible values."""
    schema, free = summary_schema(result_schema), {axis.path for axis in result_schema.axes if axis.text is None}
    types = {field.name: {pa.string(), pa.float64()} if field.name in free else {field.type} for field in schema}
    fields = file.schema_arrow  # their names in any order: a grid may name its axes in another
    if sorted(fields.names) != sorted(schema.names) or any(field.type not in types[field.name] for field in fields):
        raise MisshapenError("its columns are not those of its grid")
    for first in range(0, len(schema), COLUMNS_AT_ONCE):
        table = file.read(schema.names[first : first + COLUMNS_AT_ONCE], use_threads=False)
        for name, column in zip(table.schema.names, table.columns, strict=True):
            if not all(is_plausible(chunk, largest_of(name)) for chunk in column.chunks):
                raise MisshapenError(f"{name} has values that no run writes")


def _finished_ids(table: pa.Table) -> tuple[np.ndarray, np.ndarray]:
    """Return the identities (uint64) of the cases in the summary of a batch, and which of them failed."""
    for name in ("case_id", "status"):
        if table.schema.get_field_index(name) < 0 or table[name].type != pa.string() or table[name].null_count:
            raise MisshapenError(f"its column {name} is missing, or not of texts")
    ids = list(map(ids_of_column, table["case_id"].chunks))
    failed = [words_of(chunk) != "ok" for chunk in table["status"].chunks]
    return np.concatenate([np.empty(0, "u8"), *ids]), np.concatenate([np.empty(0, bool), *failed])


def ids_of_column(column: pa.Array) -> np.ndarray:
    """Return a column of identities as numbers, uint64; MisshapenError for other texts."""
    bounds = np.frombuffer(column.buffers()[1], "i4")[column.offset : column.offset + len(column) + 1]
    texts = column.buffers()[2].to_pybytes()[bounds[0] : bounds[-1]] if len(column) else b""
    return ids_of_texts(texts if (np.diff(bounds) == ID_LENGTH).all() else b"other")


def release_memory() -> None:
    """Give unused memory back to the system; Arrow and malloc keep the gaps between what is in use.  It takes 1 ms.

    From now on malloc gives back large blocks at once; it would raise the size of these with those that are freed.
    """
    pa.default_memory_pool().release_unused()
    libc = ctypes.CDLL(None)
    if hasattr(libc, "malloc_trim"):  # glibc
        libc.mallopt(_MMAP_THRESHOLD, LARGE_BLOCK)
        libc.malloc_trim(0)


def read_summary(path: Path, columns: list[str]) -> pa.Table:
    """Return columns of the summary of a batch; StorageError if it was changed after the commit."""
    try:
        with open_table(path) as file:
            return file.read(columns, use_threads=False)
    except (OSError, ValueError) as error:  # Arrow's error
        raise durable.damaged_error(path) from error


@contextlib.contextmanager
def open_table(path: Path) -> Iterator[pq.ParquetFile]:
    """Yield a Parquet file whose pages are verified on reading; nothing is read in advance.

    Arrow's reading thread could keep a buffer beyond the end of the interpreter, which aborts (apache/arrow 34314).
    """
    with durable.open_regular(path) as file, pq.ParquetFile(file, **_VERIFIED) as table:
        yield table
