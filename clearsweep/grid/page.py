"""Writes the page of all keys."""

from collections.abc import Iterable, Iterator

from ..contracts.catalogue import Catalogue
from . import choosing
from .key_trees import KeyTree, key_trees
from .keys import Word
from .reference import SPACE, quoted, parts

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


def markdown(catalogue: Catalogue) -> str:
    """Return the page in Markdown: every key with unit, range, default and meaning."""
    lines = [_HEAD, *_overview(key_trees(catalogue, slots=True))]
    for part in parts(catalogue):
        lines += [f"## {quoted(part.paths)}\n", f"{part.text}\n", _TABLE, *map(str, part.rows), ""]
    return "\n".join([*lines, choosing.markdown(catalogue)])


def _overview(trees: Iterable[KeyTree]) -> Iterator[str]:
    """Yield a table of the mechanisms and their joints that may have clearance."""
    yield "| mechanism | joints that may have clearance (body of the journal) |\n| --- | --- |"
    for tree in trees:
        names = []
        for joint, kind in tree.joints.items():
            journal = tree.keys.get(f"joints.{joint}.journal")
            body = journal.default if isinstance(journal, Word) and journal.default else ""
            names.append(f"`{joint}` ({body})" if body else f"`{joint}`" + (", a guide" if kind == "guide" else ""))
        if set(tree.joints.values()) != {"slot"}:
            yield f"| {tree.mechanism}{f' {SPACE}' if tree.spatial else ''} | {', '.join(names)} |"
    yield ""
