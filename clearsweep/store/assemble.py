"""Merges the batches of a run into `orbits.h5` and `summary.parquet`, in case_id order, in bounded memory."""

import contextlib
import hashlib
import itertools
import os
import struct
import tempfile
import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, BinaryIO, Self

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..language import phases
from . import durable
from .batch import (
    CASE_ID,
    GROUP_ROWS,
    ResultSchema,
    array_of,
    datasets,
    describe,
    field_of,
    id_texts,
    offsets_of,
    put,
    read_summary,
    summary_schema,
    with_verdict,
)
from .datasets import CASE, Dataset
from .directory import FINAL_FILES, ORBITS_FILE, SUMMARY_FILE, RunDirectory
from .record import read_record
from .worst import Again, worst_cases, write_worst

HELD_ROWS = 131072  # rows of the summary in memory at a time, from whole batches: those of a block
CHUNK_VALUES = 16384  # values in a compressed chunk of a dataset: 128 kB of float64
CHUNKS_AT_ONCE = 32  # chunks compressed in parallel before they are written
OPEN_FILES = 128  # files of batches open at a time
COMPRESSORS = min(4, os.cpu_count() or 1)  # threads; more would wait for writing
FORMAT = ("v110", "v110")  # first HDF5 format with checksums for metadata


def merge(
    run: RunDirectory,
    form: ResultSchema,
    rows: np.ndarray,
    *,
    say: Callable[[str], None] = lambda _: None,
    again: Again = lambda worst: [None] * len(worst),
) -> dict[str, str]:
    """Write orbits.h5 and summary.parquet with exactly the cases in `rows` (ROWS, ascending by id), unless present.

    Return what informs the next run whether they are still what they should be: the mark of their content, checksums.
    `say` is given a sentence for each that is not.  `again` computes the revolution of the largest peak of the worst
    cases.
    """
    mark = mark_of(run, form, rows)
    known: dict[str, str] = read_record(run.path).get("merged", {})
    if known.get("mark") == mark:
        merged = _merged(run, mark)
        if merged == known:
            return known
        for name in sorted(known):
            if merged.get(name) != known[name]:
                state = "damaged (its checksum is not that in run.json)" if name in merged else "missing"
                say(f"{name}: {state}; made anew of the batches")
    worst = worst_cases(form, lambda schema: summary_groups(run, schema, rows)) if form.worst else []
    peaks = [(case, peak) for case, peak in zip(worst, again(worst) if worst else [], strict=True) if peak]
    with durable.storing(run.path):
        with contextlib.ExitStack() as finished:
            summary, orbits = (
                finished.enter_context(durable.publishing(run.path / name, run.scratch)) for name in FINAL_FILES
            )
            with phases.phase(f"writing {ORBITS_FILE}"):
                write_orbits(orbits, run, form, rows, mark)
            if peaks:
                with h5py.File(orbits, "r+", libver=FORMAT) as file:
                    write_worst(file, form, peaks)
            with phases.phase(f"writing {SUMMARY_FILE}") as writing:
                write_summary(summary, run, form, rows, mark, lambda _, before: writing.note(share=before / len(rows)))
            for path in (summary, orbits):
                durable.sync(path)
        durable.sync(run.path)
        with phases.phase("computing checksums"):
            return _merged(run, mark)


def mark_of(run: RunDirectory, form: ResultSchema, rows: np.ndarray) -> str:
    """Return a hash of the content of the merged files, which both carry: batches are named by their content."""
    digest = hashlib.sha256(repr(form).encode())
    for column in ("id", "row"):
        digest.update(rows[column].tobytes())
    names = np.array([batch.name for batch in run.batches], "S")
    for start in range(0, len(rows), HELD_ROWS):
        digest.update(names[rows["batch"][start : start + HELD_ROWS]].tobytes())
    return digest.hexdigest()[:16]


def _merged(run: RunDirectory, mark: str) -> dict[str, str]:
    paths = [run.path / name for name in FINAL_FILES]
    return {"mark": mark} | {path.name: durable.checksum(path) for path in paths if path.exists()}


