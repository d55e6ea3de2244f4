"""An activation of a traced function: its syntax tree, checked to be what Python runs, its names, lanes and exits.

And the values that its paths carry: their parts, their forms, and their merging where the paths join.
"""

import __future__

import ast
import builtins
import functools
import inspect
import itertools
import linecache
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
    value = merged([path.block for path in paths], [path.value for path in paths], end)
    lead(paths, end)
    return value


def merged(blocks: list[Any], values: list[Any], end: Any) -> Any:
    """Return the value, numbers or tuples of one form, in the block where other blocks end that give these values."""
    values = with_common_slopes(values)
    leaf_rows = [leaves(value) for value in values]
    if len({len(row) for row in leaf_rows}) != 1:
        raise NotTraceableError("gives different forms on different paths")
    results = [merge_values(blocks, list(column), end) for column in zip(*leaf_rows, strict=True)]
    return rebuild(values[0], iter(results))


def lead(paths: list[Path], end: Any) -> None:
    """Let paths lead to a block, and continue there."""
    builder = trace().builder
    for path in paths:
        builder.position_at_end(path.block)
        builder.branch(end)
    builder.position_at_end(end)


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


# ----------------------------------------------------------------------------------------------------------------------
# Syntax trees of functions, from their sources on disk, checked to be the code that Python runs.


SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)
COMPREHENSIONS = (ast.GeneratorExp, ast.ListComp, ast.SetComp, ast.DictComp)
REFUSED = {  # what changes the meaning of a whole function, wherever it is
    ast.Global: "has a global statement",
    ast.Nonlocal: "has a nonlocal statement",
    ast.Yield: "is a generator",
    ast.YieldFrom: "is a generator",
    ast.NamedExpr: "assigns within an expression (:=)",
}


@functools.cache
def syntax_tree(code: types.CodeType) -> Any:
    """Return the syntax tree of a function, a FunctionDef or a Lambda."""
    lines = linecache.getlines(code.co_filename)
    statements = _statements(code.co_filename, hash("".join(lines)), len(lines))
    imports = tuple(x for x in statements if isinstance(x, (ast.Import, ast.ImportFrom)))
    flags = code.co_flags & __future__.annotations.compiler_flag
    for statement in statements:
        if _first_line(statement) <= code.co_firstlineno <= (statement.end_lineno or 0):
            trees = _functions_at(statement, code.co_firstlineno, code.co_name)
            for tree in trees:
                if len(trees) == 1 or isinstance(tree, ast.FunctionDef) or _contains_code(tree, code):
                    _check(tree, code, _compiled(statement, imports, code.co_filename, flags))
                    return tree
    raise NotTraceableError(f"calls {_named(code)}, whose source is not available")


def _named(code: types.CodeType) -> str:
    return f"{code.co_name} ({code.co_filename}:{code.co_firstlineno})"


@functools.cache
def _statements(path: str, source_hash: int, line_count: int) -> list[ast.stmt]:
    return ast.parse("".join(linecache.getlines(path))).body


def _functions_at(statement: ast.stmt, line: int, name: str) -> list[Any]:
    """Return the functions of this name that begin at a line, the innermost first."""
    trees = [tree for tree in _functions(statement) if _first_line(tree) == line]
    return [tree for tree in reversed(trees) if getattr(tree, "name", "<lambda>") == name]


@functools.cache
def _functions(statement: ast.stmt) -> list[Any]:
    return [node for node in ast.walk(statement) if isinstance(node, (ast.FunctionDef, ast.Lambda))]


def _first_line(node: Any) -> int:
    """Return the first line of a statement, including decorators."""
    return min([node.lineno, *(item.lineno for item in getattr(node, "decorator_list", ()))])


def _contains_code(tree: ast.Lambda, code: types.CodeType) -> bool:
    """Return whether code is that of a lambda and not of another one that begins on the same line."""
    body = tree.body
    begin, end = (body.lineno, body.col_offset), (body.end_lineno, body.end_col_offset)
    places = [place for place in code.co_positions() if None not in place and place[3]]
    if not places:  # Python 3.12 gives none to a constant that is returned, `python -X no_debug_ranges` to nothing
        alone = compile(ast.Expression(tree), code.co_filename, "eval")
        return _fingerprint(next(_codes(alone))) == _fingerprint(code)
    return all(begin <= (place[0], place[2]) and (place[1], place[3]) <= end for place in places)


@functools.cache
def _compiled(statement: ast.stmt, imports: tuple, path: str, flags: int) -> list[types.CodeType]:
    """Return the code of all functions in a statement; that of calls depends on what the module imports."""
    module = ast.Module([*imports, statement], [])
    return list(_codes(compile(module, path, "exec", flags, dont_inherit=True)))


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield constant
            yield from _codes(constant)


def _fingerprint(code: types.CodeType) -> Any:
    """Return what a function does, without the lines in which it is."""
    constants: list[Any] = []
    for x in code.co_consts:
        is_set = isinstance(x, frozenset)
        constants.append(
            _fingerprint(x) if isinstance(x, types.CodeType) else sorted(map(repr, x)) if is_set else repr(x)
        )
    return code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars, constants


