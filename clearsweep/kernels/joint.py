"""A revolute joint with clearance: from the relative motion of two pins to the forces between the bodies.

Bearing and journal are circles; the journal surface touches the bearing where the eccentricity exceeds the clearance.
Forces act at the journal surface, so that moments about both centres and the sliding speed belong together and the
power of friction is tangential force times sliding speed.
"""

from typing import NamedTuple

from . import calculus as math
from .dual import alike
from .family import kernel
from .friction import friction_force
from .normal import contact_force, lowest_force

FREE, PRESSED, CLIPPED = 0, 1, 2  # what a joint is doing; CLIPPED: penetrating, but its law would pull


class Joint(NamedTuple):
    """A clearance joint between a proximal body (towards the drive) and a distal one."""

    clearance: float  # m, radial
    bearing_radius: float  # m
    journal_radius: float  # m
    side: float  # +1: the journal sits on the distal body, -1: on the proximal one
    law: tuple  # contact_force
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force
    wear: tuple  # wear.deposit


class Gap(NamedTuple):
    """The distal pin relative to the proximal one in the fixed frame, and how fast both bodies turn."""

    x: float  # m
    y: float  # m
    vx: float  # m/s
    vy: float  # m/s
    spin_proximal: float  # rad/s
    spin_distal: float  # rad/s


class Load(NamedTuple):
    """What a joint does to the bodies and to itself."""

    fx: float  # N, on the distal body
    fy: float  # N
    moment_proximal: float  # N m, on the proximal body about its pin
    moment_distal: float  # N m
    normal: float  # N, at least what its law allows: 0 but where the law pulls
    tangential: float  # N, on the journal
    slip: float  # m/s, sliding speed of the journal surface on the bearing; in free flight the relative speed
    rate: float  # m/s, rate of the eccentricity
    depth: float  # m, eccentricity less clearance; negative where there is a gap
    elastic: float  # N, the elastic part of the normal force
    raw: float  # N, the normal force before it is clipped, above the least that its law allows


@kernel
def surface_speed(joint, gap, tx, ty):
    """Return the speed (m/s) of the journal surface over the bearing surface along the unit tangent (tx, ty)."""
    spin = gap.spin_distal * joint.journal_radius - gap.spin_proximal * joint.bearing_radius
    if joint.side < 0.0:
        spin = gap.spin_proximal * joint.journal_radius - gap.spin_distal * joint.bearing_radius
    return joint.side * (gap.vx * tx + gap.vy * ty) + spin


@kernel
def joint_load(joint, gap, state, pen, onset_rate):
    """Return the Load of a joint in `state` whose contact has penetration `pen` (m) and began at `onset_rate` (m/s)."""
    eccentricity = math.sqrt(gap.x * gap.x + gap.y * gap.y)
    if state == FREE:
        speed = math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy)
        rate = (gap.x * gap.vx + gap.y * gap.vy) / eccentricity if eccentricity > 0.0 else speed
        zero = alike(0.0, eccentricity)
        return Load(zero, zero, zero, zero, zero, zero, speed, rate, eccentricity - joint.clearance, zero, zero)
    inverse = joint.side / eccentricity
    nx, ny = gap.x * inverse, gap.y * inverse
    rate = joint.side * (gap.vx * nx + gap.vy * ny)
    force, elastic = contact_force(joint.law, joint.elastic, pen, rate, onset_rate)
    lowest = lowest_force(joint.law)
    normal = force if state == PRESSED else 0.0
    slip = surface_speed(joint, gap, -ny, nx)
    rubbing = normal if lowest == 0.0 else max(normal, 0.0)  # no kink where an event is located
    tangential = alike(friction_force(joint.friction, rubbing, slip), eccentricity)
    fx = -normal * nx - tangential * ny
    fy = -normal * ny + tangential * nx
    on_journal = joint.journal_radius * tangential
    on_bearing = -joint.bearing_radius * tangential
    depth = eccentricity - joint.clearance
    if joint.side < 0.0:
        return Load(-fx, -fy, on_journal, on_bearing, normal, tangential, slip, rate, depth, elastic, force - lowest)
    return Load(fx, fy, on_bearing, on_journal, normal, tangential, slip, rate, depth, elastic, force - lowest)
