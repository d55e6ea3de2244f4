"""Symbols: numbers, integers and truth values known at run time, and the memory that contains them.

A symbol represents one value or, in lanes, WIDTH values.  Operations on symbols are emitted into the current trace.
Nothing is left to the compiler's choice: every operation is rounded separately, except a sum with a product of the same
function, which is fused.
"""

import contextlib
import functools
import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from llvmlite import ir

#: Number of loop iterations that run simultaneously: as many numbers as the widest registers contain.
WIDTH = 8
DOUBLE, INT64, BOOL = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
ADDRESS = ir.IntType(8).as_pointer()
DEEPEST_PLACE = 12  # calls that a message about an untraceable body names
INTEGERS = range(-(2**63), 2**63)  # of an int64


class NotTraceableError(Exception):
    """A body that cannot be compiled: why and, from the innermost call to the outermost, where."""

    def __init__(self, reason: str):
        super().__init__(reason)
        self.places: list[str] = []

    def add_place(self, place: str) -> None:
        """Add the place of a call, or, as the first, of the statement that cannot be compiled."""
        if len(self.places) < DEEPEST_PLACE:
            self.places.append(place)

    def __str__(self) -> str:
        return "\n  ".join(self.places) or super().__str__()


class Trace:
    """A module under construction, and the builder that emits its code."""

    def __init__(self, width: int = 1):
        self.width = width  # current width: WIDTH in iterations that run simultaneously
        self.are_indices_checked = False  # whether those known only at run time may count from the end, as in Python
        self.module = ir.Module("scene", context=ir.Context())
        self.builder: Any = None
        self.lanes: Callable[[], Any] = lambda: None  # returns the active lanes; None: all
        self.blocks: list[Any] = []  # of all functions
        self.functions: dict[Any, Any] = {}  # machine code functions, by body and forms of arguments
        self.intrinsics: dict[str, Any] = {}  # functions of LLVM, by name
        self.tables: dict[int, Any] = {}  # arrays that became constants, by identity
        self.sources: set[str] = set()  # files of the functions that were traced, or run while tracing
        self.chooses = False  # whether a function chose a body by type, which any module may register
        self.kept_alive: list[Any] = []  # objects that live as long as the trace

    def block(self) -> Any:
        """Return a new block of the current function."""
        self.blocks.append(self.builder.append_basic_block())
        return self.blocks[-1]

    def open_blocks(self, first: Any) -> list[Any]:
        """Return the blocks of the current function from a block on that do not end yet."""
        later = itertools.dropwhile(lambda block: block is not first, self.blocks)
        return [x for x in later if x.function is self.builder.function and not x.is_terminated]

    def intrinsic(self, name: str, result: Any, operands: list[Any]) -> Any:
        """Return a function of LLVM."""
        if name not in self.intrinsics:
            self.intrinsics[name] = ir.Function(self.module, ir.FunctionType(result, operands), name)
        return self.intrinsics[name]


_TRACES: list[Trace] = []


def trace() -> Trace:
    """Return the current trace."""
    return _TRACES[-1]


@contextlib.contextmanager
def current_trace(new_trace: Trace) -> Iterator[None]:
    """Make a trace the current one in this context."""
    _TRACES.append(new_trace)
    try:
        yield
    finally:
        _TRACES.pop()


class Symbol:
    """A value known at run time; width : 1, or WIDTH in lanes."""

    __array_ufunc__ = None
    __hash__ = None  # type: ignore[assignment]
    __slots__ = ("product", "value", "width")
    item: Any = None

    def __init__(self, value: Any, width: int = 1, product: Any = None):
        self.value, self.width = value, width
        self.product = product  # (origin, factors) if it is a product, see `_fuse`

    def __bool__(self) -> bool:
        raise NotTraceableError("decides on a number known only at run time in code that is not traced")


class Number(Symbol):
    """A float64."""

    __slots__ = ()
    item = DOUBLE


class Integer(Symbol):
    """An int64."""

    __slots__ = ()
    item = INT64


class LaneIndices(Integer):
    """Consecutive integers across lanes; `first` : in the first lane."""

    __slots__ = ("first",)

    def __init__(self, first: Any):
        lane_numbers = ir.Constant(llvm_type(INT64, WIDTH), list(range(WIDTH)))
        super().__init__(trace().builder.add(as_kind(first, Integer, WIDTH), lane_numbers), WIDTH)
        self.first = first


class Boolean(Symbol):
    """A Boolean."""

    __slots__ = ()
    item = BOOL


# ---------------------------------------------------------------------------------------------- forms


def llvm_type(item: Any, width: int) -> Any:
    """Return LLVM's type of a value or of a vector of them."""
    return item if width == 1 else ir.VectorType(item, width)


