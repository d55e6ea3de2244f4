"""The driver of a sweep: divides pending cases into batches, supplies the workers, and replaces dead ones."""

import contextlib
import os
import secrets
import signal
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait

import numpy as np

from .. import store
from ..language.errors import ClearsweepError, StorageError
from ..language.phases import Progress
from ..store import durable
from . import signals
from .executors import Executor
from .progress import Cases
from .tasks import Batch, Tasks
from .worker import Job, Manifest, failure, read_note, run_batch

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


class Batches:
    """Pending cases, divided into batches of about TARGET_SECONDS; lost cases come first."""

    def __init__(
        self,
        pending: np.ndarray,
        ids: np.ndarray,
        jobs: int,
        bytes_per_case: float,
        drop: Callable[[], np.ndarray] | None = None,
    ):
        """Prepare for the indices of the `pending` cases and their identities, uint64, both (cases,).

        drop : called at intervals; returns the identities (ascending) of the cases that other drivers have finished
        """
        self.pending, self.ids, self.jobs, self.drop = pending, ids, jobs, drop
        self.max_cases = max(1, min(MAX_BATCH_CASES, int(MAX_BATCH_BYTES / max(bytes_per_case, 1.0))))
        self.handed_out_count, self.largest_batch = 0, 1
        self.done, self.seconds = 0.0, 0.0  # of recent batches
        self.requeued: deque[Batch] = deque()
        self.last_drop_time = time.monotonic()

    def copy_times(self, earlier: "Batches") -> None:
        """Expect these cases to take as long as those of earlier batches."""
        self.done, self.seconds, self.largest_batch = earlier.done, earlier.seconds, earlier.largest_batch

    def learn(self, manifest: Manifest) -> None:
        """Include the time of a finished batch in the estimate; older batches count less: the first ones load code."""
        if manifest.seconds:
            self.done = OLD_BATCH_WEIGHT * self.done + manifest.done
            self.seconds = OLD_BATCH_WEIGHT * self.seconds + manifest.seconds
            self.largest_batch = max(self.largest_batch, manifest.done)

    def next(self) -> Batch | None:
        """Return the next batch, or None if none is left."""
        if self.requeued:
            return self.requeued.popleft()
        if self.drop and time.monotonic() - self.last_drop_time > TARGET_SECONDS:
            self._drop(self.drop())
        size = min(self._size(), len(self.pending) - self.handed_out_count)
        if not size:
            return None
        selection = slice(self.handed_out_count, self.handed_out_count + size)
        self.handed_out_count += size
        return new_batch(Tasks(self.pending[selection], self.ids[selection]))

    def _drop(self, finished_ids: np.ndarray) -> None:
        """Drop finished cases from those not handed out yet."""
        is_left = ~np.isin(self.ids[self.handed_out_count :], finished_ids)
        self.pending, self.ids, self.handed_out_count = (
            self.pending[self.handed_out_count :][is_left],
            self.ids[self.handed_out_count :][is_left],
            0,
        )
        self.last_drop_time = time.monotonic()

    def _size(self) -> int:
        if not self.done:
            return 1
        mean = max(self.seconds / self.done, 1e-6)
        even_size = (len(self.pending) - self.handed_out_count) / (2.0 * self.jobs)
        return max(
            1,
            min(
                int(max(min(TARGET_SECONDS / mean, even_size), MIN_BATCH_SECONDS / mean)),
                BATCH_GROWTH * self.largest_batch,
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
        job: Job,
        batches: Batches,
        allowed_failures: int | None,
        progress: Cases,
    ):
        self.executor, self.directory, self.job, self.batches = executor, directory, job, batches
        self.allowed_failures, self.progress = allowed_failures, progress
        progress.read_cases = self._current_cases
        self.running: dict[Future, Batch] = {}  # under way
        self.ran, self.failed, self.case_seconds, self.restarts = 0, 0, 0.0, 0
        self.death_times: dict[Future, float] = {}  # s, time at which its worker was found dead

    def run(self) -> bool:
        """Run all batches; return False if stopped because too many cases failed."""
        with signals.patience():
            while not signals.requested():
                if self._has_too_many_failures():
                    self._drain()
                    return False
                self._hand_out()
                if not self.running:
                    return True
                done, _ = wait(self.running, timeout=CHECK_INTERVAL, return_when=FIRST_COMPLETED)
                for future in done or self._orphans():
                    self._settle(future)
            self._drain()
            raise signals.Stopped(
                signals.requested(),
                f"stopped: {self.ran:,} of {self.progress.total:,} "
                "cases were finished and are kept; run the same command again to continue",
            )

    def _has_too_many_failures(self) -> bool:
        return self.allowed_failures is not None and self.failed > self.allowed_failures

    def _hand_out(self) -> None:
        jobs = self.batches.jobs = self.progress.jobs = self.executor.jobs  # the number of a cluster's workers varies
        while len(self.running) < BATCHES_PER_WORKER * jobs and not signals.requested():
            batch = self.batches.next()
            if batch is None:
                return
            try:
                self.running[self.executor.submit(run_batch, self.job, batch)] = batch
            except RuntimeError:  # the pool has just broken
                self.batches.requeued.appendleft(batch)
                self._restart()

    def _settle(self, future: Future) -> None:
        """Record the end of one batch."""
        if future not in self.running:
            return  # lost in a restart that another batch caused
        batch = self.running.pop(future)
        if self.death_times.pop(future, None) and not future.done():
            future.cancel()
            self._handle_death(batch, None)
            return
        try:
            manifest = future.result()
        except self.executor.death_errors as error:
            self._handle_death(batch, getattr(error, "exitcode", None))
        except (BrokenExecutor, CancelledError):
            self.running[future] = batch
            self._restart()
        except StorageError:
            self._drain()
            raise
        else:
            self._record_result(batch, manifest)

    def _record_result(self, batch: Batch, manifest: Manifest) -> None:
        """Record a batch that its worker has returned."""
        self._discard(batch)
        if manifest.committed:
            self.directory.register_batch(manifest.committed)
            self.restarts = 0
        self.batches.learn(manifest)
        self.ran += manifest.done
        self.failed += manifest.failed
        self.case_seconds += manifest.seconds
        self.progress.advance(manifest.done, self.failed)
        if remaining_cases := batch.cases.part(manifest.done):
            self.batches.requeued.append(new_batch(remaining_cases))  # its worker was asked to stop

    def _was_committed(self, batch: Batch) -> bool:
        """Return whether a worker committed this batch before it died; if so, record it."""
        committed = self.directory.committed_summary(batch.name)
        if committed is None:
            return False
        self._record_result(batch, Manifest(committed, *self.directory.counts_of(committed), 0.0))
        return True

    def _handle_death(self, batch: Batch, exitcode: int | None) -> None:
        """Handle a batch whose worker died: its current case runs once more by itself, the others are requeued."""
        note = read_note(self.job, batch)
        self._discard(batch)
        if self._was_committed(batch):
            return
        if note is None:  # it died before the first case
            self.batches.requeued.append(new_batch(batch.cases, batch.attempts + 1))
            if batch.attempts < MAX_RESTARTS:
                return
            raise ClearsweepError(
                f"workers die before their first case ({_death_cause(exitcode)}); try --executor serial to see why"
            )
        position = note.batch_index
        failing_case, remaining = batch.cases.part(position, position + 1), batch.cases.without(position)
        if remaining:
            self.batches.requeued.append(new_batch(remaining, 1))  # one by one
        if note.late:
            self._give_up(
                failing_case, "timeout", f"took longer than the {self.job.case_timeout:g} s of --case-timeout"
            )
        elif remaining or not batch.attempts:
            self.batches.requeued.append(new_batch(failing_case, 1))
        else:
            self._give_up(failing_case, "crashed", f"its worker died twice ({_death_cause(exitcode)})")

    def _give_up(self, failing_case: Tasks, status: str, message: str) -> None:
        """Commit a failed row for a case that cannot be computed."""
        batch, (case,) = new_batch(failing_case), failing_case.listed()
        row = store.Row(case.case_id, self.job.grid.point(case.grid_index), failure(status, message))
        committed = store.commit(self.job.directory, self.job.result_schema, batch.name, [row])
        self._record_result(batch, Manifest(committed, 1, 1, 0.0))

    def _restart(self) -> None:
        """Replace a broken pool; running batches are handed out again unless they were committed."""
        self.restarts += 1
        if self.restarts > MAX_RESTARTS:
            raise ClearsweepError("the workers cannot be started or die at once; try --executor serial to see why")
        running, self.running, self.death_times = self.running, {}, {}
        self.executor.restart()
        for batch in running.values():
            if not self._was_committed(batch):
                self.batches.requeued.append(new_batch(batch.cases, batch.attempts))

    def _orphans(self) -> list[Future]:
        """Return futures that will not end: their worker died some time ago, unnoticed by the pool.

        A worker on another machine cannot be checked, but its commits can.
        """
        now, elsewhere = time.monotonic(), self.executor.is_remote
        committed = self.directory.committed() if elsewhere else set()
        for future, batch in self.running.items():
            note = None if elsewhere else read_note(self.job, batch)
            if batch.name in committed or (note and not _is_alive(note.process)):
                self.death_times.setdefault(future, now)
        return [future for future, since in list(self.death_times.items()) if now - since > DEATH_TIMEOUT]

    def _discard(self, batch: Batch) -> None:
        """Remove a worker's note on a batch."""
        durable.discard(self.job.note(batch))
        self.job.working(batch).replace_progress(None)

    def _current_cases(self) -> tuple[int, list[Progress]]:
        """Return how many cases of the running batches are finished, and the current cases of the workers."""
        done, cases = 0, []
        for batch in list(self.running.values()):  # another thread may change it
            note = read_note(self.job, batch)
            if note is None:
                continue
            done += note.batch_index
            task, progress = batch.cases[note.batch_index], self.job.working(batch).read()
            if progress is None or progress.facts.get("case_id") != task.case_id:
                progress = Progress("", max(time.time() - note.since, 0.0), facts=self.job.facts(task))
            cases.append(progress)
        return done, sorted(cases, key=lambda case: -case.seconds)

    def _drain(self) -> None:
        """Wait until the workers have finished their current cases, end them, and record their commits."""
        with contextlib.suppress(OSError):  # a full disk: end them without a warning
            os.close(durable.create(self.job.stop))
        for future in wait(self.running, timeout=STOP_TIMEOUT).done:
            with contextlib.suppress(Exception):
                self._record_result(self.running[future], future.result())
                del self.running[future]
        self.executor.close()
        for batch in self.running.values():
            self._was_committed(batch)


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def _death_cause(exitcode: int | None) -> str:
    if exitcode is None:
        return "unknown cause"
    if exitcode >= 0:
        return f"exit code {exitcode}"
    name = signal.Signals(-exitcode).name
    return f"{name}, perhaps out of memory" if name == "SIGKILL" else name
