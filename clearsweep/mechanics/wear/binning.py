"""Adds the wear of an arc over a step to the bins of a body.

The load of the arc before the edge of a bin is integrated over the step for every edge that the arc meets, see
`arc_over_step`.  The wear of a bin is the difference between its edges, hence the mean over the bin whatever its width.
"""

import math
from typing import NamedTuple

from ...tracing.compiled.choosing import lane_range, rolled_range
from ...tracing.compiled.family import family, inlined, kernel
from ..observe import PARTS, SLIP_ROW
from .account import account_span
from .arc_over_step import (
    AREA,
    BODY_SIZE,
    DURATION_ROW,
    FIRST_BODY,
    HALF,
    INDICES,
    MIDDLE,
    PER_HALF,
    POINTS,
    START,
    STOP,
    TERM,
    WORN,
    evaluate_arc,
    fit_arc,
    is_monotonic,
    range_of_row,
    row_sum,
    unfitted_edges,
    wear_before_edge,
    write_passing_times,
    write_wear_before_passed_edges,
)
from .contract import cumulative_pressure, smooth_range, update_wear_over_span

MIN_BATCH = 2  # edges that one end passes: from this number on they are processed together


class Edges(NamedTuple):
    """Numbers of the last edges of each kind: passed by the arc's start, near it, within the arc, near its stop."""

    start: int
    near_start: int
    near_stop: int
    stop: int


class BinCursor(NamedTuple):
    """The bin that follows an edge, the wear before that edge, and the wear of the whole arc."""

    position: int  # of the bin behind the edge
    wear_before: float  # m rad
    total: float  # m rad


@kernel
def edges_of(pressure, workspace, width):
    """Return the number of the last edge before the arc, Edges, and the last edge met; `width` (rad) apart."""
    (first_edge, start), (stop_edge, last_edge) = range_of_row(workspace, START), range_of_row(workspace, STOP)
    passed_by_start, passed_by_stop = math.floor(start / width), math.floor(stop_edge / width)
    near_start, near_stop = passed_by_start, passed_by_stop
    if smooth_range(pressure) < 1.0:
        for i in lane_range(POINTS):
            margin = (1.0 - smooth_range(pressure)) * workspace[HALF * POINTS + i]
            workspace[TERM * POINTS + i] = workspace[START * POINTS + i] + margin
            workspace[(TERM + 1) * POINTS + i] = workspace[STOP * POINTS + i] - margin
        near_start = math.floor(range_of_row(workspace, TERM)[1] / width)
        near_stop = math.floor(range_of_row(workspace, TERM + 1)[0] / width)
    edges = Edges(passed_by_start, near_start, near_stop, passed_by_stop)
    return math.floor(first_edge / width), edges, math.floor(last_edge / width)


@kernel
def write_wear_before_edges(pressure, workspace, edge, edges, last_edge):
    """Write the wear before an edge that an end of the arc meets, and following ones, to WORN; return their number.

    last_edge : the last edge to process; edges : Edges and their distance (rad).  Where the ends reverse or meet the
    same edges, each edge is processed alone.
    """
    last_edges, width = edges
    angle = edge * width
    is_start_end, is_stop_end = edge <= last_edges.start, edge > last_edges.stop
    count = min(POINTS, (min(last_edges.start, last_edges.stop) if is_start_end else last_edge) - edge + 1)
    is_single = is_start_end == is_stop_end or count < MIN_BATCH
    if is_single or not is_monotonic(workspace, START if is_start_end else STOP):
        workspace[WORN * POINTS] = wear_before_edge(pressure, workspace, angle)
        return 1
    end = -1.0 if is_start_end else 1.0
    write_passing_times(workspace, end, angle, width)
    write_wear_before_passed_edges(pressure, workspace, end, angle, width)
    return count


@inlined
def update_wear_bin(workspace, bins, number, cursor):
    """Add the wear between an edge, item `number` of WORN, and the previous one to a bin; return the next BinCursor."""
    bins_per_radian = bins.count / (2.0 * math.pi)
    cumulative = min(max(workspace[WORN * POINTS + number], cursor.wear_before), cursor.total)
    bins.depths[bins.start + cursor.position] += (cumulative - cursor.wear_before) * bins_per_radian
    return BinCursor(cursor.position + 1 if cursor.position + 1 < bins.count else 0, cumulative, cursor.total)


@kernel
def update_bins_at_arc_ends(pressure, workspace, bins, span, edges, cursor):
    """Add the wear between the edges of a `span` (begin, end), which the arc's ends meet; return the next BinCursor."""
    batch_size, index_in_batch = 0, 0
    for edge in range(span[0] + 1, span[1] + 1):
        if index_in_batch == batch_size:
            batch_size, index_in_batch = write_wear_before_edges(pressure, workspace, edge, edges, span[1]), 0
        cursor = update_wear_bin(workspace, bins, index_in_batch, cursor)
        index_in_batch += 1
    return cursor


