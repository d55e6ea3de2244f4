"""Arrays of several cases that lie side by side in memory, and rows of numbers in lanes, as compiled code sees them.

Number i of a case is WIDTH numbers before its number i + 1, and between them the same number i of other cases: so a
register contains it of all of them, and a case alone is an array like any other, with larger strides.
"""

import itertools
import math
from collections.abc import Mapping

import numpy as np

from ..trace.memory import View
from ..trace.primitives import primitive
from .family import WIDTH


class BatchArrays:
    """Arrays of WIDTH cases, zeros: name -> (shape of the array of one case, type of its items of eight bytes)."""

    def __init__(self, shapes: Mapping[str, tuple[tuple[int, ...], type]]):
        counts = [math.prod(shape) for shape, _ in shapes.values()]
        ends = itertools.accumulate(counts)
        buffer = np.zeros((sum(counts) + 1) * WIDTH, np.int64)  # at once, as each array takes microseconds to make
        first = -buffer.ctypes.data // 8 % WIDTH  # where a register is loaded from
        self.numbers = buffer[first : first + sum(counts) * WIDTH].reshape(-1, WIDTH)
        self.parts = {name: slice(end - count, end) for name, count, end in zip(shapes, counts, ends, strict=True)}
        self.arrays = {
            name: self.numbers[self.parts[name]].view(dtype).reshape(*shape, WIDTH)
            for name, (shape, dtype) in shapes.items()
        }

    def lane(self, place: int) -> dict[str, np.ndarray]:
        """Return the arrays of one of the cases by name."""
        return {name: array[..., place] for name, array in self.arrays.items()}

    def up_to(self, name: str, place: int) -> np.ndarray:
        """Return what one of the cases has in the first arrays, up to the one of this name, as one array (numbers,)."""
        return self.numbers[: self.parts[name].stop, place].view(float)


def in_rows(arrays, width):
    """Return a NamedTuple of arrays of a lane of a Board as rows: of this lane alone, or from it on as wide as that."""
    return arrays


@primitive(in_rows)
def _in_rows(arrays, width):
    made = arrays.made() if hasattr(arrays, "made") else arrays
    return type(made)(*(View(x.base, x.item, x.shape, x.strides, width, x.offset) for x in made))
