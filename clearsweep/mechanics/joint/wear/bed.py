"""Wear under the springs of `joint.worn_bed`: they press where the worn gap closes, and as deep as it does.

In the frame of the normal at the deepest point the surfaces overlap by

    f(psi) = (pen + c + h(0)) cos psi + h'(0) sin psi - c - h(psi) ,

which is largest, pen, at psi = 0.  The pressure goes with f, and what of it lies before the edge of a bin is known in
closed form, as the table of a shape has its integral.  Over time it is Lobatto's rule: a body loses what the law says,
but a bin whose edge an end of the arc passes within a step gets a little more or less of it than its due.
"""

import math
from typing import NamedTuple

from ...compiled.choosing import turns
from ...compiled.family import inlined, kernel
from ...observe.histogram import FORCE, KAPPA_COURSE, PARTS, RUBBED_COURSE, SLIP_COURSE
from ..nearest import surfaces_of
from ..worn import WornOnBed
from ..worn_bed import BLUNT, arc_ends, overlap
from .contract import Rubbing, enter_span, middle_arc, pressure_on, wear_rate
from .passage import DEEPEST, ON_BEARING, ON_JOURNAL, PLACES, POINTS, WAY, WEIGHTS, value
from .shape import integral_at, worn_at


class Arc(NamedTuple):
    """Where and how deep worn surfaces are in each other; angles from the deepest point."""

    x: float  # m, f by cos psi
    y: float  # m, by sin psi
    turned: tuple  # rad, how far bearing and journal are turned in the frame of the deepest point
    start: float  # rad
    stop: float  # rad
    depth: float  # m, the largest f
    total: float  # m rad, integral of f; 0 where the surfaces do not press


@inlined
def summed_to(joint, arc, psi):
    """Return the integral of f (m rad) from somewhere to an angle (rad)."""
    worn = integral_at(joint.bearing, psi - arc.turned[0]) + integral_at(joint.journal, psi - arc.turned[1])
    return arc.x * math.sin(psi) - arc.y * math.cos(psi) - joint.clearance * psi - worn


@kernel
def arc_at(joint, workspace, share):
    """Return the Arc at a share of a step."""
    turned, depth = (
        (-value(workspace, ON_BEARING, share), -value(workspace, ON_JOURNAL, share)),
        value(workspace, DEEPEST, share),
    )
    surfaces = surfaces_of(joint)
    h, slope, bend, _ = worn_at(surfaces.bearing, -turned[0])
    other, more, other_bend, _ = worn_at(surfaces.journal, -turned[1])
    x, y = depth + joint.clearance + (h + other), slope + more
    if depth <= 0.0:
        return Arc(x, y, turned, 0.0, 0.0, 0.0, 0.0)
    guess = math.sqrt(2.0 * depth / max(x + bend + other_bend, depth + BLUNT * joint.clearance))
    low, high = arc_ends(surfaces, x, y, turned, (0.0, guess))
    arc = Arc(x, y, turned, -low, high, depth, 0.0)
    total = max(summed_to(joint, arc, high) - summed_to(joint, arc, -low), 0.0)
    return Arc(x, y, turned, -low, high, depth, total)


@kernel
def sum_over_force(joint, arc):
    """Return the pressure summed up over an Arc, whatever its direction, over its resultant (Lobatto's rule)."""
    normal_sum, across, reach = 0.0, 0.0, 0.5 * (arc.stop - arc.start)
    for i in turns(POINTS):
        psi = arc.start + reach * (1.0 + PLACES[i])
        f, _, _ = overlap(surfaces_of(joint), arc.x, arc.y, psi, arc.turned)
        normal_sum += WEIGHTS[i] * f * math.cos(psi)
        across += WEIGHTS[i] * f * math.sin(psi)
    return arc.total / (reach * math.sqrt(normal_sum * normal_sum + across * across)) if arc.total > 0.0 else 0.0


@kernel
def rubbing_on(joint, workspace, arc, share):
    """Return the Rubbing on an Arc at a share of a step."""
    load, slid = max(value(workspace, FORCE, share), 0.0), workspace[WAY * POINTS] + workspace[WAY * POINTS + 1] * share
    return Rubbing(
        line_load=load,
        depth=arc.depth,
        slip=abs(value(workspace, SLIP_COURSE, share)),
        work=max(value(workspace, RUBBED_COURSE, share), 0.0),
        slid=slid,
        pressed=load * sum_over_force(joint, arc),
        clearance=joint.clearance,
    )


@kernel
def enter_arc(joint, arc, body, area, bins):
    """Enter what an Arc wears off a body, 0 the bearing or 1 the journal: an `area` over its radius (m rad)."""
    width, per_width, before = 2.0 * math.pi / bins.count, bins.count / (2.0 * math.pi), 0.0
    start, stop = arc.start - arc.turned[body], arc.stop - arc.turned[body]
    first, last = math.floor(start / width), math.floor(stop / width)
    begun, per_total = summed_to(joint, arc, arc.start), area / arc.total
    place = first % bins.count
    for edge in range(first + 1, last + 2):
        up_to = area
        if edge <= last:
            up_to = (summed_to(joint, arc, edge * width + arc.turned[body]) - begun) * per_total
            up_to = min(max(up_to, before), area)
        bins.depths[bins.first + place] += (up_to - before) * per_width
        before = up_to
        place = place + 1 if place + 1 < bins.count else 0


@enter_span.member(WornOnBed)
def _enter_span_worn_on_bed(joint, workspace, length, span, bins):
    reach = 0.5 * (span[1] - span[0])
    for i in turns(POINTS):
        share = span[0] + reach * (1.0 + PLACES[i])
        arc = arc_at(joint, workspace, share)
        if arc.total > 0.0:
            bearing, journal = wear_rate(joint.wear, rubbing_on(joint, workspace, arc, share))
            pace = length * reach * WEIGHTS[i] * max(value(workspace, KAPPA_COURSE, share), 0.0)
            enter_arc(joint, arc, 0, pace * bearing / joint.bearing_radius, bins[0])
            enter_arc(joint, arc, 1, pace * journal / joint.journal_radius, bins[1])


@pressure_on.member(WornOnBed)
def _pressure_on_worn_on_bed(joint, step, j, place):
    arc = arc_at(joint, step.workspace, place / PARTS)
    if not arc.total > 0.0:
        return 0.0, 0.0
    load = max(step.step_values[j, FORCE, place], 0.0) / joint.wear.length
    pressed = load * sum_over_force(joint, arc) / joint.bearing_radius
    return pressed / (arc.stop - arc.start), pressed * arc.depth / arc.total


@middle_arc.member(WornOnBed)
def _middle_arc_worn_on_bed(joint, workspace):
    arc = arc_at(joint, workspace, 0.5)
    return arc.stop - arc.start, rubbing_on(joint, workspace, arc, 0.5)
