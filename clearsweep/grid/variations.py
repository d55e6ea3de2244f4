"""Finds which values a grid varies and how: combined (`sweep`), in step (`zip`, `cases`) or drawn (`sample`)."""

from collections.abc import Callable
from itertools import product
from typing import Any

from ..language.errors import nearest, shown
from . import case_table, identified, optimised, sampling, seek, varied_materials
from .axes import Reading, axis
from .defined import START
from .document import WrittenValue
from .keys import Name, Number, Section, Shape, Word, value_key
from .naming import BODIES
from .reader import Reader

#: The sections that vary values, in the order in which their axes appear; those after `sweep` go in step.
WAYS = ("sweep", "zip", "cases", "sample")
#: The sections with values that may be unused by some of the varied laws.
EACH = ("sweep", seek.SEEK, optimised.OPTIMISE, identified.IDENTIFY)


def find(reader: Reader, root: WrittenValue, whole: Shape, fixed: frozenset[str]) -> None:
    """Record the varied values; report paths that cannot vary.  Paths in `fixed` no longer vary."""
    for way in WAYS:
        section = root.value.get(way) if isinstance(root.value, dict) else None
        if section is None:
            continue
        written, where, example = section, way, "[value, ...]"
        if way == "cases" and isinstance(section.value, str):
            written = case_table.read(reader.problems, section)
            if written is None:
                continue
        if way == "sample":
            if not isinstance(section.value, dict):
                sentence = f"found {shown(section.value)}; expected a section with the keys method, n, seed, over"
                reader.problems.add(section, way, sentence)
                continue
            written, where = section.value.get("over", section), "sample.over"
            example = "{normal: {mean: 1 mm, cv: 0.1}}"
            if "over" not in section.value:
                reader.problems.add(section, where, f"is missing; write `dotted.path: {example}`")
                continue
        if not isinstance(written.value, dict) or not written.value:
            nothing = {"sweep": "nothing is swept", "sample": "nothing is drawn"}.get(way, "nothing goes in step")
            rest = f"write `dotted.path: {example}`, or leave the key '{way}' out"
            reader.problems.add(written, where, f"{nothing}; {rest}")
            continue
        for path, values in written.value.items():
            if path not in fixed:
                _enter(reader, way, path, written.key_place(path), values, whole)
        if way == "sample":
            drawn = [path for path in reader.swept if reader.way[path] == "sample"]
            reader.drawn = tuple(drawn)
            reader.sample = sampling.read(reader.problems, section, len(drawn)) if drawn else None


def find_optimised(reader: Reader, root: WrittenValue, whole: Shape) -> None:
    """Record the values that `optimise` and `identify` may choose."""
    for path, (place, values) in optimised.find(reader, root).items():
        _enter(reader, optimised.OPTIMISE, path, place, values, whole)
    for path, (place, values) in identified.find(reader, root).items():
        _enter(reader, identified.IDENTIFY, path, place, values, whole)


def find_seek(reader: Reader, root: WrittenValue, whole: Shape, values_of: Callable[[str], tuple[float, ...]]) -> None:
    """Record the range of a search, as an axis of its two ends or of all values to try."""
    between = seek.range_of(reader, root, values_of)
    for place in between[0] if between else ():
        assert between is not None  # there is at least one path
        _enter_seek(reader, place.value, place, between[1], whole)


def _enter_seek(reader: Reader, path: str, place: WrittenValue, between: WrittenValue, whole: Shape) -> None:
    """Record the values of one path of a search."""
    node = whole.get(path)
    if isinstance(node, Word) or (isinstance(node, Number) and any(use.field.whole for use in node.uses)):
        noun = "a name" if isinstance(node, Word) else "a whole number"
        sentence = f"{path} is {noun}, which has nothing in between; write it under `sweep`"
        reader.problems.add(place, seek.SEEK, sentence)
    elif path.endswith(".exponent"):
        reader.problems.add(place, seek.SEEK, f"{path} cannot be searched for, because units depend on it")
    else:
        _enter(reader, seek.SEEK, path, place, between, whole)


