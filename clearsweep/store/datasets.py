"""Columns of the tables and datasets of the orbits, as every file of results has them, and their checked reading."""

import binascii
import contextlib
import math
import os
import struct
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from isal import isal_zlib

from ..contracts import results
from ..contracts.catalogue import LIVES
from ..contracts.layout import SECTION_COUNT, Column, Layout
from . import durable
from .record import MisshapenError

# ----------------------------------------------------------------------------------------------------------------------
# Columns of Arrow tables: their fields, and their values as arrays of numpy and back, without loading pandas.


LARGEST = 1e100  # size of a number in results, far above that of a grid; beyond it is null, but see `largest_of`


def field_of(column: Column) -> pa.Field:
    """Return the field of a column; its metadata hold `unit` and `description`."""
    types = {"float": pa.float64(), "int": pa.int64(), "text": pa.string()}
    return pa.field(column.name, types[column.kind], metadata={"unit": column.unit, "description": column.description})


def column_of(values: list, kind: pa.DataType, largest: float = LARGEST) -> pa.Array:
    """Return a column, null where None or beyond `largest`; pa.array would import pandas, 0.4 s in every worker."""
    if kind == pa.string():
        valid = np.array([value is not None for value in values], bool)
        texts = [(value or "").encode() for value in values]
        content = [np.cumsum([0, *map(len, texts)]).astype("i4"), b"".join(texts)]
    else:
        numbers = np.array(values, float)  # None is NaN
        valid = np.abs(numbers) <= largest  # False for NaN
        exact_values = numbers if kind == pa.float64() else np.array(values, object)  # a count may exceed 2**53
        content = [np.where(valid, exact_values, 0).astype(kind.to_pandas_dtype())]
    return array_of([np.packbits(valid, bitorder="little"), *content], kind, len(values))


def array_of(buffers: list, kind: pa.DataType, count: int) -> pa.Array:
    """Return an Arrow array of `count` values from raw buffers; None for an absent buffer."""
    return pa.Array.from_buffers(kind, count, [None if buffer is None else pa.py_buffer(buffer) for buffer in buffers])


def largest_of(name: str) -> float:
    """Return the largest size of a number in a column; a life may be infinite."""
    return np.inf if name.endswith(LIVES) else LARGEST


def is_plausible(column: pa.Array, largest: float) -> bool:
    """Return whether all values of a column can be from `column_of`: its numbers are up to `largest`, or null."""
    if column.type != pa.float64():
        return True
    valid_count = np.count_nonzero(np.abs(values_of(column)) <= largest)
    return bool(valid_count == len(column) - column.null_count)


def values_of(column: pa.Array) -> np.ndarray:
    """Return a column as an array: numbers as float64, NaN for null, texts as objects; to_numpy would import pandas."""
    if column.type == pa.string():
        return words_of(column)
    span = slice(column.offset, column.offset + len(column))
    values = np.frombuffer(column.buffers()[1], column.type.to_pandas_dtype())[span].astype(float)
    if column.null_count:
        values[_bits(column.buffers()[0])[span] == 0] = np.nan
    return values


def words_of(column: pa.Array) -> np.ndarray:
    """Return a column of texts as objects, None for null; equal texts are one object."""
    words = column.to_pylist()
    first_of = dict[str | None, str | None]()
    return np.array([*map(first_of.setdefault, words, words)], object)


def rows_at(column: pa.Array, positions: np.ndarray) -> pa.Array:
    """Return the rows of a column at some positions; Arrow's own functions take 28 ms and 12 MB to load."""
    places = positions + column.offset
    valid, content, *texts = column.buffers()
    if texts:
        bounds = np.frombuffer(content, "i4")
        lengths = bounds[places + 1] - bounds[places]
        ends = np.concatenate([[0], np.cumsum(lengths)])
        letters = np.repeat(bounds[places] - ends[:-1], lengths) + np.arange(ends[-1])
        taken = [ends.astype("i4"), np.frombuffer(texts[0] or b"", "u1")[letters]]
    else:
        taken = [np.frombuffer(content, column.type.to_pandas_dtype())[places]]
    valid = valid and np.packbits(_bits(valid)[places], bitorder="little")
    return array_of([valid, *taken], column.type, len(positions))


