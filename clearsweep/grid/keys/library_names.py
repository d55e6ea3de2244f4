"""Replaces the names of materials, oils and wear pairs by numbers, once or for every case of a varied material."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from ...language.errors import InputError, quoted
from .. import library
from ..library import MATERIALS, Entry, Value
from ..written.document import Problems, WrittenValue
from .kinds import Name, Shape, Word

MATERIAL, OIL, PAIR = "name", "oil", "pair"  # the keys that take a name
BODIES = ("bearing", "journal")
OF_MATERIAL = ("young", "poisson", "yield_strength")
LAW = "archard"  # law of wear if a pair is named without a law
_CONTACTS = ("contact", "axial")


class Taken(NamedTuple):
    """A number taken from a library."""

    path: str  # path in the grid
    name: str  # of the entry
    value: Value


class _Named:
    """The names in a document, and the numbers taken for them."""

    def __init__(self, problems: Problems):
        self.problems, self.taken = problems, list[Taken]()
        self.materials: dict[str, Entry] = {}  # path -> name of the entry

    def joint(self, path: str, joint: WrittenValue) -> WrittenValue:
        """Return a joint with its names replaced by numbers."""
        for contact in _CONTACTS:
            joint = _within(joint, f"{path}.{contact}", contact, self._contact)
        joint = _within(joint, f"{path}.film", "film", self._film)
        joint = _within(joint, f"{path}.thermal", "thermal", self._thermal)
        return _within(joint, f"{path}.wear", "wear", self._wear)

    def _thermal(self, path: str, thermal: WrittenValue) -> WrittenValue:
        """Return a heat balance with the thermal expansion of named materials."""
        if not isinstance(thermal.value, dict):
            return thermal
        material_path = f"{path.rpartition('.')[0]}.contact.material"
        materials = {
            body: self.materials.get(f"{material_path}.{body}", self.materials.get(material_path)) for body in BODIES
        }
        written = thermal.value.get("expansion", _replaced(thermal, {}))
        if None in materials.values() or not isinstance(written.value, dict):
            return thermal
        content = dict(written.value)
        for body, entry in materials.items():
            if body not in content and entry is not None:
                value = entry.values["expansion"]
                content[body] = _replaced(written, _written(value))
                self.taken.append(Taken(f"{path}.expansion.{body}", entry.name, value))
        return _replaced(thermal, thermal.value | {"expansion": _replaced(written, content)})

    def _contact(self, path: str, contact: WrittenValue) -> WrittenValue:
        def material(nested: str, written: WrittenValue) -> WrittenValue:
            for body in BODIES:
                written = _within(written, f"{nested}.{body}", body, self._material)
            return self._material(nested, written)

        return _within(contact, f"{path}.material", "material", material)

    def _material(self, path: str, written: WrittenValue) -> WrittenValue:
        """Return a material as a section, from a name or from a section with a name."""
        if isinstance(written.value, str):
            name, content = written, dict[str, WrittenValue]()
        elif isinstance(written.value, dict) and MATERIAL in written.value:
            name, content = written.value[MATERIAL], {k: v for k, v in written.value.items() if k != MATERIAL}
        else:
            return written
        entry = self.materials[path] = self._entry(library.MATERIALS, path, name)
        return _replaced(written, self._filled(path, content, entry, OF_MATERIAL, name))

    def _film(self, path: str, film: WrittenValue) -> WrittenValue:
        if not isinstance(film.value, dict) or OIL not in film.value:
            return film
        name, viscosity = film.value[OIL], film.value.get("viscosity")
        if viscosity is not None and not isinstance(viscosity.value, dict):
            sentence = "conflicts with `viscosity`, which it determines; remove one of the two"
            self.problems.add(film.key_position(OIL), f"{path}.{OIL}", sentence)
            return _replaced(film, {key: value for key, value in film.value.items() if key != OIL})
        content = {} if viscosity is None else viscosity.value
        entry = self._entry(library.OILS, f"{path}.{OIL}", name)
        filled = self._filled(f"{path}.viscosity", content, entry, tuple(entry.values), name)
        without_name = {key: value for key, value in film.value.items() if key != OIL}
        return _replaced(film, without_name | {"viscosity": _replaced(viscosity or name, filled)})

    def _wear(self, path: str, wear: WrittenValue) -> WrittenValue:
        if not isinstance(wear.value, dict) or PAIR not in wear.value:
            return wear
        name = wear.value[PAIR]
        content = {key: value for key, value in wear.value.items() if key != PAIR}
        content.setdefault("law", _replaced(name, LAW))
        entry = self._entry(library.PAIRS, f"{path}.{PAIR}", name)
        return _replaced(wear, self._filled(path, content, entry, ("coefficient",), name))

    def _entry(self, materials: Mapping[str, Entry], path: str, name: WrittenValue) -> Entry:
        """Return the entry of a name; a wrong name is reported and gets any entry, whose numbers are never used."""
        if isinstance(name.value, str):
            try:
                return library.find_entry(materials, name.value)
            except InputError as error:
                self.problems.add(name, path, str(error))
        else:
            kind = next(kind for kind, item in library.LIBRARIES.items() if item is materials)
            sentence = f"found {quoted(name.value)}; expected a name that `clearsweep list {kind}` prints"
            self.problems.add(name, path, sentence)
        return next(iter(materials.values()))

    def _filled(
        self, path: str, content: dict[str, WrittenValue], entry: Entry, keys: tuple[str, ...], name: WrittenValue
    ) -> dict[str, WrittenValue]:
        """Return a section completed by the numbers of an entry, and record these."""
        missing = [key for key in keys if key not in content]
        self.taken += [Taken(f"{path}.{key}", entry.name, entry.values[key]) for key in missing]
        location = name.origin, name.line, name.column
        return content | {key: WrittenValue(_written(entry.values[key]), *location, by_name=True) for key in missing}


def put_library_numbers(root: WrittenValue, problems: Problems) -> tuple[WrittenValue, list[Taken]]:
    """Return the document with library names replaced by numbers, and the numbers taken."""
    named_values = _Named(problems)

    def joints(path: str, section: WrittenValue) -> WrittenValue:
        for name in section.value if isinstance(section.value, dict) else ():
            section = _within(section, f"{path}.{name}", name, named_values.joint)
        return section

    return _within(root, "joints", "joints", joints), named_values.taken


def _within(
    section: WrittenValue, path: str, key: str, change: Callable[[str, WrittenValue], WrittenValue]
) -> WrittenValue:
    """Return a section with the value of `key`, if any, changed."""
    if not isinstance(section.value, dict) or key not in section.value:
        return section
    replacement = change(path, section.value[key])
    return section if replacement is section.value[key] else _replaced(section, section.value | {key: replacement})


def _replaced(written: WrittenValue, value: object) -> WrittenValue:
    """Return a new value at the position of another."""
    return WrittenValue(value, written.origin, written.line, written.column, written.keys)


def _written(value: Value) -> str | float:
    """Return a typical value as a user would write it."""
    return value.typical if value.unit == "1" else f"{value.typical!r} {value.unit}"


_NAME = f".{MATERIAL}"  # end of the path of a name


class VariedMaterial(NamedTuple):
    """A material whose name varies."""

    first: str  # name in its place outside the section that varies it
    library_keys: Mapping[str, str]  # path of a number -> its key in the library


def find_varied_materials(
    varied_paths: Iterable[str], library_values: Iterable[Taken], full_shape: Shape
) -> dict[str, VariedMaterial]:
    """Return path of a name -> the material of that name, for the paths that a grid varies."""
    by_path = {item.path: item for item in library_values}
    materials = {}
    for path in varied_paths:
        section = path.removesuffix(_NAME)
        if not isinstance(full_shape.get(f"{section}{_NAME}"), Name) or not section.rpartition(".contact.")[0]:
            continue
        numbers = {f"{section}.{key}": key for key in OF_MATERIAL}
        joint, _, body_path = section.partition(".contact.material")
        bodies = [body_path[1:]] if body_path else BODIES
        numbers |= {f"{joint}.thermal.expansion.{body}": "expansion" for body in bodies}
        library_keys = {number: key for number, key in numbers.items() if number in by_path}
        if library_keys:
            materials[f"{section}{_NAME}"] = VariedMaterial(by_path[next(iter(library_keys))].name, library_keys)
    return materials


def keys_of_materials(materials: Iterable[str]) -> Shape:
    """Return the keys of the names that vary."""
    return {path: Word(tuple(MATERIALS), "the material", sweep=True, noun="material") for path in materials}


def name_path(path: str, shape: Shape) -> str:
    """Return the path of a material's name if `path` is its section, otherwise the unchanged path."""
    name = f"{path}{_NAME}"
    return name if isinstance(shape.get(name), Word) else path


