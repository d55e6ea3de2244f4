"""Nearest or deepest point of worn surfaces; `joint.worn` uses it.

The deepest point is where the slope of g = e . u(phi) - h is zero, e sin(gamma - phi) = h', found from the direction
gamma of the eccentricity by Halley's method, of the third order, whose last step is differentiated.  This stationary
point is the deepest point in two cases.  If e^2 > h'^2 + h''^2 at all angles, there is only one such point on that
side. With r the least h + h'', h - r is the support function of a convex region; so the directions with g > -r are one
arc, and g has one maximum on it.  This is so wherever surfaces touch at one point, as c + r > 0.  Otherwise the journal
is close to the centre compared with the wear, and the deepest of SAMPLES samples is refined within a bracket.
"""

from typing import NamedTuple

import numpy as np

from ....tracing import portable
from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import rolled_range
from ....tracing.compiled.direction import direction
from ....tracing.compiled.dual import Dual, plain
from ....tracing.compiled.family import family, inlined, kernel, map_joints
from ...wear.shape import wear_depth_at
from ..offsets import after_number

NEXT_TO_LAST_STEP = 0.004  # rad, a quarter of the smallest smoothing width: after a smaller step the next is the last
MAX_LAST_STEP = 1e-4  # rad: largest last step, which is differentiated
MAX_STEPS, MAX_BISECTIONS = 8, 60
SAMPLES = 64  # samples round the bearing


class Surfaces(NamedTuple):
    """Worn shapes of both bodies of a joint, as tables."""

    clearance: float  # m, unworn
    bearing: float  # address of the table of a Shape
    journal: float


class GapWithAngles(NamedTuple):
    """A Gap with the angles of both bodies."""

    x: float  # m
    y: float  # m
    vx: float  # m/s
    vy: float  # m/s
    spin_proximal: float  # rad/s
    spin_distal: float  # rad/s
    angle_proximal: float  # rad
    angle_distal: float  # rad


class Nearest(NamedTuple):
    """The nearest or deepest point of the surfaces."""

    angle: float  # rad, of the normal
    nx: float  # normal of the bearing, outwards
    ny: float
    depth: float  # m, negative for a gap
    rate: float  # m/s, of the depth
    rolling_speed: float  # m/s, of the journal's surface over the bearing's from spins only
    radii: tuple  # m, worn radii of bearing and journal there
    slopes: tuple  # m/rad, h' of bearing and journal there
    local_clearance: float  # m, difference of the radii of curvature of the surfaces there
    normal_rate: float  # rad/s, of the normal


@inlined
def bodies_of(joint, gap):
    """Return angles (rad) and spins (rad/s) of the bearing's and of the journal's body: (angle, angle, spin, spin)."""
    bearing, journal = gap.angle_proximal, gap.angle_distal
    bearing_spin, journal_spin = gap.spin_proximal, gap.spin_distal
    if joint.side < 0.0:
        bearing, journal, bearing_spin, journal_spin = journal, bearing, journal_spin, bearing_spin
    return bearing, journal, bearing_spin, journal_spin


def _arctangent(square):
    root = np.sqrt(np.maximum(square, 1e-12))
    return portable.atan(root) / root


#: Coefficients of arctan(z) / z in powers of z^2, 0 to 1, to 5e-6: first guess of a search.
ARCTANGENT = portable.polynomial_through(_arctangent, 5)


@inlined
def approximate_angle(y, x):
    """Return the angle (rad) of a point (x, y), not the origin, to 5e-6."""
    larger, smaller = max(abs(x), abs(y)), min(abs(x), abs(y))
    z = smaller / larger
    square, total = z * z, 0.0
    for i in range(ARCTANGENT.size - 1, -1, -1):
        total = total * square + ARCTANGENT[i]
    angle = z * total
    angle = 0.5 * math.pi - angle if abs(y) > abs(x) else angle
    angle = math.pi - angle if x < 0.0 else angle
    return math.copysign(angle, y)


@inlined
def surfaces_of(joint):
    """Return the Surfaces of a worn joint."""
    return Surfaces(joint.clearance, joint.bearing.table, joint.journal.table)


