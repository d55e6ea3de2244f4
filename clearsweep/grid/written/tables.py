"""Reads tables (cases, columns of a key, measured signals) from CSV or Parquet files, and dampings in per cent."""

import csv
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from ...contracts.catalogue import Columns, Field
from ...language import np, quantity
from ...language.errors import InputError, did_you_mean, mistake_of, quoted
from ...language.wording import count_text
from . import (
    AXIS_SECTIONS,
    KNOWN_FILES_TEXT,
    READERS,
    MistakeError,
    Problems,
    TableRow,
    WrittenValue,
    check_regular_file,
    complete_rows_of_csv,
    split_header,
)

# ----------------------------------------------------------------------------------------------------------------------
# Dampings in per cent: of a housing they are ratios, under the key `damping_ratio`.


DAMPING, RATIO = "damping", "damping_ratio"
_DAMPING_PATH = re.compile(rf"(mechanism\.mounts\.[^.]+)\.{DAMPING}((?:\.[01])?)")


def with_damping_ratios(root: WrittenValue, problems: Problems) -> WrittenValue:
    """Return a document in which every damping of a housing in per cent is under the key `damping_ratio`.

    Raises InputError if one is in per cent and the other is not.
    """

    def renamed_axis(path: str, content: WrittenValue) -> str:
        match = _DAMPING_PATH.fullmatch(path)
        return f"{match[1]}.{RATIO}{match[2]}" if match and _is_in_per_cent(content) else path

    def renamed_key(key: str, content: WrittenValue) -> str:
        if key != DAMPING or not _is_in_per_cent(content, any):
            return key
        if not _is_in_per_cent(content):
            message = "% is allowed only for quantities without a unit; write both dampings in %, or both in N*s/m"
            problems.add(content, "mechanism.mounts", message)
            problems.check()
        return RATIO

    mechanism = root.value.get("mechanism", WrittenValue({}))
    mounts = mechanism.entries.get("mounts", WrittenValue({}))
    if mounts.entries:
        renamed = {name: _renamed(mount, renamed_key) for name, mount in mounts.value.items()}
        mechanism = mechanism.with_value(mechanism.value | {"mounts": mounts.with_value(renamed)})
        root = root.with_value(root.value | {"mechanism": mechanism})
    sections = {name: _renamed(root.value[name], renamed_axis) for name in AXIS_SECTIONS if name in root.value}
    return root.with_value(root.value | sections)


def _renamed(section: WrittenValue, name_of: Callable[[str, WrittenValue], str]) -> WrittenValue:
    """Return a section whose keys have other names; anything else stays."""
    names = {key: name_of(key, content) for key, content in section.entries.items()}
    if all(key == name for key, name in names.items()):
        return section
    if len({*names.values()}) < len(names):
        message = f"{DAMPING} in % conflicts with `{RATIO}`, which it is; write one of them"
        raise InputError(f"{section.position_text}mechanism.mounts: {message}")
    keys = {names.get(key, key): place for key, place in section.keys.items()}
    return replace(section, value={names[key]: value for key, value in section.value.items()}, keys=keys)


def _is_in_per_cent(written: WrittenValue, number: Callable[[Iterable[bool]], bool] = all) -> bool:
    """Return whether all (or any) values of a list or a section, or the only value, are in per cent."""
    texts = list(leaf_values(written))
    return bool(texts) and number(isinstance(text, str) and text.rstrip(" ]}").endswith("%") for text in texts)


def leaf_values(written: WrittenValue) -> Iterator[Any]:
    """Yield every text in a value, an axis or a distribution."""
    if isinstance(written.value, (dict, list)):
        items = written.value.values() if isinstance(written.value, dict) else written.value
        for item in items:
            yield from leaf_values(item)
    else:
        yield written.value


# ----------------------------------------------------------------------------------------------------------------------
# Reads tables: cases, columns of a key, and measured signals, from CSV or Parquet files.


