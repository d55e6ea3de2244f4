"""Symbols: numbers, integers and truth values known at run time, and the memory that contains them.

A symbol represents one value or, in lanes, WIDTH values.  Operations on symbols are emitted into the current trace.
Nothing is left to the compiler's choice: every operation is rounded separately, except a sum with a product of the same
function, which is fused.
"""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from llvmlite import ir

#: Number of loop turns that run simultaneously: as many numbers as the widest registers contain.
WIDTH = 8
DOUBLE, WHOLE, BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
ADDRESS = ir.IntType(8).as_pointer()


class NotTraceableError(Exception):
    """A body that cannot be compiled."""


class Trace:
    """A module under construction, and the place where code is emitted."""

    def __init__(self, width: int = 1):
        self.width = width  # current width: WIDTH in turns that run simultaneously
        self.module = ir.Module("scene")
        self.builder: Any = None
        self.lanes: Callable[[], Any] = lambda: None  # returns the active lanes; None: all
        self.functions: dict[Any, Any] = {}  # machine code functions, by body and forms of arguments
        self.tables: dict[int, Any] = {}  # arrays that became constants, by identity
        self.kept_alive: list[Any] = []  # objects that live as long as the trace

    def block(self) -> Any:
        """Return a new block of the current function."""
        return self.builder.function.append_basic_block()


_IN_HAND: list[Trace] = []


def trace() -> Trace:
    """Return the current trace."""
    return _IN_HAND[-1]


@contextlib.contextmanager
def in_hand(results: Trace) -> Iterator[None]:
    """Make a trace the current one in this context."""
    _IN_HAND.append(results)
    try:
        yield
    finally:
        _IN_HAND.pop()


class Symbol:
    """A value known at run time; width : 1, or WIDTH in lanes."""

    __array_ufunc__ = None
    __hash__ = None  # type: ignore[assignment]
    __slots__ = ("product", "value", "width")
    item: Any = None

    def __init__(self, value: Any, width: int = 1, product: Any = None):
        self.value, self.width = value, width
        self.product = product  # place of the multiplication, if it is a product

    def __bool__(self) -> bool:
        raise NotTraceableError("decides on a number outside what is traced")

    def __add__(self, right_operand: Any) -> Any:
        return plus(self, right_operand)

    def __radd__(self, right_operand: Any) -> Any:
        return plus(right_operand, self)

    def __sub__(self, right_operand: Any) -> Any:
        return minus(self, right_operand)

    def __rsub__(self, right_operand: Any) -> Any:
        return minus(right_operand, self)

    def __mul__(self, right_operand: Any) -> Any:
        return times(self, right_operand)

    def __rmul__(self, right_operand: Any) -> Any:
        return times(right_operand, self)

    def __truediv__(self, right_operand: Any) -> Any:
        return over(self, right_operand)

    def __rtruediv__(self, right_operand: Any) -> Any:
        return over(right_operand, self)

    def __neg__(self) -> Any:
        return negative(self)


class Number(Symbol):
    """A float64."""

    __slots__ = ()
    item = DOUBLE


class Whole(Symbol):
    """An int64."""

    __slots__ = ()
    item = WHOLE


class Abreast(Whole):
    """Consecutive integers across lanes; `first` : in the first lane."""

    __slots__ = ("first",)

    def __init__(self, leading: Any):
        each = ir.Constant(form(WHOLE, WIDTH), list(range(WIDTH)))
        super().__init__(trace().builder.add(as_kind(leading, Whole, WIDTH), each), WIDTH)
        self.first = leading


class Truth(Symbol):
    """A truth value."""

    __slots__ = ()
    item = BIT


# ---------------------------------------------------------------------------------------------- forms


def form(item: Any, width: int) -> Any:
    """Return LLVM's type of a value or of a vector of them."""
    return item if width == 1 else ir.VectorType(item, width)


def constant(item: Any, number: Any, width: int = 1) -> Any:
    """Return a constant of LLVM."""
    if item is not BIT:
        number = float(number) if item is DOUBLE else int(number)
    return ir.Constant(item, number) if width == 1 else ir.Constant(form(item, width), [number] * width)


def is_symbol(x: Any) -> bool:
    """Return whether a value is known only at run time."""
    return isinstance(x, Symbol)


def width_of(*operands: Any) -> int:
    """Return the width of a result of these values."""
    return max((x.width for x in operands if isinstance(x, Symbol)), default=1)


