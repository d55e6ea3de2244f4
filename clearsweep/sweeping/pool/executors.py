"""Executors: where batches run."""

import contextlib
import functools
import logging
import math
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future
from typing import Any, Protocol, TypeVar

from ...language.errors import InputError, SchedulerLostError, error_line
from . import system, worker
from .system import THREAD_VARIABLES, no_preparation

NODES = "nodes"  # not an executor: a driver on each node of a cluster, see `nodes`
RECOUNT_INTERVAL = 2.0  # s between counts of a cluster's workers
ANSWER_TIMEOUT = 10.0  # s for a scheduler to answer a request, including the connection
BASE_FILES = 24  # most open files of a run, without those of its workers
FILES_OF_WORKER = {"local": 2, "serial": 0, "dask": 10, NODES: 0}
QUIETED_LOGGERS = (
    "asyncio",
    "distributed",
    "tornado",
)  # loggers that print tracebacks of failures that are handled here


def cores() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def allow_files(executor: str, worker_count: int) -> None:
    """Raise the limit of open files to the need of `worker_count` workers; InputError if that is not permitted."""
    system.allow_files(BASE_FILES + FILES_OF_WORKER[executor] * worker_count)


class Executor(Protocol):
    """Workers that run batches, as the driver uses them.

    Arguments: number of workers, address of a scheduler, and a function that each new worker calls first.
    """

    death_errors: tuple[type[Exception], ...]  # exceptions of a batch whose worker died
    is_remote: bool  # whether workers may be on other machines

    @property
    def worker_count(self) -> int:
        """Return the number of workers."""

    def submit(self, function: Callable, *args: Any) -> Future:
        """Run `function(*args)` in a worker; raise RuntimeError if the pool is broken."""

    def restart(self) -> None:
        """Replace all workers; their unfinished batches are lost."""

    def close(self) -> None:
        """End all workers."""


class Serial:
    """This process, one batch at a time: for debugging a case, not for sweeps."""

    worker_count, is_remote = 1, False
    death_errors: tuple[type[Exception], ...] = ()

    def submit(self, function: Callable, *args: Any) -> Future:
        """Run `function(*args)` and return its outcome."""
        future: Future = Future()
        try:
            future.set_result(function(*args))
        except Exception as error:
            future.set_exception(error)
        return future

    def restart(self) -> None:
        """Do nothing: there are no workers."""

    def close(self) -> None:
        """Do nothing."""


class Dask:
    """The workers of the dask cluster at a scheduler's address; without an address, those of a new local cluster."""

    is_remote = True

    def __init__(self, worker_count: int, scheduler: str | None = None, _load: Callable[[], None] = no_preparation):
        distributed = _distributed()
        self.death_errors: tuple[type[Exception], ...] = (distributed.KilledWorker, worker.AbandonedError)
        self._requested_worker_count, self._scheduler = worker_count, scheduler
        self._start()

    def _start(self) -> None:
        self._cluster = None if self._scheduler else _cluster(self._requested_worker_count)
        self._client = client(self._scheduler or self._cluster)
        self._executor = self._client.get_executor(pure=False, retries=0)
        self._counted_at = -math.inf

    @property
    def worker_count(self) -> int:
        """Return the number of workers, at least 1, counted at most every RECOUNT_INTERVAL seconds."""
        if time.monotonic() - self._counted_at > RECOUNT_INTERVAL:
            try:
                self._worker_count = max(1, len(with_timeout(self._client.nthreads)))
            except Exception as error:
                raise self._lost_error(error) from None
            self._counted_at = time.monotonic()
        return self._worker_count

    def submit(self, function: Callable, *args: Any) -> Future:
        """Run `function(*args)` on some worker; raise RuntimeError if the connection to the scheduler is lost."""
        content = pickle.dumps((function, args))
        try:
            future: Future = self._executor.submit(worker.run_packed, content)
        except Exception as error:  # a closed client raises its own error
            raise BrokenExecutor(error_line(error)) from None
        return future

    def restart(self) -> None:
        """Connect again; a cluster that this run started is replaced."""
        self.close()
        try:
            self._start()
        except InputError as error:
            raise self._lost_error(error.__cause__) from None

    def _lost_error(self, error: BaseException | None) -> SchedulerLostError:
        """Return the error for a scheduler that no longer answers."""
        return SchedulerLostError(
            f"scheduler: {self._scheduler or 'the one of this run'} was lost ({error}); "
            "finished cases are kept: run the same command again to continue"
        )

    def close(self) -> None:
        """Cancel unfinished batches; end the workers of a cluster that this run started."""
        self._executor.shutdown(wait=False)
        if self._cluster is not None:
            for nanny in self._cluster.workers.values():
                nanny.auto_restart = False
                with contextlib.suppress(ProcessLookupError, TypeError):
                    os.kill(nanny.pid, signal.SIGKILL)  # a case may never end
        close_peer(self._client)
        if self._cluster is not None:
            close_peer(self._cluster)


