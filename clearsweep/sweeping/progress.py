"""Progress of a sweep on stderr: a bar on a terminal, a plain line now and then in a log."""

import sys
import time
from contextlib import AbstractContextManager

from ..errors import printable


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

    def __exit__(self, *_: object) -> None:
        """End the display."""


class Bar(Silent):
    """A bar with rate and time left."""

    def __init__(self, total: int):
        from tqdm import tqdm

        self.bar = tqdm(total=total, unit="case", dynamic_ncols=True, file=sys.stderr)

    def advance(self, done: int, failed: int) -> None:
        """Move the bar on by `done` cases."""
        self.bar.update(done)
        if failed:
            self.bar.set_postfix_str(f"{failed} failed", refresh=False)

    def __exit__(self, *_: object) -> None:
        self.bar.close()


class Lines(Silent):
    """A line after 5 s, then at growing intervals up to a minute."""

    def __init__(self, total: int):
        self.total, self.done, self.begin = total, 0, time.monotonic()
        self.due, self.interval = self.begin + 5.0, 5.0

    def advance(self, done: int, failed: int) -> None:
        """Write a line if one is due."""
        self.done += done
        now = time.monotonic()
        if now < self.due or not self.done:
            return
        self.interval = min(1.5 * self.interval, 60.0)
        self.due = now + self.interval
        spent = now - self.begin
        left = clock(spent * (self.total - self.done) / self.done)
        say(f"{self.done:,} of {self.total:,} cases, {failed:,} failed, {clock(spent)} spent, about {left} left")


def clock(seconds: float) -> str:
    """Return a duration as '3 s', '4 min 20 s' or '5 h 10 min'."""
    if seconds < 1.0:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if not minutes:
        return f"{rest} s"
    hours, minutes_left = divmod(minutes, 60)
    return f"{hours} h {minutes_left} min" if hours else f"{minutes} min {rest} s"
