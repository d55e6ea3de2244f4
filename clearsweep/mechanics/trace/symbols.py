"""Symbols: numbers, whole numbers and answers that are known when the program runs, and memory that holds them.

A symbol stands for one value or, in lanes, for WIDTH values side by side.  Whatever is done to symbols is emitted into
the trace in hand.  Nothing is left to the compiler's choice: every operation is rounded by itself, but for a sum with a
product of the same function, which is fused.
"""

import contextlib
import functools
import math
import types
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir

#: How many cases lie side by side in memory, see `rows.Board`: as many numbers as the widest registers hold.
WIDTH = 8
DOUBLE, WHOLE, BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
ADDRESS = ir.IntType(8).as_pointer()


class NotTraceable(Exception):
    """What a body does cannot be written down."""


class Trace:
    """A module in the making, and where in it code is emitted."""

    def __init__(self, width: int):
        self.width = width  # of the numbers of scenes
        self.module = ir.Module("scene")
        self.builder: Any = None
        self.lanes: Callable[[], Any] = lambda: None  # returns in which lanes something is to be done; None: in all
        self.functions: dict[Any, Any] = {}  # those of machine code, by body and forms of what they are given
        self.tables: dict[int, Any] = {}  # arrays that became constants, by their identity
        self.held: list[Any] = []  # they live as long as the trace does

    def block(self) -> Any:
        """Return a new block of the function in hand."""
        return self.builder.function.append_basic_block()


_IN_HAND: list[Trace] = []


def trace() -> Trace:
    """Return the trace in hand."""
    return _IN_HAND[-1]


@contextlib.contextmanager
def in_hand(made: Trace) -> Iterator[None]:
    """Let a trace be the one in hand."""
    _IN_HAND.append(made)
    try:
        yield
    finally:
        _IN_HAND.pop()


