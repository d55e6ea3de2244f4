"""Rank correlations of drawn variables with a figure, simple and partial, and their intervals.

Ranks only measure whether the figure increases with the variable, so that a single large peak has little weight.
"""

import math

import numpy as np

from .probability import Estimate

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
