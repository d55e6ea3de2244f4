"""Values that a search may choose: the section `over` of `optimise` and `identify`."""

import math
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from ..grid.keys.kinds import Number
from ..grid.sections.reader import Reader
from ..grid.sections.section import CountKey, KeySection
from ..grid.written.document import WrittenValue
from ..language import quantity

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


def find_over(
    reader: Reader, root: WrittenValue, section: WrittenValue, key_section: KeySection, conflicts: Collection[str]
) -> WrittenValue | None:
    """Return `over` of a section that chooses all cases, or None if it is missing or conflicts with another section."""
    for conflict in conflicts:
        if conflict in root.value:
            message = (
                f"conflicts with `{conflict}`; `{key_section.name}` chooses all cases itself; remove one of the two"
            )
            reader.problems.add(section, key_section.name, message)
            return None
    over: WrittenValue | None = key_section.value(reader.problems, section, "over")
    return over


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
