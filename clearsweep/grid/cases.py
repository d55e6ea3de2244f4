"""Numbers the cases of a grid, and computes their content and their identities without creating all of them."""

import hashlib
import json
import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import accumulate, product
from typing import Any, NamedTuple

from .. import MODEL_VERSION
from .keys import KeyTable, Word, value_key
from .resolve import SharedSection
from .written import leaves
from .written.law_files import LAWS, digests_in_use

MAX_CACHED_ROWS = 4096  # rows of a factor kept in memory while all cases are enumerated

LawAssignment = frozenset[tuple[str, str]]  # swept paths and their laws


class LawCombination(NamedTuple):
    """A combination of law names and the axes in use with it."""

    law_by_path: dict[str, str | None]  # swept law names; None: not in use
    paths: tuple[str, ...]
    size: int


class Factor(NamedTuple):
    """Axes that depend on the same law names, by combination of these names.

    The cases of a grid are the product of its factors.
    """

    combinations: tuple[LawCombination, ...]
    stops: tuple[int, ...]  # index after the last row of each combination

    @property
    def size(self) -> int:
        """Return the number of combinations of these axes."""
        return self.stops[-1]

    def point(self, index: int, axes: Mapping[str, tuple[Any, ...]]) -> dict[str, Any]:
        """Return the values of these axes at `index`; the last axis varies fastest."""
        combination_index = bisect_right(self.stops, index)
        combination = self.combinations[combination_index]
        index -= self.stops[combination_index] - combination.size
        values: dict[str, Any] = dict(combination.law_by_path)
        for path in reversed(combination.paths):
            index, k = divmod(index, len(axes[path]))
            values[path] = axes[path][k]
        return values


class ZippedAxes(NamedTuple):
    """Axes that vary together, as those of `zip`: each row of their values is one combination."""

    paths: tuple[str, ...]
    rows: tuple[int, ...]  # positions on the axes; only the first of equal rows

    @property
    def size(self) -> int:
        """Return the number of different rows."""
        return len(self.rows)

    def point(self, index: int, axes: Mapping[str, tuple[Any, ...]]) -> dict[str, Any]:
        """Return the values of these axes at `index`."""
        return {path: axes[path][self.rows[index]] for path in self.paths}


def zipped_axes(paths: tuple[str, ...], axes: Mapping[str, tuple[Any, ...]]) -> ZippedAxes:
    """Return axes that vary together without repeated rows."""
    rows: dict[tuple[Any, ...], int] = {}
    for row, values in enumerate(zip(*(axes[path] for path in paths), strict=True)):
        rows.setdefault(values, row)
    return ZippedAxes(paths, tuple(rows.values()))


def factor_of(
    paths: list[str],
    axes: Mapping[str, tuple[Any, ...]],
    key_table: KeyTable,
    names_in_grid: Mapping[str, frozenset[str]],
) -> Factor:
    """Return axes that depend on the same law names, for each distinct combination of these names."""
    law_paths = [path for path in paths if isinstance(key_table[path], Word)]
    combinations = {}
    for law_values in product(*(axes[path] for path in law_paths)):
        names = dict(names_in_grid) | {
            path: frozenset({word}) for path, word in zip(law_paths, law_values, strict=True)
        }
        laws_in_use = {
            path: word if value_key(key_table, path).is_used(names) else None
            for path, word in zip(law_paths, law_values, strict=True)
        }
        used_paths = tuple(
            path for path in paths if path not in laws_in_use and value_key(key_table, path).is_used(names)
        )
        combinations[tuple(laws_in_use.values())] = LawCombination(
            laws_in_use, used_paths, math.prod(len(axes[path]) for path in used_paths)
        )
    return Factor(
        tuple(combinations.values()), tuple(accumulate(combination.size for combination in combinations.values()))
    )


def law_assignment_at(point: Mapping[str, Any]) -> LawAssignment:
    """Return the law names among the values at a point, with their paths."""
    return frozenset((path, value) for path, value in point.items() if isinstance(value, str))


