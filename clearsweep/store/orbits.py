"""Writes `orbits.h5`: the histories of all batches in case_id order, in bounded memory."""

import os
import struct
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from io import BufferedReader
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np
from isal import isal_zlib

from ..language import phases
from ..language.errors import StorageError
from . import durable
from .batch import ResultSchema, describe_dataset, id_texts, write_dataset
from .datasets import CASE, CASE_ID, Contents, Dataset, check_values, datasets, offset_datasets
from .directory import RunDirectory, check_histories
from .record_shape import MisshapenError
from .summary import ROWS_IN_MEMORY, indices_by_value

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
        self.handles: dict[int, BufferedReader] = {}  # number of a batch -> its open file

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for handle in self.handles.values():
            handle.close()

    def extents(self, item: str, width: int, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return first index and number of values of every case in its batch's dataset, both int64."""
        if item == CASE:
            return rows["row"].astype("i8") * width, np.full(len(rows), width, "i8")
        first, count = np.zeros(len(rows), "i8"), np.zeros(len(rows), "i8")
        for selection in indices_by_value(rows["batch"]):
            if file := self._file(int(rows["batch"][selection[0]])):
                starts, row = file.offsets[item], rows["row"][selection]
                first[selection], count[selection] = starts[row], starts[row + 1] - starts[row]
        return first * width, count * width

    def _file(self, number: int) -> Contents | None:
        """Return the datasets of a batch, or None if it has none; StorageError if they are not as a run writes them.

        The next run then computes the cases again: the batch is set aside, unless it is in another directory.
        """
        batch = self.run.batches[number]
        if number not in self.files and batch.orbits:
            try:
                self.files[number] = check_histories(batch, self.result_schema)
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
            file = self._file(number)
            count = len(batch.ids) if dataset.item == CASE else int(file.offsets[dataset.item][-1]) if file else 0
            if file:
                try:
                    _checked(self.read(number, dataset, 0, count * dataset.width), dataset)
                except MisshapenError as error:
                    raise self._refusal(number, error) from error

    def read(self, number: int, dataset: Dataset, first: int, count: int) -> bytes:
        """Return `count` values of a batch's dataset from value `first` on, as bytes."""
        if not count:
            return b""  # a dataset without values has no offset in the file
        file, path = self._file(number), self.run.batches[number].orbits
        assert file is not None  # there are values
        assert path is not None
        if number not in self.handles:
            if len(self.handles) >= OPEN_FILES:
                self.handles.pop(next(iter(self.handles))).close()
            self.handles[number] = durable.open_regular(path)
        size, start = dataset.dtype.itemsize, file.positions[dataset.path]
        try:
            return durable.read_span(self.handles[number], start + first * size, count * size)
        except EOFError as error:
            raise durable.damaged_error(path, str(error)) from error


def write_orbits(
    path: Path, run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray, content_hash: str
) -> None:
    """Write the histories of the given rows."""
    with (
        h5py.File(path, "x", libver=HDF5_LIBRARY_VERSIONS) as file,
        OrbitFiles(run, result_schema) as orbits,
        ThreadPoolExecutor(COMPRESSORS) as threads,
    ):
        file.attrs["clearsweep"] = content_hash
        write_dataset(file, CASE_ID, id_texts(rows["id"]), fletcher32=len(rows) > 0)
        for item, dataset in offset_datasets(result_schema).items():
            _, count = orbits.extents(item, 1, rows)
            write_dataset(file, dataset, np.concatenate([[0], np.cumsum(count)]).astype("i8"), fletcher32=True)
        all_datasets, writing = datasets(result_schema), phases.innermost_phase()
        for number, dataset in enumerate(all_datasets):
            first, count = orbits.extents(dataset.item, dataset.width, rows)
            values = _case_values(orbits, dataset, rows["batch"], first, count)
            try:
                _write_dataset(file, dataset, values, count.sum(), threads)
            except MisshapenError:
                orbits.refuse_values(dataset)
            if writing:
                writing.note(share=(number + 1) / len(all_datasets))


def _case_values(
    orbits: OrbitFiles, dataset: Dataset, numbers: np.ndarray, first: np.ndarray, count: np.ndarray
) -> Iterator[bytes]:
    """Yield the bytes of every case's values, in order."""
    for group_start in range(0, len(numbers), ROWS_IN_MEMORY):
        group = slice(group_start, group_start + ROWS_IN_MEMORY)
        for number, start, values in zip(*(array[group].tolist() for array in (numbers, first, count)), strict=True):
            if values:
                yield orbits.read(number, dataset, start, values)


def _write_dataset(
    file: h5py.File, dataset: Dataset, case_values: Iterator[bytes], value_count: int, threads: ThreadPoolExecutor
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
    complete = _of_total(case_values, int(value_count) * size, dataset.path)
    row, chunks = 0, _rechunk(complete, rows * dataset.width * size)
    while batch := [chunk for _, chunk in zip(range(CHUNKS_AT_ONCE), chunks, strict=False)]:
        for content in threads.map(lambda chunk: _filter_chunk(_checked(chunk, dataset), size), batch):
            target.id.write_direct_chunk((row, *(0 for _ in shape[1:])), content)
            row += rows


def _checked(content: bytes, dataset: Dataset) -> bytes:
    """Return the bytes of values of a dataset; MisshapenError if no run writes them."""
    check_values(dataset.path, np.frombuffer(content, dataset.dtype), len(h5py.check_enum_dtype(dataset.dtype) or ()))
    return content


def _of_total(case_values: Iterator[bytes], size: int, path: str) -> Iterator[bytes]:
    """Yield `case_values`; StorageError unless they have `size` bytes in all, since later ones would be shifted."""
    total = 0
    for values in case_values:
        total += len(values)
        yield values
    if total != size:
        raise StorageError(f"{path}: {total:,} bytes of histories were read, not {size:,}; run the same command again")


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


def _filter_chunk(chunk: bytes, size: int) -> bytes:
    """Return a chunk after HDF5's shuffle, deflate and checksum filters; `size`: bytes of one value."""
    shuffled = np.frombuffer(chunk, "u1").reshape(-1, size).T.tobytes()
    content = isal_zlib.compress(shuffled, level=1)  # ten times as fast as zlib at level 1, files 10 % longer
    return content + struct.pack("<I", fletcher32(content))


def fletcher32(content: bytes) -> int:
    """Return the checksum of HDF5's filter: Fletcher's (1982) two sums of big-endian words, modulo 65535.

    A multiple of 65535 counts as 65535 unless all words are zero, because HDF5 uses an end-around carry.  Sums of
    little-endian words are 256 times as large modulo 65535, and 256 * 256 is 1.

    content : at most 32 MB, so that 32 bits hold the sums
    """
    count = -(-len(content) // 2)
    words = np.frombuffer(content + b"\0" * (-len(content) % 512), "<u2").reshape(-1, 256)
    rows, columns = words.sum(axis=1, dtype="u4"), words.sum(axis=0, dtype="u4")
    total = int(rows.sum(dtype="u8"))
    weighted = 256 * int(rows @ np.arange(len(rows), dtype="u8")) + int(columns @ np.arange(256, dtype="u8"))
    # the second sum adds up the first as it grows: word i is in it count - i times
    first, second = ((256 * value - 1) % 65535 + 1 if value else 0 for value in (total, count * total - weighted))
    return second << 16 | first
