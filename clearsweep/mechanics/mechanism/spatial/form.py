"""The compiled form of a slider-crank that moves in space.

The crank turns about z at constant speed, the slider moves along x without turning; the rod between them has its
frame at its first pin, x towards the second, z along the pins.  Which of the two pins has clearance, and what the other
one allows, decides the coordinates, x of the slider first:

============  ============  ===========================================================
crank-rod     rod-slider    further coordinates
============  ============  ===========================================================
open          spherical     quaternion of the rod
spherical     open          quaternion of the rod
open          open          quaternion of the rod, its centre of mass x, y, z
open          cylindrical   z of the rod, its angle
cylindrical   open          z of the rod, its angle
============  ============  ===========================================================
"""

from typing import NamedTuple

import numpy as np

from ...compiled.vector import Symmetric, Vector


class Bearing(NamedTuple):
    """A pin with clearance: its bearing on the crank or on the slider."""

    offset: Vector  # m, of its middle from the nominal one, in the frame of its body
    axis: Vector  # unit vector along it, likewise
    across: Vector  # unit vector of its own x axis, from which wear is told round it


class Spherical(NamedTuple):
    """A pin without clearance about which the rod turns freely."""


class Cylindrical(NamedTuple):
    """A pin without clearance about whose axis the rod turns and along which it slides."""


class Links(NamedTuple):
    """Crank, slider and the drive."""

    crank_length: float  # m
    crank_center: Vector  # m, centre of mass in the crank's frame
    crank_mass: float  # kg
    crank_inertia: float  # kg m^2, about the z axis through the centre of mass
    slider_mass: float  # kg
    gravity: Vector  # m/s^2
    speed: float  # rad/s


class Rod(NamedTuple):
    """The rod, and its inertia about the point by which it hangs: a pin without clearance, or the centre of mass."""

    length: float  # m
    mass: float  # kg
    center: Vector  # m, centre of mass from the first pin
    arm: Vector  # m, centre of mass from the point by which it hangs
    inertia: Symmetric  # kg m^2, about that point
    inverse: Symmetric  # 1/(kg m^2), what turns a moment into an acceleration of what may turn


class SpatialSliderCrank(NamedTuple):
    """The compiled form: the types of its sites choose the coordinates and the equations."""

    links: Links
    rod: Rod
    sites: tuple  # Bearing, Spherical or Cylindrical at crank-rod and rod-slider


def rod_of(bodies, sites) -> Rod:
    """Return the rod of the numbers `bodies` by key, which hangs as the types of its sites say."""
    length, mass = bodies["rod.length"], bodies["rod.mass"]
    center = np.array([bodies[f"rod.center.{k}"] for k in range(3)])
    hinge = center
    if not isinstance(sites[1], Bearing):
        hinge = np.array([length, 0.0, 0.0])
    elif not isinstance(sites[0], Bearing):
        hinge = np.zeros(3)
    arm = center - hinge
    inertia = np.diag([bodies[f"rod.inertia.{k}"] for k in range(3)])
    inertia = inertia + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    inverse = np.linalg.inv(inertia)
    if any(isinstance(site, Cylindrical) for site in sites):
        inverse = np.diag([0.0, 0.0, 1.0 / inertia[2, 2]])
    return Rod(length, mass, Vector(*center), Vector(*arm), _symmetric(inertia), _symmetric(inverse))


def _symmetric(matrix) -> Symmetric:
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return Symmetric(*(float(matrix[place]) for place in places))
