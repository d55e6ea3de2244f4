"""Wear under a uniform pressure, whose load before an edge is a linear function of the edge's angle.

The load before an edge at angle e is, while the edge is within an arc of middle m and half-angle h, the fraction
(1 + (e - m) / h) / 2 of the load.  Its integral over a part of the step is that of the polynomial through the nodes.
Many edges that one end passes share three antiderivatives, of rate / 2, rate (m - m0) / (2 h) and rate / (2 h).
"""

import math

from ...tracing.compiled.choosing import lane_range, rolled_range
from ...tracing.compiled.family import inlined, kernel
from .arc_over_step import (
    AREA,
    BASIS,
    BASIS_INTEGRAL,
    END,
    END_POLYNOMIAL,
    END_SLOPE,
    HALF,
    HALF_POLYNOMIAL,
    INDICES,
    INVERSE_WEIGHTS,
    MIDDLE,
    MIDDLE_POLYNOMIAL,
    NODE_TERM,
    NODES,
    PAIRS,
    PASSINGS,
    PER_HALF,
    POINTS,
    RATE,
    SMALLEST_HALF_ANGLE,
    SPACINGS,
    START,
    STOP,
    TERM,
    TIME_PER_ANGLE,
    UNIT_WEIGHTS,
    WORN,
    evaluate_columns,
    evaluate_polynomial,
    fit_arc,
    fit_row,
    inside_time,
    region_of,
    row_sum,
    unfitted_edges,
    wear_before_edge,
    write_wear_before_passed_edges,
)
from .binning import MIN_BATCH, BinCursor, update_bins_inside_arc
from .pressure import UniformPressure

#: Rows of the antiderivatives over the time x, each over x: of rate / 2, rate (m - m0) / (2 h), rate / (2 h).
HALF_RATE, MOMENT, PER_ARC = RATE, TERM, TERM + 1
MAX_PER_HALF = 1e7  # 1/rad: in a narrower arc there is no load, and rounding must not be magnified
#: Estimates of the time at which an end of the arc passes an edge: their largest number; change from which on another
#: one follows.
MAX_ESTIMATES, CLOSE_ESTIMATE = 8, 2e-3
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


@inlined
def _distance_and_load(workspace, edge, row, t):
    """Return the distance (rad) of an edge from an end of the arc, a row, at time t, and the load between until t."""
    for k in lane_range(POINTS):
        distance = edge - workspace[row * POINTS + k]
        workspace[NODE_TERM * POINTS + k] = evaluate_columns(BASIS, t, k) * distance
        workspace[(NODE_TERM + 1) * POINTS + k] = (
            evaluate_columns(BASIS_INTEGRAL, t, k) * _per_arc(workspace, k) * distance
        )
    return row_sum(workspace, NODE_TERM), (1.0 + t) * row_sum(workspace, NODE_TERM + 1)


@kernel
def _load_until_passing(workspace, edge, end, i):
    """Return the integral of the load between an end (-1, 1) of the arc and an edge, until the end passes the edge.

    The end passes between nodes `i - 1` and `i`.  The first estimate of the time is linear, each next one takes the
    slope of the parabola through three distances.  The load between the last two estimates is that of a triangle.
    """
    row, low, high = START if end < 0 else STOP, NODES[i - 1], NODES[i]
    a, b = edge - workspace[row * POINTS + i - 1], edge - workspace[row * POINTS + i]
    t, mean_slope = low if a == b else (low * b - high * a) / (b - a), (b - a) / SPACINGS[i]
    load, attempts = 0.0, 0
    while attempts < MAX_ESTIMATES:
        distance, load = _distance_and_load(workspace, edge, row, t)
        before, behind = t - low, high - t
        product, bend = before * behind, distance - a - mean_slope * before
        slope = mean_slope * product + bend * (behind - before)  # of the parabola, times the product
        correction = distance * product * slope / (slope * slope + SMALLEST_HALF_ANGLE)
        correction = min(max(correction, -behind), before)
        load -= 0.5 * _per_arc(workspace, i) * INVERSE_WEIGHTS[i] * distance * correction
        t -= correction
        attempts = attempts + 1 if abs(correction) > CLOSE_ESTIMATE else MAX_ESTIMATES
    return -end * load


@wear_before_edge.member(UniformPressure)
def _wear_before_edge_uniform(pressure, workspace, edge):
    """Return the wear as if the edge stayed in the region of the last node, minus what differs before each passing."""
    region, difference = region_of(workspace, edge, 0), 0.0
    for i in rolled_range(1, POINTS):
        next_region = region_of(workspace, edge, i)
        while region != next_region:
            end = region if region != 0 else next_region  # the end of the arc that passes the edge
            direction = 1.0 if next_region > region else -1.0
            difference += direction * _load_until_passing(workspace, edge, end, i)
            region = 0 if region != 0 else next_region
    if region < 0:
        return -difference
    if region > 0:
        return row_sum(workspace, AREA) - difference
    for i in lane_range(POINTS):
        workspace[NODE_TERM * POINTS + i] = _per_arc(workspace, i) * (edge - workspace[START * POINTS + i])
    return row_sum(workspace, NODE_TERM) - difference


@unfitted_edges.member(UniformPressure)
def _unfitted_edges_uniform(pressure):
    return MIN_BATCH - 1


@kernel
def _wear_before_inner_edge(workspace, edge, total):
    """Return the wear, of a `total`, before an `edge` (rad) that is within the arc at all points, and its slope."""
    for i in lane_range(POINTS):
        per_arc = _per_arc(workspace, i)
        workspace[END * POINTS + i] = per_arc
        workspace[TIME_PER_ANGLE * POINTS + i] = per_arc * (edge - workspace[MIDDLE * POINTS + i])
    return 0.5 * total + row_sum(workspace, TIME_PER_ANGLE), row_sum(workspace, END)


@update_bins_inside_arc.member(UniformPressure)
def _update_bins_inside_arc_uniform(pressure, workspace, bins, span, cursor):
    """Every bin between two edges within the arc receives the same depth."""
    count, width, total = span[1] - span[0] - 1, 2.0 * math.pi / bins.count, cursor.total
    if count < 0:
        return cursor
    first_wear, slope = _wear_before_inner_edge(workspace, (span[0] + 1) * width, total)
    first_wear = min(max(first_wear, cursor.wear_before), total)
    last_wear = min(first_wear + slope * width * count, total)
    bins.depths[bins.start + cursor.position] += (first_wear - cursor.wear_before) / width
    depth, next_position = (last_wear - first_wear) / (width * max(count, 1)), cursor.position + 1
    count_to_end = min(count, bins.count - next_position)
    _add_depth(bins, next_position, count_to_end, depth)
    _add_depth(bins, 0, count - count_to_end, depth)
    position = next_position + count
    return BinCursor(position if position < bins.count else position - bins.count, last_wear, total)


@inlined
def _add_depth(bins, first_bin, count, depth):
    """Add a depth (m) to `count` bins that follow each other."""
    for k in rolled_range(count):
        bins.depths[bins.start + first_bin + k] += depth
