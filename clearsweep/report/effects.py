"""What figures depend on: effects of swept values, and the spread of a sample with its sensitivity to each variable.

Effects are medians, pairs of otherwise equal cases, and ranges of laws.  Intervals of a sample assume independent
points; for Sobol points and Latin hypercubes, which are spread more evenly, they are wider than necessary.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from ..answers import judge
from ..answers.judge import known_blocks, verdict_on
from ..answers.judged import CONFIDENCE, QUANTILES, Estimate, binomial_distribution, binomial_interval, variance_shares
from ..answers.validity import YIELD_SPEED
from ..answers.verdict import EXCEEDED_COLUMN, UNDECIDED_COLUMN
from ..contracts.layout import DIFFERENCE
from ..language import wording
from ..language.errors import InputError
from ..language.wording import is_missing
from ..store import StoredRun
from .axis import CACHED_VALUES, Axis
from .study import Joint, Study, comparable_values, joint_of, known, resolve_cases

# Main effects of swept values on a figure: medians over the values, share of the variation.


class MainEffect(NamedTuple):
    """The main effect of one axis on one figure, over blocks of cases that differ on this axis alone."""

    axis: Axis
    column: str
    medians: np.ndarray  # (values,) SI; NaN without a finished case
    low: np.ndarray  # (values,) 10th percentile
    high: np.ndarray  # (values,) 90th percentile
    share: float  # of the figure's variance, corrected for chance, 0 to 1; NaN: undefined
    verdict: str  # of answers.blocks

    def factor(self) -> float:
        """Return the ratio of largest to smallest median; NaN unless both are positive."""
        low, high = float(np.nanmin(self.medians)), float(np.nanmax(self.medians))
        return high / low if low > 0.0 else np.nan


def main_effects_of(study: Study, column: str) -> list[MainEffect]:
    """Return the main effects of all swept axes on a figure over the finished cases, the strongest first."""
    return study.cases.cached(("effects", column), lambda: _main_effects(study, column))


def _main_effects(study: Study, column: str) -> list[MainEffect]:
    levels, values = study.levels(), np.where(_is_between(study), np.nan, comparable_values(study, column))
    codes = {axis.path: study.indices_on(axis) for axis in study.swept()}
    shares = variance_shares(values, [codes[axis.path] for axis in levels])
    effects = []
    for axis, share in zip(levels, shares, strict=True):
        of_axis = judge.Axis((axis.path,), list(axis.values), codes[axis.path])
        matched = known_blocks(codes, of_axis, values)
        if not len(matched):
            continue
        groups = [column[np.isfinite(column)] for column in matched.T]
        quantiles = [np.percentile(group, (50, 10, 90)) if len(group) else [np.nan] * 3 for group in groups]
        medians, low, high = np.array(quantiles).T
        verdict = verdict_on(of_axis, matched)
        effects.append(MainEffect(axis, column, medians, low, high, share, verdict))
    return sorted(effects, key=lambda effect: (-np.nan_to_num(effect.share), -float(np.nanmax(effect.medians))))


def _is_between(study: Study) -> np.ndarray:
    """Return a mask of the finished cases between the values of an axis, which `refine` added."""
    is_between = np.zeros(len(study.cases), bool)
    for axis in (axis for axis in study.swept() if axis.is_numeric):
        is_between |= (study.indices_on(axis) < 0) & np.isfinite(study.cases[axis.path].astype(float))
    return is_between


# Matched cases, which differ in one law only.


class MatchedTable(NamedTuple):
    """A figure by group of matched cases and value of their axis."""

    groups: np.ndarray  # (groups,) their numbers
    levels: np.ndarray  # (levels,) values of the axis, ascending
    values: np.ndarray  # (groups, levels) NaN: no case


class MatchedCases(NamedTuple):
    """Groups of cases that differ in the value of one axis only; a case may belong to several."""

    axis: Axis
    groups: np.ndarray  # (pairs,) number of a group
    rows: np.ndarray  # (pairs,) a case of it
    levels: np.ndarray  # (levels,) the values of all cases on the axis, ascending
    codes: np.ndarray  # (pairs,) index in `levels`, -1: none

    def table(self, values: np.ndarray, *, largest: bool = False) -> MatchedTable:
        """Return values of the finished cases by group and level, for groups with such at two levels or more.

        values : (cases,) NaN where unknown; of those of several cases their median counts, or the `largest`
        """
        of_pairs, level_count = values[self.rows], max(len(self.levels), 1)
        known = (self.codes >= 0) & ~np.isnan(of_pairs)
        numbers = self.groups[known] * level_count + self.codes[known]
        cells, cell_of_pair, counts = np.unique(numbers, return_inverse=True, return_counts=True)
        ordered, ends = of_pairs[known][np.lexsort((of_pairs[known], cell_of_pair))], np.cumsum(counts)
        below, above = (1, 1) if largest else (counts // 2 + 1, (counts + 1) // 2)  # from the end of a cell
        groups, row_of_cell = np.unique(cells // level_count, return_inverse=True)
        table = np.full((len(groups), len(self.levels)), np.nan)
        table[row_of_cell, cells % level_count] = 0.5 * (ordered[ends - below] + ordered[ends - above])
        is_compared = np.count_nonzero(~np.isnan(table), axis=1) > 1
        has_values = ~np.isnan(table[is_compared]).all(axis=0)
        return MatchedTable(groups[is_compared], self.levels[has_values], table[is_compared][:, has_values])

    def row(self, group: int, level: float | str) -> int:
        """Return the first case of a group at a level."""
        return int(self.rows[np.argmax((self.groups == group) & (self.levels[self.codes] == level))])


def match_cases(study: Study, axis: Axis) -> MatchedCases:
    """Return the cases that share all swept values except those of one axis.

    A value that a law does not use does not separate cases: the case then belongs to every group that shares the
    others.
    """
    return study.cases.cached(("matches", axis.path), lambda: _match_cases(study, axis))


def _match_cases(study: Study, axis: Axis) -> MatchedCases:
    others = [_codes(study.cases[other.path])[1] for other in study.swept() if other is not axis]
    codes = np.stack([*others, np.zeros(len(study.cases), int)], axis=-1)  # (cases, other axes and one more)
    groups, used, pairs = list(dict.fromkeys(map(tuple, codes))), codes >= 0, []
    for is_shared in dict.fromkeys(map(tuple, used)):
        rows_of: dict[tuple, list[int]] = {}
        for row in np.flatnonzero((used == is_shared).all(axis=1)).tolist():
            rows_of.setdefault(tuple(itertools.compress(codes[row], is_shared)), []).append(row)
        shared = (tuple(itertools.compress(group, is_shared)) for group in groups)
        pairs += [(number, row) for number, key in enumerate(shared) for row in rows_of.get(key, ())]
    numbers, rows = np.array(pairs, int).reshape(-1, 2).T
    levels, codes_on_axis = _codes(study.cases[axis.path])
    return MatchedCases(axis, numbers, rows, levels, codes_on_axis[rows])


def positive_values(study: Study, column: str) -> np.ndarray:
    """Return a figure of the finished cases (cases,) where it is positive, otherwise NaN."""
    values = study.cases[column]
    return np.where(values > 0.0, values, np.nan)


def _codes(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the distinct values, ascending, and the index of each value in them, -1 for a missing one."""
    known = np.array([not is_missing(value) for value in values.tolist()], bool)
    codes = np.full(len(values), -1)
    levels, codes[known] = np.unique(values[known], return_inverse=True)
    return levels, codes


