"""Contact strips along the walls of a spatial joint, and the distribution of the load along them.

A wall contact is at the deepest point of the surfaces.  From there the surfaces touch over a strip that extends
inwards, over at most half of the length on which journal and bore overlap.  Its depth decreases linearly:

    depth(z) = depth - lean z,    0 <= z <= reach.

For spread walls, the load per length is the elastic force at this depth, as in the equations of motion.  If one end is
separated, its strip still carries load where the contact of the other end extends past the middle.  For walls that
carry load at their ends, the load along the strip is proportional to the depth, as on an elastic foundation (Johnson
1985, Contact Mechanics, section 4.3).  So a parallel journal is loaded evenly and a tilted journal at its edge.
"""

import math
from typing import NamedTuple

from ...compiled.choosing import rolled_range
from ...compiled.family import family, kernel
from ...compiled.vector import dot
from ...observe.histogram import FORCE_ROW, PARTS
from ..elastic.contract import elastic_force
from ..modes import touches
from ..spatial import AtEdges, EndContacts, InBore, Overlapping, Spread
from ..spatial.points import is_beyond
from ..spatial.strips import mean_elastic, pressed_between


class Slope(NamedTuple):
    """Depth along a strip, from the deepest point of the surfaces."""

    reach: float  # m, largest length of the strip
    lean: float  # 1, decrease of depth per length


@kernel
def pressed_range(strip, depth):
    """Return (begin, end) (m) of the pressed part of a strip of `depth` (m) at its start; (0, 0) without contact."""
    pressed_range = pressed_between((depth, depth - strip.lean * strip.reach))
    return strip.reach * pressed_range.first, strip.reach * (pressed_range.first + pressed_range.length)


@kernel
def depth_before(strip, depth, distance):
    """Return the integral (m^2) of the depth up to `distance` (m) along a strip; depth : at its start, at least 0."""
    stop_distance = min(distance, pressed_range(strip, depth)[1])
    return stop_distance * (depth - 0.5 * strip.lean * stop_distance)


@kernel
def share_of(strip, depth, low, high):
    """Return the share of the load between two places (m) along a strip; for a point, all load is at its start."""
    total = depth_before(strip, depth, strip.reach)
    if total <= 0.0:
        return 1.0 if low <= 0.0 else 0.0
    return (depth_before(strip, depth, high) - depth_before(strip, depth, low)) / total


@family
def depth_at_end(walls, depth):
    """Return the depth (m) at the start of a strip from the depth of its contact."""


@depth_at_end.member(EndContacts)
def _depth_at_end_end_contacts(walls, depth):
    return max(depth, 0.0)


@depth_at_end.member(Spread)
def _depth_at_end_spread(walls, depth):
    return depth


@family
def load_share(walls, joint, strip, depth, interval):
    """Return the share of a strip's load between two places (m)."""


@load_share.member(EndContacts)
def _load_share_end_contacts(walls, joint, strip, depth, interval):
    return share_of(strip, depth, interval[0], interval[1])


@load_share.member(Spread)
def _load_share_spread(walls, joint, strip, depth, interval):
    low, high = interval
    total = _elastic_load(joint, strip, depth, 0.0, strip.reach)
    if total <= 0.0:
        return 1.0 if low <= 0.0 else 0.0
    return _elastic_load(joint, strip, depth, low, high) / total


@kernel
def _elastic_load(joint, strip, depth, low, high):
    """Return the integral (N m) of the elastic force of the whole joint between two places (m) along a strip."""
    end_depths = depth - strip.lean * low, depth - strip.lean * high
    return (high - low) * mean_elastic(joint.elastic, joint.walls.rule, end_depths)


class Loads(NamedTuple):
    """Distribution of the load along a strip."""

    even: float  # N/m, over the loaded length
    depth: float  # m, mean over that length
    most: float  # N/m, at the deepest place
    deepest: float  # m


@family
def loads_along(walls, joint, strip, depth, load):
    """Return the Loads of a strip that carries a load (N); all are 0 without load."""


@loads_along.member(EndContacts)
def _loads_along_end_contacts(walls, joint, strip, depth, load):
    cover, area = pressed_range(strip, depth)[1], depth_before(strip, depth, strip.reach)
    if area <= 0.0:
        return Loads(0.0, 0.0, 0.0, 0.0)
    deepest_point = max_depth(strip, depth)
    return Loads(load / cover, area / cover, load * deepest_point / area, deepest_point)


@loads_along.member(Spread)
def _loads_along_spread(walls, joint, strip, depth, load):
    (cover_start, cover_end), total = pressed_range(strip, depth), _elastic_load(joint, strip, depth, 0.0, strip.reach)
    cover, deepest_point = cover_end - cover_start, max_depth(strip, depth)
    if total <= 0.0 or cover <= 0.0:
        return Loads(0.0, 0.0, 0.0, 0.0)
    stop_distance = load * elastic_force(joint.elastic, deepest_point) / total
    return Loads(load / cover, depth - strip.lean * (cover_start + 0.5 * cover), stop_distance, deepest_point)


@kernel
def max_depth(strip, depth):
    """Return the largest depth (m) along a strip; negative without contact."""
    return max(depth, depth - strip.lean * strip.reach)


@family
def bears(walls, step, j, wall):
    """Return whether the strip of one of two walls carries load in a step.Step; `j` : contact of the first wall."""


@bears.member(EndContacts)
def _bears_end_contacts(walls, step, j, wall):
    return touches(step.mode[j + wall])


@bears.member(Spread)
def _bears_spread(walls, step, j, wall):
    if touches(step.mode[j + wall]):
        return True
    stop_distance = 0.0
    for i in rolled_range(PARTS + 1):
        stop_distance = max(stop_distance, step.step_values[j + wall, FORCE_ROW, i])
    return touches(step.mode[j + 1 - wall]) and stop_distance > 0.0


# ---------------------------------------------------------------------------------------------- where it is


class Placed(NamedTuple):
    """Position of a strip."""

    lean: float  # 1, decrease of depth per length
    on_bearing: float  # m, its begin along the bearing, from the middle of the bearing
    on_journal: float  # m, along the journal
    facing: float  # 1 where both axes point the same way, else -1


@family
def placed(end_depths, joint, gap, point, end):
    """Return the Placed of the strip of the wall contact at one of the ENDS, from its deepest Point."""


@placed.member(InBore)
def _placed_in_bore(end_depths, joint, gap, point, end):
    facing = math.copysign(1.0, gap.axis.z)
    return Placed(end * point.normal.z, dot(point.position, gap.axis), end * joint.half_journal, facing)


@placed.member(AtEdges)
def _placed_at_edges(end_depths, joint, gap, point, end):
    facing = math.copysign(1.0, gap.axis.z)
    outward = end * facing
    return Placed(
        -outward * dot(point.normal, gap.axis), outward * joint.half_length, point.position.z - gap.middle.z, facing
    )


@placed.member(Overlapping)
def _placed_overlapping(end_depths, joint, gap, point, end):
    if is_beyond(joint, gap, end):
        return placed(AtEdges(), joint, gap, point, end)
    return placed(InBore(), joint, gap, point, end)
