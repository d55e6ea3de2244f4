"""The compiled form of a spatial joint, how its bodies stand, and which contacts and laws it has."""

from typing import NamedTuple

from ...compiled.vector import Vector
from ..contract import ACTS, FREE, PRESSED, ContactModes, Part, contact_modes, parts
from ..dry import Clip


class InBore(NamedTuple):
    """The end circles of the journal are in the bore."""


class AtEdges(NamedTuple):
    """The journal goes beyond the bore, whose edges bear on it."""


class Through(NamedTuple):
    """A spatial joint without flanges."""

    clearance: float  # m, radial
    side: float  # +1: that of a gap, journal less bearing
    bearing_radius: float  # m
    journal_radius: float  # m
    half_length: float  # m, of the bearing
    half_journal: float  # m
    offset: Vector  # m, of the bearing's middle from the nominal one, in the frame of its body
    axis: Vector  # unit vector along the bearing, likewise
    ends: tuple  # InBore or AtEdges
    law: tuple  # contact_force, of each wall twice this
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force
    wear: tuple  # wear_rate
    across: Vector  # unit vector of the bearing's own x axis, in the frame of its body
    wear_rows: float  # bins of wear along the length


class Flanged(NamedTuple):
    """A spatial joint between flanges."""

    clearance: float  # m, radial
    side: float
    bearing_radius: float  # m
    journal_radius: float  # m
    half_length: float  # m
    half_journal: float  # m
    offset: Vector  # m
    axis: Vector  # unit vector
    ends: tuple  # InBore
    law: tuple
    elastic: tuple
    friction: tuple
    wear: tuple
    across: Vector
    wear_rows: float
    axial_clearance: float  # m, on each side
    axial_law: tuple  # contact_force of a flange
    axial_elastic: tuple


class SpatialGap(NamedTuple):
    """The journal in its bearing: all in the frame of the journal, but `frame`."""

    middle: Vector  # m, of the journal, from the middle of the bearing
    velocity: Vector  # m/s, of the journal's middle less that of the bearing's
    axis: Vector  # unit vector along the bearing
    on_bearing: Vector  # rad/s, angular velocity of the bearing
    on_journal: Vector  # rad/s, of the journal
    frame: tuple  # attitude.Frame of the journal


class SpatialLoad(NamedTuple):
    """What a spatial joint does to the bodies, in the frame of the journal."""

    force: Vector  # N, on the journal
    on_journal: Vector  # N m, moment about the journal's middle
    on_bearing: Vector  # N m, moment on the bearing about its middle
    contacts: tuple  # of Contacts


_WALLS = (ContactModes(FREE, PRESSED), ContactModes(FREE, PRESSED))
_TELLING = (ContactModes(ACTS, ACTS), ContactModes(ACTS, ACTS))


@contact_modes.member(Through)
def _two_walls(joint):
    return (*_WALLS, *_TELLING)


@contact_modes.member(Flanged)
def _two_walls_and_two_flanges(joint):
    return (*_WALLS, *_WALLS, *_TELLING)


@parts.member(Through)
def _laws_of_walls(joint):
    return (
        Part(Clip(), 0),
        Part(joint.law, 0),
        Part(joint.friction, 0),
        Part(Clip(), 1),
        Part(joint.law, 1),
        Part(joint.friction, 1),
    )


@parts.member(Flanged)
def _laws_of_walls_and_flanges(joint):
    return (
        Part(Clip(), 0),
        Part(joint.law, 0),
        Part(joint.friction, 0),
        Part(Clip(), 1),
        Part(joint.law, 1),
        Part(joint.friction, 1),
        Part(Clip(), 2),
        Part(joint.axial_law, 2),
        Part(joint.friction, 2),
        Part(Clip(), 3),
        Part(joint.axial_law, 3),
        Part(joint.friction, 3),
    )
