"""A worker process: computes the cases of a batch, commits them and returns its outcome."""

import contextlib
import faulthandler
import functools
import math
import os
import pickle
import platform
import secrets
import time
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import h5py  # noqa: F401 - workers are forks: what a commit needs is loaded before, and once
import numpy as np

from ... import simulation, store
from ...answers.validity import LIFE_FAILED
from ...contracts.case import Case
from ...contracts.catalogue import Catalogue
from ...contracts.results import Peak, Trajectory
from ...grid import Grid
from ...language import phases
from ...language.errors import ClearsweepError, DirectoryError, InputError, StorageError, error_line
from ...store import durable
from .. import NO_OPTIONS, Options
from . import system

# Cases that a driver sends to a worker.


class Task(NamedTuple):
    """A case for a worker, which generates its values itself to relieve the parent."""

    case_id: str
    grid_index: int


class Tasks:
    """Cases for a worker, as two arrays: creating a `Task` for each would take a driver most of its time."""

    def __init__(self, indices: np.ndarray, ids: np.ndarray):
        """Take the indices and the identities, uint64, of the cases, both (cases,)."""
        self.indices, self.ids = indices, ids

    def __len__(self) -> int:
        return len(self.indices)

    def __getitem__(self, position: int) -> Task:
        return Task(f"{int(self.ids[position]):016x}", int(self.indices[position]))

    def part(self, first: int, last: int | None = None) -> "Tasks":
        """Return the cases from position `first` up to but not including `last`; default: to the end."""
        return Tasks(self.indices[first:last], self.ids[first:last])

    def without(self, position: int) -> "Tasks":
        """Return all cases except the one at a position."""
        return Tasks(np.delete(self.indices, position), np.delete(self.ids, position))

    def listed(self) -> list[Task]:
        """Return the cases as a list of tasks."""
        pairs = zip(self.ids.tolist(), self.indices.tolist(), strict=True)
        return [Task(f"{number:016x}", index) for number, index in pairs]


class Batch(NamedTuple):
    """Cases that are computed and committed together."""

    name: str  # of its files
    cases: Tasks
    attempts: int = 0  # how often it was lost with its worker


CHUNK_SIZE = 64  # cases created at a time, in a third of the time of one by one
CASE_SHARE = 0.125  # of the patience for a batch, for each of its cases
CHECK_INTERVAL = 0.01  # s between checks for a request to stop
ERROR_CHECK_COST = 10.0**0.125  # run time of an error check over that of the case, at a tenth of the tolerance
CHAIN_SECONDS = 2.0  # s of work that a killed worker loses of a chain, which is one batch
OUT_OF_TIME = "time-budget"  # status of a case that exceeded its time
STATUS_LENGTH = 22  # bytes for worker and case; after them a watchdog writes the position of a case that timed out


def _recommended(case: Case) -> list[str]:
    return simulation.recommended_texts(simulation.recommendations(case))


class Simulator(NamedTuple):
    """The functions of `clearsweep.simulation` that a sweep calls, as one value; it is pickled for worker processes."""

    catalogue: Callable[[], Catalogue] = simulation.catalogue  # all laws, for reading a grid
    load: Callable[[], None] = simulation.load  # loads the modules of cases
    signature: Callable[[Case], Hashable] = simulation.signature  # a key that cases with the same compiled code share
    compile_for: Callable[[Case], None] = simulation.compile_for  # compiles the code of a signature, or loads it
    compile_loop: Callable[[Case], None] = simulation.compile_loop  # compiles the code of all cases, or loads it
    solve: Callable[..., Trajectory] = simulation.solve  # result of a case; a life resumes from a `store.Unfinished`
    #: Revolution with the largest normal force of a joint, of a run of this length (revolutions); the last argument:
    #: revolutions before its window, None: those of the case.
    peak: Callable[[Case, int, float, float | None], Peak] = simulation.peak_revolution
    derived: Callable[[Case], dict[str, tuple[float, str]]] = simulation.derived  # name -> (value, SI unit)
    warnings: Callable[[Case], list[str]] = simulation.warnings  # sentences about suspicious values
    recommended: Callable[[Case], list[str]] = _recommended  # lines on the laws recommended for the joints of a case
    #: Path of a law's name -> the other laws that are suitable for its joint.
    alternatives: Callable[[Case], dict[str, list[str]]] = simulation.alternatives


