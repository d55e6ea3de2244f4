"""Extremes of the polynomials over recorded steps."""

import numpy as np

from ...mechanics.solver.signal_sums import EXCESS, FINE_POINTS, NODE_COUNT, TO_FINE_POINTS, values_at

ZOOM_POINTS = FINE_POINTS[0] * np.linspace(-1.0, 1.0, 65)  # about the largest of the fine points


def largest_size(values: np.ndarray, bound: float) -> float:
    """Return the largest size of values (steps, ..., nodes) in recorded steps and between their nodes, or `bound`.

    Between nodes only steps are searched whose values there may be larger.
    """
    flat = values.reshape(-1, NODE_COUNT)
    low, high = flat.min(axis=1), flat.max(axis=1)
    size = np.maximum(high, -low)
    largest = max(bound, float(size.max()))
    candidates = flat[size + EXCESS * (high - low) > largest]
    fine = np.abs(candidates @ TO_FINE_POINTS)
    if not fine.size or fine.max() <= bound:
        return largest
    step, point = np.unravel_index(int(fine.argmax()), fine.shape)
    nearby = np.clip(FINE_POINTS[point] + ZOOM_POINTS, 0.0, 1.0)
    return max(largest, float(np.abs(candidates[step] @ values_at(nearby)).max()))
