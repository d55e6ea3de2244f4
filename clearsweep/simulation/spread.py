"""Quantiles of a value of every revolution, and their intervals."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

CONFIDENCE = 0.95
STRONGEST = 0.9  # correlation of neighbours that is allowed for
OUTSIDE = 0.5 * (1.0 - CONFIDENCE)  # chance to lie beyond either end of an interval


class Quantile(NamedTuple):
    """A quantile of a value of every revolution, and its 95 % interval; None: there are too few revolutions."""

    value: float | None
    low: float | None
    high: float | None


class Spread(NamedTuple):
    """How the force peaks (N) of a joint spread over the window's revolutions."""

    median: Quantile
    p95: Quantile
    highest: tuple[float, int] | None = None  # N, and the revolution of the run in which it lies, the first being 1


def quantiles(values: np.ndarray, shares: tuple[float, ...]) -> tuple[Quantile, ...]:
    """Return quantiles (linear between neighbours) of values that follow each other, with their intervals.

    Intervals run between order statistics (David & Nagaraja 2003, Order Statistics, 7.1).  Where neighbours are alike
    (lag 1, if positive) there are fewer independent values, by (1 - r) / (1 + r), as for a first-order autoregressive
    process.
    """
    if not len(values):
        return (Quantile(None, None, None),) * len(shares)
    ordered = sorted(values.tolist())
    independent = max(round(len(values) / dependence(values)), 1)
    return tuple([_quantile(ordered, independent, share) for share in shares])


def _quantile(ordered: list[float], independent: int, share: float) -> Quantile:
    """Return a quantile of values in their order, so many of them `independent`."""
    count = len(ordered)
    place = share * (count - 1)
    below = min(int(place), count - 1)
    value = ordered[below] + (place - below) * (ordered[min(below + 1, count - 1)] - ordered[below])
    low, high = _ranks(independent, share)
    bottom = None if low is None else ordered[low * count // independent]
    top = None if high is None else ordered[min(-(-(high + 1) * count // independent), count) - 1]
    return Quantile(value, bottom, top)


def dependence(values: np.ndarray) -> float:
    """Return how many of the values, which follow each other, count as one: (1 + r) / (1 - r)."""
    if len(values) < 3:
        return 1.0  # two lie on either side of their mean
    off = values - np.add.reduce(values) / len(values)
    squares = float(off @ off)
    together = min(max(float(off[1:] @ off[:-1]) / squares, 0.0), STRONGEST) if squares > 0.0 else 0.0
    return (1.0 + together) / (1.0 - together)


@lru_cache(1024)
def _ranks(count: int, share: float) -> tuple[int | None, int | None]:
    """Return the places, from 0, of the ordered values between which a quantile lies; None: there are too few."""
    from scipy.special import bdtr

    below = np.asarray(bdtr(np.arange(count, dtype=float), count, share))  # chance of at most 0, 1, ... below
    low = int(np.searchsorted(below, OUTSIDE, side="right")) - 1
    high = int(np.searchsorted(below, 1.0 - OUTSIDE))
    return (low if low >= 0 else None), (high if high < count else None)
