"""The driver of a sweep: divides pending cases into batches, supplies the workers, and replaces dead ones."""

import contextlib
import math
import os
import secrets
import signal
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from pathlib import Path
from typing import Any

import numpy as np

from ... import store
from ...language import phases
from ...language.errors import ClearsweepError, StorageError, error_line
from ...language.phases import Progress
from ...store import durable
from ...store.batch import hash_in_name
from . import system
from .executors import Executor
from .worker import Batch, BatchOutcome, RunContext, Tasks, failure, read_worker_status, run_batch

# Progress of the cases of a sweep, and of the workers that compile for it; `language.phases` prints it.


SETTLING_TIME = 1.0  # s after the first case before the time left is shown
MAX_LISTED_CASES = 3  # most running cases in a line
LONG_CASE_TIME = phases.FIRST_LINE_DELAY  # s after which a running case is listed


class CaseProgress(phases.Phase):
    """The phase in which cases run: how many are finished, how long the others take, and which take long."""

    def __init__(self, total: int, title: str = "", *, done: int = 0, failed: int = 0, later: int = 0):
        """Prepare for a number of cases, with a title.

        done, failed : cases of `total` that an earlier run finished, and that failed in it; later : further cases
        """
        super().__init__(self._status_text)
        self.title, self.earlier, self.later = title, done, later
        self.total, self.done, self.failed, self.worker_count = total, done, failed, 1
        self.facts = {"run": self._counts()}
        self.first_cases: tuple[float, int] | None = None  # s and number, from which the mean rate counts
        #: Returns the number of finished cases in running batches, and the current cases of the workers.
        self.read_progress: Callable[[], tuple[int, Sequence[phases.Progress]]] = _nothing_at_work
        self._last_read: tuple[float, tuple[int, Sequence[phases.Progress]]] = (-math.inf, (0, ()))

    def _counts(self) -> dict[str, int]:
        """Return the numbers of cases for `status`."""
        return {"cases": self.total, "ok": self.done - self.failed, "failed": self.failed}

    def running_cases(self) -> tuple[int, Sequence[phases.Progress]]:
        """Return the number of finished cases and the progress of the running ones; files are read once in a while."""
        now = time.monotonic()
        if now - self._last_read[0] >= phases.REFRESH_INTERVAL:
            self._last_read = now, self.read_progress()
        return self._last_read[1]

    def advance(self, new_done: int, new_failed: int) -> None:
        """Record more finished cases, and how many of them failed."""
        self.done, self.failed = self.done + new_done, self.failed + new_failed
        self._remaining_by_rate(self.done)
        self.note(run=self._counts())

    def _status_text(self) -> str:
        done_count = min(self.done + self.running_cases()[0], self.total)
        self.share = done_count / max(self.total, 1)
        return f"{self.title}{done_count:,} of {self.total:,} cases, {self.failed:,} failed"

    def _remaining_by_rate(self, done: int) -> float | None:
        """Return the time (s) left after `done` cases at the mean rate since the first ones, None while unknown."""
        if self.first_cases is None and done > self.earlier:
            self.first_cases = time.monotonic(), done
        begin, first_done = self.first_cases or (math.inf, done)
        spent = time.monotonic() - begin
        if done == first_done or spent < SETTLING_TIME:
            return None
        return spent * (self.total + self.later - done) / (done - first_done)

    def remaining_time(self, now: float) -> float | None:
        """Return the time (s) left: from the mean pace of cases, or from the progress of running ones."""
        done_in_batches, running = self.running_cases()
        with_estimate = [case for case in running if case.left is not None]
        done = self.done + done_in_batches
        remaining_by_rate = self._remaining_by_rate(done)
        if not with_estimate:
            return remaining_by_rate
        remaining_time = max(case.left or 0.0 for case in with_estimate)
        if remaining_by_rate is not None:
            return max(remaining_by_rate, remaining_time)
        durations = [case.seconds + (case.left or 0.0) for case in with_estimate if not case.once]
        if not durations:
            return None
        waiting = max(self.total + self.later - done - len(running), 0)
        return max(
            remaining_time,
            sum(durations) / len(durations) * (1.0 + waiting / max(self.worker_count, 1)) - with_estimate[0].seconds,
        )

    def line_suffix(self) -> str:
        """Return the long cases, each with its progress."""
        long_cases = [case for case in self.running_cases()[1] if case.seconds >= LONG_CASE_TIME]
        omitted = f"; and {len(long_cases) - MAX_LISTED_CASES:,} more" if len(long_cases) > MAX_LISTED_CASES else ""
        return "".join(f"; {store.case_text(case)}" for case in long_cases[:MAX_LISTED_CASES]) + omitted


