"""Cosine and sine of an angle together, by polynomials around the nearest axis.

There is no table: eight angles in vector lanes would look up their entries one after the other.
"""

import math

import numpy as np

from ..functions import COSINE, SINE
from .choosing import bits_of, rolled_range, where
from .family import Routine, inlined, shaped

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
