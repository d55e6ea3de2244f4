"""Reads a run in blocks: rows are located by the indices of blocks and read on demand."""

import contextlib
import os
from collections.abc import Iterator
from functools import cached_property
from io import BufferedReader
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
import pyarrow as pa

from ..contracts.layout import Layout
from ..language.errors import DirectoryError, InputError
from . import durable
from .batch import id_text, open_table
from .blocks import IDS_FILE, SAMPLE_FILE, Block, numbers_of_blocks, read_mark
from .columns import values_of
from .datasets import ID_LENGTH, Contents
from .directory import DATASET, ORBITS_FILE, SUMMARY_FILE
from .lazy import Filter, LazySummary
from .read import StoredRun, damage_said, plausible
from .record import RECORD_FILE, check_format, damaged_error, read_record

if TYPE_CHECKING:
    import pandas as pd

READ_AROUND = 1024  # identities read on each side of the expected position
MAX_NAMED = 3  # most cases in a message


class OneBlock(StoredRun):
    """A block of a run, used like a run."""

    def __init__(self, directory: Path, block: Block, grid: dict[str, Any], layout: Layout):
        """Prepare with the run's directory, the block, the content of run.json and the layout."""
        self.directory, self.files_directory, self.block, self.grid, self.layout = (
            directory,
            directory,
            block,
            grid,
            layout,
        )

    def _path(self, name: str) -> Path:
        return self.block.files.get(name, self.directory / name)

    def orbits(self) -> contextlib.AbstractContextManager[h5py.File]:
        """Return the orbits as a context manager."""
        return self._orbits()

    @property
    def numbers(self) -> np.ndarray:
        """Return the identities of its cases, uint64, ascending."""
        content = durable.read(self._ids_file)
        if len(content) != 8 * self._row_count:
            raise damaged_error(self._ids_file, "its size is not that of the identities of the cases")
        return np.frombuffer(content, "<u8")

    @property
    def _mark(self) -> str | None:
        return None

    def _accept(self, contents: Contents) -> None:
        if not np.array_equal(contents.ids, self._ids):
            raise damaged_error(self._path(ORBITS_FILE), f"its cases are not those of {IDS_FILE}")

    @cached_property
    def _row_count(self) -> int:
        """Return the number of rows of its summary."""
        with self._table() as file:
            return int(file.metadata.num_rows)

    @property
    def _ids_file(self) -> Path:
        path = self.block.files[IDS_FILE]
        if not path.is_file():
            raise damaged_error(path, "it is missing")
        return path

    def __len__(self) -> int:
        return self._ids_file.stat().st_size // 8

    def rows_between(self, low: int, high: int) -> np.ndarray:
        """Return the range of rows (first, end) whose identities are from `low` to `high`.

        Identities are uniformly distributed hashes, so a few kilobytes around the expected row are read.
        """
        with durable.open_regular(self._ids_file) as file:
            return np.array([_count_below(file, len(self), low), _count_below(file, len(self), high + 1)])

    def id_at(self, index: int) -> str:
        """Return the identity of the case at an index."""
        with durable.open_regular(self._ids_file) as file:
            return id_text(int(_read_ids(file, index, index + 1)[0]))

    @cached_property
    def _ids(self) -> np.ndarray:
        return np.array([id_text(value).encode() for value in self.numbers.tolist()], f"S{ID_LENGTH}")


