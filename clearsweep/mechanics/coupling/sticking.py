"""Surfaces that stick: the tangential force that stops their sliding, found from the mechanism itself.

The accelerations are affine in the tangential forces: one evaluation of the motion, and one more for each joint that
sticks, give how all sliding speeds change with all of these forces.  Each force is then solved for in turn, clipped at
what its surfaces hold, until nothing changes: projected Gauss-Seidel, on a matrix that is symmetric and positive
definite because these forces work on these very slips.
"""

from typing import NamedTuple

from ..compiled.dual import as_type_of
from ..compiled.family import family, kernel, map_joints
from ..joint.contract import STUCK, Contact, Load
from ..joint.dry import Joint
from ..joint.friction.contract import static_limit
from ..joint.places import after_joint, after_number, first_place
from ..mechanism.contract import accelerate, gap_accelerations

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
    """Return the Surface of a joint at its contact number `contact`; one that sticks nothing where it cannot stick."""


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
def _slip_rate(surface, gap, place, shared):
    return slip_rate(surface, gap)


@kernel
def _per_force(under, base, place, force):
    return (under - base) / force


@kernel
def _nothing(_, base, place, shared):
    return as_type_of(0.0, base)


@kernel
def _moved(rate, gain, place, more):
    return rate + gain * more


@kernel
def _force(_, load, place, shared):
    return load.contacts[0].tangential


@kernel
def _replaced(_, force, place, shared):
    j, other = shared
    return other if place == j else force


@kernel
def _loaded(surface, load, place, forces):
    return with_tangential(surface, load, forces[place])


_slip_rates = map_joints(_slip_rate, after_number)  # of surfaces and gap accelerations
_rates_per_force = map_joints(_per_force, after_number)  # of rates with a force more and without, and that force
_no_rates = map_joints(_nothing, after_number)
_moved_rates = map_joints(_moved, after_number)  # of rates, rates per force, and the force more
_forces = map_joints(_force, after_number)
_replaced_in_one = map_joints(_replaced, after_number)  # of surfaces, forces, and (the joint, the force on it)
_loads = map_joints(_loaded, after_number)


@kernel
def slip_rates(scene, y, pose, surfaces, loads):
    """Return the rate (m/s^2) of the sliding speed of every joint under the loads."""
    motion = accelerate(scene.mechanism, pose, loads)
    return _slip_rates(surfaces, gap_accelerations(scene.mechanism, y, motion), 0, 0)


class Question(NamedTuple):
    """What the rates per force of the joints are found from."""

    scene: tuple
    y: tuple  # state vector
    pose: tuple
    surfaces: tuple
    loads: tuple
    rates: tuple  # m/s^2, under these loads
    mode: tuple


@kernel
def _gain(surface, load, place, question):
    limit = limit_of(surface, load)
    if question.mode[surface.contact] != STUCK or limit == 0.0:
        return _no_rates(question.surfaces, question.rates, 0, 0)
    forces = _forces(question.surfaces, question.loads, 0, 0)
    more = _replaced_in_one(question.surfaces, forces, 0, (place, forces[place] + limit))
    loads = _loads(question.surfaces, question.loads, 0, more)
    rates = slip_rates(question.scene, question.y, question.pose, question.surfaces, loads)
    return _rates_per_force(rates, question.rates, 0, limit)


_gains = map_joints(_gain, after_number)


@kernel
def limit_of(surface, load):
    """Return the largest tangential force (N) that the surfaces hold under the normal force of the load."""
    return surface.static_limit * max(load.contacts[0].normal, 0.0)


@kernel
def with_sticking_forces(scene, y, pose, relative, loads, mode):
    """Return the loads with the tangential forces of joints that stick such as let their sliding speed die away.

    It dies away with the rate `scene.reference_rate`, as what it has left is the band's width and of no account; where
    that takes more force than the surfaces hold, they bear what they hold.
    """
    if not any(type(joint.friction) in static_limit.members for joint in scene.joints if hasattr(joint, "friction")):
        return loads
    surfaces, stuck = surfaces_of(scene.joints, relative), 0
    for j in range(len(surfaces)):
        stuck += mode[surfaces[j].contact] == STUCK
    if stuck == 0:
        return loads
    rates, forces = slip_rates(scene, y, pose, surfaces, loads), _forces(surfaces, loads, 0, 0)
    gains = _gains(surfaces, loads, 0, Question(scene, y, pose, surfaces, loads, rates, mode))
    for _ in range(SWEEPS if stuck > 1 else 1):
        change = 0.0
        for j in range(len(surfaces)):
            limit = limit_of(surfaces[j], loads[j])
            if mode[surfaces[j].contact] != STUCK or limit == 0.0:
                continue
            missing = -scene.reference_rate * loads[j].contacts[0].slip - rates[j]
            force = min(max(forces[j] + missing / gains[j][j], -limit), limit)
            more = force - forces[j]
            change = max(change, abs(more) / limit)
            rates = _moved_rates(rates, gains[j], 0, more)
            forces = _replaced_in_one(surfaces, forces, 0, (j, force))
        if change < SETTLED:
            break
    return _loads(surfaces, loads, 0, forces)
