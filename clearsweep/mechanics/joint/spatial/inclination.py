"""Slope of the depth along the length from an end, and the conjugate forces and couples.

The slope is e . a, with e the unit vector from one body's axis to the centre of the touching circle, across that axis,
and a the unit vector of the circle's own axis, outwards.  Its rate is linear in the relative motion of the bodies, and
the same factors give the force and the couple that do the work of a load conjugate to the slope; so the walls' forces
have a potential.
"""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.dual import as_type_of
from ...compiled.family import family, kernel
from ...compiled.vector import Vector, cross, dot, minus, plus_scaled, times
from .form import AtEdges, InBore, Overlapping
from .points import is_past_edge


class Inclination(NamedTuple):
    """The slope of the depth at one of the ENDS."""

    slope: float  # 1, decrease of the depth per length inwards
    center: Vector  # m, centre of the circle, from the centre of the bearing
    velocity_factor: Vector  # 1/m, rate of the slope per velocity (m/s) of the journal there, relative to the bearing
    spin_factor: Vector  # 1, rate of the slope per angular velocity (rad/s) of the journal relative to the bearing


@kernel
def _inclination(center, radial_offset, outward, other_axis, rotation_sign):
    """Return the Inclination of a circle whose centre is at `radial_offset` (m) from the axis of the other body.

    rotation_sign : 1, or -1 for the bore's circle.
    """
    square = dot(radial_offset, radial_offset)
    inverse = 1.0 / math.sqrt(square) if square > 0.0 else as_type_of(0.0, square)
    unit = times(inverse, radial_offset)
    inclination = dot(unit, outward)
    tangent = plus_scaled(plus_scaled(outward, -dot(outward, other_axis), other_axis), -inclination, unit)
    return Inclination(inclination, center, times(inverse, tangent), times(rotation_sign, cross(outward, unit)))


@family
def inclination_of(end_type, joint, gap, end):
    """Return the Inclination at one of the ENDS."""


@inclination_of.member(InBore)
def _inclination_of_in_bore(end_type, joint, gap, end):
    midpoint, zero = gap.middle, as_type_of(0.0, gap.middle.z)
    center = Vector(midpoint.x, midpoint.y, midpoint.z + end * joint.journal_half_length)
    radial_offset = plus_scaled(center, -dot(center, gap.axis), gap.axis)
    return _inclination(center, radial_offset, Vector(zero, zero, zero + end), gap.axis, 1.0)


@inclination_of.member(AtEdges)
def _inclination_of_at_edges(end_type, joint, gap, end):
    midpoint, zero = gap.middle, as_type_of(0.0, gap.middle.z)
    inward = times(-end * math.copysign(1.0, gap.axis.z), gap.axis)
    center = times(-joint.half_length, inward)
    radial_offset = minus(midpoint, center)
    radial_offset = Vector(radial_offset.x, radial_offset.y, zero)
    return _inclination(center, radial_offset, inward, Vector(zero, zero, zero + 1.0), -1.0)


@inclination_of.member(Overlapping)
def _inclination_of_overlapping(end_type, joint, gap, end):
    if is_past_edge(joint, gap, end):
        return inclination_of(AtEdges(), joint, gap, end)
    return inclination_of(InBore(), joint, gap, end)
