"""Texts generated from the keys: the page of all keys, and what `clearsweep list` says of one."""

import math
import re
import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from typing import NamedTuple

from ...answers.verdict import capitalise
from ...contracts.catalogue import ANY, Catalogue, Field
from ...language import quantity
from ..keys import COUNT_WORDS, Flag, KeyTable, Name, NameList, Number, Section, Table, Word
from ..keys.outline import KeyTree, key_trees
from ..sections.axes import DESIGNS, SAMPLE_SECTION, SPACING_FORMS, parameter_forms
from ..sections.fits import DISTRIBUTION_FORM
from .schema import NAME_SECTIONS, whole_schema

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
            repeats_path = section.text.partition(" ")[2] == path.rpartition(".")[2]  # "the crank" of mechanism.crank
            text = "" if repeats_path else _with_neutral_body(path, section.text)
            owners_by_text.setdefault((text, need), []).append(owner)
        for (text, need), owners in owners_by_text.items():
            owners_text = _owners_text(owners, sections_by_owner)
            texts[f"*{owners_text}*: {capitalise(text)}" if owners_text and text else capitalise(text), need] = None
    needs = {need for _, need in texts}
    shared_needs = [_NEED_SENTENCES[need] for need in needs if len(needs) == 1]
    lines = [f"{text} ({need})" if text and need and not shared_needs else text for text, need in texts]
    return " ".join(f"{line}." for line in (*lines, *shared_needs) if line)


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


_FIRST_SECTIONS = ("name", "extends", "laws", "define", "sweep", "zip", "cases", "sample")
_CASES_TEXT = (
    "table (.csv, .xlsx or .parquet) in the directory of the grid, with a column for each path and a row for each "
    "case, or {table: FILE, sheet: 1, columns: {HEADER: 'PATH [UNIT]'}, label: HEADER}. Columns of texts ride along"
)
AXIS_FORMS = {
    **SPACING_FORMS,
    "fits": "[H7/g6, H7/f7]: the mean radial clearances of fits of ISO 286",
    "groups": "[C2, CN, C3, C4]: the mean internal clearances of groups of ISO 5753-1, of rolling bearings",
}
LABELS_TEXT = """\
An axis of `sweep`, `zip` or `cases` may give its values labels: `{bronze: 3e-15 m^2/N, PTFE: 1e-15 m^2/N}`. Tables,
figures and sentences show them. The column of summary.parquet keeps the numbers, and its metadata the labels. A label
contains a letter. The words above and the names of distributions are reserved."""
SAMPLE_FORMS = {
    **parameter_forms(),
    "fit": f"{DISTRIBUTION_FORM}: a radial clearance between the limits of a fit",
    "group": "{group: C3}, or {group: C3, distribution: normal}: an internal clearance between the limits of a group",
}

#: Section -> its syntax, of those that are no search.
_EXAMPLES = {
    "name": "name: press-joint",
    "extends": "extends: base.yaml   # sections are merged key by key, other values replace those of base.yaml",
    "laws": "laws: my_laws.py   # in the folder of the grid; it runs after `clearsweep trust my_laws.py`",
    "define": "define: {play: 50 um}   # used as `clearance: = play`",
    "sweep": "sweep: {drive.speed: [1000 rpm, 3000 rpm], joints.rod-slider.clearance: {linspace: [20 um, 80 um, 4]}}",
    "zip": "zip: {mechanism.rod.length: [120 mm, 140 mm], mechanism.rod.mass: [0.21 kg, 0.24 kg]}",
    "cases": "cases: cases.csv",
    "sample": "sample: {method: sobol, n: 64, over: {joints.rod-slider.clearance: {uniform: [20 um, 80 um]}}}",
    "figures": "figures: {amplification: rod_slider_load_peak / rod_slider_force_peak_ideal}",
    "roles": "roles: {loads.return.stiffness: choice}",
    "limits": "limits: {rod_slider_force_peak: 5 kN, rod_slider_force_peak_ratio: {at_most: 3}}",
    "uncertain": "uncertain: {joints.rod-slider.wear.coefficient: {factor: 3}}",
}


