"""What is emitted otherwise than by its body, and which bodies are run at all: entered by those who define them."""

from collections.abc import Callable
from typing import Any

from .symbols import is_symbol

PRIMITIVES: dict[Any, Callable] = {}  # functions that are emitted otherwise than by their bodies
RULES: dict[str, Callable] = {}  # operation of Python -> what does it to numbers with slopes
_SLOPE_RULES: dict[Any, Callable] = {}  # function -> what it does to numbers with slopes
LOOPS: list[Any] = [range]  # functions that give whole numbers to count by; but for the first, to be left loops
ABREAST: list[Any] = []  # functions that give whole numbers whose turns are run at once, a lane each
BODIES = "__traced__"  # attribute of a function: its body is run here wherever it is called, ON_ITS_OWN or INSIDE
ON_ITS_OWN, INSIDE = "on its own", "inside"  # as a function of machine code, or as a part of its caller


def primitive(*functions: Any) -> Callable:
    """Enter what emits a call of any of these functions where one of the values given is a symbol."""

    def register(emit: Callable) -> Callable:
        for function in functions:
            PRIMITIVES[function] = emit
        return emit

    return register


def rules_of_slopes(rules: dict[str, Callable]) -> None:
    """Enter what is done to numbers with slopes, by the operation of Python."""
    RULES.update(rules)


def rule_of_function(function: Any, rule: Callable) -> None:
    """Enter what a function does to numbers with slopes."""
    _SLOPE_RULES[function] = rule


def slope_rule(function: Any) -> Callable | None:
    """Return what a function does to numbers with slopes, or None if it has a body for them."""
    try:
        return _SLOPE_RULES.get(function)
    except TypeError:
        return None


def traceable(function: Any, how: str = INSIDE) -> Any:
    """Return a function marked so that its body is run on symbols."""
    setattr(function, BODIES, how)
    return function


def for_symbols(function: Any, emit: Callable) -> None:
    """Enter what emits a function of Python where a symbol is given; else Python does it."""

    def entered(*given: Any, **named: Any) -> Any:
        flat = given[0] if len(given) == 1 and isinstance(given[0], (list, tuple)) else given
        return emit(*given, **named) if any(map(is_symbol, flat)) else function(*given, **named)

    PRIMITIVES[function] = entered
