"""Surfaces that stick: the tangential force that stops their sliding, found from the mechanism itself.

The accelerations are affine in the tangential forces, so two evaluations of the motion tell the force of one joint.
Where several joints stick, each is solved for in turn, clipped at what it can hold, until nothing changes: projected
Gauss-Seidel, on a matrix that is symmetric and positive definite because these forces work on these very slips.
"""

from typing import NamedTuple

from numba.extending import overload

from ..compiled.family import OPTIONS, family, kernel, map_joints
from ..mechanism.contract import accelerate, gap_accelerations
from .contract import Contact, Load, after_joint, after_number, first_place
from .dry import Joint
from .friction.contract import STUCK, static_limit

SWEEPS = 100  # over the joints that stick; joints share little, so a dozen do
SETTLED = 1e-15  # of the largest force that the surfaces hold


class Surface(NamedTuple):
    """What sticking takes from a joint and its Gap."""

    contact: int
    bearing_radius: float  # m
    journal_radius: float  # m
    side: float
    static_limit: float  # largest tangential force over normal force; 0 where the law does not stick
    x: float  # m
    y: float
    vx: float  # m/s
    vy: float


# ---------------------------------------------------------------------------------------------- the force that holds


@kernel
def slip_rate(surface, gap):
    """Return the rate (m/s^2) of the sliding speed of a joint in contact, from its GapAcceleration."""
    x, y, vx, vy = surface.x, surface.y, surface.vx, surface.vy
    squared = x * x + y * y
    across = x * gap.ay - y * gap.ax - (x * vy - y * vx) * (x * vx + y * vy) / squared
    spin = gap.distal * surface.journal_radius - gap.proximal * surface.bearing_radius
    if surface.side < 0.0:
        spin = gap.proximal * surface.journal_radius - gap.distal * surface.bearing_radius
    return across / squared**0.5 + spin


@kernel
def with_tangential(surface, load, force):
    """Return the Load with the tangential force `force` (N) in place of its own."""
    contact = load.contacts[0]
    more = force - contact.tangential
    share = more / (surface.x * surface.x + surface.y * surface.y) ** 0.5
    bearing, journal = -surface.bearing_radius * more, surface.journal_radius * more
    if surface.side < 0.0:
        bearing, journal = journal, bearing
    return Load(
        fx=load.fx - share * surface.y,
        fy=load.fy + share * surface.x,
        moment_proximal=load.moment_proximal + bearing,
        moment_distal=load.moment_distal + journal,
        contacts=(
            Contact(
                normal=contact.normal,
                tangential=force,
                slip=contact.slip,
                rate=contact.rate,
                depth=contact.depth,
                elastic=contact.elastic,
                raw=contact.raw,
            ),
        ),
    )


@family
def surface_of(joint, gap, contact):
    """Return the Surface of a joint at its contact number `contact`; one that holds nothing where it cannot stick."""


@surface_of.member(None)
def _never_sticks(joint, gap, contact):
    return Surface(contact, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@surface_of.member(Joint)
def _dry(joint, gap, contact):
    return Surface(
        contact=contact,
        bearing_radius=joint.bearing_radius,
        journal_radius=joint.journal_radius,
        side=joint.side,
        static_limit=static_limit(joint.friction),
        x=gap.x,
        y=gap.y,
        vx=gap.vx,
        vy=gap.vy,
    )


@kernel
def _surface(joint, gap, place, _):
    return surface_of(joint, gap, place.contact)


_surfaces = map_joints(_surface, after_joint)


@kernel
def surfaces_of(joints, relative):
    """Return one Surface per joint of the tuple `joints`, whose Gaps are `relative`."""
    return _surfaces(joints, relative, first_place(joints, 0), 0)


@kernel
def _replaced(surface, load, place, shared):
    j, force = shared
    return with_tangential(surface, load, force) if place == j else load


_replaced_in_one = map_joints(_replaced, after_number)  # of surfaces, loads, 0 and (the joint, the force on it)


@kernel
def rate_under(scene, y, pose, surfaces, loads, j):
    """Return the rate (m/s^2) of the sliding speed of joint `j` under the loads."""
    motion = accelerate(scene.mechanism, pose, loads)
    return slip_rate(surfaces[j], gap_accelerations(scene.mechanism, y, motion)[j])


def with_sticking_forces(scene, y, pose, relative, loads, mode):
    """Return the loads with the tangential forces of joints that stick such as let their sliding speed die away.

    It dies away with the rate `scene.reference_rate`, as what it has left is the band's width and of no account; where
    that takes more force than the surfaces hold, they bear what they hold.
    """
    surfaces, stuck = surfaces_of(scene.joints, relative), 0
    for j in range(len(surfaces)):
        stuck += mode[surfaces[j].contact] == STUCK
    for _ in range(SWEEPS if stuck > 1 else stuck):
        change = 0.0
        for j in range(len(surfaces)):
            contact = loads[j].contacts[0]
            limit = surfaces[j].static_limit * max(contact.normal, 0.0)
            if mode[surfaces[j].contact] != STUCK or limit == 0.0:
                continue
            now = contact.tangential
            wanted = -scene.reference_rate * contact.slip - rate_under(scene, y, pose, surfaces, loads, j)
            other = _replaced_in_one(surfaces, loads, 0, (j, now + limit))
            gain = wanted + scene.reference_rate * contact.slip + rate_under(scene, y, pose, surfaces, other, j)
            force = min(max(now + limit * wanted / gain, -limit), limit)
            change = max(change, abs(force - now) / limit)
            loads = _replaced_in_one(surfaces, loads, 0, (j, force))
        if change < SETTLED:
            break
    return loads


@overload(with_sticking_forces, strict=False, jit_options=dict(OPTIONS))
def _with_sticking_forces(scene, y, pose, relative, loads, mode):
    joints = scene.types[scene.fields.index("joints")]
    frictions = [joint.types[joint.fields.index("friction")] for joint in joints if "friction" in joint.fields]
    if any(friction.instance_class in static_limit.members for friction in frictions):
        return with_sticking_forces
    return lambda scene, y, pose, relative, loads, mode: loads
