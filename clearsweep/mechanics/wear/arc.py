"""A contact arc over a step: it grows, shrinks and travels, and its ends pass the edges of bins.

The integral over the step of the load before an edge is split where an end of the arc passes the edge, as the pressure
is not smooth at the ends of the arc.  `bins` adds the wear to the bins.

The values at the points of a step are in one array, point by point, and are processed together, each in a lane of a
register.

Within the part of a step between two reversals of sliding, the time is counted from -1 to 1.

The account of a joint's wear has pressures and widths of the arc over the spans of a step, and the sliding distance.
"""

import math
from typing import NamedTuple

import numpy as np

from ...tracing.compiled.choosing import bits_of, lane_range, number_of, rolled_range, where
from ...tracing.compiled.family import family_with_default, inlined, kernel
from ...tracing.memory import Rows
from ...tracing.portable import Exact, coefficients_through, gauss_rule, least_squares, lobatto_rule, powers
from .. import wear
from ..observe import KAPPA_ROW, PARTS, SLIP_ROW

DEGREE = 6  # of the polynomials over the fraction of the step, as many as its stages determine
POINTS = 8  # vector width, and sufficient for the DEGREE
NODES, WEIGHTS = lobatto_rule(POINTS)
INVERSE_WEIGHTS, UNIT_WEIGHTS = 1.0 / WEIGHTS, np.ones(POINTS)
#: (PARTS + 1, POINTS): from values at equidistant times of the step to coefficients over its fraction.
FIT = np.zeros((PARTS + 1, POINTS))
FIT[:, : DEGREE + 1] = least_squares(powers(np.arange(PARTS + 1) / PARTS, DEGREE + 1)).transposed.rounded()
PAIRS = POINTS // 2  # of points symmetric to the middle
_EXACT_FROM_POINTS = coefficients_through(NODES)
#: From the coefficients of a polynomial to those of its integral since the time -1, over the time since then.
_MULTIPLE = math.lcm(*range(1, POINTS + 1))
_INTEGRATION = Exact(
    [[(-1) ** (k - m) * _MULTIPLE // (k + 1) if m <= k else 0 for k in range(POINTS)] for m in range(POINTS)], _MULTIPLE
)
_FROM_POINTS = _EXACT_FROM_POINTS.rounded()
#: (power, node): coefficients over the time of the polynomial that is 1 at a node and 0 at the others; of its integral
#: since the time -1, over the time since then and the weight of the node.
BASIS = _FROM_POINTS
BASIS_INTEGRAL = (_INTEGRATION @ _EXACT_FROM_POINTS).rounded() / WEIGHTS
#: (PAIRS, POINTS): from sums and differences of pairs' values to even and odd coefficients over the time.
EVEN, ODD = np.zeros((2, PAIRS, POINTS))
EVEN[:, ::2], ODD[:, 1::2] = _FROM_POINTS[::2, PAIRS:].T, _FROM_POINTS[1::2, PAIRS:].T
#: Nodes and weights of Gauss's rule on 0 to 1 after x = u^2 (3 - 2 u), in which the load is smooth at the ends of the
#: arc, where it varies as x^(3/2).
_NODES, _WEIGHTS = gauss_rule(POINTS)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
SMOOTHED_NODES, SMOOTHED_WEIGHTS = _NODES**2 * (3.0 - 2.0 * _NODES), 6.0 * _NODES * (1.0 - _NODES) * _WEIGHTS
SMALLEST_HALF_ANGLE = 1e-300  # rad, of an arc without width
SMALLEST_ARC = 1e-7  # rad: half-angle below which the pressure of an arc is not evaluated
#: Of each node: its distance from the previous one; one plus the power of its coefficient; its number.
SPACINGS = np.diff(NODES, prepend=-1.0)
POWERS = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 0.0])
INDICES = np.arange(8.0)


