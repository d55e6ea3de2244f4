"""Analysis of variance of a figure over varied values: the share of each."""

import numpy as np

PASSES = 20  # of the fit of main effects; one is exact if every combination finished


def variance_shares(values: np.ndarray, value_indices: list[np.ndarray]) -> list[float]:
    """Return, for each axis, its share of the variance of a figure, corrected for chance; NaN: undefined.

    The variance is that of log(values) where all values are positive, else that of the values.
    `value_indices` : per axis the index of each case on it, (cases,).  The scatter is the residual of the sum of all
    main effects (analysis of variance without interactions); without degrees of freedom no share is defined.
    """
    is_known = np.isfinite(values)
    known = values[is_known]
    is_positive = bool((known > 0.0).all())
    residuals = np.log(known) if is_positive else known / max(float(np.abs(known).max(initial=0.0)), 1e-300)
    groups = [_renumbered(indices[is_known]) for indices in value_indices]
    freedoms = [int(group.max(initial=0)) for group in groups]
    residual_freedom = len(residuals) - 1 - sum(freedoms)
    residuals -= residuals.mean() if len(residuals) else 0.0
    total = float(residuals @ residuals)
    if residual_freedom <= 0 or total <= 1e-20 * len(residuals):  # all values equal, except for rounding
        return [np.nan] * len(value_indices)
    sums_between = [float(np.bincount(group) @ _group_means(group, residuals) ** 2) for group in groups]
    for _ in range(PASSES):
        for group in groups:
            residuals -= _group_means(group, residuals)[group]
    scatter = max(float(residuals @ residuals) / residual_freedom, 1e-12 * total)
    between = zip(sums_between, freedoms, strict=True)
    return [max(0.0, (sum_of_squares - freedom * scatter) / total) for sum_of_squares, freedom in between]


def _renumbered(indices: np.ndarray) -> np.ndarray:
    """Return indices (from -1) renumbered without gaps, in the same order."""
    renumbered: np.ndarray = (np.cumsum(np.bincount(indices + 1) > 0) - 1).astype(indices.dtype)[indices + 1]
    return renumbered


def _group_means(group: np.ndarray, values: np.ndarray) -> np.ndarray:
    means: np.ndarray = np.bincount(group, values) / np.bincount(group)
    return means
