"""What a worker process does: it computes a batch of cases one by one and commits them; a manifest goes back."""

import contextlib
import ctypes
import faulthandler
import os
import pickle
import platform
import signal
import sys
import time
from collections.abc import Callable, Hashable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from .. import resources, store
from ..case import Case
from ..catalogue import Catalogue
from ..errors import ClearsweepError, brief
from ..grid import Grid
from ..results import Trajectory
from ..store import durable
from . import signals

_PR_SET_PDEATHSIG = 1
NOTE_LENGTH = 22  # bytes that say who is at which case; after them a watchdog writes where a late case was


class Simulator(Protocol):
    """What a sweep asks of mechanics: `SIMULATION`, or what a test puts in its place.

    It travels to worker processes by pickle.
    """

    def catalogue(self) -> Catalogue:
        """Return all laws there are, for reading a grid."""

    def load(self) -> None:
        """Load what cases need."""

    def signature(self, case: Case, /) -> Hashable:
        """Return what is equal for cases that share their compiled code."""

    def compile_for(self, case: Case, /) -> None:
        """Compile the code of a case, or load it from the cache."""

    def solve(self, case: Case, /) -> Trajectory:
        """Return the result of a case."""

    @property
    def solve_each(self) -> Callable[[Iterable[Case]], Iterator[tuple[int, Trajectory | Exception]]] | None:
        """Return what yields the place of each case and its result, or what went wrong, as they end.

        None where cases are to be solved one after the other.
        """

    def derived(self, case: Case, /) -> dict[str, tuple[float, str]]:
        """Return name -> (value, SI unit) of what follows from other values."""

    def warnings(self, case: Case, /) -> list[str]:
        """Return sentences about values that may not be what was meant."""


class Task(NamedTuple):
    """One case on its way to a worker, which makes its values itself: the parent stays light."""

    case_id: str
    grid_index: int


class Batch(NamedTuple):
    """Cases that are computed and committed together."""

    name: str  # of its files
    cases: tuple[Task, ...]
    tried: int = 0  # times it was lost with its worker


class Job(NamedTuple):
    """What all batches of a run share."""

    directory: Path
    grid: Grid
    simulator: Simulator
    case_timeout: float | None  # s

    @property
    def stop(self) -> Path:
        """Return the file that tells workers to finish the case they are at and take no other."""
        return durable.passing(self.directory / store.SCRATCH, "stop")

    def note(self, batch: Batch) -> Path:
        """Return the file in which a worker says which case it is at."""
        return durable.passing(self.directory / store.SCRATCH, f"{batch.name}.note")


class AbandonedError(Exception):
    """A batch that another worker had begun and, gone by now, did not finish."""


class Manifest(NamedTuple):
    """What a batch came to; the results themselves are in the store."""

    committed: str | None  # name of its summary; None where nothing was committed
    done: int
    failed: int
    seconds: float  # spent on its cases


