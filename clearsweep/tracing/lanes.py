"""Conditions over lanes, and values that differ between lanes."""

from typing import Any

from . import symbols
from .paths import select_values
from .symbols import Boolean, NotTraceableError, is_symbol, trace


def _compare_lanes(condition: Any, all_bits: int) -> Any:
    builder = trace().builder
    if not is_symbol(condition):
        return bool(condition) if all_bits else not condition
    if condition.width == 1:
        return condition if all_bits else symbols.logical_not(condition)
    bits = builder.bitcast(condition.value, symbols.ir.IntType(condition.width))
    return Boolean(builder.icmp_signed("==", bits, symbols.ir.Constant(bits.type, all_bits)))


def all_of(condition: Any) -> Any:
    """Emit whether a condition is true in every lane."""
    return _compare_lanes(condition, -1)


def none_of(condition: Any) -> Any:
    """Emit whether a condition is true in no lane."""
    return _compare_lanes(condition, 0)


def all_lanes(width: int) -> Boolean:
    """Return a condition that is true in every lane."""
    return Boolean(symbols.llvm_constant(symbols.BOOL, True, width), width)


def undefined_like(x: Any) -> Any:
    """Return an undefined value of the kind of a symbol; a known value is returned unchanged."""
    return type(x)(symbols.llvm_constant(x.item, 0, x.width), x.width) if is_symbol(x) else x


def blend(lanes: Any, new_value: Any, old_value: Any) -> Any:
    """Return the new value in some lanes and the old one in the others, or the new value if their forms differ."""
    if new_value is old_value:
        return new_value
    try:
        return select_values(lanes, new_value, old_value)
    except NotTraceableError:
        return new_value
