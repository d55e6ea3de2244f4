"""Work of a worker process: it computes the cases of a batch, commits them and returns a manifest."""

import contextlib
import ctypes
import faulthandler
import functools
import gc
import os
import pickle
import platform
import signal
import sys
import time
from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from .. import store
from ..contracts.case import Case
from ..contracts.catalogue import Catalogue
from ..contracts.results import Peak, Trajectory
from ..grid import Grid
from ..judging.validity import LIFE_FAILED
from ..language import phases
from ..language.errors import ClearsweepError, DirectoryError, InputError, StorageError, brief
from ..store import durable
from . import resources, signals

AT_ONCE = 64  # cases made at a time, in a third of the time of one by one
LOOK = 0.01  # s between two looks at what asks workers to stop
CHECK = 10.0**0.125  # times as long as the case its error check takes: a tenth of the tolerance, of order eight
OUT_OF_TIME = "time-budget"  # status of what took longer than it may
_PR_SET_PDEATHSIG = 1
NOTE_LENGTH = 22  # bytes that say who is at which case; after them a watchdog writes where a late case was


class Simulator(Protocol):
    """The functions of mechanics that a sweep calls: `SIMULATION`, or a substitute in tests.

    It travels to worker processes by pickle.
    """

    def catalogue(self) -> Catalogue:
        """Return all laws there are, for reading a grid."""

    def load(self) -> None:
        """Load what cases need."""

    def signature(self, case: Case, /) -> Hashable:
        """Return a key that cases with the same compiled code share."""

    def compile_for(self, case: Case, /) -> None:
        """Compile what a case shares with cases of the same signature, or load it from the cache."""

    def compile_loop(self, case: Case, /) -> None:
        """Compile what a case shares with all others, or load it from the cache."""

    def solve(self, case: Case, log: store.Unfinished | None = None, /) -> Trajectory:
        """Return the result of a case; only one with a life is given a log, and goes on from it."""

    def peak(self, case: Case, joint: int, revolutions: float, /) -> Peak:
        """Return the revolution of a case, of so many, in which the largest normal force of a joint lies."""

    @property
    def solve_each(self) -> Callable[[Iterable[Case]], Iterator[tuple[int, Trajectory | Exception]]] | None:
        """Return what yields the place of each case and its result, or what went wrong, as they end.

        None where cases are to be solved one after the other.
        """

    def derived(self, case: Case, /) -> dict[str, tuple[float, str]]:
        """Return name -> (value, SI unit) of derived values."""

    def warnings(self, case: Case, /) -> list[str]:
        """Return sentences about suspicious values."""

    def recommended(self, case: Case, /) -> list[str]:
        """Return a sentence on each law that is recommended for a joint of a case."""

    def alternatives(self, case: Case, /) -> dict[str, list[str]]:
        """Return path of a law's name -> the other laws that hold in its joint."""


class Task(NamedTuple):
    """One case on its way to a worker, which makes its values itself: the parent stays light."""

    case_id: str
    grid_index: int


class Batch(NamedTuple):
    """Cases that are computed and committed together."""

    name: str  # of its files
    cases: tuple[Task, ...]
    tried: int = 0  # times it was lost with its worker


@dataclass(frozen=True)
class Job:
    """Data that all batches of a run share; a process that receives it again with each batch unpacks it once."""

    directory: Path
    grid: Grid
    simulator: Simulator
    case_timeout: float | None  # s
    together: bool = False  # cases of a batch are computed together, by `solve_each`
    driver: str = ""  # whose batches they are, where several drivers work at one block

    def __reduce__(self) -> tuple[Callable[[bytes], "Job"], tuple[bytes]]:
        return _unpacked, (self._packed,)

    @cached_property
    def _packed(self) -> bytes:
        return pickle.dumps((self.directory, self.grid, self.simulator, self.case_timeout, self.together, self.driver))

    @cached_property
    def form(self) -> store.ResultSchema:
        """Return the form of the results."""
        return store.ResultSchema.of(self.grid)

    @cached_property
    def stop(self) -> Path:
        """Return the file that asks workers to finish the case they are at and take no other."""
        name = f"{self.driver}.stop" if self.driver else "stop"
        return durable.scratch_file(self.directory / store.SCRATCH, name)

    def note(self, batch: Batch) -> Path:
        """Return the file in which a worker says which case it is at."""
        return durable.scratch_file(self.directory / store.SCRATCH, f"{batch.name}.note")

    def facts(self, task: Task) -> dict[str, Any]:
        """Return which case a task is, for programs."""
        return {"case_id": task.case_id, "case": task.grid_index + 1, "cases": len(self.grid)}

    def working(self, batch: Batch) -> store.Working:
        """Return the file in which a worker keeps its progress at a case that takes long."""
        return store.Working(self.directory, batch.name)


