"""Tables of the report: columns and rows in SI for the CSV file, and as text with units for the page."""

import csv
import io
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, overload

import numpy as np

from ... import simulation
from ...answers import verdict
from ...contracts.layout import Column as LayoutColumn
from ...language import wording
from ...language.wording import is_missing
from ...store import durable
from ..axis import Axis, Rows
from ..study import COMPUTED_FIGURES, Joint, Study

# A table of the report: its columns and rows in SI for the CSV file, and as text with units for the page.

PAGE_ROWS = 50  # rows of a table on the page and in Markdown; the CSV has all
CONVERTED_DIGITS = 15  # digits of a value in another unit than SI
_MARKDOWN_ESCAPES = str.maketrans(
    {"|": r"\|", "&": "&amp;", "<": "&lt;", ">": "&gt;", "[": r"\[", "`": r"\`", "\\": "\\\\"}
)
#: A spreadsheet runs such a text as a formula, at the start of a cell; in some countries a semicolon separates cells.
_FORMULA_START = re.compile(r"(^|[;\t\r\n])(?=\s*[=+\-@\uff1d\uff0b\uff0d\uff20])")
_UNSAFE_CHARACTERS = re.compile(r"[^\w.-]|^\.+")  # in file names


class Column(NamedTuple):
    """One column of a table: its name in words, its SI unit ('1' for none), and its axis, if it has one."""

    name: str
    unit: str = "1"
    axis: Axis | None = None
    file_only: bool = False  # only in the CSV
    heading: str = ""  # on the page, if it differs from the name in the file


class Quantity(NamedTuple):
    """One cell with a unit of its own: a number in the CSV, number and unit on the page."""

    value: float | str | None  # SI
    text: str


class Head(NamedTuple):
    """The head of a column on the page."""

    name: str
    unit: str  # '' for none
    numeric: bool  # no cell is a word


class TableText(NamedTuple):
    """A table in text, cut to the rows that the page shows."""

    heads: list[Head]
    rows: list[list[str]]
    total_rows: int  # of the whole table


class Table(NamedTuple):
    """One table: `rows` in SI, in the order in which they are shown."""

    key: str  # name of the CSV file
    title: str
    note: str
    columns: Sequence[Column]
    rows: Sequence[tuple]
    is_file: bool = True  # whether it is written as a file; not if another table has all its rows

    def to_text(self) -> TableText:
        """Return the table in text: heads with readable units, the first PAGE_ROWS rows."""
        heads, column_texts, first_rows = [], [], self.rows[:PAGE_ROWS]
        for column_index, column in enumerate(self.columns):
            if column.file_only:
                continue
            values = [row[column_index] for row in first_rows]
            scale = _scale(column, values)
            numeric = not any(isinstance(_si_value(value), str) for value in values)
            heads.append(Head(column.heading or column.name, scale.unit, numeric))
            column_texts.append([_cell_text(value, column, scale) for value in values])
        return TableText(heads, [list(row) for row in zip(*column_texts, strict=True)], len(self.rows))

    def write(self, directory: Path) -> list[Path]:
        """Write the table into a directory, as `csv` and as `markdown`; return the files."""
        name = _UNSAFE_CHARACTERS.sub("_", self.key)
        files = [directory / f"{name}.{ending}" for ending in ("csv", "md")]
        texts = (self.csv(), self.markdown())
        # the beginning of the CSV that does not depend on the units of a run
        starts = (texts[0].partition("[")[0].partition(",")[0].rstrip(), f"### {escape_markdown(self.title)}\n")
        for file, text, start in zip(files, texts, starts, strict=True):
            durable.replace_output(file, text.encode(), start.encode())
        return files

    def csv(self) -> str:
        """Return the table with all its rows as CSV, in SI, axes in the unit of the grid; the unit is in the head.

        A column with the labels follows the values of an axis that has labels.
        """
        text = io.StringIO(newline="")
        writer = csv.writer(text)
        writer.writerow([head for column in self.columns for head in _file_heads(column)])
        writer.writerows(
            [cell for value, column in zip(row, self.columns, strict=True) for cell in _file_cells(value, column)]
            for row in self.rows
        )
        return text.getvalue()

    def markdown(self) -> str:
        """Return the table as Markdown, with the rows of the page, numbers to the right and units in the header."""
        table_text = self.to_text()
        escaped_names = [escape_markdown(head.name) for head in table_text.heads]
        heads = [
            f"{name} [{head.unit}]" if head.unit else name
            for name, head in zip(escaped_names, table_text.heads, strict=True)
        ]
        alignments = ["---:" if head.numeric else "---" for head in table_text.heads]
        body = [[escape_markdown(cell) for cell in cells] for cells in table_text.rows]
        rows = [f"| {' | '.join(cells)} |" for cells in (heads, alignments, *body)]
        cut_note = (
            f" The first {PAGE_ROWS} of {table_text.total_rows} rows; {self.key}.csv has all."
            if table_text.total_rows > PAGE_ROWS
            else ""
        )
        note = escape_markdown(f"{self.note}{cut_note}".strip())
        return "\n".join([f"### {escape_markdown(self.title)}", "", *([note, ""] if note else []), *rows, ""])