def table_rows_at(table: pa.Table, positions: np.ndarray) -> pa.Table:
    """Return the rows of a table at some positions as a copy, so that the memory of the others can be freed."""
    columns = [rows_at(column.combine_chunks(), positions) for column in table.columns]
    return pa.Table.from_arrays(columns, schema=table.schema)


def _bits(buffer: pa.Buffer) -> np.ndarray:
    """Return the bits of a buffer, which are 0 for the nulls of a column."""
    return np.unpackbits(np.frombuffer(buffer, "u1"), bitorder="little")


# ----------------------------------------------------------------------------------------------------------------------
# The datasets of the orbits, and the opening of a file that has exactly these, as plain arrays.


CASE, SAMPLE, EVENT, SECTION, NODE = "case", "sample", "event", "section", "node"
ID_LENGTH = 16  # hexadecimal digits of a case_id
GROUP = "worst"  # of orbits.h5: the peak revolutions of the worst cases
JOINT, TURNS, OFFSETS = f"{GROUP}/joint", f"{GROUP}/turns", f"{GROUP}/offsets"
_PEAK, _PEAK_SAMPLE = "peak", "sample of a peak"  # items of this group
_FILTERS = {1, 2, 3}  # deflate, shuffle and Fletcher32 of HDF5: another could load a library
_IDS_AT_ONCE = 4096  # identities read at a time
Hdf5 = Any  # an object of h5py
LARGEST_CLOCK = 1e15  # s or rad; a step of a rounded crank angle is then 0.1 rad
_CLOCKS = ("t", "crank_angle", "events/t")  # never NaN


class _Package:
    """The package h5py, which is loaded when it is first used: only where histories are read or written."""

    def __getattr__(self, name: str) -> Any:
        import h5py as package

        return getattr(package, name)


h5py = _Package()


class Stored(NamedTuple):
    """What determines the datasets of a run."""

    layout: Layout
    histories: bool  # whether samples and events are stored


class Dataset(NamedTuple):
    """One dataset of the orbits: an array of `shape` per `item` (case, sample, event, section or node of a life)."""

    path: str
    dtype: np.dtype
    unit: str
    description: str
    item: str  # CASE, SAMPLE, EVENT, SECTION or NODE
    shape: tuple[int, ...] = ()

    @property
    def width(self) -> int:
        """Return the number of values per `item`."""
        return math.prod(self.shape)


def _names_dtype(names: Sequence[str]) -> np.dtype:
    """Return the type of the numbers of some names, as h5py marks an enum; HDF5 needs at least one."""
    return np.dtype("i1", metadata={"enum": {name: code for code, name in enumerate(names or ["none"])}})


def event_datasets(layout: Layout) -> list[Dataset]:
    """Return the datasets of contact events."""
    joints, kinds, number = _names_dtype(layout.contacts), _names_dtype(results.EVENT_KINDS), np.dtype("f8")
    peak = "largest normal force of the contact that ends there, 0 at an onset"
    return [
        Dataset("events/t", number, "s", "time of the event", EVENT),
        Dataset("events/joint", joints, "1", "joint of the event", EVENT),
        Dataset("events/kind", kinds, "1", "contact begins (on) or ends (off)", EVENT),
        Dataset("events/rate", number, "m/s", "closing rate, closing positive", EVENT),
        Dataset("events/force_peak", number, "N", peak, EVENT),
    ]


def section_datasets(layout: Layout) -> list[Dataset]:
    """Return the datasets of values stored at crank angle 0 of every revolution."""
    if not layout.sections:
        return []
    channels = {channel.name: channel for channel in layout.channels}
    text = "turns of the crank, its angle over 2 pi, at each section"
    datasets = [Dataset(SECTION_COUNT, np.dtype("i8"), "1", text, SECTION)]
    for name, path in layout.sections:
        text = f"{channels[name].description}, at crank angle 0"
        datasets.append(Dataset(path, np.dtype("f8"), channels[name].unit, text, SECTION))
    return datasets


