"""Arrays among the parameters of a scene: compiled code reads them at an address that travels as a number."""

import numpy as np

from ..trace.memory import at_address
from ..trace.primitives import primitive
from .family import kernel


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


primitive(item_of)(at_address)
