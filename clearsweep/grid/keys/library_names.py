"""Replaces names of materials, oils, wear pairs and bearings by numbers, once or for every case of a varied name."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from ...contracts.catalogue import CHOICE
from ...language.errors import InputError, mistake_of, quoted
from .. import library
from ..library import MATERIALS, WIDTH, Entry, Value, bearing_names, check_group, parse_bearing_name
from ..library.fits import NORMAL_GROUP
from ..written import Problems, WrittenValue
from . import KeyTable, Name, Word

MATERIAL, OIL, PAIR, HOUSING_MATERIAL, BEARING = "name", "oil", "pair", "material", "bearing"  # keys that take a name
UNCHECKED = "unchecked"  # the key next to a name with which the user answers for values from memory
COUNT = "elements"  # the number of a bearing that is whole
BODIES = ("bearing", "journal")
MATERIAL_KEYS = ("young", "poisson", "yield_strength")
DEFAULT_WEAR_LAW = "archard"  # law of wear if a pair is named without a law


class LibraryNumber(NamedTuple):
    """A number that replaces the name of a library entry."""

    path: str  # path in the grid
    name: str  # of the entry
    value: Value


def unchecked_text(entry: Entry) -> str:
    """Return why the values of an entry are not used without the user's consent."""
    return (
        f"the values of {entry.name} are from memory, compared with no published text; compare them with a data sheet "
        f"(`clearsweep list '{entry.name}'`), then write `{UNCHECKED}: true` next to the name, or numbers instead"
    )


