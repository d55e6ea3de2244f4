"""Wear over a step of the motion, spread over angular bins in each body's own frame.

The load of the arc before the edge of a bin is integrated over the step for every edge that the arc meets, see `arc`.
The wear of a bin is the difference between its edges, hence the mean over the bin whatever its width.

Under a uniform pressure the load before an edge is a linear function of the edge's angle.  While an edge at angle e is
within an arc of middle m and half-angle h, the load before it is the fraction (1 + (e - m) / h) / 2.  Its integral over
a part of the step is that of the polynomial through the nodes.  Many edges that one end passes share three
antiderivatives, of rate / 2, rate (m - m0) / (2 h) and rate / (2 h).
"""

import math
from typing import NamedTuple

import numpy as np

from ...tracing.compiled.choosing import lane_range, rolled_range
from ...tracing.compiled.family import family_with_default, inlined, kernel
from ...tracing.memory import Rows
from ...tracing.portable import exact, inverse
from .. import observe
from ..laws.contract import touches
from . import (
    Account,
    Bins,
    JointAccount,
    NoWear,
    arc,
    contact_angle,
    cumulative_pressure,
    smooth_range,
    update_wear_over_span,
)
from .laws import UniformPressure

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
def edges_of(pressure, rows, width):
    """Return the number of the last edge before the arc, Edges, and the last edge met; `width` (rad) apart."""
    (first_edge, start), (stop_edge, last_edge) = arc.range_of_row(rows.start), arc.range_of_row(rows.stop)
    passed_by_start, passed_by_stop = math.floor(start / width), math.floor(stop_edge / width)
    near_start, near_stop = passed_by_start, passed_by_stop
    if smooth_range(pressure) < 1.0:
        for i in lane_range(arc.POINTS):
            margin = (1.0 - smooth_range(pressure)) * rows.half[i]
            rows.term[i] = rows.start[i] + margin
            rows.second_term[i] = rows.stop[i] - margin
        near_start = math.floor(arc.range_of_row(rows.term)[1] / width)
        near_stop = math.floor(arc.range_of_row(rows.second_term)[0] / width)
    edges = Edges(passed_by_start, near_start, near_stop, passed_by_stop)
    return math.floor(first_edge / width), edges, math.floor(last_edge / width)


@kernel
def write_wear_before_edges(pressure, rows, edge, edges, last_edge):
    """Write the wear before an edge that an end of the arc meets, and following ones, to `worn`; return their number.

    last_edge : the last edge to process; edges : Edges and their distance (rad).  Where the ends reverse or meet the
    same edges, each edge is processed alone.
    """
    last_edges, width = edges
    angle = edge * width
    is_start_end, is_stop_end = edge <= last_edges.start, edge > last_edges.stop
    count = min(arc.POINTS, (min(last_edges.start, last_edges.stop) if is_start_end else last_edge) - edge + 1)
    is_single = is_start_end == is_stop_end or count < MIN_BATCH
    if is_single or not arc.is_monotonic(arc.end_row(rows, -1.0 if is_start_end else 1.0)):
        rows.worn[0] = arc.wear_before_edge(pressure, rows, angle)
        return 1
    end = -1.0 if is_start_end else 1.0
    arc.write_passing_times(rows, end, angle, width)
    arc.write_wear_before_passed_edges(pressure, rows, end, angle, width)
    return count


@inlined
def update_wear_bin(rows, bins, number, cursor):
    """Add the wear between an edge, item `number` of `worn`, and the previous one to a bin; return the BinCursor."""
    bins_per_radian = bins.count / (2.0 * math.pi)
    cumulative = min(max(rows.worn[number], cursor.wear_before), cursor.total)
    bins.depths[bins.start + cursor.position] += (cumulative - cursor.wear_before) * bins_per_radian
    return BinCursor(cursor.position + 1 if cursor.position + 1 < bins.count else 0, cumulative, cursor.total)


