"""Reads the overrides of a command line and applies them to a grid."""

from collections.abc import Mapping
from os import PathLike
from typing import NamedTuple

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from ..language.errors import InputError, shown
from .document import Problems, WrittenValue, from_node, override

SET, SWEEP = "--set", "--sweep"


class Changed(NamedTuple):
    """Overrides of a grid from the command line, each as YAML text."""

    source: str | PathLike | Mapping
    fixed: Mapping[str, str] = {}  # dotted path -> the value of every case
    swept: Mapping[str, str] = {}  # dotted path -> its values, as in a list, or evenly spaced ones in braces


def read_options(option: str, given: tuple[str, ...]) -> dict[str, str]:
    """Return path -> text of the `PATH=VALUE` arguments of an option; InputError for any other form."""
    example = "drive.speed=3000rpm" if option == SET else "drive.speed=1000rpm,3000rpm"
    options: dict[str, str] = {}
    invalid = []
    for text in given:
        path, equals, value = (piece.strip() for piece in text.partition("="))
        if not equals or not path or not (value or option == SET):
            invalid.append(f"{option} {text}: expected PATH=VALUE, such as {option} {example}")
        elif path in options:
            invalid.append(f"{option} {path}: is given twice; give it once")
        options[path] = value
    if invalid:
        raise InputError(*invalid)
    return options


def apply_overrides(root: WrittenValue, overrides: Changed, problems: Problems) -> WrittenValue:
    """Return the document with the overrides applied; an empty value removes the key."""
    for path in sorted(overrides.fixed.keys() & overrides.swept.keys()):
        problems.add(WrittenValue(None, SET), path, f"is given with {SWEEP}, too; give it with one of them")
    for path, text in overrides.fixed.items():
        root = override(root, path, _read(f"{SET} {path}", path, text, problems), problems)
    for path, text in overrides.swept.items():
        root = _sweep(root, path, _read(f"{SWEEP} {path}", path, text if text[:1] in "[{" else f"[{text}]", problems))
    return root


def _read(origin: str, path: str, text: str, problems: Problems) -> WrittenValue:
    """Return the value of a YAML text that comes from `origin`."""
    try:
        node = YAML(typ="safe", pure=True).compose(text)
    except YAMLError:
        raise InputError(f"{origin}: found {shown(text)}, which is not valid YAML") from None
    return WrittenValue(None, origin) if node is None else _placed(from_node(node, origin, path, problems, {}), origin)


def _placed(written: WrittenValue, origin: str) -> WrittenValue:
    """Return a value without line and column, which have no meaning on a command line."""
    value = written.value
    if isinstance(value, dict):
        value = {key: _placed(item, origin) for key, item in value.items()}
    elif isinstance(value, list):
        value = [_placed(item, origin) for item in value]
    return WrittenValue(value, origin)


def _sweep(root: WrittenValue, path: str, values: WrittenValue) -> WrittenValue:
    """Return the document with these values for a path in `sweep`."""
    section = root.value.get("sweep", WrittenValue({}, values.origin))
    if not isinstance(section.value, dict):
        return root  # its problem is reported elsewhere
    keys = {key: location for key, location in section.keys.items() if key != path}
    inside = WrittenValue(section.value | {path: values}, section.origin, section.line, section.column, keys)
    return WrittenValue(root.value | {"sweep": inside}, root.origin, root.line, root.column, root.keys)
