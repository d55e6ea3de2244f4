"""Reads what a grid varies: combined, together or drawn, and coexisting motions; labels of values."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import product
from typing import Any

from ...contracts.catalogue import CHOICE, ranged
from ...language import quantity
from ...language.errors import InputError, did_you_mean, mistake_of, quoted
from ..keys import KeyTable, Name, Number, Section, Use, Word, deciding_paths, value_key, word_key
from ..keys.library_names import BODIES, name_path, text_of_name
from ..keys.run_keys import BRANCHES, CARRIED, DIRECTION, DRAW, LIFE, START
from ..written import AXIS_SECTIONS, MistakeError, Problems, WrittenValue
from ..written.definitions import DEFINE, DEFINE_PREFIX, DEFINE_TEXT, Definitions
from ..written.tables import is_table, read_cases
from . import Reader, ValueReader
from .axes import DISTRIBUTIONS, SAMPLE_SECTION, SPACING_FORMS, draw_values, read_axis, read_distribution, read_sample

# ----------------------------------------------------------------------------------------------------------------------
# Reads what a grid varies: combined (`sweep`), together (`zip`, `cases`) or drawn (`sample`); labels of values.


MAX_SAME_KEYS = 2  # paths that an error names
#: The sections that vary values, in the order in which their axes appear; those after `sweep` vary together.
VARYING_SECTIONS = (*AXIS_SECTIONS, "sample")


def record_variations(reader: Reader, root: WrittenValue, all_keys: KeyTable, fixed_paths: frozenset[str]) -> None:
    """Record the varied values; report paths that cannot vary.  Paths in `fixed_paths` no longer vary."""
    for section_name in VARYING_SECTIONS:
        with reader.problems.reporting():
            if section_name in root.value:
                _record_section(reader, root, section_name, all_keys, fixed_paths)


def _record_section(
    reader: Reader, root: WrittenValue, section_name: str, all_keys: KeyTable, fixed_paths: frozenset[str]
) -> None:
    """Record the values that one section varies; MistakeError if it cannot be read."""
    section = root.value[section_name]
    written, key_path, example = section, section_name, "[value, ...]"
    if section_name == "cases" and is_table(section):
        written, reader.case_labels = read_cases(reader.problems, section)
    if section_name == "sample":
        if SAMPLE_SECTION.find(reader.problems, root) is None:
            return
        written, key_path = section.value.get("over", section), "sample.over"
        example = "{normal: {mean: 1 mm, cv: 0.1}}"
        if "over" not in section.value:
            raise MistakeError(section, key_path, f"is missing; write `dotted.path: {example}`")
    if not written.entries:
        reasons = {"sweep": "nothing is swept", "sample": "nothing is drawn"}
        remedy = f"write `dotted.path: {example}`, or leave the key '{section_name}' out"
        reason = reasons.get(section_name, "no values vary together")
        reason = "is a list; each path takes its own" if isinstance(written.value, list) else reason
        raise MistakeError(written, key_path, f"{reason}; {remedy}")
    varied = {path: values for path, values in written.value.items() if path not in fixed_paths}
    reader.written_columns[section_name] = len(varied)
    for path, values in varied.items():
        record_axis(reader, section_name, path, written.key_position(path), values, all_keys)
    if section_name == "sample":
        drawn_paths = [path for path in reader.written_axes if reader.varied_by[path] == "sample"]
        reader.drawn_paths = tuple(drawn_paths)
        reader.sample = read_sample(reader.problems, section, len(drawn_paths)) if drawn_paths else None


def record_axis(
    reader: Reader, section_name: str, path: str, position: WrittenValue, values: WrittenValue, all_keys: KeyTable
) -> None:
    """Record the values of one path, or report a mistake; `position` is where the path itself is written."""
    path = name_path(path, reader.keys_in_use)
    key_path = _axis_key_path(reader, section_name, path)
    sweepable_paths = [path for path, key in reader.keys_in_use.items() if not isinstance(key, Section) and key.sweep]
    parent, key = path.rpartition(".")[0], reader.keys_in_use.get(path)
    if path in reader.written_axes:
        message = f"is under '{reader.varied_by[path]}' already; a value varies in one way only; remove one of the two"
    elif path in sweepable_paths and section_name == "sample" and (reason := _reason_not_to_draw(path, key)):
        message = f"{reason}; write it under `sweep`"
    elif path in sweepable_paths:
        if path in reader.varied_names and isinstance(values.value, list):
            values = replace(values, value=[text_of_name(item) for item in values.value])
        reader.written_axes[path], reader.varied_by[path] = values, section_name
        return
    elif isinstance(key, Section):
        paths_inside = [other_path for other_path in sweepable_paths if other_path.startswith(f"{path}.")]
        is_named = isinstance(all_keys.get(f"{path}.name"), Name) and path.rpartition(".")[2] in (*BODIES, "material")
        remedy = "; to vary a material, write its name in the grid, such as `bearing: CuSn8`" if is_named else ""
        message = f"is a section, not a value; write a key in it, such as {', '.join(paths_inside[:3])}{remedy}"
    elif key is not None:
        message = f"cannot be swept; write it outside `{section_name}`, and a grid for each of its values"
    elif isinstance(all_keys.get(path), Name):
        message = f"a name of the library varies, but it is not written outside `{section_name}`; write one there too"
    elif path in all_keys:
        missing = next(section for section in _enclosing_paths(path) if section not in reader.keys_in_use)
        message = f"there is no section '{missing}'; write it before a value in it is swept"
    elif path.startswith(DEFINE_PREFIX):
        name, allowed = path.removeprefix(DEFINE_PREFIX), [*reader.defined.expression_by_name]
        if name in reader.defined.invalid:  # a mistake in the definition is reported elsewhere
            return
        hint_text = f"{did_you_mean(name, allowed)} (known: {', '.join(allowed) or 'none'})"
        message = f"'{name}' is not defined under `define`{hint_text}"
    else:
        siblings = [other_path for other_path in sweepable_paths if other_path.rpartition(".")[0] == parent]
        hint_text = f" (allowed next to it: {', '.join(siblings)})" if siblings else ""
        suggestion = did_you_mean(path, sweepable_paths) or _same_key_text(reader, path, all_keys)
        remedy = ""
        if section_name == "cases" and "." not in path:
            remedy = (
                "; headers are paths such as joints.rod-slider.clearance [um]. Give this header a path with "
                f"{{table: FILE, columns: {{{path}: PATH}}}}, or name texts of the rows with `label: {path}`"
            )
        message = f"is no key of this grid{suggestion}{hint_text}{remedy}"
    reader.problems.add(position, key_path, message)


def _reason_not_to_draw(path: str, key: Any) -> str:
    """Return why a value that may be swept cannot be drawn, or ''."""
    if isinstance(key, Word):
        return "is a law's name, which cannot be drawn"
    if any(key_use.field.integer for key_use in key.uses):
        return "is a whole number, which cannot be drawn"
    return "cannot be drawn, because units of other keys depend on it" if path.endswith(".exponent") else ""


def _axis_key_path(reader: Reader, section_name: str, path: str) -> str:
    """Return the full key of a varied path: 'sweep.drive.speed', 'sample.over.drive.speed'."""
    if search := reader.searches.get(section_name):
        return search.axis_path(path)
    return f"sample.over.{path}" if section_name == "sample" else f"{section_name}.{path}"


def _same_key_text(reader: Reader, name: str, keys: KeyTable) -> str:
    """Return the paths in sections in use that end in a key of this name, with their laws; '' without any."""
    texts = []
    for path, key in keys.items():
        is_present = all(section in reader.keys_in_use for section in _enclosing_paths(path))
        if not path.endswith(f".{name}") or not isinstance(key, Number) or not is_present:
            continue
        laws = sorted({law for key_use in key.uses for _, names in key_use.when[-1:] for law in names})
        texts.append(f"{path} (law {', '.join(laws)})" if laws else path)
    return f"; write the whole path, such as {' or '.join(texts[:MAX_SAME_KEYS])}" if texts else ""


def _enclosing_paths(path: str) -> list[str]:
    """Return the paths that lead to `path`, outermost first, itself last."""
    keys = path.split(".")
    return [".".join(keys[: k + 1]) for k in range(len(keys))]


def values_of_axis(reader: Reader, path: str, reading: ValueReader) -> list[Any]:
    """Return the values of a varied path; MistakeError if they are invalid."""
    section_name, written = reader.varied_by[path], reader.written_axes[path]
    key_path = _axis_key_path(reader, section_name, path)
    if path in reader.added_written:
        with reader.problems.reporting():
            added_path, added = f"{reader.added_path}.{path}", reader.added_written[path]
            reader.added_cases[path] = read_axis(reader.problems, added_path, added, reading, distinct=False)
    if section_name == "cases" and (mistake := _unit_mistake(written, reading.unit)):
        raise MistakeError(WrittenValue(None, written.origin, written.line, written.column), key_path, mistake)
    if section_name != "sample":
        is_distinct = section_name in ("sweep", *reader.searches)
        return read_axis(reader.problems, key_path, written, reading, distinct=is_distinct)
    distribution = read_distribution(reader.problems, key_path, written, reading)
    if reader.sample is None:
        raise MistakeError(written, key_path)
    reader.distributions[path] = distribution.resolved()
    if path not in reader.sample.earlier_values:
        points = reader.sample.points[:, reader.drawn_paths.index(path)]
        return draw_values(key_path, written, distribution, points, reading.fields)
    drawn_before = reader.sample.earlier_values[path]
    drawn_values = read_axis(reader.problems, f"sample.drawn.{path}", drawn_before, reading, distinct=False)
    if len(drawn_values) != len(reader.sample.points):
        message = f"found {len(drawn_values)} values; this sample has {len(reader.sample.points)}: leave 'drawn' out"
        raise MistakeError(drawn_before, f"sample.drawn.{path}", message)
    return drawn_values


def _unit_mistake(written: WrittenValue, unit: str) -> str:
    """Return why no value of a column of a table has a valid unit, or ''; a column has one unit, that of its header."""
    texts = [item.value for item in written.value] if isinstance(written.value, list) and unit else []
    units = {text.partition(" ")[2] for text in texts if quantity.has_unit(text)}
    if len(units) != 1 or not all(map(quantity.has_unit, texts)):
        return ""
    return mistake_of(quantity.read, f"1 {units.pop()}", unit)


def zipped_paths(reader: Reader) -> tuple[tuple[str, ...], ...]:
    """Return the paths that vary together, by section."""
    groups = [
        tuple(path for path in reader.axes if reader.varied_by[path] == section_name)
        for section_name in VARYING_SECTIONS[1:]
    ]
    for name, search in reader.searches.items():
        paths = tuple(path for path in reader.axes if search.in_step and reader.varied_by[path] == name)
        groups += [paths] if len(paths) > 1 else []
    return tuple(paths for paths in groups if paths)


def check_variations(reader: Reader) -> None:
    """Report zipped axes of different length, and values that varied law names do not use."""
    for paths in zipped_paths(reader):
        section_name, first_path = reader.varied_by[paths[0]], paths[0]
        unequal_paths = [path for path in paths if len(reader.axes[path]) != len(reader.axes[first_path])]
        for path in unequal_paths:
            line_text = (
                f" (line {reader.written_axes[first_path].line})" if reader.written_axes[first_path].line else ""
            )
            message = (
                f"found {len(reader.axes[path])} values, but {first_path} has "
                f"{len(reader.axes[first_path])}{line_text}; axes that vary together need equally many values"
            )
            reader.problems.add(reader.written_axes[path], _axis_key_path(reader, section_name, path), message)
        # without a column that is wrong rows may look alike
        is_whole = len(paths) == reader.written_columns.get(section_name, len(paths))
        if not unequal_paths and section_name != "sample" and is_whole:
            _report_repeated_rows(reader, section_name, paths)
    for path in reader.axes:
        _report_unused_values(reader, path)
    for name in reader.case_labels:
        if name in (*reader.axes, "case_id", "status", "message"):
            position = reader.written_axes[next(iter(reader.axes))]
            reader.problems.add(position, f"cases.{name}", "is a column of the summary already; rename the header")


def _report_repeated_rows(reader: Reader, section_name: str, paths: tuple[str, ...]) -> None:
    """Report the first repeated row of zipped values, and how many there are."""
    rows = list(zip(*(reader.axes[path] for path in paths), strict=True))
    first_rows = {values: row for row, values in reversed([*enumerate(rows)])}
    repeated = [row for row, values in enumerate(rows) if first_rows[values] != row]
    if repeated:
        row, written = repeated[0], reader.written_axes[paths[0]]
        item = written.value[row] if isinstance(written.value, list) else written
        more = f", and {len(repeated) - 1} more rows repeat others" if repeated[1:] else ""
        message = f"row {row + 1} has the values of row {first_rows[rows[row]] + 1}{more}"
        reader.problems.add(item, section_name, f"{message}; each case may occur only once")


def _report_unused_values(reader: Reader, path: str) -> None:
    """Report a zipped value that some varied law names do not use, because it would be unclear which rows count."""
    key = value_key(reader.keys_in_use, path)
    varied_law_paths = [other_path for other_path in deciding_paths(key) if other_path in reader.axes]
    sections = {reader.varied_by[other_path] for other_path in (path, *varied_law_paths)}
    if sections <= {"sweep", *reader.searches}:  # their values may be unused by some of the varied laws
        return
    for law_names in product(*(sorted(reader.names[other_path]) for other_path in varied_law_paths)):
        names = reader.names | {
            other_path: {name} for other_path, name in zip(varied_law_paths, law_names, strict=True)
        }
        if not key.is_used(names):
            required = "every tried law must use a value that is drawn or varies together with others"
            message = f"is not used by {' and '.join(law_names)}; {required}"
            reader.problems.add(
                reader.written_axes[path], _axis_key_path(reader, reader.varied_by[path], path), message
            )
            return


MAX_LABEL_LENGTH = 40  # characters of a label: it heads rows and ends sentences
#: Words that say how values are made; no label may be one of them.
_RESERVED_NAMES = ("fits", "fit", "groups", "group", "inner_warmer")
RESERVED_LABELS = (*SPACING_FORMS, *_RESERVED_NAMES, *DISTRIBUTIONS, "among", "whole", "factor")


def _has_labels(written: WrittenValue) -> bool:
    """Return whether an axis is a mapping of labels to values, and not another form of an axis."""
    content = written.value
    if not isinstance(content, dict) or not content or set(content) <= set(RESERVED_LABELS):
        return False
    items = [item.value for name, item in content.items() if name not in RESERVED_LABELS]
    return all(not isinstance(item, dict | list) or [*item][:1] in (["fit"], ["group"]) for item in items)


def replace_label_axes(reader: Reader) -> None:
    """Replace each axis with labels by the list of its values, and record the labels; mistakes are reported."""
    for path, written in list(reader.written_axes.items()):
        if reader.varied_by[path] not in AXIS_SECTIONS or not _has_labels(written):
            continue
        key_path = f"{reader.varied_by[path]}.{path}"
        invalid = {name: message for name in written.value if (message := _label_mistake(name))}
        if not isinstance(reader.keys_in_use[path], Number):
            message = "is a word, and only numbers have labels; write a list such as [a, b]"
            reader.problems.add(written, key_path, message)
        for name, message in invalid.items():
            reader.problems.add(written.key_position(name), key_path, message)
        items = [item for name, item in written.value.items() if name not in invalid]
        reader.written_axes[path] = written.with_value(items)
        if not invalid:
            reader.labels[path] = tuple(written.value)


def _label_mistake(name: str) -> str:
    """Return what is wrong with a label, or '' if nothing is."""
    if name in RESERVED_LABELS:
        return (
            f"{quoted(name)} is reserved and cannot label a value (reserved: {', '.join(RESERVED_LABELS)}); choose "
            "another label"
        )
    if len(name) > MAX_LABEL_LENGTH or not name.isprintable() or not any(map(str.isalpha, name)):
        return (
            f"found the label {quoted(name)}; expected at most {MAX_LABEL_LENGTH} printable characters, a letter among "
            "them; values without labels are written as a list"
        )
    return ""


def labels_of_axes(reader: Reader) -> dict[str, dict[str, Any]]:
    """Return path of an axis with labels -> label -> value (SI); a value with two labels is reported.

    If fits are searched, they are the labels of their largest clearances.
    """
    labels = dict(reader.search.labels()) if reader.search else {}
    for path, names in reader.labels.items():
        values = reader.axes.get(path, ())
        if len(values) < len(names):
            continue  # a mistake that is noted already
        labels[path] = dict(zip(names, values, strict=False))
        if len(set(labels[path].values())) < len(names):  # of zipped axes, whose values may repeat
            message = "has two labels for one value; write repeated values as a list without labels"
            reader.problems.add(reader.written_axes[path], f"{reader.varied_by[path]}.{path}", message)
    return labels


def recorded_labels(record: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Return path -> label -> value (SI) of the axes with labels, from the run.json of a run."""
    return {path: dict(labels) for path, labels in record.get("labels", {}).items()}


