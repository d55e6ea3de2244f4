"""Crossover interactions: a value raises a figure in some combinations of the other values and lowers it in others."""

from collections.abc import Callable, Sequence

import numpy as np

from ..language import wording
from .cases import FinishedCases, range_text
from .variance import MIN_EFFECT_RATIO, largest_over_smallest

MAX_OTHER_LEVELS = 6  # values of the other axis above which its levels are not compared


ValueFormatter = Callable[[Sequence[float]], list[str]]


def crossover_interaction_sentence(
    cases: FinishedCases, axis: str, label: str, values: np.ndarray, format_values: ValueFormatter
) -> str:
    """Return a sentence on the crossover interactions of a number on a figure, or '' if it has none.

    axis : of the number; label : name of the figure; values : (n,) SI, NaN for null; format_values : in words
    """
    rising_count, falling_count = _count_trends(cases, axis, values)
    trend_sentences = (
        _opposite_trend_sentences(cases, axis, values, format_values) if min(rising_count, falling_count) > 0 else []
    )
    if not trend_sentences:  # scatter without a cause
        return ""
    name_and_value = cases.describe_value(0, axis)
    name, combination_count_text = (
        name_and_value[0] if name_and_value else axis,
        wording.count_text(rising_count + falling_count, "combination"),
    )
    text = (
        f"Opposite effects: as {name} grows, {label} rises in {rising_count} of {combination_count_text} of the other "
        f"values and falls in {falling_count}."
    )
    return " ".join([text, *trend_sentences])


def _count_trends(cases: FinishedCases, axis: str, values: np.ndarray) -> tuple[int, int]:
    """Return the numbers of combinations of the other values in which a figure clearly rises and falls on an axis."""
    trends = [
        _trend(cases.values_of(axis)[group], values[group]) for group in _case_indices_by_group(cases, axis, None)
    ]
    return sum(trend > 0 for trend in trends), sum(trend < 0 for trend in trends)


def _case_indices_by_group(cases: FinishedCases, path: str, group_axis: str | None) -> list[np.ndarray]:
    """Return the cases with equal values at all axes but `path`, or at `group_axis` only, in order of appearance.

    Cases without a value at `path` are left out.
    """
    is_used = ~np.isnan(cases.values_of(path).astype(float))
    equal_axes = [group_axis] if group_axis else [axis for axis in cases.varied_paths if axis != path]
    columns = [cases.values_of(axis) for axis in equal_axes]
    groups: dict[tuple, list[int]] = {}
    for index in np.flatnonzero(is_used).tolist():
        groups.setdefault(tuple(str(column[index]) for column in columns), []).append(index)
    return [np.array(group) for group in groups.values()]


def _medians(x_values: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the median of the known values (n,) at each distinct x value (n,), ascending."""
    is_known = np.isfinite(values)
    return np.array([np.median(values[is_known & (x_values == number)]) for number in np.unique(x_values[is_known])])


def _trend(x_values: np.ndarray, values: np.ndarray) -> int:
    """Return 1 if values clearly rise with `x_values`, -1 if they clearly fall, 0 otherwise."""
    medians = _medians(x_values, values)
    if len(medians) < 2 or not largest_over_smallest(medians[[0, -1]]) >= MIN_EFFECT_RATIO:
        return 0
    return 1 if medians[-1] > medians[0] else -1


def _opposite_trend_sentences(
    cases: FinishedCases, axis: str, values: np.ndarray, format_values: ValueFormatter
) -> list[str]:
    """Return a sentence on an axis at whose smallest and largest value the medians have opposite trends, or []."""
    for other_axis in cases.varied_paths:
        column = cases.values_of(other_axis)
        if other_axis == axis or isinstance(column[0], str) or len(np.unique(column)) > MAX_OTHER_LEVELS:
            continue
        groups = sorted(_case_indices_by_group(cases, axis, other_axis), key=lambda group: float(column[group[0]]))
        outer_groups = [groups[0], groups[-1]]
        trends = [_trend(cases.values_of(axis)[group], values[group]) for group in outer_groups]
        if trends[0] * trends[1] == -1:
            clauses = []
            for group, trend in zip(outer_groups, trends, strict=True):
                medians = _medians(cases.values_of(axis)[group], values[group])
                medians_text = range_text(*format_values([float(medians[0]), float(medians[-1])]))
                setting_text = cases.values_text(int(group[0]), (other_axis,))
                clauses.append(f"at {setting_text} it {'rises' if trend > 0 else 'falls'} {medians_text}")
            return [f"In the medians, {clauses[0]}; {clauses[1]}."]
    return []