class StepRows(Rows):
    """Rows of the workspace of a step, each of POINTS numbers.

    The first are coefficients over the fraction of the step, in the order of its values; those from `duration` on
    are at the nodes of a span.
    """

    line_load: float  # N/m
    kappa: float  # s
    slip: float  # m/s
    depth: float  # m
    friction_power: float  # W/m
    bearing_angle: float  # rad, of the contact on each body
    journal_angle: float  # rad
    penetration: float  # m, of worn surfaces
    distance: float  # m, two numbers: sliding distance before the step and in it
    duration: float  # s
    pressure_time: float  # Pa s, product of the duration and the mean pressure on the bearing
    peak: float  # Pa, largest pressure
    pv: float  # W/m^2, its product with the sliding speed


class ArcRows(Rows):
    """Rows of a body and its arc, each of POINTS numbers: at the nodes of a span, or coefficients over the time."""

    area: float  # m rad, worn in the time of a node
    half: float  # rad, half-angle of the arc
    per_half: float  # 1/rad
    middle: float  # rad, angle of the arc's middle
    start: float  # rad, of its ends
    stop: float  # rad
    rate: float  # coefficients of the wear rate
    middle_polynomial: float  # of the arc's middle
    half_polynomial: float  # of its half-angle
    end: float  # rad, of one end: its angle at the previous node
    time_per_angle: float  # 1/rad
    end_polynomial: float  # coefficients of its angle
    end_slope: float  # of its slope
    passings: float  # times at which it passes edges
    worn: float  # m rad, wear before edges
    term: float  # terms of sums
    second_term: float
    node_term: float  # terms of sums over the nodes
    second_node_term: float


class Workspace(NamedTuple):
    """Workspace for the wear of a contact over a step."""

    step: StepRows
    bearing: ArcRows
    journal: ArcRows


#: Numbers of a Workspace.
WORKSPACE_SIZE = (StepRows.SIZE + 2 * ArcRows.SIZE) * POINTS
_START, _STOP = ArcRows.index_of("start"), ArcRows.index_of("stop")
_END_POLYNOMIAL = ArcRows.index_of("end_polynomial") * POINTS  # its first number


@inlined
def workspace_of(numbers):
    """Return the Workspace in an array of WORKSPACE_SIZE numbers."""
    bearing, journal = StepRows.SIZE * POINTS, (StepRows.SIZE + ArcRows.SIZE) * POINTS
    return Workspace(
        StepRows(numbers[:bearing].reshape(StepRows.SIZE, POINTS)),
        ArcRows(numbers[bearing:journal].reshape(ArcRows.SIZE, POINTS)),
        ArcRows(numbers[journal:WORKSPACE_SIZE].reshape(ArcRows.SIZE, POINTS)),
    )


@inlined
def end_row(rows, end):
    """Return the row of the angles (rad) of an end of the arc: its start for a negative `end`, else its stop."""
    return rows.numbers[_START if end < 0 else _STOP]


@inlined
def evaluate_polynomial(coefficients, x):
    """Return the polynomial of a row of coefficients at `x`."""
    total = coefficients[POINTS - 1]
    for i in range(POINTS - 2, -1, -1):
        total = total * x + coefficients[i]
    return total


@inlined
def evaluate_columns(coefficients, x, node):
    """Return the polynomial of column `node` of coefficients, (POINTS, POINTS), at `x`."""
    total = coefficients[POINTS - 1, node]
    for i in range(POINTS - 2, -1, -1):
        total = total * x + coefficients[i, node]
    return total


@inlined
def row_sum(row):
    """Return the sum of a row, in an order with few dependent additions."""
    return ((row[0] + row[1]) + (row[2] + row[3])) + ((row[4] + row[5]) + (row[6] + row[7]))


@inlined
def sliding_contact_of(joint, values, sliding_distance, clearance):
    """Return the SlidingContact of a joint from its profiles' values at one time, in the order of the profiles."""
    (load, _, sliding_speed, depth, friction_power), pressure = values, joint.wear.pressure
    load, sliding_speed, friction_power = max(load, 0.0), abs(sliding_speed), max(friction_power, 0.0)
    sliding = wear.SlidingContact(load, depth, sliding_speed, friction_power, sliding_distance, 0.0, clearance, 0.0)
    half_angle = wear.half_arc(pressure, joint, joint.bearing_radius, sliding)
    load_sum = wear.pressure_integral_over_load(pressure, half_angle)
    return sliding._replace(pressure_integral=load * load_sum, half_angle=half_angle)


