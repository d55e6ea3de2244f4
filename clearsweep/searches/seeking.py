"""Finds the largest or smallest value at which cases meet their limits: the next cases to run, and the answers."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from .. import store
from ..grid import Grid, Seek
from .adaptive import Point
from .bisection import Border, scan_indices, search


class Answer(NamedTuple):
    """Answer for one case of the other axes, or for the worst of them, in SI."""

    point: Point
    value: float | None  # last safe value; None: no value is safe
    low: float | None
    high: float | None
    limiting: str | None  # column of the first exceeded limit, or the status of a failed case
    probes: int
    fits: bool = False  # the search was among fits
    fit: str | None = None  # the fit at `value`
    beyond: tuple[str, ...] = ()  # fits beyond the border that nevertheless meet the limits
    best: tuple[dict[str, Any], ...] = ()  # if no value meets the limits: how near each case comes


class _Probe(NamedTuple):
    is_good: bool
    margin: float  # margin to the limits; minus infinity for a failed case
    limiting: str | None
    margins: Mapping[str, float]  # by limited column


class SeekSearch:
    """One search, round by round."""

    def __init__(self, grid: Grid):
        assert grid.seek is not None  # only for grids that have the section
        self.seek = grid.seek
        self.other_points = _other_points(grid, self.seek)
        self.index_of = {tuple(point.values()): j for j, point in enumerate(self.other_points)}
        subjects = range(len(self.other_points))
        self.subjects = [(j,) for j in subjects] if self.seek.is_per_case else [tuple(subjects)]
        self.probes: list[dict[int, _Probe]] = [{} for _ in self.other_points]  # for each: index -> probe
        self.indices = {self.seek.value(index): index for index in self._first_indices()}  # value -> index

    def _first_indices(self) -> tuple[int, ...]:
        return tuple(range(self.seek.last_index + 1)) if self.seek.fits else scan_indices(self.seek.last_index)

    def learn(self, grid: Grid, first_index: int, results: store.CaseResults) -> None:
        """Record how the cases of a grid, from the index `first_index` on, compare to its limits."""
        for index in range(first_index, len(grid)):
            point = grid.point(index)
            value_index = self.indices[[point.pop(path) for path in self.seek.paths].pop()]
            self.probes[self.index_of[tuple(point.values())]][value_index] = _probe(results, index - first_index)

    def next_points(self) -> list[Point]:
        """Return the points of the next cases."""
        return [self._point(*probe) for probe in dict.fromkeys(self._next_probes())]

    def answers(self) -> list[Answer]:
        """Return the answers of a finished search: one for each case of the other axes, or one for all."""
        return [self._answer(subject) for subject in self.subjects]

    def _next_probes(self) -> Iterator[tuple[int, int]]:
        for subject in () if self.seek.fits else self.subjects:  # all fits are tried at once
            for index in search(self._outcomes(subject), self.seek.last_index).probes:
                yield from ((j, index) for j in subject)

    def _outcomes(self, subject: tuple[int, ...]) -> dict[int, bool]:
        """Return index -> whether all cases there meet their limits."""
        return {index: all(self.probes[j][index].is_good for j in subject) for index in self.probes[subject[0]]}

    def _point(self, j: int, index: int) -> Point:
        value = self.seek.value(index)
        self.indices[value] = index
        return self.other_points[j] | dict.fromkeys(self.seek.paths, value)

    def _answer(self, subject: tuple[int, ...]) -> Answer:
        """Return the answer from the probes of some cases of the other axes."""
        outcomes, seek = self._outcomes(subject), self.seek
        border = border_of_all(outcomes, seek.last_index) if seek.fits else search(outcomes, seek.last_index).border
        assert border is not None  # the search is finished
        deciding = _deciding_index(outcomes, border, seek.last_index)
        worst = min(subject, key=lambda j: (self.probes[j][deciding].margin, j))
        limiting = None if outcomes[deciding] else self.probes[worst][deciding].limiting
        point = self.other_points[worst]
        if border.last_good is None:
            nearest = max(outcomes, key=lambda index: (min(self.probes[j][index].margin for j in subject), -index))
            best = tuple(self._best(j, nearest) for j in subject)
            probe_count = len(outcomes) * len(subject)
            return Answer(point, None, None, None, limiting, probe_count, fits=bool(seek.fits), best=best)
        last_good = seek.value(border.last_good)
        first_bad = seek.value(seek.last_index if border.first_bad is None else border.first_bad)
        answer = Answer(
            point,
            last_good,
            min(last_good, first_bad),
            max(last_good, first_bad),
            limiting,
            len(outcomes) * len(subject),
        )
        if not seek.fits:
            return answer
        passing_beyond = tuple(
            seek.fit(index).name for index in sorted(outcomes) if outcomes[index] and index > border.last_good
        )
        return answer._replace(fits=True, fit=seek.fit(border.last_good).name, beyond=passing_beyond)

    def _best(self, j: int, index: int) -> dict[str, Any]:
        """Return the best margin for one combination of the other axes, and the limiting column there."""
        probe = self.probes[j][index]
        finite = np.isfinite(probe.margin)
        return {
            "point": self.other_points[j],
            "value": self.seek.value(index),
            "fit": self.seek.fit(index).name if self.seek.fits else None,
            "margin": probe.margin if finite else None,
            "limiting": probe.limiting,
            "margins": {name: margin for name, margin in probe.margins.items() if np.isfinite(margin)},
        }


def _deciding_index(outcomes: dict[int, bool], border: Border, last_index: int) -> int:
    """Return the index that determines the limiting column: the first bad one beyond the border."""
    if border.last_good is None:
        return min((index for index, is_good in outcomes.items() if not is_good), default=0)
    return min(
        (index for index, is_good in outcomes.items() if index > border.last_good and not is_good), default=last_index
    )


def border_of_all(outcomes: Mapping[int, bool], last_index: int) -> Border:
    """Return the border if all indices from 0 to `last_index` are known: it is before the first bad one."""
    first_good = next((index for index in range(last_index + 1) if outcomes[index]), None)
    if first_good is None:
        return Border(None, 0)
    first_bad = next((index for index in range(first_good, last_index + 1) if not outcomes[index]), None)
    return Border(last_index if first_bad is None else first_bad - 1, first_bad)


def _other_points(grid: Grid, seek: Seek) -> list[Point]:
    """Return the values of all axes except the searched one, for each combination."""
    points = (grid.point(index) for index in range(len(grid)))
    other_points = (tuple((path, value) for path, value in point.items() if path not in seek.paths) for point in points)
    return [dict(point) for point in dict.fromkeys(other_points)]


def _probe(results: store.CaseResults, index: int) -> _Probe:
    """Return the probe of the case at an index of a grid."""
    status = results.status[index]
    if status != "ok":
        return _Probe(is_good=False, margin=-np.inf, limiting=status, margins={})
    margins = {name: values[index] for name, values in results.margins.items()}
    unmet = [name for name in results.unmet[index].split(",") if name]
    worst = min(unmet, key=lambda name: np.nan_to_num(margins[name], nan=-np.inf), default=None)
    finite = [margin for margin in margins.values() if not np.isnan(margin)]
    return _Probe(is_good=not unmet, margin=float(min(finite, default=np.inf)), limiting=worst, margins=margins)
