"""Fits of joints: what a verdict at their mean clearances leaves open."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from ..language import wording
from .words import Words

MAX_LISTED = 4  # fits in one sentence


def coverage_text(record: Mapping[str, Any], answer: Mapping[str, Any], words: Words) -> str:
    """Return which fits meet the limits up to the end of their tolerance; '' without fits or limits.

    With fits in one joint, the end of a tolerance towards the limit is covered if a larger (smaller) clearance that was
    run meets the limits and the verdict changes once.  Pairs of fits are judged at their mean clearances alone.
    """
    drawn = (record.get("sample") or {}).get("drawn", {})
    paths = [path for path in record.get("fits") or {} if answer["roles"].get(path) and path not in drawn]
    if not paths or not answer["designs"]:
        return ""
    if len(paths) > 1 or any(set(design["values"]) != set(paths) for design in answer["designs"]):
        return "Fits are judged at their mean clearances; add the ends of their tolerances to check the whole range."
    (path,) = paths
    fits = {fit["name"]: fit for fit in record["fits"][path]}
    clearance_of = {name: fit["mean"] for name, fit in fits.items()}
    named = [(design["values"][path], design["verdict"]) for design in answer["designs"]]
    verdicts = sorted((clearance_of.get(value, value), verdict == "meets") for value, verdict in named)
    covered = [
        name for name, verdict in named if name in fits and verdict == "meets" and _is_covered(fits[name], verdicts)
    ]
    open_fits = [name for name, verdict in named if name in fits and verdict == "meets" and name not in covered]
    end = "from the smallest clearance of its tolerance on" if _fails_below(verdicts) else "up to the largest clearance"
    parts = [f"{wording.sentence_list(covered[:MAX_LISTED])} {end}"] if covered else []
    parts += [f"{wording.sentence_list(open_fits[:MAX_LISTED])} at the mean clearance only"] if open_fits else []
    return f"Limits met: {'; '.join(parts)}." if parts else "No fit meets the limits at its mean clearance."


def _is_covered(fit: Mapping[str, Any], verdicts: list[tuple[float, bool]]) -> bool:
    """Return whether the clearances that meet the limits enclose the end of a tolerance towards the limit."""
    safe = [clearance for clearance, met in verdicts if met]
    if len(_changes(verdicts)) > 1 or not safe:
        return False
    return bool(fit["low"] >= safe[0] if _fails_below(verdicts) else fit["high"] <= safe[-1])


def _changes(verdicts: list[tuple[float, bool]]) -> list[bool]:
    """Return whether the limits are met just below each clearance at which the verdict changes."""
    return [met for (_, met), (_, met_next) in pairwise(verdicts) if met != met_next]


def _fails_below(verdicts: list[tuple[float, bool]]) -> bool:
    return _changes(verdicts) == [False]
