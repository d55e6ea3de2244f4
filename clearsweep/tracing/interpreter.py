"""Interprets the body of a function on symbols, statement by statement, from its syntax tree.

Values known while tracing are computed by Python: the law, the number of joints, whether a number has a
slope.  A branch on a symbol becomes two blocks, whose variables are merged after it; a loop of unknown length, or one
that may end early, becomes a loop of blocks.  Other loops are unrolled.  In lanes, both sides of a branch run,
each in its active lanes, and a loop runs until all lanes have left it.
"""

import functools
import math
from types import FunctionType
from typing import Any

from . import functions, portable, symbols
from .calls import RUNNERS, call
from .loops import Loops
from .paths import select_values
from .protocols import INLINED, PRIMITIVES, SEPARATE, mark_traceable, register_emitter, register_symbol_emitter
from .symbols import Boolean, Integer, NotTraceableError, as_boolean

RUNNERS.append(Loops)


def _absolute(x: Any) -> Any:
    if isinstance(x, (Boolean, Integer)):
        return symbols.select(symbols.compare("<", x, 0), symbols.negate(x), x)
    return symbols.call_intrinsic("fabs", x)


register_symbol_emitter(max, symbols.extremum_emitter(">"))
register_symbol_emitter(min, symbols.extremum_emitter("<"))
register_symbol_emitter(abs, _absolute)
register_symbol_emitter(int, symbols.truncate)
register_symbol_emitter(float, symbols.as_number)
register_symbol_emitter(bool, as_boolean)
register_symbol_emitter(math.sqrt, lambda x: symbols.call_intrinsic("sqrt", x))
register_symbol_emitter(math.copysign, lambda a, b: symbols.call_intrinsic("copysign", a, b))
register_symbol_emitter(math.floor, lambda x: symbols.truncate(symbols.floor_number(x)))
register_symbol_emitter(math.isfinite, lambda x: symbols.compare("<", symbols.call_intrinsic("fabs", x), math.inf))


register_emitter(portable.where)(select_values)
register_symbol_emitter(portable.fma, symbols.fma)
register_symbol_emitter(portable.copysign, lambda a, b: symbols.call_intrinsic("copysign", a, b))
register_symbol_emitter(portable.bits_of, symbols.bits_of)
register_symbol_emitter(portable.number_of, symbols.number_of)


def _refused(name: str, *operands: Any) -> Any:
    raise NotTraceableError(f"calls {name}, which has no portable implementation")


#: Functions of Python that are emitted from the bodies in `functions`: bits do not depend on the system's library.
PORTABLE = ("atan", "atan2", "cos", "cosh", "exp", "expm1", "log", "log1p", "log2", "sin", "sinh", "tanh")
for _name, _body in vars(functions).items():
    if isinstance(_body, FunctionType) and _body.__module__ == functions.__name__:
        mark_traceable(_body, SEPARATE if _name in (*PORTABLE, "pow") else INLINED)
for _name in PORTABLE:
    register_symbol_emitter(getattr(math, _name), functools.partial(call, getattr(functions, _name)))
register_symbol_emitter(pow, functools.partial(_refused, "pow"))


for _name, _function in vars(math).items():
    if callable(_function) and _function not in PRIMITIVES and not _name.startswith("_"):
        register_symbol_emitter(_function, functools.partial(_refused, f"math.{_name}"))
