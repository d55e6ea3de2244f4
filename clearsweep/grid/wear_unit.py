"""Finds the unit of wear coefficients: by default, numbers without a unit next to a hardness are k H."""

from collections.abc import Iterator

from .document import WrittenValue
from .key_table import DIMENSIONLESS
from .reader import Reader

#: Keys of wear coefficients, below `wear`.
COEFFICIENTS = (
    *("coefficient", "bearing_coefficient", "journal_coefficient"),
    *("running_in.initial", "running_in.steady", "running_in.bearing_initial", "running_in.journal_initial"),
)


def put_units(reader: Reader) -> None:
    """Set, for each joint with wear, whether its coefficients are dimensionless, unless the grid says so."""
    for path in [path for path in reader.shape if path.endswith(".wear.coefficient_unit")]:
        wear = path.rpartition(".")[0]
        entries = reader.swept | reader.written
        coefficients = [entries[f"{wear}.{key}"] for key in COEFFICIENTS if f"{wear}.{key}" in entries]
        if (
            path not in reader.written
            and f"{wear}.hardness" in entries
            and coefficients
            and all(map(_bare, coefficients))
        ):
            location = coefficients[0]
            reader.written[path] = WrittenValue(DIMENSIONLESS, location.origin, location.line, location.column)


def _bare(written: WrittenValue) -> bool:
    """Return whether only numbers without a unit are written."""
    leaves = list(_texts(written))
    return bool(leaves) and all(map(_is_number, leaves))


def _texts(written: WrittenValue) -> Iterator[object]:
    """Yield every text in a value, an axis or a distribution."""
    if isinstance(written.value, (dict, list)):
        for item in written.value.values() if isinstance(written.value, dict) else written.value:
            yield from _texts(item)
    else:
        yield written.value


def _is_number(value: object) -> bool:
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return not isinstance(value, bool)
