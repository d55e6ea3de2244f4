"""Sentences on the cases of one random sample: the spread of a figure, and the variables that drive it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..language import wording
from . import ranks
from .probability import Estimate, is_one_sample

__all__ = ["causes", "correlations", "is_clear", "is_one_sample", "spread"]

LEAST = 8  # cases: correlations of fewer are meaningless
QUANTILES = (0.05, 0.5, 0.95)


def correlations(drawn: Mapping[str, np.ndarray], values: np.ndarray) -> list[tuple[str, Estimate, Estimate]]:
    """Return variable, rank correlation with a figure, and partial rank correlation, the strongest first.

    [] with too few cases, and for a constant figure.  drawn : path -> (n,) values; values : (n,), NaN for null
    """
    known = np.isfinite(values)
    if known.sum() < LEAST or np.ptp(values[known]) == 0.0:
        return []
    rows, there = [], {path: np.asarray(each, float)[known] for path, each in drawn.items()}
    for path, x in there.items():
        others = [other for name, other in there.items() if name != path]
        alone = ranks.rank_correlation(x, values[known])
        rows.append((path, alone, ranks.partial_rank_correlation(x, values[known], others)))
    return sorted(rows, key=lambda each: -abs(np.nan_to_num(each[2].value)))


def is_clear(correlation: Estimate) -> bool:
    """Return whether the interval of a correlation excludes 0."""
    return correlation.low > 0.0 or correlation.high < 0.0


def causes(figure: str, known: Sequence[tuple[str, Estimate, Estimate]], names: Mapping[str, str]) -> str:
    """Return the variables that drive a figure, the strongest first, and those without a clear effect.

    figure : 'the force peak', or a column; known : as `correlations` returns it; names : path -> words
    """
    clear = [(names[path], partial) for path, _, partial in known if is_clear(partial)]
    weak = [names[path] for path, _, partial in known if not is_clear(partial)]
    if not clear:
        return f"No variable has a clear effect on {figure}."
    correlations_text = [
        f"{name} ({wording.plain(each.value, 2)}; 95 %: {wording.plain(each.low, 2)} to {wording.plain(each.high, 2)})"
        for name, each in clear
    ]
    text = f"What drives {figure}, by rank correlation with the other variables fixed: "
    text += f"{wording.sentence_list(correlations_text)}."
    return text + (f" No clear effect on it: {wording.sentence_list(weak)}." if weak else "")


def spread(name: str, texts: Sequence[str], sure: str = "", where: str = "") -> str:
    """Return the sentence on the spread of a figure; texts : its QUANTILES in words."""
    low, middle, high = texts
    return f"{name}{where}: median {middle}{sure}; 90 % of the cases are between {low} and {high}."


def drawn_of(record: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return the drawn values of a sample in run.json."""
    return {path: np.asarray(values, float) for path, values in record["sample"]["drawn"].items()}
