"""Contact strips along the walls of a spatial joint, and the distribution of the load along them.

A wall contact is at the deepest point of the surfaces.  From there the surfaces touch over a strip that extends
inwards, over at most half of the length on which journal and bore overlap.  Positions z along it are from its start.

For spread walls, depth and load are those of the equations of motion: the distance of the axes is a hyperbola,

    (clearance + depth(z))^2 = (clearance + depth)^2 - 2 (clearance + depth) lean z + tilt_square z^2,

and the load per length is the elastic force at this depth.  If one end is separated, its strip still carries load
where the contact of the other end extends past the middle.

For walls that carry load at their ends, the depth decreases linearly, depth(z) = depth - lean z, and the load along the
strip is proportional to it, as on an elastic foundation (Johnson 1985, Contact Mechanics, section 4.3).  So a parallel
journal is loaded evenly and a tilted journal at its edge.
"""

import math
from typing import NamedTuple

from ....tracing.compiled.choosing import rolled_range
from ....tracing.compiled.family import family, kernel
from ....tracing.compiled.vector import dot
from ...laws.contract import touches
from ...laws.elastic import elastic_force
from ...observe import FORCE_ROW, PARTS
from . import AtEdges, EndContacts, InBore, Overlapping, Spread
from .points import is_past_edge
from .strips import Profile, depth_at, integrals_up_to, lifted_part, mean_elastic


class DepthProfile(NamedTuple):
    """Depth along a strip, from the deepest point of the surfaces."""

    reach: float  # m, largest length of the strip
    lean: float  # 1, decrease of depth per length at its start
    tilt_square: float  # 1, square of the sine of the angle between the axes


@kernel
def _profile_of(joint, strip, depth):
    """Return the Profile of a strip of spread walls; depth : m, at its start."""
    distance, tilt_square = joint.clearance + depth, max(strip.tilt_square, strip.lean * strip.lean)
    return Profile(joint.clearance, depth * (joint.clearance + distance), -distance * strip.lean, tilt_square)


@family
def pressed_part(walls, joint, strip, depth, interval):
    """Return (begin, end) (m) of the pressed part of an interval of a strip; end is not above begin without contact.

    depth : m, at the strip's start.
    """


@pressed_part.member(EndContacts)
def _pressed_part_end_contacts(walls, joint, strip, depth, interval):
    inner_depth, begin, length = depth - strip.lean * strip.reach, 0.0, 1.0
    if depth <= 0.0 and inner_depth <= 0.0:
        length = 0.0
    elif inner_depth <= 0.0:
        length = depth / (depth - inner_depth)
    elif depth <= 0.0:
        length = inner_depth / (inner_depth - depth)
        begin = 1.0 - length
    return max(strip.reach * begin, interval[0]), min(strip.reach * (begin + length), interval[1])


@pressed_part.member(Spread)
def _pressed_part_spread(walls, joint, strip, depth, interval):
    low, high = interval
    lifted = lifted_part(_profile_of(joint, strip, depth), 2.0 * strip.reach, 0.0)
    if low < lifted.begin:
        return low, high if lifted.end < high else min(high, lifted.begin)
    return max(low, lifted.end), high


@family
def integrals_of(walls, joint, strip, depth):
    """Return integrals over a strip: one proportional to its load, and of the depth (m^2); depth : m, at its start."""


@integrals_of.member(EndContacts)
def _integrals_of_end_contacts(walls, joint, strip, depth):
    area = _depth_integral(joint, strip, depth, strip.reach)
    return area, area


@kernel
def _depth_integral(joint, strip, depth, distance):
    """Return the integral (m^2) of a linear depth up to `distance` (m) along a strip; depth : at its start, m."""
    stop_distance = min(distance, pressed_part(joint.walls, joint, strip, depth, (0.0, strip.reach))[1])
    return stop_distance * (depth - 0.5 * strip.lean * stop_distance)


@integrals_of.member(Spread)
def _integrals_of_spread(walls, joint, strip, depth):
    return integrals_up_to(_profile_of(joint, strip, depth), strip.reach, joint.elastic, joint.walls.rule)


