"""A server that forks worker processes: each starts within milliseconds, with all modules of a case loaded.

The server is a fork of this process, which has loaded the modules already, as long as this process has a single thread.
Otherwise a lock of another thread would stay locked for ever in the fork, so the server is a new process that
loads them once for all workers.  Requests and answers go through a pair of sockets.  The server ends with this process,
and the workers end with the server.
"""

import contextlib
import gc
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future
from io import BytesIO
from multiprocessing import connection, popen_fork, reduction
from multiprocessing.context import SpawnContext, SpawnProcess, set_spawning_popen
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import Any, ClassVar, cast

from pebble import CONSTS, ProcessExpired, ProcessPool

from ...language import phases
from ...language.errors import InputError, error_line
from . import system, worker
from .system import THREAD_VARIABLES, no_preparation

CONSTS.sleep_unit = 0.02  # s; how soon a dead worker is noticed and a closed pool left
CONSTS.channel_lock_timeout = 2.0  # s; a worker that is killed with the lock stalls the others for twice as long
_OWN_THREADS = "/proc/self/task"
_OWN_FILES = "/proc/self/fd"


class SpawnedProcess(SpawnProcess):
    """A new process that does not re-import the user's script, which may lack a `__main__` guard."""

    @staticmethod
    def _Popen(process_obj: BaseProcess) -> Any:  # noqa: N802 - the name that multiprocessing calls
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            return SpawnProcess._Popen(process_obj)
        finally:
            sys.modules["__main__"] = main


class Context(SpawnContext):
    """The context of a pool, which knows the names of its locks; without a server its processes are new ones."""

    def __init__(self, load: Callable[[], None]) -> None:
        self.lock_names: list[str] = []
        self.server = Server(load) if sys.platform == "linux" else None  # libraries of other systems survive no fork

    def close(self) -> None:
        """End the server."""
        if self.server:
            self.server.close()

    def Process(self, **arguments: Any) -> BaseProcess:  # type: ignore[override]  # noqa: N802 - as pebble calls it
        """Return a process that is not started yet."""
        return ForkedProcess(self.server, **arguments) if self.server else SpawnedProcess(**arguments)

    def RLock(self) -> Any:  # noqa: N802 - the name that pebble calls
        """Return a lock that processes share."""
        lock: Any = super().RLock()
        self.lock_names.append(lock._semlock.name)
        return lock


class ForkedProcess(BaseProcess):
    """A process that a server forks."""

    _start_method = "spawn"  # of further processes

    def __init__(self, server: "Server", **arguments: Any):
        super().__init__(**arguments)
        self._server = server

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_server"}

    @staticmethod
    def _Popen(process_obj: Any) -> Any:  # noqa: N802 - the name that multiprocessing calls
        return _Started(process_obj)


class _Inherited:
    """A file that came with a request, in the process forked for it."""

    files: ClassVar[list[int]] = []

    def __init__(self, position: int):
        self.position = position

    def detach(self) -> int:
        """Return the descriptor."""
        return self.files[self.position]


class _Started(popen_fork.Popen):
    """A started process, as `multiprocessing` uses it."""

    DupFd = _Inherited
    sentinel: int  # becomes readable when the process ends

    def __init__(self, process: ForkedProcess):
        self._server, self._files = process._server, list[int]()
        super().__init__(process)

    def duplicate_for_child(self, file: int) -> int:
        """Send a file with the request; return its position."""
        self._files.append(file)
        return len(self._files) - 1

    def _launch(self, process: BaseProcess) -> None:
        content, popen = BytesIO(), cast("Any", self)
        set_spawning_popen(popen)
        try:
            reduction.dump(process, content)
        finally:
            set_spawning_popen(None)
        self.sentinel, end = os.pipe()
        try:
            self.pid = self._server.fork(content.getvalue(), [*self._files, end])
        except OSError:
            os.close(self.sentinel)
            raise
        finally:
            os.close(end)
        self.finalizer = multiprocessing.util.Finalize(self, os.close, (self.sentinel,))

    def poll(self, flag: int = os.WNOHANG) -> int | None:
        """Return the exit code, or None if the process has not ended; without the flag WNOHANG wait for the end."""
        if self.returncode is None and connection.wait([self.sentinel], 0 if flag == os.WNOHANG else None):
            self.returncode = self._server.exit_code(self.pid)
        return self.returncode


