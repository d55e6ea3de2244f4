"""`refine`: further cases along the border between acceptable and unacceptable ones.

A box has cases at its corners.  If some meet the limits and some do not, the border crosses the box.  It is then
halved along an edge whose ends differ, which encloses the border ever more closely; the largest boxes come first.
"""

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..contracts.search import CaseResults, Found, Point, Search
from ..grid import Grid
from ..grid.keys import Number, value_key
from ..grid.sections import KeySection, Reader, WordKey, cases_key, check_always_used
from ..grid.written import WrittenValue

REFINE = "refine"
REFINE_BORDER = "limits"
MAX_CASES = 1_000_000
REFINE_SECTION = KeySection(
    REFINE,
    "further cases between those of `sweep`, along the border of `limits`",
    "{along: limits, cases: 200}",
    (
        WordKey(
            "along",
            "border along which cases are added; `limits` is the only choice",
            words=(REFINE_BORDER,),
            default=REFINE_BORDER,
        ),
        cases_key(1, MAX_CASES),
    ),
)
HALVINGS = 10  # most halvings of a grid step per axis: the border is known to a thousandth of it
STEP = 1 << HALVINGS  # divisions of a grid step
SEED = 0  # seed of the order in which boxes of equal size are halved

GridPoint = tuple[int, ...]  # position along each axis, in divisions of a grid step


@dataclasses.dataclass(frozen=True)
class RefineFound(Found):
    """Results of refining a grid."""

    asked: int  # most cases to add
    added: int
    crossed: int  # boxes of the grid that the border crosses
    whole: bool  # all crossed boxes have the smallest size

    def facts(self, catalogue: Any, record: Mapping[str, Any], judged: Any) -> dict[str, Any]:
        """Return the counts."""
        return dataclasses.asdict(self)


@dataclasses.dataclass(frozen=True)
class Refine(Search):
    """The section `refine`: the number of cases to add along the border, and the values to subdivide."""

    name: ClassVar[str] = REFINE
    keys: ClassVar[KeySection] = REFINE_SECTION
    example: ClassVar[str] = "refine: {along: limits, cases: 100}"
    answer_key: ClassVar[str] = "refined"
    has_table: ClassVar[bool] = False
    judges: ClassVar[bool] = False
    refusal_of_shards: ClassVar[str] = (
        "the cases that `refine` adds depend on all others; run the shards without `refine` and merge them, "
        "then run the grid with it in the merged directory"
    )
    cases: int  # at most
    divided: tuple[str, ...]  # swept numbers

    def resolved(self) -> dict[str, Any]:
        """Return the section in the form of a grid file."""
        return {"along": REFINE_BORDER, "cases": self.cases}

    @classmethod
    def read(cls, reader: Reader, root: WrittenValue) -> "Refine | None":
        """Return the section `refine`, or None if it is missing or wrong; the axes must have been read."""
        problems_before = len(reader.problems)
        section = REFINE_SECTION.find(reader.problems, root)
        if section is None:
            return None
        if "seek" in root.value:
            message = "conflicts with `seek`, which finds the limit automatically; remove one of the two"
            reader.problems.add(section, REFINE, message)
        if not reader.limits:
            reader.problems.add(section, REFINE, "needs limits, whose border it refines; add `limits`")
        paths = tuple(path for path in reader.axes if reader.varied_by[path] == "sweep" and _is_divisible(reader, path))
        if not paths:
            message = (
                "cannot add cases between those of the grid; `sweep` at least one quantity with two or more values"
            )
            reader.problems.add(section, REFINE, message)
        for path in reader.axes:
            check_always_used(reader, section, REFINE, path)
        REFINE_SECTION.value(reader.problems, section, "along")
        cases = REFINE_SECTION.value(reader.problems, section, "cases")
        return None if cases is None or len(reader.problems) > problems_before else Refine(cases, paths)

    def expectation(self, added: int) -> str:
        """Return that the number of cases is not known."""
        return f"up to {self.cases:,} cases that `refine` adds are not included; they depend on these results"

    def begin(self, grid: Grid, simulator: Any) -> "Refinement":
        """Return the search at work."""
        return Refinement(grid, self)


