"""Materials that a grid varies by name: the numbers of a case follow from the name.

A name has no part in the identity of a case, only its numbers.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from .document import WrittenValue
from .keys import Name, Shape, Word
from .library import MATERIALS
from .naming import BODIES, MATERIAL, OF_MATERIAL, Taken

_NAME = f".{MATERIAL}"  # end of the path of a name


class VariedMaterial(NamedTuple):
    """A material whose name varies."""

    first: str  # name in its place outside the section that varies it
    follow: Mapping[str, str]  # path of a number -> its key in the library


def find(varied_paths: Iterable[str], library_values: Iterable[Taken], complete: Shape) -> dict[str, VariedMaterial]:
    """Return path of a name -> the material of that name, for the paths that a grid varies."""
    by_path = {item.path: item for item in library_values}
    materials = {}
    for path in varied_paths:
        section = path.removesuffix(_NAME)
        if not isinstance(complete.get(f"{section}{_NAME}"), Name) or not section.rpartition(".contact.")[0]:
            continue
        numbers = {f"{section}.{key}": key for key in OF_MATERIAL}
        joint, _, inside = section.partition(".contact.material")
        bodies = [inside[1:]] if inside else BODIES
        numbers |= {f"{joint}.thermal.expansion.{body}": "expansion" for body in bodies}
        follow = {number: key for number, key in numbers.items() if number in by_path}
        if follow:
            materials[f"{section}{_NAME}"] = VariedMaterial(by_path[next(iter(follow))].name, follow)
    return materials


def keys_of(materials: Iterable[str]) -> Shape:
    """Return the keys of the names that vary."""
    return {path: Word(tuple(MATERIALS), "the material", sweep=True, noun="material") for path in materials}


def path_of(path: str, shape: Shape) -> str:
    """Return the path of the name of a material for that of its section, any other path as it is."""
    name = f"{path}{_NAME}"
    return name if isinstance(shape.get(name), Word) else path


def reached(path: str, materials: Mapping[str, VariedMaterial], axes: Mapping[str, tuple[Any, ...]]) -> Iterator[float]:
    """Yield the values of a number that follows from names on an axis."""
    for name, material in materials.items():
        if path in material.follow:
            for word in axes.get(name, ()):
                yield MATERIALS[word].values[material.follow[path]].typical


def put_numbers(values_by_path: dict[str, Any], materials: Mapping[str, VariedMaterial]) -> dict[str, Any]:
    """Return the values of a case with the numbers of its materials in place of their names."""
    names = {path: values_by_path.pop(path) for path in materials if path in values_by_path}
    for path, name in names.items():
        entry, follow = MATERIALS[name], materials[path].follow
        values_by_path |= {
            number: entry.values[key].typical for number, key in follow.items() if number in values_by_path
        }
    return values_by_path


def with_names(base: Mapping[str, Any], materials: Mapping[str, VariedMaterial]) -> dict[str, Any]:
    """Return values outside all axes with the names of varied materials in place of their numbers."""
    followers = {number for material in materials.values() for number in material.follow}
    kept_values = {path: value for path, value in base.items() if path not in followers}
    return kept_values | {path: material.first for path, material in materials.items()}


def written_names(materials: Mapping[str, VariedMaterial], location: WrittenValue) -> dict[str, WrittenValue]:
    """Return the names that stand in a grid outside the section that varies them, as if written at a place."""
    spots = location.origin, location.line, location.column
    return {path: WrittenValue(material.first, *spots) for path, material in materials.items()}
