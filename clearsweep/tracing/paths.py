"""Values composed of symbols: their parts, their forms, and their merging where paths through the code join."""

import math
import types
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir

from . import symbols
from .memory import View, constant_table
from .protocols import Composite, Sloped, has_slope
from .symbols import (
    ADDRESS,
    Boolean,
    LaneIndices,
    NotTraceableError,
    Symbol,
    as_kind,
    is_symbol,
    kind_of,
    llvm_type,
    select,
    trace,
    width_of,
)


class Path(NamedTuple):
    """A path through a body, with the block at which it ends."""

    block: Any
    value: Any


def map_leaves(x: Any, function: Callable) -> Any:
    """Return nested tuples with every item changed."""
    return rebuild(x, iter([function(item) for item in leaves(x)]))


def type_key(x: Any) -> Any:
    """Return the form of a value on which machine code depends: all of it except the values of symbols."""
    if isinstance(x, tuple):
        return (type(x), *map(type_key, x))
    if isinstance(x, Composite):
        return (type(x), x.static_key, *map(type_key, x.traced_parts()))
    if isinstance(x, LaneIndices):
        return LaneIndices, type_key(x.first)
    if isinstance(x, Symbol):
        return type(x), x.width
    if isinstance(x, View):
        constant = x.base if isinstance(x.base, ir.GlobalVariable) else None
        extents = tuple(map(type_key, (*x.shape, *x.strides, x.offset)))
        return View, constant, x.item, len(x.shape), extents, x.width
    if isinstance(x, np.ndarray):
        trace().kept_alive.append(x)
        return np.ndarray, id(x)
    if isinstance(x, float):
        return float, x.hex()
    if not isinstance(x, (int, str, type, types.FunctionType, np.generic, type(None))):
        raise NotTraceableError(f"passes a {type(x).__name__}")
    return type(x), x


def passed_values(x: Any) -> list[Any]:
    """Return the parts of a value that are passed to a function of machine code."""
    values: list[Any] = []
    for item in leaves(x):
        if isinstance(item, LaneIndices):
            values += passed_values(item.first)
        elif isinstance(item, Symbol):
            values.append(item.value)
        elif isinstance(item, View):
            if not isinstance(item.base, ir.GlobalVariable):
                values.append(item.base)
            values += passed_values((*item.shape, *item.strides, item.offset))
    return values


def receive_values(x: Any, arguments: Iterator[Any]) -> Any:
    """Return a value as a function of machine code receives it."""

    def receive(item: Any) -> Any:
        if isinstance(item, LaneIndices):
            return LaneIndices(receive(item.first))
        if isinstance(item, Symbol):
            return type(item)(next(arguments), item.width)
        if isinstance(item, View):
            base = item.base if isinstance(item.base, ir.GlobalVariable) else next(arguments)
            shape, strides = (tuple(receive(count) for count in counts) for counts in (item.shape, item.strides))
            return View(base, item.item, shape, strides, item.width, receive(item.offset))
        return item

    return map_leaves(x, receive)


def leaves(x: Any) -> list[Any]:
    """Return the items of nested tuples and of numbers with slopes."""
    items, waiting = [], [x]
    while waiting:
        value = waiting.pop()
        if isinstance(value, tuple):
            waiting += value[::-1]
        elif isinstance(value, Composite):
            waiting += value.traced_parts()[::-1]
        else:
            items.append(value)
    return items


def rebuild(x: Any, values: Iterator[Any]) -> Any:
    """Return nested tuples with their items replaced."""
    if isinstance(x, tuple):
        parts = [rebuild(item, values) for item in x]
        return type(x)(*parts) if hasattr(x, "_fields") else tuple(parts)
    if isinstance(x, Composite):
        return x.with_traced_parts([rebuild(item, values) for item in x.traced_parts()])
    return next(values)


def with_common_slopes(values: list[Any]) -> list[Any]:
    """Return values, with slopes added to all numbers where one of them has slopes."""
    first = values[0]
    if all(isinstance(x, tuple) for x in values):
        if any(len(x) != len(first) or type(x) is not type(first) for x in values):
            raise NotTraceableError("returns tuples of different forms")
        columns = [with_common_slopes(list(column)) for column in zip(*values, strict=True)]
        leaf_rows: Any = zip(*columns, strict=True) if columns else [() for _ in values]
        return [type(first)(*row) if hasattr(first, "_fields") else tuple(row) for row in leaf_rows]
    slopes = [x for x in values if isinstance(x, Sloped)]
    if slopes and len(slopes) < len(values):
        return [x if has_slope(x) else type(slopes[0])(x, 0.0) for x in values]
    if slopes:
        parts = zip(*(x.traced_parts() for x in values), strict=True)
        columns = [with_common_slopes(list(column)) for column in parts]
        return [type(x)(*row) for x, row in zip(values, zip(*columns, strict=True), strict=True)]
    return values


