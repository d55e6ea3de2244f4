"""Merges the batches of a run into `summary.parquet` and `orbits.h5`, in case_id order and in bounded memory."""

import contextlib
import hashlib
import itertools
import os
import stat
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from io import BufferedReader
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..contracts.results import Peak
from ..language import phases
from ..language.errors import DamagedError, StorageError
from ..language.wording import is_missing
from . import durable
from .batch import (
    GROUP_ROWS,
    HASH_LENGTH,
    BatchFiles,
    ResultSchema,
    add_label_columns,
    add_verdict_columns,
    describe_dataset,
    file_name,
    label_fields,
    read_summary,
    release_memory,
    summary_schema,
    table_bytes,
    write_dataset,
)
from .datasets import (
    CASE,
    CASE_ID,
    GROUP,
    JOINT,
    OFFSETS,
    TURNS,
    Contents,
    Dataset,
    Hdf5,
    check_values,
    datasets,
    field_of,
    filter_chunk,
    h5py,
    id_texts,
    offset_datasets,
    peak_datasets,
    rows_at,
    values_of,
)
from .directory import FINAL_FILES, ORBITS_FILE, SUMMARY_FILE, Checked, RunDirectory, check_histories
from .read import StoredRun
from .record import MisshapenError, read_record

# ----------------------------------------------------------------------------------------------------------------------
# Writes `summary.parquet`: the rows of all batches in case_id order, in bounded memory.


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
    fields = [*schema, *map(field_of, result_schema.verdict.columns), *label_fields(result_schema.labels)]
    full_schema = pa.schema(fields, {"clearsweep": content_hash})
    # building dictionaries of columns with many distinct values takes most of the time
    repetitive = [field.name for field in full_schema if field.type == pa.string() and field.name != "case_id"]
    with (
        os.fdopen(durable.create_file(path), "wb") as file,
        pq.ParquetWriter(file, full_schema, write_page_checksum=True, use_dictionary=repetitive) as writer,
    ):
        for number, group in enumerate(summary_groups(run, schema, rows)):
            table = add_verdict_columns(result_schema.verdict, group)
            table = add_label_columns(result_schema.labels, table)
            on_group(table, number * GROUP_ROWS)
            writer.write_table(table.replace_schema_metadata(full_schema.metadata))
            pa.default_memory_pool().release_unused()  # it would keep the gaps between the columns of a group


def summary_groups(run: RunDirectory, schema: pa.Schema, rows: np.ndarray) -> Iterator[pa.Table]:
    """Yield the given rows of the summary, GROUP_ROWS at a time; every batch is read once.

    Up to ROWS_IN_MEMORY rows are kept in memory.  Otherwise rows of a few batches at a time are sorted into an unnamed
    file, and each group is merged from these files.  They have Arrow's stream format, since its file format is read in
    advance by other threads (see `batch.open_table`).
    """
    set_of_batch = (np.cumsum(np.bincount(rows["batch"])) - 1) // ROWS_IN_MEMORY
    row_sets = indices_by_value(set_of_batch.astype("u4")[rows["batch"]])
    if len(row_sets) < 2:
        columns, order = _rows_of_batches(run, schema, rows)
        # column by column: one of them fits into the processor's cache, all of them do not
        ordered = pa.Table.from_arrays([rows_at(column, order) for column in columns], schema=schema)
        for first in range(0, len(order), GROUP_ROWS):
            yield ordered.slice(first, GROUP_ROWS)
        return
    group_bounds = np.arange(0, len(rows) + GROUP_ROWS, GROUP_ROWS)
    with contextlib.ExitStack() as files:
        sorted_rows = []
        for positions in row_sets:
            file = files.enter_context(tempfile.TemporaryFile(dir=run.scratch if run.scratch.is_dir() else None))
            bounds = np.searchsorted(positions, group_bounds)
            unsorted, order = _rows_of_batches(run, schema, rows[positions])
            with pa.ipc.new_stream(file, schema) as writer:
                in_memory = list(unsorted)
                for first, last in itertools.pairwise(bounds.tolist()):
                    selected = [rows_at(column, order[first:last]) for column in in_memory]
                    writer.write_batch(pa.RecordBatch.from_arrays(selected, schema=schema))
            file.seek(0)
            sorted_rows.append((positions, bounds, pa.ipc.open_stream(file)))
        for k in range(len(group_bounds) - 1):
            columns = pa.Table.from_batches([reader.read_next_batch() for *_, reader in sorted_rows], schema).columns
            order = np.argsort(
                np.concatenate([positions[bounds[k] : bounds[k + 1]] for positions, bounds, _ in sorted_rows])
            )
            in_order = [rows_at(columns.pop(0).combine_chunks(), order) for _ in schema]
            yield pa.Table.from_arrays(in_order, schema=schema)


