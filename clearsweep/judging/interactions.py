"""Opposite effects: a value that raises a figure in some combinations of the other values and lowers it in others."""

from collections.abc import Callable, Sequence

import numpy as np

from ..language import wording
from .cases import Cases, range_text
from .variance import CLEAR_FACTOR, largest_over_smallest

MOST_LEVELS = 6  # values of the other axis above which its levels are not compared


Texts = Callable[[Sequence[float]], list[str]]


def sentence(cases: Cases, path: str, label: str, values: np.ndarray, texts: Texts) -> str:
    """Return a sentence on the opposite effects of a number on a figure, or '' if it has none.

    path : of the number; label : name of the figure; values : (n,) SI, NaN for null; texts : returns them in words
    """
    rising, falling = _counts(cases, path, values)
    split = _split(cases, path, values, texts) if min(rising, falling) > 0 else []
    if not split:  # scatter without a cause
        return ""
    pair = cases.named_value(0, path)
    name, combinations = pair[0] if pair else path, wording.count(rising + falling, "combination")
    text = (
        f"Opposite effects: as {name} grows, {label} rises in {rising} of {combinations} of the other values and "
        f"falls in {falling}."
    )
    return " ".join([text, *split])


def _counts(cases: Cases, path: str, values: np.ndarray) -> tuple[int, int]:
    """Return the numbers of combinations of the other values in which a figure clearly rises and falls with a path."""
    trends = [_trend(cases.column(path)[group], values[group]) for group in _groups(cases, path, None)]
    return sum(trend > 0 for trend in trends), sum(trend < 0 for trend in trends)


def _groups(cases: Cases, path: str, by: str | None) -> list[np.ndarray]:
    """Return the cases with equal values at all axes but `path`, or at the axis `by` only, in order of appearance.

    Cases without a value at `path` are left out.
    """
    is_used = ~np.isnan(cases.column(path).astype(float))
    others = [by] if by else [axis for axis in cases.axes if axis != path]
    columns = [cases.column(other) for other in others]
    groups: dict[tuple, list[int]] = {}
    for index in np.flatnonzero(is_used).tolist():
        groups.setdefault(tuple(str(column[index]) for column in columns), []).append(index)
    return [np.array(group) for group in groups.values()]


def _medians(numbers: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the median of the known values (n,) at each distinct number (n,), numbers ascending."""
    known = np.isfinite(values)
    return np.array([np.median(values[known & (numbers == each)]) for each in np.unique(numbers[known])])


def _trend(numbers: np.ndarray, values: np.ndarray) -> int:
    """Return 1 if values clearly rise with numbers, -1 if they clearly fall, 0 otherwise."""
    medians = _medians(numbers, values)
    if len(medians) < 2 or not largest_over_smallest(medians[[0, -1]]) >= CLEAR_FACTOR:
        return 0
    return 1 if medians[-1] > medians[0] else -1


def _split(cases: Cases, path: str, values: np.ndarray, texts: Texts) -> list[str]:
    """Return a sentence on an axis at whose smallest and largest value the medians have opposite trends, or []."""
    for other in cases.axes:
        column = cases.column(other)
        if other == path or isinstance(column[0], str) or len(np.unique(column)) > MOST_LEVELS:
            continue
        groups = sorted(_groups(cases, path, other), key=lambda group: float(column[group[0]]))
        ends = [groups[0], groups[-1]]
        trends = [_trend(cases.column(path)[group], values[group]) for group in ends]
        if trends[0] * trends[1] == -1:
            said = []
            for group, trend in zip(ends, trends, strict=True):
                medians = _medians(cases.column(path)[group], values[group])
                span = range_text(*texts([float(medians[0]), float(medians[-1])]))
                setting = cases.setting(int(group[0]), (other,))
                said.append(f"at {setting} it {'rises' if trend > 0 else 'falls'} {span}")
            return [f"In the medians, {said[0]}; {said[1]}."]
    return []