def keys_of_definitions(definitions: Definitions) -> KeyTable:
    """Return the keys of the user-defined quantities that an axis varies."""
    if not definitions.varied_names:
        return {}
    names = [name for name in definitions.expression_by_name if name in definitions.varied_names]
    fields = {name: ranged(name, definitions.units[name], "defined by the grid", "(-inf, inf)") for name in names}
    numbers = {f"{DEFINE_PREFIX}{name}": Number((Use(field),), CHOICE) for name, field in fields.items()}
    return {DEFINE: Section(DEFINE_TEXT, need="optional"), **numbers}


def check_dependents(reader: Reader) -> None:
    """Report numbers that cannot depend on a varied name, and dependent values out of range."""
    for path, text in reader.defined.dependents.items():
        key, name = reader.keys_in_use.get(path), min(reader.defined.varied_in(text))
        fields = key.fields(reader.names) if isinstance(key, Number) else ()
        is_fixed = not isinstance(key, Number) or not key.sweep or path.endswith(".exponent")
        if is_fixed or any(field.integer for field in fields):
            what = "this value" if is_fixed else "a whole number"
            message = f"but {what} must be the same in all cases; write it without that name"
            reader.report(path, f"depends on {DEFINE_PREFIX}{name}, which varies, {message}")
            continue
        invalid = [(field, value) for value in reader.values_of(path) for field in fields if not field.contains(value)]
        for field, value in invalid[:1]:
            message = f"= {text} gives {value:.6g}, out of range; allowed: {field.allowed(value)}"
            reader.problems.add(reader.written_axes[f"{DEFINE_PREFIX}{name}"], path, message)


