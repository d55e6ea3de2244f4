"""Depth along a wall of a spatial joint, and the sums of the force of its slices.

The bearing's axis is a straight line, seen from the journal.  So the distance of the journal's circle at the
position z along the pin is a hyperbola,

    distance(z)^2 = square + 2 product z + tilt_square z^2,    depth(z) = distance(z) + intercept + slope z.

The straight part makes the depth exact at both ends.  The depth is convex: it is largest at an end, and only between
the ends can the journal lift off.  Slices carry load independently: the force per length is that of the joint's law
at the depth and rate of the slice, over the length.

A span is a pressed part of the length.  With the fraction s of the span, and the signed roots a and b of the depth
where it begins and ends,

    x = a + (b - a) u,    s = u (a + x) / (a + b),    ds = 2 x / (a + b) du,    0 <= u <= 1,

and the depth is x^2 less the sag of the hyperbola below its chord, without cancellation.  For a straight depth and a
Hertzian force, also with a loss linear in the rate, the integrand is a polynomial in u, and Gauss's rule is exact.
"""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.dual import as_type_of
from ...compiled.family import family, kernel
from ...trace.portable import gauss_rule
from ..elastic.contract import elastic_energy, elastic_force
from ..elastic.power import Linear, PowerThreeHalves
from ..loss.contract import contact_force, sign_past_separation
from .form import FewNodes, ManyNodes, Spread

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
    """The depth along the pin, see above."""

    square: float  # m^2, of the distance of the axes at z = 0
    product: float  # m, half the slope of the squared distance there
    tilt_square: float  # 1
    intercept: float  # m
    slope: float  # 1


@kernel
def distance_at(profile, z):
    """Return the distance (m) of the axes at the position z (m)."""
    square = profile.square + z * (2.0 * profile.product + profile.tilt_square * z)
    return math.sqrt(max(square, 1e-24 * profile.intercept * profile.intercept))


@kernel
def depth_at(profile, z):
    """Return the depth (m) at the position z (m)."""
    return distance_at(profile, z) + (profile.intercept + profile.slope * z)


class Lifted(NamedTuple):
    """The part of the length on which the journal is lifted, of length 0 at the least depth if there is none."""

    begin: float  # m
    end: float  # m
    is_lifted: bool


@kernel
def _ratio_within(numerator, denominator, bound):
    """Return a ratio within plus and minus a bound; denominator : not negative."""
    if abs(numerator) < bound * denominator:
        return numerator / denominator
    return as_type_of(math.copysign(bound, numerator), numerator)


@kernel
def lifted_part(profile, bound):
    """Return the Lifted part of a Profile, limited to positions between plus and minus a bound (m)."""
    # depth = 0 where the squared distance is (intercept + slope z)^2: leading z^2 + 2 middle z + constant = 0
    leading = profile.tilt_square - profile.slope * profile.slope
    middle = profile.product - profile.intercept * profile.slope
    constant = profile.square - profile.intercept * profile.intercept
    discriminant = middle * middle - leading * constant
    leading = max(leading, 0.0)
    if discriminant <= 0.0:
        vertex = _ratio_within(-middle, leading, bound)
        return Lifted(vertex, vertex, False)
    root_sum = abs(middle) + math.sqrt(discriminant)
    far, near = _ratio_within(root_sum, leading, bound), _ratio_within(constant, root_sum, bound)
    if middle >= 0.0:
        return Lifted(-far, -near, True)
    return Lifted(near, far, True)


# ---------------------------------------------------------------------------------------------- spans


class Span(NamedTuple):
    """A pressed part of the length."""

    start: float  # m, position where it begins
    stop: float  # m, where it ends
    begin: float  # m^0.5, signed root of the depth where it begins
    end: float  # m^0.5, where it ends


class _Node(NamedTuple):
    """A slice at a node of a span."""

    z: float  # m, position
    distance: float  # m, of the axes
    root: float  # m^0.5, negative past a separation
    depth: float  # m
    weight: float  # m, length of the slice


class _Chord(NamedTuple):
    """What all nodes of a span share."""

    begin: float  # m^0.5, root
    inverse: float  # m^-0.5, one over the sum of the roots
    distance: float  # m, of the axes where the span begins
    rise: float  # m, its increase along the span
    excess: float  # m^2, of the squared tilt over the squared slope of the chord, times the length squared


@kernel
def _chord_of(profile, span):
    begin = max(span.begin, MIN_ROOT_RATIO * span.end) if span.end > 0.0 else span.begin
    length, first, last = span.stop - span.start, distance_at(profile, span.start), distance_at(profile, span.stop)
    chord_slope = (2.0 * profile.product + profile.tilt_square * (span.start + span.stop)) / (first + last)
    excess = max(profile.tilt_square - chord_slope * chord_slope, 0.0) * length * length
    return _Chord(begin, 1.0 / (begin + span.end), first, length * chord_slope, excess)


