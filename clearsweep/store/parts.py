"""One part of a run: its rows, histories and identities, whose content is checked as it is read."""

import contextlib
import os
from collections.abc import Iterator, Mapping
from functools import cached_property
from io import BufferedReader
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..language.errors import ClearsweepError, DirectoryError
from . import durable
from .batch import GROUP_ROWS, open_table
from .datasets import Hdf5, Stored, h5py, id_text, is_plausible, largest_of, open_orbits
from .directory import IDS_FILE, ORBITS_FILE, SUMMARY_FILE
from .record import MisshapenError, damaged_error

if TYPE_CHECKING:
    import pandas as pd

READ_AROUND = 1024  # identities read on each side of the expected position
T = TypeVar("T", pa.Table, pa.RecordBatch)


class Part:
    """One part of a run: the rows of some cases, sorted by identity, their histories, and their identities."""

    def __init__(self, files: Mapping[str, Path], stored: Stored, mark: str | None = None):
        """Prepare with the files by the names that they have in a run of one part.

        mark : that of the run, which orbits.h5 must have; None: it has none of its own.
        """
        self.files, self._stored, self._mark = files, stored, mark
        self._checked: tuple[int, ...] = ()  # the state of orbits.h5 when it was last checked
        self._opened: Hdf5 | None = None  # it, in this state: its chunks stay decompressed from case to case

    @contextlib.contextmanager
    def table(self, name: str = SUMMARY_FILE) -> Iterator[pq.ParquetFile]:
        """Yield a table, whose pages are verified on reading; raise DamagedError if one was changed."""
        path = self.files[name]
        with damage_said(path), open_table(path) as table:
            yield table

    @contextlib.contextmanager
    def orbits(self) -> Iterator[Hdf5]:
        """Yield orbits.h5, whose parts are verified on reading; DamagedError if it is not as a run writes it."""
        path = self.files[ORBITS_FILE]
        with damage_said(path, RuntimeError, KeyError, TypeError):  # of HDF5 and h5py
            durable.open_regular(path).close()
            state = os.stat(path)
            identity = state.st_ino, state.st_size, state.st_mtime_ns  # changes if the file is replaced or written to
            if identity == self._checked:
                if not self._opened:
                    self._opened = h5py.File(path, "r")
                yield self._opened
                return
            self._opened = None
            with open_orbits(path, self._stored, len(self), mark=self._mark) as (file, contents):
                if IDS_FILE not in self.files:
                    self.ids = contents.ids
                elif not np.array_equal(contents.ids, self.ids):
                    raise damaged_error(path, f"its cases are not those of {IDS_FILE}")
                self._checked = identity
                yield file

    def __len__(self) -> int:
        return self._row_count if IDS_FILE not in self.files else self._ids_file.stat().st_size // 8

    @cached_property
    def _row_count(self) -> int:
        """Return the number of rows of the summary."""
        with self.table() as file:
            return int(file.metadata.num_rows)

    @cached_property
    def ids(self) -> np.ndarray:
        """Return the identities of the cases, uint64, ascending; without a file of them, orbits.h5 has them."""
        if IDS_FILE not in self.files:
            with self.orbits():  # sets them
                ids: np.ndarray = self.__dict__["ids"]
                return ids
        content = durable.read(self._ids_file)
        if len(content) != 8 * self._row_count:
            raise damaged_error(self._ids_file, "its size is not that of the identities of the cases")
        return np.frombuffer(content, "<u8")

    @property
    def _ids_file(self) -> Path:
        path = self.files[IDS_FILE]
        if not path.is_file():
            raise damaged_error(path, "it is missing")
        return path

    def rows_between(self, low: int, high: int) -> tuple[int, int]:
        """Return the range of rows (first, end) whose identities are from `low` to `high`.

        Identities are uniformly distributed hashes, so a few kilobytes around the expected row are read of their file.
        Statistics of Parquet do not distinguish them: 10^8 cases in 763 parts take 40 times as long by these.
        """
        if IDS_FILE not in self.files:
            first, end = np.searchsorted(self.ids, np.uint64(low)), np.searchsorted(self.ids, np.uint64(high), "right")
            return int(first), int(end)
        with durable.open_regular(self._ids_file) as file:
            return _count_below(file, len(self), low), _count_below(file, len(self), high + 1)

    def id_at(self, index: int) -> str:
        """Return the identity of the case at an index."""
        if IDS_FILE not in self.files:
            return id_text(int(self.ids[index]))
        with durable.open_regular(self._ids_file) as file:
            return id_text(int(_read_ids(file, index, index + 1)[0]))

    def rows(self, columns: list[str] | None = None) -> Iterator[pa.RecordBatch]:
        """Yield these columns of the summary, or all, some rows at a time; DamagedError for such as no run writes."""
        with self.table() as file:
            for batch in file.iter_batches(batch_size=GROUP_ROWS, columns=columns, use_threads=False):
                yield plausible(batch)