def section_keys(catalogue: Catalogue) -> dict[str, dict[str, str]]:
    """Return the meaning of each key of the sections with keys of their own, by section."""
    sections = (SAMPLE_SECTION, *(search.keys for search in catalogue.searches if search.keys))
    return {
        section.name: {key.name: key.text for key in section.all_keys if not key.internal or section.adds_cases}
        for section in sections
    }


def section_examples(catalogue: Catalogue) -> dict[str, str]:
    """Return the syntax of each section."""
    return _EXAMPLES | {search.name: search.example for search in catalogue.searches}


@cache
def section_texts(catalogue: Catalogue) -> Mapping[str, str]:
    """Return section -> description, in the order of the page."""
    properties = whole_schema(catalogue)["properties"]
    keys = (
        *_FIRST_SECTIONS,
        *(section.name for section in NAME_SECTIONS),
        *(search.name for search in catalogue.searches),
    )
    texts = {key: properties[key].get("description", "") for key in keys}
    return texts | {"cases": _CASES_TEXT, "name": texts["name"].replace("<name>", "NAME")}


def sections_markdown(catalogue: Catalogue) -> str:
    """Return the last part of the page of keys: these sections."""
    keys = section_keys(catalogue)
    return "\n".join(
        [
            "## Choosing cases\n",
            *_two_columns("key", "meaning", section_texts(catalogue)),
            "\nAn axis is a list of values, or one of\n",
            *_two_columns("form", "contains", AXIS_FORMS),
            f"\n{LABELS_TEXT}",
            *(
                line
                for name in keys
                if name != "sample"
                for line in (f"\n### `{name}`\n", *_two_columns("key", "meaning", keys[name]))
            ),
            "\n### `sample`\n",
            *_two_columns("key", "meaning", keys["sample"]),
            "",
            *_two_columns("design", "what it draws", DESIGNS),
            "",
            *_two_columns("distribution", "contains", SAMPLE_FORMS),
            "",
        ]
    )


def _two_columns(first_heading: str, second_heading: str, rows: Mapping[str, str]) -> list[str]:
    return [
        f"| {first_heading} | {second_heading} |",
        "| --- | --- |",
        *(f"| `{key}` | {text} |" for key, text in rows.items()),
    ]


WIDTH = 96  # characters in a line
_EXAMPLE_JOINT, _EXAMPLE_LOAD = "rod-slider", "press"  # replaces NAME in an example


def key_text(name: str, catalogue: Catalogue) -> str | None:
    """Return the description of the key `name`, a path or the end of one, or None if there is no such key.

    Paths of a grid (`joints.rod-slider.clearance`) and of the page (`joints.NAME.clearance`) both match.
    """
    sections = page_sections(catalogue)
    keys = [(path, row) for section in sections for path in section.paths for row in section.rows]
    requested = name.split(".")
    described: list[tuple[str, str, PageSection | Row]] = [
        (path, path, section) for section in sections for path in section.paths
    ]
    described += [(f"{path}.{row.key}", path, row) for path, row in keys]
    kinds = [_match_kind(whole.split("."), requested) for whole, *_ in described]
    accepted = "all" if "all" in kinds else "end"
    matching = [part for part, kind in zip(described, kinds, strict=True) if kind == accepted]
    if not matching:
        about = [(path, row) for path, row in keys if name in row.options and row.key == "type"]
        about = about or [(path, row) for path, row in keys if re.search(rf"\b{re.escape(name)}\b", row.text)]
        matching = [(f"{path}.{row.key}", path, row) for path, row in about if len({row.key for _, row in about}) == 1]
    blocks: dict[str, list[str]] = {}  # text -> its paths
    examples: dict[str, str] = {}  # of the first path
    for whole, path, part in matching:
        text = _section_text(part) if isinstance(part, PageSection) else _key_facts(part)
        if isinstance(part, Row):
            examples.setdefault(text, _example(path, part, requested))
        blocks.setdefault(text, []).append(_with_requested_names(whole, requested))
    texts: dict[str, list[str]] = {}
    for text, paths in blocks.items():
        example = examples.get(text)
        with_example = f"{text}\n{_fact_line('example', example)}" if example else text
        texts.setdefault(", ".join(dict.fromkeys(paths)), []).append(with_example)
    lines = [paths_text + "\n" + "\n\n".join(matches) for paths_text, matches in texts.items()]
    return "\n\n".join([*lines, *_case_section_help(name, catalogue)]) or None


