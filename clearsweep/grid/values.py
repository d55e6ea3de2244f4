"""Converts a document to SI values and axes, and reports all mistakes at once."""

import math

from ..contracts.catalogue import Catalogue, Field, Mechanism
from ..language import quantity
from ..language.errors import InputError, nearest, shown
from . import (
    added_cases,
    defined,
    fits,
    followers,
    identified,
    labels,
    law_check,
    life_keys,
    limit_keys,
    list_key,
    naming,
    optimised,
    refine,
    save_keys,
    seek,
    table_key,
    uncertain,
    variations,
    varied_materials,
    wear_unit,
)
from .axes import Reading
from .document import Problems, WrittenValue
from .expected_figures import figures
from .key_table import shape
from .keys import Flag, Name, NameList, Number, Section, Shape, Table, Word
from .outlining import DRIVES, is_open, outline_of_document, wrong_names
from .reader import Reader

_SEARCHES = (seek.SEEK, refine.REFINE, optimised.OPTIMISE, identified.IDENTIFY)
_OF_NO_CASE = [  # sections that belong to no law or mechanism
    *("name", defined.DEFINE, *limit_keys.SECTIONS, uncertain.UNCERTAIN),
    *(*_SEARCHES, law_check.CHECK, *variations.WAYS),
]
Meaning = tuple[Field, list[str]]  # meaning of a quantity, and its possible units


def read_keys(
    root: WrittenValue, catalogue: Catalogue, problems: Problems, fixed: frozenset[str] = frozenset()
) -> Reader:
    """Return the values in the document `root` without sweeping the paths in `fixed`; mistakes go to `problems`."""
    written_names = root.value.get(defined.DEFINE)
    root, definitions = defined.resolve(root, problems, fixed)
    outline = outline_of_document(root)
    mechanism = _mechanism(root, catalogue.mechanisms)
    mechanism = mechanism.outlined(outline) if mechanism.outlined else mechanism
    root, taken = naming.put_numbers(root, problems)
    whole = followers.keys_of(definitions) | shape(mechanism, catalogue)
    materials = varied_materials.find([path for path, _ in defined.varied_paths(root.value)], taken, whole)
    reader = Reader(problems, mechanism, outline, defined=definitions, materials=materials)
    whole |= varied_materials.keys_of(materials)
    _walk(reader, root, "", whole)
    reader.written |= varied_materials.written_names(materials, root)
    _activate(reader, whole)
    variations.find(reader, root, whole, fixed)
    variations.find_optimised(reader, root, whole)
    labels.put_lists(reader)
    law_check.read(reader, root)
    fits.put_numbers(reader, lambda path: _values_before_reading(reader, path))
    reader.taken = {each.path: each for each in taken if each.path not in reader.varied_numbers}
    wear_unit.put_units(reader)
    variations.find_seek(reader, root, whole, lambda path: _values_before_reading(reader, path))
    added_cases.find(reader, root, (*_SEARCHES, law_check.CHECK))
    for path, node in reader.shape.items():
        if isinstance(node, Word):
            _word(reader, path, node)
        elif isinstance(node, Number):
            _number(reader, path, node)
        elif isinstance(node, Flag):
            _flag(reader, path)
        elif isinstance(node, Table):
            _table(reader, path, node)
        elif isinstance(node, NameList):
            save_keys.read_channels(reader, path)
    reader.axes = {path: reader.axes[path] for path in reader.swept if path in reader.axes}
    variations.check(reader)
    followers.check(reader)
    uncertain.read_into(reader, root)
    reader.figures = figures(reader, mechanism, catalogue)
    followers.refuse_columns(reader, written_names)
    limit_keys.read_into(reader, root)
    reader.seek = seek.read(reader, root, reader.limits)
    reader.optimise = optimised.read(reader, root)
    reader.identify = identified.read(reader, root)
    identified.put_saved(reader)
    reader.refine = refine.read(reader, root, reader.limits)
    return reader


def _mechanism(root: WrittenValue, mechanisms: tuple[Mechanism, ...]) -> Mechanism:
    """Return the mechanism whose keys apply: the named one, or the likeliest if the name is wrong."""
    section = root.value.get("mechanism") if isinstance(root.value, dict) else None
    kind = section.value.get("type") if section and isinstance(section.value, dict) else None
    named = {mechanism.name: mechanism for mechanism in mechanisms}
    word = str(kind.value) if kind else ""
    likeliest = next(
        (name for name in named if name == word or f"'{name}'" in nearest(word, named)), mechanisms[0].name
    )
    return named[likeliest]