@kernel
def update_bins_at_arc_ends(pressure, rows, bins, span, edges, cursor):
    """Add the wear between the edges of a `span` (begin, end), which the arc's ends meet; return the next BinCursor."""
    batch_size, index_in_batch = 0, 0
    for edge in range(span[0] + 1, span[1] + 1):
        if index_in_batch == batch_size:
            batch_size, index_in_batch = write_wear_before_edges(pressure, rows, edge, edges, span[1]), 0
        cursor = update_wear_bin(rows, bins, index_in_batch, cursor)
        index_in_batch += 1
    return cursor


@family_with_default
def update_bins_inside_arc(pressure, rows, bins, span, cursor):
    """Add the wear between the edges of a `span`, within the arc at all points; return the next BinCursor."""
    width, batch_size, index_in_batch = 2.0 * math.pi / bins.count, 0, 0
    for edge in range(span[0] + 1, span[1] + 1):
        if index_in_batch == batch_size:
            write_wear_before_inner_edges(pressure, rows, edge * width, width)
            batch_size, index_in_batch = arc.POINTS, 0
        cursor = update_wear_bin(rows, bins, index_in_batch, cursor)
        index_in_batch += 1
    return cursor


@kernel
def write_wear_before_inner_edges(pressure, rows, edge, width):
    """Write the wear before edges, `width` (rad) apart, that are within the arc at all points, to `worn`."""
    for k in lane_range(arc.POINTS):
        angle, total = edge + arc.INDICES[k] * width, 0.0
        for i in range(arc.POINTS):
            x = (angle - rows.middle[i]) * rows.per_half[i]
            total += rows.area[i] * cumulative_pressure(pressure, x, rows.half[i])
        rows.worn[k] = total


@kernel
def update_body_wear(pressure, rows, bins):
    """Add the wear of the arc to a body, from the points in its rows."""
    total = arc.row_sum(rows.area)
    if total <= 0.0:
        return
    width = 2.0 * math.pi / bins.count
    first_edge, edges, last_edge = edges_of(pressure, rows, width)
    begin, end = edges.near_start, edges.near_stop  # between them the edges that are within the arc
    if end <= begin:
        begin, end = last_edge, last_edge
    if max(begin - first_edge, last_edge - end) > arc.unfitted_edges(pressure):
        arc.fit_arc(pressure, rows)
    cursor = BinCursor(first_edge % bins.count, 0.0, total)
    cursor = update_bins_at_arc_ends(pressure, rows, bins, (first_edge, begin), (edges, width), cursor)
    cursor = update_bins_inside_arc(pressure, rows, bins, (begin, end), cursor)
    cursor = update_bins_at_arc_ends(pressure, rows, bins, (end, last_edge), (edges, width), cursor)
    bins.depths[bins.start + cursor.position] += (total - cursor.wear_before) * (bins.count / (2.0 * math.pi))


@kernel
def update_wear_over_arc(joint, workspace, step_length, span, bins):
    """Do what `update_wear_over_span` says, under an arc whose middle is the point of contact."""
    arc.evaluate_arc(joint, workspace, step_length, span[0], span[1])
    update_body_wear(joint.wear.pressure, workspace.bearing, bins[0])
    update_body_wear(joint.wear.pressure, workspace.journal, bins[1])


@update_wear_over_span.member(None)
def _default_update_wear_over_span(joint, workspace, step_length, span, bins):
    update_wear_over_arc(joint, workspace, step_length, span, bins)


@inlined
def is_reversing(workspace, values):
    """Return whether sliding reverses within a step; to be called before a span of it is added."""
    for i in lane_range(observe.PARTS):  # the row of the durations is free until a span is added
        workspace.step.duration[i] = values[observe.SLIP_ROW, i] * values[observe.SLIP_ROW, i + 1]
    return arc.range_of_row(workspace.step.duration)[0] < 0.0


@inlined
def worn_bins(rows, count, reverses):
    """Return the parts (begin, end) of `count` bins within which the latest span added wear; all of a step in spans."""
    width = 2.0 * math.pi / count
    low, high = math.floor(arc.range_of_row(rows.start)[0] / width), math.floor(arc.range_of_row(rows.stop)[1] / width)
    first, number = (0, count) if reverses or high - low + 1 >= count else (low % count, high - low + 1)
    to_end = min(number, count - first)
    return (first, first + to_end), (0, number - to_end)


