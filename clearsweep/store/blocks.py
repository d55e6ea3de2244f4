"""Blocks: a large run is divided into blocks of consecutive cases, each with its own batches, final files and mark.

The mark is written last and means that the block is finished.  Resuming, counting and reading use the marks and do
not open the batches.
"""

import contextlib
import fcntl
import hashlib
import json
import os
import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..grid import Grid
from . import durable
from .batch import ResultSchema
from .datasets import table_rows_at, values_of
from .directory import BLOCKS, DATASET, IDS_FILE, LOCK, ORBITS_FILE, SUMMARY_FILE, RunDirectory
from .merged import ComputePeakRevolutions, content_hash_of, worst_with_peaks, write_orbits, write_summary

BLOCK = 2**17  # consecutive indices of a grid in a block; a grid of more cases is cut
MARK_FILE, SAMPLE_FILE = "block.json", "sample.parquet"
SAMPLED_ROWS = 2**15  # rows of all blocks that are drawn for reports
MIN_SAMPLED_ROWS = 16  # of them from each block
MAX_CASES = 10**12  # number of cases that a mark may have
_NAME = re.compile(r"\d{5}")
_MARK_COUNTS = ("cases", "ok", "failed", "missing", "others", "drawn")  # of a mark
_COUNT_SECTIONS = ("statuses", "remarks", "limits", "exceeded", "unknown", "fails", "unjudged")  # below its `counts`


class Block(NamedTuple):
    """The location of one block of a run."""

    run: Path
    number: int

    @property
    def path(self) -> Path:
        """Return the directory of the block's batches."""
        return self.run / BLOCKS / self.name

    @property
    def name(self) -> str:
        """Return the number of the block as text for file names."""
        return f"{self.number:05d}"

    @property
    def files(self) -> dict[str, Path]:
        """Return the final files of the block, by the names that they have in a run without blocks."""
        return {
            SUMMARY_FILE: self.run / DATASET / f"{self.name}.parquet",
            ORBITS_FILE: self.path / ORBITS_FILE,
            IDS_FILE: self.path / IDS_FILE,
            SAMPLE_FILE: self.path / SAMPLE_FILE,
        }

    @property
    def mark(self) -> Path:
        """Return the file with the outcome of the block."""
        return self.path / MARK_FILE

    def directory(self, result_schema: ResultSchema) -> RunDirectory:
        """Return the directory of the block's batches; create it if it is missing."""
        directory = RunDirectory(self.path)
        directory.expect(result_schema)
        for folder in (self.path.parent, self.path, directory.orbits, directory.summaries, directory.scratch):
            durable.make_folder(folder)
        return directory


