"""Choice between values in kernels whose numbers may be in vector lanes, where branches are impossible."""

import numpy as np

from ..trace import lanes, symbols
from ..trace.memory import gathered, table_of
from ..trace.paths import leaves, rebuilt, with_common_slopes
from ..trace.primitives import LANE_LOOPS, LOOPS, for_symbols, primitive, traceable


def where(condition, a, b):
    """Return `a` if the condition is true, else `b`; both are evaluated."""
    return a if condition else b


def rolled_range(*bounds):
    """Return `range(*bounds)`, for a loop that is compiled once instead of being unrolled."""
    return range(*bounds)


def abreast(count):
    """Return the numbers 0 to WIDTH - 1, for a loop whose turns run simultaneously, each in a vector lane.

    No turn may depend on another; in an array a turn accesses the index of its number, or one at a fixed
    offset from it.
    """
    return range(count)


def total_of(row):
    """Return the sum of WIDTH numbers, in the order in which halves of a register are added."""
    first_half, second_half = (row[0] + row[4]) + (row[2] + row[6]), (row[1] + row[5]) + (row[3] + row[7])
    return first_half + second_half


def cond(first, second):
    """Return a function that returns `first(*given)` if a condition is true, else `second(*given)`.

    It takes (condition, given).  Both kernels return numbers or tuples of the same form.  Only one of them runs if
    all lanes agree, otherwise both.  `first` is compiled twice, so it should be the shorter.
    """

    def chosen(condition, arguments):
        return first(*arguments) if condition else second(*arguments)

    chosen.sides = first, second
    return chosen


def none_of(condition):
    """Return whether a condition is true in no lane."""
    return not condition


@primitive(where)
def _selected(condition, a, b):
    if not symbols.is_symbol(condition):
        return a if condition else b
    a, b = with_common_slopes([a, b])
    pairs = zip(leaves(a), leaves(b), strict=True)
    return rebuilt(a, iter([symbols.selected(condition, x, y) for x, y in pairs]))


primitive(none_of)(lanes.none_of)
traceable(total_of)
LOOPS.append(rolled_range)
LANE_LOOPS.append(abreast)


# ---------------------------------------------------------------------------------------------- bits and tables


def bits_of(number):
    """Return the bits of a number as an integer."""
    return np.float64(number).view(np.int64)


def number_of(bits):
    """Return the number with these bits."""
    return np.int64(bits).view(np.float64)


def looked_up(table, index, column):
    """Return the number in row `index` of a column of a table (rows, columns)."""
    return table[index, column]


for_symbols(bits_of, symbols.bits_of)
for_symbols(number_of, symbols.number_of)


@primitive(looked_up)
def _gathered(table, index, column):
    return gathered(table_of(table), (index, column))
