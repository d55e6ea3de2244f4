"""Shared content of cases with the same law names, so that creating a further case takes little time."""

import hashlib
import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cached_property
from typing import Any, NamedTuple

from .. import MODEL_VERSION
from .resolve import Shared

Value = Any  # value of a key: a number in SI, a word, True for a flag

#: The sections that, with `simulate`, decide the identity of a case.
_IDENTITY = ("mechanism", "drive", "loads", "life", "uncertain", "joints")
PATIENCE = "time_budget"  # keys of `simulate` that are not part of the identity: how long to wait for a case
#: Key of both bodies below `wear`, as users write it -> the keys of each body that follow from it.
_OF_BOTH = {
    "coefficient": ("bearing_coefficient", "journal_coefficient"),
    "running_in.steady": ("bearing_coefficient", "journal_coefficient"),
    "running_in.initial": ("running_in.bearing_initial", "running_in.journal_initial"),
}
_WEAR = ".wear."
_SHOWN = "\0{}\0"  # placeholder of a varied value; no written value contains such characters


class Slot(NamedTuple):
    """A value of a case that follows from a single other value."""

    path: str
    source: str  # path of the other value; its own path if it varies itself
    follow: Callable[[Value], Value]


def _same(value: Value) -> Value:
    return value


def _half(length: float) -> float:
    return length / 2.0


def _discard(revolutions: float) -> float:
    return 2.0 if revolutions > 2.0 else 0.0


def _saved(revolutions: float) -> float:
    return min(2.0, revolutions)


def following(paths: Collection[str]) -> Iterator[Slot]:
    """Yield the values that, if absent, follow from one other value, given the `paths` of all keys."""
    for path in paths:
        if path.endswith(".center"):
            yield Slot(path, f"{path.removesuffix('center')}length", _half)
        if path.endswith(".center.0"):  # body with pins, in space
            yield Slot(path, f"{path.removesuffix('center.0')}length", _half)
        if path.endswith(".journal_length"):
            yield Slot(path, f"{path.removesuffix('journal_length')}length", _same)
    yield Slot("simulate.discard", "simulate.revolutions", _discard)
    yield Slot("save.revolutions", "simulate.revolutions", _saved)
    for path in paths:
        wear, _, key = path.partition(_WEAR)
        for other in _OF_BOTH.get(key, ()):
            yield Slot(f"{wear}{_WEAR}{other}", path, _same)


def derived(flat: Mapping[str, Value]) -> dict[str, Value]:
    """Return a copy without absent values (None) and with the defaults that follow from other values."""
    values = {path: value for path, value in flat.items() if value is not None}
    for slot in following(flat):
        if slot.source in values:
            values.setdefault(slot.path, slot.follow(values[slot.source]))
    return {path: value for path, value in values.items() if path.partition(_WEAR)[2] not in _OF_BOTH}


def nested(flat: Mapping[str, Any], pairs: Collection[str]) -> dict[str, Any]:
    """Return nested dicts from dotted paths; sections at the paths `pairs` become lists, as in a grid file."""
    return _listed(_tree(flat), pairs)


def _tree(flat: Mapping[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for path, value in flat.items():
        *above, key = path.split(".")
        inside = tree
        for part in above:
            inside = inside.setdefault(part, {})
        inside[key] = value
    return tree


def _listed(tree: dict[str, Any], pairs: Collection[str]) -> dict[str, Any]:
    """Return the tree, changed in place, with lists at the paths `pairs`."""
    for path in pairs:
        *above, key = path.split(".")
        inside = tree
        for part in above:
            inside = inside.get(part, {})
        if inside.get(key):
            inside[key] = [inside[key][place] for place in sorted(inside[key])]
    return tree


def identity_text(case: Mapping[str, Any]) -> str:
    """Return the text that determines the identity of a resolved case: all keys but `save` and time_budget."""
    content = {key: case[key] for key in _IDENTITY if key in case}
    content["simulate"] = {key: value for key, value in case["simulate"].items() if key != PATIENCE}
    return json.dumps(
        content | {"model_version": MODEL_VERSION}, sort_keys=True, separators=(",", ":"), allow_nan=False
    )


def name_of(text: str) -> str:
    """Return the identity, 16 hexadecimal digits, from its text."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def number_of(text: str) -> int:
    """Return the identity as a number below 2**64, from its text; ten times as fast as converting the name."""
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8])


class Texts:
    """The varied values as they appear in the text of an identity."""

    def __init__(self, paths: Collection[str], varied: Collection[str]):
        """Prepare for the `paths` of all keys, of which some are `varied`."""
        slots = [slot for slot in following(paths) if slot.path not in varied]
        self.slots = {source: [slot for slot in slots if slot.source == source] for source in varied}

    def of(self, point: Mapping[str, Value]) -> dict[str, str]:
        """Return path -> text of the varied values at a point and of all values that follow from them."""
        texts = {}
        for path, value in point.items():
            if value is not None and not isinstance(value, str):
                texts[path] = _text(value)
                for slot in self.slots[path]:
                    texts[slot.path] = _text(slot.follow(value))
        return texts


def _text(value: float) -> str:
    return float.__repr__(value) if isinstance(value, float) else json.dumps(value)


class Pattern:
    """A case with some values left open."""

    def __init__(self, flat: Mapping[str, Value], varied: Collection[str], pairs: Collection[str]):
        """Prepare from path -> value of one such case, None for absent values, and the paths of varied values.

        pairs : paths of sections written as lists.
        """
        self.values, self._pairs = derived(flat), pairs
        present = {path for path, value in flat.items() if value is not None}
        own = [Slot(path, path, _same) for path in varied if path in self.values]
        others = [slot for slot in following(flat) if slot.source in varied and slot.path not in present]
        self.slots = tuple(slot for slot in (*own, *others) if slot.path in self.values)
        self._tree = _shared(_tree(self.values))
        listed = [pair for pair in pairs if any(path.startswith(f"{pair}.") for path in self.values)]
        self._changing = _sections_above([*(slot.path for slot in self.slots), *listed])
        self._places = [(slot.path.split("."), slot.source, slot.follow) for slot in self.slots]

    def case(self, point: Mapping[str, Value]) -> dict[str, Any]:
        """Return the case at a point, swept path -> value, in the form of a grid file."""
        tree = dict(self._tree)
        for *above, key in self._changing:
            inside = tree
            for part in above:
                inside = inside[part]
            inside[key] = dict(inside[key])
        for (*above, key), source, follow in self._places:
            inside = tree
            for part in above:
                inside = inside[part]
            inside[key] = follow(point[source])
        return _listed(tree, self._pairs)

    @cached_property
    def text(self) -> str:
        """Return the text of the identity with %(path)s for every varied value."""
        shown = {slot.path: _SHOWN.format(slot.path) for slot in self.slots}
        text = identity_text(nested(self.values | shown, self._pairs)).replace("%", "%%")
        for path, word in shown.items():
            text = text.replace(json.dumps(word), f"%({path})s")
        return text


def _shared(tree: dict[str, Any]) -> Shared:
    """Return nested sections as sections that cases share."""
    return Shared({key: _shared(value) if isinstance(value, dict) else value for key, value in tree.items()})


def _sections_above(paths: Iterable[str]) -> list[list[str]]:
    """Return the sections that contain one of the paths, outer ones first."""
    parts = [path.split(".") for path in paths]
    above = dict.fromkeys(tuple(part[:depth]) for part in parts for depth in range(1, len(part)))
    return sorted(map(list, above), key=len)
