"""The window of a run: the argument of all formulas for figures."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import Case
from ...contracts.catalogue import Mechanism
from ...contracts.layout import WALLS, JointLayout, Layout
from ...mechanics.joints import dry
from ...mechanics.solver.accumulate.totals import ContactTotals, Largest, Resultant, Totals
from ...mechanics.solver.integration import Counts
from ...mechanics.wear import ARC_TIME, MAX_BINS, PRESSURE_MAX, PRESSURE_TIME, PV_BEYOND, PV_MAX, SLIDING_DISTANCE
from .spread import Repetition, Spread

RARE_SHARE = 0.01  # of the window's time, for which the force figure is exceeded
DRY_FORCE_THRESHOLD = 1e-3  # of a joint's mean load: a smaller dry force does not count
SEAM_BINS = 4  # bins repeated beyond the seam of the circle


class JointTotals(ContactTotals):
    """Figures of the window for a joint; the fields added here are those of a guide or a spatial joint."""

    corner_force_max: float  # N, at a guide's corner
    corner_force_square: float  # N^2 s, the largest of a guide's corners
    axial_force_max: float  # N, at a flange
    axial_onsets: float  # number of onsets at the flanges
    uneven_time: float  # N s, of the difference between the walls
    tilt_max: float  # rad


class Summed(NamedTuple):
    """Sums and maxima of one integration by joint: a Totals without histograms and scratch arrays."""

    mechanism: Any  # MechanismTotals.VALUES
    joint: list[Any]  # ContactTotals.VALUES by joint, JointTotals.VALUES where a joint has several contacts
    wear: np.ndarray
    account: np.ndarray
    friction: list[float]  # J, by joint without clearance that has friction


def summed_of(totals: Totals) -> Summed:
    """Return a copy of the sums by joint."""
    return Summed(
        totals.mechanism.values(),
        totals.joint.values(),
        totals.wear.copy(),
        totals.account.copy(),
        totals.friction.tolist(),
    )


class Cost(NamedTuple):
    """Work of one or more integrations: the fields of a Window from which the work counts of a case are computed."""

    counts: Counts
    integration_time: float  # s

    def plus(self, other_cost: "Cost") -> "Cost":
        """Return the sum of two costs."""
        return Cost(
            Counts(self.counts.numbers + other_cost.counts.numbers), self.integration_time + other_cost.integration_time
        )


NO_COST = Cost(Counts.zeros(), 0.0)


class Window(NamedTuple):
    """Results of a run after `discard`; figures are functions of a Window and a joint's index."""

    case: Case
    mechanism: Mechanism
    layout: Layout
    joints: tuple[dry.Joint, ...]
    totals: Summed
    exceeded_force: list[float]  # N, by joint: normal force exceeded for the share RARE_SHARE of the time
    dry_time: list[
        float
    ]  # s, by joint: time with a dry force above DRY_FORCE_THRESHOLD of its mean load; 0 without a film
    ideal: Mapping[str, float]  # N, largest reaction of each joint without clearance
    wear: dict[str, tuple[np.ndarray, np.ndarray]]  # m, see `wear_depths_of`
    counts: Counts  # of the whole integration
    events: int  # of the motion itself
    integration_time: float  # s, integration time
    duration: float  # s
    turns: float  # revolutions; 1 where nothing turns
    spreads: tuple[Spread, ...]  # of each joint's force peaks over the revolutions
    repetition: Repetition | None  # of a periodic motion
    sliding_distance: list[float]  # (joints,) m, sliding distance before the run
    onset_rate: list[float]  # (joints,) m/s, onset rate in the law at the end; nan: none


def by_joint(totals: Totals, layout: Layout) -> Totals:
    """Return the sums by joint from those by contact: a guide combines its corners, a spatial joint its walls.

    The work of a preload counts as friction of its joint and as heat; `friction` is by joint without clearance.

    Counts and energies are added; of depths and of times in contact, the largest counts.  Forces are those of the
    resultant of the contacts.
    """
    if layout.frictions:
        totals = _with_friction(totals, layout)
    if not any(joint.corners for joint in layout.joints):
        return totals
    rows, resultants = contact_slices(layout), force_contacts(layout)
    pairs = zip(rows, layout.joints, strict=True)
    joints = JointTotals(np.array([_combined_totals(totals.joint[row], joint).numbers for row, joint in pairs]))
    account = np.array([combined_account(totals.account[row], totals.joint[row]) for row in rows])
    wear = totals.wear.reshape(len(totals.joint), -1)[[row.start for row in rows]].ravel()
    histogram, bins = totals.histogram[resultants], totals.bins[resultants]
    dry = totals.dry[[row.start for row in rows]] if len(totals.dry) else totals.dry
    return totals._replace(joint=joints, histogram=histogram, dry=dry, bins=bins, account=account, wear=wear)


def _with_friction(totals: Totals, layout: Layout) -> Totals:
    """Return the sums with the work of friction loads assigned to their joints."""
    joint, work = totals.joint.copy(), dict.fromkeys(layout.rubbing, 0.0)
    clearance_joints = {
        joint_layout.name: (row, joint_layout)
        for row, joint_layout in zip(contact_slices(layout), layout.joints, strict=True)
    }
    for name, friction_work in zip(layout.frictions, totals.friction, strict=True):
        if name in clearance_joints:
            row, _ = clearance_joints[name]
            joint[row.start].friction_energy += friction_work
            joint[row.start].heat += friction_work
        else:
            work[name] += friction_work
    return totals._replace(joint=joint, friction=np.array(list(work.values())))