def write_summary(
    path: Path,
    run: RunDirectory,
    form: ResultSchema,
    rows: np.ndarray,
    mark: str,
    watch: Callable[[pa.Table, int], None] = lambda *_: None,
) -> None:
    """Write the given rows of the summary; `watch` receives every group and the number of rows before it."""
    schema = summary_schema(form)
    verdict_fields = [field_of(column) for column in form.verdict.columns]
    whole = pa.schema([*schema, *verdict_fields], {"clearsweep": mark})
    with (
        os.fdopen(durable.create(path), "wb") as file,
        pq.ParquetWriter(file, whole, write_page_checksum=True, use_dictionary=repetitive(whole)) as writer,
    ):
        for number, group in enumerate(summary_groups(run, schema, rows)):
            table = with_verdict(form.verdict, group)
            watch(table, number * GROUP_ROWS)
            writer.write_table(table.replace_schema_metadata(whole.metadata))


def repetitive(schema: pa.Schema) -> list[str]:
    """Return the columns in which few values are different: to look for them in others takes most of the writing."""
    return [field.name for field in schema if field.type == pa.string() and field.name != "case_id"]


def summary_groups(run: RunDirectory, schema: pa.Schema, rows: np.ndarray) -> Iterator[pa.Table]:
    """Yield the given rows of the summary, GROUP_ROWS at a time; every batch is read once.

    Up to HELD_ROWS they are kept in memory.  Of more, the rows of some batches at a time go, sorted, to a file without
    a name; each group is then picked from these files.  They are streams, not files of Arrow, as those are read in
    advance by threads of its own (see `batch.open_table`).
    """
    pieces = _split((np.cumsum(np.bincount(rows["batch"]))[rows["batch"]] - 1) // HELD_ROWS)
    if len(pieces) < 2:
        yield from _groups(*_rows_of_batches(run, schema, rows))
        return
    cuts = np.arange(0, len(rows) + GROUP_ROWS, GROUP_ROWS)
    with contextlib.ExitStack() as files:
        sorted_rows = []
        for places in pieces:
            file = files.enter_context(tempfile.TemporaryFile(dir=run.scratch if run.scratch.is_dir() else None))
            bounds = np.searchsorted(places, cuts)
            table, order = _rows_of_batches(run, schema, rows[places])
            with pa.ipc.new_stream(file, schema) as writer:
                for first, last in itertools.pairwise(bounds.tolist()):
                    columns = table.take(_indices(order[first:last])).columns
                    writer.write_batch(
                        pa.RecordBatch.from_arrays([column.combine_chunks() for column in columns], schema=schema)
                    )
            file.seek(0)
            sorted_rows.append((places, bounds, pa.ipc.open_stream(file)))
        for k in range(len(cuts) - 1):
            group = pa.Table.from_batches([reader.read_next_batch() for *_, reader in sorted_rows], schema)
            order = np.argsort(np.concatenate([places[bounds[k] : bounds[k + 1]] for places, bounds, _ in sorted_rows]))
            yield group.take(_indices(order)).combine_chunks()


def _groups(table: pa.Table, order: np.ndarray) -> Iterator[pa.Table]:
    """Yield the rows of a table in an order, GROUP_ROWS at a time."""
    places = _indices(order)
    # column by column: one of them fits into the processor's cache, all of them do not
    ordered = pa.Table.from_arrays([column.take(places) for column in table.columns], schema=table.schema)
    for first in range(0, len(order), GROUP_ROWS):
        yield ordered.slice(first, GROUP_ROWS)


def _split(numbers: np.ndarray) -> list[np.ndarray]:
    """Return the places, ascending, of the values that are equal, for each of them; the values are small."""
    if not len(numbers):
        return []
    narrow = np.ascontiguousarray(numbers, "u2" if numbers.max() < 2**16 else "u4")  # of two bytes: sorted by counting
    order = np.argsort(narrow, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(narrow[order])) + 1)


