"""Rank correlations of the drawn variables of a sample with a figure."""

from collections.abc import Mapping

import numpy as np

from . import ranks
from .probability import Estimate, is_one_sample

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
        simple_correlation = ranks.rank_correlation(variable, values[is_known])
        rows.append((path, simple_correlation, ranks.partial_rank_correlation(variable, values[is_known], others)))
    return sorted(rows, key=lambda row: -abs(np.nan_to_num(row[2].value)))


def is_clear(correlation: Estimate) -> bool:
    """Return whether the interval of a correlation excludes 0."""
    return correlation.low > 0.0 or correlation.high < 0.0


def direction_verb(correlation: float) -> str:
    """Return 'rises' or 'falls', the trend of a figure with a variable."""
    return "rises" if correlation > 0.0 else "falls"
