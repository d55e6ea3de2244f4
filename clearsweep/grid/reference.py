"""The page of all grid keys, generated from the key table."""

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

from ..contracts.catalogue import Catalogue, Field
from ..contracts.outline import ANY
from ..language import quantity
from . import choosing
from .key_trees import KeyTree, key_trees
from .keys import ITEMS, Flag, Name, NameList, Number, Section, Shape, Table, Word

_HEAD = """\
# Keys of a grid file

<!-- written by `clearsweep schema --markdown`; a test compares -->

A grid file is YAML 1.2. `NAME` is a name that the grid chooses. A quantity is text with a unit (`0.5 mm`, `5000 rpm`)
or a bare number in the SI unit of the table; any unit of the same dimension is allowed. In the column *default*,
*required* marks a key without a default and a dash an optional one. Words in italics say which mechanisms or joints
have a key; without them all have it. Laws before a colon say which laws use it.

Sweeps may vary numbers, except those marked *fixed*, and names of laws. Items of a list have the paths `.0`, `.1`,
`.2`. `clearsweep list NAME` explains a law and its keys. `clearsweep schema` writes the same keys as a JSON Schema for
editors.
"""
_TABLE = "| key | unit | allowed | default | meaning |\n| --- | --- | --- | --- | --- |"
_JOINT = f"joints.{ANY}"
#: Sections with the keys of another section: path -> path of the other, and whose keys they are.
_LIKE = {f"{_JOINT}.axial": (f"{_JOINT}.contact", "flange"), f"loads.{ANY}.friction": (f"{_JOINT}.friction", "load")}
_KINDS = {"revolute": "pin", "guide": "guide", "slot": "slot", "line": "impact-pair", ANY: "pin"}
_SPACE = "in space"
_SMALL = 0.05  # example of a share that is usually left out


class Row(NamedTuple):
    """A row of a table on the page."""

    key: str
    units: tuple[str, ...]
    allowed: str
    default: str
    text: str
    laws: tuple[str, ...] = ()  # laws for which the key has this meaning; empty: all laws
    options: tuple[str, ...] = ()  # allowed words
    example: str = ""  # an allowed value

    def __str__(self) -> str:
        units = " or ".join(unit or "1" for unit in self.units) if any(self.units) else ""
        cells = (f"`{self.key}`", units, self.allowed or _quoted(self.options), self.default, self.text)
        return f"| {' | '.join(cell.replace('|', '&#124;').replace('<', '&lt;') for cell in cells)} |"


_Places = dict[str, tuple[Section, tuple[Row, ...]]]  # (mechanism or kind of joint, a section of it)


def _quoted(words: Iterable[str]) -> str:
    """Return words as a list in code font."""
    return ", ".join(f"`{word}`" for word in words)


class Part(NamedTuple):
    """A part of the page: one section of a grid file, or several with the same keys."""

    paths: tuple[str, ...]  # as on the page: `joints.NAME.contact`
    text: str  # what it is
    rows: tuple[Row, ...]


def parts(catalogue: Catalogue) -> list[Part]:
    """Return every section of a grid file with its keys, in page order, except those that choose cases.

    A section that several mechanisms or joints share appears once; a row names its owners unless all have it.
    """
    sections: dict[str, _Places] = {}
    for tree in key_trees(catalogue, slots=True):
        for path, node in tree.keys.items():
            if isinstance(node, Section) and not node.items and (rows := tuple(_rows(tree.keys, path))):
                common, place = _common(tree, path)
                sections.setdefault(common, {}).setdefault(place, (node, rows))
    alike: dict[tuple[Row, ...], list[str]] = {}
    tops = list(dict.fromkeys(path.partition(".")[0] for path in sections))
    for path, places in sorted(sections.items(), key=lambda item: tops.index(item[0].partition(".")[0])):
        alike.setdefault(tuple(_merged_rows(places)), []).append(path)
    made = []
    for rows, paths in alike.items():
        like = [other for other, (path, _) in _LIKE.items() if path in paths]
        made.append(Part((*paths, *like), _sentences({path: sections[path] for path in paths}), rows))
    return made


def markdown(catalogue: Catalogue) -> str:
    """Return the page in Markdown: every key with unit, range, default and meaning."""
    lines = [_HEAD, *_overview(key_trees(catalogue, slots=True))]
    for part in parts(catalogue):
        lines += [f"## {_quoted(part.paths)}\n", f"{part.text}\n", _TABLE, *map(str, part.rows), ""]
    return "\n".join([*lines, choosing.markdown(catalogue)])


def _common(tree: KeyTree, path: str) -> tuple[str, str]:
    """Return the path of a section on the page, and the mechanism or kind of joint that it belongs to."""
    place = f"{tree.mechanism} {_SPACE}" if tree.spatial else tree.mechanism
    first, _, rest = path.partition(".")
    if first == "joints" and rest:
        joint, _, inside = rest.partition(".")
        place = _SPACE if tree.spatial else _KINDS[tree.joints[joint]]
        path = f"{_JOINT}.{inside}" if inside else _JOINT
    return _LIKE.get(path, (path, place))


