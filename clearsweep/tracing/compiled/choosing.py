"""Choice between values in kernels whose numbers may be in vector lanes; and cosine and sine of an angle there."""

import math

import numpy as np

from .. import activation
from ..functions import COSINE, SINE
from ..memory import constant_table
from ..portable import bits_of, number_of, where
from ..protocols import LANE_LOOPS, LOOPS, mark_traceable, register_emitter
from .family import Routine, inlined, shaped

# ----------------------------------------------------------------------------------------------------------------------
# Choice between values in kernels whose numbers may be in vector lanes, where branches are impossible.


__all__ = ["bits_of", "number_of", "where"]  # of `portable`, offered here to kernels


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


_THIRD_ROOT_BITS = 2 * (1023 << 52) // 3 - (200 << 40)  # of 1; minus half the error of the root


def rough_cube_root(x):
    """Return the cube root of a positive number within 5 %, in a fraction of the time of `pow`."""
    return number_of(bits_of(x) // 3 + _THIRD_ROOT_BITS)


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


@inlined
def replaced(items, index, item):
    """Return a tuple with another item at an index, which may be known only at run time."""
    return tuple([item if i == index else other for i, other in enumerate(items)])


register_emitter(none_of)(activation.none_of)
mark_traceable(total_of)
mark_traceable(rough_cube_root)
LOOPS.append(rolled_range)
LANE_LOOPS.append(lane_range)


# ---------------------------------------------------------------------------------------------- bits and tables


def table_item(table, index, column):
    """Return the number in row `index` of a column of a table (rows, columns)."""
    return table[index, column]


register_emitter(table_item)(lambda table, index, column: constant_table(table)[index, column])


# ----------------------------------------------------------------------------------------------------------------------
# Cosine and sine of an angle together, by polynomials around the nearest axis.
#
# There is no table: eight angles in vector lanes would look up their entries one after the other.


# A quarter turn in two parts, the first of so few digits that its multiples up to MAX_EXACT_ANGLE are exact (Cody and
# Waite).
HALF_PI_HIGH = math.ldexp(round(math.ldexp(0.5 * math.pi, 32)), -32)
# the sine is the difference between pi and math.pi
HALF_PI_LOW = (0.5 * math.pi - HALF_PI_HIGH) + 0.5 * math.sin(math.pi)
SHIFT = 1.5 * 2.0**52  # adding this rounds a number to an integer in its last bits
MAX_EXACT_ANGLE = 1e6  # rad


@inlined
def direction(angle):
    """Return cosine and sine of `angle` (rad), each to 2e-16 up to MAX_EXACT_ANGLE, else to the angle's rounding."""
    shifted = angle * (2.0 / math.pi) + SHIFT
    quarters, shifted_bits = shifted - SHIFT, bits_of(shifted)
    x = (angle - quarters * HALF_PI_HIGH) - quarters * HALF_PI_LOW
    z = x * x
    fourth = z * z
    high = (SINE[3] + z * SINE[4]) + fourth * (SINE[5] + z * SINE[6])
    sine = x + x * z * ((SINE[0] + z * SINE[1]) + fourth * (SINE[2] + z * high))
    high = (COSINE[2] + z * COSINE[3]) + fourth * (COSINE[4] + z * COSINE[5])
    cosine = 1.0 - (0.5 * z - fourth * ((COSINE[0] + z * COSINE[1]) + fourth * high))
    is_swapped = shifted_bits & 1 == 1
    c, s = where(is_swapped, sine, cosine), where(is_swapped, cosine, sine)
    return where((shifted_bits + 1) & 2 == 2, -c, c), where(shifted_bits & 2 == 2, -s, s)


def _directions(angles, cosines, sines, count):
    angles, cosines, sines = shaped(angles, (count,)), shaped(cosines, (count,)), shaped(sines, (count,))
    for k in rolled_range(count):
        cosines[k], sines[k] = direction(angles[k])


_write_directions = Routine(_directions, "fff")


def directions(angles):
    """Return cosines and sines of an array of angles (rad), the same bits as in compiled code."""
    angles = np.require(angles, float, "CW")
    cosines, sines = np.empty_like(angles), np.empty_like(angles)
    _write_directions((angles.reshape(-1), cosines.reshape(-1), sines.reshape(-1)), angles.size)
    return cosines, sines
