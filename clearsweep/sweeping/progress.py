"""Progress of a sweep on stderr: a bar on a terminal, a plain line now and then in a log."""

import sys
import time
from contextlib import AbstractContextManager

from ..language.errors import printable
from ..language.wording import duration

SETTLING = 1.0  # s after the first case before the time left is told


def of(total: int, *, wanted: bool) -> "Silent":
    """Return a context with `advance(done, failed)` for `total` cases."""
    if not wanted or sys.stderr is None:
        return Silent()
    return Bar(total) if sys.stderr.isatty() else Lines(total)


def say(sentence: str) -> None:
    """Tell whoever watches something."""
    if sys.stderr is not None:  # None would mean stdout
        print(printable(sentence), file=sys.stderr, flush=True)


class Silent(AbstractContextManager["Silent"]):
    """No progress."""

    def advance(self, done: int, failed: int) -> None:
        """Take note of `done` more cases; `failed` is the number that failed in all."""

    def look(self, in_hand: int) -> None:
        """Show the time that goes by, and so many cases that are done but not committed."""

    def __exit__(self, *_: object) -> None:
        """End the display."""


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


class Bar(Silent):
    """A bar with the time left; it moves with every case that a worker has done, committed or not."""

    def __init__(self, total: int):
        from tqdm import tqdm

        form = "{percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} cases, {elapsed} spent{postfix}"
        self.bar = tqdm(total=total, bar_format=form, dynamic_ncols=True, file=sys.stderr)
        self.pace, self.done, self.failed, self.due = Pace(), 0, 0, 0.0

    def advance(self, done: int, failed: int) -> None:
        """Move the bar on by `done` cases."""
        self.done, self.failed = self.done + done, failed

    def look(self, in_hand: int) -> None:
        """Draw the bar, twice a second at most."""
        now = time.monotonic()
        if now < self.due:
            return
        self.due = now + 0.5
        self.bar.n = max(self.bar.n, min(self.done + in_hand, self.bar.total))
        left = self.pace.left(self.bar.n, self.bar.total)
        said = [] if left is None else [f"about {duration(left)} left"]
        said += [f"{self.failed:,} failed"] if self.failed else []
        self.bar.set_postfix_str(", ".join(said))

    def __exit__(self, *_: object) -> None:
        self.bar.n = self.done
        self.bar.set_postfix_str(f"{self.failed:,} failed" if self.failed else "")
        self.bar.close()


class Lines(Silent):
    """A line after 5 s, then at growing intervals up to a minute."""

    def __init__(self, total: int):
        self.total, self.done, self.begin, self.pace = total, 0, time.monotonic(), Pace()
        self.due, self.interval = self.begin + 5.0, 5.0

    def advance(self, done: int, failed: int) -> None:
        """Write a line if one is due."""
        self.done += done
        left = self.pace.left(self.done, self.total)
        now = time.monotonic()
        if now < self.due or not self.done:
            return
        self.interval = min(1.5 * self.interval, 60.0)
        self.due = now + self.interval
        spent = now - self.begin
        rest = "" if left is None else f", about {duration(left)} left"
        say(f"{self.done:,} of {self.total:,} cases, {failed:,} failed, {duration(spent)} spent{rest}")
