"""Depth along a wall of a spatial joint, sums of the force of its slices, and the distribution of the load for wear.

The axis of the bearing is a straight line, seen from the journal.  So the distance of the axes is a hyperbola over the
position z along the pin,

    depth(z) = distance(z) - clearance,    distance(z)^2 = clearance^2 + constant + 2 product z + tilt_square z^2.

It is convex: the depth is largest at an end, and only between the ends can the journal lift off.  Slices carry load
independently: the force per length is that of the joint's law at the depth and rate of the slice, over the length.

A span is a pressed part of the length.  With the fraction s of the span, and the signed roots a and b of the depth
where it begins and ends,

    x = a + (b - a) u,    s = u (a + x) / (a + b),    ds = 2 x / (a + b) du,    0 <= u <= 1,

and the depth is x^2 less the sag of the hyperbola below its chord, without cancellation.  For a straight depth and a
Hertzian force, also with a loss linear in the rate, the integrand is a polynomial in u, and Gauss's rule is exact.

For wear, a wall contact is at the deepest point of the surfaces.  From there the surfaces touch over a strip that
extends inwards, over at most half of the length on which journal and bore overlap.  Positions z along it are from its
start.  For spread walls, depth and load are those of the equations of motion,

    (clearance + depth(z))^2 = (clearance + depth)^2 - 2 (clearance + depth) lean z + tilt_square z^2,

and the load per length is the elastic force at this depth.  If one end is separated, its strip still carries load
where the contact of the other end extends past the middle.

For walls that carry load at their ends, the depth decreases linearly, depth(z) = depth - lean z, and the load along the
strip is proportional to it, as on an elastic foundation (Johnson 1985, Contact Mechanics, section 4.3).  So a parallel
journal is loaded evenly and a tilted journal at its edge.
"""

from typing import NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import rolled_range
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import family, family_with_default, inlined, kernel
from ....tracing.compiled.vector import dot
from ....tracing.portable import gauss_rule
from ...laws.contract import touches
from ...laws.elastic import Linear, PowerThreeHalves, elastic_energy, elastic_force
from ...laws.loss import contact_force, sign_past_separation
from ...observe import FORCE_ROW, PARTS
from . import AtEdges, EndContacts, FewNodes, InBore, ManyNodes, Overlapping, Spread, is_past_edge

#: Least depth, over its rise along a strip, from which the quadrature is as exact without a division there.
SPLIT_DEPTH = 0.25
MIN_ROOT_RATIO = -0.5  # of the other root of a span: most negative root at an end past its separation, in a trial step


def gauss_on_unit_interval(count: int) -> tuple[tuple[float, float], ...]:
    """Return (node, weight) of the Gauss-Legendre rule on (0, 1)."""
    return tuple((float(0.5 * x + 0.5), float(0.5 * w)) for x, w in zip(*gauss_rule(count), strict=True))


FEW_NODES, MANY_NODES = gauss_on_unit_interval(5), gauss_on_unit_interval(16)


@family
def nodes_of(quadrature):
    """Return (node, weight) of the rule that a Spread integrates with."""


nodes_of.member(FewNodes)(lambda quadrature: FEW_NODES)
nodes_of.member(ManyNodes)(lambda quadrature: MANY_NODES)


def spread_over(elastic: tuple) -> Spread:
    """Return the walls with distributed stiffness, with the quadrature rule for the elastic law."""
    return Spread(FewNodes() if isinstance(elastic, Linear | PowerThreeHalves) else ManyNodes())


# ---------------------------------------------------------------------------------------------- depth


class Profile(NamedTuple):
    """The depth over a position z, see above; z and the length are in one unit, m unless stated otherwise."""

    clearance: float  # m
    constant: float  # m^2
    product: float  # m
    tilt_square: float  # 1


@inlined
def _square_past_clearance(profile, z):
    """Return the squared distance of the axes at z, less the squared clearance (m^2)."""
    return profile.constant + z * (2.0 * profile.product + profile.tilt_square * z)


@inlined
def distance_at(profile, z):
    """Return the distance (m) of the axes at z."""
    square = profile.clearance * profile.clearance
    return math.sqrt(max(square + _square_past_clearance(profile, z), 1e-24 * square))


@inlined
def depth_at(profile, z):
    """Return the depth (m) at z."""
    return _square_past_clearance(profile, z) / (profile.clearance + distance_at(profile, z))