def _overview(trees: Iterable[KeyTree]) -> Iterator[str]:
    """Yield a table of the mechanisms and their joints that may have clearance."""
    yield "| mechanism | joints that may have clearance (body of the journal) |\n| --- | --- |"
    for tree in trees:
        words = []
        for joint, kind in tree.joints.items():
            journal = tree.keys.get(f"joints.{joint}.journal")
            body = journal.default if isinstance(journal, Word) and journal.default else ""
            words.append(f"`{joint}` ({body})" if body else f"`{joint}`" + (", a guide" if kind == "guide" else ""))
        if set(tree.joints.values()) != {"slot"}:
            yield f"| {tree.mechanism}{f' {_SPACE}' if tree.spatial else ''} | {', '.join(words)} |"
    yield ""


def _merged_rows(places: _Places) -> Iterator[Row]:
    """Yield the rows of a section; a row that only some mechanisms or joints have names them.

    Rows that differ only in units, laws or options are merged; the row of `law` lists the laws of each joint.
    """
    rows: dict[Row, dict[str, list[Row]]] = {}
    for place, (_, own) in places.items():
        for row in own:
            rows.setdefault(row._replace(units=(), laws=(), options=(), example=""), {}).setdefault(place, []).append(
                row
            )
    order, known = list(dict.fromkeys(row.key for row in rows)), tuple[str, ...]()
    for row, owners in sorted(rows.items(), key=lambda item: order.index(item[0].key)):
        every = [each for own in owners.values() for each in own]
        units = tuple(dict.fromkeys(unit for each in every for unit in each.units))
        laws = tuple(dict.fromkeys(law for each in every for law in each.laws)) if all(r.laws for r in every) else ()
        options = tuple(dict.fromkeys(word for each in every for word in each.options))
        known = options if row.key == "law" else known
        text = f"{_laws(laws, known)}: {row.text}" if laws else row.text
        lacking: dict[tuple[str, ...], list[str]] = {}
        for place, owner in owners.items():
            lacking.setdefault(tuple(word for word in options if word not in owner[0].options), []).append(place)
        for words, those in lacking.items():
            text += f"; {_owners_text(those, owners)}: without {_quoted(words)}" if words else ""
        having = {place for place, (_, own) in places.items() if any({*laws} & {*each.options} for each in own)}
        only = (
            "" if having == set(owners) else _owners_text(owners, places)
        )  # the row of `law` says which joints have a law
        text = f"*{only}*: {text}" if only else text
        yield row._replace(units=units, text=text, options=options, example=every[0].example)


def _laws(own: Collection[str], known: Collection[str]) -> str:
    """Return the names of laws; if most laws of a section have the key, those without it."""
    others = [name for name in known if name not in own]
    if others and len(others) < len(own) and {*own} <= {*known}:
        return f"all but {_quoted(others)}"
    return "all" if {*own} == {*known} else _quoted(own)


def _owners_text(owners: Collection[str], places: Collection[str]) -> str:
    """Return in words which owners have a row, or '' if all have it."""
    if len(owners) == len(places):
        return ""
    in_space = {place for place in places if place.endswith(_SPACE)}
    in_plane = set(places) - in_space - {"impact-pair"}
    for group, text in ((in_space, _SPACE), (in_plane, "in the plane"), (set(places) - in_space, f"not {_SPACE}")):
        if set(owners) == group:
            return text
    others = [place for place in places if place not in owners]
    return f"not {', '.join(others)}" if len(others) < len(owners) else ", ".join(owners)


def _sentences(sections: Mapping[str, _Places]) -> str:
    """Return what sections with the same keys are and whether they are required, by owner if that differs."""
    texts: dict[tuple[str, str], None] = {}
    for path, places in sections.items():
        of: dict[tuple[str, str], list[str]] = {}
        for place, (section, _) in places.items():
            need = "" if "left out" in section.text else "required" if section.need == "required" else "optional"
            text = "" if section.text.endswith(f" {path.rpartition('.')[2]}") else _of_body(path, section.text)
            of.setdefault((text, need), []).append(place)
        for (text, need), own in of.items():
            only = _owners_text(own, places)
            texts[f"{text} ({only})" if only and text else text, need] = None
    needs = {need for _, need in texts}
    lines = [text if len(needs) == 1 else f"{text}; {need}" if text and need else text or need for text, need in texts]
    common = needs if len(needs) == 1 else set()
    return " ".join(f"{line[0].upper()}{line[1:]}." for line in (*lines, *common) if line)


