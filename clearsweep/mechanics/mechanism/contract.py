"""What a mechanism is: one value that describes it, and the functions of its compiled form.

A mechanism is a file, or a folder where that would be long: a `catalogue.Mechanism` that describes it, and the members
of the families below for the type of its compiled form.  Nothing else names it: its name, keys, joints and channels are
read from that description, and the types in the compiled form choose the code.

Joints without clearance are types too: a compiled form has a tuple with `Ideal()` or `Open()` for each joint site,
and where the equations depend on what is open, members for that tuple are chosen by them (`slider_crank`).  A
four-bar is one such file; the planar mechanism of any topology is another, whose sites are as many as its joints and
whose one body of `accelerate` eliminates the constraints of the ideal ones; a free crank is a coordinate more and
`turns` as before; loads on bodies are further values of the compiled form that `accelerate` reads.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..compiled.dual import as_type_of, slope
from ..compiled.family import family, inlined, kernel, map_joints
from ..compiled.moving import Moving
from ..joint.places import after_number


class IdealMotion(NamedTuple):
    """A mechanism without clearance at angles of what drives it, arrays of any shape (...)."""

    place: np.ndarray  # of the output, in the unit of its catalogue.Output: m, or rad where it turns
    velocity: np.ndarray  # the same per s
    acceleration: np.ndarray  # the same per s^2
    reactions: Mapping[str, np.ndarray]  # joint -> (..., 2) N, force on its distal body
    torque: np.ndarray | None = None  # N m, of the drive on the crank, or None if it is not known


class Built(NamedTuple):
    """A mechanism with numbers and clearances."""

    value: tuple  # the compiled form
    start: np.ndarray  # (2 n + 1,) coordinates, their rates, time, with the distal pins where they were asked to be
    lengths: np.ndarray  # (n,) m: how far the bodies move for a unit of each coordinate
    size: float  # m, of the whole: what places are rounded to follows from it
    rate: float  # rad/s, by which time is measured: that of the crank, or of approach over clearance


# ---------------------------------------------------------------------------------------------- the compiled form


class Ideal(NamedTuple):
    """A joint without clearance: its pins coincide."""


class Open(NamedTuple):
    """A joint with clearance: nothing but its load acts between its bodies."""


class Motion(NamedTuple):
    """How a mechanism accelerates."""

    accelerations: tuple  # of the coordinates
    output: float  # of the output, in its unit per s^2; 0 where there is none
    torque: float  # N m, of the drive; 0 where there is none


class GapAcceleration(NamedTuple):
    """How the rates of a Gap change."""

    ax: float  # m/s^2
    ay: float
    proximal: float  # rad/s^2
    distal: float


@family
def place(mechanism, y):
    """Return the pose, a NamedTuple of the mechanism's own, at the state `y`: coordinates, their rates, time."""


@family
def gaps(mechanism, pose):
    """Return one Gap per open joint, in the order of the sites."""


@family
def accelerate(mechanism, pose, loads):
    """Return the Motion under the joint loads `loads`, one Load per open joint."""


@family
def impact_masses(mechanism, pose, relative):
    """Return, for each open joint, the mass (kg) that takes part in an impact along its Gap of `relative`.

    1 / (n^T J M^-1 J^T n), n being the unit vector along the gap, M the whole mass matrix and J the gap's derivatives
    by the coordinates: force over relative acceleration.
    """


@family
def energy(mechanism, pose):
    """Return the kinetic energy (J) and the power (W) of gravity and of loads that depend on the pose alone."""


@family
def body_angles(mechanism, y):
    """Return the angles (rad) of the proximal and the distal body of every open joint at the state `y`.

    Of a joint in space it is its bearing's own x axis, a Vector in the frame of the journal.
    """


@family
def crank_rate(mechanism, pose, nominal):
    """Return the rate (rad/s) at which the drive's torque does work; `nominal` where that is constant."""


@crank_rate.member(None)
def _default_crank_rate(mechanism, pose, nominal):
    return nominal


@family
def load_power(mechanism, motion):
    """Return the power (W) of loads that depend on the Motion, such as friction in joints without clearance."""


@load_power.member(None)
def _default_load_power(mechanism, motion):
    return 0.0


@family
def friction_loads(mechanism):
    """Return how many loads of a mechanism are friction in joints without clearance, or of a given size."""


@friction_loads.member(None)
def _default_friction_loads(mechanism):
    return 0


@family
def friction_powers(mechanism, motion):
    """Return the power (W) of each of these loads for a Motion, below 0 where it takes energy."""


@friction_powers.member(None)
def _default_friction_powers(mechanism, motion):
    return ()


@family
def output_error(mechanism, pose):
    """Return how far the output is from its place in the ideal mechanism, in its unit, and the rate of that."""


@family
def describe(mechanism, y, pose, motion, out):
    """Put the time histories of the bodies into `out`, in the order of their channels; return how many there are."""


@inlined
def gap_accelerations(mechanism, y, motion):
    """Return one GapAcceleration per open joint: the slopes in time of the rates that `gaps` gives."""
    relative = gaps(mechanism, place(mechanism, Moving(y, motion.accelerations)))
    return _slopes(relative, relative, 0, 0)


@kernel
def _slope(gap, _, place, shared):
    """Return the GapAcceleration of a Gap of Duals; all its numbers have one type, whatever those of the Gap."""
    ax = slope(gap.vx)
    return GapAcceleration(
        ax,
        as_type_of(slope(gap.vy), ax),
        as_type_of(slope(gap.spin_proximal), ax),
        as_type_of(slope(gap.spin_distal), ax),
    )


_slopes = map_joints(_slope, after_number)


def at_open(sites, values):
    """Return those of `values`, a tuple with one for each of `sites`, that belong to open joints."""
    return tuple(item for site, item in zip(sites, values, strict=True) if isinstance(site, Open))