def close_peer(peer: Any) -> None:
    """Close a client or a cluster, or abandon it after ANSWER_TIMEOUT.

    Closing waits for a lock that all clients and clusters share. Garbage collection of one of them meanwhile can leave
    it locked for ever. The interpreter must not close an abandoned cluster again at its end. A client that has lost its
    scheduler connects again by itself, or gives up; closed meanwhile, it may drop the new connection unclosed.
    """
    deadline = time.monotonic() + ANSWER_TIMEOUT
    while getattr(peer, "status", None) == "connecting" and time.monotonic() < deadline and not system.requested():
        time.sleep(0.01)
    with contextlib.suppress(Exception):
        with_timeout(functools.partial(peer.close, timeout=ANSWER_TIMEOUT))
        return
    with contextlib.suppress(AttributeError, KeyError):
        type(peer)._instances.discard(peer)


def check_scheduler(scheduler: str | None) -> None:
    """Raise InputError if dask is not installed, the scheduler does not answer, or a worker has several threads."""
    _distributed()
    if scheduler is None:
        return
    dask_client = client(scheduler)
    try:
        multithreaded = [address for address, threads in with_timeout(dask_client.nthreads).items() if threads > 1]
    except Exception as error:
        raise _no_answer(scheduler, error) from None
    finally:
        close_peer(dask_client)
    if multithreaded:
        raise InputError(
            f"scheduler: {len(multithreaded)} workers of {scheduler} have several threads ({multithreaded[0]}); start "
            "them with `dask worker --nthreads 1 --nworkers N`, one case at a time in each"
        )


def client(address: Any) -> Any:
    """Return a client of the scheduler at `address`, or of a cluster."""
    connect = functools.partial(_distributed().Client, address, timeout=ANSWER_TIMEOUT, set_as_default=False)
    try:
        return with_timeout(connect)
    except Exception as error:  # many kinds: a wrong address, no server, or a server of another protocol
        raise _no_answer(address, error) from error


def _no_answer(address: Any, error: Exception) -> InputError:
    """Return the error for an address at which no scheduler answers."""
    return InputError(
        f"scheduler: {address} does not answer ({error_line(error)}); expected the address that "
        "`dask scheduler` prints, such as tcp://10.0.0.1:8786"
    )


T = TypeVar("T")


def with_timeout(function: Callable[[], T]) -> T:
    """Return `function()`, or raise TimeoutError after ANSWER_TIMEOUT; its thread then continues in the background.

    The time limit of a client applies to each message separately, and restarts when it closes.
    """
    answer: Future[T] = Future()

    def run() -> None:
        try:
            answer.set_result(function())
        except BaseException as error:
            answer.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    try:
        return answer.result(ANSWER_TIMEOUT)
    except TimeoutError:
        raise TimeoutError(f"no answer within {ANSWER_TIMEOUT:g} s") from None


def _cluster(worker_count: int) -> Any:
    """Return a cluster of processes on this machine, one thread each."""
    import dask

    settings = {
        "distributed.scheduler.allowed-failures": 10,  # for batches that were only waiting when a worker died
        "distributed.nanny.pre-spawn-environ": dict.fromkeys(THREAD_VARIABLES, "1"),
    }
    with dask.config.set(settings), system.shielded():
        return _distributed().LocalCluster(
            n_workers=worker_count,
            threads_per_worker=1,
            host="127.0.0.1",
            memory_limit=0,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        )


def _distributed() -> Any:
    """Return the package `distributed`; raise InputError if it is not installed."""
    try:
        import distributed
    except ImportError:
        raise InputError("executor: dask is not installed; `pip install 'clearsweep[dask]'` installs it") from None
    for name in {*QUIETED_LOGGERS, *logging.root.manager.loggerDict}:
        if name.partition(".")[0] in QUIETED_LOGGERS:
            logging.getLogger(name).setLevel(logging.CRITICAL)
    return distributed


MakeExecutor = Callable[[int, str | None, Callable[[], None]], Executor]  # of jobs, scheduler, load


def _local(worker_count: int, _scheduler: str | None, load: Callable[[], None]) -> Executor:
    from .forks import Local  # loads asyncio, which cases in this process do not need

    return Local(worker_count, load)


EXECUTORS: dict[str, MakeExecutor] = {"local": _local, "serial": lambda *_: Serial(), "dask": Dask}
