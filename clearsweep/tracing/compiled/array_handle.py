"""Arrays among the parameters of a scene: compiled code reads them at an address that is passed as a number."""

import numpy as np

from ..memory import load_at_address
from ..protocols import register_emitter
from .family import kernel


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


register_emitter(load_item)(load_at_address)
