"""An activation of a traced function: its syntax tree, checked to be what Python runs, its names, lanes and exits."""

import __future__

import ast
import builtins
import functools
import inspect
import itertools
import linecache
import types
from collections.abc import Iterator
from typing import Any, NamedTuple

from . import symbols
from .paths import Path
from .symbols import NotTraceableError, trace

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
            for tree in _functions_at(statement, code.co_firstlineno, code.co_name):
                if isinstance(tree, ast.FunctionDef) or _contains_code(tree, code):
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
    if not places:
        raise NotTraceableError(f"calls {_named(code)}, one of several in its line, without positions in its code")
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