@inlined
def sliding_contact_at(joint, workspace, x):
    """Return the SlidingContact of a joint at the fraction `x` (0 to 1) of the step."""
    load = evaluate_polynomial(workspace.step.line_load, x)
    depth = evaluate_polynomial(workspace.step.depth, x)
    slip = evaluate_polynomial(workspace.step.slip, x)
    sliding_distance = workspace.step.distance[0] + workspace.step.distance[1] * x
    values = load, 0.0, slip, depth, evaluate_polynomial(workspace.step.friction_power, x)
    bearing_angle = evaluate_polynomial(workspace.step.bearing_angle, x)
    journal_angle = evaluate_polynomial(workspace.step.journal_angle, x)
    clearance = wear.local_clearance(joint, bearing_angle, journal_angle)
    return sliding_contact_of(joint, values, sliding_distance, clearance)


@inlined
def _write_arc(rows, i, area, angle, half_angle):
    """Write the arc of a body at a point to its rows."""
    half_angle = max(half_angle, SMALLEST_HALF_ANGLE)
    rows.area[i], rows.middle[i] = area, angle
    rows.half[i], rows.per_half[i] = half_angle, 1.0 / half_angle
    rows.start[i], rows.stop[i] = angle - half_angle, angle + half_angle


@inlined
def write_pressure(workspace, i, pressures, speed, duration):
    """Write the (mean, largest) pressure (Pa) on the bearing at a node, which represents a `duration` (s)."""
    workspace.step.duration[i], workspace.step.pressure_time[i] = duration, pressures[0] * duration
    workspace.step.peak[i], workspace.step.pv[i] = pressures[1], pressures[1] * speed


@kernel
def evaluate_arc(joint, workspace, step_length, low, high):
    """Write the arc, its wear (m rad) and its pressure at the nodes between two fractions of a step to `workspace`.

    step_length : s over kappa
    """
    span_middle, half_width, pressure = 0.5 * (low + high), 0.5 * (high - low), joint.wear.pressure
    per_bearing_radius, per_journal_radius = 1.0 / joint.bearing_radius, 1.0 / joint.journal_radius
    for i in lane_range(POINTS):
        x = span_middle + half_width * NODES[i]
        sliding = sliding_contact_at(joint, workspace, x)
        bearing_rate, journal_rate = wear.wear_rate(joint.wear, sliding)
        duration = step_length * half_width * WEIGHTS[i] * max(evaluate_polynomial(workspace.step.kappa, x), 0.0)
        half_angle = wear.half_arc(pressure, joint, joint.bearing_radius, sliding)
        # not at an onset or a separation, where there is no load either
        per_width = where(half_angle > SMALLEST_ARC, 0.5 / max(half_angle, SMALLEST_HALF_ANGLE), 0.0)
        mean_pressure = per_width * per_bearing_radius * sliding.pressure_integral
        pressures = mean_pressure, mean_pressure * wear.peak_over_mean(pressure, half_angle)
        write_pressure(workspace, i, pressures, sliding.sliding_speed, duration)
        _write_arc(
            workspace.bearing,
            i,
            duration * bearing_rate * per_bearing_radius,
            evaluate_polynomial(workspace.step.bearing_angle, x),
            half_angle,
        )
        half_angle = wear.half_arc(pressure, joint, joint.journal_radius, sliding)
        _write_arc(
            workspace.journal,
            i,
            duration * journal_rate * per_journal_radius,
            evaluate_polynomial(workspace.step.journal_angle, x),
            half_angle,
        )


@inlined
def range_of_row(row):
    """Return the least and the largest value of a row, compared in pairs for few dependent operations."""
    low = [min(row[i], row[i + 1]) for i in range(0, POINTS, 2)]
    high = [max(row[i], row[i + 1]) for i in range(0, POINTS, 2)]
    lowest, largest = min(low[0], low[1]), max(high[0], high[1])
    return min(lowest, min(low[2], low[3])), max(largest, max(high[2], high[3]))  # noqa: PLW3301 - in pairs


