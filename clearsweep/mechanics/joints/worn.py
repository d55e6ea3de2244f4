"""A revolute joint in which the worn shapes act on the contact (`wear.evolve`).

Bearing and journal are circles minus wear, a function h of the angle in the frame of each body (`wear.shape`),
which is constant during a run.  With u(phi) the unit vector at an angle, e the eccentricity and theta the
angles of the bodies, the surfaces penetrate where they are closest by

    depth = max over phi of  e . u(phi) - c - h_b(phi - theta_b) - h_j(phi - theta_j) .

The normal is u there.  By virtual work the normal force F turns the bearing by -F h_b' and the journal by -F h_j',
since the rate of the depth is v . u + h_b' omega_b + h_j' omega_j: the stored energy is a potential, and
only the law dissipates energy.  Sliding is at the worn radii.

The deepest point is where the slope of g = e . u(phi) - h is zero, e sin(gamma - phi) = h', found from the direction
gamma of the eccentricity by Halley's method, of the third order, whose last step is differentiated.  A stage of a step
is searched from where the last sweep found it, as long as that is near.  This stationary point is the deepest point in
two cases.  If e^2 > h'^2 + h''^2 at all angles, there is only one such point on that
side. With r the least h + h'', h - r is the support function of a convex region; so the directions with g > -r are one
arc, and g has one maximum on it.  This is so wherever surfaces touch at one point, as c + r > 0.  Otherwise the journal
is close to the centre compared with the wear, and the deepest of SAMPLES samples is refined within a bracket.
"""

from typing import NamedTuple

import numpy as np

from ...tracing import portable
from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import direction, rolled_range
from ...tracing.compiled.dual import Dual, as_type_of, plain
from ...tracing.compiled.family import family, family_with_default, inlined, kernel
from ..laws.contract import FREE
from ..laws.friction import friction_force
from ..wear import contact_angle, local_clearance
from ..wear.shape import Shape, wear_depth_at
from .contract import CONTACT_FIELDS, contacts_at_speed, load, power_lost, power_stored, with_current_laws
from .dry import Gap, Joint, load_on_journal, no_load, normal_forces, register_single_contact, separate_contact

NEXT_TO_LAST_STEP = 0.004  # rad, a quarter of the smallest smoothing width: after a smaller step the next is the last
MAX_LAST_STEP = 1e-4  # rad: largest last step, which is differentiated
NEGLIGIBLE_STEP = 1e-6  # rad: a smaller step from where the deepest point was found last is the last one
MAX_STEPS, MAX_BISECTIONS = 8, 60
SAMPLES = 64  # samples round the bearing


class Surfaces(NamedTuple):
    """Worn shapes of both bodies of a joint, as tables."""

    clearance: float  # m, unworn
    bearing: float  # address of the table of a Shape
    journal: float


GapWithAngles = NamedTuple(
    "GapWithAngles", [*Gap.__annotations__.items(), ("angle_proximal", float), ("angle_distal", float)]
)
GapWithAngles.__doc__ = "A Gap with the angles (rad) of both bodies."


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


class SurfacePoint(NamedTuple):
    """The surfaces in a direction in space."""

    c: float  # cosine and sine of its angle
    s: float
    radial: float  # m, components of the eccentricity along it and across
    tangential: float
    bearing: tuple  # h (m) of the body and its first three derivatives
    journal: tuple


@inlined
def place_at(joint, x, y, body_angles, angle):
    """Return the SurfacePoint at an angle (rad); x, y : m, of the journal; body_angles : rad, of both bodies."""
    c, s = direction(angle)
    bearing = wear_depth_at(joint.bearing.table, angle - body_angles[0])
    journal = wear_depth_at(joint.journal.table, angle - body_angles[1])
    return SurfacePoint(c, s, x * c + y * s, y * c - x * s, bearing, journal)


@inlined
def halley(place):
    """Return (step (rad) towards the deepest point, whether g is concave at a SurfacePoint, g (m) there)."""
    _, _, radial, tangential_distance, bearing, journal = place
    bearing_wear, bearing_slope, bearing_curvature, bearing_third = bearing
    journal_wear, journal_slope, journal_curvature, journal_third = journal
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
        residual = y * c - x * s - (bearing_slope + journal_slope)
        curvature = x * c + y * s + bearing_curvature + journal_curvature
        low, high = (angle, high) if residual > 0.0 else (low, angle)
        newton_angle = angle + residual / curvature if curvature > 0.0 else low
        if not low < newton_angle < high:
            newton_angle = 0.5 * (low + high)
        correction, angle = abs(newton_angle - angle), newton_angle
        if correction < MAX_LAST_STEP:
            break
    return angle