@inlined
def halley(surfaces, angle, body_angles, radial, tangential_distance):
    """Return (step (rad) towards the deepest point, whether g is concave at `angle`, g (m) at `angle`).

    body_angles : the angles of bearing and journal, rad
    radial, tangential_distance : m, components of the eccentricity in the direction `angle`
    """
    bearing_wear, bearing_slope, bearing_curvature, bearing_third = wear_depth_at(
        surfaces.bearing, angle - body_angles[0]
    )
    journal_wear, journal_slope, journal_curvature, journal_third = wear_depth_at(
        surfaces.journal, angle - body_angles[1]
    )
    curvature = radial + (bearing_curvature + journal_curvature)
    inverse_curvature = 1.0 / curvature
    step = (tangential_distance - (bearing_slope + journal_slope)) * inverse_curvature
    third_order = -0.5 * (tangential_distance + (bearing_third + journal_third)) * step * inverse_curvature
    return step + step * min(max(third_order, -0.5), 0.5), curvature > 0.0, radial - (bearing_wear + journal_wear)


@kernel
def deepest_by_sampling(surfaces, x, y, body_angles):
    """Return the angle (rad) of the deepest point, from SAMPLES samples and Newton's method in a bracket."""
    greatest_depth, deepest_at, width = -math.inf, 0.0, 2.0 * math.pi / SAMPLES
    for i in rolled_range(SAMPLES):
        c, s = direction(i * width)
        bearing_wear, _, _, _ = wear_depth_at(surfaces.bearing, i * width - body_angles[0])
        journal_wear, _, _, _ = wear_depth_at(surfaces.journal, i * width - body_angles[1])
        if x * c + y * s - (bearing_wear + journal_wear) > greatest_depth:
            greatest_depth, deepest_at = x * c + y * s - (bearing_wear + journal_wear), i * width
    angle, low, high = deepest_at, deepest_at - width, deepest_at + width
    for _ in range(MAX_BISECTIONS):
        c, s = direction(angle)
        _, bearing_slope, bearing_curvature, _ = wear_depth_at(surfaces.bearing, angle - body_angles[0])
        _, journal_slope, journal_curvature, _ = wear_depth_at(surfaces.journal, angle - body_angles[1])
        residual, curvature = (
            y * c - x * s - (bearing_slope + journal_slope),
            x * c + y * s + bearing_curvature + journal_curvature,
        )
        low, high = (angle, high) if residual > 0.0 else (low, angle)
        newton_angle = angle + residual / curvature if curvature > 0.0 else low
        if not low < newton_angle < high:
            newton_angle = 0.5 * (low + high)
        correction, angle = abs(newton_angle - angle), newton_angle
        if correction < MAX_LAST_STEP:
            break
    return angle


@kernel
def step_tolerance(x):
    """Return the step length (rad) after which the next step is the last; smaller for derivatives."""
    return MAX_LAST_STEP if isinstance(x, Dual) else NEXT_TO_LAST_STEP


@inlined
def deepest_angle(joint, x, y, body_angles, tolerance):
    """Return the angle (rad) of the nearest point before the last step; tolerance : rad, of the next-to-last step."""
    surfaces = surfaces_of(joint)
    max_slope, max_curvature = (
        joint.bearing.max_slope + joint.journal.max_slope,
        joint.bearing.max_curvature + joint.journal.max_curvature,
    )
    min_radius = -(joint.bearing.min_radius_change + joint.journal.min_radius_change)
    square, angle, is_converged = x * x + y * y, 0.0 * x, False
    if square > 0.0:
        start_angle = approximate_angle(y, x)
        step, is_maximum, overlap = halley(surfaces, start_angle, body_angles, math.sqrt(square), 0.0)
        angle = start_angle + step
        for _ in range(MAX_STEPS):
            if not (is_maximum and abs(angle - start_angle) < 0.5 * math.pi):
                break
            if abs(step) < tolerance:
                is_converged = overlap > min_radius or square > max_slope * max_slope + max_curvature * max_curvature
                break
            c, s = direction(angle)
            step, is_maximum, overlap = halley(surfaces, angle, body_angles, x * c + y * s, y * c - x * s)
            angle += step
    if not is_converged:  # in some lane: what follows a return would be computed for none, too
        angle = deepest_by_sampling(surfaces, x, y, body_angles)
    return angle