def contact_slices(layout: Layout) -> list[slice]:
    """Return the indices of the contacts of each joint among all contacts."""
    ends = np.cumsum([len(joint.contacts) for joint in layout.joints])
    return [slice(end - len(joint.contacts), end) for end, joint in zip(ends, layout.joints, strict=True)]


def force_contacts(layout: Layout) -> list[int]:
    """Return the contact of each joint whose normal force is that of the joint: the resultant of several contacts."""
    pairs = zip(contact_slices(layout), layout.joints, strict=True)
    return [contacts.start + joint.corners for contacts, joint in pairs]


def _combined_totals(contacts: ContactTotals, joint: JointLayout) -> JointTotals:
    """Return the sums of a joint from those of its contacts, (contacts,)."""
    combined = JointTotals.zeros()
    points = contacts[: max(joint.corners, 1)]
    walls = points[:WALLS] if joint.is_spatial else points
    combined.numbers[: ContactTotals.SIZE] = walls.numbers.sum(axis=0)
    for name, kind in ContactTotals.DECLARED.items():
        if kind is Largest:
            setattr(combined, name, walls.column(name).max())
        elif kind is Resultant and joint.corners:
            setattr(combined, name, getattr(contacts[joint.corners], name))
    if joint.is_guide:
        combined.corner_force_max = points.column("force_max").max()
        combined.corner_force_square = points.column("force_square").max()
    if joint.is_spatial:
        flanges, wall_difference = contacts[WALLS : joint.corners], contacts[-1]
        combined.clips, combined.friction_energy = points.column("clips").sum(), points.column("friction_energy").sum()
        combined.axial_force_max = flanges.column("force_max").max(initial=0.0)
        combined.axial_onsets = flanges.column("onsets").sum()
        combined.uneven_time, combined.tilt_max = (
            wall_difference.force_time,
            math.asin(min(wall_difference.depth_max, 1.0)),
        )
    return combined


def combined_account(accounts: np.ndarray, contacts: ContactTotals) -> np.ndarray:
    """Return the wear account of a joint, (ACCOUNT_SIZE,), from those of its contacts, (contacts, ACCOUNT_SIZE).

    Maxima and the time beyond the limit are those of one contact; the mean pressure is an average over the times
    in contact of all.  contacts : sums of the contacts.
    """
    combined: np.ndarray = accounts.sum(axis=0)
    for column in (PRESSURE_MAX, PV_MAX, PV_BEYOND, SLIDING_DISTANCE):
        combined[column] = accounts[:, column].max()
    time = contacts.column("contact_time")[accounts[:, ARC_TIME] > 0.0]
    if time.size:
        combined[PRESSURE_TIME] *= time.max() / time.sum()
    return combined


def interpolated_depths(depths: np.ndarray, bins: int) -> np.ndarray:
    """Return means over `bins` bins that preserve given means over fewer bins: (bins,) m from (coarse_bins,) m.

    Depths may have a further axis: (bins, rows) m from (coarse_bins, rows) m.

    Cumulative wear over the angle is interpolated between bin edges by a monotone cubic (Fritsch & Butland
    1984, SIAM J. Sci. Stat. Comput. 5:300), so no bin is negative.
    """
    from scipy.interpolate import PchipInterpolator

    periodic, coarse_bins = np.concatenate([depths[-SEAM_BINS:], depths, depths[:SEAM_BINS]]), len(depths)
    edges = np.arange(-SEAM_BINS, coarse_bins + SEAM_BINS + 1) / coarse_bins
    cumulative_wear = PchipInterpolator(
        edges, np.concatenate([periodic[:1] * 0.0, np.cumsum(periodic, axis=0)]) / coarse_bins
    )
    depths_by_bin: np.ndarray = np.maximum(np.diff(cumulative_wear(np.arange(bins + 1) / bins), axis=0) * bins, 0.0)
    return depths_by_bin


def wear_depths_of(layout: Layout, totals: Totals | Summed) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the wear depths (m) of bearing and journal by bin, for every joint with wear; totals : by joint.

    For a spatial joint they are over angle and length, (bins, rows).
    """
    wear: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    if not any(joint.wear_bins for joint in layout.joints):
        return wear
    for joint, depths in zip(layout.joints, totals.wear.reshape(len(layout.joints), 2, -1), strict=True):
        bins = joint.wear_bins
        if bins:
            computed_bins, rows = min(bins, MAX_BINS), joint.wear_rows
            bearing, journal = depths[:, : computed_bins * rows].reshape(2, rows, computed_bins).swapaxes(1, 2).copy()
            if not joint.is_spatial:
                bearing, journal = bearing[:, 0], journal[:, 0]
            wear[joint.name] = (
                (bearing, journal)
                if bins <= MAX_BINS
                else (interpolated_depths(bearing, bins), interpolated_depths(journal, bins))
            )
    return wear
