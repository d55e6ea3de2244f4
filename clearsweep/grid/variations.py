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


def find(reader: Reader, root: WrittenValue, complete: Shape, fixed: frozenset[str]) -> None:
    """Record the varied values; report paths that cannot vary.  Paths in `fixed` no longer vary."""
    for variation in WAYS:
        section = root.value.get(variation) if isinstance(root.value, dict) else None
        if section is None:
            continue
        written, where, example = section, variation, "[value, ...]"
        if variation == "cases" and isinstance(section.value, str):
            written = case_table.read(reader.problems, section)
            if written is None:
                continue
        if variation == "sample":
            if not isinstance(section.value, dict):
                sentence = f"found {shown(section.value)}; expected a section with the keys method, n, seed, over"
                reader.problems.add(section, variation, sentence)
                continue
            written, where = section.value.get("over", section), "sample.over"
            example = "{normal: {mean: 1 mm, cv: 0.1}}"
            if "over" not in section.value:
                reader.problems.add(section, where, f"is missing; write `dotted.path: {example}`")
                continue
        if not isinstance(written.value, dict) or not written.value:
            reason = {"sweep": "nothing is swept", "sample": "nothing is drawn"}.get(variation, "nothing goes in step")
            remedy = f"write `dotted.path: {example}`, or leave the key '{variation}' out"
            reader.problems.add(written, where, f"{reason}; {remedy}")
            continue
        for path, values in written.value.items():
            if path not in fixed:
                _enter(reader, variation, path, written.key_place(path), values, complete)
        if variation == "sample":
            drawn_paths = [path for path in reader.swept if reader.way[path] == "sample"]
            reader.drawn = tuple(drawn_paths)
            reader.sample = sampling.read(reader.problems, section, len(drawn_paths)) if drawn_paths else None


def find_optimised(reader: Reader, root: WrittenValue, complete: Shape) -> None:
    """Record the values that `optimise` and `identify` may choose."""
    for path, (location, values) in optimised.find(reader, root).items():
        _enter(reader, optimised.OPTIMISE, path, location, values, complete)
    for path, (location, values) in identified.find(reader, root).items():
        _enter(reader, identified.IDENTIFY, path, location, values, complete)


def find_seek(
    reader: Reader, root: WrittenValue, complete: Shape, values_of: Callable[[str], tuple[float, ...]]
) -> None:
    """Record the range of a search, as an axis of its two ends or of all values to try."""
    between = seek.range_of(reader, root, values_of)
    for location in between[0] if between else ():
        assert between is not None  # there is at least one path
        _enter_seek(reader, location.value, location, between[1], complete)


def _enter_seek(reader: Reader, path: str, location: WrittenValue, between: WrittenValue, complete: Shape) -> None:
    """Record the values of one path of a search."""
    node = complete.get(path)
    if isinstance(node, Word) or (isinstance(node, Number) and any(key_use.field.whole for key_use in node.uses)):
        noun = "a name" if isinstance(node, Word) else "a whole number"
        sentence = f"{path} is {noun}, which has nothing in between; write it under `sweep`"
        reader.problems.add(location, seek.SEEK, sentence)
    elif path.endswith(".exponent"):
        reader.problems.add(location, seek.SEEK, f"{path} cannot be searched for, because units depend on it")
    else:
        _enter(reader, seek.SEEK, path, location, between, complete)


def _enter(reader: Reader, variation: str, path: str, key: WrittenValue, values: WrittenValue, complete: Shape) -> None:
    """Record the values of one path, or report a mistake; `key` is the position of the path itself."""
    path = varied_materials.path_of(path, reader.shape)
    where = _where(variation, path)
    free_paths = [path for path, node in reader.shape.items() if not isinstance(node, Section) and node.sweep]
    parent, node = path.rpartition(".")[0], reader.shape.get(path)
    if path in reader.swept:
        sentence = f"is under '{reader.way[path]}' already; a value varies in one way only; remove one of the two"
        reader.problems.add(key, where, sentence)
    elif path in free_paths and variation == "sample" and isinstance(node, Word):
        reader.problems.add(key, where, "is a law's name, which cannot be drawn; write it under `sweep`")
    elif (
        path in free_paths
        and variation == "sample"
        and isinstance(node, Number)
        and any(key_use.field.whole for key_use in node.uses)
    ):
        reader.problems.add(key, where, "is a whole number, which cannot be drawn; write it under `sweep`")
    elif path in free_paths and variation == "sample" and path.endswith(".exponent"):
        reader.problems.add(key, where, "cannot be drawn, because units depend on it; write it under `sweep`")
    elif path in free_paths:
        reader.swept[path], reader.way[path] = values, variation
    elif isinstance(node, Section):
        inside = [other_path for other_path in free_paths if other_path.startswith(f"{path}.")]
        is_named = isinstance(complete.get(f"{path}.name"), Name) and path.rpartition(".")[2] in (*BODIES, "material")
        remedy = "; a material varies by name where the grid names one: `bearing: CuSn8`" if is_named else ""
        reader.problems.add(key, where, f"names a section, not a value; such as {', '.join(inside[:3])}{remedy}")
    elif node is not None:
        remedy_text = f"cannot be swept; write it outside `{variation}`, and a grid for each of its values"
        reader.problems.add(key, where, remedy_text)
    elif path in complete:
        missing = next(section for section in _sections(path) if section not in reader.shape)
        sentence = f"there is no section '{missing}'; write it before a value in it is swept"
        reader.problems.add(key, where, sentence)
    elif path.startswith(START):
        name, allowed = path.removeprefix(START), [*reader.defined.texts]
        if name not in reader.defined.wrong:  # what is wrong there is said there
            hint = f"{nearest(name, allowed)} (known: {', '.join(allowed) or 'none'})"
            reader.problems.add(key, where, f"'{name}' is not defined under `define`{hint}")
    else:
        siblings = [other_path for other_path in free_paths if other_path.rpartition(".")[0] == parent]
        hint = f" (allowed next to it: {', '.join(siblings)})" if siblings else ""
        reader.problems.add(key, where, f"names nothing{nearest(path, free_paths)}{hint}")