@dataclass(frozen=True)
class Division:
    """How the cases of a grid are divided into blocks."""

    size: int  # consecutive indices in a block
    cases: int  # of the grid
    fingerprint: str  # hash of everything that determines the content of the blocks

    @classmethod
    def of(cls, grid: Grid, shard: str = "") -> "Division | None":
        """Return the division of a grid, or of one shard, or None if it has only one block.

        Grids with a search have one block, since the cases that a search adds depend on earlier ones.
        """
        if len(grid) <= BLOCK or grid.search:
            return None
        digest = hashlib.sha256(repr((BLOCK, shard, ResultSchema.of(grid).content)).encode())
        for path, values in grid.axes.items():
            digest.update(repr((path, values)).encode())
        return cls(BLOCK, len(grid), digest.hexdigest()[:16])

    @property
    def count(self) -> int:
        """Return the number of blocks."""
        return -(-self.cases // self.size)

    @property
    def sampled(self) -> int:
        """Return the number of rows that each block gives to the sample of a report."""
        return max(SAMPLED_ROWS // self.count, MIN_SAMPLED_ROWS)

    def part(self, number: int) -> range:
        """Return the indices of a block."""
        return range(number * self.size, min((number + 1) * self.size, self.cases))


def read_mark(block: Block, fingerprint: str | None = None) -> dict[str, Any] | None:
    """Return the mark of a block whose final files exist with the sizes in the mark, or None if it is unfinished.

    fingerprint : fingerprint of the `Division`; a mark with another one is ignored
    """
    try:
        mark = json.loads(durable.read(block.mark))
        checksum = mark.pop("checksum")
        sizes = {name: size for name, (_, size) in mark["files"].items()}
        is_intact = checksum == _checksum(mark) and fingerprint in (None, mark["form"])
        is_valid = is_intact and all(os.stat(path).st_size == sizes[name] for name, path in block.files.items())
    except (FileNotFoundError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return dict(mark) if is_valid and mark["block"] == block.number and _is_complete(mark) else None


def sum_counts(counts: Sequence[Mapping[str, Any]], section: str) -> Counter[str]:
    """Return the sums of a section of the `counts` of marks over all blocks."""
    total: Counter[str] = Counter()
    for count in counts:
        total.update(count[section])
    return total


def _is_complete(mark: dict[str, Any]) -> bool:
    """Return whether a mark has all entries that `finish_block` writes: its checksum does not prove that."""
    counts = mark.get("counts")
    ranges = mark.get("ranges")
    return (
        all(isinstance(mark.get(name), int) and 0 <= mark[name] <= MAX_CASES for name in _MARK_COUNTS)
        and isinstance(ranges, dict)
        and all(
            isinstance(extremes, list) and [type(value) for value in extremes] == [float, float, str, str]
            for extremes in ranges.values()
        )
        and isinstance(counts, dict)
        and all(isinstance(counts.get(name), int) for name in ("unreached", "unlimited"))
        and all(
            isinstance(counts.get(name), dict) and all(isinstance(count, int) for count in counts[name].values())
            for name in _COUNT_SECTIONS
        )
        and {"cases"} <= counts["remarks"].keys()
        and {"cases", "any", "unknown"} <= counts["limits"].keys()
    )


def write_mark(block: Block, mark: Mapping[str, Any], scratch: Path) -> dict[str, Any]:
    """Write the mark of a block whose final files are on disk; return it with their checksums and sizes."""
    files = {name: [durable.checksum(path), path.stat().st_size] for name, path in block.files.items()}
    entries = {**mark, "block": block.number, "files": files}
    complete = json.loads(json.dumps(entries, default=lambda value: value.item()))
    content = json.dumps(complete | {"checksum": _checksum(complete)})
    with durable.storing(block.mark):
        durable.replace(block.mark, content.encode(), scratch)
    return dict(complete)


def _checksum(mark: Mapping[str, Any]) -> str:
    return sha256_of(json.dumps(mark, sort_keys=True))


def sha256_of(text: str) -> str:
    """Return the SHA-256 of a text in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()


def verify_block(block: Block, mark: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence for each final file of a block whose checksum is not that of its mark."""
    for name, path in block.files.items():
        try:
            actual = durable.checksum(path)
        except FileNotFoundError:
            actual = ""
        if actual != mark["files"][name][0]:
            yield f"{path}: damaged (its checksum is not that of its block)" if actual else f"{path}: missing"


def numbers_of_blocks(run: Path) -> list[int]:
    """Return the numbers of the blocks that have a directory in a run, ascending."""
    folder = run / BLOCKS
    names = os.listdir(folder) if folder.is_dir() else []
    return sorted(int(name) for name in names if _NAME.fullmatch(name))


def discard_from(run: Path, count: int) -> None:
    """Remove the marks and final files of the blocks from a number on; keep their batches."""
    for number in numbers_of_blocks(run):
        if number >= count:
            block = Block(run, number)
            for path in (block.mark, *block.files.values()):
                durable.discard(path)


class Sampler:
    """Collects the sorted rows of a block; keeps ranges of its columns, random rows, and extreme ones.

    Rows are sorted by identities, which are hashes: the first ones are a random sample.  The others are the rows with
    the smallest and the largest value of each column, and those whose identities `select` returns.
    """

    def __init__(self, rows: int, select: Callable[[dict[str, np.ndarray]], set[str]]):
        """Prepare to keep `rows` random rows.

        select : takes the columns of further rows; returns the identities of all rows to keep so far
        """
        self.rows, self.select = rows, select
        self.random_rows: list[pa.Table] = []
        self.ranges: dict[str, list[Any]] = {}  # column -> smallest, largest value, their identities
        self.selected: dict[str, pa.Table] = {}  # case_id -> its row
        self.random_count = 0

    def add(self, table: pa.Table, columns: dict[str, np.ndarray]) -> None:
        """Add rows, with their `columns` as arrays."""
        if (missing := self.rows - self.random_count) > 0:
            self.random_rows.append(table_rows_at(table, np.arange(min(missing, len(table)))))
            self.random_count += len(self.random_rows[-1])
        ids = columns["case_id"].tolist()
        for name, values in columns.items():
            if values.dtype == object:
                continue
            finite = np.isfinite(values)
            if not finite.any():
                continue
            low = int(np.argmin(values if finite.all() else np.where(finite, values, np.inf)))
            high = int(np.argmax(values if finite.all() else np.where(finite, values, -np.inf)))
            extremes = self.ranges.setdefault(name, [np.inf, -np.inf, "", ""])
            if values[low] < extremes[0]:
                extremes[0], extremes[2] = float(values[low]), ids[low]
            if values[high] > extremes[1]:
                extremes[1], extremes[3] = float(values[high]), ids[high]
        selected_ids = self.select(columns) | {case_id for extremes in self.ranges.values() for case_id in extremes[2:]}
        for case_id in selected_ids - self.selected.keys():
            position = bisect_left(ids, case_id)
            if position < len(ids) and ids[position] == case_id:
                self.selected[case_id] = table_rows_at(table, np.array([position]))
        self.selected = {case_id: row for case_id, row in self.selected.items() if case_id in selected_ids}

    def table(self, schema: pa.Schema) -> pa.Table:
        """Return the random rows, followed by the others, each once."""
        random_rows = pa.concat_tables([pa.Table.from_batches([], schema), *self.random_rows])
        drawn_ids = set(random_rows["case_id"].to_pylist())
        others = [row for case_id, row in sorted(self.selected.items()) if case_id not in drawn_ids]
        return pa.concat_tables([random_rows, *others]).combine_chunks()


# ----------------------------------------------------------------------------------------------------------------------
# Finishes a block: its batches become a sorted summary, orbits, the index of its cases, a sample and its mark.


def finish_block(  # noqa: PLR0913 - the block, its content, what is made of it
    block: Block,
    division: Division,
    result_schema: ResultSchema,
    requested: np.ndarray,
    select: Callable[[dict[str, np.ndarray]], set[str]],
    counts: Callable[[], dict[str, Any]],
    compute_peak_revolutions: ComputePeakRevolutions,
) -> dict[str, Any]:
    """Write the final files of a block, whose batches are committed; return its mark.

    requested : identities of the cases in the block, ascending.  select : as of a `Sampler`; counts : after all cases
    were selected from, returns the `counts` of the mark.  `compute_peak_revolutions` : as in `merge`.
    """
    block.directory(result_schema)
    with durable.open_lock(block.path / LOCK) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # an abandoned driver may finish the block at the same time
        run = block.directory(result_schema)
        run.load_batches()
        rows = run.rows()
        stored_count = len(rows)
        if not np.array_equal(rows["id"], requested):
            rows = rows[np.isin(rows["id"], requested, assume_unique=True)]
        content_hash = content_hash_of(run, result_schema, rows)
        existing = read_mark(block, division.fingerprint)
        if existing and existing["mark"] == content_hash:
            return existing

        sampler = Sampler(division.sampled, select)
        peaks = worst_with_peaks(run, result_schema, rows, compute_peak_revolutions)
        with durable.storing(block.path):
            durable.discard(block.mark)
            durable.make_folder(block.run / DATASET)
            with contextlib.ExitStack() as exit_stack:
                targets = {
                    name: exit_stack.enter_context(durable.atomic_file(path, run.scratch))
                    for name, path in block.files.items()
                }
                write_orbits(targets[ORBITS_FILE], run, result_schema, rows, content_hash, peaks)
                write_summary(
                    targets[SUMMARY_FILE],
                    run,
                    result_schema,
                    rows,
                    content_hash,
                    lambda table, _: sampler.add(table, _columns(table)),
                )
                targets[IDS_FILE].write_bytes(np.ascontiguousarray(rows["id"]).astype("<u8").tobytes())
                schema = pq.read_schema(targets[SUMMARY_FILE])
                with pq.ParquetWriter(targets[SAMPLE_FILE], schema, write_page_checksum=True) as writer:
                    writer.write_table(sampler.table(schema))
                for path in targets.values():
                    durable.sync(path)
            durable.sync(block.path)
            durable.sync(block.run / DATASET)
        failed = int(np.count_nonzero(rows["failed"]))
        return write_mark(
            block,
            {
                "form": division.fingerprint,
                "mark": content_hash,
                "cases": len(requested),
                "ok": len(rows) - failed,
                "failed": failed,
                "missing": len(requested) - len(rows),
                "others": stored_count - len(rows),
                "drawn": sampler.random_count,
                "ranges": sampler.ranges,
                "counts": counts(),
            },
            run.scratch,
        )


def _columns(table: pa.Table) -> dict[str, np.ndarray]:
    """Return the columns of some rows of a summary as arrays."""
    return {name: values_of(table[name].combine_chunks()) for name in table.column_names}
