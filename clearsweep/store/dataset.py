"""A run in blocks as a dataset of Parquet parts: `pyarrow.dataset` finds the rows that meet a condition.

The summary is lazy: columns compared with values become a condition, and only the parts, row groups and columns that it
asks for are read.  The mark of a block guarantees the ranges of its columns, and statistics those of its row groups.
"""

import operator
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property, partialmethod
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pyarrow as pa

from ..contracts.layout import Layout
from ..language.errors import DamagedError, DirectoryError, InputError
from . import durable
from .batch import GROUP_ROWS
from .blocks import SAMPLE_FILE, Block, numbers_of_blocks, read_mark
from .datasets import EVENT, ID_LENGTH, Stored, read_values, table_rows_at, values_of
from .directory import DATASET, ORBITS_FILE, SUMMARY_FILE
from .parts import Part, attributes_of, damage_said, plausible, to_frame, unfinished_error
from .read import EVENT_COLUMNS, HEXADECIMAL, OFFSETS_BY_ITEM, StoredRun
from .record import RECORD_FILE, check_format, damaged_error, read_record

if TYPE_CHECKING:  # pyarrow.dataset loads pandas, which takes a second
    import pandas as pd
    import pyarrow.compute as pc
    import pyarrow.dataset as pds

LARGEST_EXACT = 2**53  # size of a whole number that a mark has exactly


class Condition(NamedTuple):
    """A condition on columns of a summary; `&`, `|` and `~` combine them.  No comparison with null is met."""

    expression: Any  # a pyarrow.compute.Expression; None: every row
    columns: frozenset[str]
    ids: frozenset[str] | None = None  # identities of the rows that may meet it; None: of any

    def __and__(self, other: "Condition") -> "Condition":
        ids = self.ids if other.ids is None else other.ids if self.ids is None else self.ids & other.ids
        return Condition(self.expression & other.expression, self.columns | other.columns, ids)

    def __or__(self, other: "Condition") -> "Condition":
        ids = None if self.ids is None or other.ids is None else self.ids | other.ids
        return Condition(self.expression | other.expression, self.columns | other.columns, ids)

    def __invert__(self) -> "Condition":
        return Condition(~self.expression, self.columns)


EVERY_ROW = Condition(None, frozenset())