class _NameReplacer:
    """Replaces the library names in a document by numbers, and records these numbers."""

    def __init__(self, problems: Problems):
        self.problems, self.numbers = problems, list[LibraryNumber]()
        self.materials: dict[str, Entry] = {}  # path -> name of the entry
        self.unchecked_sections: list[str] = []  # with `unchecked: true`

    def replace_in_joint(self, path: str, joint: WrittenValue) -> WrittenValue:
        """Return a joint with its names replaced by numbers."""
        joint = self._bearing(path, joint)
        joint = _changed(path, joint, ("contact", "axial"), self._contact)
        of_rolling = partial(self._material, unchecked=False, used_keys=MATERIAL_KEYS[:2])  # without the strength
        joint = _changed(path, joint, ("material",), of_rolling)
        joint = _changed(path, joint, ("film",), self._film)
        joint = _changed(path, joint, ("thermal",), self._thermal)
        return _changed(path, joint, ("wear",), self._wear)

    def _bearing(self, path: str, joint: WrittenValue) -> WrittenValue:
        """Return a rolling bearing with the sizes, ratings and group of a named one; keys next to the name stay."""
        if "type" not in joint.entries:
            return joint
        joint, name, unchecked = self._taken(path, joint, BEARING)
        if name is None:
            return joint
        name = text_of_name(name)
        designation, group = parse_bearing_name(name.value) if isinstance(name.value, str) else (name.value, "")
        entry = self._entry(library.BEARINGS, f"{path}.{BEARING}", name.with_value(designation))
        sizes, grooves, ratings = (_part_of(entry, part) for part in ("", "groove", "capacity"))
        content = {"kind": _by_name(name, "ball" if grooves.values else "needle")} | joint.value
        content = self._filled(path, content, sizes, tuple(sizes.values), name, unchecked)
        capacity = content.get("capacity", name.with_value({}))
        if isinstance(capacity.value, dict):
            rated = self._filled(f"{path}.capacity", capacity.value, ratings, tuple(ratings.values), name, unchecked)
            content["capacity"] = capacity.with_value(rated)
        if grooves.values and "groove" not in content:
            filled = self._filled(f"{path}.groove", {}, grooves, tuple(grooves.values), name, unchecked)
            content["groove"] = name.with_value([*filled.values()])
        if mistake := mistake_of(check_group, entry.name, group):
            self.problems.add(name, f"{path}.{BEARING}", mistake)
        if grooves.values:
            content["clearance"] = self._clearance(path, content.get("clearance"), name, group)
        return joint.with_value(content)

    def _clearance(self, path: str, written: WrittenValue | None, name: WrittenValue, group: str) -> WrittenValue:
        """Return the clearance of a named bearing: its group, CN if there is none, mounted as written."""
        named_group = {"group": _by_name(name, group or NORMAL_GROUP)}
        if written is None:
            return _by_name(name, named_group)
        if isinstance(written.value, dict) and not {"group", "groups"} & {*written.value}:
            return written.with_value(named_group | written.value)
        if group:
            message = f"conflicts with the group {group} in the name of the bearing; remove one of the two"
            self.problems.add(written, f"{path}.clearance", message)
        return written

    def _thermal(self, path: str, thermal: WrittenValue) -> WrittenValue:
        """Return a heat balance with the thermal expansion of named materials."""
        thermal = _changed(path, thermal, ("housing",), partial(self.with_material, keys=("expansion",)))
        material_path = f"{path.rpartition('.')[0]}.contact.material"
        materials = [
            self.materials.get(f"{material_path}.{body}", self.materials.get(material_path)) for body in BODIES
        ]
        written = thermal.entries.get("expansion", thermal.with_value({}))
        if not isinstance(thermal.value, dict) or None in materials or not isinstance(written.value, dict):
            return thermal
        content = dict(written.value)
        for body, entry in zip(BODIES, materials, strict=True):
            if body not in content and entry is not None:
                value = entry.values["expansion"]
                content[body] = written.with_value(_written_text(value))
                self.numbers.append(LibraryNumber(f"{path}.expansion.{body}", entry.name, value))
        return thermal.with_value(thermal.value | {"expansion": written.with_value(content)})

    def with_material(self, path: str, section: WrittenValue, keys: tuple[str, ...]) -> WrittenValue:
        """Return a section with the name of its material replaced by the numbers of these keys."""
        section, name, unchecked = self._taken(path, section, HOUSING_MATERIAL)
        if name is None:
            return section
        entry = self._entry(library.MATERIALS, f"{path}.{HOUSING_MATERIAL}", name)
        return section.with_value(self._filled(path, section.value, entry, keys, name, unchecked))

    def _contact(self, path: str, contact: WrittenValue) -> WrittenValue:
        def material(nested: str, written: WrittenValue) -> WrittenValue:
            written, unchecked = self._pop_unchecked(nested, written, (MATERIAL, *BODIES))
            written = _changed(nested, written, BODIES, partial(self._material, unchecked=unchecked))
            return self._material(nested, written, unchecked=unchecked)

        return _changed(path, contact, ("material",), material)

    def _material(
        self, path: str, written: WrittenValue, *, unchecked: bool, used_keys: tuple[str, ...] = MATERIAL_KEYS
    ) -> WrittenValue:
        """Return a material as a section, from a name or from a section with a name."""
        written, name, consents = self._taken(path, written, MATERIAL)
        if isinstance(written.value, str):
            name, written = written, written.with_value({})
        if name is None:
            return written
        entry = self.materials[path] = self._entry(library.MATERIALS, path, name)
        unchecked |= consents
        return written.with_value(self._filled(path, written.value, entry, used_keys, name, unchecked))

    def _film(self, path: str, film: WrittenValue) -> WrittenValue:
        place = film.keys.get(OIL)
        film, name, unchecked = self._taken(path, film, OIL)
        if name is None:
            return film
        viscosity = film.value.get("viscosity", name.with_value({}))
        if not isinstance(viscosity.value, dict):
            message = "conflicts with `viscosity`, which it determines; remove one of the two"
            self.problems.add(place or name, f"{path}.{OIL}", message)
            return film
        entry = self._entry(library.OILS, f"{path}.{OIL}", name)
        filled = self._filled(f"{path}.viscosity", viscosity.value, entry, tuple(entry.values), name, unchecked)
        return film.with_value(film.value | {"viscosity": viscosity.with_value(filled)})

    def _wear(self, path: str, wear: WrittenValue) -> WrittenValue:
        """Return a section of wear with the coefficient of a named pair; the harder of unlike bodies does not wear."""
        wear, name, unchecked = self._taken(path, wear, PAIR)
        if name is None:
            return wear
        content = {"law": name.with_value(DEFAULT_WEAR_LAW)} | wear.value
        entry = self._entry(library.PAIRS, f"{path}.{PAIR}", name)
        content = self._filled(path, content, entry, ("coefficient",), name, unchecked)
        hard_body = self._harder_body(path.rpartition(".")[0])
        if not entry.hard_body_wears and f"{hard_body}_coefficient" not in content:
            zero, value = _by_name(name, 0), Value("m^2/N", 0.0, 0.0, 0.0)
            content[f"{hard_body}_coefficient"] = zero
            self.numbers.append(LibraryNumber(f"{path}.{hard_body}_coefficient", entry.name, value))
            unworn = {f"{hard_body}_initial": zero}
            wear = wear.with_value(content)
            return _changed(path, wear, ("running_in",), lambda _, part: part.with_value(unworn | part.entries))
        return wear.with_value(content)

    def _harder_body(self, joint: str) -> str:
        """Return the harder body of a joint by its materials; the journal, as in a bush, where they are not named."""
        material = f"{joint}.contact.material"
        bearing, journal = (self.materials.get(f"{material}.{body}") for body in BODIES)
        if bearing and journal and bearing.values["hardness"].typical > journal.values["hardness"].typical:
            return "bearing"
        return "journal"

    def _entry(self, entries: Mapping[str, Entry], path: str, name: WrittenValue) -> Entry:
        """Return the entry of a name; a wrong name is reported and gets any entry, whose numbers are never used."""
        if isinstance(name.value, str):
            try:
                return library.find_entry(entries, name.value)
            except InputError as error:
                self.problems.add(name, path, str(error))
        else:
            kind = next(kind for kind, item in library.LIBRARIES.items() if item is entries)
            message = f"found {quoted(name.value)}; expected a name that `clearsweep list {kind}` prints"
            self.problems.add(name, path, message)
        return next(iter(entries.values()))

    def _taken(self, path: str, section: WrittenValue, key: str) -> tuple[WrittenValue, WrittenValue | None, bool]:
        """Return a section without a name and `unchecked`, the name or None, and whether `unchecked` is true."""
        section, unchecked = self._pop_unchecked(path, section, (key,))
        return section.without(key), section.entries.get(key), unchecked

    def _pop_unchecked(self, path: str, section: WrittenValue, names: tuple[str, ...]) -> tuple[WrittenValue, bool]:
        """Return a section without its key `unchecked`, and whether that is true; names : keys it may belong to."""
        if UNCHECKED not in section.entries:
            return section, False
        flag = section.value[UNCHECKED]
        if not isinstance(flag.value, bool):
            self.problems.add(flag, f"{path}.{UNCHECKED}", f"found {quoted(flag.value)}; expected true or false")
        elif not any(name in section.value for name in names):
            message = f"belongs next to a name of the library ({' or '.join(names)}); remove it"
            self.problems.add(section.key_position(UNCHECKED), f"{path}.{UNCHECKED}", message)
        elif flag.value:
            self.unchecked_sections.append(path)
        return section.without(UNCHECKED), flag.value is True

    def _filled(
        self,
        path: str,
        content: dict[str, WrittenValue],
        entry: Entry,
        keys: tuple[str, ...],
        name: WrittenValue,
        unchecked: bool,  # noqa: FBT001 - what the user wrote
    ) -> dict[str, WrittenValue]:
        """Return a section completed by the numbers of an entry, and record these; unchecked numbers need consent."""
        missing = [key for key in keys if key not in content]
        if missing and not entry.checked and not unchecked:
            self.problems.add(name, path, unchecked_text(entry))
        self.numbers += [LibraryNumber(f"{path}.{key}", entry.name, entry.values[key]) for key in missing]
        return content | {key: _by_name(name, _written_text(entry.values[key])) for key in missing}


