"""Tells that code is being compiled, for how long still: only where it is, not where it is loaded from the cache."""

import contextlib
import time
from collections.abc import Iterator

from numba.core import event

from ...language import phases

PAUSE = 1.0  # s without compiling after which further compiling is another stretch of it
# s of processor time that compiling takes, as measured on a core of a server of 2023
LOOP, SCENE, TOGETHER, SLOPES = 50.0, 22.0, 10.0, 10.0


class _Listener(event.Listener):
    """Opens a phase while the compiler is at work."""

    def __init__(self) -> None:
        self.depth = 0
        self.phase: phases.Phase | None = None
        self.begin = self.end = float("-inf")  # s, of the present stretch
        self.expected: list[tuple[float, float, float]] = []  # s of processor time; both clocks where it began, s

    def on_start(self, event: event.Event) -> None:
        """Open the phase at the outermost function, and note how long compiling takes still."""
        if not self.depth:
            now = time.monotonic()
            self.begin = now if now - self.end > PAUSE else self.begin
            self.phase = phases.start(phases.Phase("compiling (kept for later runs)", once=True, since=self.begin))
        self.depth += 1
        if self.phase:
            self.phase.note(left=self._left())

    def on_end(self, event: event.Event) -> None:
        """Close the phase at the end of the outermost function."""
        self.depth -= 1
        if not self.depth and self.phase:
            phases.end(self.phase)
            self.end = time.monotonic()

    def _left(self) -> float | None:
        """Return the time (s) left, at the share of a core that this process gets; None where nothing is known."""
        if not self.expected:
            return None
        expected, wall, processor = self.expected[-1]
        spent = time.process_time() - processor
        pace = max((time.monotonic() - wall) / spent, 1.0) if spent > PAUSE else 1.0
        return max(expected - spent, 0.0) * pace or None


_listener = _Listener()
event.register("numba:run_pass", _listener)  # a phase for whatever is compiled in this process, and wherever


@contextlib.contextmanager
def announced(expected: float) -> Iterator[None]:
    """Estimate how long compiling takes within this context: `expected`, s of processor time where nothing is kept."""
    _listener.expected.append((expected, time.monotonic(), time.process_time()))
    try:
        yield
    finally:
        _listener.expected.pop()
