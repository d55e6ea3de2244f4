"""Lazy summary of a run in blocks: conditions on columns determine which parts are read."""

import operator
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from .columns import values_of
from .datasets import ID_LENGTH

if TYPE_CHECKING:
    import pandas as pd


class Run(Protocol):
    """The interface that a lazy summary needs of a run."""

    def __len__(self) -> int:
        """Return the number of rows."""

    @property
    def columns(self) -> list[str]:
        """Return the names of the columns."""

    def column(self, name: str) -> "pd.Series":
        """Return one column of all rows."""

    def matching(self, filters: "Filter", columns: list[str] | None = None) -> "pd.DataFrame":
        """Return the rows that pass some filters."""


_COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


class Filter:
    """Conditions on columns of a summary, which a row must all meet."""

    def __init__(self, conditions: tuple[tuple[str, str, Any], ...]):
        """Prepare conditions such as ('drive.speed', '>=', 100.0) or ('case_id', 'in', {...})."""
        self.conditions = conditions

    def __and__(self, other: "Filter") -> "Filter":
        return Filter(self.conditions + other.conditions)

    @property
    def columns(self) -> list[str]:
        """Return the columns in the conditions."""
        return [column for column, _, _ in self.conditions]

    @property
    def case_ids(self) -> set[str] | None:
        """Return the identities that a matching row can have, or None if it can have any."""
        sets = [
            {value} if comparison == "==" else set(value)
            for column, comparison, value in self.conditions
            if column == "case_id" and comparison in ("==", "in")
        ]
        if not sets:
            return None
        letters = frozenset("0123456789abcdef")
        return {
            case_id for case_id in set.intersection(*sets) if len(case_id) == ID_LENGTH and letters.issuperset(case_id)
        }

    def may_match_ranges(self, ranges: dict[str, list[Any]]) -> bool:
        """Return whether values in these ranges (column -> smallest, largest) can meet all conditions."""
        return all(
            may_match(comparison, value, *ranges[column][:2])
            for column, comparison, value in self.conditions
            if column in ranges and not isinstance(value, str)
        )

    def groups(self, file: pq.ParquetFile, rows_between: Callable[[int, int], np.ndarray]) -> list[int]:
        """Return the row groups of a summary that may contain matching rows.

        rows_between : range of identities -> range of rows.
        """
        groups = range(file.metadata.num_row_groups)
        ids = self.case_ids
        if ids is None:
            return list(groups)
        row_ranges = [rows_between(int(case_id, 16), int(case_id, 16)).tolist() for case_id in ids]
        group_ends = np.cumsum([file.metadata.row_group(group).num_rows for group in groups])
        return sorted({int(np.searchsorted(group_ends, first, "right")) for first, last in row_ranges if last > first})

    def mask(self, table: pa.Table) -> np.ndarray:
        """Return a mask of the rows of a table that match; null never matches."""
        mask = np.ones(len(table), bool)
        for column, comparison, value in self.conditions:
            values = values_of(table[column].combine_chunks())
            if comparison == "in":
                mask &= np.array([item in value for item in values.tolist()], bool)
            else:
                is_known = np.array(values != None) if values.dtype == object else ~np.isnan(values)  # noqa: E711
                is_met = np.zeros(len(values), bool)
                is_met[is_known] = _COMPARE[comparison](values[is_known], value)
                mask &= is_met
        return mask


class LazyColumn:
    """A column of a lazy summary: compared with a value it is a filter; anything else reads all of it, as a Series."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, run: Run, name: str):
        """Prepare for a run and the name of the column."""
        self._run, self._name = run, name

    def _filter(self, comparison: str, value: Any) -> Filter:
        return Filter(((self._name, comparison, value),))

    def __eq__(self, value: object) -> Filter:  # type: ignore[override]
        return self._filter("==", value)

    def __ne__(self, value: object) -> Filter:  # type: ignore[override]
        return self._filter("!=", value)

    def __lt__(self, value: Any) -> Filter:
        return self._filter("<", value)

    def __le__(self, value: Any) -> Filter:
        return self._filter("<=", value)

    def __gt__(self, value: Any) -> Filter:
        return self._filter(">", value)

    def __ge__(self, value: Any) -> Filter:
        return self._filter(">=", value)

    def isin(self, values: Any) -> Filter:
        """Return the filter for rows with one of some values."""
        return self._filter("in", frozenset(values))

    def __len__(self) -> int:
        return len(self._run)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._run.column(self._name))

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return np.asarray(self._run.column(self._name), dtype)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._run.column(self._name), name)


class LazySummary:
    """The summary of a run in blocks: used like a DataFrame, but only requested parts are read.

    `summary[summary["case_id"] == "..."]` and `summary[(summary["drive.speed"] > 100.0) & ...]` are DataFrames with the
    rows that pass; `summary["column"]` compares without being read; `summary.frame()` reads everything.
    """

    def __init__(self, run: Run):
        """Take the run."""
        self._run = run

    def __len__(self) -> int:
        return len(self._run)

    def __repr__(self) -> str:
        return f"<lazy summary: {len(self):,} cases, {len(self.columns)} columns>"

    @property
    def columns(self) -> list[str]:
        """Return the names of the columns."""
        return self._run.columns

    @property
    def attrs(self) -> dict[str, dict[str, str]]:
        """Return `units` and `descriptions` by column."""
        return dict(self._run.matching(Filter((("case_id", "in", frozenset()),))).attrs)

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __getitem__(self, selection: "str | list[str] | Filter") -> Any:
        if isinstance(selection, Filter):
            return self._run.matching(selection)
        if isinstance(selection, list):
            return self._run.matching(Filter(()), selection)
        if selection not in self.columns:
            raise KeyError(selection)
        return LazyColumn(self._run, selection)

    def frame(self) -> "pd.DataFrame":
        """Return the whole summary as a DataFrame, block after block."""
        return self._run.matching(Filter(()))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self[name] if name in self.columns else getattr(self.frame(), name)


def may_match(comparison: str, value: Any, low: float, high: float) -> bool:
    """Return whether a number in a range can meet a condition."""
    conditions: dict[str, Callable[[], bool]] = {
        "==": lambda: low <= value <= high,
        "!=": lambda: True,
        "<": lambda: low < value,
        "<=": lambda: low <= value,
        ">": lambda: high > value,
        ">=": lambda: high >= value,
        "in": lambda: any(low <= item <= high for item in value),
    }
    return conditions[comparison]()
