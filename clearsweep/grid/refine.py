"""Reads `refine`: further cases along the border between acceptable and unacceptable cases."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..language.errors import shown
from .added_cases import check_always_used, count, section_of
from .document import WrittenValue
from .keys import Number, value_key
from .reader import Reader
from .seek import SEEK

REFINE = "refine"
ALONG = "limits"
KEYS = ("along", "cases")
MOST_CASES = 1_000_000
_EXAMPLE = "{along: limits, cases: 200}"


class Refine(NamedTuple):
    """How many cases to add along the border, and which values to subdivide."""

    cases: int  # at most
    paths: tuple[str, ...]  # swept numbers

    def written(self) -> dict[str, Any]:
        """Return the section in the form of a grid file."""
        return {"along": ALONG, "cases": self.cases}


def read(reader: Reader, root: WrittenValue, limits: Mapping[str, Any]) -> Refine | None:
    """Return the section `refine`, the axes being read already, or None if it is missing or wrong."""
    noted = len(reader.problems)
    section = section_of(reader, root, REFINE, KEYS, _EXAMPLE)
    if section is None:
        return None
    border = section.value.get("along")
    if border is not None and border.value != ALONG:
        reader.problems.add(border, f"{REFINE}.along", f"found {shown(border.value)}; expected {ALONG}")
    if SEEK in root.value:
        sentence = "conflicts with `seek`, which finds a border by itself; remove one of the two"
        reader.problems.add(section, REFINE, sentence)
    if not limits:
        reader.problems.add(section, REFINE, "needs limits, whose border it refines; add `limits`")
    paths = tuple(path for path in reader.axes if reader.way[path] == "sweep" and _divisible(reader, path))
    if not paths:
        sentence = "no cases can be added between the cases: `sweep` at least one quantity with two or more values"
        reader.problems.add(section, REFINE, sentence)
    for path in reader.axes:
        check_always_used(reader, section, REFINE, path)
    cases = count(reader, section, (REFINE, "cases"), (1, MOST_CASES), None)
    return None if cases is None or len(reader.problems) > noted else Refine(cases, paths)


def _divisible(reader: Reader, path: str) -> bool:
    """Return whether an axis can be subdivided."""
    node = value_key(reader.shape, path)
    whole = not isinstance(node, Number) or any(use.field.whole for use in node.uses)
    return not whole and not path.endswith(".exponent") and len(reader.axes[path]) > 1
