"""Main effects of swept values on a figure: medians over the values, share of the variation."""

from typing import NamedTuple

import numpy as np

from ..data.axis import Axis
from ..data.study import Study, grouped

CLEAR_FACTOR = 1.05  # ratio of largest to smallest median below which an axis has no clear effect
CLEAR_CONTRAST = 4.0  # F ratio below which it has none
PASSES = 20  # of the fit of main effects; one is exact if every combination finished


class MainEffect(NamedTuple):
    """The main effect of one axis on one figure, averaged over all values of the other axes."""

    axis: Axis
    column: str
    medians: np.ndarray  # (values,) SI; NaN without a finished case
    low: np.ndarray  # (values,) 10th percentile
    high: np.ndarray  # (values,) 90th percentile
    share: float  # of the variance of the figure's logarithm, corrected for chance, 0 to 1; NaN: undefined
    contrast: float  # variance between the values over the variance not explained by any axis (F ratio); NaN: undefined

    def extremes(self) -> tuple[int, int]:
        """Return the indices of the smallest and the largest median."""
        return int(np.nanargmin(self.medians)), int(np.nanargmax(self.medians))

    def clear(self) -> bool:
        """Return whether the effect of the axis exceeds the scatter; from its medians if there is no scatter."""
        enough = bool(self.factor() >= CLEAR_FACTOR)
        return enough if np.isnan(self.contrast) else enough and self.contrast >= CLEAR_CONTRAST

    def factor(self) -> float:
        """Return the ratio of largest to smallest median; NaN if it is zero or undefined."""
        if not np.isfinite(self.medians).any():
            return np.nan
        smallest, largest = (self.medians[place] for place in self.extremes())
        return largest / smallest if smallest > 0.0 else np.nan


def main_effects(study: Study, column: str) -> list[MainEffect]:
    """Return the main effects of all swept axes on a figure over the finished cases, the strongest first."""
    return study.cases.once(("effects", column), lambda: _main_effects(study, column))


def _main_effects(study: Study, column: str) -> list[MainEffect]:
    axes, values = study.levels(), study.cases[column].to_numpy(float)
    places = [study.places(axis) for axis in axes]
    shares = explained(values, places)
    effects = []
    for axis, place, share in zip(axes, places, shares, strict=True):
        groups = [values[cases] for cases in grouped(np.where(np.isfinite(values), place, -1), len(axis.values))]
        quantiles = np.array([np.percentile(group, (50, 10, 90)) if len(group) else [np.nan] * 3 for group in groups])
        medians, low, high = quantiles.T
        effects.append(MainEffect(axis, column, medians, low, high, *share))
    return sorted(effects, key=lambda effect: (-np.nan_to_num(effect.share), -np.nan_to_num(effect.factor())))


def explained(values: np.ndarray, places: list[np.ndarray]) -> list[tuple[float, float]]:
    """Return, for each axis, its share of the variance of log(values), corrected for chance, and its F ratio.

    `places` : per axis the index of each case on it, (cases,).  The scatter is the residual of the sum of all main
    effects
    (analysis of variance without interactions); without degrees of freedom both are NaN.
    """
    known = np.isfinite(values) & (values > 0.0)
    rest = np.log(values[known])  # the largest array here, so there is only one
    groups = [_numbered(place[known]) for place in places]
    freedoms = [int(group.max(initial=0)) for group in groups]
    spare = len(rest) - 1 - sum(freedoms)
    rest -= rest.mean() if len(rest) else 0.0
    total = float(rest @ rest)
    if spare <= 0 or total <= 1e-20 * len(rest):  # all values equal, except for rounding
        return [(np.nan, np.nan)] * len(places)
    between = [float(np.bincount(group) @ _means(group, rest) ** 2) for group in groups]
    for _ in range(PASSES):
        for group in groups:
            rest -= _means(group, rest)[group]
    scatter = max(float(rest @ rest) / spare, 1e-12 * total)
    return [
        (max(0.0, (part - freedom * scatter) / total), part / freedom / scatter if freedom else np.nan)
        for part, freedom in zip(between, freedoms, strict=True)
    ]


def _numbered(places: np.ndarray) -> np.ndarray:
    """Return indices (from -1) renumbered without gaps, in the same order."""
    return (np.cumsum(np.bincount(places + 1) > 0) - 1).astype(places.dtype)[places + 1]


def _means(group: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.bincount(group, values) / np.bincount(group)
