"""The interface of wear laws and contact pressures.

A wear law is a member of `wear_rate` and has the fields `bins` (of each body), `length` (m, along the pin), `pv_limit`
(W/m^2, inf for none) and `pressure`, a member of `half_arc`, `cumulative_pressure`, `smooth_range`,
`pressure_integral_over_load` and `peak_over_mean`.
"""

import math
from typing import NamedTuple

import numpy as np

from ...tracing.compiled.family import family, family_with_default
from ...tracing.memory import Fields
from ..laws.contract import require
from ..observe import Largest

#: Largest number of bins in the sums; finer bins are interpolated from these, see `simulation.figures.window`.
MAX_BINS = 720
RESOLVED_WIDTH = 5.0  # bins: a narrower arc counts as unresolved
CLASSES = 48  # of the widths of arcs


class Account(Fields):
    """Sums and maxima of the wear of a contact.

    The volume per length (m^2) removed from both bodies by arcs of each of the CLASSES of width follows; from class to
    class the width decreases by a factor of root two.
    """

    arc_time: float  # s, with wear
    narrow_time: float  # s, of it with a narrow arc
    sliding_distance: Largest  # m, in contact
    pressure_max: Largest  # Pa
    pressure_time: float  # Pa s, integral of the arc's mean pressure
    pv_max: Largest  # W/m^2, largest pressure times sliding speed
    pv_beyond: Largest  # s, above its limit


ACCOUNT_SIZE = Account.SIZE + CLASSES


class Worn(NamedTuple):
    """Wear of the bodies of a joint before a run."""

    bearing: np.ndarray  # (bins,) m, mean depth of each bin, in the frame of its body
    journal: np.ndarray  # (bins,) m
    sliding_distance: float = 0.0  # m, sliding distance in contact


class Bins(NamedTuple):
    """Bins of a body, to which its wear is added."""

    depths: np.ndarray  # (joints, 2, stride) m, mean depth of each bin, flat
    start: int
    count: int


class JointAccount(NamedTuple):
    """The account of a joint's wear, to which spans of steps are added."""

    sums: Account
    length_fraction: float  # fraction of the joint's length that wears


class SlidingContact(NamedTuple):
    """Load and sliding of a contact at one time."""

    line_load: float  # N/m
    depth: float  # m, penetration
    sliding_speed: float  # m/s, at least 0
    friction_power: float  # W/m, dissipated by friction, at least 0
    sliding_distance: float  # m, sliding distance in contact so far
    pressure_integral: float  # N/m, integral of the scalar pressure over the arc
    clearance: float  # m, difference of the radii of curvature of both surfaces where they touch
    half_angle: float  # rad, half the contact arc on the bearing


@family_with_default
def contact_angle(joint, gap):
    """Return the contact angle (rad) of a joint, its rate (rad/s), the depth (m) and its rate (m/s).

    Depth and its rate are used for worn surfaces only.
    """
    rate = (gap.x * gap.vy - gap.y * gap.vx) / (gap.x * gap.x + gap.y * gap.y)
    return math.atan2(joint.side * gap.y, joint.side * gap.x), rate, 0.0, 0.0


@family_with_default
def local_clearance(joint, bearing_angle, journal_angle):
    """Return the difference (m) of the radii of curvature of the surfaces at the contact; angles : rad, body frames."""
    return joint.clearance


@family
def update_wear_over_span(joint, workspace, step_length, span, bins):
    """Add the wear of bearing and journal between two fractions of a step of `step_length` (s over kappa).

    Write the rows of the workspace that `account_span` reads: those of the span, `area` of both bodies, `half` of the
    bearing.
    """


@family
def arc_width(joint, workspace, i):
    """Return the width (rad) of the arc on the bearing at node `i` of a span of a step."""


@family
def wear_rate(law, sliding):
    """Return the rates (m^2/s) at which a SlidingContact removes cross-section from bearing and journal."""


@family
def half_arc(pressure, joint, radius, sliding):
    """Return half the angle (rad) of the contact arc of a SlidingContact, on the body of `radius` (m)."""


@family
def cumulative_pressure(pressure, x, half_angle):
    """Return the fraction of the load before `x` (-1 to 1) on an arc of half-angle `half_angle` (rad)."""


@family
def smooth_range(pressure):
    """Return the largest |x| up to which `cumulative_pressure` is smooth enough for quadrature with few points."""


@family
def pressure_integral_over_load(pressure, half_angle):
    """Return the integral of the scalar pressure over an arc of half-angle `half_angle` (rad), divided by the load."""


@family
def peak_over_mean(pressure, half_angle):
    """Return the largest over the mean pressure on an arc of half-angle `half_angle` (rad)."""


require("wear", wear_rate)
require("pressure", half_arc, cumulative_pressure, smooth_range, pressure_integral_over_load, peak_over_mean)


class NoWear(NamedTuple):
    """No wear, and no computation."""


def class_width(index):
    """Return the least width (rad) of an arc of class `index`."""
    return 2.0 * math.pi * 2.0 ** (-0.5 * (index + 1))
