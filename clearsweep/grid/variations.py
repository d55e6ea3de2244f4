"""Finds which values a grid varies and how: each by each (`sweep`), in step (`zip`, `cases`), by chance (`sample`)."""

from collections.abc import Callable
from itertools import product
from typing import Any

from ..language.errors import nearest, shown
from . import case_table, identified, optimised, sampling, sought
from .axes import Reading, axis
from .document import WrittenValue
from .draft import Draft
from .keys import Number, Section, Shape, Word, value_key

#: The sections that vary values, in the order in which their axes stand; those after `sweep` go in step.
WAYS = ("sweep", "zip", "cases", "sample")
#: The sections whose values may be used by some of the laws that vary beside them, and not by others.
EACH = ("sweep", sought.SEEK, optimised.OPTIMISE, identified.IDENTIFY)


def find(draft: Draft, root: WrittenValue, whole: Shape, fixed: frozenset[str]) -> None:
    """Note the values whose path names something that can be varied; paths in `fixed` are not varied any more."""
    for way in WAYS:
        section = root.value.get(way) if isinstance(root.value, dict) else None
        if section is None:
            continue
        written, where, example = section, way, "[value, ...]"
        if way == "cases" and isinstance(section.value, str):
            written = case_table.read(draft.problems, section)
            if written is None:
                continue
        if way == "sample":
            if not isinstance(section.value, dict):
                sentence = f"found {shown(section.value)}; expected a section with the keys method, n, seed, over"
                draft.problems.add(section, way, sentence)
                continue
            written, where = section.value.get("over", section), "sample.over"
            example = "{normal: {mean: 1 mm, cv: 0.1}}"
            if "over" not in section.value:
                draft.problems.add(section, where, f"is missing; write `dotted.path: {example}`")
                continue
        if not isinstance(written.value, dict) or not written.value:
            nothing = {"sweep": "nothing is swept", "sample": "nothing is drawn"}.get(way, "nothing goes in step")
            rest = f"write `dotted.path: {example}`, or leave the key '{way}' out"
            draft.problems.add(written, where, f"{nothing}; {rest}")
            continue
        for path, values in written.value.items():
            if path not in fixed:
                _enter(draft, way, path, written.key_place(path), values, whole)
        if way == "sample":
            drawn = [path for path in draft.swept if draft.way[path] == "sample"]
            draft.drawn = tuple(drawn)
            draft.sample = sampling.read(draft.problems, section, len(drawn)) if drawn else None


def find_optimised(draft: Draft, root: WrittenValue, whole: Shape) -> None:
    """Note the values that `optimise` and `identify` may choose."""
    for path, (place, values) in optimised.find(draft, root).items():
        _enter(draft, optimised.OPTIMISE, path, place, values, whole)
    for path, (place, values) in identified.find(draft, root).items():
        _enter(draft, identified.IDENTIFY, path, place, values, whole)


def find_sought(draft: Draft, root: WrittenValue, whole: Shape, values_of: Callable[[str], tuple[float, ...]]) -> None:
    """Note the range of the value that is sought, as an axis of its two ends, or of all that is tried."""
    found = sought.range_of(draft, root, values_of)
    for place in found[0] if found else ():
        assert found is not None  # it has a path
        _enter_sought(draft, place.value, place, found[1], whole)


def _enter_sought(draft: Draft, path: str, place: WrittenValue, between: WrittenValue, whole: Shape) -> None:
    """Note the values of one path that is sought."""
    node = whole.get(path)
    if isinstance(node, Word) or (isinstance(node, Number) and any(use.field.whole for use in node.uses)):
        noun = "a name" if isinstance(node, Word) else "a whole number"
        sentence = f"{path} is {noun}, which has nothing in between; write it under `sweep`"
        draft.problems.add(place, sought.SEEK, sentence)
    elif path.endswith(".exponent"):
        draft.problems.add(place, sought.SEEK, f"{path} cannot be sought, because units depend on it")
    else:
        _enter(draft, sought.SEEK, path, place, between, whole)


def _enter(draft: Draft, way: str, path: str, key: WrittenValue, values: WrittenValue, whole: Shape) -> None:
    """Note the values of one path, or what is wrong with it; `key` is the place of the path itself."""
    where = _where(way, path)
    free = [path for path, node in draft.shape.items() if not isinstance(node, Section) and node.sweep]
    parent, node = path.rpartition(".")[0], draft.shape.get(path)
    if path in draft.swept:
        sentence = f"is under '{draft.way[path]}' already; a value varies in one way only; remove one of the two"
        draft.problems.add(key, where, sentence)
    elif path in free and way == "sample" and isinstance(node, Word):
        draft.problems.add(key, where, "is a law's name, which cannot be drawn; write it under `sweep`")
    elif path in free and way == "sample" and isinstance(node, Number) and any(use.field.whole for use in node.uses):
        draft.problems.add(key, where, "is a whole number, which cannot be drawn; write it under `sweep`")
    elif path in free and way == "sample" and path.endswith(".exponent"):
        draft.problems.add(key, where, "cannot be drawn, because units depend on it; write it under `sweep`")
    elif path in free:
        draft.swept[path], draft.way[path] = values, way
    elif isinstance(node, Section):
        inside = [other for other in free if other.startswith(f"{path}.")]
        draft.problems.add(key, where, f"names a section, not a value; such as {', '.join(inside[:3])}")
    elif node is not None:
        outside = f"cannot be swept; write it outside `{way}`, and a grid for each of its values"
        draft.problems.add(key, where, outside)
    elif path in whole:
        missing = next(section for section in _sections(path) if section not in draft.shape)
        sentence = f"there is no section '{missing}'; write it before a value in it is swept"
        draft.problems.add(key, where, sentence)
    else:
        beside = [other for other in free if other.rpartition(".")[0] == parent]
        there = f" (allowed next to it: {', '.join(beside)})" if beside else ""
        draft.problems.add(key, where, f"names nothing{nearest(path, free)}{there}")


