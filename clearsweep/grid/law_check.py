"""Reads `check_laws`: the deciding case of a run is to run again under the other laws that hold in its joints."""

from collections.abc import Mapping
from typing import Any

from ..language.errors import shown
from .added_cases import ADDED
from .document import WrittenValue
from .keys import Word
from .reader import Reader

CHECK = "check_laws"
TEXT = "true: the deciding case runs again under each other elastic and contact law that is valid in its joints"
_CHECKED = (".contact.elastic", ".contact.law")
_CONFLICTS = ("seek", "refine", "optimise", "identify")


def read(reader: Reader, root: WrittenValue) -> None:
    """Note whether laws are checked; that is written as true, or as run.json has it, with the cases that were added."""
    written = root.value.get(CHECK) if isinstance(root.value, dict) else None
    if written is None or written.value is False:
        return
    section = isinstance(written.value, dict) and set(written.value) <= {ADDED}
    if written.value is not True and not section:
        reader.problems.add(written, CHECK, f"found {shown(written.value)}; expected true or false")
        return
    for conflict in _CONFLICTS:
        if conflict in root.value:
            sentence = f"conflicts with `{conflict}`, which adds cases, too; run its answer as a grid with `{CHECK}`"
            reader.problems.add(written, CHECK, sentence)
    reader.check_laws = True


def put_axis(reader: Reader, path: str) -> None:
    """Make an axis of the law at `path`, which is read and not swept, so that other laws can be on it, too."""
    if reader.check_laws and path.endswith(_CHECKED) and path not in reader.swept and path in reader.values:
        location = reader.place(path)
        reader.swept[path] = WrittenValue(reader.values[path], location.origin, location.line, location.column)
        reader.way[path] = "sweep"
        reader.axes[path] = (reader.values.pop(path),)
        if path in reader.added_written:
            reader.added_cases[path] = [item.value for item in reader.added_written[path].value]


def paths(reader: Reader) -> tuple[str, ...]:
    """Return the paths of the laws that are checked."""
    swept = (path for path, node in reader.shape.items() if isinstance(node, Word) and path.endswith(_CHECKED))
    return tuple(path for path in swept if reader.check_laws and len(reader.axes.get(path, ())) == 1)


def base_laws(record: Mapping[str, Any]) -> dict[str, str]:
    """Return path -> law of the grid, of the laws that a run checks, by its run.json; {} where it checks none."""
    if not record.get(CHECK):
        return {}
    sweep = record.get("sweep") or {}
    return {path: laws[0] for path, laws in sweep.items() if path.endswith(_CHECKED) and len(laws) == 1}
