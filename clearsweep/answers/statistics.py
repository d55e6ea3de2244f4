"""Statistics of the cases of a run: chances of exceeding a limit, shares of variance, correlations of ranks."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

# Probability of exceeding a limit, from the cases of a random sample.

RANDOM_METHODS = ("sobol", "latin-hypercube", "random")  # methods whose points represent the distributions
ONE_AT_A_TIME = "one-at-a-time"  # method whose cases are no designs
CONFIDENCE = 0.95  # of intervals


class Estimate(NamedTuple):
    """An estimate and its confidence interval; an end is NaN if the sample is too small."""

    value: float
    low: float
    high: float


def median(values: np.ndarray) -> float:
    """Return the median of known numbers, NaN of none; that of numpy loads its masked arrays, in 25 ms."""
    if not len(values):
        return math.nan
    low, high = np.sort(values)[[(len(values) - 1) // 2, len(values) // 2]].tolist()
    return float(0.5 * (low + high))


def binomial_interval(count: int, cases: int) -> tuple[float, float, float]:
    """Return the probability from `count` of `cases`, and the ends of Clopper and Pearson's exact interval."""
    from scipy.stats import binomtest

    test = binomtest(count, cases)
    interval = test.proportion_ci(CONFIDENCE, method="exact")
    return float(test.statistic), float(interval.low), float(interval.high)


def binomial_distribution(count: int, probability: float) -> np.ndarray:
    """Return the probabilities (count + 1,) of at most 0, 1, ... successes in `count` trials."""
    successes = np.arange(1, count + 1)
    ratios = (count + 1 - successes) / successes * (probability / (1.0 - probability))  # of each to one fewer
    logarithms = np.concatenate([[0.0], np.cumsum(np.log(ratios))])
    sums = np.cumsum(np.exp(logarithms - logarithms.max()))
    cumulative: np.ndarray = sums / sums[-1]
    return cumulative


def is_one_sample(record: Mapping[str, Any]) -> bool:
    """Return whether the cases of a run are one random sample, by its run.json."""
    sample = record.get("sample") or {}
    drawn = sample.get("drawn", {})
    return sample.get("method") in RANDOM_METHODS and set(record.get("units", {})) == set(drawn)


# Analysis of variance of a figure over varied values: the share of each.

PASSES = 20  # of the fit of main effects; one is exact if every combination finished


def variance_shares(values: np.ndarray, value_indices: list[np.ndarray]) -> list[float]:
    """Return, for each axis, its share of the variance of a figure, corrected for chance; NaN: undefined.

    The variance is that of log(values) where all values are positive, else that of the values.
    `value_indices` : per axis the index of each case on it, (cases,).  The scatter is the residual of the sum of all
    main effects (analysis of variance without interactions); without degrees of freedom no share is defined.
    """
    is_known = np.isfinite(values)
    known = values[is_known]
    is_positive = bool((known > 0.0).all())
    residuals = np.log(known) if is_positive else known / max(float(np.abs(known).max(initial=0.0)), 1e-300)
    groups = [_renumbered(indices[is_known]) for indices in value_indices]
    freedoms = [int(group.max(initial=0)) for group in groups]
    residual_freedom = len(residuals) - 1 - sum(freedoms)
    residuals -= residuals.mean() if len(residuals) else 0.0
    total = float(residuals @ residuals)
    if residual_freedom <= 0 or total <= 1e-20 * len(residuals):  # all values equal, except for rounding
        return [np.nan] * len(value_indices)
    sums_between = [float(np.bincount(group) @ _group_means(group, residuals) ** 2) for group in groups]
    for _ in range(PASSES):
        for group in groups:
            residuals -= _group_means(group, residuals)[group]
    scatter = max(float(residuals @ residuals) / residual_freedom, 1e-12 * total)
    between = zip(sums_between, freedoms, strict=True)
    return [max(0.0, (sum_of_squares - freedom * scatter) / total) for sum_of_squares, freedom in between]


def _renumbered(indices: np.ndarray) -> np.ndarray:
    """Return indices (from -1) renumbered without gaps, in the same order."""
    renumbered: np.ndarray = (np.cumsum(np.bincount(indices + 1) > 0) - 1).astype(indices.dtype)[indices + 1]
    return renumbered


def _group_means(group: np.ndarray, values: np.ndarray) -> np.ndarray:
    means: np.ndarray = np.bincount(group, values) / np.bincount(group)
    return means


