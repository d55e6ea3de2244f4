"""Effects of varied values on a figure in words: direction and size, the strongest first."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..language import wording
from . import interactions, labels
from .cases import Cases, range_text
from .variance import is_clear, largest_over_smallest, variance_shares

MAX_LEVELS = 30  # distinct values of an axis above which its levels are not compared
MAX_EFFECTS = 3  # effects on one figure in words
MIN_SHARE = 0.01  # of the variation: an axis with less has little effect
MAX_REVERSAL = 0.1  # of the range of the medians: smaller reversals leave a trend monotone
LEAD_INS, PRONOUN = ("Strongest effect: ", "Next: ", "Then: "), "it"

Texts = Callable[[Sequence[float]], list[str]]


class Effect(NamedTuple):
    """The effect of one axis on one figure, over all values of the other axes."""

    path: str
    cases: tuple[int, ...]  # index of a case with each value; numbers ascend
    numeric: bool
    medians: np.ndarray  # (values,) SI, finite
    is_grouped: bool  # whether a value has several cases
    share: float  # of the variance of the figure's logarithm, corrected for chance, 0 to 1; NaN: undefined
    f_ratio: float  # variance between the values over the variance not explained by any axis (F ratio); NaN: undefined


def effects_on(cases: Cases, values: np.ndarray) -> list[Effect]:
    """Return the effects of the axes on a figure, the strongest first; values : (n,) SI, NaN for null."""
    drawn = (cases.record.get("sample") or {}).get("drawn", {})
    levels = [(path, *_levels(cases.column(path))) for path in cases.axes if path not in drawn]
    levels = [effect for effect in levels if 1 < len(effect[1]) <= MAX_LEVELS]
    shares = variance_shares(values, [level_indices for _, _, level_indices in levels])
    effects = []
    for (path, uniques, level_indices), share in zip(levels, shares, strict=True):
        groups = [np.flatnonzero((level_indices == level) & np.isfinite(values)) for level in range(len(uniques))]
        groups = [group for group in groups if group.size]
        if len(groups) < 2:
            continue
        medians = np.array([np.median(values[group]) for group in groups])
        numeric = not isinstance(uniques[0], str)
        first, is_grouped = tuple(int(group[0]) for group in groups), any(group.size > 1 for group in groups)
        effects.append(Effect(path, first, numeric, medians, is_grouped, *share))
    return sorted(
        effects,
        key=lambda effect: (-np.nan_to_num(effect.share), -np.nan_to_num(largest_over_smallest(effect.medians))),
    )


def sentences(cases: Cases, label: str, values: np.ndarray, texts: Texts, most: int = MAX_EFFECTS) -> list[str]:
    """Return sentences on the clear effects on a figure with direction and size, and on values without effect.

    label : name of the figure; texts : returns values of the figure in words, in one unit
    """
    effects = effects_on(cases, values) if cases.is_complete else []
    if not effects or not np.isfinite(values).any():
        return []
    clear = [effect for effect in effects if is_clear(effect.medians, effect.f_ratio) and _is_large(effect, effects)]
    if not clear:
        return [] if label == PRONOUN else [f"No varied value has a clear effect on the {label}."]
    lines, reported = [], clear[:most]
    for rank, effect in enumerate(reported):
        beginning = LEAD_INS[min(rank, len(LEAD_INS) - 1)] if len(reported) > 1 else ""
        text = (
            _effect_text(cases, effect, label, texts)
            if rank == 0
            else _effect_text(cases, effect, PRONOUN, texts, note="")
        )
        lines.append(labels.capital(beginning + text))
    return [
        *lines,
        *(
            _unclear_effect_sentences(cases, [other for other in effects if other not in clear], label, values, texts)
            if most > 1
            else []
        ),
    ]


def _unclear_effect_sentences(
    cases: Cases, weak: list[Effect], label: str, values: np.ndarray, texts: Texts
) -> list[str]:
    """Return sentences on values without a clear effect of their own: opposite effects, then those with little effect.

    Opposite effects at different values of the other axes cancel in the medians.
    """
    sentence_by_path = {
        effect.path: interactions.sentence(cases, effect.path, label, values, texts)
        for effect in weak
        if effect.numeric
    }
    negligible = [_axis_name(cases, effect) for effect in weak if not sentence_by_path.get(effect.path)]
    lines = [sentence for sentence in sentence_by_path.values() if sentence]
    return [*lines, *([f"Little or no effect: {wording.sentence_list(negligible)}."] if negligible else [])]


def _effect_text(cases: Cases, effect: Effect, subject: str, texts: Texts, note: str = " (medians)") -> str:
    """Return an effect: 'force peak rises from 1 to 2 kN (medians) as crank speed grows from 20 to 60 rpm.'."""
    name, medians = _axis_name(cases, effect), effect.medians
    note = note if effect.is_grouped else ""
    if effect.numeric and _is_monotone(medians):
        verb = "rises" if medians[-1] > medians[0] else "falls"
        span = range_text(*texts([float(medians[0]), float(medians[-1])]))
        ends = range_text(_level_text(cases, effect, 0), _level_text(cases, effect, -1))
        return f"{subject} {verb} {span}{note} as {name} grows {ends}."
    low, high = int(medians.argmin()), int(medians.argmax())
    smallest, largest = texts([float(medians[low]), float(medians[high])])
    at = f"at {name} {_level_text(cases, effect, low)}"
    return (
        f"{subject} is smallest, {smallest}, {at} and largest, {largest}, at {_level_text(cases, effect, high)}{note}."
    )


def _is_large(effect: Effect, effects: list[Effect]) -> bool:
    """Return whether an effect is the only one, or explains more than a hundredth of the variation."""
    return len(effects) == 1 or not effect.share < MIN_SHARE


def _is_monotone(medians: np.ndarray) -> bool:
    """Return whether medians rise or fall throughout, with their extremes at the ends."""
    steps = np.sign(medians[-1] - medians[0]) * np.diff(medians)
    span = medians.max() - medians.min()
    return bool(steps.min() >= -MAX_REVERSAL * span) and {int(medians.argmin()), int(medians.argmax())} == {
        0,
        len(medians) - 1,
    }


def _axis_name(cases: Cases, effect: Effect) -> str:
    pair = cases.named_value(effect.cases[0], effect.path)
    return pair[0] if pair else effect.path


def _level_text(cases: Cases, effect: Effect, level: int) -> str:
    pair = cases.named_value(effect.cases[level], effect.path)
    return pair[1] if pair else ""


def _levels(column: np.ndarray) -> tuple[list, np.ndarray]:
    """Return the distinct values of an axis, numbers ascending, and the index of each case's value (-1: no value)."""
    if column.dtype.kind in "fiub":
        values, indices = np.unique(column, return_inverse=True)
        is_finite = np.isfinite(values.astype(float))
        return values[is_finite].tolist(), np.where(is_finite[indices], indices, -1)
    present = [value for value in column.tolist() if not wording.is_missing(value)]
    has_text = any(isinstance(value, str) for value in present)
    uniques = list(dict.fromkeys(present)) if has_text else sorted(set(present))
    index_of = {value: index for index, value in enumerate(uniques)}
    return uniques, np.array([index_of.get(value, -1) for value in column.tolist()], int)
