"""Reads `optimise`: the values to vary, the columns to minimise or maximise, and the number of cases to run."""

import math
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from ...language import quantity
from ...language.errors import did_you_mean, quoted
from ..keys.kinds import Number, Word
from ..keys.library_names import name_path
from ..written.document import WrittenValue
from .reader import Reader, check_always_used, find_over
from .section import (
    FITS_SCHEMA,
    PAIR_SCHEMA,
    CountKey,
    EntriesKey,
    KeySection,
    NamesKey,
    cases_key,
    section_in,
    single_key_schemas,
)

OPTIMISE = "optimise"
SENSES = ("minimise", "maximise")
AMONG, WHOLE = "among", "whole"
ROUND_SIZE = 16  # cases that are asked for at a time, whatever the number of workers
MAX_CASES = 100_000
#: Ratio of the ends of a range from which on equal ratios count, not equal differences.
LOG_SCALE_RATIOS = {"range": 20.0, "prior": 4.0}
SEED_KEY = CountKey("seed", "a whole number, default 0", low=0, high=2**31, default=0)
MISSING_OVER_TEXT = "; name at least one key to vary"
_AMONG_FORM = {"anyOf": [{"type": "array", "minItems": 1}, FITS_SCHEMA]}
OPTIMISE_SECTION = KeySection(
    OPTIMISE,
    "search for the values that minimise or maximise columns of summary.parquet within `limits`",
    "{over: {define.play: [5 um, 100 um]}, minimise: rod_slider_load_peak, cases: 300}",
    (
        EntriesKey(
            "over",
            "path -> [low, high], {among: [a, ...]} (laws, materials, fits, numbers) or {whole: [low, high]}",
            required=True,
            missing=f"{MISSING_OVER_TEXT}, such as {{define.play: [5 um, 100 um]}}",
            entry={"anyOf": [PAIR_SCHEMA, *single_key_schemas({AMONG: _AMONG_FORM, WHOLE: PAIR_SCHEMA})]},
        ),
        *(NamesKey(sense, f"column or columns to {sense}", noun="column") for sense in SENSES),
        cases_key(1, MAX_CASES),
        SEED_KEY,
    ),
    {"anyOf": [{"required": [sense]} for sense in SENSES]},
)


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


class Optimise(NamedTuple):
    """Objectives, and the values to choose from, in SI."""

    over: dict[str, Choice]
    objectives: tuple[tuple[str, bool], ...]  # column, and whether it is to be large
    cases: int
    seed: int
    start: dict[str, Any]  # the values that the grid has written, or {} if some are missing or outside

    def first(self) -> list[tuple[Any, ...]]:
        """Return the values of the first round: those written in the grid, and evenly spread points."""
        from scipy.stats import qmc

        count = min(ROUND_SIZE, self.cases)
        fractions = qmc.Sobol(len(self.over), seed=self.seed).random(ROUND_SIZE).tolist()
        points = [
            tuple(choice.value_at(fraction) for choice, fraction in zip(self.over.values(), row, strict=True))
            for row in fractions
        ]
        written_point = [tuple(self.start.values())] if self.start else []
        return list(dict.fromkeys([*written_point, *points]))[:count]

    def columns(self, available: Collection[str]) -> list[str]:
        """Return the columns that compare cases: objectives, and the ends of their intervals if `available`."""
        objectives = [name for name, _ in self.objectives]
        return [*objectives, *(end for name in objectives for end in interval_columns(name) if end in available)]

    def resolved(self) -> dict[str, Any]:
        """Return the section in the form of a grid file, in SI."""
        columns_by_sense = {
            sense: [column for column, is_maximised in self.objectives if is_maximised is (sense == SENSES[1])]
            for sense in SENSES
        }
        section = {"over": {path: choice.resolved() for path, choice in self.over.items()}}
        return (
            section
            | {key: names for key, names in columns_by_sense.items() if names}
            | {"cases": self.cases, "seed": self.seed}
        )


def interval_columns(column: str) -> tuple[str, str]:
    """Return the names of the columns with the ends of a column's 95 % interval, which few columns have."""
    return f"{column}_low", f"{column}_high"


def find_optimise_axes(reader: Reader, root: WrittenValue) -> dict[str, tuple[WrittenValue, WrittenValue]]:
    """Return path -> (position, values in the form of an axis) for all keys to vary; record the kinds of choices."""
    section = OPTIMISE_SECTION.find(reader.problems, root)
    conflicts = ("sweep", "zip", "cases", "sample", "seek", "refine")
    over = find_over(reader, root, section, OPTIMISE_SECTION, conflicts) if section else None
    if over is None:
        return {}
    axes = {}
    for key, written in over.value.items():
        path = name_path(key, reader.keys_in_use)
        values = _read_choice(reader, path, written)
        if values is not None:
            axes[path] = (over.key_position(key), values)
    return axes


