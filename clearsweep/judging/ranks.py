"""Rank correlations of drawn variables with a figure, simple and partial, and their intervals.

Ranks only measure whether the figure increases with the variable, so that a single large peak has little weight.
"""

import math

import numpy as np

from .probability import Estimate

BEYOND = 1.959963984540054  # standard deviations: 95 % of a normal distribution are within


def ranks(values: np.ndarray) -> np.ndarray:
    """Return the ranks of values (n,); equal values share a rank."""
    from scipy.stats import rankdata

    ranked: np.ndarray = rankdata(values)
    return ranked


def rank_correlation(x: np.ndarray, y: np.ndarray) -> Estimate:
    """Return Spearman's rank correlation and its 95 % interval (Bonett & Wright 2000, Psychometrika 65:23).

    The result is NaN if one of them is constant, or with fewer than five values.
    """
    return _estimate(_correlation(ranks(x), ranks(y)), len(x), 0)


def partial_rank_correlation(x: np.ndarray, y: np.ndarray, others: list[np.ndarray]) -> Estimate:
    """Return the rank correlation of the residuals of both ranks after linear regression on the ranks `others`.

    Iman, Shortencarier & Johnson 1985 (SAND85-0044): PRCC.
    """
    known = np.column_stack([np.ones(len(x)), *(ranks(other) for other in others)])
    left = []
    for values in (ranks(x), ranks(y)):
        fitted = known @ np.linalg.lstsq(known, values, rcond=None)[0]
        rest = values - fitted
        left.append(np.where(np.abs(rest) > 1e-9 * len(x), rest, 0.0))  # rounding is nothing left
    return _estimate(_correlation(*left), len(x), len(others))


def _correlation(x: np.ndarray, y: np.ndarray) -> float:
    x, y = x - x.mean(), y - y.mean()
    size = math.sqrt(float(x @ x) * float(y @ y))
    return min(max(float(x @ y) / size, -1.0), 1.0) if size > 0.0 else math.nan


def _estimate(r: float, count: int, others: int) -> Estimate:
    """Return a correlation and its interval by Fisher's transformation."""
    freedom = count - others - 3
    if math.isnan(r) or freedom < 2:
        return Estimate(r if freedom >= 2 else math.nan, math.nan, math.nan)
    if abs(r) >= 1.0:
        return Estimate(r, r, r)
    width = BEYOND * math.sqrt((1.0 + 0.5 * r * r) / freedom)
    return Estimate(r, math.tanh(math.atanh(r) - width), math.tanh(math.atanh(r) + width))
