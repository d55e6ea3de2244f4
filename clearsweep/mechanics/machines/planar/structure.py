"""The structure of a planar machine, read from its compiled type, and its spanning tree.

It decides which operations the programs of the machine have.
"""

from typing import Any, NamedTuple

from ....contracts.machine import Braking, Constant, Guide, Mesh, Rubbing, Slot, Stops, Stretch, ends_of
from ...laws.friction import Karnopp
from ..contract import Open
from ..programs import kinds_of, shared_by
from .drives import FREE, is_regulated
from .form import STATIONS, Bent, BentPoint, BranchingCycle, Housing, Planar, Segment

FRICTION_LOADS = Rubbing, Braking


# ---------------------------------------------------------------------------------------------- the spanning tree

# Spanning tree of a planar machine: angle groups, tree of joints, coordinates, loops.
#
# Bodies that a guide without clearance keeps parallel share one angle, measured in the fixed frame.  A tree of joints
# without clearance leads from the ground to every body that such joints connect; each further joint closes a loop.
# The other bodies float: one of each connected set has the position of its centre of mass as
# coordinates, and the others are attached to it.  Joints with clearance constrain nothing.

#: Kinds of coordinates: of an angle group, along a guide, of a floating body, of the deformation of a link that bends.
#: A cut opens such a link at a station; it stays closed, and its force is the normal force of the link there.
#: The rate of INTEGRAL is the integral part of a servo's torque: it moves nothing, and is the last of the state.
ANGLE, TRAVEL, SHIFT_X, SHIFT_Y, BEND, CUT, INTEGRAL = range(7)


class Link(NamedTuple):
    """A joint as an edge of the graph."""

    slides: bool
    open: bool
    proximal: int  # number of a body, 0 for the ground
    distal: int
    sprung: bool = False  # connects two masses of an elastic link
    geared: bool = False  # keeps a ratio of two angles, or a travel, between two sides


class Coordinate(NamedTuple):
    """A coordinate of the tree."""

    kind: int
    owner: int  # number of the group, of the joint, or of the body; of a deformation its own number


class SpanningTree(NamedTuple):
    """Spanning tree of a machine."""

    group: tuple  # group of each body, 0 for the ground; a group has the number of its first body
    parents: tuple  # parent (body, joint) of each body; None for the ground and floating bodies
    order: tuple  # bodies after their parents, without the ground
    loop_joints: tuple  # joints that close loops
    crank: int  # group that the drive rotates
    coordinates: tuple  # in the order of the state; a free crank's angle first

    def roots(self) -> tuple:
        """Return the floating bodies."""
        return tuple(body for body in self.order if self.parents[body] is None)


def spanning_tree(
    count: int, links: tuple, crank: int, *, free: bool, deformations: int = 0, regulated: bool = False
) -> SpanningTree:
    """Return the spanning tree of `count` bodies, including the ground, connected by `links`.

    free : the crank's angle is one of the coordinates; deformations : number of those of all links that bend;
    regulated : the drive has an integral part.
    """
    group = _groups(count, links)
    parents, order, tree_joints = _shortest_tree(count, links)
    loop_joints = tuple(j for j, link in enumerate(links) if not link.open and j not in tree_joints)
    angles = [g for g in dict.fromkeys(group) if g not in (0, group[crank])]
    coordinates = [Coordinate(ANGLE, group[crank])] if free else []
    coordinates += [Coordinate(ANGLE, g) for g in angles]
    coordinates += [Coordinate(TRAVEL, j) for j, link in enumerate(links) if link.slides and j in tree_joints]
    for body in order:
        if parents[body] is None:
            coordinates += [Coordinate(SHIFT_X, body), Coordinate(SHIFT_Y, body)]
    coordinates += [Coordinate(BEND, i) for i in range(deformations)]
    coordinates += [Coordinate(INTEGRAL, 0)] if regulated else []
    return SpanningTree(group, parents, order, loop_joints, group[crank], tuple(coordinates))


def _groups(count: int, links: tuple) -> tuple:
    group = list(range(count))
    for link in links:
        if link.slides and not link.open:
            lower, higher = sorted((group[link.proximal], group[link.distal]))
            group = [lower if g == higher else g for g in group]
    return tuple(group)


def _shortest_tree(count: int, links: tuple) -> tuple:
    """Return the parent of each body, the bodies in order, and the tree joints; paths to the ground are shortest."""
    parents: list = [None] * count
    order: list[int] = []
    tree_joints: set[int] = set()
    for root in range(count):
        if root in order:
            continue
        order.append(root)
        layer = [root, *_attach_link_masses(links, root, order, parents, tree_joints)]
        order += layer[1:]
        while layer:
            layer = _attach_children(links, layer, order, parents, tree_joints)
            order += layer
    return tuple(parents), tuple(order[1:]), tree_joints


