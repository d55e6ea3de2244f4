"""How a kernel chooses where its numbers may be in lanes, on which it cannot branch."""

import numpy as np

from ..trace import lanes, symbols
from ..trace.memory import gathered, table_of
from ..trace.paths import alike, leaves, rebuilt
from ..trace.primitives import ABREAST, LOOPS, for_symbols, primitive, traceable


def where(condition, a, b):
    """Return `a` where the condition is true, else `b`: numbers that are both there."""
    return a if condition else b


def turns(count):
    """Return the numbers from 0 on, so many: of a loop that is compiled once, not written out turn by turn."""
    return range(count)


def abreast(count):
    """Return the numbers from 0 on, WIDTH of them: of a loop whose turns are run at once, a lane each.

    No turn may need what another one does; of an array a turn reads and fills the place of its number, or one as far
    from that as in all others.
    """
    return range(count)


def total_of(row):
    """Return the sum of WIDTH numbers, in the order in which halves of a register are added."""
    early, late = (row[0] + row[4]) + (row[2] + row[6]), (row[1] + row[5]) + (row[3] + row[7])
    return early + late


def either(first, second):
    """Return a function that gives `first(*given)` where a condition is true, else `second(*given)`.

    It takes (condition, given).  The two, kernels, return the same numbers or tuples of them.  One of them runs where
    all lanes want that, else both.  `first` becomes code twice, so it should be the shorter.
    """

    def chosen(condition, given):
        return first(*given) if condition else second(*given)

    chosen.sides = first, second
    return chosen


def all_of(condition):
    """Return whether a condition is true in every lane."""
    return condition


def none_of(condition):
    """Return whether a condition is true in no lane."""
    return not condition


@primitive(where)
def _selected(condition, a, b):
    if not symbols.is_symbol(condition):
        return a if condition else b
    a, b = alike([a, b])
    pairs = zip(leaves(a), leaves(b), strict=True)
    return rebuilt(a, iter([symbols.selected(condition, x, y) for x, y in pairs]))


primitive(all_of)(lanes.all_of)
primitive(none_of)(lanes.none_of)
traceable(total_of)
LOOPS.append(turns)
ABREAST.append(abreast)


# ---------------------------------------------------------------------------------------------- bits and tables


def bits_of(number):
    """Return the bits of a number as a whole number."""
    return np.float64(number).view(np.int64)


def number_of(bits):
    """Return the number that has these bits."""
    return np.int64(bits).view(np.float64)


def looked_up(table, place, column):
    """Return the number in row `place` of a column of a table (rows, columns)."""
    return table[place, column]


for_symbols(bits_of, symbols.bits_of)
for_symbols(number_of, symbols.number_of)


@primitive(looked_up)
def _gathered(table, place, column):
    return gathered(table_of(table), (place, column))