class LazyColumn:
    """A column of a lazy summary: compared with a value it is a condition; anything else reads it, as a Series."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, run: "BlockedRun", name: str):
        """Prepare for a run and the name of the column."""
        self._run, self._name = run, name

    def _condition(self, compare: Callable[[Any, Any], Any], *values: Any) -> Condition:
        """Return the condition that `compare` makes of a column and values; InputError for values of another kind."""
        import pyarrow.compute as pc

        kind = self._run.schema.field(self._name).type
        for value in values:
            if isinstance(value, str) != (kind == pa.string()):
                expected = "a text" if kind == pa.string() else "a number"
                raise InputError(f"{self._name}: is compared with {value!r}; expected {expected}")
        ids = frozenset(values) if self._name == "case_id" and compare in (operator.eq, _is_in) else None
        operand = pa.array(values, kind) if compare is _is_in else values[0]
        return Condition(compare(pc.field(self._name), operand), frozenset([self._name]), ids)

    __eq__: Callable[..., Condition] = partialmethod(_condition, operator.eq)  # type: ignore[assignment]
    __ne__: Callable[..., Condition] = partialmethod(_condition, operator.ne)  # type: ignore[assignment]
    __lt__: Callable[..., Condition] = partialmethod(_condition, operator.lt)  # type: ignore[assignment]
    __le__: Callable[..., Condition] = partialmethod(_condition, operator.le)  # type: ignore[assignment]
    __gt__: Callable[..., Condition] = partialmethod(_condition, operator.gt)  # type: ignore[assignment]
    __ge__: Callable[..., Condition] = partialmethod(_condition, operator.ge)  # type: ignore[assignment]

    def isin(self, values: Any) -> Condition:
        """Return the condition of one of some values."""
        return self._condition(_is_in, *values)

    def __len__(self) -> int:
        return len(self._run)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._run.column(self._name).tolist())

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return np.asarray(self._run.column(self._name), dtype)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        import pandas as pd

        return getattr(pd.Series(self._run.column(self._name), name=self._name), name)


def _is_in(field: "pc.Expression", values: pa.Array) -> "pc.Expression":
    return field.isin(values)


class LazySummary:
    """The summary of a run in blocks: used like a DataFrame, but only requested parts are read.

    `summary[summary["case_id"] == "..."]` and `summary[(summary["drive.speed"] > 100.0) & ...]` are DataFrames with the
    rows that meet the condition; `summary["column"]` compares without being read; `summary.frame()` reads everything.
    """

    def __init__(self, run: "BlockedRun"):
        """Take the run."""
        self._run = run

    def __len__(self) -> int:
        return len(self._run)

    def __repr__(self) -> str:
        return f"<lazy summary: {len(self):,} cases, {len(self.columns)} columns>"

    @property
    def columns(self) -> list[str]:
        """Return the names of the columns."""
        return list(self._run.schema.names)

    @property
    def attrs(self) -> dict[str, dict[str, str]]:
        """Return `units` and `descriptions` by column."""
        return attributes_of(self._run.schema)

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __getitem__(self, selection: "str | list[str] | Condition") -> Any:
        if isinstance(selection, Condition):
            return self._run.matching(selection)
        if isinstance(selection, list):
            return self._run.matching(EVERY_ROW, selection)
        if selection not in self.columns:
            raise KeyError(selection)
        return LazyColumn(self._run, selection)

    def frame(self) -> "pd.DataFrame":
        """Return the whole summary as a DataFrame, block after block."""
        return self._run.matching(EVERY_ROW)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self[name] if name in self.columns else getattr(self.frame(), name)


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
        is_merged = "merged" in self.grid
        if not is_merged and not partial:
            raise unfinished_error(self.directory)
        self.layout = Layout.read(self.grid["layout"])
        if is_merged:
            listed = self.grid["blocks"]["numbers"]
            folder = self.directory / DATASET
            stored = set(os.listdir(folder)) if folder.is_dir() else set()
            missing = (block for block in self._blocks(listed) if block.files[SUMMARY_FILE].name not in stored)
            if lost := next(missing, None):
                raise damaged_error(lost.files[SUMMARY_FILE], "it is missing")
        else:
            listed = [block for block in numbers_of_blocks(self.directory) if read_mark(Block(self.directory, block))]
        if not listed:
            raise DirectoryError(f"{directory}: no block of its run is finished yet; `status` shows the progress")
        self.listed, names = self._blocks(listed), Stored(self.layout, self.histories)
        self.parts = [Part(block.files, names) for block in self.listed]

    def _blocks(self, numbers: Iterable[int]) -> list[Block]:
        return [Block(self.directory, number) for number in numbers]

    @property
    def files(self) -> tuple[str, ...]:
        """Return the names of the files and folders that a reader uses."""
        return (f"{DATASET}/", f"blocks/*/{ORBITS_FILE}", RECORD_FILE)

    @cached_property
    def _marks(self) -> list[dict[str, Any]]:
        marks = []
        for block in self.listed:
            mark = read_mark(block)
            if mark is None:
                raise damaged_error(block.mark, "it or one of its files has changed since it was written")
            marks.append(mark)
        return marks

    @cached_property
    def samples(self) -> list[pa.Table]:
        """Return the random and the extreme rows of every block."""
        return list(map(_read_sample, self.parts))

    def marks(self) -> list[dict[str, Any]]:
        """Return the marks of all blocks."""
        return self._marks

    @property
    def summary(self) -> LazySummary:
        """Return the summary, of which only requested parts are read."""
        return LazySummary(self)

    def sample_and_extremes(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield these columns for the random and the extreme rows of every block."""
        for table in self.samples:
            if len(table):
                yield {name: values_of(table[name].combine_chunks()) for name in columns}

    def sampled_parts(self) -> Iterator[tuple[Part, pa.Table]]:
        """Yield every part with its random rows and those with the extremes of a column over all parts."""
        extreme_ids: set[str] = set()
        for name in {name for mark in self._marks for name in mark["ranges"]}:
            ranges = [mark["ranges"][name] for mark in self._marks if name in mark["ranges"]]
            extreme_ids |= {min(ranges)[2], max(ranges, key=lambda extreme: extreme[1])[3]}
        for part, mark, table in zip(self.parts, self._marks, self.samples, strict=True):
            ids = table["case_id"].to_pylist()
            selected = [index for index, case_id in enumerate(ids) if index < mark["drawn"] or case_id in extreme_ids]
            yield part, table_rows_at(table, np.array(selected, int))

    def matching(self, condition: Condition, columns: list[str] | None = None) -> "pd.DataFrame":
        """Return the rows of the summary that meet a condition; parts that cannot contain any are not read."""
        names = self.schema.names if columns is None else columns
        tables = [scan(fragment, condition, names) for fragment in self._fragments(condition)]
        empty = pa.schema([self.schema.field(name) for name in names]).empty_table()
        return to_frame(pa.concat_tables([empty, *tables]))

    def _fragments(self, condition: Condition) -> "list[pds.Fragment]":
        """Return the summaries that may have rows that meet a condition."""
        import pyarrow.dataset as pds
        from pyarrow.fs import LocalFileSystem

        files = [part.files[SUMMARY_FILE] for part in self.parts]
        guarantees: list[pc.Expression | None] = [None] * len(files)
        if condition.ids is not None:  # an identity is in the file of identities of its part, or in none
            valid = [text for text in condition.ids if len(text) == ID_LENGTH and HEXADECIMAL.issuperset(text)]
            numbers = [int(case_id, 16) for case_id in valid]
            has_value = [any(np.ptp(part.rows_between(value, value)) for value in numbers) for part in self.parts]
            files = [file for file, is_possible in zip(files, has_value, strict=True) if is_possible]
        elif condition.columns:
            guarantees = [_guarantee(self.schema, mark["ranges"], condition.columns) for mark in self._marks]
        options = pds.ParquetFragmentScanOptions(pre_buffer=False, page_checksum_verification=True)
        local, form = LocalFileSystem(), pds.ParquetFileFormat(default_fragment_scan_options=options)
        fragments = [
            form.make_fragment(os.fspath(file), local, partition_expression=guarantee)
            for file, guarantee in zip(files, guarantees, strict=False)
        ]
        dataset = pds.FileSystemDataset(fragments, self.schema, form, local)
        return list(dataset.get_fragments(condition.expression))


