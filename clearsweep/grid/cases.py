"""Numbers the cases of a grid, and computes their content and their identities without creating all of them."""

import hashlib
import json
import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import accumulate, product
from typing import Any, NamedTuple

from .. import MODEL_VERSION
from .keys.kinds import Shape, Word, value_key
from .resolve import Shared

MOST_CACHED_ROWS = 4096  # rows of a factor kept in memory while all cases are enumerated

Words = frozenset[tuple[str, str]]  # swept paths and their law names


class Block(NamedTuple):
    """A combination of law names and the axes in use with it."""

    words: dict[str, str | None]  # swept law names; None: not in use
    paths: tuple[str, ...]
    size: int


class Factor(NamedTuple):
    """Axes that depend on the same law names, in blocks; the cases of a grid are the product of its factors."""

    blocks: tuple[Block, ...]
    ends: tuple[int, ...]  # index after the last row of each block

    @property
    def size(self) -> int:
        """Return the number of combinations of these axes."""
        return self.ends[-1]

    def point(self, index: int, axes: Mapping[str, tuple[Any, ...]]) -> dict[str, Any]:
        """Return the values of these axes at `index`; the last axis varies fastest."""
        block_index = bisect_right(self.ends, index)
        block = self.blocks[block_index]
        index -= self.ends[block_index] - block.size
        values: dict[str, Any] = dict(block.words)
        for path in reversed(block.paths):
            index, k = divmod(index, len(axes[path]))
            values[path] = axes[path][k]
        return values


class Step(NamedTuple):
    """Axes that vary in step: cases take their values row by row."""

    paths: tuple[str, ...]
    rows: tuple[int, ...]  # positions on the axes; only the first of equal rows

    @property
    def size(self) -> int:
        """Return the number of different rows."""
        return len(self.rows)

    def point(self, index: int, axes: Mapping[str, tuple[Any, ...]]) -> dict[str, Any]:
        """Return the values of these axes at `index`."""
        return {path: axes[path][self.rows[index]] for path in self.paths}


def step_of(paths: tuple[str, ...], axes: Mapping[str, tuple[Any, ...]]) -> Step:
    """Return the axes as a Step; of equal rows only the first is kept."""
    rows: dict[tuple[Any, ...], int] = {}
    for row, values in enumerate(zip(*(axes[path] for path in paths), strict=True)):
        rows.setdefault(values, row)
    return Step(paths, tuple(rows.values()))


def factor_of(
    paths: list[str], axes: Mapping[str, tuple[Any, ...]], shape: Shape, names_in_grid: Mapping[str, frozenset[str]]
) -> Factor:
    """Return the blocks of axes that depend on the same law names, one for each distinct combination."""
    law_paths = [path for path in paths if isinstance(shape[path], Word)]
    blocks = {}
    for law_names in product(*(axes[path] for path in law_paths)):
        names = dict(names_in_grid) | {path: frozenset({word}) for path, word in zip(law_paths, law_names, strict=True)}
        laws_in_use = {
            path: word if value_key(shape, path).used(names) else None
            for path, word in zip(law_paths, law_names, strict=True)
        }
        used_paths = tuple(path for path in paths if path not in laws_in_use and value_key(shape, path).used(names))
        blocks[tuple(laws_in_use.values())] = Block(
            laws_in_use, used_paths, math.prod(len(axes[path]) for path in used_paths)
        )
    return Factor(tuple(blocks.values()), tuple(accumulate(block.size for block in blocks.values())))


def words_at(point: Mapping[str, Any]) -> Words:
    """Return the law names among the values at a point."""
    return frozenset((path, value) for path, value in point.items() if isinstance(value, str))


