"""A revolute joint in which the worn shapes act on the contact (`wear.evolve`).

Bearing and journal are circles minus wear, a function h of the angle in the frame of each body (`wear.shape`),
which is constant during a run.  With u(phi) the unit vector at an angle, e the eccentricity and theta the
angles of the bodies, the surfaces penetrate where they are closest by

    depth = max over phi of  e . u(phi) - c - h_b(phi - theta_b) - h_j(phi - theta_j) .

The normal is u there.  By virtual work the normal force F turns the bearing by -F h_b' and the journal by -F h_j',
since the rate of the depth is v . u + h_b' omega_b + h_j' omega_j: the stored energy is a potential, and
only the law dissipates energy.  Sliding is at the worn radii.
"""

from typing import NamedTuple

import numpy as np

from ....tracing.compiled import calculus as math
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import family, inlined
from ...laws.contract import FREE, PRESSED
from ...laws.friction import friction_force
from ...wear import contact_angle, local_clearance
from ...wear.shape import Shape, wear_depth_at
from ..contract import ContactModes, Load, Part, contact_modes, load, parts, power_lost, power_stored
from ..dry import Clip, Joint, normal_forces
from ..offsets import with_current_laws
from .nearest import bodies_of, gap_with_angles, nearest, with_angles

_FIELDS = [*Joint.__annotations__.items(), ("bearing", Shape), ("journal", Shape)]

WornJoint = NamedTuple("WornJoint", _FIELDS)
WornJoint.__doc__ = "A dry joint with worn bodies; all force acts at the deepest point of the surfaces."

WornOnFoundation = NamedTuple("WornOnFoundation", _FIELDS)
WornOnFoundation.__doc__ = "A WornJoint on an elastic foundation, which presses over an arc; see `worn_foundation`."

WORN_JOINTS = (WornJoint, WornOnFoundation)


class WornContact(NamedTuple):
    """Observables of a worn contact; the first fields are those of a Contact."""

    normal: float  # N
    tangential: float  # N, on the journal
    slip: float  # m/s, as in a dry joint; in free flight a bound of the rate of the depth
    rate: float  # m/s, of the depth
    depth: float  # m, as measured by `generalised_depth`; negative for a gap
    elastic: float  # N, the elastic part of the normal force
    raw: float  # N, the normal force before it is clipped, above the least that its law allows
    generalised_rate: float  # m/s, conjugate to the normal force: their product is its power


# ---------------------------------------------------------------------------------------------- loads


class GeneralisedDepth(NamedTuple):
    """Generalised depth of worn surfaces in contact, and the direction of the load."""

    nx: float  # direction in which the bearing is pressed, a unit vector
    ny: float
    depth: float  # m, generalised depth; a law's force is the derivative of the stored energy by it
    rate: float  # m/s, of the generalised depth
    force_factor: (
        float  # 1, its derivative as the journal moves along the direction: true forces are larger by this factor
    )
    body_slopes: tuple  # m/rad, its derivatives as bearing and journal rotate


@family
def generalised_depth(joint, nearest_point, gap, pen):
    """Return the GeneralisedDepth of a worn joint from its Nearest and GapWithAngles, at the penetration `pen` (m)."""


@generalised_depth.member(WornJoint)
def _generalised_depth_worn_joint(joint, nearest_point, gap, pen):
    force_factor = as_type_of(1.0, nearest_point.depth)
    return GeneralisedDepth(
        nearest_point.nx, nearest_point.ny, nearest_point.depth, nearest_point.rate, force_factor, nearest_point.slopes
    )


@inlined
def separate_load(joint, gap):
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
        nearest_point = nearest(joint, gap)
        depth, rate = nearest_point.depth, nearest_point.rate
    zero = as_type_of(0.0, eccentricity)
    contact = WornContact(
        normal=zero,
        tangential=zero,
        slip=surface_speed,
        rate=rate,
        depth=depth,
        elastic=zero,
        raw=zero,
        generalised_rate=rate,
    )
    return Load(fx=zero, fy=zero, moment_proximal=zero, moment_distal=zero, contacts=(contact,))


@inlined
def worn_load(joint, gap, mode, pen, onset_rate):
    """Return the Load of a worn joint in a touching mode, like `dry.joint_load` for circles."""
    nearest_point = nearest(joint, gap)
    generalised = generalised_depth(joint, nearest_point, gap, pen)
    nx, ny, force_factor = generalised.nx, generalised.ny, generalised.force_factor
    generalised_rate = generalised.rate / force_factor
    force, friction_load, elastic, unclipped = normal_forces(joint, mode, pen, generalised_rate, onset_rate)
    x_rate, y_rate = joint.side * gap.vx, joint.side * gap.vy
    slip = y_rate * nx - x_rate * ny + nearest_point.rolling_speed
    normal, tangential = (
        force_factor * force,
        as_type_of(friction_force(joint.friction, force_factor * friction_load, slip), slip),
    )
    fx, fy = -normal * nx - tangential * ny, -normal * ny + tangential * nx
    bearing_moment = -nearest_point.radii[0] * tangential - generalised.body_slopes[0] * force
    journal_moment = nearest_point.radii[1] * tangential - generalised.body_slopes[1] * force
    contact = WornContact(
        normal=normal,
        tangential=tangential,
        slip=slip,
        rate=generalised.rate,
        depth=generalised.depth,
        elastic=force_factor * elastic,
        raw=unclipped,
        generalised_rate=generalised_rate,
    )
    if joint.side < 0.0:
        return Load(fx=-fx, fy=-fy, moment_proximal=journal_moment, moment_distal=bearing_moment, contacts=(contact,))
    return Load(fx=fx, fy=fy, moment_proximal=bearing_moment, moment_distal=journal_moment, contacts=(contact,))


@power_stored.member(WornContact)
def _power_stored_worn_contact(contact):
    return contact.elastic * contact.generalised_rate


@power_lost.member(WornContact)
def _power_lost_worn_contact(contact):
    return (contact.normal - contact.elastic) * contact.generalised_rate


@contact_modes.member(WornJoint)
@contact_modes.member(WornOnFoundation)
def _contact_modes_worn_joint_or_worn_on_foundation(joint):
    return (ContactModes(FREE, PRESSED),)


@parts.member(WornJoint)
@parts.member(WornOnFoundation)
def _parts_worn_joint_or_worn_on_foundation(joint):
    return Part(Clip(), 0), Part(joint.law, 0), Part(joint.friction, 0)


@load.member(WornJoint)
@load.member(WornOnFoundation)
def _load_worn_joint_or_worn_on_foundation(joint, gap, offsets, state):
    mode = state.mode[offsets.contact]
    if mode == FREE:
        return separate_load(joint, gap)
    root = state.y[state.roots + offsets.contact]
    current = with_current_laws(joint, offsets, state)
    return worn_load(current, gap, mode, root * abs(root), state.latched[offsets.contact])


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


@contact_angle.member(WornJoint)
@contact_angle.member(WornOnFoundation)
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
