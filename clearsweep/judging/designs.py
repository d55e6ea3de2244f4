"""Designs of a grid: cases that differ only in their operating conditions, compared by their smallest margin."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..language import wording
from .verdict import MARGIN

OPERATING = ("drive.speed", "loads.")  # beginnings of the paths that are operating conditions
LISTED = 4  # designs in one sentence


class Designs(NamedTuple):
    """The designs of a grid, the largest of their smallest margins first."""

    varied: tuple[str, ...]  # paths that make a design
    conditions: tuple[str, ...]  # the other varied paths
    first: tuple[int, ...]  # index of a case of each design
    margins: tuple[float, ...]  # smallest margin of each, -inf if it cannot be assessed


def of_cases(axes: Sequence[str], column: Callable[[str], np.ndarray], count: int) -> Designs | None:
    """Return the designs of `count` finished cases, None unless both designs and conditions vary.

    axes : varied paths; column : values of a path or of the margin
    """
    conditions = tuple(path for path in axes if path.startswith(OPERATING))
    varied = tuple(path for path in axes if path not in conditions)
    if not conditions or not varied:
        return None
    values = [column(path) for path in varied]
    margins = np.nan_to_num(column(MARGIN).astype(float), nan=-np.inf)
    members: dict[tuple, list[int]] = {}
    for index in range(count):
        members.setdefault(tuple(str(each[index]) for each in values), []).append(index)
    if len(members) < 2 or len(members) == count:
        return None
    smallest = sorted(
        ((float(margins[cases].min()), cases[0]) for cases in members.values()), key=lambda each: -each[0]
    )
    return Designs(varied, conditions, tuple(first for _, first in smallest), tuple(margin for margin, _ in smallest))


def sentences(designs: Designs, setting: Callable[[int], str]) -> list[str]:
    """Return which designs keep to the limits under every condition, the safest first; setting : case -> words."""
    names = wording.sentence_list([wording.axis_name(path) for path in designs.conditions])
    kept = [place for place, margin in enumerate(designs.margins) if margin >= 0.0]
    every = f"at every {names}"
    if not kept:
        if not np.isfinite(designs.margins[0]):
            return [f"No design can be assessed {every}."]
        return [f"No design keeps to the limits {every}. Nearest: {_listed(designs, 0, setting)} (smallest margin)."]
    listed = "; ".join(_listed(designs, place, setting) for place in kept[:LISTED])
    more = f"; and {len(kept) - LISTED} more" if len(kept) > LISTED else ""
    count = (
        f"{len(kept)} of {len(designs.first)} designs keep"
        if len(kept) > 1
        else f"1 of {len(designs.first)} designs keeps"
    )
    return [f"{count} to the limits {every} (smallest margin, best first): {listed}{more}."]


def _listed(designs: Designs, place: int, setting: Callable[[int], str]) -> str:
    margin = f"{wording.short(100.0 * designs.margins[place], 3)}{wording.BLANK}%"
    return f"{setting(designs.first[place])} {margin}"