def indices_by_value(numbers: np.ndarray) -> list[np.ndarray]:
    """Return the indices of equal values, ascending, for each distinct value; the values are small."""
    if not len(numbers):
        return []
    narrow = np.ascontiguousarray(numbers, "u2" if numbers.max() < 2**16 else "u4")  # of two bytes: sorted by counting
    order = np.argsort(narrow, kind="stable").astype("u4")
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
            pa.default_memory_pool().release_unused()  # the parts are small: it would keep the gaps they leave


# ----------------------------------------------------------------------------------------------------------------------
# Writes `orbits.h5`: the histories of all batches in case_id order, in bounded memory.


CHUNK_VALUES = 16384  # values in a compressed chunk of a dataset: 128 kB of float64
CHUNKS_AT_ONCE = 32  # chunks compressed in parallel before they are written
OPEN_FILES = 128  # files of batches open at a time
COMPRESSORS = min(4, os.cpu_count() or 1)  # threads; more would wait for writing
HDF5_LIBRARY_VERSIONS = ("v110", "v110")  # first HDF5 format with checksums for metadata


class OrbitFiles:
    """The orbits of all batches of a run, opened on demand; few files are open at a time."""

    def __init__(self, run: RunDirectory, result_schema: ResultSchema):
        self.run, self.result_schema = run, result_schema
        self.files: dict[int, Contents] = {}  # number of a batch -> its datasets, each a plain run of bytes
        self.checked = Checked()  # the same by file, which batches may share
        self.handles: dict[int, BufferedReader] = {}  # number of a batch -> its open file
        self.merged: dict[Path, Hdf5] = {}  # open files that merges wrote

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for handle in (*self.handles.values(), *self.merged.values()):
            handle.close()

    def extents(self, item: str, width: int, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return first index and number of values of every case in its batch's dataset, both int64."""
        places = rows["row"] + np.array([batch.first for batch in self.run.batches], "i4")[rows["batch"]]
        if item == CASE:
            return places * np.int64(width), np.full(len(rows), width, "i8")
        first, count = np.zeros(len(rows), "i8"), np.zeros(len(rows), "i8")
        for selection in indices_by_value(rows["batch"]):
            if file := self._file(int(rows["batch"][selection[0]])):
                starts, row = file.offsets[item], places[selection]
                first[selection] = starts[row] * width
                count[selection] = (starts[row + 1] - starts[row]) * width
        return first, count

    def _file(self, number: int) -> Contents | None:
        """Return the datasets of a batch, or None if it has none; StorageError if they are not as a run writes them.

        The next run then computes the cases again: the batch is set aside, unless it is in another directory.
        """
        batch = self.run.batches[number]
        if number not in self.files and batch.orbits:
            try:
                self.files[number] = check_histories(batch, self.result_schema, self.checked)
            except MisshapenError as error:
                raise self._refusal(number, error) from error
        return self.files.get(number)

    def _refusal(self, number: int, error: MisshapenError) -> StorageError:
        batch = self.run.batches[number]
        assert batch.orbits is not None
        if batch.summary.parent == self.run.summaries:
            durable.set_aside(batch.summary)
        return durable.damaged_error(batch.orbits, str(error))

    def refuse_values(self, dataset: Dataset) -> None:
        """Raise the StorageError for the batch in which values of a dataset are such as no run writes."""
        for number, batch in enumerate(self.run.batches):
            if file := self._file(number):
                ends = np.array([batch.first, batch.first + len(batch.ids)])
                first, end = (ends if dataset.item == CASE else file.offsets[dataset.item][ends]).tolist()
                try:
                    _checked(self.read(number, dataset, first * dataset.width, (end - first) * dataset.width), dataset)
                except MisshapenError as error:
                    raise self._refusal(number, error) from error

    def read(self, number: int, dataset: Dataset, first: int, count: int) -> bytes:
        """Return `count` values of a batch's dataset from value `first` on, as bytes."""
        if not count:
            return b""  # a dataset without values has no offset in the file
        handle = self.handles.get(number)
        if handle is None:
            file, path = self._file(number), self.run.batches[number].orbits
            assert file is not None  # there are values
            assert path is not None
            if self.run.batches[number].cases is not None:
                return self._read_merged(path, dataset, first // dataset.width, count // dataset.width)
            if len(self.handles) >= OPEN_FILES:
                self.handles.pop(next(iter(self.handles))).close()
            handle = self.handles[number] = durable.open_regular(path)
        size, start = dataset.dtype.itemsize, self.files[number].positions[dataset.path]
        try:
            return durable.read_span(handle, start + first * size, count * size)
        except EOFError as error:
            raise durable.damaged_error(Path(handle.name), str(error)) from error

    def _read_merged(self, path: Path, dataset: Dataset, first: int, count: int) -> bytes:
        """Return some items of a dataset of a file that a merge wrote, as bytes; its chunks stay decompressed."""
        try:
            if path not in self.merged:
                self.merged[path] = h5py.File(path, "r")
            values: np.ndarray = self.merged[path][dataset.path][first : first + count]
        except OSError as error:
            raise durable.damaged_error(path, str(error)) from error
        return values.tobytes()


def write_orbits(
    path: Path,
    run: RunDirectory,
    result_schema: ResultSchema,
    rows: np.ndarray,
    content_hash: str,
    peaks: "Sequence[tuple[Worst, Peak]]",
) -> None:
    """Write the histories of the given rows, and the peak revolutions of the worst ones."""
    with (
        h5py.File(path, "x", libver=HDF5_LIBRARY_VERSIONS) as file,
        OrbitFiles(run, result_schema) as orbits,
        ThreadPoolExecutor(COMPRESSORS) as threads,
    ):
        file.attrs["clearsweep"] = content_hash
        write_dataset(file, CASE_ID, id_texts(rows["id"]), fletcher32=len(rows) > 0)
        for item, dataset in offset_datasets(result_schema.stored).items():
            offsets = np.zeros(len(rows) + 1, "i8")
            np.cumsum(orbits.extents(item, 1, rows)[1], out=offsets[1:])
            write_dataset(file, dataset, offsets, fletcher32=True)
        all_datasets, writing = datasets(result_schema.stored), phases.innermost_phase()
        for number, dataset in enumerate(all_datasets):
            first, count = orbits.extents(dataset.item, dataset.width, rows)
            values = _case_values(orbits, dataset, rows["batch"], first, count)
            try:
                _write_compressed(file, dataset, values, count.sum(), threads)
            except MisshapenError:
                orbits.refuse_values(dataset)
            if writing:
                writing.note(share=(number + 1) / len(all_datasets))
    if peaks:
        with h5py.File(path, "r+", libver=HDF5_LIBRARY_VERSIONS) as file:
            write_worst(file, result_schema, peaks)


def _case_values(
    orbits: OrbitFiles, dataset: Dataset, numbers: np.ndarray, first: np.ndarray, count: np.ndarray
) -> Iterator[bytes]:
    """Yield the bytes of every case's values, in order; StorageError if some are missing: others would be shifted."""
    total, size = 0, int(count.sum()) * dataset.dtype.itemsize
    for group_start in range(0, len(numbers), ROWS_IN_MEMORY):
        group = slice(group_start, group_start + ROWS_IN_MEMORY)
        for number, start, values in zip(*(array[group].tolist() for array in (numbers, first, count)), strict=True):
            if values:
                content = orbits.read(number, dataset, start, values)
                total += len(content)
                yield content
    if total != size:
        message = f"{total:,} bytes of histories were read, not {size:,}; run the same command again"
        raise StorageError(f"{dataset.path}: {message}")


def _write_compressed(
    file: Hdf5, dataset: Dataset, case_values: Iterator[bytes], value_count: int, threads: ThreadPoolExecutor
) -> None:
    """Write the values of all cases, compressed in threads and with checksums: h5py would use one core."""
    items = int(value_count) // dataset.width
    shape = (items, *dataset.shape)
    rows = max(1, min(items, CHUNK_VALUES // dataset.width))
    compression: dict[str, Any] = {
        "chunks": (rows, *shape[1:]),
        "shuffle": True,
        "compression": "gzip",
        "compression_opts": 1,
        "fletcher32": True,
    }
    target = file.create_dataset(dataset.path, shape, dataset.dtype, **(compression if items else {}))
    describe_dataset(target, dataset)
    size = dataset.dtype.itemsize
    row, chunks = 0, _rechunk(case_values, rows * dataset.width * size)
    while batch := [chunk for _, chunk in zip(range(CHUNKS_AT_ONCE), chunks, strict=False)]:
        for content in threads.map(lambda chunk: filter_chunk(_checked(chunk, dataset), size), batch):
            target.id.write_direct_chunk((row, *(0 for _ in shape[1:])), content)
            row += rows


def _checked(content: bytes, dataset: Dataset) -> bytes:
    """Return the bytes of values of a dataset; MisshapenError if no run writes them."""
    check_values(dataset.path, np.frombuffer(content, dataset.dtype), len(h5py.check_enum_dtype(dataset.dtype) or ()))
    return content


def _rechunk(case_values: Iterator[bytes], size: int) -> Iterator[bytes]:
    """Yield the bytes of `case_values` in chunks of `size` bytes, the last one filled up with zeros."""
    chunk = bytearray()
    for values in case_values:
        chunk += values
        while len(chunk) >= size:
            yield bytes(chunk[:size])
            del chunk[:size]
    if chunk:
        yield bytes(chunk.ljust(size, b"\0"))


# ----------------------------------------------------------------------------------------------------------------------
# The worst cases of a run, and their peak revolutions in orbits.h5.


RANKING_FIGURES = ("force_peak_ratio", "force_peak")  # figures of a joint: the first of which any case has a value
_LENGTH_COLUMNS = ("revolutions_run", "window_from")  # of `simulate.until`


class Worst(NamedTuple):
    """One of the worst cases."""

    case_id: str
    point: dict[str, Any]  # swept path -> value
    joint: int  # index of its joint in the layout
    column: str  # of the largest normal force of that joint
    peak: float  # N, this force
    revolutions: float | None  # length of its run, if `simulate.until` determined it
    window_from: float | None  # revolutions before the window of its figures, likewise


#: Computes the revolution of the largest peak of some cases again, or None if that failed.
ComputePeakRevolutions = Callable[[Sequence[Worst]], Sequence[Peak | None]]


def worst_with_peaks(
    run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray, compute: ComputePeakRevolutions
) -> list[tuple[Worst, Peak]]:
    """Return the worst of the cases in `rows` whose peak revolution is found again, each with it, the worst first.

    They are those with the largest load ratio of any joint; if no case has one, the largest normal force counts.
    """
    worst, layout = list[Worst](), result_schema.layout
    for figure in RANKING_FIGURES if layout.joints and result_schema.worst and len(rows) else ():
        names = [f"{joint.name}_{figure}" for joint in layout.joints]
        if not worst and {column.name for column in layout.columns}.issuperset(names):
            worst = _cases_with_largest(run, result_schema, rows, names)
    return [(case, peak) for case, peak in zip(worst, compute(worst) if worst else [], strict=True) if peak]


def _cases_with_largest(
    run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray, names: list[str]
) -> list[Worst]:
    """Return the cases with the largest value of any of some columns, one for each joint."""
    joints, paths = result_schema.layout.joints, [axis.path for axis in result_schema.axes]
    peaks, alike = [f"{joint.name}_force_peak" for joint in joints], result_schema.layout.comparable(names)
    full_schema = summary_schema(result_schema)
    optional = [name for name in _LENGTH_COLUMNS if name in full_schema.names]
    names_to_read = dict.fromkeys(["case_id", "status", *paths, *names, *peaks, *optional])
    ranked: list[tuple[float, Worst]] = []
    schema = pa.schema([full_schema.field(name) for name in names_to_read])
    for group in summary_groups(run, schema, rows):
        columns = {name: values_of(group[name].combine_chunks()) for name in names_to_read}
        figures = np.array([columns[name] for name in names])
        figures[:, columns["status"] != "ok"] = np.nan
        figures[[name not in alike for name in names]] = np.nan
        largest = np.where(np.isnan(figures).all(axis=0), -np.inf, np.fmax.reduce(figures, axis=0))
        for row in np.lexsort((columns["case_id"], -largest))[: result_schema.worst].tolist():
            if np.isfinite(largest[row]):
                joint = int(np.nanargmax(figures[:, row]))
                values = {path: columns[path].item(row) for path in paths}
                point = {path: None if is_missing(value) else value for path, value in values.items()}
                length = [float(columns[name][row]) if name in optional else None for name in _LENGTH_COLUMNS]
                peak = peaks[joint], float(columns[peaks[joint]][row])
                case = Worst(columns["case_id"][row], point, joint, *peak, *length)
                ranked.append((float(largest[row]), case))
    ranked.sort(key=lambda entry: (-entry[0], entry[1].case_id))
    return [case for _, case in ranked[: result_schema.worst]]


def write_worst(file: Hdf5, result_schema: ResultSchema, cases: Sequence[tuple[Worst, Peak]]) -> None:
    """Write the peak revolutions, the worst case first."""
    paths = [peak.path for _, peak in cases]
    content: dict[str, Any] = {
        f"{GROUP}/case_id": [case.case_id.encode() for case, _ in cases],
        JOINT: [case.joint for case, _ in cases],
        TURNS: [peak.turns for _, peak in cases],
        OFFSETS: np.cumsum([0, *(len(path.t) for path in paths)]),
    }
    for dataset in peak_datasets(result_schema.layout):
        values = content.get(dataset.path)
        if values is None:
            values = np.concatenate([path.samples(dataset.path.removeprefix(f"{GROUP}/")) for path in paths])
        write_dataset(file, dataset, np.asarray(values, dataset.dtype), fletcher32=True)


# ----------------------------------------------------------------------------------------------------------------------
# Merges the batches of a run into `orbits.h5` and `summary.parquet`.


def merge(
    run: RunDirectory,
    result_schema: ResultSchema,
    rows: np.ndarray,
    *,
    report: Callable[[str], None] = lambda _: None,
    compute_peak_revolutions: ComputePeakRevolutions = lambda worst: [None] * len(worst),
) -> dict[str, str]:
    """Write orbits.h5 and summary.parquet with exactly the cases in `rows`, unless present.

    rows : structured array with the fields `id`, `batch` and `row`, ascending by id.
    Return the hash of their content and their checksums, by which the next run recognises unchanged files.
    `report` receives a sentence for each changed file.  `compute_peak_revolutions` returns those of the worst cases.
    """
    content_hash = content_hash_of(run, result_schema, rows)
    recorded_checksums: dict[str, str] = read_record(run.path).get("merged", {})  # of it alone: it lists all values
    if recorded_checksums.get("mark") == content_hash:
        current_checksums = _checksums(run, content_hash)
        if current_checksums == recorded_checksums:
            try:
                StoredRun.check_merged(run.path, read_record(run.path))
                return recorded_checksums
            except DamagedError as error:
                report(f"{str(error).partition(';')[0]}; written again from the batches")
        for name in sorted(recorded_checksums):
            if current_checksums.get(name) != recorded_checksums[name]:
                state = "damaged (its checksum is not that in run.json)" if name in current_checksums else "missing"
                report(f"{name}: {state}; written again from the batches")
    peaks = worst_with_peaks(run, result_schema, rows, compute_peak_revolutions)
    with durable.storing(run.path):
        with contextlib.ExitStack() as exit_stack:
            summary, orbits = (
                exit_stack.enter_context(durable.atomic_file(run.path / name, run.scratch)) for name in FINAL_FILES
            )
            with phases.phase(f"writing {ORBITS_FILE}"):
                write_orbits(orbits, run, result_schema, rows, content_hash, peaks)
            release_memory()
            with phases.phase(f"writing {SUMMARY_FILE}") as writing:
                write_summary(
                    summary,
                    run,
                    result_schema,
                    rows,
                    content_hash,
                    lambda _, written_rows: writing.note(share=written_rows / len(rows)),
                )
            for path in (summary, orbits):
                durable.sync(path)
        durable.sync(run.path)
        with phases.phase("computing checksums"):
            return _checksums(run, content_hash)


def content_hash_of(run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray) -> str:
    """Return a hash of the content of the merged files, which is stored in both files.

    It is computed from the names of the batches, since these contain hashes of their content.
    """
    return hashlib.sha256(f"{result_schema.content}{_rows_hash(run, rows)}".encode()).hexdigest()[:HASH_LENGTH]


def _file_of_all(run: RunDirectory, rows: np.ndarray) -> Path | None:
    """Return the merged histories that contain these rows and no others, or None."""
    files = {(batch.orbits, batch.cases) for batch in _batches_of(run, rows)}
    orbits, cases = files.pop() if len(files) == 1 else (None, None)
    return orbits if cases == len(rows) else None


def _batches_of(run: RunDirectory, rows: np.ndarray) -> list[BatchFiles]:
    return [run.batches[number] for number in np.flatnonzero(np.bincount(rows["batch"])).tolist()]


def _rows_hash(run: RunDirectory, rows: np.ndarray) -> str:
    """Return a hash of some rows and their histories, the same after `keep_histories_once` renamed their batches."""
    if file := _file_of_all(run, rows):
        return file.name[:HASH_LENGTH]
    digest = hashlib.sha256()
    for column in ("id", "row"):
        digest.update(rows[column].tobytes())
    names = np.array([batch.name for batch in run.batches], "S")
    for start in range(0, len(rows), ROWS_IN_MEMORY):
        digest.update(names[rows["batch"][start : start + ROWS_IN_MEMORY]].tobytes())
    return digest.hexdigest()[:HASH_LENGTH]


def keep_histories_once(run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray, checksum: str) -> None:
    """Let the batches of merged rows share orbits.h5, under a second name, and remove their own histories.

    The new batches are committed before the old ones are removed, so that a process that is killed loses no case.
    A file system without links keeps the batches as they are.

    checksum : of orbits.h5
    """
    whole, merged = _file_of_all(run, rows), run.path / ORBITS_FILE
    has_own = any(batch.orbits and batch.cases is None for batch in _batches_of(run, rows))
    if whole.samefile(merged) if whole else not has_own:
        return
    name = _rows_hash(run, rows)
    shared = run.orbits / file_name(name, checksum, "h5")
    facts = {"shard": shared.name, "sha256": checksum, "written": time.time_ns(), "frame": result_schema.frame}
    with durable.storing(shared):
        try:
            with durable.atomic_file(shared, run.scratch) as temporary:
                os.link(merged, temporary, follow_symlinks=False)
        except OSError:
            return
        if whole == shared:
            return
        os.chmod(shared, stat.S_IRUSR | stat.S_IRGRP | stat.S_IROTH)  # to change it would damage the cases, too
        durable.sync(run.orbits)
        new_names, first = list[str](), 0
        for group in summary_groups(run, summary_schema(result_schema), rows):
            for start in range(0, len(group), ROWS_IN_MEMORY):
                part = group.slice(start, ROWS_IN_MEMORY)
                content = table_bytes(part, facts | {"span": [first, len(rows)]})
                new_names.append(file_name(name, hashlib.sha256(content).hexdigest(), "parquet"))
                durable.replace(run.summaries / new_names[-1], content, run.scratch)
                first += len(part)
        for new_name in new_names:
            run.register_batch(new_name)
        unused = {*rows["batch"].tolist()} - {*run.rows()["batch"].tolist()}
        removed = [run.batches[number] for number in unused]
        run.batches = [batch for number, batch in enumerate(run.batches) if number not in unused]
        for batch in removed:
            durable.discard(batch.summary)
        durable.sync(run.summaries)  # before the histories: a summary without them is damaged
        for path in {batch.orbits for batch in removed} - {batch.orbits for batch in (*run.batches, *run.others)}:
            if path:
                durable.discard(path)


def _checksums(run: RunDirectory, content_hash: str) -> dict[str, str]:
    paths = [run.path / name for name in FINAL_FILES]
    return {"mark": content_hash} | {path.name: durable.checksum(path) for path in paths if path.exists()}
