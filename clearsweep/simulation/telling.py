"""Tells how far a long run is: a line on stderr now and then, revolution by revolution."""

import sys
import time

from ..language.wording import count, duration, text
from ..mechanics.solver.event import Work

FIRST, INTERVAL = 2.0, 5.0  # s until the first line, and between lines


class TellingLife:
    """Tells how far a life is, block by block."""

    def __init__(self, limit: float):
        """Prepare for a life to a limit (m)."""
        self.limit, self.begin = limit, time.monotonic()
        self.due = self.begin + FIRST

    def say(self, blocks: int, reached: float) -> None:
        """Say how much (m) is reached with so many blocks if a line is due."""
        now = time.monotonic()
        if now >= self.due and sys.stderr is not None:
            self.due = now + INTERVAL
            line = f"{count(blocks, 'block')}, {text(reached, 'm')} of {text(self.limit, 'm')}"
            print(f"{line}, {duration(now - self.begin)} spent", file=sys.stderr, flush=True)


class Telling:
    """Watches a run and changes nothing of it."""

    parts = 1

    def __init__(self, discard: float, revolutions: float):
        """Prepare for a run of so many revolutions, of which the first `discard` are not looked at."""
        self.turns, self.revolutions = discard - 1.0, revolutions
        self.begin = time.monotonic()
        self.due = self.begin + FIRST

    def see(self, work: Work) -> bool:
        """Say how far the run is if a line is due; return False, as it does not end the run."""
        self.turns += 1.0
        now = time.monotonic()
        if now >= self.due and sys.stderr is not None:
            self.due, spent = now + INTERVAL, now - self.begin
            left = f", about {duration(spent * (self.revolutions / self.turns - 1.0))} left" if self.turns else ""
            line = f"revolution {self.turns:.6g} of {self.revolutions:.6g}, {duration(spent)} spent{left}"
            print(line, file=sys.stderr, flush=True)
        return False