@kernel
def update_worn_profile(joint, workspace, values, step_length, bins, account):
    """Add the wear of a step of `step_length` (s over kappa) to the worn profiles of both bodies and a JointAccount.

    workspace : Workspace with the coefficients over the fraction of the step; values : (STEP_VALUE_ROWS, PARTS
    + 1), from which the sliding speed is read; bins : of both bodies.
    """
    low, reverses = 0.0, is_reversing(workspace, values)
    for i in rolled_range(0 if reverses else observe.PARTS, observe.PARTS + 1):
        high = 1.0
        if i < observe.PARTS:
            a, b = values[observe.SLIP_ROW, i], values[observe.SLIP_ROW, i + 1]
            if a * b >= 0.0:
                continue
            high = (i + a / (a - b)) / observe.PARTS  # where sliding reverses, its speed has a kink
        update_wear_over_span(joint, workspace, step_length, (low, high), bins)
        arc.account_span(joint, workspace, account.sums, account.length_fraction)
        low = high


# ---------------------------------------------------------------------------------------------- uniform pressure


MAX_PER_HALF = 1e7  # 1/rad: in a narrower arc there is no load, and rounding must not be magnified
#: Estimates of the time at which an end of the arc passes an edge: their largest number; change from which on another
#: one follows.
MAX_ESTIMATES, CLOSE_ESTIMATE = 8, 2e-3
PER_POWER = 1.0 / (1.0 + arc.INDICES)  # from the coefficients of a polynomial to those of its antiderivative over x


@inlined
def _origin(rows):
    """Return the angle m0 (rad) that is subtracted from all angles, since the angle of a rotating body may be large."""
    return rows.middle[arc.PAIRS]


@inlined
def _per_arc(rows, i):
    """Return half the wear at a point over the half-angle of the arc (m)."""
    return 0.5 * rows.area[i] * min(rows.per_half[i], MAX_PER_HALF)


@arc.fit_arc.member(UniformPressure)
def _fit_arc_uniform(pressure, rows):
    """Write antiderivatives over the time x, each over x: of rate / 2, rate (m - m0) / (2 h) and rate / (2 h)."""
    origin = _origin(rows)
    for i in lane_range(arc.POINTS):  # the rows of an end are free until `write_passing_times`
        half_rate, per_arc = 0.5 * rows.area[i], _per_arc(rows, i)
        rows.end[i], rows.end_slope[i] = half_rate, per_arc
        rows.end_polynomial[i] = per_arc * (rows.middle[i] - origin)
    arc.fit_row(rows.end, rows.rate, arc.INVERSE_WEIGHTS)
    arc.fit_row(rows.end_polynomial, rows.term, arc.INVERSE_WEIGHTS)
    arc.fit_row(rows.end_slope, rows.second_term, arc.INVERSE_WEIGHTS)
    for i in lane_range(arc.POINTS):
        rows.rate[i] *= PER_POWER[i]
        rows.term[i] *= PER_POWER[i]
        rows.second_term[i] *= PER_POWER[i]
    arc.fit_row(rows.middle, rows.middle_polynomial, arc.UNIT_WEIGHTS)
    arc.fit_row(rows.half, rows.half_polynomial, arc.UNIT_WEIGHTS)


@inlined
def _load_integral(rows, end, angle, x):
    """Return the integral up to the time `x` of the load between an end (-1, 1) of the arc and an edge within it.

    angle : rad, of the edge, from the origin.
    """
    moment = arc.evaluate_polynomial(rows.term, x) - angle * arc.evaluate_polynomial(rows.second_term, x)
    return x * (arc.evaluate_polynomial(rows.rate, x) + end * moment)


@arc.write_wear_before_passed_edges.member(UniformPressure)
def _write_wear_before_passed_edges_uniform(pressure, rows, end, edge, width):
    end_time, first_angle = arc.inside_time(rows, end), edge - _origin(rows)
    total_area = arc.row_sum(rows.area) if end > 0.0 else 0.0
    for k in lane_range(arc.POINTS):
        angle = first_angle + arc.INDICES[k] * width
        wear_inside = _load_integral(rows, end, angle, end_time) - _load_integral(rows, end, angle, rows.passings[k])
        rows.worn[k] = total_area - end * (end_time * wear_inside)