def report_column_name_clashes(reader: Reader, section: WrittenValue | None) -> None:
    """Report names in `define` that are also columns of the summary."""
    for name in reader.defined.expression_by_name:
        if section is not None and name in reader.figures:
            message = "is the name of a column of the summary; give the quantity another name"
            reader.problems.add(section.key_position(name), f"{DEFINE_PREFIX}{name}", message)


# ----------------------------------------------------------------------------------------------------------------------
# Coexisting motions: the axes that `simulate.start: carried` and `{random: N}` add, and what refuses them.


_FORMS = "{random: 32, seed: 1} or {carried: drive.speed}"
_MOST_DRAWS = 100_000


def with_branch_axes(root: WrittenValue, problems: Problems) -> WrittenValue:
    """Return a document in which the start of the motion is a word, and the starts of each point are an axis."""
    simulate = root.value.get("simulate", WrittenValue({}))
    settings = simulate.entries
    start = settings.get("start")
    if start is None:
        return root
    if isinstance(start.value, dict):
        settings = {**settings, **_settings_of(start, settings, problems)}
        root = _with(root, "simulate", simulate.with_value(settings))
    word, sweep = settings["start"].value, root.value.get("sweep", WrittenValue({}, start.origin))
    if word not in BRANCHES or not isinstance(sweep.value, dict):
        return root
    path = DIRECTION if word == "carried" else DRAW
    if path.rpartition(".")[2] in settings or path in sweep.value:
        return root
    values = ["up", "down"] if word == "carried" else range(1, 1 + (_count(settings.get("random")) or 1))
    items = [start.with_value(value) for value in values]
    axis = start.with_value(items)
    root = _with(root, "simulate", simulate.with_value(settings).without("random"))
    return _with(root, "sweep", sweep.with_value({**sweep.value, path: axis})) if len(items) > 1 else root


