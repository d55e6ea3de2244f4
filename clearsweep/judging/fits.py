"""Fits of a joint against limits: which meet them over their whole tolerance, and which are open."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..language import wording
from .cases import Cases
from .verdict import MARGIN

LISTED = 4  # fits in one sentence


class FitStates(NamedTuple):
    """The fits of a path by what the run shows of them, each in the order of the grid."""

    path: str  # of the clearance
    sure: tuple[Mapping[str, Any], ...]  # meet the limits over their whole tolerance
    open: tuple[Mapping[str, Any], ...]  # meet them at their mean clearance; one end of the tolerance is not covered
    exceeding: tuple[Mapping[str, Any], ...]  # exceed a limit at their mean clearance
    kept: tuple[float, ...]  # clearances (m) that meet the limits in every case, ascending
    exceeded: tuple[float, ...]  # the other clearances (m), ascending

    @property
    def total(self) -> int:
        """Return the number of fits."""
        return len(self.sure) + len(self.open) + len(self.exceeding)


def of_cases(cases: Cases) -> FitStates | None:
    """Return the states of the fits of the first path with fits that varies; None without one or without limits."""
    path = next((path for path in cases.record.get("fits") or {} if path in cases.axes), None)
    if path is None or not cases.record.get("limits") or (cases.record.get("sample") or {}).get("drawn", {}).get(path):
        return None
    values, margins = cases.column(path).astype(float), cases.column(MARGIN).astype(float)
    keeps = {value: bool((margins[values == value] >= 0.0).all()) for value in np.unique(values).tolist()}
    listed: Sequence[Mapping[str, Any]] = [fit for fit in cases.record["fits"][path] if fit["mean"] in keeps]
    keeping = [fit for fit in listed if keeps[fit["mean"]]]
    if not listed:  # a search runs the ends of fits, not their means
        return None
    return FitStates(
        path,
        tuple(fit for fit in keeping if _is_covered(fit, keeps)),
        tuple(fit for fit in keeping if not _is_covered(fit, keeps)),
        tuple(fit for fit in listed if not keeps[fit["mean"]]),
        tuple(value for value, kept in keeps.items() if kept),
        tuple(value for value, kept in keeps.items() if not kept),
    )


def _is_covered(fit: Mapping[str, Any], keeps: Mapping[float, bool]) -> bool:
    """Return whether the end of a tolerance towards the limit lies within the clearances that meet the limits.

    keeps : clearance (m) -> whether all of its cases meet the limits, ascending.  Where the verdict changes more
    than once, no fit is covered.
    """
    changes = [now for now, then in pairwise(keeps.values()) if now != then]
    kept = [clearance for clearance, value in keeps.items() if value]
    if len(changes) > 1 or not kept:
        return False
    exceeded_below = changes == [False]
    return bool(fit["low"] >= kept[0] if exceeded_below else fit["high"] <= kept[-1])


def sentences(cases: Cases) -> list[str]:
    """Return which fits one may choose, which are open and why, and which exceed a limit; [] without fits."""
    states = of_cases(cases)
    if states is None:
        return []
    said = [_chosen(states), *(_open(states, fit) for fit in states.open[:LISTED])]
    if states.exceeding:
        said.append(f"Exceeding a limit at the mean clearance: {_names(states.exceeding)}.")
    if states.open:
        said.append("To decide, add the open clearance to the sweep.")
    return [" ".join(said)]


def _chosen(states: FitStates) -> str:
    if not states.sure:
        return "No fit is known to meet the limits over its whole tolerance."
    verb, their = ("meets", "its") if len(states.sure) == 1 else ("meet", "their")
    first = f"{_names(states.sure)} {verb} the limits over {their} whole tolerance"
    if states.exceeded and states.exceeded[0] < states.kept[0]:
        return f"{first}: {their} smallest clearance lies above one that meets them ({_size(states.kept[0])})."
    return f"{first}: {their} largest clearance lies below one that meets them ({_size(states.kept[-1])})."


def _open(states: FitStates, fit: Mapping[str, Any]) -> str:
    """Return why a fit is open: where its uncovered clearance lies."""
    if states.exceeded and states.exceeded[0] < states.kept[0]:
        word, end = "smallest", fit["low"]
    else:
        word, end = "largest", fit["high"]
    below = max((value for value in (*states.kept, *states.exceeded) if value <= end), default=None)
    above = min((value for value in (*states.kept, *states.exceeded) if value > end), default=None)
    ends = [f"{_size(value)} ({'met' if value in states.kept else 'exceeded'})" for value in (below, above) if value]
    if len(ends) == 2:
        where = f"lies between {ends[0]} and {ends[1]}"
    else:
        where = f"lies {'above' if above is None else 'below'} {ends[0]}, the {word} that was run"
    return f"{fit['name']} is open: its {word} clearance, {_size(end)}, {where}."


def _names(fits: Sequence[Mapping[str, Any]]) -> str:
    return wording.sentence_list([fit["name"] for fit in fits])


def _size(clearance: float) -> str:
    """Return a clearance (m) in micrometres."""
    return f"{1e6 * clearance:.4g}{wording.BLANK}\u00b5m"
