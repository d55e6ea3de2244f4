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
    return rebuilt(x, iter([change(part) for part in leaves(x)]))


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
        known = x.base if isinstance(x.base, ir.GlobalVariable) else None
        extents = tuple(map(form_of, (*x.shape, *x.strides, x.offset)))
        return View, known, x.item, len(x.shape), extents, x.width
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
    for part in leaves(x):
        if isinstance(part, Abreast):
            names += passed(part.first)
        elif isinstance(part, Symbol):
            names.append(part.value)
        elif isinstance(part, View):
            if not isinstance(part.base, ir.GlobalVariable):
                names.append(part.base)
            names += passed((*part.shape, *part.strides, part.offset))
    return names


def received(x: Any, arguments: Iterator[Any]) -> Any:
    """Return a value as a function of machine code receives it."""

    def single(part: Any) -> Any:
        if isinstance(part, Abreast):
            return Abreast(single(part.first))
        if isinstance(part, Symbol):
            return type(part)(next(arguments), part.width)
        if isinstance(part, View):
            base = part.base if isinstance(part.base, ir.GlobalVariable) else next(arguments)
            shape, strides = (tuple(single(count) for count in counts) for counts in (part.shape, part.strides))
            return View(base, part.item, shape, strides, part.width, single(part.offset))
        return part

    return changed(x, single)


def leaves(x: Any) -> Iterator[Any]:
    """Yield the items of nested tuples and of numbers with slopes."""
    if isinstance(x, tuple):
        for part in x:
            yield from leaves(part)
    elif hasattr(x, "pieces"):
        for part in x.pieces():
            yield from leaves(part)
    else:
        yield x


def rebuilt(x: Any, values: Iterator[Any]) -> Any:
    """Return nested tuples with their items replaced."""
    if isinstance(x, tuple):
        parts = [rebuilt(part, values) for part in x]
        return type(x)(*parts) if hasattr(x, "_fields") else tuple(parts)
    if hasattr(x, "pieces"):
        made = [rebuilt(part, values) for part in x.pieces()]
        return x.remade(made) if hasattr(x, "remade") else type(x)(*made)
    return next(values)


def alike(values: list[Any]) -> list[Any]:
    """Return values, with slopes added to all numbers where one of them has slopes."""
    first = values[0]
    if all(isinstance(x, tuple) for x in values):
        if any(len(x) != len(first) or type(x) is not type(first) for x in values):
            raise NotTraceableError("returns tuples of different forms")
        columns = [alike(list(column)) for column in zip(*values, strict=True)]
        rows: Any = zip(*columns, strict=True) if columns else [() for _ in values]
        return [type(first)(*row) if hasattr(first, "_fields") else tuple(row) for row in rows]
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
    made = [meeting([path.block for path in paths], list(column), end) for column in zip(*rows, strict=True)]
    for path in paths:
        builder.position_at_end(path.block)
        builder.branch(end)
    builder.position_at_end(end)
    return rebuilt(values[0], iter(made))


def meeting(blocks: list[Any], column: list[Any], end: Any) -> Any:
    """Return the merged values in the block where other blocks end."""
    first, builder = column[0], trace().builder
    if all(x is first for x in column):
        return first
    if any(isinstance(x, (View, np.ndarray)) for x in column):
        return _view_of(blocks, [table_of(x) if isinstance(x, np.ndarray) else x for x in column], end)
    if not all(isinstance(x, (Symbol, int, float, np.number, np.bool_)) for x in column):
        if all(type(x) is type(first) and x == first for x in column):
            return first
        raise NotTraceableError("gives different things on different paths")
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
    phi = builder.phi(form(kind.item, width))  # type: ignore[attr-defined]
    for block, value in zip(blocks, emitted, strict=True):
        phi.add_incoming(value, block)
    return kind(phi, width)


def _view_of(blocks: list[Any], column: list[Any], end: Any) -> View:
    first, base = column[0], column[0].base
    same = all(
        isinstance(x, View) and (x.item, x.width, len(x.shape)) == (first.item, first.width, len(first.shape))
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
    count = len(first.shape)
    return View(base, first.item, tuple(extents[:count]), tuple(extents[count:-1]), first.width, extents[-1])


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