def _settings_of(start: WrittenValue, settings: dict[str, Any], problems: Problems) -> dict[str, Any]:
    """Return the keys of `simulate` that a start written as a section means; report an invalid one."""
    allowed = {"random": ("random", "seed"), "carried": ("carried",)}
    word = next((word for word in BRANCHES[::-1] if word in start.value), "")
    wrong = [key for key in start.value if key not in allowed.get(word, ())]
    plain = {"start": replace(start, value="centred")}
    if not word or wrong:
        fault = f"unknown key '{wrong[0]}'" if wrong else "found an empty section"
        problems.add(start, START, f"{fault}; expected {_FORMS}")
        return plain
    written = {"carried_axis" if key == "carried" else key: value for key, value in start.value.items()}
    if clash := [key for key in written if key in settings]:
        problems.add(start, START, f"conflicts with simulate.{clash[0]}, which says the same; remove one of the two")
        return plain
    if word == "random" and _count(start.value["random"]) is None:
        count = start.value["random"]
        message = f"found {quoted(count.value)}; expected a whole number from 2 to {_MOST_DRAWS}"
        problems.add(count, f"{START}.random", message)
        return plain
    return {**written, "start": replace(start, value=word)}


def _count(written: WrittenValue | None) -> int | None:
    """Return the number of random starts, None for anything but a whole number in range."""
    with suppress(InputError):
        number = quantity.read(written.value, "1") if written is not None else 0.0
        if number == int(number) and 2 <= number <= _MOST_DRAWS:
            return int(number)
    return None


