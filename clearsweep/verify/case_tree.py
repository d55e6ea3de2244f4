"""A case in the form of a grid file, in SI, reduced to its motion and changed by dotted path."""

import copy
from collections.abc import Iterator, Mapping
from typing import Any

from .. import grid
from ..simulation.setup import scene

Tree = dict[str, Any]  # a case in the form of a grid file, in SI


def base_tree(written: Mapping[str, Any], **settings: Any) -> Tree:
    """Return a case reduced to its motion: one revolution from the start, no history, with some `simulate` settings."""
    tree: Tree = copy.deepcopy(plain(written))
    for name in ("life", "uncertain", "define"):
        tree.pop(name, None)
    simulation = tree["simulate"]
    for name in ("until", "horizon", "error_check", "discard", "time_budget"):
        simulation.pop(name, None)
    if "revolutions" in simulation:
        simulation |= {"revolutions": 1.0, "discard": 0.0}
    tree["save"] = {"orbits": "none"}
    simulation |= settings
    return tree


def plain(value: Any) -> Any:
    """Return nested sections as plain dicts and lists."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def scene_of(tree: Tree) -> scene.Scene:
    """Return the Scene of a case in the form of a grid file.  Raises InputError."""
    return scene.build(grid.load(tree, scene.catalogue()).case(0))


def with_values(tree: Tree, values: Mapping[str, Any]) -> Tree:
    """Return a copy with some values, by dotted path."""
    changed: Tree = copy.deepcopy(tree)
    for path, value in values.items():
        *parents, key = path.split(".")
        section = changed
        for parent in parents:
            section = section.setdefault(parent, {})
        section[key] = value
    return changed


def without(tree: Tree, path: str) -> Tree:
    """Return a copy without a section."""
    changed: Tree = copy.deepcopy(tree)
    *parents, key = path.split(".")
    section = changed
    for parent in parents:
        section = section[parent]
    del section[key]
    return changed


def leaves(tree: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of every number and word of a tree."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            yield from leaves(value, f"{prefix}.{key}" if prefix else key)
    elif not isinstance(tree, list):
        yield prefix, tree