@kernel
def root_at(profile, z):
    """Return the root (m^0.5) of the depth at z, 0 if the journal is lifted there."""
    return math.sqrt(max(depth_at(profile, z), 0.0))


class Lifted(NamedTuple):
    """The part of the length on which the journal is lifted, of length 0 if there is none."""

    begin: float  # m
    end: float  # m
    is_lifted: bool


@inlined
def _ratio_within(numerator, denominator, bound):
    """Return a ratio within plus and minus a bound; denominator : not negative."""
    if abs(numerator) < bound * denominator:
        return numerator / denominator
    return as_type_of(math.copysign(bound, numerator), numerator)


@inlined
def lifted_part(profile, bound, reach):
    """Return the Lifted part of a Profile, with positions between plus and minus a bound.

    If the journal is nowhere lifted, spans are divided at `begin` for the quadrature: near the least depth if that is
    small, and at 0 if it exceeds SPLIT_DEPTH of the rise of the depth over a `reach` from there.
    """
    leading, middle = max(profile.tilt_square, 0.0), profile.product
    discriminant = middle * middle - leading * profile.constant
    if discriminant > 0.0:
        root_sum = abs(middle) + math.sqrt(discriminant)
        far, near = _ratio_within(root_sum, leading, bound), _ratio_within(profile.constant, root_sum, bound)
        if middle >= 0.0:
            return Lifted(-far, -near, True)
        return Lifted(near, far, True)
    division = as_type_of(0.0, leading)
    rise = SPLIT_DEPTH * (leading * reach) * (leading * reach)
    if rise + discriminant > 0.0:
        closeness = (rise + discriminant) / rise
        division = (closeness * closeness) * _ratio_within(-middle, leading, bound)
    return Lifted(division, division, False)


# ---------------------------------------------------------------------------------------------- spans


class Span(NamedTuple):
    """A pressed part of the length."""

    start: float  # m, position where it begins
    stop: float  # m, where it ends
    begin: float  # m^0.5, signed root of the depth where it begins
    end: float  # m^0.5, where it ends
    start_distance: float  # m, of the axes where it begins
    stop_distance: float  # m, where it ends


class _Node(NamedTuple):
    """A slice at a node of a span."""

    z: float  # m, position
    inverse: float  # 1/m, one over the distance of the axes
    root: float  # m^0.5, negative past a separation
    depth: float  # m
    weight: float  # m, signed length of the slice


class _Chord(NamedTuple):
    """What all nodes of a span share."""

    begin: float  # m^0.5, root
    inverse: float  # m^-0.5, one over the sum of the roots
    length: float  # m, signed
    rise: float  # m, increase of the distance of the axes along the span
    excess: float  # m^1.5, of the squared tilt over the squared slope of the chord, times length squared and `inverse`
    weight: float  # m^0.5, length of a slice per weight of the rule and root


@inlined
def _chord_of(profile, span):
    begin = max(span.begin, MIN_ROOT_RATIO * span.end) if span.end > 0.0 else span.begin
    roots, distances, length = begin + span.end, span.start_distance + span.stop_distance, span.stop - span.start
    inverse = 1.0 / (roots * distances)
    slope = (2.0 * profile.product + profile.tilt_square * (span.start + span.stop)) * (roots * inverse)
    excess = max(profile.tilt_square - slope * slope, 0.0) * (length * length)
    inverse = distances * inverse
    return _Chord(begin, inverse, length, length * slope, excess * inverse, 2.0 * inverse * abs(length))


@inlined
def _node_of(profile, span, chord, u, weight):
    """Return the _Node at `u`, 0 to 1, of a span."""
    x = chord.begin + (span.end - chord.begin) * u
    fraction = u * (chord.begin + x) * chord.inverse
    z = span.start + chord.length * fraction
    distance = distance_at(profile, z)
    distances = span.start_distance + chord.rise * fraction + distance
    inverse = 1.0 / (distance * distances)
    sag = chord.excess * (fraction * ((1.0 - u) * (span.end + x))) * (distance * inverse)
    return _Node(z, distances * inverse, x, max(x * x - sag, 0.0), weight * x * chord.weight)


class StripSums(NamedTuple):
    """Sums over the slices of a strip at z, from -1 to 1 over the length."""

    force: float  # N
    outward: float  # N, of force times the size of z
    over_distance: float  # N/m, of force over the distance of the axes
    outward_over_distance: float  # N/m, of force times the size of z over distance
    square_over_distance: float  # N/m, of force times z^2 over distance


