"""Reads axes whose values have names of the user's own, `{bronze: 3e-15 m^2/N, ptfe: 1e-15 m^2/N}`, as lists."""

from collections.abc import Mapping
from typing import Any

from ..language.errors import shown
from .axes import FORMS
from .document import WrittenValue
from .keys import Number
from .reader import Reader
from .sampling import DISTRIBUTIONS

LONGEST = 40  # characters of a label: it is the head of rows and the end of sentences
#: Words that say how values are made; no label may be one of them.
RESERVED = (*FORMS, "fits", "fit", *DISTRIBUTIONS, "among", "whole", "factor")
_WAYS = ("sweep", "zip", "cases")  # sections whose axes may have labels


def put_lists(reader: Reader) -> None:
    """Put the list of its values in place of each axis with labels, and note the labels."""
    for path, written in list(reader.swept.items()):
        if reader.way[path] in _WAYS and _labelled(written):
            _put_list(reader, path, written)


def _labelled(written: WrittenValue) -> bool:
    """Return whether an axis is a mapping of labels to values, not one of the other ways to write one."""
    content = written.value
    if not isinstance(content, dict) or not content or set(content) <= set(RESERVED):
        return False
    return all(_alone(item) for name, item in content.items() if name not in RESERVED)


def _alone(item: WrittenValue) -> bool:
    """Return whether something written is a single value, or a fit."""
    return [*item.value] == ["fit"] if isinstance(item.value, dict) else not isinstance(item.value, list)


def _put_list(reader: Reader, path: str, written: WrittenValue) -> None:
    """Put a list in place of one axis with labels; a mistake is noted, and the axis has no labels then."""
    where = f"{reader.way[path]}.{path}"
    invalid = {name: sentence for name in written.value if (sentence := _mistake(name))}
    if not isinstance(reader.shape[path], Number):
        sentence = "is a word, which is its own label: write a list such as [a, b] (labels are for numbers)"
        reader.problems.add(written, where, sentence)
    for name, sentence in invalid.items():
        reader.problems.add(written.key_place(name), where, sentence)
    items = [item for name, item in written.value.items() if name not in invalid]
    reader.swept[path] = WrittenValue(items, written.origin, written.line, written.column)
    if not invalid:
        reader.labels[path] = tuple(written.value)


def _mistake(name: str) -> str:
    """Return what is wrong with a label, '' for nothing."""
    if name in RESERVED:
        return (
            f"{shown(name)} is reserved and cannot label a value (reserved: {', '.join(RESERVED)}); choose another "
            "label"
        )
    if len(name) > LONGEST or not name.isprintable() or not any(map(str.isalpha, name)):
        return (
            f"found the label {shown(name)}; expected at most {LONGEST} printable characters, a letter among them; "
            "values without labels are written as a list"
        )
    return ""


def of_axes(reader: Reader) -> dict[str, dict[str, Any]]:
    """Return path of an axis with labels -> label -> value, SI; a value with two labels is noted.

    Fits that are searched are the labels of their largest clearances.
    """
    paths = reader.seek.paths if reader.among and reader.seek else ()
    labels = {path: {fit.name: fit.high for fit in reader.among} for path in paths}
    for path, names in reader.labels.items():
        values = reader.axes.get(path, ())
        if len(values) < len(names):
            continue  # a mistake that is noted already
        labels[path] = dict(zip(names, values, strict=False))
        if len(set(labels[path].values())) < len(names):  # of axes in step, whose values may repeat
            sentence = "has one value under two labels; write values that repeat as a list"
            reader.problems.add(reader.swept[path], f"{reader.way[path]}.{path}", sentence)
    return labels


def noted(record: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Return path -> label -> value (SI) of the axes with labels, by the run.json of a run."""
    return {path: dict(labels) for path, labels in record.get("labels", {}).items()}
