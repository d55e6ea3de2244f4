"""A function at work: its names, the lanes in which it goes on, the paths by which it is left, its source."""

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

LANES = "lanes "  # names of variables that hold in which lanes a function, a loop or its turn goes on
RETURNED = "returned "  # name of the variable that contains what was returned in lanes that go on no more
_NUMBERS = itertools.count()  # of activations


class Returns(Exception):  # noqa: N818 - it is no error: the loop is emitted anew
    """A loop returns a value in some lanes, for which there is to be a variable when it begins."""

    def __init__(self, value: Any):
        super().__init__()
        self.value = value


class Loop(NamedTuple):
    """Where the paths that leave a turn of a loop are kept."""

    breaks: list[Path]
    goes_on: list[Path]


class Activation:
    """A function at work."""

    __slots__ = ("asked_by", "free", "function", "loops", "mask", "names", "node", "number", "returns")

    def __init__(self, function: Any, names: dict[str, Any], free: dict[str, Any]):
        self.function, self.names, self.free = function, names, free
        self.returns: list[Path] = []
        self.loops: list[Loop] = []
        self.node: Any = None
        self.number = next(_NUMBERS)
        self.mask: Any = None  # in which lanes a statement is to do something; None: in all
        self.asked_by: Any = trace().lanes()  # in which lanes the function is wanted

    def lanes(self) -> Any:
        """Return in which lanes a statement does something, as far as this function decides; None: in all."""
        mask = self.mask
        for name, there in self.names.items():
            if name.startswith(LANES):
                mask = there if mask is None else symbols.both(mask, there)
        return mask

    def lanes_in_all(self) -> Any:
        """Return the same, as all functions at work decide."""
        mask = self.lanes()
        if mask is None or self.asked_by is None:
            return self.asked_by if mask is None else mask
        return symbols.both(self.asked_by, mask)

    def look_up(self, name: str) -> Any:
        """Return what a name represents."""
        for space in (self.names, self.free, self.function.__globals__):
            if name in space:
                return space[name]
        try:
            return getattr(builtins, name)
        except AttributeError:
            raise NotTraceableError(f"uses {name}, which has no value on every path") from None


@functools.cache
def _trees(file: str, first: int, count: int) -> dict[int, Any]:
    text = "".join(linecache.getlines(file))
    trees: dict[int, Any] = {}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            begin = min([node.lineno, *(item.lineno for item in node.decorator_list)])
            trees[begin] = node
        elif isinstance(node, ast.Lambda):
            trees.setdefault(node.lineno, node)
    return trees


@functools.cache
def tree_of(code: types.CodeType) -> Any:
    """Return the syntax tree of a function."""
    lines = linecache.getlines(code.co_filename)
    trees = _trees(code.co_filename, hash("".join(lines)), len(lines))
    if code.co_firstlineno not in trees:
        raise NotTraceableError(f"is a function whose source is not at hand: {code.co_name}")
    return trees[code.co_firstlineno]


@functools.cache
def stored(node: Any) -> tuple[str, ...]:
    """Return the names that a statement, or what is in it, gives values."""
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return tuple(dict.fromkeys(names))


@functools.cache
def contains(node: Any, kind: type) -> bool:
    """Return whether there is a statement of a kind in a loop."""
    return any(isinstance(n, kind) for statement in node.body for n in ast.walk(statement))


def refusal(activation: Activation, reason: str) -> NotTraceableError:
    """Return the error that says where, in which function, what cannot be traced."""
    code, line = activation.function.__code__, getattr(activation.node, "lineno", 0)
    text = linecache.getline(code.co_filename, line).strip()
    return NotTraceableError(f"{code.co_filename}:{line}: {code.co_name} cannot be traced: it {reason}: {text}")
