"""What the tracer asks of the objects that it meets: the protocols of values and of functions, and its registries.

Values: numbers, truth values, None, texts, types, functions and (named) tuples of values need no protocol, arrays are
Views, and every other value with parts that are known only at run time is a `Composite`:

| protocol of a Composite | answers |
| --- | --- |
| `traced_parts()` | its parts, values themselves, of which some are known only at run time |
| `with_traced_parts(parts)` | a value of the same form with other parts |
| `static_key` | what else of it decides on machine code, or None |
| `traced_item` | the function (value, index) whose body gives an item, or None |
| `Sloped` | a Composite that is a number with a slope; its parts are the number and the slope |

Functions: one that `mark_traceable` has marked is traced, as is every plain function of Python; two attributes, each
read by the function below it of the same name, say that a call is one of another function:

| attribute | a call with these operands is |
| --- | --- |
| `body_of(value)` | one of the body for the type of the first operand (`compiled.family.family`) |
| `sides` | one of two functions, as a condition decides: (if true, if false) (`compiled.choosing.cond`) |
"""

from collections.abc import Callable
from typing import Any

from .symbols import NotTraceableError, is_symbol

PRIMITIVES: dict[Any, Callable] = {}  # functions that are not emitted from their bodies
RULES: dict[str, Callable] = {}  # Python operation -> its rule for numbers with slopes
_SLOPE_RULES: dict[Any, Callable] = {}  # function -> its rule for numbers with slopes
LOOPS: list[Any] = [range]  # functions that return loop indices; all but the first are never unrolled
LANE_LOOPS: list[Any] = []  # functions that return loop indices whose iterations run simultaneously, one per lane
BODIES = "__traced__"  # attribute of a marked function: SEPARATE, INLINED or KNOWN
SEPARATE, INLINED = "on its own", "inside"  # as a separate machine code function, or inlined in its caller
KNOWN = "while tracing"  # runs as Python, and looks at nothing but types and known values


class Composite:
    """A value with parts that may be known only at run time."""

    __slots__ = ()
    static_key: Any = None
    traced_item: Any = None

    def traced_parts(self) -> tuple[Any, ...]:
        """Return the parts."""
        raise NotImplementedError

    def with_traced_parts(self, parts: list[Any]) -> Any:
        """Return a value of the same form with other parts."""
        return type(self)(*parts)


class Sloped(Composite):
    """A number with a slope."""

    __slots__ = ()


def has_slope(*operands: Any) -> bool:
    """Return whether any operand is a number with a slope."""
    return any(isinstance(x, Sloped) for x in operands)


def body_of(function: Any, operands: tuple) -> Any:
    """Return the body that a function chooses by the type of its first operand, or None if it chooses none."""
    choose = getattr(function, "body_of", None)
    if choose is None:
        return None
    if body := choose(operands[0]):
        return body
    raise NotTraceableError(f"calls {function.__name__}, which has no body for a {type(operands[0]).__name__}")


def sides(function: Any) -> Any:
    """Return both functions between which a condition decides, or None."""
    return getattr(function, "sides", None)


def mode_of(function: Any) -> str | None:
    """Return how a marked function is traced, or None if it is not marked."""
    return getattr(function, BODIES, None)


def mark_traceable(function: Any, mode: str = INLINED) -> Any:
    """Return a function marked as traceable."""
    setattr(function, BODIES, mode)
    return function


def register_emitter(*functions: Any) -> Callable:
    """Return a decorator that registers the emitter of calls of these functions with symbols."""

    def register(emit: Callable) -> Callable:
        for function in functions:
            PRIMITIVES[function] = emit
        return emit

    return register


def register_symbol_emitter(function: Any, emit: Callable) -> None:
    """Register the emitter of a Python function with symbols; without symbols, Python runs the function."""

    def dispatch(*operands: Any, **keywords: Any) -> Any:
        items = operands[0] if len(operands) == 1 and isinstance(operands[0], (list, tuple)) else operands
        return emit(*operands, **keywords) if any(map(is_symbol, items)) else function(*operands, **keywords)

    PRIMITIVES[function] = dispatch


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