def enter(parent: int, load: Callable[[], None]) -> None:
    """Prepare a worker process: it dies with its parent, heeds signals between cases, and has its modules loaded."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)  # the parent went before it could be tied to
    signals.in_worker()
    store.use_one_thread()
    with contextlib.suppress(Exception):  # what is wrong with them comes up again in a case, where it is recorded
        load()


def compile_all(simulator: Simulator, cases: list[Case]) -> None:
    """Compile what these cases need, so that every other process finds it in the cache."""
    for case in cases:
        simulator.compile_for(case)


def time_case(simulator: Simulator, case: Case) -> tuple[float, int]:
    """Return the time (s) that a case takes and the number of its events."""
    begin = time.perf_counter()
    trajectory = simulator.solve(case)
    return time.perf_counter() - begin, len(trajectory.events)


def run_packed(content: bytes) -> Any:
    """Return the outcome of a pickled (function, arguments): for executors that look into arguments on the way."""
    store.use_one_thread()
    function, arguments = pickle.loads(content)
    return function(*arguments)


def run_batch(job: Job, batch: Batch) -> Manifest:
    """Compute the cases of a batch and commit them; asked to stop, commit the first ones that are done."""
    signals.leave_if_asked()
    first = batch.cases[0]
    if job.grid.case_id(first.grid_index) != first.case_id:
        raise ClearsweepError(
            f"the worker on {platform.node()} has another version of clearsweep than the program "
            "that sends it work; install the same one everywhere"
        )
    rows, begin = [], time.perf_counter()
    with signals.patience():
        with durable.storing(job.note(batch)):
            try:
                note = durable.create(job.note(batch))
            except FileExistsError:  # a scheduler tries again by itself what killed a worker
                raise AbandonedError(f"batch {batch.name} was begun before") from None
        try:
            together = job.simulator.solve_each and not job.case_timeout and not batch.tried and len(batch.cases) > 1
            for case, trajectory in (_all if together else _one_by_one)(job, batch, note):
                rows.append(store.Row(case.case_id, job.grid.point(case.grid_index), trajectory))
            seconds = time.perf_counter() - begin
            committed = store.commit(job.directory, store.Form.of(job.grid), batch.name, rows) if rows else None
        finally:
            os.close(note)
    return Manifest(committed, len(rows), sum(row.trajectory.status != "ok" for row in rows), seconds)


def _one_by_one(job: Job, batch: Batch, note: int) -> Iterator[tuple[Task, Trajectory]]:
    """Yield the cases of a batch and their results, one after the other; asked to stop, end after the case at hand."""
    for index, case in enumerate(batch.cases):
        if signals.requested() or job.stop.exists():
            return
        _write_note(job, batch, note, index)
        yield case, _solve(job, job.grid.case(case.grid_index), note)


def _all(job: Job, batch: Batch, note: int) -> Iterator[tuple[Task, Trajectory]]:
    """Yield the same of cases that are computed together; asked to stop, end with the first that is not done.

    Who dies over them is not found out: all go one by one when the batch is tried again.
    """
    assert job.simulator.solve_each
    _write_note(job, batch, note, 0)
    done: dict[int, Trajectory] = {}
    for index, result in job.simulator.solve_each(job.grid.case(case.grid_index) for case in batch.cases):
        done[index] = result if isinstance(result, Trajectory) else _crashed(result)
        if signals.requested() or job.stop.exists():
            break
    for index, case in enumerate(batch.cases):
        if index not in done:
            return
        yield case, done[index]


def _write_note(job: Job, batch: Batch, note: int, index: int) -> None:
    """Note which case this process is at."""
    with durable.storing(job.note(batch)):
        os.pwrite(note, f"{os.getpid():10d} {index:10d}\n".encode(), 0)
        os.lseek(note, NOTE_LENGTH, os.SEEK_SET)


class Note(NamedTuple):
    """What a worker left about the batch it was at."""

    process: int
    batch_index: int
    late: bool  # the case took longer than it may


def read_note(job: Job, batch: Batch) -> Note | None:
    """Return what is noted of a batch, None where no worker has begun it."""
    try:
        process, index, *rest = durable.read(job.note(batch)).split()
        return Note(int(process), int(index), bool(rest))
    except (OSError, ValueError):
        return None


def _solve(job: Job, case: Case, note: int) -> Trajectory:
    """Return the result of one case; whatever goes wrong in it becomes its status."""
    if job.case_timeout:  # a watchdog ends the process, even inside compiled code, and says so in the note
        faulthandler.dump_traceback_later(job.case_timeout, exit=True, file=note)
    try:
        return job.simulator.solve(case)
    except Exception as error:
        return _crashed(error)
    finally:
        if job.case_timeout:
            faulthandler.cancel_dump_traceback_later()


def _crashed(error: Exception) -> Trajectory:
    """Return the result of a case in which something went wrong that nobody foresaw."""
    return failure("crashed", resources.remedy(error) or brief(error))


def failure(status: str, message: str) -> Trajectory:
    """Return the result of a case that has none."""
    return Trajectory(status, message, {})
