"""The page of all grid keys, generated from the key table."""

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from typing import NamedTuple

from ...contracts.catalogue import ANY, Catalogue, Field
from ...language import quantity
from ..keys import COUNT_WORDS, Flag, KeyTable, Name, NameList, Number, Section, Table, Word
from ..keys.outline import KeyTree, key_trees

_JOINT_PATH = f"joints.{ANY}"
#: Sections with the keys of another section: path -> path of the other, and whose keys they are.
_SAME_KEYS = {
    f"{_JOINT_PATH}.axial": (f"{_JOINT_PATH}.contact", "flange"),
    f"loads.{ANY}.friction": (f"{_JOINT_PATH}.friction", "load"),
}
_JOINT_NAMES = {
    "revolute": "pin",
    "guide": "guide",
    "slot": "slot",
    "line": "impact-pair",
    ANY: "pin",
    "rolling": "rolling bearing",
    "gear": "gear",
    "coupling": "coupling",
    "stops": "stopped pin",
    "guide_stops": "stopped guide",
}
IN_SPACE_TEXT = "in space"
_SMALL_SHARE = 0.05  # example of a share that is usually left out
_WITHOUT_SECTION = "Without this section"  # begins the sentence on the effect of leaving out an optional section
_NEED_SENTENCES = {"required": "This section is required", "optional": "This section is optional", "": ""}


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


_SectionsByOwner = dict[str, tuple[Section, tuple[Row, ...]]]  # mechanism or kind of joint -> a section and its rows


def quoted(names: Iterable[str]) -> str:
    """Return words as a list in code font."""
    return ", ".join(f"`{name}`" for name in names)


class PageSection(NamedTuple):
    """A part of the page: one section of a grid file, or several with the same keys."""

    paths: tuple[str, ...]  # as on the page: `joints.NAME.contact`
    text: str  # what it is
    rows: tuple[Row, ...]


@cache
def page_sections(catalogue: Catalogue) -> tuple[PageSection, ...]:
    """Return every section of a grid file with its keys, in page order, except those that choose cases.

    A section that several mechanisms or joints share appears once; a row names its owners unless all have it.
    """
    sections: dict[str, _SectionsByOwner] = {}
    for tree in key_trees(catalogue, slots=True):
        for path, key in tree.keys.items():
            if isinstance(key, Section) and not key.items and (rows := tuple(_section_rows(tree.keys, path))):
                page_path, owner = _page_path(tree, path)
                sections.setdefault(page_path, {}).setdefault(owner, (key, rows))
    paths_by_rows: dict[tuple[Row, ...], list[str]] = {}
    top_sections = list(dict.fromkeys(path.partition(".")[0] for path in sections))
    for path, sections_by_owner in sorted(
        sections.items(), key=lambda item: top_sections.index(item[0].partition(".")[0])
    ):
        paths_by_rows.setdefault(tuple(_merged_rows(sections_by_owner)), []).append(path)
    merged_sections = []
    for rows, paths in paths_by_rows.items():
        alias_paths = [alias for alias, (path, _) in _SAME_KEYS.items() if path in paths]
        merged_sections.append(
            PageSection((*paths, *alias_paths), _sentences({path: sections[path] for path in paths}), rows)
        )
    return tuple(merged_sections)


def _page_path(tree: KeyTree, path: str) -> tuple[str, str]:
    """Return the path of a section on the page, and the mechanism or kind of joint that it belongs to."""
    owner = f"{tree.mechanism} {IN_SPACE_TEXT}" if tree.spatial else tree.mechanism
    root, _, remainder = path.partition(".")
    if root == "joints" and remainder:
        joint, _, path_in_joint = remainder.partition(".")
        owner = IN_SPACE_TEXT if tree.spatial else _JOINT_NAMES[tree.joints[joint]]
        path = f"{_JOINT_PATH}.{path_in_joint}" if path_in_joint else _JOINT_PATH
    return _SAME_KEYS.get(path, (path, owner))


