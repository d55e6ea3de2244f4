"""Spanning tree of a planar machine: angle groups, tree of joints, coordinates, loops.

Bodies that a guide without clearance keeps parallel share one angle, measured in the fixed frame.  A tree of joints
without clearance leads from the ground to every body that such joints connect; each further joint closes a loop.
The other bodies float: one of each connected set has the position of its centre of mass as
coordinates, and the others are attached to it.  Joints with clearance constrain nothing.
"""

from typing import NamedTuple

ANGLE, TRAVEL, SHIFT_X, SHIFT_Y = range(4)  # kinds of coordinates: of an angle group, along a guide, of a floating body


class Link(NamedTuple):
    """A joint as an edge of the graph."""

    slides: bool
    open: bool
    proximal: int  # number of a body, 0 for the ground
    distal: int
    sprung: bool = False  # connects two masses of an elastic link


class Coordinate(NamedTuple):
    """A coordinate of the tree."""

    kind: int
    owner: int  # number of the group, of the joint, or of the body


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


def spanning_tree(count: int, links: tuple, crank: int, *, free: bool) -> SpanningTree:
    """Return the spanning tree of `count` bodies, including the ground, connected by `links`.

    free : the crank's angle is one of the coordinates.
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
            if not link.open and placed_body in layer and new_body not in placed and new_body not in order:
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
