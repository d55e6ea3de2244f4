"""Worn surfaces on a bed of springs, and wear in proportion to their overlap.

The springs are those of `pressure: winkler` with `elastic: winkler` and `evolve: true`.  Where the surfaces overlap by
f(phi) = e . u(phi) - c - h_b(phi - theta_b) - h_j(phi - theta_j), the layer presses with k f.  Its stored energy is

    W = (1/2) K integral of f^2 dphi,   K = k R_b L ,

whose derivatives by e and by the angles of the bodies are its force and its moments: K times the integrals of f u,
f h_b' and f h_j'.  Laws of the normal force use one penetration: here that of the circular joint with equal energy,
W_0(depth) = W.  Its derivative with respect to the depth is F_0(depth), the closed form of the circular joint; so the
depth grows by g = K integral(f u) / F_0 as the journal moves, and all forces are those of the circular joint times
|g|, in its direction.  An impact has the restitution of the law, whatever the shape.

The arc over which f is above zero has two ends, found by Halley's method, and the integrals are Gauss's.  The depth
follows from the surfaces alone, by Newton's method.  With F_0 at the root of penetration instead, the root would keep
W_0(pen) - W rather than pen - depth: an error far below the tolerance under load is a whole penetration without load.

Wear is in proportion to the overlap with `pressure: winkler` and `evolve: true`, whatever the elastic law.  In the
frame of the normal at the deepest point the surfaces overlap by

    f(psi) = (penetration + c + h(0)) cos psi + h'(0) sin psi - c - h(psi)   (m)

c : radial clearance (m); h : wear depth of bearing and journal together (m); psi : angle from the deepest point
(rad); penetration : the maximum of f (m), at psi = 0.

The pressure is proportional to f.  Under a steady load the surfaces so wear into arcs of the same radius, on which f
varies as cos psi.  Its fraction before the edge of a bin is known in closed form, because the table of a shape has the
integral of h.  The wear is integrated by Lobatto's rule over the step, whose length is in tau; the factor kappa =
dt/dtau (s) makes it a time.  The total wear of a body is that of the law.  A bin whose edge an end of the arc passes
within a step receives an approximate depth.
"""

from typing import NamedTuple

import numpy as np

from ...tracing import portable
from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import direction, lane_range, rolled_range, where
from ...tracing.compiled.dual import plain
from ...tracing.compiled.family import family_with_default, inlined, kernel
from ...tracing.memory import Rows
from ..laws.elastic import elastic_force
from ..wear import SlidingContact, update_wear_over_span, wear_rate
from ..wear.arc import (
    NODES,
    POINTS,
    WEIGHTS,
    ArcRows,
    evaluate_polynomial,
    range_of_row,
    row_sum,
    write_pressure,
)
from ..wear.bins import update_wear_over_arc
from ..wear.shape import KNOT_SPACING, Shape, wear_depth_at, wear_integral_at, wear_moments_at
from .worn import (
    GapWithAngles,
    GeneralisedDepth,
    Surfaces,
    WornJoint,
    WornOnFoundation,
    bodies_of,
    generalised_depth,
    nearest,
    seated_position,
    surfaces_of,
)

GAUSS_POINTS = 7  # points of Gauss's rule: to 1e-10 over half an arc of 60 degrees
GAUSS_NODES, GAUSS_WEIGHTS = portable.gauss_rule(GAUSS_POINTS)
END_TOLERANCE = 0.05  # of the distance to an end of the arc: after a smaller Halley step the next is 1e-4 of it
MAX_LAST_STEP = 0.25 * KNOT_SPACING  # rad: over more, an edge of a groove is no parabola
MAX_STEPS = 30  # the last bisections are of 1e-8 rad
#: Newton steps for the generalised depth, and the relative step after which the next one is the last, to 1e-12.
DEPTH_ITERATIONS, DEPTH_TOLERANCE = 8, 1e-3
MAX_END_ANGLE = 1.7  # rad from the deepest point: there f is always negative
MIN_RADIUS_DIFFERENCE = 0.05  # clearances: least difference of curvature radii in the first guess of an arc's end
POINT_CONTACT_DEPTH = 1e-8  # clearances: a smaller penetration is treated as a point contact


def _arc_angle(depth_ratio):
    """Return twice the half-angle theta (rad) of the arc of circles; depth_ratio : pen / (2 c + pen)."""
    return 4.0 * portable.atan(np.sqrt(depth_ratio))


