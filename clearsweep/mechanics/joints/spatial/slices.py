"""Wear of a spatial joint over angle and length: the contact strip of each wall is cut into slices.

`strips` gives the position and load of the strips.  Each slice wears like a planar joint under its fraction of the
load; over a step its fraction is that of the work, so the total is conserved.  The bins of each body are along its own
axis, around its own x axis.  Wear beyond a body's end is added at its end.

The account of a joint's wear: pressures and widths of the arc over the spans of a step, sliding distance.
"""

import math
from typing import NamedTuple

import numpy as np

from ....tracing.compiled.choosing import lane_range, rolled_range
from ....tracing.compiled.family import family_with_default, inlined, kernel
from ....tracing.compiled.vector import cross, dot, plus_scaled
from ....tracing.portable import coefficients_through, exact, powers
from ...laws.contract import touches
from ...observe import DEPTH_ROW, FORCE_ROW, KAPPA_ROW, PARTS, QUARTER_POINTS, SLIP_ROW
from ...wear import Bins, JointAccount, NoWear, SlidingContact, half_arc, peak_over_mean
from ...wear.arc import (
    FIT,
    POINTS,
    SMALLEST_ARC,
    account_pressure,
    accumulate_distance,
    range_of_row,
    row_sum,
    sliding_contact_of,
)
from ...wear.bins import (
    BUFFER_ROWS,
    SLOPES,
    StripRows,
    fit_positions,
    fit_profiles,
    is_reversing,
    record,
    unwrap_angles,
    update_joint_wear,
    update_worn_profile,
    worn_bins,
)
from . import ENDS, Flanged, Through, strips, wall_point
from .spread import bearing_length

LOAD_TOLERANCE = 0.2  # of the largest load per length: slices with smaller differences have a common arc width
#: Of the largest depth in a step: below, the largest pressure is not evaluated.  It has a limit at the depth 0, but
#: load and depth are two polynomials over the step, whose errors leave 0 / 0.
SMALLEST_DEPTH = 1e-2
EDGE_TOLERANCE = 1e-9  # of a bin's length: a slice that ends closer to an edge ends at it
_QUARTERS = np.arange(QUARTER_POINTS + 2) / (QUARTER_POINTS + 1)
_POWERS = coefficients_through(_QUARTERS)
#: (QUARTER_POINTS + 2, PARTS + 1): values at equidistant times of a step from those at its quarters.
FROM_QUARTERS = np.ascontiguousarray((powers(np.arange(PARTS + 1) / PARTS, QUARTER_POINTS + 2) @ _POWERS).rounded().T)
#: Weights of the equidistant times but the first, exact for parabolas.
WEIGHTS = np.array([0.0, 11.0 / 6.0, 5.0 / 6.0, 5.0 / 6.0, *[1.0] * (PARTS - 4), 0.5])
#: (2, QUARTER_POINTS + 2): slopes at both ends of a step, per its length.
END_SLOPES = (
    exact([[float(p * at ** max(p - 1, 0)) for p in range(QUARTER_POINTS + 2)] for at in (0.0, 1.0)]) @ _POWERS
).rounded()


@record.member(Through, Flanged)
def _record_through_or_flanged(joint, gap, body_angles, j, instant):
    for wall in range(len(ENDS)):
        if strips.carries_load(joint.walls, instant.step, j, wall):
            _record_wall(joint, gap, body_angles, (j + wall, ENDS[wall]), instant)