class StripLoad(NamedTuple):
    """Load of a strip, not clipped."""

    total: StripSums
    elastic: float  # N, elastic part of the force
    elastic_outward: float  # N, times the size of z
    stored_power: float  # W, times the rate of the depth


class SliceRates(NamedTuple):
    """Rate of the depth times the distance of the axes, constant + slope z + curvature z^2, with z from -1 to 1."""

    constant: float  # m^2/s
    slope: float  # m^2/s
    curvature: float  # m^2/s


@inlined
def no_sums(zero):
    """Return the StripSums of an unloaded strip."""
    return StripSums(zero, zero, zero, zero, zero)


@inlined
def _with_slice(sums, force, t, inverse):
    """Return StripSums with a slice at the size `t` of z; inverse : 1/m, one over its distance."""
    over_distance = force * inverse
    outward_over_distance = over_distance * t
    return StripSums(
        sums.force + force,
        sums.outward + force * t,
        sums.over_distance + over_distance,
        sums.outward_over_distance + outward_over_distance,
        sums.square_over_distance + outward_over_distance * t,
    )


@inlined
def is_empty(span):
    """Return whether a span has no length or no depth."""
    return span.start == span.stop or (span.begin == 0.0 and span.end == 0.0)


@inlined
def with_span(load, profile, span, laws, rule, rates, onset_rate, scale):
    """Return the StripLoad with the slices of a Span over -1 to 1.

    laws : (law, elastic); rates : SliceRates; scale : fraction of the stiffness of the whole joint on a unit of z.
    """
    if is_empty(span):
        return load
    law, elastic = laws
    total, elastic_force_sum, elastic_outward, stored_power = load
    chord = _chord_of(profile, span)
    for u, weight in nodes_of(rule):
        node = _node_of(profile, span, chord, u, weight)
        inverse, t, share = node.inverse, abs(node.z), node.weight * scale
        rate = (rates.constant + node.z * (rates.slope + rates.curvature * node.z)) * inverse
        force, elastic_part = contact_force(law, elastic, node.depth, rate, onset_rate)
        if node.root < 0.0:
            share = share * sign_past_separation(law, elastic)
        total, elastic_part = _with_slice(total, share * force, t, inverse), share * elastic_part
        elastic_force_sum = elastic_force_sum + elastic_part
        elastic_outward = elastic_outward + elastic_part * t
        stored_power = stored_power + elastic_part * rate
    return StripLoad(total, elastic_force_sum, elastic_outward, stored_power)


@kernel
def with_second_span(load, profile, span, laws, rule, rates, onset_rate, scale):
    """Return the StripLoad `with_span` that is rarely pressed: one piece of code for all of them."""
    return with_span(load, profile, span, laws, rule, rates, onset_rate, scale)


@kernel
def energy_of(profile, span, elastic, quadrature):
    """Return the integral over a Span of the energy (J) that the whole joint stores at the depth of its slices."""
    total = as_type_of(0.0, span.stop)
    if is_empty(span):
        return total
    chord = _chord_of(profile, span)
    for u, weight in nodes_of(quadrature):
        node = _node_of(profile, span, chord, u, weight)
        total = total + node.weight * elastic_energy(elastic, node.depth)
    return total


# ---------------------------------------------------------------------------------------------- wear


@kernel
def _with_integrals(integrals, profile, span, elastic, quadrature):
    """Return (load, area) with the integrals of the elastic force (N m) and the depth (m^2) over a Span."""
    load, area = integrals
    if is_empty(span):
        return load, area
    chord = _chord_of(profile, span)
    for u, weight in nodes_of(quadrature):
        node = _node_of(profile, span, chord, u, weight)
        load += node.weight * elastic_force(elastic, node.depth)
        area += node.weight * node.depth
    return load, area


