"""What searches are made of: halvings of an interval, choices among values, and what helps where `seek` finds none."""

import hashlib
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from importlib import util
from typing import Any, ClassVar, NamedTuple, Self

from .. import grid as grids
from ..answers.verdict import KINDS, MARGIN_COLUMN, Limit, limits_and_figures_of, units_of
from ..contracts.catalogue import CHOICE
from ..contracts.search import FurtherRuns, Rounds, Search
from ..grid.keys import Number
from ..grid.sections import CountKey, Reader, check_always_used
from ..grid.written import AXIS_SECTIONS, MistakeError, WrittenValue
from ..language import np, phases, quantity
from ..language.errors import InputError, mistake_of

# ----------------------------------------------------------------------------------------------------------------------
# Finds the border in a sequence of values that begins with good ones: the next values to try, and the answer.
#
# Values are addressed by index.  Near the border the motion is chaotic, so good and bad values may alternate.
# Hence a scan and bisection enclose it; then neighbours on both sides are examined until AGREEING_NEIGHBOURS of them
# in a row agree, further away each time they do not.  Good values beyond the first bad one of the scan do not count.


SCAN_INTERVALS = 4  # equal intervals whose ends are examined first
AGREEING_NEIGHBOURS = 2  # neighbours on each side that must agree with the border

Outcomes = Mapping[int, bool]  # index -> whether it is good


class Border(NamedTuple):
    """The end of the good values, by index."""

    last_good: int | None  # last index up to which all examined ones are good; None: none is
    first_bad: int | None  # index after the border that is bad like its next neighbours; None: the last index is good


class Bisection(NamedTuple):
    """State of a search: the next indices to try, or the answer."""

    probes: tuple[int, ...] = ()
    border: Border | None = None


