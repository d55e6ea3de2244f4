"""An error budget: effects of single unknowns on the force peak, from a base case and one-at-a-time changes."""

from collections import Counter
from typing import NamedTuple

import numpy as np
import pandas as pd

from ...language import wording
from ..blocks.picture import Picture
from ..blocks.section import Gallery, Section, Sentences, without_empty
from ..blocks.table import Column, Quantity, Table
from ..data.axis import Axis
from ..data.leading import PEAK
from ..data.study import Study
from ..draw import budget

MIN_UNKNOWNS = 3  # unknowns of a budget
MAX_CASES = 2000  # cases that are looked at: a budget has few
NEGLIGIBLE_CHANGE = 0.02  # of the base: an unknown that moves a figure by less decides nothing


class Unknown(NamedTuple):
    """Axes that change together, and the cases in which they do."""

    axes: tuple[Axis, ...]
    cases: tuple[str, ...]

    @property
    def name(self) -> str:
        """Return the name of the unknown in words."""
        return " and ".join(axis.name for axis in self.axes)


class Bar(NamedTuple):
    """Effect of an unknown on a figure."""

    unknown: Unknown
    decrease: float  # of the base, at most 0
    increase: float  # at least 0
    case_of_decrease: str  # case_id; '': the base
    case_of_increase: str


def sections(study: Study) -> list[Section]:
    """Return the section, or [] unless the finished cases are a base case and cases that each change one unknown."""
    if study.cases.empty or not study.joints:
        return []
    column = study.most_loaded_joint().column(PEAK.figure)
    design = one_at_a_time_design(study)
    if design is None or not study.has(column) or not study.cases.at[design[0], column] > 0.0:
        return []
    base, unknowns = design
    bars = bars_of(study, column, base, unknowns)
    blocks = without_empty(
        [Sentences(_sentences(study, column, base, bars)), Gallery("", [_picture(study, bars)]), _table(study, bars)]
    )
    return [Section("budget", "Error budget of the force peak", blocks)]


def one_at_a_time_design(study: Study) -> tuple[str, list[Unknown]] | None:
    """Return the base case and the unknowns, or None if cases differ from each other in another way."""
    axes, cases = study.swept(), study.cases
    if "sample" in study.run.grid or not MIN_UNKNOWNS <= len(axes) < len(cases) <= MAX_CASES:
        return None
    values = pd.DataFrame({axis.path: np.asarray(cases[axis.path], dtype=object) for axis in axes}, index=cases.index)
    most_frequent = [Counter(values[axis.path].dropna()).most_common(1)[0][0] for axis in axes]
    differs = values.ne(pd.Series(most_frequent, index=values.columns), axis=1)
    base_ids = differs.index[~differs.any(axis=1)]
    if len(base_ids) != 1:
        return None
    change_patterns = np.unique(differs.to_numpy()[differs.index != base_ids[0]], axis=0)
    if (change_patterns.sum(axis=0) > 1).any():  # an axis of two groups: cases change several unknowns
        return None
    groups: dict[tuple[str, ...], list[str]] = {}
    for case_id, is_changed in differs.drop(index=base_ids[0]).iterrows():
        groups.setdefault(tuple(is_changed.index[is_changed]), []).append(str(case_id))
    if len(groups) < MIN_UNKNOWNS:
        return None
    by_path = {axis.path: axis for axis in axes}
    unknowns = [Unknown(tuple(by_path[path] for path in group), tuple(ids)) for group, ids in groups.items()]
    return str(base_ids[0]), unknowns


def bars_of(study: Study, column: str, base: str, unknowns: list[Unknown]) -> list[Bar]:
    """Return the bar of each unknown, the one with the largest effect first."""
    base_value, bars = float(study.cases.at[base, column]), []
    for unknown in unknowns:
        changes = {case: float(study.cases.at[case, column]) / base_value - 1.0 for case in unknown.cases}
        changes = {"": 0.0} | {case: change for case, change in changes.items() if np.isfinite(change)}
        low, high = min(changes, key=changes.__getitem__), max(changes, key=changes.__getitem__)
        bars.append(Bar(unknown, changes[low], changes[high], low, high))
    return sorted(bars, key=lambda bar: bar.decrease - bar.increase)


