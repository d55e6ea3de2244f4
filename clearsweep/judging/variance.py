"""Analysis of variance of a figure over varied values: their shares, and whether an effect exceeds the scatter."""

import numpy as np

CLEAR_FACTOR = 1.05  # ratio of largest to smallest median below which an axis has no clear effect
CLEAR_CONTRAST = 4.0  # F ratio below which it has none
PASSES = 20  # of the fit of main effects; one is exact if every combination finished


def is_clear(medians: np.ndarray, contrast: float) -> bool:
    """Return whether an effect exceeds the scatter; without scatter (NaN), decide by its medians."""
    enough = bool(factor(medians) >= CLEAR_FACTOR)
    return enough if np.isnan(contrast) else enough and contrast >= CLEAR_CONTRAST


def factor(medians: np.ndarray) -> float:
    """Return the ratio of largest to smallest median; NaN if it is zero or undefined."""
    known = medians[np.isfinite(medians)]
    return float(known.max() / known.min()) if known.size and known.min() > 0.0 else np.nan


def explained(values: np.ndarray, places: list[np.ndarray]) -> list[tuple[float, float]]:
    """Return, for each axis, its share of the variance of log(values), corrected for chance, and its F ratio.

    `places` : per axis the index of each case on it, (cases,).  The scatter is the residual of the sum of all main
    effects (analysis of variance without interactions); without degrees of freedom both are NaN.
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
    numbered: np.ndarray = (np.cumsum(np.bincount(places + 1) > 0) - 1).astype(places.dtype)[places + 1]
    return numbered


def _means(group: np.ndarray, values: np.ndarray) -> np.ndarray:
    means: np.ndarray = np.bincount(group, values) / np.bincount(group)
    return means
