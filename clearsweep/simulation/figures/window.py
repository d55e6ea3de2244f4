"""The window of a run: the argument of all formulas for figures."""

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...answers.judged import binomial_distribution
from ...contracts.case import Case
from ...contracts.catalogue import Mechanism
from ...contracts.layout import WALLS, JointLayout, Layout
from ...mechanics.joints import dry
from ...mechanics.observe import Largest, Resultant
from ...mechanics.solver.integration import Counts
from ...mechanics.solver.totals import ContactTotals, Totals
from ...mechanics.wear import MAX_BINS, Account
from ...tracing import portable

# Quantiles of a value per revolution, and their intervals.

CONFIDENCE = 0.95
MAX_CORRELATION = 0.9  # largest correlation of neighbours in the correction
TAIL_PROBABILITY = 0.5 * (1.0 - CONFIDENCE)  # probability beyond either end of an interval


class Quantile(NamedTuple):
    """A quantile of a value per revolution, and its 95 % interval; values are None for too few revolutions."""

    value: float | None
    low: float | None
    high: float | None


class Spread(NamedTuple):
    """Distribution of a joint's force peaks (N) over the window's revolutions."""

    median: Quantile
    p95: Quantile
    of_million: Quantile = Quantile(None, None, None)  # the largest of 10^6 revolutions
    highest: tuple[float, int] | None = None  # N, and its revolution in the run, counted from 1


class Repetition(NamedTuple):
    """A motion that repeats itself at the end of a window."""

    period: int  # revolutions
    begin: float  # revolutions since the start of the run, from which it repeats itself


def quantiles(values: np.ndarray, probabilities: tuple[float, ...]) -> tuple[Quantile, ...]:
    """Return quantiles (linear interpolation) of successive values, with their intervals.

    Intervals are between order statistics (David & Nagaraja 2003, Order Statistics, 7.1).  If neighbours correlate
    (lag 1, r if positive) the number of independent values is (1 - r) / (1 + r) of all, as for a first-order
    autoregressive process.
    """
    if not len(values):
        return (Quantile(None, None, None),) * len(probabilities)
    ordered = sorted(values.tolist())
    independent = max(round(len(values) / variance_inflation(values)), 1)
    return tuple([_quantile(ordered, independent, probability) for probability in probabilities])