SIMULATION = Simulator()


@dataclass(frozen=True)
class RunContext:
    """Data that all batches of a run share; a process unpacks it only once."""

    directory: Path
    grid: Grid
    simulator: Simulator
    options: Options = NO_OPTIONS
    driver: str = ""  # owner of the batches, if several drivers work at one block
    patience: float = math.inf  # s of a batch after which it ends early; CASE_SHARE of it: after which a case is left

    def __reduce__(self) -> tuple[Callable[[bytes], "RunContext"], tuple[bytes]]:
        return _unpack_context, (self._packed,)

    @cached_property
    def _packed(self) -> bytes:
        return pickle.dumps((self.directory, self.grid, self.simulator, self.options, self.driver))

    @property
    def time(self) -> Callable[[], float]:
        """Return what times batches (s): where patience ends, processor time, as others slow workers, too."""
        return time.perf_counter if self.patience == math.inf else time.process_time

    @cached_property
    def result_schema(self) -> store.ResultSchema:
        """Return the schema of the results."""
        return store.ResultSchema.of(self.grid)

    @cached_property
    def stop(self) -> Path:
        """Return the file that asks workers to stop after their current case."""
        name = f"{self.driver}.stop" if self.driver else "stop"
        return durable.scratch_file(self.directory / store.SCRATCH, name)

    def status_file(self, batch: Batch) -> Path:
        """Return the file in which a worker records its current case."""
        return durable.scratch_file(self.directory / store.SCRATCH, f"{batch.name}.note")

    def facts(self, task: Task) -> dict[str, Any]:
        """Return the description of a task's case, for programs."""
        return {"case_id": task.case_id, "case": task.grid_index + 1, "cases": len(self.grid)}

    def working(self, batch: Batch) -> store.Working:
        """Return the file in which a worker records its progress in a long case."""
        return store.Working(self.directory, batch.name)


@functools.lru_cache(maxsize=1)
def _unpack_context(content: bytes) -> RunContext:
    return RunContext(*pickle.loads(content))


class AbandonedError(Exception):
    """A batch that another worker began but did not finish before it ended."""


class BatchOutcome(NamedTuple):
    """Outcome of a batch; the results themselves are in the store."""

    committed: str | None  # name of its summary, or None if nothing was committed
    finished_count: int
    failed_count: int
    seconds: float  # s, time for its cases


def start_worker(parent: int, load: Callable[[], None]) -> None:
    """Prepare a worker process: it ends with its parent, obeys signals between cases, and has its modules loaded."""
    system.end_with(parent)
    phases.forget()
    system.in_worker()
    store.use_one_thread()
    with contextlib.suppress(Exception):  # an error comes up again in a case, where it is recorded
        load()
    system.collect_as_usual()


class CaseTime(NamedTuple):
    """The time of a case, measured or extrapolated from its beginning."""

    seconds: float | None  # s, without compiling; None: the beginning does not determine it
    events: int
    elapsed: float  # s, time of the measurement without compiling
    compiling: float  # s, compiling during the measurement
    extrapolated: bool = False
    over_budget: bool = False  # its time budget ends it earlier, so that is its time
    failure: str = ""  # status and message of a case that fails


