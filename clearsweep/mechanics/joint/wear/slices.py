"""Wear of a spatial joint over angle and length: the contact strip of each wall is cut into slices.

`wall_strips` gives the position and load of the strips.  Each slice wears like a planar joint under its share of the
load; over a step its share is that of the work, so the total is conserved.  The bins of each body are along its own
axis, around its own x axis.  Wear beyond a body's end is added at its end.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.choosing import rolled_range
from ...compiled.family import family, kernel
from ...compiled.vector import cross, dot, plus_scaled
from ...observe.histogram import DEPTH_ROW, FORCE_ROW, KAPPA_ROW, PARTS, QUARTER_POINTS, SLIP_ROW
from ...trace.portable import coefficients_through, exact, powers
from ..modes import touches
from ..spatial import ENDS, Flanged, Through, bearing_length, wall_point
from .arc_over_step import FIT, POINTS, sliding_contact_of
from .binning import accumulate_wear
from .contract import (
    PRESSURE_MAX,
    PRESSURE_TIME,
    PV_BEYOND,
    PV_MAX,
    Bins,
    NoWear,
    SlidingContact,
    half_arc,
    peak_over_mean,
)
from .step import (
    BEARING_START,
    FACING,
    JOURNAL_START,
    LEAN,
    MAX_DEPTH,
    REACH,
    SLOPES,
    SMALLEST_ARC,
    accumulate_arc_width,
    accumulate_distance,
    fit_places,
    fit_profiles,
    record,
    unwrap_angles,
    wear_joint,
)
from .wall_strips import (
    Slope,
    bears,
    depth_at_end,
    load_share,
    loads_along,
    max_depth,
    placed,
    pressed_range,
)

SAME_LOAD = 0.2  # of the largest load per length: slices with smaller differences share one arc width
EDGE_TOLERANCE = 1e-9  # of a bin's length: a slice that ends closer to an edge ends at it
_QUARTERS = np.arange(QUARTER_POINTS + 2) / (QUARTER_POINTS + 1)
_POWERS = coefficients_through(_QUARTERS)
#: (PARTS + 1, QUARTER_POINTS + 2): values at equidistant times of a step from those at its quarters.
FROM_QUARTERS = (powers(np.arange(PARTS + 1) / PARTS, QUARTER_POINTS + 2) @ _POWERS).rounded()
#: (2, QUARTER_POINTS + 2): slopes at both ends of a step, per its length.
END_SLOPES = (
    exact([[float(p * at ** max(p - 1, 0)) for p in range(QUARTER_POINTS + 2)] for at in (0.0, 1.0)]) @ _POWERS
).rounded()


@record.member(Through)
@record.member(Flanged)
def _record_through_or_flanged(joint, gap, body_angles, j, moment):
    for wall in range(len(ENDS)):
        if bears(joint.walls, moment.step, j, wall):
            _record_wall(joint, gap, body_angles, (j + wall, ENDS[wall]), moment)


@kernel
def _record_wall(joint, gap, body_angles, contact, moment):
    """Record the position of a contact at one of the ENDS: its number, its end."""
    step, i, (c, end) = moment.step, moment.number, contact
    point = wall_point(joint.ends, joint, gap, end)
    transverse = plus_scaled(point.normal, -dot(point.normal, gap.axis), gap.axis)
    step.positions[c, 0, i] = math.atan2(dot(transverse, cross(gap.axis, body_angles)), dot(transverse, body_angles))
    step.positions[c, 1, i] = math.atan2(point.normal.y, point.normal.x)
    placement = placed(joint.ends, joint, gap, point, end)
    step.axial[c, LEAN, i], step.axial[c, REACH, i] = placement.lean, bearing_length(joint.ends, joint, gap).half
    step.axial[c, BEARING_START, i], step.axial[c, JOURNAL_START, i] = placement.on_bearing, placement.on_journal
    step.axial[c, FACING, i] = placement.facing


# ---------------------------------------------------------------------------------------------- slices


class Slice(NamedTuple):
    """A slice over a step: means weighted by the work of friction."""

    share: float  # of the load
    cover: float  # m, length that carries load
    depth: float  # of the strip's largest depth, mean over that length: 0 to 1
    begin: float  # m, from its near end to the part that carries load


class Strips(NamedTuple):
    """The strip of a contact at equidistant times of a step."""

    reach: float  # m, the largest
    values: np.ndarray  # (STRIP, PARTS + 1)
    step_values: np.ndarray  # (STEP_VALUE_ROWS, PARTS + 1) of the contact


@kernel
def _strip_at(joint, strips, i):
    """Return the Slope of a strip and its depth (m) at equidistant time number `i`."""
    return Slope(strips.values[REACH, i], strips.values[LEAN, i]), depth_at_end(
        joint.walls, strips.step_values[DEPTH_ROW, i]
    )


@kernel
def slice_of(joint, strips, low, high):
    """Return the Slice between two distances (m) along the strip of a contact; beyond its reach there is no load.

    Its depth is relative to the strip's largest one.  That is above 0 under load; the depth at the strip's
    begin is 0 at every onset and separation of an end.
    """
    step_values, work, load = strips.step_values, 0.0, 0.0
    share = cover = depth = begin = 0.0
    for i in rolled_range(PARTS + 1):
        weight = 0.5 if i in (0, PARTS) else 1.0  # the trapezoidal rule
        weight *= max(step_values[KAPPA_ROW, i] * step_values[FORCE_ROW, i] * abs(step_values[SLIP_ROW, i]), 0.0)
        if weight <= 0.0:
            continue
        strip, depth_at = _strip_at(joint, strips, i)
        near_end, far_end, max_depth_ = min(low, strip.reach), min(high, strip.reach), strips.values[MAX_DEPTH, i]
        slice_share = load_share(joint.walls, joint, strip, depth_at, (near_end, far_end))
        cover_start, cover_end = pressed_range(strip, depth_at)
        cover_start, cover_end = max(cover_start, near_end), min(cover_end, far_end)
        share += weight * slice_share
        work += weight
        if cover_end > cover_start:
            cover += weight * slice_share * (cover_end - cover_start)
            begin += weight * slice_share * (cover_start - low)
            mean = depth_at - 0.5 * strip.lean * (cover_start + cover_end)
            depth += weight * slice_share * mean / max_depth_
            load += weight * slice_share
    if load <= 0.0:
        return Slice(0.0, 0.0, 0.0, 0.0)
    return Slice(share / work, cover / load, depth / load, begin / load)


@kernel
def accumulate_strip_pressure(joint, step, strips, account):
    """Record pressure and pressure times sliding speed of a wall contact at equidistant places of the step."""
    law, step_values = joint.wear, strips.step_values
    for i in rolled_range(PARTS + 1):
        strip, depth_at = _strip_at(joint, strips, i)
        load, slip = max(step_values[FORCE_ROW, i], 0.0), step_values[SLIP_ROW, i]
        loads = loads_along(joint.walls, joint, strip, depth_at, load)
        if loads.deepest <= 0.0:
            continue
        mean_sliding = sliding_contact_of(joint, (loads.even, 0.0, slip, loads.depth, 0.0), 0.0, joint.clearance)
        max_depth_ = sliding_contact_of(joint, (loads.most, 0.0, slip, loads.deepest, 0.0), 0.0, joint.clearance)
        half_angle, half_most = _half(joint, mean_sliding), _half(joint, max_depth_)
        if min(half_angle, half_most) < SMALLEST_ARC:
            continue
        peak = (
            max_depth_.pressure_sum / (2.0 * joint.bearing_radius * half_most) * peak_over_mean(law.pressure, half_most)
        )
        time = (0.5 if i in (0, PARTS) else 1.0) / PARTS * step.length * step_values[KAPPA_ROW, i]
        account[PRESSURE_TIME] += mean_sliding.pressure_sum / (2.0 * joint.bearing_radius * half_angle) * time
        account[PRESSURE_MAX] = max(account[PRESSURE_MAX], peak)
        account[PV_MAX] = max(account[PV_MAX], peak * max_depth_.slip)
        if peak * max_depth_.slip > law.pv_limit:
            account[PV_BEYOND] += time


@kernel
def _half(joint, sliding: SlidingContact):
    return half_arc(joint.wear.pressure, joint, joint.bearing_radius, sliding)


class AxialRange(NamedTuple):
    """Position of a slice on a body."""

    begin: float  # m, from the body's middle
    end: float  # m, its end
    half: float  # m, half the body's length
    rows: int  # bins along it


@kernel
def accumulate_axially(depths, factor, bins, placement):
    """Add `depths` (m) around a body, times a factor, to its bins over angle and length.

    placement : position on the body; each bin is the mean over its length.
    """
    per_length = placement.rows / (2.0 * placement.half)
    cover_start, last = (
        _in_bins(placement.begin, placement.half, per_length),
        _in_bins(placement.end, placement.half, per_length),
    )
    row = min(max(math.floor(cover_start), 0), placement.rows - 1)
    while cover_start < last:
        cover_end = last if row == placement.rows - 1 else min(last, row + 1.0)
        slice_share, start = factor * (cover_end - cover_start), bins.first + row * bins.count
        for k in rolled_range(bins.count):
            bins.depths[start + k] += slice_share * depths[k]
        cover_start, row = cover_end, row + 1


@kernel
def _in_bins(angle, half_angle, per_length):
    position = (angle + half_angle) * per_length
    nearest_edge = math.floor(position + 0.5)
    return nearest_edge if abs(position - nearest_edge) < EDGE_TOLERANCE else position


@family
def wear_wall(law, joint, wall, c, shared):
    """Add the wear of contact `c`, at one of the walls, of a joint with this wear law; shared : Step and Worn."""


@wear_wall.member(NoWear)
def _wear_wall_no_wear(law, joint, wall, c, shared):
    pass


@kernel
def fit_strip(joint, c, step):
    """Write the profiles of the angles of contact `c` to `step.workspace`; return its Strips."""
    observed, strip_values, strips = step.axial[c], step.strip, Strips(0.0, step.strip, step.step_values[c])
    for body in range(2):
        angles = step.positions[c, body]
        unwrap_angles(angles)
        for side in range(2):
            slope = 0.0
            for i in rolled_range(QUARTER_POINTS + 2):
                slope += END_SLOPES[side, i] * angles[i]
            step.positions[c, SLOPES + body, side * (QUARTER_POINTS + 1)] = slope
    fit_places(step.workspace, step.positions[c])
    longest_slice = 0.0
    for i in rolled_range(PARTS + 1):
        strip_values[LEAN, i] = strip_values[REACH, i] = 0.0
        for k in rolled_range(QUARTER_POINTS + 2):
            strip_values[LEAN, i] += FROM_QUARTERS[i, k] * observed[LEAN, k]
            strip_values[REACH, i] += FROM_QUARTERS[i, k] * observed[REACH, k]
        strip_values[REACH, i] = max(strip_values[REACH, i], 0.0)
        longest_slice = max(longest_slice, strip_values[REACH, i])
        strip, depth_at = _strip_at(joint, strips, i)
        strip_values[MAX_DEPTH, i] = max_depth(strip, depth_at)
    return Strips(longest_slice, strip_values, step.step_values[c])


@kernel
def fit_depth(strips, workspace, share):
    """Write the coefficients of the strip's largest depth, times a share of it, to `workspace`."""
    for i in rolled_range(POINTS):
        total = 0.0
        for k in rolled_range(PARTS + 1):
            total += FIT[k, i] * strips.values[MAX_DEPTH, k]
        workspace[DEPTH_ROW * POINTS + i] = share * total


