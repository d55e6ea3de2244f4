"""Reads `refine`: further cases where the border of the limits runs between those of a grid."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..language import quantity
from ..language.errors import InputError, nearest, shown
from .added import ADDED
from .document import WrittenValue
from .draft import Draft
from .keys import Number, value_key
from .sought import SEEK, always_used

REFINE = "refine"
ALONG = "limits"
KEYS = ("along", "cases")
MOST_CASES = 1_000_000
_EXAMPLE = "{along: limits, cases: 200}"


class Refine(NamedTuple):
    """How many further cases are put where the border runs, and which values may lie between those of the grid."""

    cases: int  # at most
    paths: tuple[str, ...]  # swept numbers

    def written(self) -> dict[str, Any]:
        """Return the section as a grid may have it."""
        return {"along": ALONG, "cases": self.cases}


def read(draft: Draft, root: WrittenValue, limits: Mapping[str, Any]) -> Refine | None:
    """Return how the grid is refined, its axes being known; None where it is not or something is wrong."""
    section = root.value.get(REFINE) if isinstance(root.value, dict) else None
    if section is None:
        return None
    if not isinstance(section.value, dict):
        draft.problems.add(section, REFINE, f"found {shown(section.value)}; expected a section such as {_EXAMPLE}")
        return None
    noted = len(draft.problems)
    for key in section.value:
        if key not in (*KEYS, ADDED):
            sentence = f"unknown key '{key}'{nearest(key, KEYS)} (allowed: {', '.join(KEYS)})"
            draft.problems.add(section.key_place(key), f"{REFINE}.{key}", sentence)
    along = section.value.get("along")
    if along is not None and along.value != ALONG:
        draft.problems.add(along, f"{REFINE}.along", f"found {shown(along.value)}; expected {ALONG}")
    if SEEK in root.value:
        sentence = "conflicts with `seek`, which finds a border by itself; remove one of the two"
        draft.problems.add(section, REFINE, sentence)
    if not limits:
        draft.problems.add(section, REFINE, "there are no limits whose border could be followed; write `limits`")
    paths = tuple(path for path in draft.axes if draft.way[path] == "sweep" and _divisible(draft, path))
    if not paths:
        sentence = "nothing can lie between the cases: `sweep` at least one quantity with two values or more"
        draft.problems.add(section, REFINE, sentence)
    for path in draft.axes:
        always_used(draft, section, REFINE, path)
    cases = _cases(draft, section)
    return None if cases is None or len(draft.problems) > noted else Refine(cases, paths)


def _divisible(draft: Draft, path: str) -> bool:
    """Return whether there are values between those of an axis that cases can have."""
    node = value_key(draft.shape, path)
    whole = not isinstance(node, Number) or any(use.field.whole for use in node.uses)
    return not whole and not path.endswith(".exponent") and len(draft.axes[path]) > 1


def _cases(draft: Draft, section: WrittenValue) -> int | None:
    """Return how many cases may be added, None where that is missing or wrong."""
    written = section.value.get("cases")
    if written is None:
        draft.problems.add(section, f"{REFINE}.cases", "is missing; write how many further cases there may be")
        return None
    try:
        cases = quantity.read(written.value, "1")
    except InputError as error:
        draft.problems.add(written, f"{REFINE}.cases", str(error))
        return None
    if cases != int(cases) or not 1 <= cases <= MOST_CASES:
        sentence = f"found {written.value}; allowed: a whole number from 1 to {MOST_CASES:,}"
        draft.problems.add(written, f"{REFINE}.cases", sentence)
        return None
    return int(cases)