def _nothing_at_work() -> tuple[int, Sequence[phases.Progress]]:
    return 0, ()


class CompilationProgress(phases.Phase):
    """The phase in which workers compile or load the code of cases."""

    def __init__(self, parts: int, read_progress: Callable[[], Sequence[phases.Progress]]):
        """Prepare for a number of parts to compile; `read_progress` returns the progress of running ones."""
        super().__init__(self._status_text)
        self.parts, self.read_progress, self.done = parts, read_progress, 0

    def _status_text(self) -> str:
        if phases.innermost_phase() is not self:
            return ""  # the worker is this process, which shows it itself
        phase = next((part.what for part in self.read_progress()), "loading compiled code")
        return f"{phase}, part {min(self.done + 1, self.parts)} of {self.parts}"

    def remaining_time(self, now: float) -> float | None:
        """Return the time (s) left: of the slowest running part, and of the others at the present pace."""
        slowest = max((part.left for part in self.read_progress() if part.left is not None), default=None)
        if slowest is None or not self.done:
            return slowest
        return slowest + (now - self.begin) * max(self.parts / self.done - 2.0, 0.0)  # at least two at a time


TARGET_SECONDS = 2.0  # s of work in a batch: a commit takes about 20 ms, and a killed worker loses this much
MIN_BATCH_SECONDS = 0.25  # s of work in a batch near the end, when the rest is distributed evenly
MAX_BATCH_CASES = 4096  # cases in a batch, whose rows are kept in memory, 3 kB each
MAX_BATCH_BYTES = 32e6  # bytes of histories in a batch
OLD_BATCH_WEIGHT = 0.25  # weight of a batch in the mean time of a case, per later batch
BATCH_GROWTH = 8  # largest growth of the batch size: the first cases may not be typical
BATCHES_PER_WORKER = 2  # batches per worker: one running, one waiting
CHECK_INTERVAL = 0.25  # s between checks of signals and workers
STOP_TIMEOUT = 4.0  # s for workers to finish their cases after a signal
DEATH_TIMEOUT = 2.0  # s for the pool to notice a dead worker itself
MAX_RESTARTS = 3  # restarts of the pool without a finished batch in between


class CaseTimes:
    """The mean time of a case, from the times of batches."""

    def __init__(self) -> None:
        self.case_count, self.seconds = 0.0, 0.0  # of recent batches; older ones count less
        self.largest_batch_size = 1

    def add(self, outcome: BatchOutcome) -> None:
        """Include the time of a finished batch; older batches count less: the first ones load code."""
        if outcome.seconds:
            self.case_count = OLD_BATCH_WEIGHT * self.case_count + outcome.finished_count
            self.seconds = OLD_BATCH_WEIGHT * self.seconds + outcome.seconds
            self.largest_batch_size = max(self.largest_batch_size, outcome.finished_count)

    @property
    def mean(self) -> float:
        """Return the mean time (s), 0 before the first batch."""
        return self.seconds / self.case_count if self.case_count else 0.0


