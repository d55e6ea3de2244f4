"""Units that a grid leaves out: where SI is assumed, and what wear coefficients are in."""

from collections.abc import Iterator, Mapping
from typing import Any

from ...language.quantity import WrittenUnit, is_bare, written_unit
from ..keys.key_table import DIMENSIONLESS
from ..keys.kinds import Number
from ..keys.outline import unit_of_number
from ..sections.fits import recorded_fits
from ..sections.variations import recorded_labels
from ..written.document import WrittenValue
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
        nested = next(iter(value.values()), WrittenValue(None)).value
        value = [nested["mean"]] if isinstance(nested, dict) and "mean" in nested else nested
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
    among_fits = (
        {path for path, variation in reader.varied_by.items() if variation == "seek"} if reader.searched_fits else set()
    )
    for path, node in reader.shape.items():
        written = reader.swept.get(path) or reader.written.get(path)
        if not isinstance(node, Number) or not node.fields(reader.names) or written is None:
            continue
        if path in reader.fits or path in among_fits:
            continue
        exponent = reader.values.get(f"{path.rpartition('.')[0]}.exponent")
        unit_fields = unit_of_number(node, reader.names, exponent)
        readings = (written_unit(text, unit_fields) for text in _texts(written))
        first_reading = next((reading for reading in readings if reading), None)
        if first_reading:
            units[path] = first_reading
    return units


def as_written(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fits, labels and units that the user wrote; a grid read back from its `record` in SI has lost them."""
    units = {path: WrittenUnit(**unit_fields) for path, unit_fields in record.get("written_units", {}).items()}
    return {"fits": recorded_fits(record), "labels": recorded_labels(record), "written_units": units}


def _texts(written: WrittenValue) -> Iterator[Any]:
    """Yield the texts at a path: a value, the items of a list, or the numbers of an axis; names are left out."""
    value = None if written.by_name else written.value
    nested = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    if nested is None:
        yield f"1 {value}" if isinstance(value, str) and value[:1].isalpha() else value  # unit of a logspace
        return
    for item in nested:
        yield from _texts(item)


#: Keys of wear coefficients, below `wear`.
COEFFICIENTS = (
    *("coefficient", "bearing_coefficient", "journal_coefficient"),
    *("running_in.initial", "running_in.steady", "running_in.bearing_initial", "running_in.journal_initial"),
)


def put_wear_units(reader: Reader) -> None:
    """Set, for each joint with wear, whether its coefficients are dimensionless, unless the grid says so."""
    for path in [path for path in reader.shape if path.endswith(".wear.coefficient_unit")]:
        wear = path.rpartition(".")[0]
        entries = reader.swept | reader.written
        coefficients = [entries[f"{wear}.{key}"] for key in COEFFICIENTS if f"{wear}.{key}" in entries]
        if (
            path not in reader.written
            and f"{wear}.hardness" in entries
            and coefficients
            and all(map(_all_bare, coefficients))
        ):
            location = coefficients[0]
            reader.written[path] = WrittenValue(DIMENSIONLESS, location.origin, location.line, location.column)


def _all_bare(written: WrittenValue) -> bool:
    """Return whether only numbers without a unit are written."""
    leaves = list(_leaf_texts(written))
    return bool(leaves) and all(map(_is_number, leaves))


def _leaf_texts(written: WrittenValue) -> Iterator[object]:
    """Yield every text in a value, an axis or a distribution."""
    if isinstance(written.value, (dict, list)):
        for item in written.value.values() if isinstance(written.value, dict) else written.value:
            yield from _leaf_texts(item)
    else:
        yield written.value


def _is_number(value: object) -> bool:
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return not isinstance(value, bool)
