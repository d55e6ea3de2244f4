"""Finds which values a grid varies and how: each by each (`sweep`), in step (`zip`, `cases`), by chance (`sample`)."""

from collections.abc import Callable
from itertools import product

from .. import quantity
from ..errors import InputError, nearest, shown
from . import case_table, sampling
from .axes import axis
from .document import Entry
from .draft import Draft
from .keys import Number, Section, Shape, Word

#: The sections that vary values, in the order in which their axes stand; those after `sweep` go in step.
WAYS = ("sweep", "zip", "cases", "sample")


def find(read: Draft, root: Entry, whole: Shape, fixed: frozenset) -> None:
    """Note the entries whose path names something that can be varied; paths in `fixed` are not varied any more."""
    for way in WAYS:
        section = root.value.get(way) if isinstance(root.value, dict) else None
        if section is None:
            continue
        entry, where, example = section, way, "[value, ...]"
        if way == "cases" and isinstance(section.value, str):
            entry = case_table.read(read.problems, section)
            if entry is None:
                continue
        if way == "sample":
            if not isinstance(section.value, dict):
                sentence = f"found {shown(section.value)}; expected a section with the keys method, n, seed, over"
                read.problems.add(section, way, sentence)
                continue
            entry, where = section.value.get("over", section), "sample.over"
            example = "{normal: {mean: 1 mm, cv: 0.1}}"
            if "over" not in section.value:
                read.problems.add(section, where, f"is missing; write `dotted.path: {example}`")
                continue
        if not isinstance(entry.value, dict) or not entry.value:
            nothing = {"sweep": "nothing is swept", "sample": "nothing is drawn"}.get(way, "nothing goes in step")
            rest = f"write `dotted.path: {example}`, or leave the key '{way}' out"
            read.problems.add(entry, where, f"{nothing}; {rest}")
            continue
        for path, one in entry.value.items():
            if path not in fixed:
                _enter(read, way, f"{where}.{path}", path, entry.keys.get(path, one), one, whole)
        if way == "sample":
            drawn = [path for path in read.swept if read.way[path] == "sample"]
            read.drawn = tuple(drawn)
            read.sample = sampling.read(read.problems, section, len(drawn)) if drawn else None


def _enter(read: Draft, way: str, where: str, path: str, key: Entry, entry: Entry, whole: Shape) -> None:
    """Note one path, or what is wrong with it."""
    free = [path for path, node in read.shape.items() if not isinstance(node, Section) and node.sweep]
    parent, node = path.rpartition(".")[0], read.shape.get(path)
    if path in read.swept:
        sentence = f"is under '{read.way[path]}' already; a value varies in one way: leave one of them out"
        read.problems.add(key, where, sentence)
    elif path in free and way == "sample" and isinstance(node, Word):
        read.problems.add(key, where, "is a law's name, which cannot be drawn; write it under `sweep`")
    elif path in free and way == "sample" and any(use.field.whole for use in node.uses):
        read.problems.add(key, where, "is a whole number, which cannot be drawn; write it under `sweep`")
    elif path in free and way == "sample" and path.endswith(".exponent"):
        read.problems.add(key, where, "cannot be drawn, because units depend on it; write it under `sweep`")
    elif path in free:
        read.swept[path], read.way[path] = entry, way
    elif isinstance(node, Section):
        inside = [other for other in free if other.startswith(f"{path}.")]
        read.problems.add(key, where, f"names a section, not a value; such as {', '.join(inside[:3])}")
    elif node is not None:
        outside = f"cannot be swept; write it outside `{way}`, and a grid for each of its values"
        read.problems.add(key, where, outside)
    elif path in whole:
        missing = next(section for section in _sections(path) if section not in read.shape)
        sentence = f"there is no section '{missing}'; write it before a value in it is swept"
        read.problems.add(key, where, sentence)
    else:
        beside = [other for other in free if other.rpartition(".")[0] == parent]
        there = f" (allowed beside it: {', '.join(beside)})" if beside else ""
        read.problems.add(key, where, f"names nothing{nearest(path, free)}{there}")


def _sections(path: str) -> list[str]:
    """Return the paths that lead to `path`, outermost first, itself last."""
    parts = path.split(".")
    return [".".join(parts[: k + 1]) for k in range(len(parts))]