def pair_warnings(numbers: Iterable[LibraryNumber]) -> list[str]:
    """Return a warning for every joint whose wear pair is of other materials than its bodies."""
    names = {number.path: number.name for number in numbers}
    warnings = []
    for path, pair in names.items():
        joint, _, key = path.rpartition(".wear.")
        material = f"{joint}.contact.material"
        of_bodies = []
        for body in BODIES:
            keys = [f"{material}{part}.{number}" for part in (f".{body}", "") for number in MATERIAL_KEYS]
            of_bodies += [names[number] for number in keys if number in names][:1]
        if pair in library.PAIRS and key == "coefficient" and not library.is_of_pair(of_bodies, pair):
            others = " and ".join(dict.fromkeys(of_bodies))
            warnings.append(
                f"{joint}.wear.pair: {pair} is of other materials than {others} of {material}; take a pair of these "
                "(`clearsweep list pairs`), or write their `coefficient`"
            )
    return warnings


def replace_library_names(
    root: WrittenValue, problems: Problems
) -> tuple[WrittenValue, list[LibraryNumber], list[str]]:
    """Return the document with library names replaced by numbers, these numbers, and where values are unchecked."""
    replacer = _NameReplacer(problems)
    change_link = partial(replacer.with_material, keys=("young", "density"))

    def bodies(path: str, section: WrittenValue) -> WrittenValue:
        section = _changed(path, section, ("bodies",), bodies)
        links = [name for name in section.entries if name != "bodies"]
        return _changed(path, section, links, lambda nested, body: _changed(nested, body, ("elastic",), change_link))

    root = _changed("", root, ("mechanism",), bodies)
    root = _changed(
        "", root, ("joints",), lambda path, joints: _changed(path, joints, joints.entries, replacer.replace_in_joint)
    )
    return root, replacer.numbers, replacer.unchecked_sections