@functools.lru_cache(maxsize=1)
def _unpacked(content: bytes) -> Job:
    return Job(*pickle.loads(content))


class AbandonedError(Exception):
    """A batch that another worker had begun and, gone by now, did not finish."""


class Manifest(NamedTuple):
    """Outcome of a batch; the results themselves are in the store."""

    committed: str | None  # name of its summary; None where nothing was committed
    done: int
    failed: int
    seconds: float  # spent on its cases


def start_worker(parent: int, load: Callable[[], None]) -> None:
    """Prepare a worker process: it dies with its parent, heeds signals between cases, and has its modules loaded."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)  # the parent went before it could be tied to
    signals.in_worker()
    store.use_one_thread()
    with contextlib.suppress(Exception):  # what is wrong with them comes up again in a case, where it is recorded
        load()
    gc.freeze()  # what is loaded stays, so it need not be looked through again and again


class Timed(NamedTuple):
    """The time that a case takes, as it was measured, or extrapolated from its beginning."""

    seconds: float | None  # what is compiled once does not count; None: the beginning does not count
    events: int
    spent: float  # s, that measuring took, without what is compiled
    once: float  # s, that compiling took on the way
    extrapolated: bool = False
    beyond: bool = False  # its time budget ends it before, and that is its time


def time_case(simulator: Simulator, case: Case, patience: float, working: store.Working | None = None) -> Timed:
    """Return the time that a case takes; of one that takes more than `patience` (s) as its beginning allows."""
    budget = min(case.simulate.time_budget, patience)
    begin, once = time.perf_counter(), phases.once_seconds()
    with phases.written(working.put) if working else contextlib.nullcontext(), phases.estimated() as latest:
        trajectory = simulator.solve(case._replace(simulate=case.simulate._replace(time_budget=budget)))
    once = phases.once_seconds() - once
    spent = time.perf_counter() - begin - once
    out_of_time = [trajectory.status, *trajectory.message.partition(LIFE_FAILED)[2:]]  # of the case, of a further life
    if not any(OUT_OF_TIME in text for text in out_of_time) or budget == case.simulate.time_budget:
        return Timed(spent, len(trajectory.events), spent, once)
    total = latest.total and max(latest.total - once, spent)
    if total and case.simulate.error_check:
        total *= 1.0 + CHECK
    beyond = total is not None and total > case.simulate.time_budget
    return Timed(case.simulate.time_budget if beyond else total, 0, spent, once, extrapolated=True, beyond=beyond)


def prepare(working: store.Working, part: Callable[[Case], None], case: Case) -> None:
    """Compile a part of what a case needs, or load it, and keep the progress of compiling in a file."""
    with phases.written(working.put):
        part(case)


def find_peak(simulator: Simulator, case: Case, joint: int, revolutions: float) -> Peak:
    """Return the revolution of a case in which the largest normal force of a joint lies."""
    return simulator.peak(case, joint, revolutions)


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
    rows, logs, begin = [], list[store.Unfinished](), time.perf_counter()
    together = job.together and not batch.tried
    with signals.patience(), _noting(job.note(batch)) as note, phases.written(job.working(batch).put):
        for task, point, trajectory in (_together if together else _one_by_one)(job, batch, note, logs):
            rows.append(store.Row(task.case_id, point, trajectory))
        seconds = time.perf_counter() - begin
        committed = store.commit(job.directory, job.form, batch.name, rows) if rows else None
        for log in logs:
            log.discard()
    return Manifest(committed, len(rows), sum(row.trajectory.status != "ok" for row in rows), seconds)


_Solved = Iterator[tuple[Task, dict[str, Any], Trajectory]]


def _one_by_one(job: Job, batch: Batch, note: "_Noting", logs: list[store.Unfinished]) -> _Solved:
    """Yield the cases of a batch and their results; asked to stop, end after the case at hand.

    `logs` : gets those of lives, which are of no use once their results are stored.
    """
    stopping = _Stopping(job)
    for index, (task, point, case) in enumerate(_cases(job.grid, batch)):
        if stopping.asked():
            return
        note.say(index)
        log = store.Unfinished(job.directory, task.case_id) if case.life else None
        with phases.phase("") as phase:
            phase.facts = job.facts(task)
            trajectory = _solve(job, case, log, note.handle)
        yield task, point, trajectory
        logs += [log] if log else []


def _together(job: Job, batch: Batch, note: "_Noting", logs: list[store.Unfinished]) -> _Solved:
    """Yield the same of cases that are computed together; asked to stop, end before the first that is not done.

    Lives, which keep logs, go one by one.  Which case a worker dies over is not known here: the first is noted, and all
    go one by one from there on.
    """
    assert job.simulator.solve_each
    stopping, listed, done = _Stopping(job), list(_cases(job.grid, batch)), dict[int, Trajectory]()
    if any(case.life for _, _, case in listed):
        yield from _one_by_one(job, batch, note, logs)
        return
    note.say(0)
    for index, result in job.simulator.solve_each([case for _, _, case in listed]):
        done[index] = result if isinstance(result, Trajectory) else _gone_wrong(result)
        if stopping.asked():
            break
    for index, (task, point, _) in enumerate(listed):
        if index not in done:
            return
        yield task, point, done[index]


def _cases(grid: Grid, batch: Batch) -> Iterator[tuple[Task, dict[str, Any], Case]]:
    """Yield tasks, points and cases; some are made at once, which takes a third of making each after another's run."""
    for first in range(0, len(batch.cases), AT_ONCE):
        tasks = batch.cases[first : first + AT_ONCE]
        points = [grid.point(task.grid_index) for task in tasks]
        yield from zip(tasks, points, [grid.case_at(point) for point in points], strict=True)


