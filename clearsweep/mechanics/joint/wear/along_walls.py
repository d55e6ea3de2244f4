"""The strips along which the walls of a joint in space bear, and how the load lies along them.

A contact of a wall is where the surfaces come deepest; from there the surfaces stay together over a strip that runs
inwards, over half of the length on which journal and bore overlap at most.  Its depth falls in proportion to the way:

    depth(z) = depth - lean z,    0 <= z <= reach.

Where walls are spread, the load per length is the elastic force at this depth, as in the motion, and the strip of an
end that is apart bears, too, where the pressed length goes beyond the middle.  Where walls bear at the ends, the load
is spread along the strip like the depth, as on an elastic foundation (Johnson 1985, Contact Mechanics, section 4.3).
So a parallel journal bears evenly and a tilted one on its edge.
"""

import math
from typing import NamedTuple

from ...compiled.choosing import turns
from ...compiled.family import family, kernel
from ...compiled.vector import dot
from ...observe.histogram import FORCE, PARTS
from ..contract import touches
from ..elastic.contract import elastic_force
from ..spatial import AtEdges, EndContacts, InBore, Overlapping, Spread
from ..spatial.points import is_beyond
from ..spatial.strips import mean_elastic, pressed_between


class Slope(NamedTuple):
    """How the depth falls along a strip, from the deepest point of the surfaces on."""

    reach: float  # m, how far it can go
    lean: float  # 1, by which its depth falls per way


@kernel
def pressed_ways(strip, depth):
    """Return from where to where (m) a strip is pressed, `depth` (m) deep at its begin; nowhere: from 0 to 0."""
    part = pressed_between((depth, depth - strip.lean * strip.reach))
    return strip.reach * part.first, strip.reach * (part.first + part.length)


@kernel
def depth_before(strip, depth, way):
    """Return the integral of the depth (m^2) up to `way` (m) along a strip; depth : at its begin, at least 0."""
    most = min(way, pressed_ways(strip, depth)[1])
    return most * (depth - 0.5 * strip.lean * most)


@kernel
def share_of(strip, depth, low, high):
    """Return the share of the load between two ways (m) along a strip; where that is a point, all is at its begin."""
    total = depth_before(strip, depth, strip.reach)
    if total <= 0.0:
        return 1.0 if low <= 0.0 else 0.0
    return (depth_before(strip, depth, high) - depth_before(strip, depth, low)) / total


@family
def depth_at_end(walls, depth):
    """Return the depth (m) at the begin of a strip by that which is seen of its contact."""


@depth_at_end.member(EndContacts)
def _depth_at_end_end_contacts(walls, depth):
    return max(depth, 0.0)


@depth_at_end.member(Spread)
def _depth_at_end_spread(walls, depth):
    return depth


@family
def load_share(walls, joint, strip, depth, ways):
    """Return the share of a strip's load between two ways (m)."""


@load_share.member(EndContacts)
def _load_share_end_contacts(walls, joint, strip, depth, ways):
    return share_of(strip, depth, ways[0], ways[1])


@load_share.member(Spread)
def _load_share_spread(walls, joint, strip, depth, ways):
    low, high = ways
    total = _borne(joint, strip, depth, 0.0, strip.reach)
    if total <= 0.0:
        return 1.0 if low <= 0.0 else 0.0
    return _borne(joint, strip, depth, low, high) / total


@kernel
def _borne(joint, strip, depth, low, high):
    """Return the integral (N m) of the elastic force, as if of the whole joint, between two ways (m) along a strip."""
    ends = depth - strip.lean * low, depth - strip.lean * high
    return (high - low) * mean_elastic(joint.elastic, joint.walls.rule, ends)


class Loads(NamedTuple):
    """How the load of a strip lies along it."""

    even: float  # N/m, over the length that bears
    depth: float  # m, mean over that length
    most: float  # N/m, where it is deepest
    deepest: float  # m


@family
def loads_along(walls, joint, strip, depth, load):
    """Return the Loads of a strip that bears a load (N); of no length where it bears none, all of it 0."""


@loads_along.member(EndContacts)
def _loads_along_end_contacts(walls, joint, strip, depth, load):
    cover, area = pressed_ways(strip, depth)[1], depth_before(strip, depth, strip.reach)
    if area <= 0.0:
        return Loads(0.0, 0.0, 0.0, 0.0)
    deepest = max_depth(strip, depth)
    return Loads(load / cover, area / cover, load * deepest / area, deepest)


@loads_along.member(Spread)
def _loads_along_spread(walls, joint, strip, depth, load):
    (first, until), total = pressed_ways(strip, depth), _borne(joint, strip, depth, 0.0, strip.reach)
    cover, deepest = until - first, max_depth(strip, depth)
    if total <= 0.0 or cover <= 0.0:
        return Loads(0.0, 0.0, 0.0, 0.0)
    most = load * elastic_force(joint.elastic, deepest) / total
    return Loads(load / cover, depth - strip.lean * (first + 0.5 * cover), most, deepest)


@kernel
def max_depth(strip, depth):
    """Return the largest depth (m) along a strip; below 0 it bears nowhere."""
    return max(depth, depth - strip.lean * strip.reach)


@family
def bears(walls, step, j, wall):
    """Return whether the strip of one of two walls bears in a step.Step, `j` being the contact of the first one."""


@bears.member(EndContacts)
def _bears_end_contacts(walls, step, j, wall):
    return touches(step.mode[j + wall])


@bears.member(Spread)
def _bears_spread(walls, step, j, wall):
    if touches(step.mode[j + wall]):
        return True
    most = 0.0
    for i in turns(PARTS + 1):
        most = max(most, step.step_values[j + wall, FORCE, i])
    return touches(step.mode[j + 1 - wall]) and most > 0.0


# ---------------------------------------------------------------------------------------------- where it is


class Placed(NamedTuple):
    """How a strip lies."""

    lean: float  # 1, by which its depth falls per way
    on_bearing: float  # m, where it begins, along the bearing from its middle
    on_journal: float  # m, along the journal
    facing: float  # 1 where both axes point the same way, else -1


@family
def placed(ends, joint, gap, point, end):
    """Return how the strip of the wall contact at one of the ENDS is Placed, whose deepest Point is known."""


@placed.member(InBore)
def _placed_in_bore(ends, joint, gap, point, end):
    facing = math.copysign(1.0, gap.axis.z)
    return Placed(end * point.normal.z, dot(point.at, gap.axis), end * joint.half_journal, facing)


@placed.member(AtEdges)
def _placed_at_edges(ends, joint, gap, point, end):
    facing = math.copysign(1.0, gap.axis.z)
    out = end * facing
    return Placed(-out * dot(point.normal, gap.axis), out * joint.half_length, point.at.z - gap.middle.z, facing)


@placed.member(Overlapping)
def _placed_overlapping(ends, joint, gap, point, end):
    if is_beyond(joint, gap, end):
        return placed(AtEdges(), joint, gap, point, end)
    return placed(InBore(), joint, gap, point, end)