class BlockedRun(StoredRun):
    """The results of a run in blocks.

    Attributes and methods are those of StoredRun.  `summary` is lazy: see `LazySummary`.  Opening verifies the checksum
    of run.json; pages of the summaries are verified on reading, and `status --verify` compares all checksums.
    """

    def __init__(self, directory: str | Path, *, partial: bool = False):
        """Open a directory; with `partial`, an unfinished run has the blocks that are finished so far."""
        self.directory = self.files_directory = Path(directory)
        self.grid = read_record(self.directory)
        check_format(self.directory, self.grid)
        if "merged" not in self.grid and not partial:
            raise DirectoryError(
                f"{directory}: its run is not finished; run the grid again with --out {directory}, which computes only "
                "missing cases. To read the finished cases, use report --partial or clearsweep.open(..., partial=True)"
            )
        self.layout = Layout.read(self.grid["layout"])
        stored = [int(name[:5]) for name in _summary_names(self.directory / DATASET)]
        is_merged = "merged" in self.grid
        if is_merged and (missing := sorted(set(self.grid["blocks"]["numbers"]) - set(stored))):
            raise damaged_error(Block(self.directory, missing[0]).files[SUMMARY_FILE], "it is missing")
        if is_merged:
            listed = self.grid["blocks"]["numbers"]
        else:
            listed = [block for block in numbers_of_blocks(self.directory) if read_mark(Block(self.directory, block))]
        self.block_runs = [
            OneBlock(self.directory, Block(self.directory, number), self.grid, self.layout) for number in listed
        ]
        if not self.block_runs:
            raise DirectoryError(f"{directory}: no block of its run is finished yet; `status` shows the progress")

    @property
    def files(self) -> tuple[str, ...]:
        """Return the names of the files and folders that a reader uses."""
        return (f"{DATASET}/", f"blocks/*/{ORBITS_FILE}", RECORD_FILE)

    def _path(self, name: str) -> Path:
        return self.block_runs[0]._path(name)

    @cached_property
    def _marks(self) -> list[dict[str, Any]]:
        marks = []
        for block_run in self.block_runs:
            mark = read_mark(block_run.block)
            if mark is None:
                raise damaged_error(block_run.block.mark, "it or one of its files has changed since it was written")
            marks.append(mark)
        return marks

    def marks(self) -> list[dict[str, Any]]:
        """Return the marks of all blocks."""
        return self._marks

    def __len__(self) -> int:
        return sum(len(block_run) for block_run in self.block_runs)

    @property
    def summary(self) -> LazySummary:
        """Return the summary, of which only requested parts are read."""
        return LazySummary(self)

    def column(self, name: str) -> "pd.Series":
        """Return one column of the summary for all cases, block after block; a number takes 8 bytes."""
        import pandas as pd

        values = [block[name] for block in self.blocks([name])]
        return pd.Series(np.concatenate(values) if values else np.empty(0), name=name)

    def blocks(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield these columns of the summary, name -> values, for a few thousand rows at a time, block after block."""
        for block_run in self.block_runs:
            yield from block_run.blocks(columns)

    def sample_and_extremes(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield these columns for the random and the extreme rows of every block."""
        for block_run in self.block_runs:
            table = _read_sample(block_run.block)
            if len(table):
                yield {name: values_of(table[name].combine_chunks()) for name in columns}

    def sampled_parts(self) -> Iterator[tuple[OneBlock, pa.Table]]:
        """Yield every block with its random rows and those with the extremes of a column over all blocks."""
        extreme_ids: set[str] = set()
        for name in {name for mark in self._marks for name in mark["ranges"]}:
            ranges = [mark["ranges"][name] for mark in self._marks if name in mark["ranges"]]
            extreme_ids |= {min(ranges)[2], max(ranges, key=lambda extreme: extreme[1])[3]}
        for block_run, mark in zip(self.block_runs, self._marks, strict=True):
            table = _read_sample(block_run.block)
            ids = table["case_id"].to_pylist()
            selected = [index for index, case_id in enumerate(ids) if index < mark["drawn"] or case_id in extreme_ids]
            yield block_run, table.take(pa.array(selected, pa.int64()))

    def block_of(self, prefix: str) -> OneBlock:
        """Return the block of the case whose case_id begins with `prefix`; InputError if none or several do."""
        text = str(prefix)
        matches = []
        if 0 < len(text) <= ID_LENGTH and all(letter in "0123456789abcdef" for letter in text):
            low, high = int(text.ljust(ID_LENGTH, "0"), 16), int(text.ljust(ID_LENGTH, "f"), 16)
            for block_run in self.block_runs:
                first, last = block_run.rows_between(low, high).tolist()
                matches += [(block_run.id_at(index), block_run) for index in range(first, min(last, first + MAX_NAMED))]
        if not matches:
            raise InputError(f"{self.directory}: no case {prefix!r}; the case_id column of summary/ lists them")
        if len(matches) > 1:
            examples = ", ".join(case_id for case_id, _ in matches[:MAX_NAMED])
            raise InputError(
                f"{self.directory}: several cases begin with {prefix!r} ({examples}, ...); write more characters"
            )
        return matches[0][1]

    def full_id(self, prefix: str) -> str:
        """Return the case_id that begins with `prefix`; InputError if none or several do."""
        return self.block_of(prefix).full_id(prefix)

    def orbit(self, case_id: str) -> "pd.DataFrame":
        """Return the result of `StoredRun.orbit`."""
        return self.block_of(case_id).orbit(case_id)

    def events(self, case_id: str) -> "pd.DataFrame":
        """Return the result of `StoredRun.events`."""
        return self.block_of(case_id).events(case_id)

    def poincare(self, case_id: str) -> "pd.DataFrame":
        """Return the result of `StoredRun.poincare`."""
        return self.block_of(case_id).poincare(case_id)

    def wear(self, case_id: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return the result of `StoredRun.wear`."""
        return self.block_of(case_id).wear(case_id)

    def history(self, case_id: str) -> dict[str, np.ndarray]:
        """Return the result of `StoredRun.history`."""
        return self.block_of(case_id).history(case_id)

    def peak_revolution(self, case_id: str) -> "pd.DataFrame":
        """Return the result of `StoredRun.peak_revolution`."""
        return self.block_of(case_id).peak_revolution(case_id)

    @property
    def worst(self) -> list[str]:
        """Return the cases whose peak revolution was saved, block after block."""
        return (
            [case_id for block_run in self.block_runs for case_id in block_run.worst]
            if self.grid["save"].get("worst")
            else []
        )

    def event_blocks(self) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
        """Yield the results of `StoredRun.event_blocks`, block after block."""
        for block_run in self.block_runs:
            yield from block_run.event_blocks()

    def matching(self, filters: Filter, columns: list[str] | None = None) -> "pd.DataFrame":
        """Return the rows of the summary that pass some filters; blocks that cannot contain any are not read."""
        tables, schema = [], None
        for block_run in self._matching_blocks(filters):
            with damage_said(path := block_run._path(SUMMARY_FILE)), open_table(path) as file:
                schema = file.schema_arrow
                groups = filters.groups(file, block_run.rows_between)
                names = None if columns is None else list(dict.fromkeys([*columns, *filters.columns]))
                for group in groups:
                    table = plausible(file.read_row_group(group, names, use_threads=False))
                    mask = filters.mask(table)
                    if mask.any():
                        tables.append(table.filter(pa.array(mask)))
        if schema is None:
            with damage_said(path := self._path(SUMMARY_FILE)), open_table(path) as file:
                schema = file.schema_arrow
        selected = pa.schema([schema.field(name) for name in columns]) if columns is not None else schema
        table = pa.concat_tables([selected.empty_table(), *(table.select(selected.names) for table in tables)])
        return to_frame(table)

    def _matching_blocks(self, filters: Filter) -> Iterator[OneBlock]:
        """Yield the blocks that may have matching rows."""
        ids = filters.case_ids
        if ids is not None:
            numbers = [int(case_id, 16) for case_id in ids]
            for block_run in self.block_runs:
                if any(np.ptp(block_run.rows_between(value, value)) for value in numbers):
                    yield block_run
            return
        for block_run, mark in zip(self.block_runs, self._marks, strict=True):
            if filters.may_match_ranges(mark["ranges"]):
                yield block_run


def _summary_names(folder: Path) -> list[str]:
    names = os.listdir(folder) if folder.is_dir() else []
    return [name for name in names if name.endswith(".parquet") and name[:5].isdigit()]


def _read_sample(block: Block) -> pa.Table:
    path = block.files[SAMPLE_FILE]
    with damage_said(path), open_table(path) as file:
        return plausible(file.read(use_threads=False))


def to_frame(table: pa.Table) -> "pd.DataFrame":
    """Return a table as a DataFrame whose `attrs` hold units and descriptions by column."""
    frame = table.replace_schema_metadata(None).to_pandas(use_threads=False)
    for name, key in (("units", b"unit"), ("descriptions", b"description")):
        frame.attrs[name] = {field.name: field.metadata[key].decode() for field in table.schema}
    return frame


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
