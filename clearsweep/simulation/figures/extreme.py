"""Largest value to expect in many revolutions, from the values of some: extreme-value statistics of peaks.

Values above a threshold are modelled by a generalised Pareto distribution (Coles 2001, An Introduction to Statistical
Modeling of Extreme Values, 4.2-4.3).  All its shapes and scales count by their likelihood, and their predictions of
the largest future value are averaged (Coles 2001, 9.1.3), so that the interval contains both chance and the uncertainty
of the fit.  A motion with clearance is bounded, and so are its forces: shapes above zero are excluded.
"""

import math
from typing import NamedTuple

import numpy as np

from .spread import TAIL_PROBABILITY, Quantile, variance_inflation

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
        max(threshold + _quantile(tail, rate, probability), largest) for probability in (0.5, 1.0 - TAIL_PROBABILITY)
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


def _quantile(tail: Tail, rate: float, probability: float) -> float:
    """Return the quantile `probability` of the largest of `rate` values above the threshold."""

    def probability_below(value: float) -> float:
        return float(tail.weight @ np.exp(-rate * tail.exceedance_probabilities(value)))

    low, high = 0.0, float(tail.scale.max())
    while probability_below(high) < probability:
        high *= 2.0
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        low, high = (low, mid) if probability_below(mid) >= probability else (mid, high)
    return high
