"""Reads a table, written in the grid or in a CSV file next to it."""

import csv
import math
from pathlib import Path

from ..contracts.catalogue import Columns, Field
from ..language import quantity
from ..language.errors import InputError, nearest, shown
from .case_table import head_of, rows_of_csv
from .document import Problems, WrittenValue, refuse_endless

_LARGEST = 16 * 2**20  # bytes of a file
_MOST_ROWS = 20_000
_FINEST = 1e-9  # smallest step between rows over the table's span; finer steps vanish in rounding when it repeats
_SPANS = (2.0 * math.pi, 4.0 * math.pi)  # rad, over which a table repeats

Values = dict[str, list[float]]  # column -> values in SI


def read(problems: Problems, path: str, written: WrittenValue, columns: Columns) -> Values | None:
    """Return the table at the key `path`; None, with problems, if it is invalid."""
    if isinstance(written.value, dict):
        table = dict(written.value.items())
        places = written.keys
    elif isinstance(written.value, str):
        content = _from_file(problems, path, written)
        if content is None:
            return None
        table, places = content
    else:
        example = ", ".join(field.name for field in (*columns.over[:1], *columns.values[:1]))
        sentence = f"found {shown(written.value)}; expected the name of a .csv file, or columns: {example}"
        problems.add(written, path, sentence)
        return None
    problems_before = len(problems)
    values = _columns(
        problems, path, WrittenValue(table, written.origin, written.line, written.column, places), columns
    )
    return (
        values
        if len(problems) == problems_before and _is_increasing(problems, path, written, table, values, columns)
        else None
    )


def _from_file(
    problems: Problems, path: str, written: WrittenValue
) -> tuple[dict[str, WrittenValue], dict[str, WrittenValue]] | None:
    """Return the columns of a CSV file by header, and the positions of the headers."""
    file = Path(written.origin).parent / written.value if written.line else Path(written.value)
    if file.suffix.lower() != ".csv":
        problems.add(written, path, f"found '{written.value}'; expected the name of a .csv file")
        return None
    try:
        refuse_endless(file, _LARGEST)
        heads, rows = rows_of_csv(file)
    except FileNotFoundError:
        problems.add(written, path, f"there is no file {file}; the name is relative to the grid's directory")
        return None
    except (OSError, ValueError, csv.Error) as error:
        problems.add(written, path, f"{file} cannot be read: {getattr(error, 'strerror', None) or error}")
        return None
    for line, cells in rows:
        if len(cells) != len(heads):
            sentence = f"row {line} has {len(cells)} cells but the header has {len(heads)}; write every value"
            problems.add(WrittenValue(None, str(file), line, 1), path, sentence)
            return None
    table, places = {}, {}
    for column, heading in enumerate(heads, start=1):
        head_location = WrittenValue(None, str(file), 1, column)
        if heading.strip() in table:
            problems.add(head_location, path, f"the column '{heading.strip()}' occurs twice; keep one of them")
            return None
        cells = [WrittenValue(row[column - 1].strip(), str(file), line, column) for line, row in rows]
        table[heading.strip()], places[heading.strip()] = WrittenValue(cells, str(file), 1, column), head_location
    return table, places


def _columns(problems: Problems, path: str, table: WrittenValue, columns: Columns) -> dict[str, list[float]]:
    """Return the values of the columns by name; report mistakes in them."""
    fields = {field.name: field for field in (*columns.over, *columns.values)}
    allowed = ", ".join(f"{field.name} [{_shown_unit(field)}]" for field in fields.values())
    values: dict[str, list[float]] = {}
    for heading, cells in table.value.items():
        name, unit = head_of(heading)
        field = fields.get(name)
        if field is None or name in values:
            invalid = "occurs twice" if field else f"is no column of this table{nearest(name, fields)}"
            problems.add(table.key_place(heading), path, f"'{heading}' {invalid} (known: {allowed})")
        elif not isinstance(cells.value, list):
            problems.add(cells, f"{path}.{heading}", f"found {shown(cells.value)}; expected a list of values")
        elif len(cells.value) > _MOST_ROWS:
            problems.add(cells, path, f"has {len(cells.value):,} rows; at most {_MOST_ROWS:,} are read")
        else:
            values[name] = [_value(problems, path, cell, unit, field) for cell in cells.value]
    return values


def _shown_unit(field: Field) -> str:
    return {"rad": "deg", "rad/s": "rpm"}.get(field.unit, field.unit)


def _value(problems: Problems, path: str, cell: WrittenValue, unit: str, field: Field) -> float:
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


def _is_increasing(
    problems: Problems, path: str, written: WrittenValue, table: dict, values: Values, columns: Columns
) -> bool:
    """Return whether a table is complete and increasing; report mistakes."""
    abscissae = [field.name for field in columns.over if field.name in values]
    sentence = ""
    if len(abscissae) != 1:
        names = " or ".join(field.name for field in columns.over)
        sentence = f"has {len(abscissae)} of the columns {names}; expected exactly one independent column"
    elif len(values) < 2:
        names = ", ".join(field.name for field in columns.values)
        sentence = f"has no column of {names}; write at least one"
    elif len({len(column) for column in values.values()}) > 1 or len(values[abscissae[0]]) < 2:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in values.items())
        sentence = f"has columns of {lengths} values; expected equally many, at least 2"
    if sentence:
        problems.add(written, path, sentence)
        return False
    knots = values[abscissae[0]]
    cells = next(cells for heading, cells in table.items() if head_of(heading)[0] == abscissae[0]).value
    for index in range(1, len(knots)):
        if not knots[index] > knots[index - 1]:
            actual = f"found {cells[index].value} after {cells[index - 1].value}"
            problems.add(cells[index], path, f"{abscissae[0]}: {actual}; it has to increase from row to row")
            return False
        if knots[index] - knots[index - 1] < _FINEST * (knots[-1] - knots[0]):
            actual = f"found {cells[index].value} after {cells[index - 1].value}"
            too_fine = f"{abscissae[0]}: {actual}, a step of less than {_FINEST:g} of the table's span"
            problems.add(cells[index], path, f"{too_fine}; remove one of the rows")
            return False
    for name in columns.above_zero:
        if not any(values[name]):
            problems.add(written, path, f"{name}: is 0 in every row; write at least one row in which it is above 0")
            return False
    return abscissae[0] != "crank_angle" or _periodic(problems, path, cells[-1], values)


def _periodic(problems: Problems, path: str, last: WrittenValue, values: Values) -> bool:
    """Return whether a table over the crank angle is periodic; report it if not."""
    knots = values["crank_angle"]
    span = knots[-1] - knots[0]
    if not any(math.isclose(span, complete, rel_tol=1e-9) for complete in _SPANS):
        sentence = (
            f"crank_angle: the table spans {math.degrees(span):.6g} deg, over which it repeats; expected 360 or 720 "
            "deg, its last row being its first again"
        )
        problems.add(last, path, sentence)
        return False
    for name, column in values.items():
        largest = max(map(abs, column))
        if name != "crank_angle" and abs(column[-1] - column[0]) > 1e-9 * largest:
            sentence = f"{name}: the last row differs from the first, which is the same crank angle; make them equal"
            problems.add(last, path, sentence)
            return False
        column[-1] = column[0] if name != "crank_angle" else column[-1]
    return True
