"""Reads the values of one axis of a sweep: a list, or values evenly spaced on a linear or a logarithmic scale."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from ...contracts.catalogue import Field
from ...language import quantity
from ...language.errors import InputError, shown
from ..written.document import Problems, WrittenValue

_MOST_WRITTEN = 100_000  # values in a list: as many as a person or a script may reasonably write out
_MOST_VALUES = 1_000_000  # values on one axis; they are kept in memory
FORMS = {
    "linspace": "[first, last, count]",
    "geomspace": "[first, last, count]",
    "logspace": "[exponent of the first, exponent of the last, count] with the unit as a fourth where it is not SI",
}


class Reading(NamedTuple):
    """How the values of one key are read."""

    value: Callable[[WrittenValue], Any]  # in SI, or a word; None, and a problem, where it is wrong
    unit: str  # SI; '' for words
    fields: tuple[Field, ...] = ()  # meanings of the key; drawn values must stay within their ranges


def axis(
    problems: Problems, where: str, written: WrittenValue, reading: Reading, *, distinct: bool = True
) -> list[Any] | None:
    """Return the values of the axis at the key `where`, or None if it is invalid.

    Values must be distinct unless they vary in step with those of other axes.
    """
    if isinstance(written.value, list):
        if not written.value:
            problems.add(written, where, "the list is empty; write at least one value, or leave the path out")
        if half_bare(problems, where, written.value, reading.unit):
            return None
        return _distinct(problems, where, written, reading) if distinct else _repeatable(written, reading)
    if (
        reading.unit
        and isinstance(written.value, dict)
        and len(written.value) == 1
        and set(written.value) <= set(FORMS)
    ):
        ((kind, given),) = written.value.items()
        return _generated(problems, where, kind, given, reading)
    spaced = (
        f", {{label: a, other label: b}}, or {{linspace: {FORMS['linspace']}}}, or geomspace or logspace in its place"
    )
    problems.add(
        written, where, f"found {shown(written.value)}; expected a list such as [a, b]{spaced if reading.unit else ''}"
    )
    return None


def half_bare(problems: Problems, where: str, items: Iterable[WrittenValue], unit: str) -> bool:
    """Report numbers without a unit next to others that have one, and return whether there are any.

    `[200 rpm, 500]` would mean 500 rad/s, which is hardly ever intended.
    """
    items = list(items)
    named = next((item for item in items if _reads(item.value, unit)), None) if unit not in ("", "1") else None
    bare = [item for item in items if quantity.is_bare(item.value)] if named else []
    for item in bare:
        sentence = (
            f"found {item.value} without a unit next to {shown(named.value if named else '')}; alone it would mean "
            f"{item.value} {unit}: write the unit of each, or of none"
        )
        problems.add(item, where, sentence)
    return bool(bare)


def _reads(value: Any, unit: str) -> bool:
    """Return whether a quantity is written with a unit of the right dimension."""
    try:
        return quantity.has_unit(value) and quantity.exact(value, unit) is not None
    except InputError:
        return False


def _repeatable(written: WrittenValue, reading: Reading) -> list[Any] | None:
    """Return the values of a list, which may repeat."""
    values = [reading.value(item) for item in written.value]
    return None if not values or None in values else values


def _distinct(problems: Problems, where: str, written: WrittenValue, reading: Reading) -> list[Any] | None:
    """Return the values of a list, which must all differ."""
    if written.line and len(written.value) > _MOST_WRITTEN:
        problems.add(
            written,
            where,
            f"found a list of {len(written.value)} values; at most {_MOST_WRITTEN} can be written out: "
            "use {linspace: [first, last, count]} or {geomspace: [first, last, count]}",
        )
        return None
    first: dict[Any, WrittenValue] = {}
    for item in written.value:
        value = reading.value(item)
        if value is not None and value in first:
            there = f" (line {first[value].line})" if first[value].line else ""
            problems.add(
                item,
                where,
                f"duplicate value {shown(item.value)}, the same as {shown(first[value].value)}{there}; "
                "each value may occur only once",
            )
        elif value is not None:
            first[value] = item
    return list(first) if len(first) == len(written.value) else None


def _generated(problems: Problems, where: str, kind: str, given: WrittenValue, reading: Reading) -> list[Any] | None:
    """Return evenly spaced values."""
    items = given.value if isinstance(given.value, list) else []
    try:
        if len(items) != 3 and not (kind == "logspace" and len(items) == 4):
            raise InputError(f"found {shown(given.value)} of {len(items)}; expected {FORMS[kind]}")
        count = quantity.read(items[2].value, "1")
        if count != int(count) or not 2 <= count <= _MOST_VALUES:
            raise InputError(f"found the count {count:.15g}; expected a whole number from 2 to {_MOST_VALUES}")
        if kind == "logspace":
            values = _powers(items, int(count), reading.unit)
        elif half_bare(problems, where, items[:2], reading.unit) or None in [reading.value(item) for item in items[:2]]:
            return None
        else:
            values = _between(kind, items, int(count), reading.unit)
        if len(set(values)) < len(values):
            raise InputError(f"{len(values)} values from {values[0]!r} to {values[-1]!r} (SI) are not all different")
    except InputError as error:
        problems.add(given, where, f"{kind}: {error}")
        return None
    checked = [reading.value(WrittenValue(value, given.origin, given.line, given.column)) for value in values]
    return None if None in checked else checked


def _between(kind: str, items: list[WrittenValue], count: int, unit: str) -> list[float]:
    """Return values from the first to the second item, both included.

    Linear spacing is exact before the last rounding, so each value equals the one a user would write out.
    """
    steps = count - 1
    first, last = quantity.exact(items[0].value, unit), quantity.exact(items[1].value, unit)
    if kind == "linspace":
        below = first.denominator * last.denominator * steps
        start, stop = first.numerator * last.denominator, last.numerator * first.denominator
        return [(start * (steps - k) + stop * k) / below for k in range(count)]
    if first * last <= 0:
        raise InputError("first and last must be both above 0 or both below; use linspace")
    low, high = float(first), float(last)
    return [low, *(low * (high / low) ** (k / steps) for k in range(1, steps)), high]


def _powers(items: list[WrittenValue], count: int, unit: str) -> list[float]:
    """Return powers of ten from one exponent to another, in the unit of the fourth item or in SI."""
    first, last = (quantity.read(item.value, "1") for item in items[:2])
    named = items[3].value if len(items) == 4 else ""
    if not isinstance(named, str):
        raise InputError(f"found {shown(named)} as the unit; expected one such as {unit if unit != '1' else '%'}")
    scale = quantity.read(f"1 {named}", unit) if named else 1.0
    try:
        return [scale * 10.0 ** (first + (last - first) * (k / (count - 1))) for k in range(count)]
    except OverflowError:
        raise InputError(f"the exponents {first:.15g} and {last:.15g} exceed the range of numbers") from None
