"""Designs of a grid: cases that differ only in their operating conditions, compared by their smallest margin."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..language import wording
from . import fits
from .cases import Cases
from .verdict import MARGIN

OPERATING = ("drive.speed", "loads.")  # beginnings of the paths that are operating conditions
LISTED = 4  # designs in one sentence


class Designs(NamedTuple):
    """The designs of a grid, the largest of their smallest margins first."""

    varied: tuple[str, ...]  # paths that make a design
    conditions: tuple[str, ...]  # the other varied paths
    worst: tuple[int, ...]  # index of the case with the smallest margin of each design
    margins: tuple[float, ...]  # smallest margin of each, -inf if it cannot be assessed
    members: tuple[tuple[int, ...], ...]  # indices of the cases of each


def of_cases(axes: Sequence[str], column: Callable[[str], np.ndarray], count: int) -> Designs | None:
    """Return the designs of `count` finished cases, or None unless both designs and conditions vary.

    axes : varied paths; column : values of a path or of the margin
    """
    varied, conditions = divided(axes)
    if not conditions or not varied:
        return None
    designs = _grouped(varied, conditions, column, count)
    return None if len(designs.members) in (1, count) else designs


def divided(axes: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the varied paths that make a design, and those that are operating conditions."""
    conditions = tuple(path for path in axes if path.startswith(OPERATING))
    return tuple(path for path in axes if path not in conditions), conditions


def groups(varied: Sequence[str], column: Callable[[str], np.ndarray], count: int) -> list[list[int]]:
    """Return the indices of the cases with equal values at the `varied` paths."""
    values = [column(path) for path in varied]
    grouped: dict[tuple, list[int]] = {}
    for index in range(count):
        grouped.setdefault(tuple(str(each[index]) for each in values), []).append(index)
    return list(grouped.values())


def _grouped(
    varied: tuple[str, ...], conditions: tuple[str, ...], column: Callable[[str], np.ndarray], count: int
) -> Designs:
    """Return the cases grouped by their values at the `varied` paths."""
    margins = np.nan_to_num(column(MARGIN).astype(float), nan=-np.inf)
    members = sorted(groups(varied, column, count), key=lambda cases: -float(margins[cases].min()))
    worst = tuple(cases[int(np.argmin(margins[cases]))] for cases in members)
    return Designs(
        varied, conditions, worst, tuple(float(margins[index]) for index in worst), tuple(map(tuple, members))
    )


def accepted(cases: Cases) -> np.ndarray:
    """Return which cases (n,) belong to a design that meets the limits in all of its cases; all without limits."""
    count = len(cases.case_ids)
    if not cases.limits:
        return np.ones(count, bool)
    grouped = of_cases(cases.axes, cases.column, count) or _grouped(cases.axes, (), cases.column, count)
    meets = np.zeros(count, bool)
    for margin, members in zip(grouped.margins, grouped.members, strict=True):
        meets[list(members)] = margin >= 0.0
    return meets


def sentences(cases: Cases, limits: str) -> list[str]:
    """Return sentences on the designs that meet the limits under every condition, and on the first one that does not.

    limits : the limits in words
    """
    count = len(cases.case_ids)
    designs = of_cases(cases.axes, cases.column, count)
    if designs is None:
        designs = _grouped(cases.axes, (), cases.column, count)
    every, noun = "", "case"
    if designs.conditions:
        names = wording.sentence_list([wording.axis_name(path) for path in designs.conditions])
        every, noun = f" at every {names}", "design"
    accepted = sum(margin >= 0.0 for margin in designs.margins)
    total = len(designs.margins)
    if not accepted and not np.isfinite(designs.margins[0]):
        return [f"No design can be assessed{every}."] if every else []
    number = {0: "No", total: "All"}.get(accepted, f"{accepted} of {total}") if total > 1 else "The"
    nouns = noun if not accepted or total == 1 else f"{noun}s" if accepted == total else wording.count(total, noun)
    head = f"{number} {nouns}" if number in ("No", "All", "The") else f"{accepted} of {nouns}"
    if fits.of_cases(cases) is not None:
        head = f"At the mean clearances of the fits, {head[0].lower()}{head[1:]}"
    verb = "meets" if accepted <= 1 else "meet"
    if total == 1 and not accepted:
        head, verb = "The case", "does not meet"
    first = f"{head} {verb} the limits{every}: {limits}."
    return [first, *_boundary(cases, designs)] if total > 1 else [first]


def _boundary(cases: Cases, designs: Designs) -> list[str]:
    """Return the last value of a single varied path that meets the limits, or the margins of the best designs."""
    accepted = [place for place, margin in enumerate(designs.margins) if margin >= 0.0]
    if not accepted:
        return [f"Nearest: {_listed(cases, designs, 0)} (smallest margin)."]
    if len(designs.varied) == 1 and len(accepted) < len(designs.margins):
        values = cases.column(designs.varied[0])
        numbers = [values[index] for index in designs.worst]
        if not any(isinstance(value, str) or wording.missing(value) for value in numbers):
            order = sorted(range(len(numbers)), key=lambda place: float(numbers[place]))
            passes = [place in accepted for place in order]
            changes = [place for place, (now, then) in enumerate(pairwise(passes)) if now != then]
            if len(changes) == 1:
                return _one_boundary(cases, designs, order[changes[0] : changes[0] + 2])
    listed = "; ".join(_listed(cases, designs, place) for place in accepted[:LISTED])
    more = f"; and {len(accepted) - LISTED} more" if len(accepted) > LISTED else ""
    return [f"Smallest margins, best first: {listed}{more}."] if designs.varied else []


def _one_boundary(cases: Cases, designs: Designs, ends: list[int]) -> list[str]:
    """Return the last value that meets the limits, and the first that does not, with its worst condition."""
    safe, failing = ends if designs.margins[ends[0]] >= 0.0 else ends[::-1]
    word, beyond = ("up to", "From") if safe == ends[0] else ("from", "Up to")
    setting = cases.setting(designs.worst[safe], designs.varied)
    pair = cases.named_value(designs.worst[failing], designs.varied[0])
    condition = cases.setting(designs.worst[failing], designs.conditions)
    where = f", worst at {condition}" if condition else ""
    margin = _percent(designs.margins[failing])
    return [
        f"The limits are met {word} {setting} (smallest margin {_percent(designs.margins[safe])}).",
        f"{beyond} {pair[1] if pair else ''} a limit is exceeded{where} (margin {margin}).",
    ]


def _listed(cases: Cases, designs: Designs, place: int) -> str:
    return f"{cases.setting(designs.worst[place], designs.varied)} {_percent(designs.margins[place])}"


def _percent(margin: float) -> str:
    return f"{wording.short(100.0 * margin, 3)}{wording.BLANK}%" if np.isfinite(margin) else "unknown"
