"""Wear under a uniform pressure, whose load before an edge is a linear function of the edge's angle.

The load before an edge at angle e is, while the edge is within an arc of middle m and half-angle h, the fraction
(1 + (e - m) / h) / 2 of the load.  Its integral over a part of the step follows from three antiderivatives, of
rate / 2, rate (m - m0) / (2 h) and rate / (2 h), so no edge needs a quadrature of its own.
"""

import math

from ...compiled.choosing import lane_range
from ...compiled.family import inlined, kernel
from .arc_over_step import (
    AREA,
    END,
    END_POLYNOMIAL,
    END_SLOPE,
    HALF,
    HALF_POLYNOMIAL,
    INDICES,
    INVERSE_WEIGHTS,
    MIDDLE,
    MIDDLE_POLYNOMIAL,
    PAIRS,
    PASSINGS,
    PER_HALF,
    POINTS,
    RATE,
    TERM,
    TIME_PER_ANGLE,
    UNIT_WEIGHTS,
    WORN,
    evaluate_polynomial,
    fit_arc,
    fit_row,
    inside_time,
    row_sum,
    wear_before_edge_in_span,
    write_wear_before_passed_edges,
)
from .binning import BinCursor, update_bins_inside_arc
from .pressure import UniformPressure

#: Rows of the antiderivatives over the time x, each over x: of rate / 2, rate (m - m0) / (2 h), rate / (2 h).
HALF_RATE, MOMENT, PER_ARC = RATE, TERM, TERM + 1
MAX_PER_HALF = 1e7  # 1/rad: in a narrower arc there is no load, and rounding must not be magnified
PER_POWER = 1.0 / (1.0 + INDICES)  # from the coefficients of a polynomial to those of its antiderivative over x


@inlined
def _origin(workspace):
    """Return the angle m0 (rad) that is subtracted from all angles, since the angle of a rotating body may be large."""
    return workspace[MIDDLE * POINTS + PAIRS]


@inlined
def _per_arc(workspace, i):
    """Return half the wear at a point over the half-angle of the arc (m)."""
    return 0.5 * workspace[AREA * POINTS + i] * min(workspace[PER_HALF * POINTS + i], MAX_PER_HALF)


@fit_arc.member(UniformPressure)
def _fit_arc_uniform(pressure, workspace):
    origin = _origin(workspace)
    for i in lane_range(POINTS):  # the rows of an end are free until `write_passing_times`
        half_rate, per_arc = 0.5 * workspace[AREA * POINTS + i], _per_arc(workspace, i)
        workspace[END * POINTS + i], workspace[END_SLOPE * POINTS + i] = half_rate, per_arc
        workspace[END_POLYNOMIAL * POINTS + i] = per_arc * (workspace[MIDDLE * POINTS + i] - origin)
    fit_row(workspace, END, HALF_RATE, INVERSE_WEIGHTS)
    fit_row(workspace, END_POLYNOMIAL, MOMENT, INVERSE_WEIGHTS)
    fit_row(workspace, END_SLOPE, PER_ARC, INVERSE_WEIGHTS)
    for i in lane_range(POINTS):
        workspace[HALF_RATE * POINTS + i] *= PER_POWER[i]
        workspace[MOMENT * POINTS + i] *= PER_POWER[i]
        workspace[PER_ARC * POINTS + i] *= PER_POWER[i]
    fit_row(workspace, MIDDLE, MIDDLE_POLYNOMIAL, UNIT_WEIGHTS)
    fit_row(workspace, HALF, HALF_POLYNOMIAL, UNIT_WEIGHTS)


@inlined
def _load_integral(workspace, end, angle, x):
    """Return the integral up to the time `x` of the load between an end (-1, 1) of the arc and an edge within it.

    angle : rad, of the edge, from the origin.
    """
    moment = evaluate_polynomial(workspace, MOMENT, x) - angle * evaluate_polynomial(workspace, PER_ARC, x)
    return x * (evaluate_polynomial(workspace, HALF_RATE, x) + end * moment)


@write_wear_before_passed_edges.member(UniformPressure)
def _write_wear_before_passed_edges_uniform(pressure, workspace, end, edge, width):
    end_time, first_angle = inside_time(workspace, end), edge - _origin(workspace)
    total_area = row_sum(workspace, AREA) if end > 0.0 else 0.0
    for k in lane_range(POINTS):
        angle = first_angle + INDICES[k] * width
        wear_inside = _load_integral(workspace, end, angle, end_time) - _load_integral(
            workspace, end, angle, workspace[PASSINGS * POINTS + k]
        )
        workspace[WORN * POINTS + k] = total_area - end * (end_time * wear_inside)


@wear_before_edge_in_span.member(UniformPressure)
def _wear_before_edge_in_span_uniform(pressure, workspace, edge, region, span):
    low, high = span
    if region < 0 or high <= low:
        return 0.0
    if region > 0:
        return 2.0 * (
            high * evaluate_polynomial(workspace, HALF_RATE, high)
            - low * evaluate_polynomial(workspace, HALF_RATE, low)
        )
    angle = edge - _origin(workspace)
    return _load_integral(workspace, -1.0, angle, high) - _load_integral(workspace, -1.0, angle, low)


@kernel
def _wear_before_inner_edge(workspace, edge):
    """Return the wear before an `edge` (rad) that is within the arc at all points, and its slope."""
    for i in lane_range(POINTS):
        per_arc = _per_arc(workspace, i)
        workspace[END * POINTS + i] = per_arc
        workspace[TIME_PER_ANGLE * POINTS + i] = per_arc * (edge - workspace[MIDDLE * POINTS + i])
    return 0.5 * row_sum(workspace, AREA) + row_sum(workspace, TIME_PER_ANGLE), row_sum(workspace, END)


@update_bins_inside_arc.member(UniformPressure)
def _update_bins_inside_arc_uniform(pressure, workspace, bins, span, cursor):
    """Every bin between two edges within the arc receives the same depth."""
    count, width, total = span[1] - span[0] - 1, 2.0 * math.pi / bins.count, row_sum(workspace, AREA)
    if count < 0:
        return cursor
    first_wear, slope = _wear_before_inner_edge(workspace, (span[0] + 1) * width)
    first_wear = min(max(first_wear, cursor.wear_before), total)
    last_wear = min(first_wear + slope * width * count, total)
    bins.depths[bins.start + cursor.position] += (first_wear - cursor.wear_before) / width
    position, depth = cursor.position, (last_wear - first_wear) / (width * max(count, 1))
    for _ in range(count):
        position = position + 1 if position + 1 < bins.count else 0
        bins.depths[bins.start + position] += depth
    return BinCursor(position + 1 if position + 1 < bins.count else 0, last_wear)
