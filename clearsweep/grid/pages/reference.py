"""The page of all grid keys, generated from the key table."""

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from typing import NamedTuple

from ...contracts.catalogue import Catalogue, Field
from ...contracts.outline import ANY
from ...language import quantity
from ..keys.kinds import ITEMS, Flag, Name, NameList, Number, Section, Shape, Table, Word
from ..keys.outline import KeyTree, key_trees

_JOINT = f"joints.{ANY}"
#: Sections with the keys of another section: path -> path of the other, and whose keys they are.
_LIKE = {f"{_JOINT}.axial": (f"{_JOINT}.contact", "flange"), f"loads.{ANY}.friction": (f"{_JOINT}.friction", "load")}
_KINDS = {"revolute": "pin", "guide": "guide", "slot": "slot", "line": "impact-pair", ANY: "pin"}
SPACE = "in space"
_SMALL = 0.05  # example of a share that is usually left out
_WITHOUT = "Without this section"  # begins the sentence on the effect of leaving out an optional section
_NEED = {"required": "This section is required", "optional": "This section is optional", "": ""}


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
        cells = (f"`{self.key}`", units, self.allowed or quoted(self.options), self.default, self.text)
        return f"| {' | '.join(cell.replace('|', '&#124;').replace('<', '&lt;') for cell in cells)} |"


_Places = dict[str, tuple[Section, tuple[Row, ...]]]  # (mechanism or kind of joint, a section of it)


def quoted(names: Iterable[str]) -> str:
    """Return words as a list in code font."""
    return ", ".join(f"`{name}`" for name in names)


class Part(NamedTuple):
    """A part of the page: one section of a grid file, or several with the same keys."""

    paths: tuple[str, ...]  # as on the page: `joints.NAME.contact`
    text: str  # what it is
    rows: tuple[Row, ...]


@cache
def parts(catalogue: Catalogue) -> tuple[Part, ...]:
    """Return every section of a grid file with its keys, in page order, except those that choose cases.

    A section that several mechanisms or joints share appears once; a row names its owners unless all have it.
    """
    sections: dict[str, _Places] = {}
    for tree in key_trees(catalogue, slots=True):
        for path, node in tree.keys.items():
            if isinstance(node, Section) and not node.items and (rows := tuple(_rows(tree.keys, path))):
                common, machine = _common(tree, path)
                sections.setdefault(common, {}).setdefault(machine, (node, rows))
    equal_sections: dict[tuple[Row, ...], list[str]] = {}
    tops = list(dict.fromkeys(path.partition(".")[0] for path in sections))
    for path, places in sorted(sections.items(), key=lambda item: tops.index(item[0].partition(".")[0])):
        equal_sections.setdefault(tuple(_merged_rows(places)), []).append(path)
    pages = []
    for rows, paths in equal_sections.items():
        same_as = [other_name for other_name, (path, _) in _LIKE.items() if path in paths]
        pages.append(Part((*paths, *same_as), _sentences({path: sections[path] for path in paths}), rows))
    return tuple(pages)


def _common(tree: KeyTree, path: str) -> tuple[str, str]:
    """Return the path of a section on the page, and the mechanism or kind of joint that it belongs to."""
    machine = f"{tree.mechanism} {SPACE}" if tree.spatial else tree.mechanism
    root, _, remainder = path.partition(".")
    if root == "joints" and remainder:
        joint, _, inside = remainder.partition(".")
        machine = SPACE if tree.spatial else _KINDS[tree.joints[joint]]
        path = f"{_JOINT}.{inside}" if inside else _JOINT
    return _LIKE.get(path, (path, machine))


def _merged_rows(places: _Places) -> Iterator[Row]:
    """Yield the rows of a section; a row that only some mechanisms or joints have names them.

    Rows that differ only in units, laws or options are merged; the row of `law` lists the laws of each joint.
    """
    rows: dict[Row, dict[str, list[Row]]] = {}
    for machine, (_, machine_rows) in places.items():
        for row in machine_rows:
            rows.setdefault(row._replace(units=(), laws=(), options=(), example=""), {}).setdefault(machine, []).append(
                row
            )
    order, all_laws = list(dict.fromkeys(row.key for row in rows)), tuple[str, ...]()
    for row, owners in sorted(rows.items(), key=lambda item: order.index(item[0].key)):
        all_rows = [item for machine_rows in owners.values() for item in machine_rows]
        units = tuple(dict.fromkeys(unit for item in all_rows for unit in item.units))
        laws = (
            tuple(dict.fromkeys(law for item in all_rows for law in item.laws)) if all(r.laws for r in all_rows) else ()
        )
        options = tuple(dict.fromkeys(name for item in all_rows for name in item.options))
        all_laws = options if row.key == "law" else all_laws
        text = f"{_laws(laws, all_laws)}: {row.text}" if laws else row.text
        lacking: dict[tuple[str, ...], list[str]] = {}
        for machine, owner in owners.items():
            lacking.setdefault(tuple(name for name in options if name not in owner[0].options), []).append(machine)
        for names, owners_lacking in lacking.items():
            text += f"; *{_owners_text(owners_lacking, owners)}*: all but {quoted(names)}" if names else ""
        having = {
            machine
            for machine, (_, machine_rows) in places.items()
            if any({*laws} & {*item.options} for item in machine_rows)
        }
        only = (
            "" if having == set(owners) else _owners_text(owners, places)
        )  # the row of `law` says which joints have a law
        text = f"*{only}*: {text}" if only else text
        yield row._replace(units=units, text=text, options=options, example=all_rows[0].example)


