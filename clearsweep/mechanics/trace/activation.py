"""An activation of a traced function: its names, active lanes, exits and source."""

import ast
import builtins
import functools
import itertools
import linecache
import types
from typing import Any, NamedTuple

from . import symbols
from .paths import Path
from .symbols import NotTraceableError, trace

LANES = "lanes "  # names of variables with the active lanes of a function, a loop or its turn
RETURNED = "returned "  # name of the variable with the values returned in inactive lanes
_NUMBERS = itertools.count()  # of activations


class Returns(Exception):  # noqa: N818 - not an error: the loop is emitted again
    """A loop returns a value in some lanes, which needs a variable from its beginning."""

    def __init__(self, value: Any):
        super().__init__()
        self.value = value


class Loop(NamedTuple):
    """Exits of a turn of a loop."""

    breaks: list[Path]
    goes_on: list[Path]


class Activation:
    """An activation of a function."""

    __slots__ = ("asked_by", "free", "function", "loops", "mask", "names", "node", "number", "returns")

    def __init__(self, function: Any, names: dict[str, Any], free: dict[str, Any]):
        self.function, self.names, self.free = function, names, free
        self.returns: list[Path] = []
        self.loops: list[Loop] = []
        self.node: Any = None
        self.number = next(_NUMBERS)
        self.mask: Any = None  # lanes in which statements have an effect; None: all
        self.asked_by: Any = trace().lanes()  # lanes in which the function is called

    def lanes(self) -> Any:
        """Return the lanes in which statements of this function have an effect, or None for all lanes."""
        mask = self.mask
        for name, there in self.names.items():
            if name.startswith(LANES):
                mask = there if mask is None else symbols.both(mask, there)
        return mask

    def lanes_in_all(self) -> Any:
        """Return the lanes in which statements have an effect, over all activations."""
        mask = self.lanes()
        if mask is None or self.asked_by is None:
            return self.asked_by if mask is None else mask
        return symbols.both(self.asked_by, mask)

    def look_up(self, name: str) -> Any:
        """Return the value of a name."""
        for space in (self.names, self.free, self.function.__globals__):
            if name in space:
                return space[name]
        try:
            return getattr(builtins, name)
        except AttributeError:
            raise NotTraceableError(f"uses {name}, which has no value on every path") from None


@functools.cache
def _statements(file: str, leading: int, count: int) -> list[ast.stmt]:
    return ast.parse("".join(linecache.getlines(file))).body


@functools.cache
def _trees(statement: ast.stmt) -> dict[int, Any]:
    trees: dict[int, Any] = {}
    for node in ast.walk(statement):
        if isinstance(node, ast.FunctionDef):
            trees[_first_line(node)] = node
        elif isinstance(node, ast.Lambda):
            trees.setdefault(node.lineno, node)
    return trees


def _first_line(node: Any) -> int:
    """Return the first line of a statement, including decorators."""
    return min([node.lineno, *(item.lineno for item in getattr(node, "decorator_list", ()))])


@functools.cache
def tree_of(code: types.CodeType) -> Any:
    """Return the syntax tree of a function."""
    lines = linecache.getlines(code.co_filename)
    for statement in _statements(code.co_filename, hash("".join(lines)), len(lines)):
        is_inside = _first_line(statement) <= code.co_firstlineno <= (statement.end_lineno or 0)
        if is_inside and (tree := _trees(statement).get(code.co_firstlineno)):
            return tree
    raise NotTraceableError(f"is a function whose source is not at hand: {code.co_name}")


@functools.cache
def stored(node: Any) -> tuple[str, ...]:
    """Return the names that a statement and its parts assign."""
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return tuple(dict.fromkeys(names))


@functools.cache
def contains(node: Any, kind: type) -> bool:
    """Return whether there is a statement of a kind in a loop."""
    return any(isinstance(n, kind) for statement in node.body for n in ast.walk(statement))


def refusal(activation: Activation, reason: str) -> NotTraceableError:
    """Return the error for untraceable code, with function and line."""
    code, line = activation.function.__code__, getattr(activation.node, "lineno", 0)
    text = linecache.getline(code.co_filename, line).strip()
    return NotTraceableError(f"{code.co_filename}:{line}: {code.co_name} cannot be traced: it {reason}: {text}")
