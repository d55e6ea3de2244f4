"""Adds cases along the border between acceptable and unacceptable ones, by halving the boxes that it crosses.

A box has cases at its corners.  If some meet the limits and some do not, the border crosses the box.  It is then
halved along an edge whose ends differ, which encloses the border ever more closely; the largest boxes come first.
"""

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from .. import store
from ..grid import Grid
from .adaptive import Point

HALVINGS = 10  # most halvings of a grid step per axis: the border is known to a thousandth of it
STEP = 1 << HALVINGS  # divisions of a grid step
SEED = 0  # seed of the order in which boxes of equal size are halved

GridPoint = tuple[int, ...]  # position along each axis, in divisions of a grid step


class Refined(NamedTuple):
    """Results of refining a grid."""

    asked: int  # most cases to add
    added: int
    crossed: int  # boxes of the grid that the border crosses
    whole: bool  # all crossed boxes have the smallest size


class _Axis:
    """The values along one axis: those of the grid in ascending order, and midpoints between them."""

    def __init__(self, values: Iterable[float]):
        self.values = sorted(values)
        self.geometric = _geometric(self.values)
        self.places = {value: STEP * k for k, value in enumerate(self.values)}  # indices of the values in use

    def value(self, place: int) -> float:
        """Return the value at a position, computed by halving for the same bits on every machine."""
        k, rest = divmod(place, STEP)
        if not rest:
            return self.values[k]
        (low, high), (first, last) = self.values[k : k + 2], (0, STEP)
        while True:
            middle = (first + last) // 2
            between = math.sqrt(low) * math.sqrt(high) if self.geometric else 0.5 * low + 0.5 * high
            if middle == rest:
                self.places[between] = place
                return between
            if rest < middle:
                high, last = between, middle
            else:
                low, first = between, middle


def _geometric(values: Sequence[float]) -> bool:
    """Return whether ascending values are closer to a geometric than to an arithmetic sequence."""
    if values[0] <= 0.0:
        return False
    steps, ratios = np.diff(values), np.diff(np.log(values))
    return bool(ratios.std() / ratios.mean() < steps.std() / steps.mean())


class _Box(NamedTuple):
    """A box of the grid or a part of one, for one combination of the other axes."""

    other: int
    low: GridPoint
    size: GridPoint

    def corners(self) -> list[GridPoint]:
        """Return the positions of the corners; the last axis varies fastest."""
        ends = ((low, low + size) for low, size in zip(self.low, self.size, strict=True))
        return list(itertools.product(*ends))

    def edges(self, axis: int) -> list[tuple[GridPoint, GridPoint]]:
        """Return the positions of both ends of the edges along an axis."""
        first = [corner for corner in self.corners() if corner[axis] == self.low[axis]]
        return [(corner, _shifted(corner, axis, self.size[axis])) for corner in first]

    def halves(self, axis: int) -> tuple["_Box", "_Box"]:
        """Return both halves along an axis."""
        half = self.size[axis] // 2
        size = (*self.size[:axis], half, *self.size[axis + 1 :])
        return self._replace(size=size), _Box(self.other, _shifted(self.low, axis, half), size)


def _shifted(place: GridPoint, axis: int, by: int) -> GridPoint:
    return (*place[:axis], place[axis] + by, *place[axis + 1 :])