@inlined
def _distance_and_load(rows, edge, angles, t):
    """Return the distance (rad) of an edge from an end of the arc at time t, and the load between until t."""
    for k in lane_range(arc.POINTS):
        distance = edge - angles[k]
        rows.node_term[k] = arc.evaluate_columns(arc.BASIS, t, k) * distance
        rows.second_node_term[k] = arc.evaluate_columns(arc.BASIS_INTEGRAL, t, k) * _per_arc(rows, k) * distance
    return arc.row_sum(rows.node_term), (1.0 + t) * arc.row_sum(rows.second_node_term)


@kernel
def _load_until_passing(rows, edge, end, i):
    """Return the integral of the load between an end (-1, 1) of the arc and an edge, until the end passes the edge.

    The end passes between nodes `i - 1` and `i`.  The first estimate of the time is linear, each next one takes the
    slope of the parabola through three distances.  The load between the last two estimates is that of a triangle.
    """
    angles, low, high = arc.end_row(rows, end), arc.NODES[i - 1], arc.NODES[i]
    a, b = edge - angles[i - 1], edge - angles[i]
    t, mean_slope = low if a == b else (low * b - high * a) / (b - a), (b - a) / arc.SPACINGS[i]
    load, attempts = 0.0, 0
    while attempts < MAX_ESTIMATES:
        distance, load = _distance_and_load(rows, edge, angles, t)
        before, behind = t - low, high - t
        product, bend = before * behind, distance - a - mean_slope * before
        slope = mean_slope * product + bend * (behind - before)  # of the parabola, times the product
        correction = distance * product * slope / (slope * slope + arc.SMALLEST_HALF_ANGLE)
        correction = min(max(correction, -behind), before)
        load -= 0.5 * _per_arc(rows, i) * arc.INVERSE_WEIGHTS[i] * distance * correction
        t -= correction
        attempts = attempts + 1 if abs(correction) > CLOSE_ESTIMATE else MAX_ESTIMATES
    return -end * load


@arc.wear_before_edge.member(UniformPressure)
def _wear_before_edge_uniform(pressure, rows, edge):
    """Return the wear as if the edge stayed in the region of the last node, minus what differs before each passing."""
    region, difference = arc.region_of(rows, edge, 0), 0.0
    for i in rolled_range(1, arc.POINTS):
        next_region = arc.region_of(rows, edge, i)
        while region != next_region:
            end = region if region != 0 else next_region  # the end of the arc that passes the edge
            direction = 1.0 if next_region > region else -1.0
            difference += direction * _load_until_passing(rows, edge, end, i)
            region = 0 if region != 0 else next_region
    if region < 0:
        return -difference
    if region > 0:
        return arc.row_sum(rows.area) - difference
    for i in lane_range(arc.POINTS):
        rows.node_term[i] = _per_arc(rows, i) * (edge - rows.start[i])
    return arc.row_sum(rows.node_term) - difference


arc.unfitted_edges.member(UniformPressure)(lambda pressure: MIN_BATCH - 1)


@kernel
def _wear_before_inner_edge(rows, edge, total):
    """Return the wear, of a `total`, before an `edge` (rad) that is within the arc at all points, and its slope."""
    for i in lane_range(arc.POINTS):
        per_arc = _per_arc(rows, i)
        rows.end[i] = per_arc
        rows.time_per_angle[i] = per_arc * (edge - rows.middle[i])
    return 0.5 * total + arc.row_sum(rows.time_per_angle), arc.row_sum(rows.end)


@update_bins_inside_arc.member(UniformPressure)
def _update_bins_inside_arc_uniform(pressure, rows, bins, span, cursor):
    """Every bin between two edges within the arc receives the same depth."""
    count, width, total = span[1] - span[0] - 1, 2.0 * math.pi / bins.count, cursor.total
    if count < 0:
        return cursor
    first_wear, slope = _wear_before_inner_edge(rows, (span[0] + 1) * width, total)
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