def _energy_series(depth_ratio):
    """Return W_0 over K (c + pen)^2 depth_ratio^(5/2), half of u + (u / 2) cos u - (3 / 2) sin u, as a series."""
    u = _arc_angle(depth_ratio)
    terms = ((-1.0) ** k * (0.25 / math.factorial(2 * k) - 0.75 / math.factorial(2 * k + 1)) for k in range(2, 20))
    series = sum(term * portable.power(u, 2 * k) for k, term in enumerate(terms))
    return series * portable.power(u, 5) / portable.power(depth_ratio, 2.5)


def _force_series(depth_ratio):
    """Return F_0 over K (c + pen) depth_ratio^(3/2): half of u - sin u, as a series."""
    u = _arc_angle(depth_ratio)
    terms = (0.5 * (-1.0) ** (k + 1) / math.factorial(2 * k + 1) for k in range(1, 20))
    series = sum(term * portable.power(u, 2 * k) for k, term in enumerate(terms))
    return series * portable.power(u, 3) / portable.power(depth_ratio, 1.5)


#: Coefficients of both by powers of the fraction, to 1e-10 and 1e-11.
ENERGY_SERIES, FORCE_SERIES = (
    portable.polynomial_through(function, 15) for function in (_energy_series, _force_series)
)


@inlined
def overlap(surfaces, x, y, angle, body_angles):
    """Return f (m) at an angle (rad), its slope and curvature; x, y : journal's centre, m; body_angles : (2,) rad."""
    c, s = direction(angle)
    bearing_wear, bearing_slope, bearing_curvature, _ = wear_depth_at(surfaces.bearing, angle - body_angles[0])
    journal_wear, journal_slope, journal_curvature, _ = wear_depth_at(surfaces.journal, angle - body_angles[1])
    radial = x * c + y * s
    return (
        radial - (surfaces.clearance + (bearing_wear + journal_wear)),
        y * c - x * s - (bearing_slope + journal_slope),
        -(radial + (bearing_curvature + journal_curvature)),
    )


@inlined
def end_step(overlap_values, distance, sign, interval):
    """Return the angle (rad) from the deepest point to an arc's end, one step from `distance` (rad).

    A Halley step, or half of the bracket where that leaves it.  Also return whether the next step is accurate, and the
    bracket (rad) of the end: f is positive before and not behind it.
    """
    f, slope, curvature = overlap_values
    slope = sign * slope
    inside, outside = (distance, interval[1]) if f > 0.0 else (interval[0], distance)
    inverse_slope = 1.0 / slope if slope < 0.0 else 0.0
    step = f * inverse_slope
    halley = distance - step / (1.0 - min(max(0.5 * curvature * step * inverse_slope, -0.5), 0.5))
    is_inside = slope < 0.0 and inside < halley < outside
    end = halley if is_inside else 0.5 * (inside + outside)
    return end, is_inside and abs(end - distance) < min(END_TOLERANCE * end, MAX_LAST_STEP), (inside, outside)


@kernel
def arc_ends(surfaces, x, y, body_angles, guess):
    """Return the angles (rad) from the deepest point to the two ends of the arc.

    guess : rad, angle of the deepest point, and the angle from there to one end.
    """
    arc_middle, low, high = guess[0], guess[1], guess[1]
    low_bracket, high_bracket = (0.0, MAX_END_ANGLE), (0.0, MAX_END_ANGLE)
    for _ in range(MAX_STEPS):
        at_low = overlap(surfaces, x, y, arc_middle - low, body_angles)
        at_high = overlap(surfaces, x, y, arc_middle + high, body_angles)
        low, is_low_accurate, low_bracket = end_step(at_low, low, -1.0, low_bracket)
        high, is_high_accurate, high_bracket = end_step(at_high, high, 1.0, high_bracket)
        if is_low_accurate and is_high_accurate:
            break
    return low, high


@inlined
def circle_energy_and_force(clearance, pen):
    """Return W_0 / K (m^2) and F_0 / K (m) of circles at a penetration `pen` (m), without the arctangent of a law."""
    depth_ratio, energy, force = pen / (2.0 * clearance + pen), 0.0, 0.0
    for i in range(ENERGY_SERIES.size - 1, -1, -1):
        energy = energy * depth_ratio + ENERGY_SERIES[i]
        force = force * depth_ratio + FORCE_SERIES[i]
    scale = (clearance + pen) * depth_ratio * math.sqrt(depth_ratio)
    return (clearance + pen) * scale * depth_ratio * energy, scale * force


