"""Main effects of swept values on a figure: medians over the values, share of the variation."""

from typing import NamedTuple

import numpy as np

from ...answers import blocks, variance
from ..data.axis import Axis
from ..data.comparable import comparable_values
from ..data.study import Study, indices_by_value


class MainEffect(NamedTuple):
    """The main effect of one axis on one figure, over blocks of cases that differ on this axis alone."""

    axis: Axis
    column: str
    medians: np.ndarray  # (values,) SI; NaN without a finished case
    low: np.ndarray  # (values,) 10th percentile
    high: np.ndarray  # (values,) 90th percentile
    share: float  # of the figure's variance, corrected for chance, 0 to 1; NaN: undefined
    verdict: str  # of answers.blocks

    def extreme_indices(self) -> tuple[int, int]:
        """Return the indices of the smallest and the largest median."""
        return int(np.nanargmin(self.medians)), int(np.nanargmax(self.medians))

    def factor(self) -> float:
        """Return the ratio of largest to smallest median; NaN unless both are positive."""
        low, high = float(np.nanmin(self.medians)), float(np.nanmax(self.medians))
        return high / low if low > 0.0 else np.nan


def main_effects_of(study: Study, column: str) -> list[MainEffect]:
    """Return the main effects of all swept axes on a figure over the finished cases, the strongest first."""
    return study.cases.cached(("effects", column), lambda: _main_effects(study, column))


def _main_effects(study: Study, column: str) -> list[MainEffect]:
    levels, values = study.levels(), comparable_values(study, column)
    codes = {axis.path: study.indices_on(axis) for axis in study.swept()}
    shares = variance.variance_shares(values, [codes[axis.path] for axis in levels])
    effects = []
    for axis, share in zip(levels, shares, strict=True):
        of_axis = blocks.Axis((axis.path,), list(axis.values), codes[axis.path])
        matched = blocks.known_blocks(codes, of_axis, values)
        if not matched:
            continue
        rows = np.concatenate(matched)
        groups = [values[rows[group]] for group in indices_by_value(codes[axis.path][rows], len(axis.values))]
        quantiles = [np.percentile(group, (50, 10, 90)) if len(group) else [np.nan] * 3 for group in groups]
        medians, low, high = np.array(quantiles).T
        verdict = blocks.verdict_on(of_axis, matched, values)
        effects.append(MainEffect(axis, column, medians, low, high, share, verdict))
    return sorted(effects, key=lambda effect: (-np.nan_to_num(effect.share), -float(np.nanmax(effect.medians))))