def axis_key(axis: Axis) -> str:
    """Return an axis as a key of tables: 'laws_rod_slider_contact_law' for 'joints.rod-slider.contact.law'."""
    return axis.path.replace("joints.", "laws_", 1).replace(".", "_").replace("-", "_")


# Trend of a figure with one swept value, from pairs of otherwise equal cases, without assumed distributions.

#: Comparisons up to which the distribution of orders is exact; above, it is approximated as normal.
MAX_EXACT_PAIRS = 3000


def trend_exponent(x: np.ndarray, table: np.ndarray, claims: int = 1) -> tuple[Estimate, int]:
    """Return the exponent of `x` in the trend of a figure, its interval, and the number of pairs of cases.

    The exponent is the median slope of log figure over log x of all pairs of a row; the interval contains the
    slopes that the orders within the rows do not reject (Sen 1968, J. Am. Stat. Assoc. 63:1379; several rows as
    blocks: Hirsch, Slack & Smith 1982, Water Resour. Res. 18:107). The method assumes that without a trend every
    order of a row is equally likely, and that rows are independent.

    Parameters
    ----------
    x : (values,) above 0, distinct
    table : (rows, values) the positive figure; in a row everything except x is equal; NaN if unknown
    claims : number of claims that share the probability of error of one interval (Bonferroni)

    Returns
    -------
    exponent : Estimate, NaN without a pair; its ends NaN with too few pairs for an interval

    """
    log_values, log_x = np.log(table), np.log(np.asarray(x, float))
    slope_arrays = [
        (log_values[:, k] - log_values[:, j]) / (log_x[k] - log_x[j])
        for j, k in itertools.combinations(range(len(log_x)), 2)
    ]
    slopes = np.sort(np.concatenate(slope_arrays)) if slope_arrays else np.empty(0)
    slopes = slopes[np.isfinite(slopes)]
    if not len(slopes):
        return Estimate(math.nan, math.nan, math.nan), 0
    sizes = np.isfinite(log_values).sum(axis=1)
    beyond = slopes_beyond(sizes[sizes > 1], 0.5 * (1.0 - CONFIDENCE) / claims)
    interval = (float(slopes[beyond]), float(slopes[-1 - beyond])) if beyond >= 0 else (math.nan, math.nan)
    return Estimate(float(np.median(slopes)), *interval), len(slopes)