class Batches:
    """Pending cases, divided into batches of about TARGET_SECONDS; lost cases come first."""

    def __init__(
        self,
        pending: np.ndarray,
        ids: np.ndarray,
        worker_count: int,
        bytes_per_case: float,
        times: CaseTimes | None = None,
        read_finished_ids: Callable[[], np.ndarray] | None = None,
    ):
        """Prepare for the indices of the `pending` cases and their identities, uint64, both (cases,).

        times : of cases that take about as long, to which those of these cases are added; default: unknown
        read_finished_ids : called at intervals; returns the identities (ascending) of cases that other drivers finished
        """
        self.pending = pending
        self.ids = ids
        self.worker_count = worker_count
        self.read_finished_ids = read_finished_ids
        self.chains: np.ndarray | None = None  # number of the chain of each pending case, whose cases are together
        self.is_too_long: Callable[[float], bool] | None = None  # whether some s of work are left to other workers
        self.max_cases = max(1, min(MAX_BATCH_CASES, int(MAX_BATCH_BYTES / max(bytes_per_case, 1.0))))
        self.handed_out_count, self.times = 0, times or CaseTimes()
        self.requeued: deque[Batch] = deque()
        self.last_removal_time = time.monotonic()

    @property
    def is_empty(self) -> bool:
        """Return whether all cases are handed out."""
        return not self.requeued and self.handed_out_count == len(self.pending)

    def next(self) -> Batch | None:
        """Return the next batch, or None if none is left."""
        if self.is_too_long and (self.requeued or self.is_too_long(self._remaining_seconds())):
            return None
        if self.requeued:
            return self.requeued.popleft()
        if self.read_finished_ids and time.monotonic() - self.last_removal_time > TARGET_SECONDS:
            finished_ids = self.read_finished_ids()
            is_left = ~np.isin(self.ids[self.handed_out_count :], finished_ids)
            self.pending = self.pending[self.handed_out_count :][is_left]
            self.ids = self.ids[self.handed_out_count :][is_left]
            self.handed_out_count = 0
            self.last_removal_time = time.monotonic()
        size = min(self._size(), len(self.pending) - self.handed_out_count)
        if not size:
            return None
        if self.chains is not None:  # each case needs the end of the one before it: a chain is not divided
            last = self.chains[self.handed_out_count + size - 1]
            size = int(np.searchsorted(self.chains, last, side="right")) - self.handed_out_count
        selection = slice(self.handed_out_count, self.handed_out_count + size)
        self.handed_out_count += size
        # copies: the pool keeps its latest batches, and with views of them all cases, 16 bytes each
        return new_batch(Tasks(self.pending[selection].copy(), self.ids[selection].copy()))

    def _remaining_seconds(self) -> float:
        """Return the expected time (s) of the cases that are not handed out yet, 0 before the first case."""
        return self.times.mean * (len(self.pending) - self.handed_out_count)

    def _size(self) -> int:
        if not self.times.case_count:
            return 1
        mean = max(self.times.mean, 1e-6)
        even_size = (len(self.pending) - self.handed_out_count) / (2.0 * self.worker_count)
        even_size *= 2.0 if self.worker_count == 1 else 1.0  # nobody else waits for the last cases
        return max(
            1,
            min(
                int(max(min(TARGET_SECONDS / mean, even_size), MIN_BATCH_SECONDS / mean)),
                BATCH_GROWTH * self.times.largest_batch_size,
                self.max_cases,
            ),
        )


def new_batch(cases: Tasks, attempts: int = 0) -> Batch:
    """Return a batch with a unique name."""
    return Batch(secrets.token_hex(8), cases, attempts)


