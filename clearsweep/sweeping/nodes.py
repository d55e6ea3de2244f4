"""Runs the blocks of a grid on the nodes of a cluster, each with a pool of processes."""

import functools
import multiprocessing
import pickle
import secrets
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import store
from ..language import phases
from ..language.errors import ClearsweepError, InputError, SchedulerLostError, StorageError, error_line
from ..store import durable
from .blockwise import BlockJob, BlockRunner, BlocksOutcome, allowed_failures, finished_mark, unfinished_blocks
from .pool import executors, system, worker
from .pool.case_runner import CaseRunner, Pending, missing_indices
from .pool.driver import CaseProgress

# The driver on a node of a cluster: runs whole blocks with a pool of processes on that node.


class NodeReport(NamedTuple):
    """Outcome of a task on a node."""

    node: str  # address of the node
    ran: int = 0
    failed: int = 0
    case_seconds: float = 0.0
    complete: bool = True  # False: too many cases failed, or the run must stop
    refused: str = ""  # error of its file system


class _StoppedError(Exception):
    """The run must stop."""


class _NodeDriver:
    """The driver of this node, with a pool that lasts for the whole run."""

    def __init__(self, token: str, job: BlockJob):
        self.token, self.job = token, job
        self.directory = store.RunDirectory(job.directory)
        options = self.job.options._replace(executor="local", scheduler=None)
        self.case_runner = CaseRunner(self.directory, options, self.job.simulator)
        self.runner = BlockRunner(job, self.case_runner, earlier=self.directory)


_node_drivers: list[_NodeDriver] = []  # driver of this process, at most one


def stop_file(job: BlockJob, token: str) -> Path:
    """Return the file that asks all nodes of a run to stop."""
    return durable.scratch_file(job.directory / store.SCRATCH, f"{token}.part")


def _node_driver(token: str, content: bytes) -> _NodeDriver:
    """Return this process's driver for a run; that of an earlier run is closed."""
    if not _node_drivers or _node_drivers[0].token != token:
        while _node_drivers:
            _node_drivers.pop().case_runner.close()
        multiprocessing.current_process()._config.pop("daemon", None)  # type: ignore[attr-defined] # a nanny's child
        _node_drivers.append(_NodeDriver(token, pickle.loads(content)))
    return _node_drivers[0]


def _commits_in(node: _NodeDriver, number: int) -> Callable[[], np.ndarray]:
    """Return what reads the identities of the cases of a block that any driver committed, ascending.

    Each summary is read once.  _StoppedError says that the run must stop.
    """
    directory = store.RunDirectory(store.Block(node.job.directory, number).path)
    directory.expect(store.ResultSchema.of(node.job.grid))
    ids_by_name: dict[str, np.ndarray] = {}

    def read_finished_ids() -> np.ndarray:
        if stop_file(node.job, node.token).exists():
            raise _StoppedError
        for name in directory.summary_names() - ids_by_name.keys():
            ids_by_name[name] = directory.read_batch(name).ids
        return np.unique(np.concatenate([np.empty(0, "u8"), *ids_by_name.values()]))

    return read_finished_ids


def run_block(
    token: str, content: bytes, number: int, most_failures: int | None = None, *, is_helping: bool = False
) -> NodeReport:
    """Run the missing cases of a block with the workers of this node, and start finishing the block.

    is_helping : the block is that of another node, whose cases are run from its end until all are committed
    """
    node, address = _node_driver(token, content), _address()
    case_runner, runner = node.case_runner, node.runner
    counts_before = case_runner.ran, case_runner.failed, case_runner.case_seconds
    error_text, complete = "", True
    try:
        with phases.show_progress(enabled=False):
            read_finished_ids = _commits_in(node, number)
            read_finished_ids()
            if is_helping:
                _help(node, number, read_finished_ids)
            else:
                runner.allowed_failures = None if most_failures is None else case_runner.failed + most_failures
                complete = runner.run(number, read_finished_ids)
    except _StoppedError:
        case_runner.close()
        runner.finishing.clear()
        complete = False
    except StorageError as error:
        _node_drivers.clear()
        case_runner.close()
        error_text = str(error)
    return NodeReport(
        address,
        case_runner.ran - counts_before[0],
        case_runner.failed - counts_before[1],
        case_runner.case_seconds - counts_before[2],
        complete=complete,
        refused=error_text,
    )


