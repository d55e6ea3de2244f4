"""Wear of a spatial joint over angle and length: the contact strip of each wall is cut into slices.

`along_walls` gives the position and load of the strips.  Each slice wears like a planar joint under its share of the
load; over a step its share is that of the work, so the total is conserved.  The bins of each body are along its own
axis, around its own x axis.  Wear beyond a body's end is added at its end.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.choosing import turns
from ...compiled.family import family, kernel
from ...compiled.vector import cross, dot, plus_scaled
from ...observe.histogram import BETWEEN, DEPTH_COURSE, FORCE, KAPPA_COURSE, PARTS, SLIP_COURSE
from ..contract import touches
from ..spatial import ENDS, Flanged, Through, bearing_length, wall_point
from .along_walls import (
    Slope,
    bears,
    depth_at_end,
    load_share,
    loads_along,
    max_depth,
    placed,
    pressed_ways,
)
from .contract import (
    PRESSURE_MAX,
    PRESSURE_TIME,
    PV_BEYOND,
    PV_MAX,
    Bins,
    NoWear,
    Rubbing,
    half_arc,
    peak_over_mean,
)
from .passage import FIT, POINTS, enter_wear, rubbing_of
from .step import (
    BEARING_START,
    FACING,
    JOURNAL_START,
    LEAN,
    LEAST,
    MAX_DEPTH,
    REACH,
    SLOPES,
    fit_courses,
    fit_places,
    note_arc,
    note_way,
    see,
    wear_joint,
    without_leaps,
)

ALIKE = 0.2  # of the largest load per length: slices with smaller differences share one arc width
NEAR = 1e-9  # of a bin's length: a slice that comes closer to its edge ends there
_QUARTERS = np.arange(BETWEEN + 2) / (BETWEEN + 1)
_POWERS = np.linalg.inv(np.vander(_QUARTERS, increasing=True))
#: (PARTS + 1, BETWEEN + 2): values at even places of a step from those at its quarters.
EVENLY = np.vander(np.arange(PARTS + 1) / PARTS, BETWEEN + 2, increasing=True) @ _POWERS
#: (2, BETWEEN + 2): slopes at both ends of a step, per its length.
END_SLOPES = np.array([[float(p * at ** max(p - 1, 0)) for p in range(BETWEEN + 2)] for at in (0.0, 1.0)]) @ _POWERS


@see.member(Through)
@see.member(Flanged)
def _see_through_or_flanged(joint, gap, turned, j, moment):
    for wall in range(len(ENDS)):
        if bears(joint.walls, moment.step, j, wall):
            _see_wall(joint, gap, turned, (j + wall, ENDS[wall]), moment)


@kernel
def _see_wall(joint, gap, turned, contact, moment):
    """Record the position of a contact at one of the ENDS: its number, its end."""
    step, i, (c, end) = moment.step, moment.number, contact
    point = wall_point(joint.ends, joint, gap, end)
    across = plus_scaled(point.normal, -dot(point.normal, gap.axis), gap.axis)
    step.places[c, 0, i] = math.atan2(dot(across, cross(gap.axis, turned)), dot(across, turned))
    step.places[c, 1, i] = math.atan2(point.normal.y, point.normal.x)
    lies = placed(joint.ends, joint, gap, point, end)
    step.axial[c, LEAN, i], step.axial[c, REACH, i] = lies.lean, bearing_length(joint.ends, joint, gap).half
    step.axial[c, BEARING_START, i], step.axial[c, JOURNAL_START, i] = lies.on_bearing, lies.on_journal
    step.axial[c, FACING, i] = lies.facing


# ---------------------------------------------------------------------------------------------- what is worn


class Slice(NamedTuple):
    """What a slice is over a step: means by the work that rubs."""

    share: float  # of the load
    cover: float  # m, over which it bears
    depth: float  # of the strip's largest depth, mean over that length: 0 to 1
    begin: float  # m, from its near end to where it bears


class Strips(NamedTuple):
    """The strip of a contact at the even places of a step."""

    reach: float  # m, the largest
    at: np.ndarray  # (STRIP, PARTS + 1)
    step_values: np.ndarray  # (COURSES, PARTS + 1) of the contact


@kernel
def _strip_at(joint, strips, i):
    """Return the Slope of a strip and its depth (m) at an even place."""
    return Slope(strips.at[REACH, i], strips.at[LEAN, i]), depth_at_end(
        joint.walls, strips.step_values[DEPTH_COURSE, i]
    )


@kernel
def slice_of(joint, strips, low, high):
    """Return the Slice between two ways (m) along the strip of a contact; what is beyond its reach bears nothing.

    Its depth is compared to the strip's largest one.  That is above 0 while the strip bears; the depth at the strip's
    begin is 0 at every onset and separation of an end.
    """
    step_values, work, load = strips.step_values, 0.0, 0.0
    share = cover = depth = begin = 0.0
    for i in turns(PARTS + 1):
        weight = 0.5 if i in (0, PARTS) else 1.0  # the trapezoidal rule
        weight *= max(step_values[KAPPA_COURSE, i] * step_values[FORCE, i] * abs(step_values[SLIP_COURSE, i]), 0.0)
        if weight <= 0.0:
            continue
        strip, deep = _strip_at(joint, strips, i)
        near, far, most = min(low, strip.reach), min(high, strip.reach), strips.at[MAX_DEPTH, i]
        part = load_share(joint.walls, joint, strip, deep, (near, far))
        first, until = pressed_ways(strip, deep)
        first, until = max(first, near), min(until, far)
        share += weight * part
        work += weight
        if until > first:
            cover += weight * part * (until - first)
            begin += weight * part * (first - low)
            mean = deep - 0.5 * strip.lean * (first + until)
            depth += weight * part * mean / most
            load += weight * part
    if load <= 0.0:
        return Slice(0.0, 0.0, 0.0, 0.0)
    return Slice(share / work, cover / load, depth / load, begin / load)


@kernel
def note_edges(joint, step, strips, account):
    """Record pressure and pressure times sliding speed of a wall contact at equidistant places of the step."""
    law, step_values = joint.wear, strips.step_values
    for i in turns(PARTS + 1):
        strip, deep = _strip_at(joint, strips, i)
        load, slip = max(step_values[FORCE, i], 0.0), step_values[SLIP_COURSE, i]
        loads = loads_along(joint.walls, joint, strip, deep, load)
        if loads.deepest <= 0.0:
            continue
        even = rubbing_of(joint, (loads.even, 0.0, slip, loads.depth, 0.0), 0.0, joint.clearance)
        most = rubbing_of(joint, (loads.most, 0.0, slip, loads.deepest, 0.0), 0.0, joint.clearance)
        half, half_most = _half(joint, even), _half(joint, most)
        if min(half, half_most) < LEAST:
            continue
        peak = most.pressed / (2.0 * joint.bearing_radius * half_most) * peak_over_mean(law.pressure, half_most)
        time = (0.5 if i in (0, PARTS) else 1.0) / PARTS * step.length * step_values[KAPPA_COURSE, i]
        account[PRESSURE_TIME] += even.pressed / (2.0 * joint.bearing_radius * half) * time
        account[PRESSURE_MAX] = max(account[PRESSURE_MAX], peak)
        account[PV_MAX] = max(account[PV_MAX], peak * most.slip)
        if peak * most.slip > law.pv_limit:
            account[PV_BEYOND] += time


@kernel
def _half(joint, rubbing: Rubbing):
    return half_arc(joint.wear.pressure, joint, joint.bearing_radius, rubbing)


class Lies(NamedTuple):
    """Position of a slice on a body."""

    begin: float  # m, from the body's middle
    end: float  # m, its end
    half: float  # m, half the body's length
    rows: int  # bins along it


@kernel
def enter_along(depths, factor, bins, lies):
    """Add `depths` (m) around a body, times a factor, to its bins over angle and length.

    lies : position on the body; each bin is the mean over its length.
    """
    per_length = lies.rows / (2.0 * lies.half)
    first, last = _in_bins(lies.begin, lies.half, per_length), _in_bins(lies.end, lies.half, per_length)
    row = min(max(math.floor(first), 0), lies.rows - 1)
    while first < last:
        until = last if row == lies.rows - 1 else min(last, row + 1.0)
        part, start = factor * (until - first), bins.first + row * bins.count
        for k in turns(bins.count):
            bins.depths[start + k] += part * depths[k]
        first, row = until, row + 1


@kernel
def _in_bins(at, half, per_length):
    place = (at + half) * per_length
    nearest = math.floor(place + 0.5)
    return nearest if abs(place - nearest) < NEAR else place


@family
def wear_wall(law, joint, wall, c, shared):
    """Add the wear of contact `c`, at one of the walls, of a joint with this wear law; shared : Step and Worn."""


@wear_wall.member(NoWear)
def _wear_wall_no_wear(law, joint, wall, c, shared):
    pass


@kernel
def fit_strip(joint, c, step):
    """Write the profiles of the angles of contact `c` to `step.workspace`; return its Strips."""
    seen, at, strips = step.axial[c], step.strip, Strips(0.0, step.strip, step.step_values[c])
    for body in range(2):
        angles = step.places[c, body]
        without_leaps(angles)
        for side in range(2):
            slope = 0.0
            for i in turns(BETWEEN + 2):
                slope += END_SLOPES[side, i] * angles[i]
            step.places[c, SLOPES + body, side * (BETWEEN + 1)] = slope
    fit_places(step, c)
    longest = 0.0
    for i in turns(PARTS + 1):
        at[LEAN, i] = at[REACH, i] = 0.0
        for k in turns(BETWEEN + 2):
            at[LEAN, i] += EVENLY[i, k] * seen[LEAN, k]
            at[REACH, i] += EVENLY[i, k] * seen[REACH, k]
        at[REACH, i] = max(at[REACH, i], 0.0)
        longest = max(longest, at[REACH, i])
        strip, deep = _strip_at(joint, strips, i)
        at[MAX_DEPTH, i] = max_depth(strip, deep)
    return Strips(longest, at, step.step_values[c])


@kernel
def fit_depth(strips, workspace, share):
    """Write the coefficients of the strip's largest depth, times a share of it, to `workspace`."""
    for i in turns(POINTS):
        total = 0.0
        for k in turns(PARTS + 1):
            total += FIT[k, i] * strips.at[MAX_DEPTH, k]
        workspace[DEPTH_COURSE * POINTS + i] = share * total