def _changed(
    path: str, section: WrittenValue, keys: Iterable[str], change: Callable[[str, WrittenValue], WrittenValue]
) -> WrittenValue:
    """Return a section, the one at `path`, with those values changed that it has at these keys."""
    changed = {
        key: change(f"{path}.{key}".removeprefix("."), section.value[key]) for key in keys if key in section.entries
    }
    return section.with_value(section.value | changed) if changed else section


def _part_of(entry: Entry, part: str) -> Entry:
    """Return an entry with the values of a section of the joint, '' for those of the joint itself."""
    paths = {key: key.rpartition(".") for key in entry.values if key != WIDTH}
    return entry._replace(values={paths[key][2]: entry.values[key] for key in paths if paths[key][0] == part})


def _by_name(name: WrittenValue, value: object) -> WrittenValue:
    """Return a value that follows from a name, at its position."""
    return WrittenValue(value, name.origin, name.line, name.column, by_name=True)


def _written_text(value: Value) -> str | float:
    """Return a typical value as a user would write it."""
    return value.typical if value.unit == "1" else f"{value.typical!r} {value.unit}"


_NAME_SUFFIX = f".{MATERIAL}"  # end of the path of a material's name


class VariedName(NamedTuple):
    """The name of a material or of a rolling bearing that varies."""

    base_name: str  # name that is outside the section that varies it
    numbers: Mapping[str, Mapping[str, float]]  # name that is allowed -> path -> number (SI) that follows from it
    refused: Mapping[str, str]  # another name -> why it is not allowed
    unchecked: bool = False  # the user answers for values from memory
    clearance: Mapping[str, Any] = {}  # path of a clearance that follows from the name -> what is written of it

    @property
    def paths(self) -> set[str]:
        """Return the paths of the numbers that follow from the name."""
        return {path for numbers in self.numbers.values() for path in numbers}


def find_varied_names(
    varied_paths: Iterable[str],
    library_numbers: Iterable[LibraryNumber],
    key_table: KeyTable,
    unchecked_sections: Iterable[str],
) -> dict[str, VariedName]:
    """Return path of a name -> the name, for the paths that a grid varies.

    unchecked_sections : paths of sections with `unchecked: true`
    """
    numbers_by_path = {item.path: item for item in library_numbers}
    varied_names = {}
    for path in varied_paths:
        section = path.removesuffix(_NAME_SUFFIX)
        joint, _, body_path = section.partition(".contact.material")
        if isinstance(key_table.get(f"{section}{_NAME_SUFFIX}"), Name) and joint != section:
            name_path, entries = f"{section}{_NAME_SUFFIX}", MATERIALS
            keys_by_path = {f"{section}.{key}": key for key in MATERIAL_KEYS}
            bodies = [body_path[1:]] if body_path else BODIES
            keys_by_path |= {f"{joint}.thermal.expansion.{body}": "expansion" for body in bodies}
        elif isinstance(key_table.get(path), Name) and path.endswith(f".{BEARING}"):
            section, name_path = path.removesuffix(f".{BEARING}"), path
            entries = {name: library.BEARINGS[parse_bearing_name(name).designation] for name in bearing_names()}
            keys_by_path = {f"{section}.{key}": key for entry in entries.values() for key in entry.values}
        else:
            continue
        library_keys = {number: key for number, key in keys_by_path.items() if number in numbers_by_path}
        if library_keys:
            base_name = numbers_by_path[next(iter(library_keys))].name
            unchecked = any(f"{section}.".startswith(f"{consenting}.") for consenting in unchecked_sections)
            varied_names[name_path] = _varied_name(base_name, entries, library_keys, unchecked=unchecked)
    return varied_names


