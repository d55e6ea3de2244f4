"""The functions of `math` for kernels that are differentiated: for numbers with or without slopes."""

import functools
import math
import sys
from math import *  # noqa: F403

from ..calls import call
from ..protocols import register_emitter, register_slope_rule
from . import dual
from .choosing import direction as direction_of
from .dual import FUNCTIONS, Dual, direction_of_dual


def _differentiable(function, rule):
    """Return `function` for numbers and `rule` for Duals."""

    @functools.wraps(function)
    def differentiable(*arguments):
        return rule(*arguments) if any(isinstance(x, Dual) for x in arguments) else function(*arguments)

    register_emitter(differentiable)(lambda *arguments: call(function, *arguments))
    register_slope_rule(differentiable, rule)
    return differentiable


globals().update({name: _differentiable(getattr(math, name), rule) for name, rule in FUNCTIONS.items()})
direction = _differentiable(direction_of, direction_of_dual)
# Duals of Duals: functions in the rules have rules themselves
dual.math = sys.modules[__name__]
dual.direction = direction
