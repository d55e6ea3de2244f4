"""Wear under an even pressure, whose load before an edge is a linear function of the edge's angle.

The load before an edge at angle e is, while the edge is within an arc of middle m and half-angle h, the share
(1 + (e - m) / h) / 2 of the load.  Its integral over a part of the step follows from three antiderivatives, of
rate / 2, rate (m - m0) / (2 h) and rate / (2 h), so no edge needs a quadrature of its own.
"""

import math

from ...compiled.choosing import abreast
from ...compiled.family import inlined, kernel
from .entering import Entered, enter_within
from .passage import (
    AREA,
    COURSE,
    END,
    END_COURSE,
    END_SLOPE,
    EVENLY,
    HALF,
    HALF_COURSE,
    MIDDLE,
    NUMBERS,
    PAIRS,
    PASSING,
    PER_HALF,
    PER_WAY,
    PER_WEIGHT,
    POINTS,
    RATE,
    TERM,
    WORN,
    crossed,
    fit,
    fit_points,
    inner_side,
    piece,
    summed,
    value,
)
from .pressure import Mean

#: Rows of the antiderivatives over the place x, each over x: of rate / 2, rate (m - m0) / (2 h), rate / (2 h).
WHOLE, MOMENT, PER_ARC = RATE, TERM, TERM + 1
MOST_PER_HALF = 1e7  # 1/rad: in a narrower arc there is no load, and rounding must not be magnified
PER_POWER = 1.0 / (1.0 + NUMBERS)  # from the coefficients of a polynomial to those of its antiderivative over x


@inlined
def _origin(workspace):
    """Return the angle (rad) m0 from which angles are counted here, as that of a body that turns may be large."""
    return workspace[MIDDLE * POINTS + PAIRS]


@inlined
def _per_arc(workspace, i):
    """Return half the wear at a point over the half-angle of the arc (m)."""
    return 0.5 * workspace[AREA * POINTS + i] * min(workspace[PER_HALF * POINTS + i], MOST_PER_HALF)


@fit_points.member(Mean)
def _fit_points_mean(pressure, workspace):
    origin = _origin(workspace)
    for i in abreast(POINTS):  # the rows of an end are free until `find_passing`
        half_rate, per_arc = 0.5 * workspace[AREA * POINTS + i], _per_arc(workspace, i)
        workspace[END * POINTS + i], workspace[END_SLOPE * POINTS + i] = half_rate, per_arc
        workspace[END_COURSE * POINTS + i] = per_arc * (workspace[MIDDLE * POINTS + i] - origin)
    fit(workspace, END, WHOLE, PER_WEIGHT)
    fit(workspace, END_COURSE, MOMENT, PER_WEIGHT)
    fit(workspace, END_SLOPE, PER_ARC, PER_WEIGHT)
    for i in abreast(POINTS):
        workspace[WHOLE * POINTS + i] *= PER_POWER[i]
        workspace[MOMENT * POINTS + i] *= PER_POWER[i]
        workspace[PER_ARC * POINTS + i] *= PER_POWER[i]
    fit(workspace, MIDDLE, COURSE, EVENLY)
    fit(workspace, HALF, HALF_COURSE, EVENLY)


@inlined
def _area(workspace, end, angle, x):
    """Return the integral up to the place `x` of the load between an end (-1, 1) of the arc and an edge within it.

    angle : rad, of the edge, from the origin.
    """
    beyond = value(workspace, MOMENT, x) - angle * value(workspace, PER_ARC, x)
    return x * (value(workspace, WHOLE, x) + end * beyond)


@crossed.member(Mean)
def _crossed_mean(pressure, workspace, end, edge, width):
    edge_side, first = inner_side(workspace, end), edge - _origin(workspace)
    whole_area = summed(workspace, AREA) if end > 0.0 else 0.0
    for k in abreast(POINTS):
        angle = first + NUMBERS[k] * width
        within = _area(workspace, end, angle, edge_side) - _area(workspace, end, angle, workspace[PASSING * POINTS + k])
        workspace[WORN * POINTS + k] = whole_area - end * (edge_side * within)


@piece.member(Mean)
def _piece_mean(pressure, workspace, edge, side, span):
    low, high = span
    if side < 0 or high <= low:
        return 0.0
    if side > 0:
        return 2.0 * (high * value(workspace, WHOLE, high) - low * value(workspace, WHOLE, low))
    angle = edge - _origin(workspace)
    return _area(workspace, -1.0, angle, high) - _area(workspace, -1.0, angle, low)


@kernel
def _worn_before(workspace, edge):
    """Return the wear before an `edge` (rad) that is within the arc at all points, and its slope."""
    for i in abreast(POINTS):
        per_arc = _per_arc(workspace, i)
        workspace[END * POINTS + i] = per_arc
        workspace[PER_WAY * POINTS + i] = per_arc * (edge - workspace[MIDDLE * POINTS + i])
    return 0.5 * summed(workspace, AREA) + summed(workspace, PER_WAY), summed(workspace, END)


@enter_within.member(Mean)
def _enter_within_mean(pressure, workspace, bins, span, at):
    """Every bin between two such edges takes the same depth."""
    count, width, total = span[1] - span[0] - 1, 2.0 * math.pi / bins.count, summed(workspace, AREA)
    if count < 0:
        return at
    first, slope = _worn_before(workspace, (span[0] + 1) * width)
    first = min(max(first, at.before), total)
    last = min(first + slope * width * count, total)
    bins.depths[bins.first + at.position] += (first - at.before) / width
    position, depth = at.position, (last - first) / (width * max(count, 1))
    for _ in range(count):
        position = position + 1 if position + 1 < bins.count else 0
        bins.depths[bins.first + position] += depth
    return Entered(position + 1 if position + 1 < bins.count else 0, last)
