"""Dampings in per cent: of a housing they are ratios, under the key `damping_ratio`."""

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from .document import WrittenValue

DAMPING, RATIO = "damping", "damping_ratio"
_DAMPING_PATH = re.compile(rf"(mechanism\.mounts\.[^.]+)\.{DAMPING}((?:\.[01])?)")
_AXIS_SECTIONS = ("sweep", "zip", "cases")


def with_damping_ratios(root: WrittenValue) -> WrittenValue:
    """Return a document in which every damping of a housing in per cent is under the key `damping_ratio`."""

    def renamed_axis(path: str, content: WrittenValue) -> str:
        match = _DAMPING_PATH.fullmatch(path)
        return f"{match[1]}.{RATIO}{match[2]}" if match and _is_in_per_cent(content) else path

    def renamed_key(key: str, content: WrittenValue) -> str:
        return RATIO if key == DAMPING and _is_in_per_cent(content) else key

    root = _changed(root, ("mechanism", "mounts"), renamed_key)
    for section in _AXIS_SECTIONS:
        root = _changed(root, (section,), renamed_axis, depth=0)
    return root


def _changed(section: WrittenValue, path: tuple[str, ...], rename: Any, depth: int = 1) -> WrittenValue:
    """Return a section in which the keys of the sections `depth` levels below `path` have other names."""
    if not isinstance(section.value, dict):
        return section
    if not path and depth == 0:
        names = {key: rename(key, content) for key, content in section.value.items()}
        keys = {names.get(key, key): place for key, place in section.keys.items()}
        content = {names[key]: value for key, value in section.value.items()}
        return (
            section if all(key == name for key, name in names.items()) else replace(section, value=content, keys=keys)
        )
    below = [path[0]] if path else list(section.value)
    content = {
        key: _changed(value, path[1:], rename, depth if path else depth - 1) if key in below else value
        for key, value in section.value.items()
    }
    return replace(section, value=content)


def _is_in_per_cent(written: WrittenValue) -> bool:
    """Return whether all values of a list or a section, or the only value, are in per cent."""
    texts = list(_texts(written))
    return bool(texts) and all(isinstance(text, str) and text.rstrip(" ]}").endswith("%") for text in texts)


def _texts(written: WrittenValue) -> Iterator[Any]:
    if isinstance(written.value, (dict, list)):
        items = written.value.values() if isinstance(written.value, dict) else written.value
        for item in items:
            yield from _texts(item)
    else:
        yield written.value
