"""Effects of varied values on a figure in words: direction and size, the strongest first."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..language import wording
from . import interactions, labels
from .cases import FinishedCases, range_text
from .variance import is_clear, largest_over_smallest, variance_shares

MAX_LEVELS = 30  # distinct values of an axis above which its levels are not compared
MAX_EFFECTS = 3  # effects on one figure in words
MIN_SHARE = 0.01  # of the variation: an axis with less has little effect
MAX_REVERSAL = 0.1  # of the range of the medians: smaller reversals leave a trend monotone
RANK_PHRASES, FIGURE_PRONOUN = ("Strongest effect: ", "Next: ", "Then: "), "it"

ValueFormatter = Callable[[Sequence[float]], list[str]]


class Effect(NamedTuple):
    """The effect of one axis on one figure, over all values of the other axes."""

    path: str  # of the axis
    example_cases: tuple[int, ...]  # index of a case with each value; numbers ascend
    is_numeric: bool  # whether the values are numbers
    medians: np.ndarray  # (values,) SI, finite
    is_grouped: bool  # whether a value has several cases
    variance_share: (
        float  # part of the variance of the figure's logarithm, corrected for chance, 0 to 1; NaN: undefined
    )
    f_ratio: float  # variance between the values over the variance not explained by any axis (F ratio); NaN: undefined


def rank_effects(cases: FinishedCases, figure_values: np.ndarray) -> list[Effect]:
    """Return the effects of the axes on a figure, the strongest first; values : (n,) SI, NaN for null."""
    sampled_paths = (cases.record.get("sample") or {}).get("drawn", {})
    axis_levels = [(path, *_levels(cases.values_of(path))) for path in cases.varied_paths if path not in sampled_paths]
    axis_levels = [entry for entry in axis_levels if 1 < len(entry[1]) <= MAX_LEVELS]
    shares_and_ratios = variance_shares(figure_values, [level_indices for _, _, level_indices in axis_levels])
    effects = []
    for (path, distinct_values, level_indices), share_and_ratio in zip(axis_levels, shares_and_ratios, strict=True):
        groups = [
            np.flatnonzero((level_indices == level_index) & np.isfinite(figure_values))
            for level_index in range(len(distinct_values))
        ]
        groups = [group for group in groups if group.size]
        if len(groups) < 2:
            continue
        medians = np.array([np.median(figure_values[group]) for group in groups])
        is_numeric = not isinstance(distinct_values[0], str)
        example_cases, is_grouped = tuple(int(group[0]) for group in groups), any(group.size > 1 for group in groups)
        effects.append(Effect(path, example_cases, is_numeric, medians, is_grouped, *share_and_ratio))
    return sorted(
        effects,
        key=lambda entry: (-np.nan_to_num(entry.variance_share), -np.nan_to_num(largest_over_smallest(entry.medians))),
    )


def sentences(
    cases: FinishedCases,
    label: str,
    figure_values: np.ndarray,
    format_values: ValueFormatter,
    max_effects: int = MAX_EFFECTS,
) -> list[str]:
    """Return sentences on the clear effects on a figure with direction and size, and on values without effect.

    label : name of the figure; format_values : returns values of the figure in words, in one unit
    """
    effects = rank_effects(cases, figure_values) if cases.is_complete else []
    if not effects or not np.isfinite(figure_values).any():
        return []
    clear_effects = [
        effect for effect in effects if is_clear(effect.medians, effect.f_ratio) and _is_relevant(effect, effects)
    ]
    if not clear_effects:
        return [] if label == FIGURE_PRONOUN else [f"No varied value has a clear effect on the {label}."]
    effect_sentences, reported_effects = [], clear_effects[:max_effects]
    for rank, effect in enumerate(reported_effects):
        lead_in = RANK_PHRASES[min(rank, len(RANK_PHRASES) - 1)] if len(reported_effects) > 1 else ""
        effect_text = (
            _effect_text(cases, effect, label, format_values)
            if rank == 0
            else _effect_text(cases, effect, FIGURE_PRONOUN, format_values, note="")
        )
        effect_sentences.append(labels.capitalise(lead_in + effect_text))
    return [
        *effect_sentences,
        *(
            _unclear_effect_sentences(
                cases, [other for other in effects if other not in clear_effects], label, figure_values, format_values
            )
            if max_effects > 1
            else []
        ),
    ]


def _unclear_effect_sentences(
    cases: FinishedCases,
    unclear_effects: list[Effect],
    label: str,
    figure_values: np.ndarray,
    format_values: ValueFormatter,
) -> list[str]:
    """Return sentences on values without a clear effect of their own: crossover interactions, then little effects.

    Crossover interactions with the other axes cancel in the medians.
    """
    sentence_by_path = {
        effect.path: interactions.crossover_interaction_sentence(
            cases, effect.path, label, figure_values, format_values
        )
        for effect in unclear_effects
        if effect.is_numeric
    }
    negligible_names = [
        _axis_name(cases, effect) for effect in unclear_effects if not sentence_by_path.get(effect.path)
    ]
    crossover_sentences = [sentence for sentence in sentence_by_path.values() if sentence]
    return [
        *crossover_sentences,
        *([f"Little or no effect: {wording.sentence_list(negligible_names)}."] if negligible_names else []),
    ]


def _effect_text(
    cases: FinishedCases, effect: Effect, subject: str, format_values: ValueFormatter, note: str = " (medians)"
) -> str:
    """Return an effect: 'force peak rises from 1 to 2 kN (medians) as crank speed grows from 20 to 60 rpm.'."""
    axis_name, medians = _axis_name(cases, effect), effect.medians
    note = note if effect.is_grouped else ""
    if effect.is_numeric and _is_monotone(medians):
        verb = "rises" if medians[-1] > medians[0] else "falls"
        medians_text = range_text(*format_values([float(medians[0]), float(medians[-1])]))
        levels_text = range_text(_level_text(cases, effect, 0), _level_text(cases, effect, -1))
        return f"{subject} {verb} {medians_text}{note} as {axis_name} grows {levels_text}."
    lowest, highest = int(medians.argmin()), int(medians.argmax())
    smallest, largest = format_values([float(medians[lowest]), float(medians[highest])])
    location = f"at {axis_name} {_level_text(cases, effect, lowest)}"
    return (
        f"{subject} is smallest, {smallest}, {location} and largest, {largest}, at "
        f"{_level_text(cases, effect, highest)}{note}."
    )


def _is_relevant(effect: Effect, effects: list[Effect]) -> bool:
    """Return whether an effect is the only one, or explains more than a hundredth of the variation."""
    return len(effects) == 1 or not effect.variance_share < MIN_SHARE


def _is_monotone(medians: np.ndarray) -> bool:
    """Return whether medians rise or fall throughout, with their extremes at the ends."""
    steps = np.sign(medians[-1] - medians[0]) * np.diff(medians)
    medians_range = medians.max() - medians.min()
    return bool(steps.min() >= -MAX_REVERSAL * medians_range) and {int(medians.argmin()), int(medians.argmax())} == {
        0,
        len(medians) - 1,
    }


def _axis_name(cases: FinishedCases, effect: Effect) -> str:
    """Return the name of an effect's axis in words."""
    name_and_value = cases.describe_value(effect.example_cases[0], effect.path)
    return name_and_value[0] if name_and_value else effect.path


def _level_text(cases: FinishedCases, effect: Effect, level_index: int) -> str:
    """Return the value of an effect's axis with index `level`, with its unit."""
    name_and_value = cases.describe_value(effect.example_cases[level_index], effect.path)
    return name_and_value[1] if name_and_value else ""


def _levels(axis_values: np.ndarray) -> tuple[list, np.ndarray]:
    """Return the distinct values of an axis, numbers ascending, and the index of each case's value (-1: no value)."""
    if axis_values.dtype.kind in "fiub":
        unique_values, indices = np.unique(axis_values, return_inverse=True)
        is_finite = np.isfinite(unique_values.astype(float))
        return unique_values[is_finite].tolist(), np.where(is_finite[indices], indices, -1)
    present_values = [value for value in axis_values.tolist() if not wording.is_missing(value)]
    has_text = any(isinstance(value, str) for value in present_values)
    distinct_values = list(dict.fromkeys(present_values)) if has_text else sorted(set(present_values))
    index_of = {value: index for index, value in enumerate(distinct_values)}
    return distinct_values, np.array([index_of.get(value, -1) for value in axis_values.tolist()], int)