# Rank correlations of drawn variables with a figure, simple and partial, and their intervals.
#
# Ranks only measure whether the figure increases with the variable, so that a single large peak has little weight.

NORMAL_QUANTILE = 1.959963984540054  # standard deviations: 95 % of a normal distribution are within


def rank_values(values: np.ndarray) -> np.ndarray:
    """Return the ranks of values (n,); equal values share a rank."""
    from scipy.stats import rankdata

    ranked: np.ndarray = rankdata(values)
    return ranked


def rank_correlation(x: np.ndarray, y: np.ndarray) -> Estimate:
    """Return Spearman's rank correlation and its 95 % interval (Bonett & Wright 2000, Psychometrika 65:23).

    The result is NaN if one of them is constant, or with fewer than five values.
    """
    return _with_interval(_correlation(rank_values(x), rank_values(y)), len(x), 0)


def partial_rank_correlation(x: np.ndarray, y: np.ndarray, others: list[np.ndarray]) -> Estimate:
    """Return the rank correlation of the residuals of both ranks after linear regression on the ranks `others`.

    Iman, Shortencarier & Johnson 1985 (SAND85-0044): PRCC.
    """
    regressors = np.column_stack([np.ones(len(x)), *(rank_values(other) for other in others)])
    residuals = []
    for values in (rank_values(x), rank_values(y)):
        fitted = regressors @ np.linalg.lstsq(regressors, values, rcond=None)[0]
        residual = values - fitted
        residuals.append(np.where(np.abs(residual) > 1e-9 * len(x), residual, 0.0))  # below this it is rounding
    return _with_interval(_correlation(*residuals), len(x), len(others))


def _correlation(x: np.ndarray, y: np.ndarray) -> float:
    x, y = x - x.mean(), y - y.mean()
    norm = math.sqrt(float(x @ x) * float(y @ y))
    return min(max(float(x @ y) / norm, -1.0), 1.0) if norm > 0.0 else math.nan


def _with_interval(correlation: float, count: int, controlled_count: int) -> Estimate:
    """Return a correlation and its interval by Fisher's transformation."""
    degrees_of_freedom = count - controlled_count - 3
    if math.isnan(correlation) or degrees_of_freedom < 2:
        return Estimate(correlation if degrees_of_freedom >= 2 else math.nan, math.nan, math.nan)
    if abs(correlation) >= 1.0:
        return Estimate(correlation, correlation, correlation)
    half_width = NORMAL_QUANTILE * math.sqrt((1.0 + 0.5 * correlation * correlation) / degrees_of_freedom)
    return Estimate(
        correlation, math.tanh(math.atanh(correlation) - half_width), math.tanh(math.atanh(correlation) + half_width)
    )


# Rank correlations of the drawn variables of a sample with a figure.

__all__ = ["direction_verb", "is_clear", "is_one_sample", "variable_correlations"]

MIN_CASES = 8  # cases: correlations of fewer are meaningless
QUANTILES = (0.05, 0.5, 0.95)
STRENGTH_NOTE = "Strength of an effect: 0 means none, 1 that the variable decides alone."


def variable_correlations(drawn: Mapping[str, np.ndarray], values: np.ndarray) -> list[tuple[str, Estimate, Estimate]]:
    """Return variable, rank correlation with a figure, and partial rank correlation, the strongest first.

    Return [] if there are too few cases or the figure is constant.

    drawn : path -> (n,) values; values : (n,), NaN for null
    """
    is_known = np.isfinite(values)
    if is_known.sum() < MIN_CASES or np.ptp(values[is_known]) == 0.0:
        return []
    rows, known_values = [], {path: np.asarray(column_values, float)[is_known] for path, column_values in drawn.items()}
    for path, variable in known_values.items():
        others = [other for name, other in known_values.items() if name != path]
        simple_correlation = rank_correlation(variable, values[is_known])
        rows.append((path, simple_correlation, partial_rank_correlation(variable, values[is_known], others)))
    return sorted(rows, key=lambda row: -abs(np.nan_to_num(row[2].value)))


def is_clear(correlation: Estimate) -> bool:
    """Return whether the interval of a correlation excludes 0."""
    return correlation.low > 0.0 or correlation.high < 0.0


def direction_verb(correlation: float) -> str:
    """Return 'rises' or 'falls', the trend of a figure with a variable."""
    return "rises" if correlation > 0.0 else "falls"
