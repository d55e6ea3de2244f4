"""Wear in proportion to the overlap of worn surfaces: `pressure: winkler` with `evolve: true`.

In the frame of the normal at the deepest point the surfaces overlap by

    f(psi) = (penetration + c + h(0)) cos psi + h'(0) sin psi - c - h(psi)   (m)

c : radial clearance (m); h : wear depth of bearing and journal together (m); psi : angle from the deepest point
(rad); penetration : the maximum of f (m), at psi = 0.

The force acts at that point or on the springs of `joint.worn_foundation`.  The pressure is proportional to f.  Under a
steady load the surfaces so wear into arcs of the same radius, on which f varies as cos psi.  Its fraction before the
edge of a bin is known in closed form, because the table of a shape has the integral of h.  The wear is integrated by
Lobatto's rule over the step, whose length is in tau; the factor kappa = dt/dtau (s) makes it a time.  The total wear
of a body is that of the law.  A bin whose edge an end of the arc passes within a step receives an approximate depth.
"""

import math
from typing import NamedTuple

from ....tracing.compiled.choosing import rolled_range
from ....tracing.compiled.family import family, inlined, kernel
from ...observe import FRICTION_POWER_ROW, KAPPA_ROW, SLIP_ROW
from ...wear import SlidingContact, update_wear_over_span, wear_rate
from ...wear.arc import (
    AREA,
    BEARING_ANGLE_ROW,
    BODY_SIZE,
    DISTANCE_ROW,
    FIRST_BODY,
    HALF,
    JOURNAL_ANGLE_ROW,
    LINE_LOAD_ROW,
    NODES,
    PENETRATION_ROW,
    POINTS,
    WEIGHTS,
    evaluate_polynomial,
    write_pressure,
)
from ...wear.bins import update_wear_over_arc
from ...wear.shape import Shape, wear_depth_at, wear_integral_at
from .nearest import Surfaces
from .worn import WornJoint, WornOnFoundation
from .worn_foundation import MIN_RADIUS_DIFFERENCE, arc_ends, overlap

MAX_DISTANCE = 0.25  # bins: an arc that moves less within a step counts as standing


class Overlap(NamedTuple):
    """Pressure proportional to the overlap of worn surfaces, whose shapes conform to each other."""

    bearing: Shape
    journal: Shape


class OverlapArc(NamedTuple):
    """Overlap of worn surfaces: its position and penetration; angles from the deepest point."""

    cos_coefficient: float  # m, coefficient of cos psi in f
    sin_coefficient: float  # m, coefficient of sin psi in f
    body_angles: tuple  # rad, angles of bearing and journal in the frame of the deepest point
    start_angle: float  # rad, first end of the arc
    stop_angle: float  # rad, last end of the arc
    penetration: float  # m, the maximum of f
    overlap_integral: float  # m rad, integral of f over the arc; 0 without contact


@inlined
def conformal_surfaces(joint):
    """Return the Surfaces of a joint on whose overlap its wear depends."""
    return Surfaces(joint.clearance, joint.wear.pressure.bearing.table, joint.wear.pressure.journal.table)


@inlined
def overlap_antiderivative(joint, arc, psi):
    """Return the antiderivative of f at psi (m rad); its constant cancels in differences.  psi : angle (rad)."""
    pressure = joint.wear.pressure
    worn = wear_integral_at(pressure.bearing, psi - arc.body_angles[0]) + wear_integral_at(
        pressure.journal, psi - arc.body_angles[1]
    )
    return arc.cos_coefficient * math.sin(psi) - arc.sin_coefficient * math.cos(psi) - joint.clearance * psi - worn


