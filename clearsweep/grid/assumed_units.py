"""Finds the quantities of a grid that have no unit, so that SI is assumed, and the units of all others."""

from collections.abc import Iterator, Mapping
from typing import Any

from ..language.quantity import WrittenUnit, is_bare, written_unit
from . import labels
from .document import WrittenValue
from .fits import fits_of_record
from .key_units import unit
from .keys import Number
from .reader import Reader


def assumed_units(reader: Reader) -> tuple[str, ...]:
    """Return the paths of quantities and axes that need a unit but are written without one."""
    numbers = (path for path, node in reader.shape.items() if isinstance(node, Number) and _has_unit(reader, node))
    return tuple(path for path in numbers if _bare(reader.swept.get(path) or reader.written.get(path)))


def _has_unit(reader: Reader, node: Number) -> bool:
    fields = node.fields(reader.names)
    return bool(fields) and fields[0].unit != "1"


def _bare(written: WrittenValue | None) -> bool:
    """Return whether a value is a bare number, or a list or distribution that contains one."""
    if written is None:
        return False
    value = written.value
    if isinstance(value, dict):  # an axis: its ends come first, and a mean is among its keys
        inner = next(iter(value.values()), WrittenValue(None)).value
        value = [inner["mean"]] if isinstance(inner, dict) and "mean" in inner else inner
        if "logspace" in written.value:
            return isinstance(value, list) and len(value) == 3
    if isinstance(value, list):  # either all items have units or none
        return any(is_bare(item.value) for item in value[:2])
    return is_bare(value)


def written_units(reader: Reader) -> dict[str, WrittenUnit]:
    """Return path -> unit in which a quantity is written; for an axis, the unit of its first value with one.

    Values without a unit, expressions, fits and names of library entries are left out.
    """
    units = {}
    among_fits = {path for path, way in reader.way.items() if way == "seek"} if reader.among else set()
    for path, node in reader.shape.items():
        written = reader.swept.get(path) or reader.written.get(path)
        if not isinstance(node, Number) or not node.fields(reader.names) or written is None:
            continue
        if path in reader.fits or path in among_fits:
            continue
        exponent = reader.values.get(f"{path.rpartition('.')[0]}.exponent")
        known = unit(node, reader.names, exponent)
        readings = (written_unit(text, known) for text in _texts(written))
        first = next((reading for reading in readings if reading), None)
        if first:
            units[path] = first
    return units


def as_written(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fits, labels and units that the user wrote; a grid read back from its `record` in SI has lost them."""
    units = {path: WrittenUnit(**known) for path, known in record.get("written_units", {}).items()}
    return {"fits": fits_of_record(record), "labels": labels.noted(record), "written_units": units}


def _texts(written: WrittenValue) -> Iterator[Any]:
    """Yield the texts at a path: a value, the items of a list, or the numbers of an axis; names are left out."""
    value = None if written.by_name else written.value
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    if inner is None:
        yield f"1 {value}" if isinstance(value, str) and value[:1].isalpha() else value  # unit of a logspace
        return
    for item in inner:
        yield from _texts(item)
