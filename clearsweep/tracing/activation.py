"""An activation of a traced function: its names, active lanes and exits."""

import builtins
import itertools
from typing import Any, NamedTuple

from . import symbols
from .paths import Path
from .sources import local_names, syntax_tree
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
