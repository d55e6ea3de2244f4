"""Values composed of symbols: their parts, their forms, and their merging where paths through the code join."""

import math
import types
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir

from .memory import View, table_of
from .symbols import ADDRESS, Abreast, NotTraceableError, Symbol, as_kind, form, is_symbol, kind_of, trace, width_of


class Path(NamedTuple):
    """A path through a body, with the block at which it ends."""

    block: Any
    value: Any


def changed(x: Any, change: Callable) -> Any:
    """Return nested tuples with every item changed."""
    return rebuilt(x, iter([change(item) for item in leaves(x)]))


def form_of(x: Any) -> Any:
    """Return the form of a value on which machine code depends: all of it except the values of symbols."""
    if isinstance(x, tuple):
        return (type(x), *map(form_of, x))
    if hasattr(x, "pieces"):
        return (type(x), getattr(x, "known", None), *map(form_of, x.pieces()))
    if isinstance(x, Abreast):
        return Abreast, form_of(x.first)
    if isinstance(x, Symbol):
        return type(x), x.width
    if isinstance(x, View):
        constant_value = x.base if isinstance(x.base, ir.GlobalVariable) else None
        extents = tuple(map(form_of, (*x.shape, *x.strides, x.offset)))
        return View, constant_value, x.item, len(x.shape), extents, x.width
    if isinstance(x, np.ndarray):
        return np.ndarray, id(x)
    if isinstance(x, float):
        return float, x.hex()
    if not isinstance(x, (int, str, type, types.FunctionType, np.generic, type(None))):
        raise NotTraceableError(f"hands over a {type(x).__name__}")
    return type(x), x


def passed(x: Any) -> list[Any]:
    """Return the parts of a value that are passed to a function of machine code."""
    names: list[Any] = []
    for item in leaves(x):
        if isinstance(item, Abreast):
            names += passed(item.first)
        elif isinstance(item, Symbol):
            names.append(item.value)
        elif isinstance(item, View):
            if not isinstance(item.base, ir.GlobalVariable):
                names.append(item.base)
            names += passed((*item.shape, *item.strides, item.offset))
    return names


def received(x: Any, arguments: Iterator[Any]) -> Any:
    """Return a value as a function of machine code receives it."""

    def one_lane(item: Any) -> Any:
        if isinstance(item, Abreast):
            return Abreast(one_lane(item.first))
        if isinstance(item, Symbol):
            return type(item)(next(arguments), item.width)
        if isinstance(item, View):
            base = item.base if isinstance(item.base, ir.GlobalVariable) else next(arguments)
            shape, strides = (tuple(one_lane(count) for count in counts) for counts in (item.shape, item.strides))
            return View(base, item.item, shape, strides, item.width, one_lane(item.offset))
        return item

    return changed(x, one_lane)


def leaves(x: Any) -> Iterator[Any]:
    """Yield the items of nested tuples and of numbers with slopes."""
    if isinstance(x, tuple):
        for item in x:
            yield from leaves(item)
    elif hasattr(x, "pieces"):
        for item in x.pieces():
            yield from leaves(item)
    else:
        yield x


def rebuilt(x: Any, values: Iterator[Any]) -> Any:
    """Return nested tuples with their items replaced."""
    if isinstance(x, tuple):
        parts = [rebuilt(item, values) for item in x]
        return type(x)(*parts) if hasattr(x, "_fields") else tuple(parts)
    if hasattr(x, "pieces"):
        results = [rebuilt(item, values) for item in x.pieces()]
        return x.remade(results) if hasattr(x, "remade") else type(x)(*results)
    return next(values)


def alike(values: list[Any]) -> list[Any]:
    """Return values, with slopes added to all numbers where one of them has slopes."""
    leading = values[0]
    if all(isinstance(x, tuple) for x in values):
        if any(len(x) != len(leading) or type(x) is not type(leading) for x in values):
            raise NotTraceableError("returns tuples of different forms")
        columns = [alike(list(column)) for column in zip(*values, strict=True)]
        rows: Any = zip(*columns, strict=True) if columns else [() for _ in values]
        return [type(leading)(*row) if hasattr(leading, "_fields") else tuple(row) for row in rows]
    slopes = [x for x in values if hasattr(x, "parts")]
    if slopes and len(slopes) < len(values):
        return [x if hasattr(x, "parts") else type(slopes[0])(x, 0.0) for x in values]
    if slopes:
        columns = [alike(list(column)) for column in zip(*(x.parts() for x in values), strict=True)]
        return [type(x)(*row) for x, row in zip(values, zip(*columns, strict=True), strict=True)]
    return values


def joined(paths: list[Path]) -> Any:
    """Emit the block where paths join; return the value there."""
    builder = trace().builder
    if len(paths) == 1:
        builder.position_at_end(paths[0].block)
        return paths[0].value
    end = trace().block()
    values = alike([path.value for path in paths])
    rows = [list(leaves(value)) for value in values]
    if len({len(row) for row in rows}) != 1:
        raise NotTraceableError("gives different forms on different paths")
    results = [meeting([path.block for path in paths], list(column), end) for column in zip(*rows, strict=True)]
    for path in paths:
        builder.position_at_end(path.block)
        builder.branch(end)
    builder.position_at_end(end)
    return rebuilt(values[0], iter(results))


def meeting(blocks: list[Any], column: list[Any], end: Any) -> Any:
    """Return the merged values in the block where other blocks end."""
    leading, builder = column[0], trace().builder
    if all(x is leading for x in column):
        return leading
    if any(isinstance(x, (View, np.ndarray)) for x in column):
        return _view_of(blocks, [table_of(x) if isinstance(x, np.ndarray) else x for x in column], end)
    if not all(isinstance(x, (Symbol, int, float, np.number, np.bool_)) for x in column):
        if all(type(x) is type(leading) and x == leading for x in column):
            return leading
        raise NotTraceableError("gives different things on different paths")
    if not any(map(is_symbol, column)) and all(
        type(x) is type(leading) and x == leading and math.copysign(1.0, x) == math.copysign(1.0, leading)
        for x in column
    ):
        return leading
    kind, width = kind_of(*column), width_of(*column)
    emitted = []
    for block, x in zip(blocks, column, strict=True):
        builder.position_at_end(block)
        emitted.append(as_kind(x, kind, width))
    builder.position_at_end(end)
    phi = builder.phi(form(kind.item, width))  # type: ignore[attr-defined]
    for block, value in zip(blocks, emitted, strict=True):
        phi.add_incoming(value, block)
    return kind(phi, width)


def _view_of(blocks: list[Any], column: list[Any], end: Any) -> View:
    leading, base = column[0], column[0].base
    same = all(
        isinstance(x, View) and (x.item, x.width, len(x.shape)) == (leading.item, leading.width, len(leading.shape))
        for x in column
    )
    if not same:
        raise NotTraceableError("gives different arrays on different paths")
    if any(x.base is not base for x in column):
        base = _address_of(blocks, [x.base for x in column], end)
    extents = [
        meeting(blocks, list(each), end)
        for each in zip(*((*x.shape, *x.strides, x.offset) for x in column), strict=True)
    ]
    count = len(leading.shape)
    return View(base, leading.item, tuple(extents[:count]), tuple(extents[count:-1]), leading.width, extents[-1])


def _address_of(blocks: list[Any], bases: list[Any], end: Any) -> Any:
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
