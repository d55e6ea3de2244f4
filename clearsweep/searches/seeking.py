"""What a search for an extreme value is made of: halvings of an interval, and choices among named values."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Self

from ..contracts.search import Search
from ..grid.keys import Number
from ..grid.sections.reader import Reader, check_always_used
from ..grid.sections.section import CountKey, section_in
from ..grid.written.document import WrittenValue
from ..language import quantity

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


def interval_count(low: float, high: float, within: float) -> int:
    """Return the number of equal steps of at most `within` between two values, a power of 2."""
    return 1 << max(math.ceil(math.log2((high - low) / within)), SCAN_INTERVALS.bit_length() - 1)


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

    @classmethod
    def axes(cls, reader: Reader, root: WrittenValue) -> dict[str, tuple[WrittenValue, WrittenValue]]:
        """Return path -> (position, values in the form of an axis) of the keys to vary; record the kinds of choices."""
        section = cls.keys.find(reader.problems, root)
        if section is None:
            return {}
        for conflict in cls.conflicts:
            if conflict in root.value:
                message = f"conflicts with `{conflict}`; `{cls.name}` chooses all cases itself; remove one of the two"
                reader.problems.add(section, cls.name, message)
                return {}
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
        section = section_in(root, cls.name)
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


def start_values(reader: Reader, over: Mapping[str, Choice]) -> dict[str, Any]:
    """Return the values written in the grid, or {} unless all are written and within their choices."""
    start: dict[str, Any] = {}
    for path, choice in over.items():
        written, key = reader.written.get(path), reader.keys_in_use[path]
        if written is None:
            return {}
        value: Any = written.value
        if isinstance(key, Number):
            exponents = reader.values_of(f"{path.rpartition('.')[0]}.exponent")
            unit = quantity.replace_exponent(key.fields(reader.names)[0].unit, exponents[0] if exponents else 1.5)
            value = quantity.read(value, unit)
        is_allowed = value in choice.values if choice.kind == AMONG else choice.values[0] <= value <= choice.values[-1]
        if not is_allowed or (isinstance(value, float) and math.isnan(value)):
            return {}
        start[path] = int(value) if choice.kind == WHOLE else value
    return start