def scan_indices(last_index: int) -> tuple[int, ...]:
    """Return the first indices to examine, of 0 to `last_index`, a power of 2."""
    return tuple(range(0, last_index + 1, max(last_index // SCAN_INTERVALS, 1)))


def expected_probe_count(last_index: int) -> int:
    """Return how many indices of 0 to `last_index` are examined if the border is sharp."""
    return len(scan_indices(last_index)) + int(math.log2(last_index / SCAN_INTERVALS)) + 2 * AGREEING_NEIGHBOURS


def search(outcomes: Outcomes, last_index: int) -> Bisection:
    """Return the next indices of 0 to `last_index` to examine, or the border; it depends only on `outcomes`."""
    scanned = scan_indices(last_index)
    if untested := _untested(scanned, outcomes):
        return Bisection(untested)
    first_good = next((index for index in scanned if outcomes[index]), None)
    if first_good is None:
        return Bisection((), Border(None, 0))
    first_bad = next((index for index in scanned if index > first_good and not outcomes[index]), None)
    last_good = max(index for index in scanned if index >= first_good and (first_bad is None or index < first_bad))
    while first_bad is not None and first_bad - last_good > 1:
        middle = (last_good + first_bad) // 2
        if middle not in outcomes:
            return Bisection((middle,))
        last_good, first_bad = (middle, first_bad) if outcomes[middle] else (last_good, middle)
    lower = _first_agreeing(outcomes, last_good, -1, first_good)
    upper = _first_agreeing(outcomes, first_bad, 1, last_index)
    if untested := (*lower.probes, *upper.probes):
        return Bisection(tuple(sorted(set(untested))))
    return Bisection((), Border(lower.position, upper.position))


class _BorderSide(NamedTuple):
    probes: tuple[int, ...] = ()
    position: int | None = None


def _first_agreeing(outcomes: Outcomes, index: int | None, step: int, end: int) -> _BorderSide:
    """Return the first index from `index` towards `end` whose next AGREEING_NEIGHBOURS neighbours agree with it.

    Below the border (`step` -1) values must be good, above it bad.  None if the sequence ends earlier.
    """
    stride = 1
    while index is not None and (end - index) * step >= 0:
        if index not in outcomes:
            return _BorderSide((index,))
        neighbours = [index + step * k for k in range(1, AGREEING_NEIGHBOURS + 1) if (end - index) * step >= k]
        if outcomes[index] is (step < 0):
            if untested := _untested(neighbours, outcomes):
                return _BorderSide(untested)
            disagreeing = [neighbour for neighbour in neighbours if outcomes[neighbour] is not outcomes[index]]
            if not disagreeing:
                return _BorderSide((), index)
            index = disagreeing[-1]
        index += step * stride
        stride *= 2
    return _BorderSide()


def _untested(indices: tuple[int, ...] | list[int], outcomes: Outcomes) -> tuple[int, ...]:
    return tuple(index for index in indices if index not in outcomes)


def deciding_index(outcomes: Outcomes, border: Border, last_index: int) -> int:
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


# ----------------------------------------------------------------------------------------------------------------------
# Values that a search may choose, and searches that choose all cases themselves: `optimise` and `identify`.


AMONG, WHOLE = "among", "whole"
ROUND_SIZE = 16  # cases that are asked for at a time, whatever the number of workers
#: Ratio of the ends of a range from which on equal ratios count, not equal differences.
LOG_SCALE_RATIOS = {"range": 20.0, "prior": 4.0}
SEED_KEY = CountKey("seed", "a whole number, default 0", low=0, high=2**31, default=0)
MISSING_OVER_TEXT = "; name at least one key to vary"


class Choice(NamedTuple):
    """The values that one path may take, SI."""

    kind: str  # 'range', 'prior', AMONG or WHOLE
    values: tuple[Any, ...]  # both ends of a range, or all that there are to choose from

    @property
    def is_logarithmic(self) -> bool:
        """Return whether the scale of the choice is logarithmic."""
        low, high = self.values[0], self.values[-1]
        return self.kind in LOG_SCALE_RATIOS and low > 0.0 and high >= LOG_SCALE_RATIOS[self.kind] * low

    def value_at(self, fraction: float) -> Any:
        """Return the value at a fraction (0 to 1) of the choice."""
        if self.kind == AMONG:
            return self.values[min(int(fraction * len(self.values)), len(self.values) - 1)]
        low, high = self.values
        if self.kind == WHOLE:
            return min(low + int(fraction * (high - low + 1)), high)
        return low * (high / low) ** fraction if self.is_logarithmic else low + (high - low) * fraction

    def fraction_of(self, value: Any) -> float:
        """Return the fraction (0 to 1) of a value in the choice; for one of several values, the middle of its share."""
        if self.kind == AMONG:
            return (self.values.index(value) + 0.5) / len(self.values)
        low, high = self.values
        if self.kind == WHOLE:
            return float((value - low + 0.5) / (high - low + 1))
        return math.log(value / low) / math.log(high / low) if self.is_logarithmic else (value - low) / (high - low)

    def resolved(self) -> Any:
        """Return the choice in the form of a grid file."""
        return list(self.values) if self.kind in LOG_SCALE_RATIOS else {self.kind: list(self.values)}


@dataclass(frozen=True)
class SearchOver(Search):
    """A search that chooses all cases itself: its section has `over`, a number of cases and a seed."""

    conflicts: ClassVar[tuple[str, ...]]  # sections that also choose cases
    seconds_per_choice: ClassVar[float]  # s for choosing a case; one process chooses
    library: ClassVar[tuple[str, str]]  # module and name of what chooses, which is an optional dependency
    at_work: ClassVar[Callable[..., Any]]  # the search at work, from the section
    over: dict[str, Choice]
    cases: int
    seed: int
    start: dict[str, Any]  # the values that the grid has written, or {} if some are missing or outside

    @property
    def varied_paths(self) -> tuple[str, ...]:
        """Return the paths to vary."""
        return tuple(self.over)

    @property
    def start_values(self) -> dict[str, Any]:
        """Return the values that the grid has written."""
        return self.start

    def expected_cases(self, grid: Any) -> tuple[int, float]:
        """Return the remaining cases."""
        return max(self.cases - len(grid), 0), self.seconds_per_choice

    def sobol_points(self, skipped: int, count: int) -> "np.ndarray":
        """Return points (count, paths) of a Sobol sequence in the unit cube, without the first `skipped` points."""
        from scipy.stats import qmc

        sequence = qmc.Sobol(len(self.over), seed=self.seed)
        points: np.ndarray = (sequence.fast_forward(skipped) if skipped else sequence).random(count)
        return points

    def point(self, fractions: "np.ndarray") -> dict[str, Any]:
        """Return the values at a point (paths,) of the unit cube."""
        choices = zip(self.over.items(), fractions.tolist(), strict=True)
        return {path: choice.value_at(fraction) for (path, choice), fraction in choices}

    def first_points(self) -> list[tuple[Any, ...]]:
        """Return the points of the first round that are not evenly spread."""
        return []

    def first(self) -> dict[str, tuple[Any, ...]]:
        """Return the values of the first round: those of `first_points`, and evenly spread ones."""
        spread = [tuple(self.point(fractions).values()) for fractions in self.sobol_points(0, ROUND_SIZE)]
        distinct = list(dict.fromkeys([*self.first_points(), *spread]))[: min(ROUND_SIZE, self.cases)]
        return dict(zip(self.over, zip(*distinct, strict=True), strict=True))

    def resolved_fields(self) -> dict[str, Any]:
        """Return the further fields of the section in the form of a grid file, in SI."""
        raise NotImplementedError

    def resolved(self) -> dict[str, Any]:
        """Return the section in the form of a grid file, in SI."""
        over = {path: choice.resolved() for path, choice in self.over.items()}
        return {"over": over, **self.resolved_fields(), "cases": self.cases, "seed": self.seed}

    def begin(self, grid: Any, simulator: Any) -> Rounds:
        """Return the search at work; raise InputError without the library that chooses."""
        module, library = self.library
        if util.find_spec(module) is None:
            remedy = f"run `pip install 'clearsweep[{self.name}]'`"
            raise InputError(f"{self.name}: needs {library}, which is not installed; {remedy}")
        begun: Rounds = self.at_work(self)
        return begun

    @classmethod
    def axes(cls, reader: Reader, root: WrittenValue) -> dict[str, tuple[WrittenValue, WrittenValue]]:
        """Return path -> (position, values in the form of an axis) of the keys to vary; record the kinds of choices."""
        section = cls.keys.find(reader.problems, root)
        if section is None:
            return {}
        for conflict in cls.conflicts:
            if conflict in root.value:
                message = f"conflicts with `{conflict}`; `{cls.name}` chooses all cases itself; remove one of the two"
                raise MistakeError(section, cls.name, message)
        over = cls.keys.value(reader.problems, section, "over")
        axes = {}
        for key, written in over.value.items() if over else ():
            if choice := cls.read_choice(reader, key, written):
                path, values = choice
                axes[path] = (over.key_position(key), values)
        return axes

    @classmethod
    def read_choice(cls, reader: Reader, key: str, written: WrittenValue) -> tuple[str, WrittenValue] | None:
        """Return path and values of an entry of `over`, and record the kind of its choice; report mistakes."""
        raise NotImplementedError

    @classmethod
    def read(cls, reader: Reader, root: WrittenValue) -> Self | None:
        """Return the section, or None if it is missing or wrong; the axes must have been read."""
        section = root.value.get(cls.name)
        paths = [path for path, section_name in reader.varied_by.items() if section_name == cls.name]
        if section is None or not isinstance(section.value, dict):
            return None
        problems_before = len(reader.problems)
        for path in reader.axes.keys() & {*paths}:
            check_range(reader, path, cls.name)
            check_always_used(reader, reader.written_axes[path], cls.name, path)
        own_fields = cls.read_own(reader, section)
        cases, seed = (cls.keys.value(reader.problems, section, key) for key in ("cases", "seed"))
        if cases is None or seed is None or not own_fields or len(reader.problems) > problems_before:
            return None
        if not paths or not reader.axes.keys() >= {*paths}:  # what is wrong with them is said
            return None
        over = {path: Choice(reader.choices[path], reader.axes[path]) for path in paths}
        return cls(over, cases, seed, start_values(reader, over), **own_fields)

    @classmethod
    def read_own(cls, reader: Reader, section: WrittenValue) -> dict[str, Any]:
        """Return the further fields of the search, or {} if one is missing; report mistakes."""
        raise NotImplementedError


def check_range(reader: Reader, path: str, section: str) -> None:
    """Report a range whose ends are in the wrong order, and a path that cannot vary from case to case."""
    values = reader.axes[path]
    if reader.choices[path] != AMONG and values[0] >= values[-1]:
        message = "the first value is not below the second; swap them"
        reader.problems.add(reader.written_axes[path], f"{section}.over.{path}", message)
    if path.endswith(".exponent"):
        message = f"cannot vary under `{section}`, because units of other keys depend on it"
        reader.problems.add(reader.written_axes[path], f"{section}.over.{path}", message)


def unit_of_path(reader: Reader, path: str) -> str:
    """Return the SI unit of the quantity at a path."""
    key = reader.keys_in_use[path]
    assert isinstance(key, Number)  # others cannot be searched for
    exponents = reader.values_of(f"{path.rpartition('.')[0]}.exponent")
    return quantity.replace_exponent(key.fields(reader.names)[0].unit, exponents[0] if exponents else 1.5)


def start_values(reader: Reader, over: Mapping[str, Choice]) -> dict[str, Any]:
    """Return the values written in the grid, or {} unless all are written and within their choices."""
    start: dict[str, Any] = {}
    for path, choice in over.items():
        written, key = reader.written.get(path), reader.keys_in_use[path]
        if written is None:
            return {}
        value: Any = written.value
        if isinstance(key, Number):
            value = quantity.read(value, unit_of_path(reader, path))
        is_allowed = value in choice.values if choice.kind == AMONG else choice.values[0] <= value <= choice.values[-1]
        if not is_allowed or (isinstance(value, float) and math.isnan(value)):
            return {}
        start[path] = int(value) if choice.kind == WHOLE else value
    return start


# ----------------------------------------------------------------------------------------------------------------------
# What helps if `seek` finds no value: limits that would pass, and other keys that change the margin.
#
# The effects of the keys are finite differences.  Their cases are a separate run in a folder of the run's directory,
# so it resumes like any other.


STEP = 0.1  # relative step: larger than the scatter of chaotic motion, small enough for a slope
FOLDER = "sensitivity"  # prefix of its name; a hash of the keys follows
DIGITS = 4  # digits of a limit that would pass
_EXPONENT = ".exponent"  # the units of other keys depend on this key


class Effect(NamedTuple):
    """Effect of a key on the margin if no tried value meets the limits."""

    path: str
    value: float  # SI, value in the grid
    margin: float  # margin at this value
    lower: float | None  # margin with the value lower by STEP, or None if the case failed or is impossible
    upper: float | None

    @property
    def size(self) -> float:
        """Return the largest change of the margin."""
        return max(abs(margin - self.margin) for margin in (self.lower, self.upper, self.margin) if margin is not None)


def effects(grid: grids.Grid, best: Sequence[Mapping[str, Any]], runs: FurtherRuns) -> list[Effect]:
    """Return the effects of the other choices on the margin, the largest first; [] without a margin or `runs.run`.

    They apply to the case furthest from its limits, at its best value.  best : how near each case comes to its limits
    """
    worst = furthest_from_limits(best)
    if grid.search is None or worst is None or runs.run is None:
        return []
    point = worst["point"] | dict.fromkeys(grid.search.varied_paths, worst["value"])
    fixed = {key: section for key, section in grid.resolved().items() if key not in (*AXIS_SECTIONS, "sample", "seek")}
    perturbed = _perturbed(grid, point, fixed, runs.catalogue)
    paths = list(perturbed)
    if not paths:
        return []
    point_values = {path: value for path, value in _numbers(grid, point).items() if path in perturbed}
    points = [point_values, *(point_values | {path: value} for path, values in perturbed.items() for value in values)]
    columns = {path: [value] * len(points) for path, value in point.items()}
    columns |= {path: [row[path] for row in points] for path in paths}
    phases.print_line(
        f"no value meets the limits; {len(points)} more cases show which other keys help (--no-effects leaves them out)"
    )
    name = hashlib.sha256(" ".join(sorted(columns)).encode()).hexdigest()[:8]
    table = runs.run(fixed | {"cases": columns}, runs.directory / f"{FOLDER}-{name}").summary
    values_with_margin = table[[*paths, MARGIN_COLUMN]].dropna().to_numpy(float).tolist()
    margins = {tuple(values): margin for *values, margin in values_with_margin}
    start = margins.get(tuple(point_values.values()))
    if start is None:
        return []
    effects = []
    for path in paths:
        neighbours = [
            margins.get(tuple((point_values | {path: point_values[path] * factor}).values()))
            for factor in (1.0 - STEP, 1.0 + STEP)
        ]
        effects.append(Effect(path, point_values[path], start, *neighbours))
    return sorted(effects, key=lambda effect: (-effect.size, effect.path))


def most_cases(grid: grids.Grid) -> int:
    """Return the largest number of cases that `effects` runs."""
    return 1 + 2 * len(_numbers(grid, grid.point(0)))


def furthest_from_limits(best: Iterable[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """Return the case furthest from its limits at its best value, or None if no margin is known."""
    finite = [case for case in best if case["margin"] is not None]
    return min(finite, key=lambda case: case["margin"], default=None)


def _numbers(grid: grids.Grid, point: Mapping[str, Any]) -> dict[str, float]:
    """Return path -> value (SI) of the numbers of a case that the designer chooses."""
    tree = grid.case_tree(point)
    return {
        path: value
        for path, value in grids.leaves(tree)
        if isinstance(value, float)
        and ".table." not in path
        and not path.startswith("uncertain.")
        and value
        and path not in point
        and not path.endswith(_EXPONENT)
        and grid.role(path) == CHOICE
    }


def _perturbed(
    grid: grids.Grid, point: Mapping[str, Any], fixed: dict[str, Any], catalogue: grids.Catalogue
) -> dict[str, list[float]]:
    """Return path -> values lower and higher by STEP, for keys that accept them."""
    perturbed, columns = {}, {axis: [coordinate] for axis, coordinate in point.items()}
    for path, value in _numbers(grid, point).items():
        possible = [
            changed
            for changed in (value * (1.0 - STEP), value * (1.0 + STEP))
            if not mistake_of(grids.load, fixed | {"cases": columns | {path: [changed]}}, catalogue)
        ]
        if possible:
            perturbed[path] = possible
    return perturbed


def unanswered_facts(
    record: Mapping[str, Any], best: Sequence[Mapping[str, Any]], effects: Iterable[Effect], catalogue: grids.Catalogue
) -> dict[str, Any]:
    """Return facts about searches without an answer for run.json, in SI.

    record : run.json; best : how near each case comes to its limits
    """
    limits, columns = limits_and_figures_of(record).limits, units_of(record)
    finite = all(case["margin"] is not None for case in best)
    units = grids.key_units(record, catalogue) if effects else {}
    return {
        "best": [{**case} | {"needed": loosened_limits(limits, columns, [case["margins"]])} for case in best],
        "needed": loosened_limits(limits, columns, [case["margins"] for case in best]) if finite else {},
        "furthest": furthest_from_limits(best),
        "effects": [effect._asdict() | {"unit": units.get(effect.path, "1")} for effect in effects],
    }


def loosened_limits(
    limits: Sequence[Limit], units: Mapping[str, str], margins: Sequence[Mapping[str, float]]
) -> dict[str, str]:
    """Return in words the exceeded limits for cases with these margins, each relaxed so that all cases pass.

    Columns with two limits are left out: a margin does not show which limit is exceeded.
    """
    texts: dict[str, str] = {}
    columns = Counter(limit.column for limit in limits)
    for limit in limits:
        margin = min((margin.get(limit.column, 0.0) for margin in margins), default=0.0)
        if margin < 0.0 and columns[limit.column] > 1:
            return {}
        if margin < 0.0:
            is_upper = limit.kind == KINDS[0]
            size = abs(limit.value) or 1.0  # the margin to a bound of 0 is the excess
            loosened = limit.value + size * (-margin if is_upper else margin)
            value = _rounded(loosened, ROUND_CEILING if is_upper else ROUND_FLOOR)
            texts[limit.column] = replace(limit, value=value).bound_text(units.get(limit.column, "1"))
    return texts


def _rounded(value: float, rounding: str) -> float:
    """Return a number with DIGITS digits, rounded up or down so that the relaxed limit still passes."""
    exact = Decimal(f"{value:.12g}")  # removes rounding errors of a margin
    return float(exact.quantize(Decimal(1).scaleb(exact.adjusted() + 1 - DIGITS), rounding))
