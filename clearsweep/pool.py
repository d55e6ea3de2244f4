"""Executors: where batches run. Each has `submit(function, *args) -> Future`, `restart()` and `close()`."""

import multiprocessing
import os
import sys
from concurrent.futures import Future
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType

from pebble import CONSTS, ProcessPool

from clearsweep import stopping, worker

THREAD_VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS",
                    "VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS")
CONSTS.sleep_unit = 0.02  # s; how soon a dead worker is noticed and a closed pool left
CONSTS.channel_lock_timeout = 10.0  # s; a worker killed while it held the lock must not stop the others for long


def cores() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Process(SpawnProcess):
    """A worker process that does not import the user's own script again: it may have no `__main__` guard."""

    @staticmethod
    def _Popen(process_obj):  # noqa: N802 - the name that multiprocessing calls
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            return SpawnProcess._Popen(process_obj)
        finally:
            sys.modules["__main__"] = main


class _Context(SpawnContext):
    Process = _Process


class Local:
    """Processes of their own on this machine, one thread each; one that dies takes only its own batch along."""

    def __init__(self, jobs: int):
        self.jobs = jobs
        self._environment = {name: os.environ.get(name) for name in THREAD_VARIABLES}
        os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))  # read by numpy when the workers import it
        self._pool = self._started()

    def _started(self) -> ProcessPool:
        pool = ProcessPool(self.jobs, 0, worker.enter, (os.getpid(),), _Context())
        with stopping.shielded():
            if not pool.active:  # asking starts the workers
                raise RuntimeError("the worker processes could not be started")
        return pool

    def submit(self, function, *args) -> Future:
        """Run `function(*args)` in a worker; RuntimeError where the pool is broken."""
        return self._pool.schedule(function, args=args)

    def restart(self) -> None:
        """Replace all workers; what they had in hand is lost."""
        self.close()
        os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
        self._pool = self._started()

    def close(self) -> None:
        """End all workers at once, which harms nothing that is committed."""
        self._pool.stop()
        for process in multiprocessing.active_children():
            if isinstance(process, _Process):
                process.kill()
        self._pool.join()
        for name, value in self._environment.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


class Serial:
    """This very process, one batch at a time: for looking into a case, not for sweeps."""

    jobs = 1

    def __init__(self, _jobs: int = 1):
        """Take any number of jobs for one."""

    def submit(self, function, *args) -> Future:
        """Run `function(*args)` and return its outcome."""
        future = Future()
        try:
            future.set_result(function(*args))
        except Exception as error:
            future.set_exception(error)
        return future

    def restart(self) -> None:
        """Do nothing: there is no worker to lose."""

    def close(self) -> None:
        """Do nothing."""


EXECUTORS = {"local": Local, "serial": Serial}
