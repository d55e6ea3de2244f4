"""Runs a grid that is divided into blocks, one block after another, with the workers of one pool."""

import json
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import store
from ..contracts.results import Peak
from ..grid import Grid
from ..language import phases
from ..language.errors import ClearsweepError, error_line
from ..store import durable
from .facts import RunFacts
from .pool import system
from .pool.case_runner import (
    CaseRunner,
    Options,
    Pending,
    Shard,
    failure_limit,
    finished_counts,
    is_common,
    missing_indices,
    peak_or_none,
)
from .pool.driver import CHECK_INTERVAL, MAX_RESTARTS
from .pool.worker import RunContext, Simulator, find_peak


class BlockJob(NamedTuple):
    """Data that all blocks of a run share."""

    directory: Path  # of the run
    grid: Grid
    simulator: Simulator
    options: Options
    division: store.Division
    shard: Shard | None
    duplicates: np.ndarray  # indices of cases that repeat an earlier one, ascending

    def cases(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the indices of a block's cases and their identities, uint64."""
        indices = self.division.part(number)
        ids = np.fromiter(self.grid.identities(indices), "u8", len(indices))
        is_first = np.ones(len(indices), bool)
        first, last = np.searchsorted(self.duplicates, (indices.start, indices.stop))
        is_first[self.duplicates[first:last] - indices.start] = False
        if self.shard:
            is_first &= is_common(ids, self.shard.ids(ids[is_first]))
        positions = np.flatnonzero(is_first)
        return indices.start + positions, ids[positions]


def duplicate_indices(grid: Grid) -> np.ndarray:
    """Return the indices of cases that repeat an earlier one, ascending; they belong to the block of the first."""
    if not grid.may_repeat:
        return np.empty(0, "i8")
    ids = np.fromiter(grid.identities(), "u8", len(grid))
    order = np.argsort(ids, kind="stable")
    ids = ids[order]
    return np.sort(order[1:][ids[1:] == ids[:-1]])


def finish_block(
    context: RunContext, block: store.Block, division: store.Division, requested: np.ndarray
) -> dict[str, Any]:
    """Write the final files of a block and return its mark; runs in a worker.

    requested : identities of the cases in the block, ascending.
    """
    store.use_one_thread()
    schema, grid = context.result_schema, context.grid
    units = dict.fromkeys(grid.axes, "1")
    record = store.json_round_trip({**grid.resolved(), "layout": grid.layout.written(), "units": units})

    def compute_peak_revolutions(worst: Sequence[store.Worst]) -> list[Peak | None]:
        return [peak_or_none(case, find_peak(context.simulator, grid.case_at(case.point), case)) for case in worst]

    facts = RunFacts(record, grid.layout)
    return store.finish_block(block, division, schema, requested, facts.select, facts.counts, compute_peak_revolutions)


class BlocksOutcome(NamedTuple):
    """Outcome of the blocks of a run."""

    marks: dict[int, dict[str, Any]]  # marks of finished blocks, by number
    ran: int
    case_seconds: float
    complete: bool  # False: stopped because too many cases failed


def finished_mark(job: BlockJob, number: int) -> dict[str, Any] | None:
    """Return the mark of a finished block, or None if work is left."""
    mark = store.read_mark(store.Block(job.directory, number), job.division.fingerprint)
    if mark is None or mark["missing"] or (mark["failed"] and job.options.retry_failed):
        return None
    return mark


def unfinished_blocks(job: BlockJob) -> tuple[list[int], dict[int, dict[str, Any]]]:
    """Return the numbers of unfinished blocks, and the marks of the others, by number."""
    marks = {number: mark for number in range(job.division.count) if (mark := finished_mark(job, number))}
    return [number for number in range(job.division.count) if number not in marks], marks


class BlockRunner:
    """Runs blocks with the workers of a pool; while one worker finishes a block, the others begin the next."""

    def __init__(self, job: BlockJob, case_runner: CaseRunner, *, earlier: store.RunDirectory | None = None):
        """Prepare with the runner of the cases, and a directory that may already contain batches of theirs."""
        self.job, self.case_runner, self.earlier_run = job, case_runner, earlier
        self.finishing: dict[int, tuple[Future, Callable[[], Future]]] = {}
        self.marks: dict[int, dict[str, Any]] = {}
        self.allowed_failures: int | None = None
        self.shared: set[int] = set()  # blocks on which other drivers may work
        self._earlier_ids = earlier.rows() if earlier and earlier.batches else None

    def run(self, number: int, read_finished_ids: Callable[[], np.ndarray] | None = None, *, later: int = 0) -> bool:
        """Run the missing cases of a block and let a worker finish it; return False if too many cases failed.

        read_finished_ids : as in `Pending`, if other drivers may also work on the block; their files are then kept.
        later : cases of later blocks
        """
        job = self.job
        block = store.Block(job.directory, number)
        if read_finished_ids:
            self.shared.add(number)
        else:
            durable.remove_temporaries(block.path / store.SCRATCH)
        directory = self._opened(block)
        indices, ids = job.cases(number)
        self._take_earlier(directory, ids)
        requested = np.sort(ids)
        pending = missing_indices(ids, requested, directory.rows(), retry_failed=job.options.retry_failed)
        self.case_runner.directory = directory
        self.case_runner.start_workers(len(job.division.part(number)))
        is_complete = True
        if len(pending):
            title = f"block {number + 1:,} of {job.division.count:,}: "
            allowed = None if self.allowed_failures is None else max(self.allowed_failures - self.case_runner.failed, 0)
            cases = Pending(
                indices[pending],
                ids[pending],
                title,
                read_finished_ids=read_finished_ids,
                has_similar_times=True,
                later=later,
                earlier=finished_counts(directory.rows(), requested, ids[pending]),
            )
            is_complete = self.case_runner.run_cases(job.grid, cases, allowed)
        self._submit(number, block, requested)
        self.collect(wait=False)
        return is_complete

    def join(self, number: int, sources: Sequence[store.RunDirectory]) -> None:
        """Take over the batches of a block from other directories, and finish it."""
        block = store.Block(self.job.directory, number)
        directory = self._opened(block)
        for source in sources:
            directory.link_batches(source)
        self._submit(number, block, np.sort(self.job.cases(number)[1]))
        self.collect()

    def _opened(self, block: store.Block) -> store.RunDirectory:
        """Return the directory of a block with its intact batches; what is damaged is said."""
        directory = block.directory(store.ResultSchema.of(self.job.grid))
        durable.check_writable(directory.scratch)
        for sentence in directory.load_intact_batches():
            phases.print_line(f"{block.path}: {sentence}")
        return directory

    def _take_earlier(self, directory: store.RunDirectory, ids: np.ndarray) -> None:
        """Take over batches with cases of this block from before the run was divided."""
        if self.earlier_run is None or self._earlier_ids is None:
            return
        numbers = np.unique(self._earlier_ids["batch"][is_common(self._earlier_ids["id"], np.sort(ids))])
        earlier_directory = store.RunDirectory(self.earlier_run.path)
        earlier_directory.batches = [self.earlier_run.batches[number] for number in numbers.tolist()]
        directory.link_batches(earlier_directory)

    def _submit(self, number: int, block: store.Block, requested: np.ndarray) -> None:
        context = RunContext(self.job.directory, self.job.grid, self.job.simulator)

        def submit() -> Future:
            workers = self.case_runner.start_workers(1)  # anew, if the driver has ended them
            return workers.submit(finish_block, context, block, self.job.division, requested)

        self.finishing[number] = submit(), submit

    def collect(self, *, wait: bool = True) -> None:
        """Collect the marks of finished blocks; `wait` for all of them."""
        for number, (future, submit) in list(self.finishing.items()):
            if not wait and not future.done():
                continue
            self.marks[number] = self._await_mark(future, submit)
            del self.finishing[number]
            if number not in self.shared:
                scratch = store.Block(self.job.directory, number).path / store.SCRATCH
                durable.remove_temporaries(scratch, remove_folder=True)

    def _await_mark(self, future: Future, submit: Callable[[], Future]) -> dict[str, Any]:
        """Return the mark from a worker; a dead worker is replaced."""
        for attempt in range(MAX_RESTARTS + 1):
            try:
                while not future.done():
                    if system.requested():
                        raise system.Stopped(system.requested())
                    time.sleep(0.2 * CHECK_INTERVAL)
                mark: dict[str, Any] = future.result()
            except ClearsweepError:
                raise
            except Exception as error:
                if attempt == MAX_RESTARTS:
                    problem = f"a block cannot be finished ({error_line(error)}); run the same command again"
                    raise ClearsweepError(problem) from error
                try:
                    future = submit()
                except RuntimeError:
                    self.case_runner.start_workers(1).restart()
                    future = submit()
            else:
                return mark
        raise AssertionError  # the last attempt returns or raises


def run_blocks(job: BlockJob, case_runner: CaseRunner, directory: store.RunDirectory) -> BlocksOutcome:
    """Run all blocks of a grid with the workers of a pool."""
    numbers, marks = unfinished_blocks(job)
    runner = BlockRunner(job, case_runner, earlier=directory)
    runner.allowed_failures = allowed_failures(job, numbers)
    is_complete = True
    with phases.phase("running blocks"):
        later = sum(len(job.division.part(number)) for number in numbers)
        for number in numbers:
            later -= len(job.division.part(number))
            is_complete = runner.run(number, later=later)
            if not is_complete:
                break
    with phases.phase("finishing blocks"):
        runner.collect()
    return BlocksOutcome(marks | runner.marks, case_runner.ran, case_runner.case_seconds, is_complete)


def allowed_failures(job: BlockJob, numbers: list[int]) -> int | None:
    """Return how many cases of some blocks may fail."""
    cases = sum(len(job.division.part(number)) for number in numbers)
    return failure_limit(job.options.max_failures, cases)


def conclude(
    directory: store.RunDirectory, job: BlockJob, outcome: BlocksOutcome, counts_of_run: tuple[int, int], **facts: Any
) -> dict[str, Any]:
    """Write run.json of a run in blocks; return the counts.

    counts_of_run : numbers of cases run and requested.
    """
    ran, requested = counts_of_run
    store.discard_from(directory.path, job.division.count)
    for name in store.FINAL_FILES:
        durable.discard(directory.path / name)
    marks = [outcome.marks[number] for number in sorted(outcome.marks)]
    ok, failed, others = (sum(mark[name] for mark in marks) for name in ("ok", "failed", "others"))
    counts = counts_of(requested, ran, ok=ok, failed=failed, others=others)
    merged = {"mark": store.sha256_of(json.dumps([mark["files"] for mark in marks]))}
    entries = {"counts": counts, "merged": merged, "blocks": blocks_entry(job, outcome.marks), "answers": {}}
    directory.write_record(job.grid, end=store.utc_now(), **entries, **facts)
    return counts


def counts_of(requested: int, ran: int, *, ok: int, failed: int, others: int) -> dict[str, int]:
    """Return the counts of the cases of a run; others : stored cases that the grid does not have."""
    counts = {"cases": requested, "ran": ran, "reused": max(ok + failed - ran, 0), "ok": ok, "failed": failed}
    return counts | {"missing": requested - ok - failed, "others": others}


def blocks_entry(job: BlockJob, finished: Iterable[int]) -> dict[str, Any]:
    """Return the entry of run.json on the blocks of a run, of which some are finished."""
    return {"size": job.division.size, "count": job.division.count, "numbers": sorted(finished)}


def count_requested(job: BlockJob) -> int:
    """Return the number of different cases of a grid, or of its shard."""
    if job.shard is None:
        return job.division.cases - len(job.duplicates)
    sizes = (len(job.division.part(number)) for number in range(job.division.count))
    shard_count, number = job.shard.of, job.shard.number
    if len(job.duplicates) == 0:
        return sum(len(range(number - 1, size, shard_count)) for size in sizes)
    return sum(len(job.cases(number)[0]) for number in range(job.division.count))
