"""Reads the rows of tables: CSV with any usual separator and decimal sign, Excel and Parquet files."""

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...language.errors import InputError
from .document import check_regular_file

if TYPE_CHECKING:  # few grids name workbooks
    import zipfile
    from xml.etree import ElementTree

TableRow = tuple[int, list[Any]]  # number and cells

_HEADER_PATTERN = re.compile(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\]\s*)?")
_DECIMAL_COMMA = re.compile(r"\s*[+-]?(\d*),(\d+)(?:[eE][+-]?\d+)?(?=\s|$|[^\d,.])")
_SHEET_PATTERN = re.compile(r"xl/worksheets/sheet(\d+)\.xml")
_CELL_PATTERN = re.compile(r"([A-Z]{1,3})\d+")
MAX_PART_BYTES = 256 * 2**20  # bytes of a part of a workbook, unpacked


def split_header(heading: str) -> tuple[str, str]:
    """Return name and unit of a column header such as `drive.speed [rpm]`; '' for a missing part."""
    match = _HEADER_PATTERN.fullmatch(heading)
    return (match[1], (match[2] or "").strip()) if match else ("", "")


def rows_of_csv(file: Path) -> tuple[list[str], list[TableRow]]:
    """Return the headers, and line number and cells of every row that is not blank.

    Columns are separated by the first of tab, semicolon and comma that the header contains; numbers of the first two
    may have a decimal comma.  Raises ValueError where a comma may be a decimal or a thousands separator.
    """
    with open(file, newline="", encoding="utf-8-sig") as stream:
        first_line = stream.readline()
        separator = next((sign for sign in "\t;" if sign in first_line), ",")
        stream.seek(0)
        lines = csv.reader(stream, delimiter=separator)
        headers = next(lines, [])
        rows = [(lines.line_num, cells) for cells in lines if any(cell.strip() for cell in cells)]
    return headers, rows if separator == "," else _with_decimal_points(rows)


def _with_decimal_points(rows: list[TableRow]) -> list[TableRow]:
    """Return rows with decimal points in place of commas; ValueError if it is not clear what the commas mean."""
    commas = [(line, cell, match) for line, cells in rows for cell in cells if (match := _DECIMAL_COMMA.match(cell))]
    if not commas:
        return rows
    point = next((line for line, cells in rows for cell in cells if re.match(r"\s*[+-]?\d*\.\d", cell)), None)
    if point is not None:
        raise ValueError(
            f"row {commas[0][0]} has the decimal comma of {commas[0][1].strip()!r}, row {point} a decimal point; write "
            "one of the two"
        )
    if all(len(match[2]) == 3 and match[1].lstrip("0") for *_, match in commas):
        raise ValueError(
            f"row {commas[0][0]}: {commas[0][1].strip()!r} may be a fraction or thousands; write a decimal point"
        )
    return [
        (line, [cell.replace(",", ".", 1) if _DECIMAL_COMMA.match(cell) else cell for cell in cells])
        for line, cells in rows
    ]


def complete_rows_of_csv(path: Path, max_bytes: int) -> tuple[list[str], list[TableRow]]:
    """Return headers and rows as `rows_of_csv`.

    Raise InputError, with the row, if a row lacks a cell or has too many.
    """
    try:
        check_regular_file(path, max_bytes)
        headers, rows = rows_of_csv(path)
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    for line, cells in rows:
        if len(cells) != len(headers):
            raise InputError(
                f"{path}:{line}: the row has {len(cells)} cells but the header has {len(headers)}; write every value"
            )
    return headers, rows


def rows_of_parquet(file: Path) -> tuple[list[str], list[TableRow]]:
    """Return the headers, and number and cells of every row."""
    import pyarrow.parquet as pq

    with pq.ParquetFile(file, pre_buffer=False) as content:
        table = content.read(use_threads=False)
    columns = [table.column(k).to_pylist() for k in range(table.num_columns)]
    rows = zip(*columns, strict=True)
    return table.column_names, [(number, list(cells)) for number, cells in enumerate(rows, start=1)]


