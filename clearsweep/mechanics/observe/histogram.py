"""How long a force is how large: the course of an observable over a step, and its histogram over time."""

import numpy as np

from ..compiled.family import kernel
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
FORCE, KAPPA_COURSE, SLIP_COURSE, DEPTH_COURSE, RUBBED_COURSE, COURSES = range(
    6
)  # rows of Tally.course: N, s, m/s, m, W


def _lagrange(nodes, points):
    """Return the (points, nodes) matrix of the polynomial through values at `nodes`, evaluated at `points`."""
    matrix = np.ones((points.size, nodes.size))
    for i in range(nodes.size):
        for m in range(nodes.size):
            if m != i:
                matrix[:, i] *= (points - nodes[m]) / (nodes[i] - nodes[m])
    return matrix


COURSE = np.ascontiguousarray(_lagrange(SHARES, np.arange(PARTS + 1) / PARTS).T)  # (stages, places)


@kernel
def force_bin(force):
    """Return the histogram bin of `force` (N): the leading bits of its exponent and mantissa, from LOWEST on."""
    place = (np.float64(force).view(np.int64) >> (52 - BIN_BITS)) - FIRST_BIN
    return min(max(place, 0), BINS - 1)


@kernel
def bin_edge(place):
    """Return the lower edge (N) of the histogram bin `place`."""
    return np.int64((place + FIRST_BIN) << (52 - BIN_BITS)).view(np.float64)


@kernel
def fill_ramp(time, ramp, a, b, duration):
    """Enter a force that goes from `a` to `b` (N) at an even rate during `duration` (s)."""
    low, high = max(min(a, b), 0.0), max(a, b, 0.0)
    i, k = force_bin(low), force_bin(high)
    density = duration / (high - low if i != k else 1.0)
    time[i] += density * (bin_edge(i + 1) - low) if i != k else duration
    time[k] += density * (high - bin_edge(k)) if i != k else 0.0
    between = density if k > i + 1 else 0.0  # no whole bins: a huge density would come and go, and leave its rounding
    ramp[min(i + 1, k)] += between
    ramp[k] -= between


def force_exceeded(time, ramp, duration):
    """Return the force (N) that is exceeded during `duration` (s); 0 where contact lasted less than that.

    time, ramp : (BINS,) rows of the Tally.
    """
    for count in (4 << BIN_BITS, BINS):  # the highest bins mostly suffice
        entered = (time != 0.0) | (ramp != 0.0)
        top = BINS - int(entered[::-1].argmax())  # above, nothing was
        low = max(top - count, 0)
        density = -np.cumsum(ramp[low:top][::-1])  # of the bins from the top down, each without its own change
        density[1:], density[0] = density[:-1].copy(), 0.0
        spent = time[low:top][::-1] + density * WIDTHS[low:top][::-1]
        above = np.cumsum(spent)  # time at a force of each bin or higher
        if above[-1] >= duration:
            place = int((above >= duration).argmax())
            edge = top - 1 - place
            return EDGES[edge] + (above[place] - duration) / spent[place] * WIDTHS[edge]
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
