"""Arrays among the parameters of a scene: compiled code reads them at an address that travels as a number."""

import numpy as np

from ..trace.memory import at_address
from ..trace.primitives import primitive
from .family import kernel


class ArrayHandle(float):
    """The address of an array, which lives as long as this; below 2^53, so exact as a float."""

    array: np.ndarray

    def __reduce__(self):
        return array_handle, (self.array,)


def array_handle(values: np.ndarray) -> ArrayHandle:
    """Return what compiled code finds a copy of `values` by, whatever their shape, in their order in memory."""
    array = np.array(values, dtype=np.float64).ravel()
    number = ArrayHandle(array.ctypes.data)
    number.array = array
    return number


def load_item(address, place):
    """Return number `place` of what is kept at an address."""
    return float(address.array[place])


@kernel
def row_of(address, width, rows, now):
    """Return where the last of `rows` rows of `width` numbers begins whose first number is at most `now`.

    Their first numbers increase; below all of them it is the first row.
    """
    low, high = 0, rows
    while high - low > 1:
        middle = (low + high) // 2
        if load_item(address, width * middle) <= now:
            low = middle
        else:
            high = middle
    return width * low


primitive(load_item)(at_address)