def key_names(catalogue: Catalogue) -> tuple[str, ...]:
    """Return the last parts of all paths that `key_text` accepts, and the sections."""
    sections = page_sections(catalogue)
    paths = [path for section in sections for path in section.paths]
    key_names = [path.rpartition(".")[2] for path in paths] + [row.key for section in sections for row in section.rows]
    other_keys = (*section_texts(catalogue), *(key for keys in section_keys(catalogue).values() for key in keys))
    return tuple(dict.fromkeys((*key_names, *other_keys)))


def _match_kind(path: list[str], requested: list[str]) -> str:
    """Return 'all' if a name matches a whole path (any word matches NAME), 'end' if it matches its end, else ''."""
    if requested == path[-len(requested) :]:
        return "all" if len(requested) == len(path) else "end"
    is_whole_path = len(requested) == len(path) and all(
        part_name in (name, ANY) for name, part_name in zip(requested, path, strict=True)
    )
    return "all" if is_whole_path else ""


def _with_requested_names(path: str, requested: list[str]) -> str:
    """Return a path of the page with the requested names in place of NAME."""
    path_names = path.split(".")
    if len(path_names) == len(requested):
        path_names = [
            requested_name if part_name == ANY else part_name
            for part_name, requested_name in zip(path_names, requested, strict=True)
        ]
    return ".".join(path_names)


def _section_text(section: PageSection) -> str:
    """Return the description of a section, and a line for each of its keys."""
    width = max(len(row.key) for row in section.rows) + 2
    lines = [_fact_line(row.key, _without_markdown(row.text), width) for row in section.rows]
    text = _without_markdown(section.text)
    return "\n".join([*(textwrap.wrap(text, WIDTH, initial_indent="  ", subsequent_indent="  ")), "", *lines])


def _key_facts(row: Row) -> str:
    """Return the facts about a key, one per line, without an example."""
    rows = {
        "meaning": _without_markdown(row.text),
        "unit": " or ".join(unit or "1" for unit in row.units) if any(row.units) else "",
        "allowed": _without_markdown(row.allowed or ", ".join(row.options)),
        "default": _without_markdown("optional" if row.default == "-" else row.default),
    }
    return "\n".join(_fact_line(heading, text) for heading, text in rows.items() if text)


def _example(path: str, row: Row, requested: list[str]) -> str:
    """Return an example of the key in a grid, or '' if its value depends on the grid."""
    value = row.example or (row.options[0] if row.options else "true" if row.allowed.startswith("`true`") else "")
    if not value:
        return ""
    path_names = _with_requested_names(f"{path}.{row.key}", requested).split(".")
    example_names = {"joints": _EXAMPLE_JOINT, "loads": _EXAMPLE_LOAD}
    path_names = [example_names.get(path_names[0], "link") if name == ANY else name for name in path_names]
    return (
        "".join(f"{name}: {{" for name in path_names[:-1]) + f"{path_names[-1]}: {value}" + "}" * (len(path_names) - 1)
    )