@inlined
def is_only_maximum(joint, square, overlap):
    """Return whether a maximum of g is the only one; square : m^2, of the eccentricity; overlap : m, g there."""
    max_slope = joint.bearing.max_slope + joint.journal.max_slope
    max_curvature = joint.bearing.max_curvature + joint.journal.max_curvature
    min_radius = -(joint.bearing.min_radius_change + joint.journal.min_radius_change)
    return overlap > min_radius or square > max_slope * max_slope + max_curvature * max_curvature


@inlined
def deepest_angle(joint, x, y, body_angles, tolerance):
    """Return the angle (rad) of the nearest point before the last step; tolerance : rad, of the next-to-last step."""
    square, angle, is_converged = x * x + y * y, 0.0 * x, False
    if square > 0.0:
        start_angle = approximate_angle(y, x)
        start = place_at(joint, x, y, body_angles, start_angle)
        step, is_maximum, overlap = halley(start._replace(radial=math.sqrt(square), tangential=0.0))
        angle = start_angle + step
        for _ in range(MAX_STEPS):
            if not (is_maximum and abs(angle - start_angle) < 0.5 * math.pi):
                break
            if abs(step) < tolerance:
                is_converged = is_only_maximum(joint, square, overlap)
                break
            step, is_maximum, overlap = halley(place_at(joint, x, y, body_angles, angle))
            angle += step
    if not is_converged:  # in some lane: what follows a return would be computed for none, too
        angle = deepest_by_sampling(surfaces_of(joint), x, y, body_angles)
    return angle


@inlined
def nearest(joint, gap, last_angle=None):
    """Return the Nearest of a GapWithAngles, differentiable through the last Newton step.

    last_angle : (1,) rad, its angle where it was found last, which is replaced; None if it is not known.
    """
    x, y, vx, vy = joint.side * gap.x, joint.side * gap.y, joint.side * gap.vx, joint.side * gap.vy
    bearing_angle, journal_angle, bearing_spin, journal_spin = bodies_of(joint, gap)
    plain_angles = plain(bearing_angle), plain(journal_angle)
    if last_angle is None:
        tolerance = MAX_LAST_STEP if isinstance(x, Dual) else NEXT_TO_LAST_STEP
        angle = deepest_angle(joint, plain(x), plain(y), plain_angles, tolerance)
        there = place_at(joint, x, y, (bearing_angle, journal_angle), angle)
    else:
        angle, there = last_angle[0], place_at(joint, x, y, plain_angles, last_angle[0])
        step, is_maximum, overlap = halley(there)
        is_near = is_maximum and there.radial > 0.0 and abs(step) < NEXT_TO_LAST_STEP
        is_near = is_near and is_only_maximum(joint, x * x + y * y, overlap)
        if not (is_near and abs(step) < NEGLIGIBLE_STEP):
            angle += step
            if not is_near:
                angle = deepest_angle(joint, x, y, plain_angles, NEXT_TO_LAST_STEP)
            there = place_at(joint, x, y, plain_angles, angle)
    c, s, radial, tangential_distance, bearing, journal = there
    bearing_wear, bearing_slope, bearing_curvature, bearing_third = bearing
    journal_wear, journal_slope, journal_curvature, journal_third = journal
    residual = tangential_distance - (bearing_slope + journal_slope)
    curvature = plain(radial) + bearing_curvature + journal_curvature
    inverse_curvature = 1.0 / curvature if curvature > 0.0 else 0.0
    correction = residual * inverse_curvature
    skew = plain(tangential_distance) + (bearing_third + journal_third)
    correction = correction - 0.5 * skew * inverse_curvature * correction * correction
    third_of_skew = skew * (1.0 / 3.0)
    if last_angle is not None:
        last_angle[0] = angle + correction
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


@family_with_default
def with_angles(joint, gap, angles):
    """Return the Gap of a joint, with the angles (rad) of its bodies if the joint needs them."""
    return gap


@inlined
def gap_with_angles(joint, gap, angles):
    """Return the GapWithAngles of a Gap; angles : rad, of the proximal and the distal body."""
    return GapWithAngles(*gap, *angles)


