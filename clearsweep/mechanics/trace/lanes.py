"""Answers in lanes: in all, in none; values that differ from lane to lane."""

from typing import Any

from . import symbols
from .paths import alike, leaves, rebuilt
from .symbols import NotTraceableError, Truth, is_symbol, trace


def _lanes(condition: Any, number: int) -> Any:
    builder = trace().builder
    if not is_symbol(condition):
        return bool(condition) if number else not condition
    if condition.width == 1:
        return condition if number else symbols.opposite(condition)
    bits = builder.bitcast(condition.value, symbols.ir.IntType(condition.width))
    return Truth(builder.icmp_signed("==", bits, symbols.ir.Constant(bits.type, number)))


def all_of(condition: Any) -> Any:
    """Emit whether a condition is true in every lane."""
    return _lanes(condition, -1)


def none_of(condition: Any) -> Any:
    """Emit whether a condition is true in no lane."""
    return _lanes(condition, 0)


def all_lanes(width: int) -> Truth:
    """Return yes in every lane."""
    return Truth(symbols.constant(symbols.BIT, True, width), width)


def nothing(x: Any) -> Any:
    """Return a value of the kind of a symbol that means nothing; of what is known, itself."""
    return type(x)(symbols.constant(x.item, 0, x.width), x.width) if is_symbol(x) else x


def blended(lanes: Any, new: Any, old: Any) -> Any:
    """Return a value in some lanes, that before in the others; the new one where they are of different forms."""
    if new is old:
        return new
    try:
        new, old = alike([new, old])
        pairs = list(zip(leaves(new), leaves(old), strict=True))
        made = [a if a is b else symbols.selected(lanes, a, b) for a, b in pairs]
    except (NotTraceableError, ValueError, TypeError):
        return new
    return rebuilt(new, iter(made))