class Refining:
    """One refinement, round by round."""

    def __init__(self, grid: Grid):
        assert grid.refine is not None  # only for grids that have the section
        self.refine = grid.refine
        self.axes = [_Axis(grid.axes[path]) for path in self.refine.paths]
        self.numbers: dict[tuple, int] = {}  # values of the other axes -> their number
        self.points: list[Point] = []  # these values by path, by number
        self.of_grid = np.zeros(0, bool)  # whether grid cases are acceptable: (others, values of each axis)
        self.between: dict[tuple[int, GridPoint], bool] = {}  # the same for added cases, by number and position
        self.boxes: list[_Box] = []  # boxes that the border crosses
        self.halved: list[tuple[_Box, int]] = []  # boxes whose halves must be examined, and the axis of halving
        self.crossed, self.added, self.left = 0, 0, False

    def learn(self, grid: Grid, first: int, results: store.CaseResults) -> None:
        """Record how the cases of a grid, from the index `first` on, compare to its limits."""
        keys = [self._key(grid.point(index)) for index in range(first, len(grid))]
        good = [status == "ok" and not names for status, names in zip(results.status, results.exceeded, strict=True)]
        if first:
            self.between |= dict(zip(keys, good, strict=True))
            self._look_at_halves()
        else:
            self.of_grid = np.zeros((len(self.points), *(len(axis.values) for axis in self.axes)), bool)
            for (other, place), each in zip(keys, good, strict=True):
                self.of_grid[other, *(part // STEP for part in place)] = each
            self.boxes = self._boxes_of_grid()
            self.crossed = len(self.boxes)

    def wanted(self) -> list[Point]:
        """Return the points of the next cases, in the largest boxes that the border crosses."""
        asked: dict[tuple[int, GridPoint], None] = {}
        while self.boxes and not asked:
            largest = max(math.prod(box.size) for box in self.boxes)
            now = [box for box in self.boxes if math.prod(box.size) == largest]
            self.boxes = [box for box in self.boxes if math.prod(box.size) < largest]
            for number in np.random.default_rng(SEED).permutation(len(now)).tolist():
                self._halve(now[number], asked)
            if not asked:  # all corners of the halves are known
                self._look_at_halves()
        self.added += len(asked)
        return [self._point(*key) for key in asked]

    def result(self) -> Refined:
        """Return the results, at the end."""
        return Refined(self.refine.cases, self.added, self.crossed, whole=not self.left)

    def _halve(self, box: _Box, asked: dict[tuple[int, GridPoint], None]) -> None:
        """Halve a box, unless it has the smallest size or too few cases are left."""
        axes = [axis for axis, size in enumerate(box.size) if size > 1 and self._differ(box, axis)]
        if not axes:
            return
        axis = max(axes, key=lambda each: box.size[each])
        corners = [(box.other, corner) for half in box.halves(axis) for corner in half.corners()]
        new = dict.fromkeys(key for key in corners if key not in asked and self._good(*key) is None)
        if self.added + len(asked) + len(new) > self.refine.cases:
            self.left = True
        else:
            asked |= new
            self.halved.append((box, axis))

    def _look_at_halves(self) -> None:
        """Keep the halves that the border crosses."""
        halves = (half for box, axis in self.halved for half in box.halves(axis))
        self.boxes += [
            half for half in halves if len({self._good(half.other, corner) for corner in half.corners()}) == 2
        ]
        self.halved = []

    def _boxes_of_grid(self) -> list[_Box]:
        """Return the boxes between cases of the grid that the border crosses."""
        all_good, any_good = self.of_grid, self.of_grid
        for axis in range(1, self.of_grid.ndim):
            low, high = ((slice(None),) * axis + (part,) for part in (slice(None, -1), slice(1, None)))
            all_good, any_good = all_good[low] & all_good[high], any_good[low] | any_good[high]
        crossed = np.argwhere(any_good & ~all_good).tolist()
        return [_Box(j, tuple(STEP * k for k in places), (STEP,) * len(places)) for j, *places in crossed]

    def _differ(self, box: _Box, axis: int) -> bool:
        """Return whether the ends of an edge along an axis differ."""
        return any(self._good(box.other, a) is not self._good(box.other, b) for a, b in box.edges(axis))

    def _good(self, other: int, place: GridPoint) -> bool | None:
        """Return whether the case at a position meets the limits, or None if it was not run."""
        if any(part % STEP for part in place):
            return self.between.get((other, place))
        return bool(self.of_grid[other, *(part // STEP for part in place)])

    def _key(self, point: Point) -> tuple[int, GridPoint]:
        place = tuple(axis.places[point.pop(path)] for path, axis in zip(self.refine.paths, self.axes, strict=True))
        number = self.numbers.setdefault(tuple(point.values()), len(self.numbers))
        if number == len(self.points):
            self.points.append(point)
        return number, place

    def _point(self, other: int, place: GridPoint) -> Point:
        values = {path: axis.value(part) for path, axis, part in zip(self.refine.paths, self.axes, place, strict=True)}
        return self.points[other] | values