class Server:
    """The process that forks workers; `load` is called in it before the first fork."""

    def __init__(self, load: Callable[[], None]):
        self._one_at_a_time = threading.Lock()
        self._requests, remote = multiprocessing.Pipe()
        with phases.without_thread():
            make: Any = multiprocessing.get_context("fork").Process if _has_one_thread() else SpawnedProcess
            self._process = make(target=_serve, args=(remote, os.getpid(), load))
            self._process.start()
        remote.close()
        self.pid: int = self._process.pid

    def fork(self, content: bytes, files: list[int]) -> int:
        """Return the number of a new process that runs a pickled process object, which refers to the files."""
        with self._one_at_a_time:
            try:
                self._requests.send((content, len(files)))
                for file in files:
                    reduction.send_handle(self._requests, file, self.pid)
                answer = self._requests.recv()
            except EOFError:
                raise ConnectionResetError("the process that starts the workers has ended") from None
        if isinstance(answer, OSError):
            raise answer
        return int(answer)

    def exit_code(self, pid: int) -> int:
        """Return the exit code of a process that has ended, negative for a signal."""
        with self._one_at_a_time:
            try:
                self._requests.send(pid)
                return int(self._requests.recv())
            except (OSError, EOFError):
                return -signal.SIGKILL  # with the server

    def close(self) -> None:
        """End the server, and with it all of its processes."""
        self._requests.close()
        self._process.kill()
        self._process.join()


def _has_one_thread() -> bool:
    """Return whether this process has no thread but the present one, of Python or of a library."""
    try:
        return len(os.listdir(_OWN_THREADS)) == 1
    except OSError:
        return False


def _serve(requests: Any, parent: int, load: Callable[[], None]) -> None:
    """Answer requests until the parent closes their other end; signals stay blocked, as the parent has blocked them."""
    system.end_with(parent)
    _release_files(requests.fileno())
    phases.forget()
    with contextlib.suppress(Exception):  # an error comes up again in a case, where it is recorded
        load()
    gc.freeze()  # a worker that looked through what is loaded would get a copy of its memory
    while True:
        try:
            request = requests.recv()
        except (EOFError, OSError):
            return
        if isinstance(request, int):
            requests.send(os.waitstatus_to_exitcode(os.waitpid(request, 0)[1]))
            continue
        content, count = request
        files = [reduction.recv_handle(requests) for _ in range(count)]
        try:
            answer: Any = os.fork()
        except OSError as error:
            answer = error
        if answer == 0:
            requests.close()
            _run(content, files)
        for file in files:
            os.close(file)
        requests.send(answer)


def _run(content: bytes, files: list[int]) -> None:
    """Run a pickled process object in this fork, and end with its exit code."""
    code = 1
    try:
        _Inherited.files[:] = files
        code = pickle.loads(content)._bootstrap()
    finally:
        os._exit(code)


def _release_files(kept: int) -> None:
    """Let go of the files of the process of which this is a fork, such as its lock, but for standard streams.

    Their numbers stay in use, as objects that are copies of the parent's may still close them.
    """
    null = os.open(os.devnull, os.O_RDWR)
    for name in os.listdir(_OWN_FILES):
        if int(name) not in (0, 1, 2, kept, null):
            os.dup2(null, int(name))


class Local:
    """Processes on this machine, one thread each; a process that dies loses only its own batch."""

    death_errors: tuple[type[Exception], ...] = (ProcessExpired,)
    is_remote = False

    def __init__(self, worker_count: int, load: Callable[[], None] = no_preparation):
        self.worker_count, self._load = worker_count, load
        self._environment = {name: os.environ.get(name) for name in THREAD_VARIABLES}
        os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))  # read by numpy when the workers import it
        self._pool = self._started()

    def _started(self) -> ProcessPool:
        with system.shielded(), contextlib.ExitStack() as undo:
            try:
                self._context = Context(self._load)
                undo.callback(self._context.close)
                server = self._context.server
                parent, load = (server.pid, no_preparation) if server else (os.getpid(), self._load)
                pool = ProcessPool(self.worker_count, 0, worker.start_worker, (parent, load), self._context)
                if pool.active:  # this call starts the workers
                    undo.pop_all()
                    return pool
                reason = ""
            except (OSError, BrokenExecutor) as error:
                reason = f" ({error_line(error.__cause__ or error)})"
        raise InputError(
            f"jobs: {self.worker_count} worker processes could not be started{reason}; reduce --jobs, or raise the "
            "limit (ulimit -a)"
        )

    def submit(self, function: Callable, *args: Any) -> Future:
        """Run `function(*args)` in a worker; raise RuntimeError if the pool is broken."""
        return self._pool.schedule(function, args=args)

    def restart(self) -> None:
        """Replace all workers; their unfinished batches are lost."""
        self.close()
        os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
        self._pool = self._started()

    def close(self) -> None:
        """Kill all workers; finished batches are kept."""
        try:
            system.register_locks(self._context.lock_names)
        finally:
            self._pool.stop()
        for process in multiprocessing.active_children():
            if isinstance(process, ForkedProcess | SpawnedProcess):
                process.kill()
        self._pool.join()
        self._context.close()
        for name, value in self._environment.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