class Symbol:
    """A value that is known when the program runs; width : 1, or WIDTH where it stands in lanes."""

    __array_ufunc__ = None
    __hash__ = None  # type: ignore[assignment]
    __slots__ = ("product", "value", "width")
    item: Any = None

    def __init__(self, value: Any, width: int = 1, product: Any = None):
        self.value, self.width = value, width
        self.product = product  # where it was multiplied, if it is a product

    def __bool__(self) -> bool:
        raise NotTraceable("decides on a number outside what is traced")

    def __add__(self, other: Any) -> Any:
        return plus(self, other)

    def __radd__(self, other: Any) -> Any:
        return plus(other, self)

    def __sub__(self, other: Any) -> Any:
        return minus(self, other)

    def __rsub__(self, other: Any) -> Any:
        return minus(other, self)

    def __mul__(self, other: Any) -> Any:
        return times(self, other)

    def __rmul__(self, other: Any) -> Any:
        return times(other, self)

    def __truediv__(self, other: Any) -> Any:
        return over(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return over(other, self)

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


class Truth(Symbol):
    """An answer, yes or no."""

    __slots__ = ()
    item = BIT


# ---------------------------------------------------------------------------------------------- forms


def form(item: Any, width: int) -> Any:
    """Return LLVM's type of a value or of so many side by side."""
    return item if width == 1 else ir.VectorType(item, width)


def constant(item: Any, number: Any, width: int = 1) -> Any:
    """Return a constant of LLVM."""
    if item is not BIT:
        number = float(number) if item is DOUBLE else int(number)
    return ir.Constant(item, number) if width == 1 else ir.Constant(form(item, width), [number] * width)


def is_symbol(x: Any) -> bool:
    """Return whether a value is known only when the program runs."""
    return isinstance(x, Symbol)


def width_of(*given: Any) -> int:
    """Return the width of what is made of these values."""
    return max((x.width for x in given if isinstance(x, Symbol)), default=1)


def as_kind(x: Any, kind: type, width: int = 1) -> Any:
    """Emit a value as a Number, Whole or Truth of a width; return what LLVM calls it."""
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
            raise NotTraceable("takes a number for a whole one")
        value = b.zext(value, form(WHOLE, x.width))
    elif kind is Truth and not isinstance(x, Truth):
        raise NotTraceable("takes a number for an answer")
    if width > x.width:
        one = b.insert_element(ir.Constant(form(kind.item, width), ir.Undefined), value, WHOLE(0))  # type: ignore[attr-defined]
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
        value = b.shuffle_vector(one, ir.Constant(one.type, ir.Undefined), zeros)
    return value


def number(x: Any, width: int = 1) -> Number:
    """Return a value as a Number."""
    width = max(width, width_of(x))
    return x if isinstance(x, Number) and x.width == width else Number(as_kind(x, Number, width), width)


def intrinsic(name: str, *given: Any) -> Number:
    """Emit a function of LLVM's own of numbers."""
    width = width_of(*given)
    kind = form(DOUBLE, width)
    full = f"llvm.{name}.{'f64' if width == 1 else f'v{width}f64'}"
    module = trace().module
    function = module.globals.get(full) or ir.Function(module, ir.FunctionType(kind, [kind] * len(given)), full)
    return Number(trace().builder.call(function, [as_kind(x, Number, width) for x in given]), width)


# ---------------------------------------------------------------------------------------------- arithmetic


def _is_float(*given: Any) -> bool:
    return any(isinstance(x, (Number, float)) for x in given)


def _emitted(kind: type, name: str, a: Any, b: Any, product: Any = None) -> Any:
    width = width_of(a, b)
    emit = getattr(trace().builder, name)
    return kind(emit(as_kind(a, kind, width), as_kind(b, kind, width)), width, product)


def plus(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a + b; `where` : the place in hand, see `fused`."""
    if _is_float(a, b):
        fused = _fused(a, b, where, ())
        return _emitted(Number, "fadd", a, b) if fused is None else fused
    return _emitted(Whole, "add", a, b)


def minus(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a - b."""
    if _is_float(a, b):
        fused = _fused(a, b, where, (1,))
        return _emitted(Number, "fsub", a, b) if fused is None else fused
    return _emitted(Whole, "sub", a, b)


def _fused(a: Any, b: Any, where: Any, taken_off: tuple[int, ...]) -> Any:
    """Emit a sum with a single rounding where one side is a product that was made at the same place; else None."""
    if where is None:
        return None
    sides = [a, b]
    for place in (0, 1):
        side = sides[place]
        if isinstance(side, Number) and side.product == where:
            width, builder = width_of(a, b), trace().builder
            factors = [Number(factor, side.width) for factor in side.value.operands]
            rest: Any = sides[1 - place]
            if place in taken_off:
                factors[0] = Number(builder.fneg(factors[0].value), side.width)
            elif 1 - place in taken_off:
                rest = Number(builder.fneg(as_kind(rest, Number, width)), width)
            return fma(factors[0], factors[1], rest)
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
    """Emit a // b of whole numbers, b > 0."""
    if _is_float(a, b):
        return floor_number(over(a, b))
    builder, width = trace().builder, width_of(a, b)
    x, y = as_kind(a, Whole, width), as_kind(b, Whole, width)
    rest = builder.srem(x, y)
    below = builder.icmp_signed("<", rest, constant(WHOLE, 0, width))
    return Whole(builder.sub(builder.sdiv(x, y), builder.zext(below, form(WHOLE, width))), width)


def remainder(a: Any, b: Any, where: Any = None) -> Any:
    """Emit a % b of whole numbers, b > 0."""
    if _is_float(a, b):
        raise NotTraceable("takes the remainder of numbers")
    builder, width = trace().builder, width_of(a, b)
    x, y = as_kind(a, Whole, width), as_kind(b, Whole, width)
    rest = builder.srem(x, y)
    below = builder.icmp_signed("<", rest, constant(WHOLE, 0, width))
    return Whole(builder.select(below, builder.add(rest, y), rest), width)


def negative(a: Any) -> Any:
    """Emit -a."""
    if isinstance(a, Number):
        return Number(trace().builder.fneg(a.value), a.width)
    return minus(0, a)


def bitwise(name: str) -> Any:
    """Return what emits an operation on the bits of whole numbers or answers."""

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


def kind_of(*given: Any) -> type:
    """Return what several values can be together: Number, Whole or Truth."""
    if all(isinstance(x, (Truth, bool, np.bool_)) for x in given):
        return Truth
    return Number if _is_float(*given) else Whole


def selected(condition: Truth, a: Any, b: Any) -> Any:
    """Emit `a` where the condition holds, else `b`."""
    kind, width = kind_of(a, b), width_of(condition, a, b)
    mask = as_kind(condition, Truth, width if condition.width > 1 else 1)
    return kind(trace().builder.select(mask, as_kind(a, kind, width), as_kind(b, kind, width)), width)


def extreme(sign: str) -> Any:
    """Return what emits the one of several numbers for which Python's `max` or `min` decides."""

    def emit(*given: Any) -> Any:
        if len(given) == 1:
            given = tuple(given[0])
        best = given[0]
        for x in given[1:]:
            if is_symbol(best) or is_symbol(x):
                best = selected(compared(sign, x, best), x, best)
            else:
                best = max(best, x) if sign == ">" else min(best, x)
        return best

    return emit


def as_whole(x: Any) -> Any:
    """Emit a number without its digits behind the point as a whole number."""
    if not isinstance(x, Number):
        return x
    return Whole(trace().builder.fptosi(x.value, form(WHOLE, x.width)), x.width)


def floor_number(x: Any) -> Number:
    """Emit the largest whole number not above x, as a Number."""
    return intrinsic("floor", x)


def bits_of(x: Number) -> Whole:
    """Emit the bits of a number."""
    return Whole(trace().builder.bitcast(x.value, form(WHOLE, x.width)), x.width)


def number_of(x: Whole) -> Number:
    """Emit the number that has these bits."""
    return Number(trace().builder.bitcast(x.value, form(DOUBLE, x.width)), x.width)


# ---------------------------------------------------------------------------------------------- memory


class Bare:
    """A pointer of which nothing but the kind of its items is known."""

    def __init__(self, base: Any, item: Any):
        self.base, self.item = base, item

    @classmethod
    def at(cls, address: "Whole", kind: str) -> "Bare":
        """Return the pointer to an address, 'f' to float64, 'i' to int64."""
        return cls(trace().builder.inttoptr(address.value, ADDRESS), DOUBLE if kind == "f" else WHOLE)


def word_at(address: "Whole", place: int, kind: type) -> Any:
    """Emit a word of what lies at an address and stays as it is while the program runs."""
    builder = trace().builder
    first = builder.inttoptr(address.value, kind.item.as_pointer())  # type: ignore[attr-defined]
    loaded = builder.load(builder.gep(first, [WHOLE(place)]), align=8)
    loaded.set_metadata("invariant.load", trace().module.add_metadata([]))
    return kind(loaded)


def call_at(code: Any, parameters: Any, arrays: tuple, integer: Any) -> None:
    """Emit the call of the machine code at an address with that of parameters, those of arrays, and an integer."""
    builder = trace().builder
    given = [builder.inttoptr(as_kind(parameters, Whole), ADDRESS)]
    given += [builder.bitcast(array.address(), ADDRESS) for array in arrays]
    kind = ir.FunctionType(ir.VoidType(), [ADDRESS] * len(given) + [WHOLE])
    builder.call(builder.inttoptr(as_kind(code, Whole), kind.as_pointer()), [*given, as_kind(integer, Whole)])


class View:
    """An array in memory, or a part of one: the values lie `strides` (in numbers of eight bytes) apart.

    width : how many values lie side by side at each place, WIDTH apart from those of the next place.
    """

    __slots__ = ("base", "item", "offset", "shape", "strides", "width")

    def __init__(self, base: Any, item: Any, shape: tuple, strides: tuple[int, ...], width: int = 1, offset: Any = 0):
        self.base, self.item, self.shape, self.strides = base, item, shape, strides
        self.width, self.offset = width, offset

    @property
    def size(self) -> Any:
        """Return the number of values."""
        return _product(self.shape)

    def reshape(self, *shape: int) -> "View":
        """Return the same values, which lie without gaps, as an array of another shape."""
        steps = [self.strides[-1]]
        for count in reversed(shape[1:]):
            steps.append(steps[-1] * count)
        return View(self.base, self.item, shape, tuple(reversed(steps)), self.width, self.offset)

    def _part(self, index: Any) -> "View":
        given = index if isinstance(index, tuple) else (index,)
        offset, shape, strides = self.offset, [], []
        for axis, place in enumerate(given):
            if isinstance(place, slice):
                first = 0 if place.start is None else place.start
                last = self.shape[axis] if place.stop is None else place.stop
                offset = _moved(offset, first, self.strides[axis])
                shape.append(last - first if not (is_symbol(last) or is_symbol(first)) else minus(last, first))
                strides.append(self.strides[axis])
                continue
            if not is_symbol(place):
                place = int(place)
                if place < 0:
                    place = self.shape[axis] + place
            offset = _moved(offset, place, self.strides[axis])
        count = len(given)
        return View(
            self.base,
            self.item,
            (*shape, *self.shape[count:]),
            (*strides, *self.strides[count:]),
            self.width,
            offset,
        )

    def address(self) -> Any:
        """Emit the address of its first value."""
        builder = trace().builder
        first = builder.bitcast(self.base, self.item.as_pointer())
        place = self.offset.value if is_symbol(self.offset) else WHOLE(self.offset)
        at = builder.gep(first, [place])
        return at if self.width == 1 else builder.bitcast(at, form(self.item, self.width).as_pointer())

    def __getitem__(self, index: Any) -> Any:
        part = self._part(index)
        if part.shape:
            return part
        if is_symbol(part.offset) and part.offset.width > 1:
            return part._each_lane()
        value = trace().builder.load(part.address(), align=8 * self.width)
        return (Number if self.item is DOUBLE else Whole)(value, self.width)

    def _each_lane(self) -> Any:
        """Emit the values at places that differ from lane to lane."""
        builder, offset, lanes = trace().builder, self.offset, trace().lanes()
        if lanes is not None:  # what the others would look up may be anywhere
            offset = selected(lanes, offset, 0)
        found = ir.Constant(form(self.item, offset.width), ir.Undefined)
        for lane in range(offset.width):
            place = Whole(builder.extract_element(offset.value, WHOLE(lane)))
            beside = lane if self.width > 1 else 0
            one = View(self.base, self.item, (), (), 1, plus(place, beside) if beside else place)
            found = builder.insert_element(found, one[()].value, WHOLE(lane))
        return (Number if self.item is DOUBLE else Whole)(found, offset.width)

    def __setitem__(self, index: Any, x: Any) -> None:
        part = self._part(index)
        if part.shape:
            raise NotTraceable("fills a part of an array at once")
        kind, lanes = Number if self.item is DOUBLE else Whole, trace().lanes()
        if lanes is not None:
            if self.width == 1:
                raise NotTraceable("puts a number of several lanes into one place")
            x = selected(lanes, x, part[()])
        trace().builder.store(as_kind(x, kind, self.width), part.address(), align=8 * self.width)


def viewed(array: Any, shape: tuple, apart: int = 1, width: int = 1) -> View:
    """Return a bare pointer as an array of a shape, whose values lie so many numbers apart."""
    steps: list[Any] = [apart]
    for count in reversed(shape[1:]):
        steps.append(_multiplied(steps[-1], count))
    return View(array.base, array.item, tuple(shape), tuple(reversed(steps)), width)


def _multiplied(a: Any, b: Any) -> Any:
    return times(a, b) if is_symbol(a) or is_symbol(b) else a * b


def _product(shape: tuple) -> Any:
    return functools.reduce(_multiplied, shape, 1)


def _moved(offset: Any, place: Any, stride: Any) -> Any:
    if not is_symbol(place) and place == 0:
        return offset
    step = place if not is_symbol(stride) and stride == 1 else _multiplied(place, stride)
    if not is_symbol(offset) and offset == 0:
        return step
    return plus(offset, step) if is_symbol(offset) or is_symbol(step) else offset + step


def table_of(array: np.ndarray) -> View:
    """Return the constant that an array of numpy becomes."""
    hand = trace()
    if id(array) not in hand.tables:
        flat = np.ascontiguousarray(array).ravel()
        item = DOUBLE if array.dtype.kind == "f" else WHOLE
        kind = ir.ArrayType(item, flat.size)
        name = f"table.{len(hand.tables)}"
        known = ir.GlobalVariable(hand.module, kind, name)
        known.initializer = ir.Constant(kind, [item(x) for x in flat.tolist()])
        known.global_constant, known.linkage = True, "internal"
        hand.tables[id(array)] = known
        hand.held.append(array)
    steps = tuple(int(math.prod(array.shape[axis + 1 :])) for axis in range(array.ndim))
    item = DOUBLE if array.dtype.kind == "f" else WHOLE
    return View(hand.tables[id(array)], item, array.shape, steps)


def gathered(view: View, index: tuple) -> Number:
    """Emit the values of an array at places that differ from lane to lane."""
    width, lanes = width_of(*index), trace().lanes()
    if width == 1:
        return view[index]
    if lanes is not None:  # what the others would look up may be anywhere
        index = tuple(selected(lanes, x, 0) if is_symbol(x) else x for x in index)
    builder = trace().builder
    joined = ir.Constant(form(view.item, width), ir.Undefined)
    for lane in range(width):
        place = tuple(
            Whole(builder.extract_element(x.value, WHOLE(lane))) if is_symbol(x) and x.width > 1 else x for x in index
        )
        joined = builder.insert_element(joined, view[place].value, WHOLE(lane))
    return (Number if view.item is DOUBLE else Whole)(joined, width)


def at_address(address: Number, place: Any) -> Number:
    """Emit a number of what lies at an address that travels as a number."""
    builder, width = trace().builder, width_of(address, place)

    def one(address: Any, place: Any) -> Any:
        first = builder.inttoptr(builder.fptoui(address, WHOLE), DOUBLE.as_pointer())
        return builder.load(builder.gep(first, [place]), align=8)

    if width == 1:
        return Number(one(number(address).value, as_kind(place, Whole)))
    lanes = trace().lanes()
    if lanes is not None:  # what the others would look up may be anywhere
        place = selected(lanes, place, 0)
    addresses, places = as_kind(address, Number, width), as_kind(place, Whole, width)
    joined = ir.Constant(form(DOUBLE, width), ir.Undefined)
    for lane in range(width):
        at = (builder.extract_element(x, WHOLE(lane)) for x in (addresses, places))
        joined = builder.insert_element(joined, one(*at), WHOLE(lane))
    return Number(joined, width)


# ---------------------------------------------------------------------------------------------- what is made of symbols


class Path(NamedTuple):
    """A way through a body, which goes on at the end of a block."""

    block: Any
    value: Any


def changed(x: Any, change: Callable) -> Any:
    """Return nested tuples with what is in them changed."""
    return rebuilt(x, iter([change(part) for part in leaves(x)]))


def form_of(x: Any) -> Any:
    """Return what a function of machine code for such a value depends on: all of it but what symbols stand for."""
    if isinstance(x, tuple):
        return (type(x), *map(form_of, x))
    if hasattr(x, "pieces"):
        return (type(x), getattr(x, "known", None), *map(form_of, x.pieces()))
    if isinstance(x, Symbol):
        return type(x), x.width
    if isinstance(x, View):
        known = x.base if isinstance(x.base, ir.GlobalVariable) else None
        extents = tuple(map(form_of, (*x.shape, *x.strides, x.offset)))
        return View, known, x.item, len(x.shape), extents, x.width
    if isinstance(x, np.ndarray):
        return np.ndarray, id(x)
    if isinstance(x, float):
        return float, x.hex()
    if not isinstance(x, (int, str, type, types.FunctionType, np.generic, type(None))):
        raise NotTraceable(f"hands over a {type(x).__name__}")
    return type(x), x


def passed(x: Any) -> list[Any]:
    """Return what of a value is handed over to a function of machine code."""
    found: list[Any] = []
    for part in leaves(x):
        if isinstance(part, Symbol):
            found.append(part.value)
        elif isinstance(part, View):
            if not isinstance(part.base, ir.GlobalVariable):
                found.append(part.base)
            found += [count.value for count in (*part.shape, *part.strides, part.offset) if is_symbol(count)]
    return found


def received(x: Any, arguments: Iterator[Any]) -> Any:
    """Return a value as a function of machine code sees it."""

    def one(part: Any) -> Any:
        if isinstance(part, Symbol):
            return type(part)(next(arguments), part.width)
        if isinstance(part, View):
            base = part.base if isinstance(part.base, ir.GlobalVariable) else next(arguments)
            shape, strides = (tuple(one(count) for count in counts) for counts in (part.shape, part.strides))
            return View(base, part.item, shape, strides, part.width, one(part.offset))
        return part

    return changed(x, one)


def leaves(x: Any) -> Iterator[Any]:
    """Yield what is in nested tuples and numbers with slopes."""
    if isinstance(x, tuple):
        for part in x:
            yield from leaves(part)
    elif hasattr(x, "pieces"):
        for part in x.pieces():
            yield from leaves(part)
    else:
        yield x


def rebuilt(x: Any, values: Iterator[Any]) -> Any:
    """Return nested tuples with other values in them."""
    if isinstance(x, tuple):
        parts = [rebuilt(part, values) for part in x]
        return type(x)(*parts) if hasattr(x, "_fields") else tuple(parts)
    if hasattr(x, "pieces"):
        made = [rebuilt(part, values) for part in x.pieces()]
        return x.remade(made) if hasattr(x, "remade") else type(x)(*made)
    return next(values)


def alike(values: list[Any]) -> list[Any]:
    """Return values with numbers that carry slopes wherever one of them does."""
    first = values[0]
    if all(isinstance(x, tuple) for x in values):
        if any(len(x) != len(first) or type(x) is not type(first) for x in values):
            raise NotTraceable("returns tuples of different forms")
        columns = [alike(list(column)) for column in zip(*values, strict=True)]
        rows: Any = zip(*columns, strict=True) if columns else [() for _ in values]
        return [type(first)(*row) if hasattr(first, "_fields") else tuple(row) for row in rows]
    slopes = [x for x in values if hasattr(x, "parts")]
    if slopes and len(slopes) < len(values):
        return [x if hasattr(x, "parts") else type(slopes[0])(x, 0.0) for x in values]
    if slopes:
        columns = [alike(list(column)) for column in zip(*(x.parts() for x in values), strict=True)]
        return [type(x)(*row) for x, row in zip(values, zip(*columns, strict=True), strict=True)]
    return values


def joined(paths: list[Path]) -> Any:
    """Emit the place where paths meet; return the value there."""
    builder = trace().builder
    if len(paths) == 1:
        builder.position_at_end(paths[0].block)
        return paths[0].value
    end = trace().block()
    values = alike([path.value for path in paths])
    rows = [list(leaves(value)) for value in values]
    if len({len(row) for row in rows}) != 1:
        raise NotTraceable("gives different forms on different paths")
    made = [_meeting([path.block for path in paths], list(column), end) for column in zip(*rows, strict=True)]
    for path in paths:
        builder.position_at_end(path.block)
        builder.branch(end)
    builder.position_at_end(end)
    return rebuilt(values[0], iter(made))


def _meeting(blocks: list[Any], column: list[Any], end: Any) -> Any:
    """Return what values become in the block in which other blocks end."""
    first, builder = column[0], trace().builder
    if all(x is first for x in column):
        return first
    if any(isinstance(x, (View, np.ndarray)) for x in column):
        return _view_of(blocks, [table_of(x) if isinstance(x, np.ndarray) else x for x in column], end)
    if not all(isinstance(x, (Symbol, int, float, np.number, np.bool_)) for x in column):
        if all(type(x) is type(first) and x == first for x in column):
            return first
        raise NotTraceable("gives different things on different paths")
    if not any(map(is_symbol, column)) and all(
        type(x) is type(first) and x == first and math.copysign(1.0, x) == math.copysign(1.0, first) for x in column
    ):
        return first
    kind, width = kind_of(*column), width_of(*column)
    emitted = []
    for block, x in zip(blocks, column, strict=True):
        builder.position_at_end(block)
        emitted.append(as_kind(x, kind, width))
    builder.position_at_end(end)
    phi = builder.phi(form(kind.item, width))  # type: ignore[attr-defined]
    for block, value in zip(blocks, emitted, strict=True):
        phi.add_incoming(value, block)
    return kind(phi, width)


def _view_of(blocks: list[Any], column: list[Any], end: Any) -> View:
    first, base = column[0], column[0].base
    same = all(
        isinstance(x, View) and (x.item, x.width, len(x.shape)) == (first.item, first.width, len(first.shape))
        for x in column
    )
    if not same:
        raise NotTraceable("gives different arrays on different paths")
    if any(x.base is not base for x in column):
        base = _address_of(blocks, [x.base for x in column], end)
    extents = [
        _meeting(blocks, list(each), end) for each in zip(*((*x.shape, *x.strides, x.offset) for x in column), strict=True)
    ]
    count = len(first.shape)
    return View(base, first.item, tuple(extents[:count]), tuple(extents[count:-1]), first.width, extents[-1])


def _address_of(blocks: list[Any], bases: list[Any], end: Any) -> Any:
    """Return the address of one of several arrays in the block in which other blocks end."""
    builder, addresses = trace().builder, []
    for block, base in zip(blocks, bases, strict=True):
        builder.position_at_end(block)
        addresses.append(builder.bitcast(base, ADDRESS))
    builder.position_at_end(end)
    phi = builder.phi(ADDRESS)
    for block, address in zip(blocks, addresses, strict=True):
        phi.add_incoming(address, block)
    return phi
