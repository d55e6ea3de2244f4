"""How a kernel chooses where its numbers may stand in lanes, on which it cannot branch."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from ..trace import interpreter, symbols
from .family import OPTIONS
from .lanes import LanesType, MaskType


def where(condition, a, b):
    """Return `a` where the condition holds, else `b`: numbers that are both there."""
    return a if condition else b


def turns(count):
    """Return the numbers from 0 on, so many: of a loop that is compiled once, not written out turn by turn."""
    return range(count)


@overload(where, strict=False, jit_options=dict(OPTIONS, forceinline=True))
def _where(condition, a, b):
    if isinstance(condition, MaskType):
        return lambda condition, a, b: _blend(condition, a, b)  # noqa: PLW0108
    return where


def either(first, second):
    """Return a function that gives `first(*given)` where a condition holds, else `second(*given)`.

    It takes (condition, given).  The two, kernels, return the same numbers or tuples of them.  One of them runs where
    all lanes want that, else both.  `first` becomes code twice, so it should be the shorter.
    """

    def chosen(condition, given):
        return first(*given) if condition else second(*given)

    chosen.sides = first, second
    return chosen


@intrinsic
def _blend(typing_context, condition, a, b):
    """Emit `a` in the lanes in which the condition holds and `b` in the others."""
    result = LanesType(condition.width)

    def emit(context, builder, signature, values):
        sides = (context.cast(builder, x, kind, result) for x, kind in zip(values[1:], (a, b), strict=True))
        return builder.select(values[0], *sides)

    return result(condition, a, b), emit


def _bits_are(number):
    """Return an intrinsic that emits whether the answers in all lanes, as bits, are a number: 0 or -1."""

    @intrinsic
    def compared(typing_context, mask):
        def emit(context, builder, signature, values):
            bits = builder.bitcast(values[0], ir.IntType(mask.width))
            return builder.icmp_signed("==", bits, ir.Constant(bits.type, number))

        return types.boolean(mask), emit

    return compared


_all, _none = _bits_are(-1), _bits_are(0)


def everywhere(condition):
    """Return whether a condition holds in every lane."""
    return condition


def nowhere(condition):
    """Return whether a condition holds in no lane."""
    return not condition


@overload(everywhere, strict=False, jit_options=dict(OPTIONS, forceinline=True))
def _everywhere(condition):
    return (lambda condition: _all(condition)) if isinstance(condition, MaskType) else everywhere  # noqa: PLW0108


@overload(nowhere, strict=False, jit_options=dict(OPTIONS, forceinline=True))
def _nowhere(condition):
    return (lambda condition: _none(condition)) if isinstance(condition, MaskType) else nowhere  # noqa: PLW0108


@interpreter.primitive(where)
def _selected(condition, a, b):
    if not symbols.is_symbol(condition):
        return a if condition else b
    a, b = symbols.alike([a, b])
    pairs = zip(symbols.leaves(a), symbols.leaves(b), strict=True)
    return symbols.rebuilt(a, iter([symbols.selected(condition, x, y) for x, y in pairs]))


interpreter.primitive(everywhere)(interpreter.everywhere)
interpreter.primitive(nowhere)(interpreter.nowhere)
interpreter.LOOPS.append(turns)
