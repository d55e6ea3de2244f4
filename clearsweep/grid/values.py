"""Turns a document into SI values and axes, telling everything that is wrong with it at once."""

import math

from .. import quantity
from ..case import column_name
from ..catalogue import Catalogue, Field, Mechanism
from ..errors import InputError, nearest, shown
from ..layout import columns_of
from . import variations
from .document import Entry, Problems
from .draft import Draft
from .key_table import shape
from .keys import Flag, Number, Section, Shape, Word


def draft(root: Entry, catalogue: Catalogue, problems: Problems, fixed: frozenset = frozenset()) -> Draft:
    """Return what the document `root` says, the paths in `fixed` not swept; mistakes go to `problems`."""
    mechanism = _mechanism(root, catalogue.mechanisms)
    read = Draft(problems, mechanism)
    whole = shape(mechanism, catalogue)
    _walk(read, root, "", whole)
    _activate(read, whole)
    variations.find(read, root, whole, fixed)
    for path, node in read.shape.items():
        if isinstance(node, Word):
            _word(read, path, node)
        elif isinstance(node, Number):
            _number(read, path, node)
        elif isinstance(node, Flag):
            _flag(read, path)
    read.axes = {path: read.axes[path] for path in read.swept if path in read.axes}
    variations.check(read)
    read.figures = _figures(read, mechanism, catalogue)
    read.limits = variations.limits(read, root)
    return read


def _mechanism(root: Entry, mechanisms: tuple[Mechanism, ...]) -> Mechanism:
    """Return the mechanism whose keys to check against: the one named, or the likeliest where the name is wrong."""
    section = root.value.get("mechanism") if isinstance(root.value, dict) else None
    kind = section.value.get("type") if section and isinstance(section.value, dict) else None
    named = {mechanism.name: mechanism for mechanism in mechanisms}
    word = str(kind.value) if kind else ""
    likeliest = next(
        (name for name in named if name == word or f"'{name}'" in nearest(word, named)), mechanisms[0].name
    )
    return named[likeliest]


def _figures(read: Draft, mechanism: Mechanism, catalogue: Catalogue) -> dict[str, str]:
    """Return the figures of merit that the cases will have, each with its unit."""
    sections = [path.split(".") for path, node in read.shape.items() if isinstance(node, Section)]
    inside = [path[1:] for path in sections if path[0] == "joints" and len(path) > 1]
    parts = {
        column_name(joint): {part for other, *rest in inside if other == joint for part in rest[:1]}
        for joint, *_ in inside
    }
    until = read.values.get("simulate.until.figure", "")
    asked = {name for name in ("horizon", "error_check") if f"simulate.{name}" in read.values}
    columns = columns_of(catalogue, mechanism, parts, asked | ({"until"} if until else set()), until)
    return {column.name: column.unit for column in columns}


def _walk(read: Draft, entry: Entry, path: str, whole: Shape) -> None:
    """Note the sections and values under `path`, and the keys that do not belong there."""
    known = [inner.rpartition(".")[2] for inner in whole if inner.rpartition(".")[0] == path] + (
        ["name", "limits", *variations.WAYS] if not path else []
    )
    read.sections[path] = entry
    content = entry.value
    if path in whole and whole[path].pair:
        if isinstance(content, dict):  # an override of one of the two
            content = list(content.values())
        if not isinstance(content, list) or len(content) != 2:
            read.problems.add(
                entry, path, f"found {shown(content)}; expected a list of two quantities, such as [0.2 kg, 0.2 kg]"
            )
            read.broken.add(path)
            return
        content = {str(k): item for k, item in enumerate(content)}
    if content is None and path in whole and whole[path].need == "implied":
        content = {}
    if not isinstance(content, dict):
        read.problems.add(entry, path, f"found {shown(content)}; expected a section with the keys {', '.join(known)}")
        read.broken.add(path)
        return
    for key, below in content.items():
        inner = f"{path}.{key}" if path else key
        node = None if "." in key else whole.get(inner)
        if isinstance(node, Section):
            _walk(read, below, inner, whole)
        elif node is not None:
            read.written[inner] = below
        elif key not in known:
            read.problems.add(
                entry.keys.get(key, below),
                inner,
                f"unknown key '{key}'{nearest(key, known)} (allowed: {', '.join(known)})",
            )
    for key in known:
        inner = f"{path}.{key}" if path else key
        if key not in content and isinstance(whole.get(inner), Section) and whole[inner].need == "required":
            read.problems.add(entry, inner, f"is missing; write the section '{key}' ({whole[inner].text})")