def time_case(simulator: Simulator, case: Case, patience: float, working: store.Working | None = None) -> CaseTime:
    """Return the time of a case; after `patience` (s) it is extrapolated from the beginning."""
    budget = min(case.simulate.time_budget, patience)
    begin, compile_time = time.perf_counter(), phases.compile_seconds()
    with (
        phases.store_progress(working.replace_progress) if working else contextlib.nullcontext(),
        phases.track_estimate() as latest,
    ):
        try:
            trajectory = simulator.solve(case._replace(simulate=case.simulate._replace(time_budget=budget)))
        except InputError as error:
            trajectory = Trajectory("refused", str(error), {})
    compile_time = phases.compile_seconds() - compile_time
    elapsed = time.perf_counter() - begin - compile_time
    status_texts = [trajectory.status, *trajectory.message.partition(LIFE_FAILED)[2:]]  # of the case, of a further life
    if not any(OUT_OF_TIME in text for text in status_texts) or budget == case.simulate.time_budget:
        failure = "" if trajectory.status == "ok" else f"{trajectory.status}: {trajectory.message}"
        return CaseTime(elapsed, len(trajectory.events), elapsed, compile_time, failure=failure)
    total = latest.total_time and max(latest.total_time - compile_time, elapsed)
    if total and case.simulate.error_check:
        total *= 1.0 + ERROR_CHECK_COST
    is_over_budget = total is not None and total > case.simulate.time_budget
    return CaseTime(
        case.simulate.time_budget if is_over_budget else total,
        0,
        elapsed,
        compile_time,
        extrapolated=True,
        over_budget=is_over_budget,
    )


def prepare(working: store.Working, compile_part: Callable[[Case], None], case: Case) -> float:
    """Compile a part of a case's code, or load it, with the progress in a file; return the time (s) of compiling."""
    begin = phases.compile_seconds()
    with phases.store_progress(working.replace_progress):
        compile_part(case)
    return phases.compile_seconds() - begin


def find_peak(simulator: Simulator, case: Case, worst_case: store.Worst) -> Peak | str:
    """Return the revolution of a finished case with its largest normal force, or the reason why it is not found."""
    try:
        revolutions = worst_case.revolutions or case.simulate.revolutions
        peak = simulator.peak(case, worst_case.joint, revolutions, worst_case.window_from)
    except Exception as error:
        return error_line(error)
    is_same_peak = peak.path.status == "ok" and peak.path.summary[worst_case.column] == worst_case.peak
    return peak if is_same_peak else "its motion differs on this machine"


def run_packed(content: bytes) -> Any:
    """Return the outcome of a pickled (function, arguments), for executors that inspect arguments."""
    store.use_one_thread()
    function, arguments = pickle.loads(content)
    return function(*arguments)


def run_batch(context: RunContext, batch: Batch) -> BatchOutcome:
    """Compute the cases of a batch and commit them; on a request to stop, commit the finished ones."""
    system.exit_if_requested()
    first_task = batch.cases[0]
    if context.grid.case_id(first_task.grid_index) != first_task.case_id:
        raise ClearsweepError(
            f"the worker on {platform.node()} has another version of clearsweep than the main "
            "program; install the same version everywhere"
        )
    rows, logs, begin = [], list[store.Unfinished](), context.time()
    stored, stored_at = 0, begin
    with (
        system.patience(),
        _new_status_file(context.status_file(batch)) as status,
        phases.store_progress(context.working(batch).replace_progress),
    ):
        for task, point, trajectory in _solved(context, batch, *status, logs):
            rows.append(store.Row(task.case_id, point, trajectory))
            if context.grid.chained and context.time() - stored_at > CHAIN_SECONDS:
                store.commit(context.directory, context.result_schema, secrets.token_hex(8), rows[stored:])
                stored, stored_at = len(rows), context.time()
        seconds = context.time() - begin
        committed = store.commit(context.directory, context.result_schema, batch.name, rows) if rows else None
        for log in logs:
            log.discard()
    return BatchOutcome(committed, len(rows), sum(row.trajectory.status != "ok" for row in rows), seconds)


