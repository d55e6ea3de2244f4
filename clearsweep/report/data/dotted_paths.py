"""Values of nested mappings by dotted path, and the paths that a run searched."""

from collections.abc import Mapping
from typing import Any


def value_at(tree: Mapping, path: str) -> Any:
    """Return the value at a dotted path of a nested mapping, or None."""
    value: Any = tree
    for key in path.split("."):
        if not isinstance(value, Mapping) or key not in value:
            return None
        value = value[key]
    return value


def leaves(tree: Mapping, prefix: str = "") -> list[tuple[str, object]]:
    """Return the leaves of a nested mapping: dotted path, value."""
    pairs: list[tuple[str, object]] = []
    for key, value in tree.items():
        pairs += leaves(value, f"{prefix}{key}.") if isinstance(value, Mapping) else [(f"{prefix}{key}", value)]
    return pairs


def first_sought_path(record: Mapping) -> str:
    """Return the first path whose largest or smallest value a run searches for, or ''."""
    return next(iter(sought_paths(record)), "")


def sought_paths(record: Mapping) -> tuple[str, ...]:
    """Return the parallel paths whose largest or smallest value a run searches for."""
    seek = record.get("seek") or {}
    paths = seek.get("largest") or seek.get("smallest") or ()
    return (paths,) if isinstance(paths, str) else tuple(paths)


def tried_paths(record: Mapping) -> tuple[str, ...]:
    """Return the paths whose values were chosen by a search."""
    searched = record.get("optimise") or record.get("identify") or {}
    return sought_paths(record) or tuple(searched.get("over", ()))