@kernel
def put_slices(joint, strips, step):
    """Write the Slices of a strip to `step.scratch`, after the bins; return the largest load per length (1/m)."""
    rows = int(joint.wear_rows)
    first, long, largest = 2 * step.scratch.size // 3, 2.0 * strips.reach / rows, 0.0
    for k in range((rows + 1) // 2):
        low = k * long
        seen = slice_of(joint, strips, low, min(low + long, strips.reach))
        if seen.share > 0.0:
            largest = max(largest, seen.share / seen.cover)
        here = first + k * len(seen)
        for i in range(len(seen)):
            step.scratch[here + i] = seen[i]
    return largest


@kernel
def slice_at(step, k):
    """Return Slice `k` of the written ones."""
    here = 2 * step.scratch.size // 3 + 4 * k
    return Slice(step.scratch[here], step.scratch[here + 1], step.scratch[here + 2], step.scratch[here + 3])


class Group(NamedTuple):
    """Slices that are processed together, because their loads per length are similar."""

    begin: int
    end: int
    whole: Slice


@kernel
def group_from(step, begin, slices, largest):
    """Return the Group of slices from slice `begin`, of `slices` in all; largest : result of put_slices."""
    share = cover = depth = load = 0.0
    end = begin
    while end < slices:
        seen = slice_at(step, end)
        if seen.share <= 0.0:
            break
        here = seen.share / seen.cover
        if end == begin:
            load = here
        if abs(here - load) > ALIKE * largest:
            break
        share, cover, depth = share + seen.share, cover + seen.cover, depth + seen.share * seen.depth
        end += 1
    return Group(begin, max(end, begin + 1), Slice(share, cover, depth / share if share > 0.0 else 0.0, 0.0))


@kernel
def enter_group(joint, end, c, shared, strips, group):
    """Add the wear of a Group of slices of the Strips of contact `c` at one of the ENDS."""
    step, worn = shared
    workspace, count, rows, whole = step.workspace, int(joint.wear.bins), int(joint.wear_rows), group.whole
    fit_courses(step, c, whole.cover / whole.share)
    fit_depth(strips, workspace, whole.depth)
    scratch = Bins(step.scratch, 0, count), Bins(step.scratch, worn.stride, count)
    enter_wear(joint, workspace, step.step_values[c], step.length, scratch)
    note_arc(joint, step, worn.account[c], whole.cover / joint.wear.length)
    seen, first = step.axial[c, :, BETWEEN // 2 + 1], 2 * (c if end == ENDS[0] else c - 1) * worn.stride
    long = 2.0 * strips.reach / rows
    for body in range(2):
        half = joint.half_length if body == 0 else joint.half_journal
        way = -end * (seen[FACING] if body == 0 else 1.0)
        depths = step.scratch[body * worn.stride : body * worn.stride + count]
        bins = Bins(worn.depths, first + body * worn.stride, count)
        for k in range(group.begin, group.end):
            part = slice_at(step, k)
            near = seen[BEARING_START + body] + way * (k * long + part.begin)
            far = near + way * part.cover
            factor = part.share * whole.cover / (part.cover * whole.share)
            enter_along(depths, factor, bins, Lies(min(near, far), max(near, far), half, rows))
        for k in turns(count):
            depths[k] = 0.0


@wear_wall.member(None)
def _default_wear_wall(law, joint, wall, c, shared):
    step, worn = shared
    strips = fit_strip(joint, c, step)
    fit_courses(step, c, 1.0)
    note_way(step, c, worn.account[c])
    if touches(step.mode[c]):  # the mean pressure is over the times in contact
        note_edges(joint, step, strips, worn.account[c])
    largest = put_slices(joint, strips, step)
    begin, slices = 0, (int(joint.wear_rows) + 1) // 2
    while begin < slices:
        group = group_from(step, begin, slices, largest)
        if group.whole.share > 0.0:
            enter_group(joint, ENDS[wall], c, shared, strips, group)
        begin = group.end


@wear_joint.member(Through)
@wear_joint.member(Flanged)
def _wear_joint_through_or_flanged(joint, j, shared):
    for wall in range(len(ENDS)):
        if bears(joint.walls, shared[0], j, wall):
            wear_wall(joint.wear, joint, wall, j + wall, shared)
