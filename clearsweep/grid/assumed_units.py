"""Finds quantities of a grid that are bare numbers, for which SI is assumed, and the units of all others."""

from collections.abc import Iterator, Mapping
from typing import Any

from ..language.quantity import WrittenUnit, is_bare, written_unit
from . import labels
from .document import WrittenValue
from .fits import noted
from .key_units import unit
from .keys import Number
from .reader import Reader


def assumed_units(reader: Reader) -> tuple[str, ...]:
    """Return the paths of quantities with a unit, and of axes of such, that are written without."""
    numbers = (path for path, node in reader.shape.items() if isinstance(node, Number) and _has_unit(reader, node))
    return tuple(path for path in numbers if _bare(reader.swept.get(path) or reader.written.get(path)))


def _has_unit(reader: Reader, node: Number) -> bool:
    fields = node.fields(reader.names)
    return bool(fields) and fields[0].unit != "1"


def _bare(written: WrittenValue | None) -> bool:
    """Return whether what is written is a bare number, or a list or distribution that has one where others may be."""
    if written is None:
        return False
    value = written.value
    if isinstance(value, dict):  # of one way to write an axis: its ends come first, its mean is among its keys
        inner = next(iter(value.values()), WrittenValue(None)).value
        value = [inner["mean"]] if isinstance(inner, dict) and "mean" in inner else inner
        if "logspace" in written.value:
            return isinstance(value, list) and len(value) == 3
    if isinstance(value, list):  # all of it has units or none has
        return any(is_bare(item.value) for item in value[:2])
    return is_bare(value)


def written_units(reader: Reader) -> dict[str, WrittenUnit]:
    """Return path of a quantity -> the unit that it is written in; of an axis that of its first value with a unit.

    Left out is what is written without a unit, as an expression, or by the name of a fit or of an entry of a library.
    """
    units = {}
    among_fits = [path for path, way in reader.way.items() if way == "seek"] if reader.among else []
    for path, node in reader.shape.items():
        written = reader.written.get(path) if path in among_fits else reader.swept.get(path) or reader.written.get(path)
        if not isinstance(node, Number) or not node.fields(reader.names) or written is None or path in reader.fits:
            continue
        exponent = reader.values.get(f"{path.rpartition('.')[0]}.exponent")
        known = unit(node, reader.names, exponent)
        readings = (written_unit(each, known) for each in _texts(written))
        first = next((each for each in readings if each), None)
        if first:
            units[path] = first
    return units


def as_written(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return fits, labels and units as they were written, which a grid that is read from its `record` in SI lacks."""
    units = {path: WrittenUnit(**known) for path, known in record.get("written_units", {}).items()}
    return {"fits": noted(record), "labels": labels.noted(record), "written_units": units}


def _texts(written: WrittenValue) -> Iterator[Any]:
    """Yield what is written at a path: a value, those of a list, or those of a way to write an axis; not by name."""
    value = None if written.by_name else written.value
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    if inner is None:
        yield f"1 {value}" if isinstance(value, str) and value[:1].isalpha() else value  # the unit of a logspace
        return
    for item in inner:
        yield from _texts(item)