def rows_of_xlsx(file: Path, sheet: int = 1) -> tuple[list[str], list[TableRow]]:
    """Return the headers, and number and cells of every row of a sheet of an Excel workbook that is not blank.

    sheet : its number, 1 for the first.  Values of formulas are those that Excel stored.  Raises ValueError if the
    file is no workbook or has no such sheet.
    """
    import zipfile
    from xml.etree import ElementTree

    try:
        with zipfile.ZipFile(file) as book:
            sheets = {int(match[1]): name for name in book.namelist() if (match := _SHEET_PATTERN.fullmatch(name))}
            if sheet not in sheets:
                raise ValueError(f"has {len(sheets)} sheets; there is no sheet {sheet}")
            shared = _shared_texts(book) if "xl/sharedStrings.xml" in book.namelist() else []
            root = _part(book, sheets[sheet])
        rows = _rows_of_sheet(root, shared)
    except (zipfile.BadZipFile, ElementTree.ParseError, LookupError, NotImplementedError, RuntimeError) as error:
        raise ValueError(f"is no Excel workbook (.xlsx), or is encrypted: {error}") from None
    if not rows:
        return [], []
    headers = [str(cell) for cell in rows[0][1]]
    width = len(headers)
    return headers, [(number, cells + [""] * (width - len(cells))) for number, cells in rows[1:]]


def _rows_of_sheet(root: "ElementTree.Element", shared: list[str]) -> list[TableRow]:
    """Return number and cells of every row that is not blank."""
    rows = []
    for number, row in enumerate(root.iterfind(".//{*}sheetData/{*}row"), start=1):
        cells = {_column(cell, k): _cell_value(cell, shared) for k, cell in enumerate(row.iterfind("{*}c"))}
        if any(value not in ("", None) for value in cells.values()):
            rows.append((int(row.get("r", number)), [cells.get(k, "") for k in range(max(cells) + 1)]))
    return rows


def _part(book: "zipfile.ZipFile", name: str) -> "ElementTree.Element":
    """Return a part of a workbook; ValueError if it is too large once it is unpacked."""
    from xml.etree import ElementTree

    if book.getinfo(name).file_size > MAX_PART_BYTES:
        raise ValueError(f"its part {name} has more than {MAX_PART_BYTES:,} bytes")
    return ElementTree.fromstring(book.read(name))  # expat limits the expansion of entities


def _shared_texts(book: "zipfile.ZipFile") -> list[str]:
    items = _part(book, "xl/sharedStrings.xml").iterfind("{*}si")
    return ["".join(text.text or "" for text in item.iterfind(".//{*}t")) for item in items]


def _column(cell: "ElementTree.Element", default: int) -> int:
    """Return the number of the column of a cell, 0 for the first: 27 of AB4."""
    match = _CELL_PATTERN.fullmatch(cell.get("r", ""))
    if not match:
        return default
    number = 0
    for letter in match[1]:
        number = 26 * number + ord(letter) - ord("A") + 1
    return number - 1


def _cell_value(cell: "ElementTree.Element", shared: list[str]) -> Any:
    """Return the value of a cell: text, or the text of a number; `=` and a formula whose value is not stored."""
    if cell.get("t") == "inlineStr":
        return "".join(text.text or "" for text in cell.iterfind(".//{*}t"))
    content, formula = cell.findtext("{*}v") or "", cell.findtext("{*}f")
    if cell.get("t") == "s" and content:
        return shared[int(content)]
    if cell.get("t") == "b":
        return "TRUE" if content == "1" else "FALSE"
    return content or (f"={formula}" if formula else "")


#: Ending of the name of a file -> the function that reads its rows.
READERS: dict[str, Callable[..., tuple[list[str], list[TableRow]]]] = {
    ".csv": rows_of_csv,
    ".tsv": rows_of_csv,
    ".txt": rows_of_csv,
    ".xlsx": rows_of_xlsx,
    ".parquet": rows_of_parquet,
}
KNOWN_FILES_TEXT = "a .csv, .xlsx or .parquet file"
