"""A spatial revolute joint: a journal with radial and axial clearance, which may tilt in its bearing.

Both are cylinders (geometry after Marques, Isaac, Dourado & Flores 2017, Mechanism and Machine Theory 116).  Everything
is in the frame of the journal, whose axis is z, from the centre of the bearing.  The points where the surfaces can
touch are separate contacts:

    1, 2    an end circle of the journal, at the end of +z and of -z, on the wall of the bore; or, if that is beyond
            the bore and there are no flanges, the edge of the bore at this end on the journal
    3, 4    the rims of the same ends on the flanges, up to which the bore extends

Each is one point, the deepest point of the surfaces: on a circle its exact maximiser, otherwise energy would be lost.
Force and moment act on each body at its own surface point; their distance along the normal is the penetration, and all
powers add up to normal force times rate of penetration and friction times sliding speed.  The walls share the load in
parallel: each has half of the stiffness at its point (`EndContacts`), or all is spread over the length (`Spread`).

Two auxiliary contacts follow, which only report: the vector sum of the walls' normal forces, and the difference of
their magnitudes, with the sine of the tilt as its depth.
"""

import math as std
from typing import NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import family, inlined, kernel
from ....tracing.compiled.vector import Vector, dot, plus_scaled, times
from ...laws.contract import ACTS, FREE, MEETS, PRESSED, Guard, guards
from ...observe import RAW
from ..contract import CONTACT_FIELDS, ContactModes, Part, contact_modes, parts, power_lost, power_stored
from ..dry import dry_parts


class InBore(NamedTuple):
    """The end circles of the journal touch the wall of the bore."""


class AtEdges(NamedTuple):
    """The edges of the bore touch the wall of the journal."""


class Overlapping(NamedTuple):
    """Without flanges: at each end the journal's end circle touches or, if it is beyond the bore, the bore's edge."""


class EndContacts(NamedTuple):
    """Each wall contact has half of the stiffness, at its end."""


class FewNodes(NamedTuple):
    """Gauss rule with few nodes, exact for forces in proportion to depth or depth^(3/2)."""


class ManyNodes(NamedTuple):
    """Gauss rule with many nodes."""


class Spread(NamedTuple):
    """The stiffness is distributed uniformly over the overlap of journal and bore."""

    rule: tuple  # FewNodes or ManyNodes


class Leaving(NamedTuple):
    """The part of a joint without flanges that ends the run when the journal leaves the bore."""


class Through(NamedTuple):
    """A spatial joint without flanges."""

    clearance: float  # m, radial
    side: float  # +1: sign of a gap, journal minus bearing
    bearing_radius: float  # m
    journal_radius: float  # m
    half_length: float  # m, of the bearing
    journal_half_length: float  # m
    offset: Vector  # m, offset of the bearing's centre, in the frame of its body
    axis: Vector  # unit vector along the bearing, likewise
    end_type: tuple  # Overlapping
    walls: tuple  # EndContacts or Spread
    law: tuple  # contact_force of the whole joint
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force
    wear: tuple  # wear_rate
    across: Vector  # unit vector of the bearing's own x axis, in the frame of its body
    wear_rows: float  # bins of wear along the length


Flanged = NamedTuple(
    "Flanged",
    [
        *Through.__annotations__.items(),
        ("axial_clearance", float),  # m, on each side
        ("axial_law", tuple),  # contact_force of a flange
        ("axial_elastic", tuple),
    ],
)
Flanged.__doc__ = "A spatial joint between flanges."

SPATIAL_JOINT_TYPES: tuple[type, ...] = (Through, Flanged)


class SpatialGap(NamedTuple):
    """Motion of the journal in its bearing; everything but `frame` is in the frame of the journal."""

    middle: Vector  # m, of the journal, from the centre of the bearing
    velocity: Vector  # m/s, of the journal's middle less that of the bearing's
    axis: Vector  # unit vector along the bearing
    bearing_spin: Vector  # rad/s, angular velocity of the bearing
    journal_spin: Vector  # rad/s, of the journal
    frame: tuple  # attitude.Frame of the journal


class SpatialLoad(NamedTuple):
    """Forces of a spatial joint on its bodies, in the frame of the journal."""

    force: Vector  # N, on the journal
    journal_moment: Vector  # N m, moment about the journal's middle
    bearing_moment: Vector  # N m, moment on the bearing about its middle
    contacts: tuple  # of Contacts
    points: tuple = ()  # see `points_of`