@kernel
def arc_at(joint, workspace, fraction):
    """Return the OverlapArc at a fraction (0 to 1) of a step."""
    body_angles, penetration = (
        (
            -evaluate_polynomial(workspace, BEARING_ANGLE_ROW, fraction),
            -evaluate_polynomial(workspace, JOURNAL_ANGLE_ROW, fraction),
        ),
        evaluate_polynomial(workspace, PENETRATION_ROW, fraction),
    )
    surfaces = conformal_surfaces(joint)
    bearing_wear, bearing_slope, bearing_curvature, _ = wear_depth_at(surfaces.bearing, -body_angles[0])
    journal_wear, journal_slope, journal_curvature, _ = wear_depth_at(surfaces.journal, -body_angles[1])
    cos_coefficient, sin_coefficient = (
        penetration + joint.clearance + (bearing_wear + journal_wear),
        bearing_slope + journal_slope,
    )
    if penetration <= 0.0:
        return OverlapArc(cos_coefficient, sin_coefficient, body_angles, 0.0, 0.0, 0.0, 0.0)
    guess = math.sqrt(
        2.0
        * penetration
        / max(
            cos_coefficient + bearing_curvature + journal_curvature,
            penetration + MIN_RADIUS_DIFFERENCE * joint.clearance,
        )
    )
    low, high = arc_ends(surfaces, cos_coefficient, sin_coefficient, body_angles, (0.0, guess))
    arc = OverlapArc(cos_coefficient, sin_coefficient, body_angles, -low, high, penetration, 0.0)
    overlap_integral = max(overlap_antiderivative(joint, arc, high) - overlap_antiderivative(joint, arc, -low), 0.0)
    return OverlapArc(cos_coefficient, sin_coefficient, body_angles, -low, high, penetration, overlap_integral)


@kernel
def pressure_integral_over_load(joint, arc):
    """Return the integral of the pressure over an OverlapArc over the magnitude of its resultant (Lobatto's rule)."""
    normal_sum, tangential_sum, half_angle = 0.0, 0.0, 0.5 * (arc.stop_angle - arc.start_angle)
    for i in rolled_range(POINTS):
        psi = arc.start_angle + half_angle * (1.0 + NODES[i])
        f, _, _ = overlap(conformal_surfaces(joint), arc.cos_coefficient, arc.sin_coefficient, psi, arc.body_angles)
        normal_sum += WEIGHTS[i] * f * math.cos(psi)
        tangential_sum += WEIGHTS[i] * f * math.sin(psi)
    return (
        arc.overlap_integral / (half_angle * math.sqrt(normal_sum * normal_sum + tangential_sum * tangential_sum))
        if arc.overlap_integral > 0.0
        else 0.0
    )


@kernel
def sliding_contact_on(joint, workspace, arc, load_sum, fraction):
    """Return the SlidingContact on an OverlapArc at a fraction (0 to 1) of a step.

    load_sum : integral of the pressure over the arc over the magnitude of its resultant
    """
    line_load, sliding_distance = (
        max(evaluate_polynomial(workspace, LINE_LOAD_ROW, fraction), 0.0),
        workspace[DISTANCE_ROW * POINTS] + workspace[DISTANCE_ROW * POINTS + 1] * fraction,
    )
    return SlidingContact(
        line_load=line_load,
        depth=arc.penetration,
        sliding_speed=abs(evaluate_polynomial(workspace, SLIP_ROW, fraction)),
        friction_power=max(evaluate_polynomial(workspace, FRICTION_POWER_ROW, fraction), 0.0),
        sliding_distance=sliding_distance,
        pressure_integral=line_load * load_sum,
        clearance=joint.clearance,
    )


@kernel
def write_wear_at(joint, workspace, arc, load_sum, node, time):
    """Write the wear under an OverlapArc at a node of Lobatto's rule over a span; return its areas over the radii.

    load_sum : as in `sliding_contact_on`; time : (fraction of the step, duration (s) of the node without kappa)
    """
    fraction, journal = time[0], FIRST_BODY + BODY_SIZE
    duration = time[1] * WEIGHTS[node] * max(evaluate_polynomial(workspace, KAPPA_ROW, fraction), 0.0)
    width, bearing_area, journal_area = arc.stop_angle - arc.start_angle, 0.0, 0.0
    mean_pressure, largest_pressure, speed = 0.0, 0.0, 0.0
    if arc.overlap_integral > 0.0:
        sliding = sliding_contact_on(joint, workspace, arc, load_sum, fraction)
        bearing_rate, journal_rate = wear_rate(joint.wear, sliding)
        bearing_area = duration * bearing_rate / joint.bearing_radius
        journal_area = duration * journal_rate / joint.journal_radius
        pressure_sum, speed = sliding.pressure_integral / joint.bearing_radius, sliding.sliding_speed
        mean_pressure = pressure_sum / width
        # the largest pressure is where the surfaces overlap most
        largest_pressure = pressure_sum * arc.penetration / arc.overlap_integral
    write_pressure(workspace, node, (mean_pressure, largest_pressure), speed, duration)
    workspace[FIRST_BODY + HALF * POINTS + node] = 0.5 * width
    workspace[FIRST_BODY + AREA * POINTS + node], workspace[journal + AREA * POINTS + node] = bearing_area, journal_area
    return bearing_area, journal_area


