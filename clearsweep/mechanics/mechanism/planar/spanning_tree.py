"""How the bodies of a planar machine hang on each other: angles, the tree of joints, coordinates, loops.

Bodies that a guide without clearance keeps parallel share one angle, measured in the fixed frame.  A tree of joints
without clearance leads from the ground to every body that such joints connect with it; each further one closes a loop.
What the ground does not hold that way floats: one of its bodies has the place of its centre of mass for
coordinates, and the others hang on it.  Joints with clearance hold nothing.
"""

from typing import NamedTuple

ANGLE, RUN, SHIFT_X, SHIFT_Y = range(4)  # kinds of coordinates: of an angle group, along a guide, of a floating body


class Link(NamedTuple):
    """A joint as it hangs."""

    slides: bool
    open: bool
    proximal: int  # number of a body, 0 for the ground
    distal: int
    sprung: bool = False  # keeps two masses of an elastic link together


class Coordinate(NamedTuple):
    """A coordinate of the tree."""

    kind: int
    of: int  # number of the group, of the joint, or of the body


class SpanningTree(NamedTuple):
    """How everything hangs."""

    group: tuple  # of each body, the ground's being 0; a group is numbered by its first body
    parents: tuple  # of each body: (body, joint) it hangs on; None for the ground and what floats
    order: tuple  # bodies, each after the one it hangs on, without the ground
    loop_joints: tuple  # joints that close loops
    crank: int  # group that the drive turns
    coordinates: tuple  # in the order of the state; the crank's angle, where it is one, first

    def roots(self) -> tuple:
        """Return the bodies that float."""
        return tuple(body for body in self.order if self.parents[body] is None)


def spanning_tree(count: int, links: tuple, crank: int, *, free: bool) -> SpanningTree:
    """Return how `count` bodies, the ground among them, hang on each other by `links`.

    free : the crank's angle is one of the coordinates.
    """
    group = _groups(count, links)
    parents, order, used = _tree(count, links)
    loop_joints = tuple(j for j, link in enumerate(links) if not link.open and j not in used)
    angles = [g for g in dict.fromkeys(group) if g not in (0, group[crank])]
    coordinates = [Coordinate(ANGLE, group[crank])] if free else []
    coordinates += [Coordinate(ANGLE, g) for g in angles]
    coordinates += [Coordinate(RUN, j) for j, link in enumerate(links) if link.slides and j in used]
    for body in order:
        if parents[body] is None:
            coordinates += [Coordinate(SHIFT_X, body), Coordinate(SHIFT_Y, body)]
    return SpanningTree(group, parents, order, loop_joints, group[crank], tuple(coordinates))


def _groups(count: int, links: tuple) -> tuple:
    group = list(range(count))
    for link in links:
        if link.slides and not link.open:
            kept, gone = sorted((group[link.proximal], group[link.distal]))
            group = [kept if g == gone else g for g in group]
    return tuple(group)


def _tree(count: int, links: tuple) -> tuple:
    """Return the parent of each body, the bodies in order, and the joints of the tree: shortest ways to the ground."""
    parents: list = [None] * count
    order: list[int] = []
    used: set[int] = set()
    for root in range(count):
        if root in order:
            continue
        order.append(root)
        layer = [root, *_chained(links, root, order, parents, used)]
        order += layer[1:]
        while layer:
            layer = _following(links, layer, order, parents, used)
            order += layer
    return tuple(parents), tuple(order[1:]), used


def _following(links: tuple, layer: list, placed: list, parents: list, used: set) -> list:
    """Return the bodies that hang on those of `layer`, which are noted in `parents` and `used` with the joint."""
    found: list[int] = []
    for j, link in enumerate(links):
        for near, far in ((link.proximal, link.distal), (link.distal, link.proximal)):
            if not link.open and near in layer and far not in placed and far not in found:
                parents[far] = (near, j)
                used.add(j)
                found.append(far)
                found += _chained(links, far, [*placed, *found], parents, used)
    return found


def _chained(links: tuple, body: int, placed: list, parents: list, used: set) -> list:
    """Return the masses of the elastic link that `body` is one of, hung on each other: no spring closes a loop."""
    found: list[int] = []
    pending = [body]
    while pending:
        near = pending.pop()
        for j, link in enumerate(links):
            if not link.sprung or near not in (link.proximal, link.distal):
                continue
            far = link.distal if near == link.proximal else link.proximal
            if far not in placed and far not in found:
                parents[far] = (near, j)
                used.add(j)
                found.append(far)
                pending.append(far)
    return found