class Driver:
    """Hands batches to an executor until none is left, a signal arrives, or too many cases failed."""

    def __init__(
        self,
        executor: Executor,
        directory: store.RunDirectory,
        context: RunContext,
        batches: Batches,
        allowed_failures: int | None,
        progress: CaseProgress,
    ):
        self.executor, self.directory, self.context, self.batches = executor, directory, context, batches
        self.allowed_failures, self.progress = allowed_failures, progress
        progress.read_progress = self._current_cases
        self.running: dict[Future, Batch] = {}  # under way
        self.ran, self.failed, self.case_seconds, self.restarts = 0, 0, 0.0, 0
        self.death_times: dict[Future, float] = {}  # s, time at which its worker was found dead

    def run(self) -> bool:
        """Run all batches; return False if stopped because too many cases failed."""
        with system.patience(), contextlib.ExitStack() as at_end:
            at_end.callback(setattr, self.progress, "read_progress", _nothing_at_work)  # and this driver can be freed
            while not system.requested():
                if self.allowed_failures is not None and self.failed > self.allowed_failures:
                    self._drain()
                    return False
                self._hand_out()
                if not self.running:
                    return True
                self.progress.note()  # of long cases
                completed_futures, _ = wait(self.running, timeout=CHECK_INTERVAL, return_when=FIRST_COMPLETED)
                for future in completed_futures or self._futures_of_dead_workers():
                    self._handle_completion(future)
            self._drain()
            raise system.Stopped(
                system.requested(),
                f"stopped: {self.progress.done:,} of {self.progress.total:,} "
                "cases are finished and kept; run the same command again to continue",
            )

    def _hand_out(self) -> None:
        worker_count = self.executor.worker_count  # that of a cluster varies
        self.batches.worker_count = self.progress.worker_count = worker_count
        while len(self.running) < BATCHES_PER_WORKER * worker_count and not system.requested():
            batch = self.batches.next()
            if batch is None:
                return
            try:
                future = self.executor.submit(run_batch, self.context, batch)
                self.running[future] = batch
                if future.done():  # it ran in this process: its time divides the others
                    return
            except RuntimeError:  # the pool has just broken
                self.batches.requeued.appendleft(batch)
                self._restart()

    def _handle_completion(self, future: Future) -> None:
        """Record the end of one batch."""
        if future not in self.running:
            return  # lost in a restart that another batch caused
        batch = self.running.pop(future)
        if self.death_times.pop(future, None) and not future.done():
            future.cancel()
            self._handle_death(batch, None)
            return
        try:
            outcome = future.result()
        except self.executor.death_errors as error:
            self._handle_death(batch, getattr(error, "exitcode", None))
        except (BrokenExecutor, CancelledError):
            self.running[future] = batch
            self._restart()
        except StorageError:
            self._drain()
            raise
        except ClearsweepError:
            raise
        except Exception as error:
            if not self.executor.is_remote:
                raise
            raise _strange_answer(f"it ended with {error_line(error)}") from error
        else:
            self._record_result(batch, outcome)

    def _record_result(self, batch: Batch, outcome: BatchOutcome) -> None:
        """Record a batch that its worker has returned; ClearsweepError for an answer that no worker of a run gives."""
        if strange := _describe_strange(batch, outcome):
            raise _strange_answer(strange)
        self._remove_worker_files(batch)
        if outcome.committed:
            self.directory.register_batch(outcome.committed)
            if not np.array_equal(
                np.sort(self.directory.batches[-1].ids), np.sort(batch.cases.ids[: outcome.finished_count])
            ):
                raise _strange_answer(f"{outcome.committed} has other cases than the batch")
            self.restarts = 0
        self.batches.times.add(outcome)
        self.ran += outcome.finished_count
        self.failed += outcome.failed_count
        self.case_seconds += outcome.seconds
        self.progress.advance(outcome.finished_count, outcome.failed_count)
        if remaining_cases := batch.cases.part(outcome.finished_count):  # its worker stopped earlier
            attempts = 0 if outcome.finished_count else batch.attempts + 1
            if attempts > MAX_RESTARTS:
                raise _strange_answer("no case of it is finished, however often it is handed out")
            self.batches.requeued.append(new_batch(remaining_cases, attempts))

    def _record_if_committed(self, batch: Batch) -> bool:
        """Record a batch if its worker committed it before it died; return whether it did."""
        committed = next((path.name for path in self.directory.summaries.glob(f"{batch.name}-*.parquet")), None)
        if committed is None:
            return False
        failed = self.directory.read_batch(committed).failed
        self._record_result(batch, BatchOutcome(committed, len(failed), int(np.count_nonzero(failed)), 0.0))
        return True

    def _handle_death(self, batch: Batch, exitcode: int | None) -> None:
        """Handle a batch whose worker died: its current case runs once more by itself, the others are requeued."""
        worker_status = read_worker_status(self.context, batch)
        self._remove_worker_files(batch)
        if self._record_if_committed(batch):
            return
        if worker_status is None:  # it died before the first case
            self.batches.requeued.append(new_batch(batch.cases, batch.attempts + 1))
            if batch.attempts < MAX_RESTARTS:
                return
            raise ClearsweepError(
                f"workers die before their first case ({death_cause(exitcode)}); try --executor serial to see why"
            )
        position = worker_status.batch_index
        failing_case, remaining = batch.cases.part(position, position + 1), batch.cases.without(position)
        if remaining:
            self.batches.requeued.append(new_batch(remaining))
        if worker_status.timed_out:
            self._give_up(
                failing_case,
                "timeout",
                f"took longer than the {self.context.options.case_timeout:g} s of --case-timeout",
            )
        elif remaining or not batch.attempts:
            self.batches.requeued.append(new_batch(failing_case, 1))
        else:
            self._give_up(failing_case, "crashed", f"its worker died twice ({death_cause(exitcode)})")

    def _give_up(self, failing_case: Tasks, status: str, message: str) -> None:
        """Commit a failed row for a case that cannot be computed."""
        batch, (case,) = new_batch(failing_case), failing_case.listed()
        row = store.Row(case.case_id, self.context.grid.point(case.grid_index), failure(status, message))
        committed = store.commit(self.context.directory, self.context.result_schema, batch.name, [row])
        self._record_result(batch, BatchOutcome(committed, 1, 1, 0.0))

    def _restart(self) -> None:
        """Replace a broken pool; running batches are handed out again unless they were committed."""
        self.restarts += 1
        if self.restarts > MAX_RESTARTS:
            raise ClearsweepError("the workers cannot be started or die at once; try --executor serial to see why")
        running, self.running, self.death_times = self.running, {}, {}
        self.executor.restart()
        for batch in running.values():
            if not self._record_if_committed(batch):
                self.batches.requeued.append(new_batch(batch.cases, batch.attempts))

    def _futures_of_dead_workers(self) -> list[Future]:
        """Return futures that will not end: their worker died some time ago, unnoticed by the pool.

        A worker on another machine cannot be checked, but its commits can.
        """
        now, elsewhere = time.monotonic(), self.executor.is_remote
        committed = {name.partition("-")[0] for name in self.directory.summary_names()} if elsewhere else set()
        for future, batch in self.running.items():
            worker_status = None if elsewhere else read_worker_status(self.context, batch)
            if batch.name in committed or (worker_status and not _is_alive(worker_status.process)):
                self.death_times.setdefault(future, now)
        return [future for future, since in list(self.death_times.items()) if now - since > DEATH_TIMEOUT]

    def _remove_worker_files(self, batch: Batch) -> None:
        """Remove the status and the progress of a batch's worker."""
        durable.discard(self.context.status_file(batch))
        self.context.working(batch).replace_progress(None)

    def _current_cases(self) -> tuple[int, list[Progress]]:
        """Return how many cases of the running batches are finished, and the current cases of the workers."""
        finished_count, cases = 0, []
        for batch in list(self.running.values()):  # another thread may change it
            worker_status = read_worker_status(self.context, batch)
            if worker_status is None:
                continue
            finished_count += worker_status.batch_index
            task, progress = batch.cases[worker_status.batch_index], self.context.working(batch).read()
            if progress is None or progress.facts.get("case_id") != task.case_id:
                progress = Progress("", max(time.time() - worker_status.since, 0.0), facts=self.context.facts(task))
            cases.append(progress)
        return finished_count, sorted(cases, key=lambda case: -case.seconds)

    def _drain(self) -> None:
        """Wait until the workers have finished their current cases, end them, and record their commits."""
        with contextlib.suppress(OSError):  # a full disk: end them without a warning
            os.close(durable.create_file(self.context.stop))
        for future in wait(self.running, timeout=STOP_TIMEOUT).done:
            with contextlib.suppress(Exception):
                self._record_result(self.running[future], future.result())
                del self.running[future]
        self.executor.close()
        for batch in self.running.values():
            self._record_if_committed(batch)