def _walk(reader: Reader, written: WrittenValue, path: str, whole: Shape) -> None:
    """Record the sections and values under `path`; report keys that do not belong there."""
    known = [inner.rpartition(".")[2] for inner in whole if inner.rpartition(".")[0] == path]
    known += [] if path else _OF_NO_CASE
    reader.sections[path] = written
    content = written.value
    section = whole.get(path)
    if isinstance(section, Section) and section.items:
        content = list_key.items(reader, written, path, whole)
        if content is None:
            return
    if content is None and isinstance(section, Section) and section.need == "implied":
        content = {}
    if not isinstance(content, dict):
        reader.problems.add(
            written, path, f"found {shown(content)}; expected a section with the keys {', '.join(known)}"
        )
        reader.broken.add(path)
        return
    wrong = dict(wrong_names(path, content)) if is_open(path) else {}
    for key, below in content.items():
        inner = f"{path}.{key}" if path else key
        if key in wrong:
            reader.problems.add(written.key_place(key), inner, f"'{key}' {wrong[key]}")
            continue
        node = None if "." in key else whole.get(inner)
        instead = isinstance(node, Number) and isinstance(below.value, dict) and _has_keys_below(whole, inner)
        if isinstance(node, Section) or instead:  # a section, or a section that replaces a quantity
            _walk(reader, below, inner, whole)
        elif node is not None:
            reader.written[inner] = below
        elif key not in known and not _misnamed(reader, inner, below):
            reader.problems.add(written.key_place(key), inner, _unknown(path, key, known))
    for inner, node in whole.items():
        if isinstance(node, Section) and inner.rpartition(".")[0] == path and _missing_section(inner, node, content):
            key = inner.rpartition(".")[2]
            reader.problems.add(written, inner, f"is missing; write the section '{key}' ({node.text})")


def _misnamed(reader: Reader, path: str, written: WrittenValue) -> bool:
    """Report invalid names in an open section, and return whether there are any."""
    names = list(written.value) if is_open(path) and isinstance(written.value, dict) else []
    wrong = dict(wrong_names(path, names))
    for name, sentence in wrong.items():
        reader.problems.add(written.key_place(name), f"{path}.{name}", f"'{name}' {sentence}")
    return bool(wrong)


def _missing_section(path: str, node: Section, content: dict[str, WrittenValue]) -> bool:
    """Return whether the section at `path` is missing from its parent `content`."""
    return node.need == "required" and path.rpartition(".")[2] not in content and node.unless not in content


def _unknown(path: str, key: str, known: list[str]) -> str:
    """Return the message for a key that does not belong in the section at `path`."""
    if path == "drive" and key in DRIVES:
        other = next((drive for drive in DRIVES if drive in known), DRIVES[0])
        return f"conflicts with {other}; a drive has one of {', '.join(DRIVES)}: leave the others out"
    if key == "elastic" and path.startswith("mechanism."):
        stretches = "an elastic link stretches along the line between two pins of a plane"
        return f"{stretches}; this one is rigid: leave `elastic` out"
    allowed = f"(allowed: {', '.join(known)})" if known else "(nothing is named here that could have any)"
    return f"unknown key '{key}'{nearest(key, known)} {allowed}"


def _activate(reader: Reader, whole: Shape) -> None:
    """Reduce the whole shape to the keys in use; wear and roughness also get keys that otherwise only laws have."""
    for path, node in whole.items():
        parent = path.rpartition(".")[0]
        there = not isinstance(node, Section) or _exists(reader, path, node)
        if isinstance(whole.get(parent), Number):
            there = parent in reader.sections
        elif isinstance(node, Number) and path in reader.sections:  # a section replaces it
            there = False
        known_parent = not parent or parent in reader.shape or isinstance(whole.get(parent), Number)
        if there and known_parent and not isinstance(node, Name) and reader.broken.isdisjoint((path, parent)):
            reader.shape[path] = node
            if isinstance(node, Section):
                reader.sections.setdefault(path, reader.sections[parent])
    life_keys.put_patience(reader)
    for path, node in reader.shape.items():
        joint = ".".join(path.split(".")[:2])
        of_material = path.startswith(f"{joint}.contact.material.")
        sized = f"{joint}.roughness" in reader.shape and (
            of_material or path in (f"{joint}.length", f"{joint}.bearing_radius")
        )
        if isinstance(node, Number) and (sized or (of_material and f"{joint}.wear" in reader.shape)):
            reader.shape[path] = Number(tuple(use._replace(when=()) for use in node.uses))


