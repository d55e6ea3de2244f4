"""What the rooms ask of a search, a section of a grid that adds cases while the grid runs.

The grid reads its section, a sweep runs its cases, the store keeps its table, and `run` prints its answer.  All reach
it through these classes; `searches` has the searches themselves.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Protocol

from ..language import np
from .layout import Column

Point = dict[str, Any]  # dotted path -> value


class CaseResults(NamedTuple):
    """Finished cases compared with their limits."""

    status: list[str]
    unmet: list[str]  # columns whose limits are exceeded or undecided, comma separated; '': all limits are met
    margins: "dict[str, np.ndarray]"  # by limited column; of a bound of 0 minus the excess, minus infinity if undecided
    columns: "dict[str, np.ndarray]"  # requested columns, NaN for null
    margin: "np.ndarray"  # of each case, as in the summary; NaN for null
    histories: "tuple[dict[str, np.ndarray], ...]" = ()  # requested channels of each case; empty for a failed case


class SearchTable(NamedTuple):
    """The table of an answer: one column of `values` for each of `columns`."""

    columns: Sequence[Column]
    values: Sequence[Sequence[Any]]


class FurtherRuns(NamedTuple):
    """What a search needs to run grids of its own."""

    catalogue: Any  # `contracts.catalogue.Catalogue`
    directory: Path  # of the run
    #: Runs a grid in a directory, and returns the `store.StoredRun`; None: no further cases are wanted.
    run: Callable[[dict[str, Any], Path], Any] | None


class Found:
    """The answer of a search that is complete."""

    note: str = ""  # warns that the search has no answer

    def table(self, axes: Sequence[Column], units: Mapping[str, str]) -> SearchTable | None:
        """Return the table, or None without an answer.

        axes : of the varied paths; units : column of the summary -> its unit
        """
        return None

    def entries(self) -> dict[str, Any]:
        """Return entries of run.json."""
        return {}

    def further(self, grid: Any, record: Mapping[str, Any], runs: FurtherRuns) -> tuple["Found", dict[str, Any]]:
        """Return the answer with what further runs show about it, and entries to add to run.json, now `record`."""
        return self, {}

    def facts(self, catalogue: Any, record: Mapping[str, Any], judged: Any) -> dict[str, Any] | None:
        """Return the answer for `run --json`, in SI units.

        record : run.json; judged : the limits of its grid, `answers.verdict.LimitsAndFigures`
        """
        return None


class Rounds(Protocol):
    """A search at work: it records the results of a round, and is asked for the cases of the next."""

    def record(self, grid: Any, first_index: int, results: CaseResults) -> None:
        """Record the results of the cases of a grid from the index `first_index` on."""

    def ask(self) -> Sequence[Point]:
        """Return the points of the next cases; none if no more are needed."""

    def result(self) -> Found:
        """Return the answer, once no more cases are needed."""


class Search:
    """One kind of search; an instance is its section in a grid, in SI."""

    name: ClassVar[str]  # of the section
    keys: ClassVar[Any] = None  # `grid.sections.KeySection` of the section
    example: ClassVar[str]  # of the section, for its help
    in_step: ClassVar[bool] = False  # all its paths have the same value; else they vary together, row by row
    answer_key: ClassVar[str] = ""  # of `Found.facts` in `run --json`; '' without
    has_table: ClassVar[bool] = True  # it writes NAME.parquet
    rows_answer: ClassVar[bool] = True  # the rows of the table are answers
    judges: ClassVar[bool] = True  # its answer says whether limits are met
    refusal_of_shards: ClassVar[str] = "the cases of `{name}` depend on one another; run it without shards"

    @property
    def varied_paths(self) -> tuple[str, ...]:
        """Return the paths whose values it chooses."""
        return ()

    @property
    def start_values(self) -> Mapping[str, Any]:
        """Return path -> value that the grid has written for these paths, or {} if some have none."""
        return {}

    @classmethod
    def schema(cls) -> dict[str, Any]:
        """Return the JSON Schema of the section."""
        schema: dict[str, Any] = cls.keys.schema
        return schema

    @classmethod
    def axis_path(cls, path: str) -> str:
        """Return the full key of a varied path, for messages."""
        return f"{cls.name}.over.{path}"

    @classmethod
    def axes(cls, reader: Any, root: Any) -> dict[str, tuple[Any, Any]]:
        """Return path -> (position, values as written) of the paths to vary, before any value is read."""
        return {}

    @classmethod
    def late_axes(
        cls, reader: Any, root: Any, keys: Any, values_of: Callable[[str], tuple[float, ...]]
    ) -> dict[str, tuple[Any, Any]]:
        """Return the same where they depend on other values of the grid: `values_of` returns those of a path."""
        return {}

    @classmethod
    def read(cls, reader: Any, root: Any) -> "Search | None":
        """Return the section, or None if it is missing or wrong; the axes and limits must have been read."""
        raise NotImplementedError

    def check(self, reader: Any, root: Any, layout: Any) -> "Search":
        """Return the section, checked against the columns and channels of the cases."""
        return self

    @classmethod
    def varies_word(cls, reader: Any, path: str) -> bool:
        """Return whether it adds cases with other words at a path that is written and read."""
        return False

    def first(self) -> dict[str, tuple[Any, ...]]:
        """Return path -> values of the first cases, for the paths of the search."""
        return {}

    def labels(self) -> dict[str, dict[str, Any]]:
        """Return path -> label -> value, SI, of values that have a label."""
        return {}

    def resolved(self) -> dict[str, Any]:
        """Return the section in the form of a grid file, in SI; {} for `true`."""
        raise NotImplementedError

    def result_columns(self, grid: Any) -> Sequence[str]:
        """Return the columns of the summary that `Rounds.record` needs."""
        return ()

    def result_channels(self) -> Sequence[str]:
        """Return the channels that `Rounds.record` needs."""
        return ()

    def expected_cases(self, grid: Any) -> tuple[int, float]:
        """Return how many cases it will about add to those of a grid, and the time (s) for choosing each."""
        return 0, 0.0

    def expectation(self, added: int) -> str:
        """Return a sentence for `--dry-run` on the cases that it will add; '' for none."""
        return f"time and storage include {added:,} cases that `{self.name}` adds to these" if added else ""

    def further_cases(self, grid: Any) -> int:
        """Return how many cases it runs at most beyond the search, where this finds no answer."""
        return 0

    def begin(self, grid: Any, simulator: Any) -> Rounds:
        """Return the search at work, before its first round."""
        raise NotImplementedError

    @classmethod
    def table_columns(cls, record: Mapping[str, Any]) -> set[str]:
        """Return the names of the columns that its table must have; `record` is run.json.  Default: the paths."""
        return {*record["units"]}

    @classmethod
    def missing_answer(cls, answer: Mapping[str, Any]) -> str:
        """Return why the answer of a run, as in answer.json, lacks that of the search, or ''."""
        return ""

    @classmethod
    def lines(cls, facts: Mapping[str, Any]) -> list[str]:
        """Return lines that `run` prints on its answer; `facts` are those of `Found.facts`."""
        return []