def _describe_strange(batch: Batch, outcome: Any) -> str:
    """Return why an answer for a batch cannot be from a worker of a run, or ''; those of a cluster are not trusted."""
    if not isinstance(outcome, BatchOutcome):
        return f"it is {type(outcome).__name__}, not the outcome of a batch"
    committed, finished, failed, seconds = outcome
    counts = (finished, failed)
    if not all(type(count) is int for count in counts) or not 0 <= failed <= finished <= len(batch.cases):
        return f"it counts {finished!r} finished and {failed!r} failed of {len(batch.cases)} cases"
    if not isinstance(seconds, float) or not 0.0 <= seconds < math.inf:
        return f"it took {seconds!r} s"
    if (committed is None) != (finished == 0):
        return f"it finished {finished} cases and committed {committed!r}"
    is_own = committed is None or (hash_in_name(Path(str(committed))) and str(committed).startswith(f"{batch.name}-"))
    return "" if is_own else f"it committed {committed!r}, which is none of its files"


def _strange_answer(reason: str) -> ClearsweepError:
    return ClearsweepError(
        f"a batch of cases was answered as no worker of this run answers: {reason}; finished cases are kept: run the "
        "same command again, on a cluster that nobody else uses"
    )


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def death_cause(exitcode: int | None) -> str:
    """Return why a worker died, by its exit code, as a message says it."""
    if exitcode is None:
        return "unknown cause"
    if exitcode >= 0:
        return f"exit code {exitcode}"
    try:
        name = signal.Signals(-exitcode).name
    except ValueError:  # a real-time signal has a number only
        name = f"signal {-exitcode}"
    return f"{name}, perhaps out of memory" if name == "SIGKILL" else name
