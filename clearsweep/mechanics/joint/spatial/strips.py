"""Distribution of a wall's force along the length: a strip from each end to the middle, each with its own normal.

The depth decreases linearly along a strip, from `depth` at its end to `inner_depth` in the middle of the length;
the rate is also linear.  The force per length is that of the joint's law at the slice's depth and rate, over the
length.  With the fraction s of the strip from its end, and the roots x = sqrt(depth) a and b where the pressed part
begins and ends,

    x = a + (b - a) u,    s = u (a + x) / (a + b),    ds = 2 x / (a + b) du,    0 <= u <= 1,

there is no cancellation for a parallel journal, a = b.  In u a Hertzian force is a polynomial, also with a loss
linear in the rate, so Gauss's rule is exact; it equals the closed form for a power n of the depth,

    (depth^(n + 1) - inner_depth^(n + 1)) / ((n + 1) (depth - inner_depth)).
"""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.dual import as_type_of
from ...compiled.family import family, kernel
from ...trace.portable import gauss_rule
from ..elastic.contract import elastic_force
from ..elastic.power import Linear, PowerThreeHalves
from ..loss.contract import contact_force, sign_past_separation
from .form import FewNodes, ManyNodes, Spread

MIN_ROOT_RATIO = -0.5  # of the inner root: most negative root at an end past its separation, in a trial step


class Strip(NamedTuple):
    """Half of the length, from one end inwards."""

    root: float  # m^0.5, of the depth at the end; negative in a trial step past its separation
    depth: float  # m, at the end
    inner_depth: float  # m, in the middle of the length
    rate: float  # m/s, of the depth at the end
    inner_rate: float  # m/s, of that in the middle


class PressedRange(NamedTuple):
    """The part of a strip that is pressed."""

    begin: float  # m^0.5, root of the depth where it begins
    end: float  # m^0.5, root of the depth where it ends
    start_fraction: float  # fraction of the strip at which it begins
    length_fraction: float  # its length over that of the strip


class StripLoad(NamedTuple):
    """Moments of a strip's force over the fraction s of the strip, as if the strip were the whole joint."""

    outer: float  # N, integral of the force times 1 - s
    inner: float  # N, times s
    elastic_outer: float  # N, the same of the elastic part
    elastic_inner: float  # N


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


@kernel
def is_pressed(strip):
    """Return whether any of a strip is pressed."""
    return strip.depth > 0.0 or strip.inner_depth > 0.0


@kernel
def pressed_part(strip, is_one_sided):
    """Return the PressedRange of a strip; is_one_sided : whether the other end is past its separation or apart."""
    depth, inner_depth = strip.depth, strip.inner_depth
    zero, unit = as_type_of(0.0, depth), as_type_of(1.0, depth)
    if inner_depth <= 0.0:
        return PressedRange(strip.root, zero, zero, depth / (depth - inner_depth))
    root = math.sqrt(inner_depth)
    if depth <= 0.0:
        length_fraction = inner_depth / (inner_depth - depth)
        return PressedRange(zero, root, 1.0 - length_fraction, length_fraction)
    if strip.root < 0.0 and is_one_sided:
        return PressedRange(strip.root, -root, zero, unit)
    return PressedRange(max(strip.root, MIN_ROOT_RATIO * root), root, zero, unit)


@kernel
def strip_load_of(strip, pressed_range, laws, quadrature, onset_rate):
    """Return the StripLoad of a strip of which a PressedRange is pressed; laws : (law, elastic).  Not clipped."""
    law, elastic = laws
    zero = as_type_of(0.0, strip.depth)
    outer = inner = elastic_outer = elastic_inner = zero
    total = pressed_range.begin + pressed_range.end
    if total == 0.0:
        return StripLoad(outer, inner, elastic_outer, elastic_inner)
    inverse = 1.0 / total
    for node, weight in nodes_of(quadrature):
        x = pressed_range.begin + (pressed_range.end - pressed_range.begin) * node
        fraction = pressed_range.start_fraction + pressed_range.length_fraction * (
            node * (pressed_range.begin + x) * inverse
        )
        strip_weight = 2.0 * weight * pressed_range.length_fraction * (x * inverse)
        rate = strip.rate + (strip.inner_rate - strip.rate) * fraction
        force, elastic_part = contact_force(law, elastic, x * x, rate, onset_rate)
        if x < 0.0:
            strip_weight = strip_weight * sign_past_separation(law, elastic)
        outer, inner = outer + strip_weight * (1.0 - fraction) * force, inner + strip_weight * fraction * force
        elastic_outer = elastic_outer + strip_weight * (1.0 - fraction) * elastic_part
        elastic_inner = elastic_inner + strip_weight * fraction * elastic_part
    return StripLoad(outer, inner, elastic_outer, elastic_inner)


@kernel
def pressed_between(depths):
    """Return the PressedRange between two linear depths (m), of length 0 if none is pressed."""
    strip = Strip(math.sqrt(max(depths[0], 0.0)), depths[0], depths[1], 0.0, 0.0)
    if is_pressed(strip):
        return pressed_part(strip, is_one_sided=False)
    return PressedRange(0.0, 0.0, 0.0, 0.0)


@kernel
def mean_elastic(elastic, quadrature, depths):
    """Return the mean elastic force (N) between two linear depths (m)."""
    pressed_range, total = pressed_between(depths), 0.0
    if pressed_range.length_fraction == 0.0:
        return 0.0
    inverse = 1.0 / (pressed_range.begin + pressed_range.end)
    for node, weight in nodes_of(quadrature):
        x = pressed_range.begin + (pressed_range.end - pressed_range.begin) * node
        total += 2.0 * weight * (x * inverse) * elastic_force(elastic, x * x)
    return pressed_range.length_fraction * total