@kernel
def circle_depth(clearance, energy):
    """Return the penetration (m) of circles at W_0 / K = `energy` (m^2), and F_0 / K (m) there; both differentiable."""
    target = plain(energy)
    depth = (target * (5.656854249492381 / ENERGY_SERIES[0])) ** 0.4 * clearance**0.2  # of a shallow arc; 2^2.5
    for _ in range(DEPTH_ITERATIONS):
        circle_energy, circle_force = circle_energy_and_force(clearance, depth)
        step = (target - circle_energy) / circle_force
        depth = depth + step
        if abs(step) < DEPTH_TOLERANCE * depth:
            break
    circle_energy, circle_force = circle_energy_and_force(clearance, depth)
    depth = depth + (energy - circle_energy) / circle_force
    return depth, circle_energy_and_force(clearance, depth)[1]


@generalised_depth.member(WornOnFoundation)
def _generalised_depth_worn_on_foundation(joint, nearest_point, gap):
    x, y = joint.side * gap.x, joint.side * gap.y
    bearing_angle, journal_angle, _, _ = bodies_of(joint, gap)
    c = joint.clearance
    radius_difference = max(plain(nearest_point.local_clearance), MIN_RADIUS_DIFFERENCE * c)
    if nearest_point.depth <= POINT_CONTACT_DEPTH * c:
        point_factor = (c / radius_difference) ** 0.2  # f is a parabola
        return GeneralisedDepth(
            nx=nearest_point.nx,
            ny=nearest_point.ny,
            depth=point_factor * nearest_point.depth,
            force_factor=point_factor + 0.0 * nearest_point.depth,
            body_slopes=(point_factor * nearest_point.slopes[0], point_factor * nearest_point.slopes[1]),
        )
    body_angles, point_depth = (plain(bearing_angle), plain(journal_angle)), plain(nearest_point.depth)
    guess = nearest_point.angle, math.sqrt(2.0 * point_depth / (radius_difference + point_depth))
    low, high = arc_ends(surfaces_of(joint), plain(x), plain(y), body_angles, guess)
    half_width, arc_middle = 0.5 * (high + low), nearest_point.angle + 0.5 * (high - low)
    zero = 0.0 * nearest_point.depth
    x_sum, y_sum, bearing_sum, journal_sum, energy_sum = zero, zero, zero, zero, zero
    for i in range(GAUSS_POINTS):
        angle = arc_middle + half_width * GAUSS_NODES[i]
        ux, uy = direction(angle)
        bearing_wear, bearing_slope, _, _ = wear_depth_at(joint.bearing.table, angle - bearing_angle)
        journal_wear, journal_slope, _, _ = wear_depth_at(joint.journal.table, angle - journal_angle)
        f = x * ux + y * uy - (c + (bearing_wear + journal_wear))
        weighted_overlap = GAUSS_WEIGHTS[i] * f
        x_sum, y_sum = x_sum + weighted_overlap * ux, y_sum + weighted_overlap * uy
        bearing_sum = bearing_sum + weighted_overlap * bearing_slope
        journal_sum = journal_sum + weighted_overlap * journal_slope
        energy_sum = energy_sum + weighted_overlap * f
    depth, circle_force = circle_depth(c, 0.5 * half_width * energy_sum)
    scale = half_width / circle_force
    gx, gy, body_slopes = scale * x_sum, scale * y_sum, (scale * bearing_sum, scale * journal_sum)
    force_factor = math.sqrt(gx * gx + gy * gy)
    return GeneralisedDepth(gx / force_factor, gy / force_factor, depth, force_factor, body_slopes)


