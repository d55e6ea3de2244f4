"""Finds the largest or smallest value with which cases keep to their limits: which cases to run next, and the answers.

Its probes are cases like any others, so what was stored before is not run again, and the same probes give the same
answers however often the run was interrupted.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from .. import store
from ..grid import Grid, Seek
from .bracket import Border, search

Point = dict[str, Any]  # dotted path -> value of the other axes
#: Runs what is missing of a grid and judges its cases from an index on; None where it was stopped.
Look = Callable[[Grid, int], store.Judged | None]


class Answer(NamedTuple):
    """What was found for one case of the other axes, or for the worst of them; SI."""

    point: Point
    value: float | None  # the last one that is safe; None: none is
    low: float | None
    high: float | None
    limiting: str | None  # the column whose limit is exceeded first, or the status of a case that failed
    probes: int


class _Probe(NamedTuple):
    good: bool
    margin: float  # of the limits; minus infinity of a failed case
    limiting: str | None


class Seeking:
    """One search, round by round."""

    def __init__(self, grid: Grid):
        assert grid.seek is not None  # it is asked for
        self.grid, self.seek = grid, grid.seek
        self.others = _others(grid, self.seek)
        every = range(len(self.others))
        self.subjects = [(j,) for j in every] if self.seek.each else [tuple(every)]
        self.probes: list[dict[int, _Probe]] = [{} for _ in self.others]  # of each: place -> what it gave
        self.stopped = False

    def run(self, look: Look) -> Grid:
        """Run round after round by `look`; return the grid of all cases that were looked at."""
        asked: dict[tuple[int, int], None] = {}
        grid = self.grid
        while wanted := list(self._wanted()):
            asked.update(dict.fromkeys(wanted))
            grid = self.grid.at([self._point(*probe) for probe in asked])
            judged = look(grid, len(asked) - len(wanted))
            if judged is None:
                self.stopped = True
                break
            for index, (j, place) in enumerate(wanted):
                self.probes[j][place] = _probe(judged, index)
        return grid

    def answers(self) -> list[Answer]:
        """Return what was found: one for each case of the other axes, or one for all; none of a search that stopped."""
        return [] if self.stopped else [self._answer(subject) for subject in self.subjects]

    def _wanted(self) -> Iterator[tuple[int, int]]:
        """Yield the probes to look at next."""
        for subject in self.subjects:
            for place in search(self._known(subject), self.seek.last).wanted:
                yield from ((j, place) for j in subject)

    def _known(self, subject: tuple[int, ...]) -> dict[int, bool]:
        """Return place -> whether all cases there keep to their limits."""
        return {place: all(self.probes[j][place].good for j in subject) for place in self.probes[subject[0]]}

    def _point(self, j: int, place: int) -> Point:
        return self.others[j] | {self.seek.path: self.seek.value(place)}

    def _answer(self, subject: tuple[int, ...]) -> Answer:
        """Return what the probes of some cases of the other axes say."""
        known, seek = self._known(subject), self.seek
        border = search(known, seek.last).border
        assert border is not None  # nothing is wanted any more
        at = _deciding(known, border, seek.last)
        worst = min(subject, key=lambda j: (self.probes[j][at].margin, j))
        limiting = None if known[at] else self.probes[worst][at].limiting
        point = self.others[worst]
        if border.good is None:
            return Answer(point, None, None, None, limiting, len(known) * len(subject))
        good = seek.value(border.good)
        bad = seek.value(seek.last if border.bad is None else border.bad)
        return Answer(point, good, min(good, bad), max(good, bad), limiting, len(known) * len(subject))


def _deciding(known: dict[int, bool], border: Border, last: int) -> int:
    """Return the place that tells what the limiting column is: the first bad one beyond the border."""
    if border.good is None:
        return 0
    return min((place for place, good in known.items() if place > border.good and not good), default=last)


def _others(grid: Grid, seek: Seek) -> list[Point]:
    """Return the values of all axes but the one that is sought, of every case of these."""
    points = (grid.point(index) for index in range(len(grid)))
    found = (tuple((path, value) for path, value in point.items() if path != seek.path) for point in points)
    return [dict(point) for point in dict.fromkeys(found)]


def _probe(judged: store.Judged, index: int) -> _Probe:
    """Return what the case at an index of a grid gave."""
    status = judged.status[index]
    if status != "ok":
        return _Probe(good=False, margin=-np.inf, limiting=status)
    margins = {name: values[index] for name, values in judged.margins.items()}
    exceeded = [name for name in judged.exceeded[index].split(",") if name]
    worst = min(exceeded, key=lambda name: np.nan_to_num(margins[name], nan=-np.inf), default=None)
    finite = [margin for margin in margins.values() if not np.isnan(margin)]
    return _Probe(good=not exceeded, margin=float(min(finite, default=np.inf)), limiting=worst)
