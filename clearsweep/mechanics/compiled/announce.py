"""Tells whoever waits that code is being compiled: only where it is, not where it is loaded from the cache."""

import contextlib
import sys
import time
from collections.abc import Iterator

from numba.core import event

PATIENCE = 1.0  # s of compiling before anything is said


class _Teller(event.Listener):
    """Says once, at the first function that is compiled more than PATIENCE after another one."""

    def __init__(self) -> None:
        self.begin: float | None = None
        self.told = False

    def on_start(self, event: event.Event) -> None:
        """Note when the first compilation began."""
        now = time.monotonic()
        self.begin = now if self.begin is None else self.begin
        if not self.told and now - self.begin > PATIENCE and sys.stderr is not None:
            self.told = True
            print("compiling a kind of scene (kept for later runs)", file=sys.stderr, flush=True)

    def on_end(self, event: event.Event) -> None:
        """Do nothing."""


@contextlib.contextmanager
def announced() -> Iterator[None]:
    """Write a line to stderr where what is done within this context compiles for more than PATIENCE."""
    with event.install_listener("numba:compile", _Teller()):
        yield