def _read_choice(reader: Reader, path: str, written: WrittenValue) -> WrittenValue | None:
    """Return the values of one path in the form of an axis."""
    key_path, key = f"{OPTIMISE}.over.{path}", reader.keys_in_use.get(path)
    is_whole = isinstance(key, Number) and any(use.field.integer for use in key.uses)
    content, kind = written.value, "range"
    if isinstance(content, dict) and len(content) == 1 and {*content} <= {AMONG, WHOLE}:
        ((kind, written),) = content.items()
        content = written.value
        if kind == AMONG and isinstance(content, dict) and [*content] == ["fits"]:
            reader.choices[path] = AMONG
            return written
    is_pair = isinstance(content, list) and len(content) == 2
    if not isinstance(content, list) or not content or (kind != AMONG and not is_pair):
        message = f"found {quoted(content)}; expected [low, high], {{among: [...]}} or {{whole: [low, high]}}"
        reader.problems.add(written, key_path, message)
        return None
    if kind != AMONG and (isinstance(key, Word) or is_whole != (kind == WHOLE)):
        expected = "{among: [...]}" if isinstance(key, Word) else "{whole: [low, high]}" if is_whole else "[low, high]"
        reader.problems.add(written, key_path, f"found {quoted(content)}; this key takes {expected}")
        return None
    reader.choices[path] = kind
    return written


def read_optimise(reader: Reader, root: WrittenValue) -> Optimise | None:
    """Return the section `optimise`, or None if it is missing or wrong; the axes must have been read."""
    section = section_in(root, OPTIMISE)
    paths = [path for path, section_name in reader.varied_by.items() if section_name == OPTIMISE]
    if section is None or not isinstance(section.value, dict):
        return None
    problems_before = len(reader.problems)
    for path in reader.axes.keys() & {*paths}:
        check_range(reader, path, OPTIMISE)
        check_always_used(reader, reader.written_axes[path], OPTIMISE, path)
    objectives = _read_objectives(reader, section)
    cases, seed = (OPTIMISE_SECTION.value(reader.problems, section, key) for key in ("cases", "seed"))
    if cases is None or seed is None or not objectives or len(reader.problems) > problems_before:
        return None
    if not paths or not reader.axes.keys() >= {*paths}:  # what is wrong with them is said
        return None
    over = {path: Choice(reader.choices[path], reader.axes[path]) for path in paths}
    return Optimise(over, objectives, cases, seed, start_values(reader, over))


def check_range(reader: Reader, path: str, section: str) -> None:
    """Report a range whose ends are in the wrong order, and a path that cannot vary from case to case."""
    values = reader.axes[path]
    if reader.choices[path] != AMONG and values[0] >= values[-1]:
        message = "the first value is not below the second; swap them"
        reader.problems.add(reader.written_axes[path], f"{section}.over.{path}", message)
    if path.endswith(".exponent"):
        message = f"cannot vary under `{section}`, because units of other keys depend on it"
        reader.problems.add(reader.written_axes[path], f"{section}.over.{path}", message)


def _read_objectives(reader: Reader, section: WrittenValue) -> tuple[tuple[str, bool], ...]:
    """Return the columns to minimise or maximise."""
    objectives: list[tuple[str, bool]] = []
    known_columns = {**reader.figures, **dict.fromkeys(reader.user_figures, "")}
    for sense in SENSES:
        for item in OPTIMISE_SECTION.value(reader.problems, section, sense) or ():
            if item.value not in known_columns:
                suggestion = did_you_mean(item.value, known_columns) or f" (known: {', '.join(known_columns)})"
                message = f"{quoted(item.value)} is not a column of this grid{suggestion}"
                reader.problems.add(item, f"{OPTIMISE}.{sense}", message)
            elif item.value in dict(objectives):
                reader.problems.add(item, f"{OPTIMISE}.{sense}", f"{item.value} occurs twice; remove one of them")
            else:
                objectives.append((item.value, sense == SENSES[1]))
    if not any(sense in section.value for sense in SENSES):
        message = "is missing; give the column to minimise, or maximise: the column to maximise"
        reader.problems.add(section, f"{OPTIMISE}.{SENSES[0]}", message)
    return tuple(objectives)


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
