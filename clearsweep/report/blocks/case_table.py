"""Tables with one row per finished case: its swept values, then its figures."""

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np

from ..data.axis import Axis
from ..data.rows import Rows
from ..data.study import Study
from .table import Column, Table

CHUNK_ROWS = 4096  # rows in memory
Headings = Sequence[tuple[str, str]]  # figure, its heading in a table


def case_table(
    study: Study, key: str, title: str, columns: Headings, sort_column: str, *, smallest: bool = False
) -> Table:
    """Return a table of the available columns of the summary, ordered by `sort_column`; no rows without that column.

    The largest value comes first, or the smallest.
    """
    available = [(column, heading) for column, heading in columns if column in study.cases]
    table_columns = (
        Column("case_id"),
        *axis_columns(study, study.swept()),
        *(Column(heading, study.unit(column)) for column, heading in available),
    )
    if sort_column not in dict(available) or study.cases.empty:
        return Table(key, title, "", table_columns, [])
    column_names = [*(axis.path for axis in study.swept()), *(column for column, _ in available)]
    note = f"Sorted by {dict(available)[sort_column]}, {'smallest' if smallest else 'largest'} first."
    return Table(key, title, note, table_columns, CaseRows(study.cases, column_names, sort_column, smallest=smallest))


class CaseRows(Sequence):
    """Rows of a table, one per case, computed as they are read: a page shows only a few of a million cases."""

    def __init__(self, cases: Rows, columns: list[str], sort_column: str = "", *, smallest: bool = False):
        """Take the cases, the columns after case_id, and the column and direction of the order."""
        self.cases, self.columns, self.sort_column, self.smallest = cases, columns, sort_column, smallest

    def __len__(self) -> int:
        return len(self.cases)

    def _order(self) -> np.ndarray:
        """Return the row numbers in the order of the table."""
        if not self.sort_column:
            return np.arange(len(self))
        return self.cases.ordered(self.sort_column, smallest=self.smallest)

    @overload
    def __getitem__(self, selection: int) -> tuple: ...
    @overload
    def __getitem__(self, selection: slice) -> list[tuple]: ...
    def __getitem__(self, selection: int | slice) -> tuple | list[tuple]:
        if isinstance(selection, int):
            return self[selection : selection + 1 or None][0]
        row_numbers = self._order()[
            selection
        ].copy()  # a view would keep the indices of all cases while columns are read
        values = [self.cases.index[row_numbers].tolist()]
        values += [self.cases[column].iloc[row_numbers].tolist() for column in self.columns]
        return list(zip(*values, strict=True))

    def __iter__(self) -> Iterator[tuple]:
        order = self._order()
        columns = [self.cases.index.to_series(), *(self.cases[column] for column in self.columns)]
        for start in range(0, len(self), CHUNK_ROWS):
            row_numbers = order[start : start + CHUNK_ROWS]
            yield from zip(*(column.iloc[row_numbers].tolist() for column in columns), strict=True)


def axis_columns(study: Study, axes: Sequence[Axis]) -> list[Column]:
    """Return the columns with the values of some axes."""
    return [Column(axis.name, study.unit(axis.path), axis) for axis in axes]