@kernel
def _node_of(profile, span, chord, u, weight):
    """Return the _Node at `u`, 0 to 1, of a span."""
    x = chord.begin + (span.end - chord.begin) * u
    fraction = u * (chord.begin + x) * chord.inverse
    product = fraction * ((1.0 - u) * (span.end + x) * chord.inverse)
    z = span.start + (span.stop - span.start) * fraction
    distance = distance_at(profile, z)
    sag = chord.excess * product / (chord.distance + chord.rise * fraction + distance)
    length = 2.0 * weight * (x * chord.inverse) * abs(span.stop - span.start)
    return _Node(z, distance, x, max(x * x - sag, 0.0), length)


class StripSums(NamedTuple):
    """Sums over the slices of a strip; t : 0 at the middle of the length to 1 at the end of the strip."""

    force: float  # N
    outward: float  # N, of force times t
    over_distance: float  # N/m, of force over the distance of the axes
    outward_over_distance: float  # N/m, of force times t over distance
    square_over_distance: float  # N/m, of force times t^2 over distance


class StripLoad(NamedTuple):
    """Load of a strip, not clipped."""

    total: StripSums
    elastic: StripSums
    least_distance: float  # m, of the axes at the slices


class SliceRates(NamedTuple):
    """Rate of the depth (m/s) along the length: offset + slope z + (first + second z + third z^2) / distance."""

    offset: float  # m/s
    slope: float  # 1/s
    first: float  # m^2/s
    second: float  # m/s
    third: float  # 1/s


@kernel
def no_sums(zero):
    """Return the StripSums of an unloaded strip."""
    return StripSums(zero, zero, zero, zero, zero)


@kernel
def _with_slice(sums, force, t, inverse):
    """Return StripSums with a slice at `t`; inverse : 1/m, one over its distance."""
    outward, over_distance = force * t, force * inverse
    outward_over_distance = over_distance * t
    return StripSums(
        sums.force + force,
        sums.outward + outward,
        sums.over_distance + over_distance,
        sums.outward_over_distance + outward_over_distance,
        sums.square_over_distance + outward_over_distance * t,
    )


@kernel
def is_empty(span):
    """Return whether a span has no length or no depth."""
    return span.start == span.stop or (span.begin == 0.0 and span.end == 0.0)


@kernel
def with_span(load, profile, span, laws, quadrature, rates, onset_rate, strip):
    """Return the StripLoad with the slices of a Span; laws : (law, elastic).

    rates : SliceRates; strip : (middle of the length, m; inverse of the strip's length outwards, 1/m; of the length
    that has the full stiffness, 1/m).
    """
    if is_empty(span):
        return load
    law, elastic = laws
    middle, per_strip, per_length = strip
    total, elastic_sums, least_distance = load
    chord = _chord_of(profile, span)
    for u, weight in nodes_of(quadrature):
        node = _node_of(profile, span, chord, u, weight)
        inverse, t, length = 1.0 / node.distance, (node.z - middle) * per_strip, node.weight * per_length
        rate = rates.offset + rates.slope * node.z
        rate = rate + (rates.first + node.z * (rates.second + rates.third * node.z)) * inverse
        force, elastic_part = contact_force(law, elastic, node.depth, rate, onset_rate)
        if node.root < 0.0:
            length = length * sign_past_separation(law, elastic)
        total = _with_slice(total, length * force, t, inverse)
        elastic_sums = _with_slice(elastic_sums, length * elastic_part, t, inverse)
        least_distance = min(least_distance, node.distance)
    return StripLoad(total, elastic_sums, least_distance)


@kernel
def energy_of(profile, span, elastic, quadrature):
    """Return the integral (J m) of the stored energy of the whole joint over a Span."""
    total = as_type_of(0.0, span.stop)
    if is_empty(span):
        return total
    chord = _chord_of(profile, span)
    for u, weight in nodes_of(quadrature):
        node = _node_of(profile, span, chord, u, weight)
        total = total + node.weight * elastic_energy(elastic, node.depth)
    return total


@kernel
def root_at(profile, z):
    """Return the root (m^0.5) of the depth at the position z (m), 0 if the journal is lifted there."""
    return math.sqrt(max(depth_at(profile, z), 0.0))


@kernel
def _integrals_of(profile, span, elastic, quadrature):
    """Return the integrals of the elastic force (N m) of the whole joint and of the depth (m^2) over a Span."""
    load = area = 0.0
    if is_empty(span):
        return load, area
    chord = _chord_of(profile, span)
    for u, weight in nodes_of(quadrature):
        node = _node_of(profile, span, chord, u, weight)
        load += node.weight * elastic_force(elastic, node.depth)
        area += node.weight * node.depth
    return load, area


@kernel
def integrals_between(profile, lifted, elastic, quadrature, interval):
    """Return the integrals of the elastic force (N m) and of the depth (m^2) over an interval (m) outside a Lifted."""
    low, high = interval
    below, above = min(high, lifted.begin), max(low, lifted.end)
    load = area = 0.0
    if low < below:
        load, area = _integrals_of(
            profile, Span(low, below, root_at(profile, low), root_at(profile, below)), elastic, quadrature
        )
    if above < high:
        other_load, other_area = _integrals_of(
            profile, Span(above, high, root_at(profile, above), root_at(profile, high)), elastic, quadrature
        )
        load, area = load + other_load, area + other_area
    return load, area