def _help(node: _NodeDriver, number: int, read_finished_ids: Callable[[], np.ndarray]) -> None:
    """Run uncommitted cases of a block, last cases first: its own driver begins with the first cases."""
    job, case_runner = node.job, node.case_runner
    block = store.Block(job.directory, number)
    directory = block.directory(store.ResultSchema.of(job.grid))
    directory.load_batches(histories=False)
    indices, ids = job.cases(number)
    pending = missing_indices(ids, np.sort(ids), directory.rows(), retry_failed=False)[::-1]
    if not len(pending):
        return
    case_runner.directory = directory
    case_runner.start_workers(len(ids))
    case_runner.run_cases(job.grid, Pending(indices[pending], ids[pending], read_finished_ids=read_finished_ids))


def flush(token: str) -> NodeReport:
    """Wait until the blocks of this node are finished."""
    error_text = ""
    for node in _node_drivers:
        if node.token == token:
            try:
                node.runner.collect()
            except StorageError as error:
                error_text = str(error)
            except ClearsweepError:
                node.runner.finishing.clear()  # they are requested again
    return NodeReport(_address(), refused=error_text)


def close(token: str) -> None:
    """End the workers of this node."""
    while _node_drivers and _node_drivers[0].token == token:
        _node_drivers.pop().case_runner.close()


def _address() -> str:
    """Return the address of this node at its scheduler."""
    from distributed import get_worker

    return str(get_worker().address)


# The parent of a run on the nodes of a cluster: it distributes whole blocks to nodes.

CHECK_INTERVAL = 0.05  # s between checks of running blocks
RECOUNT_INTERVAL = 2.0  # s between updates of the list of nodes
HELP_AFTER = 4.0  # s after which idle nodes help with a running block
SILENCE_TIMEOUT = 10.0  # s for the node of a block to finish it after all cases are committed
RECONNECT_TIMEOUT = 120.0  # s for a lost scheduler to come back
MAX_ROUNDS = 5  # rounds over all blocks: blocks of dead nodes are requested again


class Cluster:
    """The nodes of a scheduler: each of its workers is one."""

    def __init__(self, address: str):
        """Connect to the scheduler at `address`."""
        self.address = address
        self.excluded: set[str] = set()  # nodes with file system errors
        self.silent: set[str] = set()  # nodes that did not answer in time
        self._client = executors.client(address)
        self._nodes: list[str] = []
        self._counted_at = -RECOUNT_INTERVAL

    def nodes(self) -> list[str]:
        """Return the addresses of usable nodes."""
        if time.monotonic() - self._counted_at > RECOUNT_INTERVAL:
            self._nodes = sorted(executors.with_timeout(self._client.nthreads))
            self._counted_at = time.monotonic()
        usable = [address for address in self._nodes if address not in self.excluded]
        if not self.silent.issuperset(usable):
            return [address for address in usable if address not in self.silent]
        self.silent.clear()  # no other node is left, so these are tried again
        return usable

    def submit(self, function: Callable, *args: Any, on: str | None = None) -> Any:
        """Return the future of a function on any node, or on one of the nodes `on`."""
        where = [on] if on else self.nodes() if self.excluded | self.silent else None
        task = pickle.dumps((function, args))
        return self._client.submit(worker.run_packed, task, pure=False, workers=where, allow_other_workers=False)

    def exclude_node_of(self, future: Any) -> None:
        """Stop using the node that runs a task."""
        at_work = executors.with_timeout(self._client.processing)
        self.silent |= {address for address, keys in at_work.items() if future.key in map(str, keys)}

    def reconnect(self) -> None:
        """Reconnect, waiting for the scheduler; raise SchedulerLostError if it does not come back."""
        deadline, reason = time.monotonic() + RECONNECT_TIMEOUT, "no answer"
        self.close()
        while time.monotonic() < deadline and not system.requested():
            try:
                self._client = executors.client(self.address)
                self._counted_at = -RECOUNT_INTERVAL
                if self.nodes():
                    return
                self.close()
                reason = "it has no nodes"
            except Exception as error:
                reason = error_line(error)
            time.sleep(0.5)
        raise SchedulerLostError(
            f"scheduler: {self.address} was lost ({reason}); finished blocks are stored: run the same command again "
            "to resume"
        )

    def close(self) -> None:
        """Disconnect from the scheduler."""
        executors.close_peer(self._client)


