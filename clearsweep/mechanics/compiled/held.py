"""Arrays among the parameters of a scene: compiled code reads them at an address that travels as a number."""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from .family import OPTIONS, kernel


class Held(float):
    """The address of an array, which lives as long as this; below 2^53, so exact as a float."""

    array: np.ndarray

    def __reduce__(self):
        return held, (self.array,)


def held(values: np.ndarray) -> Held:
    """Return what compiled code finds a copy of `values` by, whatever their shape, in their order in memory."""
    array = np.array(values, dtype=np.float64).ravel()
    number = Held(array.ctypes.data)
    number.array = array
    return number


def item_of(address, place):
    """Return number `place` of what is held at an address."""
    return float(address.array[place])


@intrinsic
def _load(typing_context, address, place):
    """Emit the load of a number behind an address."""

    def emit(context, builder, signature, values):
        where = builder.inttoptr(builder.fptoui(values[0], ir.IntType(64)), ir.DoubleType().as_pointer())
        return builder.load(builder.gep(where, [values[1]]))

    return types.float64(types.float64, types.int64), emit


@overload(item_of, strict=False, jit_options=dict(OPTIONS))
def _item_of(address, place):
    def compiled(address, place):
        return _load(address, place)

    return compiled


@kernel
def row_of(address, width, rows, now):
    """Return where the last of `rows` rows of `width` numbers begins whose first number is at most `now`.

    Their first numbers increase; below all of them it is the first row.
    """
    low, high = 0, rows
    while high - low > 1:
        middle = (low + high) // 2
        if item_of(address, width * middle) <= now:
            low = middle
        else:
            high = middle
    return width * low
