"""`optimise`: its section, which has the values to vary, the columns to minimise or maximise, and the best cases."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import util
from typing import Any, ClassVar

from ..grid.keys import Number, Word
from ..grid.keys.library_names import name_path
from ..grid.sections.fits import naming_of
from ..grid.sections.reader import Reader
from ..grid.sections.section import (
    AXES_OF_NAMES,
    PAIR_SCHEMA,
    EntriesKey,
    KeySection,
    NamesKey,
    cases_key,
    single_key_schemas,
)
from ..grid.written.document import WrittenValue
from ..language.errors import InputError, did_you_mean, quoted
from .optimising import Optimisation, interval_columns
from .seeking import AMONG, MISSING_OVER_TEXT, ROUND_SIZE, SEED_KEY, WHOLE, SearchOver

OPTIMISE = "optimise"
SENSES = ("minimise", "maximise")
MAX_CASES = 100_000
_AMONG_FORM = {"anyOf": [{"type": "array", "minItems": 1}, *AXES_OF_NAMES]}
OPTIMISE_SECTION = KeySection(
    OPTIMISE,
    "search for the values that minimise or maximise columns of summary.parquet within `limits`",
    "{over: {define.play: [5 um, 100 um]}, minimise: rod_slider_load_peak, cases: 300}",
    (
        EntriesKey(
            "over",
            "path -> [low, high], {among: [a, ...]} (laws, materials, fits, groups, numbers) or {whole: [low, high]}",
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
class Optimise(SearchOver):
    """Objectives, and the values to choose from, in SI."""

    name: ClassVar[str] = OPTIMISE
    keys: ClassVar[KeySection] = OPTIMISE_SECTION
    example: ClassVar[str] = (
        "optimise: {over: {drive.speed: [500 rpm, 3000 rpm]}, minimise: rod_slider_load_peak, cases: 60}"
    )
    answer_key: ClassVar[str] = "optimised"
    conflicts: ClassVar[tuple[str, ...]] = ("sweep", "zip", "cases", "sample", "seek", "refine")
    seconds_per_choice: ClassVar[float] = 6e-3
    objectives: tuple[tuple[str, bool], ...]  # column, and whether it is to be large

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

    def begin(self, grid: Any, simulator: Any) -> Optimisation:
        """Return the search at work; raise InputError without Optuna."""
        if util.find_spec("optuna") is None:
            raise InputError("optimise: needs Optuna, which is not installed; run `pip install 'clearsweep[optimise]'`")
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
    def read_choice(cls, reader: Reader, key: str, written: WrittenValue) -> tuple[str, WrittenValue] | None:
        """Return path and values of an entry of `over`, and record the kind of its choice."""
        path = name_path(key, reader.keys_in_use)
        key_path, used_key = f"{OPTIMISE}.over.{path}", reader.keys_in_use.get(path)
        is_whole = isinstance(used_key, Number) and any(use.field.integer for use in used_key.uses)
        content, kind = written.value, "range"
        if isinstance(content, dict) and len(content) == 1 and {*content} <= {AMONG, WHOLE}:
            ((kind, written),) = content.items()
            content = written.value
            if kind == AMONG and isinstance(content, dict) and naming_of(reader, path):
                reader.choices[path] = AMONG
                return path, written
        is_pair = isinstance(content, list) and len(content) == 2
        if not isinstance(content, list) or not content or (kind != AMONG and not is_pair):
            message = f"found {quoted(content)}; expected [low, high], {{among: [...]}} or {{whole: [low, high]}}"
            reader.problems.add(written, key_path, message)
            return None
        is_word = isinstance(used_key, Word)
        if kind != AMONG and (is_word or is_whole != (kind == WHOLE)):
            expected = "{among: [...]}" if is_word else "{whole: [low, high]}" if is_whole else "[low, high]"
            reader.problems.add(written, key_path, f"found {quoted(content)}; this key takes {expected}")
            return None
        reader.choices[path] = kind
        return path, written

    @classmethod
    def read_own(cls, reader: Reader, section: WrittenValue) -> dict[str, Any]:
        """Return the objectives."""
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
        return {"objectives": tuple(objectives)} if objectives else {}
