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
    """A pointer to items of known kind but unknown number."""

    def __init__(self, base: Any, item: Any):
        self.base, self.item = base, item

    @classmethod
    def at(cls, address: "Whole", kind: str) -> "Bare":
        """Return the pointer to an address, 'f' to float64, 'i' to int64."""
        return cls(trace().builder.inttoptr(address.value, ADDRESS), DOUBLE if kind == "f" else WHOLE)


def word_at(address: "Whole", position: int, kind: type) -> Any:
    """Emit a word stored at an address, which is constant while the program runs."""
    builder = trace().builder
    leading = builder.inttoptr(address.value, kind.item.as_pointer())  # type: ignore[attr-defined]
    loaded = builder.load(builder.gep(leading, [WHOLE(position)]), align=8)
    loaded.set_metadata("invariant.load", trace().module.add_metadata([]))
    return kind(loaded)


def call_at(code: Any, parameters: Any, arrays: tuple, integer: Any) -> None:
    """Emit a call of the machine code at an address, with the addresses of parameters and arrays, and an integer."""
    builder = trace().builder
    operands = [builder.inttoptr(as_kind(parameters, Whole), ADDRESS)]
    operands += [builder.bitcast(array.address(), ADDRESS) for array in arrays]
    kind = ir.FunctionType(ir.VoidType(), [ADDRESS] * len(operands) + [WHOLE])
    builder.call(builder.inttoptr(as_kind(code, Whole), kind.as_pointer()), [*operands, as_kind(integer, Whole)])


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
        operands = index if isinstance(index, tuple) else (index,)
        offset, shape, strides = self.offset, [], []
        for axis, position in enumerate(operands):
            if isinstance(position, slice):
                leading = 0 if position.start is None else position.start
                last = self.shape[axis] if position.stop is None else position.stop
                offset = _moved(offset, leading, self.strides[axis])
                shape.append(last - leading if not (is_symbol(last) or is_symbol(leading)) else minus(last, leading))
                strides.append(self.strides[axis])
                continue
            constant_value = not is_symbol(position)
            counted = (
                self.shape[axis] + int(position)
                if constant_value and position < 0
                else int(position)
                if constant_value
                else position
            )
            offset = _moved(offset, counted, self.strides[axis])
        count = len(operands)
        return View(
            self.base,
            self.item,
            (*shape, *self.shape[count:]),
            (*strides, *self.strides[count:]),
            self.width,
            offset,
        )

    def address(self) -> Any:
        """Emit the address of the first value."""
        builder = trace().builder
        leading = builder.bitcast(self.base, self.item.as_pointer())
        position = self.offset.value if is_symbol(self.offset) else WHOLE(self.offset)
        at = builder.gep(leading, [position])
        return at if self.width == 1 else builder.bitcast(at, form(self.item, self.width).as_pointer())

    def abreast(self) -> Any:
        """Emit the address of values that are adjacent across lanes, for all lanes together."""
        leading = View(self.base, self.item, (), (), 1, self.offset.first).address()
        return trace().builder.bitcast(leading, form(self.item, self.offset.width).as_pointer())

    def __getitem__(self, index: Any) -> Any:
        item = self._part(index)
        if item.shape:
            return item
        if isinstance(item.offset, Abreast) and item.width == 1:
            value = trace().builder.load(item.abreast(), align=8)
            return (Number if self.item is DOUBLE else Whole)(value, item.offset.width)
        if is_symbol(item.offset) and item.offset.width > 1:
            return item._each_lane()
        value = trace().builder.load(item.address(), align=8 * self.width)
        return (Number if self.item is DOUBLE else Whole)(value, self.width)

    def _each_lane(self) -> Any:
        """Emit the values at places that differ between lanes."""
        builder, offset, lanes = trace().builder, self.offset, trace().lanes()
        if lanes is not None:  # the addresses of inactive lanes may be invalid
            offset = selected(lanes, offset, 0)
        packed = ir.Constant(form(self.item, offset.width), ir.Undefined)
        for lane in range(offset.width):
            position = Whole(builder.extract_element(offset.value, WHOLE(lane)))
            lane_offset = lane if self.width > 1 else 0
            one_lane = View(self.base, self.item, (), (), 1, plus(position, lane_offset) if lane_offset else position)
            packed = builder.insert_element(packed, one_lane[()].value, WHOLE(lane))
        return (Number if self.item is DOUBLE else Whole)(packed, offset.width)

    def __setitem__(self, index: Any, x: Any) -> None:
        item = self._part(index)
        if item.shape:
            raise NotTraceableError("fills a part of an array at once")
        kind, lanes = Number if self.item is DOUBLE else Whole, trace().lanes()
        if isinstance(item.offset, Abreast) and item.width == 1:
            x = x if lanes is None else selected(lanes, x, item[()])
            trace().builder.store(as_kind(x, kind, item.offset.width), item.abreast(), align=8)
            return
        if lanes is not None:
            if self.width == 1:
                raise NotTraceableError("puts a number of several lanes into one place")
            x = selected(lanes, x, item[()])
        trace().builder.store(as_kind(x, kind, self.width), item.address(), align=8 * self.width)


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