def _with(root: WrittenValue, name: str, section: WrittenValue) -> WrittenValue:
    return replace(root, value={**root.value, name: section})


def with_carried_paths(keys: KeyTable, varied: list[str]) -> None:
    """Let `simulate.carried_axis` name any varied quantity, except numerical settings."""
    if CARRIED in keys:
        physical = [path for path in varied if isinstance(keys.get(path), Number) and not path.startswith("simulate.")]
        keys[CARRIED] = word_key(keys, CARRIED)._replace(options=tuple(physical))


def check_branches(reader: Reader, root: WrittenValue) -> None:
    """Report what cannot be combined with carried or random starts, and find the axis that is carried."""
    word = reader.values.get(START)
    if word not in BRANCHES:
        return

    def refuse(reason: str) -> None:
        reader.report(START, f"{word} {reason}")

    if not reader.values_of("drive.speed") or "drive.speed" in reader.sections:
        refuse("needs a drive of constant speed: without it no two cases pass the same angles at the same times")
    if any(value != int(value) for value in reader.values_of("simulate.revolutions")):
        refuse("needs a whole number of revolutions, so that every case begins at the angle at which another ends")
    for path, reason in _REFUSED_SECTIONS.items():
        if path in reader.keys_in_use and reader.is_given(path):
            refuse(f"conflicts with {path}: {reason}; remove one of the two")
    for path in reader.keys_in_use:
        if (reason := _refusal_of(reader, path, word)) and reader.is_given(path):
            refuse(f"conflicts with {path}: {reason}")
            break
    for name in [name for name in (*reader.searches, "sample") if name in root.value]:
        refuse(f"conflicts with `{name}`, which would judge every start as a case of its own; sweep values instead")
    if word == "random" and not reader.is_given(DRAW):
        reader.warnings.append("simulate.start: random is one random start; {random: 32, seed: 1} tries 32 of them")
    if word == "carried":
        for path in reader.keys_in_use:
            if path.startswith("loads.") and any("time" in v for v in reader.values_of(path) if isinstance(v, dict)):
                refuse(f"conflicts with {path}: a load over time begins again in every case; write it over crank_angle")
        _find_carried(reader, refuse)