_CONSTANTS: dict[Any, Any] = {}  # of LLVM, which belong to no module: a scene has some 20,000, most of them alike


def llvm_constant(item: Any, number: Any, width: int = 1) -> Any:
    """Return a constant of LLVM."""
    if item is not BOOL:
        number = float(number) if item is DOUBLE else int(number)
    key = item, repr(number), width
    if key not in _CONSTANTS:
        _CONSTANTS[key] = ir.Constant(llvm_type(item, width), number if width == 1 else [number] * width)
    return _CONSTANTS[key]


@functools.cache
def undefined(item: Any, width: int) -> Any:
    """Return an undefined value, or a vector of them."""
    return ir.Constant(llvm_type(item, width), ir.Undefined)


def is_symbol(x: Any) -> bool:
    """Return whether a value is known only at run time."""
    return isinstance(x, Symbol)


def width_of(*operands: Any) -> int:
    """Return the width of a result of these values."""
    width = 1
    for x in operands:
        if isinstance(x, Symbol) and x.width > width:
            width = x.width
    return width


def as_kind(x: Any, kind: type, width: int = 1) -> Any:
    """Emit a value as a Number, Integer or Boolean of a width; return its LLVM value."""
    b = trace().builder
    if not isinstance(x, Symbol):
        return llvm_constant(kind.item, _checked_constant(x, kind), width)  # type: ignore[attr-defined]
    value = x.value
    if kind is Number and not isinstance(x, Number):
        convert = b.uitofp if isinstance(x, Boolean) else b.sitofp
        value = convert(value, llvm_type(DOUBLE, x.width))
    elif kind is Integer and not isinstance(x, Integer):
        if isinstance(x, Number):
            raise NotTraceableError("uses a float as an integer")
        value = b.zext(value, llvm_type(INT64, x.width))
    elif kind is Boolean and not isinstance(x, Boolean):
        raise NotTraceableError("uses a float as a condition")
    if width > x.width:
        empty = undefined(kind.item, width)  # type: ignore[attr-defined]
        vector = b.insert_element(empty, value, llvm_constant(INT64, 0))
        value = b.shuffle_vector(vector, empty, llvm_constant(ir.IntType(32), 0, width))
    return value


def _checked_constant(x: Any, kind: type) -> Any:
    """Return a known number for use as a Number, Integer or Boolean."""
    if not isinstance(x, (bool, int, float, np.bool_, np.int64)):
        raise NotTraceableError(f"uses a value of type {type(x).__name__} as a number")
    if kind is Boolean:
        return bool(x)
    if kind is Integer and isinstance(x, float):
        raise NotTraceableError("uses a float as an integer")
    if kind is Integer and int(x) not in INTEGERS:
        raise NotTraceableError(f"uses the integer {x}, which 64 bits do not hold")
    return x


def as_number(x: Any, width: int = 1) -> Number:
    """Return a value as a Number."""
    width = max(width, width_of(x))
    return x if isinstance(x, Number) and x.width == width else Number(as_kind(x, Number, width), width)


def call_intrinsic(name: str, *operands: Any) -> Number:
    """Emit an LLVM intrinsic of numbers."""
    width = width_of(*operands)
    kind = llvm_type(DOUBLE, width)
    full_name = f"llvm.{name}.{'f64' if width == 1 else f'v{width}f64'}"
    function = trace().intrinsic(full_name, kind, [kind] * len(operands))
    return Number(trace().builder.call(function, [as_kind(x, Number, width) for x in operands]), width)


# ---------------------------------------------------------------------------------------------- arithmetic


def _is_float(*operands: Any) -> bool:
    return any(isinstance(x, (Number, float)) for x in operands)


def _emit(kind: type, instruction: str, a: Any, b: Any) -> Any:
    width = width_of(a, b)
    emit = getattr(trace().builder, instruction)
    return kind(emit(as_kind(a, kind, width), as_kind(b, kind, width)), width)


def plus(a: Any, b: Any, origin: Any = None) -> Any:
    """Emit a + b; `origin` : (activation, block) of the operation, see `_fuse`."""
    if _is_float(a, b):
        fused = _fuse(a, b, origin, ())
        return _emit(Number, "fadd", a, b) if fused is None else fused
    for indices, offset in ((a, b), (b, a)):
        if isinstance(indices, LaneIndices) and width_of(offset) == 1:
            return LaneIndices(
                plus(indices.first, offset) if is_symbol(indices.first) or is_symbol(offset) else indices.first + offset
            )
    return _emit(Integer, "add", a, b)