_MAX_CASES = 1_000_000
_MAX_CASES_BYTES = 512 * 2**20  # bytes of a table: 500 for each row

LABEL = "label"  # header of a column of texts that ride along


class CasesTable(NamedTuple):
    """The columns of a table of cases."""

    columns: WrittenValue  # dotted path -> list of values
    labels: dict[str, list[str]]  # header -> texts that ride along


def is_table(section: WrittenValue) -> bool:
    """Return whether the section `cases` names a file."""
    return isinstance(section.value, str) or "table" in section.entries


_CASES_KEYS = ("table", "sheet", "columns", "label")


def read_cases(problems: Problems, section: WrittenValue) -> CasesTable:
    """Return the columns of the table that `cases` names; MistakeError if it is invalid.

    section : the name of a file next to the grid, or {table, sheet, columns: {header: path [unit]}, label}
    Every value has its file, row (1 is the header; a Parquet file has none, so its first case is row 1) and column.
    """
    keys = _checked_keys(problems, section)
    sheet = [int(keys["sheet"].value)] if "sheet" in keys else []
    file, headers, rows = _rows_of_file("cases", keys["table"], _MAX_CASES_BYTES, KNOWN_FILES_TEXT, *sheet)
    if not rows or len(rows) > _MAX_CASES:
        raise MistakeError(keys["table"], "cases", f"{file} contains {len(rows)} cases; expected 1 to {_MAX_CASES}")
    names, columns, label = [header.strip() for header in headers], keys.get("columns"), keys.get("label")
    paths = {name: entry.value for name, entry in columns.value.items()} if columns else {}
    wanted = [(name, columns.key_position(name)) for name in paths if columns]
    wanted += [(label.value, label)] if label else []
    known = {*names, *(split_header(name)[0] for name in names)}
    missing = [(name, position) for name, position in wanted if name not in known]
    for name, position in missing:
        hint = did_you_mean(name, names) or f" (found: {', '.join(names)})"
        problems.add(position, "cases", f"{file} has no column '{name}'{hint}")
    if missing:
        raise MistakeError(section, "cases")
    headers = [_mapped(name, paths) for name in names]
    return _case_columns(problems, file, headers, rows, label.value if label else None)


def _checked_keys(problems: Problems, section: WrittenValue) -> dict[str, WrittenValue]:
    """Return the keys of a table of cases; MistakeError if one is invalid."""
    keys = section.entries or {"table": section}
    count = len(problems)
    for key in keys:
        if key not in _CASES_KEYS:
            message = f"unknown key '{key}'{did_you_mean(key, _CASES_KEYS)} (allowed: {', '.join(_CASES_KEYS)})"
            problems.add(section.key_position(key), f"cases.{key}", message)
    table, sheet, columns, label = (keys.get(key) for key in _CASES_KEYS)
    assert table is not None  # `is_table`
    if sheet and (not str(sheet.value).isdigit() or str(sheet.value) == "0"):
        problems.add(sheet, "cases.sheet", f"found {quoted(sheet.value)}; expected the number of a sheet, 1 or more")
    entries = columns.value if columns else {}
    if columns and not (isinstance(entries, dict) and all(isinstance(item.value, str) for item in entries.values())):
        example = "{gap: 'joints.rod-slider.clearance [um]'}"
        problems.add(columns, "cases.columns", f"expected a path for each header, such as {example}")
    if label and not isinstance(label.value, str):
        problems.add(label, "cases.label", f"found {quoted(label.value)}; expected the header of a column")
    if not isinstance(table.value, str):
        problems.add(table, "cases.table", f"found {quoted(table.value)}; expected the name of {KNOWN_FILES_TEXT}")
    if len(problems) > count:
        raise MistakeError(section, "cases")
    return keys


