"""The stretch of a run over which figures are taken: all that their formulas are functions of."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..case import Case
from ..catalogue import Mechanism
from ..layout import Layout
from ..mechanics.joint import dry
from ..mechanics.joint.wear.contract import FINEST
from ..mechanics.observe.tally import (
    APPROACH,
    BEYOND_TIME,
    CONTACT_TIME,
    DEPTH_MAX,
    FORCE_MAX,
    LOAD_MAX,
    ONSET_MAX,
    PEAK,
    Tally,
)
from .spread import Spread

LARGEST = (CONTACT_TIME, BEYOND_TIME, FORCE_MAX, LOAD_MAX, DEPTH_MAX, ONSET_MAX, PEAK, APPROACH)  # of Tally.joint
FEW = 4  # bins taken from beyond the seam, where a turn begins anew


class Window(NamedTuple):
    """What a run came to after `discard`: what formulas of figures are functions of, with a joint's place."""

    case: Case
    mechanism: Mechanism
    layout: Layout
    joints: tuple[dry.Joint, ...]
    tally: Tally
    wear: dict[str, tuple[np.ndarray, np.ndarray]]  # m, see `wear_of`
    counts: np.ndarray  # see solver.event, of all that was integrated
    seconds: float  # s, that integrating took
    duration: float  # s
    turns: float  # revolutions; 1 where nothing turns
    spreads: tuple[Spread, ...]  # of each joint's force peaks over the revolutions
    period: int | None  # revolutions after which the motion repeats itself; None: it was not seen to
    onset: np.ndarray  # (joints,) m/s, onset rate that its law goes by at the end; nan: none


def by_joint(tally: Tally, layout: Layout) -> Tally:
    """Return what was summed up contact by contact as joint by joint: of a guide what its corners come to together.

    Counts, squares and histograms are added; of what is largest, and of times in contact, the largest counts.
    """
    if not any(joint.corners for joint in layout.joints):
        return tally
    ends = np.cumsum([len(joint.contacts) for joint in layout.joints])
    rows = [slice(end - len(joint.contacts), end) for end, joint in zip(ends, layout.joints, strict=True)]
    joints = np.array([tally.joint[row].sum(axis=0) for row in rows])
    for column in LARGEST:
        joints[:, column] = [tally.joint[row, column].max() for row in rows]
    time, ramp = (np.array([part[row].sum(axis=0) for row in rows]) for part in (tally.time, tally.ramp))
    return tally._replace(joint=joints, time=time, ramp=ramp)


def finer(depths: np.ndarray, bins: int) -> np.ndarray:
    """Return the means over `bins` bins that follow from those over fewer, which they keep: (bins,) m from (n,) m.

    What is worn up to an angle is interpolated between the edges of the n bins by a monotone cubic (Fritsch & Butland
    1984, SIAM J. Sci. Stat. Comput. 5:300), so that no bin is negative.
    """
    turn, n = np.concatenate([depths[-FEW:], depths, depths[:FEW]]), len(depths)
    edges = np.arange(-FEW, n + FEW + 1) / n
    worn = PchipInterpolator(edges, np.concatenate([[0.0], np.cumsum(turn)]) / n)
    finest: np.ndarray = np.maximum(np.diff(worn(np.arange(bins + 1) / bins)) * bins, 0.0)
    return finest


def wear_of(layout: Layout, tally: Tally) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the wear depths (m) of bearing and journal by bin, of every joint where there is wear."""
    found = {}
    for joint, depths in zip(layout.joints, tally.wear.reshape(len(layout.joints), 2, -1), strict=True):
        bins = joint.wear_bins
        if bins:
            bearing, journal = depths[:, : min(bins, FINEST)].copy()
            found[joint.name] = (bearing, journal) if bins <= FINEST else (finer(bearing, bins), finer(journal, bins))
    return found