def _enter(reader: Reader, way: str, path: str, key: WrittenValue, values: WrittenValue, whole: Shape) -> None:
    """Record the values of one path, or report a mistake; `key` is the position of the path itself."""
    path = varied_materials.path_of(path, reader.shape)
    where = _where(way, path)
    free = [path for path, node in reader.shape.items() if not isinstance(node, Section) and node.sweep]
    parent, node = path.rpartition(".")[0], reader.shape.get(path)
    if path in reader.swept:
        sentence = f"is under '{reader.way[path]}' already; a value varies in one way only; remove one of the two"
        reader.problems.add(key, where, sentence)
    elif path in free and way == "sample" and isinstance(node, Word):
        reader.problems.add(key, where, "is a law's name, which cannot be drawn; write it under `sweep`")
    elif path in free and way == "sample" and isinstance(node, Number) and any(use.field.whole for use in node.uses):
        reader.problems.add(key, where, "is a whole number, which cannot be drawn; write it under `sweep`")
    elif path in free and way == "sample" and path.endswith(".exponent"):
        reader.problems.add(key, where, "cannot be drawn, because units depend on it; write it under `sweep`")
    elif path in free:
        reader.swept[path], reader.way[path] = values, way
    elif isinstance(node, Section):
        inside = [other for other in free if other.startswith(f"{path}.")]
        named = isinstance(whole.get(f"{path}.name"), Name) and path.rpartition(".")[2] in (*BODIES, "material")
        remedy = "; a material varies by name where the grid names one: `bearing: CuSn8`" if named else ""
        reader.problems.add(key, where, f"names a section, not a value; such as {', '.join(inside[:3])}{remedy}")
    elif node is not None:
        outside = f"cannot be swept; write it outside `{way}`, and a grid for each of its values"
        reader.problems.add(key, where, outside)
    elif path in whole:
        missing = next(section for section in _sections(path) if section not in reader.shape)
        sentence = f"there is no section '{missing}'; write it before a value in it is swept"
        reader.problems.add(key, where, sentence)
    elif path.startswith(START):
        name, known = path.removeprefix(START), [*reader.defined.texts]
        if name not in reader.defined.wrong:  # what is wrong there is said there
            there = f"{nearest(name, known)} (known: {', '.join(known) or 'none'})"
            reader.problems.add(key, where, f"'{name}' is not defined under `define`{there}")
    else:
        siblings = [other for other in free if other.rpartition(".")[0] == parent]
        there = f" (allowed next to it: {', '.join(siblings)})" if siblings else ""
        reader.problems.add(key, where, f"names nothing{nearest(path, free)}{there}")


def _where(way: str, path: str) -> str:
    """Return the full key of a varied path: 'sweep.drive.speed', 'sample.over.drive.speed'."""
    if way == seek.SEEK:
        return f"{way}.between"
    if way in (optimised.OPTIMISE, identified.IDENTIFY):
        return f"{way}.over.{path}"
    return f"sample.over.{path}" if way == "sample" else f"{way}.{path}"


def _sections(path: str) -> list[str]:
    """Return the paths that lead to `path`, outermost first, itself last."""
    parts = path.split(".")
    return [".".join(parts[: k + 1]) for k in range(len(parts))]


