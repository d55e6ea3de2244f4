"""Reads the value of one key: a word, a quantity, a list, a table or a flag, or the values of its axis."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from ...contracts.catalogue import Field
from ...language import quantity
from ...language.errors import InputError, did_you_mean, quoted
from ...language.quantity import WrittenUnit, is_bare, written_unit
from ..keys import COUNT_WORDS, Flag, KeyTable, Number, Section, Table, Word, deciding_paths
from ..keys.key_table import DIMENSIONLESS
from ..keys.outline import unit_of_number
from ..sections import Reader, ValueReader, make_word_axis, report_mixed_units
from ..sections.fits import recorded_fits
from ..sections.variations import recorded_labels, values_of_axis
from ..written import Problems, WrittenValue
from ..written.tables import leaf_values, read_table

Meaning = tuple[Field, list[str]]  # meaning of a quantity, and its possible units
_MAX_LAWS_NAMED = 6  # laws in a message
MAX_LISTED_WORDS = 80  # words in a message


def read_word_key(reader: Reader, path: str, key: Word) -> None:
    """Read a word, or the law names on its axis."""

    def read_word(written: WrittenValue) -> str | None:
        if isinstance(written.value, str) and written.value in key.options:
            return written.value
        noun = f"unknown {key.noun}"
        hint = did_you_mean(written.value, key.options) if isinstance(written.value, str) else ""
        reason = key.refused.get(str(written.value))
        allowed = f"`clearsweep list {key.noun}s` has {len(key.options)}"
        if len(key.options) <= MAX_LISTED_WORDS:
            allowed = ", ".join(key.options) or "none"
        description = f"found {quoted(written.value)}; {reason}" if reason else f"{noun} {quoted(written.value)}"
        reader.problems.add(written, path, f"{description}{hint} (known: {allowed})")
        reader.unread_laws.add(path)
        return None

    values: tuple[str, ...] = ()
    if path in reader.written:
        value = read_word(reader.written[path])
        values = () if value is None else (value,)
    elif key.default is not None:
        has_conditional_default = key.conditional_default and key.conditional_default.applies(
            reader.is_given, reader.names
        )
        values = (key.conditional_default.word if key.conditional_default and has_conditional_default else key.default,)
    if path in reader.written_axes:
        with reader.problems.reporting():
            reader.axes[path] = tuple(values_of_axis(reader, path, ValueReader(read_word, "")))
        values = reader.axes.get(path, ())
    elif values:
        reader.values[path] = values[0]
    if not values:
        reader.unread_laws.add(path)
        if path not in reader.written and path not in reader.written_axes:
            without = "name one of a file in `laws`" if path.endswith(".law") else "first add what it names"
            known = f"write one of {', '.join(key.options)}" if key.options else without
            reader.report(path, f"is missing; {known} ({key.text})")
    elif not key.may_be_unused and not key.is_used(reader.names) and _seems_used(reader, path, key):
        reader.report(path, f"is not used by {_law_names_text(reader, key)}; leave it out")
    reader.names[path] = frozenset(values or key.options)
    make_word_axis(reader, path)


def read_table_key(reader: Reader, path: str, key: Table) -> None:
    """Read one table."""
    if key.when and not key.is_used(reader.names):
        if _seems_used(reader, path, key):
            reader.report(path, f"is not used by {_law_names_text(reader, key)}; leave it out")
        return
    if path not in reader.written and key.optional:
        return
    if path not in reader.written:
        message = f"is missing; write the name of a .csv file in the directory of the grid ({key.columns.text})"
        reader.report(path, message)
        return
    with reader.problems.reporting():
        reader.values[path] = read_table(reader.problems, path, reader.written[path], key.columns)


def read_flag(reader: Reader, path: str) -> None:
    """Read a flag; false is treated as left out."""
    key, written = reader.keys_in_use[path], reader.written.get(path)
    assert isinstance(key, Flag), path
    if written is not None and not isinstance(written.value, bool):
        reader.problems.add(written, path, f"found {quoted(written.value)}; expected true or false")
    value = key.default if written is None else bool(written.value)
    if value or key.default is not None:
        reader.values[path] = value


def read_number(reader: Reader, path: str, key: Number) -> None:
    """Read a quantity, or its axis, with the meaning that each law in use gives it."""
    fields = key.fields(reader.names)
    if not fields and _seems_used(reader, path, key):
        owners = sorted({name for key_use in key.uses for name in key_use.when[-1][1]})
        others_text = f" and {len(owners) - _MAX_LAWS_NAMED} more" if len(owners) > _MAX_LAWS_NAMED else ""
        owners_text = ", ".join(owners[:_MAX_LAWS_NAMED])
        refusal = next((f" ({key_use.field.refusal})" for key_use in key.uses if key_use.field.refusal), "")
        message = (
            f"is not used by {_law_names_text(reader, key)}, only by {owners_text}{others_text}; leave it out or "
            f"choose another law{refusal}"
        )
        reader.report(path, message)
        return
    possible_fields = fields or tuple(key_use.field for key_use in key.uses)
    meanings = [(field, _possible_units(reader, path, field)) for field in possible_fields]
    is_unclear = _depends_on_unreadable(reader, key)
    if is_unclear or not fields:  # it is unknown which meaning applies, or unused: any that fits will do
        silent, written = Reader(Problems(), reader.mechanism, reader.outline), reader.written.get(path)
        fitting = [each for each in meanings if written and _read_number(silent, path, written, [each]) is not None]
        if is_unclear and (fitting or path in reader.written_axes):
            return
        meanings = (fitting or meanings)[:1]
    if path in reader.written_axes:
        possible_fields = tuple(field for field, _ in meanings)
        unit = meanings[0][1][0]
        reading = ValueReader(lambda item: _read_number(reader, path, item, meanings), unit, possible_fields)
        with reader.problems.reporting():
            reader.axes[path] = tuple(values_of_axis(reader, path, reading))
    if path in reader.written:
        value = _read_number(reader, path, reader.written[path], meanings)
        if value is not None and path not in reader.written_axes:
            reader.values[path] = value
    elif path not in reader.written_axes and not is_unclear:
        for field in fields:
            if field.default is None and not field.optional and not _follows_from_material(reader, path, field):
                _report_missing(reader, path, key, field)


def _report_missing(reader: Reader, path: str, key: Number, field: Field) -> None:
    """Report a missing quantity, and which of the laws in use need it."""
    law_names = {
        name for key_use in key.uses if key_use.field == field and key_use.when for name in key_use.when[-1][1]
    }
    laws_needing = [
        name for name in sorted(law_names) if any(name in reader.names[chooser] for chooser in deciding_paths(key))
    ]
    laws_text = f" for {' and '.join(laws_needing)}" if laws_needing else ""
    unit_text = quantity.expected_text(quantity.replace_exponent(field.unit, 1.5))
    reader.report(path, f"is missing{laws_text} ({field.text or field.name}); {unit_text}")


def _read_number(reader: Reader, path: str, written: WrittenValue, meanings: list[Meaning]) -> float | int | None:
    """Return a quantity in SI that fits every field in all its units; None, with a problem, if there is none."""
    value = math.nan
    for field, units in meanings:
        for unit in units:
            try:
                value = quantity.read(written.value, unit)
            except InputError as error:
                reader.problems.add(written, path, str(error))
                return None
        if not field.contains(value):
            reader.problems.add(written, path, f"found {written.value}, out of range; allowed: {field.allowed(value)}")
            return None
    return int(value) if meanings[0][0].integer else value


def _possible_units(reader: Reader, path: str, field: Field) -> list[str]:
    """Return the possible units of a value: several if the exponent in the unit is swept."""
    if "^exponent" not in field.unit:
        return [field.unit]
    exponents = exponent_values(reader, path)
    return [quantity.replace_exponent(field.unit, exponent) for exponent in sorted({min(exponents), max(exponents)})]


def exponent_values(reader: Reader, path: str) -> tuple[float, ...]:
    """Return the values of the key `exponent` next to `path`, or (1.5,) if unreadable."""
    return values_before_reading(reader, f"{path.rpartition('.')[0]}.exponent") or (1.5,)


def values_before_reading(reader: Reader, path: str) -> tuple[float, ...]:
    """Return every value of the number at `path` before it is read in turn, or () if unreadable or drawn."""
    key = reader.keys_in_use.get(path)
    if path in reader.defined.dependents:
        return ()
    nothing = Reader(Problems(), reader.mechanism, reader.outline)
    known = ("keys_in_use", "sections", "written", "written_axes", "names", "varied_by")
    silent_reader = replace(nothing, **{name: getattr(reader, name) for name in known})
    if isinstance(key, Number) and (path in reader.written or path in reader.written_axes):
        read_number(silent_reader, path, key)
    return silent_reader.values_of(path)


def _follows_from_material(reader: Reader, path: str, missing: Field) -> bool:
    """Return whether the stiffness at `path` follows from the material, which requires Hertz's exponent."""
    section = path.rpartition(".")[0]
    if missing.unit != "N/m^exponent" or missing.name != "stiffness" or f"{section}.material" not in reader.keys_in_use:
        return False
    if any(not math.isclose(exponent, 1.5) for exponent in exponent_values(reader, path)):
        message = "is missing; `material` determines the stiffness only for the exponent 1.5; write the stiffness"
        reader.report(path, message)
    return True