@inlined
def fit_row(row, coefficients, weights):
    """Write the coefficients over the time of the polynomial through a row times `weights`."""
    for i in lane_range(POINTS):
        total = 0.0
        for k in range(PAIRS):
            late_value = row[PAIRS + k] * weights[PAIRS + k]
            early_value = row[PAIRS - 1 - k] * weights[PAIRS - 1 - k]
            total += EVEN[k, i] * (late_value + early_value) + ODD[k, i] * (late_value - early_value)
        coefficients[i] = total


@family_with_default
def fit_arc(pressure, rows):
    """Write the coefficients that the other families of this file need.

    By default these are the polynomials over the time of the wear rate, of the arc's middle and of its half-angle:
    `rate`, `middle_polynomial` and `half_polynomial`.
    """
    fit_row(rows.area, rows.rate, INVERSE_WEIGHTS)
    fit_row(rows.middle, rows.middle_polynomial, UNIT_WEIGHTS)
    fit_row(rows.half, rows.half_polynomial, UNIT_WEIGHTS)


@inlined
def is_monotonic(row):
    """Return whether a row is monotonic."""
    growth_count = 0
    for i in range(1, POINTS):
        growth_count += row[i] > row[i - 1]
    return growth_count in (0, POINTS - 1)


@kernel
def write_passing_times(rows, end, edge, width):
    """Write the times at which an end (-1, 1) of the arc passes edges, `width` (rad) apart, to `passings`.

    The end moves in one direction only.  The time is interpolated linearly and corrected by one Newton step.  The
    remaining error enters squared at most, as the load is zero at the ends.
    """
    angles, coefficients = end_row(rows, end), rows.numbers.reshape(ArcRows.SIZE * POINTS)
    for i in lane_range(POINTS):
        previous_angle = angles[i - 1]  # that before the first point is of another row, and not used
        change = angles[i] - previous_angle
        rows.end[i] = previous_angle
        rows.time_per_angle[i] = where(change != 0.0, SPACINGS[i] / where(change != 0.0, change, 1.0), 0.0)
        rows.end_polynomial[i] = rows.middle_polynomial[i] + end * rows.half_polynomial[i]
    for i in lane_range(POINTS):
        rows.end_slope[i] = POWERS[i] * coefficients[_END_POLYNOMIAL + i + 1]
    rows.end_slope[POINTS - 1] = 0.0  # the value after the last coefficient is undefined
    for k in lane_range(POINTS):
        angle, x = edge + INDICES[k] * width, NODES[0]
        for i in range(1, POINTS):
            change = (angle - rows.end[i]) * rows.time_per_angle[i]
            x += min(max(change, 0.0), SPACINGS[i])
        slope = evaluate_polynomial(rows.end_slope, x)
        step = (angle - evaluate_polynomial(rows.end_polynomial, x)) * slope / (slope * slope + SMALLEST_HALF_ANGLE)
        rows.passings[k] = min(max(x + min(max(step, -0.1), 0.1), -1.0), 1.0)


@inlined
def inside_time(rows, end):
    """Return the end of the time, -1 or 1, at which the edges that an end (-1, 1) of the arc passes are inside it."""
    angles = end_row(rows, end)
    rises = angles[POINTS - 1] > angles[0]
    return -1.0 if rises == (end < 0.0) else 1.0


@family_with_default
def write_wear_before_passed_edges(pressure, rows, end, edge, width):
    """Write the wear before edges, `width` (rad) apart, that an end (-1, 1) of the arc has passed, to `worn`.

    The times of passing are in `passings`.  The end moves in one direction only, and the other end does not meet these
    edges.
    """
    end_time = inside_time(rows, end)
    total_area = row_sum(rows.area) if end > 0.0 else 0.0
    for k in lane_range(POINTS):
        time_passed, angle, total = rows.passings[k], edge + INDICES[k] * width, 0.0
        for j in rolled_range(SMOOTHED_NODES.size):
            x = time_passed + (end_time - time_passed) * SMOOTHED_NODES[j]
            offset = angle - evaluate_polynomial(rows.middle_polynomial, x)
            half_angle = max(evaluate_polynomial(rows.half_polynomial, x), SMALLEST_HALF_ANGLE)
            fraction = wear.cumulative_pressure(pressure, -end * offset / half_angle, half_angle)
            total += SMOOTHED_WEIGHTS[j] * evaluate_polynomial(rows.rate, x) * fraction
        rows.worn[k] = total_area - end * abs(end_time - time_passed) * total