class ContactForce(NamedTuple):
    """Force of a contact."""

    normal: Vector  # N, normal force on the journal
    force: Vector  # N, with friction
    moment: Vector  # N m, on the journal about its middle
    twist: Vector  # N m, of friction on the bearing's surface about the opposite point of the journal
    contact: tuple  # Contact or SpreadContact


SpreadContact = NamedTuple(
    "SpreadContact", [*CONTACT_FIELDS, ("stored_power", float), ("lost_power", float), ("end_force", float)]
)
SpreadContact.__doc__ = """Observables of a contact of spread walls: its rate and depth are at the end.

normal : N, for a wall that of its strip; stored_power, lost_power : W; end_force : N, for a wall: force at its end, of
the two end forces with the strips' sum and moment.
"""


power_stored.member(SpreadContact)(lambda contact: contact.stored_power)
power_lost.member(SpreadContact)(lambda contact: contact.lost_power)


#: Mode of a wall contact in `Spread`: the pressed length may reach the half of an end that is apart.
APART = ACTS | MEETS
_WALLS = (ContactModes(FREE, PRESSED), ContactModes(FREE, PRESSED))
_SPREAD_WALLS = (ContactModes(APART, PRESSED), ContactModes(APART, PRESSED))
_AUXILIARY = (ContactModes(ACTS, ACTS), ContactModes(ACTS, ACTS))


def _wall_modes_of(joint):
    return _SPREAD_WALLS if joint is not None and isinstance(joint.walls, Spread) else _WALLS


contact_modes.member(Through)(lambda joint: (*_wall_modes_of(joint), *_AUXILIARY))
contact_modes.member(Flanged)(lambda joint: (*_wall_modes_of(joint), *_WALLS, *_AUXILIARY))
guards.member(Leaving)(lambda leaving: (Guard((ACTS,), observable=RAW, ends_run=True),))


parts.member(Through)(lambda joint: (*dry_parts(joint.friction, joint.law, joint.law), Part(Leaving(), 3)))
parts.member(Flanged)(lambda joint: dry_parts(joint.friction, joint.law, joint.law, joint.axial_law, joint.axial_law))


# ---------------------------------------------------------------------------------------------- deepest points


ENDS = (1.0, -1.0)  # of the journal, along its z
SERIES_LIMIT = 0.025  # of radius k^2 over the distance: below, the error after a Halley step is under the last bit
NEWTON_TOLERANCE = 1e-8  # of the distance: size of the last Newton step, whose error is its square
MAX_STEPS = 60


class Point(NamedTuple):
    """A deepest point of the surfaces."""

    position: Vector  # m, on the journal, from the centre of the bearing
    normal: Vector  # unit vector, from the journal into the bearing
    depth: float  # m


@kernel
def farthest_direction(px, py, kx, ky, radius):
    """Return the unit vector d that maximises p . d - radius (k . d)^2 / 2.

    A circle of this radius about p, seen along an axis that leans by k against its own, is an ellipse: d is where it
    is farthest from the axis, or for a negative radius where it is nearest to the point -p.  From

        lambda d = p - radius k (k . d)

    d follows once lambda is known, the largest root of |p - radius k (k . p) / (lambda + radius k^2)| = lambda.  With
    x = lambda / |p| - 1, e = radius k^2 / |p| and c the cosine of the angle between p and k that is, for small e,

        x (2 + x) (1 + x + e)^2 + e c^2 (2 (1 + x) + e) = 0,    x = -e c^2 + 3/2 e^2 c^2 (1 - c^2) + O(e^3),

    from where one step of Halley's method, whose error is the cube of the previous one, reaches the last bit.
    """
    tilt_square, square = radius * (kx * kx + ky * ky), px * px + py * py
    if not tilt_square * tilt_square < SERIES_LIMIT * SERIES_LIMIT * square:
        return farthest_direction_by_newton(px, py, kx, ky, radius)
    product = kx * px + ky * py
    radius_product, distance, inverse = radius * product, math.sqrt(square), 1.0 / square
    along_both = radius_product * product
    e_cosine_square = along_both * inverse
    correction = e_cosine_square * (1.5 * (tilt_square - e_cosine_square) * distance * inverse - 1.0)
    root, shifted_root = distance + correction, distance + correction + tilt_square
    separation = correction * (distance + root)
    value = separation * shifted_root * shifted_root + along_both * (shifted_root + root)
    denominator = 2.0 * (root * shifted_root * shifted_root + separation * shifted_root + along_both)
    second_derivative = 2.0 * shifted_root * (shifted_root + 4.0 * root) + 2.0 * separation
    root -= 2.0 * value * denominator / (2.0 * denominator * denominator - value * second_derivative)
    shifted_root = root + tilt_square
    inverse = 1.0 / (root * shifted_root)
    along_p, along_k = shifted_root * inverse, radius_product * inverse
    return px * along_p - along_k * kx, py * along_p - along_k * ky


