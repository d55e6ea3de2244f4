"""Merges: the batches of a run become `orbits.h5` and `summary.parquet`, in case_id order, in bounded memory."""

import hashlib
import os
import zlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from . import durable
from .batch import (
    CASE,
    CASE_ID,
    Dataset,
    Form,
    array_of,
    datasets,
    describe,
    offsets_of,
    put,
    read_summary,
    summary_schema,
)
from .directory import RunDirectory, id_text, read_record

GROUP_ROWS = 4096  # rows of the summary held in memory at a time
CHUNK_VALUES = 16384  # values in one compressed piece of a dataset: 128 kB of float64
CHUNKS_AT_ONCE = 32  # pieces compressed side by side before they are written
OPEN_FILES = 128  # of batches, open at a time
COMPRESSORS = min(4, os.cpu_count() or 1)  # threads; more would wait for the writing


ORBITS_FILE, SUMMARY_FILE = "orbits.h5", "summary.parquet"


def merge(run: RunDirectory, form: Form, rows: np.ndarray) -> dict[str, str]:
    """Write orbits.h5 and summary.parquet with exactly the cases in `rows` (ROWS, ascending by id), unless they do.

    Return what tells the next run whether they are still what they should be: the mark of their content, checksums.
    """
    mark = _mark(run, form, rows)
    known: dict[str, str] = read_record(run.path).get("merged", {})
    if known.get("mark") == mark and known == _merged(run, mark):
        return known
    with durable.storing(run.path):
        _write_orbits(run.scratch / ORBITS_FILE, run, form, rows, mark)
        _write_summary(run.scratch / SUMMARY_FILE, run, form, rows, mark)
        for name in (ORBITS_FILE, SUMMARY_FILE):
            durable.sync(run.scratch / name)
        for name in (ORBITS_FILE, SUMMARY_FILE):
            durable.publish(run.scratch / name, run.path / name)
        return _merged(run, mark)


def _mark(run: RunDirectory, form: Form, rows: np.ndarray) -> str:
    """Return a hash of what the merged files hold, which both carry: batches are named by their content."""
    digest = hashlib.sha256(repr(form).encode() + rows["id"].tobytes() + rows["row"].tobytes())
    digest.update(np.array([batch.name for batch in run.batches], "S")[rows["batch"]].tobytes())
    return digest.hexdigest()[:16]


def _merged(run: RunDirectory, mark: str) -> dict[str, str]:
    paths = [run.path / name for name in (ORBITS_FILE, SUMMARY_FILE)]
    return {"mark": mark} | {path.name: durable.checksum(path) for path in paths if path.exists()}


def _write_summary(path: Path, run: RunDirectory, form: Form, rows: np.ndarray, mark: str) -> None:
    schema = summary_schema(form).with_metadata({"clearsweep": mark})
    with pq.ParquetWriter(path, schema) as writer:
        for start in range(0, len(rows), GROUP_ROWS):
            writer.write_table(summary_group(run, schema, rows[start : start + GROUP_ROWS]))


def summary_group(run: RunDirectory, schema: pa.Schema, rows: np.ndarray) -> pa.Table:
    """Return the given rows of the summary, read from the batches that hold them."""
    tables, places = [], []
    for number in np.unique(rows["batch"]).tolist():
        here = np.flatnonzero(rows["batch"] == number)
        table = read_summary(run.batches[number].summary, schema.names)
        tables.append(table.select(schema.names).take(_indices(rows["row"][here])).cast(schema))
        places.append(here)
    order = np.argsort(np.concatenate(places))
    return pa.concat_tables(tables).take(_indices(order)).combine_chunks()


def _indices(values: np.ndarray) -> pa.Array:
    return array_of([None, np.ascontiguousarray(values, "i8")], pa.int64(), len(values))


class _OrbitFile:
    """The datasets of one batch, each a plain run of bytes in the file."""

    def __init__(self, path: Path, form: Form):
        self.path = path
        with h5py.File(path, "r") as file:
            self.starts = {each: file[dataset.path][:] for each, dataset in offsets_of(form).items()}
            self.places = {dataset.path: file[dataset.path].id.get_offset() for dataset in datasets(form)}