def _quantile(ordered: list[float], independent: int, probability: float) -> Quantile:
    """Return a quantile of sorted values, of which the number `independent` are independent."""
    count = len(ordered)
    rank = probability * (count - 1)
    lower = min(int(rank), count - 1)
    value = ordered[lower] + (rank - lower) * (ordered[min(lower + 1, count - 1)] - ordered[lower])
    low, high = _enclosing_ranks(independent, probability)
    lower_end = None if low is None else ordered[low * count // independent]
    upper_end = None if high is None else ordered[min(-(-(high + 1) * count // independent), count) - 1]
    return Quantile(value, lower_end, upper_end)


def variance_inflation(values: np.ndarray) -> float:
    """Return the number of successive values that count as one independent value, from their lag-1 correlation."""
    return inflation_of(lag_correlation(values))


def lag_correlation(values: np.ndarray) -> float:
    """Return the correlation of successive values with their neighbours; 0 for fewer than three or equal ones."""
    if len(values) < 3:
        return 0.0  # two values lie on either side of their mean
    deviations = values - np.add.reduce(values) / len(values)
    squares = float(portable.product(deviations, deviations))
    return float(portable.product(deviations[1:], deviations[:-1])) / squares if squares > 0.0 else 0.0


def inflation_of(correlation: float) -> float:
    """Return (1 + r) / (1 - r) for a correlation r of neighbours, which counts up to MAX_CORRELATION if positive."""
    counted = min(max(correlation, 0.0), MAX_CORRELATION)
    return (1.0 + counted) / (1.0 - counted)


@lru_cache(1024)
def _enclosing_ranks(count: int, probability: float) -> tuple[int | None, int | None]:
    """Return the ranks, from 0, that enclose a quantile, or None for too few values."""
    cumulative = binomial_distribution(count, probability)[:-1]  # of at most 0, 1, ... values below
    low = int(np.searchsorted(cumulative, TAIL_PROBABILITY, side="right")) - 1
    high = int(np.searchsorted(cumulative, 1.0 - TAIL_PROBABILITY))
    return (low if low >= 0 else None), (high if high < count else None)


# Largest value to expect in many revolutions, from the values of some: extreme-value statistics of peaks.
#
# Values above a threshold are modelled by a generalised Pareto distribution (Coles 2001, An Introduction to
# Statistical Modeling of Extreme Values, 4.2-4.3).  All its shapes and scales count by their likelihood, and their
# predictions of the largest future value are averaged (Coles 2001, 9.1.3), so that the interval contains both chance
# and the uncertainty of the fit.  A motion with clearance is bounded, and so are its forces: shapes above zero are
# excluded.

PREDICTED_REVOLUTIONS = 1e6  # for which the largest value is predicted
MIN_VALUES = 100  # independent values, below which nothing is predicted
MIN_EXCEEDANCES = 20  # values above the threshold, at least
EXCEEDANCE_FACTOR = 2.0  # times the root of the number of values: how many of them are above the threshold
SHAPES = np.linspace(-1.0, 0.0, 41)  # equally likely beforehand; at -1 all values up to the largest are equally likely
SCALES = np.exp(np.linspace(-1.8, 1.8, 61))  # times the mean above the threshold, which is scale / (1 - shape)
SHAPE_STEP, LOG_SCALE_STEP = 0.025, 0.06  # of both
WEIGHT_CUTOFF = 1e-5  # of the largest weight: below, a second, finer grid leaves them out
EQUAL_TOLERANCE = 1e-6  # relative spread below which all values are equal
BISECTIONS = 40  # of the range of a quantile
UNKNOWN_QUANTILE = Quantile(None, None, None)


class Tail(NamedTuple):
    """Generalised Pareto distributions above zero, F = 1 - (1 + shape x / scale)^(-1 / shape), and their weights."""

    scale: np.ndarray  # (tails,)
    shape: np.ndarray  # (tails,), below 0 but for the last ones, which are 0
    weight: np.ndarray  # (tails,), of sum 1

    def exceedance_probabilities(self, value: float) -> np.ndarray:
        """Return the probability (tails,) with which each distribution exceeds a value."""
        probabilities: np.ndarray = np.exp(_log_survival(np.array([value]), self.scale, self.shape)[:, 0])
        return probabilities


def expected_largest(values: np.ndarray, revolutions: float = PREDICTED_REVOLUTIONS) -> Quantile:
    """Return the median of the largest value in many revolutions, from successive given values, and its interval.

    The interval begins at the largest given value; the largest of many exceeds its end with a probability of 2.5 %.

    With fewer than MIN_VALUES independent values the result is UNKNOWN_QUANTILE; if all are equal, it is their value.
    """
    if len(values) < MIN_VALUES:
        return UNKNOWN_QUANTILE
    largest = float(values.max())
    if largest - float(values.min()) <= EQUAL_TOLERANCE * abs(largest):
        return Quantile(largest, largest, largest)
    cluster_size = variance_inflation(values)
    if len(values) < MIN_VALUES * cluster_size:
        return UNKNOWN_QUANTILE
    ordered = np.sort(values)[::-1]
    count = max(MIN_EXCEEDANCES, round(EXCEEDANCE_FACTOR * math.sqrt(len(values))))
    threshold = float(ordered[count])
    exceedances = ordered[:count] - threshold
    if exceedances[0] <= EQUAL_TOLERANCE * abs(largest):
        return Quantile(largest, largest, largest)
    tail = _posterior(exceedances, cluster_size)
    rate = revolutions * count / len(values)  # values above the threshold in all revolutions
    median, high = (
        max(threshold + _tail_quantile(tail, rate, probability), largest)
        for probability in (0.5, 1.0 - TAIL_PROBABILITY)
    )
    return Quantile(median, largest, high)  # densities that end abruptly would need a lower end of their own


def _posterior(exceedances: np.ndarray, cluster_size: float) -> Tail:
    """Return the distributions that values above a threshold may have, weighted by their likelihood.

    cluster_size : number of successive values that count as one independent value
    """
    tail = _posterior_on_grid(exceedances, cluster_size, SHAPES, SCALES)
    likely = tail.weight > WEIGHT_CUTOFF * tail.weight.max()
    shapes, scales = tail.shape[likely], tail.scale[likely] / exceedances.mean()
    low, high = (
        min(max(edge, SHAPES[0]), SHAPES[-1]) for edge in (shapes.min() - SHAPE_STEP, shapes.max() + SHAPE_STEP)
    )
    finer = np.exp(
        np.linspace(np.log(scales.min()) - LOG_SCALE_STEP, np.log(scales.max()) + LOG_SCALE_STEP, len(SCALES))
    )
    return _posterior_on_grid(exceedances, cluster_size, np.linspace(low, high, len(SHAPES)), finer)


def _posterior_on_grid(exceedances: np.ndarray, cluster_size: float, shapes: np.ndarray, scales: np.ndarray) -> Tail:
    """Return the distributions on a grid of shapes and of scales over the mean above the threshold."""
    shape, ratio = (axis.ravel() for axis in np.meshgrid(shapes, scales, indexing="ij"))
    scale = float(exceedances.mean()) * ratio
    logarithms = _log_survival(exceedances, scale, shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        density = (1.0 + shape[:, None]) * logarithms - np.log(scale)[:, None]
    density[np.isneginf(logarithms)] = -np.inf
    likelihood = density.sum(axis=1) / cluster_size
    weight = np.exp(likelihood - likelihood.max())
    return Tail(scale, shape, weight / weight.sum())


def _log_survival(values: np.ndarray, scale: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Return the logarithm of the probability that each distribution exceeds each value, (distributions, values)."""
    ratio = values / scale[:, None]
    nonzero_shape = np.where(shape != 0.0, shape, -1.0)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        general = -np.log1p(np.maximum(nonzero_shape * ratio, -1.0)) / nonzero_shape
    logarithms: np.ndarray = np.where(shape[:, None] != 0.0, general, -ratio)
    return logarithms


def _tail_quantile(tail: Tail, rate: float, probability: float) -> float:
    """Return the quantile `probability` of the largest of `rate` values above the threshold."""

    def probability_below(value: float) -> float:
        return float(portable.product(tail.weight, np.exp(-rate * tail.exceedance_probabilities(value))))

    low, high = 0.0, float(tail.scale.max())
    while probability_below(high) < probability:
        high *= 2.0
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        low, high = (low, mid) if probability_below(mid) >= probability else (mid, high)
    return high


RARE_SHARE = 0.01  # of the window's time, for which the force figure is exceeded
DRY_FORCE_THRESHOLD = 1e-3  # of a joint's mean load: a smaller dry force does not count
SEAM_BINS = 4  # bins repeated beyond the seam of the circle


class JointTotals(ContactTotals):
    """Figures of the window for a joint; the added fields are those of a joint with several contacts."""

    corner_force_max: float  # N, at a guide's corner
    corner_force_square: float  # N^2 s, the largest of a guide's corners
    axial_force_max: float  # N, at a flange
    axial_onsets: float  # number of onsets at the flanges
    uneven_time: float  # N s, of the difference between the walls
    tilt_max: float  # rad
    element_force_max: float  # N, at an element of a rolling bearing
    elements_loaded: float  # largest number of elements that carry load at a time
    eccentricity_depth: float  # m, largest eccentricity of a rolling bearing minus its length of reference
    relative_turn: float  # rad, integral of the size of the relative speed of its rings
    drive_depth: float  # m, largest depth at the drive flank of a gear or coupling, below 0 if it never touched
    coast_depth: float  # m, likewise at the coast flank


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
    light_load_time: list[float]  # s, by joint: time of a rolling bearing below its least load; 0 of others
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
    """Return the sums by joint from those by contact: of corners of a guide, walls in space, elements of a bearing.

    The work of a preload counts as friction of its joint and as heat; `friction` is by joint without clearance.

    Counts and energies are added; of depths, the largest counts.  Forces are those of the resultant of the contacts;
    a joint is in contact while any of them touches.
    """
    if layout.frictions:
        totals = _with_friction(totals, layout)
    if not any(joint.corners for joint in layout.joints):
        return totals
    rows, resultants = contact_slices(layout), resultant_contacts(layout)
    pairs = zip(rows, layout.joints, strict=True)
    joints = JointTotals(np.array([_combined_totals(totals.joint[row], joint).numbers for row, joint in pairs]))
    account = np.array(
        [
            combined_account(totals.account[row], totals.joint[row], contact_time)
            for row, contact_time in zip(rows, joints.column("contact_time"), strict=True)
        ]
    )
    wear = totals.wear.reshape(len(totals.joint), -1)[[row.start for row in rows]].ravel()
    histogram = np.array([totals.histogram[contacts].sum(axis=0) for contacts in resultants])
    bins = np.array([totals.bins[contacts].max(axis=0) for contacts in resultants])
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


def resultant_contacts(layout: Layout) -> list[slice]:
    """Return the contacts of each joint whose normal force is that of the joint, at most one of which acts at a time.

    They are both flanks of a gear or coupling, else the only contact or the resultant of several.
    """
    pairs = zip(contact_slices(layout), layout.joints, strict=True)
    return [
        contacts if joint.flanked else slice(contacts.start + joint.corners, contacts.start + joint.corners + 1)
        for contacts, joint in pairs
    ]


def _combined_totals(contacts: ContactTotals, joint: JointLayout) -> JointTotals:
    """Return the sums of a joint from those of its contacts, (contacts,)."""
    combined = JointTotals.zeros()
    points = contacts[: max(joint.corners, 1)]
    walls = points[:WALLS] if joint.is_spatial else points
    combined.numbers[: ContactTotals.SIZE] = walls.numbers.sum(axis=0)
    for name, kind in ContactTotals.DECLARED.items():
        if kind is Largest:
            setattr(combined, name, walls.column(name).max())
        elif kind is Resultant and joint.corners and not joint.flanked:
            setattr(combined, name, getattr(contacts[joint.corners], name))
    if joint.flanked:  # at most one of them touches
        for name in ("force_max", "force_max_to_target", "load_max"):
            setattr(combined, name, contacts.column(name).max())
        combined.contact_time = contacts.column("contact_time").sum()
        combined.drive_depth, combined.coast_depth = contacts.column("depth_max")
    if joint.is_guide:
        combined.corner_force_max = points.column("force_max").max()
        combined.corner_force_square = points.column("force_square").max()
    if joint.is_rolling:
        # Set the sums of a rolling bearing from those of its elements and its auxiliary contacts
        resultant, rings = contacts[joint.corners :]
        combined.friction_energy, combined.heat = resultant.friction_energy, resultant.heat
        combined.element_force_max = points.column("force_max").max()
        combined.elements_loaded, combined.eccentricity_depth = rings.depth_max, resultant.depth_max
        combined.relative_turn = rings.force_time
        combined.inner_fatigue, combined.outer_fatigue = rings.inner_fatigue, rings.outer_fatigue
    if joint.is_spatial:
        flanges, wall_difference = contacts[WALLS : joint.corners], contacts[-1]
        combined.clips, combined.friction_energy = points.column("clips").sum(), points.column("friction_energy").sum()
        combined.axial_force_max = flanges.column("force_max").max(initial=0.0)
        combined.axial_onsets = flanges.column("onsets").sum()
        combined.uneven_time = wall_difference.force_time
        combined.tilt_max = math.asin(min(wall_difference.depth_max, 1.0))
    return combined


def combined_account(accounts: np.ndarray, contacts: ContactTotals, contact_time: float) -> np.ndarray:
    """Return the wear account of a joint, (ACCOUNT_SIZE,), from those of its contacts, (contacts, ACCOUNT_SIZE).

    Maxima and the time beyond the limit are those of one contact; the mean pressure is an average over the times
    in contact of all.  contacts : sums of the contacts; contact_time : that of the joint, s.
    """
    combined: np.ndarray = accounts.sum(axis=0)
    for column in (Account.index_of(name) for name, kind in Account.DECLARED.items() if kind is Largest):
        combined[column] = accounts[:, column].max()
    time = contacts.column("contact_time")[Account(accounts).column("arc_time") > 0.0]
    if time.size:
        Account(combined).pressure_time *= contact_time / time.sum()
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