def _attach_children(links: tuple, layer: list, placed: list, parents: list, tree_joints: set) -> list:
    """Return the children of the bodies in `layer`; record them in `parents`, and their joints in `tree_joints`."""
    order: list[int] = []
    for j, link in enumerate(links):
        for placed_body, new_body in ((link.proximal, link.distal), (link.distal, link.proximal)):
            if link.open or link.geared:
                continue
            if placed_body in layer and new_body not in placed and new_body not in order:
                parents[new_body] = (placed_body, j)
                tree_joints.add(j)
                order.append(new_body)
                order += _attach_link_masses(links, new_body, [*placed, *order], parents, tree_joints)
    return order


def _attach_link_masses(links: tuple, body: int, placed: list, parents: list, tree_joints: set) -> list:
    """Return the masses of the elastic link of `body`, attached in a chain: no spring closes a loop."""
    order: list[int] = []
    pending = [body]
    while pending:
        placed_body = pending.pop()
        for j, link in enumerate(links):
            if not link.sprung or placed_body not in (link.proximal, link.distal):
                continue
            new_body = link.distal if placed_body == link.proximal else link.proximal
            if new_body not in placed and new_body not in order:
                parents[new_body] = (placed_body, j)
                tree_joints.add(j)
                order.append(new_body)
                pending.append(new_body)
    return order


# ---------------------------------------------------------------------------------------------- the type of a machine


class BentForm(NamedTuple):
    """The forms of the vectors of a BentPoint."""

    at: type
    slopes: tuple[type, ...]
    curvatures: tuple[type, ...]
    cuts: int


PointForm = type | BentForm


class BentKind(NamedTuple):
    """A body that bends, and its deformations: modes, then extensions of axial segments."""

    body: int
    modes: int
    coordinates: tuple[Coordinate, ...]
    axis: type

    @property
    def cuts(self) -> tuple[Coordinate, ...]:
        """Return its cuts at all stations."""
        return tuple(Coordinate(CUT, self.body * len(STATIONS) + i) for i in range(len(STATIONS)))


class Site(NamedTuple):
    """A joint, and the forms of its points, such as Centre."""

    link: Link
    near: PointForm  # on the proximal body
    far: PointForm
    axis: type | None  # of a guide; of a gear along the line of centres
    carrier: int = 0  # body of a gear on which both wheels turn
    pins: tuple[int, ...] = ()  # of the first and the second wheel of a gear
    guide: int | None = None  # whose travel is stopped
    eccentric: tuple[PointForm, ...] = ()  # forms of the centres of the pitch circles of a gear, from their pins


class LoadKind(NamedTuple):
    """A load and its points of action."""

    form: type
    points: tuple[tuple[int, PointForm, str], ...]  # bodies, forms of points, and the fields that contain these


class FrictionLoad(NamedTuple):
    """Friction in a joint without clearance, or of a given size in any joint."""

    load: int  # its number among the loads
    joint: int
    is_given: bool  # it does not depend on the reaction
    sticks: bool = False  # its law sticks


class MachineType(NamedTuple):
    """The structure of a planar machine."""

    sites: tuple[Site, ...]
    spanning_tree: SpanningTree
    crank: int  # number of the driven body
    free: bool  # the crank is free
    steady: bool  # the crank's speed is constant
    dependent: tuple[Coordinate, ...]  # dependent coordinates
    loads: tuple[LoadKind | None, ...]  # None where it is friction
    friction_loads: tuple[FrictionLoad, ...]
    aim: tuple  # (number of the body, form of the point or None, form of the direction)
    bent: dict[int, BentKind]  # bodies that bend
    segments: tuple[int, ...] = ()  # numbers of bodies that are further masses of elastic links
    branches: bool = False  # its loops pass change points
    housings: tuple[int, ...] = ()  # numbers of bodies that are housings on springs, or lie between them
    of_dyads: bool = False  # dyads close all its loops

    @property
    def bodies(self) -> int:
        """Return the number of bodies, including the ground."""
        return len(self.spanning_tree.group)

    @property
    def state(self) -> list[Coordinate]:
        """Return the coordinates in the order of the state."""
        return [coordinate for coordinate in self.spanning_tree.coordinates if coordinate not in self.dependent]

    @property
    def regulated(self) -> bool:
        """Return whether the drive has an integral part."""
        return self.spanning_tree.coordinates[-1:] == (Coordinate(INTEGRAL, 0),)

    @property
    def groups(self) -> list[int]:
        """Return the rotating groups in the order of a pose."""
        return [g for g in dict.fromkeys(self.spanning_tree.group) if g != 0]

    @property
    def open(self) -> list[int]:
        """Return the joints with clearance."""
        return [j for j, site in enumerate(self.sites) if site.link.open]

    @property
    def sprung(self) -> list[int]:
        """Return the joints between masses of elastic links, and those under housings."""
        return [j for j, site in enumerate(self.sites) if site.link.sprung]

    @property
    def whole_bodies(self) -> list[tuple[int, ...]]:
        """Return the moving bodies without housings, with the masses of an elastic link grouped."""
        chains: list[tuple[int, ...]] = []
        for body in range(1, self.bodies):
            if body in self.segments:
                chains[-1] = (*chains[-1], body)
            elif body not in self.housings:
                chains.append((body,))
        return chains