# ---------------------------------------------------------------------------------------------- a step


ANGLES = (
    observe.QUARTER_POINTS + 4
)  # numbers that determine the profile of an angle: at the quarters, then its slopes at both ends
POSITIONS = 3  # such profiles of a contact: its angles on both bodies (rad) and, of worn surfaces, its depth (m)
SLOPES = POSITIONS  # of these profiles, per fraction of the step; `record` writes the rates per second
_FIRST_POSITION = arc.StepRows.index_of("bearing_angle")  # row of the workspace
_QUARTERS = np.arange(observe.QUARTER_POINTS + 2) / (observe.QUARTER_POINTS + 1)
#: (ANGLES, POINTS): the coefficients of an angle's profile from its values at the quarters and its end slopes.
FROM_ANGLES = np.zeros((ANGLES, arc.POINTS))
_AT_QUARTERS = [[quarter**i for i in range(arc.DEGREE + 1)] for quarter in _QUARTERS.tolist()]
_AT_ENDS = [[float(i == 1) for i in range(arc.DEGREE + 1)], [float(i) for i in range(arc.DEGREE + 1)]]
FROM_ANGLES[:, : arc.DEGREE + 1] = inverse(exact(_AT_QUARTERS + _AT_ENDS)).transposed.rounded()


class AxialRows(Rows):
    """What a joint in space notes of a contact at the quarters, see `strips.StripPosition`."""

    lean: float  # 1
    reach: float  # m
    tilt_square: float  # 1
    bearing_start: float  # m
    journal_start: float  # m
    facing: float  # 1


class StripRows(Rows):
    """The strip of one contact at equidistant times."""

    lean: float  # 1
    reach: float  # m
    tilt_square: float  # 1
    max_depth: float  # m, the largest along it
    load_integral: float  # see `strips.integrals_of`
    depth_integral: float  # m^2


RECORDED_SIZE = (POSITIONS + SLOPES + AxialRows.SIZE) * observe.STATE_POINTS  # numbers stored per contact
BUFFER_ROWS = 7  # of the wear buffer, each as long as the bins of a body: two of bins, the others for slices


class Step(NamedTuple):
    """Profiles and positions of the contacts over a step of the motion, and workspaces."""

    step_values: np.ndarray  # (contacts, STEP_VALUE_ROWS, PARTS + 1) see observe.histogram
    length: float  # of the step
    mode: np.ndarray  # (contacts,) int64, mode of each contact
    positions: np.ndarray  # (contacts, POSITIONS + SLOPES, STATE_POINTS)
    axial: AxialRows  # (contacts,) of joints in space
    strip: StripRows  # of one of their contacts
    workspace: arc.Workspace
    wear_buffer: np.ndarray  # (BUFFER_ROWS stride,) bins (m) of both bodies, at 0 between the contacts; then slices


class WearTotals(NamedTuple):
    """Wear of all joints, to which each step adds; the depths of a joint are at its first contact."""

    depths: np.ndarray  # (2 contacts stride,) m, the bins of bearing and journal
    stride: int
    account: Account  # (contacts,)


class Instant(NamedTuple):
    """Positions of the bodies at one time of a step."""

    gaps: tuple  # a gap per joint
    body_angles: tuple  # body_angles of every joint
    number: int
    step: Step


@family_with_default
def record(joint, gap, body_angles, j, instant):
    """Record the positions of a joint's contacts, the first being `j`, at an Instant; body_angles : (2,) rad."""
    step, i = instant.step, instant.number
    if not touches(step.mode[j]):
        return
    side = joint.side
    angle, angle_rate, depth, depth_rate = contact_angle(joint, gap)
    proximal_angle, distal_angle = body_angles
    bearing_angle, journal_angle = (proximal_angle, distal_angle) if side > 0.0 else (distal_angle, proximal_angle)
    step.positions[j, 0, i] = angle - bearing_angle
    step.positions[j, 1, i] = angle - journal_angle
    step.positions[j, 2, i] = depth
    proximal_rate, distal_rate = angle_rate - gap.spin_proximal, angle_rate - gap.spin_distal
    step.positions[j, SLOPES, i] = proximal_rate if side > 0.0 else distal_rate
    step.positions[j, SLOPES + 1, i] = distal_rate if side > 0.0 else proximal_rate
    step.positions[j, SLOPES + 2, i] = depth_rate


