"""A value at a fixed address, so that compiled code can process several values of the same form in turn.

In memory it is a sequence of eight-byte words: a number or integer is one word, an array the address of its first item
and its shape, a Fields that of its array, a tuple the words of its items.
"""

import ctypes
import struct
from typing import Any

import numpy as np

from .. import symbols
from ..memory import Fields, Pointer, call_number_at, load_at_address, load_items_at_address, load_word, view_at
from ..protocols import Composite, register_emitter, register_slope_rule
from . import dual
from .dual import Dual, plain
from .family import is_plain, kernel

_PLAIN: dict[int, Any] = {}  # address -> value, if nothing is compiled
_DOUBLE = struct.Struct("<d")
_INT64 = struct.Struct("<q")


class Pinned:
    """A value and its address; this object keeps the value and everything it refers to alive."""

    __slots__ = ("address", "numbers", "value")

    def __init__(self, value: Any):
        machine_words: list[int] = []
        _append_words(value, machine_words)
        buffer = np.array(machine_words, dtype=np.int64)
        self.value, self.numbers, self.address = value, buffer.view(np.float64), buffer.ctypes.data
        if is_plain():
            _PLAIN[self.address] = value

    def put(self, **numbers: float) -> None:
        """Replace numbers (float) in fields of the value; its address does not change."""
        offsets, fields = layout_of(self.value).offsets, list(self.value)
        for name, number in numbers.items():
            fields[type(self.value)._fields.index(name)] = self.numbers[offsets[name]] = number
        self.value = self.value._make(fields)
        if is_plain():
            _PLAIN[self.address] = self.value


def _append_words(value: Any, machine_words: list[int]) -> None:
    """Add the words of a value to a list."""
    for item in value:
        if isinstance(item, tuple):
            _append_words(item, machine_words)
        elif isinstance(item, (np.ndarray, Fields)):
            array = item.numbers if isinstance(item, Fields) else item
            machine_words.append(array.ctypes.data)
            machine_words += array.shape
        elif isinstance(item, float):
            machine_words += _INT64.unpack(_DOUBLE.pack(item))
        else:
            machine_words.append(int(item))


class Layout:
    """Memory layout of a NamedTuple; the last lengths of an array annotated as `Annotated[np.ndarray, 8]` are known."""

    def __init__(self, value: Any):
        self.type, self.field_layouts, self.offsets, offset = type(value), {}, {}, 0
        known_lengths = {name: getattr(kind, "__metadata__", ()) for name, kind in type(value).__annotations__.items()}
        for name, item in zip(type(value)._fields, value, strict=True):
            self.offsets[name] = offset
            if isinstance(item, tuple):
                self.field_layouts[name] = Layout(item)
                offset += self.field_layouts[name].size
            elif isinstance(item, np.ndarray):
                self.field_layouts[name] = _array_layout(name, item, known_lengths[name])
                offset += 1 + item.ndim
            elif isinstance(item, Fields):
                self.field_layouts[name] = (type(item), *_array_layout(name, item.numbers, (type(item).SIZE,)))
                offset += 1 + item.numbers.ndim
            else:
                self.field_layouts[name] = float if isinstance(item, float) else int
                offset += 1
        self.size = offset  # words

    def __repr__(self) -> str:
        return f"{self.type.__name__}({self.field_layouts})"


