"""Arrays in memory: addresses, views and items; arrays whose numbers have names."""

import functools
import math
from collections import namedtuple
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Self

import numpy as np
from llvmlite import ir

from .protocols import Composite
from .symbols import (
    ADDRESS,
    DOUBLE,
    INT64,
    Boolean,
    Integer,
    LaneIndices,
    NotTraceableError,
    Number,
    as_kind,
    as_number,
    compare,
    is_symbol,
    llvm_constant,
    llvm_type,
    minus,
    plus,
    select,
    times,
    trace,
    undefined,
    width_of,
)


class Pointer:
    """A pointer to items of known kind but unknown number."""

    def __init__(self, base: Any, item: Any):
        self.base, self.item = base, item

    @classmethod
    def at(cls, address: "Integer", kind: str) -> "Pointer":
        """Return the pointer to an address, 'f' to float64, 'i' to int64."""
        return cls(trace().builder.inttoptr(address.value, ADDRESS), DOUBLE if kind == "f" else INT64)


def load_word(address: "Integer", position: int, kind: type) -> Any:
    """Emit a word stored at an address, which is constant while the program runs."""
    builder = trace().builder
    words = builder.inttoptr(address.value, kind.item.as_pointer())  # type: ignore[attr-defined]
    loaded = builder.load(builder.gep(words, [INT64(position)]), align=8)
    loaded.set_metadata("invariant.load", trace().module.add_metadata([]))
    return kind(loaded)


def call_at(code: Any, parameters: Any, arrays: tuple, integer: Any) -> None:
    """Emit a call of the machine code at an address, with the addresses of parameters and arrays, and an integer."""
    builder = trace().builder
    operands = [builder.inttoptr(as_kind(parameters, Integer), ADDRESS)]
    operands += [builder.bitcast(array.address(), ADDRESS) for array in arrays]
    kind = ir.FunctionType(ir.VoidType(), [ADDRESS] * len(operands) + [INT64])
    builder.call(builder.inttoptr(as_kind(code, Integer), kind.as_pointer()), [*operands, as_kind(integer, Integer)])


