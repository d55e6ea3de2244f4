"""A revolute joint with clearance: from the relative motion of two pins to the forces between the bodies.

Bearing and journal are circles; the journal surface touches the bearing where the eccentricity exceeds the clearance.
Forces act at the journal surface, so that moments about both centres and the sliding speed belong together and the
power of friction is tangential force times sliding speed.
"""

from typing import NamedTuple

from numba.extending import overload

from ..compiled import calculus as math
from ..compiled.dual import alike
from ..compiled.family import OPTIONS, kernel
from .friction.contract import friction_force
from .internal_state import memory, recalled
from .loss.contract import contact_force, lowest_force, sign_beyond

# What a joint is doing.  CLIPPED: penetrating, but its law would pull; STUCK: pressed, and its surfaces stick
FREE, PRESSED, CLIPPED, STUCK = range(4)


class Joint(NamedTuple):
    """A clearance joint between a proximal body (towards the drive) and a distal one."""

    clearance: float  # m, radial
    bearing_radius: float  # m
    journal_radius: float  # m
    side: float  # +1: the journal sits on the distal body, -1: on the proximal one
    law: tuple  # contact_force
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force
    wear: tuple  # wear_rate


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
def width(joint):
    """Return how many numbers the laws of a joint remember."""
    return len(memory(joint.law)) + len(memory(joint.friction))


def remembering(joint, y, place):
    """Return the joint with what its laws remember, which stands in the state `y` from `place` on."""
    law = recalled(joint.law, y, place)
    friction = recalled(joint.friction, y, place + len(memory(joint.law)))
    return Joint(
        joint.clearance,
        joint.bearing_radius,
        joint.journal_radius,
        joint.side,
        law,
        joint.elastic,
        friction,
        joint.wear,
    )


@overload(remembering, strict=False, jit_options=dict(OPTIONS))
def _remembering(joint, y, place):
    return remembering if remembers(joint) else lambda joint, y, place: joint


def remembers(joint):
    """Return whether a law of `joint`, a compiled type, has a memory."""
    laws = [joint.types[joint.fields.index(name)].instance_class for name in ("law", "friction")]
    return any(law in memory.members for law in laws)


@kernel
def surface_speed(joint, gap, tx, ty):
    """Return the speed (m/s) of the journal surface over the bearing surface along the unit tangent (tx, ty)."""
    spin = gap.spin_distal * joint.journal_radius - gap.spin_proximal * joint.bearing_radius
    if joint.side < 0.0:
        spin = gap.spin_proximal * joint.journal_radius - gap.spin_distal * joint.bearing_radius
    return joint.side * (gap.vx * tx + gap.vy * ty) + spin


@kernel
def joint_load(joint, gap, state, pen, onset_rate):
    """Return the Load of a joint in `state` whose contact has penetration `pen` (m) and began at `onset_rate` (m/s).

    A negative `pen` is that of a trial step past the separation.
    """
    square = gap.x * gap.x + gap.y * gap.y
    if state == FREE:
        eccentricity = math.sqrt(square)
        speed = math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy)
        rate = (gap.x * gap.vx + gap.y * gap.vy) / eccentricity if eccentricity > 0.0 else speed
        zero = alike(0.0, eccentricity)
        return Load(zero, zero, zero, zero, zero, zero, speed, rate, eccentricity - joint.clearance, zero, zero)
    x, y, vx, vy = joint.side * gap.x, joint.side * gap.y, joint.side * gap.vx, joint.side * gap.vy
    # The root of penetration follows the eccentricity, so it gives the latter's inverse before the gap is known; one
    # step of Newton's method takes what they still differ by to its square.  All that comes after waits for the gap
    # alone, not for a root and a division.
    guess = 1.0 / (joint.clearance + pen)
    inverse = guess * (1.5 - 0.5 * square * guess * guess)
    nx, ny = x * inverse, y * inverse
    rate = vx * nx + vy * ny
    force, elastic = contact_force(joint.law, joint.elastic, abs(pen), rate, onset_rate)
    lowest = lowest_force(joint.law)
    raw = force - lowest
    if pen < 0.0:
        sign = sign_beyond(joint.law, joint.elastic)
        force, elastic = sign * force, sign * elastic
    normal = force if state != CLIPPED else 0.0
    slip = surface_speed(joint, gap, -ny, nx)
    rubbing = normal if lowest == 0.0 else max(normal, 0.0)  # no kink where an event is located
    tangential = alike(friction_force(joint.friction, rubbing, slip), slip)
    fx = -normal * nx - tangential * ny
    fy = -normal * ny + tangential * nx
    on_journal = joint.journal_radius * tangential
    on_bearing = -joint.bearing_radius * tangential
    depth = square * inverse - joint.clearance
    if joint.side < 0.0:
        return Load(-fx, -fy, on_journal, on_bearing, normal, tangential, slip, rate, depth, elastic, raw)
    return Load(fx, fy, on_bearing, on_journal, normal, tangential, slip, rate, depth, elastic, raw)
