"""Arrays in memory: addresses, views and items."""

import functools
import math
from typing import Any

import numpy as np
from llvmlite import ir

from .symbols import (
    ADDRESS,
    DOUBLE,
    WHOLE,
    Abreast,
    NotTraceableError,
    Number,
    Whole,
    as_kind,
    form,
    is_symbol,
    minus,
    number,
    plus,
    selected,
    times,
    trace,
    width_of,
)


class Bare:
    """A pointer of which only the kind of its items is known."""

    def __init__(self, base: Any, item: Any):
        self.base, self.item = base, item

    @classmethod
    def at(cls, address: "Whole", kind: str) -> "Bare":
        """Return the pointer to an address, 'f' to float64, 'i' to int64."""
        return cls(trace().builder.inttoptr(address.value, ADDRESS), DOUBLE if kind == "f" else WHOLE)


def word_at(address: "Whole", place: int, kind: type) -> Any:
    """Emit a word stored at an address, which is constant while the program runs."""
    builder = trace().builder
    first = builder.inttoptr(address.value, kind.item.as_pointer())  # type: ignore[attr-defined]
    loaded = builder.load(builder.gep(first, [WHOLE(place)]), align=8)
    loaded.set_metadata("invariant.load", trace().module.add_metadata([]))
    return kind(loaded)


def call_at(code: Any, parameters: Any, arrays: tuple, integer: Any) -> None:
    """Emit a call of the machine code at an address, with the addresses of parameters and arrays, and an integer."""
    builder = trace().builder
    given = [builder.inttoptr(as_kind(parameters, Whole), ADDRESS)]
    given += [builder.bitcast(array.address(), ADDRESS) for array in arrays]
    kind = ir.FunctionType(ir.VoidType(), [ADDRESS] * len(given) + [WHOLE])
    builder.call(builder.inttoptr(as_kind(code, Whole), kind.as_pointer()), [*given, as_kind(integer, Whole)])


class View:
    """An array in memory, or a part of one, with `strides` in units of eight bytes.

    width : number of adjacent values at each place; WIDTH if they belong to lanes.
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
        """Return the contiguous values as an array of another shape."""
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
            known = not is_symbol(place)
            counted = self.shape[axis] + int(place) if known and place < 0 else int(place) if known else place
            offset = _moved(offset, counted, self.strides[axis])
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

    def abreast(self) -> Any:
        """Emit the address of values that are adjacent across lanes, for all lanes together."""
        first = View(self.base, self.item, (), (), 1, self.offset.first).address()
        return trace().builder.bitcast(first, form(self.item, self.offset.width).as_pointer())

    def __getitem__(self, index: Any) -> Any:
        part = self._part(index)
        if part.shape:
            return part
        if isinstance(part.offset, Abreast) and part.width == 1:
            value = trace().builder.load(part.abreast(), align=8)
            return (Number if self.item is DOUBLE else Whole)(value, part.offset.width)
        if is_symbol(part.offset) and part.offset.width > 1:
            return part._each_lane()
        value = trace().builder.load(part.address(), align=8 * self.width)
        return (Number if self.item is DOUBLE else Whole)(value, self.width)

    def _each_lane(self) -> Any:
        """Emit the values at places that differ between lanes."""
        builder, offset, lanes = trace().builder, self.offset, trace().lanes()
        if lanes is not None:  # the addresses of inactive lanes may be invalid
            offset = selected(lanes, offset, 0)
        packed = ir.Constant(form(self.item, offset.width), ir.Undefined)
        for lane in range(offset.width):
            place = Whole(builder.extract_element(offset.value, WHOLE(lane)))
            lane_offset = lane if self.width > 1 else 0
            single = View(self.base, self.item, (), (), 1, plus(place, lane_offset) if lane_offset else place)
            packed = builder.insert_element(packed, single[()].value, WHOLE(lane))
        return (Number if self.item is DOUBLE else Whole)(packed, offset.width)

    def __setitem__(self, index: Any, x: Any) -> None:
        part = self._part(index)
        if part.shape:
            raise NotTraceableError("fills a part of an array at once")
        kind, lanes = Number if self.item is DOUBLE else Whole, trace().lanes()
        if isinstance(part.offset, Abreast) and part.width == 1:
            x = x if lanes is None else selected(lanes, x, part[()])
            trace().builder.store(as_kind(x, kind, part.offset.width), part.abreast(), align=8)
            return
        if lanes is not None:
            if self.width == 1:
                raise NotTraceableError("puts a number of several lanes into one place")
            x = selected(lanes, x, part[()])
        trace().builder.store(as_kind(x, kind, self.width), part.address(), align=8 * self.width)


def viewed(array: Any, shape: tuple, apart: int = 1, width: int = 1) -> View:
    """Return a bare pointer as an array of a shape, with a stride of `apart` numbers."""
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
    """Return the constant made of a numpy array."""
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
        hand.kept_alive.append(array)
    steps = tuple(int(math.prod(array.shape[axis + 1 :])) for axis in range(array.ndim))
    item = DOUBLE if array.dtype.kind == "f" else WHOLE
    return View(hand.tables[id(array)], item, array.shape, steps)


def gathered(view: View, index: tuple) -> Number:
    """Emit the values of an array at places that differ between lanes."""
    width, lanes = width_of(*index), trace().lanes()
    if width == 1 or isinstance(view._part(index).offset, Abreast):
        return view[index]
    if lanes is not None:  # the addresses of inactive lanes may be invalid
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
    """Emit a number stored at an address that is passed as a number."""
    builder, width = trace().builder, width_of(address, place)

    def single(address: Any, place: Any) -> Any:
        first = builder.inttoptr(builder.fptoui(address, WHOLE), DOUBLE.as_pointer())
        return builder.load(builder.gep(first, [place]), align=8)

    if width == 1:
        return Number(single(number(address).value, as_kind(place, Whole)))
    lanes = trace().lanes()
    if lanes is not None:  # the addresses of inactive lanes may be invalid
        place = selected(lanes, place, 0)
    addresses, places = as_kind(address, Number, width), as_kind(place, Whole, width)
    joined = ir.Constant(form(DOUBLE, width), ir.Undefined)
    for lane in range(width):
        at = (builder.extract_element(x, WHOLE(lane)) for x in (addresses, places))
        joined = builder.insert_element(joined, single(*at), WHOLE(lane))
    return Number(joined, width)
