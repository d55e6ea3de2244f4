"""A part of a step in free flight: how deep the journal can have come in it, and the cubic through its ends."""

from typing import NamedTuple

from ..compiled.family import inlined, kernel


@inlined
def deepest_between(depth_begin, depth_end, reach):
    """Return how deep (m) a path no longer than `reach` (m) between two depths (m) can have gone.

    What it goes beyond the one depth it has to come back by, and the rest, to the other; no less deep than either.
    """
    return max(max(depth_begin, depth_end), 0.5 * (depth_begin + depth_end + reach))  # noqa: PLW3301 - as in acceptance


class Span(NamedTuple):
    """A part of a step in free flight: its ends as shares of the step, with depths and their slopes there."""

    begin: float
    depth_begin: float  # m
    slope_begin: float  # m per step
    end: float
    depth_end: float  # m
    slope_end: float  # m per step


@kernel
def cubic(span):
    """Return the coefficients of u^2 and u^3 of the cubic through the ends of a Span, u from 0 to 1."""
    wide, rise = span.end - span.begin, span.depth_end - span.depth_begin
    begin, end = wide * span.slope_begin, wide * span.slope_end
    return 3.0 * rise - 2.0 * begin - end, begin + end - 2.0 * rise


@kernel
def fold(span):
    """Return where that cubic bends the other way, if its slope, of one sign at both ends, has the other sign there.

    Else the end.  What has just left can so be pressed back, and fall again, between two ends at which it falls.
    """
    lean, bend = cubic(span)
    u = -lean / (3.0 * bend) if bend != 0.0 else 1.0
    begin, there = span.slope_begin, (span.end - span.begin) * span.slope_begin + lean * u
    return span.begin + u * (span.end - span.begin) if 0.0 < u < 1.0 and begin * there < 0.0 else span.end


@kernel
def cubic_onset(span):
    """Return where the cubic through the ends of a Span crosses zero, by a few steps of Newton's method."""
    a, b, sa = span.begin, span.end, span.slope_begin
    wide, rise = b - a, span.depth_end - span.depth_begin
    lean, bend = cubic(span)
    x = a - wide * span.depth_begin / rise if sa > 0.0 else b  # just left, the depth at `begin` is all but 0, too
    for _ in range(3):
        u = (x - a) / wide
        value = span.depth_begin + u * (wide * sa + u * (lean + u * bend))
        slope = sa + u * (2.0 * lean + 3.0 * u * bend) / wide
        better = x - value / slope if slope > 0.0 else b
        x = better if a < better < b else x
    return x
