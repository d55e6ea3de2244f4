"""The wear of an arc over a step, entered into the bins of a body.

The load of the arc before the edge of a bin is integrated over the step for every edge that the arc meets, see
`passage`.  The wear of a bin is the difference between its edges, hence the mean over the bin whatever its width.
"""

import math
from typing import NamedTuple

from ...compiled.choosing import abreast, rolled_range
from ...compiled.family import family, inlined, kernel
from ...observe.histogram import PARTS, SLIP_COURSE
from .contract import enter_span, share_before, smooth_within
from .passage import (
    AREA,
    BODY,
    FIRST,
    HALF,
    MIDDLE,
    NUMBERS,
    PER_HALF,
    POINTS,
    START,
    STOP,
    TERM,
    WORN,
    crossed,
    find_passing,
    fit_points,
    passed,
    reach_of,
    see_points,
    steady,
    summed,
)

SEVERAL = 2  # edges that one end passes: from this number on they are processed together


class Edges(NamedTuple):
    """Numbers of the last edges of a kind: passed at the start, near it, well within the arc, near its stop."""

    start: int
    near_start: int
    near_stop: int
    stop: int


class Entered(NamedTuple):
    """The state between two edges."""

    position: int  # of the bin behind the edge
    before: float  # m rad, worn before it


@kernel
def edges_of(pressure, workspace, width):
    """Return the number of the last edge before the arc, Edges, and the last edge met; `width` (rad) apart."""
    (first_edge, start), (stop_edge, last_edge) = reach_of(workspace, START), reach_of(workspace, STOP)
    passed_by_start, within_until = math.floor(start / width), math.floor(stop_edge / width)
    near_start, near_stop = passed_by_start, within_until
    if smooth_within(pressure) < 1.0:
        for i in abreast(POINTS):
            margin = (1.0 - smooth_within(pressure)) * workspace[HALF * POINTS + i]
            workspace[TERM * POINTS + i] = workspace[START * POINTS + i] + margin
            workspace[(TERM + 1) * POINTS + i] = workspace[STOP * POINTS + i] - margin
        near_start = math.floor(reach_of(workspace, TERM)[1] / width)
        near_stop = math.floor(reach_of(workspace, TERM + 1)[0] / width)
    edges = Edges(passed_by_start, near_start, near_stop, within_until)
    return math.floor(first_edge / width), edges, math.floor(last_edge / width)


@kernel
def worn_before(pressure, workspace, edge, edges, last_edge):
    """Write the wear before an edge that an end of the arc meets, and before those that follow, up to `last_edge`, to
    WORN; return their number.

    edges : Edges and their distance (rad).  Where the ends reverse or meet the same edges, each edge is processed
    alone.
    """
    kinds, width = edges
    angle = edge * width
    starting, stopping = edge <= kinds.start, edge > kinds.stop
    count = min(POINTS, (min(kinds.start, kinds.stop) if starting else last_edge) - edge + 1)
    is_single = starting == stopping or count < SEVERAL
    if is_single or not steady(workspace, START if starting else STOP):
        workspace[WORN * POINTS] = passed(pressure, workspace, angle)
        return 1
    end = -1.0 if starting else 1.0
    find_passing(workspace, end, angle, width)
    crossed(pressure, workspace, end, angle, width)
    return count


@inlined
def enter_edge(workspace, bins, number, total, at):
    """Add the wear between an edge, its wear in place `number` of WORN, and the one before; return the next Entered."""
    per_width = bins.count / (2.0 * math.pi)
    cumulative = min(max(workspace[WORN * POINTS + number], at.before), total)
    bins.depths[bins.first + at.position] += (cumulative - at.before) * per_width
    return Entered(at.position + 1 if at.position + 1 < bins.count else 0, cumulative)


@kernel
def enter_met(pressure, workspace, bins, span, edges, at):
    """Add the wear between edges that the ends of the arc meet, those of a `span` (begin, end); return the Entered."""
    known, entered, total = 0, 0, summed(workspace, AREA)
    for edge in range(span[0] + 1, span[1] + 1):
        if entered == known:
            known, entered = worn_before(pressure, workspace, edge, edges, span[1]), 0
        at = enter_edge(workspace, bins, entered, total, at)
        entered += 1
    return at


@family
def enter_within(pressure, workspace, bins, span, at):
    """Add the wear between edges that are within the arc at all points, those of a `span`; return the Entered."""


@enter_within.member(None)
def _default_enter_within(pressure, workspace, bins, span, at):
    width, known, entered, total = 2.0 * math.pi / bins.count, 0, 0, summed(workspace, AREA)
    for edge in range(span[0] + 1, span[1] + 1):
        if entered == known:
            within(pressure, workspace, edge * width, width)
            known, entered = POINTS, 0
        at = enter_edge(workspace, bins, entered, total, at)
        entered += 1
    return at


@kernel
def within(pressure, workspace, edge, width):
    """Write the wear before edges, `width` (rad) apart, that are within the arc at all points, to WORN."""
    for k in abreast(POINTS):
        angle, total = edge + NUMBERS[k] * width, 0.0
        for i in range(POINTS):
            x = (angle - workspace[MIDDLE * POINTS + i]) * workspace[PER_HALF * POINTS + i]
            total += workspace[AREA * POINTS + i] * share_before(pressure, x, workspace[HALF * POINTS + i])
        workspace[WORN * POINTS + k] = total


@kernel
def enter_part(pressure, workspace, bins):
    """Add the wear of the arc to a body, from the points in its workspace."""
    total = summed(workspace, AREA)
    if total <= 0.0:
        return
    width = 2.0 * math.pi / bins.count
    first_edge, edges, last_edge = edges_of(pressure, workspace, width)
    begin, end = edges.near_start, edges.near_stop  # between them the edges that are within the arc
    if end <= begin:
        begin, end = last_edge, last_edge
    if last_edge - first_edge > end - begin:
        fit_points(pressure, workspace)
    at = Entered(first_edge % bins.count, 0.0)
    at = enter_met(pressure, workspace, bins, (first_edge, begin), (edges, width), at)
    at = enter_within(pressure, workspace, bins, (begin, end), at)
    at = enter_met(pressure, workspace, bins, (end, last_edge), (edges, width), at)
    bins.depths[bins.first + at.position] += (total - at.before) * (bins.count / (2.0 * math.pi))


@enter_span.member(None)
def _default_enter_span(joint, workspace, length, span, bins):
    see_points(joint, workspace, length, span[0], span[1])
    for body in range(2):
        part = workspace[FIRST + body * BODY : FIRST + (body + 1) * BODY]
        enter_part(joint.wear.pressure, part, bins[body])


@kernel
def enter_wear(joint, workspace, values, length, bins):
    """Add the wear of bearing and journal over a step of `length`, in the unit of kappa.

    workspace : (ROOM,) with the coefficients over the share of the step; values : (COURSES, PARTS + 1), from which the
    sliding speed is read; bins : of both bodies.
    """
    low = 0.0
    for i in rolled_range(PARTS + 1):
        high = 1.0
        if i < PARTS:
            a, b = values[SLIP_COURSE, i], values[SLIP_COURSE, i + 1]
            if a * b >= 0.0:
                continue
            high = (i + a / (a - b)) / PARTS  # where sliding reverses, its speed has a kink
        enter_span(joint, workspace, length, (low, high), bins)
        low = high
