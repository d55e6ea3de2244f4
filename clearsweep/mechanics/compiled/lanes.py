"""Several numbers side by side in one vector register, so that the same code works on several cases at once.

Where the compiler meets a number of type `LanesType`, every operation is done on each of its lanes.  A sum with a
product is fused, rounded once, wherever a kernel writes one in one expression; beyond that the compiler may change
nothing: whatever a kernel makes of a case is the same to the last bit in one lane, LanesType(1), and beside others.
Functions that the processor has for single numbers only are called lane by lane.  What a kernel may not do with lanes
is branch on them: it chooses by `where`, or by `either` between two functions.
"""

import builtins
import functools
import math
import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typeconv import Conversion
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_cast,
    models,
    overload,
    register_model,
    type_callable,
)

from ..trace import interpreter, symbols
from .family import OPTIONS

DOUBLE, WHOLE, BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
EXACT = ("afn",)  # allows nothing of a sum or product; those with no flag would be given the flags of ARITHMETIC


class _Several(types.Type):
    """The compiler's type of `width` values side by side."""

    item, single = DOUBLE, types.float64

    def __init__(self, width):
        self.width = width
        super().__init__(f"{type(self).__name__}({width})")

    def unify(self, typing_context, other):
        """Return the type that the two ends of a branch have together."""
        return self if isinstance(other, (types.Number, types.Boolean)) else None

    def can_convert_from(self, typing_context, other):
        """Return how a single value becomes one: it stands in every lane."""
        return Conversion.safe if isinstance(other, (types.Number, types.Boolean)) else None


class LanesType(_Several):
    """The compiler's type of numbers side by side."""


class WholesType(_Several):
    """The compiler's type of whole numbers side by side."""

    item, single = WHOLE, types.int64


class MaskType(_Several):
    """The compiler's type of answers, yes or no, side by side."""

    item, single = BIT, types.boolean


@register_model(LanesType)
@register_model(WholesType)
@register_model(MaskType)
class _SeveralModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, vector_of(kind))


def vector_of(kind):
    """Return what holds a value of a type of several: a vector; of one lane the value as it is, faster to compile."""
    return kind.item if kind.width == 1 else ir.VectorType(kind.item, kind.width)


def _lane(builder, several, kind, lane):
    """Emit the value in a lane."""
    return several if kind.width == 1 else builder.extract_element(several, WHOLE(lane))


def _joined(builder, singles, kind):
    """Emit what holds these values, one per lane."""
    if kind.width == 1:
        return singles[0]
    joined = ir.Constant(vector_of(kind), ir.Undefined)
    for lane, single in enumerate(singles):
        joined = builder.insert_element(joined, single, WHOLE(lane))
    return joined


def _spread(builder, single, kind):
    """Emit a vector that holds a single value in every lane."""
    if kind.width == 1:
        return single
    vector = vector_of(kind)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), single, WHOLE(0))
    return builder.shuffle_vector(
        one, ir.Constant(vector, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), kind.width), [0] * kind.width)
    )


@lower_cast(types.Number, LanesType)
@lower_cast(types.Number, WholesType)
@lower_cast(types.Boolean, MaskType)
def _single_to_several(context, builder, source, target, number):
    return _spread(builder, context.cast(builder, number, source, target.single), target)


def _kind_of(given, form):
    """Return the type that is a `form` among those given, None where there is none or where others are no numbers."""
    kinds = {kind for kind in given if isinstance(kind, form)}
    fits = all(isinstance(kind, (types.Number, types.Boolean)) for kind in given if not isinstance(kind, form))
    return kinds.pop() if len(kinds) == 1 and fits else None


def _teach(function, form, emit, returned=None, taken=2):
    """Let the compiler emit `emit(builder, *values)` for `function` of several values of a `form` each, or of one."""
    def typed(*given):
        kind = _kind_of(given, form)
        return kind and (returned(kind.width) if returned else kind)

    if taken == 1:
        type_callable(function)(lambda context: lambda a: typed(a))  # noqa: PLW0108
        patterns = [(form,)]
    else:
        type_callable(function)(lambda context: lambda a, b: typed(a, b))  # noqa: PLW0108
        single = types.Boolean if form is MaskType else types.Number
        patterns = [(form, form), (form, single), (single, form)]

    def lowered(context, builder, signature, values):
        kind = _kind_of(signature.args, form)
        return emit(
            context,
            builder,
            kind,
            *map(functools.partial(context.cast, builder), values, signature.args, [kind] * taken),
        )

    for pattern in patterns:
        lower_builtin(function, *pattern)(lowered)


def _plainly(name):
    return lambda context, builder, kind, *values: getattr(builder, name)(*values)


def _exactly(name):
    return lambda context, builder, kind, a, b: getattr(builder, name)(a, b, flags=EXACT)


def _compared(name, comparison):
    return lambda context, builder, kind, a, b: getattr(builder, name)(comparison, a, b)