class _Stopping:
    """Whether a worker is to take no other case; at the file that says so it looks now and then: a look takes 5 us."""

    def __init__(self, job: Job):
        self.stop, self.due = os.fspath(job.stop), 0.0

    def asked(self) -> bool:
        """Return whether to stop."""
        if signals.requested():
            return True
        if (now := time.monotonic()) < self.due:
            return False
        self.due = now + LOOK
        return os.path.exists(self.stop)


class _Noting:
    """The note of a batch, as its worker writes it; after what it says there is room for the watchdog."""

    def __init__(self, path: Path, handle: int):
        self.path, self.handle, self.process = path, handle, os.getpid()
        os.lseek(handle, NOTE_LENGTH, os.SEEK_SET)

    def say(self, index: int) -> None:
        """Say which case of the batch is next."""
        try:
            os.pwrite(self.handle, f"{self.process:10d} {index:10d}\n".encode(), 0)
        except OSError as error:
            raise durable.refused(self.path, error) from error


@contextlib.contextmanager
def _noting(path: Path) -> Iterator[_Noting]:
    """Yield a new note; AbandonedError where there is one: a scheduler tries again by itself what killed a worker."""
    with durable.storing(path):
        try:
            handle = durable.create(path)
        except FileExistsError:
            raise AbandonedError(f"{path.name}: its batch was begun before") from None
    try:
        yield _Noting(path, handle)
    finally:
        os.close(handle)


class Note(NamedTuple):
    """A worker's note on its batch."""

    process: int
    batch_index: int
    late: bool  # the case took longer than it may
    since: float = 0.0  # s of the clock, when it was written


def read_note(job: Job, batch: Batch) -> Note | None:
    """Return what is noted of a batch, None where no worker has begun it."""
    try:
        path = job.note(batch)
        process, index, *rest = durable.read(path).split()
        return Note(int(process), int(index), bool(rest), path.stat().st_mtime)
    except (OSError, ValueError):
        return None


def _solve(job: Job, case: Case, log: store.Unfinished | None, note: int) -> Trajectory:
    """Return the result of one case; whatever goes wrong in it becomes its status."""
    if job.case_timeout:  # a watchdog ends the process, even inside compiled code, and says so in the note
        faulthandler.dump_traceback_later(job.case_timeout, exit=True, file=note)
    try:
        return job.simulator.solve(case, log) if log else job.simulator.solve(case)
    except (StorageError, DirectoryError):
        raise  # of the log: no case can be stored
    except Exception as error:
        return _gone_wrong(error)
    finally:
        if job.case_timeout:
            faulthandler.cancel_dump_traceback_later()


def _gone_wrong(error: Exception) -> Trajectory:
    """Return the result of a case that ended with an exception."""
    if isinstance(error, InputError):
        return failure("refused", str(error))
    return failure("crashed", resources.remedy(error) or brief(error))


def failure(status: str, message: str) -> Trajectory:
    """Return the result of a case that has none."""
    return Trajectory(status, message, {})