def _check(tree: Any, code: types.CodeType, compiled: list[types.CodeType]) -> None:
    """Raise an error if a function is not what its source contains, or has what cannot be traced anywhere."""
    same = (x for x in compiled if (x.co_name, x.co_firstlineno) == (code.co_name, code.co_firstlineno))
    expected = _fingerprint(code)
    if not any(_fingerprint(x) == expected for x in same):
        raise NotTraceableError(
            f"calls {_named(code)}, whose source on disk is no longer what Python runs: start Python again"
        )
    if code.co_flags & (inspect.CO_GENERATOR | inspect.CO_COROUTINE | inspect.CO_ASYNC_GENERATOR):
        raise NotTraceableError(f"calls {_named(code)}, which is a generator or a coroutine")
    for node in own_nodes(tree):
        if type(node) in REFUSED:
            raise NotTraceableError(f"calls {_named(code)}, which {REFUSED[type(node)]} in line {node.lineno}")


def own_nodes(tree: Any) -> Iterator[Any]:
    """Yield the nodes of a function without those of functions in it."""
    bodies = tree.body if isinstance(tree.body, list) else [tree.body]
    waiting = list(bodies)
    while waiting:
        node = waiting.pop()
        yield node
        if not isinstance(node, SCOPES):
            waiting += ast.iter_child_nodes(node)


@functools.cache
def local_names(tree: Any) -> frozenset[str]:
    """Return the names that are local to a function: its arguments and what it assigns."""
    names = {item.arg for item in ast.walk(tree.args) if isinstance(item, ast.arg)}
    for node in tree.body if isinstance(tree.body, list) else ():
        names |= _assigned(node)
    return frozenset(names)


def _assigned(node: Any) -> set[str]:
    """Return the names that a node assigns in the scope in which it is."""
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        return {node.name}
    if isinstance(node, (ast.Lambda, *COMPREHENSIONS)):
        return set()
    names = {node.id} if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) else set()
    return names.union(*map(_assigned, ast.iter_child_nodes(node)))


@functools.cache
def assigned_names(node: Any) -> tuple[str, ...]:
    """Return the names that a statement and its parts assign."""
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return tuple(dict.fromkeys(names))


@functools.cache
def contains(node: Any, node_type: type) -> bool:
    """Return whether a loop contains a statement of a type."""
    return any(isinstance(n, node_type) for statement in node.body for n in ast.walk(statement))


def place_of(function: Any, node: Any) -> tuple[str, str]:
    """Return file and line of a statement, and its text."""
    code = function.__code__
    line = getattr(node, "lineno", code.co_firstlineno)
    return f"{code.co_filename}:{line}", linecache.getline(code.co_filename, line).strip()


# ----------------------------------------------------------------------------------------------------------------------


LANES = "lanes "  # prefix of variables with the active lanes of a function, a loop or one iteration
RETURNED = "returned "  # name of the variable with the values returned in inactive lanes
_ACTIVATION_COUNTER = itertools.count()  # of activations


class ReturnInLanes(Exception):  # noqa: N818 - not an error: the loop is emitted again
    """A loop returns a value in some lanes, which needs a variable from its beginning."""

    def __init__(self, value: Any):
        super().__init__()
        self.value = value


class LoopExits(NamedTuple):
    """Exits of an iteration of a loop."""

    breaks: list[Path]
    continues: list[Path]
    is_rolled: bool  # whether the loop is one of blocks


class Activation:
    """An activation of a function."""

    __slots__ = (
        "caller_lanes",
        "closure",
        "comprehensions",
        "function",
        "loops",
        "mask",
        "names",
        "node",
        "number",
        "returns",
    )

    def __init__(self, function: Any, names: dict[str, Any], closure: dict[str, Any]):
        self.function, self.names, self.closure = function, names, closure
        self.returns: list[Path] = []
        self.loops: list[LoopExits] = []
        self.comprehensions = 0  # comprehensions that are being evaluated
        self.node: Any = None
        self.number = next(_ACTIVATION_COUNTER)
        self.mask: Any = None  # lanes in which statements have an effect; None: all
        self.caller_lanes: Any = trace().lanes()  # lanes in which the function is called

    def lanes(self) -> Any:
        """Return the lanes in which statements of this function have an effect, or None for all lanes."""
        mask = self.mask
        for name, lanes in self.names.items():
            if name.startswith(LANES):
                mask = lanes if mask is None else symbols.bit_and(mask, lanes)
        return mask

    def lanes_in_all(self) -> Any:
        """Return the lanes in which statements have an effect, over all activations."""
        lanes = self.lanes()
        if lanes is None or self.caller_lanes is None:
            return self.caller_lanes if lanes is None else lanes
        return symbols.bit_and(self.caller_lanes, lanes)

    def look_up(self, name: str) -> Any:
        """Return the value of a name."""
        if name in self.names:
            return self.names[name]
        if name in local_names(syntax_tree(self.function.__code__)):
            raise NotTraceableError(f"uses {name}, which has no value on every path, or not one of one form")
        for namespace in (self.closure, self.function.__globals__, vars(builtins)):
            if name in namespace:
                return namespace[name]
        raise NotTraceableError(f"uses {name}, which is not defined")