@kernel
def fit_profiles(workspace, step_values, length):
    """Write the coefficients of the profiles of a contact, its forces per `length` (m), to `workspace`."""
    per_length = 1.0 / length
    for i in lane_range(arc.POINTS):
        for row in range(observe.STEP_VALUE_ROWS):
            total = 0.0
            for k in range(observe.PARTS + 1):
                total += arc.FIT[k, i] * step_values[row, k]
            workspace.step.numbers[row, i] = (
                total * per_length if row in (observe.FORCE_ROW, observe.FRICTION_POWER_ROW) else total
            )


@kernel
def unwrap_angles(angles):
    """Remove jumps by full turns from angles (rad) at the quarters of a step."""
    full_turn, turns, previous_angle, largest_change = 2.0 * math.pi, 0.0, angles[0], 0.0
    for i in range(1, observe.QUARTER_POINTS + 2):
        largest_change = max(largest_change, abs(angles[i] - angles[i - 1]))
    if largest_change <= math.pi:
        return
    for i in range(1, observe.QUARTER_POINTS + 2):
        angle = angles[i]
        turns += math.floor((angle - previous_angle) * (1.0 / full_turn) + 0.5)
        angles[i], previous_angle = angle - full_turn * turns, angle


@kernel
def fit_positions(workspace, positions):
    """Write the coefficients of the profiles of the position of a contact to `workspace`."""
    for i in lane_range(arc.POINTS):
        for row in range(POSITIONS):
            total = 0.0
            for k in range(observe.QUARTER_POINTS + 2):
                total += FROM_ANGLES[k, i] * positions[row, k]
            total += FROM_ANGLES[ANGLES - 2, i] * positions[SLOPES + row, 0]
            total += FROM_ANGLES[ANGLES - 1, i] * positions[SLOPES + row, observe.QUARTER_POINTS + 1]
            workspace.step.numbers[_FIRST_POSITION + row, i] = total


@family_with_default
def update_contact_wear(law, joint, j, step_and_totals):
    """Add the wear of contact `j` of a joint with this wear law, over a Step; step_and_totals : Step and WearTotals."""
    step, totals = step_and_totals
    fit_profiles(step.workspace, step.step_values[j], law.length)
    for body in range(2):
        unwrap_angles(step.positions[j, body])
    for end, part_index in ((0, 0), (observe.QUARTER_POINTS + 1, observe.PARTS)):  # slopes from rates per second
        duration = step.length * step.step_values[j, observe.KAPPA_ROW, part_index]
        for row in range(POSITIONS):
            step.positions[j, SLOPES + row, end] *= duration
    fit_positions(step.workspace, step.positions[j])
    arc.accumulate_distance(step, j, totals.account[j])
    count, bins_offset = int(law.bins), 2 * j * totals.stride
    bins = Bins(totals.depths, bins_offset, count), Bins(totals.depths, bins_offset + totals.stride, count)
    account = JointAccount(totals.account[j], 1.0)
    update_worn_profile(joint, step.workspace, step.step_values[j], step.length, bins, account)


@update_contact_wear.member(NoWear)
def _update_contact_wear_no_wear(law, joint, j, step_and_totals):
    pass


@family_with_default
def update_joint_wear(joint, j, step_and_totals):
    """Add the wear of a joint, whose first contact is `j`, over a Step; step_and_totals : Step and WearTotals."""
    if touches(step_and_totals[0].mode[j]):
        update_contact_wear(joint.wear, joint, j, step_and_totals)


def never_wears(joint_type):
    """Register a type of joint whose own surfaces do not wear, while other joints do."""
    record.member(joint_type)(lambda joint, gap, body_angles, j, instant: None)
    update_joint_wear.member(joint_type)(lambda joint, j, step_and_totals: None)
