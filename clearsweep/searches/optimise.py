"""`optimise`: its section, which has the values to vary, the columns to minimise or maximise, and the best cases."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import util
from typing import Any, ClassVar

from ..contracts.search import Search
from ..grid.keys.kinds import Number, Word
from ..grid.keys.library_names import name_path
from ..grid.sections.reader import Reader, check_always_used
from ..grid.sections.section import (
    FITS_SCHEMA,
    PAIR_SCHEMA,
    EntriesKey,
    KeySection,
    NamesKey,
    cases_key,
    section_in,
    single_key_schemas,
)
from ..grid.written.document import WrittenValue
from ..language.errors import InputError, did_you_mean, quoted
from .choices import AMONG, MISSING_OVER_TEXT, ROUND_SIZE, SEED_KEY, WHOLE, Choice, check_range, find_over, start_values
from .optimising import Optimisation, interval_columns

OPTIMISE = "optimise"
SENSES = ("minimise", "maximise")
MAX_CASES = 100_000
SECONDS_PER_CHOICE = 6e-3  # s for choosing a case; one process chooses
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


@dataclass(frozen=True)
class Optimise(Search):
    """Objectives, and the values to choose from, in SI."""

    name: ClassVar[str] = OPTIMISE
    keys: ClassVar[KeySection] = OPTIMISE_SECTION
    example: ClassVar[str] = (
        "optimise: {over: {drive.speed: [500 rpm, 3000 rpm]}, minimise: rod_slider_load_peak, cases: 60}"
    )
    answer_key: ClassVar[str] = "optimised"
    over: dict[str, Choice]
    objectives: tuple[tuple[str, bool], ...]  # column, and whether it is to be large
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

    def first(self) -> dict[str, tuple[Any, ...]]:
        """Return the values of the first round: those written in the grid, and evenly spread points."""
        from scipy.stats import qmc

        count = min(ROUND_SIZE, self.cases)
        fractions = qmc.Sobol(len(self.over), seed=self.seed).random(ROUND_SIZE).tolist()
        points = [
            tuple(choice.value_at(fraction) for choice, fraction in zip(self.over.values(), row, strict=True))
            for row in fractions
        ]
        written_point = [tuple(self.start.values())] if self.start else []
        distinct = list(dict.fromkeys([*written_point, *points]))[:count]
        return dict(zip(self.over, zip(*distinct, strict=True), strict=True))

    def result_columns(self, grid: Any) -> list[str]:
        """Return the columns that compare cases: objectives, and the ends of their intervals, which few have."""
        available = {column.name for column in grid.layout.columns}
        objectives = [name for name, _ in self.objectives]
        return [*objectives, *(end for name in objectives for end in interval_columns(name) if end in available)]

    def expected_cases(self, grid: Any) -> tuple[int, float]:
        """Return the remaining cases."""
        return max(self.cases - len(grid), 0), SECONDS_PER_CHOICE

    def begin(self, grid: Any, simulator: Any) -> Optimisation:
        """Return the search at work; raise InputError without Optuna."""
        if util.find_spec("optuna") is None:
            raise InputError("optimise: needs Optuna, which is not installed; run `pip install clearsweep[optimise]`")
        return Optimisation(self)

    @classmethod
    def missing_answer(cls, answer: Mapping[str, Any]) -> str:
        """Return that no case meets the limits."""
        is_met = answer["search"] and answer.get("best_met", True)
        return "" if is_met else "`optimise` has no case that meets the limits"

    @classmethod
    def table_columns(cls, record: Mapping[str, Any]) -> set[str]:
        """Return the columns of optimise.parquet."""
        section = record.get(OPTIMISE) or {}
        objectives = {name for sense in SENSES for name in section.get(sense, [])}
        return {"case_id", *record["units"], *objectives, "margin", "limiting"}

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

    @classmethod
    def axes(cls, reader: Reader, root: WrittenValue) -> dict[str, tuple[WrittenValue, WrittenValue]]:
        """Return path -> (position, values in the form of an axis) of the keys to vary; record the kinds of choices."""
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

    @classmethod
    def read(cls, reader: Reader, root: WrittenValue) -> "Optimise | None":
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
