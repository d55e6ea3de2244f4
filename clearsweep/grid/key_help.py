"""The text that `clearsweep list KEY` prints, from the same rows as the page of all keys."""

import re
import textwrap
from collections.abc import Iterator

from ..contracts.catalogue import Catalogue
from ..contracts.outline import ANY
from . import choosing
from .reference import Part, Row, parts
from .sampling import METHODS

WIDTH = 96  # characters in a line
_INDENT = 12  # characters before the second column
_JOINT, _LOAD = "rod-slider", "press"  # replaces NAME in an example


def key_text(name: str, catalogue: Catalogue) -> str | None:
    """Return the description of the key `name`, a path or the end of one, or None if there is no such key.

    Paths of a grid (`joints.rod-slider.clearance`) and of the page (`joints.NAME.clearance`) both match.
    """
    sections = parts(catalogue)
    keys = [(path, row) for section in sections for path in section.paths for row in section.rows]
    requested = name.split(".")
    places = {path: _length(path.split("."), requested) for section in sections for path in section.paths}
    rows = [(_length([*path.split("."), *row.key.split(".")], requested), path, row) for path, row in keys]
    exact = any(length == "all" for length in (*places.values(), *(length for length, *_ in rows)))
    fitting = ("all",) if exact else ("all", "end")
    blocks: dict[str, list[str]] = {}  # text -> its paths
    for section in sections:
        if matches := [path for path in section.paths if places[path] in fitting]:
            blocks.setdefault(_section(section), []).extend(_named(path, requested) for path in matches)
    examples: dict[str, str] = {}  # of the first path
    for length, path, row in rows:
        if length in fitting:
            facts = _key(row)
            examples.setdefault(facts, _example(path, row, requested))
            blocks.setdefault(facts, []).append(_named(f"{path}.{row.key}", requested))
    texts: dict[str, list[str]] = {}
    for text, paths in blocks.items():
        example = examples.get(text)
        complete = f"{text}\n{_line('example', example)}" if example else text
        texts.setdefault(", ".join(dict.fromkeys(paths)), []).append(complete)
    lines = [heading + "\n" + "\n\n".join(matches) for heading, matches in texts.items()]
    return "\n\n".join([*lines, *_choosing(name, catalogue)]) or None


def key_names(catalogue: Catalogue) -> tuple[str, ...]:
    """Return the last parts of all paths that `key_text` accepts, and the sections."""
    sections = parts(catalogue)
    paths = [path for section in sections for path in section.paths]
    names_shown = [path.rpartition(".")[2] for path in paths] + [
        row.key for section in sections for row in section.rows
    ]
    other_keys = (*choosing.sections(catalogue), *(key for keys in choosing.KEYS.values() for key in keys))
    return tuple(dict.fromkeys((*names_shown, *other_keys)))


def _length(path: list[str], requested: list[str]) -> str:
    """Return 'all' if a name matches a whole path, with any word for NAME, 'end' if it matches its end, else ''."""
    if requested == path[-len(requested) :]:
        return "all" if len(requested) == len(path) else "end"
    complete = len(requested) == len(path) and all(
        part_name in (name, ANY) for name, part_name in zip(requested, path, strict=True)
    )
    return "all" if complete else ""


def _named(path: str, requested: list[str]) -> str:
    """Return a path of the page with the requested names in place of NAME."""
    names_shown = path.split(".")
    if len(names_shown) == len(requested):
        names_shown = [
            requested_name if part_name == ANY else part_name
            for part_name, requested_name in zip(names_shown, requested, strict=True)
        ]
    return ".".join(names_shown)


def _section(section: Part) -> str:
    """Return the description of a section, and a line for each of its keys."""
    width = max(len(row.key) for row in section.rows) + 2
    lines = [
        textwrap.fill(
            _plain(row.text), WIDTH, initial_indent=f"  {row.key:{width}}", subsequent_indent=" " * (width + 2)
        )
        for row in section.rows
    ]
    return "\n".join([*(textwrap.wrap(section.text, WIDTH, initial_indent="  ", subsequent_indent="  ")), "", *lines])


def _key(row: Row) -> str:
    """Return the facts about a key, one a line, without an example."""
    rows = {
        "meaning": _plain(row.text),
        "unit": " or ".join(unit or "1" for unit in row.units) if any(row.units) else "",
        "allowed": _plain(row.allowed or ", ".join(row.options)),
        "default": _plain("optional" if row.default == "-" else row.default),
    }
    return "\n".join(_line(heading, text) for heading, text in rows.items() if text)


def _example(path: str, row: Row, requested: list[str]) -> str:
    """Return an example of the key in a grid, or '' if its value depends on the grid."""
    value = row.example or (row.options[0] if row.options else "true" if row.allowed.startswith("`true`") else "")
    if not value:
        return ""
    names_shown = _named(f"{path}.{row.key}", requested).split(".")
    names = {"joints": _JOINT, "loads": _LOAD}
    names_shown = [names.get(names_shown[0], "link") if name == ANY else name for name in names_shown]
    return (
        "".join(f"{name}: {{" for name in names_shown[:-1])
        + f"{names_shown[-1]}: {value}"
        + "}" * (len(names_shown) - 1)
    )


def _choosing(name: str, catalogue: Catalogue) -> Iterator[str]:
    """Yield the description of a section that chooses cases, or of its keys."""
    texts = choosing.sections(catalogue)
    parent, _, key = name.rpartition(".")
    if name in texts:
        lines = [_line("meaning", _plain(texts[name])), _line("example", choosing.EXAMPLES[name])]
        choices = choosing.KEYS.get(name, {}) | (METHODS | choosing.SAMPLES if name == "sample" else {})
        choices |= choosing.AXES if name in ("sweep", "zip") else {}
        width = max(map(len, choices), default=0) + 2
        rows = [
            textwrap.fill(_plain(text), WIDTH, initial_indent=f"  {name:{width}}", subsequent_indent=" " * (width + 2))
            for name, text in choices.items()
        ]
        yield "\n".join([name, *lines, *([""] if rows else []), *rows])
    for section, keys in choosing.KEYS.items():
        if parent in ("", section) and key in keys and name not in texts:
            lines = [_line("meaning", _plain(keys[key])), _line("example", choosing.EXAMPLES[section])]
            yield "\n".join([f"{section}.{key}", *lines])
    for kinds, owner in ((choosing.AXES, "an axis"), (METHODS, "sample.method"), (choosing.SAMPLES, "sample.over")):
        if name in kinds:
            yield f"{name}, of {owner}\n{_line('meaning', _plain(kinds[name]))}"


def _line(heading: str, text: str) -> str:
    """Return a fact as a line that begins with its name."""
    return textwrap.fill(
        text,
        WIDTH,
        initial_indent=f"  {heading:{_INDENT - 2}}",
        subsequent_indent=" " * _INDENT,
        break_on_hyphens=False,
        break_long_words=False,
    )


def _plain(text: str) -> str:
    """Return a text of the page without Markdown."""
    return re.sub(r"\[(.*?)\]\(.*?\)", r"\1", text).translate(str.maketrans("", "", "`*"))
