"""Statistics of a sample of cases: spread of figures, chance of exceeding a limit, sensitivity to each variable.

Intervals assume independent points; for Sobol points and Latin hypercubes, which are spread more evenly, they are wider
than necessary.  The statistics do not depend on the origin of the figures.
"""

import functools
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...answers.statistics import CONFIDENCE, QUANTILES, Estimate, binomial_distribution, binomial_interval
from ...answers.verdict import EXCEEDED_COLUMN, UNDECIDED_COLUMN
from ...contracts.layout import DIFFERENCE
from ...language.errors import InputError
from ...store import StoredRun
from ..axis import CACHED_VALUES

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
        return (
            self.scatter / effect_size
            if not self.is_chaotic and 0.0 < BLURRED_RATIO * effect_size <= self.scatter
            else np.nan
        )


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
    ids, failed = run.column("case_id").to_numpy(), (run.column("status") != "ok").to_numpy(bool)
    names = [
        name
        for name in run.columns[run.columns.index("message") + 1 :]
        if name not in (EXCEEDED_COLUMN, UNDECIDED_COLUMN)
    ]

    @functools.lru_cache(CACHED_VALUES)
    def read(column: str) -> np.ndarray:
        return np.where(failed, np.nan, run.column(column).to_numpy(float, na_value=np.nan))

    samples = []
    for point, row_by_values in sorted(rows_of_point.items(), key=lambda item: _sort_key(item[0])):
        row_numbers = np.array([row_by_values.get(row, -1) for row in rows])
        drawn, figures = np.where(row_numbers >= 0, ids[row_numbers], ""), Figures(names, read, row_numbers)
        failed_ids = tuple(dict.fromkeys(drawn[failed[row_numbers] & (row_numbers >= 0)]))
        samples.append(Sample(dict(zip(other_paths, point, strict=True)), tuple(drawn), figures, failed_ids))
    return samples


def _values_by_row(run: StoredRun, paths: list[str]) -> list[tuple]:
    """Return the values of these columns in every row; None for unused values."""
    columns = [run.column(path) for path in paths or ["case_id"]]
    lists = [column.astype(object).where(column.notna(), None).tolist() for column in columns]
    return list(zip(*lists, strict=True)) if paths else [()] * len(columns[0])


def _sort_key(point: tuple) -> tuple:
    """Return the sort key of a point: numbers by size, then words, then unused values."""
    return tuple((value is None, isinstance(value, str), 0.0 if value is None else value) for value in point)


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
    interval_ends = np.nanquantile(
        resampled_indices, ((1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0), axis=0
    )  # (2, 2, variables)
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
    first, _, *disturbed_rows = sample.figures.get(MOTION_COLUMN, np.arange(sample.figures[figure].size)).reshape(
        blocks
    )
    is_disturbed = [bool(np.any(disturbed != first)) for disturbed in disturbed_rows]
    totals = [
        index.total.value
        for index, is_disturbed_variable in zip(indices, is_disturbed, strict=True)
        if is_disturbed_variable
    ]
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