@inlined
def nearest(joint, gap):
    """Return the Nearest of a GapWithAngles, differentiable through the last Newton step."""
    x, y, vx, vy = joint.side * gap.x, joint.side * gap.y, joint.side * gap.vx, joint.side * gap.vy
    bearing_angle, journal_angle, bearing_spin, journal_spin = bodies_of(joint, gap)
    angle = deepest_angle(joint, plain(x), plain(y), (plain(bearing_angle), plain(journal_angle)), step_tolerance(x))
    c, s = direction(angle)
    bearing_wear, bearing_slope, bearing_curvature, bearing_third = wear_depth_at(
        joint.bearing.table, angle - bearing_angle
    )
    journal_wear, journal_slope, journal_curvature, journal_third = wear_depth_at(
        joint.journal.table, angle - journal_angle
    )
    radial, tangential_distance = x * c + y * s, y * c - x * s
    residual = tangential_distance - (bearing_slope + journal_slope)
    curvature = plain(radial) + bearing_curvature + journal_curvature
    inverse_curvature = 1.0 / curvature if curvature > 0.0 else 0.0
    correction = residual * inverse_curvature
    skew = plain(tangential_distance) + (bearing_third + journal_third)
    correction, third_of_skew = (
        correction - 0.5 * skew * inverse_curvature * correction * correction,
        skew * (1.0 / 3.0),
    )
    cosine = 1.0 - 0.5 * correction * correction  # series of the cosine of the remainder
    nx, ny = c * cosine - s * correction, s * cosine + c * correction
    radii = joint.bearing_radius + bearing_wear, joint.journal_radius - journal_wear
    slopes = (
        bearing_slope + correction * (bearing_curvature + 0.5 * bearing_third * correction),
        journal_slope + correction * (journal_curvature + 0.5 * journal_third * correction),
    )
    return Nearest(
        angle=angle + plain(correction),
        nx=nx,
        ny=ny,
        depth=radial
        + correction * (residual - 0.5 * correction * (curvature + third_of_skew * correction))
        - (joint.clearance + (bearing_wear + journal_wear)),
        rate=vx * nx + vy * ny + slopes[0] * bearing_spin + slopes[1] * journal_spin,
        rolling_speed=journal_spin * radii[1] - bearing_spin * radii[0],
        radii=radii,
        slopes=slopes,
        local_clearance=joint.clearance + (bearing_wear + bearing_curvature + journal_wear + journal_curvature),
        normal_rate=(vy * c - vx * s + bearing_curvature * bearing_spin + journal_curvature * journal_spin)
        * inverse_curvature,
    )


# ---------------------------------------------------------------------------------------------- angles of the bodies


@family
def with_angles(joint, gap, angles):
    """Return the Gap of a joint, with the angles (rad) of its bodies if the joint needs them."""


@with_angles.member(None)
def _default_with_angles(joint, gap, angles):
    return gap


@inlined
def gap_with_angles(joint, gap, angles):
    """Return the GapWithAngles of a Gap; angles : rad, of the proximal and the distal body."""
    return GapWithAngles(
        x=gap.x,
        y=gap.y,
        vx=gap.vx,
        vy=gap.vy,
        spin_proximal=gap.spin_proximal,
        spin_distal=gap.spin_distal,
        angle_proximal=angles[0],
        angle_distal=angles[1],
    )


@kernel
def _with_angles(joint, gap_and_angles, index, _context):
    return with_angles(joint, gap_and_angles[0], gap_and_angles[1])


@kernel
def _pair(gap, angles, index, _context):
    return gap, angles


_with_all_angles, _pairs = map_joints(_with_angles, after_number), map_joints(_pair, after_number)


@inlined
def with_body_angles(joints, relative, angles):
    """Return the Gaps `relative` of joints, for worn joints with the `angles` of their bodies."""
    return _with_all_angles(joints, _pairs(relative, angles, 0, 0), 0, 0)
