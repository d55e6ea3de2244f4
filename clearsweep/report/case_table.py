"""Tables with one row per finished case: its swept values, then its figures."""

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np
import pandas as pd

from .study import Axis, Study
from .table import Column, Table

AT_ONCE = 4096  # rows in memory
Headings = Sequence[tuple[str, str]]  # figure, its heading in a table


def case_table(study: Study, key: str, title: str, columns: Headings, by: str) -> Table:
    """Return columns of the summary that are there, the largest of the column `by` first; no rows without that."""
    present = [(column, heading) for column, heading in columns if column in study.cases]
    heads = (
        Column("case_id"),
        *axis_columns(study, study.swept()),
        *(Column(heading, study.unit(column)) for column, heading in present),
    )
    if by not in dict(present) or study.cases.empty:
        return Table(key, title, "", heads, [])
    order = np.argsort(-study.cases[by].to_numpy(float), kind="stable")  # without a value: last
    shown = [*(axis.path for axis in study.swept()), *(column for column, _ in present)]
    note = f"Sorted by {dict(present)[by]}, largest first."
    return Table(key, title, note, heads, CaseRows(study.cases, order, shown))


class CaseRows(Sequence):
    """Rows of a table, one per case, made as they are read: of a million cases a page shows a few."""

    def __init__(self, cases: pd.DataFrame, order: np.ndarray, columns: list[str]):
        """Take cases by case_id, the order of their rows, and the columns behind case_id."""
        self.cases, self.order, self.columns = cases, order, columns

    def __len__(self) -> int:
        return len(self.order)

    @overload
    def __getitem__(self, which: int) -> tuple: ...
    @overload
    def __getitem__(self, which: slice) -> list[tuple]: ...
    def __getitem__(self, which: int | slice) -> tuple | list[tuple]:
        if isinstance(which, int):
            return self[which : which + 1 or None][0]
        places = self.order[which]
        values = [self.cases.index[places].tolist()]
        values += [self.cases[column].iloc[places].tolist() for column in self.columns]
        return list(zip(*values, strict=True))

    def __iter__(self) -> Iterator[tuple]:
        for start in range(0, len(self), AT_ONCE):
            yield from self[start : start + AT_ONCE]


def axis_columns(study: Study, axes: Sequence[Axis]) -> list[Column]:
    """Return the columns that hold the values of some axes."""
    return [Column(axis.name, study.unit(axis.path), axis) for axis in axes]