def _rows_of_file(
    path: str, written: WrittenValue, most_bytes: int, kinds: str, *sheet: int
) -> tuple[str, list[str], list[TableRow]]:
    """Return the name of a file, its headers and its rows, each with a cell for every header.

    Raises MistakeError if it cannot be read, or is of none of these kinds.
    """
    file = Path(written.origin).parent / written.value if written.line else Path(written.value)
    suffix = file.suffix.lower()
    if suffix not in READERS or (suffix == ".parquet" and suffix not in kinds):
        raise MistakeError(written, path, f"found '{written.value}'; expected the name of {kinds}")
    try:
        check_regular_file(file, most_bytes)
        headers, rows = READERS[suffix](file, *(sheet if suffix == ".xlsx" else ()))
    except FileNotFoundError:
        message = f"there is no file {file}; the name is relative to the grid's directory"
        raise MistakeError(written, path, message) from None
    except (OSError, ValueError, csv.Error) as error:  # pyarrow's errors are ValueErrors
        message = f"{file} cannot be read: {getattr(error, 'strerror', None) or error}"
        raise MistakeError(written, path, message) from None
    for line, cells in rows:
        if len(cells) != len(headers):
            message = f"row {line} has {len(cells)} cells but the header has {len(headers)}; write every value"
            raise MistakeError(WrittenValue(None, str(file), line, 1), path, message)
    return str(file), headers, rows


def _mapped(header: str, paths: Mapping[str, str]) -> str:
    """Return the header that `columns` gives a column; its unit stays where the new one has none."""
    name, unit = split_header(header)
    mapped = paths.get(header) or paths.get(name)
    if mapped is None:
        return header
    return f"{mapped} [{unit}]" if unit and not split_header(mapped)[1] else mapped


def _case_columns(
    problems: Problems, origin: str, headers: list[str], rows: list[TableRow], label: str | None
) -> CasesTable:
    """Return the columns of a table; MistakeError if a header is invalid; label : header of the column of labels."""
    columns: dict[str, WrittenValue] = {}
    positions: dict[str, WrittenValue] = {}
    labels: dict[str, list[str]] = {}
    problems_before = len(problems)
    for index, header in enumerate(headers):
        header_position = WrittenValue(None, origin, 1, index + 1)
        path, unit = split_header(header)
        cells = [(line, row[index].strip() if isinstance(row[index], str) else row[index]) for line, row in rows]
        if path and path not in (*columns, *labels) and (path == label or _is_label(path, unit, cells)):
            labels[path] = [str(cell) for _, cell in cells]
            continue
        if not path or path in columns:
            invalid = (
                "occurs twice; keep one of them"
                if path
                else ("is not a valid header; expected a dotted path and its unit")
            )
            message = f"column {index + 1}: '{header}' {invalid}, such as drive.speed [rpm]"
            problems.add(header_position, "cases", message)
        values = [
            WrittenValue(
                f"{cell} {unit}" if unit and cell not in ("", None) else None if cell == "" else cell,
                origin,
                line,
                index + 1,
            )
            for line, cell in cells
        ]
        columns[path], positions[path] = WrittenValue(values, origin, 1, index + 1), header_position
    if len(problems) > problems_before:
        raise MistakeError(WrittenValue(None, origin), "cases")
    return CasesTable(WrittenValue(columns, origin, 1, 1, positions), labels)


def _is_label(name: str, unit: str, cells: list[tuple[int, Any]]) -> bool:
    """Return whether a column labels its rows: it is called `label`, or has texts below a name that is no path."""
    if name == LABEL:
        return True
    texts = [str(cell) for _, cell in cells]
    return "." not in name and not unit and any(texts) and not any(text[:1].isdigit() for text in texts)


_MAX_TABLE_BYTES = 16 * 2**20  # bytes of a file
_MAX_ROWS = 20_000
_MIN_RELATIVE_STEP = (
    1e-9  # smallest step between rows over the table's span; finer steps vanish in rounding when it repeats
)
#: Independent column -> spans over which a table repeats, and what it should span in words.
_PERIODS = {"crank_angle": ((2.0 * math.pi, 4.0 * math.pi), "360 or 720 deg"), "pitch": ((1.0,), "one pitch, 0 to 1")}