class View:
    """An array in memory, or a part of one, with `strides` in units of eight bytes.

    width : number of adjacent values at each position; WIDTH if they belong to lanes.
    """

    ATTRIBUTES = ("shape", "size", "reshape")  # that a body may use
    __slots__ = ("base", "item", "offset", "shape", "strides", "width")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, base: Any, item: Any, shape: tuple, strides: tuple[int, ...], width: int = 1, offset: Any = 0):
        self.base, self.item, self.shape, self.strides = base, item, shape, strides
        self.width, self.offset = width, offset

    def __eq__(self, other: Any) -> Any:
        raise NotTraceableError("compares arrays")

    def __bool__(self) -> bool:
        raise NotTraceableError("takes the truth value of an array")

    def __len__(self) -> int:
        if not self.shape or is_symbol(self.shape[0]):
            raise NotTraceableError("takes the length of an array whose shape is known only at run time")
        return int(self.shape[0])

    def __iter__(self) -> Iterator[Any]:
        return (self[position] for position in range(len(self)))

    @property
    def size(self) -> Any:
        """Return the number of values."""
        return functools.reduce(_multiply, self.shape, 1)

    def reshape(self, *shape: int) -> "View":
        """Return the contiguous values as an array of another shape."""
        known = not any(map(is_symbol, (*self.shape, *self.strides, *shape)))
        if known and (self.strides != _contiguous(self.shape) or self.size != math.prod(shape)):
            raise NotTraceableError("reshapes an array that is not contiguous, or to another size")
        strides = [self.strides[-1]]
        for count in reversed(shape[1:]):
            strides.append(strides[-1] * count)
        return View(self.base, self.item, shape, tuple(reversed(strides)), self.width, self.offset)

    def _subview(self, index: Any) -> "View":
        indices = index if isinstance(index, tuple) else (index,)
        if len(indices) > len(self.shape):
            raise NotTraceableError(f"takes an item by {len(indices)} indices of an array of {len(self.shape)}")
        offset, shape, strides = self.offset, [], []
        for axis, axis_index in enumerate(indices):
            if isinstance(axis_index, slice):
                start, stop = _slice_bounds(axis_index, self.shape[axis])
                offset = _advance_offset(offset, start, self.strides[axis])
                shape.append(stop - start if not (is_symbol(stop) or is_symbol(start)) else minus(stop, start))
                strides.append(self.strides[axis])
                continue
            offset = _advance_offset(offset, _item_index(axis_index, self.shape[axis]), self.strides[axis])
        count = len(indices)
        return View(
            self.base, self.item, (*shape, *self.shape[count:]), (*strides, *self.strides[count:]), self.width, offset
        )

    def address(self) -> Any:
        """Emit the address of the first value."""
        builder = trace().builder
        base = builder.bitcast(self.base, self.item.as_pointer())
        item_offset = self.offset.value if is_symbol(self.offset) else INT64(self.offset)
        pointer = builder.gep(base, [item_offset])
        return pointer if self.width == 1 else builder.bitcast(pointer, llvm_type(self.item, self.width).as_pointer())

    def lane_address(self) -> Any:
        """Emit the address of values that are adjacent across lanes, for all lanes together."""
        pointer = View(self.base, self.item, (), (), 1, self.offset.first).address()
        return trace().builder.bitcast(pointer, llvm_type(self.item, self.offset.width).as_pointer())

    def __getitem__(self, index: Any) -> Any:
        item = self._subview(index)
        if item.shape:
            return item
        if isinstance(item.offset, LaneIndices) and item.width == 1:
            value = trace().builder.load(item.lane_address(), align=8)
            return (Number if self.item is DOUBLE else Integer)(value, item.offset.width)
        if is_symbol(item.offset) and item.offset.width > 1:
            return item._each_lane()
        value = trace().builder.load(item.address(), align=8 * self.width)
        return (Number if self.item is DOUBLE else Integer)(value, self.width)

    def _each_lane(self) -> Any:
        """Emit the values at positions that differ between lanes."""
        builder, offset, lanes = trace().builder, self.offset, trace().lanes()
        if lanes is not None:  # the addresses of inactive lanes may be invalid
            offset = select(lanes, offset, 0)
        vector = undefined(self.item, offset.width)
        for lane in range(offset.width):
            item_offset = Integer(builder.extract_element(offset.value, INT64(lane)))
            lane_offset = lane if self.width > 1 else 0
            item = View(self.base, self.item, (), (), 1, plus(item_offset, lane_offset) if lane_offset else item_offset)
            vector = builder.insert_element(vector, item[()].value, INT64(lane))
        return (Number if self.item is DOUBLE else Integer)(vector, offset.width)

    def __setitem__(self, index: Any, x: Any) -> None:
        item = self._subview(index)
        if item.shape:
            raise NotTraceableError("assigns to a part of an array")
        kind, lanes = Number if self.item is DOUBLE else Integer, trace().lanes()
        if isinstance(item.offset, LaneIndices) and item.width == 1:
            x = x if lanes is None else select(lanes, x, item[()])
            trace().builder.store(as_kind(x, kind, item.offset.width), item.lane_address(), align=8)
            return
        if lanes is not None:
            if self.width == 1:
                raise NotTraceableError("stores values of several lanes at one address")
            x = select(lanes, x, item[()])
        trace().builder.store(as_kind(x, kind, self.width), item.address(), align=8 * self.width)


def _item_index(index: Any, count: Any) -> Any:
    """Return the index of an item, counted from the first one; that of the loop's own arrays is taken as it is."""
    if not (isinstance(index, (Integer, int, np.integer)) and not isinstance(index, bool)):
        raise NotTraceableError(f"takes an item of an array by a {type(index).__name__}")
    if is_symbol(index):
        return index_from_start(index, count) if trace().are_indices_checked else index
    if not is_symbol(count) and not -count <= index < count:
        raise IndexError(f"index {index} of an array of {count}")
    return count + int(index) if index < 0 else int(index)


