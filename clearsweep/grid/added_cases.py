"""Reads the cases beside the product of a grid's axes, which `seek` and `refine` put there and run.json keeps."""

from typing import Any

from .document import WrittenValue
from .reader import Reader

ADDED = "added"  # in a section that adds cases: dotted path -> the values of the added cases


def find(reader: Reader, root: WrittenValue, sections: tuple[str, ...]) -> None:
    """Note what is written of added cases in one of these sections."""
    for name in sections:
        section = root.value.get(name) if isinstance(root.value, dict) else None
        written = section.value.get(ADDED) if section is not None and isinstance(section.value, dict) else None
        if written is None:
            continue
        if isinstance(written.value, dict):
            reader.added_in, reader.added_written = f"{name}.{ADDED}", dict(written.value)
        else:
            reader.problems.add(written, f"{name}.{ADDED}", "run.json keeps here what a run added; leave the key out")


def rows(reader: Reader) -> tuple[tuple[Any, ...], ...]:
    """Return the values of every added case, in the order of the axes."""
    if not reader.added_written:
        return ()
    values = [reader.added_cases.get(path, []) for path in reader.axes]
    if set(reader.added_written) != set(reader.axes) or len(set(map(len, values))) > 1:
        place = next(iter(reader.added_written.values()))
        reader.problems.add(place, reader.added_in, "has not a value of every swept path for every case; leave it out")
        return ()
    return tuple(zip(*values, strict=True))
