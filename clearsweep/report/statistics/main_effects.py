"""Main effects of swept values on a figure: medians over the values, share of the variation."""

from typing import NamedTuple

import numpy as np

from ...answers import variance
from ..data.axis import Axis
from ..data.comparable import comparable_values
from ..data.study import Study, indices_by_value


class MainEffect(NamedTuple):
    """The main effect of one axis on one figure, averaged over all values of the other axes."""

    axis: Axis
    column: str
    medians: np.ndarray  # (values,) SI; NaN without a finished case
    low: np.ndarray  # (values,) 10th percentile
    high: np.ndarray  # (values,) 90th percentile
    share: float  # of the variance of the figure's logarithm, corrected for chance, 0 to 1; NaN: undefined
    f_ratio: float  # variance between the values over the variance not explained by any axis (F ratio); NaN: undefined

    def extreme_indices(self) -> tuple[int, int]:
        """Return the indices of the smallest and the largest median."""
        return int(np.nanargmin(self.medians)), int(np.nanargmax(self.medians))

    def is_clear(self) -> bool:
        """Return whether the effect of the axis exceeds the scatter."""
        return variance.is_clear(self.medians, self.f_ratio)

    def factor(self) -> float:
        """Return the ratio of largest to smallest median; NaN if it is zero or undefined."""
        return variance.largest_over_smallest(self.medians)


def main_effects_of(study: Study, column: str) -> list[MainEffect]:
    """Return the main effects of all swept axes on a figure over the finished cases, the strongest first."""
    return study.cases.cached(("effects", column), lambda: _main_effects(study, column))


def _main_effects(study: Study, column: str) -> list[MainEffect]:
    axes, values = study.levels(), comparable_values(study, column)
    value_indices = [study.indices_on(axis) for axis in axes]
    shares_and_ratios = variance.variance_shares(values, value_indices)
    effects = []
    for axis, indices, share_and_ratio in zip(axes, value_indices, shares_and_ratios, strict=True):
        groups = [
            values[cases] for cases in indices_by_value(np.where(np.isfinite(values), indices, -1), len(axis.values))
        ]
        quantiles = np.array([np.percentile(group, (50, 10, 90)) if len(group) else [np.nan] * 3 for group in groups])
        medians, low, high = quantiles.T
        effects.append(MainEffect(axis, column, medians, low, high, *share_and_ratio))
    return sorted(effects, key=lambda effect: (-np.nan_to_num(effect.share), -np.nan_to_num(effect.factor())))
