"""The pictures of a page, drawn by two processes where there are two processors.

The second process is a copy of the first (a fork), as what draws a picture cannot be sent to another.  It draws every
second picture into a file and ends; it touches no file, thread or lock of the first.  Whatever becomes of it, the page
has all pictures, with the same bytes: what it does not bring in time is drawn here.
"""

import contextlib
import gc
import json
import os
import signal
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Iterator, Sequence
from typing import IO

from .picture import Picture, svg

SEVERAL = 8  # pictures from which on a copy of the process pays
PATIENCE, AT_LEAST = 3.0, 5.0  # times of the first process, s: how long the other may take beyond it
OFTEN = 0.01  # s


def svgs(pictures: Sequence[Picture]) -> list[str]:
    """Return pictures as SVG, in their order; their ids begin with f1, f2 and so on."""
    if len(pictures) < SEVERAL or not _can_copy():
        return _some(pictures, range(len(pictures)))
    mine, others = range(0, len(pictures), 2), range(1, len(pictures), 2)
    with tempfile.TemporaryFile("w+", encoding="utf-8") as file, _copy(pictures, others, file) as copy:
        begin = time.monotonic()
        even = _some(pictures, mine)
        done = _ended(copy, max(PATIENCE * (time.monotonic() - begin), AT_LEAST))
        file.seek(0)
        odd = json.load(file) if done else _some(pictures, others)
    found = [""] * len(pictures)
    found[::2], found[1::2] = even, odd
    return found


def _some(pictures: Sequence[Picture], places: range) -> list[str]:
    return [svg(pictures[place], f"f{place + 1}") for place in places]


def _can_copy() -> bool:
    """Return whether a copy of this process may draw: on Linux, with two processors, and no thread of Python's."""
    return sys.platform == "linux" and len(os.sched_getaffinity(0)) > 1 and threading.active_count() == 1


@contextlib.contextmanager
def _copy(pictures: Sequence[Picture], places: range, file: IO[str]) -> Iterator[int]:
    """Begin to draw some pictures into a file in a copy of this process; give its number, and end it in the end."""
    gc.freeze()  # what is there is not looked at again, so that both processes keep it in the same memory
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads below Python, which hold nothing it uses
        copy = os.fork()
    if not copy:
        failed = 1
        try:
            json.dump(_some(pictures, places), file)
            file.flush()
            failed = 0
        finally:
            os._exit(failed)
    gc.unfreeze()
    try:
        yield copy
    finally:
        os.kill(copy, signal.SIGKILL)
        os.waitpid(copy, 0)  # only now may its number be another's


def _ended(copy: int, patience: float) -> bool:
    """Return whether a copy ends well within so many seconds."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        found = os.waitid(os.P_PID, copy, os.WEXITED | os.WNOHANG | os.WNOWAIT)
        if found:
            return found.si_code == os.CLD_EXITED and found.si_status == 0
        time.sleep(OFTEN)
    return False
