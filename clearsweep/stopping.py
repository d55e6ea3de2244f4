"""Ctrl-C and SIGTERM: asked once, a run finishes what is under way and stops; asked twice, it stops at once."""

import contextlib
import os
import signal
import threading

SIGNALS = (signal.SIGINT, signal.SIGTERM)
_requested = 0  # the signal that asked, 0 while nobody has
_patient = False  # whether whoever runs looks at requested() between two cases


class Stopped(KeyboardInterrupt):
    """A run that was asked to stop; what was finished is committed."""

    def __init__(self, signum: int, message: str = ""):
        super().__init__(message)
        self.exit_code = 128 + signum


def requested() -> int:
    """Return the signal that asked to stop, 0 where none has."""
    return _requested


@contextlib.contextmanager
def patience():
    """Inside, the first signal is only noted: the code looks at requested() itself."""
    global _patient
    before, _patient = _patient, True
    try:
        yield
    finally:
        _patient = before


@contextlib.contextmanager
def catching():
    """Inside, SIGINT and SIGTERM raise Stopped, or are noted first where there is patience; for the main thread."""
    global _requested
    _requested = 0
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread can catch signals
        return
    before = {signum: signal.signal(signum, _in_parent) for signum in SIGNALS}
    try:
        yield
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)


def in_worker() -> None:
    """Make this process leave SIGINT to its parent, finish its case on SIGTERM, and go at once where it has none."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _in_worker)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)


@contextlib.contextmanager
def shielded():
    """Inside, threads and processes are born with both signals blocked: a worker starting up is not torn by Ctrl-C."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _in_parent(signum, _frame):
    global _requested
    again, _requested = _requested, signum
    if again or not _patient:
        raise Stopped(signum)


def leave_if_asked() -> None:
    """End this process if it is a worker that was told to go while it was busy."""
    if _requested and signal.getsignal(signal.SIGTERM) is _in_worker:
        os._exit(128 + _requested)


def _in_worker(signum, _frame):
    global _requested
    _requested = signum
    if not _patient:
        leave_if_asked()
