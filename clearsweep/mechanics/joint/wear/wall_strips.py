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
from ..spatial.points import is_past_edge
from ..spatial.strips import mean_elastic, pressed_between


class DepthProfile(NamedTuple):
    """Depth along a strip, from the deepest point of the surfaces."""

    reach: float  # m, largest length of the strip
    lean: float  # 1, decrease of depth per length


@kernel
def pressed_range(strip, depth):
    """Return (begin, end) (m) of the pressed part of a strip of `depth` (m) at its start; (0, 0) without contact."""
    pressed = pressed_between((depth, depth - strip.lean * strip.reach))
    return strip.reach * pressed.start_fraction, strip.reach * (pressed.start_fraction + pressed.length_fraction)


@kernel
def depth_integral(strip, depth, distance):
    """Return the integral (m^2) of the depth up to `distance` (m) along a strip; depth : at its start, at least 0."""
    stop_distance = min(distance, pressed_range(strip, depth)[1])
    return stop_distance * (depth - 0.5 * strip.lean * stop_distance)


@kernel
def foundation_load_fraction(strip, depth, low, high):
    """Return the load fraction between two distances (m) along a strip on a foundation; a point has it at its start."""
    total = depth_integral(strip, depth, strip.reach)
    if total <= 0.0:
        return 1.0 if low <= 0.0 else 0.0
    return (depth_integral(strip, depth, high) - depth_integral(strip, depth, low)) / total


@family
def depth_at_start(walls, depth):
    """Return the depth (m) at the start of a strip from the depth of its contact."""


@depth_at_start.member(EndContacts)
def _depth_at_start_end_contacts(walls, depth):
    return max(depth, 0.0)


@depth_at_start.member(Spread)
def _depth_at_start_spread(walls, depth):
    return depth


@family
def load_fraction(walls, joint, strip, depth, interval):
    """Return the fraction of a strip's load between two distances (m) along it."""


@load_fraction.member(EndContacts)
def _load_fraction_end_contacts(walls, joint, strip, depth, interval):
    return foundation_load_fraction(strip, depth, interval[0], interval[1])


@load_fraction.member(Spread)
def _load_fraction_spread(walls, joint, strip, depth, interval):
    low, high = interval
    total = _elastic_load(joint, strip, depth, 0.0, strip.reach)
    if total <= 0.0:
        return 1.0 if low <= 0.0 else 0.0
    return _elastic_load(joint, strip, depth, low, high) / total


@kernel
def _elastic_load(joint, strip, depth, low, high):
    """Return the integral (N m) of the elastic force of the whole joint between two distances (m) along a strip."""
    end_depths = depth - strip.lean * low, depth - strip.lean * high
    return (high - low) * mean_elastic(joint.elastic, joint.walls.rule, end_depths)


class LoadDistribution(NamedTuple):
    """Distribution of the load along a strip."""

    mean_load: float  # N/m, mean over the loaded length
    mean_depth: float  # m, mean over that length
    max_load: float  # N/m, at the deepest point
    max_depth: float  # m, at that point


@family
def loads_along(walls, joint, strip, depth, load):
    """Return the LoadDistribution of a strip that carries a load (N); all are 0 without load."""


@loads_along.member(EndContacts)
def _loads_along_end_contacts(walls, joint, strip, depth, load):
    loaded_length, area = pressed_range(strip, depth)[1], depth_integral(strip, depth, strip.reach)
    if area <= 0.0:
        return LoadDistribution(0.0, 0.0, 0.0, 0.0)
    largest_depth = largest_depth_along(strip, depth)
    return LoadDistribution(load / loaded_length, area / loaded_length, load * largest_depth / area, largest_depth)


@loads_along.member(Spread)
def _loads_along_spread(walls, joint, strip, depth, load):
    (loaded_start, loaded_end), total = (
        pressed_range(strip, depth),
        _elastic_load(joint, strip, depth, 0.0, strip.reach),
    )
    loaded_length, largest_depth = loaded_end - loaded_start, largest_depth_along(strip, depth)
    if total <= 0.0 or loaded_length <= 0.0:
        return LoadDistribution(0.0, 0.0, 0.0, 0.0)
    max_load = load * elastic_force(joint.elastic, largest_depth) / total
    return LoadDistribution(
        load / loaded_length, depth - strip.lean * (loaded_start + 0.5 * loaded_length), max_load, largest_depth
    )


@kernel
def largest_depth_along(strip, depth):
    """Return the largest depth (m) along a strip; negative without contact."""
    return max(depth, depth - strip.lean * strip.reach)


@family
def carries_load(walls, step, j, wall):
    """Return whether the strip of one of two walls carries load in a step.Step; `j` : contact of the first wall."""


@carries_load.member(EndContacts)
def _carries_load_end_contacts(walls, step, j, wall):
    return touches(step.mode[j + wall])


@carries_load.member(Spread)
def _carries_load_spread(walls, step, j, wall):
    if touches(step.mode[j + wall]):
        return True
    largest_force = 0.0
    for i in rolled_range(PARTS + 1):
        largest_force = max(largest_force, step.step_values[j + wall, FORCE_ROW, i])
    return touches(step.mode[j + 1 - wall]) and largest_force > 0.0


# ---------------------------------------------------------------------------------------------- position


class StripPosition(NamedTuple):
    """Position of a strip."""

    lean: float  # 1, decrease of depth per length
    bearing_start: float  # m, position of its start along the bearing, from the bearing's middle
    journal_start: float  # m, position of its start along the journal, from the journal's middle
    facing: float  # 1 where both axes point the same way, else -1


@family
def strip_position(end_type, joint, gap, point, end):
    """Return the StripPosition of the wall contact at one of the ENDS, from its deepest Point."""


@strip_position.member(InBore)
def _strip_position_in_bore(end_type, joint, gap, point, end):
    facing = math.copysign(1.0, gap.axis.z)
    return StripPosition(end * point.normal.z, dot(point.position, gap.axis), end * joint.journal_half_length, facing)


@strip_position.member(AtEdges)
def _strip_position_at_edges(end_type, joint, gap, point, end):
    facing = math.copysign(1.0, gap.axis.z)
    outward = end * facing
    return StripPosition(
        -outward * dot(point.normal, gap.axis), outward * joint.half_length, point.position.z - gap.middle.z, facing
    )


@strip_position.member(Overlapping)
def _strip_position_overlapping(end_type, joint, gap, point, end):
    if is_past_edge(joint, gap, end):
        return strip_position(AtEdges(), joint, gap, point, end)
    return strip_position(InBore(), joint, gap, point, end)