def select_values(condition: Any, a: Any, b: Any) -> Any:
    """Emit `a` where a condition is true, else `b`: both are evaluated, and are numbers or tuples of one form."""
    if not is_symbol(condition):
        return a if condition else b
    a, b = with_common_slopes([a, b])
    first_items, second_items = leaves(a), leaves(b)
    if (type(a) is not type(b) and isinstance(a, (tuple, Composite))) or len(first_items) != len(second_items):
        raise NotTraceableError("chooses between values of different forms")
    pairs = zip(first_items, second_items, strict=True)
    return rebuild(a, iter([x if x is y else _select_item(condition, x, y) for x, y in pairs]))


def _select_item(condition: Any, a: Any, b: Any) -> Any:
    numbers = (Symbol, int, float, np.number, np.bool_)
    if isinstance(a, numbers) and isinstance(b, numbers):
        return select(condition, a, b)
    if type(a) is type(b) and isinstance(a, (str, type)) and a == b:
        return a
    raise NotTraceableError("chooses between values that are no numbers")


def join_paths(paths: list[Path]) -> Any:
    """Emit the block where paths join; return the value there."""
    builder = trace().builder
    if len(paths) == 1:
        builder.position_at_end(paths[0].block)
        return paths[0].value
    end = trace().block()
    values = with_common_slopes([path.value for path in paths])
    leaf_rows = [leaves(value) for value in values]
    if len({len(row) for row in leaf_rows}) != 1:
        raise NotTraceableError("gives different forms on different paths")
    results = [
        merge_values([path.block for path in paths], list(column), end) for column in zip(*leaf_rows, strict=True)
    ]
    for path in paths:
        builder.position_at_end(path.block)
        builder.branch(end)
    builder.position_at_end(end)
    return rebuild(values[0], iter(results))


def merge_values(blocks: list[Any], column: list[Any], end: Any) -> Any:
    """Return the merged values in the block where other blocks end."""
    first, builder = column[0], trace().builder
    if all(x is first for x in column):
        return first
    if any(isinstance(x, (View, np.ndarray)) for x in column):
        return _merge_views(blocks, [constant_table(x) if isinstance(x, np.ndarray) else x for x in column], end)
    if not all(isinstance(x, (Symbol, int, float, np.number, np.bool_)) for x in column):
        if not any(map(is_symbol, column)) and all(type(x) is type(first) and x == first for x in column):
            return first
        raise NotTraceableError("gives values of different types on different paths")
    if not any(map(is_symbol, column)) and all(
        type(x) is type(first) and x == first and math.copysign(1.0, x) == math.copysign(1.0, first) for x in column
    ):
        return first
    kind, width = kind_of(*column), width_of(*column)
    emitted = []
    for block, x in zip(blocks, column, strict=True):
        builder.position_at_end(block)
        emitted.append(as_kind(x, kind, width))
    builder.position_at_end(end)
    phi = builder.phi(llvm_type(kind.item, width))  # type: ignore[attr-defined]
    for block, value in zip(blocks, emitted, strict=True):
        phi.add_incoming(value, block)
    return kind(phi, width)


def _merge_views(blocks: list[Any], column: list[Any], end: Any) -> View:
    first, base = column[0], column[0].base
    is_same_form = all(
        isinstance(x, View) and (x.item, x.width, len(x.shape)) == (first.item, first.width, len(first.shape))
        for x in column
    )
    if not is_same_form:
        raise NotTraceableError("gives different arrays on different paths")
    if any(x.base is not base for x in column):
        base = _merge_addresses(blocks, [x.base for x in column], end)
    extents = [
        merge_values(blocks, list(sizes), end)
        for sizes in zip(*((*x.shape, *x.strides, x.offset) for x in column), strict=True)
    ]
    count = len(first.shape)
    return View(base, first.item, tuple(extents[:count]), tuple(extents[count:-1]), first.width, extents[-1])


def _merge_addresses(blocks: list[Any], bases: list[Any], end: Any) -> Any:
    """Return the address of one of several arrays in the block where other blocks end."""
    builder, addresses = trace().builder, []
    for block, base in zip(blocks, bases, strict=True):
        builder.position_at_end(block)
        addresses.append(builder.bitcast(base, ADDRESS))
    builder.position_at_end(end)
    phi = builder.phi(ADDRESS)
    for block, address in zip(blocks, addresses, strict=True):
        phi.add_incoming(address, block)
    return phi


# ----------------------------------------------------------------------------------------------------------------------
# Conditions over lanes, and values that differ between lanes.


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