def _depends_on_unreadable(reader: Reader, key: Word | Number | Table) -> bool:
    """Return whether this key depends on a law name that could not be read and is reported already."""
    return any(path in reader.unread_laws for path in deciding_paths(key))


def _seems_used(reader: Reader, path: str, key: Word | Number | Table) -> bool:
    """Return whether an unused key was written as if it were used; it may belong to another law that is swept.

    Where the section of a law is missing, that is the mistake.
    """
    choosers = deciding_paths(key)
    has_swept_law = any(chooser in reader.written_axes or chooser not in reader.names for chooser in choosers)
    is_written = path in reader.written_axes or (path in reader.written and not has_swept_law)
    return is_written and not _depends_on_unreadable(reader, key)


def _law_names_text(reader: Reader, key: Word | Number | Table) -> str:
    """Return in words the law names on which this key depends: `law 'hertz'`."""
    names = {path: sorted(reader.names[path]) for path in deciding_paths(key)}
    return ", ".join(f"{path.rpartition('.')[2]} {' or '.join(map(repr, choice))}" for path, choice in names.items())


def list_items(reader: Reader, written: WrittenValue, path: str, key_table: KeyTable) -> dict[str, WrittenValue] | None:
    """Return the items of the list at `path` by index; None, with a problem, if they cannot be read."""
    section, content = key_table[path], written.value
    assert isinstance(section, Section), path
    if isinstance(content, dict):  # an override of a single item
        content = list(content.values())
    if section.scalar_factors and isinstance(content, (str, int, float)):
        return {str(k): _times_sign(written, factor) for k, factor in enumerate(section.scalar_factors)}
    if isinstance(content, list) and len(content) == section.items:
        first_key = key_table.get(f"{path}.0")
        report_mixed_units(
            reader.problems, path, content, first_key.uses[0].field.unit if isinstance(first_key, Number) else ""
        )
        return {str(k): item for k, item in enumerate(content)}
    reader.problems.add(written, path, f"found {quoted(content)}; expected {_expected_list(key_table, path, section)}")
    reader.unread_sections.add(path)
    return None


