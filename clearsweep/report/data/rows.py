"""Cases of a run as a table whose columns are read on demand: a page needs only a few of a million cases."""

import bisect
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from ...grid import Definitions
from ...store import StoredRun

Found = TypeVar("Found")
KEPT = 3_000_000  # values in memory, of the latest columns: of a million cases three, of 8 MB each


class Rows:
    """Some cases of a run by case_id, ascending: numbers as float64, NaN for missing values.

    It reads like a DataFrame: `rows[column]`, `rows.at[case_id, column]`, `column in rows`, `rows.index`.
    """

    def __init__(
        self,
        run: StoredRun,
        ids: pd.Series,
        chosen: np.ndarray,
        texts: set[str],
        derived: Mapping[str, Callable[["Rows"], pd.Series]] | None = None,
    ) -> None:
        """Take the case_id of all rows of a summary, the `chosen` rows, its text columns, and the computed columns."""
        self._run, self._texts, self._derived = run, texts, derived or {}
        self.chosen = chosen  # (rows of the summary,)
        self._chosen = slice(None) if chosen.all() else chosen
        self.index = pd.Index(ids[self._chosen], name="case_id")
        self.columns = [name for name in run.columns if name != "case_id"] + list(self._derived)
        self._names = frozenset(self.columns)
        self._kept: OrderedDict[str, pd.Series] = OrderedDict()
        self._found: dict[Hashable, Any] = {}

    def __len__(self) -> int:
        return len(self.index)

    def __contains__(self, column: str) -> bool:
        return column in self._names

    def __getitem__(self, column: str) -> pd.Series:
        """Return a column; raise KeyError if it is missing."""
        if column in self._kept:
            self._kept.move_to_end(column)
            return self._kept[column]
        if column not in self:
            raise KeyError(column)
        values = self._derived[column](self) if column in self._derived else self._read(column)
        self._kept[column] = values
        while len(self._kept) > 1 and len(self._kept) * len(self) > KEPT:
            self._kept.popitem(last=False)
        return values

    def get(self, column: str, default: Any) -> Any:
        """Return a column, or `default` if it is missing."""
        if column in self:
            return self[column]
        return default

    def _read(self, column: str) -> pd.Series:
        values = self._run.column(column)[self._chosen]
        if column in self._texts:
            return values.set_axis(self.index)
        return pd.Series(values.to_numpy(float, na_value=np.nan), self.index, name=column)

    @property
    def empty(self) -> bool:
        """Return whether there are no cases."""
        return not len(self)

    @property
    def at(self) -> "_At":
        """Return an indexer of one value by `[case_id, column]`."""
        return _At(self)

    def place(self, case_id: str) -> int:
        """Return the row of a case, -1 if it is not among them."""
        place = bisect.bisect_left(range(len(self)), case_id, key=self.index.__getitem__)
        return place if place < len(self) and self.index[place] == case_id else -1

    def largest(self, column: str) -> float:
        """Return the largest value of a figure, or NaN if it has no value or column."""
        if column not in self:
            return np.nan
        return self.once(("largest", column), lambda: float(self[column].max()) if len(self) else np.nan)

    def ordered(self, column: str, *, smallest: bool = False) -> np.ndarray:
        """Return the indices of all cases by the value of a column, descending (or ascending), missing values last."""
        values = self[column].to_numpy()
        return np.argsort(values if smallest else -values, kind="stable")

    def ranked(self, column: str) -> tuple[str, ...]:
        """Return the cases with the largest, the median and the smallest value of a column, without repetition."""
        places = self.ordered(column)[: int(self[column].count())]
        return tuple(
            self.index[places[k]] for k in dict.fromkeys((0, len(places) // 2, len(places) - 1)) if len(places)
        )

    def once(self, key: Hashable, find: Callable[[], Found]) -> Found:
        """Return the result of `find`, cached by key, for small results that several sections need."""
        if key not in self._found:
            self._found[key] = find()
        return self._found[key]


class _At:
    def __init__(self, rows: Rows) -> None:
        self._rows = rows

    def __getitem__(self, which: tuple[str, str]) -> Any:
        case_id, column = which
        place = self._rows.place(case_id)
        if place < 0:
            raise KeyError(case_id)
        return self._rows[column].iloc[place]


def dependent_values(defined: Definitions, path: str, cases: Rows, base: Mapping) -> pd.Series:
    """Return a number derived from swept names, for every case."""
    axes = {f"define.{name}": cases[f"define.{name}"].to_numpy() for name in sorted(defined.varied)}
    points = (dict(zip(axes, values, strict=True)) for values in zip(*axes.values(), strict=True))
    return pd.Series([defined.values_at(point)[path] for point in points], cases.index, dtype="float64")
