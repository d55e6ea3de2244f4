"""Reads `figures` (user-defined columns) and `limits` of columns."""

from typing import Any

from ..judging.verdict import EXCEEDED, KINDS, MARGIN
from ..language import expression, quantity
from ..language.errors import InputError, nearest, shown
from .document import WrittenValue
from .reader import Reader

SECTIONS = ("figures", "limits")  # sections of a grid file
_TIMES = "times"
_LIMIT = "rod_slider_force_peak: 5 kN"
_FIGURE = 'headroom: "1 - rod_slider_load_peak / (2 * rod_slider_force_peak_ideal)"'


def read_into(reader: Reader, root: WrittenValue) -> None:
    """Read both sections into the reader; its columns must be known."""
    units = dict(reader.figures)
    for name, written in _entries(reader, root, "figures", _FIGURE).items():
        taken = _taken(reader, name)
        if problem := taken or _unreadable(written.value, units):
            place = root.value["figures"].key_place(name) if taken else written
            reader.problems.add(place, f"figures.{name}", problem)
            continue
        units[name] = expression.unit_of(written.value, units)
        reader.own_figures[name] = written.value
    for column, written in _entries(reader, root, "limits", _LIMIT).items():
        if column not in units:
            place = root.value["limits"].key_place(column)
            reader.problems.add(place, f"limits.{column}", _unknown(column, units))
        elif isinstance(written.value, dict):
            _bounds(reader, column, written, units)
        else:
            limit = _quantity(reader, written, f"limits.{column}", units[column])
            reader.limits |= {} if limit is None else {column: limit}


def _entries(reader: Reader, root: WrittenValue, name: str, example: str) -> dict[str, WrittenValue]:
    """Return the entries of a section, or {} if it is missing."""
    section = root.value.get(name) if isinstance(root.value, dict) else None
    if section is None:
        return {}
    if not isinstance(section.value, dict) or not section.value:
        noun = name.removesuffix("s")
        sentence = f"contains no {noun}; for example: `{example}`, or leave the key '{name}' out"
        reader.problems.add(section, name, sentence)
        return {}
    entries: dict[str, WrittenValue] = section.value
    return entries


def _unknown(name: str, units: dict[str, str]) -> str:
    known = f" (known: {', '.join(units)})"  # a long list, shown only if no name is near
    return f"is not a column of this grid{nearest(name, units) or known}"


def _taken(reader: Reader, name: str) -> str:
    """Return why a user-defined figure cannot have this name, or '' if it can."""
    if name in reader.figures:
        return "is a column already; give the figure another name"
    if name in (EXCEEDED, MARGIN, "case_id", "status", "message", *expression.FUNCTIONS):
        return "is a reserved name; rename the figure"
    return "" if name.isidentifier() else "found a name that is none; expected letters, digits and _, no digit first"


def _unreadable(text: Any, units: dict[str, str]) -> str:
    """Return what is wrong with an expression, or '' if nothing is."""
    if not isinstance(text, str):
        return f"found {shown(text)}; expected an expression of columns, in quotes, such as `{_FIGURE}`"
    try:
        expression.unit_of(text, units)
    except InputError as error:
        return str(error)
    return ""


def _bounds(reader: Reader, column: str, written: WrittenValue, units: dict[str, str]) -> None:
    """Read a limit written as a section: at_most, at_least, times."""
    path, entries = f"limits.{column}", written.value
    known = (*KINDS, _TIMES)
    for key in entries:
        if key not in known:
            sentence = f"unknown key{nearest(key, known)} (known: {', '.join(known)})"
            reader.problems.add(written.key_place(key), f"{path}.{key}", sentence)
    if not any(kind in entries for kind in KINDS) and all(key in known for key in entries):
        reader.problems.add(written, path, f"contains no limit; add {' or '.join(KINDS)}, such as {{at_most: 5 kN}}")
        return
    unit, bounds = units[column], dict[str, Any]()
    if _TIMES in entries:
        times = entries[_TIMES].value
        if not isinstance(times, str) or times not in units:
            reader.problems.add(entries[_TIMES], f"{path}.{_TIMES}", f"{shown(times)} {_unknown(str(times), units)}")
            return
        unit = quotient(unit, units[times])
        bounds[_TIMES] = times
    for kind in KINDS:
        if kind in entries:
            limit = _quantity(reader, entries[kind], f"{path}.{kind}", unit)
            bounds |= {} if limit is None else {kind: limit}
    if any(kind in bounds for kind in KINDS):
        reader.limits[column] = bounds


def quotient(unit: str, by: str) -> str:
    """Return the SI unit of a quotient of two quantities, '1' for equal units."""
    if by in ("1", unit):
        return unit if by == "1" else "1"
    return expression.unit_of("a / b", {"a": unit, "b": by})


def _quantity(reader: Reader, written: WrittenValue, path: str, unit: str) -> float | None:
    try:
        return quantity.read(written.value, unit)
    except InputError as error:
        reader.problems.add(written, path, str(error))
        return None
