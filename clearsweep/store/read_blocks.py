"""Reads a run that is cut into blocks: rows are found by the indices of the blocks, and read where they are asked for."""

import operator
import os
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from ..contracts.layout import Layout
from ..language.errors import DirectoryError, InputError
from . import durable
from .batch import GROUP_ROWS, ID_LENGTH, id_text, open_table, values_of
from .blocks import DATASET, IDS_FILE, SAMPLE_FILE, Block, numbers_of_blocks, read_mark
from .directory import ORBITS_FILE, SUMMARY_FILE
from .read import StoredRun
from .record import RECORD_FILE, check_form, damaged, read_record

if TYPE_CHECKING:
    import pandas as pd

LISTED = 3  # cases that a message lists
_COMPARE = {"==": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


class OneBlock(StoredRun):
    """One block of a run, read like a run."""

    def __init__(self, directory: Path, block: Block, grid: dict[str, Any], layout: Layout):
        """Take the run's directory, content of run.json and layout, and where the block is."""
        self.directory, self.place, self.block, self.grid, self.layout = directory, directory, block, grid, layout

    def _path(self, name: str) -> Path:
        return self.block.files.get(name, self.directory / name)

    @cached_property
    def numbers(self) -> np.ndarray:
        """Return the identities of its cases, uint64, ascending."""
        path = self.block.files[IDS_FILE]
        try:
            return np.memmap(path, "<u8", "r") if path.stat().st_size else np.empty(0, "u8")
        except FileNotFoundError:
            raise damaged(path, "it is missing") from None

    @cached_property
    def _ids(self) -> np.ndarray:
        return np.array([id_text(value).encode() for value in self.numbers.tolist()], f"S{ID_LENGTH}")


class BlockedRun(StoredRun):
    """The results in one directory whose run was cut into blocks.

    Attributes and methods are those of StoredRun.  `summary` is lazy: see `LazySummary`.  Opening compares the checksum
    of run.json; pages of the summaries are checked as they are read, and `status --verify` compares all checksums.
    """

    def __init__(self, directory: str | Path, *, partial: bool = False):
        """Take the directory; `partial`: with the blocks that are finished so far."""
        self.directory = self.place = Path(directory)
        self.grid = read_record(self.directory)
        check_form(self.directory, self.grid)
        if "merged" not in self.grid and not partial:
            raise DirectoryError(
                f"{directory}: its run is not finished; run the grid again with --out {directory}, which computes only "
                "what is missing, or read what there is: report --partial, clearsweep.open(..., partial=True)"
            )
        self.layout = Layout.read(self.grid["layout"])
        present = [int(name[:5]) for name in _names(self.directory / DATASET)]
        whole = "merged" in self.grid
        if whole and (missing := sorted(set(self.grid["blocks"]["numbers"]) - set(present))):
            raise damaged(Block(self.directory, missing[0]).files[SUMMARY_FILE], "it is missing")
        if whole:
            listed = self.grid["blocks"]["numbers"]
        else:
            listed = [each for each in numbers_of_blocks(self.directory) if read_mark(Block(self.directory, each))]
        self.parts = [OneBlock(self.directory, Block(self.directory, each), self.grid, self.layout) for each in listed]
        if not self.parts:
            raise DirectoryError(f"{directory}: no block of its run is finished yet; `status` tells how far it is")

    @property
    def files(self) -> tuple[str, ...]:
        """Return the names of what a reader looks for in the directory."""
        return (f"{DATASET}/", f"blocks/*/{ORBITS_FILE}", RECORD_FILE)

    def _path(self, name: str) -> Path:
        return self.parts[0]._path(name)

    @cached_property
    def _marks(self) -> list[dict[str, Any]]:
        marks = []
        for part in self.parts:
            mark = read_mark(part.block)
            if mark is None:
                raise damaged(part.block.mark, "it is not what was written, or a file that it names is not")
            marks.append(mark)
        return marks

    def marks(self) -> list[dict[str, Any]]:
        """Return the marks of all blocks."""
        return self._marks

    def __len__(self) -> int:
        return sum(len(part.numbers) for part in self.parts)

    @property
    def summary(self) -> "LazySummary":  # type: ignore[override]
        """Return the summary, of which only what is asked for is read."""
        return LazySummary(self)

    def column(self, name: str) -> "pd.Series":
        """Return one column of the summary, all cases, block after block; 8 bytes a number."""
        import pandas as pd

        values = [block[name] for block in self.blocks([name])]
        return pd.Series(np.concatenate(values) if values else np.empty(0), name=name)

    def blocks(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield these columns of the summary, name -> values, for a few thousand rows at a time, block after block."""
        for part in self.parts:
            yield from part.blocks(columns)

    def striking(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield these columns for the rows of every block that are kept: at random, or because they stand out."""
        for part in self.parts:
            table = _sample(part.block)
            if len(table):
                yield {name: values_of(table[name].combine_chunks()) for name in columns}

    def sample(self) -> pa.Table:
        """Return rows at random from all blocks, and the rows with the extremes of each column over all, by case_id."""
        wanted: set[str] = set()
        for name in {name for mark in self._marks for name in mark["ranges"]}:
            ranges = [mark["ranges"][name] for mark in self._marks if name in mark["ranges"]]
            wanted |= {min(ranges)[2], max(ranges, key=lambda each: each[1])[3]}
        tables = []
        for part, mark in zip(self.parts, self._marks, strict=True):
            table = _sample(part.block)
            ids = table["case_id"].to_pylist()
            keep = [place for place, case_id in enumerate(ids) if place < mark["drawn"] or case_id in wanted]
            tables.append(table.take(pa.array(keep, pa.int64())))
        whole = pa.concat_tables(tables)
        return whole.take(pc.sort_indices(whole, [("case_id", "ascending")])).combine_chunks()

    def part_of(self, begin: str) -> OneBlock:
        """Return the block of the case whose case_id begins with `begin`; InputError where none does, or several do."""
        text = str(begin)
        found = []
        if 0 < len(text) <= ID_LENGTH and all(letter in "0123456789abcdef" for letter in text):
            low, high = int(text.ljust(ID_LENGTH, "0"), 16), int(text.ljust(ID_LENGTH, "f"), 16)
            for part in self.parts:
                first, last = _bounds(part.numbers, low, high)
                found += [(id_text(int(part.numbers[place])), part) for place in range(first, min(last, first + LISTED))]
        if not found:
            raise InputError(f"{self.directory}: no case {begin!r}; the case_id column of summary/ lists them")
        if len(found) > 1:
            some = ", ".join(case_id for case_id, _ in found[:LISTED])
            raise InputError(f"{self.directory}: several cases begin with {begin!r} ({some}, ...); write more")
        return found[0][1]

    def full_id(self, begin: str) -> str:
        """Return the case_id that begins with `begin`; InputError where none does, or several do."""
        return self.part_of(begin).full_id(begin)

    def orbit(self, case_id: str) -> "pd.DataFrame":
        """Return what StoredRun.orbit does."""
        return self.part_of(case_id).orbit(case_id)

    def events(self, case_id: str) -> "pd.DataFrame":
        """Return what StoredRun.events does."""
        return self.part_of(case_id).events(case_id)

    def poincare(self, case_id: str) -> "pd.DataFrame":
        """Return what StoredRun.poincare does."""
        return self.part_of(case_id).poincare(case_id)

    def wear(self, case_id: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return what StoredRun.wear does."""
        return self.part_of(case_id).wear(case_id)

    def history(self, case_id: str) -> dict[str, np.ndarray]:
        """Return what StoredRun.history does."""
        return self.part_of(case_id).history(case_id)

    def peak_revolution(self, case_id: str) -> "pd.DataFrame":
        """Return what StoredRun.peak_revolution does."""
        return self.part_of(case_id).peak_revolution(case_id)

    @property
    def worst(self) -> list[str]:
        """Return the cases of which the revolution of the largest peak was saved, block after block."""
        return [case_id for part in self.parts for case_id in part.worst] if self.grid["save"].get("worst") else []

    def event_blocks(self) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
        """Yield what StoredRun.event_blocks does, block after block."""
        for part in self.parts:
            yield from part.event_blocks()

    def matching(self, filters: "Filter", columns: list[str] | None = None) -> "pd.DataFrame":
        """Return the rows of the summary that pass some filters; blocks and groups that cannot have any are not read."""
        tables, schema = [], None
        for part, mark in self._possible(filters):
            with open_table(part._path(SUMMARY_FILE)) as file:
                schema = file.schema_arrow
                groups = filters.groups(file, part, mark)
                names = None if columns is None else list(dict.fromkeys([*columns, *filters.columns]))
                for group in groups:
                    table = file.read_row_group(group, names, use_threads=False)
                    mask = filters.mask(table)
                    if mask.any():
                        tables.append(table.filter(pa.array(mask)))
        if schema is None:
            with open_table(self._path(SUMMARY_FILE)) as file:
                schema = file.schema_arrow
        chosen = pa.schema([schema.field(name) for name in columns]) if columns is not None else schema
        table = pa.concat_tables([chosen.empty_table(), *(table.select(chosen.names) for table in tables)])
        return _framed(table)

    def _possible(self, filters: "Filter") -> Iterator[tuple[OneBlock, dict[str, Any] | None]]:
        """Yield the blocks that may have a row that passes some filters."""
        ids = filters.case_ids
        if ids is not None:
            numbers = np.array(sorted(int(each, 16) for each in ids), "u8")
            for part in self.parts:
                if any(np.subtract(*_bounds(part.numbers, value, value)[::-1]) for value in numbers.tolist()):
                    yield part, None
            return
        for part, mark in zip(self.parts, self._marks, strict=True):
            if filters.possible(mark["ranges"]):
                yield part, mark


class Filter:
    """Conditions on columns of a summary, all of which a row is to meet."""

    def __init__(self, conditions: tuple[tuple[str, str, Any], ...]):
        """Take conditions such as ('drive.speed', '>=', 100.0) or ('case_id', 'in', {...})."""
        self.conditions = conditions

    def __and__(self, other: "Filter") -> "Filter":
        return Filter(self.conditions + other.conditions)

    @property
    def columns(self) -> list[str]:
        """Return the columns that it looks at."""
        return [column for column, _, _ in self.conditions]

    @property
    def case_ids(self) -> set[str] | None:
        """Return the identities that rows may have, None: any."""
        sets = [
            {value} if how == "==" else set(value)
            for column, how, value in self.conditions
            if column == "case_id" and how in ("==", "in")
        ]
        if not sets:
            return None
        letters = frozenset("0123456789abcdef")
        return {each for each in set.intersection(*sets) if len(each) == ID_LENGTH and letters.issuperset(each)}

    def possible(self, ranges: dict[str, list[Any]]) -> bool:
        """Return whether values in these ranges (column -> smallest, largest) can meet all conditions."""
        return all(
            _reaches(how, value, *ranges[column][:2])
            for column, how, value in self.conditions
            if column in ranges and not isinstance(value, str)
        )

    def groups(self, file: pq.ParquetFile, part: OneBlock, mark: dict[str, Any] | None) -> list[int]:
        """Return the groups of rows of a summary that may have rows that meet them."""
        groups = range(file.metadata.num_row_groups)
        ids = self.case_ids
        if ids is None:
            return list(groups)
        places = [_bounds(part.numbers, int(each, 16), int(each, 16)) for each in ids]
        return sorted({first // GROUP_ROWS for first, last in places if last > first})

    def mask(self, table: pa.Table) -> np.ndarray:
        """Return which rows of a table meet them; null meets none."""
        mask = np.ones(len(table), bool)
        for column, how, value in self.conditions:
            values = values_of(table[column].combine_chunks())
            if how == "in":
                mask &= np.array([each in value for each in values.tolist()], bool)
            else:
                known = ~np.isnan(values) if values.dtype != object else np.not_equal(values, None)
                met = np.zeros(len(values), bool)
                met[known] = _COMPARE[how](values[known], value)
                mask &= met
        return mask


class LazyColumn:
    """A column of a lazy summary: compared with a value it is a filter; anything else reads all of it, as a Series."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, run: BlockedRun, name: str):
        """Take the run and the name of the column."""
        self._run, self._name = run, name

    def _filter(self, how: str, value: Any) -> Filter:
        return Filter(((self._name, how, value),))

    def __eq__(self, value: object) -> Filter:  # type: ignore[override]
        return self._filter("==", value)

    def __ne__(self, value: object) -> Filter:  # type: ignore[override]
        return self._filter("!=", value)

    def __lt__(self, value: Any) -> Filter:
        return self._filter("<", value)

    def __le__(self, value: Any) -> Filter:
        return self._filter("<=", value)

    def __gt__(self, value: Any) -> Filter:
        return self._filter(">", value)

    def __ge__(self, value: Any) -> Filter:
        return self._filter(">=", value)

    def isin(self, values: Any) -> Filter:
        """Return the filter for rows with one of some values."""
        return self._filter("in", frozenset(values))

    def __len__(self) -> int:
        return len(self._run)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._run.column(self._name))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.asarray(self._run.column(self._name), dtype)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._run.column(self._name), name)


class LazySummary:
    """The summary of a run that is cut: it is read like a DataFrame, and only what is asked for is read.

    `summary[summary["case_id"] == "..."]` and `summary[(summary["drive.speed"] > 100.0) & ...]` are DataFrames with the
    rows that pass; `summary["column"]` compares without being read; `summary.frame()` reads everything.
    """

    def __init__(self, run: BlockedRun):
        """Take the run."""
        self._run = run

    def __len__(self) -> int:
        return len(self._run)

    def __repr__(self) -> str:
        return f"<lazy summary: {len(self):,} cases, {len(self.columns)} columns>"

    @property
    def columns(self) -> list[str]:
        """Return the names of the columns."""
        return self._run.columns

    @property
    def attrs(self) -> dict[str, dict[str, str]]:
        """Return `units` and `descriptions` by column."""
        return dict(self._run.matching(Filter((("case_id", "in", frozenset()),))).attrs)

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __getitem__(self, wanted: "str | list[str] | Filter") -> Any:
        if isinstance(wanted, Filter):
            return self._run.matching(wanted)
        if isinstance(wanted, list):
            return self._run.matching(Filter(()), wanted)
        if wanted not in self.columns:
            raise KeyError(wanted)
        return LazyColumn(self._run, wanted)

    def frame(self) -> "pd.DataFrame":
        """Return all of it as a DataFrame, block after block."""
        return self._run.matching(Filter(()))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self[name] if name in self.columns else getattr(self.frame(), name)


def _bounds(numbers: np.ndarray, low: int, high: int) -> tuple[int, int]:
    """Return where the identities from `low` to `high` are among some, ascending."""
    first = int(np.searchsorted(numbers, np.uint64(low)))
    return first, first + int(np.searchsorted(numbers[first:], np.uint64(high), side="right"))


def _reaches(how: str, value: Any, low: float, high: float) -> bool:
    """Return whether a number between two others can meet a condition."""
    tests: dict[str, Callable[[], bool]] = {
        "==": lambda: low <= value <= high,
        "!=": lambda: True,
        "<": lambda: low < value,
        "<=": lambda: low <= value,
        ">": lambda: high > value,
        ">=": lambda: high >= value,
        "in": lambda: any(low <= each <= high for each in value),
    }
    return tests[how]()


def _names(folder: Path) -> list[str]:
    names = os.listdir(folder) if folder.is_dir() else []
    return [name for name in names if name.endswith(".parquet") and name[:5].isdigit()]


def _sample(block: Block) -> pa.Table:
    path = block.files[SAMPLE_FILE]
    durable.check_regular(path)
    try:
        with open_table(path) as file:
            return file.read(use_threads=False)
    except (OSError, ValueError) as error:
        raise damaged(path, str(error)) from error


def _framed(table: pa.Table) -> "pd.DataFrame":
    """Return a table as a DataFrame whose `attrs` hold units and descriptions by column."""
    frame = table.replace_schema_metadata(None).to_pandas(use_threads=False)
    for name, key in (("units", b"unit"), ("descriptions", b"description")):
        frame.attrs[name] = {field.name: field.metadata[key].decode() for field in table.schema}
    return frame