@kernel
def integrals_up_to(profile, reach, elastic, quadrature):
    """Return the integrals of the elastic force (N m) and of the depth (m^2) from 0 to a reach (m)."""
    lifted = lifted_part(profile, 2.0 * reach, 0.0)
    first_distance, last_distance = distance_at(profile, 0.0), distance_at(profile, reach)
    first, last = root_at(profile, 0.0), root_at(profile, reach)
    if not lifted.is_lifted:
        span = Span(0.0, reach, first, last, first_distance, last_distance)
        return _with_integrals((0.0, 0.0), profile, span, elastic, quadrature)
    low, high = min(max(lifted.begin, 0.0), reach), min(max(lifted.end, 0.0), reach)
    low_root, high_root = last if low == reach else 0.0, first if high == 0.0 else 0.0
    span = Span(0.0, low, first, low_root, first_distance, distance_at(profile, low))
    integrals = _with_integrals((0.0, 0.0), profile, span, elastic, quadrature)
    span = Span(high, reach, high_root, last, distance_at(profile, high), last_distance)
    return _with_integrals(integrals, profile, span, elastic, quadrature)


@kernel
def mean_elastic(elastic, quadrature, depths):
    """Return the mean elastic force (N) between two depths (m) of a straight line."""
    first, last = depths
    if first <= 0.0 and last <= 0.0:
        return 0.0
    fraction, begin, end = 1.0, math.sqrt(max(first, 0.0)), math.sqrt(max(last, 0.0))
    if first <= 0.0 or last <= 0.0:
        fraction = max(first, last) / abs(first - last)
    return fraction * _mean_between(elastic, quadrature, begin, end)


@family_with_default
def _mean_between(elastic, quadrature, begin, end):
    """Return the mean elastic force (N) over a straight depth with roots `begin` and `end` (m^0.5)."""
    total, inverse = 0.0, 1.0 / (begin + end)
    for u, weight in nodes_of(quadrature):
        x = begin + (end - begin) * u
        total += 2.0 * weight * (x * inverse) * elastic_force(elastic, x * x)
    return total


_mean_between.member(Linear)(
    lambda elastic, quadrature, begin, end: 0.5 * elastic.stiffness * (begin * begin + end * end)
)


@_mean_between.member(PowerThreeHalves)
def _mean_between_power_three_halves(elastic, quadrature, begin, end):
    product, squares = begin * end, begin * begin + end * end
    return 0.4 * elastic.stiffness * (squares * (squares + product) - product * product) / (begin + end)


# ---------------------------------------------------------------------------------------------- strips along the walls


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
    stop_distance = pressed_part(walls, joint, strip, depth, (0.0, strip.reach))[1]
    area = stop_distance * (depth - 0.5 * strip.lean * stop_distance)
    return area, area


@integrals_of.member(Spread)
def _integrals_of_spread(walls, joint, strip, depth):
    return integrals_up_to(_profile_of(joint, strip, depth), strip.reach, joint.elastic, joint.walls.rule)


@family
def load_integral(walls, joint, length, end_depths):
    """Return the first of `integrals_of` over a `length` (m) with a straight depth; end_depths : m, at both ends."""


load_integral.member(EndContacts)(
    lambda walls, joint, length, end_depths: length * mean_elastic(Linear(1.0), FewNodes(), end_depths)
)
load_integral.member(Spread)(
    lambda walls, joint, length, end_depths: length * mean_elastic(joint.elastic, walls.rule, end_depths)
)


@family
def sum_of_fractions(walls, total):
    """Return the sum of the load fractions of all slices of a strip; total : as computed slice by slice."""


sum_of_fractions.member(EndContacts)(lambda walls, total: 1.0)
sum_of_fractions.member(Spread)(lambda walls, total: total)


@family
def depth_along(walls, joint, strip, depth, z):
    """Return the depth (m) at the position z (m) of a strip; depth : m, at its start."""


depth_along.member(EndContacts)(lambda walls, joint, strip, depth, z: depth - strip.lean * z)
depth_along.member(Spread)(lambda walls, joint, strip, depth, z: depth_at(_profile_of(joint, strip, depth), z))


@kernel
def largest_depth_along(joint, strip, depth):
    """Return the largest depth (m) along a strip, which is at its start or its inner end; negative without contact."""
    return max(depth, depth_along(joint.walls, joint, strip, depth, strip.reach))


@family
def depth_at_start(walls, depth):
    """Return the depth (m) at the start of a strip from the depth of its contact."""


depth_at_start.member(EndContacts)(lambda walls, depth: max(depth, 0.0))
depth_at_start.member(Spread)(lambda walls, depth: depth)


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


carries_load.member(EndContacts)(lambda walls, step, j, wall: touches(step.mode[j + wall]))


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