def _slice_bounds(part: slice, count: Any) -> tuple[Any, Any]:
    """Return the first index of a part of an array, and the one after its last."""
    if part.step not in (None, 1):
        raise NotTraceableError("takes every n-th item of an array")
    if not any(map(is_symbol, (part.start, part.stop, count))):
        start, stop, _ = part.indices(count)
        return start, max(start, stop)
    if trace().are_indices_checked:
        raise NotTraceableError("takes a part of an array whose bounds are known only at run time")
    bounds = 0 if part.start is None else part.start, count if part.stop is None else part.stop
    if any(not is_symbol(x) and x < 0 for x in bounds):
        raise NotTraceableError("takes a part of an array from its end, which is known only at run time")
    return bounds


def _contiguous(shape: tuple) -> tuple[int, ...]:
    """Return the strides of a contiguous array."""
    return tuple(int(math.prod(shape[axis + 1 :])) for axis in range(len(shape)))


def view_at(array: Any, shape: tuple, stride: int = 1, width: int = 1) -> View:
    """Return a bare pointer as an array of a shape, with a stride of `stride` numbers."""
    strides: list[Any] = [stride]
    for count in reversed(shape[1:]):
        strides.append(_multiply(strides[-1], count))
    return View(array.base, array.item, tuple(shape), tuple(reversed(strides)), width)


def _multiply(a: Any, b: Any) -> Any:
    return times(a, b) if is_symbol(a) or is_symbol(b) else a * b


def _advance_offset(offset: Any, index: Any, stride: Any) -> Any:
    if not is_symbol(index) and index == 0:
        return offset
    increment = index if not is_symbol(stride) and stride == 1 else _multiply(index, stride)
    if not is_symbol(offset) and offset == 0:
        return increment
    return plus(offset, increment) if is_symbol(offset) or is_symbol(increment) else offset + increment


def index_from_start(index: Any, count: int) -> Any:
    """Return an index of a table, which may be known only at run time, counted from the first item."""
    if not is_symbol(index) or isinstance(index, LaneIndices):
        return index
    return select(compare("<", index, 0), plus(index, count), index)


def constant_table(array: np.ndarray) -> View:
    """Return the constant made of a numpy array."""
    active_trace = trace()
    if array.dtype not in (np.float64, np.int64):
        raise NotTraceableError(f"uses an array of {array.dtype}: only float64 and int64 are supported")
    if id(array) not in active_trace.tables:
        flat = np.ascontiguousarray(array).ravel()
        item = DOUBLE if array.dtype.kind == "f" else INT64
        kind = ir.ArrayType(item, flat.size)
        name = f"table.{len(active_trace.tables)}"
        table = ir.GlobalVariable(active_trace.module, kind, name)
        table.initializer = ir.Constant(kind, [item(x) for x in flat.tolist()])
        table.global_constant, table.linkage, table.align = True, "internal", 64  # the lanes of a row in one cache line
        active_trace.tables[id(array)] = table
        active_trace.kept_alive.append(array)
    item = DOUBLE if array.dtype.kind == "f" else INT64
    return View(active_trace.tables[id(array)], item, array.shape, _contiguous(array.shape))


def load_at_address(address: Number, position: Any) -> Number:
    """Emit a number stored at an address that is passed as a number."""
    builder, width = trace().builder, width_of(address, position)

    def load(address: Any, position: Any) -> Any:
        numbers = builder.inttoptr(builder.fptoui(address, INT64), DOUBLE.as_pointer())
        return builder.load(builder.gep(numbers, [position]), align=8)

    if width == 1:
        return Number(load(as_number(address).value, as_kind(position, Integer)))
    lanes = trace().lanes()
    if lanes is not None:  # the addresses of inactive lanes may be invalid
        position = select(lanes, position, 0)
    addresses, positions = as_kind(address, Number, width), as_kind(position, Integer, width)
    vector = undefined(DOUBLE, width)
    for lane in range(width):
        arguments = (builder.extract_element(x, INT64(lane)) for x in (addresses, positions))
        vector = builder.insert_element(vector, load(*arguments), INT64(lane))
    return Number(vector, width)


