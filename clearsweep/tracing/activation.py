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


class Activation:
    """An activation of a function."""

    __slots__ = ("caller_lanes", "closure", "function", "loops", "mask", "names", "node", "number", "returns")

    def __init__(self, function: Any, names: dict[str, Any], closure: dict[str, Any]):
        self.function, self.names, self.closure = function, names, closure
        self.returns: list[Path] = []
        self.loops: list[LoopExits] = []
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
        for namespace in (self.names, self.closure, self.function.__globals__):
            if name in namespace:
                return namespace[name]
        try:
            return getattr(builtins, name)
        except AttributeError:
            raise NotTraceableError(f"uses {name}, which has no value on every path") from None


@functools.cache
def _statements(path: str, source_hash: int, line_count: int) -> list[ast.stmt]:
    return ast.parse("".join(linecache.getlines(path))).body


@functools.cache
def _functions_by_line(statement: ast.stmt) -> dict[int, Any]:
    functions: dict[int, Any] = {}
    for node in ast.walk(statement):
        if isinstance(node, ast.FunctionDef):
            functions[_first_line(node)] = node
        elif isinstance(node, ast.Lambda):
            functions.setdefault(node.lineno, node)
    return functions


def _first_line(node: Any) -> int:
    """Return the first line of a statement, including decorators."""
    return min([node.lineno, *(item.lineno for item in getattr(node, "decorator_list", ()))])


@functools.cache
def syntax_tree(code: types.CodeType) -> Any:
    """Return the syntax tree of a function."""
    lines = linecache.getlines(code.co_filename)
    for statement in _statements(code.co_filename, hash("".join(lines)), len(lines)):
        is_enclosing = _first_line(statement) <= code.co_firstlineno <= (statement.end_lineno or 0)
        if is_enclosing and (tree := _functions_by_line(statement).get(code.co_firstlineno)):
            return tree
    raise NotTraceableError(f"is a function whose source is not available: {code.co_name}")


@functools.cache
def assigned_names(node: Any) -> tuple[str, ...]:
    """Return the names that a statement and its parts assign."""
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return tuple(dict.fromkeys(names))


@functools.cache
def contains(node: Any, node_type: type) -> bool:
    """Return whether a loop contains a statement of a type."""
    return any(isinstance(n, node_type) for statement in node.body for n in ast.walk(statement))


def untraceable_error(activation: Activation, reason: str) -> NotTraceableError:
    """Return the error for untraceable code, with function and line."""
    code, line = activation.function.__code__, getattr(activation.node, "lineno", 0)
    text = linecache.getline(code.co_filename, line).strip()
    return NotTraceableError(f"{code.co_filename}:{line}: {code.co_name} cannot be traced: it {reason}: {text}")
