"""From numbers and clearances to a slider-crank in space and its start."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...compiled.vector import Vector
from ...joint.spatial import deepest_of, overlap_of
from ..contract import Built, gaps, place
from . import motion  # noqa: F401 - enters the equations of motion
from .form import Bearing, Cylindrical, Links, SpatialSliderCrank, Spherical, rod_of
from .pose import ANGLE, CENTER, RISE, SLIDER, TURNED, count

IDEAL = {"spherical": Spherical, "cylindrical": Cylindrical}
PINS = ("crank-rod", "rod-slider")


def build(bodies, drive, joints, offsets) -> Built:
    """Return the slider-crank at crank angle 0 with its rod in the nominal plane, moving as without clearance.

    bodies : numbers in SI and words by key below `mechanism`; drive : rad/s; joints : compiled form of each joint with
    clearance; offsets : of no meaning here, a spatial joint starts centred.
    """
    sites = tuple(
        Bearing(joints[name].offset, joints[name].axis, joints[name].across)
        if name in joints
        else IDEAL[bodies[f"ideal.{name}"]]()
        for name in PINS
    )
    rod = rod_of(bodies, sites)
    links = Links(
        bodies["crank.length"],
        Vector(*(bodies[f"crank.center.{k}"] for k in range(3))),
        bodies["crank.mass"],
        bodies["crank.inertia.2"],
        bodies["slider.mass"],
        Vector(*(bodies[f"gravity.{k}"] for k in range(3))),
        drive,
    )
    mechanism = SpatialSliderCrank(links, rod, sites)
    return Built(mechanism, _start(mechanism), _lengths(mechanism), links.crank_length + rod.length, drive)


class Seat(NamedTuple):
    """How a journal sits in its bearing."""

    depth: float  # m, largest penetration, below 0 where it is apart everywhere
    overlap: float  # m, of journal and bore along the journal's axis; 0 or less: it is beside its bearing


def seats(built: Built, joints: Mapping) -> dict[str, Seat]:
    """Return how each journal sits in its bearing at the start.

    joints : compiled forms in the order of the mechanism's sites.
    """
    relative = gaps(built.value, place(built.value, built.start))
    pairs = zip(joints.items(), relative, strict=True)
    return {name: Seat(deepest_of(joint, gap), float(overlap_of(joint, gap))) for (name, joint), gap in pairs}


def _tilts(mechanism: SpatialSliderCrank) -> bool:
    """Return whether the rod may tilt."""
    return not any(isinstance(site, Cylindrical) for site in mechanism.sites)


def _start(mechanism: SpatialSliderCrank) -> np.ndarray:
    """Return coordinates, their rates and time."""
    links, rod, n = mechanism.links, mechanism.rod, count(mechanism)
    tip = links.crank_length * links.speed
    rate = -tip / rod.length
    start = np.zeros(2 * n + 1)
    start[SLIDER] = links.crank_length + rod.length
    if not _tilts(mechanism):
        start[n + ANGLE] = rate
        return start
    start[TURNED], start[n + TURNED + 3] = 1.0, 0.5 * rate
    if n > CENTER:
        center = rod.center
        start[CENTER : CENTER + 3] = links.crank_length + center.x, center.y, center.z
        start[n + CENTER : n + CENTER + 3] = -rate * center.y, tip + rate * center.x, 0.0
    return start


def _lengths(mechanism: SpatialSliderCrank) -> np.ndarray:
    """Return how far (m) bodies move for a unit of each coordinate."""
    lengths, long = np.ones(count(mechanism)), mechanism.rod.length
    if _tilts(mechanism):
        lengths[TURNED : TURNED + 4] = 2.0 * long
    else:
        lengths[ANGLE], lengths[RISE] = long, 1.0
    return lengths