def product_cases(
    factors: Sequence[Factor | ZippedAxes],
    axes: Mapping[str, tuple[Any, ...]],
    texts_of: Callable[[Mapping[str, Any]], dict[str, str]],
    indices: range,
) -> Iterator[tuple[LawAssignment, dict[str, str]]]:
    """Yield law names and value texts of the cases at `indices`, a range of step 1, in order.

    `texts_of` returns the texts of the values of some axes.  Cases before the range are skipped at no cost.
    """
    if not factors:
        if len(indices):
            yield frozenset(), {}
        return
    *outer_factors, last = factors

    def rows(row_indices: range) -> Iterator[tuple[LawAssignment, dict[str, str]]]:
        points = (last.point(k, axes) for k in row_indices)
        return ((law_assignment_at(point), texts_of(point)) for point in points)

    cached_rows = list(rows(range(last.size))) if last.size <= MAX_CACHED_ROWS else None
    outer = range(indices.start // last.size, -(-indices.stop // last.size))
    for k, (outer_assignment, outer_texts) in zip(
        outer, product_cases(outer_factors, axes, texts_of, outer), strict=True
    ):
        start, end = max(indices.start - k * last.size, 0), min(indices.stop - k * last.size, last.size)
        for row_assignment, row_texts in rows(range(start, end)) if cached_rows is None else cached_rows[start:end]:
            yield outer_assignment | row_assignment, outer_texts | row_texts


KeyValue = Any  # value of a key: a number in SI, a word, True for a flag

#: The sections that, with `simulate`, decide the identity of a case.
_IDENTITY_SECTIONS = ("mechanism", "drive", "loads", "life", "uncertain", "joints", "figures")
TIME_BUDGET = "time_budget"  # key of `simulate` that is not part of the identity
#: Key of both bodies below `wear`, as users write it -> the keys of each body that follow from it.
_COEFFICIENTS_PER_BODY = {
    "coefficient": ("bearing_coefficient", "journal_coefficient"),
    "running_in.steady": ("bearing_coefficient", "journal_coefficient"),
    "running_in.initial": ("running_in.bearing_initial", "running_in.journal_initial"),
}
_WEAR_INFIX = ".wear."
_PLACEHOLDER = "\0{}\0"  # placeholder of a varied value; no written value contains such characters


class DependentValue(NamedTuple):
    """A value of a case that is computed from a single other value."""

    path: str
    source: str  # path of the other value; its own path if it varies itself
    derive: Callable[[KeyValue], KeyValue]


def _unchanged(value: KeyValue) -> KeyValue:
    return value


def _half(length: float) -> float:
    return length / 2.0


def _default_discard(revolutions: float) -> float:
    return 2.0 if revolutions > 2.0 else 0.0


def _default_saved_revolutions(revolutions: float) -> float:
    return min(2.0, revolutions)


def dependent_values(paths: Collection[str]) -> Iterator[DependentValue]:
    """Yield the values that, if absent, are computed from one other value, given the `paths` of all keys."""
    for path in paths:
        if path.endswith(".center"):
            yield DependentValue(path, f"{path.removesuffix('center')}length", _half)
        if path.endswith(".center.0"):  # body with pins, in space
            yield DependentValue(path, f"{path.removesuffix('center.0')}length", _half)
        if path.endswith(".journal_length"):
            yield DependentValue(path, f"{path.removesuffix('journal_length')}length", _unchanged)
    yield DependentValue("simulate.discard", "simulate.revolutions", _default_discard)
    yield DependentValue("save.revolutions", "simulate.revolutions", _default_saved_revolutions)
    yield DependentValue("simulate.discard", "simulate.cycles", _default_discard)
    yield DependentValue("save.revolutions", "simulate.cycles", _default_saved_revolutions)
    for path in paths:
        wear, _, key = path.partition(_WEAR_INFIX)
        for target in _COEFFICIENTS_PER_BODY.get(key, ()):
            yield DependentValue(f"{wear}{_WEAR_INFIX}{target}", path, _unchanged)


def with_dependent_values(values_by_path: Mapping[str, KeyValue]) -> dict[str, KeyValue]:
    """Return a copy without absent values (None) and with the defaults that follow from other values."""
    values = {path: value for path, value in values_by_path.items() if value is not None}
    for dependent in dependent_values(values_by_path):
        if dependent.source in values:
            values.setdefault(dependent.path, dependent.derive(values[dependent.source]))
    return {
        path: value for path, value in values.items() if path.partition(_WEAR_INFIX)[2] not in _COEFFICIENTS_PER_BODY
    }


def nest(values_by_path: Mapping[str, Any], list_paths: Collection[str]) -> dict[str, Any]:
    """Return nested dicts from dotted paths; sections at `list_paths` become lists, as in a grid file."""
    return _convert_lists(put_values({}, values_by_path), list_paths)


def put_values(tree: dict[str, Any], values_by_path: Mapping[str, Any]) -> dict[str, Any]:
    """Return a tree, changed in place, with values at dotted paths."""
    for path, value in values_by_path.items():
        *parents, key = path.split(".")
        section = tree
        for parent in parents:
            section = section.setdefault(parent, {})
        section[key] = value
    return tree


def _convert_lists(tree: dict[str, Any], list_paths: Collection[str]) -> dict[str, Any]:
    """Return the tree, changed in place, with lists at `list_paths`."""
    for path in list_paths:
        *parents, key = path.split(".")
        section = tree
        for parent in parents:
            section = section.get(parent, {})
        if section.get(key):
            section[key] = [section[key][index] for index in sorted(section[key])]
    return tree


def identity_text(case: Mapping[str, Any]) -> str:
    """Return the text that determines the identity of a resolved case: all keys but `save` and time_budget.

    Figures of one's own also depend on the number of samples.
    """
    content = {key: case[key] for key in _IDENTITY_SECTIONS if key in case}
    content |= {"samples": case["save"]["samples"]} if "figures" in case else {}
    content["simulate"] = {key: value for key, value in case["simulate"].items() if key != TIME_BUDGET}
    if digests := digests_in_use(case.get(LAWS, ()), (value for _, value in leaves(content))):
        content[LAWS] = digests
    return json.dumps(
        content | {"model_version": MODEL_VERSION}, sort_keys=True, separators=(",", ":"), allow_nan=False
    )


def identity_of_text(text: str) -> str:
    """Return the identity, 16 hexadecimal digits, from its text."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def identity_number(text: str) -> int:
    """Return the identity as a number below 2**64, from its text; ten times as fast as by its hexadecimal digits."""
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8])


class IdentityTexts:
    """Texts of varied values, as they appear in the text of an identity."""

    def __init__(self, paths: Collection[str], varied_paths: Collection[str]):
        """Prepare for the `paths` of all keys, of which some are `varied_paths`."""
        dependents = [dependent for dependent in dependent_values(paths) if dependent.path not in varied_paths]
        self.dependents_by_source = {
            source: [dependent for dependent in dependents if dependent.source == source] for source in varied_paths
        }

    def texts_at(self, point: Mapping[str, KeyValue]) -> dict[str, str]:
        """Return path -> text of the varied values at a point and of all values that follow from them."""
        texts = {}
        for path, value in point.items():
            if value is not None and not isinstance(value, str):
                texts[path] = _text(value)
                for dependent in self.dependents_by_source[path]:
                    texts[dependent.path] = _text(dependent.derive(value))
        return texts


def _text(value: float) -> str:
    return float.__repr__(value) if isinstance(value, float) else json.dumps(value)


class CaseTemplate:
    """A case without its varied values, shared by all cases with the same law names."""

    def __init__(
        self, values_by_path: Mapping[str, KeyValue], varied_paths: Collection[str], list_paths: Collection[str]
    ):
        """Prepare from path -> value of one such case, None for absent values, and the paths of varied values.

        list_paths : paths of the sections that are written as lists
        """
        self.values, self._list_paths = with_dependent_values(values_by_path), list_paths
        present_paths = {path for path, value in values_by_path.items() if value is not None}
        own_values = [DependentValue(path, path, _unchanged) for path in varied_paths if path in self.values]
        default_values = [
            dependent
            for dependent in dependent_values(values_by_path)
            if dependent.source in varied_paths and dependent.path not in present_paths
        ]
        self.dependents = tuple(
            dependent for dependent in (*own_values, *default_values) if dependent.path in self.values
        )
        varied = [dependent.path for dependent in self.dependents]
        self._varied_lists = [path for path in list_paths if any(each.startswith(f"{path}.") for each in varied)]
        fixed_lists = [path for path in list_paths if path not in self._varied_lists]
        self._tree = _make_shared(nest(self.values, fixed_lists))
        parts = [path.split(".") for path in varied]
        parents = dict.fromkeys(tuple(names[:depth]) for names in parts for depth in range(1, len(names)))
        self._sections_to_copy = sorted(map(list, parents), key=len)
        self._assignments = [
            (dependent.path.split("."), dependent.source, dependent.derive) for dependent in self.dependents
        ]

    def case(self, point: Mapping[str, KeyValue]) -> dict[str, Any]:
        """Return the case at a point, swept path -> value, in the form of a grid file."""
        tree = dict(self._tree)
        for *parents, key in self._sections_to_copy:
            section = tree
            for parent in parents:
                section = section[parent]
            section[key] = dict(section[key])
        for (*parents, key), source, derive in self._assignments:
            section = tree
            for parent in parents:
                section = section[parent]
            section[key] = derive(point[source])
        return _convert_lists(tree, self._varied_lists)

    @cached_property
    def identity_template(self) -> str:
        """Return the text of the identity with %(path)s for every varied value."""
        placeholders = {dependent.path: _PLACEHOLDER.format(dependent.path) for dependent in self.dependents}
        text = identity_text(nest(self.values | placeholders, self._list_paths)).replace("%", "%%")
        for path, placeholder in placeholders.items():
            text = text.replace(json.dumps(placeholder), f"%({path})s")
        return text


def _make_shared(tree: dict[str, Any]) -> SharedSection:
    """Return nested sections as sections that cases share."""
    return SharedSection(
        {key: _make_shared(value) if isinstance(value, dict) else value for key, value in tree.items()}
    )