def _where(variation: str, path: str) -> str:
    """Return the full key of a varied path: 'sweep.drive.speed', 'sample.over.drive.speed'."""
    if variation == seek.SEEK:
        return f"{variation}.between"
    if variation in (optimised.OPTIMISE, identified.IDENTIFY):
        return f"{variation}.over.{path}"
    return f"sample.over.{path}" if variation == "sample" else f"{variation}.{path}"


def _sections(path: str) -> list[str]:
    """Return the paths that lead to `path`, outermost first, itself last."""
    parts = path.split(".")
    return [".".join(parts[: k + 1]) for k in range(len(parts))]


def values(reader: Reader, path: str, reading: Reading) -> list[Any] | None:
    """Return the values of a varied path, or None if they are invalid."""
    variation, written = reader.way[path], reader.swept[path]
    where = _where(variation, path)
    if path in reader.added_written:
        added_values = axis(
            reader.problems, f"{reader.added_in}.{path}", reader.added_written[path], reading, distinct=False
        )
        reader.added_cases[path] = added_values or []
    if variation != "sample":
        return axis(reader.problems, where, written, reading, distinct=variation in EACH)
    distribution = sampling.distribution(reader.problems, where, written, reading)
    if distribution is None or reader.sample is None:
        return None
    reader.distributions[path] = distribution
    if path not in reader.sample.drawn:
        points = reader.sample.points[:, reader.drawn.index(path)]
        return sampling.draw(reader.problems, where, written, distribution, points, reading.fields)
    drawn_before = reader.sample.drawn[path]
    drawn_paths = axis(reader.problems, f"sample.drawn.{path}", drawn_before, reading, distinct=False)
    if drawn_paths is not None and len(drawn_paths) != len(reader.sample.points):
        sentence = f"found {len(drawn_paths)} values; this sample has {len(reader.sample.points)}: leave 'drawn' out"
        reader.problems.add(drawn_before, f"sample.drawn.{path}", sentence)
        return None
    return drawn_paths


def steps(reader: Reader) -> tuple[tuple[str, ...], ...]:
    """Return the paths that vary in step, by section."""
    joint_groups = [
        tuple(path for path in reader.axes if reader.way[path] == variation) for variation in (*WAYS[1:], seek.SEEK)
    ]
    joint_groups[-1] = joint_groups[-1] if len(joint_groups[-1]) > 1 else ()
    return tuple(paths for paths in joint_groups if paths)


def check(reader: Reader) -> None:
    """Report axes in step of different length, and values that varied law names do not use."""
    for paths in steps(reader):
        variation, first_path = reader.way[paths[0]], paths[0]
        uneven = [path for path in paths if len(reader.axes[path]) != len(reader.axes[first_path])]
        for path in uneven:
            hint = f" (line {reader.swept[first_path].line})" if reader.swept[first_path].line else ""
            sentence = (
                f"found {len(reader.axes[path])} values, but {first_path} has {len(reader.axes[first_path])}{hint}; "
                "axes in step have equally many"
            )
            reader.problems.add(reader.swept[path], _where(variation, path), sentence)
        if not uneven and variation != "sample":
            _distinct(reader, variation, paths)
    for path in reader.axes:
        _always_used(reader, path)


def _distinct(reader: Reader, variation: str, paths: tuple[str, ...]) -> None:
    """Report repeated rows of values in step."""
    lines_seen: dict[tuple[Any, ...], int] = {}
    for row, values in enumerate(zip(*(reader.axes[path] for path in paths), strict=True)):
        if values in lines_seen:
            written = reader.swept[paths[0]]
            item = written.value[row] if isinstance(written.value, list) else written
            sentence = f"row {row + 1} has the values of row {lines_seen[values] + 1}; every case may be there once"
            reader.problems.add(item, variation, sentence)
        lines_seen.setdefault(values, row)


def _always_used(reader: Reader, path: str) -> None:
    """Report a value in step that some varied law names do not use: it is unclear which rows would count."""
    node = value_key(reader.shape, path)
    varied_choosers = [other_path for other_path in node.choosers() if other_path in reader.axes]
    if all(reader.way[other_path] in EACH for other_path in (path, *varied_choosers)):
        return
    for choice in product(*(sorted(reader.names[other_path]) for other_path in varied_choosers)):
        names = reader.names | {other_path: {name} for other_path, name in zip(varied_choosers, choice, strict=True)}
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
    for item in filter(None, (reader.optimise, reader.identify)):
        firsts |= dict(zip(item.over, zip(*item.first(), strict=True), strict=True))
    return firsts