#: History of a life for each joint with wear: name, unit, description, and whether it has a value per bin.
_JOINT_HISTORIES = (
    ("wear_depth_max", "m", "largest wear depth of either body", False),
    ("clearance", "m", "largest eccentricity, over directions, at which the surfaces touch first", False),
    ("force_peak", "N", "largest normal force of the block at this node", False),
    ("wear_rate", "m/s", "largest wear rate of a bin", False),
    ("profile_bearing", "m", "wear depth of the bearing in angular bins of its own frame", True),
    ("profile_journal", "m", "wear depth of the journal in angular bins of its own frame", True),
)


def life_datasets(layout: Layout) -> list[Dataset]:
    """Return the datasets of the history of a life, node by node."""
    if not layout.life:
        return []
    text = "revolutions from the unworn start to the limit, or to the last block"
    datasets = [Dataset(f"{results.HISTORY}revolutions", np.dtype("f8"), "1", text, NODE)]
    for joint in layout.joints:
        for name, unit, text, has_bins in _JOINT_HISTORIES if joint.wear_bins else ():
            path, shape = f"{results.HISTORY}{joint.name}/{name}", (joint.wear_bins,) if has_bins else ()
            datasets.append(Dataset(path, np.dtype("f8"), unit, text, NODE, shape))
    return datasets


CASE_ID = Dataset("case_id", np.dtype(f"S{ID_LENGTH}"), "1", "identity of the case, ascending", CASE)


def datasets(stored: Stored) -> tuple[Dataset, ...]:
    """Return the datasets of the orbits for `case_id` and the offsets."""
    all_datasets = []
    if stored.histories:
        channels = stored.layout.stored
        all_datasets += [Dataset(item.name, np.dtype("f8"), item.unit, item.description, SAMPLE) for item in channels]
        all_datasets += [*event_datasets(stored.layout), *section_datasets(stored.layout)]
    for joint in stored.layout.joints:
        if joint.wear_bins:
            text = "wear depth of the {} in angular bins of its own frame"
            shape: tuple[int, ...] = (joint.wear_bins,)
            if joint.is_spatial:
                text, shape = f"{text}, and in bins along its axis", (*shape, joint.wear_rows)
            all_datasets += [
                Dataset(f"wear/{joint.name}/{body}", np.dtype("f8"), "m", text.format(body), CASE, shape)
                for body in ("bearing", "journal")
            ]
    return (*all_datasets, *life_datasets(stored.layout))


def offset_datasets(stored: Stored) -> dict[str, Dataset]:
    """Return the datasets with the offsets of cases, by the counted item: sample, event and so on."""
    text = "first {} of each case; the last value is their number"
    offsets = {SAMPLE: Dataset("offsets", np.dtype("i8"), "1", text.format(SAMPLE), CASE)}
    if stored.histories:
        offsets[EVENT] = Dataset("events/offsets", np.dtype("i8"), "1", text.format(EVENT), CASE)
        if stored.layout.sections:
            offsets[SECTION] = Dataset("poincare/offsets", np.dtype("i8"), "1", text.format(SECTION), CASE)
    if stored.layout.life:
        offsets[NODE] = Dataset(f"{results.HISTORY}offsets", np.dtype("i8"), "1", text.format(NODE), CASE)
    return offsets


def peak_datasets(layout: Layout) -> tuple[Dataset, ...]:
    """Return the datasets of the peak revolutions of the worst cases, the worst case first."""
    joints = _names_dtype([joint.name for joint in layout.joints])
    return (
        CASE_ID._replace(path=f"{GROUP}/case_id", description="identity of the case, the worst first", item=_PEAK),
        Dataset(JOINT, joints, "1", "joint whose largest normal force it is", _PEAK),
        Dataset(TURNS, np.dtype("f8"), "1", "revolutions before the first sample", _PEAK),
        Dataset(OFFSETS, np.dtype("i8"), "1", "first sample of each case; the last value is their number", _PEAK),
        *(
            Dataset(f"{GROUP}/{column.name}", np.dtype("f8"), column.unit, column.description, _PEAK_SAMPLE)
            for column in layout.channels
        ),
    )


# ---------------------------------------------------------------------------------------------- checked reading


class _Expected(NamedTuple):
    """The datasets of a file, all by path."""

    datasets: dict[str, Dataset]
    types: dict[str, Any]  # HDF5's
    offsets: dict[str, str]  # item -> path of its offsets
    groups: frozenset[str]


