"""Choice between values in kernels whose numbers may be in vector lanes, where branches are impossible."""

from .. import paths
from ..memory import constant_table, gather
from ..portable import bits_of, number_of, where
from ..protocols import LANE_LOOPS, LOOPS, mark_traceable, register_emitter

__all__ = ["bits_of", "cond", "lane_range", "none_of", "number_of", "rolled_range", "table_item", "total_of", "where"]


def rolled_range(*bounds):
    """Return `range(*bounds)`, for a loop that is compiled once instead of being unrolled."""
    return range(*bounds)


def lane_range(count):
    """Return the numbers 0 to WIDTH - 1, for a loop whose iterations run simultaneously, each in a vector lane.

    No iteration may depend on another.  It accesses arrays at the index of its number, or at a fixed offset from it.
    """
    return range(count)


def total_of(row):
    """Return the sum of WIDTH numbers, in the order in which halves of a register are added."""
    first_half, second_half = (row[0] + row[4]) + (row[2] + row[6]), (row[1] + row[5]) + (row[3] + row[7])
    return first_half + second_half


def cond(if_true, if_false):
    """Return a function that returns `if_true(*arguments)` if a condition is true, else `if_false(*arguments)`.

    It takes (condition, arguments).  Both kernels return numbers or tuples of the same form.  Only one of them runs if
    all lanes agree, otherwise both.  `if_true` is compiled twice, so it should be the shorter.
    """

    def chosen(condition, arguments):
        return if_true(*arguments) if condition else if_false(*arguments)

    chosen.sides = if_true, if_false
    return chosen


def none_of(condition):
    """Return whether a condition is true in no lane."""
    return not condition


register_emitter(none_of)(paths.none_of)
mark_traceable(total_of)
LOOPS.append(rolled_range)
LANE_LOOPS.append(lane_range)


# ---------------------------------------------------------------------------------------------- bits and tables


def table_item(table, index, column):
    """Return the number in row `index` of a column of a table (rows, columns)."""
    return table[index, column]


@register_emitter(table_item)
def _emit_table_item(table, index, column):
    return gather(constant_table(table), (index, column))
