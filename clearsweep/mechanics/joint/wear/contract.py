"""What a wear law and the pressure it acts on declare.

A wear law is a member of `wear_rate` and has the fields `bins` (of each body), `length` (m, along the pin), `pv_limit`
(W/m^2, inf for none) and `pressure`, a member of `half_arc`, `share_before`, `smooth_within`, `sum_over_load` and
`peak_over_mean`.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.family import family, kernel

#: Bins that wear is summed up in, at most: finer ones are interpolated from these, see `clearsweep.simulation.window`.
FINEST = 720
WIDE = 5.0  # bins: an arc narrower than this is not resolved, and counted
#: Columns of the account of a joint's wear: steps with wear, those with a narrow arc; the way slid in contact (m), the
#: largest pressure (Pa), the integral of the arc's mean pressure over time (Pa s), the largest pressure times sliding
#: speed (W/m^2), how long that is beyond its limit (s); then the volume per length (m^2) that arcs of each class of
#: width wear off both bodies; from class to class the width falls by a factor of root two.
ARCS, NARROW, SLID, PRESSURE_MAX, PRESSURE_TIME, PV_MAX, PV_BEYOND, FIRST_CLASS = range(8)
CLASSES = 48
ACCOUNT = FIRST_CLASS + CLASSES


class Worn(NamedTuple):
    """What the bodies of a joint have lost before a run."""

    bearing: np.ndarray  # (bins,) m, mean depth of each bin, in the frame of its body
    journal: np.ndarray  # (bins,) m
    slid: float = 0.0  # m, the way slid in contact


class Bins(NamedTuple):
    """Where the wear of a body is entered."""

    depths: np.ndarray  # (joints, 2, stride) m, mean depth of each bin, flat
    first: int
    count: int


class Rubbing(NamedTuple):
    """What presses while it slides."""

    line_load: float  # N/m
    depth: float  # m, penetration
    slip: float  # m/s, at least 0
    work: float  # W/m, that friction dissipates, at least 0
    slid: float  # m, the way slid in contact so far
    pressed: float  # N/m, the pressure summed up over the arc, whatever its direction
    clearance: float  # m, difference of the radii of curvature of both surfaces where they touch


@family
def contact_angle(joint, gap):
    """Return the angle (rad) at which the surfaces of a joint touch, its rate (rad/s), and how deep (m) and its rate.

    The depth is asked for of worn surfaces alone.
    """


@contact_angle.member(None)
def _default_contact_angle(joint, gap):
    rate = (gap.x * gap.vy - gap.y * gap.vx) / (gap.x * gap.x + gap.y * gap.y)
    return math.atan2(joint.side * gap.y, joint.side * gap.x), rate, 0.0, 0.0


@family
def local_clearance(joint, on_bearing, on_journal):
    """Return by how much (m) the radii of curvature of the surfaces differ where they touch, rad in their frames."""


@local_clearance.member(None)
def _default_local_clearance(joint, on_bearing, on_journal):
    return joint.clearance


@family
def pressure_on(joint, step, j, place):
    """Return the mean and the largest pressure (Pa) on the bearing of joint `j` at one of the even places of a Step."""


@family
def enter_span(joint, workspace, length, span, bins):
    """Enter what bearing and journal lose between two shares of a step of this length, in the unit of kappa."""


@family
def middle_arc(joint, workspace):
    """Return how wide (rad) the arc is in the middle of a step, and the Rubbing on it."""


@family
def wear_rate(law, rubbing):
    """Return the area (m^2/s) that a Rubbing wears off the cross-sections of bearing and journal."""


@family
def half_arc(pressure, joint, radius, rubbing):
    """Return half the angle (rad) of the contact arc of a Rubbing, on the body of `radius` (m)."""


@family
def share_before(pressure, x, half):
    """Return the share of the pressure before `x` of the arc, whose ends are -1 and 1, of `half` its angle (rad)."""


@family
def smooth_within(pressure):
    """Return up to which x, on both sides of the arc's middle, `share_before` is smooth enough for a few points."""


@family
def sum_over_load(pressure, half):
    """Return the pressure summed up over an arc of `half` its angle (rad), whatever its direction, over the load."""


@family
def peak_over_mean(pressure, half):
    """Return the largest pressure on an arc of `half` its angle (rad) over the mean one."""


PRESSURE_FAMILIES = (
    half_arc,
    share_before,
    smooth_within,
    sum_over_load,
    peak_over_mean,
)  # a type of pressure is a member of each
WEAR_FAMILIES = (wear_rate,)


class NoWear(NamedTuple):
    """Nothing is worn and nothing computed."""


@kernel
def width_class(width):
    """Return the class of an arc of `width` (rad), 0 for the widest: column of the account less FIRST_CLASS."""
    return min(max(int(2.0 * math.log2(2.0 * math.pi / max(width, 1e-300))), 0), CLASSES - 1)


def class_width(place):
    """Return the least width (rad) of an arc of class `place`."""
    return 2.0 * math.pi * 2.0 ** (-0.5 * (place + 1))
