"""Runs the missing cases of one or more grids: compiles once, and hands cases to the workers."""

import dataclasses
import re
import secrets
import shutil
import time
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import BrokenExecutor, Future, wait
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ... import grid as grids
from ... import store
from ...contracts.case import Case
from ...contracts.results import Peak
from ...contracts.search import CaseResults, Rounds
from ...language import phases
from ...language.errors import InputError, error_line
from .. import Options
from . import executors, system
from .driver import CHECK_INTERVAL, Batches, CaseProgress, CaseTimes, CompilationProgress, Driver
from .worker import SIMULATION, RunContext, Simulator, find_peak, prepare

HERE_SECONDS = 2.0  # s of cases that this process runs at most
POOL_SECONDS = 0.4  # s that worker processes must save before they are started
COMPILE_SECONDS = 0.5  # s of compiling in this process after which workers compile further kinds of scenes at once


def may_run_here(grid: grids.Grid, case: Case, options: Options, simulator: Simulator) -> bool:
    """Return whether cases like this one may run in this process, which they cannot end.

    Laws of one's own may end it, lives and checked cases take long, and only another process ends a case in time.
    """
    is_plain = not (grid.law_files or grid.chained or case.life or case.simulate.error_check or options.case_timeout)
    return simulator is SIMULATION and options.executor == "local" and is_plain


def is_worth_workers(seconds: float, jobs: int) -> bool:
    """Return whether worker processes finish cases of `seconds` in all sooner than this process."""
    return seconds > HERE_SECONDS or seconds * (1.0 - 1.0 / jobs) > POOL_SECONDS


# Shards: parts of a grid that run independently on separate machines.