@kernel
def farthest_direction_by_newton(px, py, kx, ky, radius):
    """Return `farthest_direction` of a strongly inclined or centred circle, by Newton's method between bounds."""
    tilt_square = radius * (kx * kx + ky * ky)
    product = kx * px + ky * py
    distance = math.sqrt(px * px + py * py)
    low, high = max(-tilt_square, 0.0 * tilt_square), distance + max(-tilt_square, 0.0 * tilt_square)
    root = high
    for _ in range(MAX_STEPS):
        inverse = 1.0 / (root + tilt_square) if root + tilt_square > 0.0 else as_type_of(0.0, root)
        radial_term = radius * product * inverse
        vx, vy = px - radial_term * kx, py - radial_term * ky
        offset_length = math.sqrt(vx * vx + vy * vy)
        if offset_length <= 0.0:
            break
        residual = offset_length - root
        if residual > 0.0:
            low = root
        else:
            high = root
        residual_slope = 1.0 - radial_term * product * root * inverse * inverse / offset_length
        newton = root + residual / residual_slope if residual_slope > 0.0 else 0.5 * (low + high)
        if not low <= newton <= high:
            newton = 0.5 * (low + high)
        step, root = abs(newton - root), newton
        if step <= NEWTON_TOLERANCE * root:
            break
    inverse = 1.0 / (root + tilt_square) if root + tilt_square > 0.0 else as_type_of(0.0, root)
    radial_term = radius * product * inverse
    vx, vy = px - radial_term * kx, py - radial_term * ky
    offset_length = math.sqrt(vx * vx + vy * vy)
    if offset_length <= 0.0:
        return as_type_of(1.0, px), as_type_of(0.0, px)
    return vx / offset_length, vy / offset_length


@family
def wall_point(end_type, joint, gap, end):
    """Return the Point of the wall contact at one of the ENDS."""


@wall_point.member(InBore)
def _wall_point_in_bore(end_type, joint, gap, end):
    axis, midpoint, radius = gap.axis, gap.middle, joint.journal_radius
    center = Vector(midpoint.x, midpoint.y, midpoint.z + end * joint.journal_half_length)
    radial_offset = plus_scaled(center, -dot(center, axis), axis)
    dx, dy = farthest_direction(radial_offset.x, radial_offset.y, axis.x, axis.y, radius)
    rx, ry = radius * dx, radius * dy
    position = Vector(center.x + rx, center.y + ry, center.z)
    correction = rx * axis.x + ry * axis.y
    outward = Vector(
        radial_offset.x + rx - correction * axis.x,
        radial_offset.y + ry - correction * axis.y,
        radial_offset.z - correction * axis.z,
    )
    distance = math.sqrt(dot(outward, outward))
    inverse = 1.0 / distance
    return Point(position, times(inverse, outward), distance - joint.bearing_radius)


@wall_point.member(AtEdges)
def _wall_point_at_edges(end_type, joint, gap, end):
    axis, radius = times(math.copysign(1.0, gap.axis.z), gap.axis), joint.bearing_radius
    factor = 1.0 / (1.0 + axis.z)
    first_axis = Vector(1.0 - axis.x * axis.x * factor, -axis.x * axis.y * factor, -axis.x)
    second_axis = Vector(-axis.x * axis.y * factor, 1.0 - axis.y * axis.y * factor, -axis.y)
    center = times(end * joint.half_length, axis)
    ox, oy = gap.middle.x - center.x, gap.middle.y - center.y
    dx, dy = farthest_direction(
        ox * first_axis.x + oy * first_axis.y,
        ox * second_axis.x + oy * second_axis.y,
        first_axis.z,
        second_axis.z,
        -radius,
    )
    edge = plus_scaled(plus_scaled(center, radius * dx, first_axis), radius * dy, second_axis)
    hx, hy = edge.x - gap.middle.x, edge.y - gap.middle.y
    distance = math.sqrt(hx * hx + hy * hy)
    inverse = 1.0 / distance
    normal = Vector(hx * inverse, hy * inverse, as_type_of(0.0, hx))
    depth = joint.journal_radius - distance
    return Point(plus_scaled(edge, depth, normal), normal, depth)


