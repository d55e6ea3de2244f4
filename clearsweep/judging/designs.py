"""Designs of a grid: cases that differ only in their operating conditions, compared by their smallest margin."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..language import wording
from . import fits
from .cases import FinishedCases
from .verdict import MARGIN, small_margin_sentences

OPERATING_PREFIXES = ("drive.speed", "loads.")  # beginnings of the paths that are operating conditions
MAX_LISTED_DESIGNS = 4  # designs in one sentence


class Designs(NamedTuple):
    """The designs of a grid, the largest of their smallest margins first."""

    design_paths: tuple[str, ...]  # paths that make a design
    condition_paths: tuple[str, ...]  # the other varied paths
    worst_cases: tuple[int, ...]  # index of the case with the smallest margin of each design
    margins: tuple[float, ...]  # smallest margin of each, -inf if it cannot be assessed
    members: tuple[tuple[int, ...], ...]  # indices of the cases of each


def designs_of(axes: Sequence[str], column: Callable[[str], np.ndarray], count: int) -> Designs | None:
    """Return the designs of `count` finished cases, or None unless both designs and conditions vary.

    axes : varied paths; column : values of a path or of the margin
    """
    design_paths, condition_paths = split_axes(axes)
    if not condition_paths or not design_paths:
        return None
    designs = _sort_designs(design_paths, condition_paths, column, count)
    return None if len(designs.members) in (1, count) else designs


def split_axes(axes: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the varied paths that make a design, and those that are operating conditions."""
    condition_paths = tuple(path for path in axes if path.startswith(OPERATING_PREFIXES))
    return tuple(path for path in axes if path not in condition_paths), condition_paths


def group_cases(design_paths: Sequence[str], column: Callable[[str], np.ndarray], count: int) -> list[list[int]]:
    """Return the indices of the cases with equal values at `design_paths`."""
    values = [column(path) for path in design_paths]
    groups: dict[tuple, list[int]] = {}
    for index in range(count):
        groups.setdefault(tuple(str(column_values[index]) for column_values in values), []).append(index)
    return list(groups.values())


def _sort_designs(
    design_paths: tuple[str, ...], condition_paths: tuple[str, ...], column: Callable[[str], np.ndarray], count: int
) -> Designs:
    """Return the cases grouped by their values at `design_paths`."""
    margins = np.nan_to_num(column(MARGIN).astype(float), nan=-np.inf)
    groups = group_cases(design_paths, column, count)
    members = sorted(groups, key=lambda indices: -float(margins[indices].min()))
    worst_cases = tuple(indices[int(np.argmin(margins[indices]))] for indices in members)
    return Designs(
        design_paths,
        condition_paths,
        worst_cases,
        tuple(float(margins[index]) for index in worst_cases),
        tuple(map(tuple, members)),
    )


def is_in_accepted_design(cases: FinishedCases) -> np.ndarray:
    """Return which cases (n,) belong to a design that meets the limits in all of its cases; all without limits."""
    count = len(cases.case_ids)
    if not cases.limits:
        return np.ones(count, bool)
    designs = designs_of(cases.varied_paths, cases.values_of, count) or _sort_designs(
        cases.varied_paths, (), cases.values_of, count
    )
    meets_limits = np.zeros(count, bool)
    for margin, members in zip(designs.margins, designs.members, strict=True):
        meets_limits[list(members)] = margin >= 0.0
    return meets_limits