def _expected_list(key_table: KeyTable, path: str, section: Section) -> str:
    """Return a description of the list expected at `path`."""
    first_key, count = key_table.get(f"{path}.0"), COUNT_WORDS[section.items]
    if isinstance(first_key, Word):
        return f"a list of {count} names, such as [ground, crank]"
    assert isinstance(first_key, Number)
    unit = first_key.uses[0].field.unit
    if section.items == 2:
        return f"a list of two quantities, such as [{', '.join([quantity.example_text(unit)] * 2)}]"
    if not first_key.uses[0].field.text.endswith(("x", "y", "z")) and not section.scalar_factors:
        examples = ", ".join([quantity.example_text(unit)] * section.items)
        return f"a list of {count} quantities ({unit}), such as [{examples}]"
    prefix = "one quantity, or " if section.scalar_factors else ""
    return f"{prefix}a list of {count} quantities ({unit}), along x, y and z"


def _times_sign(written: WrittenValue, factor: int) -> WrittenValue:
    """Return a written quantity times 1, 0 or -1."""
    value = written.value
    if factor == 0:
        value = 0
    elif factor < 0:
        value = -value if not isinstance(value, str) else value[1:] if value.startswith("-") else f"-{value}"
    return written.with_value(value)


def assumed_units(reader: Reader) -> tuple[str, ...]:
    """Return the paths of quantities and axes that need a unit but are written without one."""
    fields = {path: key.fields(reader.names) for path, key in reader.keys_in_use.items() if isinstance(key, Number)}
    return tuple(
        path
        for path, meanings in fields.items()
        if meanings
        and meanings[0].unit != "1"
        and _contains_bare_number(reader.written_axes.get(path) or reader.written.get(path))
    )


_SIZES = ("m", "kg", "kg*m^2", "rad/s", "m/s")  # units of lengths, masses, inertias and speeds
_MAX_BARE_NAMED = 12  # numbers in a message