def minus(a: Any, b: Any, origin: Any = None) -> Any:
    """Emit a - b."""
    if _is_float(a, b):
        fused = _fuse(a, b, origin, (1,))
        return _emit(Number, "fsub", a, b) if fused is None else fused
    if isinstance(a, LaneIndices) and width_of(b) == 1:
        return plus(a, negate(b) if is_symbol(b) else -b)
    return _emit(Integer, "sub", a, b)


def _fuse(a: Any, b: Any, origin: Any, negated: tuple[int, ...]) -> Any:
    """Emit a sum with a single rounding if one side is a product of the same origin; else return None."""
    if origin is None:
        return None
    operands = [a, b]
    for index in (0, 1):
        operand = operands[index]
        if isinstance(operand, Number) and operand.product and operand.product[0] == origin:
            width, builder = width_of(a, b), trace().builder
            factors = [Number(factor, operand.width) for factor in operand.product[1]]
            addend: Any = operands[1 - index]
            if index in negated:
                factors[0] = Number(builder.fneg(factors[0].value), operand.width)
            elif 1 - index in negated:
                addend = Number(builder.fneg(as_kind(addend, Number, width)), width)
            return fma(factors[0], factors[1], addend)
    return None


def fma(a: Any, b: Any, c: Any) -> Number:
    """Emit a b + c with a single rounding."""
    return call_intrinsic("fma", a, b, c)


def times(a: Any, b: Any, origin: Any = None) -> Any:
    """Emit a b."""
    if not _is_float(a, b):
        return _emit(Integer, "mul", a, b)
    width = width_of(a, b)
    factors = as_kind(a, Number, width), as_kind(b, Number, width)
    return Number(trace().builder.fmul(*factors), width, origin and (origin, factors))


def divide(a: Any, b: Any, origin: Any = None) -> Any:
    """Emit a / b."""
    return _emit(Number, "fdiv", as_number(a), as_number(b))


def _divide_integers(a: Any, b: Any) -> tuple[Any, Any, Any, Any]:
    """Emit a / b of integers, truncated; return quotient, remainder, divisor and whether Python's quotient is lower.

    Where Python raises, or the quotient overflows, 1 divides instead: the processor would end the process.
    """
    if _is_float(a, b):
        raise NotTraceableError("divides floats with // or %: write math.floor(a / b), or a - b * math.floor(a / b)")
    builder, width = trace().builder, width_of(a, b)
    if is_symbol(b):
        is_overflow = bit_and(compare("==", b, -1), compare("==", a, INTEGERS[0]))
        b = select(bit_or(compare("==", b, 0), is_overflow), 1, b)
    elif b == 0:
        raise NotTraceableError("divides by zero")
    x, y = as_kind(a, Integer, width), as_kind(b, Integer, width)
    remainder_value, zero = builder.srem(x, y), llvm_constant(INT64, 0, width)
    if is_symbol(b) or b < 0:
        has_other_sign = builder.icmp_signed("<", builder.xor(remainder_value, y), zero)
        is_lower = builder.and_(has_other_sign, builder.icmp_signed("!=", remainder_value, zero))
    else:
        is_lower = builder.icmp_signed("<", remainder_value, zero)
    return builder.sdiv(x, y), remainder_value, y, is_lower


def floor_divide(a: Any, b: Any, origin: Any = None) -> Any:
    """Emit a // b of integers."""
    quotient, _, _, is_lower = _divide_integers(a, b)
    width = width_of(a, b)
    return Integer(trace().builder.sub(quotient, trace().builder.zext(is_lower, llvm_type(INT64, width))), width)


def remainder(a: Any, b: Any, origin: Any = None) -> Any:
    """Emit a % b of integers."""
    _, remainder_value, divisor, is_lower = _divide_integers(a, b)
    builder = trace().builder
    return Integer(builder.select(is_lower, builder.add(remainder_value, divisor), remainder_value), width_of(a, b))


def negate(a: Any) -> Any:
    """Emit -a."""
    if isinstance(a, Number):
        return Number(trace().builder.fneg(a.value), a.width)
    return minus(0, a)


def bitwise_emitter(name: str) -> Any:
    """Return the emitter of a bitwise operation on integers or truth values."""

    def emit(a: Any, b: Any, origin: Any = None) -> Any:
        are_booleans = all(isinstance(x, (Boolean, bool, np.bool_)) for x in (a, b))
        return _emit(Boolean if are_booleans else Integer, name, a, b)

    return emit


bit_and, bit_or, bit_xor = bitwise_emitter("and_"), bitwise_emitter("or_"), bitwise_emitter("xor")


