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
    smallest_margins: tuple[float, ...]  # smallest margin of each, -inf if it cannot be assessed
    case_indices: tuple[tuple[int, ...], ...]  # indices of the cases of each


def designs_of(axes: Sequence[str], values_of: Callable[[str], np.ndarray], case_count: int) -> Designs | None:
    """Return the designs of `case_count` finished cases, or None unless both designs and conditions vary.

    axes : varied paths; values_of : returns the values of a path or of the margin
    """
    design_paths, condition_paths = split_axes(axes)
    if not condition_paths or not design_paths:
        return None
    designs = _sort_designs(design_paths, condition_paths, values_of, case_count)
    return None if len(designs.case_indices) in (1, case_count) else designs


def split_axes(axes: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the varied paths that make a design, and those that are operating conditions."""
    condition_paths = tuple(path for path in axes if path.startswith(OPERATING_PREFIXES))
    return tuple(path for path in axes if path not in condition_paths), condition_paths


def group_cases(
    design_paths: Sequence[str], values_of: Callable[[str], np.ndarray], case_count: int
) -> list[list[int]]:
    """Return the indices of the cases with equal values at `design_paths`."""
    values = [values_of(path) for path in design_paths]
    groups: dict[tuple, list[int]] = {}
    for index in range(case_count):
        groups.setdefault(tuple(str(column_values[index]) for column_values in values), []).append(index)
    return list(groups.values())


def _sort_designs(
    design_paths: tuple[str, ...],
    condition_paths: tuple[str, ...],
    values_of: Callable[[str], np.ndarray],
    case_count: int,
) -> Designs:
    """Return the designs, which are the cases grouped by their values at `design_paths`, the largest margin first."""
    margins = np.nan_to_num(values_of(MARGIN).astype(float), nan=-np.inf)
    groups = group_cases(design_paths, values_of, case_count)
    case_indices = sorted(groups, key=lambda indices: -float(margins[indices].min()))
    worst_cases = tuple(indices[int(np.argmin(margins[indices]))] for indices in case_indices)
    return Designs(
        design_paths,
        condition_paths,
        worst_cases,
        tuple(float(margins[index]) for index in worst_cases),
        tuple(map(tuple, case_indices)),
    )


def is_in_accepted_design(cases: FinishedCases) -> np.ndarray:
    """Return which cases (n,) belong to a design that meets the limits in all of its cases; all without limits."""
    case_count = len(cases.case_ids)
    if not cases.limits:
        return np.ones(case_count, bool)
    designs = designs_of(cases.varied_paths, cases.values_of, case_count) or _sort_designs(
        cases.varied_paths, (), cases.values_of, case_count
    )
    meets_limits = np.zeros(case_count, bool)
    for smallest_margin, case_indices in zip(designs.smallest_margins, designs.case_indices, strict=True):
        meets_limits[list(case_indices)] = smallest_margin >= 0.0
    return meets_limits


def sentences(cases: FinishedCases, limits_text: str) -> list[str]:
    """Return sentences on the designs that meet the limits under every condition, and on the first one that does not.

    limits_text : the limits in words
    """
    case_count = len(cases.case_ids)
    designs = designs_of(cases.varied_paths, cases.values_of, case_count)
    if designs is None:
        designs = _sort_designs(cases.varied_paths, (), cases.values_of, case_count)
    condition_text, noun = "", "case"
    if designs.condition_paths:
        names = wording.sentence_list([wording.axis_name(path) for path in designs.condition_paths])
        condition_text, noun = f" at every {names}", "design"
    accepted_count = sum(margin >= 0.0 for margin in designs.smallest_margins)
    design_count = len(designs.smallest_margins)
    if not accepted_count and not np.isfinite(designs.smallest_margins[0]):
        return [f"No design can be assessed{condition_text}."] if condition_text else []
    quantifier = (
        {0: "No", design_count: "All"}.get(accepted_count, f"{accepted_count} of {design_count}")
        if design_count > 1
        else "The"
    )
    noun_phrase = (
        noun
        if not accepted_count or design_count == 1
        else f"{noun}s"
        if accepted_count == design_count
        else wording.count_text(design_count, noun)
    )
    subject = (
        f"{quantifier} {noun_phrase}" if quantifier in ("No", "All", "The") else f"{accepted_count} of {noun_phrase}"
    )
    if fits.classify_fits(cases) is not None:
        subject = f"At the mean clearances of the fits, {subject[0].lower()}{subject[1:]}"
    verb = "meets" if accepted_count <= 1 else "meet"
    if design_count == 1 and not accepted_count:
        subject, verb = "The case", "does not meet"
    statement = f"{subject} {verb} the limits{condition_text}: {limits_text}."
    return [statement, *_boundary_sentences(cases, designs)] if design_count > 1 else [statement]


def _boundary_sentences(cases: FinishedCases, designs: Designs) -> list[str]:
    """Return where a single varied path meets the limits; else the best designs, or the nearest if none does."""
    accepted_ranks = [rank for rank, margin in enumerate(designs.smallest_margins) if margin >= 0.0]
    if not accepted_ranks:
        return [f"Nearest: {_design_text(cases, designs, 0)} (smallest margin)."]
    if len(designs.design_paths) == 1 and len(accepted_ranks) < len(designs.smallest_margins):
        values = cases.values_of(designs.design_paths[0])
        worst_values = [values[index] for index in designs.worst_cases]
        if not any(isinstance(value, str) or wording.is_missing(value) for value in worst_values):
            order = sorted(range(len(worst_values)), key=lambda rank: float(worst_values[rank]))
            is_accepted_in_order = [rank in accepted_ranks for rank in order]
            change_positions = [
                position
                for position, (is_accepted, is_next_accepted) in enumerate(pairwise(is_accepted_in_order))
                if is_accepted != is_next_accepted
            ]
            if len(change_positions) == 1:
                return _single_boundary_sentences(cases, designs, order[change_positions[0] : change_positions[0] + 2])
    designs_text = "; ".join(_design_text(cases, designs, rank) for rank in accepted_ranks[:MAX_LISTED_DESIGNS])
    more_text = (
        f"; and {len(accepted_ranks) - MAX_LISTED_DESIGNS} more" if len(accepted_ranks) > MAX_LISTED_DESIGNS else ""
    )
    return [f"Smallest margins, best first: {designs_text}{more_text}."] if designs.design_paths else []


def _single_boundary_sentences(cases: FinishedCases, designs: Designs, neighbour_ranks: list[int]) -> list[str]:
    """Return the last value that meets the limits, and the first that does not, with its worst condition."""
    accepted_rank, rejected_rank = (
        neighbour_ranks if designs.smallest_margins[neighbour_ranks[0]] >= 0.0 else neighbour_ranks[::-1]
    )
    preposition, opposite_preposition = ("up to", "From") if accepted_rank == neighbour_ranks[0] else ("from", "Up to")
    design_text = cases.values_text(designs.worst_cases[accepted_rank], designs.design_paths)
    name_and_value = cases.describe_value(designs.worst_cases[rejected_rank], designs.design_paths[0])
    condition_values = cases.values_text(designs.worst_cases[rejected_rank], designs.condition_paths)
    condition_text = f", at {condition_values}" if condition_values else ""
    margin_text = _margin_text(designs.smallest_margins[rejected_rank])
    return [
        f"The limits are met {preposition} {design_text} (smallest margin "
        f"{_margin_text(designs.smallest_margins[accepted_rank])}).",
        *small_margin_sentences(designs.smallest_margins[accepted_rank]),
        f"{opposite_preposition} {name_and_value[1] if name_and_value else ''} a limit is exceeded "
        f"(margin {margin_text} there{condition_text}).",
    ]


def _design_text(cases: FinishedCases, designs: Designs, rank: int) -> str:
    margin_text = _margin_text(designs.smallest_margins[rank])
    return f"{cases.values_text(designs.worst_cases[rank], designs.design_paths)} {margin_text}"


def _margin_text(margin: float) -> str:
    return f"{wording.short_number_text(100.0 * margin, 3)}{wording.BLANK}%" if np.isfinite(margin) else "unknown"