def _activate(read: Draft, whole: Shape) -> None:
    """Keep of the whole shape what is there, and give the material to wear where there is wear."""
    for path, node in whole.items():
        parent = path.rpartition(".")[0]
        there = not isinstance(node, Section) or path in read.sections or node.need == "implied"
        if there and path not in read.broken and (not parent or parent in read.shape):
            read.shape[path] = node
            if isinstance(node, Section):
                read.sections.setdefault(path, read.sections[parent])
    for path, node in read.shape.items():
        joint = path.partition(".contact.material.")[0]
        if joint != path and f"{joint}.wear" in read.shape:
            read.shape[path] = Number(tuple(use._replace(when=()) for use in node.uses))


def _word(read: Draft, path: str, node: Word) -> None:
    """Read one word, or the law names on its axis."""

    def one(entry: Entry) -> str | None:
        if isinstance(entry.value, str) and entry.value in node.options:
            return entry.value
        noun = "unknown law" if node.law else "unknown word"
        hint = nearest(entry.value, node.options) if isinstance(entry.value, str) else ""
        read.problems.add(
            entry, path, f"{noun} {shown(entry.value)}{hint} (known: {', '.join(node.options) or 'none'})"
        )
        read.unsure.add(path)
        return None

    values = ()
    if path in read.written:
        value = one(read.written[path])
        values = () if value is None else (value,)
    elif node.default is not None:
        values = (node.default,)
    if path in read.swept:
        _enter_axis(read, path, one, "", ())
        values = read.axes.get(path, ())
    elif values:
        read.values[path] = values[0]
    if not values:
        read.unsure.add(path)
        if path not in read.written and path not in read.swept:
            read.problems.add(
                read.place(path), path, f"is missing; write one of {', '.join(node.options)} ({node.text})"
            )
    elif not node.used(read.names) and _meant(read, path, node):
        read.problems.add(read.place(path), path, f"is not used by {_chosen(read, node)}; leave it out")
    if node.law:
        read.names[path] = frozenset(values or node.options)


def _flag(read: Draft, path: str) -> None:
    """Read one flag; nothing is entered where it is false, as where it is left out."""
    entry = read.written.get(path)
    if entry is None or entry.value is False:
        return
    if entry.value is not True:
        read.problems.add(entry, path, f"found {shown(entry.value)}; expected true or false")
    read.values[path] = True


def _number(read: Draft, path: str, node: Number) -> None:
    """Read one quantity, or its axis, as every law in play understands it."""
    fields = node.fields(read.names)
    if not fields and _meant(read, path, node):
        owners = sorted({name for use in node.uses for name in use.when[-1][1]})
        sentence = (
            f"is not used by {_chosen(read, node)}, only by {', '.join(owners)}; leave it out or choose another law"
        )
        read.problems.add(read.place(path), path, sentence)
        return
    meanings = [(one, _units(read, path, one)) for one in fields or (node.uses[0].field,)]
    if _doubtful(read, node):  # which meaning holds is not known: one that fits will do
        quiet = Draft(Problems())
        entry = read.written.get(path)
        if path in read.swept or any(_read(quiet, path, entry, [meaning]) is not None for meaning in meanings if entry):
            return
        meanings = meanings[:1]
    if path in read.swept:
        inside = tuple(one for one, _ in meanings)
        _enter_axis(read, path, lambda entry: _read(read, path, entry, meanings), meanings[0][1][0], inside)
    if path in read.written:
        value = _read(read, path, read.written[path], meanings)
        if value is not None and path not in read.swept:
            read.values[path] = value
    elif path not in read.swept and not _doubtful(read, node):
        for field in fields:
            if field.default is None and not field.optional and not _from_material(read, path, field):
                _missing(read, path, node, field)


