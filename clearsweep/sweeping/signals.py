"""Ctrl-C, SIGTERM, SIGHUP: at the first, a run finishes what is under way and stops; at the second it stops at once."""

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from types import FrameType

from ..language.errors import ClearsweepError

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class _Request:
    """The request to stop, as far as this process has had one."""

    signum = 0  # the signal that asked it to stop, 0 while none has
    patient = False  # whether whoever runs looks at requested() between two cases
    leaving = False  # whether it is on its way out: later signals change nothing
    last = False  # whether the process ends with the run


class Stopped(KeyboardInterrupt):
    """A run that was asked to stop; what was finished is committed."""

    def __init__(self, signum: int, message: str = "stopped; run the same command again to go on"):
        _Request.leaving = True
        super().__init__(message)
        self.exit_code = 128 + signum


def requested() -> int:
    """Return the signal that asked to stop, 0 where none has."""
    return _Request.signum


def end_with_run() -> None:
    """Let signals that come after the one that stopped a run change nothing until this process ends."""
    _Request.last = True


@contextlib.contextmanager
def patience() -> Iterator[None]:
    """Let the first signal only be noted inside: the code there looks at requested() itself."""
    before, _Request.patient = _Request.patient, True
    try:
        yield
    finally:
        _Request.patient = before


@contextlib.contextmanager
def catching() -> Iterator[None]:
    """Let a signal raise Stopped inside, or be noted first where there is patience; for the main thread.

    The first signal decides the exit code.  Once Stopped is raised, further signals change nothing: one that broke into
    the way out could leave a lock in a state that is none.  A SIGHUP that is ignored stays so: `nohup` asked for that.
    """
    _Request.signum, _Request.leaving = 0, False
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread can catch signals
        return
    nohup = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    caught = [signum for signum in SIGNALS if signum != signal.SIGHUP or not nohup]
    before = {signum: signal.signal(signum, _in_parent) for signum in caught}
    try:
        yield
    except ClearsweepError:
        raise
    except Exception as error:
        if _Request.leaving:  # what Stopped broke into, as a lock that was about to be taken
            raise Stopped(_Request.signum) from error
        raise
    finally:
        for signum, handler in before.items():
            signal.signal(signum, signal.SIG_IGN if _Request.last and _Request.leaving else handler)


def in_worker() -> None:
    """Make this process leave SIGINT and SIGHUP, which a terminal sends to all, to its parent, and finish its case on
    SIGTERM; it goes at once where it has none."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _in_worker)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)


@contextlib.contextmanager
def shielded() -> Iterator[None]:
    """Block all of them for threads and processes born inside: a worker starting up is not torn by Ctrl-C."""
    from multiprocessing import resource_tracker

    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    resource_tracker.ensure_running()  # it would start with the first worker, and unblock two of them
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _in_parent(signum: int, _frame: FrameType | None) -> None:
    if _Request.leaving:
        return
    again, _Request.signum = _Request.signum, _Request.signum or signum
    if again or not _Request.patient:
        raise Stopped(_Request.signum)


def leave_if_asked() -> None:
    """End this process if it is a worker that was asked to go while it was busy."""
    if _Request.signum and signal.getsignal(signal.SIGTERM) is _in_worker:
        os._exit(128 + _Request.signum)


def _in_worker(signum: int, _frame: FrameType | None) -> None:
    _Request.signum = signum
    if not _Request.patient:
        leave_if_asked()
