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

LEAST = 3  # unknowns of a budget
MOST = 2000  # cases that are looked at: a budget has few
SMALL = 0.02  # of the base: an unknown that moves a figure by less decides nothing


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
    down: float  # of the base, at most 0
    up: float  # at least 0
    at_down: str  # case_id; '': the base
    at_up: str


def sections(study: Study) -> list[Section]:
    """Return the section, or [] unless the finished cases are a base case and cases that each change one unknown."""
    if study.cases.empty or not study.joints:
        return []
    column = study.hardest_joint().column(PEAK.figure)
    design = designed(study)
    if design is None or not study.has(column) or not study.cases.at[design[0], column] > 0.0:
        return []
    base, unknowns = design
    bars = bars_of(study, column, base, unknowns)
    blocks = without_empty(
        [Sentences(_sentences(study, column, base, bars)), Gallery("", [_picture(study, bars)]), _table(study, bars)]
    )
    return [Section("budget", "Error budget of the force peak", blocks)]


def designed(study: Study) -> tuple[str, list[Unknown]] | None:
    """Return the base case and the unknowns, or None if cases differ from each other in another way."""
    axes, cases = study.swept(), study.cases
    if "sample" in study.run.grid or not LEAST <= len(axes) < len(cases) <= MOST:
        return None
    values = pd.DataFrame({axis.path: np.asarray(cases[axis.path], dtype=object) for axis in axes}, index=cases.index)
    usual = [Counter(values[axis.path].dropna()).most_common(1)[0][0] for axis in axes]
    differs = values.ne(pd.Series(usual, index=values.columns), axis=1)
    same = differs.index[~differs.any(axis=1)]
    if len(same) != 1:
        return None
    changes = np.unique(differs.to_numpy()[differs.index != same[0]], axis=0)
    if (changes.sum(axis=0) > 1).any():  # an axis of two groups: cases change several unknowns
        return None
    groups: dict[tuple[str, ...], list[str]] = {}
    for case_id, row in differs.drop(index=same[0]).iterrows():
        groups.setdefault(tuple(row.index[row]), []).append(str(case_id))
    if len(groups) < LEAST:
        return None
    by_path = {axis.path: axis for axis in axes}
    unknowns = [Unknown(tuple(by_path[path] for path in group), tuple(ids)) for group, ids in groups.items()]
    return str(same[0]), unknowns


def bars_of(study: Study, column: str, base: str, unknowns: list[Unknown]) -> list[Bar]:
    """Return the bar of each unknown, the one with the largest effect first."""
    start, bars = float(study.cases.at[base, column]), []
    for unknown in unknowns:
        changes = {case: float(study.cases.at[case, column]) / start - 1.0 for case in unknown.cases}
        changes = {"": 0.0} | {case: change for case, change in changes.items() if np.isfinite(change)}
        low, high = min(changes, key=changes.__getitem__), max(changes, key=changes.__getitem__)
        bars.append(Bar(unknown, changes[low], changes[high], low, high))
    return sorted(bars, key=lambda bar: bar.down - bar.up)


def together(bars: list[Bar]) -> tuple[float, float]:
    """Return the relative change of a figure, down and up, by all unknowns together.

    The unknowns are independent, so the logarithms of the ratios are combined by root-sum-square.  Logarithms are used
    because a peak cannot fall by more than 100 %.
    """
    down = np.linalg.norm([np.log1p(bar.down) for bar in bars])
    up = np.linalg.norm([np.log1p(bar.up) for bar in bars])
    return float(np.expm1(-down)), float(np.expm1(up))


def _sentences(study: Study, column: str, base: str, bars: list[Bar]) -> list[str]:
    down, up = together(bars)
    decides = [bar.unknown.name for bar in bars if bar.up - bar.down >= SMALL]
    idle = [bar.unknown.name for bar in bars if bar.up - bar.down < SMALL]
    start = study.text(base, column)
    largest = wording.sentence_list(decides[:2]) if decides else "none of the unknowns"
    verb = "have" if len(decides[:2]) > 1 else "has"
    sentences = [
        f"The base case {base[:8]} has a force peak of {start}. Each other case changes one unknown. If the "
        f"unknowns are independent, the uncertainty of the peak is {_percent(down)} to {_percent(up)}. For each bound, "
        "the logarithms of the changes are combined by root-sum-square.",
        f"{largest[:1].upper()}{largest[1:]} {verb} the largest effect on the peak.",
    ]
    if idle:
        sentences.append(f"The effect is below {wording.percent(SMALL)} for {wording.sentence_list(idle)}.")
    return [*sentences, "The cases change one unknown at a time, so they do not show interactions."]


def _percent(share: float) -> str:
    return f"{100.0 * share:+.1f} %"


def _at(study: Study, bar: Bar, case: str) -> str:
    """Return the values of an unknown in a case."""
    if not case:
        return "base"
    return ", ".join(axis.text(study.cases.at[case, axis.path]) for axis in bar.unknown.axes)


def _picture(study: Study, bars: list[Bar]) -> Picture:
    drawn = [(b.unknown.name, b.down, b.up, _at(study, b, b.at_down), _at(study, b, b.at_up)) for b in reversed(bars)]
    alt = "; ".join(f"{b.unknown.name}: {_percent(b.down)} to {_percent(b.up)}" for b in bars)
    return Picture(
        "Error budget",
        "effect of each unknown alone on the force peak",
        f"Bars of the change of the force peak by unknown. {alt}",
        lambda ax: budget.draw_tornado(ax, drawn, PEAK.name),
        size=(7.0, 0.8 + 0.34 * len(bars)),
    )


def _table(study: Study, bars: list[Bar]) -> Table:
    """Return the table with the numbers of the bars."""
    heads = ("unknown", "cases", "least change", "at", "largest change", "reached at")
    rows = [
        (
            bar.unknown.name,
            Quantity(len(bar.unknown.cases), str(len(bar.unknown.cases))),
            Quantity(bar.down, _percent(bar.down)),
            _at(study, bar, bar.at_down),
            Quantity(bar.up, _percent(bar.up)),
            _at(study, bar, bar.at_up),
        )
        for bar in bars
    ]
    note = "Change of the largest normal force from that of the base case, one unknown at a time."
    return Table("budget", "Error budget", note, tuple(map(Column, heads)), rows)