def _read_ids(file: BufferedReader, first: int, last: int) -> np.ndarray:
    """Return some of the identities in an open file."""
    try:
        return np.frombuffer(durable.read_span(file, 8 * first, 8 * (last - first)), "<u8")
    except EOFError as error:
        raise damaged_error(Path(file.name), str(error)) from error


def _count_below(file: BufferedReader, count: int, value: int) -> int:
    """Return how many of `count` identities in an open file, ascending, are below a value."""
    expected_row, distance = (count * value) >> 64, READ_AROUND
    while True:
        first, last = max(expected_row - distance, 0), min(expected_row + distance, count)
        identities = _read_ids(file, first, last)
        if len(identities) == 0 or value >> 64:
            return count if value >> 64 else first
        if (first == 0 or identities[0] < value) and (last == count or identities[-1] >= value):
            return first + int(np.searchsorted(identities, np.uint64(value)))
        distance *= 8


@contextlib.contextmanager
def damage_said(path: Path, *errors: type[Exception]) -> Iterator[None]:
    """Convert an error in reading a file into a DirectoryError: it is damaged, unreadable or missing."""
    try:
        yield
    except ClearsweepError:
        raise
    except FileNotFoundError:
        raise unfinished_error(path.parent, path.name) from None
    except (OSError, ValueError, MisshapenError, pa.ArrowException, *errors) as error:
        if isinstance(error, OSError) and error.errno:  # the system's
            raise durable.unreadable_error(path, error) from error
        raise damaged_error(path, str(error)) from error


def unfinished_error(directory: Path, name: str = "") -> DirectoryError:
    """Return the error for an unfinished run, or for the name of a final file that is not there."""
    state = f"its run is not finished, or {name} was moved away" if name else "its run is not finished"
    return DirectoryError(
        f"{directory}: {state}; run the grid again with --out {directory}, which computes only missing cases. To read "
        "the finished cases, use report --partial or clearsweep.open(..., partial=True)"
    )


def plausible(rows: T) -> T:
    """Return rows of a table; MisshapenError if a number is not finite or if a case has no identity or status."""
    for field, column in zip(rows.schema, rows.columns, strict=True):
        chunks = column.chunks if isinstance(column, pa.ChunkedArray) else [column]
        if not all(is_plausible(chunk, largest_of(field.name)) for chunk in chunks) or (
            field.name in ("case_id", "status") and column.null_count
        ):
            raise MisshapenError(f"{field.name} has values that no run writes")
    return rows


def attributes_of(schema: pa.Schema) -> dict[str, dict[str, str]]:
    """Return `units` and `descriptions` of the columns of a table."""
    keys = {"units": b"unit", "descriptions": b"description"}
    return {name: {field.name: field.metadata[key].decode() for field in schema} for name, key in keys.items()}


def to_frame(table: pa.Table) -> "pd.DataFrame":
    """Return a table as a DataFrame whose `attrs` hold units and descriptions by column; it uses up the table."""
    attributes = attributes_of(table.schema)
    table = table.replace_schema_metadata(None)
    frame = table.to_pandas(use_threads=False, split_blocks=True, self_destruct=True)  # without a second copy
    frame.attrs |= attributes
    return frame