ColumnValues = dict[str, list[float]]  # column -> values in SI


def read_table(problems: Problems, path: str, written: WrittenValue, columns: Columns) -> ColumnValues:
    """Return the table at the key `path`; MistakeError if it is invalid."""
    table = written
    if isinstance(written.value, str):
        if path.rpartition(".")[0] in problems.unread:  # an expression, which is reported already
            raise MistakeError(written, path)
        table = _columns_of_csv(path, written, columns)
    elif not isinstance(written.value, dict):
        message = f"found {quoted(written.value)}; expected the name of {_kinds_of_table(columns)}"
        raise MistakeError(written, path, message)
    problems_before = len(problems)
    values = _read_columns(problems, path, table, columns)
    if len(problems) > problems_before:
        raise MistakeError(written, path)
    _check_table(path, written, table.value, values, columns)
    return values


def _kinds_of_table(columns: Columns) -> str:
    """Return in words how a table is written."""
    example = ", ".join(f"{field.name}: [...]" for field in (*columns.over[:1], *columns.values[:1]))
    return f"a .csv or .xlsx file, or its columns {{{example}}}"


def _columns_of_csv(path: str, written: WrittenValue, columns: Columns) -> WrittenValue:
    """Return the columns of a CSV file by header."""
    file, headers, rows = _rows_of_file(path, written, _MAX_TABLE_BYTES, _kinds_of_table(columns))
    if len(rows) < 2:
        message = f"has {count_text(len(rows), 'row')} of values below its header; write at least 2"
        raise MistakeError(WrittenValue(None, file, 1, 1), path, message)
    table, positions = {}, {}
    for column, header in enumerate(headers, start=1):
        position = WrittenValue(None, file, 1, column)
        if header.strip() in table:
            raise MistakeError(position, path, f"the column '{header.strip()}' occurs twice; keep one of them")
        cells = [WrittenValue(row[column - 1].strip(), file, line, column) for line, row in rows]
        table[header.strip()], positions[header.strip()] = WrittenValue(cells, file, 1, column), position
    return WrittenValue(table, written.origin, written.line, written.column, positions)


def _read_columns(problems: Problems, path: str, table: WrittenValue, columns: Columns) -> dict[str, list[float]]:
    """Return the values of the columns by name; report mistakes in them."""
    fields = {field.name: field for field in (*columns.over, *columns.values)}
    shown = {"rad": "deg", "rad/s": "rpm"}
    allowed = ", ".join(f"{field.name} [{shown.get(field.unit, field.unit)}]" for field in fields.values())
    values: dict[str, list[float]] = {}
    for header, cells in table.value.items():
        name, unit = split_header(header)
        field = fields.get(name)
        if field is None or name in values:
            invalid = "occurs twice" if field else f"is not a column of this table{did_you_mean(name, fields)}"
            problems.add(table.key_position(header), path, f"'{header}' {invalid} (known: {allowed})")
        elif not isinstance(cells.value, list):
            problems.add(cells, f"{path}.{header}", f"found {quoted(cells.value)}; expected a list of values")
        elif len(cells.value) > _MAX_ROWS:
            problems.add(cells, path, f"has {len(cells.value):,} rows; at most {_MAX_ROWS:,} are read")
        elif unit and (mistake := mistake_of(quantity.read, f"1 {unit}", field.unit)):
            problems.add(table.key_position(header), path, f"'{header}': {mistake}")
        else:
            values[name] = [_read_cell(problems, path, cell, unit, field) for cell in cells.value]
    return values