def _case_section_help(name: str, catalogue: Catalogue) -> Iterator[str]:
    """Yield the description of a section that chooses cases, or of its keys."""
    texts = section_texts(catalogue)
    parent, _, key = name.rpartition(".")
    if name in texts:
        example = section_examples(catalogue)[name]
        lines = [_fact_line("meaning", _without_markdown(texts[name])), _fact_line("example", example)]
        choices = section_keys(catalogue).get(name, {}) | (DESIGNS | SAMPLE_FORMS if name == "sample" else {})
        choices |= AXIS_FORMS if name in ("sweep", "zip") else {}
        width = max(map(len, choices), default=0) + 2
        rows = [_fact_line(choice, _without_markdown(text), width) for choice, text in choices.items()]
        yield "\n".join([name, *lines, *([""] if rows else []), *rows])
    for section, keys in section_keys(catalogue).items():
        if parent in ("", section) and key in keys and name not in texts:
            lines = [
                _fact_line("meaning", _without_markdown(keys[key])),
                _fact_line("example", section_examples(catalogue)[section]),
            ]
            yield "\n".join([f"{section}.{key}", *lines])
    for descriptions, owner in ((AXIS_FORMS, "an axis"), (DESIGNS, "sample.method"), (SAMPLE_FORMS, "sample.over")):
        if name in descriptions:
            yield f"{name}, of {owner}\n{_fact_line('meaning', _without_markdown(descriptions[name]))}"


def _fact_line(heading: str, text: str, width: int = 10) -> str:
    """Return a fact as a line that begins with its name, which has so many characters."""
    first, others = f"  {heading:{width}}", " " * (width + 2)
    wrapper = textwrap.TextWrapper(WIDTH, first, others, break_on_hyphens=False, break_long_words=False)
    return wrapper.fill(text)


def _without_markdown(text: str) -> str:
    """Return a text of the page without Markdown."""
    return re.sub(r"\[(.*?)\]\(.*?\)", r"\1", text).translate(str.maketrans("", "", "`*"))


_PAGE_HEAD = """\
# Keys of a grid file

<!-- written by `clearsweep schema --markdown`; a test compares -->

A grid file is YAML 1.2. `NAME` is a name that the grid chooses. A quantity is text with a unit (`0.5 mm`, `5000 rpm`)
or a bare number in the SI unit of the table; any unit of the same dimension is allowed. The quantities of one list all
have a unit, or none has; so have the lengths, masses, inertias and speeds of one file. In the column *default*,
*required* marks a key without a default, and a dash marks an optional key. Words in italics before a colon name the
mechanisms or joints that have a key; without such words, all have it. Names of laws before a colon name the laws that
use the key.

Sweeps may vary numbers, except those marked *fixed*, and names of laws. The items of a list have the paths `.0`, `.1`
and `.2`. `clearsweep list NAME` explains a law and its keys. `clearsweep schema` writes the same keys as a JSON Schema
for editors.
"""


_TABLE_HEAD = "| key | unit | allowed | default | meaning |\n| --- | --- | --- | --- | --- |"


def markdown(catalogue: Catalogue) -> str:
    """Return the page in Markdown: every key with unit, range, default and meaning."""
    lines = [_PAGE_HEAD, *_overview(key_trees(catalogue))]
    for section in page_sections(catalogue):
        lines += [f"## {quoted(section.paths)}\n", f"{section.text}\n", _TABLE_HEAD, *map(str, section.rows), ""]
    return "\n".join([*lines, sections_markdown(catalogue)])


def _overview(trees: Iterable[KeyTree]) -> Iterator[str]:
    """Yield a table of the mechanisms and their joints that may have clearance."""
    yield "| mechanism | joints that may have clearance (body of the journal) |\n| --- | --- |"
    for tree in trees:
        names = []
        for joint, kind in tree.joints.items():
            journal = tree.keys.get(f"joints.{joint}.journal")
            body = journal.default if isinstance(journal, Word) and journal.default else ""
            names.append(f"`{joint}` ({body})" if body else f"`{joint}`" + (", a guide" if kind == "guide" else ""))
        if "rolling" not in tree.joints.values():  # those of a pin again
            yield f"| {tree.mechanism}{f' {IN_SPACE_TEXT}' if tree.spatial else ''} | {', '.join(names)} |"
    yield ""
