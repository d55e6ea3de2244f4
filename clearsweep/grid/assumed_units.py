"""Finds the quantities of a grid that are written as bare numbers, so that SI is assumed for them."""

from ..language.quantity import is_bare
from .document import WrittenValue
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