def _intrinsic(name):
    def emit(context, builder, kind, *values):
        vector = vector_of(kind)
        signature = ir.FunctionType(vector, [vector] * len(values))
        form = "f64" if kind.width == 1 else f"v{kind.width}f64"
        function = cgutils.get_or_insert_function(builder.module, signature, f"llvm.{name}.{form}")
        return builder.call(function, values)

    return emit


def _fused(plain, minus=()):
    """Return what emits a sum whose one side is a product with a single rounding; `minus`: sides that are taken off."""

    def emit(context, builder, kind, a, b):
        sides = [a, b]
        for place in (0, 1):
            if getattr(sides[place], "opname", "") == "fmul" and tuple(sides[place].flags) == EXACT:  # of lanes
                factors, rest = list(sides[place].operands), sides[1 - place]
                if place in minus:
                    factors[0] = builder.fneg(factors[0])
                elif 1 - place in minus:
                    rest = builder.fneg(rest)
                return _intrinsic("fma")(context, builder, kind, *factors, rest)
        return getattr(builder, plain)(a, b, flags=EXACT)

    return emit


for _sums, _emit in (
    ((operator.add, operator.iadd), _fused("fadd")),
    ((operator.sub, operator.isub), _fused("fsub", minus=(1,))),
    ((operator.mul, operator.imul), _exactly("fmul")),
    ((operator.truediv, operator.itruediv), _exactly("fdiv")),
):
    for _function in _sums:
        _teach(_function, LanesType, _emit)
_teach(operator.neg, LanesType, _plainly("fneg"), taken=1)
_teach(abs, LanesType, _intrinsic("fabs"), taken=1)
_teach(math.sqrt, LanesType, _intrinsic("sqrt"), taken=1)
_teach(math.copysign, LanesType, _intrinsic("copysign"))
for _function, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _teach(_function, LanesType, _compared("fcmp_ordered", _sign), MaskType)
    _teach(_function, WholesType, _compared("icmp_signed", _sign), MaskType)
_teach(operator.ne, LanesType, _compared("fcmp_unordered", "!="), MaskType)
_teach(operator.ne, WholesType, _compared("icmp_signed", "!="), MaskType)
for _function, _name in ((operator.and_, "and_"), (operator.or_, "or_")):
    _teach(_function, MaskType, _plainly(_name))
    _teach(_function, WholesType, _plainly(_name))
for _function, _name in (
    (operator.rshift, "ashr"),
    (operator.lshift, "shl"),
    (operator.add, "add"),
    (operator.sub, "sub"),
):
    _teach(_function, WholesType, _plainly(_name))


def _extreme(comparison):
    """Return what takes the one of two numbers for which Python's `max` or `min` decides."""

    def emit(context, builder, kind, a, b):
        return builder.select(builder.fcmp_ordered(comparison, b, a), b, a)

    return emit


def _whole_extreme(comparison):
    """Return what takes the larger or the smaller of two whole numbers."""

    def emit(context, builder, kind, a, b):
        return builder.select(builder.icmp_signed(comparison, b, a), b, a)

    return emit


_teach(builtins.max, LanesType, _extreme(">"))
_teach(builtins.min, LanesType, _extreme("<"))
_teach(builtins.max, WholesType, _whole_extreme(">"))
_teach(builtins.min, WholesType, _whole_extreme("<"))


@intrinsic
def spread_like(typing_context, number, model):
    """Emit a number in every lane of a type of several."""

    def emit(context, builder, signature, values):
        return context.cast(builder, values[0], number, model)

    return model(number, model), emit


# ---------------------------------------------------------------------------------------------- tables


def bits_of(number):
    """Return the bits of a number as a whole number."""
    return np.float64(number).view(np.int64)


def number_of(bits):
    """Return the number that has these bits."""
    return np.int64(bits).view(np.float64)


def looked_up(table, place, column):
    """Return the number in row `place` of a column of a table (rows, columns)."""
    return table[place, column]


@intrinsic
def _bits(typing_context, number):
    """Emit the bits of every lane."""
    result = WholesType(number.width)

    def emit(context, builder, signature, values):
        return builder.bitcast(values[0], vector_of(result))

    return result(number), emit


@intrinsic
def _number(typing_context, bits):
    """Emit the number of every lane."""
    result = LanesType(bits.width)

    def emit(context, builder, signature, values):
        return builder.bitcast(values[0], vector_of(result))

    return result(bits), emit


@overload(bits_of, strict=False, jit_options=dict(OPTIONS, forceinline=True))
def _bits_of(number):
    return (lambda number: _bits(number)) if isinstance(number, LanesType) else bits_of  # noqa: PLW0108


@overload(number_of, strict=False, jit_options=dict(OPTIONS, forceinline=True))
def _number_of(bits):
    return (lambda bits: _number(bits)) if isinstance(bits, WholesType) else number_of  # noqa: PLW0108



interpreter._for_symbols(bits_of, symbols.bits_of)
interpreter._for_symbols(number_of, symbols.number_of)


@interpreter.primitive(looked_up)
def _gathered(table, place, column):
    return symbols.gathered(symbols.table_of(table), (place, column))
