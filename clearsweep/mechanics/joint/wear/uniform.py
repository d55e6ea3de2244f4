"""Wear under a uniform pressure, whose load before an edge is a linear function of the edge's angle.

The load before an edge at angle e is, while the edge is within an arc of middle m and half-angle h, the share
(1 + (e - m) / h) / 2 of the load.  Its integral over a part of the step follows from three antiderivatives, of
rate / 2, rate (m - m0) / (2 h) and rate / (2 h), so no edge needs a quadrature of its own.
"""

import math

from ...compiled.choosing import abreast
from ...compiled.family import inlined, kernel
from .arc_over_step import (
    AREA,
    COURSE,
    END,
    END_COURSE,
    END_SLOPE,
    HALF,
    HALF_COURSE,
    INDICES,
    INVERSE_WEIGHTS,
    MIDDLE,
    PAIRS,
    PASSINGS,
    PER_HALF,
    POINTS,
    RATE,
    TERM,
    TIME_PER_ANGLE,
    UNIT_WEIGHTS,
    WORN,
    fit,
    fit_arc,
    inner_side,
    polynomial,
    row_sum,
    worn_in_interval,
    write_worn_before_passed,
)
from .binning import BinCursor, accumulate_inside
from .pressure import Mean

#: Rows of the antiderivatives over the time x, each over x: of rate / 2, rate (m - m0) / (2 h), rate / (2 h).
HALF_RATE, MOMENT, PER_ARC = RATE, TERM, TERM + 1
MAX_PER_HALF = 1e7  # 1/rad: in a narrower arc there is no load, and rounding must not be magnified
PER_POWER = 1.0 / (1.0 + INDICES)  # from the coefficients of a polynomial to those of its antiderivative over x


@inlined
def _origin(workspace):
    """Return the angle (rad) m0 from which angles are counted here, as that of a body that turns may be large."""
    return workspace[MIDDLE * POINTS + PAIRS]


@inlined
def _per_arc(workspace, i):
    """Return half the wear at a point over the half-angle of the arc (m)."""
    return 0.5 * workspace[AREA * POINTS + i] * min(workspace[PER_HALF * POINTS + i], MAX_PER_HALF)


@fit_arc.member(Mean)
def _fit_arc_mean(pressure, workspace):
    origin = _origin(workspace)
    for i in abreast(POINTS):  # the rows of an end are free until `find_passings`
        half_rate, per_arc = 0.5 * workspace[AREA * POINTS + i], _per_arc(workspace, i)
        workspace[END * POINTS + i], workspace[END_SLOPE * POINTS + i] = half_rate, per_arc
        workspace[END_COURSE * POINTS + i] = per_arc * (workspace[MIDDLE * POINTS + i] - origin)
    fit(workspace, END, HALF_RATE, INVERSE_WEIGHTS)
    fit(workspace, END_COURSE, MOMENT, INVERSE_WEIGHTS)
    fit(workspace, END_SLOPE, PER_ARC, INVERSE_WEIGHTS)
    for i in abreast(POINTS):
        workspace[HALF_RATE * POINTS + i] *= PER_POWER[i]
        workspace[MOMENT * POINTS + i] *= PER_POWER[i]
        workspace[PER_ARC * POINTS + i] *= PER_POWER[i]
    fit(workspace, MIDDLE, COURSE, UNIT_WEIGHTS)
    fit(workspace, HALF, HALF_COURSE, UNIT_WEIGHTS)


@inlined
def _area(workspace, end, angle, x):
    """Return the integral up to the time `x` of the load between an end (-1, 1) of the arc and an edge within it.

    angle : rad, of the edge, from the origin.
    """
    moment = polynomial(workspace, MOMENT, x) - angle * polynomial(workspace, PER_ARC, x)
    return x * (polynomial(workspace, HALF_RATE, x) + end * moment)


@write_worn_before_passed.member(Mean)
def _write_worn_before_passed_mean(pressure, workspace, end, edge, width):
    edge_side, first_angle = inner_side(workspace, end), edge - _origin(workspace)
    whole_area = row_sum(workspace, AREA) if end > 0.0 else 0.0
    for k in abreast(POINTS):
        angle = first_angle + INDICES[k] * width
        worn_inside = _area(workspace, end, angle, edge_side) - _area(
            workspace, end, angle, workspace[PASSINGS * POINTS + k]
        )
        workspace[WORN * POINTS + k] = whole_area - end * (edge_side * worn_inside)


@worn_in_interval.member(Mean)
def _worn_in_interval_mean(pressure, workspace, edge, side, span):
    low, high = span
    if side < 0 or high <= low:
        return 0.0
    if side > 0:
        return 2.0 * (high * polynomial(workspace, HALF_RATE, high) - low * polynomial(workspace, HALF_RATE, low))
    angle = edge - _origin(workspace)
    return _area(workspace, -1.0, angle, high) - _area(workspace, -1.0, angle, low)


@kernel
def _worn_before_inner_edge(workspace, edge):
    """Return the wear before an `edge` (rad) that is within the arc at all points, and its slope."""
    for i in abreast(POINTS):
        per_arc = _per_arc(workspace, i)
        workspace[END * POINTS + i] = per_arc
        workspace[TIME_PER_ANGLE * POINTS + i] = per_arc * (edge - workspace[MIDDLE * POINTS + i])
    return 0.5 * row_sum(workspace, AREA) + row_sum(workspace, TIME_PER_ANGLE), row_sum(workspace, END)


@accumulate_inside.member(Mean)
def _accumulate_inside_mean(pressure, workspace, bins, span, cursor):
    """Every bin between two edges within the arc receives the same depth."""
    count, width, total = span[1] - span[0] - 1, 2.0 * math.pi / bins.count, row_sum(workspace, AREA)
    if count < 0:
        return cursor
    first, slope = _worn_before_inner_edge(workspace, (span[0] + 1) * width)
    first = min(max(first, cursor.wear_before), total)
    last = min(first + slope * width * count, total)
    bins.depths[bins.first + cursor.position] += (first - cursor.wear_before) / width
    position, depth = cursor.position, (last - first) / (width * max(count, 1))
    for _ in range(count):
        position = position + 1 if position + 1 < bins.count else 0
        bins.depths[bins.first + position] += depth
    return BinCursor(position + 1 if position + 1 < bins.count else 0, last)