def as_kind(x: Any, kind: type, width: int = 1) -> Any:
    """Emit a value as a Number, Whole or Truth of a width; return its LLVM value."""
    b = trace().builder
    if not isinstance(x, Symbol):
        if kind is Truth:
            x = bool(x)
        return constant(kind.item, x, width)  # type: ignore[attr-defined]
    value = x.value
    if kind is Number and not isinstance(x, Number):
        convert = b.uitofp if isinstance(x, Truth) else b.sitofp
        value = convert(value, form(DOUBLE, x.width))
    elif kind is Whole and not isinstance(x, Whole):
        if isinstance(x, Number):
            raise NotTraceableError("takes a number for a whole one")
        value = b.zext(value, form(WHOLE, x.width))
    elif kind is Truth and not isinstance(x, Truth):
        raise NotTraceableError("takes a number for an answer")
    if width > x.width:
        one_lane = b.insert_element(ir.Constant(form(kind.item, width), ir.Undefined), value, WHOLE(0))  # type: ignore[attr-defined]
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
        value = b.shuffle_vector(one_lane, ir.Constant(one_lane.type, ir.Undefined), zeros)
    return value


def number(x: Any, width: int = 1) -> Number:
    """Return a value as a Number."""
    width = max(width, width_of(x))
    return x if isinstance(x, Number) and x.width == width else Number(as_kind(x, Number, width), width)


def intrinsic(name: str, *operands: Any) -> Number:
    """Emit an LLVM intrinsic of numbers."""
    width = width_of(*operands)
    kind = form(DOUBLE, width)
    full_name = f"llvm.{name}.{'f64' if width == 1 else f'v{width}f64'}"
    module = trace().module
    function = module.globals.get(full_name) or ir.Function(
        module, ir.FunctionType(kind, [kind] * len(operands)), full_name
    )
    return Number(trace().builder.call(function, [as_kind(x, Number, width) for x in operands]), width)


# ---------------------------------------------------------------------------------------------- arithmetic


def _is_float(*operands: Any) -> bool:
    return any(isinstance(x, (Number, float)) for x in operands)


def _emitted(kind: type, name: str, a: Any, b: Any, product: Any = None) -> Any:
    width = width_of(a, b)
    emit = getattr(trace().builder, name)
    return kind(emit(as_kind(a, kind, width), as_kind(b, kind, width)), width, product)


