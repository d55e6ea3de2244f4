"""Fits of a joint against limits: which meet them over their tolerance, their loads, and which are undecided."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..language import wording
from .cases import FinishedCases
from .verdict import MARGIN, Limit

MAX_LISTED = 4  # fits in one sentence


class ClassifiedFits(NamedTuple):
    """The fits of a path, classified by whether they meet the limits; each group in the order of the grid."""

    path: str  # of the clearance
    accepted: tuple[Mapping[str, Any], ...]  # meet the limits over their whole tolerance
    undecided: tuple[
        Mapping[str, Any], ...
    ]  # meet them at their mean clearance; one end of the tolerance is not covered
    rejected: tuple[Mapping[str, Any], ...]  # exceed a limit at their mean clearance
    safe_clearances: tuple[float, ...]  # clearances (m) that meet the limits in every case, ascending
    unsafe_clearances: tuple[float, ...]  # the other clearances (m), ascending
    margins: Mapping[float, float]  # clearance (m) -> smallest margin of its cases, ascending

    @property
    def total(self) -> int:
        """Return the number of fits."""
        return len(self.accepted) + len(self.undecided) + len(self.rejected)


def classify_fits(cases: FinishedCases) -> ClassifiedFits | None:
    """Return the classified fits of the first varied path with fits; None without such a path or without limits."""
    path = next((path for path in cases.record.get("fits") or {} if path in cases.varied_paths), None)
    if path is None or not cases.record.get("limits") or (cases.record.get("sample") or {}).get("drawn", {}).get(path):
        return None
    values, margins = cases.values_of(path).astype(float), cases.values_of(MARGIN).astype(float)
    meets_limits = {value: bool((margins[values == value] >= 0.0).all()) for value in np.unique(values).tolist()}
    run_fits: Sequence[Mapping[str, Any]] = [fit for fit in cases.record["fits"][path] if fit["mean"] in meets_limits]
    accepted_at_mean = [fit for fit in run_fits if meets_limits[fit["mean"]]]
    if not run_fits:  # a search runs the ends of fits, not their means
        return None
    return ClassifiedFits(
        path,
        tuple(fit for fit in accepted_at_mean if _is_covered(fit, meets_limits)),
        tuple(fit for fit in accepted_at_mean if not _is_covered(fit, meets_limits)),
        tuple(fit for fit in run_fits if not meets_limits[fit["mean"]]),
        tuple(value for value, meets in meets_limits.items() if meets),
        tuple(value for value, meets in meets_limits.items() if not meets),
        {value: float(margins[values == value].min()) for value in meets_limits},
    )


def _is_covered(fit: Mapping[str, Any], meets_limits: Mapping[float, bool]) -> bool:
    """Return whether the end of a tolerance towards the limit lies within the clearances that meet the limits.

    meets_limits : clearance (m) -> whether all of its cases meet the limits, ascending.  Where the verdict changes more
    than once, no fit is covered.
    """
    changes = [meets for meets, meets_next in pairwise(meets_limits.values()) if meets != meets_next]
    safe_clearances = [clearance for clearance, meets in meets_limits.items() if meets]
    if len(changes) > 1 or not safe_clearances:
        return False
    fails_below = changes == [False]
    return bool(fit["low"] >= safe_clearances[0] if fails_below else fit["high"] <= safe_clearances[-1])


def sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the accepted, the undecided and the rejected fits; [] without fits."""
    classified = classify_fits(cases)
    if classified is None:
        return []
    lines = [
        _accepted_sentence(classified),
        *_load_sentences(cases, classified),
        *(_undecided_sentence(classified, fit) for fit in classified.undecided[:MAX_LISTED]),
    ]
    if classified.rejected:
        lines.append(f"Exceeding a limit at the mean clearance: {_names_text(classified.rejected)}.")
    if classified.undecided:
        clearance_texts = dict.fromkeys(
            _micrometres_text(_critical_clearance(classified, fit)) for fit in classified.undecided
        )
        lines.append(f"To decide, add {wording.sentence_list(list(clearance_texts))} to the sweep.")
    lines += [*_unchecked_end_sentences(classified), *_wear_allowance_sentences(cases, classified)]
    return [" ".join(lines)]


def accepted_cases(cases: FinishedCases) -> np.ndarray | None:
    """Return which cases (n,) are those of accepted fits, or None without fits."""
    classified = classify_fits(cases)
    if classified is None:
        return None
    return np.isin(cases.values_of(classified.path).astype(float), [fit["mean"] for fit in classified.accepted])


def accepted_text(cases: FinishedCases) -> str:
    """Return the names of the accepted fits, or ''."""
    classified = classify_fits(cases)
    return _names_text(classified.accepted) if classified is not None else ""


def _wear_allowance_sentences(cases: FinishedCases, classified: ClassifiedFits) -> list[str]:
    """Return by how much wear may widen the largest clearances of accepted fits, or [] without wear."""
    joint_name = classified.path.split(".")[1]
    wears = any(wording.joint_name(joint.name) == joint_name and joint.wear_bins for joint in cases.layout.joints)
    if not wears or not classified.accepted or _fails_below(classified):
        return []
    largest = classified.safe_clearances[-1]
    allowances = [
        f"{_micrometres_text(largest - fit['high'])} for {fit['name']}" for fit in classified.accepted[:MAX_LISTED]
    ]
    return [
        f"Wear may widen the largest clearances up to {_micrometres_text(largest)}: "
        f"by {wording.sentence_list(allowances)}."
    ]


def _fails_below(classified: ClassifiedFits) -> bool:
    """Return whether small clearances exceed a limit, so that the smallest clearance of a fit decides."""
    unsafe, safe = classified.unsafe_clearances, classified.safe_clearances
    return bool(unsafe and safe and unsafe[0] < safe[0])


