"""Progress of the cases of a sweep, and of the workers that compile for it; `language.phases` prints it."""

import math
import time
from collections.abc import Callable, Sequence

from ... import store
from ...language import phases
from ...language.phases import print_line, show_progress

__all__ = ["CaseProgress", "CompilationProgress", "CompletionRate", "print_line", "show_progress"]

SETTLING_TIME = 1.0  # s after the first case before the time left is shown
MAX_LISTED_CASES = 3  # most running cases in a line
LONG_CASE_TIME = phases.FIRST_LINE_DELAY  # s after which a running case is listed


class CompletionRate:
    """Mean rate of finished cases since the first one; a single batch hardly changes it."""

    def __init__(self) -> None:
        self.start_time: float | None = None
        self.initial_count = 0

    def record(self, done: int) -> None:
        """Record that `done` cases are finished: the rate counts from the first ones."""
        if self.start_time is None and done:
            self.start_time, self.initial_count = time.monotonic(), done

    def remaining_time(self, done: int, total: int) -> float | None:
        """Return the seconds left after `done` cases, or None while unknown."""
        if self.start_time is None:
            self.record(done)
            return None
        spent = time.monotonic() - self.start_time
        return (
            None
            if done == self.initial_count or spent < SETTLING_TIME
            else spent * (total - done) / (done - self.initial_count)
        )


class CaseProgress(phases.Phase):
    """The phase in which cases run: how many are finished, how long the others take, and which take long."""

    def __init__(self, total: int, title: str = ""):
        """Prepare for a number of cases, with a title."""
        super().__init__(self._status_text)
        self.title = title
        self.total, self.done, self.failed, self.worker_count = total, 0, 0, 1
        self.rate = CompletionRate()
        #: Returns the number of finished cases in running batches, and the current cases of the workers.
        self.read_progress: Callable[[], tuple[int, Sequence[phases.Progress]]] = lambda: (0, ())
        self._last_read: tuple[float, tuple[int, Sequence[phases.Progress]]] = (-math.inf, (0, ()))

    def running_cases(self) -> tuple[int, Sequence[phases.Progress]]:
        """Return the number of finished cases and the progress of the running ones; files are read once in a while."""
        now = time.monotonic()
        if now - self._last_read[0] >= phases.REFRESH_INTERVAL:
            self._last_read = now, self.read_progress()
        return self._last_read[1]

    def advance(self, new_done: int, total_failed: int) -> None:
        """Record more finished cases, and the total of failed ones."""
        self.done, self.failed = self.done + new_done, total_failed
        self.rate.record(self.done)

    def _status_text(self) -> str:
        done_count = min(self.done + self.running_cases()[0], self.total)
        self.share = done_count / max(self.total, 1)
        return f"{self.title}{done_count:,} of {self.total:,} cases, {self.failed:,} failed"

    def remaining_time(self, now: float) -> float | None:
        """Return the time (s) left: from the mean pace of cases, or from the progress of running ones."""
        done_in_batches, running = self.running_cases()
        with_estimate = [case for case in running if case.left is not None]
        remaining_by_rate = self.rate.remaining_time(self.done + done_in_batches, self.total)
        if not with_estimate:
            return remaining_by_rate
        remaining_time = max(case.left or 0.0 for case in with_estimate)
        if remaining_by_rate is not None:
            return max(remaining_by_rate, remaining_time)
        durations = [case.seconds + (case.left or 0.0) for case in with_estimate if not case.once]
        if not durations:
            return None
        waiting = max(self.total - self.done - done_in_batches - len(running), 0)
        return max(
            remaining_time,
            sum(durations) / len(durations) * (1.0 + waiting / max(self.worker_count, 1)) - with_estimate[0].seconds,
        )

    def line_suffix(self) -> str:
        """Return the long cases, each with its progress."""
        long_cases = [case for case in self.running_cases()[1] if case.seconds >= LONG_CASE_TIME]
        omitted = f"; and {len(long_cases) - MAX_LISTED_CASES:,} more" if len(long_cases) > MAX_LISTED_CASES else ""
        return "".join(f"; {store.case_text(case)}" for case in long_cases[:MAX_LISTED_CASES]) + omitted


class CompilationProgress(phases.Phase):
    """The phase in which workers compile or load the code of cases."""

    def __init__(self, parts: int, read_progress: Callable[[], Sequence[phases.Progress]]):
        """Prepare for a number of parts to compile; `read_progress` returns the progress of running ones."""
        super().__init__(self._status_text)
        self.parts, self.read_progress, self.done = parts, read_progress, 0

    def _status_text(self) -> str:
        if phases.innermost_phase() is not self:
            return ""  # the worker is this process, which shows it itself
        phase = next((part.what for part in self.read_progress()), "loading compiled code")
        return f"{phase}, part {min(self.done + 1, self.parts)} of {self.parts}"

    def remaining_time(self, now: float) -> float | None:
        """Return the time (s) left: of the slowest running part, and of the others at the present pace."""
        slowest = max((part.left for part in self.read_progress() if part.left is not None), default=None)
        if slowest is None or not self.done:
            return slowest
        return slowest + (now - self.begin) * max(self.parts / self.done - 2.0, 0.0)  # at least two at a time
