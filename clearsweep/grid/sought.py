"""Reads `seek`: the largest or smallest value of one key with which cases keep to the limits."""

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from ..language import quantity
from ..language.errors import InputError, nearest, shown
from .added import ADDED
from .document import WrittenValue
from .draft import Draft
from .keys import Number, Word, value_key

SEEK = "seek"
ENDS, FOR = ("largest", "smallest"), ("each", "all")
KEYS = (*ENDS, "between", "within", "meeting", "for")
FINEST = 40  # times a range can be halved: what is left is near the rounding of floats
FIRST_STRETCHES = 4  # of the range, whose ends are tried first
_EXAMPLE = "{largest: joints.rod-slider.clearance, between: [5 um, 200 um], within: 1 um}"


class Seek(NamedTuple):
    """What is sought, in SI."""

    end: str  # one of ENDS
    path: str
    between: tuple[float, float]
    within: float
    each: bool  # for each case of the other axes; False: for all of them together

    @property
    def last(self) -> int:
        """Return the number of equal steps, a power of 2, that the range is divided into: none is above `within`."""
        low, high = self.between
        halvings = max(math.ceil(math.log2((high - low) / self.within)), FIRST_STRETCHES.bit_length() - 1)
        return 1 << halvings

    def value(self, place: int) -> float:
        """Return the value at a place from 0 to `last`, counted from the end that is the safer one."""
        low, high = (Fraction(end) for end in self.between)
        k = place if self.end == ENDS[0] else self.last - place
        return float(low + (high - low) * k / self.last)

    def first(self) -> tuple[float, ...]:
        """Return the values that are tried first, ascending."""
        return tuple(sorted(self.value(place) for place in range(0, self.last + 1, self.last // FIRST_STRETCHES)))

    def written(self) -> dict[str, Any]:
        """Return the section as a grid may have it, in SI."""
        head = {self.end: self.path, "between": list(self.between), "within": self.within}
        return head | {"meeting": "limits", "for": FOR[not self.each]}


def range_of(draft: Draft, root: WrittenValue) -> tuple[str, WrittenValue, WrittenValue] | None:
    """Return the path that is sought, where it stands, and its range as written; None where there is none to vary."""
    section = root.value.get(SEEK) if isinstance(root.value, dict) else None
    if section is None:
        return None
    if not isinstance(section.value, dict):
        draft.problems.add(section, SEEK, f"found {shown(section.value)}; expected a section such as {_EXAMPLE}")
        return None
    for key in section.value:
        if key not in (*KEYS, ADDED):
            sentence = f"unknown key '{key}'{nearest(key, KEYS)} (allowed: {', '.join(KEYS)})"
            draft.problems.add(section.key_place(key), f"{SEEK}.{key}", sentence)
    ends = [end for end in ENDS if end in section.value]
    between = section.value.get("between")
    if len(ends) != 1:
        told = "has both largest and smallest; write one of them" if ends else "is missing; write the path to vary"
        draft.problems.add(section, f"{SEEK}.{ENDS[0]}", f"{told}, such as {_EXAMPLE}")
        return None
    path = section.value[ends[0]]
    if between is None or not isinstance(between.value, list) or len(between.value) != 2:
        found = "is missing" if between is None else f"found {shown(between.value)}"
        draft.problems.add(between or section, f"{SEEK}.between", f"{found}; write the range, such as [5 um, 200 um]")
        return None
    if not isinstance(path.value, str):
        draft.problems.add(path, f"{SEEK}.{ends[0]}", f"found {shown(path.value)}; expected a dotted path")
        return None
    return path.value, path, between


def read(draft: Draft, root: WrittenValue, limits: Mapping[str, Any]) -> Seek | None:
    """Return what is sought, its axis being known; None where nothing is or something is wrong."""
    section = root.value.get(SEEK) if isinstance(root.value, dict) else None
    path = next((path for path, way in draft.way.items() if way == SEEK), None)
    if section is None or path is None or path not in draft.axes:
        return None
    given, noted = section.value, len(draft.problems)
    (end,) = [end for end in ENDS if end in given]
    low, high = draft.axes[path]
    if low >= high:
        draft.problems.add(given["between"], f"{SEEK}.between", "the first value is not below the second; swap them")
    if not limits:
        draft.problems.add(section, SEEK, "there are no limits to meet; write the section 'limits'")
    for key, allowed in (("meeting", ("limits",)), ("for", FOR)):
        if key in given and given[key].value not in allowed:
            sentence = f"found {shown(given[key].value)}; expected {' or '.join(allowed)}"
            draft.problems.add(given[key], f"{SEEK}.{key}", sentence)
    for other in draft.axes:
        always_used(draft, given[end], SEEK, other)
    within = _within(draft, section, path)
    if within is None or len(draft.problems) > noted:
        return None
    if not (high - low) / 2.0**FINEST < within <= (high - low) / FIRST_STRETCHES:
        least, most = (quantity.said(size, _unit(draft, path)) for size in ((high - low) / 1e12, (high - low) / 4.0))
        sentence = f"found {given['within'].value}; allowed: {least} to {most}, a quarter of the range"
        draft.problems.add(given["within"], f"{SEEK}.within", sentence)
        return None
    each = "for" not in given or given["for"].value == FOR[0]
    return Seek(end, path, (low, high), within, each)


def _within(draft: Draft, section: WrittenValue, path: str) -> float | None:
    """Return the width of the answer that is good enough (SI), None where it is missing or wrong."""
    written = section.value.get("within")
    if written is None:
        draft.problems.add(section, f"{SEEK}.within", "is missing; write how close the answer has to be, such as 1 um")
        return None
    try:
        return quantity.read(written.value, _unit(draft, path))
    except InputError as error:
        draft.problems.add(written, f"{SEEK}.within", str(error))
        return None


def _unit(draft: Draft, path: str) -> str:
    node = draft.shape[path]
    assert isinstance(node, Number)  # others cannot be sought
    exponents = draft.reached(f"{path.rpartition('.')[0]}.exponent")
    return quantity.exponent_of(node.fields(draft.names)[0].unit, exponents[0] if exponents else 1.5)


def always_used(draft: Draft, place: WrittenValue, section: str, path: str) -> None:
    """Note a swept key that some of the swept laws do not use: cases are added one by one, and each has every value."""
    node = value_key(draft.shape, path)
    if isinstance(node, Word):
        return
    for chooser in node.choosers():
        for law in draft.axes.get(chooser, ()):
            if not node.used(draft.names | {chooser: frozenset({law})}):
                sentence = f"{path} is not used by {law}; with `{section}` every law that is tried has to use every key"
                draft.problems.add(place, section, f"{sentence} that is swept")
                return