_REFUSED_SECTIONS = {
    "simulate.until": "starts are compared over equal windows",
    LIFE: "a life follows one motion",
    "simulate.horizon": "its second run has another start",
    "simulate.cycles": "a case ends after whole revolutions",
    "simulate.time": "a case ends after whole revolutions",
}
#: Last keys of paths in a joint, a body or a load -> why they conflict with either start.
_REFUSED_KEYS = {
    "evolve": "a surface that wears has a history of its own; leave `evolve` out",
    "profile": "the room in which its journal starts is no circle; leave `profile` out",
    "thermal": "a temperature is that of one motion; give `temperature` or leave `thermal` out",
    "height": "only pins, gears and couplings have such a start, no guides",
    "slot_length": "only pins, gears and couplings have such a start, no slots",
    "element_diameter": "only plain pins, gears and couplings have such a start, no rolling bearings",
}


def _refusal_of(reader: Reader, path: str, word: str) -> str:
    """Return why a written key conflicts with a start, '' if it does not."""
    parts = path.split(".")
    if parts[0] == "joints" and parts[-1] in _REFUSED_KEYS:
        return _REFUSED_KEYS[parts[-1]]
    if parts[0] == "mechanism" and parts[-1] in ("initial", "elastic") and (word == "random" or parts[-1] == "elastic"):
        why = {"initial": "it says where the body starts", "elastic": "an elastic link has a state of its own"}
        return f"{why[parts[-1]]}; remove one of the two"
    if parts[0] == "loads" and parts[-1] in ("torsional_stiffness", "torsional_damping"):
        return "a body that only a torsion spring reaches has no position in a play"
    return ""


def _find_carried(reader: Reader, refuse: Any) -> None:
    """Find the axis along which the state is carried, or report that there is none or more than one."""
    axes = {
        path: values
        for path, values in reader.axes.items()
        if len(values) > 1 and not isinstance(values[0], str) and not path.startswith("simulate.")
    }
    swept = [path for path in axes if reader.varied_by[path] == "sweep"]
    named = reader.values.get(CARRIED, "")
    others = [path for path in axes if reader.varied_by[path] != "sweep"]
    if named and named not in swept:
        refuse(f"names {named}, which `sweep` does not vary{did_you_mean(named, swept)}; sweep two values or more")
    elif not named and not swept:
        place = f": {others[0]} is under `{reader.varied_by[others[0]]}`" if others else ""
        example = "such as drive.speed: [500 rpm, 600 rpm]"
        refuse(f"needs a quantity with two values or more under `sweep`{place}; {example}")
    elif not named and len(swept) > 1:
        written = " or ".join(f"{{carried: {path}}}" for path in swept[:2])
        refuse(f"does not say along which of {', '.join(swept)}; write start: {written}")
    else:
        reader.values[CARRIED] = named or swept[0]