@kernel
def _record_wall(joint, gap, body_angles, contact, instant):
    """Record the position of a contact at one of the ENDS: its number, its end."""
    step, i, (j, end) = instant.step, instant.number, contact
    point = wall_point(joint.end_type, joint, gap, end)
    transverse = plus_scaled(point.normal, -dot(point.normal, gap.axis), gap.axis)
    step.positions[j, 0, i] = math.atan2(dot(transverse, cross(gap.axis, body_angles)), dot(transverse, body_angles))
    step.positions[j, 1, i] = math.atan2(point.normal.y, point.normal.x)
    strip_start = strips.strip_position(joint.end_type, joint, gap, point, end)
    overlap = bearing_length(joint.end_type, joint, gap)
    axial = step.axial[j]
    axial.lean[i], axial.reach[i] = strip_start.lean, overlap.half_length
    axial.tilt_square[i] = gap.axis.x * gap.axis.x + gap.axis.y * gap.axis.y
    axial.bearing_start[i], axial.journal_start[i] = strip_start.bearing_start, strip_start.journal_start
    axial.facing[i] = strip_start.facing


# ---------------------------------------------------------------------------------------------- slices


class Slice(NamedTuple):
    """A slice of a strip: means over a step, weighted by the work of friction."""

    load_fraction: float  # fraction of the strip's load
    loaded_length: float  # m, length that carries load
    depth: float  # mean depth over that length, divided by the strip's largest depth: 0 to 1
    begin: float  # m, from its near end to the part that carries load
    loaded_work: float = 0.0  # fraction of the weights at the times when its length is above 0


LOADED_WORK = Slice._fields.index("loaded_work")


class StripHistory(NamedTuple):
    """The strip of a contact at equidistant times of a step."""

    reach: float  # m, the largest
    values: StripRows
    step_values: np.ndarray  # (STEP_VALUE_ROWS, PARTS + 1) of the contact


@kernel
def _strip_at(joint, history, i):
    """Return the DepthProfile of a strip and its depth (m) at equidistant time number `i`."""
    values = history.values
    strip = strips.DepthProfile(values.reach[i], values.lean[i], values.tilt_square[i])
    return strip, strips.depth_at_start(joint.walls, history.step_values[DEPTH_ROW, i])


class StripPressure(NamedTuple):
    """Pressure of a strip at one of the equidistant times of a step, all 0 without load."""

    duration: float  # s, that the time represents
    mean: float  # Pa s, of its mean pressure
    peak: float  # Pa
    pv: float  # W/m^2, its product with the sliding speed


@kernel
def _strip_pressure_at(joint, step, history, i, smallest_depth):
    """Return the StripPressure at time number `i`; below `smallest_depth` (m) without its largest values."""
    law, step_values = joint.wear, history.step_values
    strip, start_depth = _strip_at(joint, history, i)
    load, slip, zero = max(step_values[FORCE_ROW, i], 0.0), step_values[SLIP_ROW, i], 0.0 * start_depth
    integrals = history.values.load_integral[i], history.values.depth_integral[i]
    loads = strips.loads_along(joint.walls, joint, strip, start_depth, (load, *integrals))
    if loads.max_depth <= 0.0:
        return StripPressure(zero, zero, zero, zero)
    mean_sliding = sliding_contact_of(joint, (loads.mean_load, 0.0, slip, loads.mean_depth, 0.0), 0.0, joint.clearance)
    peak_sliding = sliding_contact_of(joint, (loads.max_load, 0.0, slip, loads.max_depth, 0.0), 0.0, joint.clearance)
    half_angle, half_angle_at_peak = _half_angle(joint, mean_sliding), _half_angle(joint, peak_sliding)
    if min(half_angle, half_angle_at_peak) < SMALLEST_ARC:
        return StripPressure(zero, zero, zero, zero)
    duration = WEIGHTS[i] / PARTS * step.length * step_values[KAPPA_ROW, i]
    mean = mean_sliding.pressure_integral / (2.0 * joint.bearing_radius * half_angle) * duration
    if loads.max_depth < smallest_depth:
        return StripPressure(duration, mean, zero, zero)
    peak = (
        peak_sliding.pressure_integral
        / (2.0 * joint.bearing_radius * half_angle_at_peak)
        * peak_over_mean(law.pressure, half_angle_at_peak)
    )
    return StripPressure(duration, mean, peak, peak * peak_sliding.sliding_speed)


