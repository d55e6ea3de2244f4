"""The driver on a node of a cluster: runs whole blocks with a pool of processes on that node."""

import functools
import multiprocessing
import pickle
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ... import store
from ...language import phases
from ...language.errors import ClearsweepError, StorageError
from ...store import durable
from ..pool.case_runner import CaseRunner, Pending, missing_indices
from .blockwise import BlockJob, BlockRunner


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
        self.case_runner = self._case_runner()
        self.runner = BlockRunner(job, self.case_runner, earlier=self.directory)

    def _case_runner(self) -> CaseRunner:
        options = self.job.options._replace(executor="local", scheduler=None)
        return CaseRunner(self.directory, options, self.job.simulator)

    def close(self) -> None:
        """End the workers."""
        if self.case_runner.workers is not None:
            self.case_runner.workers.close()
            self.case_runner.workers = None

    def must_stop(self) -> bool:
        """Return whether the run must stop."""
        return stop_file(self.job, self.token).exists()


_node_drivers: list[_NodeDriver] = []  # driver of this process, at most one


def stop_file(job: BlockJob, token: str) -> Path:
    """Return the file that asks all nodes of a run to stop."""
    return durable.scratch_file(job.directory / store.SCRATCH, f"{token}.part")


@functools.lru_cache(maxsize=1)
def _unpacked(content: bytes) -> BlockJob:
    job: BlockJob = pickle.loads(content)
    return job


def _node_driver(token: str, content: bytes) -> _NodeDriver:
    """Return this process's driver for a run; that of an earlier run is closed."""
    if not _node_drivers or _node_drivers[0].token != token:
        while _node_drivers:
            _node_drivers.pop().close()
        multiprocessing.current_process()._config.pop("daemon", None)  # type: ignore[attr-defined] # a nanny's child
        _node_drivers.append(_NodeDriver(token, _unpacked(content)))
    return _node_drivers[0]


class _OtherCommits:
    """Commits of other drivers in a block; each summary is read once."""

    def __init__(self, node: _NodeDriver, number: int):
        self.node = node
        self.directory = store.RunDirectory(store.Block(node.job.directory, number).path)
        self.directory.expect(store.ResultSchema.of(node.job.grid))
        self.ids = np.empty(0, "u8")
        self.read_names: set[str] = set()

    def __call__(self) -> np.ndarray:
        """Return the identities of committed cases, ascending; raise _StoppedError if the run must stop."""
        if self.node.must_stop():
            raise _StoppedError
        names = self.directory.summary_names() - self.read_names
        id_arrays = [self.directory.finished_ids_in(name) for name in sorted(names)]
        self.read_names |= names
        self.ids = np.unique(np.concatenate([self.ids, *id_arrays]))
        return self.ids


def run_block(token: str, content: bytes, number: int, most_failures: int | None) -> NodeReport:
    """Run the missing cases of a block with the workers of this node, and start finishing the block."""
    return _run(token, content, number, most_failures, is_helping=False)


def help_block(token: str, content: bytes, number: int) -> NodeReport:
    """Run cases of another node's block, from its end, until all are committed."""
    return _run(token, content, number, None, is_helping=True)


def _run(token: str, content: bytes, number: int, most_failures: int | None, *, is_helping: bool) -> NodeReport:
    node, address = _node_driver(token, content), _address()
    case_runner, runner = node.case_runner, node.runner
    counts_before = case_runner.ran, case_runner.failed, case_runner.case_seconds
    error_text, complete = "", True
    try:
        with phases.show_progress(enabled=False):
            other_nodes = _OtherCommits(node, number)
            other_nodes()
            if is_helping:
                _help(node, number, other_nodes)
            else:
                runner.allowed_failures = None if most_failures is None else case_runner.failed + most_failures
                complete = runner.run(number, other_nodes)
    except _StoppedError:
        node.close()
        runner.finishing.clear()
        complete = False
    except StorageError as error:
        _node_drivers.clear()
        node.close()
        error_text = str(error)
    return NodeReport(
        address,
        case_runner.ran - counts_before[0],
        case_runner.failed - counts_before[1],
        case_runner.case_seconds - counts_before[2],
        complete=complete,
        refused=error_text,
    )


def _help(node: _NodeDriver, number: int, other_nodes: _OtherCommits) -> None:
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
    if case_runner.workers is None:
        case_runner.start_workers(len(ids))
    case_runner.run_cases(job.grid, Pending(indices[pending], ids[pending], read_finished_ids=other_nodes))


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
        _node_drivers.pop().close()


def _address() -> str:
    """Return the address of this node at its scheduler."""
    from distributed import get_worker

    return str(get_worker().address)