@seated_position.member(WornOnFoundation)
def _seated_position_worn_on_foundation(joint, eccentricity, angles):
    """Both components of the force are those of the load, by Newton's method with differences."""
    distance = float(np.hypot(*eccentricity))
    load, pen = elastic_force(joint.elastic, distance - joint.clearance), distance - joint.clearance

    def force_and_depth(pin):
        gap = GapWithAngles(joint.side * pin[0], joint.side * pin[1], 0.0, 0.0, 0.0, 0.0, *angles)
        generalised = generalised_depth(joint, nearest(joint, gap), gap)
        magnitude = generalised.force_factor * elastic_force(joint.elastic, max(generalised.depth, 0.0))
        return np.array([magnitude * generalised.nx, magnitude * generalised.ny]) / load, generalised.depth

    pin, target = seated_position(WornJoint(*joint), eccentricity, angles)[0], eccentricity / distance
    for _ in range(MAX_STEPS):
        current_force, _ = force_and_depth(pin)
        step = 1e-6 * pen
        jacobian = np.array([(force_and_depth(pin + step * axis)[0] - current_force) / step for axis in np.eye(2)]).T
        correction = portable.solve(jacobian, target - current_force)
        pin = pin + correction * min(1.0, pen / float(np.hypot(*correction)))
        if np.hypot(*correction) < 1e-13 * distance:
            break
    return pin, force_and_depth(pin)[1]


# ---------------------------------------------------------------------------------------------- wear by the overlap


MAX_DISTANCE = 0.25  # bins: an arc that moves less within a step counts as standing
MIDDLE_AND_ENDS = np.array([0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])  # of a span, half spans from its middle


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
    body_angles = (
        -evaluate_polynomial(workspace.step.bearing_angle, fraction),
        -evaluate_polynomial(workspace.step.journal_angle, fraction),
    )
    penetration = evaluate_polynomial(workspace.step.penetration, fraction)
    surfaces = conformal_surfaces(joint)
    bearing_wear, bearing_slope, bearing_curvature, _ = wear_depth_at(surfaces.bearing, -body_angles[0])
    journal_wear, journal_slope, journal_curvature, _ = wear_depth_at(surfaces.journal, -body_angles[1])
    cos_coefficient = penetration + joint.clearance + (bearing_wear + journal_wear)
    sin_coefficient = bearing_slope + journal_slope
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
    return arc._replace(overlap_integral=overlap_integral)


@inlined
def overlap_moments(joint, arc, psi):
    """Return the antiderivatives of f cos psi and f sin psi (m rad), but for constants; psi : angle (rad)."""
    c, s = direction(psi)
    bearing = wear_moments_at(joint.wear.pressure.bearing, psi, arc.body_angles[0])
    journal = wear_moments_at(joint.wear.pressure.journal, psi, arc.body_angles[1])
    a, b = arc.cos_coefficient, arc.sin_coefficient
    return (
        0.5 * (a * (psi + c * s) + b * s * s) - joint.clearance * s - (bearing[0] + journal[0]),
        0.5 * (a * s * s + b * (psi - c * s)) + joint.clearance * c - (bearing[1] + journal[1]),
    )


@kernel
def resultant(joint, arc):
    """Return the magnitude of the integral of f (cos psi, sin psi) over an OverlapArc, m rad.

    Exact, as the worn surfaces differ in curvature from knot to knot; over less than an interval by Lobatto's rule, as
    there the exact one loses its digits.
    """
    half_angle = 0.5 * (arc.stop_angle - arc.start_angle)
    if 2.0 * half_angle > KNOT_SPACING:
        before, behind = overlap_moments(joint, arc, arc.start_angle), overlap_moments(joint, arc, arc.stop_angle)
        normal_sum, tangential_sum = behind[0] - before[0], behind[1] - before[1]
    else:
        normal_sum, tangential_sum = 0.0, 0.0
        for i in rolled_range(POINTS):
            psi = arc.start_angle + half_angle * (1.0 + NODES[i])
            f, _, _ = overlap(conformal_surfaces(joint), arc.cos_coefficient, arc.sin_coefficient, psi, arc.body_angles)
            normal_sum += half_angle * WEIGHTS[i] * f * math.cos(psi)
            tangential_sum += half_angle * WEIGHTS[i] * f * math.sin(psi)
    return math.sqrt(normal_sum * normal_sum + tangential_sum * tangential_sum)


@kernel
def pressure_integral_over_load(joint, arc):
    """Return the integral of the pressure over an OverlapArc over the magnitude of its resultant."""
    return arc.overlap_integral / resultant(joint, arc) if arc.overlap_integral > 0.0 else 0.0