def _read_cell(problems: Problems, path: str, cell: WrittenValue, unit: str, field: Field) -> float:
    """Return one cell in SI; nan, with a problem, if it is invalid."""
    try:
        is_plain = isinstance(cell.value, str | int | float) and not isinstance(cell.value, bool)
        value = quantity.read(f"{cell.value} {unit}" if unit and is_plain else cell.value, field.unit)
    except InputError as error:
        problems.add(cell, path, f"{field.name}: {error}")
        return math.nan
    if not field.contains(value):
        problems.add(cell, path, f"{field.name}: found {cell.value}, out of range; allowed: {field.allowed(value)}")
    return value


def _check_table(path: str, written: WrittenValue, table: dict, values: ColumnValues, columns: Columns) -> None:
    """Raise MistakeError if a table is not complete and increasing."""
    abscissae = [field.name for field in columns.over if field.name in values]
    message = ""
    if len(abscissae) != 1:
        names = " or ".join(field.name for field in columns.over)
        message = f"has {len(abscissae)} of the columns {names}; expected exactly one independent column"
    elif len(values) < 2:
        names = ", ".join(field.name for field in columns.values)
        message = f"has no column of {names}; write at least one"
    elif len({len(column) for column in values.values()}) > 1 or len(values[abscissae[0]]) < 2:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in values.items())
        message = f"has columns of {lengths} values; expected equally many, at least 2"
    if message:
        raise MistakeError(written, path, message)
    knots = values[abscissae[0]]
    cells = next(cells for header, cells in table.items() if split_header(header)[0] == abscissae[0]).value
    for index in range(1, len(knots)):
        found_text = f"{abscissae[0]}: found {cells[index].value} after {cells[index - 1].value}"
        if not knots[index] > knots[index - 1]:
            raise MistakeError(cells[index], path, f"{found_text}; it must increase from row to row")
        if knots[index] - knots[index - 1] < _MIN_RELATIVE_STEP * (knots[-1] - knots[0]):
            step_text = f"{found_text}, a step of less than {_MIN_RELATIVE_STEP:g} of the table's span"
            raise MistakeError(cells[index], path, f"{step_text}; remove one of the rows")
    for name in columns.nonzero:
        if not any(values[name]):
            raise MistakeError(written, path, f"{name}: is 0 in every row; at least one row needs another value")
    if columns.from_zero and knots[0] != 0.0:
        message = f"{abscissae[0]}: starts at {cells[0].value}; the first row is the start of the run: write 0 there"
        raise MistakeError(cells[0], path, message)
    if abscissae[0] in _PERIODS:
        _check_period(path, cells[-1], values, abscissae[0])


def _check_period(path: str, last: WrittenValue, values: ColumnValues, over: str) -> None:
    """Raise MistakeError if a table over the column `over` is not periodic."""
    span, (periods, text) = values[over][-1] - values[over][0], _PERIODS[over]
    if not any(math.isclose(span, period, rel_tol=1e-9) for period in periods):
        span_text = f"{math.degrees(span):.6g} deg" if over == "crank_angle" else f"{span:.6g}"
        message = (
            f"{over}: the table spans {span_text}; expected one period of {text}, whose last row repeats the first"
        )
        raise MistakeError(last, path, message)
    for name, column in values.items():
        if name != over and abs(column[-1] - column[0]) > 1e-9 * max(map(abs, column)):
            place = over.replace("_", " ")
            message = f"{name}: the last row has the same {place} as the first, but another value; make both equal"
            raise MistakeError(last, path, message)
        column[-1] = column[0] if name != over else column[-1]


MAX_SIGNALS_BYTES = 512 * 2**20  # bytes of a file
ABSCISSA_UNITS = {"crank_angle": "rad", "time": "s"}  # a file has exactly one of these columns; SI units
MAX_STEP_RATIO = 3.0  # times the median step; a longer step means missing samples
MIN_ROWS = 16


class MeasuredSignals(NamedTuple):
    """The content of a file of measured signals, in SI."""

    file: str
    over: str  # a key of OVER
    abscissa: "np.ndarray"  # (n,) rad or s, ascending
    signals: "dict[str, np.ndarray]"  # name in the header -> (n,) values