@kernel
def passing_time(rows, edge, end, i):
    """Return the time at which an end (-1, 1) of the arc is at `edge` (rad), between nodes `i - 1` and `i`.

    An error e of it changes the integral by e^(5/2): one step of regula falsi and a parabola through all three suffice.
    """
    angles, low, high = end_row(rows, end), NODES[i - 1], NODES[i]
    a, b = edge - angles[i - 1], edge - angles[i]
    if a == b:
        return low
    x = (low * b - high * a) / (b - a)
    c = edge - evaluate_polynomial(rows.middle_polynomial, x) - end * evaluate_polynomial(rows.half_polynomial, x)
    if c in (a, b):
        return x
    x = low * b * c / ((a - b) * (a - c)) + high * a * c / ((b - a) * (b - c)) + x * a * b / ((c - a) * (c - b))
    return min(max(x, low), high)


@family_with_default
def unfitted_edges(pressure):
    """Return how many edges at an end of the arc are processed without the coefficients of `fit_arc`."""
    return 0


@kernel
def wear_before_edge_in_span(pressure, rows, edge, region, span):
    """Return the wear (m rad) before an `edge` (rad) between two times, a `span`, in which the edge is in one region.

    region : -1 before the arc, 1 behind it, 0 in it.
    """
    low, length = span[0], span[1] - span[0]
    if region < 0 or length <= 0.0:
        return 0.0
    for i in lane_range(POINTS):
        position = low + length * SMOOTHED_NODES[i]
        half_angle = max(evaluate_polynomial(rows.half_polynomial, position), SMALLEST_HALF_ANGLE)
        fraction = wear.cumulative_pressure(
            pressure, (edge - evaluate_polynomial(rows.middle_polynomial, position)) / half_angle, half_angle
        )
        rows.term[i] = (
            SMOOTHED_WEIGHTS[i] * evaluate_polynomial(rows.rate, position) * where(region == 0, fraction, 1.0)
        )
    return length * row_sum(rows.term)


@inlined
def region_of(rows, edge, i):
    """Return -1 if an `edge` (rad) is before the arc of point `i`, 1 if behind it, 0 if in it."""
    if edge <= rows.start[i]:
        return -1
    return 1 if edge >= rows.stop[i] else 0


@family_with_default
def wear_before_edge(pressure, rows, edge):
    """Return the wear (m rad) before an `edge` (rad) that the arc's ends pass."""
    total, low, region = 0.0, NODES[0], region_of(rows, edge, 0)
    for i in rolled_range(1, POINTS):
        next_region = region_of(rows, edge, i)
        while region != next_region:
            end = region if region != 0 else next_region  # the end of the arc that passes the edge
            x = max(low, passing_time(rows, edge, end, i))
            total += wear_before_edge_in_span(pressure, rows, edge, region, (low, x))
            low, region = x, (0 if region != 0 else next_region)
    return total + wear_before_edge_in_span(pressure, rows, edge, region, (low, NODES[POINTS - 1]))


# ---------------------------------------------------------------------------------------------- account of a span


NEAR_LARGEST = 0.9  # of the largest value so far: a larger one at a node may belong to a new maximum
SIMPSON = np.array([1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 4.0]) / (3.0 * PARTS)  # weights of all points but the last


@kernel
def accumulate_distance(step, j, account):
    """Write the sliding distance (m) of joint `j` over the step to `step.workspace`, and add the step's to `account`.

    Simpson's rule over the profile of the sliding speed.
    """
    workspace, step_values = step.workspace, step.step_values[j]
    for i in lane_range(PARTS):
        workspace.step.duration[i] = SIMPSON[i] * step_values[KAPPA_ROW, i] * abs(step_values[SLIP_ROW, i])
    distance = row_sum(workspace.step.duration)
    distance += SIMPSON[0] * step_values[KAPPA_ROW, PARTS] * abs(step_values[SLIP_ROW, PARTS])
    distance *= step.length
    workspace.step.distance[0], workspace.step.distance[1] = account.sliding_distance, distance
    account.sliding_distance += distance