def _guarantee(schema: pa.Schema, ranges: Mapping[str, list[Any]], columns: Iterable[str]) -> "pc.Expression":
    """Return what the mark of a block guarantees of some columns: null, or within a range."""
    import pyarrow.compute as pc

    guarantee = pc.scalar(value=True)
    for name in columns:
        kind, field = schema.field(name).type, pc.field(name)
        low, high = ranges.get(name, (-np.inf, np.inf))[:2]
        if kind != pa.float64() and max(abs(low), abs(high)) >= LARGEST_EXACT:
            continue
        for bound in (field >= pa.scalar(low, kind), field <= pa.scalar(high, kind)):
            guarantee &= bound | field.is_null()
    return guarantee


def scan(fragment: "pds.Fragment", condition: Condition, columns: list[str]) -> pa.Table:
    """Return the columns of the rows of a summary that meet a condition; DamagedError for such as no run writes."""
    path = Path(fragment.path)
    with damage_said(path):
        durable.open_regular(path).close()  # Arrow would follow a link, and wait for a pipe
        return plausible(fragment.to_table(columns=columns, filter=condition.expression, use_threads=False))


def _read_sample(part: Part) -> pa.Table:
    with part.table(SAMPLE_FILE) as file:
        return plausible(file.read(use_threads=False))


def unmark_damaged(directory: Path) -> list[int]:
    """Remove the marks of blocks with final files that no run writes, so that they are finished again.

    Return their numbers.  Checksums do not prove that a run wrote a file, and a run reads the marks alone.
    """
    run, damaged = BlockedRun(directory, partial=True), []
    for block, part in zip(run.listed, run.parts, strict=True):
        try:
            for _ in part.rows():  # checks every value
                pass
            _read_sample(part)
            with part.orbits():  # checks it
                pass
        except DamagedError:
            durable.discard(block.mark)
            damaged.append(block.number)
    return damaged


class SampledRun(BlockedRun):
    """A sample of a run in blocks: random rows and the extremes of every column, sorted by case_id, in little memory.

    Counts of all cases are in `marks`.
    """

    def __init__(self, run: BlockedRun):
        """Take the run."""
        self.whole, self._sampled = run, list(run.sampled_parts())
        vars(self).update(vars(run))  # what is read once is shared
        rows = pa.concat_tables([table for _, table in self._sampled])
        self._sample = table_rows_at(rows, np.argsort(values_of(rows["case_id"].combine_chunks())))

    def __len__(self) -> int:
        return len(self._sample)

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """Return the rows of the sample as a DataFrame."""
        return to_frame(self._sample)

    def column(self, name: str) -> np.ndarray:
        """Return one column of the sample."""
        return values_of(self._sample[name].combine_chunks())

    def blocks(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield columns of the sample, name -> values, for a few thousand rows at a time."""
        for first in range(0, len(self), GROUP_ROWS):
            rows = self._sample.slice(first, GROUP_ROWS)
            yield {name: values_of(rows[name].combine_chunks()) for name in columns}

    def event_blocks(self) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
        """Yield the results of `StoredRun.event_blocks` for the whole sample at once."""
        events: dict[str, tuple[np.ndarray, ...]] = {}  # case_id -> its columns
        for part, table in self._sampled:
            ids = table["case_id"].to_pylist()
            events |= dict.fromkeys(ids, (np.empty(0),) * len(EVENT_COLUMNS))
            rows = np.searchsorted(part.ids, np.array([int(case_id, 16) for case_id in ids], "u8"))
            with part.orbits() as file:
                offsets = file[OFFSETS_BY_ITEM[EVENT]][:] if self.histories and ids else np.empty(0, "i8")
                runs = np.split(np.arange(len(rows)), np.flatnonzero(np.diff(rows) != 1) + 1)
                for run in runs if len(offsets) else ():  # consecutive rows are read at once
                    bounds = offsets[rows[run[0]] : rows[run[-1]] + 2]
                    columns = [
                        np.split(read_values(file, f"events/{name}", slice(*bounds[[0, -1]])), bounds[1:-1] - bounds[0])
                        for name in EVENT_COLUMNS
                    ]
                    events |= zip([ids[k] for k in run.tolist()], zip(*columns, strict=True), strict=True)
        in_order = [events[case_id] for case_id in sorted(events)]
        yield (
            np.array([len(times) for times, *_ in in_order], int),
            {
                name: np.concatenate([np.empty(0), *(columns[k] for columns in in_order)])
                for k, name in enumerate(EVENT_COLUMNS)
            },
        )