class OrbitFiles:
    """The orbits of all batches of a run; a limited number of files is open at a time."""

    def __init__(self, run: RunDirectory, form: Form):
        self.files = {
            number: _OrbitFile(batch.orbits, form) for number, batch in enumerate(run.batches) if batch.orbits
        }
        self.handles: dict[int, int] = {}  # number of a batch -> file descriptor

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for handle in self.handles.values():
            os.close(handle)

    def extents(self, each: str, width: int, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return first value and number of values of every case, both int64, counted in its own batch's dataset."""
        if each == CASE:
            return rows["row"].astype("i8") * width, np.full(len(rows), width, "i8")
        first, count = np.zeros(len(rows), "i8"), np.zeros(len(rows), "i8")
        for number, file in self.files.items():
            here = rows["batch"] == number
            first[here] = file.starts[each][rows["row"][here]]
            count[here] = file.starts[each][rows["row"][here] + 1] - first[here]
        return first, count

    def read(self, number: int, dataset: Dataset, first: int, count: int) -> bytes:
        """Return `count` values of a batch's dataset from value `first` on, as bytes."""
        if not count:
            return b""  # a dataset without values has no place in the file
        if number not in self.handles:
            if len(self.handles) >= OPEN_FILES:
                os.close(self.handles.pop(next(iter(self.handles))))
            self.handles[number] = os.open(self.files[number].path, os.O_RDONLY)
        size = dataset.dtype.itemsize
        return os.pread(self.handles[number], count * size, self.files[number].places[dataset.path] + first * size)


def _write_orbits(path: Path, run: RunDirectory, form: Form, rows: np.ndarray, mark: str) -> None:
    with h5py.File(path, "w") as file, OrbitFiles(run, form) as orbits, ThreadPoolExecutor(COMPRESSORS) as threads:
        file.attrs["clearsweep"] = mark
        put(file, CASE_ID, np.array([id_text(value).encode() for value in rows["id"]], CASE_ID.dtype))
        for each, dataset in offsets_of(form).items():
            _, count = orbits.extents(each, 1, rows)
            put(file, dataset, np.concatenate([[0], np.cumsum(count)]).astype("i8"))
        for dataset in datasets(form):
            first, count = orbits.extents(dataset.each, dataset.width, rows)
            _write_dataset(file, dataset, _pieces(orbits, dataset, rows["batch"], first, count), count.sum(), threads)


def _pieces(
    orbits: OrbitFiles, dataset: Dataset, numbers: np.ndarray, first: np.ndarray, count: np.ndarray
) -> Iterator[bytes]:
    """Yield the bytes of every case's values, in order."""
    for number, start, values in zip(numbers.tolist(), first.tolist(), count.tolist(), strict=True):
        if values:
            yield orbits.read(number, dataset, start, values)


def _write_dataset(
    file: h5py.File, dataset: Dataset, pieces: Iterator[bytes], values: int, threads: ThreadPoolExecutor
) -> None:
    """Write the pieces one after another, shuffled and deflated in threads: zlib in h5py would use one core."""
    items = int(values) // dataset.width
    shape = (items,) if dataset.each != CASE else (items, dataset.width)
    rows = max(1, min(items, CHUNK_VALUES // dataset.width))
    squeeze: dict[str, Any] = {
        "chunks": (rows, *shape[1:]),
        "shuffle": True,
        "compression": "gzip",
        "compression_opts": 1,
    }
    target = file.create_dataset(dataset.path, shape, dataset.dtype, **(squeeze if items else {}))
    describe(target, dataset)
    size = dataset.dtype.itemsize
    place, chunks = 0, _rechunked(pieces, rows * dataset.width * size)
    while batch := [chunk for _, chunk in zip(range(CHUNKS_AT_ONCE), chunks, strict=False)]:
        for content in threads.map(lambda chunk: _deflated(chunk, size), batch):
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


def _deflated(chunk: bytes, size: int) -> bytes:
    """Return a chunk as HDF5's shuffle and deflate filters would run it; `size`: bytes of one value."""
    return zlib.compress(np.frombuffer(chunk, "u1").reshape(-1, size).T.tobytes(), 1)