@lru_cache(8)
def _expected(stored: Stored, *, with_peaks: bool) -> _Expected:
    """Return what the contract says of a file."""
    offsets, peaks = offset_datasets(stored), peak_datasets(stored.layout) if with_peaks else ()
    all_datasets = [CASE_ID, *offsets.values(), *datasets(stored), *peaks]
    by_path = {dataset.path: dataset for dataset in all_datasets}
    paths_of_offsets = {item: dataset.path for item, dataset in offsets.items()}
    paths_of_offsets |= {_PEAK_SAMPLE: OFFSETS} if with_peaks else {}
    groups = {path[:end] for path in by_path for end in range(len(path)) if path[end] == "/"}
    types = {path: h5py.h5t.py_create(dataset.dtype, logical=True) for path, dataset in by_path.items()}
    return _Expected(by_path, types, paths_of_offsets, frozenset(groups))


class Contents(NamedTuple):
    """What a checked file says of its cases."""

    ids: np.ndarray  # uint64, one for each case
    offsets: dict[str, np.ndarray]  # item -> first item of each case and the number of items, int64
    positions: dict[str, int]  # path -> its first byte in the file; of files of batches


@contextlib.contextmanager
def open_orbits(
    path: Path, stored: Stored, rows: int, *, mark: str | None = None, plain: bool = False
) -> Iterator[tuple[Hdf5, Contents]]:
    """Yield a file of orbits that has the datasets of `stored` for `rows` cases, and nothing else; with its contents.

    An HDF5 file can refer to other files, pipes and libraries.  So every link must be a hard one, and every dataset an
    array in this file with the type and the shape of the contract.  `mark`: that of the run to which it must belong;
    `plain`: without chunks and filters, as in a batch.

    Raises MisshapenError, or what HDF5 raises: OSError, RuntimeError, KeyError, ValueError or TypeError.
    """
    durable.open_regular(path).close()
    with h5py.File(path, "r") as file:
        stored_mark = file.attrs["clearsweep"] if mark is not None else None
        if mark is not None and not (isinstance(stored_mark, str) and stored_mark == mark):
            raise MisshapenError("it belongs to another run than summary.parquet")
        yield file, _check_file(file, stored, rows, os.stat(path).st_size if plain else None)


def _check_file(file: Hdf5, stored: Stored, rows: int, plain_size: int | None) -> Contents:
    """Return the contents of a file; raise MisshapenError if it has others than `stored` says."""
    has_peaks = bool(file.id.links.exists(GROUP.encode()))  # `in` would follow a link
    expected = _expected(stored, with_peaks=has_peaks)
    _check_links(file, expected)
    opened = {path: h5py.h5d.open(file.id, path.encode()) for path in expected.datasets}
    for path, dataset in opened.items():
        _check_dataset(path, dataset, expected.types[path], plain=plain_size is not None)
    counts = {CASE: rows, _PEAK: opened[f"{GROUP}/case_id"].shape[0] if has_peaks else 0}
    contents = Contents(_read_ids(file, rows, has_peaks=has_peaks), {}, {})
    for item, path in expected.offsets.items():
        cases = counts[_PEAK if item == _PEAK_SAMPLE else CASE]
        _check_shape(path, opened[path].shape, (cases + 1,))
        offsets = contents.offsets[item] = file[path][:]
        counts[item] = int(offsets[-1])
        if offsets[0] != 0 or (offsets[1:] < offsets[:-1]).any():
            raise MisshapenError(f"{path} does not ascend from 0")
    for path, dataset in expected.datasets.items():
        if path not in expected.offsets.values():
            _check_shape(path, opened[path].shape, (counts[dataset.item], *dataset.shape))
        if plain_size is not None and math.prod(opened[path].shape):
            position, size = opened[path].get_offset(), math.prod(opened[path].shape) * dataset.dtype.itemsize
            if position is None or position + size > plain_size:
                raise MisshapenError(f"{path} is not in the file")
            contents.positions[path] = position
    return contents


