"""Dual numbers: values with a derivative, for exact automatic differentiation of forces and motions.

A `Dual` is a value and its slope along one direction of the state (Griewank & Walther 2008, "Evaluating Derivatives",
2nd ed., chapter 3).  Every rule is here once: the compiler applies it to its own type of such numbers, and Python
to the class.  A kernel that is differentiated calls the functions of `calculus` instead of `math`.

The value and the slope may be Duals themselves: for second derivatives both are seeded at the state, so that all
variable numbers are nested equally deep; a less nested number is constant along the outer direction.
"""

import builtins
import math
import operator

from ..protocols import Composite, Sloped, mark_traceable, register_slope_rule, register_slope_rules
from .choosing import direction


class Dual(Sloped):
    """A value and its slope."""

    __slots__ = ("slope", "value")

    def __init__(self, value, slope):
        self.value, self.slope = value, slope

    def traced_parts(self):
        """Return value and slope."""
        return self.value, self.slope

    def __bool__(self):
        return bool(self.value)


class Seeded(Composite):
    """A state whose component `direction` has slope 1 and the others 0; `[i]` returns Duals."""

    __slots__ = ("direction", "values")

    def __init__(self, values, direction):
        self.values, self.direction = values, direction

    def traced_parts(self):
        """Return the components."""
        return self.values, self.direction

    def __getitem__(self, i):
        return seeded_item(self, i)


def seeded_item(state, i):
    """Return component `i` of a Seeded state."""
    return Dual(state.values[i], 1.0 if i == state.direction else 0.0)


def value(x):
    """Return the value of a number, with a slope or without."""
    return x.value if isinstance(x, Dual) else x


def plain(x):
    """Return a number without slopes at any depth."""
    return plain(x.value) if isinstance(x, Dual) else x


def slope(x):
    """Return the slope of a number, or 0 without one."""
    return x.slope if isinstance(x, Dual) else 0.0


def as_type_of(x, model):
    """Return the number `x` with a slope if `model` has one: the branches of a function must return one type."""
    return x


def as_dual(x):
    """Return the number `x` as a Dual, with slope 0 by default."""
    return Dual(value(x), slope(x))


def chain_rule(number, rate, x):
    """Return `number`, a function of `x` with the derivative `rate` at `x`, with its slope by the chain rule."""
    return Dual(number, rate * x.slope) if isinstance(x, Dual) else number


def rate_or_slope(x):
    """Return the slope of a Dual, or a number without slope itself."""
    return x.slope if isinstance(x, Dual) else x


# ---------------------------------------------------------------------------------------------- rules


def _add(a, b):
    return Dual(value(a) + value(b), slope(a) + slope(b))


def _subtract(a, b):
    return Dual(value(a) - value(b), slope(a) - slope(b))


def _multiply(a, b):
    return Dual(value(a) * value(b), value(a) * slope(b) + slope(a) * value(b))


def _divide(a, b):
    ratio = value(a) / value(b)
    return Dual(ratio, (slope(a) - ratio * slope(b)) / value(b))


def _power(a, b):
    """Return a power with its slope; the exponent has no slope.

    At 0, where the derivative may be undefined, the derivative of powers above 1 is used.
    """
    power = value(a) ** b
    if value(a) == 0.0:
        return Dual(power, slope(a) if b == 1.0 else 0.0)
    return Dual(power, b * power / value(a) * slope(a))


def _absolute(a):
    return Dual(abs(a.value), math.copysign(1.0, a.value) * a.slope)


def _sqrt(a):
    root = math.sqrt(a.value)
    return Dual(root, 0.5 * a.slope / root if (root != 0.0) | (a.slope != 0.0) else 0.0)


def _tanh(a):
    result = math.tanh(a.value)
    return Dual(result, (1.0 - result * result) * a.slope)


def _exp(a):
    power = math.exp(a.value)
    return Dual(power, power * a.slope)


def _copysign(a, b):
    """Only the sign of `b` is used, so a slope of `b` does not matter."""
    result = math.copysign(value(a), value(b))
    return Dual(result, slope(a) if result == value(a) else -slope(a))