def _where(way: str, path: str) -> str:
    """Return the key under which a section says how `path` varies: 'sweep.drive.speed', 'sample.over.drive.speed'."""
    if way == sought.SEEK:
        return f"{way}.between"
    if way in (optimised.OPTIMISE, identified.IDENTIFY):
        return f"{way}.over.{path}"
    return f"sample.over.{path}" if way == "sample" else f"{way}.{path}"


def _sections(path: str) -> list[str]:
    """Return the paths that lead to `path`, outermost first, itself last."""
    parts = path.split(".")
    return [".".join(parts[: k + 1]) for k in range(len(parts))]


def values(draft: Draft, path: str, reading: Reading) -> list[Any] | None:
    """Return the values of a varied path, None where they are wrong."""
    way, written = draft.way[path], draft.swept[path]
    where = _where(way, path)
    if path in draft.added_written:
        more = axis(draft.problems, f"{draft.added_in}.{path}", draft.added_written[path], reading, distinct=False)
        draft.added[path] = more or []
    if way != "sample":
        return axis(draft.problems, where, written, reading, distinct=way in EACH)
    distribution = sampling.distribution(draft.problems, where, written, reading)
    if distribution is None or draft.sample is None:
        return None
    draft.distributions[path] = distribution
    if path not in draft.sample.drawn:
        points = draft.sample.points[:, draft.drawn.index(path)]
        return sampling.draw(draft.problems, where, written, distribution, points, reading.fields)
    before = draft.sample.drawn[path]
    drawn = axis(draft.problems, f"sample.drawn.{path}", before, reading, distinct=False)
    if drawn is not None and len(drawn) != len(draft.sample.points):
        sentence = f"found {len(drawn)} values; this sample has {len(draft.sample.points)}: leave 'drawn' out"
        draft.problems.add(before, f"sample.drawn.{path}", sentence)
        return None
    return drawn


def steps(draft: Draft) -> tuple[tuple[str, ...], ...]:
    """Return the paths that go in step, section by section."""
    together = [tuple(path for path in draft.axes if draft.way[path] == way) for way in (*WAYS[1:], sought.SEEK)]
    together[-1] = together[-1] if len(together[-1]) > 1 else ()
    return tuple(paths for paths in together if paths)


def check(draft: Draft) -> None:
    """Note axes in step that do not fit together, and values that the law names beside them do not use."""
    for paths in steps(draft):
        way, first = draft.way[paths[0]], paths[0]
        uneven = [path for path in paths if len(draft.axes[path]) != len(draft.axes[first])]
        for path in uneven:
            there = f" (line {draft.swept[first].line})" if draft.swept[first].line else ""
            sentence = (
                f"found {len(draft.axes[path])} values, but {first} has {len(draft.axes[first])}{there}; "
                "axes in step have equally many"
            )
            draft.problems.add(draft.swept[path], _where(way, path), sentence)
        if not uneven and way != "sample":
            _distinct(draft, way, paths)
    for path in draft.axes:
        _always_used(draft, path)


def _distinct(draft: Draft, way: str, paths: tuple[str, ...]) -> None:
    """Note a row of values in step that is there twice."""
    seen: dict[tuple[Any, ...], int] = {}
    for row, values in enumerate(zip(*(draft.axes[path] for path in paths), strict=True)):
        if values in seen:
            written = draft.swept[paths[0]]
            item = written.value[row] if isinstance(written.value, list) else written
            sentence = f"row {row + 1} has the values of row {seen[values] + 1}; every case may be there once"
            draft.problems.add(item, way, sentence)
        seen.setdefault(values, row)


def _always_used(draft: Draft, path: str) -> None:
    """Note a value in step that some of the varied law names do not use: which rows would count is not clear."""
    node = value_key(draft.shape, path)
    varied = [other for other in node.choosers() if other in draft.axes]
    if all(draft.way[other] in EACH for other in (path, *varied)):
        return
    for choice in product(*(sorted(draft.names[other]) for other in varied)):
        names = draft.names | {other: {name} for other, name in zip(varied, choice, strict=True)}
        if not node.used(names):
            sentence = f"is not used by {' and '.join(choice)}; in step or drawn, every law that is tried has to use it"
            draft.problems.add(draft.swept[path], _where(draft.way[path], path), sentence)
            return


def searched(draft: Draft) -> dict[str, tuple[str, ...]]:
    """Return the paths that `optimise` or `identify` vary in step, by the section."""
    found = {optimised.OPTIMISE: draft.optimise, identified.IDENTIFY: draft.identify}
    return {section: tuple(each.over) for section, each in found.items() if each}


def first_values(draft: Draft) -> dict[str, tuple[Any, ...]]:
    """Return the values that a search tries first, path by path."""
    found = {path: draft.seek.first() for path in draft.seek.paths} if draft.seek else {}
    for each in filter(None, (draft.optimise, draft.identify)):
        found |= dict(zip(each.over, zip(*each.first(), strict=True), strict=True))
    return found
