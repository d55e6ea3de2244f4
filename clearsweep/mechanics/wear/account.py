"""The account of a joint's wear: pressures and widths of the arc over the spans of a step, sliding distance."""

import math

import numpy as np

from ...tracing.compiled.choosing import bits_of, lane_range, number_of
from ...tracing.compiled.family import family, inlined, kernel
from ..joints.spatial import Flanged, Through
from ..observe import KAPPA_ROW, PARTS, SLIP_ROW
from .arc_over_step import (
    AREA,
    BODY_SIZE,
    DISTANCE_ROW,
    DURATION_ROW,
    FIRST_BODY,
    HALF,
    NODES,
    PAIRS,
    PEAK_ROW,
    POINTS,
    PRESSURE_TIME_ROW,
    PV_ROW,
    range_of_row,
    row_sum,
)
from .contract import (
    ARC_COUNT,
    CLASSES,
    FIRST_CLASS,
    NARROW_COUNT,
    PRESSURE_MAX,
    PRESSURE_TIME,
    PV_BEYOND,
    PV_MAX,
    RESOLVED_WIDTH,
    SLIDING_DISTANCE,
    arc_width,
)

NEAR_LARGEST = 0.9  # of the largest value so far: a larger one at a node may belong to a new maximum
SIMPSON = np.array([1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 4.0]) / (3.0 * PARTS)  # weights of all points but the last


@kernel
def accumulate_distance(step, j, account):
    """Write the sliding distance (m) of joint `j` over the step to `step.workspace`, and add the step's to `account`.

    Simpson's rule over the profile of the sliding speed.
    """
    workspace, step_values = step.workspace, step.step_values[j]
    for i in lane_range(PARTS):
        workspace[DURATION_ROW * POINTS + i] = SIMPSON[i] * step_values[KAPPA_ROW, i] * abs(step_values[SLIP_ROW, i])
    distance = row_sum(workspace, DURATION_ROW)
    distance += SIMPSON[0] * step_values[KAPPA_ROW, PARTS] * abs(step_values[SLIP_ROW, PARTS])
    distance *= step.length
    workspace[DISTANCE_ROW * POINTS], workspace[DISTANCE_ROW * POINTS + 1] = account[SLIDING_DISTANCE], distance
    account[SLIDING_DISTANCE] += distance


@kernel
def _maximum_near_nodes(workspace, row):
    """Return the largest value of a row at its nodes, or on the parabola through the largest and its neighbours."""
    node = 1
    for i in range(2, POINTS - 1):
        node = i if workspace[row * POINTS + i] > workspace[row * POINTS + node] else node
    a, b, c = NODES[node - 1], NODES[node], NODES[node + 1]
    before, middle, after = (workspace[row * POINTS + node + shift] for shift in (-1, 0, 1))
    largest = range_of_row(workspace, row)[1]
    rise, fall = (middle - before) / (b - a), (after - middle) / (c - b)
    if rise > 0.0 > fall:
        curvature = (fall - rise) / (c - a)
        slope = rise + curvature * (b - a)
        largest = max(largest, middle - slope * slope / (4.0 * curvature))
    return largest


@inlined
def _raised_maximum(workspace, row, largest):
    """Return the larger of `largest` and the maximum of a row."""
    if range_of_row(workspace, row)[1] > NEAR_LARGEST * largest:
        return max(largest, _maximum_near_nodes(workspace, row))
    return largest


@family
def account_pressure(joint, workspace, account):
    """Add pressure, and pressure times sliding speed, on the bearing over a span to an account."""


@account_pressure.member(None)
def _default_account_pressure(joint, workspace, account):
    account[PRESSURE_TIME] += row_sum(workspace, PRESSURE_TIME_ROW)
    account[PRESSURE_MAX] = _raised_maximum(workspace, PEAK_ROW, account[PRESSURE_MAX])
    account[PV_MAX] = _raised_maximum(workspace, PV_ROW, account[PV_MAX])
    if account[PV_MAX] > joint.wear.pv_limit:
        for i in range(POINTS):
            if workspace[PV_ROW * POINTS + i] > joint.wear.pv_limit:
                account[PV_BEYOND] += workspace[DURATION_ROW * POINTS + i]


@account_pressure.member(Through)
@account_pressure.member(Flanged)
def _account_pressure_through_or_flanged(joint, workspace, account):
    pass  # `slices` adds the pressure of a whole strip


@inlined
def middle_width(workspace):
    """Return the width (rad) of the arc on the bearing in the middle of a span, the mean of the nodes next to it."""
    half_row = FIRST_BODY + HALF * POINTS
    return workspace[half_row + PAIRS - 1] + workspace[half_row + PAIRS]


@arc_width.member(None)
def _default_arc_width(joint, workspace):
    return middle_width(workspace)


@kernel
def account_span(joint, workspace, account, length_fraction):
    """Add the pressure over a span, and its worn volume by the arc's width, to an account.

    length_fraction : fraction of the joint's length that wears
    """
    account_pressure(joint, workspace, account)
    width = arc_width(joint, workspace)
    account[ARC_COUNT] += 1.0
    if width < RESOLVED_WIDTH * 2.0 * math.pi / joint.wear.bins:
        account[NARROW_COUNT] += 1.0
    bearing_row, journal_row = FIRST_BODY // POINTS + AREA, (FIRST_BODY + BODY_SIZE) // POINTS + AREA
    bearing, journal = row_sum(workspace, bearing_row), row_sum(workspace, journal_row)
    volume = joint.bearing_radius * bearing + joint.journal_radius * journal
    account[FIRST_CLASS + width_class(width)] += length_fraction * volume


@inlined
def width_class(width):
    """Return the class of an arc of `width` (rad), 0 for the widest: its column of the account minus FIRST_CLASS."""
    ratio = 2.0 * math.pi / max(width, 1e-300)
    exponent = (bits_of(ratio) >> 52) - 1023
    mantissa = ratio * number_of((1023 - exponent) << 52)  # 1 to 2
    return min(max(2 * exponent + (1 if mantissa >= math.sqrt(2.0) else 0), 0), CLASSES - 1)