def _rows_of_batches(run: RunDirectory, schema: pa.Schema, rows: np.ndarray) -> tuple[pa.Table, np.ndarray]:
    """Return the batches with the given rows of the summary as one table, and where each row is in it."""
    tables, starts, count = [pa.Table.from_batches([], schema)], np.zeros(len(run.batches), int), 0
    for number in np.flatnonzero(np.bincount(rows["batch"])).tolist():
        batch = run.batches[number]
        table = read_summary(batch.summary, schema.names) if batch.table is None else batch.table
        columns = table.select(schema.names)
        tables.append(columns if columns.schema.equals(schema) else columns.cast(schema))
        starts[number], count = count, count + len(table)
    return pa.concat_tables(tables).combine_chunks(), starts[rows["batch"]] + rows["row"]


def _indices(values: np.ndarray) -> pa.Array:
    return array_of([None, np.ascontiguousarray(values, "i8")], pa.int64(), len(values))


class _OrbitFile:
    """The datasets of one batch, each a plain run of bytes in the file."""

    def __init__(self, path: Path, form: ResultSchema):
        self.path = path
        durable.check_regular(path)
        with h5py.File(path, "r") as file:
            self.starts = {each: file[dataset.path][:] for each, dataset in offsets_of(form).items()}
            names = [dataset.path for dataset in datasets(form)]
            self.places = {name: h5py.h5d.open(file.id, name.encode()).get_offset() for name in names}


