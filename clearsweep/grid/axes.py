"""Reads the values of one axis of a sweep: a list, or values evenly spaced on a linear or a logarithmic scale."""

from collections.abc import Callable

from .. import quantity
from ..errors import InputError, shown
from .document import Entry, Problems

_MOST_WRITTEN = 100_000  # values in a list: what a person or a script may reasonably write out
_MOST_VALUES = 1_000_000  # values on one axis: they are kept in memory
FORMS = {
    "linspace": "[first, last, count]",
    "geomspace": "[first, last, count]",
    "logspace": "[exponent of the first, exponent of the last, count] with the unit as a fourth where it is not SI",
}


def axis(
    problems: Problems, where: str, entry: Entry, one: Callable, unit: str, *, distinct: bool = True
) -> list | None:
    """Return the values of the axis written at the key `where`, None where it is wrong.

    `one(entry)` reads a value, None where that is wrong; `unit` is the SI unit of the values, '' for words.  Values
    have to be `distinct` unless they go in step with those of other axes.
    """
    if isinstance(entry.value, list):
        return _listed(problems, where, entry, one, distinct)
    if unit and isinstance(entry.value, dict) and len(entry.value) == 1 and set(entry.value) <= set(FORMS):
        ((kind, given),) = entry.value.items()
        return _generated(problems, where, kind, given, one, unit)
    spaced = f" or {{linspace: {FORMS['linspace']}}}, or geomspace or logspace in its place"
    problems.add(entry, where, f"found {shown(entry.value)}; expected a list such as [a, b]{spaced if unit else ''}")
    return None


def _listed(problems: Problems, where: str, entry: Entry, one, distinct: bool) -> list | None:
    """Return the values of a list, each of them different where they have to be `distinct`."""
    if not entry.value:
        problems.add(entry, where, "the list is empty; write at least one value, or leave the path out")
    if distinct and entry.line and len(entry.value) > _MOST_WRITTEN:
        problems.add(
            entry,
            where,
            f"found a list of {len(entry.value)} values; at most {_MOST_WRITTEN} can be written out: "
            "use {linspace: [first, last, count]} or {geomspace: [first, last, count]}",
        )
        return None
    if not distinct:
        values = [one(item) for item in entry.value]
        return None if not values or None in values else values
    first: dict = {}
    for item in entry.value:
        value = one(item)
        if value is not None and value in first:
            there = f" (line {first[value].line})" if first[value].line else ""
            problems.add(
                item,
                where,
                f"duplicate value {shown(item.value)}, the same as {shown(first[value].value)}{there}; "
                "every value may be there once",
            )
        elif value is not None:
            first[value] = item
    return list(first) if len(first) == len(entry.value) else None


def _generated(problems: Problems, where: str, kind: str, given: Entry, one: Callable, unit: str) -> list | None:
    """Return evenly spaced values."""
    items = given.value if isinstance(given.value, list) else []
    try:
        if len(items) != 3 and not (kind == "logspace" and len(items) == 4):
            raise InputError(f"found {shown(given.value)} of {len(items)}; expected {FORMS[kind]}")
        count = quantity.read(items[2].value, "1")
        if count != int(count) or not 2 <= count <= _MOST_VALUES:
            raise InputError(f"found the count {count:.15g}; expected a whole number from 2 to {_MOST_VALUES}")
        if kind == "logspace":
            values = _powers(items, int(count), unit)
        elif None in [one(item) for item in items[:2]]:
            return None
        else:
            values = _between(kind, items, int(count), unit)
        if len(set(values)) < len(values):
            raise InputError(f"{len(values)} values from {values[0]!r} to {values[-1]!r} (SI) are not all different")
    except InputError as error:
        problems.add(given, where, f"{kind}: {error}")
        return None
    checked = [one(Entry(value, given.origin, given.line, given.column)) for value in values]
    return None if None in checked else checked


def _between(kind: str, items: list[Entry], count: int, unit: str) -> list[float]:
    """Return values from the first to the second item, both included.

    Linear ones are exact before the last rounding, so that each has the bits of the same value written out.
    """
    steps = count - 1
    first, last = (quantity.exact(item.value, unit) for item in items[:2])
    if kind == "linspace":
        below = first.denominator * last.denominator * steps
        start, stop = first.numerator * last.denominator, last.numerator * first.denominator
        return [(start * (steps - k) + stop * k) / below for k in range(count)]
    if first * last <= 0:
        raise InputError("first and last have to be both above 0 or both below; use linspace")
    low, high = float(first), float(last)
    return [low, *(low * (high / low) ** (k / steps) for k in range(1, steps)), high]


def _powers(items: list[Entry], count: int, unit: str) -> list[float]:
    """Return powers of ten from one exponent to another, in the unit of the fourth item or in SI."""
    first, last = (quantity.read(item.value, "1") for item in items[:2])
    scale = quantity.read(f"1 {items[3].value}", unit) if len(items) == 4 else 1.0
    try:
        return [scale * 10.0 ** (first + (last - first) * (k / (count - 1))) for k in range(count)]
    except OverflowError:
        raise InputError(f"the exponents {first:.15g} and {last:.15g} lead beyond every float") from None