def load_items_at_address(address: Number, position: Any, count: int) -> tuple[Number, ...]:
    """Emit `count` numbers that follow each other; four at a time, in lanes, from one load for each lane."""
    builder, width, lanes = trace().builder, width_of(address, position), trace().lanes()
    if width != 8 or count != 4 or width_of(address) > 1:
        return tuple(load_at_address(address, plus(position, i)) for i in range(count))
    if lanes is not None:  # the addresses of inactive lanes may be invalid
        position = select(lanes, position, 0)
    numbers = builder.inttoptr(builder.fptoui(as_kind(address, Number), INT64), DOUBLE.as_pointer())
    positions, row = as_kind(position, Integer, width), ir.VectorType(DOUBLE, count).as_pointer()
    places = (builder.gep(numbers, [builder.extract_element(positions, INT64(lane))]) for lane in range(width))
    rows = [builder.load(builder.bitcast(place, row), align=8) for place in places]
    pairs = [_shuffled(rows[i], rows[i + 1], range(8)) for i in range(0, width, 2)]
    halves = [
        [_shuffled(pairs[i], pairs[i + 1], [k + 4 * m for k in columns for m in range(4)]) for i in (0, 2)]
        for columns in ((0, 1), (2, 3))
    ]
    parts = ([0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15])
    return tuple(Number(_shuffled(*half, part), width) for half in halves for part in parts)


def _shuffled(a: Any, b: Any, indices: Any) -> Any:
    """Emit the items at `indices` of two vectors, which are counted together."""
    return trace().builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(indices)), list(indices)))


def call_number_at(function: Number, parameters: Number, *operands: Any) -> Number:
    """Emit the call of a C function double(double ..., const double *) at an address that is passed as a number.

    It is called once for each active lane, as C knows no lanes.
    """
    builder, width, lanes = trace().builder, width_of(function, parameters, *operands), trace().lanes()
    kind = ir.FunctionType(DOUBLE, [DOUBLE] * len(operands) + [DOUBLE.as_pointer()])

    def call(function: Any, parameters: Any, *numbers: Any) -> Any:
        code, pointer = (builder.fptoui(address, INT64) for address in (function, parameters))
        return builder.call(
            builder.inttoptr(code, kind.as_pointer()), [*numbers, builder.inttoptr(pointer, DOUBLE.as_pointer())]
        )

    values = [as_kind(x, Number, width) for x in (function, parameters, *operands)]
    if width == 1:
        return Number(call(*values))
    active = None if lanes is None else as_kind(lanes, Boolean, width)
    vector = llvm_constant(DOUBLE, 0.0, width)
    for lane in range(width):
        before, after = builder.block, trace().block()
        called = before if active is None else trace().block()
        if active is not None:
            builder.cbranch(builder.extract_element(active, INT64(lane)), called, after)
            builder.position_at_end(called)
        result = builder.insert_element(
            vector, call(*(builder.extract_element(x, INT64(lane)) for x in values)), INT64(lane)
        )
        builder.branch(after)
        builder.position_at_end(after)
        merged = builder.phi(vector.type)
        merged.add_incoming(result, called)
        if active is not None:
            merged.add_incoming(vector, before)
        vector = merged
    return Number(vector, width)


def rebase(value: Any) -> Any:
    """Return a View with its offset in its base, so that parts of an array share a function; other values unchanged."""
    is_global = isinstance(value, View) and isinstance(value.base, ir.GlobalVariable)
    if not isinstance(value, View) or is_global or width_of(value.offset) > 1:
        return value
    if not is_symbol(value.offset) and value.offset == 0:
        return value
    base = trace().builder.bitcast(value.address(), ADDRESS)
    return View(base, value.item, value.shape, value.strides, value.width)


# ---------------------------------------------------------------------------------------------- arrays with names


class _Field:
    """A number of a Fields, by its index."""

    def __init__(self, index: int):
        self.index = index

    def __get__(self, record: "Fields | None", owner: type | None = None) -> Any:
        return self if record is None else record.of_one_row()[self.index]

    def __set__(self, record: "Fields", value: Any) -> None:
        record.of_one_row()[self.index] = value