def report_mixed_numbers(reader: Reader, root: WrittenValue) -> None:
    """Report bare lengths, masses, inertias and speeds in a file that writes others with their unit.

    Exempt are 0, and what a program wrote or what does not come from the file itself: JSON, dicts, overrides, tables.
    """
    origins = {root.origin, *(section.origin for section in root.value.values() if ".y" in section.origin)}
    bare: list[tuple[str, WrittenValue]] = []
    others_have_unit = False
    for path, key in reader.keys_in_use.items():
        fields = key.fields(reader.names) if isinstance(key, Number) else ()
        if not fields or fields[0].unit not in _SIZES or path in reader.fits:
            continue
        for entries in (reader.written, reader.written_axes):
            written = entries.get(path)
            if written is None or not written.line or written.by_name or written.origin not in origins:
                continue
            others_have_unit |= any(quantity.has_unit(leaf) for leaf in leaf_values(written))
            if _contains_bare_number(written):
                bare.append((path, written))
    is_of_program = root.origin.endswith(".json")
    if not bare or not others_have_unit or is_of_program or reader.problems:  # another mistake may have cut a unit off
        return
    texts = [f"{path} {next(filter(is_bare, leaf_values(written)))}" for path, written in bare]
    more = f" and {len(bare) - _MAX_BARE_NAMED} more" if len(bare) > _MAX_BARE_NAMED else ""
    path, written = min(bare, key=lambda item: (item[1].line, item[1].column))
    message = (
        "has no unit, but other lengths, masses or speeds of this grid have one; a number without a unit is in SI "
        f"(m, kg, rad/s). Write a unit with {', '.join(texts[:_MAX_BARE_NAMED])}{more}"
    )
    reader.problems.add(written, path, message)


def _contains_bare_number(written: WrittenValue | None) -> bool:
    """Return whether a value is a bare number, or a list or distribution that contains one."""
    if written is None:
        return False
    value = written.value
    if isinstance(value, dict):  # an axis: its ends come first, and a mean is among its keys
        nested = next(iter(value.values()), WrittenValue(None)).value
        value = [nested["mean"]] if isinstance(nested, dict) and "mean" in nested else nested
        if "logspace" in written.value:
            return isinstance(value, list) and len(value) == 3
    if isinstance(value, list):  # either all items have units or none
        return any(is_bare(item.value) for item in value[:2])
    return is_bare(value)


def written_units(reader: Reader) -> dict[str, WrittenUnit]:
    """Return path -> unit in which a quantity or limit is written; for an axis, the unit of its first value with one.

    Values without a unit, expressions, fits and names of library entries are left out.
    """
    units = dict(reader.limit_units)
    searched_fits = reader.search.labels() if reader.search else {}
    for path, key in reader.keys_in_use.items():
        written = reader.written_axes.get(path) or reader.written.get(path)
        if not isinstance(key, Number) or not key.fields(reader.names) or written is None:
            continue
        if path in reader.fits or path in searched_fits:
            continue
        exponent = reader.values.get(f"{path.rpartition('.')[0]}.exponent")
        unit = unit_of_number(key, reader.names, exponent)
        found_units = (written_unit(text, unit) for text in _written_texts(written))
        first_unit = next((found_unit for found_unit in found_units if found_unit), None)
        if first_unit:
            units[path] = first_unit
    return units


def as_written(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fits, labels and units that the user wrote, from `record`; the grid in SI no longer has them."""
    units = {path: WrittenUnit(**fields) for path, fields in record.get("written_units", {}).items()}
    return {"fits": recorded_fits(record), "labels": recorded_labels(record), "written_units": units}


def _written_texts(written: WrittenValue) -> Iterator[Any]:
    """Yield the texts at a path: a value, the items of a list, or the numbers of an axis; names are left out."""
    value = None if written.by_name else written.value
    nested = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    if nested is None:
        yield f"1 {value}" if isinstance(value, str) and value[:1].isalpha() else value  # unit of a logspace
        return
    for item in nested:
        yield from _written_texts(item)


#: Keys of wear coefficients, below `wear`.
COEFFICIENTS = (
    *("coefficient", "bearing_coefficient", "journal_coefficient"),
    *("running_in.initial", "running_in.steady", "running_in.bearing_initial", "running_in.journal_initial"),
)


def set_wear_units(reader: Reader) -> None:
    """Set, for each joint with wear, whether its coefficients are dimensionless, unless the grid contains this."""
    for path in [path for path in reader.keys_in_use if path.endswith(".wear.coefficient_unit")]:
        wear = path.rpartition(".")[0]
        entries = reader.written_axes | reader.written
        coefficients = [entries[f"{wear}.{key}"] for key in COEFFICIENTS if f"{wear}.{key}" in entries]
        leaves = [list(leaf_values(written)) for written in coefficients]
        are_bare = bool(leaves) and all(part and all(map(_is_number, part)) for part in leaves)
        if path not in reader.written and f"{wear}.hardness" in entries and are_bare:
            reader.written[path] = coefficients[0].with_value(DIMENSIONLESS)


def _is_number(value: object) -> bool:
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return not isinstance(value, bool)
