"""Arrays of several cases that lie side by side in memory, and rows of numbers in lanes, as compiled code sees them.

Number i of a case stands WIDTH numbers before its number i + 1, and between them the same number i of other cases: so a
register holds it of all of them, and a case alone is an array like any other, with larger strides.
"""

import itertools
import math
import operator
from collections.abc import Mapping

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import (
    intrinsic,
    lower_builtin,
    make_attribute_wrapper,
    models,
    overload,
    overload_attribute,
    register_model,
    type_callable,
    typeof_impl,
)

from .family import OPTIONS, WIDTH
from .lanes import WHOLE, LanesType, WholesType, vector_of


class Board:
    """Arrays of WIDTH cases, zeros: name -> (shape of the array of one case, type of its items of eight bytes)."""

    def __init__(self, forms: Mapping[str, tuple[tuple[int, ...], type]]):
        counts = [math.prod(shape) for shape, _ in forms.values()]
        ends = itertools.accumulate(counts)
        room = np.zeros((sum(counts) + 1) * WIDTH, np.int64)  # at once, as each array takes microseconds to make
        first = -room.ctypes.data // 8 % WIDTH  # where a register is loaded from
        self.numbers = room[first : first + sum(counts) * WIDTH].reshape(-1, WIDTH)
        self.parts = {name: slice(end - count, end) for name, count, end in zip(forms, counts, ends, strict=True)}
        self.arrays = {
            name: self.numbers[self.parts[name]].view(dtype).reshape(*shape, WIDTH)
            for name, (shape, dtype) in forms.items()
        }

    def lane(self, place: int) -> dict[str, np.ndarray]:
        """Return the arrays of one of the cases by name."""
        return {name: array[..., place] for name, array in self.arrays.items()}

    def up_to(self, name: str, place: int) -> np.ndarray:
        """Return what one of the cases has in the first arrays, up to the one of this name, as one array (numbers,)."""
        return self.numbers[: self.parts[name].stop, place].view(float)


def lies_in_lanes(form, names):
    """Let the compiler take arrays of a NamedTuple for what they are in a lane: numbers with others between them.

    By itself it would take an array of one number for one without gaps: a type of its own, of which code that was
    compiled for one contact would then be handed arrays of several.
    """

    @typeof_impl.register(form)
    def typeof_form(value, context):
        kinds = [typeof_impl(item, context) for item in value]
        return types.NamedTuple(
            [kind.copy(layout="A") if name in names else kind for name, kind in zip(form._fields, kinds, strict=True)],
            form,
        )


class RowsType(types.Type):
    """The compiler's type of rows of several values each, in memory: `[i]`, or `[row, i]` of so many columns."""

    def __init__(self, several):
        self.several = several
        super().__init__(f"Rows({several})")


@register_model(RowsType)
class _RowsModel(models.StructModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, [("first", types.voidptr), ("columns", types.intp)])


make_attribute_wrapper(RowsType, "columns", "size")


@overload_attribute(RowsType, "shape", strict=False)
def _shape(rows):
    return lambda rows: (-1, rows.size)  # how many rows there are is nobody's business


def rows_at(context, builder, kind, pointer, columns):
    """Emit rows of a RowsType that begin at a pointer and have so many columns, a whole number of the compiler's."""
    rows = cgutils.create_struct_proxy(kind)(context, builder)
    rows.first, rows.columns = builder.bitcast(pointer, cgutils.voidptr_t), columns
    return rows._getvalue()


def place_in(builder, first, several, index):
    """Emit the pointer to the values with number `index` of what begins at a pointer."""
    first = builder.bitcast(first, vector_of(several).as_pointer())
    return builder.gep(first, [builder.mul(index, WHOLE(WIDTH // several.width))])


def _place(context, builder, kind, rows, index_kind, index):
    rows = cgutils.create_struct_proxy(kind)(context, builder, value=rows)
    if isinstance(index_kind, types.BaseTuple):
        row, column = cgutils.unpack_tuple(builder, index)
        index = builder.add(builder.mul(row, rows.columns), column)
    return place_in(builder, rows.first, kind.several, index)


def in_rows(arrays, width):
    """Return a NamedTuple of arrays of a lane of a Board as rows: of this lane alone, or from it on as wide as that."""
    return arrays


@overload(in_rows, strict=False, prefer_literal=True, jit_options=dict(OPTIONS, forceinline=True))
def _in_rows(arrays, width):
    wide = width.literal_value
    return lambda arrays, width: _as_rows(arrays, wide)


@intrinsic(prefer_literal=True)
def _as_rows(typing_context, arrays, width):
    """Emit the rows."""
    several = {types.float64: LanesType(width.literal_value), types.int64: WholesType(width.literal_value)}
    result = types.NamedTuple([RowsType(several[array.dtype]) for array in arrays.types], arrays.instance_class)

    def emit(context, builder, signature, values):
        found = []
        for place, (kind, form) in enumerate(zip(arrays.types, result.types, strict=True)):
            array = context.make_array(kind)(context, builder, builder.extract_value(values[0], place))
            columns = cgutils.unpack_tuple(builder, array.shape)[-1]
            found.append(rows_at(context, builder, form, array.data, columns))
        return context.make_tuple(builder, result, found)

    return result(arrays, width), emit


@type_callable(operator.getitem)
def _type_item(context):
    return lambda rows, index: rows.several if isinstance(rows, RowsType) else None


@type_callable(operator.setitem)
def _type_set_item(context):
    return lambda rows, index, value: types.void if isinstance(rows, RowsType) else None


@lower_builtin(operator.getitem, RowsType, types.Integer)
@lower_builtin(operator.getitem, RowsType, types.BaseTuple)
def _item(context, builder, signature, values):
    kind = signature.args[0]
    return builder.load(_place(context, builder, kind, values[0], signature.args[1], values[1]))


@lower_builtin(operator.setitem, RowsType, types.Integer, types.Any)
@lower_builtin(operator.setitem, RowsType, types.BaseTuple, types.Any)
def _set_item(context, builder, signature, values):
    kind = signature.args[0]
    number = context.cast(builder, values[2], signature.args[2], kind.several)
    builder.store(number, _place(context, builder, kind, values[0], signature.args[1], values[1]))
    return context.get_dummy_value()