class _Task:
    """A block under way on some node."""

    def __init__(self, number: int, future: Any, *, is_helping: bool):
        self.number, self.future, self.is_helping = number, future, is_helping
        self.since = time.monotonic()


class NodesDriver:
    """Distributes blocks to nodes until all are finished, a signal arrives, or too many cases failed."""

    def __init__(self, job: BlockJob, cluster: Cluster, display: CaseProgress):
        """Prepare to run a job on a cluster; `display` is the phase that shows progress."""
        self.job, self.cluster, self.display = job, cluster, display
        self.token, self.content = secrets.token_hex(8), pickle.dumps(job)
        self.tasks: list[_Task] = []
        self.ran, self.failed, self.case_seconds, self.complete = 0, 0, 0.0, True
        self.committed: dict[int, float] = {}  # completely committed block -> s, when this was noticed
        self.refusal = ""

    def run(self) -> bool:
        """Run and finish all blocks; return False if stopped because too many cases failed."""
        stop = stop_file(self.job, self.token)
        try:
            numbers, _marks = unfinished_blocks(self.job)
            allowed = allowed_failures(self.job, numbers)
            for _ in range(MAX_ROUNDS):
                if not numbers or not self.complete:
                    break
                self._run_round(deque(numbers), allowed)
                self._flush()
                numbers, _marks = unfinished_blocks(self.job)
            else:
                if self.complete and numbers:
                    raise SchedulerLostError(
                        "scheduler: its nodes die before they finish a block; run the same command again to continue"
                    )
        except BaseException:
            stop.touch()
            raise
        finally:
            if not self.complete:
                stop.touch()
            self._close_nodes()
        return self.complete

    def _run_round(self, queue: "deque[int]", allowed: int | None) -> None:
        """Run the blocks in `queue`; `allowed` : number of cases that may fail in all rounds."""
        with system.patience():
            while queue or self.tasks:
                if system.requested():
                    finished = f"{self.ran:,} cases are finished and stored"
                    raise system.Stopped(
                        system.requested(), f"stopped: {finished}; run the same command again to resume"
                    )
                try:
                    self._hand_out(queue, None if allowed is None else allowed - self.failed)
                    done = [task for task in self.tasks if task.future.done()]
                    for task in done:
                        self._handle_completion(task, queue)
                except (StorageError, InputError):
                    raise
                except Exception:  # many kinds: the scheduler is gone
                    phases.print_line(f"scheduler: {self.cluster.address} was lost; waiting for it to reconnect")
                    queue.extend(dict.fromkeys(task.number for task in self.tasks if not task.is_helping))
                    self.tasks.clear()
                    self.cluster.reconnect()
                    continue
                if allowed is not None and self.failed > allowed:
                    self.complete = False
                    return
                if not done:
                    time.sleep(CHECK_INTERVAL)

    def _hand_out(self, queue: "deque[int]", most_failures: int | None) -> None:
        node_count = len(self.cluster.nodes())
        if not node_count:
            if self.refusal:
                raise StorageError(self.refusal)
            return
        while queue and len(self.tasks) < node_count:
            number = queue.popleft()
            if any(task.number == number and not task.is_helping for task in self.tasks):
                continue
            future = self.cluster.submit(run_block, self.token, self.content, number, most_failures)
            self.tasks.append(_Task(number, future, is_helping=False))
        if queue or self.job.grid.layout.life:
            return  # a life must not run on two nodes
        now = time.monotonic()
        for number, committed_at in list(self.committed.items()):
            own_tasks = [task for task in self.tasks if task.number == number and not task.is_helping]
            if own_tasks and now - committed_at > SILENCE_TIMEOUT:  # its node does not answer: another node finishes it
                for task in own_tasks:
                    self.tasks.remove(task)
                    self.cluster.exclude_node_of(task.future)
                    task.future.cancel()
                del self.committed[number]
                queue.append(number)
        main_tasks = [task for task in self.tasks if not task.is_helping and now - task.since > HELP_AFTER]
        helped_numbers = [task.number for task in self.tasks if task.is_helping]
        for task in sorted(main_tasks, key=lambda task: (helped_numbers.count(task.number), task.since)):
            if len(self.tasks) >= node_count:
                return
            if task.number not in self.committed and task.number not in helped_numbers:
                helping = functools.partial(run_block, is_helping=True)
                future = self.cluster.submit(helping, self.token, self.content, task.number)
                self.tasks.append(_Task(task.number, future, is_helping=True))

    def _handle_completion(self, task: _Task, queue: "deque[int]") -> None:
        """Record the end of a task."""
        try:
            report = task.future.result(timeout=executors.ANSWER_TIMEOUT)
        except CancelledError:
            raise
        except Exception as error:
            if task.future.status == "cancelled" or type(error).__name__ in ("FutureCancelledError", "CommClosedError"):
                raise
            self.tasks.remove(task)
            if type(error).__name__ != "KilledWorker":
                phases.print_line(f"block {task.number + 1:,}: {error_line(error)}; it is tried again")
                if not isinstance(error, OSError):
                    raise InputError(f"block {task.number + 1:,}: {error_line(error)}") from error
            if not task.is_helping:
                queue.append(task.number)
            return
        self.tasks.remove(task)
        if not isinstance(report, NodeReport):  # the nodes of a cluster are not trusted
            raise InputError(
                f"block {task.number + 1:,}: was answered as no node of this run answers ({type(report).__name__}); "
                "run the same command again, on a cluster that nobody else uses"
            )
        self.ran, self.failed = self.ran + report.ran, self.failed + report.failed
        self.case_seconds += report.case_seconds
        self.display.advance(report.ran, report.failed)
        if report.refused:
            self.cluster.excluded.add(report.node)
            self.refusal = report.refused
            phases.print_line(f"node {report.node}: {report.refused.partition(';')[0]}; its work goes to other nodes")
            if not task.is_helping:
                queue.append(task.number)
        elif task.is_helping:
            self.committed[task.number] = time.monotonic()
        else:
            self.committed.pop(task.number, None)
            self.complete &= report.complete

    def _flush(self) -> None:
        """Wait until the nodes have finished their blocks; blocks of lost nodes are requested again."""
        try:
            tasks = [self.cluster.submit(flush, self.token, on=address) for address in self.cluster.nodes()]
            for task in tasks:
                deadline = time.monotonic() + executors.ANSWER_TIMEOUT
                while not task.done() and not system.requested():
                    if time.monotonic() > deadline and not unfinished_blocks(self.job)[0]:
                        break  # all are finished all the same
                    time.sleep(CHECK_INTERVAL)
                if task.done() and (report := task.result(timeout=executors.ANSWER_TIMEOUT)).refused:
                    self.cluster.excluded.add(report.node)
                    self.refusal = report.refused
        except Exception:
            self.cluster.reconnect()

    def _close_nodes(self) -> None:
        try:
            tasks = [self.cluster.submit(close, self.token, on=address) for address in self.cluster.nodes()]
            deadline = time.monotonic() + executors.ANSWER_TIMEOUT
            while tasks and time.monotonic() < deadline and not all(task.done() for task in tasks):
                time.sleep(CHECK_INTERVAL)
        except Exception:
            return
        finally:
            self.cluster.close()


def run_on_nodes(job: BlockJob) -> BlocksOutcome:
    """Run all blocks of a grid on the nodes of the cluster in the options."""
    numbers, marks = unfinished_blocks(job)
    if not numbers:
        return BlocksOutcome(marks, 0, 0.0, complete=True)
    assert job.options.scheduler  # `sweep.check` requires it
    for number in numbers:
        durable.remove_temporaries(store.Block(job.directory, number).path / store.SCRATCH)
    cases = sum(len(job.division.part(number)) for number in numbers)
    ok, failed = (sum(mark[name] for mark in marks.values()) for name in ("ok", "failed"))
    display = CaseProgress(ok + failed + cases, done=ok + failed, failed=failed)
    with phases.phase(display):
        driver = NodesDriver(job, Cluster(job.options.scheduler), display)
        complete = driver.run()
    for number in numbers:
        if mark := finished_mark(job, number):
            marks[number] = mark
        durable.remove_temporaries(store.Block(job.directory, number).path / store.SCRATCH, remove_folder=True)
    return BlocksOutcome(marks, driver.ran, driver.case_seconds, complete)