def _rows(tree: Shape, path: str) -> Iterator[Row]:
    """Yield the rows of the keys directly in the section at `path`; a list is one row."""
    for inner, node in tree.items():
        parent, _, key = inner.rpartition(".")
        if isinstance(tree.get(parent), Number):  # a quantity, or a section that replaces it
            parent, _, above = parent.rpartition(".")
            key = f"{above}.{key}"
        if parent != path:
            continue
        if isinstance(node, Section):
            if node.items:
                yield _list(tree, inner, key, node)
        elif isinstance(node, Table):
            columns = ", ".join(f"`{field.name}` ({field.unit})" for field in node.columns[2] + node.columns[3])
            yield Row(key, (), f".csv: {columns}", "-", node.columns.text)
        elif isinstance(node, Name):
            yield Row(key, (), "a name", "-", _of_body(inner, node.text))
        elif isinstance(node, Flag):
            default = "`true`" if node.default else "`false`"
            yield Row(key, (), "`true`, `false`", default, node.text)
        elif isinstance(node, NameList):
            yield Row(key, (), f"{node.noun}", "-", node.text, example=node.example)
        elif isinstance(node, Word):
            yield _word(inner, key, node)
        else:
            yield from _quantity(tree, inner, key, node)


def _word(path: str, key: str, node: Word) -> Row:
    """Return the row of a word."""
    default = f"`{node.default}`" if node.default else "required"
    if path == "simulate.until.figure":
        return Row(key, (), "a [column](columns.md) with a star", default, node.text)
    if path.startswith("joints.") and path.endswith(".journal"):
        return Row(key, (), "a body of the joint", "-", node.text)
    if path in ("life.joint", f"loads.{ANY}.on"):
        return Row(key, (), "a name", "required", node.text)
    if any(ANY in option for option in node.options) or not any(node.options):
        return Row(key, (), "a name", "-", node.text)
    return Row(key, (), "", default, node.text, options=tuple(filter(None, node.options)))


def _list(tree: Shape, path: str, key: str, section: Section) -> Row:
    """Return the row of a list, from its items."""
    nodes = [tree[f"{path}.{k}"] for k in range(section.items)]
    rows = [next(_quantity(tree, path, key, node)) for node in nodes if isinstance(node, Number)]
    allowed = f"{ITEMS[section.items]} {'names' if not rows else ', each ' + rows[0].allowed}".replace(" ,", ",")
    allowed += ", or one quantity" if section.alone else ""
    example = f"[{', '.join([rows[0].example] * section.items)}]" if rows else ""
    defaults = list(dict.fromkeys(row.default for row in rows))
    default = "required" if section.need == "required" else "-"
    default = defaults[0] if section.need == "implied" and len(defaults) == 1 else default
    return Row(key, rows[0].units if rows else (), allowed, default, section.text, example=example)


def _quantity(tree: Shape, path: str, key: str, node: Number) -> Iterator[Row]:
    """Yield a row for each meaning of a quantity, with the laws for which it has that meaning."""
    meanings: dict[Field, list[str]] = {}
    elastic = tree.get(f"{'.'.join(path.split('.')[:2])}.contact.elastic")
    for field, when in node.uses:
        always = not when or (isinstance(elastic, Word) and when == elastic.when)
        always = always or when[-1][0].endswith(".coefficient_unit")  # it only decides the unit
        meanings.setdefault(field, []).extend(() if always else sorted(when[-1][1]))
    for field, laws in meanings.items():
        default = "-" if field.optional else "required"
        default = default if field.default is None else _number(field.default)
        text = _of_body(path, field.text)
        unit = "" if field.unit == "1" else field.unit
        text = text if node.sweep else f"{text}; *fixed*"
        yield Row(key, (unit,), _range(field), default, text, tuple(laws), example=_example(field))


def _of_body(path: str, text: str) -> str:
    """Return a text with the same wording for the materials of bearing and journal."""
    return re.sub(r"\bthe (bearing|journal)\b", "this body", text) if ".material." in path else text


def _example(field: Field) -> str:
    """Return an example value: the default, a usual value of the unit, or one within the range."""
    unit = quantity.exponent_of(field.unit, 1.5)
    if field.default == 0.0 and unit == "1" and field.contains(_SMALL):
        return _number(_SMALL)
    if not field.default and field.contains(quantity.read(quantity.example(unit), unit)):
        return quantity.example(unit)
    ends = [end for end in (field.low, field.high) if math.isfinite(end)]
    numbers = (field.default, sum(ends) / 2.0, field.low + 1.0, field.high - 1.0)
    value = next((number for number in numbers if number and field.contains(number)), 0.0)
    return _number(value) if unit in ("1", "") else f"{_number(value)} {unit}"


def _number(value: float) -> str:
    """Return a number as text; powers of ten as such."""
    text = f"{value:g}" if float(f"{value:g}") == value else f"{value:.15g}"
    return re.sub(r"e\+?(-?)0?(\d)", r"e\1\2", text)


def _range(field: Field) -> str:
    """Return the range of a key in a few words."""
    low, high = _number(field.low), _number(field.high)
    if field.low == -math.inf:
        text = "any"
    elif field.high == math.inf:
        text = f"above {low}" if field.low_open else f"at least {low}"
    elif field.low_open or field.high_open:
        text = f"{'above' if field.low_open else 'from'} {low}, {'below' if field.high_open else 'up to'} {high}"
    else:
        text = f"{low} to {high}"
    return f"whole, {text}" if field.whole else text