def _solved(
    context: RunContext, batch: Batch, status_file: int, record: Callable[[int], None], logs: list[store.Unfinished]
) -> Iterator[tuple[Task, dict[str, Any], Trajectory]]:
    """Yield the cases of a batch and their results; on a request to stop, end after the current case.

    Where the patience of the context ends, the cases left belong to other workers.
    status_file, record : as `_new_status_file` yields them
    logs : receives the logs of lives, which are obsolete once their results are stored.
    """
    stop_requests = _stop_requests(context)
    end, budget = context.time() + context.patience, CASE_SHARE * context.patience
    for index, (task, point, case) in enumerate(_cases(context.grid, batch)):
        if next(stop_requests) or context.time() > end:
            return
        record(index)
        log = store.Unfinished(context.directory, task.case_id) if case.life else None
        with phases.phase("") as phase:
            phase.facts = context.facts(task)
            if is_cut := budget < case.simulate.time_budget:
                case = case._replace(simulate=case.simulate._replace(time_budget=budget))  # noqa: PLW2901
            trajectory = _solve(context, case, log, status_file)
            if is_cut and trajectory.status == OUT_OF_TIME:
                return
        yield task, point, trajectory
        logs += [log] if log else []


def _cases(grid: Grid, batch: Batch) -> Iterator[tuple[Task, dict[str, Any], Case]]:
    """Yield tasks, points and cases; several are created at once, in a third of the time."""
    for begin in range(0, len(batch.cases), CHUNK_SIZE):
        tasks = batch.cases.part(begin, begin + CHUNK_SIZE).listed()
        points = [grid.point(task.grid_index) for task in tasks]
        yield from zip(tasks, points, [grid.case_at(point) for point in points], strict=True)


def _stop_requests(context: RunContext) -> Iterator[bool]:
    """Yield whether a worker has to stop before its next case; at intervals it checks a file, which takes 5 us."""
    stop, due = os.fspath(context.stop), 0.0
    while True:
        is_requested = bool(system.requested())
        if not is_requested and (now := time.monotonic()) >= due:
            due, is_requested = now + CHECK_INTERVAL, os.path.exists(stop)
        yield is_requested


@contextlib.contextmanager
def _new_status_file(path: Path) -> Iterator[tuple[int, Callable[[int], None]]]:
    """Yield a new status file, behind its text, and what records which case of the batch is next.

    AbandonedError if one exists: the scheduler repeats a batch that killed a worker.
    """
    with durable.storing(path):
        try:
            handle = durable.create_file(path)
        except FileExistsError:
            raise AbandonedError(f"{path.name}: its batch was begun before") from None

    def record(index: int) -> None:
        with durable.storing(path):
            os.pwrite(handle, f"{os.getpid():10d} {index:10d}\n".encode(), 0)

    try:
        os.lseek(handle, STATUS_LENGTH, os.SEEK_SET)  # where a watchdog writes
        yield handle, record
    finally:
        os.close(handle)


class WorkerStatus(NamedTuple):
    """The position of a worker in its batch."""

    process: int
    batch_index: int
    timed_out: bool  # the case exceeded its time
    since: float = 0.0  # s, time of writing


def read_worker_status(context: RunContext, batch: Batch) -> WorkerStatus | None:
    """Return the status of a batch's worker, or None if no worker has begun it."""
    try:
        path = context.status_file(batch)
        process, index, *mark = durable.read(path).split()
        status = WorkerStatus(int(process), int(index), bool(mark), path.stat().st_mtime)
        return status if 0 <= status.batch_index < len(batch.cases) else None
    except (OSError, ValueError):
        return None


def _solve(context: RunContext, case: Case, log: store.Unfinished | None, status_handle: int) -> Trajectory:
    """Return the result of a case; errors in it become its status."""
    if (
        context.options.case_timeout
    ):  # a watchdog ends the process, even in compiled code, and records this in the status file
        faulthandler.dump_traceback_later(context.options.case_timeout, exit=True, file=status_handle)
    try:
        return context.simulator.solve(case, log) if log else context.simulator.solve(case)
    except (StorageError, DirectoryError):
        raise  # error of the log: no case can be stored
    except InputError as error:
        return failure("refused", str(error))
    except Exception as error:
        return failure("crashed", system.remedy_text(error) or error_line(error))
    finally:
        if context.options.case_timeout:
            faulthandler.cancel_dump_traceback_later()


def failure(status: str, message: str) -> Trajectory:
    """Return the failed result of a case."""
    return Trajectory(status, message, {})