@kernel
def is_past_edge(joint, gap, end):
    """Return whether the deepest point of the journal's end circle at one of the ENDS is beyond the edge of the bore.

    The circle's point is searched only if its centre is closer to the edge than the circle extends along the axis.
    """
    axis, midpoint, outward_sign = gap.axis, gap.middle, end * math.copysign(1.0, gap.axis.z)
    center = Vector(midpoint.x, midpoint.y, midpoint.z + end * joint.journal_half_length)
    overshoot = outward_sign * dot(center, axis) - joint.half_length
    radial_reach = joint.journal_radius * sine_of_tilt(axis)
    if overshoot > radial_reach:
        return True
    if overshoot < -radial_reach:
        return False
    point = wall_point(InBore(), joint, gap, end)
    return outward_sign * dot(point.position, axis) > joint.half_length


@wall_point.member(Overlapping)
def _wall_point_overlapping(end_type, joint, gap, end):
    if is_past_edge(joint, gap, end):
        return wall_point(AtEdges(), joint, gap, end)
    return wall_point(InBore(), joint, gap, end)


@kernel
def overlap_of(joint, gap):
    """Return the length (m) on the journal's axis from the inner end of the bore to that of the journal.

    This is the overlap unless one of them is shorter; below 0 the journal has left the bore.
    """
    return joint.journal_half_length + joint.half_length - abs(gap.middle.z)


@inlined
def flange_point(joint, gap, end):
    """Return the Point of the flange contact at one of the ENDS; for a parallel journal, the centre of its face."""
    axis, midpoint = gap.axis, gap.middle
    outward_sign = end * math.copysign(1.0, axis.z)
    radial_reach = outward_sign * _rim_reach(joint, axis)
    position = Vector(
        midpoint.x + radial_reach * axis.x,
        midpoint.y + radial_reach * axis.y,
        midpoint.z + end * joint.journal_half_length,
    )
    normal = times(outward_sign, axis)
    return Point(position, normal, dot(position, normal) - joint.half_length - joint.axial_clearance)


@kernel
def _rim_reach(joint, axis):
    """Return the radius of the journal over the sine of the tilt (m), 0 without tilt."""
    tilt_square = axis.x * axis.x + axis.y * axis.y
    return joint.journal_radius / math.sqrt(tilt_square) if tilt_square > 0.0 else as_type_of(0.0, tilt_square)


@kernel
def sine_of_tilt(axis):
    """Return the sine of the angle between bearing and journal; axis : as in SpatialGap."""
    tilt_square = axis.x * axis.x + axis.y * axis.y
    return math.sqrt(tilt_square) if tilt_square > 0.0 else as_type_of(0.0, tilt_square)


@kernel
def tilt_of(axis):
    """Return the angle (rad) between bearing and journal; axis : as in SpatialGap."""
    return math.atan(sine_of_tilt(axis) / abs(axis.z))


@kernel
def points_of(joint, gap):
    """Return the Points of a joint's walls, then of its flanges."""
    points = tuple(wall_point(joint.end_type, joint, gap, end) for end in ENDS)
    return (*points, *(flange_point(joint, gap, end) for end in ENDS)) if isinstance(joint, Flanged) else points


def deepest_of(joint, gap) -> float:
    """Return the largest depth (m) of a joint's contact points, negative if all are apart."""
    return max(point.depth for point in points_of(joint, gap))


def jam_angle(joint) -> float:
    """Return the tilt (rad) at which a centred journal touches both walls, inf if it can turn over."""
    if (
        isinstance(joint.end_type, Overlapping) and joint.journal_half_length > joint.half_length
    ):  # bearing_radius cos - half_length sin = journal_radius
        diagonal = std.hypot(joint.bearing_radius, joint.half_length)
        return std.acos(joint.journal_radius / diagonal) - std.atan2(joint.half_length, joint.bearing_radius)
    diagonal = std.hypot(
        joint.journal_half_length, joint.journal_radius
    )  # journal_half_length sin + journal_radius cos = bearing_radius
    if diagonal < joint.bearing_radius:
        return std.inf
    return std.asin(joint.bearing_radius / diagonal) - std.atan2(joint.journal_radius, joint.journal_half_length)