def _has_keys_below(whole: Shape, path: str) -> bool:
    """Return whether there are keys below `path`."""
    return any(inner.rpartition(".")[0] == path for inner in whole)


def _exists(reader: Reader, path: str, node: Section) -> bool:
    """Return whether the section at `path` exists: written or implied, together with the sections it needs."""
    required = f"{path.rpartition('.')[0].rpartition('.')[0]}.{node.needs}"
    return (path in reader.sections or node.need == "implied") and (not node.needs or required in reader.shape)


def _word(reader: Reader, path: str, node: Word) -> None:
    """Read a word, or the law names on its axis."""

    def read_word(written: WrittenValue) -> str | None:
        if isinstance(written.value, str) and written.value in node.options:
            return written.value
        noun = f"unknown {node.noun}"
        hint = nearest(written.value, node.options) if isinstance(written.value, str) else ""
        known, reason = ", ".join(node.options) or "none", node.refused.get(str(written.value))
        what = f"found {shown(written.value)}; {reason}" if reason else f"{noun} {shown(written.value)}"
        reader.problems.add(written, path, f"{what}{hint} (known: {known})")
        reader.unsure.add(path)
        return None

    values: tuple[str, ...] = ()
    if path in reader.written:
        value = read_word(reader.written[path])
        values = () if value is None else (value,)
    elif node.default is not None:
        rather = node.rather and node.rather.contains(reader.there, reader.names)
        values = (node.rather.word if node.rather and rather else node.default,)
    if path in reader.swept:
        _enter_axis(reader, path, Reading(read_word, ""))
        values = reader.axes.get(path, ())
    elif values:
        reader.values[path] = values[0]
    if not values:
        reader.unsure.add(path)
        if path not in reader.written and path not in reader.swept:
            reader.problems.add(
                reader.place(path), path, f"is missing; write one of {', '.join(node.options)} ({node.text})"
            )
    elif not node.idle and not node.used(reader.names) and _seems_used(reader, path, node):
        reader.problems.add(reader.place(path), path, f"is not used by {_chosen(reader, node)}; leave it out")
    reader.names[path] = frozenset(values or node.options)
    law_check.put_axis(reader, path)


def _table(reader: Reader, path: str, node: Table) -> None:
    """Read one table."""
    if node.when and not node.used(reader.names):
        if _seems_used(reader, path, node):
            reader.problems.add(reader.place(path), path, f"is not used by {_chosen(reader, node)}; leave it out")
        return
    if path not in reader.written and node.optional:
        return
    if path not in reader.written:
        sentence = f"is missing; write the name of a .csv file next to the grid ({node.columns.text})"
        reader.problems.add(reader.place(path), path, sentence)
        return
    if (values := table_key.read(reader.problems, path, reader.written[path], node.columns)) is not None:
        reader.values[path] = values


def _flag(reader: Reader, path: str) -> None:
    """Read a flag; false is treated as left out."""
    node, written = reader.shape[path], reader.written.get(path)
    assert isinstance(node, Flag), path
    if written is not None and not isinstance(written.value, bool):
        reader.problems.add(written, path, f"found {shown(written.value)}; expected true or false")
    value = node.default if written is None else bool(written.value)
    if value or node.default is not None:
        reader.values[path] = value


def _number(reader: Reader, path: str, node: Number) -> None:
    """Read a quantity, or its axis, with the meaning that each law in use gives it."""
    fields = node.fields(reader.names)
    if not fields and _seems_used(reader, path, node):
        owners = sorted({name for use in node.uses for name in use.when[-1][1]})
        sentence = (
            f"is not used by {_chosen(reader, node)}, only by {', '.join(owners)}; leave it out or choose another law"
        )
        reader.problems.add(reader.place(path), path, sentence)
        return
    meanings = [(field, _units(reader, path, field)) for field in fields or (node.uses[0].field,)]
    if _depends_on_unreadable(reader, node):  # which meaning applies is unknown; any that fits will do
        quiet = Reader(Problems(), reader.mechanism, reader.outline)
        written = reader.written.get(path)
        if path in reader.swept or (
            written and any(_quantity(quiet, path, written, [each]) is not None for each in meanings)
        ):
            return
        meanings = meanings[:1]
    if path in reader.swept:
        fits = tuple(field for field, _ in meanings)
        unit = meanings[0][1][0]
        _enter_axis(reader, path, Reading(lambda written: _quantity(reader, path, written, meanings), unit, fits))
    if path in reader.written:
        value = _quantity(reader, path, reader.written[path], meanings)
        if value is not None and path not in reader.swept:
            reader.values[path] = value
    elif path not in reader.swept and not _depends_on_unreadable(reader, node):
        for field in fields:
            if field.default is None and not field.optional and not _from_material(reader, path, field):
                _missing(reader, path, node, field)