class Shard(NamedTuple):
    """One of `of` parts of a grid's cases, counted from 1."""

    number: int
    of: int

    @classmethod
    def read(cls, text: str) -> "Shard":
        """Return the shard for a text such as '2/8'; raise InputError for any other text."""
        match = re.fullmatch(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", str(text))
        shard = cls(*map(int, match.groups())) if match else cls(0, 0)
        if not 1 <= shard.number <= shard.of:
            raise InputError(f"shard: found {text!r}; expected I/N with I from 1 to N, such as 2/8")
        return shard

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    def ids(self, ids: np.ndarray) -> np.ndarray:
        """Return the identities of this shard's cases, uint64, from those of all cases.

        They are every N-th of the sorted identities.  These are hashes, so every axis is spread over all shards and
        no shard gets all slow cases.
        """
        return distinct(ids)[self.number - 1 :: self.of].copy()  # a copy, not a view


def distinct(ids: np.ndarray) -> np.ndarray:
    """Return the distinct identities, ascending; np.unique needs five times the memory for a million."""
    ordered = np.sort(ids)
    is_repeated = ordered[1:] == ordered[:-1]
    return ordered[np.concatenate([[True], ~is_repeated])] if is_repeated.any() else ordered


class Pending(NamedTuple):
    """Cases to run."""

    indices: np.ndarray  # (cases,)
    ids: np.ndarray  # (cases,), their identities, uint64
    title: str = ""  # title of their progress
    earlier: tuple[int, int] = (0, 0)  # cases of the same grid or block that need not run, and how many of them failed
    later: int = 0  # cases of later blocks
    read_finished_ids: Callable[[], np.ndarray] | None = (
        None  # returns identities, ascending, that need not be run any more
    )
    has_similar_times: bool = False  # they take about as long as the cases before


class CaseRunner:
    """Runs cases of one or more grids: few cheap ones in this process, the others with workers started for them.

    `ran` is the number of cases run, `case_seconds` their total computing time (s).  `ready` is the time at which the
    first case could begin, or None.
    """

    def __init__(self, directory: store.RunDirectory, options: Options, simulator: Simulator):
        self.directory, self.options, self.simulator = directory, options, simulator
        self.workers: executors.Executor | None = None
        self.here: executors.Executor | None = None  # this process, once it has run cases
        self.ran, self.case_seconds = 0, 0.0
        self.ready_time: float | None = None
        self.failed = 0
        self.times = CaseTimes()  # of the latest cases
        self.compiled_signatures: set[Hashable] = set()  # signatures of compiled scenes
        self.retried: list[np.ndarray] = []  # identities of cases that have been tried again, which is done once

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the workers."""
        if self.workers is not None:
            self.workers.close()
            self.workers = None

    def run(self, grid: grids.Grid, ids: np.ndarray, requested: np.ndarray) -> bool:
        """Run the missing cases of a grid; return False if stopped because too many cases failed.

        ids : identities of all cases, by index
        requested : identities of the required cases, ascending
        """
        rows = self.directory.rows()
        pending = missing_indices(ids, requested, rows, retry_failed=self.options.retry_failed)
        for candidates in self.retried:
            pending = pending[~is_common(ids[pending], candidates)]
        if not len(pending):
            return True
        pending_ids = ids if len(pending) == len(ids) else ids[pending]  # in the same order
        earlier = finished_counts(rows, requested, pending_ids)
        is_complete = self.run_cases(grid, Pending(pending, pending_ids, earlier=earlier))
        if self.options.retry_failed:
            self.retried.append(np.sort(pending_ids))
        return is_complete

    def run_cases(self, grid: grids.Grid, pending: "Pending", allowed_failures: int | None = None) -> bool:
        """Run some cases of a grid; return False if stopped because too many cases failed.

        allowed_failures : number of cases that may fail; default: from the options
        """
        count = len(pending.indices)
        pending, chains = by_chain(grid, pending) if grid.chained else (pending, None)
        grids.check_disk(count * grids.largest_history(grid), shutil.disk_usage(self.directory.path).free)
        with phases.phase("listing the kinds of scenes"):
            scene_cases = one_case_per_scene(grid, pending.indices, self.simulator)
        jobs = min(self.options.jobs or executors.cores(), count)
        driver = secrets.token_hex(8) if pending.read_finished_ids else ""
        context = RunContext(self.directory.path.resolve(), grid, self.simulator, self.options, driver)
        self.times = self.times if pending.has_similar_times else CaseTimes()
        bytes_per_case = grids.first_case_history(grid)
        batches = Batches(pending.indices, pending.ids, jobs, bytes_per_case, self.times, pending.read_finished_ids)
        batches.chains = chains
        done, failed = pending.earlier
        display = CaseProgress(done + count, pending.title, done=done, failed=failed, later=pending.later)
        if allowed_failures is None:
            allowed_failures = failure_limit(self.options.max_failures, count)

        def run(workers: executors.Executor, context: RunContext) -> bool:
            with phases.phase(display):
                allowed = None if allowed_failures is None else allowed_failures + failed - display.failed
                driver = Driver(workers, self.directory, context, batches, allowed, display)
                is_complete = driver.run()
            self.ran, self.case_seconds = self.ran + driver.ran, self.case_seconds + driver.case_seconds
            self.failed += driver.failed
            return is_complete

        if self._is_ready_here(grid, scene_cases):
            assert self.here is not None
            batches.is_too_long = lambda seconds: is_worth_workers(self.case_seconds + seconds, jobs)
            is_complete = run(self.here, dataclasses.replace(context, patience=HERE_SECONDS))
            if not is_complete or batches.is_empty:
                return is_complete
            batches.is_too_long = None
        workers = self.start_workers(count)
        self._compile(workers, scene_cases)
        is_complete = run(workers, context)
        if not is_complete:
            self.workers = None  # the driver has ended them
        return is_complete

    def _is_ready_here(self, grid: grids.Grid, scene_cases: list[Case]) -> bool:
        """Return whether cases may run in this process, after compiling their code, and workers are not started."""
        if self.workers or not may_run_here(grid, scene_cases[0], self.options, self.simulator):
            return False
        self.here, begin = executors.Serial(), phases.compile_seconds()
        for case in scene_cases:
            if phases.compile_seconds() - begin > COMPILE_SECONDS:
                return False
            self._compile(self.here, [case])
        return True

    def results_from(self, grid: grids.Grid, first: int) -> CaseResults | None:
        """Run the missing cases of a grid; return how those from the index `first` on compare with their limits.

        Return None if the run stopped before all cases were finished.
        """
        ids = case_ids(grid)
        if not self.run(grid, ids, np.sort(ids)):
            return None
        stored_rows = self.directory.rows()
        new_rows = stored_rows[np.searchsorted(stored_rows["id"], ids[first:])]
        result_schema = store.ResultSchema.of(grid)
        columns, channels = (
            (grid.search.result_columns(grid), grid.search.result_channels()) if grid.search else ((), ())
        )
        new_results = store.read_results(self.directory, result_schema, new_rows, columns)
        if not channels:
            return new_results
        histories = store.read_histories(self.directory, result_schema, new_rows, channels)
        return new_results._replace(histories=tuple(histories))

    def search(self, grid: grids.Grid, active_search: Rounds) -> tuple[grids.Grid, bool]:
        """Run a grid and the cases that a search adds; return the extended grid, and whether it completed."""
        grid, begin = grid.without_added(), 0
        while results := self.results_from(grid, begin):
            active_search.record(grid, begin, results)
            begin = len(grid)
            points = active_search.ask()
            if not points:
                return grid, True
            grid = grid.with_added(points)
        return grid, False

    def peaks(self, grid: grids.Grid, worst_cases: Sequence[store.Worst]) -> list[Peak | None]:
        """Return the peak revolution of each finished case, or None for a case whose peak is not found again."""
        workers = self.workers or self.here or self.start_workers(len(worst_cases))
        results: list[Peak | None] = []
        tasks = [_submit_peak(workers, self.simulator, grid.case_at(case.point), case) for case in worst_cases]
        for done, (task, worst_case) in enumerate(zip(tasks, worst_cases, strict=True)):
            if saving := phases.innermost_phase():
                saving.note(share=done / len(worst_cases))
            try:
                peak = _await_result(task)
            except Exception as error:
                peak = error_line(error)
            results.append(peak_or_none(worst_case, peak))
        return results

    def _compile(self, workers: executors.Executor, scene_cases: list[Case]) -> None:
        """Compile the code of these cases that is not compiled yet."""
        new_cases = [case for case in scene_cases if self.simulator.signature(case) not in self.compiled_signatures]
        if new_cases:
            compile_all(workers, new_cases, self.simulator, self.directory.path.resolve())
            self.compiled_signatures |= {self.simulator.signature(case) for case in new_cases}
        self.ready_time = self.ready_time or time.monotonic()

    def start_workers(self, cases: int) -> executors.Executor:
        """Return the workers; if there are none, start them for at most `cases` cases at a time."""
        worker_count = min(self.options.jobs or executors.cores(), cases)
        self.workers = self.workers or executors.EXECUTORS[self.options.executor](
            worker_count, self.options.scheduler, self.simulator.load
        )
        return self.workers


def peak_or_none(worst_case: store.Worst, result: Peak | str) -> Peak | None:
    """Return the result of `find_peak`, or None and print why there is none."""
    if not isinstance(result, str):
        return result
    phases.print_line(f"case {worst_case.case_id}: the revolution of its largest peak is left out ({result})")
    return None


def _submit_peak(workers: executors.Executor, *arguments: Any) -> Future:
    """Return the future of `find_peak` in a worker."""
    try:
        return workers.submit(find_peak, *arguments)
    except RuntimeError as error:  # the pool is broken
        future: Future = Future()
        future.set_exception(error)
        return future


def _await_result(future: Future) -> Any:
    """Return the result of a worker; raise Stopped after a signal."""
    while not wait([future], CHECK_INTERVAL).done:
        if system.requested():
            raise system.Stopped(
                system.requested(),
                "stopped: all cases are finished and kept; run the same command again to merge their files",
            )
    return future.result()


def case_ids(grid: grids.Grid) -> np.ndarray:
    """Return the identities of all cases, uint64, by index."""
    return np.fromiter(grid.identities(), "u8", len(grid))


def missing_indices(ids: np.ndarray, requested: np.ndarray, rows: np.ndarray, *, retry_failed: bool) -> np.ndarray:
    """Return the indices of the `requested` cases (ascending) to run, each identity once.

    rows : stored rows, ascending by id.
    """
    if retry_failed:
        rows = rows[~rows["failed"]]
    order = np.argsort(ids, kind="stable")
    sorted_ids = ids[order]
    is_missing = np.concatenate([[True], sorted_ids[1:] != sorted_ids[:-1]])[: len(ids)]
    is_missing &= is_common(sorted_ids, requested)
    is_missing &= ~is_common(sorted_ids, rows["id"])
    return np.sort(order[is_missing])


def by_chain(grid: grids.Grid, pending: Pending) -> tuple[Pending, np.ndarray]:
    """Return the cases with those of a chain one behind the other in its order, and the number of each one's chain."""
    places = [grid.place_in_chain(index) for index in pending.indices.tolist()]
    numbers = {key: number for number, key in enumerate(dict.fromkeys(key for key, _ in places))}
    chains, steps = np.array([numbers[key] for key, _ in places]), np.array([step for _, step in places])
    order = np.lexsort([steps, chains])
    return pending._replace(indices=pending.indices[order], ids=pending.ids[order]), chains[order]


def finished_counts(rows: np.ndarray, requested: np.ndarray, pending: np.ndarray) -> tuple[int, int]:
    """Return how many requested cases are not pending, and how many of these failed; both arrays are identities."""
    kept = rows[is_common(rows["id"], requested) & ~is_common(rows["id"], np.sort(pending))]
    return len(requested) - len(pending), int(np.count_nonzero(kept["failed"]))


def is_common(values: np.ndarray, sorted_values: np.ndarray) -> np.ndarray:
    """Return a mask of the values that are in `sorted_values` (ascending), with a fifth of the memory of np.isin."""
    if not len(sorted_values):
        return np.zeros(len(values), bool)
    positions = np.searchsorted(sorted_values, values)
    positions[positions == len(sorted_values)] = 0
    mask: np.ndarray = sorted_values[positions] == values
    return mask


def one_case_per_scene(grid: grids.Grid, pending: np.ndarray, simulator: Simulator) -> list[Case]:
    """Return a pending case for each kind of scene; only law names can change the kind."""
    if not any(isinstance(values[0], str) for values in grid.axes.values()):
        return [grid.case(int(pending[0]))]
    first, end = int(pending.min()), int(pending.max()) + 1
    is_pending = np.zeros(end - first, bool)
    is_pending[pending - first] = True
    first_indices: dict[grids.LawAssignment, int] = {}
    for offset, law_names in enumerate(grid.law_assignments(range(first, end))):
        if is_pending[offset] and law_names not in first_indices:
            first_indices[law_names] = first + offset
    cases = [grid.case(index) for index in first_indices.values()]
    return list({simulator.signature(case): case for case in cases}.values())


def compile_all(workers: executors.Executor, cases: list[Case], simulator: Simulator, directory: Path) -> float:
    """Compile the code of these cases, each part in one worker, so that all workers find it in the cache.

    Return the total compile time (s) of all workers, without the time for loading.

    directory : the directory of the run; its folder for temporary files contains the progress

    Errors are ignored here: they occur again when the case is run, and are recorded then.
    """
    parts = [(simulator.compile_loop, cases[0]), *((simulator.compile_for, case) for case in cases)]
    progress_files = [store.Working(directory, secrets.token_hex(8)) for _ in parts]

    def read_progress() -> list[phases.Progress]:
        return [results for working in progress_files if (results := working.read())]

    try:
        compiling = CompilationProgress(len(parts), read_progress)
        with phases.phase(compiling):
            tasks = [
                workers.submit(prepare, working, *part) for working, part in zip(progress_files, parts, strict=True)
            ]
            failures, seconds = list[Exception](), 0.0
            for task in tasks:
                try:
                    seconds += task.result()
                except Exception as error:
                    failures.append(error)
                compiling.done += 1
    except RuntimeError as error:  # of the pool, as in `Driver`; BrokenExecutor is one
        failures, seconds = [BrokenExecutor(str(error))], 0.0
    if any(isinstance(failure, BrokenExecutor) for failure in failures):
        workers.restart()
    elif compile_failure := next((error for error in failures if not isinstance(error, InputError)), None):
        phases.print_line(
            f"compiling in advance failed ({error_line(compile_failure)}); cases that need this code will report it"
        )
    return seconds


def failure_limit(max_failures: int | str | None, cases: int) -> int | None:
    """Return how many cases may fail, from a number or a percentage."""
    if max_failures is None:
        return None
    text = str(max_failures).strip()
    scale = cases / 100.0 if text.endswith("%") else 1.0
    try:
        limit = int(float(text.removesuffix("%")) * scale)
    except (ValueError, OverflowError):
        limit = -1
    if limit < 0:
        raise InputError(f"max failures: found {max_failures!r}; expected a number of cases (20) or a share (5%)")
    return limit
