"""Reads a section written as a list of two or three quantities or names, or as one quantity for all."""

from ..language.errors import shown
from .axes import half_bare
from .document import WrittenValue
from .keys import ITEMS, Number, Section, Shape, Word
from .reader import Reader


def items(reader: Reader, written: WrittenValue, path: str, complete: Shape) -> dict[str, WrittenValue] | None:
    """Return the items of the list at `path` by index; None, with a problem, if they cannot be read."""
    section, content = complete[path], written.value
    assert isinstance(section, Section), path
    if isinstance(content, dict):  # an override of a single item
        content = list(content.values())
    if section.alone and isinstance(content, (str, int, float)):
        return {str(k): _scaled(written, factor) for k, factor in enumerate(section.alone)}
    if isinstance(content, list) and len(content) == section.items:
        first_key = complete.get(f"{path}.0")
        half_bare(reader.problems, path, content, first_key.uses[0].field.unit if isinstance(first_key, Number) else "")
        return {str(k): item for k, item in enumerate(content)}
    reader.problems.add(written, path, f"found {shown(content)}; expected {_listed(complete, path, section)}")
    reader.broken.add(path)
    return None


def _listed(complete: Shape, path: str, section: Section) -> str:
    """Return a description of the list expected at `path`."""
    first_key, count = complete.get(f"{path}.0"), ITEMS[section.items]
    if isinstance(first_key, Word):
        return f"a list of {count} names, such as [ground, crank]"
    if section.items == 2:
        return "a list of two quantities, such as [0.2 kg, 0.2 kg]"
    assert isinstance(first_key, Number)
    unit = first_key.uses[0].field.unit
    prefix = "one quantity, or " if section.alone else ""
    return f"{prefix}a list of {count} quantities ({unit}), along x, y and z"


def _scaled(written: WrittenValue, factor: int) -> WrittenValue:
    """Return a written quantity times 1, 0 or -1."""
    value = written.value
    if factor == 0:
        value = 0
    elif factor < 0:
        value = -value if not isinstance(value, str) else value[1:] if value.startswith("-") else f"-{value}"
    return WrittenValue(value, written.origin, written.line, written.column)
