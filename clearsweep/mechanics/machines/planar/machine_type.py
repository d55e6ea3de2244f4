"""The structure of a planar machine, read from its compiled type: it decides which operations its programs have."""

import functools
from typing import NamedTuple

from ...laws.friction import Karnopp
from ..contract import Open
from .cycle import BranchingCycle
from .drive import Free, Steady
from .form import ElasticGuide, Planar, PointAim, Segment, Slide
from .loads import FRICTION_LOADS, GivenFriction, SpringLoad
from .spanning_tree import Coordinate, Link, SpanningTree, spanning_tree


class Site(NamedTuple):
    """A joint, and the forms of its points, such as Centre."""

    link: Link
    near: type  # on the proximal body
    far: type
    axis: type | None  # of a guide


class LoadKind(NamedTuple):
    """A load and its points of action."""

    form: type
    points: tuple[tuple[int, type, str], ...]  # bodies, forms of points, and the fields that contain these


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
    segments: tuple[int, ...] = ()  # numbers of bodies that are further masses of elastic links
    branches: bool = False  # its loops pass change points

    @property
    def bodies(self) -> int:
        """Return the number of bodies, including the ground."""
        return len(self.spanning_tree.group)

    @property
    def state(self) -> list[Coordinate]:
        """Return the coordinates in the order of the state."""
        return [coordinate for coordinate in self.spanning_tree.coordinates if coordinate not in self.dependent]

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
        """Return the joints between masses of elastic links."""
        return [j for j, site in enumerate(self.sites) if site.link.sprung]

    @property
    def whole_bodies(self) -> list[tuple[int, ...]]:
        """Return the moving bodies, with the masses of an elastic link grouped."""
        chains: list[tuple[int, ...]] = []
        for body in range(1, self.bodies):
            if body in self.segments:
                chains[-1] = (*chains[-1], body)
            else:
                chains.append((body,))
        return chains


@functools.lru_cache(maxsize=1024)
def machine_type(kinds: tuple) -> MachineType:
    """Return the MachineType from the result of `kinds_of` for a Planar."""
    sites = tuple(map(_site, _kind_of_field(kinds, "joints")[1:]))
    crank, drive = _number(_kind_of_field(kinds, "crank")), _kind_of_field(kinds, "drive")[0]
    tree = spanning_tree(
        len(_kind_of_field(kinds, "bodies")), tuple(site.link for site in sites), crank, free=drive is Free
    )
    friction_loads = tuple(
        FrictionLoad(
            i,
            _number(_kind_of_field(kind, "joint")),
            kind[0] is GivenFriction,
            _kind_of_field(kind, "friction")[0] is Karnopp,
        )
        for i, kind in enumerate(_kind_of_field(kinds, "loads")[1:])
        if kind[0] in FRICTION_LOADS
    )
    loads = tuple(map(_load, _kind_of_field(kinds, "loads")[1:]))
    aim = _kind_of_field(kinds, "aim")
    assert kinds[0] is Planar
    point, direction = (
        (_kind_of_field(aim, field)[0] for field in ("point", "direction")) if aim[0] is PointAim else (None, None)
    )
    dependent = tuple(tree.coordinates[_number(kind)] for kind in _kind_of_field(kinds, "dependent")[1:])
    return MachineType(
        sites,
        tree,
        crank,
        drive is Free,
        drive is Steady,
        dependent,
        loads,
        friction_loads,
        (_number(_kind_of_field(aim, "body")), point, direction),
        tuple(i for i, kind in enumerate(_kind_of_field(kinds, "bodies")[1:], start=1) if kind[0] is Segment),
        _kind_of_field(kinds, "cycle")[0] is BranchingCycle,
    )


def _kind_of_field(kinds: tuple, field: str) -> tuple:
    return kinds[1 + kinds[0]._fields.index(field)]


def _number(kinds: tuple) -> int:
    return len(kinds) - 1


def _site(kinds: tuple) -> Site:
    slides = kinds[0] is Slide
    site, bodies = (
        _kind_of_field(kinds, "site")[0],
        (_number(_kind_of_field(kinds, "proximal")), _number(_kind_of_field(kinds, "distal"))),
    )
    link = Link(slides, site is Open, *bodies, site is ElasticGuide)
    near, far = (_kind_of_field(kinds, end)[0] for end in ("near", "far"))
    return Site(link, near, far, _kind_of_field(kinds, "axis")[0] if slides else None)


def _load(kinds: tuple) -> LoadKind | None:
    if kinds[0] in FRICTION_LOADS:
        return None
    pairs = (("first", "near"), ("second", "far")) if kinds[0] is SpringLoad else (("body", "point"),)
    endpoints = tuple(
        (_number(_kind_of_field(kinds, body)), _kind_of_field(kinds, point)[0], point) for body, point in pairs
    )
    return LoadKind(kinds[0], endpoints)
