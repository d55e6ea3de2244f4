"""A table of the report: its columns and rows in SI for the CSV file, and as text with units for the page."""

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from ...language import wording
from ...store import durable
from ..data.axis import Axis

SHOWN = 50  # rows of a table on the page and in Markdown; the CSV has all
EXACT = 15  # digits of a value in another unit than SI
_MARKUP = str.maketrans({"|": r"\|", "&": "&amp;", "<": "&lt;", ">": "&gt;", "[": r"\[", "`": r"\`", "\\": "\\\\"})
_FORMULA = ("=", "+", "-", "@")  # a text that begins so is a formula to a spreadsheet
_UNFIT = re.compile(r"[^\w.-]|^\.+")  # what no name of a file has


class Column(NamedTuple):
    """One column of a table: its name in words, its SI unit ('1' for none), and its axis, if it has one."""

    name: str
    unit: str = "1"
    axis: Axis | None = None
    file_only: bool = False  # left out on the page, where the cells carry it


class Quantity(NamedTuple):
    """One cell with a unit of its own: a number in the CSV, number and unit on the page."""

    value: float | str | None  # SI
    text: str


class Head(NamedTuple):
    """The head of a column on the page."""

    name: str
    unit: str  # '' for none
    numeric: bool  # nothing in it is a word


class Shown(NamedTuple):
    """A table in text, cut to the rows that the page shows."""

    heads: list[Head]
    rows: list[list[str]]
    total: int  # rows there are in all


class Table(NamedTuple):
    """One table: `rows` in SI, in the order in which they are shown."""

    key: str  # name of the CSV file
    title: str
    note: str
    columns: tuple[Column, ...]
    rows: Sequence[tuple]
    is_file: bool = True  # whether it is written as a file; not if another table has all its rows

    def shown(self) -> Shown:
        """Return the table in text: heads with units for people, the first SHOWN rows."""
        heads, cells, first = [], [], self.rows[:SHOWN]
        for place, column in enumerate(self.columns):
            if column.file_only:
                continue
            values = [row[place] for row in first]
            scale = _scale(column, values)
            numeric = not any(isinstance(_bare(value), str) for value in values)
            heads.append(Head(column.name, scale.unit, numeric))
            cells.append([_cell(value, column, scale) for value in values])
        return Shown(heads, [list(row) for row in zip(*cells, strict=True)], len(self.rows))

    def write(self, directory: Path) -> list[Path]:
        """Write the table into a directory, as `csv` and as `markdown`; return the files."""
        name = _UNFIT.sub("_", self.key)
        files = [directory / f"{name}.{ending}" for ending in ("csv", "md")]
        for file, text in zip(files, (self.csv(), self.markdown()), strict=True):
            durable.replace(file, text.encode())
        return files

    def csv(self) -> str:
        """Return the table with all its rows as CSV, in SI, axes in the unit of the grid; the unit is in the head.

        A column with the labels follows the values of an axis that has labels.
        """
        text = io.StringIO(newline="")
        writer = csv.writer(text)
        writer.writerow([head for column in self.columns for head in _heads(column)])
        writer.writerows(
            [cell for value, column in zip(row, self.columns, strict=True) for cell in _cells(value, column)]
            for row in self.rows
        )
        return text.getvalue()

    def markdown(self) -> str:
        """Return the table as Markdown, with the rows of the page, numbers to the right and units in the header."""
        view = self.shown()
        names = [in_markdown(head.name) for head in view.heads]
        heads = [f"{name} [{head.unit}]" if head.unit else name for name, head in zip(names, view.heads, strict=True)]
        rules = ["---:" if head.numeric else "---" for head in view.heads]
        body = [[in_markdown(cell) for cell in cells] for cells in view.rows]
        rows = [f"| {' | '.join(cells)} |" for cells in (heads, rules, *body)]
        cut = f" The first {SHOWN} of {view.total} rows; {self.key}.csv has all." if view.total > SHOWN else ""
        note = in_markdown(f"{self.note}{cut}".strip())
        return "\n".join([f"### {in_markdown(self.title)}", "", *([note, ""] if note else []), *rows, ""])


def in_markdown(text: str) -> str:
    """Return a text escaped for Markdown, so that no part of it is markup, a link or the end of a cell."""
    return text.translate(_MARKUP)


def counted(number: int) -> Quantity:
    """Return the cell of a count."""
    return Quantity(number, str(number))


def _heads(column: Column) -> list[str]:
    labels = [_inert(f"{column.name} label")] if column.axis is not None and column.axis.labels else []
    return [_head(column), *labels]


def _cells(value: Any, column: Column) -> list[object]:
    labels = column.axis.labels if column.axis is not None else {}
    return [_plain(value, column), *([_inert(labels.get(_bare(value), ""))] if labels else [])]


def _head(column: Column) -> str:
    unit = column.unit
    if column.axis is not None and column.axis.written:
        unit = column.axis.scale.unit.replace(wording.BLANK, "*")
    return _inert(column.name if unit in ("1", "") else f"{column.name} [{unit}]")


def _scale(column: Column, values: list) -> wording.Scale:
    if column.axis is not None:
        return column.axis.scale
    if values and all(isinstance(value, Quantity) for value in values):
        return wording.Scale(1.0, "")  # each carries its unit
    return wording.scale(column.unit, [value for value in values if not isinstance(value, str | Quantity)])


def _cell(value: Any, column: Column, scale: wording.Scale) -> str:
    if isinstance(value, Quantity):
        return value.text
    if missing(value):
        return wording.DASH
    if isinstance(value, str):
        return value
    return scale.number(value) if column.axis is None else column.axis.number(value)


def _plain(value: Any, column: Column) -> object:
    value = _bare(value)
    if column.axis is not None and column.axis.written and not isinstance(value, str) and not missing(value):
        value = float(f"{column.axis.scale.of(value):.{EXACT}g}")
    return _inert(value) if isinstance(value, str) else "" if missing(value) else value


def _inert(text: str) -> str:
    """Return a text changed so that a spreadsheet does not run it as a formula."""
    return f"'{text}" if text.startswith(_FORMULA) else text


def _bare(value: Any) -> Any:
    return value.value if isinstance(value, Quantity) else value


def missing(value: object) -> bool:
    """Return whether a cell has no value."""
    return value is None or bool(pd.isna(value))
