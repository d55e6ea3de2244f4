"""Many cases at once: those whose scenes are of one type are integrated side by side, as many as a register holds."""

import itertools
import time
from collections import deque
from collections.abc import Generator, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..case import Case
from ..mechanics.attempt import ARRAYS, WIDTH, lanes_of
from ..mechanics.compiled.family import NO_ENTRY, Entry
from ..mechanics.solver import loop
from ..results import Trajectory
from .run import Run
from .scene import build, signature
from .trajectory import simulating

MANY = 64  # cases of one type of scene, for which it is worth compiling their step side by side


class Lane(NamedTuple):
    """A case under way."""

    place: int  # among the cases
    course: Generator[Run, None, Trajectory]  # waits for what its run comes to
    run: Run


Ended = tuple[int, Trajectory | Exception]


def solve_each(cases: Iterable[Case]) -> Iterator[Ended]:
    """Yield the place of each case and its result, or what went wrong, as they end; each is that of the case alone."""
    kinds: dict[tuple, deque[tuple[int, Case]]] = {}
    for place, case in enumerate(cases):
        try:
            kinds.setdefault(signature(case), deque()).append((place, case))
        except Exception as error:
            yield place, error
    for waiting in kinds.values():
        yield from _Ensemble(waiting).run()


class _Ensemble:
    """Cases of one type of scene: those that wait, and up to WIDTH of them under way."""

    def __init__(self, waiting: deque[tuple[int, Case]]):
        self.waiting, self.lanes = waiting, list[Lane]()
        self.together: Entry | None = None if len(waiting) >= MANY else NO_ENTRY
        self.table = np.zeros((WIDTH, ARRAYS), dtype=np.int64)

    def run(self) -> Iterator[Ended]:
        """Yield what the cases come to."""
        while True:
            while self.waiting and len(self.lanes) < WIDTH:
                place, case = self.waiting.popleft()
                yield from self._go_on(place, _begun(case))
            if not self.lanes:
                return
            for lane in self._integrate():
                yield from self._go_on(lane.place, lane.course)

    def _go_on(self, place: int, course: Generator[Run, None, Trajectory]) -> Iterator[Ended]:
        """Let a case go on to its next integration, or yield what it came to."""
        try:
            self.lanes.append(Lane(place, course, next(course)))
        except StopIteration as end:
            yield place, end.value
        except Exception as error:
            yield place, error

    def _integrate(self) -> list[Lane]:
        """Integrate all cases under way up to where one of them or more end; return those, which are no longer here."""
        runs = [lane.run for lane in self.lanes]
        if self.together is None:
            self.together = lanes_of(runs[0].value, runs[0].parameters)
        addresses = np.array([run.kept.address for run in runs])
        status, began, clock = np.zeros(len(runs), dtype=np.int64), time.process_time(), time.perf_counter()
        loop.integrate(runs[0].kept, addresses, status, self.together, self.table)
        spent, share = time.process_time() - began, (time.perf_counter() - clock) / len(runs)
        for run in runs:
            run.duration += share
            if run.patience:
                run.patience.forgive(spent * (1.0 - 1.0 / len(runs)))
        done = [state != loop.GOING and run.ended(int(state)) for run, state in zip(runs, status, strict=True)]
        ended = list(itertools.compress(self.lanes, done))
        self.lanes = [lane for lane, over in zip(self.lanes, done, strict=True) if not over]
        return ended


def _begun(case: Case) -> Generator[Run, None, Trajectory]:
    """Build the scene of a case and simulate it; what goes wrong with the first does so with the second."""
    return (yield from simulating(build(case)))