@family
def load_integral(walls, joint, strip, depth, interval):
    """Return the first of `integrals_of` over an interval (m), along which the depth of spread walls is straight."""


@load_integral.member(EndContacts)
def _load_integral_end_contacts(walls, joint, strip, depth, interval):
    return _depth_integral(joint, strip, depth, interval[1]) - _depth_integral(joint, strip, depth, interval[0])


@load_integral.member(Spread)
def _load_integral_spread(walls, joint, strip, depth, interval):
    low, high = interval
    end_depths = depth_along(walls, joint, strip, depth, low), depth_along(walls, joint, strip, depth, high)
    return (high - low) * mean_elastic(joint.elastic, walls.rule, end_depths)


@family
def sum_of_fractions(walls, total):
    """Return the sum of the load fractions of all slices of a strip; total : as computed slice by slice."""


@sum_of_fractions.member(EndContacts)
def _sum_of_fractions_end_contacts(walls, total):
    return 1.0


@sum_of_fractions.member(Spread)
def _sum_of_fractions_spread(walls, total):
    return total


@family
def depth_along(walls, joint, strip, depth, z):
    """Return the depth (m) at the position z (m) of a strip; depth : m, at its start."""


@depth_along.member(EndContacts)
def _depth_along_end_contacts(walls, joint, strip, depth, z):
    return depth - strip.lean * z


@depth_along.member(Spread)
def _depth_along_spread(walls, joint, strip, depth, z):
    return depth_at(_profile_of(joint, strip, depth), z)


@kernel
def largest_depth_along(joint, strip, depth):
    """Return the largest depth (m) along a strip, which is at its start or its inner end; negative without contact."""
    return max(depth, depth_along(joint.walls, joint, strip, depth, strip.reach))


@family
def depth_at_start(walls, depth):
    """Return the depth (m) at the start of a strip from the depth of its contact."""


@depth_at_start.member(EndContacts)
def _depth_at_start_end_contacts(walls, depth):
    return max(depth, 0.0)


@depth_at_start.member(Spread)
def _depth_at_start_spread(walls, depth):
    return depth


class LoadDistribution(NamedTuple):
    """Distribution of the load along a strip."""

    mean_load: float  # N/m, mean over the loaded length
    mean_depth: float  # m, mean over that length
    max_load: float  # N/m, at the deepest point
    max_depth: float  # m, at that point


@family
def loads_along(walls, joint, strip, depth, load_and_integrals):
    """Return the LoadDistribution of a strip that carries a load (N); all are 0 without load.

    load_and_integrals : the load, and `integrals_of` the strip.
    """


@loads_along.member(EndContacts)
def _loads_along_end_contacts(walls, joint, strip, depth, load_and_integrals):
    load, _, area = load_and_integrals
    loaded_length = pressed_part(walls, joint, strip, depth, (0.0, strip.reach))[1]
    if area <= 0.0:
        return LoadDistribution(0.0, 0.0, 0.0, 0.0)
    largest_depth = largest_depth_along(joint, strip, depth)
    return LoadDistribution(load / loaded_length, area / loaded_length, load * largest_depth / area, largest_depth)


@loads_along.member(Spread)
def _loads_along_spread(walls, joint, strip, depth, load_and_integrals):
    load, total, area = load_and_integrals
    lifted = lifted_part(_profile_of(joint, strip, depth), 2.0 * strip.reach, 0.0)
    loaded_length = max(min(lifted.begin, strip.reach), 0.0) + max(strip.reach - max(lifted.end, 0.0), 0.0)
    if total <= 0.0 or loaded_length <= 0.0:
        return LoadDistribution(0.0, 0.0, 0.0, 0.0)
    largest_depth = largest_depth_along(joint, strip, depth)
    max_load = load * elastic_force(joint.elastic, largest_depth) / total
    return LoadDistribution(load / loaded_length, area / loaded_length, max_load, largest_depth)


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