@kernel
def accumulate_strip_pressure(joint, step, history, account):
    """Record pressure and pressure times sliding speed of a wall contact at equidistant points of the step."""
    rows, smallest_depth, pv_limit = step.workspace.step, 0.0, joint.wear.pv_limit
    for i in range(PARTS + 1):
        smallest_depth = max(smallest_depth, SMALLEST_DEPTH * history.values.max_depth[i])
    for i in lane_range(PARTS):
        numbers = _strip_pressure_at(joint, step, history, i + 1, smallest_depth)
        rows.duration[i], rows.pressure_time[i], rows.peak[i], rows.pv[i] = numbers
    account.pressure_time += row_sum(rows.pressure_time)
    account.pressure_max = max(account.pressure_max, range_of_row(rows.peak)[1])
    account.pv_max = max(account.pv_max, range_of_row(rows.pv)[1])
    if account.pv_max > pv_limit:
        for i in range(PARTS):
            account.pv_beyond += rows.duration[i] if rows.pv[i] > pv_limit else 0.0


@kernel
def _half_angle(joint, sliding: SlidingContact):
    return half_arc(joint.wear.pressure, joint, joint.bearing_radius, sliding)


class AxialRange(NamedTuple):
    """Position of a slice on a body."""

    begin: float  # m, from the body's middle
    end: float  # m, its end
    half_length: float  # m, half the body's length
    bin_count: int  # bins along it


@kernel
def add_to_rows(factors, factor, axial_range):
    """Add a factor to those of the rows of bins along a body within an AxialRange, in part to those partly within."""
    bins_per_length = axial_range.bin_count / (2.0 * axial_range.half_length)
    position = _bin_position(axial_range.begin, axial_range.half_length, bins_per_length)
    end_position = _bin_position(axial_range.end, axial_range.half_length, bins_per_length)
    row = min(max(math.floor(position), 0), axial_range.bin_count - 1)
    while position < end_position:
        next_position = end_position if row == axial_range.bin_count - 1 else min(end_position, row + 1.0)
        factors[row] += factor * (next_position - position)
        position, row = next_position, row + 1


@inlined
def add_scaled(bins, start, factor, depths, parts):
    """Add `depths` (m) around a body times a factor to its bins from `start` on, in some `parts` (begin, end)."""
    for begin, end in parts:
        for k in rolled_range(begin, end):
            bins.depths[start + k] += factor * depths[k]


@kernel
def _bin_position(distance, half_length, bins_per_length):
    position = (distance + half_length) * bins_per_length
    nearest_edge = math.floor(position + 0.5)
    return nearest_edge if abs(position - nearest_edge) < EDGE_TOLERANCE else position


@family_with_default
def update_wall_wear(law, joint, wall, j, step_and_totals):
    """Add the wear of a contact at one of the walls; law : of the joint; step_and_totals : Step and WearTotals."""
    step, totals = step_and_totals
    history = fit_strip(joint, j, step)
    fit_profiles(step.workspace, step.step_values[j], 1.0)
    accumulate_distance(step, j, totals.account[j])
    if touches(step.mode[j]):  # the mean pressure is over the times in contact
        accumulate_strip_pressure(joint, step, history, totals.account[j])
    max_line_load = write_slices(joint, history, step)
    begin, slice_count = 0, (int(joint.wear_rows) + 1) // 2
    while begin < slice_count:
        group = group_from(step, begin, slice_count, max_line_load)
        if group.total_slice.load_fraction > 0.0:
            update_group_wear(joint, ENDS[wall], j, step_and_totals, history, group)
        begin = group.end


@update_wall_wear.member(NoWear)
def _update_wall_wear_no_wear(law, joint, wall, j, step_and_totals):
    pass


