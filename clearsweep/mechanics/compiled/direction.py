"""Cosine and sine of an angle together, from a table and two short polynomials.

A right-hand side waits for its trigonometry before it can begin with anything else.  The library's functions are called
one after the other and are the largest part of that wait; here both angles of a pose are worked on at once.
"""

import math

import numpy as np

from .choosing import bits_of, either, looked_up
from .family import inlined

PLACES = 256  # of the table, a power of 2: the rest of an angle is at most pi / 256
STEP = 2.0 * math.pi / PLACES
# STEP in two parts, the first of so few digits that its multiples up to LARGEST are exact (Cody and Waite).
COARSE = math.ldexp(round(math.ldexp(STEP, 32)), -32)
FINE = (STEP - COARSE) + 2.0 * math.sin(math.pi) / PLACES  # the sine is by how much math.pi falls short of pi
SHIFT = 1.5 * 2.0**52  # a number to which this is added is rounded to an integer, which its last bits then hold
LARGEST = 1e6  # rad: beyond, and where an angle is not finite, the library's functions take over


def _at(place):
    """Return cosine and sine of `place` steps, from the angle's distance to the nearest axis: the least rounding."""
    axis = round(4 * place / PLACES)
    x = (place - axis * PLACES // 4) * STEP
    c, s = math.cos(x), math.sin(x)
    return ((c, s), (-s, c), (-c, -s), (s, -c))[axis % 4]


TABLE = np.array([_at(place) for place in range(PLACES)])


@inlined
def direction(angle):
    """Return cosine and sine of `angle` (rad), each to 3e-16 up to 1,000 turns."""
    return _direction(abs(angle) < LARGEST, (angle,))


@inlined
def _looked_up(angle):
    shifted = angle * (1.0 / STEP) + SHIFT
    multiple = shifted - SHIFT
    place = bits_of(shifted) & (PLACES - 1)
    x = (angle - multiple * COARSE) - multiple * FINE
    square = x * x
    sine = x - x * square * (1.0 / 6.0 - square * (1.0 / 120.0))
    cosine = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0)))
    c, s = looked_up(TABLE, place, 0), looked_up(TABLE, place, 1)
    return c * cosine - s * sine, s * cosine + c * sine


@inlined
def _from_library(angle):
    return math.cos(angle), math.sin(angle)


_direction = either(_looked_up, _from_library)
