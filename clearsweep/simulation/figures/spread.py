"""Quantiles of a value per revolution, and their intervals."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

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
    squares = float(deviations @ deviations)
    return float(deviations[1:] @ deviations[:-1]) / squares if squares > 0.0 else 0.0


def inflation_of(correlation: float) -> float:
    """Return (1 + r) / (1 - r) for a correlation r of neighbours, which counts up to MAX_CORRELATION if positive."""
    counted = min(max(correlation, 0.0), MAX_CORRELATION)
    return (1.0 + counted) / (1.0 - counted)


@lru_cache(1024)
def _enclosing_ranks(count: int, probability: float) -> tuple[int | None, int | None]:
    """Return the ranks, from 0, that enclose a quantile, or None for too few values."""
    from scipy.special import bdtr

    cumulative = np.asarray(
        bdtr(np.arange(count, dtype=float), count, probability)
    )  # of at most 0, 1, ... values below
    low = int(np.searchsorted(cumulative, TAIL_PROBABILITY, side="right")) - 1
    high = int(np.searchsorted(cumulative, 1.0 - TAIL_PROBABILITY))
    return (low if low >= 0 else None), (high if high < count else None)