def _laws(machine_rows: Collection[str], all_laws: Collection[str]) -> str:
    """Return the names of the laws with a key; if most laws of a section have it, the names of those without it."""
    other_places = [name for name in all_laws if name not in machine_rows]
    if other_places and len(other_places) < len(machine_rows) and {*machine_rows} <= {*all_laws}:
        return f"all but {quoted(other_places)}"
    return "all" if {*machine_rows} == {*all_laws} else quoted(machine_rows)


def _owners_text(owners: Collection[str], places: Collection[str]) -> str:
    """Return in words which owners have a row, or '' if all owners have it."""
    if len(owners) == len(places):
        return ""
    in_space = {machine for machine in places if machine.endswith(SPACE)}
    in_plane = set(places) - in_space - {"impact-pair"}
    for group, text in ((in_space, SPACE), (in_plane, "in the plane"), (set(places) - in_space, f"not {SPACE}")):
        if set(owners) == group:
            return text
    other_places = [machine for machine in places if machine not in owners]
    return f"not {', '.join(other_places)}" if len(other_places) < len(owners) else ", ".join(owners)


def _sentences(sections: Mapping[str, _Places]) -> str:
    """Return sentences on the meaning of sections with the same keys, and on whether they are required."""
    texts: dict[tuple[str, str], None] = {}
    for path, places in sections.items():
        owners_by_text: dict[tuple[str, str], list[str]] = {}
        for machine, (section, _) in places.items():
            need = "required" if section.need == "required" else "" if _WITHOUT in section.text else "optional"
            text = "" if _only_names(section.text, path) else _of_body(path, section.text)
            owners_by_text.setdefault((text, need), []).append(machine)
        for (text, need), machine_rows in owners_by_text.items():
            only = _owners_text(machine_rows, places)
            texts[f"*{only}*: {_capital(text)}" if only and text else _capital(text), need] = None
    needs = {need for _, need in texts}
    common = [_NEED[need] for need in needs if len(needs) == 1]
    lines = [f"{text} ({need})" if text and need and not common else text for text, need in texts]
    return " ".join(f"{line}." for line in (*lines, *common) if line)


def _only_names(text: str, path: str) -> bool:
    """Return whether the text of a section says no more than its path: "the crank" of `mechanism.crank`."""
    return text.partition(" ")[2] == path.rpartition(".")[2]


def _capital(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]


def _rows(tree: Shape, path: str) -> Iterator[Row]:
    """Yield the rows of the keys directly in the section at `path`; a list is one row."""
    for nested, node in tree.items():
        parent, _, key = nested.rpartition(".")
        if isinstance(tree.get(parent), Number):  # a quantity, or a section that replaces it
            parent, _, parent_key = parent.rpartition(".")
            key = f"{parent_key}.{key}"
        if parent != path:
            continue
        if isinstance(node, Section):
            if node.items:
                yield _list(tree, nested, key, node)
        elif isinstance(node, Table):
            columns = ", ".join(f"`{field.name}` ({field.unit})" for field in node.columns[2] + node.columns[3])
            yield Row(key, (), f".csv: {columns}", "-", node.columns.text)
        elif isinstance(node, Name):
            yield Row(key, (), "a name", "-", _of_body(nested, node.text))
        elif isinstance(node, Flag):
            default = "`true`" if node.default else "`false`"
            yield Row(key, (), "`true`, `false`", default, node.text)
        elif isinstance(node, NameList):
            yield Row(key, (), f"{node.noun}", "-", node.text, example=node.example)
        elif isinstance(node, Word):
            yield _word(nested, key, node)
        else:
            yield from _quantity(tree, nested, key, node)


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
    allowed_text = f"{ITEMS[section.items]} {'names' if not rows else ', each ' + rows[0].allowed}".replace(" ,", ",")
    allowed_text += ", or one quantity" if section.scalar_factors else ""
    example = f"[{', '.join([rows[0].example] * section.items)}]" if rows else ""
    defaults = list(dict.fromkeys(row.default for row in rows))
    default = "required" if section.need == "required" else "-"
    default = defaults[0] if section.need == "implied" and len(defaults) == 1 else default
    return Row(key, rows[0].units if rows else (), allowed_text, default, section.text, example=example)


def _quantity(tree: Shape, path: str, key: str, node: Number) -> Iterator[Row]:
    """Yield a row for each meaning of a quantity, with the laws for which it has that meaning."""
    meanings: dict[Field, list[str]] = {}
    elastic = tree.get(f"{'.'.join(path.split('.')[:2])}.contact.elastic")
    for field, when in node.uses:
        is_always = not when or (isinstance(elastic, Word) and when == elastic.when)
        is_always = is_always or when[-1][0].endswith(".coefficient_unit")  # it only decides the unit
        meanings.setdefault(field, []).extend(() if is_always else sorted(when[-1][1]))
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
    unit = quantity.with_exponent(field.unit, 1.5)
    if field.default == 0.0 and unit == "1" and field.contains(_SMALL):
        return _number(_SMALL)
    if not field.default and field.contains(quantity.read(quantity.example(unit), unit)):
        return quantity.example(unit)
    bounds = [edge for edge in (field.low, field.high) if math.isfinite(edge)]
    numbers = (field.default, sum(bounds) / 2.0, field.low + 1.0, field.high - 1.0)
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