@shared_by(kinds_of, 1024)
def machine_type(machine: Planar) -> MachineType:
    """Return the structure of a compiled machine, which depends on its types alone."""
    sites = tuple(map(_site, machine.joints, machine.sites))
    is_free, bent = isinstance(machine.drive, FREE), _bent_kinds(machine.bodies)
    tree = spanning_tree(
        1 + len(machine.bodies),
        tuple(site.link for site in sites),
        len(machine.crank),
        free=is_free,
        deformations=sum(len(kind.coordinates) for kind in bent.values()),
        regulated=is_regulated(machine.drive),
    )
    friction_loads = tuple(
        FrictionLoad(i, len(load.joint), isinstance(load, Braking), isinstance(load.friction, Karnopp))
        for i, load in enumerate(machine.loads)
        if isinstance(load, FRICTION_LOADS)
    )
    aim: Any = machine.aim  # mypy takes it for a tuple of anything
    has_point = type(aim.point) is not tuple
    point, direction = (_point_form(aim.point), type(aim.direction)) if has_point else (None, None)
    segments, housings = (
        tuple(i for i, body in enumerate(machine.bodies, start=1) if isinstance(body, form))
        for form in (Segment, Housing)
    )
    return MachineType(
        sites,
        tree,
        len(machine.crank),
        is_free,
        isinstance(machine.drive, Constant),
        tuple(tree.coordinates[len(index)] for index in machine.dependent),
        tuple(map(_load, machine.loads)),
        friction_loads,
        (len(aim.body), point, direction),
        bent,
        segments,
        isinstance(machine.cycle, BranchingCycle),
        housings,
        bool(machine.sides),
    )


def _bent_kinds(bodies: tuple) -> dict[int, BentKind]:
    """Return the bodies that bend, from all moving bodies."""
    bent: dict[int, BentKind] = {}
    first = 0
    for number, body in enumerate(bodies, start=1):
        if isinstance(body, Bent):
            coordinates = tuple(Coordinate(BEND, first + i) for i in range(len(body.stiffness)))
            bent[number] = BentKind(number, len(body.modes), coordinates, type(body.axis))
            first += len(coordinates)
    return bent


def _point_form(point: tuple) -> PointForm:
    """Return the form of a point of a body."""
    if not isinstance(point, BentPoint):
        return type(point)
    slopes, curvatures = (tuple(map(type, vectors)) for vectors in (point.slopes, point.curvatures))
    return BentForm(type(point.at), slopes, curvatures, len(point.cuts))


def _site(joint: Any, site: tuple) -> Site:
    slides, geared = isinstance(joint, (Guide, Slot, Stretch)), isinstance(joint, (Mesh, Stops))
    bodies = len(joint.proximal.body), len(joint.distal.body)
    link = Link(slides, isinstance(site, Open), *bodies, isinstance(joint, Stretch), geared)
    near, far = _point_form(joint.proximal.point), _point_form(joint.distal.point)
    if isinstance(joint, Stops):
        return Site(link, near, far, None, guide=len(joint.guide))
    if isinstance(joint, Mesh):
        axis = None if type(joint.centres) is tuple else type(joint.centres)
        pins, centres = tuple(map(len, joint.pins)), tuple(map(_point_form, joint.eccentricities))
        return Site(link, near, far, axis, len(joint.carrier), pins, eccentric=centres)
    return Site(link, near, far, type(joint.axis) if slides else None)


def _load(load: Any) -> LoadKind | None:
    if isinstance(load, FRICTION_LOADS):
        return None
    points = ((len(end.body), _point_form(end.point), field) for field, end in ends_of(load).items())
    return LoadKind(type(load), tuple(points))