def direction_of_dual(a):
    """Return cosine and sine of an angle with a slope."""
    c, s = direction(a.value)
    return Dual(c, -s * a.slope), Dual(s, c * a.slope)


RULES = {  # Python's name of the operation -> (function, rule)
    "__add__": (operator.add, _add),
    "__sub__": (operator.sub, _subtract),
    "__mul__": (operator.mul, _multiply),
    "__truediv__": (operator.truediv, _divide),
    "__pow__": (operator.pow, _power),
    "__neg__": (operator.neg, lambda a: Dual(-a.value, -a.slope)),
    "__abs__": (abs, _absolute),
    "__lt__": (operator.lt, lambda a, b: value(a) < value(b)),
    "__le__": (operator.le, lambda a, b: value(a) <= value(b)),
    "__gt__": (operator.gt, lambda a, b: value(a) > value(b)),
    "__ge__": (operator.ge, lambda a, b: value(a) >= value(b)),
    "__eq__": (operator.eq, lambda a, b: value(a) == value(b)),
    "__ne__": (operator.ne, lambda a, b: value(a) != value(b)),
}
REFLECTED = {"__radd__": _add, "__rsub__": _subtract, "__rmul__": _multiply, "__rtruediv__": _divide}
FUNCTIONS = {
    "sqrt": _sqrt,
    "sin": lambda a: Dual(math.sin(a.value), math.cos(a.value) * a.slope),
    "cos": lambda a: Dual(math.cos(a.value), -math.sin(a.value) * a.slope),
    "tanh": _tanh,
    "exp": _exp,
    "expm1": lambda a: Dual(math.expm1(a.value), math.exp(a.value) * a.slope),
    "log": lambda a: Dual(math.log(a.value), a.slope / a.value),
    "log1p": lambda a: Dual(math.log1p(a.value), a.slope / (1.0 + a.value)),
    "atan": lambda a: Dual(math.atan(a.value), a.slope / (1.0 + a.value * a.value)),
    "copysign": _copysign,
}
for _name, (_, _rule) in RULES.items():
    setattr(Dual, _name, _rule)
for _name, _rule in REFLECTED.items():
    setattr(Dual, _name, lambda a, b, rule=_rule: rule(b, a))
Dual.__hash__ = None
Seeded.traced_item = staticmethod(seeded_item)
register_slope_rules({name: rule for name, (_, rule) in RULES.items()})
for _name, _rule in FUNCTIONS.items():
    register_slope_rule(getattr(math, _name), _rule)
for _function, _rule in (
    (direction, direction_of_dual),
    (builtins.max, lambda a, b: as_dual(b) if value(b) > value(a) else as_dual(a)),
    (builtins.min, lambda a, b: as_dual(b) if value(b) < value(a) else as_dual(a)),
    (abs, _absolute),
):
    register_slope_rule(_function, _rule)
for _function in (value, plain, slope, as_dual, chain_rule, rate_or_slope, as_type_of):
    mark_traceable(_function)


# ----------------------------------------------------------------------------------------------------------------------
# A state with time derivatives as slopes, so that derived quantities also have their rates.


class Moving(Composite):
    """A state of coordinates, their rates and time that moves with `accelerations`; `[i]` returns Duals.

    values : (2 n + 1 or more,) numbers, or Duals for second derivatives; accelerations : tuple of n numbers.
    """

    __slots__ = ("accelerations", "values")

    def __init__(self, values, accelerations):
        self.values, self.accelerations = values, accelerations

    def traced_parts(self):
        """Return the components."""
        return self.values, self.accelerations

    def __getitem__(self, i):
        return moving_item(self, i)


def moving_item(state, i):
    """Return component `i` of a Moving state."""
    n = len(state.accelerations)
    if i < n:
        return Dual(state.values[i], state.values[n + i])
    if i < 2 * n:
        return Dual(state.values[i], state.accelerations[i - n])
    return Dual(state.values[i], 1.0)  # time


Moving.traced_item = staticmethod(moving_item)