def _is_divisible(reader: Reader, path: str) -> bool:
    """Return whether an axis can be subdivided."""
    key = value_key(reader.keys_in_use, path)
    is_indivisible = not isinstance(key, Number) or any(key_use.field.integer for key_use in key.uses)
    return not is_indivisible and not path.endswith(".exponent") and len(reader.axes[path]) > 1


class _Axis:
    """The values along one axis: those of the grid in ascending order, and midpoints between them."""

    def __init__(self, values: Iterable[float]):
        self.values = sorted(values)
        self.is_geometric = _is_geometric(self.values)
        self.positions = {value: STEP * k for k, value in enumerate(self.values)}  # indices of the values in use

    def value(self, position: int) -> float:
        """Return the value at a position, computed by halving for the same bits on every machine."""
        k, remainder = divmod(position, STEP)
        if not remainder:
            return self.values[k]
        (low, high), (begin, end) = self.values[k : k + 2], (0, STEP)
        while True:
            centre = (begin + end) // 2
            between = math.sqrt(low) * math.sqrt(high) if self.is_geometric else 0.5 * low + 0.5 * high
            if centre == remainder:
                self.positions[between] = position
                return between
            if remainder < centre:
                high, end = between, centre
            else:
                low, begin = between, centre


def _is_geometric(values: Sequence[float]) -> bool:
    """Return whether ascending values are closer to a geometric than to an arithmetic sequence."""
    if values[0] <= 0.0:
        return False
    steps, ratios = np.diff(values), np.diff(np.log(values))
    return bool(ratios.std() / ratios.mean() < steps.std() / steps.mean())


class _Box(NamedTuple):
    """A box of the grid or a part of one, for one combination of the other axes."""

    group: int
    low: GridPoint
    size: GridPoint

    def corners(self) -> list[GridPoint]:
        """Return the positions of the corners; the last axis varies fastest."""
        sides = ((low, low + size) for low, size in zip(self.low, self.size, strict=True))
        return list(itertools.product(*sides))

    def edges(self, axis: int) -> list[tuple[GridPoint, GridPoint]]:
        """Return the positions of both ends of the edges along an axis."""
        lower_corners = [corner for corner in self.corners() if corner[axis] == self.low[axis]]
        return [(corner, _shifted(corner, axis, self.size[axis])) for corner in lower_corners]

    def halves(self, axis: int) -> tuple["_Box", "_Box"]:
        """Return both halves along an axis."""
        half = self.size[axis] // 2
        size = (*self.size[:axis], half, *self.size[axis + 1 :])
        return self._replace(size=size), _Box(self.group, _shifted(self.low, axis, half), size)


def _shifted(position: GridPoint, axis: int, offset: int) -> GridPoint:
    return (*position[:axis], position[axis] + offset, *position[axis + 1 :])