def values(read: Draft, path: str, one: Callable, unit: str, fields: tuple) -> list | None:
    """Return the values of a varied path, each read by `one(entry)`, None where they are wrong.

    `unit` is the SI unit, '' for words; `fields` are the meanings whose ranges drawn values have to stay in.
    """
    way, entry = read.way[path], read.swept[path]
    if way != "sample":
        return axis(read.problems, f"{way}.{path}", entry, one, unit, distinct=way == "sweep")
    where = f"sample.over.{path}"
    found = sampling.distribution(read.problems, where, entry, one, unit)
    if found is None or read.sample is None:
        return None
    read.distributions[path] = found
    if path not in read.sample.drawn:
        points = read.sample.points[:, read.drawn.index(path)]
        return sampling.draw(read.problems, where, entry, found, points, fields)
    before = read.sample.drawn[path]
    drawn = axis(read.problems, f"sample.drawn.{path}", before, one, unit, distinct=False)
    if drawn is not None and len(drawn) != len(read.sample.points):
        sentence = f"found {len(drawn)} values; this sample has {len(read.sample.points)}: leave 'drawn' out"
        read.problems.add(before, f"sample.drawn.{path}", sentence)
        return None
    return drawn


def steps(read: Draft) -> tuple[tuple[str, ...], ...]:
    """Return the paths that go in step, section by section."""
    together = (tuple(path for path in read.axes if read.way[path] == way) for way in WAYS[1:])
    return tuple(paths for paths in together if paths)


def check(read: Draft) -> None:
    """Note axes in step that do not fit together, and values that the law names beside them do not use."""
    for paths in steps(read):
        way, first = read.way[paths[0]], paths[0]
        uneven = [path for path in paths if len(read.axes[path]) != len(read.axes[first])]
        for path in uneven:
            there = f" (line {read.swept[first].line})" if read.swept[first].line else ""
            sentence = (
                f"found {len(read.axes[path])} values, but {first} has {len(read.axes[first])}{there}; "
                "axes in step have equally many"
            )
            read.problems.add(read.swept[path], f"{way}.{path}", sentence)
        if not uneven and way != "sample":
            _distinct(read, way, paths)
    for path in read.axes:
        _always_used(read, path)


def _distinct(read: Draft, way: str, paths: tuple[str, ...]) -> None:
    """Note a row of values in step that is there twice."""
    seen: dict = {}
    for row, values in enumerate(zip(*(read.axes[path] for path in paths), strict=True)):
        if values in seen:
            entry = read.swept[paths[0]]
            item = entry.value[row] if isinstance(entry.value, list) else entry
            sentence = f"row {row + 1} has the values of row {seen[values] + 1}; every case may be there once"
            read.problems.add(item, way, sentence)
        seen.setdefault(values, row)


def _always_used(read: Draft, path: str) -> None:
    """Note a value in step that some of the varied law names do not use: which rows would count is not clear."""
    node = read.shape[path]
    varied = [other for other in node.choosers() if other in read.axes]
    if all(read.way[other] == "sweep" for other in (path, *varied)):
        return
    for choice in product(*(sorted(read.names[other]) for other in varied)):
        names = read.names | {other: {name} for other, name in zip(varied, choice, strict=True)}
        used = node.fields(names) if isinstance(node, Number) else node.used(names)
        if not used:
            sentence = f"is not used by {' and '.join(choice)}; in step or drawn, every law that is tried has to use it"
            where = "sample.over" if read.way[path] == "sample" else read.way[path]
            read.problems.add(read.swept[path], f"{where}.{path}", sentence)
            return


def limits(read: Draft, root: Entry) -> dict[str, float]:
    """Return the figures that `limits` bounds, in SI, from above."""
    section = root.value.get("limits") if isinstance(root.value, dict) else None
    if section is None:
        return {}
    if not isinstance(section.value, dict) or not section.value:
        sentence = "holds no limit; write such as `rod_slider_force_peak: 5 kN`, or leave the key 'limits' out"
        read.problems.add(section, "limits", sentence)
        return {}
    units, found = read.figures, {}
    for figure, entry in section.value.items():
        if figure not in units:
            sentence = f"is no figure of this grid{nearest(figure, units)} (known: {', '.join(units)})"
            read.problems.add(section.keys.get(figure, entry), f"limits.{figure}", sentence)
            continue
        try:
            found[figure] = quantity.read(entry.value, units[figure])
        except InputError as error:
            read.problems.add(entry, f"limits.{figure}", str(error))
    return found