def _moved(offset: Any, position: Any, stride: Any) -> Any:
    if not is_symbol(position) and position == 0:
        return offset
    step = position if not is_symbol(stride) and stride == 1 else _multiplied(position, stride)
    if not is_symbol(offset) and offset == 0:
        return step
    return plus(offset, step) if is_symbol(offset) or is_symbol(step) else offset + step


def table_of(array: np.ndarray) -> View:
    """Return the constant made of a numpy array."""
    active_trace = trace()
    if id(array) not in active_trace.tables:
        flat = np.ascontiguousarray(array).ravel()
        item = DOUBLE if array.dtype.kind == "f" else WHOLE
        kind = ir.ArrayType(item, flat.size)
        name = f"table.{len(active_trace.tables)}"
        constant_value = ir.GlobalVariable(active_trace.module, kind, name)
        constant_value.initializer = ir.Constant(kind, [item(x) for x in flat.tolist()])
        constant_value.global_constant, constant_value.linkage = True, "internal"
        active_trace.tables[id(array)] = constant_value
        active_trace.kept_alive.append(array)
    steps = tuple(int(math.prod(array.shape[axis + 1 :])) for axis in range(array.ndim))
    item = DOUBLE if array.dtype.kind == "f" else WHOLE
    return View(active_trace.tables[id(array)], item, array.shape, steps)


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
        position = tuple(
            Whole(builder.extract_element(x.value, WHOLE(lane))) if is_symbol(x) and x.width > 1 else x for x in index
        )
        joined = builder.insert_element(joined, view[position].value, WHOLE(lane))
    return (Number if view.item is DOUBLE else Whole)(joined, width)


def at_address(address: Number, position: Any) -> Number:
    """Emit a number stored at an address that is passed as a number."""
    builder, width = trace().builder, width_of(address, position)

    def one_lane(address: Any, position: Any) -> Any:
        leading = builder.inttoptr(builder.fptoui(address, WHOLE), DOUBLE.as_pointer())
        return builder.load(builder.gep(leading, [position]), align=8)

    if width == 1:
        return Number(one_lane(number(address).value, as_kind(position, Whole)))
    lanes = trace().lanes()
    if lanes is not None:  # the addresses of inactive lanes may be invalid
        position = selected(lanes, position, 0)
    addresses, places = as_kind(address, Number, width), as_kind(position, Whole, width)
    joined = ir.Constant(form(DOUBLE, width), ir.Undefined)
    for lane in range(width):
        at = (builder.extract_element(x, WHOLE(lane)) for x in (addresses, places))
        joined = builder.insert_element(joined, one_lane(*at), WHOLE(lane))
    return Number(joined, width)