@inlined
def with_body_angles(joints, relative, angles):
    """Return the Gaps `relative` of joints, for worn joints with the `angles` of their bodies."""
    items = list(zip(joints, relative, angles, strict=True))
    return tuple([with_angles(joint, gap, angles_of_joint) for joint, gap, angles_of_joint in items])


# ---------------------------------------------------------------------------------------------- the joint


_FIELDS = [*Joint.__annotations__.items(), ("bearing", Shape), ("journal", Shape)]

WornJoint = NamedTuple("WornJoint", _FIELDS)
WornJoint.__doc__ = "A dry joint with worn bodies; all force acts at the deepest point of the surfaces."

WornOnFoundation = NamedTuple("WornOnFoundation", _FIELDS)
WornOnFoundation.__doc__ = "A WornJoint on an elastic foundation, which presses over an arc; see `worn_foundation`."

WORN_JOINTS = (WornJoint, WornOnFoundation)


WornContact = NamedTuple("WornContact", [*CONTACT_FIELDS, ("generalised_rate", float), ("generalised", tuple)])
WornContact.__doc__ = """Observables of a worn contact.

rate : m/s, of the depth; depth : m, as measured by `generalised_depth`; generalised_rate : m/s, conjugate to the normal
force: their product is its power; generalised : GeneralisedDepth, zeros without contact.
"""


# ---------------------------------------------------------------------------------------------- loads


class GeneralisedDepth(NamedTuple):
    """Generalised depth of worn surfaces in contact, and the direction of the load."""

    nx: float  # direction in which the bearing is pressed, a unit vector
    ny: float
    depth: float  # m, generalised depth; a law's force is the derivative of the stored energy by it
    force_factor: (
        float  # 1, its derivative as the journal moves along the direction: true forces are larger by this factor
    )
    body_slopes: tuple  # m/rad, its derivatives as bearing and journal rotate


@inlined
def generalised_rate(generalised, joint, gap):
    """Return the rate (m/s) of a GeneralisedDepth for a GapWithAngles."""
    _, _, bearing_spin, journal_spin = bodies_of(joint, gap)
    vx, vy, slopes = joint.side * gap.vx, joint.side * gap.vy, generalised.body_slopes
    normal_rate = vx * generalised.nx + vy * generalised.ny
    return generalised.force_factor * normal_rate + (slopes[0] * bearing_spin + slopes[1] * journal_spin)


@family
def generalised_depth(joint, nearest_point, gap):
    """Return the GeneralisedDepth of a worn joint from its Nearest and GapWithAngles."""


@generalised_depth.member(WornJoint)
def _generalised_depth_worn_joint(joint, nearest_point, gap):
    force_factor = as_type_of(1.0, nearest_point.depth)
    return GeneralisedDepth(nearest_point.nx, nearest_point.ny, nearest_point.depth, force_factor, nearest_point.slopes)


@inlined
def separate_load(joint, gap, last_angle):
    """Return the Load of separate surfaces: zero, with their distance.

    Far from contact, beyond the variation of wear, the depth is that of the least worn point: it is never
    less than the true depth.  The reported speed bounds the rate of the depth.
    """
    square = gap.x * gap.x + gap.y * gap.y
    eccentricity, speed = math.sqrt(square), math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy)
    _, _, bearing_spin, journal_spin = bodies_of(joint, gap)
    surface_speed = speed + joint.bearing.max_slope * abs(bearing_spin) + joint.journal.max_slope * abs(journal_spin)
    least_wear = joint.bearing.min_depth + joint.journal.min_depth
    depth = eccentricity - (joint.clearance + least_wear)
    rate = (gap.x * gap.vx + gap.y * gap.vy) / eccentricity if eccentricity > 0.0 else speed
    if depth > least_wear - (joint.bearing.max_depth + joint.journal.max_depth):
        nearest_point = nearest(joint, gap, last_angle)
        depth, rate = nearest_point.depth, nearest_point.rate
    zero = as_type_of(0.0, eccentricity)
    no_depth = GeneralisedDepth(zero, zero, zero, zero, (zero, zero))
    return no_load(WornContact(*separate_contact(depth, rate, surface_speed)[:7], rate, no_depth))


