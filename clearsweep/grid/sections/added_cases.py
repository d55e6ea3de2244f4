"""Sections that add cases to a grid: `seek`, `refine`, `optimise`, `identify` and `check_laws`.

A run adds the cases and stores them in run.json.
"""

from collections.abc import Collection, Mapping
from typing import Any

from ...language.errors import shown
from ..keys.kinds import Word, value_key
from ..written.document import WrittenValue
from .reader import Reader
from .section import ADDED, KeySection, section_in


def find_added_cases(reader: Reader, root: WrittenValue, sections: tuple[str, ...]) -> None:
    """Record the added cases that one of these sections lists."""
    for name in sections:
        section = section_in(root, name)
        written = section.value.get(ADDED) if section is not None and isinstance(section.value, dict) else None
        if written is None:
            continue
        if isinstance(written.value, dict):
            reader.added_in, reader.added_written = f"{name}.{ADDED}", dict(written.value)
        else:
            reader.problems.add(written, f"{name}.{ADDED}", "is filled in by a run in run.json; remove the key")


def added_rows(reader: Reader) -> tuple[tuple[Any, ...], ...]:
    """Return the values of every added case, in the order of the axes."""
    if not reader.added_written:
        return ()
    values = [reader.added_cases.get(path, []) for path in reader.axes]
    if set(reader.added_written) != set(reader.axes) or len(set(map(len, values))) > 1:
        place = next(iter(reader.added_written.values()))
        reader.problems.add(place, reader.added_in, "lacks a value of a swept path for some case; remove the key")
        return ()
    return tuple(zip(*values, strict=True))


def over_of(
    reader: Reader, root: WrittenValue, section: WrittenValue, table: KeySection, others: Collection[str]
) -> WrittenValue | None:
    """Return `over` of a section that chooses all cases; None if it is missing or another section chooses, too."""
    for other in others:
        if other in root.value:
            sentence = f"conflicts with `{other}`; `{table.name}` chooses all cases itself; remove one of the two"
            reader.problems.add(section, table.name, sentence)
            return None
    over: WrittenValue | None = section.value.get("over")
    if over is None or not isinstance(over.value, dict) or not over.value:
        sentence = f"is empty; name at least one key to vary, for example: {table.example}"
        reader.problems.add(over or section, f"{table.name}.over", sentence)
        return None
    return over


def check_always_used(reader: Reader, place: WrittenValue, section: str, path: str) -> None:
    """Report a swept key that some of the swept laws do not use: every added case has a value of each key."""
    node = value_key(reader.shape, path)
    if isinstance(node, Word):
        return
    for chooser in node.choosers():
        for law in reader.axes.get(chooser, ()):
            if not node.used(reader.names | {chooser: frozenset({law})}):
                sentence = f"{path} is not used by {law}; with `{section}` every law that is tried must use every key"
                reader.problems.add(place, section, f"{sentence} that is swept")
                return


CHECK_LAWS = "check_laws"
CHECK_LAWS_TEXT = (
    "true: the deciding case runs again under each other elastic and contact law that is valid in its joints"
)
_CHECKED = (".contact.elastic", ".contact.law")
_CONFLICTS = ("seek", "refine", "optimise", "identify")


def read_check_laws(reader: Reader, root: WrittenValue) -> None:
    """Note whether laws are checked; that is written as true, or as run.json has it, with the cases that were added."""
    written = root.value.get(CHECK_LAWS) if isinstance(root.value, dict) else None
    if written is None or written.value is False:
        return
    section = isinstance(written.value, dict) and set(written.value) <= {ADDED}
    if written.value is not True and not section:
        reader.problems.add(written, CHECK_LAWS, f"found {shown(written.value)}; expected true or false")
        return
    for conflict in _CONFLICTS:
        if conflict in root.value:
            sentence = (
                f"conflicts with `{conflict}`, which adds cases, too; run its answer as a grid with `{CHECK_LAWS}`"
            )
            reader.problems.add(written, CHECK_LAWS, sentence)
    reader.check_laws = True


def put_law_axis(reader: Reader, path: str) -> None:
    """Make an axis of the law at `path`, which is read and not swept, so that other laws can be on it, too."""
    if reader.check_laws and path.endswith(_CHECKED) and path not in reader.swept and path in reader.values:
        location = reader.place(path)
        reader.swept[path] = WrittenValue(reader.values[path], location.origin, location.line, location.column)
        reader.varied_by[path] = "sweep"
        reader.axes[path] = (reader.values.pop(path),)
        if path in reader.added_written:
            reader.added_cases[path] = [item.value for item in reader.added_written[path].value]


def checked_law_paths(reader: Reader) -> tuple[str, ...]:
    """Return the paths of the laws that are checked."""
    swept = (path for path, node in reader.shape.items() if isinstance(node, Word) and path.endswith(_CHECKED))
    return tuple(path for path in swept if reader.check_laws and len(reader.axes.get(path, ())) == 1)


def base_laws(record: Mapping[str, Any]) -> dict[str, str]:
    """Return path -> law of the grid, of the laws that a run checks, by its run.json; {} where it checks none."""
    if not record.get(CHECK_LAWS):
        return {}
    sweep = record.get("sweep") or {}
    return {path: laws[0] for path, laws in sweep.items() if path.endswith(_CHECKED) and len(laws) == 1}