def combined(
    factors: Sequence[Factor | Step],
    axes: Mapping[str, tuple[Any, ...]],
    texts_of: Callable[[Mapping[str, Any]], dict[str, str]],
    interval: range,
) -> Iterator[tuple[Words, dict[str, str]]]:
    """Yield law names and value texts of the cases in `interval`, a range of indices of step 1, in order.

    `texts_of` returns the texts of part of a point.  Cases before the range take no time.
    """
    if not factors:
        if len(interval):
            yield frozenset(), {}
        return
    *outer_factors, last = factors

    def rows(indices: range) -> Iterator[tuple[Words, dict[str, str]]]:
        points = (last.point(k, axes) for k in indices)
        return ((words_at(point), texts_of(point)) for point in points)

    cached_rows = list(rows(range(last.size))) if last.size <= MOST_CACHED_ROWS else None
    outer = range(interval.start // last.size, -(-interval.stop // last.size))
    for k, (outer_words, outer_texts) in zip(outer, combined(outer_factors, axes, texts_of, outer), strict=True):
        start, end = max(interval.start - k * last.size, 0), min(interval.stop - k * last.size, last.size)
        for row_words, row_texts in rows(range(start, end)) if cached_rows is None else cached_rows[start:end]:
            yield outer_words | row_words, outer_texts | row_texts


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
_PLACEHOLDER = "\0{}\0"  # placeholder of a varied value; no written value contains such characters


class Slot(NamedTuple):
    """A value of a case that follows from a single other value."""

    path: str
    source: str  # path of the other value; its own path if it varies itself
    derive: Callable[[Value], Value]


def _same(value: Value) -> Value:
    return value


def _half(length: float) -> float:
    return length / 2.0


def _discard(revolutions: float) -> float:
    return 2.0 if revolutions > 2.0 else 0.0


def _saved(revolutions: float) -> float:
    return min(2.0, revolutions)


def following(paths: Collection[str]) -> Iterator[Slot]:
    """Yield the values that follow from one other value if they are absent; `paths` : those of all keys."""
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
        for target in _OF_BOTH.get(key, ()):
            yield Slot(f"{wear}{_WEAR}{target}", path, _same)


def derived(values_by_path: Mapping[str, Value]) -> dict[str, Value]:
    """Return a copy without absent values (None) and with the defaults that follow from other values."""
    values = {path: value for path, value in values_by_path.items() if value is not None}
    for slot in following(values_by_path):
        if slot.source in values:
            values.setdefault(slot.path, slot.derive(values[slot.source]))
    return {path: value for path, value in values.items() if path.partition(_WEAR)[2] not in _OF_BOTH}


def nested(values_by_path: Mapping[str, Any], pairs: Collection[str]) -> dict[str, Any]:
    """Return nested dicts from dotted paths; sections at the paths `pairs` become lists, as in a grid file."""
    return _listed(_tree(values_by_path), pairs)


def _tree(values_by_path: Mapping[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for path, value in values_by_path.items():
        *parents, key = path.split(".")
        section = tree
        for parent in parents:
            section = section.setdefault(parent, {})
        section[key] = value
    return tree


def _listed(tree: dict[str, Any], pairs: Collection[str]) -> dict[str, Any]:
    """Return the tree, changed in place, with lists at the paths `pairs`."""
    for path in pairs:
        *parents, key = path.split(".")
        section = tree
        for parent in parents:
            section = section.get(parent, {})
        if section.get(key):
            section[key] = [section[key][index] for index in sorted(section[key])]
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

    def __init__(self, paths: Collection[str], varied_paths: Collection[str]):
        """Prepare for the `paths` of all keys, of which some are `varied_paths`."""
        slots = [slot for slot in following(paths) if slot.path not in varied_paths]
        self.slots = {source: [slot for slot in slots if slot.source == source] for source in varied_paths}

    def of(self, point: Mapping[str, Value]) -> dict[str, str]:
        """Return path -> text of the varied values at a point and of all values that follow from them."""
        texts = {}
        for path, value in point.items():
            if value is not None and not isinstance(value, str):
                texts[path] = _text(value)
                for slot in self.slots[path]:
                    texts[slot.path] = _text(slot.derive(value))
        return texts


def _text(value: float) -> str:
    return float.__repr__(value) if isinstance(value, float) else json.dumps(value)


class Pattern:
    """A case with some values left open."""

    def __init__(self, values_by_path: Mapping[str, Value], varied_paths: Collection[str], pairs: Collection[str]):
        """Prepare from path -> value of one such case, None for absent values, and the paths of varied values.

        pairs : paths of the sections that are written as lists
        """
        self.values, self._pairs = derived(values_by_path), pairs
        present_paths = {path for path, value in values_by_path.items() if value is not None}
        own_slots = [Slot(path, path, _same) for path in varied_paths if path in self.values]
        following_slots = [
            slot for slot in following(values_by_path) if slot.source in varied_paths and slot.path not in present_paths
        ]
        self.slots = tuple(slot for slot in (*own_slots, *following_slots) if slot.path in self.values)
        self._tree = _shared(_tree(self.values))
        pairs_used = [pair for pair in pairs if any(path.startswith(f"{pair}.") for path in self.values)]
        self._changing = _sections_above([*(slot.path for slot in self.slots), *pairs_used])
        self._targets = [(slot.path.split("."), slot.source, slot.derive) for slot in self.slots]

    def case(self, point: Mapping[str, Value]) -> dict[str, Any]:
        """Return the case at a point, swept path -> value, in the form of a grid file."""
        tree = dict(self._tree)
        for *parents, key in self._changing:
            section = tree
            for parent in parents:
                section = section[parent]
            section[key] = dict(section[key])
        for (*parents, key), source, derive in self._targets:
            section = tree
            for parent in parents:
                section = section[parent]
            section[key] = derive(point[source])
        return _listed(tree, self._pairs)

    @cached_property
    def text(self) -> str:
        """Return the text of the identity with %(path)s for every varied value."""
        placeholders = {slot.path: _PLACEHOLDER.format(slot.path) for slot in self.slots}
        text = identity_text(nested(self.values | placeholders, self._pairs)).replace("%", "%%")
        for path, placeholder in placeholders.items():
            text = text.replace(json.dumps(placeholder), f"%({path})s")
        return text


def _shared(tree: dict[str, Any]) -> Shared:
    """Return nested sections as sections that cases share."""
    return Shared({key: _shared(value) if isinstance(value, dict) else value for key, value in tree.items()})


def _sections_above(paths: Iterable[str]) -> list[list[str]]:
    """Return the sections that contain one of the paths, outer ones first."""
    parts = [path.split(".") for path in paths]
    parents = dict.fromkeys(tuple(names[:depth]) for names in parts for depth in range(1, len(names)))
    return sorted(map(list, parents), key=len)
