"""Tables with one row per finished case: its swept values, then its figures."""

from collections.abc import Sequence

from .study import Axis, Study
from .table import Column, Table

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
    ordered = study.cases.sort_values(by, ascending=False, kind="stable", na_position="last")
    values = [ordered.index]
    values += [ordered[axis.path] for axis in study.swept()]
    values += [ordered[column] for column, _ in present]
    note = f"Sorted by {dict(present)[by]}, largest first."
    return Table(key, title, note, heads, list(zip(*values, strict=True)))


def axis_columns(study: Study, axes: Sequence[Axis]) -> list[Column]:
    """Return the columns that hold the values of some axes."""
    return [Column(axis.name, study.unit(axis.path), axis) for axis in axes]