def read_signals(
    file: str | PathLike, units: Mapping[str, str | None], *, allow_others: bool = False
) -> MeasuredSignals:
    """Return the signals in a file whose SI units are `units`, by name.  Raises InputError with row and column.

    units : None for an arbitrary unit
    allow_others : whether other columns are allowed; they are not read
    """
    path = Path(file)
    headers, rows = complete_rows_of_csv(path, MAX_SIGNALS_BYTES)
    if len(rows) < MIN_ROWS:
        raise InputError(f"{path}: has {len(rows)} rows; at least {MIN_ROWS} are needed")
    columns: dict[str, np.ndarray] = {}
    for column_index, header in enumerate(headers):
        name, unit = split_header(header)
        if allow_others and name not in (*ABSCISSA_UNITS, *units):
            continue
        if name not in (*ABSCISSA_UNITS, *units):
            known = [*ABSCISSA_UNITS, *units]
            raise InputError(
                f"{path}:1:{column_index + 1}: '{header.strip()}' is not a signal of this "
                f"run{did_you_mean(name, known)} "
                f"(known: {', '.join(known)}); write a signal followed by its unit, such as acceleration [m/s^2]"
            )
        if name in columns:
            raise InputError(f"{path}:1:{column_index + 1}: '{name}' occurs twice; keep one of them")
        si_unit = ABSCISSA_UNITS.get(name) or units[name]
        columns[name] = np.array(_signal_values(str(path), rows, column_index, unit if si_unit else "", si_unit or "1"))
    if allow_others and (missing := [name for name in units if name not in columns]):
        headers_text = ", ".join(header.strip() for header in headers)
        message = f"{path}:1: has no column '{missing[0]}'{did_you_mean(missing[0], headers)} (found: {headers_text})"
        raise InputError(message)
    abscissae = [name for name in ABSCISSA_UNITS if name in columns]
    if len(abscissae) != 1 or len(columns) < 2:
        raise InputError(f"{path}:1: found {', '.join(columns)}; expected crank_angle [deg] or time [s], and a signal")
    abscissa = columns.pop(abscissae[0])
    _check_steps(str(path), abscissae[0], abscissa, [line for line, _ in rows])
    return MeasuredSignals(str(path), abscissae[0], abscissa, columns)


def _signal_values(file: str, rows: list[TableRow], column_index: int, unit: str, si_unit: str) -> list[float]:
    """Return the numbers of a column in the unit `si_unit`.  Raises InputError for anything but a number."""
    try:
        scale = quantity.read(f"1 {unit}", si_unit) if unit else 1.0
    except InputError as error:
        raise InputError(f"{file}:1:{column_index + 1}: {error}") from None
    numbers = []
    for line, cells in rows:
        try:
            value = float(cells[column_index])
        except ValueError:
            value = float("nan")
        if value - value != 0.0:
            cell = quoted(cells[column_index])
            message = f"found {cell}; expected a finite number; leave cells empty where nothing was measured"
            raise InputError(f"{file}:{line}:{column_index + 1}: {message}")
        numbers.append(scale * value)
    return numbers


def _check_steps(file: str, name: str, abscissa: "np.ndarray", lines: list[int]) -> None:
    """Raise InputError if the angle or the time does not increase, or if samples are missing."""
    steps = np.diff(abscissa)
    if (steps <= 0.0).any():
        line = lines[int(np.argmax(steps <= 0.0)) + 1]
        raise InputError(f"{file}:{line}: {name} does not increase; sort the rows, and unwrap the angle")
    if steps.max() > MAX_STEP_RATIO * np.median(steps):
        line = lines[int(np.argmax(steps)) + 1]
        message = f"a step of {name} is {steps.max() / np.median(steps):.3g} times the median step"
        raise InputError(f"{file}:{line}: {message}; samples are missing; cut the file there")
