"""Arrays of several cases that lie side by side in memory, and rows of numbers in lanes, as compiled code sees them.

Number i of a case stands WIDTH numbers before its number i + 1, and between them the same number i of other cases: so a
register holds it of all of them, and a case alone is an array like any other, with larger strides.
"""

import operator
from collections.abc import Mapping

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import (
    lower_builtin,
    models,
    overload_attribute,
    register_model,
    type_callable,
    typeof_impl,
)

from .family import WIDTH
from .lanes import WHOLE, vector_of


class Board:
    """Arrays of WIDTH cases, zeros: name -> (shape of the array of one case, type of its items)."""

    def __init__(self, forms: Mapping[str, tuple[tuple[int, ...], type]]):
        self.arrays = {name: _zeros((*shape, WIDTH), dtype) for name, (shape, dtype) in forms.items()}

    def lane(self, place: int) -> dict[str, np.ndarray]:
        """Return the arrays of one of the cases by name."""
        return {name: array[..., place] for name, array in self.arrays.items()}


def _zeros(shape, dtype):
    """Return zeros of eight bytes each that begin where a register is loaded from at once."""
    count = int(np.prod(shape))
    room = np.zeros(count + WIDTH, dtype)
    first = -room.ctypes.data // 8 % WIDTH
    return room[first : first + count].reshape(shape)


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
    """The compiler's type of rows of several values each, in memory: `[i]`, or `[row, i]` with so many `columns`."""

    def __init__(self, several, columns):
        self.several, self.columns = several, columns
        super().__init__(f"Rows({several}, {columns})")


@register_model(RowsType)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, vector_of(kind.several).as_pointer())


def rows_at(builder, kind, pointer):
    """Emit rows, a RowsType or LanesType saying what of, that begin at a pointer."""
    return builder.bitcast(pointer, vector_of(getattr(kind, "several", kind)).as_pointer())


def place_in(builder, rows, several, index):
    """Emit the pointer to the values with number `index` of rows."""
    return builder.gep(rows, [builder.mul(index, WHOLE(WIDTH // several.width))])


def _place(context, builder, kind, rows, index_kind, index):
    if isinstance(index_kind, types.BaseTuple):
        row, column = cgutils.unpack_tuple(builder, index)
        index = builder.add(builder.mul(row, WHOLE(kind.columns)), column)
    return place_in(builder, rows, kind.several, index)


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


@overload_attribute(RowsType, "size", strict=False)
def _size(rows):
    columns = rows.columns
    return lambda rows: columns
