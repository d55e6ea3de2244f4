"""How a kernel chooses where its numbers may stand in lanes, on which it cannot branch."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from .family import OPTIONS
from .lanes import LanesType, MaskType


def where(condition, a, b):
    """Return `a` where the condition holds, else `b`: numbers that are both there."""
    return a if condition else b


@overload(where, strict=False, jit_options=dict(OPTIONS, forceinline=True))
def _where(condition, a, b):
    if isinstance(condition, MaskType):
        return lambda condition, a, b: _blend(condition, a, b)  # noqa: PLW0108
    return where


def either(first, second):
    """Return a function that gives `first(*given)` where a condition holds, else `second(*given)`.

    It takes (condition, given).  The two, kernels, return the same numbers or tuples of them.  One of them runs where
    all lanes want that, else both.  `first` is compiled twice, so it should be the shorter.
    """

    def chosen(condition, given):
        return first(*given) if condition else second(*given)

    def one_of(condition, given):
        if everywhere(condition):
            one = first(*given)
            return _blend(condition, one, one)
        other = second(*given)
        return _blend(condition, other, other)

    def both(condition, given):
        if everywhere(condition):
            one = first(*given)
            return _blend(condition, one, one)
        other = second(*given)
        if nowhere(condition):
            return _blend(condition, other, other)
        return _blend(condition, first(*given), other)

    def select(condition, given):
        if isinstance(condition, MaskType):
            return one_of if condition.width == 1 else both
        return chosen

    overload(chosen, strict=False, jit_options=dict(OPTIONS, forceinline=True))(select)
    return chosen


def _blended(a, b, width):
    """Return the type of the blend of two, numbers or tuples of one form."""
    if isinstance(a, types.BaseTuple):
        return _with_items(a, [_blended(x, y, width) for x, y in zip(a.types, b.types, strict=True)])
    return LanesType(width)


def _with_items(kind, items):
    """Return a tuple's type with items of other types."""
    if isinstance(kind, types.BaseNamedTuple):
        return types.NamedTuple(items, kind.instance_class)
    return types.BaseTuple.from_types(items)


@intrinsic
def _blend(typing_context, condition, a, b):
    """Emit, number by number, `a` in the lanes in which the condition holds and `b` in the others."""
    result = _blended(a, b, condition.width)

    def emit(context, builder, signature, values):
        mask = values[0]

        def blended(kind, wanted, one, other):
            if isinstance(wanted, types.BaseTuple):
                items = [
                    blended((x, y), z, builder.extract_value(one, place), builder.extract_value(other, place))
                    for place, (x, y, z) in enumerate(zip(kind[0].types, kind[1].types, wanted.types, strict=True))
                ]
                return context.make_tuple(builder, wanted, items)
            return builder.select(
                mask, context.cast(builder, one, kind[0], wanted), context.cast(builder, other, kind[1], wanted)
            )

        return blended((a, b), result, *values[1:])

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
