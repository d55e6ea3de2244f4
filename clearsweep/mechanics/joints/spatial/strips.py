"""Depth along a wall of a spatial joint, and the sums of the force of its slices.

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
"""

from typing import NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import family, inlined, kernel
from ....tracing.portable import gauss_rule
from ...laws.elastic import Linear, PowerThreeHalves, elastic_energy, elastic_force
from ...laws.loss import contact_force, sign_past_separation
from .form import FewNodes, ManyNodes, Spread

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


@nodes_of.member(FewNodes)
def _nodes_of_few_nodes(quadrature):
    return FEW_NODES


@nodes_of.member(ManyNodes)
def _nodes_of_many_nodes(quadrature):
    return MANY_NODES


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


@kernel
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
    total, inverse = 0.0, 1.0 / (begin + end)
    for u, weight in nodes_of(quadrature):
        x = begin + (end - begin) * u
        total += 2.0 * weight * (x * inverse) * elastic_force(elastic, x * x)
    return fraction * total