def combined_change(bars: list[Bar]) -> tuple[float, float]:
    """Return the relative change of a figure, down and up, by all unknowns together.

    The unknowns are independent, so the logarithms of the ratios are combined by root-sum-square.  Logarithms are used
    because a peak cannot fall by more than 100 %.
    """
    log_decrease = np.linalg.norm([np.log1p(bar.decrease) for bar in bars])
    log_increase = np.linalg.norm([np.log1p(bar.increase) for bar in bars])
    return float(np.expm1(-log_decrease)), float(np.expm1(log_increase))


def _sentences(study: Study, column: str, base: str, bars: list[Bar]) -> list[str]:
    lower, upper = combined_change(bars)
    influential = [bar.unknown.name for bar in bars if bar.increase - bar.decrease >= NEGLIGIBLE_CHANGE]
    negligible = [bar.unknown.name for bar in bars if bar.increase - bar.decrease < NEGLIGIBLE_CHANGE]
    base_peak = study.text(base, column)
    largest = wording.sentence_list(influential[:2]) if influential else "none of the unknowns"
    verb = "have" if len(influential[:2]) > 1 else "has"
    sentences = [
        f"The base case {base[:8]} has a force peak of {base_peak}. Each other case changes one unknown. If the "
        f"unknowns are independent, the uncertainty of the peak is {_percent_text(lower)} to {_percent_text(upper)}. "
        "For each "
        "bound, "
        "the logarithms of the changes are combined by root-sum-square.",
        f"{largest[:1].upper()}{largest[1:]} {verb} the largest effect on the peak.",
    ]
    if negligible:
        sentences.append(
            f"The effect is below {wording.percent_text(NEGLIGIBLE_CHANGE)} for {wording.sentence_list(negligible)}."
        )
    return [*sentences, "The cases change one unknown at a time, so they do not show interactions."]


def _percent_text(change: float) -> str:
    return f"{100.0 * change:+.1f} %"


def _values_text(study: Study, bar: Bar, case_id: str) -> str:
    """Return the values of an unknown in a case."""
    if not case_id:
        return "base"
    return ", ".join(axis.text(study.cases.at[case_id, axis.path]) for axis in bar.unknown.axes)


def _picture(study: Study, bars: list[Bar]) -> Picture:
    rows = [
        (
            bar.unknown.name,
            bar.decrease,
            bar.increase,
            _values_text(study, bar, bar.case_of_decrease),
            _values_text(study, bar, bar.case_of_increase),
        )
        for bar in reversed(bars)
    ]
    alt = "; ".join(
        f"{bar.unknown.name}: {_percent_text(bar.decrease)} to {_percent_text(bar.increase)}" for bar in bars
    )
    return Picture(
        "Error budget",
        "effect of each unknown alone on the force peak",
        f"Bars of the change of the force peak by unknown. {alt}",
        lambda ax: budget.draw_tornado(ax, rows, PEAK.name),
        size=(7.0, 0.8 + 0.34 * len(bars)),
    )


def _table(study: Study, bars: list[Bar]) -> Table:
    """Return the table with the numbers of the bars."""
    headings = ("unknown", "cases", "least change", "at", "largest change", "reached at")
    rows = [
        (
            bar.unknown.name,
            Quantity(len(bar.unknown.cases), str(len(bar.unknown.cases))),
            Quantity(bar.decrease, _percent_text(bar.decrease)),
            _values_text(study, bar, bar.case_of_decrease),
            Quantity(bar.increase, _percent_text(bar.increase)),
            _values_text(study, bar, bar.case_of_increase),
        )
        for bar in bars
    ]
    note = "Change of the largest normal force from that of the base case, one unknown at a time."
    return Table("budget", "Error budget", note, tuple(map(Column, headings)), rows)
