"""Progress of the cases of a sweep, and of the workers that compile for it; `language.phases` prints it."""

import math
import time
from collections.abc import Callable, Sequence

from .. import store
from ..language import phases
from ..language.phases import say, shown

__all__ = ["Cases", "Compiling", "Pace", "say", "shown"]

SETTLING = 1.0  # s after the first case before the time left is shown
LISTED = 3  # cases at work that a line mentions of
LONG = phases.FIRST  # s, from which a case at work is listed


class Pace:
    """How fast cases are done: their mean rate since the first was, which no single batch moves much."""

    def __init__(self) -> None:
        self.begin: float | None = None
        self.first = 0

    def left(self, done: int, total: int) -> float | None:
        """Return the seconds left with so many cases done, None while too little is known."""
        now = time.monotonic()
        if self.begin is None:
            if done:
                self.begin, self.first = now, done
            return None
        spent = now - self.begin
        return None if done == self.first or spent < SETTLING else spent * (total - done) / (done - self.first)


class Cases(phases.Phase):
    """The phase in which cases run: how many are done, how long the others take, which one takes long."""

    def __init__(self, total: int, title: str = ""):
        """Take the number of cases, and what to say before it."""
        super().__init__(self._words)
        self.title = title
        self.total, self.done, self.failed, self.jobs = total, 0, 0, 1
        self.pace = Pace()
        #: Returns the number of cases that workers have done of batches under way, and the cases they are at.
        self.look: Callable[[], tuple[int, Sequence[phases.Progress]]] = lambda: (0, ())
        self._seen: tuple[float, tuple[int, Sequence[phases.Progress]]] = (-math.inf, (0, ()))

    def seen(self) -> tuple[int, Sequence[phases.Progress]]:
        """Return what `look` returns, or what it did a moment ago: it reads files."""
        now = time.monotonic()
        if now - self._seen[0] >= phases.LOOK:
            self._seen = now, self.look()
        return self._seen[1]

    def advance(self, done: int, failed: int) -> None:
        """Take note of `done` more cases; `failed` is the number that failed in all."""
        self.done, self.failed = self.done + done, failed
        self.pace.left(self.done, self.total)

    def _words(self) -> str:
        done = min(self.done + self.seen()[0], self.total)
        self.share = done / max(self.total, 1)
        return f"{self.title}{done:,} of {self.total:,} cases, {self.failed:,} failed"

    def left(self, now: float) -> float | None:
        """Return the time (s) left: at the mean pace of cases, or as the progress of those at work foretells."""
        in_hand, at_work = self.seen()
        known = [each for each in at_work if each.left is not None]
        paced = self.pace.left(self.done + in_hand, self.total)
        if not known:
            return paced
        left = max(each.left or 0.0 for each in known)
        if paced is not None:
            return max(paced, left)
        whole = [each.seconds + (each.left or 0.0) for each in known if not each.once]
        if not whole:
            return None
        waiting = max(self.total - self.done - in_hand - len(at_work), 0)
        return max(left, sum(whole) / len(whole) * (1.0 + waiting / max(self.jobs, 1)) - known[0].seconds)

    def further(self) -> str:
        """Return the cases that take long, each with its progress."""
        long = [each for each in self.seen()[1] if each.seconds >= LONG]
        more = f"; and {len(long) - LISTED:,} more" if len(long) > LISTED else ""
        return "".join(f"; {store.case_text(each)}" for each in long[:LISTED]) + more


class Compiling(phases.Phase):
    """The phase in which workers compile what cases need, or load it."""

    def __init__(self, parts: int, look: Callable[[], Sequence[phases.Progress]]):
        """Take the number of parts to compile, and what returns the progress of those that workers are at."""
        super().__init__(self._words)
        self.parts, self.look, self.done = parts, look, 0

    def _words(self) -> str:
        if phases.innermost() is not self:
            return ""  # the worker is this process, and says it itself
        what = next((each.what for each in self.look()), "loading compiled code")
        return f"{what}, part {min(self.done + 1, self.parts)} of {self.parts}"

    def left(self, now: float) -> float | None:
        """Return the time (s) that the slowest of them takes still, and the others at the pace so far."""
        slowest = max((each.left for each in self.look() if each.left is not None), default=None)
        if slowest is None or not self.done:
            return slowest
        return slowest + (now - self.begin) * max(self.parts / self.done - 2.0, 0.0)  # two at a time at least
