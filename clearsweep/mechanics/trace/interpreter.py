"""Runs the body of a function on symbols, statement by statement, as its syntax tree has it.

What is known while tracing is worked out by Python: which law it is, how many joints there are, whether a number has a
slope.  A decision on a symbol becomes two blocks, whose variables meet behind it; a loop whose end is not known, or
that may end early, becomes a loop of blocks.  Other loops are written out.  In lanes, both sides of a decision run,
each in the lanes that want it, and a loop runs until all lanes have left it.
"""

import functools
import math
from typing import Any

from . import symbols
from .calls import RUNNERS
from .loops import Loops
from .primitives import for_symbols
from .symbols import Number, Whole, trace

RUNNERS.append(Loops)


def _size(x: Any) -> Any:
    if isinstance(x, Whole):
        return symbols.selected(symbols.compared("<", x, 0), symbols.negative(x), x)
    return symbols.intrinsic("fabs", x)


for_symbols(max, symbols.extreme(">"))
for_symbols(min, symbols.extreme("<"))
for_symbols(abs, _size)
for_symbols(int, symbols.as_whole)
for_symbols(float, symbols.number)
for_symbols(bool, lambda x: x)
for_symbols(math.sqrt, lambda x: symbols.intrinsic("sqrt", x))
for_symbols(math.copysign, lambda a, b: symbols.intrinsic("copysign", a, b))
for_symbols(math.floor, lambda x: symbols.as_whole(symbols.floor_number(x)))
for_symbols(math.isfinite, lambda x: symbols.compared("<", symbols.intrinsic("fabs", x), math.inf))


def _of_the_library(name: str, *given: Any) -> Number:
    """Emit the library's function, lane by lane."""
    hand, width = trace(), symbols.width_of(*given)
    kind = symbols.ir.FunctionType(symbols.DOUBLE, [symbols.DOUBLE] * len(given))
    function = hand.module.globals.get(name) or symbols.ir.Function(hand.module, kind, name)
    values = [symbols.as_kind(x, Number, width) for x in given]
    if width == 1:
        return Number(hand.builder.call(function, values))
    found: Any = symbols.ir.Constant(symbols.form(symbols.DOUBLE, width), symbols.ir.Undefined)
    for lane in range(width):
        place = symbols.WHOLE(lane)
        one = hand.builder.call(function, [hand.builder.extract_element(x, place) for x in values])
        found = hand.builder.insert_element(found, one, place)
    return Number(found, width)


for _function in [
    "sin",
    "cos",
    "tan",
    "tanh",
    "exp",
    "expm1",
    "log",
    "log1p",
    "log2",
    "atan",
    "atan2",
    "cosh",
    "sinh",
    "asin",
    "acos",
    "hypot",
]:
    for_symbols(getattr(math, _function), functools.partial(_of_the_library, _function))
for_symbols(pow, functools.partial(_of_the_library, "pow"))