def slopes_beyond(sizes: np.ndarray, tail: float) -> int:
    """Return the number of ordered slopes beyond each end of the interval, -1 without ends.

    The number of descending pairs of n values without a trend is distributed like the inversions of a permutation.

    tail : probability beyond either end
    """
    if (sizes * (sizes - 1) // 2).sum() > MAX_EXACT_PAIRS:
        pairs = 0.5 * (sizes * (sizes - 1.0)).sum()
        deviation = math.sqrt((sizes * (sizes - 1.0) * (2.0 * sizes + 5.0)).sum() / 72.0)
        return int(0.5 * pairs + NormalDist().inv_cdf(tail) * deviation - 0.5)
    probabilities = np.ones(1)
    for size in sizes:
        for count in range(2, size + 1):  # the last of `count` values has any rank with equal probability
            probabilities = np.convolve(probabilities, np.full(count, 1.0 / count))
    return int(np.searchsorted(np.cumsum(probabilities), tail, side="right")) - 1


# Approach speeds up to which contacts stay elastic, as sentences, cards and pictures.

MAX_SPEED_RATIO = 3.0  # times the fastest onset: a higher line would compress all onsets at the bottom of a picture
_NO_STRENGTH = ", because it needs a yield strength or a hardness"


def yield_speed_sentence(study: Study, joint: Joint) -> str:
    """Return the sentence on the approach speeds (m/s) of first yield of a joint in all cases."""
    column = joint.column(YIELD_SPEED)
    if not study.has(column):
        reason = " for this kind of joint or law" if _has_strength(study, joint) else _NO_STRENGTH
        return f"The speed at which the contact first yields is not computed{reason}."
    extremes = (study.cases.smallest(column), study.cases.largest(column))
    scale = wording.scale("m/s", extremes)
    range_text = " to ".join(dict.fromkeys(scale.number_text(extreme, 2) for extreme in extremes))
    return f"The contact first yields at {scale.with_unit(range_text)}."


def _has_strength(study: Study, joint: Joint) -> bool:
    """Return whether the strength of a joint's weaker body is known in any case; False without a finished case."""
    cases = known(lambda: resolve_cases(study, study.cases.index[:1])) or ()
    return joint.layout.strength or any(joint_of(case, joint).strength is not None for case in cases)


def yield_speeds(study: Study, case_id: str, fastest: float) -> list[tuple[str, float]]:
    """Return joint and approach speed (m/s) of first yield in a case; speeds far above the `fastest` are left out."""
    speeds = []
    for joint in study.joints:
        column = joint.column(YIELD_SPEED)
        speed = float(study.cases.at(case_id, column)) if study.has(column) else np.nan
        if speed <= MAX_SPEED_RATIO * fastest:
            speeds.append((joint.title, speed))
    return speeds


# ---------------------------------------------------------------------------------------------- samples


CHAOTIC_SHARE = 0.5  # share of chance in a figure's variance from which its indices are meaningless
BLURRED_RATIO = 0.3  # scatter over effect from which an effect is called blurred
MOTION_COLUMN = "energy_residual"  # differs whenever the motion differs, even in rounding
RESAMPLES = 1000  # of the bootstrap
_SEED = 1  # of the bootstrap: intervals depend only on the run


class Sample(NamedTuple):
    """The cases of one sample, which share the values of all axes that were not drawn."""

    point: dict  # dotted path -> value of the other axes, SI, or {} if there are none
    case_ids: tuple[str, ...]  # one for each row of the design, in its order; '' without a result in an unfinished run
    figures: Mapping[str, np.ndarray]  # column of the summary -> (rows,) SI; NaN where a case failed or is missing
    failed: tuple[str, ...]  # ids of failed cases, without repetition

    def is_finished(self) -> np.ndarray:
        """Return a mask (rows,) of the cases that finished."""
        left_out = {"", *self.failed}
        return np.array([case_id not in left_out for case_id in self.case_ids])


class Figures(Mapping[str, np.ndarray]):
    """The figures of some cases of a run, read on demand."""

    def __init__(self, names: Sequence[str], read: Callable[[str], np.ndarray], rows: np.ndarray) -> None:
        """Take the names of all figures, a function that reads one for all cases, and the rows; -1: missing."""
        self._names, self._read, self._rows = names, read, rows

    def __getitem__(self, column: str) -> np.ndarray:
        if column not in self._names:
            raise KeyError(column)
        return np.where(self._rows >= 0, self._read(column)[self._rows], np.nan)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


class Spread(NamedTuple):
    """The distribution of one figure, in its unit except for `cv`."""

    cases: int  # rows of the design with a value
    mean: Estimate
    cv: Estimate  # standard deviation over mean
    quantiles: tuple[Estimate, ...]  # of QUANTILES


class SingleEffect(NamedTuple):
    """Effect of a single variable on a figure, from its 5 % to its 95 % quantile."""

    path: str
    low: float  # the figure at the 5 % quantile, the others in the middle
    median: float
    high: float
    scatter: float  # spread of the figure under negligible disturbances
    is_chaotic: bool  # the scatter is as large as the effect, which is then meaningless

    def blurred(self) -> float:
        """Return the scatter over the effect for a blurred effect that is not chaotic, else NaN."""
        effect_size = max(self.low, self.median, self.high) - min(self.low, self.median, self.high)
        is_blurred = not self.is_chaotic and 0.0 < BLURRED_RATIO * effect_size <= self.scatter
        return self.scatter / effect_size if is_blurred else np.nan


class SobolIndex(NamedTuple):
    """The share of one variable in the variance of a figure, by itself and with all its interactions."""

    path: str
    first: Estimate
    total: Estimate


class ChanceShare(NamedTuple):
    """Share of chance in a figure's variance over a design: chaos, or the tolerance."""

    share: float  # 0 to 1; NaN for a figure that does not vary
    is_measured: bool  # from repeated cases; else the upper bound from the design

    @property
    def is_chaotic(self) -> bool:
        """Return whether chance contributes, or may contribute, as much to the variance as the variables do."""
        return bool(self.share >= CHAOTIC_SHARE)


def samples_of(run: StoredRun) -> list[Sample]:
    """Return the samples of a run (as the store opens it), one for each point of the other axes.

    Return [] if there are none.
    """
    sample = run.grid.get("sample")
    if not sample:
        return []
    paths = list(sample["drawn"])
    other_paths = [path for path in run.grid.get("units", {}) if path not in paths]
    rows = list(zip(*sample["drawn"].values(), strict=True))
    rows_of_point: dict = {}
    keys = [_values_by_row(run, other_paths), _values_by_row(run, paths)]
    for row_number, (point, drawn) in enumerate(zip(*keys, strict=True)):
        rows_of_point.setdefault(point, {})[drawn] = row_number
    ids, failed = run.column("case_id"), run.column("status") != "ok"
    names = [
        name
        for name in run.columns[run.columns.index("message") + 1 :]
        if name not in (EXCEEDED_COLUMN, UNDECIDED_COLUMN)
    ]

    @functools.lru_cache(CACHED_VALUES)
    def read(column: str) -> np.ndarray:
        return np.where(failed, np.nan, run.column(column).astype(float))

    samples = []

    def sort_key(point: tuple) -> tuple:  # numbers by size, then words, then unused values
        return tuple((value is None, isinstance(value, str), 0.0 if value is None else value) for value in point)

    for point in sorted(rows_of_point, key=sort_key):
        row_by_values = rows_of_point[point]
        row_numbers = np.array([row_by_values.get(row, -1) for row in rows])
        drawn, figures = np.where(row_numbers >= 0, ids[row_numbers], ""), Figures(names, read, row_numbers)
        failed_ids = tuple(dict.fromkeys(drawn[failed[row_numbers] & (row_numbers >= 0)]))
        samples.append(Sample(dict(zip(other_paths, point, strict=True)), tuple(drawn), figures, failed_ids))
    return samples


def _values_by_row(run: StoredRun, paths: list[str]) -> list[tuple]:
    """Return the values of these columns in every row; None for unused values."""
    columns = [run.column(path) for path in paths or ["case_id"]]
    lists = [[None if is_missing(value) else value for value in column.tolist()] for column in columns]
    return list(zip(*lists, strict=True)) if paths else [()] * len(columns[0])


def summarise_spread(values: np.ndarray) -> Spread:
    """Return the distribution of a figure, `values` (rows,) with NaN for missing ones; at least one is present."""
    ascending = np.sort(values[np.isfinite(values)])
    rng = np.random.default_rng(_SEED)
    means, ratios = np.empty(RESAMPLES), np.empty(RESAMPLES)
    for k in range(RESAMPLES):
        resample = ascending[rng.integers(0, len(ascending), len(ascending))]
        means[k], ratios[k] = resample.mean(), _variation(resample)
    return Spread(
        len(ascending),
        Estimate(float(ascending.mean()), *_central_interval(means)),
        Estimate(_variation(ascending), *_central_interval(ratios)),
        tuple(estimate_quantile(ascending, share) for share in QUANTILES),
    )


def _variation(values: np.ndarray) -> float:
    """Return standard deviation over mean; exactly 0 if all values are equal, NaN if the mean is 0."""
    if values.min() == values.max():
        return 0.0
    mean = values.mean()
    return float(values.std(ddof=1) / abs(mean)) if mean != 0.0 else np.nan


def _central_interval(values: np.ndarray) -> tuple[float, float]:
    low, high = np.quantile(values, ((1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0))
    return float(low), float(high)


def estimate_quantile(ordered: np.ndarray, share: float) -> Estimate:
    """Return a quantile of `ordered` values and its interval between two of them (order statistics).

    The number of values below the quantile is binomial, whatever the distribution: David and Nagaraja 2003, 7.1.
    """
    count, tail = len(ordered), (1.0 - CONFIDENCE) / 2.0
    value = float(np.quantile(ordered, share))
    if ordered[0] == ordered[-1]:
        return Estimate(value, value, value)
    at_most = binomial_distribution(count, share)  # P(below <= place)
    low = int(np.searchsorted(at_most, tail)) - 1  # P(below <= low) < tail
    high = int(np.searchsorted(at_most, 1.0 - tail))  # P(below > high) <= tail
    interval_ends = (float(ordered[index]) if 0 <= index < count else np.nan for index in (low, high))
    return Estimate(value, *interval_ends)


def exceedance_probability(beyond: np.ndarray) -> Estimate:
    """Return the probability of a condition that is true in some cases, with Clopper and Pearson's exact interval."""
    return Estimate(*binomial_interval(int(beyond.sum()), len(beyond)))


def sobol_indices(sample: Sample, figure: str, paths: list[str]) -> list[SobolIndex]:
    """Return the first-order and total indices of all variables, from a design of method saltelli.

    Raise InputError with the failed cases.  A constant figure has no indices: NaN.
    """
    values = _complete_values(sample, figure).reshape(len(paths) + 2, -1)
    values = values - values[:2].mean()  # the estimators lose digits to a large mean
    if np.ptp(values[:2]) == 0.0:
        undefined = Estimate(np.nan, np.nan, np.nan)
        return [SobolIndex(path, undefined, undefined) for path in paths]
    generator, count = np.random.default_rng(_SEED), values.shape[1]
    resampled_indices = [_indices(values[:, generator.integers(0, count, count)]) for _ in range(RESAMPLES)]
    tails = ((1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0)
    interval_ends = np.nanquantile(resampled_indices, tails, axis=0)  # (2, 2, variables)
    estimates = np.stack([_indices(values), *interval_ends])  # estimate, low, high; first-order, total; variables
    return [
        SobolIndex(path, *(Estimate(*map(float, column)) for column in estimates[:, :, k].T))  # first-order, total
        for k, path in enumerate(paths)
    ]


def _indices(values: np.ndarray) -> np.ndarray:
    """Return first-order and total indices, (2, variables), from the figure on A, B and every AB, (variables + 2, n).

    Saltelli et al. 2010, table 2 (b) and (f), as in scipy.stats.sobol_indices, whose bootstrap takes no seed.
    """
    first, second, mixed = values[0], values[1], values[2:]
    variance = values[:2].var()
    if variance == 0.0:
        return np.full((2, len(mixed)), np.nan)
    return np.array([(second * (mixed - first)).mean(axis=1), 0.5 * ((first - mixed) ** 2).mean(axis=1)]) / variance


def share_of_chance(sample: Sample, figure: str, indices: list[SobolIndex]) -> ChanceShare:
    """Return the share of chance in the variance of a figure over a design of method saltelli.

    Cases that diverge under a disturbance are two samples of the same figure: their mean squared difference is twice
    the variance of chance.  Without such differences chance is bounded by the smallest total index of the variables
    that disturb the motion, as it contributes to all of these.
    """
    blocks = (len(indices) + 2, -1)
    variance, scatter = sample.figures[figure].reshape(blocks)[:2].var(), disturbance_rms(sample, figure)
    if variance > 0.0 and np.isfinite(scatter):
        return ChanceShare(float(min(1.0, 0.5 * scatter**2 / variance)), True)
    rows = sample.figures.get(MOTION_COLUMN, np.arange(sample.figures[figure].size)).reshape(blocks)
    is_disturbed = [bool(np.any(disturbed != rows[0])) for disturbed in rows[2:]]
    totals = [index.total.value for index, disturbed in zip(indices, is_disturbed, strict=True) if disturbed]
    return ChanceShare(float(np.clip(min(totals), 0.0, 1.0)) if totals else np.nan, False)


def disturbance_rms(sample: Sample, figure: str) -> float:
    """Return the rms over the cases of the change of a figure at a tenth of the tolerance; NaN if unknown."""
    changes = sample.figures.get(figure + DIFFERENCE, np.empty(0))
    changes = changes[np.isfinite(changes)]
    return float(np.sqrt(np.mean(changes**2))) if changes.size else np.nan


def single_effects(sample: Sample, figure: str, paths: list[str]) -> list[SingleEffect]:
    """Return the effect of each single variable, from a design of method one-at-a-time, the largest first.

    The scatter is that of the design's own disturbed cases, or the `disturbance_rms` if that is larger.
    Raise InputError with the failed cases.
    """
    middle, *changed = _complete_values(sample, figure).tolist()
    low, high, disturbed = (changed[start::3] for start in range(3))
    scatter = float(np.nanmax([max(middle, *disturbed) - min(middle, *disturbed), disturbance_rms(sample, figure)]))
    effects = []
    for path, at_low, at_high in zip(paths, low, high, strict=True):
        effect_range = max(at_low, middle, at_high) - min(at_low, middle, at_high)
        effects.append(SingleEffect(path, at_low, middle, at_high, scatter, 0.0 < effect_range <= scatter))
    return sorted(effects, key=lambda effect: -abs(effect.high - effect.low))


def _complete_values(sample: Sample, figure: str) -> np.ndarray:
    """Return a figure on every row of the design; raise InputError if a case failed or has no result."""
    if missing := sample.case_ids.count(""):
        raise InputError(
            f"{figure}: a sensitivity needs every case of its design, and {missing} have no result; run the grid again "
            "to the end"
        )
    if sample.failed:
        failed_text = ", ".join(itertools.islice(sample.failed, 10)) + (", ..." if len(sample.failed) > 10 else "")
        raise InputError(
            f"{figure}: a sensitivity needs every case of its design, and {len(sample.failed)} failed: {failed_text}; "
            "run them again with --retry-failed, or change the ranges"
        )
    values = sample.figures[figure]
    if not np.isfinite(values).all():
        raise InputError(f"{figure}: is null in some cases of the design; choose another figure")
    return values
