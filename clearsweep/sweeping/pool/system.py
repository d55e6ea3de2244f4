"""What the operating system allows a process, and what its signals ask of it."""

import contextlib
import ctypes
import errno
import gc
import os
import resource
import signal
import sys
import threading
import warnings
from collections.abc import Iterable, Iterator
from types import FrameType

from ...language.errors import ClearsweepError, InputError

# ----------------------------------------------------------------------------------------------------------------------
# Limits of the operating system: too low ones are refused at once, with the limit and the remedy.


MIN_ADDRESS_SPACE = 1_000_000_000  # bytes of address space for loading the modules of a run and compiling a scene
ADVISED_ADDRESS_SPACE = 4_000_000  # kB, as for `ulimit -v`; the advised limit
ADVISED_FILES = 256  # least advised number of open files
THREAD_VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMBA_NUM_THREADS",
)  # environment variables with the number of threads of libraries, which read them when they are loaded


PR_SET_PDEATHSIG = 1  # of Linux: the signal that the end of the parent sends
_USUAL_THRESHOLDS = gc.get_threshold()
_OBJECTS_OF_IMPORTS = 500_000  # that stay: the garbage collector would look through them again and again


def make_start_cheap() -> None:
    """Prepare this process, which ends with its command, for loading libraries.

    They use one thread, unless the user set their number: a process with several cannot be forked, see `forks`.
    """
    gc.set_threshold(_OBJECTS_OF_IMPORTS, *_USUAL_THRESHOLDS[1:])
    for name in THREAD_VARIABLES:
        os.environ.setdefault(name, "1")


def collect_as_usual() -> None:
    """Collect garbage as Python does by default, but for the objects that there are now."""
    gc.freeze()
    gc.set_threshold(*_USUAL_THRESHOLDS)


def check_space() -> None:
    """Raise InputError if the address space is too small to load the modules of every verb."""
    space, _ = resource.getrlimit(resource.RLIMIT_AS)
    if space != resource.RLIM_INFINITY and space < MIN_ADDRESS_SPACE:
        raise InputError(
            f"memory: this process may use {space / 1e6:,.0f} MB of address space (ulimit -v), less than the "
            f"{MIN_ADDRESS_SPACE / 1e6:,.0f} MB that clearsweep needs; raise it, for example with `ulimit -v "
            f"{ADVISED_ADDRESS_SPACE}`"
        )


def allow_files(count: int) -> None:
    """Allow this process `count` open files; raise InputError if that is not permitted."""
    soft_limit, hard_limit = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft_limit == resource.RLIM_INFINITY or count <= soft_limit:
        return
    if hard_limit != resource.RLIM_INFINITY and count > hard_limit:
        raise InputError(
            f"open files: this process may have {hard_limit:,} (ulimit -n), fewer than the {count:,} that its workers "
            f"need; raise the limit, such as `ulimit -n {max(ADVISED_FILES, count)}`, or use fewer workers with --jobs"
        )
    resource.setrlimit(resource.RLIMIT_NOFILE, (count, hard_limit))


def remedy_text(error: BaseException) -> str | None:
    """Return a sentence for an error caused by a system limit, or None for any other error."""
    number = getattr(error, "errno", None)
    if isinstance(error, MemoryError) or number == errno.ENOMEM:
        return (
            f"memory: not enough ({str(error) or 'an allocation failed'}); use fewer workers with "
            "--jobs, save fewer histories with `save`, or raise the limit (ulimit -v)"
        )
    if number in (errno.EMFILE, errno.ENFILE):
        return (
            f"open files: this process has reached its limit (ulimit -n); raise it, for example with `ulimit -n "
            f"{ADVISED_FILES}`, or use fewer workers with --jobs"
        )
    if number == errno.ENAMETOOLONG:
        return path_too_long_text(str(getattr(error, "filename", "")))
    return None


def path_too_long_text(name: str) -> str:
    """Return the message for a path that is too long for the file system."""
    return f"{name[:60]}...: File name too long for the file system ({len(name)} characters); choose a shorter one"