def _check_links(file: Hdf5, expected: _Expected) -> None:
    """Check that the names in a file are those of the contract, and that none leads elsewhere."""
    missing, refused = set(expected.datasets), []

    def visit(name: bytes, link: Any) -> str | None:
        path = name.decode(errors="replace")
        missing.discard(path)
        if link.type != h5py.h5l.TYPE_HARD or (path not in expected.datasets and path not in expected.groups):
            refused.append(path)
        return refused[0] if refused else None  # a text ends the visit

    file.id.links.visit(visit, info=True)
    if refused:
        raise MisshapenError(f"it has {refused[0][:60]!r}, which leads elsewhere or is none of its datasets")
    if missing:
        raise MisshapenError(f"it has no {min(missing)!r}")


def _check_dataset(path: str, dataset: Any, expected_type: Any, *, plain: bool) -> None:
    """Check the type of a dataset, and that its values are in this file."""
    properties = dataset.get_create_plist()
    filters = {properties.get_filter(number)[0] for number in range(properties.get_nfilters())}
    layouts = (h5py.h5d.CONTIGUOUS,) if plain else (h5py.h5d.CONTIGUOUS, h5py.h5d.CHUNKED)
    if properties.get_layout() not in layouts or properties.get_external_count() or not filters <= _FILTERS:
        raise MisshapenError(f"{path} is no plain dataset of this file")
    if not dataset.get_type().equal(expected_type):
        raise MisshapenError(f"{path} has another type")


def _check_shape(path: str, shape: tuple[int, ...], expected: tuple[int, ...]) -> None:
    if shape != expected:
        raise MisshapenError(f"{path} has the shape {shape}, not {expected}")


def _read_ids(file: Hdf5, rows: int, *, has_peaks: bool) -> np.ndarray:
    """Return the identities of the cases, uint64; they are checked, and those of peaks are among them."""
    dataset, ids = file[CASE_ID.path], np.empty(rows, "u8")
    _check_shape(CASE_ID.path, dataset.shape, (rows,))
    for first in range(0, rows, _IDS_AT_ONCE):
        ids[first : first + _IDS_AT_ONCE] = ids_of_texts(dataset[first : first + _IDS_AT_ONCE].tobytes())
    if has_peaks and not np.isin(ids_of_texts(file[f"{GROUP}/case_id"][:].tobytes()), ids).all():
        raise MisshapenError(f"{GROUP}/case_id has other cases")
    return ids


def id_text(value: int) -> str:
    """Return a case_id as text."""
    return f"{value:0{ID_LENGTH}x}"


def id_texts(ids: np.ndarray) -> np.ndarray:
    """Return case_ids as texts of the dtype CASE_ID, from numbers (uint64)."""
    return np.frombuffer(binascii.hexlify(ids.astype(">u8").data), CASE_ID.dtype)


def ids_of_texts(texts: bytes) -> np.ndarray:
    """Return case_ids as numbers, uint64; MisshapenError for other texts."""
    try:
        ids = np.frombuffer(binascii.unhexlify(texts), ">u8").astype("u8")
    except ValueError:
        ids = np.empty(0, "u8")
    if id_texts(ids).tobytes() != texts:
        raise MisshapenError(f"{CASE_ID.path} has other texts than identities")
    return ids


def read_values(file: Hdf5, path: str, span: Any) -> np.ndarray:
    """Return a part of a dataset of a checked file; MisshapenError for values that no run writes.

    Codes are those of a word; times and crank angles are up to LARGEST_CLOCK, other numbers up to LARGEST, or NaN.
    """
    values: np.ndarray = file[path][span]
    words = h5py.check_enum_dtype(file[path].dtype)
    try:
        if words is not None:
            check_values(path, values, len(words))
        elif values.dtype.kind == "f":
            check_values(path, values)
    except MisshapenError as error:  # the next run does not read them: that would take as long as merging
        raise MisshapenError(f"{error}, move the file away first") from None
    return values


def check_values(path: str, values: np.ndarray, codes: int = 0) -> None:
    """Raise MisshapenError if numbers, or the codes of `codes` words, are such as no run writes."""
    if codes:
        is_valid = not values.size or (values.min() >= 0 and values.max() < codes)
    elif path in _CLOCKS:
        is_valid = bool((np.abs(values) <= LARGEST_CLOCK).all())
    else:
        is_valid = not (np.abs(values) > LARGEST).any()
    if not is_valid:
        raise MisshapenError(f"{path} has values that no run writes")


def filter_chunk(chunk: bytes, size: int) -> bytes:
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