def _critical_clearance(classified: ClassifiedFits, fit: Mapping[str, Any]) -> float:
    """Return the end of a fit's clearances (m) towards the limit."""
    return float(fit["low"] if _fails_below(classified) else fit["high"])


def _unchecked_end(classified: ClassifiedFits) -> tuple[float, float] | None:
    """Return the other end (m) of the accepted tolerances and the nearest clearance run (m), or None if it was run."""
    run_clearances = tuple(classified.margins)
    if not classified.accepted:
        return None
    if _fails_below(classified):
        end, outermost_run = max(fit["high"] for fit in classified.accepted), max(run_clearances)
        return (end, outermost_run) if end > outermost_run else None
    end, outermost_run = min(fit["low"] for fit in classified.accepted), min(run_clearances)
    return (end, outermost_run) if end < outermost_run else None


def _unchecked_end_sentences(classified: ClassifiedFits) -> list[str]:
    """Return sentences on the other ends of the accepted tolerances if they lie beyond all clearances run, or []."""
    unchecked = _unchecked_end(classified)
    if unchecked is None:
        return []
    extreme_clearance, extreme_run = unchecked
    preposition, direction = ("above", "up to") if _fails_below(classified) else ("below", "down to")
    texts = [_micrometres_text(length) for length in (extreme_run, extreme_clearance)]
    lines = [f"Clearances {preposition} {texts[0]}, {direction} {texts[1]}, were not run."]
    margins = list(classified.margins.values())[:: -1 if _fails_below(classified) else 1]
    trend = "The margin does not shrink towards them; to" if len(margins) > 1 and margins[0] >= margins[1] else "To"
    return [*lines, f"{trend} check them, add {texts[1]} to the sweep."] if extreme_clearance > 0.0 else lines


def _accepted_sentence(classified: ClassifiedFits) -> str:
    """Return which fits meet the limits, over the whole tolerance or, where one end was not run, at the other end."""
    if not classified.accepted:
        return "No fit is known to meet the limits over its whole tolerance."
    adjective, side, nearest = (
        ("smallest", "above", classified.safe_clearances[0])
        if _fails_below(classified)
        else ("largest", "below", classified.safe_clearances[-1])
    )
    verb, possessive = ("meets", "its") if len(classified.accepted) == 1 else ("meet", "their")
    subject, clearance_text = (
        f"{_names_text(classified.accepted)} {verb} the limits",
        f"{possessive} {adjective} clearance",
    )
    reason = f"lies {side} one that meets them ({_micrometres_text(nearest)})."
    if _unchecked_end(classified):
        return f"{subject} {'down' if side == 'above' else 'up'} to {clearance_text}, which {reason}"
    return f"{subject} over {possessive} whole tolerance: {clearance_text} {reason}"


def _load_sentences(cases: FinishedCases, classified: ClassifiedFits) -> list[str]:
    """Return a sentence on the limited figures of the accepted fits at their mean clearances, or []."""
    loads = accepted_loads(cases, classified)
    return [f"At their mean clearances, {wording.sentence_list(loads)}."] if loads else []


def accepted_loads(cases: FinishedCases, classified: ClassifiedFits) -> list[str]:
    """Return the worst value of each limited figure of the accepted fits: ['load peak is at most 41.9 kN']."""
    means = [fit["mean"] for fit in classified.accepted]
    is_accepted = np.isin(cases.values_of(classified.path).astype(float), means)
    return [
        f"the {cases.column_label(limit.column)} is {limit.kind.replace('_', ' ')} "
        f"{_worst_text(cases, limit, is_accepted)}"
        for limit in cases.limits
        if is_accepted.any() and np.isfinite(cases.values_of(limit.column).astype(float)[is_accepted]).any()
    ][:MAX_LISTED]


def _worst_text(cases: FinishedCases, limit: Limit, is_member: np.ndarray) -> str:
    """Return the value nearest to a limit among some cases in words; is_member : (n,)."""
    values = cases.values_of(limit.column).astype(float)[is_member]
    worst = np.nanmax(values) if limit.kind == "at_most" else np.nanmin(values)
    return cases.format_values(limit.column, [float(worst)])[0]


def _undecided_sentence(classified: ClassifiedFits, fit: Mapping[str, Any]) -> str:
    """Return why a fit is undecided: the limit of its tolerance that no run covers, and the nearest clearances run."""
    adjective, clearance = "smallest" if _fails_below(classified) else "largest", _critical_clearance(classified, fit)
    next_smaller = max(
        (value for value in (*classified.safe_clearances, *classified.unsafe_clearances) if value <= clearance),
        default=None,
    )
    next_larger = min(
        (value for value in (*classified.safe_clearances, *classified.unsafe_clearances) if value > clearance),
        default=None,
    )
    neighbours = [
        f"{_micrometres_text(value)} ({'met' if value in classified.safe_clearances else 'exceeded'})"
        for value in (next_smaller, next_larger)
        if value
    ]
    if len(neighbours) == 2:
        location = f"lies between {neighbours[0]} and {neighbours[1]}"
    else:
        location = f"lies {'above' if next_larger is None else 'below'} {neighbours[0]}, the {adjective} that was run"
    return f"{fit['name']} is open: its {adjective} clearance, {_micrometres_text(clearance)}, {location}."


def _names_text(fits: Sequence[Mapping[str, Any]]) -> str:
    return wording.sentence_list([fit["name"] for fit in fits])


def _micrometres_text(clearance: float) -> str:
    """Return a clearance (m) in micrometres."""
    return f"{1e6 * clearance:.4g}{wording.BLANK}\u00b5m"
