"""The functions of `math` for kernels that are to be differentiated.

The compiler knows what those of `math` do to a Dual; where nothing is compiled, Python has to be told.
"""

import math
import sys
from math import *  # noqa: F403

from numba import config

from . import dual
from .direction import direction
from .dual import FUNCTIONS, Dual, turned


def _either(function, rule):
    """Return `function` of `math` for numbers and `rule` for Duals."""
    return lambda *given: rule(*given) if any(isinstance(x, Dual) for x in given) else function(*given)


if config.DISABLE_JIT:
    globals().update({name: _either(getattr(math, name), rule) for name, rule in FUNCTIONS.items()})
    direction = _either(direction, turned)
    dual.math, dual.direction = sys.modules[__name__], direction  # Duals of Duals: what the rules call has rules
