"""Reads a YAML 1.2 file or a dict into entries that know where they were written, and collects what is wrong."""

import os
import stat
from collections.abc import Callable
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, SequenceNode

from ..errors import InputError, shown

_LARGEST = 64 * 2**20  # bytes of a grid file
_TAG = "tag:yaml.org,2002:"
_PLAIN = {
    "map",
    "seq",
    "str",
    "int",
    "float",
    "bool",
    "null",
    "timestamp",
    "merge",
    "value",
}  # what a value is without a tag


@dataclass(frozen=True, slots=True)
class Entry:
    """One value as it was written, and where."""

    value: Any  # dict of str to Entry, list of Entry, text or number as written, bool or None
    origin: str = ""  # file, 'overrides', or '' for a dict
    line: int = 0  # 1 for the first line; 0: not from a file
    column: int = 0
    keys: dict = field(default_factory=dict)  # key -> Entry that stands for the place of the key itself

    @property
    def place(self) -> str:
        """`grid.yaml:14:12: `, or as much of it as is known."""
        return f"{self.origin}:{self.line}:{self.column}: " if self.line else f"{self.origin}: " if self.origin else ""


class Problems:
    """The mistakes found so far; each is told once, in the order of the file."""

    def __init__(self):
        self._found: dict[str, tuple[int, int]] = {}

    def __len__(self) -> int:
        return len(self._found)

    def add(self, entry: Entry, path: str, sentence: str) -> None:
        """Note that the value at dotted `path` is wrong."""
        self._found.setdefault(f"{entry.place}{path + ': ' if path else ''}{sentence}", (entry.line, entry.column))

    def check(self) -> None:
        """Raise an InputError with everything found, if anything was."""
        if self._found:
            raise InputError(*sorted(self._found, key=self._found.get))


def read(source, problems: Problems) -> Entry:
    """Return the entry of a whole document, a path or a dict; an InputError where it cannot be read at all."""
    if not isinstance(source, (str, PathLike)):
        return entry_of(source, "")
    name = fspath(source)
    try:
        refuse_endless(name, _LARGEST)
        with open(name, encoding="utf-8-sig") as file:
            text = file.read()
    except UnicodeDecodeError as error:
        raise InputError(f"{name}: not UTF-8 text (byte {error.start}); save the file as UTF-8") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{name}: cannot be read: {reason}; give the path of a grid file") from error
    try:
        node = YAML(typ="safe", pure=True).compose(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{name}:{mark.line + 1}:{mark.column + 1}" if mark else name
        raise InputError(f"{where}: not valid YAML: {error.problem or error.context}") from error
    except (YAMLError, RecursionError, ValueError) as error:
        first = str(error).strip().splitlines()[0] if str(error).strip() else "nested too deeply"
        raise InputError(f"{name}: not valid YAML: {first}") from error
    if node is None:
        raise InputError(f"{name}:1:1: the file is empty; `clearsweep init` writes a grid to start from")
    return _from_node(node, name, "", problems, {})


def refuse_endless(name: str | PathLike, most: int) -> None:
    """Raise an OSError unless a name is that of a regular file of at most so many bytes: no device, no pipe."""
    found = os.stat(name)
    if not stat.S_ISREG(found.st_mode):
        raise OSError(0, "it is a directory" if stat.S_ISDIR(found.st_mode) else "it is no regular file")
    if found.st_size > most:
        raise OSError(0, f"it has {found.st_size:,} bytes, more than the {most:,} that are read")


def entry_of(value, origin: str) -> Entry:
    """Return the entry of a Python value: mappings, sequences, arrays, numbers and text."""
    if hasattr(value, "items"):
        return Entry({str(key): entry_of(item, origin) for key, item in value.items()}, origin)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple, range)):
        return Entry([entry_of(item, origin) for item in value], origin)
    return Entry(value, origin)


def override(root: Entry, path: str, value, problems: Problems) -> Entry:
    """Return `root` with `value` put at dotted `path`; None takes away what is there."""
    return _put(
        root,
        path.split("."),
        value,
        lambda found: problems.add(
            Entry(None, "overrides"), path, f"leads into the value {shown(found)}, not into a section"
        ),
    )


def _put(entry: Entry, keys: list[str], value, refuse: Callable) -> Entry:
    """Return `entry` with `value` put where `keys` lead; `refuse` is told of a value on the way."""
    inside = dict(enumerate(entry.value)) if isinstance(entry.value, list) else entry.value
    if not isinstance(inside, dict):
        refuse(entry.value)
        return entry
    inside = {str(key): item for key, item in inside.items()}
    key, *rest = keys
    if rest:
        inside[key] = _put(inside.get(key, Entry({}, "overrides")), rest, value, refuse)
    elif value is None:
        inside.pop(key, None)
    else:
        inside[key] = entry_of(value, "overrides")
    return Entry(inside, entry.origin, entry.line, entry.column, entry.keys)


def _from_node(node: Node, origin: str, path: str, problems: Problems, done: dict) -> Entry:
    """Return the entry of a YAML node; a node that is referred to again (an alias) is converted once."""
    at = (origin, node.start_mark.line + 1, node.start_mark.column + 1)
    if id(node) in done:
        if done[id(node)] is None:
            problems.add(Entry(None, *at), path, "an alias that contains itself; write the value out")
        return done[id(node)] or Entry(None, *at)
    done[id(node)] = None
    if str(node.tag).removeprefix(_TAG) not in _PLAIN:
        problems.add(Entry(None, *at), path, f"the YAML tag {node.tag} is not understood; write it without")
    if isinstance(node, MappingNode):
        entry = _mapping(node, at, path, problems, done)
    elif isinstance(node, SequenceNode):
        entry = Entry([_from_node(item, origin, path, problems, done) for item in node.value], *at)
    else:
        entry = Entry(_scalar(str(node.tag), node.value, Entry(None, *at), path, problems), *at)
    done[id(node)] = entry
    return entry


def _mapping(node: MappingNode, at: tuple, path: str, problems: Problems, done: dict) -> Entry:
    """Return the entry of a YAML mapping; a key that is written twice is a problem."""
    values, keys = {}, {}
    for key_node, value_node in node.value:
        here = Entry(None, at[0], key_node.start_mark.line + 1, key_node.start_mark.column + 1)
        key = str(key_node.value) if not isinstance(key_node.value, list) else "?"
        inner = f"{path}.{key}" if path else key
        if key in values:
            problems.add(here, inner, f"duplicate key; it is also on line {keys[key].line}: keep one of them")
            continue
        value = _from_node(value_node, at[0], inner, problems, done)
        blank = value.value is None and not value_node.value  # a blank has no place of its own
        values[key], keys[key] = here if blank else value, here
    return Entry(values, *at, keys)


def _scalar(tag: str, text: str, here: Entry, path: str, problems: Problems):
    """Return a YAML scalar: bool, None, or its text, from which quantities are read exactly."""
    kind = tag.removeprefix(_TAG)
    if kind == "bool":
        return text.lower() == "true"
    if kind == "null":
        return None
    if kind == "int" and text.lower().lstrip("+-").startswith(("0x", "0o")):
        return int(text, 0)
    return text