@kernel
def _maximum_near_nodes(row):
    """Return the largest value of a row at its nodes, or on the parabola through the largest and its neighbours."""
    node = 1
    for i in range(2, POINTS - 1):
        node = i if row[i] > row[node] else node
    a, b, c = NODES[node - 1], NODES[node], NODES[node + 1]
    before, middle, after = row[node - 1], row[node], row[node + 1]
    largest = range_of_row(row)[1]
    rise, fall = (middle - before) / (b - a), (after - middle) / (c - b)
    if rise > 0.0 > fall:
        curvature = (fall - rise) / (c - a)
        slope = rise + curvature * (b - a)
        largest = max(largest, middle - slope * slope / (4.0 * curvature))
    return largest


@inlined
def _raised_maximum(row, largest):
    """Return the larger of `largest` and the maximum of a row."""
    if range_of_row(row)[1] > NEAR_LARGEST * largest:
        return max(largest, _maximum_near_nodes(row))
    return largest


@family_with_default
def account_pressure(joint, workspace, account):
    """Add pressure, and pressure times sliding speed, on the bearing over a span to an account."""
    account.pressure_time += row_sum(workspace.step.pressure_time)
    account.pressure_max = _raised_maximum(workspace.step.peak, account.pressure_max)
    account.pv_max = _raised_maximum(workspace.step.pv, account.pv_max)
    if account.pv_max > joint.wear.pv_limit:
        for i in range(POINTS):
            if workspace.step.pv[i] > joint.wear.pv_limit:
                account.pv_beyond += workspace.step.duration[i]


wear.arc_width.member(None)(lambda joint, workspace, i: 2.0 * workspace.bearing.half[i])


@kernel
def _narrow_fraction(joint, workspace):
    """Return the fraction of a span's time with an arc below five bins: width and clock are linear between nodes."""
    limit, narrow, whole = wear.RESOLVED_WIDTH * 2.0 * math.pi / joint.wear.bins, 0.0, 0.0
    before, rate = wear.arc_width(joint, workspace, 0) - limit, workspace.step.duration[0] * INVERSE_WEIGHTS[0]
    for i in range(1, POINTS):
        after, next_rate = wear.arc_width(joint, workspace, i) - limit, workspace.step.duration[i] * INVERSE_WEIGHTS[i]
        low, high = min(before, after), max(before, after)
        if low < 0.0:
            part, at_low = low / (low - high) if high > 0.0 else 1.0, rate if before < after else next_rate
            narrow += SPACINGS[i] * part * ((2.0 - part) * at_low + part * (rate + next_rate - at_low))
        whole += SPACINGS[i] * (rate + next_rate)
        before, rate = after, next_rate
    return narrow / whole if whole > 0.0 else 0.0


@kernel
def account_span(joint, workspace, account, length_fraction):
    """Add the pressure over a span, and its worn volume by the arc's width, to an account.

    length_fraction : fraction of the joint's length that wears
    """
    account_pressure(joint, workspace, account)
    duration = row_sum(workspace.step.duration)
    account.arc_time += duration
    account.narrow_time += duration * _narrow_fraction(joint, workspace)
    for i in rolled_range(POINTS):
        bearing = workspace.bearing.area[i]
        journal = workspace.journal.area[i]
        volume = joint.bearing_radius * bearing + joint.journal_radius * journal
        account.numbers[wear.Account.SIZE + width_class(wear.arc_width(joint, workspace, i))] += (
            length_fraction * volume
        )


@inlined
def width_class(width):
    """Return the class of an arc of `width` (rad), 0 for the widest: its number behind the fields of an Account."""
    ratio = 2.0 * math.pi / max(width, 1e-300)
    exponent = (bits_of(ratio) >> 52) - 1023
    mantissa = ratio * number_of((1023 - exponent) << 52)  # 1 to 2
    return min(max(2 * exponent + (1 if mantissa >= math.sqrt(2.0) else 0), 0), wear.CLASSES - 1)