@kernel
def fit_strip(joint, j, step):
    """Write the profiles of a contact's angles to `step.workspace`; return its StripHistory."""
    axial, strip_values, history = step.axial[j], step.strip, StripHistory(0.0, step.strip, step.step_values[j])
    for body in range(2):
        angles = step.positions[j, body]
        unwrap_angles(angles)
        for end in range(2):
            slope = 0.0
            for i in rolled_range(QUARTER_POINTS + 2):
                slope += END_SLOPES[end, i] * angles[i]
            step.positions[j, SLOPES + body, end * (QUARTER_POINTS + 1)] = slope
    fit_positions(step.workspace, step.positions[j])
    _fit_strip_at(joint, axial, history, 0)
    for i in lane_range(PARTS):
        strip, start_depth = _fit_strip_at(joint, axial, history, i + 1)
        integrals = strips.integrals_of(joint.walls, joint, strip, start_depth)
        strip_values.load_integral[i + 1], strip_values.depth_integral[i + 1] = integrals
    max_reach = strip_values.reach[0]
    for i in range(1, PARTS + 1):
        max_reach = max(max_reach, strip_values.reach[i])
    return StripHistory(max_reach, strip_values, step.step_values[j])


@kernel
def _fit_strip_at(joint, axial, history, i):
    """Write the values of a StripHistory at time number `i`, from those at the quarters of the step.

    Return what `_strip_at` does.
    """
    values, lean, reach, tilt_square = history.values, 0.0, 0.0, 0.0
    for k in range(QUARTER_POINTS + 2):
        lean += FROM_QUARTERS[k, i] * axial.lean[k]
        reach += FROM_QUARTERS[k, i] * axial.reach[k]
        tilt_square += FROM_QUARTERS[k, i] * axial.tilt_square[k]
    values.lean[i], values.reach[i], values.tilt_square[i] = lean, max(reach, 0.0), tilt_square
    strip, start_depth = _strip_at(joint, history, i)
    values.max_depth[i] = strips.largest_depth_along(joint, strip, start_depth)
    return strip, start_depth


@kernel
def fit_depth(history, workspace, factor):
    """Write the coefficients of the strip's largest depth, times a `factor`, to `workspace`."""
    for i in rolled_range(POINTS):
        total = 0.0
        for k in rolled_range(PARTS + 1):
            total += FIT[k, i] * history.values.max_depth[k]
        workspace.step.depth[i] = factor * total


@kernel
def write_slices(joint, history, step):
    """Write the Slices of a strip to `step.wear_buffer`, after the bins; return the largest load per length (1/m)."""
    buffer, first, width = step.wear_buffer, slices_offset(step), len(Slice._fields)
    count, weights = (int(joint.wear_rows) + 1) // 2, step.workspace.step.duration
    for k in rolled_range(first, first + count * width * PARTS):
        buffer[k] = 0.0
    sums = buffer[first : first + count * width * PARTS].reshape(count, width, PARTS)
    for i in lane_range(PARTS):
        add_slices(joint, history, i + 1, i, sums)
        weights[i] = _work_at(history, i + 1)
    work, max_line_load, fraction_sum = row_sum(weights), 0.0, 0.0
    for k in rolled_range(count):
        totals, row = [row_sum(sums[k, i]) for i in range(width)], first + k * width
        inverse = 1.0 / totals[LOADED_WORK] if totals[LOADED_WORK] > 0.0 else 0.0
        buffer[row] = totals[0] / work if inverse > 0.0 else 0.0
        for i in range(1, width):
            buffer[row + i] = totals[i] * inverse
        if buffer[row] > 0.0:
            max_line_load = max(max_line_load, buffer[row] / buffer[row + 1])
        fraction_sum += buffer[row]
    fraction_sum = strips.sum_of_fractions(joint.walls, fraction_sum)
    if fraction_sum > 0.0:
        max_line_load = max_line_load / fraction_sum
        for k in rolled_range(first, first + count * width, width):
            buffer[k] /= fraction_sum
    return max_line_load