@kernel
def update_wear_under_arc(joint, arc, body, area_over_radius, bins):
    """Add the wear of a body under an OverlapArc to its bins.

    body : 0 bearing, 1 journal; area_over_radius : worn cross-section (m^2) over the radius (m) of the body
    """
    bin_angle, bins_per_radian, worn_so_far = 2.0 * math.pi / bins.count, bins.count / (2.0 * math.pi), 0.0
    start_angle, stop_angle = arc.start_angle - arc.body_angles[body], arc.stop_angle - arc.body_angles[body]
    first_bin, last_bin = math.floor(start_angle / bin_angle), math.floor(stop_angle / bin_angle)
    integral_at_start, wear_per_overlap = (
        overlap_antiderivative(joint, arc, arc.start_angle),
        area_over_radius / arc.overlap_integral,
    )
    bin_index = first_bin % bins.count
    for edge_index in range(first_bin + 1, last_bin + 2):
        cumulative = area_over_radius
        if edge_index <= last_bin:
            cumulative = (
                overlap_antiderivative(joint, arc, edge_index * bin_angle + arc.body_angles[body]) - integral_at_start
            ) * wear_per_overlap
            cumulative = min(max(cumulative, worn_so_far), area_over_radius)
        bins.depths[bins.start + bin_index] += (cumulative - worn_so_far) * bins_per_radian
        worn_so_far = cumulative
        bin_index = bin_index + 1 if bin_index + 1 < bins.count else 0


@update_wear_over_span.member(WornJoint)
@update_wear_over_span.member(WornOnFoundation)
def _update_wear_over_span_worn_joint_or_worn_on_foundation(joint, workspace, step_length, span, bins):
    update_worn_surfaces(joint.wear.pressure, joint, workspace, step_length, span, bins)


@family
def update_worn_surfaces(pressure, joint, workspace, step_length, span, bins):
    """Do what `update_wear_over_span` says for a worn joint with this pressure."""


@update_worn_surfaces.member(None)
def _default_update_worn_surfaces(pressure, joint, workspace, step_length, span, bins):
    update_wear_over_arc(joint, workspace, step_length, span, bins)


@inlined
def distance_between(first, second):
    """Return how far (rad) an OverlapArc is from another: the largest difference of angles of its ends on a body."""
    start, stop = second.start_angle - first.start_angle, second.stop_angle - first.stop_angle
    bearing = second.body_angles[0] - first.body_angles[0]
    journal = second.body_angles[1] - first.body_angles[1]
    return max(abs(start - bearing), abs(stop - bearing), abs(start - journal), abs(stop - journal))


@update_worn_surfaces.member(Overlap)
def _update_worn_surfaces_overlap(pressure, joint, workspace, step_length, span, bins):
    """Add the wear under the OverlapArc in the middle of the span, or at the nodes of Lobatto's rule if it moves."""
    half_span = 0.5 * (span[1] - span[0])
    middle, bin_angle = arc_at(joint, workspace, span[0] + half_span), 2.0 * math.pi / bins[0].count
    distance = max(
        distance_between(middle, arc_at(joint, workspace, span[0])),
        distance_between(middle, arc_at(joint, workspace, span[1])),
    )
    is_steady = middle.overlap_integral > 0.0 and distance < MAX_DISTANCE * bin_angle
    load_sum, bearing_area, journal_area = 0.0, 0.0, 0.0
    if is_steady:
        load_sum = pressure_integral_over_load(joint, middle)
    for i in rolled_range(POINTS):
        fraction = span[0] + half_span * (1.0 + NODES[i])
        time = fraction, step_length * half_span
        if is_steady:
            areas = write_wear_at(joint, workspace, middle, load_sum, i, time)
            bearing_area, journal_area = bearing_area + areas[0], journal_area + areas[1]
        else:
            arc = arc_at(joint, workspace, fraction)
            areas = write_wear_at(joint, workspace, arc, pressure_integral_over_load(joint, arc), i, time)
            if arc.overlap_integral > 0.0:
                update_wear_under_arc(joint, arc, 0, areas[0], bins[0])
                update_wear_under_arc(joint, arc, 1, areas[1], bins[1])
    if is_steady:
        update_wear_under_arc(joint, middle, 0, bearing_area, bins[0])
        update_wear_under_arc(joint, middle, 1, journal_area, bins[1])