def sentences(cases: FinishedCases, limits: str) -> list[str]:
    """Return sentences on the designs that meet the limits under every condition, and on the first one that does not.

    limits : the limits in words
    """
    count = len(cases.case_ids)
    designs = designs_of(cases.varied_paths, cases.values_of, count)
    if designs is None:
        designs = _sort_designs(cases.varied_paths, (), cases.values_of, count)
    condition_text, noun = "", "case"
    if designs.condition_paths:
        names = wording.sentence_list([wording.axis_name(path) for path in designs.condition_paths])
        condition_text, noun = f" at every {names}", "design"
    accepted_count = sum(margin >= 0.0 for margin in designs.margins)
    total = len(designs.margins)
    if not accepted_count and not np.isfinite(designs.margins[0]):
        return [f"No design can be assessed{condition_text}."] if condition_text else []
    quantity = {0: "No", total: "All"}.get(accepted_count, f"{accepted_count} of {total}") if total > 1 else "The"
    nouns = (
        noun
        if not accepted_count or total == 1
        else f"{noun}s"
        if accepted_count == total
        else wording.count_text(total, noun)
    )
    subject = f"{quantity} {nouns}" if quantity in ("No", "All", "The") else f"{accepted_count} of {nouns}"
    if fits.classify_fits(cases) is not None:
        subject = f"At the mean clearances of the fits, {subject[0].lower()}{subject[1:]}"
    verb = "meets" if accepted_count <= 1 else "meet"
    if total == 1 and not accepted_count:
        subject, verb = "The case", "does not meet"
    statement = f"{subject} {verb} the limits{condition_text}: {limits}."
    return [statement, *_boundary_sentences(cases, designs)] if total > 1 else [statement]


def _boundary_sentences(cases: FinishedCases, designs: Designs) -> list[str]:
    """Return the last value of a single varied path that meets the limits, or the margins of the best designs."""
    accepted_ranks = [rank for rank, margin in enumerate(designs.margins) if margin >= 0.0]
    if not accepted_ranks:
        return [f"Nearest: {_design_text(cases, designs, 0)} (smallest margin)."]
    if len(designs.design_paths) == 1 and len(accepted_ranks) < len(designs.margins):
        values = cases.values_of(designs.design_paths[0])
        worst_values = [values[index] for index in designs.worst_cases]
        if not any(isinstance(value, str) or wording.is_missing(value) for value in worst_values):
            order = sorted(range(len(worst_values)), key=lambda rank: float(worst_values[rank]))
            is_accepted_in_order = [rank in accepted_ranks for rank in order]
            change_ranks = [
                rank
                for rank, (is_accepted, is_next_accepted) in enumerate(pairwise(is_accepted_in_order))
                if is_accepted != is_next_accepted
            ]
            if len(change_ranks) == 1:
                return _single_boundary_sentences(cases, designs, order[change_ranks[0] : change_ranks[0] + 2])
    designs_text = "; ".join(_design_text(cases, designs, rank) for rank in accepted_ranks[:MAX_LISTED_DESIGNS])
    more_text = (
        f"; and {len(accepted_ranks) - MAX_LISTED_DESIGNS} more" if len(accepted_ranks) > MAX_LISTED_DESIGNS else ""
    )
    return [f"Smallest margins, best first: {designs_text}{more_text}."] if designs.design_paths else []


def _single_boundary_sentences(cases: FinishedCases, designs: Designs, neighbours: list[int]) -> list[str]:
    """Return the last value that meets the limits, and the first that does not, with its worst condition."""
    accepted_rank, rejected_rank = neighbours if designs.margins[neighbours[0]] >= 0.0 else neighbours[::-1]
    preposition, opposite_preposition = ("up to", "From") if accepted_rank == neighbours[0] else ("from", "Up to")
    design_text = cases.values_text(designs.worst_cases[accepted_rank], designs.design_paths)
    name_and_value = cases.name_and_value(designs.worst_cases[rejected_rank], designs.design_paths[0])
    condition_values = cases.values_text(designs.worst_cases[rejected_rank], designs.condition_paths)
    condition_text = f", at {condition_values}" if condition_values else ""
    margin_text = _margin_text(designs.margins[rejected_rank])
    return [
        f"The limits are met {preposition} {design_text} (smallest margin "
        f"{_margin_text(designs.margins[accepted_rank])}).",
        *small_margin_sentences(designs.margins[accepted_rank]),
        f"{opposite_preposition} {name_and_value[1] if name_and_value else ''} a limit is exceeded "
        f"(margin {margin_text} there{condition_text}).",
    ]


def _design_text(cases: FinishedCases, designs: Designs, rank: int) -> str:
    return f"{cases.values_text(designs.worst_cases[rank], designs.design_paths)} {_margin_text(designs.margins[rank])}"


def _margin_text(margin: float) -> str:
    return f"{wording.short_number_text(100.0 * margin, 3)}{wording.BLANK}%" if np.isfinite(margin) else "unknown"
