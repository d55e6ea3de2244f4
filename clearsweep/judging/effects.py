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
FIRST, NEXT = ("Strongest effect: ", "Next: ", "Then: "), "it"

Texts = Callable[[Sequence[float]], list[str]]


class Effect(NamedTuple):
    """The effect of one axis on one figure, over all values of the other axes."""

    path: str
    cases: tuple[int, ...]  # index of a case with each value; numbers ascend
    numeric: bool
    medians: np.ndarray  # (values,) SI, finite
    several: bool  # whether a value has several cases
    share: float  # of the variance of the figure's logarithm, corrected for chance, 0 to 1; NaN: undefined
    contrast: float  # variance between the values over the variance not explained by any axis (F ratio); NaN: undefined


def effects_on(cases: Cases, values: np.ndarray) -> list[Effect]:
    """Return the effects of the axes on a figure, the strongest first; values : (n,) SI, NaN for null."""
    drawn = (cases.record.get("sample") or {}).get("drawn", {})
    levels = [(path, *_levels(cases.column(path))) for path in cases.axes if path not in drawn]
    levels = [each for each in levels if 1 < len(each[1]) <= MAX_LEVELS]
    shares = variance_shares(values, [places for _, _, places in levels])
    effects = []
    for (path, uniques, places), share in zip(levels, shares, strict=True):
        groups = [np.flatnonzero((places == place) & np.isfinite(values)) for place in range(len(uniques))]
        groups = [group for group in groups if group.size]
        if len(groups) < 2:
            continue
        medians = np.array([np.median(values[group]) for group in groups])
        numeric = not isinstance(uniques[0], str)
        first, several = tuple(int(group[0]) for group in groups), any(group.size > 1 for group in groups)
        effects.append(Effect(path, first, numeric, medians, several, *share))
    return sorted(
        effects, key=lambda each: (-np.nan_to_num(each.share), -np.nan_to_num(largest_over_smallest(each.medians)))
    )


def sentences(cases: Cases, label: str, values: np.ndarray, texts: Texts, most: int = MAX_EFFECTS) -> list[str]:
    """Return sentences on the clear effects on a figure with direction and size, and on values without effect.

    label : name of the figure; texts : returns values of the figure in words, in one unit
    """
    effects = effects_on(cases, values) if cases.is_complete else []
    if not effects or not np.isfinite(values).any():
        return []
    clear = [effect for effect in effects if is_clear(effect.medians, effect.contrast) and _is_large(effect, effects)]
    if not clear:
        return [] if label == NEXT else [f"No varied value has a clear effect on the {label}."]
    said, named = [], clear[:most]
    for number, effect in enumerate(named):
        beginning = FIRST[min(number, len(FIRST) - 1)] if len(named) > 1 else ""
        text = _words(cases, effect, label, texts) if number == 0 else _words(cases, effect, NEXT, texts, note="")
        said.append(labels.capital(beginning + text))
    return [
        *said,
        *(_weak(cases, [each for each in effects if each not in clear], label, values, texts) if most > 1 else []),
    ]


def _weak(cases: Cases, weak: list[Effect], label: str, values: np.ndarray, texts: Texts) -> list[str]:
    """Return sentences on values without a clear effect of their own: opposite effects, then those with little effect.

    Opposite effects at different values of the other axes cancel in the medians.
    """
    opposite = {
        each.path: interactions.sentence(cases, each.path, label, values, texts) for each in weak if each.numeric
    }
    little = [_name(cases, each) for each in weak if not opposite.get(each.path)]
    said = [sentence for sentence in opposite.values() if sentence]
    return [*said, *([f"Little or no effect: {wording.sentence_list(little)}."] if little else [])]


def _words(cases: Cases, effect: Effect, subject: str, texts: Texts, note: str = " (medians)") -> str:
    """Return an effect: 'force peak rises from 1 to 2 kN (medians) as crank speed grows from 20 to 60 rpm.'."""
    name, medians = _name(cases, effect), effect.medians
    note = note if effect.several else ""
    if effect.numeric and _is_monotone(medians):
        verb = "rises" if medians[-1] > medians[0] else "falls"
        span = range_text(*texts([float(medians[0]), float(medians[-1])]))
        ends = range_text(_value(cases, effect, 0), _value(cases, effect, -1))
        return f"{subject} {verb} {span}{note} as {name} grows {ends}."
    low, high = int(medians.argmin()), int(medians.argmax())
    smallest, largest = texts([float(medians[low]), float(medians[high])])
    at = f"at {name} {_value(cases, effect, low)}"
    return f"{subject} is smallest, {smallest}, {at} and largest, {largest}, at {_value(cases, effect, high)}{note}."


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


def _name(cases: Cases, effect: Effect) -> str:
    pair = cases.named_value(effect.cases[0], effect.path)
    return pair[0] if pair else effect.path


def _value(cases: Cases, effect: Effect, place: int) -> str:
    pair = cases.named_value(effect.cases[place], effect.path)
    return pair[1] if pair else ""


def _levels(column: np.ndarray) -> tuple[list, np.ndarray]:
    """Return the distinct values of an axis, numbers ascending, and the index of each case's value (-1: no value)."""
    if column.dtype.kind in "fiub":
        values, indices = np.unique(column, return_inverse=True)
        known = np.isfinite(values.astype(float))
        return values[known].tolist(), np.where(known[indices], indices, -1)
    present = [value for value in column.tolist() if not wording.is_missing(value)]
    has_words = any(isinstance(value, str) for value in present)
    uniques = list(dict.fromkeys(present)) if has_words else sorted(set(present))
    index_of = {value: index for index, value in enumerate(uniques)}
    return uniques, np.array([index_of.get(value, -1) for value in column.tolist()], int)