def _shift_emitter(name: str) -> Any:
    """Return the emitter of a shift of an integer; one by more than 63 bits shifts all of them out."""

    def emit(a: Any, count: Any, origin: Any = None) -> Any:
        if not is_symbol(count):
            if not 0 <= count < 64:
                raise NotTraceableError("shifts by other than 0 to 63 bits")
            return _emit(Integer, name, a, count)
        bits, width = as_kind(count, Integer, count.width), count.width
        is_large = Boolean(trace().builder.icmp_unsigned(">", bits, llvm_constant(INT64, 63, width)), width)
        shifted = _emit(Integer, name, a, select(is_large, 63, count))
        return shifted if name == "ashr" else select(is_large, 0, shifted)

    return emit


shift_right, shift_left = _shift_emitter("ashr"), _shift_emitter("shl")


def logical_not(a: Any) -> Any:
    """Emit not a."""
    return bit_xor(a, True)


def as_boolean(x: Any) -> Any:
    """Return the truth value of a symbol; known values unchanged."""
    return compare("!=", x, 0) if isinstance(x, (Number, Integer)) else x


def compare(sign: str, a: Any, b: Any) -> Any:
    """Emit a comparison."""
    width, builder = width_of(a, b), trace().builder
    if _is_float(a, b):
        emit = builder.fcmp_unordered if sign == "!=" else builder.fcmp_ordered
        return Boolean(emit(sign, as_kind(a, Number, width), as_kind(b, Number, width)), width)
    if sign in ("==", "!=") and all(isinstance(x, (Boolean, bool, np.bool_)) for x in (a, b)):
        differs = bit_xor(a, b)
        return differs if sign == "!=" else logical_not(differs)
    return Boolean(builder.icmp_signed(sign, as_kind(a, Integer, width), as_kind(b, Integer, width)), width)


def kind_of(*operands: Any) -> type:
    """Return the common kind of several values: Number, Integer or Boolean."""
    if all(isinstance(x, (Boolean, bool, np.bool_)) for x in operands):
        return Boolean
    return Number if _is_float(*operands) else Integer


def select(condition: Boolean, a: Any, b: Any) -> Any:
    """Emit `a` where the condition is true, else `b`."""
    kind, width = kind_of(a, b), width_of(condition, a, b)
    mask = as_kind(condition, Boolean, width if condition.width > 1 else 1)
    return kind(trace().builder.select(mask, as_kind(a, kind, width), as_kind(b, kind, width)), width)


def extremum_emitter(sign: str) -> Any:
    """Return the emitter of Python's `max` or `min` of several numbers."""

    def emit(*operands: Any) -> Any:
        if len(operands) == 1:
            operands = tuple(operands[0])
        best = operands[0]
        for x in operands[1:]:
            if is_symbol(best) or is_symbol(x):
                best = select(compare(sign, x, best), x, best)
            else:
                best = max(best, x) if sign == ">" else min(best, x)
        return best

    return emit


def truncate(x: Any) -> Any:
    """Emit a number truncated to an integer; nan gives 0.

    So a trial step with invalid numbers still reads within a table.
    """
    if not isinstance(x, Number):
        return x
    if x.width == 1:
        function = trace().intrinsic("llvm.fptosi.sat.i64.f64", INT64, [DOUBLE])
        return Integer(trace().builder.call(function, [x.value]))
    # In lanes, LLVM would convert one lane after the other.
    low, high = float(INTEGERS.start), float(INTEGERS.stop)
    is_within = bit_and(compare(">=", x, low), compare("<", x, high))
    within = trace().builder.fptosi(select(is_within, x, 0.0).value, llvm_type(INT64, x.width))
    not_above = select(compare("<", x, low), INTEGERS[0], Integer(within, x.width))
    return select(compare(">=", x, high), INTEGERS[-1], not_above)


def bits_of(x: Number) -> Integer:
    """Emit the bits of a number."""
    return Integer(trace().builder.bitcast(x.value, llvm_type(INT64, x.width)), x.width)


def number_of(x: Integer) -> Number:
    """Emit the number with these bits."""
    return Number(trace().builder.bitcast(x.value, llvm_type(DOUBLE, x.width)), x.width)


def _set_operators() -> None:
    """Give symbols the operators of Python, with a symbol on either side."""
    for name, emit in (("add", plus), ("sub", minus), ("mul", times), ("truediv", divide)):
        setattr(Symbol, f"__{name}__", lambda a, b, emit=emit: emit(a, b))
        setattr(Symbol, f"__r{name}__", lambda a, b, emit=emit: emit(b, a))
    Symbol.__neg__ = negate  # type: ignore[attr-defined]
    Symbol.__eq__ = lambda a, b: compare("==", a, b)  # type: ignore[method-assign]
    Symbol.__ne__ = lambda a, b: compare("!=", a, b)  # type: ignore[method-assign]


_set_operators()