# ----------------------------------------------------------------------------------------------------------------------
# Ctrl-C, SIGTERM, SIGHUP: on the first, a run finishes its current cases and stops; on the second it stops at once.


SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class _Request:
    """The request to stop that this process has received, if any."""

    signum = 0  # the signal that requested the stop, or 0
    patient = False  # whether the running code checks requested() between cases
    leaving = False  # whether it is stopping: later signals have no effect
    last = False  # whether the process ends with the run


class Stopped(KeyboardInterrupt):
    """A run that was stopped by a signal; finished cases are committed."""

    def __init__(self, signum: int, message: str = "stopped; run the same command again to continue"):
        _Request.leaving = True
        super().__init__(message)
        self.exit_code = 128 + signum


def requested() -> int:
    """Return the signal that requested the stop, or 0."""
    return _Request.signum


def end_with_run() -> None:
    """Make signals after the one that stopped a run have no effect until this process ends."""
    _Request.last = True


@contextlib.contextmanager
def patience() -> Iterator[None]:
    """Only record the first signal in this context, where the code checks requested() itself."""
    was_patient, _Request.patient = _Request.patient, True
    try:
        yield
    finally:
        _Request.patient = was_patient


@contextlib.contextmanager
def catching() -> Iterator[None]:
    """Make a signal raise Stopped in this context, or record it first under patience(); for the main thread.

    The first signal decides the exit code.  Once Stopped is raised, further signals have no effect: an interrupted
    clean-up could leave a lock in an invalid state.  An ignored SIGHUP stays ignored, as `nohup` requires.
    """
    _Request.signum, _Request.leaving = 0, False
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread can catch signals
        return
    nohup = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    handled = [signum for signum in SIGNALS if signum != signal.SIGHUP or not nohup]
    old_handlers = {signum: signal.signal(signum, _in_parent) for signum in handled}
    try:
        yield
    except ClearsweepError:
        raise
    except Exception as error:
        if _Request.leaving:  # raised where Stopped interrupted, for example at a lock
            raise Stopped(_Request.signum) from error
        raise
    finally:
        for signum, handler in old_handlers.items():
            signal.signal(signum, signal.SIG_IGN if _Request.last and _Request.leaving else handler)


def in_worker() -> None:
    """Make this process ignore SIGINT and SIGHUP, which a terminal sends to all, and finish its case on
    SIGTERM; without a case it ends at once."""
    _Request.signum, _Request.patient, _Request.leaving = 0, False, False  # as the process may be a fork of the parent
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _in_worker)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)


@contextlib.contextmanager
def shielded() -> Iterator[None]:
    """Block all of these signals for threads and processes started in this context: Ctrl-C must not reach them."""
    from multiprocessing import resource_tracker

    warnings.filterwarnings("ignore", "resource_tracker: process died")  # it is started again, and no lock is lost
    old_mask = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    resource_tracker.ensure_running()  # otherwise it would start with the first worker, and unblock two signals
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, old_mask)


def register_locks(names: Iterable[str]) -> None:
    """Register locks again before they are released: another resource tracker than the first does not know them.

    A system that runs out of memory may kill the first one; its successor would print a traceback for each lock.
    """
    from multiprocessing import resource_tracker

    if not resource_tracker._resource_tracker._check_alive():  # type: ignore[attr-defined]
        for name in names:
            resource_tracker.register(name, "semaphore")


def _in_parent(signum: int, _frame: FrameType | None) -> None:
    if _Request.leaving:
        return
    is_repeated, _Request.signum = _Request.signum, _Request.signum or signum
    if is_repeated or not _Request.patient:
        raise Stopped(_Request.signum)


def exit_if_requested() -> None:
    """End this process if it is a worker that was asked to end while busy."""
    if _Request.signum and signal.getsignal(signal.SIGTERM) is _in_worker:
        os._exit(128 + _Request.signum)


def _in_worker(signum: int, _frame: FrameType | None) -> None:
    _Request.signum = signum
    if not _Request.patient:
        exit_if_requested()


def no_preparation() -> None:
    """Do nothing: workers need no modules loaded in advance."""


def end_with(parent: int) -> None:
    """Make this process end with its parent; end it now if the parent, given by its number, has ended before."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
