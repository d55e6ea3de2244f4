"""Ctrl-C, SIGTERM, SIGHUP: on the first, a run finishes its current cases and stops; on the second it stops at once."""

import contextlib
import os
import signal
import threading
import warnings
from collections.abc import Iterable, Iterator
from types import FrameType

from ...language.errors import ClearsweepError

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