@inlined
def sliding_contact_on(joint, workspace, arc, fraction):
    """Return the SlidingContact on an OverlapArc at a fraction (0 to 1) of a step."""
    line_load = max(evaluate_polynomial(workspace.step.line_load, fraction), 0.0)
    sliding_distance = workspace.step.distance[0] + workspace.step.distance[1] * fraction
    return SlidingContact(
        line_load=line_load,
        depth=arc.penetration,
        sliding_speed=abs(evaluate_polynomial(workspace.step.slip, fraction)),
        friction_power=max(evaluate_polynomial(workspace.step.friction_power, fraction), 0.0),
        sliding_distance=sliding_distance,
        pressure_integral=line_load * pressure_integral_over_load(joint, arc),
        clearance=joint.clearance,
        half_angle=0.5 * (arc.stop_angle - arc.start_angle),
    )


class OverlapRows(Rows):
    """Rows of a span, each of POINTS numbers: OverlapArcs, and the wear of a body under them."""

    cos_coefficient: float  # the fields of an OverlapArc
    sin_coefficient: float
    bearing_angle: float
    journal_angle: float
    start_angle: float
    stop_angle: float
    penetration: float
    overlap_integral: float
    fraction: float  # of the step, 0 to 1
    area: float  # m rad, worn from the body
    start: float  # rad, ends of the arc on the body
    stop: float


class EdgeRows(Rows):
    """Rows of a body, each of POINTS numbers, from which its wear before an edge follows, and that wear."""

    sine_coefficient: float  # m, of the sine and the cosine of the edge's angle
    cosine_coefficient: float  # m
    at_start: float  # m rad, antiderivative of f at the start of the arc, and c t
    per_overlap: float  # 1, wear over the integral of f
    between: float  # rad, angle of this body minus that of the other
    worn: float  # m rad, wear before edges


#: The rows of both in those of a body, free under this pressure.
_FREE = ArcRows.index_of("rate")


@kernel
def write_arcs(joint, workspace, arcs):
    """Write the OverlapArcs at the fractions in their OverlapRows."""
    for i in lane_range(POINTS):
        arc = arc_at(joint, workspace, arcs.fraction[i])
        for k, number in enumerate((*arc[:2], *arc.body_angles, *arc[3:])):
            arcs.numbers[k, i] = number


@inlined
def arc_in(arcs, i):
    """Return OverlapArc `i` of OverlapRows."""
    numbers = tuple(arcs.numbers[k, i] for k in range(8))
    return OverlapArc(numbers[0], numbers[1], numbers[2:4], *numbers[4:])


@kernel
def write_wear(joint, workspace, arcs, middle, half_span, step_length):
    """Write the wear under the OverlapArc of each node of Lobatto's rule over a span, and its pressure.

    middle, half_span : fractions of the step; step_length : s over kappa
    """
    for i in lane_range(POINTS):
        arc, fraction = arc_in(arcs, i), middle + half_span * NODES[i]
        duration = step_length * half_span * WEIGHTS[i] * max(evaluate_polynomial(workspace.step.kappa, fraction), 0.0)
        width, bearing_area, journal_area = arc.stop_angle - arc.start_angle, 0.0, 0.0
        mean_pressure, largest_pressure, speed = 0.0, 0.0, 0.0
        if arc.overlap_integral > 0.0:
            sliding = sliding_contact_on(joint, workspace, arc, fraction)
            bearing_rate, journal_rate = wear_rate(joint.wear, sliding)
            bearing_area = duration * bearing_rate / joint.bearing_radius
            journal_area = duration * journal_rate / joint.journal_radius
            pressure_sum, speed = sliding.pressure_integral / joint.bearing_radius, sliding.sliding_speed
            mean_pressure = pressure_sum / width
            # the largest pressure is where the surfaces overlap most
            largest_pressure = pressure_sum * arc.penetration / arc.overlap_integral
        write_pressure(workspace, i, (mean_pressure, largest_pressure), speed, duration)
        workspace.bearing.half[i] = 0.5 * width
        workspace.bearing.area[i], workspace.journal.area[i] = bearing_area, journal_area