class Refinement:
    """One refinement, round by round."""

    def __init__(self, grid: Grid, refine: Refine):
        self.refine = refine
        self.axes = [_Axis(grid.axes[path]) for path in refine.divided]
        self.group_numbers: dict[tuple, int] = {}  # values of the other axes -> their number
        self.points: list[Point] = []  # these values by path, by number
        self.grid_is_good = np.zeros(0, bool)  # whether grid cases are acceptable: (others, values of each axis)
        self.added_is_good: dict[tuple[int, GridPoint], bool] = {}  # the same for added cases, by number and position
        self.boxes: list[_Box] = []  # boxes that the border crosses
        self.halved: list[tuple[_Box, int]] = []  # boxes whose halves must be examined, and the axis of halving
        self.crossed, self.added_count, self.is_incomplete = 0, 0, False

    def record(self, grid: Grid, first_index: int, results: CaseResults) -> None:
        """Record how the cases of a grid, from the index `first_index` on, compare to its limits."""
        keys = [self._key(grid.point(index)) for index in range(first_index, len(grid))]
        is_good = [status == "ok" and not names for status, names in zip(results.status, results.unmet, strict=True)]
        if first_index:
            self.added_is_good |= dict(zip(keys, is_good, strict=True))
            self._keep_crossed_halves()
        else:
            self.grid_is_good = np.zeros((len(self.points), *(len(axis.values) for axis in self.axes)), bool)
            for (group, position), case_is_good in zip(keys, is_good, strict=True):
                self.grid_is_good[group, *(coordinate // STEP for coordinate in position)] = case_is_good
            self.boxes = self._boxes_of_grid()
            self.crossed = len(self.boxes)

    def ask(self) -> list[Point]:
        """Return the points of the next cases, in the largest boxes that the border crosses."""
        requested: dict[tuple[int, GridPoint], None] = {}
        while self.boxes and not requested:
            largest = max(math.prod(box.size) for box in self.boxes)
            largest_boxes = [box for box in self.boxes if math.prod(box.size) == largest]
            self.boxes = [box for box in self.boxes if math.prod(box.size) < largest]
            for number in np.random.default_rng(SEED).permutation(len(largest_boxes)).tolist():
                self._halve(largest_boxes[number], requested)
            if not requested:  # all corners of the halves are known
                self._keep_crossed_halves()
        self.added_count += len(requested)
        return [self._point(*key) for key in requested]

    def result(self) -> RefineFound:
        """Return the results, at the end."""
        return RefineFound(self.refine.cases, self.added_count, self.crossed, whole=not self.is_incomplete)

    def _halve(self, box: _Box, requested: dict[tuple[int, GridPoint], None]) -> None:
        """Halve a box, unless it has the smallest size or too few cases are left."""
        # those with an edge whose ends differ
        axes = [
            axis
            for axis, size in enumerate(box.size)
            if size > 1
            and any(self._is_good(box.group, a) is not self._is_good(box.group, b) for a, b in box.edges(axis))
        ]
        if not axes:
            return
        axis = max(axes, key=lambda candidate: box.size[candidate])
        corners = [(box.group, corner) for half in box.halves(axis) for corner in half.corners()]
        unknown = dict.fromkeys(key for key in corners if key not in requested and self._is_good(*key) is None)
        if self.added_count + len(requested) + len(unknown) > self.refine.cases:
            self.is_incomplete = True
        else:
            requested |= unknown
            self.halved.append((box, axis))

    def _keep_crossed_halves(self) -> None:
        """Keep the halves that the border crosses."""
        halves = (half for box, axis in self.halved for half in box.halves(axis))
        self.boxes += [
            half for half in halves if len({self._is_good(half.group, corner) for corner in half.corners()}) == 2
        ]
        self.halved = []

    def _boxes_of_grid(self) -> list[_Box]:
        """Return the boxes between cases of the grid that the border crosses."""
        all_good, any_good = self.grid_is_good, self.grid_is_good
        for axis in range(1, self.grid_is_good.ndim):
            low, high = ((slice(None),) * axis + (selection,) for selection in (slice(None, -1), slice(1, None)))
            all_good, any_good = all_good[low] & all_good[high], any_good[low] | any_good[high]
        crossed = np.argwhere(any_good & ~all_good).tolist()
        return [_Box(j, tuple(STEP * k for k in corner), (STEP,) * len(corner)) for j, *corner in crossed]

    def _is_good(self, group: int, position: GridPoint) -> bool | None:
        """Return whether the case at a position meets the limits, or None if it was not run."""
        if any(coordinate % STEP for coordinate in position):
            return self.added_is_good.get((group, position))
        return bool(self.grid_is_good[group, *(coordinate // STEP for coordinate in position)])

    def _key(self, point: Point) -> tuple[int, GridPoint]:
        position = tuple(
            axis.positions[point.pop(path)] for path, axis in zip(self.refine.divided, self.axes, strict=True)
        )
        number = self.group_numbers.setdefault(tuple(point.values()), len(self.group_numbers))
        if number == len(self.points):
            self.points.append(point)
        return number, position

    def _point(self, group: int, position: GridPoint) -> Point:
        values = {
            path: axis.value(coordinate)
            for path, axis, coordinate in zip(self.refine.divided, self.axes, position, strict=True)
        }
        return self.points[group] | values
