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
    keys = [(path, row) for part in sections for path in part.paths for row in part.rows]
    wanted = name.split(".")
    places = {path: _length(path.split("."), wanted) for part in sections for path in part.paths}
    rows = [(_length([*path.split("."), *row.key.split(".")], wanted), path, row) for path, row in keys]
    exact = any(length == "all" for length in (*places.values(), *(length for length, *_ in rows)))
    fitting = ("all",) if exact else ("all", "end")
    blocks: dict[str, list[str]] = {}  # text -> its paths
    for part in sections:
        if own := [path for path in part.paths if places[path] in fitting]:
            blocks.setdefault(_section(part), []).extend(_named(path, wanted) for path in own)
    examples: dict[str, str] = {}  # of the first path
    for length, path, row in rows:
        if length in fitting:
            facts = _key(row)
            examples.setdefault(facts, _example(path, row, wanted))
            blocks.setdefault(facts, []).append(_named(f"{path}.{row.key}", wanted))
    texts: dict[str, list[str]] = {}
    for text, paths in blocks.items():
        example = examples.get(text)
        whole = f"{text}\n{_line('example', example)}" if example else text
        texts.setdefault(", ".join(dict.fromkeys(paths)), []).append(whole)
    lines = [head + "\n" + "\n\n".join(own) for head, own in texts.items()]
    return "\n\n".join([*lines, *_choosing(name, catalogue)]) or None


def key_names(catalogue: Catalogue) -> tuple[str, ...]:
    """Return the last parts of all paths that `key_text` accepts, and the sections."""
    sections = parts(catalogue)
    paths = [path for part in sections for path in part.paths]
    words = [path.rpartition(".")[2] for path in paths] + [row.key for part in sections for row in part.rows]
    others = (*choosing.sections(catalogue), *(key for keys in choosing.KEYS.values() for key in keys))
    return tuple(dict.fromkeys((*words, *others)))


def _length(path: list[str], wanted: list[str]) -> str:
    """Return 'all' if a name matches a whole path, with any word for NAME, 'end' if it matches its end, else ''."""
    if wanted == path[-len(wanted) :]:
        return "all" if len(wanted) == len(path) else "end"
    whole = len(wanted) == len(path) and all(known in (word, ANY) for word, known in zip(wanted, path, strict=True))
    return "all" if whole else ""


def _named(path: str, wanted: list[str]) -> str:
    """Return a path of the page with the requested names in place of NAME."""
    words = path.split(".")
    if len(words) == len(wanted):
        words = [there if known == ANY else known for known, there in zip(words, wanted, strict=True)]
    return ".".join(words)


def _section(part: Part) -> str:
    """Return the description of a section, and a line for each of its keys."""
    wide = max(len(row.key) for row in part.rows) + 2
    lines = [
        textwrap.fill(_plain(row.text), WIDTH, initial_indent=f"  {row.key:{wide}}", subsequent_indent=" " * (wide + 2))
        for row in part.rows
    ]
    return "\n".join([*(textwrap.wrap(part.text, WIDTH, initial_indent="  ", subsequent_indent="  ")), "", *lines])


def _key(row: Row) -> str:
    """Return the facts about a key, one a line, without an example."""
    facts = {
        "meaning": _plain(row.text),
        "unit": " or ".join(unit or "1" for unit in row.units) if any(row.units) else "",
        "allowed": _plain(row.allowed or ", ".join(row.options)),
        "default": _plain("optional" if row.default == "-" else row.default),
    }
    return "\n".join(_line(head, text) for head, text in facts.items() if text)


def _example(path: str, row: Row, wanted: list[str]) -> str:
    """Return an example of the key in a grid, or '' if its value depends on the grid."""
    value = row.example or (row.options[0] if row.options else "true" if row.allowed.startswith("`true`") else "")
    if not value:
        return ""
    words = _named(f"{path}.{row.key}", wanted).split(".")
    names = {"joints": _JOINT, "loads": _LOAD}
    words = [names.get(words[0], "link") if word == ANY else word for word in words]
    return "".join(f"{word}: {{" for word in words[:-1]) + f"{words[-1]}: {value}" + "}" * (len(words) - 1)


def _choosing(name: str, catalogue: Catalogue) -> Iterator[str]:
    """Yield the description of a section that chooses cases, or of its keys."""
    texts = choosing.sections(catalogue)
    above, _, key = name.rpartition(".")
    if name in texts:
        lines = [_line("meaning", _plain(texts[name])), _line("example", choosing.EXAMPLES[name])]
        further = choosing.KEYS.get(name, {}) | (METHODS | choosing.SAMPLES if name == "sample" else {})
        further |= choosing.AXES if name in ("sweep", "zip") else {}
        wide = max(map(len, further), default=0) + 2
        rows = [
            textwrap.fill(_plain(text), WIDTH, initial_indent=f"  {word:{wide}}", subsequent_indent=" " * (wide + 2))
            for word, text in further.items()
        ]
        yield "\n".join([name, *lines, *([""] if rows else []), *rows])
    for section, keys in choosing.KEYS.items():
        if above in ("", section) and key in keys and name not in texts:
            lines = [_line("meaning", _plain(keys[key])), _line("example", choosing.EXAMPLES[section])]
            yield "\n".join([f"{section}.{key}", *lines])
    for kinds, of in ((choosing.AXES, "an axis"), (METHODS, "sample.method"), (choosing.SAMPLES, "sample.over")):
        if name in kinds:
            yield f"{name}, of {of}\n{_line('meaning', _plain(kinds[name]))}"


def _line(head: str, text: str) -> str:
    """Return a fact as a line that begins with its name."""
    return textwrap.fill(
        text,
        WIDTH,
        initial_indent=f"  {head:{_INDENT - 2}}",
        subsequent_indent=" " * _INDENT,
        break_on_hyphens=False,
        break_long_words=False,
    )


def _plain(text: str) -> str:
    """Return a text of the page without Markdown."""
    return re.sub(r"\[(.*?)\]\(.*?\)", r"\1", text).translate(str.maketrans("", "", "`*"))
