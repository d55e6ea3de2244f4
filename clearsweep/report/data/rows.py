"""Cases of a run as a table whose columns are read on demand: a page needs only a few of a million cases."""

import bisect
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from ...grid import Definitions
from ...store import StoredRun

Result = TypeVar("Result")
CACHED_VALUES = 3_000_000  # values in memory, of the latest columns: of a million cases three, of 8 MB each


class Rows:
    """Some cases of a run by case_id, ascending: numbers as float64, NaN for missing values.

    It reads like a DataFrame: `rows[column]`, `rows.at[case_id, column]`, `column in rows`, `rows.index`.
    """

    def __init__(
        self,
        run: StoredRun,
        ids: pd.Series,
        is_selected: np.ndarray,
        text_columns: set[str],
        derived: Mapping[str, Callable[["Rows"], pd.Series]] | None = None,
    ) -> None:
        """Take the case_id of all rows of a summary, the mask of these cases, text and computed columns."""
        self._run, self._text_columns, self._derived = run, text_columns, derived or {}
        self.selected = is_selected  # (rows of the summary,)
        self._selection = slice(None) if is_selected.all() else is_selected
        self.index = pd.Index(ids[self._selection], name="case_id")
        self.columns = [name for name in run.columns if name != "case_id"] + list(self._derived)
        self._names = frozenset(self.columns)
        self._column_cache: OrderedDict[str, pd.Series] = OrderedDict()
        self._result_cache: dict[Hashable, Any] = {}

    def __len__(self) -> int:
        return len(self.index)

    def __contains__(self, column: str) -> bool:
        return column in self._names

    def __getitem__(self, column: str) -> pd.Series:
        """Return a column; raise KeyError if it is missing."""
        if column in self._column_cache:
            self._column_cache.move_to_end(column)
            return self._column_cache[column]
        if column not in self:
            raise KeyError(column)
        values = self._derived[column](self) if column in self._derived else self._read(column)
        self._column_cache[column] = values
        while len(self._column_cache) > 1 and len(self._column_cache) * len(self) > CACHED_VALUES:
            self._column_cache.popitem(last=False)
        return values

    def get(self, column: str, default: Any) -> Any:
        """Return a column, or `default` if it is missing."""
        if column in self:
            return self[column]
        return default

    def _read(self, column: str) -> pd.Series:
        values = self._run.column(column)[self._selection]
        if column in self._text_columns:
            return values.set_axis(self.index)
        return pd.Series(values.to_numpy(float, na_value=np.nan), self.index, name=column)

    @property
    def empty(self) -> bool:
        """Return whether there are no cases."""
        return not len(self)

    @property
    def at(self) -> "_CellIndexer":
        """Return an indexer of one value by `[case_id, column]`."""
        return _CellIndexer(self)

    def row_of(self, case_id: str) -> int:
        """Return the row of a case, -1 if it is not among them."""
        row = bisect.bisect_left(range(len(self)), case_id, key=self.index.__getitem__)
        return row if row < len(self) and self.index[row] == case_id else -1

    def largest(self, column: str) -> float:
        """Return the largest value of a figure, or NaN if it has no value or column."""
        if column not in self:
            return np.nan
        return self.cached(("largest", column), lambda: float(self[column].max()) if len(self) else np.nan)

    def ordered(self, column: str, *, smallest: bool = False) -> np.ndarray:
        """Return the indices of all cases by the value of a column, descending (or ascending), missing values last."""
        values = self[column].to_numpy()
        return np.argsort(values if smallest else -values, kind="stable")

    def representative_cases(self, column: str) -> tuple[str, ...]:
        """Return the cases with the largest, the median and the smallest value of a column, without repetition."""
        order = self.ordered(column)[: int(self[column].count())]
        return tuple(self.index[order[k]] for k in dict.fromkeys((0, len(order) // 2, len(order) - 1)) if len(order))

    def cached(self, key: Hashable, compute: Callable[[], Result]) -> Result:
        """Return the result of `compute`, cached by key, for small results that several sections need."""
        if key not in self._result_cache:
            self._result_cache[key] = compute()
        return self._result_cache[key]


class _CellIndexer:
    def __init__(self, rows: Rows) -> None:
        self._rows = rows

    def __getitem__(self, key: tuple[str, str]) -> Any:
        case_id, column = key
        row = self._rows.row_of(case_id)
        if row < 0:
            raise KeyError(case_id)
        return self._rows[column].iloc[row]


def dependent_values(definitions: Definitions, path: str, cases: Rows, base: Mapping) -> pd.Series:
    """Return a number derived from swept names, for every case."""
    axes = {f"define.{name}": cases[f"define.{name}"].to_numpy() for name in sorted(definitions.varied_names)}
    points = (dict(zip(axes, values, strict=True)) for values in zip(*axes.values(), strict=True))
    return pd.Series([definitions.values_at(point)[path] for point in points], cases.index, dtype="float64")