def _missing(reader: Reader, path: str, node: Number, field: Field) -> None:
    """Report a missing quantity, and which of the laws in use need it."""
    laws = {name for use in node.uses if use.field == field and use.when for name in use.when[-1][1]}
    needed = [name for name in sorted(laws) if any(name in reader.names[chooser] for chooser in node.choosers())]
    whose = f" for {' and '.join(needed)}" if needed else ""
    wanted = quantity.expected(quantity.exponent_of(field.unit, 1.5))
    reader.problems.add(reader.place(path), path, f"is missing{whose} ({field.text or field.name}); {wanted}")


def _enter_axis(reader: Reader, path: str, reading: Reading) -> None:
    """Record the values of an axis."""
    if values := variations.values(reader, path, reading):
        reader.axes[path] = tuple(values)


def _quantity(reader: Reader, path: str, written: WrittenValue, meanings: list[Meaning]) -> float | int | None:
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
    return int(value) if meanings[0][0].whole else value


def _units(reader: Reader, path: str, field: Field) -> list[str]:
    """Return the possible units of a value: several if the exponent in the unit is swept."""
    if "^exponent" not in field.unit:
        return [field.unit]
    exponents = exponent_values(reader, path)
    return [quantity.exponent_of(field.unit, exponent) for exponent in sorted({min(exponents), max(exponents)})]


def exponent_values(reader: Reader, path: str) -> tuple[float, ...]:
    """Return the values of the key `exponent` next to `path`, or (1.5,) if unreadable."""
    return _values_before_reading(reader, f"{path.rpartition('.')[0]}.exponent") or (1.5,)


def _values_before_reading(reader: Reader, path: str) -> tuple[float, ...]:
    """Return every value of the number at `path` before it is read in turn, or () if unreadable or drawn."""
    node = reader.shape.get(path)
    if path in reader.defined.follow:
        return ()
    quiet = Reader(
        Problems(),
        reader.mechanism,
        reader.outline,
        reader.shape,
        reader.sections,
        reader.written,
        reader.swept,
        reader.names,
        way=reader.way,
    )
    if isinstance(node, Number) and (path in reader.written or path in reader.swept):
        _number(quiet, path, node)
    return quiet.reached(path)


def _from_material(reader: Reader, path: str, missing: Field) -> bool:
    """Return whether the stiffness at `path` follows from the material, which requires Hertz's exponent."""
    section = path.rpartition(".")[0]
    if missing.unit != "N/m^exponent" or missing.name != "stiffness" or f"{section}.material" not in reader.shape:
        return False
    if any(not math.isclose(exponent, 1.5) for exponent in exponent_values(reader, path)):
        sentence = "is missing; the material gives the stiffness only where exponent is 1.5: write it"
        reader.problems.add(reader.place(path), path, sentence)
    return True


def _depends_on_unreadable(reader: Reader, node: Word | Number | Table) -> bool:
    """Return whether this key depends on a law name that could not be read and is reported already."""
    return any(path in reader.unsure for path in node.choosers())


def _seems_used(reader: Reader, path: str, node: Word | Number | Table) -> bool:
    """Return whether an unused key was written as if it were used; it may belong to another law that is swept."""
    switched = any(chooser in reader.swept for chooser in node.choosers())
    there = path in reader.swept or (path in reader.written and not switched)
    return there and not _depends_on_unreadable(reader, node)


def _chosen(reader: Reader, node: Word | Number | Table) -> str:
    """Return in words the law names on which this key depends: `law 'hertz'`."""
    names = {path: sorted(reader.names[path]) for path in node.choosers()}
    return ", ".join(f"{path.rpartition('.')[2]} {' or '.join(map(repr, chosen))}" for path, chosen in names.items())
