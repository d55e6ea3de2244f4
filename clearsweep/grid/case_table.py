"""Reads a table of cases, a CSV or Parquet file; the head of a column is a dotted path and a unit, as `a.b [mm]`."""

import csv
import re
from pathlib import Path
from typing import Any

from .document import Problems, WrittenValue, refuse_endless

_HEAD = re.compile(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\]\s*)?")
_MOST_ROWS = 1_000_000
_LARGEST = 512 * 2**20  # bytes of a table: 500 for each row

TableRow = tuple[int, list[Any]]  # number and cells


def read(problems: Problems, written: WrittenValue) -> WrittenValue | None:
    """Return the columns of the table that `written` names, path -> list of values, or None if it is invalid.

    The file is next to the grid.  Every value knows its file, row (1 is the header; a Parquet file has none, so its
    first case is row 1) and column.
    """
    file = Path(written.origin).parent / written.value if written.line else Path(written.value)
    readers = {".csv": rows_of_csv, ".parquet": _parquet}
    if file.suffix.lower() not in readers:
        problems.add(written, "cases", f"found '{written.value}'; expected the name of a .csv or .parquet file")
        return None
    try:
        refuse_endless(file, _LARGEST)
        heads, rows = readers[file.suffix.lower()](file)
    except FileNotFoundError:
        problems.add(written, "cases", f"there is no file {file}; the name is relative to the grid's directory")
        return None
    except (OSError, ValueError, csv.Error) as error:  # pyarrow's errors are ValueErrors
        reason = getattr(error, "strerror", None) or error
        problems.add(written, "cases", f"{file} cannot be read: {reason}")
        return None
    if not rows or len(rows) > _MOST_ROWS:
        problems.add(written, "cases", f"{file} contains {len(rows)} cases; expected 1 to {_MOST_ROWS}")
        return None
    return _columns(problems, str(file), heads, rows)


def head_of(heading: str) -> tuple[str, str]:
    """Return name and unit of a column header such as `drive.speed [rpm]`; '' for a missing part."""
    match = _HEAD.fullmatch(heading)
    return (match[1], (match[2] or "").strip()) if match else ("", "")


def rows_of_csv(file: Path) -> tuple[list[str], list[TableRow]]:
    """Return the headers, and line number and cells of every row that is not blank."""
    with open(file, newline="", encoding="utf-8-sig") as stream:
        lines = csv.reader(stream)
        heads = next(lines, [])
        return heads, [(lines.line_num, cells) for cells in lines if any(cell.strip() for cell in cells)]


def _parquet(file: Path) -> tuple[list[str], list[TableRow]]:
    """Return the headers, and number and cells of every row."""
    import pyarrow.parquet as pq

    with pq.ParquetFile(file, pre_buffer=False) as content:
        table = content.read(use_threads=False)
    columns = [table.column(k).to_pylist() for k in range(table.num_columns)]
    rows = zip(*columns, strict=True)
    return table.column_names, [(number, list(cells)) for number, cells in enumerate(rows, start=1)]


def _columns(problems: Problems, origin: str, heads: list[str], rows: list[TableRow]) -> WrittenValue | None:
    """Return the columns of a table, or None if its rows do not match its header."""
    columns: dict[str, WrittenValue] = {}
    places: dict[str, WrittenValue] = {}
    units, is_valid = [], True
    for column, heading in enumerate(heads, start=1):
        cell_place = WrittenValue(None, origin, 1, column)
        path, unit = head_of(heading)
        if not path or path in columns:
            invalid = "occurs twice; keep one of them" if path else "is no head; expected a dotted path and its unit"
            problems.add(cell_place, "cases", f"column {column}: '{heading}' {invalid}, such as drive.speed [rpm]")
            is_valid = False
        columns[path], places[path] = WrittenValue([], origin, 1, column), cell_place
        units.append(unit)
    for line, cells in rows:
        if len(cells) != len(heads):
            sentence = f"row {line} has {len(cells)} cells but the header has {len(heads)}; write every value"
            problems.add(WrittenValue(None, origin, line, 1), "cases", sentence)
            is_valid = False
    if not is_valid:
        return None
    for line, cells in rows:
        for column, (values, cell, unit) in enumerate(zip(columns.values(), cells, units, strict=True), start=1):
            text = cell.strip() if isinstance(cell, str) else cell
            value = f"{text} {unit}" if unit and text not in ("", None) else None if text == "" else text
            values.value.append(WrittenValue(value, origin, line, column))
    return WrittenValue(columns, origin, 1, 1, places)