@family
def update_bins_inside_arc(pressure, workspace, bins, span, cursor):
    """Add the wear between the edges of a `span`, within the arc at all points; return the next BinCursor."""


@update_bins_inside_arc.member(None)
def _default_update_bins_inside_arc(pressure, workspace, bins, span, cursor):
    width, batch_size, index_in_batch = 2.0 * math.pi / bins.count, 0, 0
    for edge in range(span[0] + 1, span[1] + 1):
        if index_in_batch == batch_size:
            write_wear_before_inner_edges(pressure, workspace, edge * width, width)
            batch_size, index_in_batch = POINTS, 0
        cursor = update_wear_bin(workspace, bins, index_in_batch, cursor)
        index_in_batch += 1
    return cursor


@kernel
def write_wear_before_inner_edges(pressure, workspace, edge, width):
    """Write the wear before edges, `width` (rad) apart, that are within the arc at all points, to WORN."""
    for k in lane_range(POINTS):
        angle, total = edge + INDICES[k] * width, 0.0
        for i in range(POINTS):
            x = (angle - workspace[MIDDLE * POINTS + i]) * workspace[PER_HALF * POINTS + i]
            total += workspace[AREA * POINTS + i] * cumulative_pressure(pressure, x, workspace[HALF * POINTS + i])
        workspace[WORN * POINTS + k] = total


@kernel
def update_body_wear(pressure, workspace, bins):
    """Add the wear of the arc to a body, from the points in its workspace."""
    total = row_sum(workspace, AREA)
    if total <= 0.0:
        return
    width = 2.0 * math.pi / bins.count
    first_edge, edges, last_edge = edges_of(pressure, workspace, width)
    begin, end = edges.near_start, edges.near_stop  # between them the edges that are within the arc
    if end <= begin:
        begin, end = last_edge, last_edge
    if max(begin - first_edge, last_edge - end) > unfitted_edges(pressure):
        fit_arc(pressure, workspace)
    cursor = BinCursor(first_edge % bins.count, 0.0, total)
    cursor = update_bins_at_arc_ends(pressure, workspace, bins, (first_edge, begin), (edges, width), cursor)
    cursor = update_bins_inside_arc(pressure, workspace, bins, (begin, end), cursor)
    cursor = update_bins_at_arc_ends(pressure, workspace, bins, (end, last_edge), (edges, width), cursor)
    bins.depths[bins.start + cursor.position] += (total - cursor.wear_before) * (bins.count / (2.0 * math.pi))


@kernel
def update_wear_over_arc(joint, workspace, step_length, span, bins):
    """Do what `update_wear_over_span` says, under an arc whose middle is the point of contact."""
    evaluate_arc(joint, workspace, step_length, span[0], span[1])
    for body in range(2):
        body_workspace = workspace[FIRST_BODY + body * BODY_SIZE : FIRST_BODY + (body + 1) * BODY_SIZE]
        update_body_wear(joint.wear.pressure, body_workspace, bins[body])


@update_wear_over_span.member(None)
def _default_update_wear_over_span(joint, workspace, step_length, span, bins):
    update_wear_over_arc(joint, workspace, step_length, span, bins)


@kernel
def update_worn_profile(joint, workspace, values, step_length, bins, account):
    """Add the wear of a step of `step_length` (s over kappa) to the worn profiles of both bodies and a JointAccount.

    workspace : (WORKSPACE_SIZE,) with the coefficients over the fraction of the step; values : (STEP_VALUE_ROWS, PARTS
    + 1), from which the sliding speed is read; bins : of both bodies.
    """
    for i in lane_range(PARTS):  # the row of the durations is free until a span is added
        workspace[DURATION_ROW * POINTS + i] = values[SLIP_ROW, i] * values[SLIP_ROW, i + 1]
    low, reverses = 0.0, range_of_row(workspace, DURATION_ROW)[0] < 0.0
    for i in rolled_range(0 if reverses else PARTS, PARTS + 1):
        high = 1.0
        if i < PARTS:
            a, b = values[SLIP_ROW, i], values[SLIP_ROW, i + 1]
            if a * b >= 0.0:
                continue
            high = (i + a / (a - b)) / PARTS  # where sliding reverses, its speed has a kink
        update_wear_over_span(joint, workspace, step_length, (low, high), bins)
        account_span(joint, workspace, account.numbers, account.length_fraction)
        low = high
