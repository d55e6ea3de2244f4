"""Rows of several numbers each, and how they come from the arrays of single cases and go back there.

The arrays of cases lie wherever they are; eight numbers of each of eight cases are eight registers, which are
transposed on the way, so that every case finds its own numbers together.
"""

import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, models, overload_attribute, register_model, type_callable

from .family import BLOCK
from .lanes import WHOLE, vector_of


class RowsType(types.Type):
    """The compiler's type of rows of several values each, in memory: `[i]`, or `[row, i]` with so many `columns`."""

    def __init__(self, several, columns):
        self.several, self.columns = several, columns
        super().__init__(f"Rows({several}, {columns})")


@register_model(RowsType)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, vector_of(kind.several).as_pointer())


def new_rows(builder, kind, count):
    """Emit room for `count` values of several on the stack, each where a register is loaded from at once."""
    place = cgutils.alloca_once(builder, vector_of(kind.several), size=count)
    place.align = 8 * kind.several.width
    return place


def _at(context, builder, kind, rows, index_kind, index):
    if isinstance(index_kind, types.BaseTuple):
        row, column = cgutils.unpack_tuple(builder, index)
        index = builder.add(builder.mul(row, WHOLE(kind.columns)), column)
    return builder.gep(rows, [index])


@type_callable(operator.getitem)
def _type_item(context):
    return lambda rows, index: rows.several if isinstance(rows, RowsType) else None


@type_callable(operator.setitem)
def _type_set_item(context):
    return lambda rows, index, value: types.void if isinstance(rows, RowsType) else None


@lower_builtin(operator.getitem, RowsType, types.Integer)
@lower_builtin(operator.getitem, RowsType, types.BaseTuple)
def _item(context, builder, signature, values):
    return builder.load(_at(context, builder, signature.args[0], values[0], signature.args[1], values[1]))


@lower_builtin(operator.setitem, RowsType, types.Integer, types.Any)
@lower_builtin(operator.setitem, RowsType, types.BaseTuple, types.Any)
def _set_item(context, builder, signature, values):
    kind = signature.args[0]
    number = context.cast(builder, values[2], signature.args[2], kind.several)
    builder.store(number, _at(context, builder, kind, values[0], signature.args[1], values[1]))
    return context.get_dummy_value()


@overload_attribute(RowsType, "size", strict=False)
def _size(rows):
    columns = rows.columns
    return lambda rows: columns


# ---------------------------------------------------------------------------------------------- cases beside each other
#
# The arrays of each case lie wherever they are: a table (lanes, arrays) of addresses says where.


def _transposed(builder, rows, width):
    """Emit the transposed of `width` vectors of `width` values each."""
    for distance in (1 << bit for bit in range(width.bit_length() - 1)):
        for i in (i for i in range(width) if not i & distance):
            a, b = rows[i], rows[i | distance]
            low = [x if not x & distance else width + x - distance for x in range(width)]
            high = [x + distance if not x & distance else width + x for x in range(width)]
            for place, order in ((i, low), (i | distance, high)):
                mask = ir.Constant(ir.VectorType(ir.IntType(32), width), order)
                rows[place] = builder.shuffle_vector(a, b, mask)
    return rows


def room_for(count, dtype=np.float64):
    """Return zeros (count,) in front of so much room that registers may read and write past them."""
    return np.zeros(-(-count // BLOCK) * BLOCK, dtype=dtype)[:count]


def taken(builder, kind, addresses, count):
    """Emit the first values, `count` or some more, of the array of each lane, side by side; see `room_for`."""
    width, vector, found = kind.width, vector_of(kind), []
    arrays = [builder.inttoptr(address, kind.item.as_pointer()) for address in addresses]
    while len(found) < count:
        first = len(found)
        whole = [builder.bitcast(builder.gep(array, [WHOLE(first)]), vector.as_pointer()) for array in arrays]
        found += _transposed(builder, [builder.load(place, align=8) for place in whole], width)
    return found


def put_back(builder, kind, addresses, first, values):
    """Emit what puts values that are side by side into the array of each lane, from place `first` on.

    The last of them may be followed by some that mean nothing; see `room_for`.
    """
    width, vector = kind.width, vector_of(kind)
    values = values + [ir.Constant(vector, None)] * (-len(values) % width)
    arrays = [builder.inttoptr(address, kind.item.as_pointer()) for address in addresses]
    for done in range(0, len(values), width):
        for array, row in zip(arrays, _transposed(builder, values[done : done + width], width), strict=True):
            place = builder.bitcast(builder.gep(array, [WHOLE(first + done)]), vector.as_pointer())
            builder.store(row, place, align=8)