def escape_markdown(text: str) -> str:
    """Return a text escaped for Markdown, so that no part of it is markup, a link or the end of a cell."""
    return text.translate(_MARKDOWN_ESCAPES)


def count_cell(count: int) -> Quantity:
    """Return the cell of a count."""
    return Quantity(count, str(count))


def columns_of(head: str) -> list[Column]:
    """Return the columns of a head such as 'joint | peak [N] | law*', in which a star marks those only in the CSV."""
    columns = []
    for cell in head.split(" | "):
        name, _, unit = cell.removesuffix("*").removesuffix("]").partition(" [")
        columns.append(Column(name, unit or "1", file_only=cell.endswith("*")))
    return columns


def _file_heads(column: Column) -> list[str]:
    """Return the heads in the CSV of a column and, if its axis has labels, of its labels."""
    labels = [_without_formula(f"{column.name} label")] if column.axis is not None and column.axis.labels else []
    # Head of a column in the CSV, with its unit
    unit = column.unit
    if column.axis is not None and column.axis.has_written_unit:
        unit = column.axis.scale.unit.replace(wording.BLANK, "*")
    file_head = _without_formula(column.name if unit in ("1", "") else f"{column.name} [{unit}]")
    return [file_head, *labels]


def _file_cells(value: Any, column: Column) -> list[object]:
    """Return the cells in the CSV of a value and, if its axis has labels, its label."""
    labels = column.axis.labels if column.axis is not None else {}
    return [_file_value(value, column), *([_without_formula(labels.get(_si_value(value), ""))] if labels else [])]


def _scale(column: Column, values: list) -> wording.Scale:
    """Return the unit in which the page shows a column."""
    if column.axis is not None:
        return column.axis.scale
    if values and all(isinstance(value, Quantity) for value in values):
        return wording.Scale(1.0, "")  # each carries its unit
    return wording.scale(column.unit, [value for value in values if not isinstance(value, str | Quantity)])


def _cell_text(value: Any, column: Column, scale: wording.Scale) -> str:
    """Return a cell as the page shows it."""
    if isinstance(value, Quantity):
        return value.text
    if is_missing(value):
        return wording.DASH
    if isinstance(value, str):
        return value
    return scale.number_text(value) if column.axis is None else column.axis.number_text(value)


def _file_value(value: Any, column: Column) -> object:
    """Return a cell as the CSV contains it: in SI, or in the written unit of its axis."""
    value = _si_value(value)
    if (
        column.axis is not None
        and column.axis.has_written_unit
        and not isinstance(value, str)
        and not is_missing(value)
    ):
        value = float(f"{column.axis.scale.from_si(value):.{CONVERTED_DIGITS}g}")
    return _without_formula(value) if isinstance(value, str) else "" if is_missing(value) else value


def _without_formula(text: str) -> str:
    """Return a text changed so that a spreadsheet does not run it as a formula."""
    return _FORMULA_START.sub(r"\1'", text)


def _si_value(value: Any) -> Any:
    """Return the SI value of a cell."""
    return value.value if isinstance(value, Quantity) else value


