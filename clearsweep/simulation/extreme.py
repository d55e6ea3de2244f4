"""Largest value to expect in many revolutions, from the values of some: extreme-value statistics of peaks.

Values above a threshold are modelled by a generalised Pareto distribution (Coles 2001, An Introduction to Statistical
Modeling of Extreme Values, 4.2-4.3).  All its shapes and scales count by their likelihood, and what they give for the
largest future value is averaged (Coles 2001, 9.1.3), so that the interval contains both its chance and the uncertainty
of the fit.  A motion with clearance is bounded, and so are its forces: shapes above zero are excluded.
"""

import math
from typing import NamedTuple

import numpy as np

from .spread import OUTSIDE, Quantile, dependence

REVOLUTIONS = 1e6  # for which the largest value is predicted
FEWEST = 100  # independent values, below which nothing is predicted
FEWEST_ABOVE = 20  # values above the threshold, at least
SHARE_ABOVE = 2.0  # times the root of the number of values: how many of them are above the threshold
SHAPES = np.linspace(-1.0, 0.0, 41)  # equally likely beforehand; at -1 all values up to the largest are equally likely
SCALES = np.exp(np.linspace(-1.8, 1.8, 61))  # times the mean above the threshold, which is scale / (1 - shape)
STEP, LOG_STEP = 0.025, 0.06  # of both
UNLIKELY = 1e-5  # of the largest weight: below, a second, finer grid leaves them out
SAME = 1e-6  # relative spread below which all values are equal
HALVINGS = 40  # of the range of a quantile
NONE = Quantile(None, None, None)


class Tail(NamedTuple):
    """Generalised Pareto distributions above zero, F = 1 - (1 + shape x / scale)^(-1 / shape), and their weights."""

    scale: np.ndarray  # (tails,)
    shape: np.ndarray  # (tails,), below 0 but for the last ones, which are 0
    weight: np.ndarray  # (tails,), of sum 1

    def exceeded(self, value: float) -> np.ndarray:
        """Return with which probability each distribution exceeds a value, (tails,)."""
        chances: np.ndarray = np.exp(_log_exceeded(np.array([value]), self.scale, self.shape)[:, 0])
        return chances


def expected_largest(values: np.ndarray, revolutions: float = REVOLUTIONS) -> Quantile:
    """Return the median of the largest of so many values like the given successive ones, and its interval.

    The interval begins at the largest given value; the largest of many exceeds its end with a probability of 2.5 %.

    No result for fewer than FEWEST independent values; for values that do not vary the result is that value.
    """
    if len(values) < FEWEST:
        return NONE
    largest = float(values.max())
    if largest - float(values.min()) <= SAME * abs(largest):
        return Quantile(largest, largest, largest)
    clustered = dependence(values)
    if len(values) < FEWEST * clustered:
        return NONE
    ordered = np.sort(values)[::-1]
    count = max(FEWEST_ABOVE, round(SHARE_ABOVE * math.sqrt(len(values))))
    threshold = float(ordered[count])
    exceedances = ordered[:count] - threshold
    if exceedances[0] <= SAME * abs(largest):
        return Quantile(largest, largest, largest)
    tail = _weighted(exceedances, clustered)
    rate = revolutions * count / len(values)  # values above the threshold in all revolutions
    median, high = (max(threshold + _quantile(tail, rate, share), largest) for share in (0.5, 1.0 - OUTSIDE))
    return Quantile(median, largest, high)  # densities that end abruptly would need a lower end of their own


def _weighted(exceedances: np.ndarray, clustered: float) -> Tail:
    """Return the distributions that values above a threshold may have, weighted by their likelihood.

    clustered : how many successive values count as one independent value
    """
    tail = _on_grid(exceedances, clustered, SHAPES, SCALES)
    likely = tail.weight > UNLIKELY * tail.weight.max()
    shapes, scales = tail.shape[likely], tail.scale[likely] / exceedances.mean()
    low, high = (min(max(edge, SHAPES[0]), SHAPES[-1]) for edge in (shapes.min() - STEP, shapes.max() + STEP))
    finer = np.exp(np.linspace(np.log(scales.min()) - LOG_STEP, np.log(scales.max()) + LOG_STEP, len(SCALES)))
    return _on_grid(exceedances, clustered, np.linspace(low, high, len(SHAPES)), finer)


def _on_grid(exceedances: np.ndarray, clustered: float, shapes: np.ndarray, scales: np.ndarray) -> Tail:
    """Return the distributions on a grid of shapes and of scales over the mean above the threshold."""
    shape, ratio = (axis.ravel() for axis in np.meshgrid(shapes, scales, indexing="ij"))
    scale = float(exceedances.mean()) * ratio
    logarithms = _log_exceeded(exceedances, scale, shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        density = (1.0 + shape[:, None]) * logarithms - np.log(scale)[:, None]
    density[np.isneginf(logarithms)] = -np.inf
    likelihood = density.sum(axis=1) / clustered
    weight = np.exp(likelihood - likelihood.max())
    return Tail(scale, shape, weight / weight.sum())


def _log_exceeded(values: np.ndarray, scale: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Return the logarithm of the probability that each distribution exceeds each value, (distributions, values)."""
    ratio = values / scale[:, None]
    curved = np.where(shape != 0.0, shape, -1.0)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        bent = -np.log1p(np.maximum(curved * ratio, -1.0)) / curved
    logarithms: np.ndarray = np.where(shape[:, None] != 0.0, bent, -ratio)
    return logarithms


def _quantile(tail: Tail, rate: float, share: float) -> float:
    """Return the value that the largest of `rate` values above the threshold does not exceed, with a probability."""

    def probability_below(value: float) -> float:
        return float(tail.weight @ np.exp(-rate * tail.exceeded(value)))

    low, high = 0.0, float(tail.scale.max())
    while probability_below(high) < share:
        high *= 2.0
    for _ in range(HALVINGS):
        mid = 0.5 * (low + high)
        low, high = (low, mid) if probability_below(mid) >= share else (mid, high)
    return high