def _varied_name(
    base_name: str, entries: Mapping[str, Entry], library_keys: Mapping[str, str], *, unchecked: bool
) -> VariedName:
    """Return a name that varies, with what is allowed in its place; library_keys : path of a number -> its key."""
    refused, summary = dict[str, str](), entries[base_name].summary
    for name, entry in entries.items():
        if not {*library_keys.values()} <= {*entry.values}:
            refused[name] = f"it is a {entry.summary}, and {base_name} a {summary}; write a grid for each kind"
        elif not entry.checked and not unchecked:
            refused[name] = unchecked_text(entry)
    numbers = {
        name: {
            path: entry.values[key].typical if key != COUNT else round(entry.values[key].typical)
            for path, key in library_keys.items()
        }
        for name, entry in entries.items()
        if name not in refused
    }
    return VariedName(base_name, numbers, refused, unchecked)


def keys_of_names(varied_names: Mapping[str, VariedName]) -> KeyTable:
    """Return the keys of the names that vary."""
    keys: KeyTable = {}
    for path, varied in varied_names.items():
        noun = "material" if path.endswith(_NAME_SUFFIX) else "bearing"
        keys[path] = Word(
            tuple(varied.numbers), f"the {noun}", sweep=True, noun=noun, role=CHOICE, refused=varied.refused
        )
    return keys


def name_path(path: str, key_table: KeyTable) -> str:
    """Return the path of a material's name if `path` is its section, otherwise the unchanged path."""
    name = f"{path}{_NAME_SUFFIX}"
    return name if isinstance(key_table.get(name), Word) else path


def numbers_of_names(
    path: str, varied_names: Mapping[str, VariedName], axes: Mapping[str, tuple[Any, ...]]
) -> Iterator[float]:
    """Yield the values of a number that follows from names on an axis."""
    for name, varied in varied_names.items():
        if path in varied.paths:
            yield from (varied.numbers[word][path] for word in axes.get(name, ()))


def put_numbers_of_names(values_by_path: dict[str, Any], varied_names: Mapping[str, VariedName]) -> dict[str, Any]:
    """Return the values of a case with numbers in place of the names of its materials and bearings."""
    names = {path: values_by_path.pop(path) for path in varied_names if path in values_by_path}
    for path, name in names.items():
        numbers = varied_names[path].numbers[name]
        values_by_path |= {number: value for number, value in numbers.items() if number in values_by_path}
    return values_by_path


def with_names(base: Mapping[str, Any], varied_names: Mapping[str, VariedName]) -> dict[str, Any]:
    """Return values outside all axes with the names that vary in place of their numbers."""
    paths = {path for varied in varied_names.values() for path in varied.paths}
    values = {path: value for path, value in base.items() if path not in paths}
    for path, varied in varied_names.items():
        values |= {path: varied.base_name, **varied.clearance}
        if varied.unchecked:
            section = path.removesuffix(_NAME_SUFFIX).removesuffix(f".{BEARING}")
            values[f"{section}.{UNCHECKED}"] = True
    return values


def written_names(varied_names: Mapping[str, VariedName], root: WrittenValue) -> dict[str, WrittenValue]:
    """Return written names for the keys outside the section that varies them, with a position."""
    position = root.origin, root.line, root.column
    return {path: WrittenValue(varied.base_name, *position) for path, varied in varied_names.items()}


def text_of_name(written: WrittenValue) -> WrittenValue:
    """Return the name of a bearing as text: 6204 is a number of YAML."""
    is_number = isinstance(written.value, int) and not isinstance(written.value, bool)
    return written.with_value(str(written.value)) if is_number else written