# Tables with one row per finished case: its swept values, then its figures.

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
        *map(Column, study.label_columns),
        *axis_columns(study, study.swept()),
        *(Column(heading, study.unit(column)) for column, heading in available),
    )
    if sort_column not in dict(available) or study.cases.empty:
        return Table(key, title, "", table_columns, [])
    column_names = [*study.label_columns, *(axis.path for axis in study.swept()), *(column for column, _ in available)]
    note = f"Sorted by {dict(available)[sort_column]}, {'smallest' if smallest else 'largest'} first."
    return Table(key, title, note, table_columns, CaseRows(study.cases, column_names, sort_column, smallest=smallest))


class CaseRows(Sequence):
    """Rows of a table, one per case, computed as they are read: a page shows only a few of a million cases."""

    def __init__(self, cases: Rows, columns: list[str], sort_column: str = "", *, smallest: bool = False):
        """Take the cases, the columns after case_id, and the column and direction of the order."""
        self.cases, self.columns, self.sort_column, self.smallest = cases, columns, sort_column, smallest
        self.texts: dict[int, dict[str, str]] = {}  # number of a column -> case_id -> text in place of the value

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
        row_numbers = self._order()[selection].copy()  # a view would keep all indices while columns are read
        values = [self.cases.index[row_numbers].tolist()]
        values += [self.cases[column][row_numbers].tolist() for column in self.columns]
        return list(map(self._with_texts, zip(*values, strict=True)))

    def __iter__(self) -> Iterator[tuple]:
        order = self._order()
        columns = [self.cases.index, *(self.cases[column] for column in self.columns)]
        for start in range(0, len(self), CHUNK_ROWS):
            row_numbers = order[start : start + CHUNK_ROWS]
            yield from map(self._with_texts, zip(*(column[row_numbers].tolist() for column in columns), strict=True))

    def _with_texts(self, row: tuple) -> tuple:
        """Return a row with its texts in place of values; its first cell is the case_id."""
        for column, text_of_case in self.texts.items():
            if text := text_of_case.get(row[0]):
                row = (*row[:column], Quantity(row[column], text), *row[column + 1 :])
        return row


def axis_columns(study: Study, axes: Sequence[Axis]) -> list[Column]:
    """Return the columns with the values of some axes."""
    return [Column(axis.name, study.unit(axis.path), axis) for axis in axes]


# Determines the figures, the order and the headings of a table from the descriptions of the figures.


def columns_in_table(study: Study, table: str, joint: Joint | None = None) -> list[tuple[str, str]]:
    """Return column and heading of the figures of a joint and of the mechanism in a table, the joint's first.

    Without `joint`, the figures of all joints are returned; if there are several joints, headings name them.
    """
    computed_figures = [figure for figure, _, _ in COMPUTED_FIGURES]
    entries = {figure.name: figure.tables for figure in (*simulation.catalogue().figures, *computed_figures)}
    joint_order = {joint.name: joint_index for joint_index, joint in enumerate(study.joints)}
    ordered_columns = []
    computed = (
        LayoutColumn(joint.column(figure.name), figure.unit, figure.text, figure=figure.name, joint=joint.name)
        for joint in study.joints
        for figure in computed_figures
    )
    for column in (*study.run.layout.columns, *computed):
        if column.name in study.cases and (joint is None or column.joint in ("", joint.name)):
            for entry in entries.get(column.figure, ()):
                if entry.table == table and not (entry.if_any and not (study.cases[column.name] > 0.0).any()):
                    order = (joint_order.get(column.joint, len(joint_order)), entry.order)
                    ordered_columns.append(
                        (order, column.name, _heading(study, entry.heading, "" if joint else column.joint))
                    )
    return [(name, heading) for _, name, heading in sorted(ordered_columns, key=lambda column_entry: column_entry[0])]


def column_label(study: Study, column: str) -> str:
    """Return the label of a column, as in the last lines of a run."""
    return verdict.column_label(study.run.layout, column)


def _heading(study: Study, heading: str, joint: str) -> str:
    """Return a complete heading, which names `joint` if there are several joints."""
    short = "rev." if study.turn == "revolution" else study.turn
    rate_texts = {"per_rev": f" per {short}", "per_revolution": f" per {study.turn}"} if study.is_driven else {}
    text = heading.format_map({"output": study.run.layout.output, "per_rev": "", "per_revolution": ""} | rate_texts)
    return text + next(
        (study.joint_text(known_joint, " ({})") for known_joint in study.joints if known_joint.name == joint), ""
    )