def plus(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a + b; `where` : current place, see `fused`."""
    if _is_float(a, b):
        fused = _fused(a, b, where, ())
        return _emitted(Number, "fadd", a, b) if fused is None else fused
    for one_lane, right_operand in ((a, b), (b, a)):
        if isinstance(one_lane, Abreast) and width_of(right_operand) == 1:
            return Abreast(
                plus(one_lane.first, right_operand)
                if is_symbol(one_lane.first) or is_symbol(right_operand)
                else one_lane.first + right_operand
            )
    return _emitted(Whole, "add", a, b)


def minus(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a - b."""
    if _is_float(a, b):
        fused = _fused(a, b, where, (1,))
        return _emitted(Number, "fsub", a, b) if fused is None else fused
    if isinstance(a, Abreast) and width_of(b) == 1:
        return plus(a, negative(b) if is_symbol(b) else -b)
    return _emitted(Whole, "sub", a, b)


def _fused(a: Any, b: Any, where: Any, taken_off: tuple[int, ...]) -> Any:
    """Emit a sum with a single rounding if one side is a product from the same place; else return None."""
    if where is None:
        return None
    sides = [a, b]
    for position in (0, 1):
        side = sides[position]
        if isinstance(side, Number) and side.product == where:
            width, builder = width_of(a, b), trace().builder
            factors = [Number(factor, side.width) for factor in side.value.operands]
            remaining: Any = sides[1 - position]
            if position in taken_off:
                factors[0] = Number(builder.fneg(factors[0].value), side.width)
            elif 1 - position in taken_off:
                remaining = Number(builder.fneg(as_kind(remaining, Number, width)), width)
            return fma(factors[0], factors[1], remaining)
    return None


def fma(a: Any, b: Any, c: Any) -> Number:
    """Emit a b + c with a single rounding."""
    return intrinsic("fma", a, b, c)


def times(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a b."""
    if _is_float(a, b):
        return _emitted(Number, "fmul", a, b, where)
    return _emitted(Whole, "mul", a, b)


def over(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a / b."""
    return _emitted(Number, "fdiv", number(a), number(b))


def whole_over(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a // b of integers, b > 0."""
    if _is_float(a, b):
        return floor_number(over(a, b))
    builder, width = trace().builder, width_of(a, b)
    x, y = as_kind(a, Whole, width), as_kind(b, Whole, width)
    remaining = builder.srem(x, y)
    is_below = builder.icmp_signed("<", remaining, constant(WHOLE, 0, width))
    return Whole(builder.sub(builder.sdiv(x, y), builder.zext(is_below, form(WHOLE, width))), width)


def remainder(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a % b of integers, b > 0."""
    if _is_float(a, b):
        raise NotTraceableError("takes the remainder of numbers")
    builder, width = trace().builder, width_of(a, b)
    x, y = as_kind(a, Whole, width), as_kind(b, Whole, width)
    remaining = builder.srem(x, y)
    is_below = builder.icmp_signed("<", remaining, constant(WHOLE, 0, width))
    return Whole(builder.select(is_below, builder.add(remaining, y), remaining), width)


def negative(a: Any) -> Any:
    """Emit -a."""
    if isinstance(a, Number):
        return Number(trace().builder.fneg(a.value), a.width)
    return minus(0, a)


def bitwise(name: str) -> Any:
    """Return the emitter of a bitwise operation on integers or truth values."""

    def emit(a: Any, b: Any, where: Any = None) -> Any:
        truths = all(isinstance(x, (Truth, bool, np.bool_)) for x in (a, b))
        return _emitted(Truth if truths else Whole, name, a, b)

    return emit


both, one_of, without_common = bitwise("and_"), bitwise("or_"), bitwise("xor")
shifted_right, shifted_left = bitwise("ashr"), bitwise("shl")


def opposite(a: Any) -> Any:
    """Emit not a."""
    return without_common(a, True)


def compared(sign: str, a: Any, b: Any) -> Any:
    """Emit a comparison."""
    width, builder = width_of(a, b), trace().builder
    if _is_float(a, b):
        emit = builder.fcmp_unordered if sign == "!=" else builder.fcmp_ordered
        return Truth(emit(sign, as_kind(a, Number, width), as_kind(b, Number, width)), width)
    if all(isinstance(x, (Truth, bool, np.bool_)) for x in (a, b)):
        differs = without_common(a, b)
        return differs if sign == "!=" else opposite(differs)
    return Truth(builder.icmp_signed(sign, as_kind(a, Whole, width), as_kind(b, Whole, width)), width)


def kind_of(*operands: Any) -> type:
    """Return the common kind of several values: Number, Whole or Truth."""
    if all(isinstance(x, (Truth, bool, np.bool_)) for x in operands):
        return Truth
    return Number if _is_float(*operands) else Whole


def selected(condition: Truth, a: Any, b: Any) -> Any:
    """Emit `a` where the condition is true, else `b`."""
    kind, width = kind_of(a, b), width_of(condition, a, b)
    mask = as_kind(condition, Truth, width if condition.width > 1 else 1)
    return kind(trace().builder.select(mask, as_kind(a, kind, width), as_kind(b, kind, width)), width)


def extreme(sign: str) -> Any:
    """Return the emitter of Python's `max` or `min` of several numbers."""

    def emit(*operands: Any) -> Any:
        if len(operands) == 1:
            operands = tuple(operands[0])
        nearest_name = operands[0]
        for x in operands[1:]:
            if is_symbol(nearest_name) or is_symbol(x):
                nearest_name = selected(compared(sign, x, nearest_name), x, nearest_name)
            else:
                nearest_name = max(nearest_name, x) if sign == ">" else min(nearest_name, x)
        return nearest_name

    return emit


def as_whole(x: Any) -> Any:
    """Emit a number truncated to an integer; nan gives 0.

    So a trial step with invalid numbers still reads within a table.
    """
    if not isinstance(x, Number):
        return x
    kinds = form(WHOLE, x.width), form(DOUBLE, x.width)
    name = "llvm.fptosi.sat.i64.f64" if x.width == 1 else f"llvm.fptosi.sat.v{x.width}i64.v{x.width}f64"
    module = trace().module
    function = module.globals.get(name) or ir.Function(module, ir.FunctionType(kinds[0], [kinds[1]]), name)
    return Whole(trace().builder.call(function, [x.value]), x.width)


def floor_number(x: Any) -> Number:
    """Emit the largest integer not above x, as a Number."""
    return intrinsic("floor", x)


def bits_of(x: Number) -> Whole:
    """Emit the bits of a number."""
    return Whole(trace().builder.bitcast(x.value, form(WHOLE, x.width)), x.width)


def number_of(x: Whole) -> Number:
    """Emit the number with these bits."""
    return Number(trace().builder.bitcast(x.value, form(DOUBLE, x.width)), x.width)