def values(reader: Reader, path: str, reading: Reading) -> list[Any] | None:
    """Return the values of a varied path, or None if they are invalid."""
    way, written = reader.way[path], reader.swept[path]
    where = _where(way, path)
    if path in reader.added_written:
        more = axis(reader.problems, f"{reader.added_in}.{path}", reader.added_written[path], reading, distinct=False)
        reader.added_cases[path] = more or []
    if way != "sample":
        return axis(reader.problems, where, written, reading, distinct=way in EACH)
    distribution = sampling.distribution(reader.problems, where, written, reading)
    if distribution is None or reader.sample is None:
        return None
    reader.distributions[path] = distribution
    if path not in reader.sample.drawn:
        points = reader.sample.points[:, reader.drawn.index(path)]
        return sampling.draw(reader.problems, where, written, distribution, points, reading.fields)
    before = reader.sample.drawn[path]
    drawn = axis(reader.problems, f"sample.drawn.{path}", before, reading, distinct=False)
    if drawn is not None and len(drawn) != len(reader.sample.points):
        sentence = f"found {len(drawn)} values; this sample has {len(reader.sample.points)}: leave 'drawn' out"
        reader.problems.add(before, f"sample.drawn.{path}", sentence)
        return None
    return drawn


def steps(reader: Reader) -> tuple[tuple[str, ...], ...]:
    """Return the paths that vary in step, by section."""
    together = [tuple(path for path in reader.axes if reader.way[path] == way) for way in (*WAYS[1:], seek.SEEK)]
    together[-1] = together[-1] if len(together[-1]) > 1 else ()
    return tuple(paths for paths in together if paths)


def check(reader: Reader) -> None:
    """Report axes in step of different length, and values that varied law names do not use."""
    for paths in steps(reader):
        way, first = reader.way[paths[0]], paths[0]
        uneven = [path for path in paths if len(reader.axes[path]) != len(reader.axes[first])]
        for path in uneven:
            there = f" (line {reader.swept[first].line})" if reader.swept[first].line else ""
            sentence = (
                f"found {len(reader.axes[path])} values, but {first} has {len(reader.axes[first])}{there}; "
                "axes in step have equally many"
            )
            reader.problems.add(reader.swept[path], _where(way, path), sentence)
        if not uneven and way != "sample":
            _distinct(reader, way, paths)
    for path in reader.axes:
        _always_used(reader, path)


def _distinct(reader: Reader, way: str, paths: tuple[str, ...]) -> None:
    """Report repeated rows of values in step."""
    seen: dict[tuple[Any, ...], int] = {}
    for row, values in enumerate(zip(*(reader.axes[path] for path in paths), strict=True)):
        if values in seen:
            written = reader.swept[paths[0]]
            item = written.value[row] if isinstance(written.value, list) else written
            sentence = f"row {row + 1} has the values of row {seen[values] + 1}; every case may be there once"
            reader.problems.add(item, way, sentence)
        seen.setdefault(values, row)


def _always_used(reader: Reader, path: str) -> None:
    """Report a value in step that some varied law names do not use: it is unclear which rows would count."""
    node = value_key(reader.shape, path)
    varied = [other for other in node.choosers() if other in reader.axes]
    if all(reader.way[other] in EACH for other in (path, *varied)):
        return
    for choice in product(*(sorted(reader.names[other]) for other in varied)):
        names = reader.names | {other: {name} for other, name in zip(varied, choice, strict=True)}
        if not node.used(names):
            sentence = f"is not used by {' and '.join(choice)}; in step or drawn, every law that is tried has to use it"
            reader.problems.add(reader.swept[path], _where(reader.way[path], path), sentence)
            return


def searched(reader: Reader) -> dict[str, tuple[str, ...]]:
    """Return the paths that `optimise` or `identify` vary in step, by section."""
    searches = {optimised.OPTIMISE: reader.optimise, identified.IDENTIFY: reader.identify}
    return {section: tuple(search.over) for section, search in searches.items() if search}


def first_values(reader: Reader) -> dict[str, tuple[Any, ...]]:
    """Return the values that a search tries first, path by path."""
    firsts = {path: reader.seek.first() for path in reader.seek.paths} if reader.seek else {}
    for each in filter(None, (reader.optimise, reader.identify)):
        firsts |= dict(zip(each.over, zip(*each.first(), strict=True), strict=True))
    return firsts