@kernel
def update_wear_under_arcs(joint, arcs, body, count, bins, rows):
    """Add the wear of a body, 0 the bearing and 1 the journal, under the first `count` OverlapArcs to its bins.

    arcs : OverlapRows with the worn areas; rows : EdgeRows, workspace.

    With t and t' the angles of this and of the other body, an antiderivative of f at the angle e on the body is

        (a cos t + b sin t) sin e + (a sin t - b cos t) cos e - c (e + t) - H(e) - H'(e + t - t') ,

    H and H' : integrals of the wear of this and of the other body.
    """
    own, other = joint.wear.pressure[body], joint.wear.pressure[1 - body]
    for i in lane_range(POINTS):
        arc = arc_in(arcs, i)
        turn, is_worn = arc.body_angles[body], arc.overlap_integral > 0.0
        c, s = direction(turn)
        rows.sine_coefficient[i] = arc.cos_coefficient * c + arc.sin_coefficient * s
        rows.cosine_coefficient[i] = arc.cos_coefficient * s - arc.sin_coefficient * c
        rows.at_start[i] = overlap_antiderivative(joint, arc, arc.start_angle) + joint.clearance * turn
        rows.per_overlap[i] = where(is_worn, arcs.area[i] / where(is_worn, arc.overlap_integral, 1.0), 0.0)
        rows.between[i] = turn - arc.body_angles[1 - body]
        arcs.start[i] = where(is_worn, arc.start_angle - turn, math.inf)
        arcs.stop[i] = where(is_worn, arc.stop_angle - turn, -math.inf)
    bin_angle, bins_per_radian = 2.0 * math.pi / bins.count, bins.count / (2.0 * math.pi)
    first_bin = math.floor(range_of_row(arcs.start)[0] / bin_angle)
    last_bin = math.floor(range_of_row(arcs.stop)[1] / bin_angle)
    bin_index, number, before = first_bin % bins.count, POINTS, 0.0
    for edge_index in range(first_bin + 1, last_bin + 2):
        if number == POINTS:
            number = 0
            for k in lane_range(POINTS):
                edge, total = (edge_index + k) * bin_angle, 0.0
                c, s = direction(edge)
                own_integral = joint.clearance * edge + wear_integral_at(own, edge)
                for i in rolled_range(count):
                    other_integral = wear_integral_at(other, edge + rows.between[i])
                    overlap_integral = rows.sine_coefficient[i] * s + rows.cosine_coefficient[i] * c - rows.at_start[i]
                    worn = (overlap_integral - (own_integral + other_integral)) * rows.per_overlap[i]
                    worn = where(edge < arcs.stop[i], min(max(worn, 0.0), arcs.area[i]), arcs.area[i])
                    total += where(edge > arcs.start[i], worn, 0.0)
                rows.worn[k] = total
        bins.depths[bins.start + bin_index] += max(rows.worn[number] - before, 0.0) * bins_per_radian
        before = rows.worn[number]
        number += 1
        bin_index = bin_index + 1 if bin_index + 1 < bins.count else 0


@update_wear_over_span.member(WornJoint, WornOnFoundation)
def _update_wear_over_span_worn_joint_or_worn_on_foundation(joint, workspace, step_length, span, bins):
    update_worn_surfaces(joint.wear.pressure, joint, workspace, step_length, span, bins)


@family_with_default
def update_worn_surfaces(pressure, joint, workspace, step_length, span, bins):
    """Do what `update_wear_over_span` says for a worn joint with this pressure."""
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
    half_span, middle = 0.5 * (span[1] - span[0]), span[0] + 0.5 * (span[1] - span[0])
    arcs = OverlapRows(workspace.journal.numbers[_FREE : _FREE + OverlapRows.SIZE])
    rows = EdgeRows(workspace.bearing.numbers[_FREE : _FREE + EdgeRows.SIZE])
    for i in lane_range(POINTS):
        arcs.fraction[i] = middle + half_span * MIDDLE_AND_ENDS[i]
    write_arcs(joint, workspace, arcs)
    arc = arc_in(arcs, 0)
    distance = max(distance_between(arc, arc_in(arcs, 1)), distance_between(arc, arc_in(arcs, 2)))
    is_steady = arc.overlap_integral > 0.0 and distance < MAX_DISTANCE * 2.0 * math.pi / bins[0].count
    if is_steady:
        for i in lane_range(POINTS):
            for k, number in enumerate((*arc[:2], *arc.body_angles, *arc[3:])):
                arcs.numbers[k, i] = number
    else:
        for i in lane_range(POINTS):
            arcs.fraction[i] = middle + half_span * NODES[i]
        write_arcs(joint, workspace, arcs)
    write_wear(joint, workspace, arcs, middle, half_span, step_length)
    for body, body_rows in enumerate((workspace.bearing, workspace.journal)):
        total = row_sum(body_rows.area)
        for i in lane_range(POINTS):
            arcs.area[i] = where(is_steady, total, body_rows.area[i])
        if total > 0.0:
            update_wear_under_arcs(joint, arcs, body, 1 if is_steady else POINTS, bins[body], rows)