def _array_layout(name: str, array: np.ndarray, lengths: tuple[int, ...]) -> tuple[str, int, tuple[int, ...], int]:
    """Return the kind of an array's items, its number of dimensions, the last `lengths`, and the stride in numbers."""
    assert array.dtype in (np.float64, np.int64), name
    assert array.shape[array.ndim - len(lengths) :] == lengths, name
    stride = max(array.strides[-1] // 8, 1)  # for empty arrays numpy's strides are arbitrary
    return array.dtype.kind, array.ndim, lengths, stride


_LAYOUTS: dict[type, Layout] = {}  # all Pinned values of a type have one layout


def layout_of(value: Any) -> Layout:
    """Return the Layout of values of this type."""
    if type(value) not in _LAYOUTS:
        _LAYOUTS[type(value)] = Layout(value)
    return _LAYOUTS[type(value)]


def pinned_at(model: Pinned, address: int) -> tuple[Any]:
    """Return an object whose `[0]` is the value at an address, with the layout of the Pinned `model`."""
    return (_PLAIN[address],)


class LoadedValue(Composite):
    """A value at an address known only at run time; its fields are loaded on access."""

    def __init__(self, layout: Layout, address: symbols.Integer, offset: int = 0):
        self._layout, self._address, self._offset = layout, address, offset

    @property
    def static_key(self) -> tuple[int, int]:
        """Return the parts known while tracing."""
        return id(self._layout), self._offset

    def traced_parts(self) -> tuple[Any, ...]:
        """Return the parts unknown while tracing."""
        return (self._address,)

    def with_traced_parts(self, parts: list[Any]) -> "LoadedValue":
        """Return a value of the same form at another address."""
        return LoadedValue(self._layout, parts[0], self._offset)

    def __getattr__(self, name: str) -> Any:
        if name not in self._layout.field_layouts:
            raise AttributeError(name)
        layout, offset = self._layout.field_layouts[name], self._offset + self._layout.offsets[name]
        if isinstance(layout, Layout):
            return LoadedValue(layout, self._address, offset)
        if layout in (float, int):
            return load_word(self._address, offset, symbols.Number if layout is float else symbols.Integer)
        *named, kind, dimensions, lengths, stride = layout
        pointer = Pointer.at(load_word(self._address, offset, symbols.Integer), kind)
        axes = range(offset + 1, offset + 1 + dimensions - len(lengths))
        shape = *(load_word(self._address, position, symbols.Integer) for position in axes), *lengths
        view = view_at(pointer, shape, stride)
        return named[0](view) if named else view

    def __iter__(self) -> Any:
        return (getattr(self, name) for name in self._layout.field_layouts)


@register_emitter(pinned_at)
def _emit_loaded_value(model: Pinned, address: symbols.Integer) -> tuple[LoadedValue]:
    return (LoadedValue(layout_of(model.value), address),)


# ----------------------------------------------------------------------------------------------------------------------
# Arrays among the parameters of a scene: compiled code reads them at an address that is passed as a number.


class ArrayHandle(float):
    """The address of an array, which it keeps alive; below 2^53, so exact as a float."""

    array: np.ndarray

    def __reduce__(self):
        return array_handle, (self.array,)


def array_handle(values: np.ndarray) -> ArrayHandle:
    """Return a handle for compiled code to a copy of `values`, of any shape, in memory order."""
    array = np.array(values, dtype=np.float64).ravel()
    number = ArrayHandle(array.ctypes.data)
    number.array = array
    return number


def load_item(address, index):
    """Return item `index` of the array at an address."""
    return float(address.array[index])


def load_items(address, index, count):
    """Return `count` items of the array at an address, from item `index` on."""
    return tuple(load_item(address, index + i) for i in range(count))


@kernel
def row_of(address, width, row_count, time):
    """Return the index of the last of `row_count` rows of `width` numbers whose first number is at most `time`.

    First numbers increase; below all of them the result is the first row.
    """
    low, high = 0, row_count
    while high - low > 1:
        midpoint = (low + high) // 2
        if load_item(address, width * midpoint) <= time:
            low = midpoint
        else:
            high = midpoint
    return width * low


_CUBIC_WIDTH = 5  # numbers in a row of a cubic: where it begins, value, slope, curvature and rate of the curvature


def cubic_rows(curve):
    """Return the rows (n, 5) for `cubic_at` of the n pieces of a piecewise cubic polynomial of SciPy."""
    return np.stack([curve.x[:-1], curve.c[3], curve.c[2], 2.0 * curve.c[1], 6.0 * curve.c[0]], -1)


@kernel
def cubic_at(address, row_count, x):
    """Return value, slope and curvature at `x` of the cubic whose `row_count` rows are at an address."""
    row = row_of(address, _CUBIC_WIDTH, int(row_count), plain(x))
    _, value, slope, curvature, rate = load_items(address, row, _CUBIC_WIDTH)
    way = x - load_item(address, row)
    return (
        value + way * (slope + way * (0.5 * curvature + rate * way / 6.0)),
        slope + way * (curvature + 0.5 * rate * way),
        curvature + rate * way,
    )


register_emitter(load_item)(load_at_address)
register_emitter(load_items)(load_items_at_address)


# ----------------------------------------------------------------------------------------------------------------------
# C functions among the parameters of a scene: compiled code calls them at an address that is passed as a number.


RELATIVE_STEP, LEAST_STEP = 1e-7, 1e-13  # of the differences that give the slopes of a C function


def call_number(function, parameters, *operands):
    """Return the result of a C function double(double ..., const double *), from its address and that of parameters."""
    if any(isinstance(x, Dual) for x in operands):
        return _call_with_slopes(function, parameters, *operands)
    kind = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * len(operands), ctypes.c_void_p)
    return kind(int(function))(*operands, int(parameters))


def _call_with_slopes(function, parameters, *operands):
    """Return the result of a C function with its slope, from differences over each operand that has one.

    They are one-sided: a law need not exist below a penetration of 0.
    """
    numbers = tuple([dual.value(x) for x in operands])
    result, total = call_number(function, parameters, *numbers), 0.0
    for i in range(len(operands)):
        if isinstance(operands[i], Dual):
            step = RELATIVE_STEP * abs(numbers[i]) + LEAST_STEP
            above = call_number(function, parameters, *numbers[:i], numbers[i] + step, *numbers[i + 1 :])
            total = total + (above - result) / step * dual.slope(operands[i])
    return Dual(result, total)


register_emitter(call_number)(call_number_at)
register_slope_rule(call_number, _call_with_slopes)
