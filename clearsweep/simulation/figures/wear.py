"""Figures of wear and lives."""

import math
from functools import partial
from typing import Any

import numpy as np

from ...contracts.catalogue import Entry, figure, shown
from ...mechanics.joints.mesh import Mesh, worn_volume
from ...mechanics.joints.spatial import SPATIAL_JOINT_TYPES as SPATIAL
from ...mechanics.wear import RESOLVED_WIDTH, Account, class_width
from .sums import DepthRate
from .window import Window

# Figures of merit of joints with wear.

RESOLVED_SHARE = 0.95  # of the worn volume: share that must come from arcs wide enough for the bins


def depths_of(window: Window, index: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the wear depths (m) of the bearing and the journal of a joint, by bin."""
    return window.wear[window.layout.joints[index].name]


def volume(window: Window, index: int) -> float:
    """Return the volume (m^3) worn off both bodies of a joint."""
    joint, (bearing, journal) = window.joints[index], depths_of(window, index)
    if isinstance(joint, Mesh):
        return worn_volume(joint, bearing, journal)
    law: Any = joint.wear  # mypy takes it for a tuple of anything
    bin_area, (on_bearing, on_journal) = 2.0 * math.pi / len(bearing) * law.length, (1.0, 1.0)
    if type(joint) in SPATIAL:
        each: Any = joint  # arc lengths of a bin, relative to the bearing
        on_bearing, on_journal = 1.0 / each.wear_rows, each.journal_half_length / (each.half_length * each.wear_rows)
    round_journal = joint.journal_radius * journal.sum() * on_journal
    return float(bin_area * (joint.bearing_radius * bearing.sum() * on_bearing + round_journal))


def narrow_arcs(window: Window, index: int) -> float:
    """Return the share of the time in contact in which the arc was narrower than five bins."""
    account = Account(window.totals.account[index])
    return float(account.narrow_time / account.arc_time) if account.arc_time else 0.0


def sufficient_bins(window: Window, index: int) -> int:
    """Return how many bins resolve 95 % of the worn volume by arcs of at least five bins; 0 without wear.

    Within a class the volume is taken as even over the logarithm of the width.
    """
    by_width = window.totals.account[index, Account.SIZE :]
    if not by_width.any():
        return 0
    resolved = RESOLVED_SHARE * by_width.sum()
    narrowest = int(np.searchsorted(np.cumsum(by_width), resolved))
    fraction = (resolved - by_width[:narrowest].sum()) / by_width[narrowest]
    return int(np.ceil(RESOLVED_WIDTH * 2.0 * math.pi / class_width(narrowest - 1.0 + fraction)))


def pressure_mean(window: Window, index: int) -> float:
    """Return the mean pressure (Pa) over the contact arc and the time in contact, 0 without contact."""
    time = window.totals.joint[index].contact_time
    return float(Account(window.totals.account[index]).pressure_time / time) if time else 0.0


def pv_mean(window: Window, index: int) -> float:
    """Return the mean normal force over diameter and length (Pa) times the mean sliding speed (m/s), W/m^2."""
    case = window.case.joints[index]
    force = window.totals.joint[index].force_time / window.duration
    speed = (Account(window.totals.account[index]).sliding_distance - window.sliding_distance[index]) / window.duration
    assert case.length is not None  # joints with wear have both
    assert case.bearing_radius is not None
    return float(force / (2.0 * case.bearing_radius * case.length) * speed)


def pv_beyond(window: Window, index: int) -> float | None:
    """Return the share of the window's time beyond the limit of pressure times speed, or None."""
    law: Any = window.joints[index].wear
    return (
        None if math.isinf(law.pv_limit) else float(Account(window.totals.account[index]).pv_beyond / window.duration)
    )


of_joint = partial(figure, of="joint")
of_wear = partial(of_joint, needs=("wear",))
of_arc = partial(of_joint, needs=("wear", "arc"))
WEAR = (
    of_wear(
        "wear_depth_max [m]: largest wear depth in the window, of both bodies",
        value=lambda window, index: max(map(np.max, depths_of(window, index))),
        tables=shown("depth", wear=50) + shown("wear depth", sample=5, effects=4),
    ),
    of_wear(
        "wear_rate_max [m/s]: largest wear depth over the window's time",
        sums=DepthRate(),
        tables=shown("depth rate", wear=50),
    ),
    of_wear(
        "wear_volume [m^3]: worn volume of both bodies in the window",
        value=volume,
        tables=(Entry("wear", "volume"), Entry("sample", "wear volume", 6)),
    ),
    of_arc(
        "wear_narrow_arcs [1]: share of the time in contact in which the arc is narrower than five wear bins",
        value=narrow_arcs,
        tables=shown("narrow arcs", wear=70),
    ),
    of_arc(
        "wear_bins_enough [1]: smallest number of bins with which arcs of at least five bins cause 95 % of the worn "
        "volume; 0: no wear",
        kind="int",
        value=sufficient_bins,
        differs=False,
        tables=shown("bins enough", wear=71),
    ),
    of_arc(
        "pressure_peak [Pa]: largest pressure on the bearing, anywhere on the contact arc",
        value=lambda window, index: Account(window.totals.account[index]).pressure_max,
        tables=shown("pressure peak", wear=55),
    ),
    of_arc(
        "pressure_mean [Pa]: mean pressure on the bearing, over the contact arc and the time in contact",
        value=pressure_mean,
        tables=shown("pressure mean", wear=56),
    ),
    of_arc(
        "pv_peak [W/m^2]: largest product of the pressure on the bearing, anywhere on the contact arc, and the "
        "sliding speed",
        value=lambda window, index: Account(window.totals.account[index]).pv_max,
        tables=shown("pV peak", wear=57),
    ),
    of_arc(
        "pv_mean [W/m^2]: mean normal force over diameter times length, times mean sliding speed, as in catalogues of "
        "bushes",
        value=pv_mean,
        tables=shown("pV mean", wear=57),
    ),
    of_arc(
        "pv_limit_fraction [1]: share of the window's time at a pressure times speed beyond `wear.pv_limit`; null: no "
        "limit is given",
        value=pv_beyond,
        tables=shown("time past pv_limit", wear=58, if_any=True),
    ),
)


# Figures of merit of a life; `life` computes them under these names.

of_life = partial(of_joint, needs=("limited",), differs=False)
of_uncertain = partial(of_life, needs=("limited", "uncertain"))
LIFE = (
    of_life(
        "life_revolutions [1]: revolutions until `life.limit` is reached; infinite: no wear; null: not reached, so "
        "longer than `J_life_low`",
        tables=shown("life (rev.)", wear=1, sample=7) + shown("life", effects=3),
    ),
    of_life(
        "life_hours [h]: hours until `life.limit` is reached; infinite: no wear; null: not reached, so longer than "
        "`J_life_low_hours`",
        tables=shown("life (hours)", wear=2),
    ),
    of_life(
        "life_low [1]: lower end of the 95 % interval of the life (numerics only), revolutions; without reaching the "
        "limit: the revolutions run; infinite: no wear",
        tables=shown("life, low (rev.)", wear=3),
    ),
    of_life("life_low_hours [h]: lower end of the same interval, hours; without reaching the limit: the hours run"),
    of_life(
        "life_high [1]: upper end of the same interval, revolutions; infinite: no wear; null: unknown",
        tables=shown("life, high (rev.)", wear=4),
    ),
    of_uncertain(
        "life_low_uncertain [1]: revolutions of the life with the uncertain wear coefficients at the upper ends of "
        "their 95 % intervals; infinite: no wear; null: that life did not reach the limit or failed (see `message`)",
        tables=shown("life, low, uncertain (rev.)", wear=4),
    ),
    of_uncertain(
        "life_high_uncertain [1]: life with the uncertain wear coefficients at the lower ends of their 95 % "
        "intervals; null as above",
        tables=shown("life, high, uncertain (rev.)", wear=4),
    ),
    of_life(
        "life_jump_error [1]: relative change of the life with jumps twice as long (every other block); null: not "
        "reached",
        tables=shown("error of jumps", wear=72),
    ),
    of_life("life_blocks [1]: blocks of revolutions of the life", kind="int", tables=shown("blocks", wear=73)),
    of_life(
        "life_shape_error [1]: relative change of the life by smoothing the worn shapes and by bins twice as wide; 0 "
        "without `evolve`; null: not reached",
        tables=shown("error of shapes", wear=74, if_any=True),
    ),
    of_joint(
        "clearance_growth [m]: largest increase, over directions, of the eccentricity at which the surfaces touch "
        "first, at the life's end",
        needs=("wear", "life"),
        differs=False,
        tables=shown("clearance growth", wear=5),
    ),
)
