"""How long a force is how large: the course of an observable over a step, and its histogram over time."""

from typing import NamedTuple

import numpy as np
from numba import njit

from ..compiled.choosing import where
from ..compiled.family import inlined, kernel
from ..compiled.lanes import bits_of, number_of
from .observables import NODES, SHARES

# Histogram of the normal force over time: bins of equal ratio within a factor of two of being so, from the bits of the
# number: BIN_BITS of the mantissa, so a bin is at most 2^-BIN_BITS wide relative to its lower edge.
BIN_BITS = 8
LOWEST = -20  # exponent of 2 of the lowest force told apart, N
BINS = 62 << BIN_BITS
FIRST_BIN = (1023 + LOWEST) << BIN_BITS  # the bits of 2^LOWEST
EDGES = ((np.arange(BINS + 1) + FIRST_BIN) << (52 - BIN_BITS)).view(np.float64)  # N
WIDTHS = np.diff(EDGES)  # N
PARTS = 8  # of a step, into which the course of the force is divided for the histogram and for wear
# Rows of Tally.course: N, s, m/s, m, W
FORCE, KAPPA_COURSE, SLIP_COURSE, DEPTH_COURSE, RUBBED_COURSE, COURSES = range(6)


def _lagrange(nodes, points):
    """Return the (points, nodes) matrix of the polynomial through values at `nodes`, evaluated at `points`."""
    matrix = np.ones((points.size, nodes.size))
    for i in range(nodes.size):
        for m in range(nodes.size):
            if m != i:
                matrix[:, i] *= (points - nodes[m]) / (nodes[i] - nodes[m])
    return matrix


COURSE = np.ascontiguousarray(_lagrange(SHARES, np.arange(PARTS + 1) / PARTS).T)  # (stages, places)


class Ramp(NamedTuple):
    """How the time of a force that goes from one value to another at an even rate is divided among bins."""

    first: int
    last: int
    begun: float  # s, in the first bin
    ended: float  # s, in the last, if that is another
    density: float  # s/N, in whole bins between them


@inlined
def force_bin(force):
    """Return the histogram bin of `force` (N): the leading bits of its exponent and mantissa, from LOWEST on."""
    return min(max((bits_of(force) >> (52 - BIN_BITS)) - FIRST_BIN, 0), BINS - 1)


@inlined
def bin_edge(place):
    """Return the lower edge (N) of the histogram bin `place`."""
    return number_of((place + FIRST_BIN) << (52 - BIN_BITS))


@inlined
def ramp_of(a, b, duration):
    """Return the Ramp of a force that goes from `a` to `b` (N), not negative, during `duration` (s)."""
    low, high = min(a, b), max(a, b)
    first, last = force_bin(low), force_bin(high)
    one = first == last
    density = duration / where(one, 1.0, high - low)
    begun = where(one, duration, density * (bin_edge(first + 1) - low))
    ended = where(one, 0.0, density * (high - bin_edge(last)))
    # where there is no whole bin a huge density would come and go, and leave its rounding
    return Ramp(first, last, begun, ended, where(last > first + 1, density, 0.0))


@kernel
def fill(time, ramp, part):
    """Enter a Ramp into the histogram."""
    time[part.first] += part.begun
    time[part.last] += part.ended
    ramp[min(part.first + 1, part.last)] += part.density
    ramp[part.last] -= part.density


@njit(error_model="numpy", cache=True)
def force_exceeded(time, ramp, duration):
    """Return the force (N) that is exceeded during `duration` (s); 0 where contact lasted less than that.

    time, ramp : (BINS,) rows of the Tally.
    """
    top = BINS - 1
    while top >= 0 and time[top] == 0.0 and ramp[top] == 0.0:
        top -= 1
    above, density = 0.0, 0.0  # time at a force of this bin or higher; of the ramps that pass through it
    for place in range(top, -1, -1):
        spent = time[place] + density * WIDTHS[place]
        above += spent
        if above >= duration:
            return EDGES[place] + (above - duration) / spent * WIDTHS[place]
        density -= ramp[place]
    return 0.0


@kernel
def follow(o, column, course, row):
    """Put an observable's course over the step, at PARTS + 1 even places, into row `row` of `course`.

    It is the polynomial through the values at the stages.
    """
    for i in range(PARTS + 1):
        course[row, i] = 0.0
    for m in range(NODES.size):
        here = o[NODES[m], column]
        for i in range(PARTS + 1):
            course[row, i] += COURSE[m, i] * here


@kernel
def share_beyond(course, limit):
    """Return the share of a step's time in which a contact of this course is deeper than `limit` (m)."""
    beyond, total = 0.0, 0.0
    for i in range(PARTS + 1):
        total += course[KAPPA_COURSE, i]
        if course[DEPTH_COURSE, i] > limit:
            beyond += course[KAPPA_COURSE, i]
    return beyond / total
