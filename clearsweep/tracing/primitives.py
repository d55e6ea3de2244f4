"""Registry of functions with their own emitters, and of functions whose bodies are traced."""

from collections.abc import Callable
from typing import Any

from .symbols import is_symbol

PRIMITIVES: dict[Any, Callable] = {}  # functions that are not emitted from their bodies
RULES: dict[str, Callable] = {}  # Python operation -> its rule for numbers with slopes
_SLOPE_RULES: dict[Any, Callable] = {}  # function -> its rule for numbers with slopes
LOOPS: list[Any] = [range]  # functions that return loop indices; all but the first are never unrolled
LANE_LOOPS: list[Any] = []  # functions that return loop indices whose iterations run simultaneously, one per lane
BODIES = "__traced__"  # attribute of a function whose body is traced at every call, SEPARATE or INLINED
SEPARATE, INLINED = "on its own", "inside"  # as a separate machine code function, or inlined in its caller


def register_emitter(*functions: Any) -> Callable:
    """Return a decorator that registers the emitter of calls of these functions with symbols."""

    def register(emit: Callable) -> Callable:
        for function in functions:
            PRIMITIVES[function] = emit
        return emit

    return register


def register_slope_rules(rules: dict[str, Callable]) -> None:
    """Register rules for numbers with slopes, by Python operation."""
    RULES.update(rules)


def register_slope_rule(function: Any, rule: Callable) -> None:
    """Register the rule of a function for numbers with slopes."""
    _SLOPE_RULES[function] = rule


def slope_rule(function: Any) -> Callable | None:
    """Return the rule of a function for numbers with slopes, or None if its body is differentiated."""
    try:
        return _SLOPE_RULES.get(function)
    except TypeError:
        return None


def mark_traceable(function: Any, mode: str = INLINED) -> Any:
    """Return a function marked as traceable."""
    setattr(function, BODIES, mode)
    return function


def register_symbol_emitter(function: Any, emit: Callable) -> None:
    """Register the emitter of a Python function with symbols; without symbols, Python runs the function."""

    def dispatch(*operands: Any, **keywords: Any) -> Any:
        items = operands[0] if len(operands) == 1 and isinstance(operands[0], (list, tuple)) else operands
        return emit(*operands, **keywords) if any(map(is_symbol, items)) else function(*operands, **keywords)

    PRIMITIVES[function] = dispatch