def _missing(read: Draft, path: str, node: Number, field: Field) -> None:
    """Note that a quantity is missing, and which of the laws in play need it."""
    laws = {name for use in node.uses if use.field == field and use.when for name in use.when[-1][1]}
    needed = [name for name in sorted(laws) if any(name in read.names[chooser] for chooser in node.choosers())]
    whose = f" for {' and '.join(needed)}" if needed else ""
    wanted = quantity.expected(quantity.exponent_of(field.unit, 1.5))
    read.problems.add(read.place(path), path, f"is missing{whose} ({field.text or field.name}); {wanted}")


def _enter_axis(read: Draft, path: str, one, unit: str, fields: tuple[Field, ...]) -> None:
    """Enter the values of an axis, each read by `one(entry)`."""
    values = variations.values(read, path, one, unit, fields)
    if values:
        read.axes[path] = tuple(values)


def _read(read: Draft, path: str, entry: Entry, meanings: list[tuple[Field, list[str]]]) -> float | int | None:
    """Return a quantity in SI that fits every field with all its units, or None and a problem."""
    value = None
    for one, units in meanings:
        for unit in units:
            try:
                value = quantity.read(entry.value, unit)
            except InputError as error:
                read.problems.add(entry, path, str(error))
                return None
        if not one.holds(value):
            read.problems.add(entry, path, f"found {entry.value}, out of range; allowed: {one.allowed()}")
            return None
    return int(value) if meanings[0][0].whole else value


def _units(read: Draft, path: str, one: Field) -> list[str]:
    """Return the units that a value has to fit: several where the exponent in the unit is swept."""
    if "^exponent" not in one.unit:
        return [one.unit]
    exponents = exponent_values(read, path)
    return [quantity.exponent_of(one.unit, exponent) for exponent in sorted({min(exponents), max(exponents)})]


def exponent_values(read: Draft, path: str) -> tuple:
    """Return the values of the key `exponent` beside `path`, (1.5,) where they cannot be read."""
    beside = f"{path.rpartition('.')[0]}.exponent"
    node = read.shape.get(beside)
    quiet = Draft(
        Problems(), read.mechanism, read.shape, read.sections, read.written, read.swept, read.names, way=read.way
    )
    if isinstance(node, Number) and (beside in read.written or beside in read.swept):
        _number(quiet, beside, node)
    return quiet.reached(beside) or (1.5,)


def _from_material(read: Draft, path: str, missing: Field) -> bool:
    """Return whether the stiffness at `path` follows from the material, which needs Hertz's exponent."""
    section = path.rpartition(".")[0]
    if missing.unit != "N/m^exponent" or missing.name != "stiffness" or f"{section}.material" not in read.shape:
        return False
    if any(not math.isclose(exponent, 1.5) for exponent in exponent_values(read, path)):
        read.problems.add(
            read.place(path), path, "is missing; the material gives the stiffness only where exponent is 1.5: write it"
        )
    return True


def _doubtful(read: Draft, node: Word | Number) -> bool:
    """Return whether a law name that decides about this key could not be read; its own problem is told already."""
    return any(path in read.unsure for path in node.choosers())


def _switched(read: Draft, node: Word | Number) -> bool:
    """Return whether a law name that decides about this key is swept, so that the key may be kept for other values."""
    return any(path in read.swept for path in node.choosers())


def _meant(read: Draft, path: str, node: Word | Number) -> bool:
    """Return whether a key that is not in use was written as if it were."""
    there = path in read.swept or (path in read.written and not _switched(read, node))
    return there and not _doubtful(read, node)


def _chosen(read: Draft, node: Word | Number) -> str:
    """Return the law names in play that decide about this key, in words: `law 'hertz'`."""
    names = {path: sorted(read.names[path]) for path in node.choosers()}
    return ", ".join(f"{path.rpartition('.')[2]} {' or '.join(map(repr, found))}" for path, found in names.items())