def material_values(
    path: str, materials: Mapping[str, VariedMaterial], axes: Mapping[str, tuple[Any, ...]]
) -> Iterator[float]:
    """Yield the values of a number that follows from names on an axis."""
    for name, material in materials.items():
        if path in material.library_keys:
            for word in axes.get(name, ()):
                yield MATERIALS[word].values[material.library_keys[path]].typical


def put_material_numbers(values_by_path: dict[str, Any], materials: Mapping[str, VariedMaterial]) -> dict[str, Any]:
    """Return the values of a case with the numbers of its materials in place of their names."""
    names = {path: values_by_path.pop(path) for path in materials if path in values_by_path}
    for path, name in names.items():
        entry, library_keys = MATERIALS[name], materials[path].library_keys
        values_by_path |= {
            number: entry.values[key].typical for number, key in library_keys.items() if number in values_by_path
        }
    return values_by_path


def with_material_names(base: Mapping[str, Any], materials: Mapping[str, VariedMaterial]) -> dict[str, Any]:
    """Return values outside all axes with the names of varied materials in place of their numbers."""
    followers = {number for material in materials.values() for number in material.library_keys}
    kept_values = {path: value for path, value in base.items() if path not in followers}
    return kept_values | {path: material.first for path, material in materials.items()}


def written_material_names(materials: Mapping[str, VariedMaterial], root: WrittenValue) -> dict[str, WrittenValue]:
    """Return written names of materials for the keys outside the section that varies them, with a position."""
    position = root.origin, root.line, root.column
    return {path: WrittenValue(material.first, *position) for path, material in materials.items()}