def _merged_rows(sections_by_owner: _SectionsByOwner) -> Iterator[Row]:
    """Yield the rows of a section; a row that only some mechanisms or joints have names them.

    Rows that differ only in units, laws or options are merged; the row of `law` lists the laws of each joint.
    """
    rows: dict[Row, dict[str, list[Row]]] = {}
    for owner, (_, owner_rows) in sections_by_owner.items():
        for row in owner_rows:
            rows.setdefault(row._replace(units=(), laws=(), options=(), example=""), {}).setdefault(owner, []).append(
                row
            )
    order, all_laws = list(dict.fromkeys(row.key for row in rows)), tuple[str, ...]()
    for row, owners in sorted(rows.items(), key=lambda item: order.index(item[0].key)):
        all_rows = [item for owner_rows in owners.values() for item in owner_rows]
        units = tuple(dict.fromkeys(unit for item in all_rows for unit in item.units))
        laws = (
            tuple(dict.fromkeys(law for item in all_rows for law in item.laws))
            if all(item.laws for item in all_rows)
            else ()
        )
        options = tuple(dict.fromkeys(name for item in all_rows for name in item.options))
        all_laws = options if row.key == "law" else all_laws
        text = f"{_laws_text(laws, all_laws)}: {row.text}" if laws else row.text
        owners_by_missing_options: dict[tuple[str, ...], list[str]] = {}
        for owner, rows_of_owner in owners.items():
            owners_by_missing_options.setdefault(
                tuple(name for name in options if name not in rows_of_owner[0].options), []
            ).append(owner)
        for names, owners_lacking in owners_by_missing_options.items():
            text += f"; *{_owners_text(owners_lacking, owners)}*: all but {quoted(names)}" if names else ""
        owners_with_law = {
            owner
            for owner, (_, owner_rows) in sections_by_owner.items()
            if any({*laws} & {*item.options} for item in owner_rows)
        }
        # the row of `law` says which joints have a law
        owners_text = "" if owners_with_law == set(owners) else _owners_text(owners, sections_by_owner)
        text = f"*{owners_text}*: {text}" if owners_text else text
        yield row._replace(units=units, text=text, options=options, example=all_rows[0].example)


def _laws_text(laws: Collection[str], all_laws: Collection[str]) -> str:
    """Return the names of the laws with a key; if most laws of a section have it, the names of those without it."""
    other_laws = [name for name in all_laws if name not in laws]
    if other_laws and len(other_laws) < len(laws) and {*laws} <= {*all_laws}:
        return f"all but {quoted(other_laws)}"
    return "all" if {*laws} == {*all_laws} else quoted(laws)


def _owners_text(owners: Collection[str], all_owners: Collection[str]) -> str:
    """Return in words which owners have a row, or '' if all owners have it."""
    if len(owners) == len(all_owners):
        return ""
    in_space = {owner for owner in all_owners if owner.endswith(IN_SPACE_TEXT)}
    in_plane = set(all_owners) - in_space - {"impact-pair"}
    for group, text in (
        (in_space, IN_SPACE_TEXT),
        (in_plane, "in the plane"),
        (set(all_owners) - in_space, f"not {IN_SPACE_TEXT}"),
    ):
        if set(owners) == group:
            return text
    other_owners = [owner for owner in all_owners if owner not in owners]
    return f"not {', '.join(other_owners)}" if len(other_owners) < len(owners) else ", ".join(owners)


def _sentences(sections: Mapping[str, _SectionsByOwner]) -> str:
    """Return sentences on the meaning of sections with the same keys, and on whether they are required."""
    texts: dict[tuple[str, str], None] = {}
    for path, sections_by_owner in sections.items():
        owners_by_text: dict[tuple[str, str], list[str]] = {}
        for owner, (section, _) in sections_by_owner.items():
            need = "required" if section.need == "required" else "" if _WITHOUT_SECTION in section.text else "optional"
            text = "" if _only_repeats_path(section.text, path) else _with_neutral_body(path, section.text)
            owners_by_text.setdefault((text, need), []).append(owner)
        for (text, need), owners in owners_by_text.items():
            owners_text = _owners_text(owners, sections_by_owner)
            texts[f"*{owners_text}*: {_capitalised(text)}" if owners_text and text else _capitalised(text), need] = None
    needs = {need for _, need in texts}
    shared_needs = [_NEED_SENTENCES[need] for need in needs if len(needs) == 1]
    lines = [f"{text} ({need})" if text and need and not shared_needs else text for text, need in texts]
    return " ".join(f"{line}." for line in (*lines, *shared_needs) if line)


def _only_repeats_path(text: str, path: str) -> bool:
    """Return whether the text of a section says no more than its path: "the crank" of `mechanism.crank`."""
    return text.partition(" ")[2] == path.rpartition(".")[2]


def _capitalised(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]


def _section_rows(key_table: KeyTable, path: str) -> Iterator[Row]:
    """Yield the rows of the keys directly in the section at `path`; a list is one row."""
    for nested, key in key_table.items():
        parent, _, key_name = nested.rpartition(".")
        if isinstance(key_table.get(parent), Number):  # a quantity, or a section that replaces it
            parent, _, parent_key = parent.rpartition(".")
            key_name = f"{parent_key}.{key_name}"
        if parent != path:
            continue
        if isinstance(key, Section):
            if key.items:
                yield _list_row(key_table, nested, key_name, key)
        elif isinstance(key, Table):
            columns = ", ".join(f"`{field.name}` ({field.unit})" for field in key.columns[2] + key.columns[3])
            yield Row(key_name, (), f".csv: {columns}", "-", key.columns.text)
        elif isinstance(key, Name):
            yield Row(key_name, (), "a name" if key.options else "a text", "-", _with_neutral_body(nested, key.text))
        elif isinstance(key, Flag):
            default = "`true`" if key.default else "`false`"
            yield Row(key_name, (), "`true`, `false`", default, key.text)
        elif isinstance(key, NameList):
            yield Row(key_name, (), f"{key.noun}", "-", key.text, example=key.example)
        elif isinstance(key, Word):
            yield _word_row(nested, key_name, key)
        else:
            yield from _quantity_rows(key_table, nested, key_name, key)