@inlined
def _work_at(history, i):
    """Return the weight of time number `i`: the work of friction around it, see WEIGHTS."""
    values = history.step_values
    return WEIGHTS[i] * max(values[KAPPA_ROW, i] * values[FORCE_ROW, i] * abs(values[SLIP_ROW, i]), 0.0)


@kernel
def add_slices(joint, history, i, lane, sums):
    """Add the fields of all slices of a strip at time number `i`, times its weight, to a lane of `sums`.

    sums : (slices, fields, PARTS).  Depths are relative to the strip's largest one; the depth at the strip's begin is 0
    at every onset and separation of an end.  Force and depth are two polynomials over the step: of a strip that is
    about to touch, the force may be above 0 where the whole depth is not, and its depth is even.
    """
    walls, slice_length, weight = joint.walls, 2.0 * history.reach / int(joint.wear_rows), _work_at(history, i)
    if weight <= 0.0:
        return
    strip, start_depth = _strip_at(joint, history, i)
    largest_depth, total = history.values.max_depth[i], history.values.load_integral[i]
    inner_depth = strips.depth_along(walls, joint, strip, start_depth, strip.reach)
    depth_factor = 1.0 / largest_depth if largest_depth > 0.0 else 0.0 * largest_depth
    load_factor = weight / total if total > 0.0 else 0.0 * total
    near, near_depth = 0.0 * total, start_depth
    for k in rolled_range((int(joint.wear_rows) + 1) // 2):
        begin, far = k * slice_length, min((k + 1) * slice_length, strip.reach)
        far_depth = strips.depth_along(walls, joint, strip, start_depth, far)
        load = load_factor * strips.load_integral(walls, joint, far - near, (near_depth, far_depth))
        if total <= 0.0 and k == 0:  # a point has its load at its start
            load = weight
        if load > 0.0:
            sums[k, 0, lane] += load
            loaded_start, loaded_end = strips.pressed_part(walls, joint, strip, start_depth, (near, far))
            if loaded_end > loaded_start:
                depth = 0.5 * (max(near_depth, 0.0) + max(far_depth, 0.0))
                sums[k, 1, lane] += load * (loaded_end - loaded_start)
                sums[k, 2, lane] += load * (depth * depth_factor if largest_depth > 0.0 else 1.0)
                sums[k, 3, lane] += load * (loaded_start - begin)
                sums[k, LOADED_WORK, lane] += load
        if max(far_depth, inner_depth) <= 0.0:  # and so between them
            break
        near, near_depth = far, far_depth


@inlined
def slices_offset(step):
    """Return where the slices begin in `step.wear_buffer`."""
    return 2 * step.wear_buffer.size // BUFFER_ROWS


@inlined
def slices_size(bin_count):
    """Return how many numbers the slices of a strip take; the buffer behind them is free once they are written."""
    return len(Slice._fields) * ((bin_count + 1) // 2)


@kernel
def slice_at(step, k):
    """Return Slice `k` of the written ones."""
    offset = slices_offset(step) + len(Slice._fields) * k
    return Slice(*[step.wear_buffer[offset + i] for i in range(len(Slice._fields))])


class SliceGroup(NamedTuple):
    """Slices that are processed together, because their loads per length are similar."""

    begin: int
    end: int
    total_slice: Slice


@kernel
def group_from(step, begin, slice_count, max_line_load):
    """Return the SliceGroup from slice `begin` on; max_line_load : 1/m, the result of `write_slices`."""
    load_fraction_sum = length_sum = depth_sum = first_line_load = 0.0
    end = begin
    while end < slice_count:
        strip_slice = slice_at(step, end)
        if strip_slice.load_fraction <= 0.0:
            break
        line_load = strip_slice.load_fraction / strip_slice.loaded_length
        if end == begin:
            first_line_load = line_load
        if abs(line_load - first_line_load) > LOAD_TOLERANCE * max_line_load:
            break
        load_fraction_sum = load_fraction_sum + strip_slice.load_fraction
        length_sum = length_sum + strip_slice.loaded_length
        depth_sum = depth_sum + strip_slice.load_fraction * strip_slice.depth
        end += 1
    return SliceGroup(
        begin,
        max(end, begin + 1),
        Slice(load_fraction_sum, length_sum, depth_sum / load_fraction_sum if load_fraction_sum > 0.0 else 0.0, 0.0),
    )


@kernel
def update_group_wear(joint, end, j, step_and_totals, history, group):
    """Add the wear of a SliceGroup of a StripHistory of a contact at one of the ENDS."""
    step, totals = step_and_totals
    workspace = step.workspace
    count = int(joint.wear.bins)
    bin_count = int(joint.wear_rows)
    group_slice = group.total_slice
    fit_profiles(step.workspace, step.step_values[j], group_slice.loaded_length / group_slice.load_fraction)
    fit_depth(history, workspace, group_slice.depth)
    group_bins = Bins(step.wear_buffer, 0, count), Bins(step.wear_buffer, totals.stride, count)
    account = JointAccount(totals.account[j], group_slice.loaded_length / joint.wear.length)
    reverses = is_reversing(workspace, step.step_values[j])
    update_worn_profile(joint, workspace, step.step_values[j], step.length, group_bins, account)
    axial, middle = step.axial[j], QUARTER_POINTS // 2 + 1
    bodies = (
        (axial.bearing_start[middle], -end * axial.facing[middle], joint.half_length, workspace.bearing),
        (axial.journal_start[middle], -end, joint.journal_half_length, workspace.journal),
    )
    slice_length, factors_start = 2.0 * history.reach / bin_count, slices_offset(step) + slices_size(bin_count)
    factors = step.wear_buffer[factors_start : factors_start + 2 * bin_count].reshape(2, bin_count)
    for row in rolled_range(bin_count):
        factors[0, row] = factors[1, row] = 0.0
    factor_per_load = group_slice.loaded_length / group_slice.load_fraction
    for k in range(group.begin, group.end):
        strip_slice = slice_at(step, k)
        factor = factor_per_load * strip_slice.load_fraction / strip_slice.loaded_length
        for body, (start, direction, half_length, _) in enumerate(bodies):
            near_end = start + direction * (k * slice_length + strip_slice.begin)
            far_end = near_end + direction * strip_slice.loaded_length
            axial_range = AxialRange(min(near_end, far_end), max(near_end, far_end), half_length, bin_count)
            add_to_rows(factors[body], factor, axial_range)
    bins_offset = 2 * (j if end == ENDS[0] else j - 1) * totals.stride
    for body, (_, _, _, arcs) in enumerate(bodies):
        depths = step.wear_buffer[body * totals.stride : body * totals.stride + count]
        bins, worn = Bins(totals.depths, bins_offset + body * totals.stride, count), worn_bins(arcs, count, reverses)
        for row in rolled_range(bin_count):
            if factors[body, row] != 0.0:
                add_scaled(bins, bins.start + row * count, factors[body, row], depths, worn)
        for begin, stop in worn:
            for k in rolled_range(begin, stop):
                depths[k] = 0.0


@update_joint_wear.member(Through, Flanged)
def _update_joint_wear_through_or_flanged(joint, j, step_and_totals):
    for wall in range(len(ENDS)):
        if strips.carries_load(joint.walls, step_and_totals[0], j, wall):
            update_wall_wear(joint.wear, joint, wall, j + wall, step_and_totals)


# ---------------------------------------------------------------------------------------------- account of a span


@account_pressure.member(Through, Flanged)
def _account_pressure_through_or_flanged(joint, workspace, account):
    pass  # `slices` adds the pressure of a whole strip
