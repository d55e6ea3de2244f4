"""Describes keys for `clearsweep list KEY`, the sections that choose cases, and the page of all keys."""

import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from functools import cache

from ...contracts.catalogue import ANY, Catalogue
from ..keys import Word
from ..keys.outline import KeyTree, key_trees
from ..sections.axes import DESIGNS, SAMPLE_SECTION, SPACING_FORMS
from ..sections.distributions import parameter_forms
from ..sections.fits import DISTRIBUTION_FORM
from .reference import IN_SPACE_TEXT, PageSection, Row, page_sections, quoted
from .schema import NAME_SECTIONS, whole_schema

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
_INDENT = 12  # characters before the second column
_EXAMPLE_JOINT, _EXAMPLE_LOAD = "rod-slider", "press"  # replaces NAME in an example


def key_text(name: str, catalogue: Catalogue) -> str | None:
    """Return the description of the key `name`, a path or the end of one, or None if there is no such key.

    Paths of a grid (`joints.rod-slider.clearance`) and of the page (`joints.NAME.clearance`) both match.
    """
    sections = page_sections(catalogue)
    keys = [(path, row) for section in sections for path in section.paths for row in section.rows]
    requested = name.split(".")
    matches_of_paths = {path: _match_kind(path.split("."), requested) for section in sections for path in section.paths}
    rows = [(_match_kind([*path.split("."), *row.key.split(".")], requested), path, row) for path, row in keys]
    if not any(matches_of_paths.values()) and not any(match_kind for match_kind, *_ in rows):
        rows = [("end" if name in row.options and row.key == "type" else "", path, row) for path, row in keys]
    has_exact_match = any(
        match_kind == "all" for match_kind in (*matches_of_paths.values(), *(match_kind for match_kind, *_ in rows))
    )
    accepted = ("all",) if has_exact_match else ("all", "end")
    blocks: dict[str, list[str]] = {}  # text -> its paths
    for section in sections:
        if matches := [path for path in section.paths if matches_of_paths[path] in accepted]:
            blocks.setdefault(_section_text(section), []).extend(
                _with_requested_names(path, requested) for path in matches
            )
    examples: dict[str, str] = {}  # of the first path
    for match_kind, path, row in rows:
        if match_kind in accepted:
            facts = _key_facts(row)
            examples.setdefault(facts, _example(path, row, requested))
            blocks.setdefault(facts, []).append(_with_requested_names(f"{path}.{row.key}", requested))
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
    lines = [
        textwrap.fill(
            _without_markdown(row.text),
            WIDTH,
            initial_indent=f"  {row.key:{width}}",
            subsequent_indent=" " * (width + 2),
        )
        for row in section.rows
    ]
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
        rows = [
            textwrap.fill(
                _without_markdown(text), WIDTH, initial_indent=f"  {name:{width}}", subsequent_indent=" " * (width + 2)
            )
            for name, text in choices.items()
        ]
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


def _fact_line(heading: str, text: str) -> str:
    """Return a fact as a line that begins with its name."""
    return textwrap.fill(
        text,
        WIDTH,
        initial_indent=f"  {heading:{_INDENT - 2}}",
        subsequent_indent=" " * _INDENT,
        break_on_hyphens=False,
        break_long_words=False,
    )


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