def _word_row(path: str, key_name: str, key: Word) -> Row:
    """Return the row of a word."""
    default = f"`{key.default}`" if key.default else "required"
    if path == "simulate.until.figure":
        return Row(key_name, (), "a [column](columns.md) with a star", default, key.text)
    if path.startswith("joints.") and path.endswith(".journal"):
        return Row(key_name, (), "a body of the joint", "-", key.text)
    if path in ("life.joint", f"loads.{ANY}.on"):
        return Row(key_name, (), "a name", "required", key.text)
    if any(ANY in option for option in key.options) or not any(key.options):
        return Row(key_name, (), "a name", "-", key.text)
    return Row(key_name, (), "", default, key.text, options=tuple(filter(None, key.options)))


def _list_row(key_table: KeyTable, path: str, key_name: str, section: Section) -> Row:
    """Return the row of a list, from its items."""
    keys = [key_table[f"{path}.{k}"] for k in range(section.items)]
    rows = [next(_quantity_rows(key_table, path, key_name, key)) for key in keys if isinstance(key, Number)]
    allowed_text = f"{COUNT_WORDS[section.items]} {'names' if not rows else ', each ' + rows[0].allowed}".replace(
        " ,", ","
    )
    allowed_text += ", or one quantity" if section.scalar_factors else ""
    example = f"[{', '.join([rows[0].example] * section.items)}]" if rows else ""
    defaults = list(dict.fromkeys(row.default for row in rows))
    default = "required" if section.need == "required" else "-"
    default = defaults[0] if section.need == "implied" and len(defaults) == 1 else default
    return Row(key_name, rows[0].units if rows else (), allowed_text, default, section.text, example=example)


def _quantity_rows(key_table: KeyTable, path: str, key_name: str, key: Number) -> Iterator[Row]:
    """Yield a row for each meaning of a quantity, with the laws for which it has that meaning."""
    meanings: dict[Field, list[str]] = {}
    elastic = key_table.get(f"{'.'.join(path.split('.')[:2])}.contact.elastic")
    for field, when in key.uses:
        is_always = not when or (isinstance(elastic, Word) and when == elastic.when)
        is_always = is_always or when[-1][0].endswith(".coefficient_unit")  # it only decides the unit
        meanings.setdefault(field, []).extend(() if is_always else sorted(when[-1][1]))
    for field, laws in meanings.items():
        default = "-" if field.optional else "required"
        default = default if field.default is None else _number_text(field.default)
        text = _with_neutral_body(path, field.text)
        unit = "" if field.unit == "1" else field.unit
        text = text if key.sweep else f"{text}; *fixed*"
        yield Row(key_name, (unit,), _range_text(field), default, text, tuple(laws), example=_example_value(field))


def _with_neutral_body(path: str, text: str) -> str:
    """Return a text with the same wording for the materials of bearing and journal."""
    return re.sub(r"\bthe (bearing|journal)\b", "this body", text) if ".material." in path else text


def _example_value(field: Field) -> str:
    """Return an example value: the default, a usual value of the unit, or one within the range."""
    unit = quantity.replace_exponent(field.unit, 1.5)
    if field.default == 0.0 and unit == "1" and field.contains(_SMALL_SHARE):
        return _number_text(_SMALL_SHARE)
    if not field.default and field.contains(quantity.read(quantity.example_text(unit), unit)):
        return quantity.example_text(unit)
    bounds = [limit for limit in (field.low, field.high) if math.isfinite(limit)]
    numbers = (field.default, sum(bounds) / 2.0, field.low + 1.0, field.high - 1.0)
    value = next((number for number in numbers if number and field.contains(number)), 0.0)
    return _number_text(value) if unit in ("1", "") else f"{_number_text(value)} {unit}"


def _number_text(value: float) -> str:
    """Return a number as text; powers of ten as such."""
    text = f"{value:g}" if float(f"{value:g}") == value else f"{value:.15g}"
    return re.sub(r"e\+?(-?)0?(\d)", r"e\1\2", text)


def _range_text(field: Field) -> str:
    """Return the range of a key in a few words."""
    low, high = _number_text(field.low), _number_text(field.high)
    if field.low == -math.inf:
        text = "any but 0" if field.nonzero else "any"
    elif field.high == math.inf:
        text = f"above {low}" if field.low_open else f"at least {low}"
    elif field.low_open or field.high_open:
        text = f"{'above' if field.low_open else 'from'} {low}, {'below' if field.high_open else 'up to'} {high}"
    else:
        text = f"{low} to {high}"
    return f"whole, {text}" if field.integer else text
