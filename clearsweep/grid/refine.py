"""Reads `refine`: further cases where the border of the limits runs between those of a grid."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..language import quantity
from ..language.errors import InputError, nearest, shown
from .added_cases import ADDED
from .document import WrittenValue
from .reader import Reader
from .keys import Number, value_key
from .seek import SEEK, always_used

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


def read(reader: Reader, root: WrittenValue, limits: Mapping[str, Any]) -> Refine | None:
    """Return how the grid is refined, its axes being known; None where it is not or something is wrong."""
    section = root.value.get(REFINE) if isinstance(root.value, dict) else None
    if section is None:
        return None
    if not isinstance(section.value, dict):
        reader.problems.add(section, REFINE, f"found {shown(section.value)}; expected a section such as {_EXAMPLE}")
        return None
    noted = len(reader.problems)
    for key in section.value:
        if key not in (*KEYS, ADDED):
            sentence = f"unknown key '{key}'{nearest(key, KEYS)} (allowed: {', '.join(KEYS)})"
            reader.problems.add(section.key_place(key), f"{REFINE}.{key}", sentence)
    border = section.value.get("along")
    if border is not None and border.value != ALONG:
        reader.problems.add(border, f"{REFINE}.along", f"found {shown(border.value)}; expected {ALONG}")
    if SEEK in root.value:
        sentence = "conflicts with `seek`, which finds a border by itself; remove one of the two"
        reader.problems.add(section, REFINE, sentence)
    if not limits:
        reader.problems.add(section, REFINE, "there are no limits whose border could be followed; write `limits`")
    paths = tuple(path for path in reader.axes if reader.way[path] == "sweep" and _divisible(reader, path))
    if not paths:
        sentence = "nothing can lie between the cases: `sweep` at least one quantity with two values or more"
        reader.problems.add(section, REFINE, sentence)
    for path in reader.axes:
        always_used(reader, section, REFINE, path)
    cases = _cases(reader, section)
    return None if cases is None or len(reader.problems) > noted else Refine(cases, paths)


def _divisible(reader: Reader, path: str) -> bool:
    """Return whether there are values between those of an axis that cases can have."""
    node = value_key(reader.shape, path)
    whole = not isinstance(node, Number) or any(use.field.whole for use in node.uses)
    return not whole and not path.endswith(".exponent") and len(reader.axes[path]) > 1


def _cases(reader: Reader, section: WrittenValue) -> int | None:
    """Return how many cases may be added, None where that is missing or wrong."""
    written = section.value.get("cases")
    if written is None:
        reader.problems.add(section, f"{REFINE}.cases", "is missing; write how many further cases there may be")
        return None
    try:
        cases = quantity.read(written.value, "1")
    except InputError as error:
        reader.problems.add(written, f"{REFINE}.cases", str(error))
        return None
    if cases != int(cases) or not 1 <= cases <= MOST_CASES:
        sentence = f"found {written.value}; allowed: a whole number from 1 to {MOST_CASES:,}"
        reader.problems.add(written, f"{REFINE}.cases", sentence)
        return None
    return int(cases)
