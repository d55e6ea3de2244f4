"""Conditions over lanes, and values that differ between lanes."""

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
    """Return a condition that is true in every lane."""
    return Truth(symbols.constant(symbols.BIT, True, width), width)


def nothing(x: Any) -> Any:
    """Return an undefined value of the kind of a symbol; a known value is returned unchanged."""
    return type(x)(symbols.constant(x.item, 0, x.width), x.width) if is_symbol(x) else x


def blended(lanes: Any, new: Any, old_value: Any) -> Any:
    """Return the new value in some lanes and the old one in the others, or the new value if their forms differ."""
    if new is old_value:
        return new
    try:
        new, old_value = alike([new, old_value])
        pairs = list(zip(leaves(new), leaves(old_value), strict=True))
        results = [a if a is b else symbols.selected(lanes, a, b) for a, b in pairs]
    except (NotTraceableError, ValueError, TypeError):
        return new
    return rebuilt(new, iter(results))