class _WithoutDictionary(type):
    """Makes instances of all subclasses reject attributes that are no field."""

    def __new__(cls, name: str, bases: tuple[type, ...], namespace: dict[str, Any], **keywords: Any) -> type:
        return super().__new__(cls, name, bases, {"__slots__": ()} | namespace, **keywords)


class Fields(Composite, metaclass=_WithoutDictionary):
    """Named numbers in an array, all float64 or all int64, or rows of them.

    A subclass declares a number by an annotation, with unit and meaning in a comment; the order of the declarations is
    the order in memory.  The type is float or int, or a class derived from one of them that says of what kind a number
    is.  A subclass of a subclass has its fields, then its own.  The array is a numpy array or, in a traced body, a
    View: `stepper.growth = 1.0` changes it.  If the array has a further leading axis, `rows[j]` is the Fields of row
    `j`, and `rows.column("growth")` are the numbers of all rows.
    """

    DECLARED: ClassVar[dict[str, type]]  # fields
    SIZE: ClassVar[int]  # their number
    DTYPE: ClassVar[type]
    VALUES: ClassVar[Any]  # NamedTuple with these fields
    __slots__ = ("numbers",)
    numbers: Any

    def __init_subclass__(cls, like: type | None = None, **keywords: Any) -> None:
        """Declare the fields; `like` : a NamedTuple whose fields they are, as float64, instead of annotations."""
        super().__init_subclass__(**keywords)
        own_fields = dict.fromkeys(like.__annotations__, float) if like else cls.__annotations__
        declared = getattr(cls, "DECLARED", {}) | own_fields
        cls.DECLARED = declared
        cls.SIZE = len(declared)
        (cls.DTYPE,) = {float if issubclass(kind, float) else int for kind in declared.values()} or {float}
        cls.VALUES = namedtuple(f"{cls.__name__}Values", declared)
        for index, name in enumerate(declared):
            setattr(cls, name, _Field(index))

    def __init__(self, numbers: np.ndarray | View):
        self.numbers = numbers

    def __len__(self) -> int:
        return len(self.numbers)

    def __iter__(self) -> Iterator[Self]:
        return map(type(self), self.numbers)

    def __getitem__(self, row: Any) -> Self:
        return type(self)(self.numbers[row])

    def of_one_row(self) -> Any:
        """Return the array, which has one axis."""
        if len(self.numbers.shape) != 1:
            raise AttributeError(f"{type(self).__name__} has several rows: choose one, or use `column`")
        return self.numbers

    def column(self, name: str) -> np.ndarray:
        """Return the numbers of a field in all rows, as a view."""
        column: np.ndarray = self.numbers[:, self.index_of(name)]
        return column

    def values(self) -> Any:
        """Return the numbers as a NamedTuple of Python numbers, whose fields read faster, or a list of one per row."""
        numbers = self.numbers.tolist()
        return self.VALUES._make(numbers) if self.numbers.ndim == 1 else list(map(self.VALUES._make, numbers))

    def traced_parts(self) -> tuple[Any, ...]:
        """Return the parts unknown while tracing."""
        return (self.numbers,)

    def copy(self) -> Self:
        """Return the Fields with a copy of their array."""
        return type(self)(self.numbers.copy())

    @classmethod
    def zeros(cls, *rows: int, zeros: Callable[..., np.ndarray] = np.zeros) -> Self:
        """Return Fields of zeros, or rows of them; `zeros` allocates the array."""
        return cls(zeros((*rows, cls.SIZE), dtype=cls.DTYPE))

    @classmethod
    def index_of(cls, name: str) -> int:
        """Return the index of a field."""
        return list(cls.DECLARED).index(name)


class _Row:
    """A row of a Rows, by its index."""

    def __init__(self, index: int):
        self.index = index

    def __get__(self, record: "Rows | None", owner: type | None = None) -> Any:
        return self if record is None else record.numbers[self.index]


class Rows(Fields):
    """Named rows of an array, declared as the numbers of Fields are: `rows.area[i]`."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        """Declare the rows."""
        super().__init_subclass__(**keywords)
        for index, name in enumerate(cls.DECLARED):
            setattr(cls, name, _Row(index))