@kernel
def write_slices(joint, strips, step):
    """Write the Slices of a strip to `step.scratch`, after the bins; return the largest load per length (1/m)."""
    rows = int(joint.wear_rows)
    cover_start, slice_length, largest = 2 * step.scratch.size // 3, 2.0 * strips.reach / rows, 0.0
    for k in range((rows + 1) // 2):
        low = k * slice_length
        observed = slice_of(joint, strips, low, min(low + slice_length, strips.reach))
        if observed.share > 0.0:
            largest = max(largest, observed.share / observed.cover)
        slot = cover_start + k * len(observed)
        for i in range(len(observed)):
            step.scratch[slot + i] = observed[i]
    return largest


@kernel
def slice_at(step, k):
    """Return Slice `k` of the written ones."""
    slot = 2 * step.scratch.size // 3 + 4 * k
    return Slice(step.scratch[slot], step.scratch[slot + 1], step.scratch[slot + 2], step.scratch[slot + 3])


class Group(NamedTuple):
    """Slices that are processed together, because their loads per length are similar."""

    begin: int
    end: int
    total_slice: Slice


@kernel
def group_from(step, begin, slices, largest):
    """Return the Group of slices from slice `begin`, of `slices` in all; largest : result of write_slices."""
    share = cover = depth = load = 0.0
    end = begin
    while end < slices:
        observed = slice_at(step, end)
        if observed.share <= 0.0:
            break
        slot = observed.share / observed.cover
        if end == begin:
            load = slot
        if abs(slot - load) > SAME_LOAD * largest:
            break
        share, cover, depth = share + observed.share, cover + observed.cover, depth + observed.share * observed.depth
        end += 1
    return Group(begin, max(end, begin + 1), Slice(share, cover, depth / share if share > 0.0 else 0.0, 0.0))


@kernel
def accumulate_group(joint, end, c, shared, strips, group):
    """Add the wear of a Group of slices of the Strips of contact `c` at one of the ENDS."""
    step, worn = shared
    workspace, count, rows, total = step.workspace, int(joint.wear.bins), int(joint.wear_rows), group.total_slice
    fit_profiles(step.workspace, step.step_values[c], total.cover / total.share)
    fit_depth(strips, workspace, total.depth)
    scratch = Bins(step.scratch, 0, count), Bins(step.scratch, worn.stride, count)
    accumulate_wear(joint, workspace, step.step_values[c], step.length, scratch)
    accumulate_arc_width(joint, step, worn.account[c], total.cover / joint.wear.length)
    observed, cover_start = (
        step.axial[c, :, QUARTER_POINTS // 2 + 1],
        2 * (c if end == ENDS[0] else c - 1) * worn.stride,
    )
    slice_length = 2.0 * strips.reach / rows
    for body in range(2):
        half_angle = joint.half_length if body == 0 else joint.half_journal
        direction = -end * (observed[FACING] if body == 0 else 1.0)
        depths = step.scratch[body * worn.stride : body * worn.stride + count]
        bins = Bins(worn.depths, cover_start + body * worn.stride, count)
        for k in range(group.begin, group.end):
            slice_share = slice_at(step, k)
            near_end = observed[BEARING_START + body] + direction * (k * slice_length + slice_share.begin)
            far_end = near_end + direction * slice_share.cover
            factor = slice_share.share * total.cover / (slice_share.cover * total.share)
            accumulate_axially(
                depths, factor, bins, AxialRange(min(near_end, far_end), max(near_end, far_end), half_angle, rows)
            )
        for k in rolled_range(count):
            depths[k] = 0.0


@wear_wall.member(None)
def _default_wear_wall(law, joint, wall, c, shared):
    step, worn = shared
    strips = fit_strip(joint, c, step)
    fit_profiles(step.workspace, step.step_values[c], 1.0)
    accumulate_distance(step, c, worn.account[c])
    if touches(step.mode[c]):  # the mean pressure is over the times in contact
        accumulate_strip_pressure(joint, step, strips, worn.account[c])
    largest = write_slices(joint, strips, step)
    begin, slices = 0, (int(joint.wear_rows) + 1) // 2
    while begin < slices:
        group = group_from(step, begin, slices, largest)
        if group.total_slice.share > 0.0:
            accumulate_group(joint, ENDS[wall], c, shared, strips, group)
        begin = group.end


@wear_joint.member(Through)
@wear_joint.member(Flanged)
def _wear_joint_through_or_flanged(joint, j, shared):
    for wall in range(len(ENDS)):
        if bears(joint.walls, shared[0], j, wall):
            wear_wall(joint.wear, joint, wall, j + wall, shared)