class OrbitFiles:
    """The orbits of all batches of a run, opened on demand; few files are open at a time."""

    def __init__(self, run: RunDirectory, form: ResultSchema):
        self.paths, self.form = [batch.orbits for batch in run.batches], form
        self.files: dict[int, _OrbitFile] = {}  # number of a batch -> value
        self.handles: dict[int, BinaryIO] = {}  # number of a batch -> value

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for handle in self.handles.values():
            handle.close()

    def extents(self, each: str, width: int, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return first index and number of values of every case in its batch's dataset, both int64."""
        if each == CASE:
            return rows["row"].astype("i8") * width, np.full(len(rows), width, "i8")
        first, count = np.zeros(len(rows), "i8"), np.zeros(len(rows), "i8")
        for here in _split(rows["batch"]):
            if file := self._file(int(rows["batch"][here[0]])):
                starts, row = file.starts[each], rows["row"][here]
                first[here], count[here] = starts[row], starts[row + 1] - starts[row]
        return first * width, count * width

    def _file(self, number: int) -> _OrbitFile | None:
        """Return the file of a batch, or None if it has no orbits."""
        path = self.paths[number]
        if number not in self.files and path:
            self.files[number] = _OrbitFile(path, self.form)
        return self.files.get(number)

    def read(self, number: int, dataset: Dataset, first: int, count: int) -> bytes:
        """Return `count` values of a batch's dataset from value `first` on, as bytes."""
        if not count:
            return b""  # a dataset without values has no offset in the file
        file = self._file(number)
        assert file is not None  # there are values
        if number not in self.handles:
            if len(self.handles) >= OPEN_FILES:
                self.handles.pop(next(iter(self.handles))).close()
            self.handles[number] = durable.opened(file.path)
        size, handle = dataset.dtype.itemsize, self.handles[number].fileno()
        return os.pread(handle, count * size, file.places[dataset.path] + first * size)


def write_orbits(path: Path, run: RunDirectory, form: ResultSchema, rows: np.ndarray, mark: str) -> None:
    """Write the histories of the given rows."""
    with (
        h5py.File(path, "x", libver=FORMAT) as file,
        OrbitFiles(run, form) as orbits,
        ThreadPoolExecutor(COMPRESSORS) as threads,
    ):
        file.attrs["clearsweep"] = mark
        put(file, CASE_ID, id_texts(rows["id"]), fletcher32=len(rows) > 0)
        for each, dataset in offsets_of(form).items():
            _, count = orbits.extents(each, 1, rows)
            put(file, dataset, np.concatenate([[0], np.cumsum(count)]).astype("i8"), fletcher32=True)
        all_datasets, writing = datasets(form), phases.innermost()
        for number, dataset in enumerate(all_datasets):
            first, count = orbits.extents(dataset.each, dataset.width, rows)
            _write_dataset(file, dataset, _pieces(orbits, dataset, rows["batch"], first, count), count.sum(), threads)
            if writing:
                writing.note(share=(number + 1) / len(all_datasets))


def _pieces(
    orbits: OrbitFiles, dataset: Dataset, numbers: np.ndarray, first: np.ndarray, count: np.ndarray
) -> Iterator[bytes]:
    """Yield the bytes of every case's values, in order."""
    for begin in range(0, len(numbers), HELD_ROWS):
        here = slice(begin, begin + HELD_ROWS)
        for number, start, values in zip(*(each[here].tolist() for each in (numbers, first, count)), strict=True):
            if values:
                yield orbits.read(number, dataset, start, values)


def _write_dataset(
    file: h5py.File, dataset: Dataset, pieces: Iterator[bytes], values: int, threads: ThreadPoolExecutor
) -> None:
    """Write the pieces one after another, each with a checksum, filtered in threads: h5py would use one core."""
    items = int(values) // dataset.width
    shape = (items, *dataset.shape)
    rows = max(1, min(items, CHUNK_VALUES // dataset.width))
    squeeze: dict[str, Any] = {
        "chunks": (rows, *shape[1:]),
        "shuffle": True,
        "compression": "gzip",
        "compression_opts": 1,
        "fletcher32": True,
    }
    target = file.create_dataset(dataset.path, shape, dataset.dtype, **(squeeze if items else {}))
    describe(target, dataset)
    size = dataset.dtype.itemsize
    place, chunks = 0, _rechunked(pieces, rows * dataset.width * size)
    while batch := [chunk for _, chunk in zip(range(CHUNKS_AT_ONCE), chunks, strict=False)]:
        for content in threads.map(lambda chunk: _filtered(chunk, size), batch):
            target.id.write_direct_chunk((place, *(0 for _ in shape[1:])), content)
            place += rows


def _rechunked(pieces: Iterator[bytes], size: int) -> Iterator[bytes]:
    """Yield the bytes of `pieces` in chunks of `size` bytes, the last one filled up with zeros."""
    chunk = bytearray()
    for piece in pieces:
        chunk += piece
        while len(chunk) >= size:
            yield bytes(chunk[:size])
            del chunk[:size]
    if chunk:
        yield bytes(chunk.ljust(size, b"\0"))


def _filtered(chunk: bytes, size: int) -> bytes:
    """Return a chunk after HDF5's shuffle, deflate and checksum filters; `size`: bytes of one value."""
    deflate = zlib.compressobj(1, memLevel=9)  # 0.87 of the time of the usual level
    content = deflate.compress(np.frombuffer(chunk, "u1").reshape(-1, size).T.tobytes()) + deflate.flush()
    return content + struct.pack("<I", fletcher32(content))


def fletcher32(content: bytes) -> int:
    """Return the checksum of HDF5's filter: Fletcher's (1982) two sums of big-endian words, modulo 65535.

    A multiple of 65535 counts as 65535, unless all words are zero: HDF5 brings the carry round.
    """
    count = -(-len(content) // 2)
    words = np.frombuffer(content + b"\0" * (-len(content) % 512), ">u2").reshape(-1, 256).astype("u4")
    rows, columns = words.sum(axis=1, dtype="u8"), words.sum(axis=0, dtype="u8")
    total = int(rows.sum())
    before = 256 * int(rows @ np.arange(len(rows), dtype="u8")) + int(columns @ np.arange(256, dtype="u8"))
    # the second sum adds up the first as it grows: word i is in it count - i times
    first, second = ((value - 1) % 65535 + 1 if value else 0 for value in (total, count * total - before))
    return second << 16 | first
