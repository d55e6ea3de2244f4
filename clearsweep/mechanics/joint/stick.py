"""Surfaces that stick: the tangential force that stops their sliding, found from the mechanism itself.

The accelerations are affine in the tangential forces, so two evaluations of the motion tell the force of one joint.
Where several joints stick, each is solved for in turn, clipped at what it can hold, until nothing changes: projected
Gauss-Seidel, on a matrix that is symmetric and positive definite because these forces work on these very slips.
"""

from typing import NamedTuple

from numba.extending import overload

from ..compiled.family import OPTIONS, kernel
from ..mechanism.contract import accelerate, gap_accelerations
from .dry import STUCK, Load
from .friction.contract import holding

SWEEPS = 100  # over the joints that stick; joints share little, so a dozen do
SETTLED = 1e-15  # of the holding force


class Surface(NamedTuple):
    """What sticking takes from a joint and its Gap."""

    bearing_radius: float  # m
    journal_radius: float  # m
    side: float
    holding: float  # largest tangential force over normal force; 0 where the law does not stick
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
def carrying(surface, load, force):
    """Return the Load with the tangential force `force` (N) in place of its own."""
    more = force - load.tangential
    share = more / (surface.x * surface.x + surface.y * surface.y) ** 0.5
    bearing, journal = -surface.bearing_radius * more, surface.journal_radius * more
    if surface.side < 0.0:
        bearing, journal = journal, bearing
    return Load(
        load.fx - share * surface.y,
        load.fy + share * surface.x,
        load.moment_proximal + bearing,
        load.moment_distal + journal,
        load.normal,
        force,
        load.slip,
        load.rate,
        load.depth,
        load.elastic,
        load.raw,
    )


def surfaces_of(joints, relative):
    """Return one Surface per joint of the tuple `joints`, whose Gaps are `relative`."""
    if len(joints) == 0:
        return ()
    return (surface_of(joints[0], relative[0]), *surfaces_of(joints[1:], relative[1:]))


@kernel
def surface_of(joint, gap):
    """Return the Surface of a joint."""
    return Surface(
        joint.bearing_radius, joint.journal_radius, joint.side, holding(joint.friction), gap.x, gap.y, gap.vx, gap.vy
    )


@overload(surfaces_of, strict=False, jit_options=dict(OPTIONS))
def _surfaces_of(joints, relative):
    if len(joints) == 1:
        return lambda joints, relative: (surface_of(joints[0], relative[0]),)
    return lambda joints, relative: (surface_of(joints[0], relative[0]),) + surfaces_of(joints[1:], relative[1:])  # noqa: RUF005


def carried(surfaces, loads, j, force):
    """Return the tuple `loads` with the tangential force `force` (N) in that of joint `j`."""
    if len(loads) == 0:
        return ()
    first = carrying(surfaces[0], loads[0], force) if j == 0 else loads[0]
    return (first, *carried(surfaces[1:], loads[1:], j - 1, force))


@overload(carried, strict=False, jit_options=dict(OPTIONS))
def _carried(surfaces, loads, j, force):
    def last(surfaces, loads, j, force):
        return (carrying(surfaces[0], loads[0], force) if j == 0 else loads[0],)

    def more(surfaces, loads, j, force):
        first = carrying(surfaces[0], loads[0], force) if j == 0 else loads[0]
        return (first,) + carried(surfaces[1:], loads[1:], j - 1, force)  # noqa: RUF005

    return last if len(loads) == 1 else more


@kernel
def rate_under(scene, y, pose, surfaces, loads, j):
    """Return the rate (m/s^2) of the sliding speed of joint `j` under the loads."""
    motion = accelerate(scene.mechanism, pose, loads)
    return slip_rate(surfaces[j], gap_accelerations(scene.mechanism, y, motion)[j])


def held(scene, y, pose, relative, loads, state):
    """Return the loads with the tangential forces of joints that stick such as let their sliding speed die away.

    It dies away with the rate `scene.pace`, as what it has left is the band's width and of no account; where that takes
    more force than the surfaces hold, they bear what they hold.
    """
    surfaces, stuck = surfaces_of(scene.joints, relative), 0
    for j in range(len(surfaces)):
        stuck += state[j] == STUCK
    for _ in range(SWEEPS if stuck > 1 else stuck):
        change = 0.0
        for j in range(len(surfaces)):
            limit = surfaces[j].holding * max(loads[j].normal, 0.0)
            if state[j] != STUCK or limit == 0.0:
                continue
            now = loads[j].tangential
            wanted = -scene.pace * loads[j].slip - rate_under(scene, y, pose, surfaces, loads, j)
            other = carried(surfaces, loads, j, now + limit)
            gain = wanted + scene.pace * loads[j].slip + rate_under(scene, y, pose, surfaces, other, j)
            force = min(max(now + limit * wanted / gain, -limit), limit)
            change = max(change, abs(force - now) / limit)
            loads = carried(surfaces, loads, j, force)
        if change < SETTLED:
            break
    return loads


@overload(held, strict=False, jit_options=dict(OPTIONS))
def _held(scene, y, pose, relative, loads, state):
    joints = scene.types[scene.fields.index("joints")]
    laws = [joint.types[joint.fields.index("friction")].instance_class for joint in joints]
    sticks = any(law in holding.members for law in laws)
    return held if sticks else lambda scene, y, pose, relative, loads, state: loads