@inlined
def worn_load(joint, gap, mode, pen, onset_rate, last_angle=None):
    """Return the Load of a worn joint that touches, as `dry.joint_load` for circles; last_angle : see `nearest`."""
    nearest_point = nearest(joint, gap, last_angle)
    generalised = generalised_depth(joint, nearest_point, gap)
    nx, ny, force_factor = generalised.nx, generalised.ny, generalised.force_factor
    rate = generalised_rate(generalised, joint, gap)
    force, friction_load, elastic, unclipped = normal_forces(joint, mode, pen, rate / force_factor, onset_rate)
    x_rate, y_rate = joint.side * gap.vx, joint.side * gap.vy
    slip = y_rate * nx - x_rate * ny + nearest_point.rolling_speed
    normal = force_factor * force
    tangential = as_type_of(friction_force(joint.friction, force_factor * friction_load, slip), slip)
    fx, fy = -normal * nx - tangential * ny, -normal * ny + tangential * nx
    bearing_moment = -nearest_point.radii[0] * tangential - generalised.body_slopes[0] * force
    journal_moment = nearest_point.radii[1] * tangential - generalised.body_slopes[1] * force
    observed = normal, tangential, slip, rate, generalised.depth, force_factor * elastic, unclipped
    contact = WornContact(*observed, rate / force_factor, generalised)
    return load_on_journal(joint, fx, fy, (bearing_moment, journal_moment), (contact,))


power_stored.member(WornContact)(lambda contact: contact.elastic * contact.generalised_rate)
power_lost.member(WornContact)(lambda contact: (contact.normal - contact.elastic) * contact.generalised_rate)


register_single_contact(WornJoint)
register_single_contact(WornOnFoundation)


@load.member(WornJoint, WornOnFoundation)
def _load_worn_joint_or_worn_on_foundation(joint, gap, offsets, state):
    mode, contact = state.mode[offsets.contact], offsets.contact
    last_angle = None if state.deepest_angles is None else state.deepest_angles[contact : contact + 1]
    if mode == FREE:
        return separate_load(joint, gap, last_angle)
    root = state.y[state.roots + offsets.contact]
    current = with_current_laws(joint, offsets, state)
    return worn_load(current, gap, mode, root * abs(root), state.latched[offsets.contact], last_angle)


@contacts_at_speed.member(WornJoint, WornOnFoundation)
def _contacts_at_speed_worn_joint_or_worn_on_foundation(joint, gap, offsets, state, before):
    contact = before.contacts[0]
    return (contact._replace(rate=generalised_rate(contact.generalised, joint, gap)),)


# ---------------------------------------------------------------------------------------------- initial state


def has_worn_shape(joint) -> bool:
    """Return whether the worn shape of a joint affects contact."""
    return isinstance(joint, WORN_JOINTS)


@family
def seated_position(joint, eccentricity, angles):
    """Return position (2,) m and depth (m) of the journal under the load that circles carry at an `eccentricity` (m).

    angles : rad, of the proximal and the distal body.  Called only from Python.
    """


@seated_position.member(WornJoint)
def _seated_position_worn_joint(joint, eccentricity, angles):
    """With n the direction of the load, at the angle phi: (c + h + depth) n + h' n', n' being n turned by 90 deg."""
    distance = float(np.hypot(*eccentricity))
    nx, ny = eccentricity / distance
    bearing_angle, journal_angle = angles if joint.side > 0.0 else angles[::-1]
    load_angle = math.atan2(ny, nx)
    bearing_wear, bearing_slope, _, _ = wear_depth_at(joint.bearing.table, load_angle - bearing_angle)
    journal_wear, journal_slope, _, _ = wear_depth_at(joint.journal.table, load_angle - journal_angle)
    radial, tangential_offset = distance + bearing_wear + journal_wear, bearing_slope + journal_slope
    return np.array(
        [radial * nx - tangential_offset * ny, radial * ny + tangential_offset * nx]
    ), distance - joint.clearance


# ---------------------------------------------------------------------------------------------- wear


@contact_angle.member(WornJoint, WornOnFoundation)
def _contact_angle_worn_joint_or_worn_on_foundation(joint, gap):
    nearest_point = nearest(joint, gap)
    return nearest_point.angle, nearest_point.normal_rate, nearest_point.depth, nearest_point.rate


@local_clearance.member(WornJoint)
def _local_clearance_worn_joint(joint, bearing_angle, journal_angle):
    bearing_wear, _, bearing_curvature, _ = wear_depth_at(joint.bearing.table, bearing_angle)
    journal_wear, _, journal_curvature, _ = wear_depth_at(joint.journal.table, journal_angle)
    return joint.clearance + (bearing_wear + bearing_curvature + journal_wear + journal_curvature)


with_angles.member(WornJoint)(gap_with_angles)
with_angles.member(WornOnFoundation)(gap_with_angles)
