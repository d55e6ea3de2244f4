"""Sections of a grid that choose, add or assess cases: their tables of keys, their reader, and the state of reading.

A kind of key is a class with its JSON Schema and its reader; the page of keys follows from the same tables.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ...contracts.catalogue import Field, Mechanism, Outline
from ...contracts.search import Search
from ...language import np, quantity
from ...language.errors import InputError, did_you_mean, mistake_of, quoted
from ..keys import KeyTable, Number, Word, deciding_paths, value_key
from ..keys.library_names import LibraryNumber, VariedName, numbers_of_names
from ..library.fits import GROUPS, MOUNTING_KEYS, Fit
from ..written import MistakeError, Problems, WrittenValue, placed
from ..written.definitions import NO_DEFINITIONS, Definitions

ADDED = "added"  # in a section that adds cases: dotted path -> the values of the added cases
#: JSON Schemas of values in several sections.
QUANTITY_SCHEMA = {"$ref": "#/$defs/quantity"}
PAIR_SCHEMA = {"type": "array", "minItems": 2, "maxItems": 2}
MOUNTING_SCHEMA = {
    "fit": {"type": "string", "description": MOUNTING_KEYS["fit"]},
    "inner_warmer": {"description": MOUNTING_KEYS["inner_warmer"], **QUANTITY_SCHEMA},
}


def _named_schema(properties: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of a mapping whose first key is required."""
    first = next(iter(properties))
    return {"type": "object", "required": [first], "additionalProperties": False, "properties": dict(properties)}


#: Field.fit -> schema of a clearance that is named.
NAME_SCHEMAS = {
    "fit": _named_schema({"fit": {"type": "string", "description": "a clearance fit of ISO 286, such as H7/f7"}}),
    "group": _named_schema(
        {"group": {"enum": list(GROUPS), "description": "a group of ISO 5753-1"}, **MOUNTING_SCHEMA}
    ),
}
#: Axes of fits, and of groups.
AXES_OF_NAMES = [
    _named_schema({"fits": {"type": "array", "minItems": 1, "items": {"type": "string"}}}),
    _named_schema({"groups": {"type": "array", "minItems": 1, "items": {"enum": list(GROUPS)}}, **MOUNTING_SCHEMA}),
]


def entries_schema(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of a section with at least one entry of any name; entry : the schema of its value."""
    return {"type": "object", "minProperties": 1, "additionalProperties": dict(entry)}


def single_key_schemas(schemas: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the schemas of sections with a single key each: key -> schema of its value."""
    return [_named_schema({key: form}) for key, form in schemas.items()]


@dataclass(frozen=True)
class Key:
    """A key of such a section; this kind is read by its section."""

    name: str
    text: str  # its meaning
    form: Mapping[str, Any] = field(default_factory=dict)  # JSON Schema of its values
    required: bool = False  # for editors, too
    missing: str = ""  # what to write where it is missing; without text, only a required key is reported
    default: Any = None
    internal: bool = False  # a run writes it, no user

    @property
    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the key."""
        return {"description": self.text, **self.values(), **self.form}

    def values(self) -> dict[str, Any]:
        """Return the JSON Schema of the values that this kind of key may have."""
        return {}

    def choices_text(self) -> str:
        """Return the known values for messages, or '' if there is no list of them."""
        return ""

    def read(self, problems: Problems, key_path: str, written: WrittenValue, unit: str) -> Any:
        """Return the value at the key at `key_path`, of an SI `unit`; MistakeError if it is wrong."""
        return written


@dataclass(frozen=True)
class WordKey(Key):
    """A key with one of a few words."""

    words: tuple[str, ...] = ()
    noun: str = ""  # what the words are, in messages

    def values(self) -> dict[str, Any]:
        """Return the JSON Schema of the words."""
        return {"enum": list(self.words)}

    def choices_text(self) -> str:
        """Return the known words."""
        return f" (known: {', '.join(self.words)})"

    def read(self, problems: Problems, key_path: str, written: WrittenValue, unit: str) -> str:
        """Return the word."""
        word = written.value
        if word in self.words:
            return str(word)
        suggestion = did_you_mean(word, self.words) if isinstance(word, str) else ""
        message = f"unknown {self.noun} {quoted(word)}{suggestion}{self.choices_text()}"
        other = f"found {quoted(word)}; expected {' or '.join(self.words)}"
        raise MistakeError(written, key_path, message if self.noun else other)


@dataclass(frozen=True)
class WordListKey(Key):
    """A key with a list of words, or a single one; without the key, all words apply."""

    words: tuple[str, ...] = ()
    noun: str = ""  # what one of the words is, in messages

    def values(self) -> dict[str, Any]:
        """Return the JSON Schema of the list."""
        return {"type": "array", "minItems": 1, "items": {"enum": list(self.words)}}

    def read(self, problems: Problems, key_path: str, written: WrittenValue, unit: str) -> tuple[str, ...]:
        """Return the known words of the list, in the order of `words`."""
        items = written.items
        for item in items:
            if item.value not in self.words:
                suggestion = did_you_mean(str(item.value), self.words) or f" (known: {', '.join(self.words)})"
                problems.add(item, key_path, f"{quoted(item.value)} is no {self.noun}{suggestion}")
        if not items:
            problems.add(written, key_path, f"is empty; allowed: {', '.join(self.words)}")
        return tuple(word for word in self.words if word in [item.value for item in items])


@dataclass(frozen=True)
class NamesKey(Key):
    """A key with a name of the grid, such as a dotted path or a column, or with a list of names."""

    noun: str = ""  # what a name is, in messages

    def values(self) -> dict[str, Any]:
        """Return the JSON Schema of the names."""
        return {"anyOf": [{"type": "string"}, {"type": "array", "minItems": 1, "items": {"type": "string"}}]}

    def read(self, problems: Problems, key_path: str, written: WrittenValue, unit: str) -> list[WrittenValue]:
        """Return the names with their positions, each once."""
        items = written.items
        invalid = [item for item in items if not isinstance(item.value, str)]
        if invalid or not items:
            faulty = invalid[0] if invalid else written
            message = f"found {quoted(faulty.value)}; expected a {self.noun}, or a list of such"
            raise MistakeError(faulty, key_path, message)
        first_items: dict[str, WrittenValue] = {}
        for item in items:
            if item.value in first_items:
                problems.add(item, key_path, f"{item.value} occurs twice; remove one of them")
            first_items.setdefault(item.value, item)
        return list(first_items.values())


@dataclass(frozen=True)
class CountKey(Key):
    """A key with a whole number."""

    low: int = 1  # smallest
    high: int = 1  # largest

    def values(self) -> dict[str, Any]:
        """Return the JSON Schema of the number."""
        return {"type": "integer", "minimum": self.low}

    def read(self, problems: Problems, key_path: str, written: WrittenValue, unit: str) -> int:
        """Return the number."""
        number = placed(written, key_path, quantity.exact, written.value, "1")
        if number.denominator == 1 and self.low <= number <= self.high:
            return int(number)
        message = f"found {written.value}; allowed: a whole number from {self.low} to {self.high:,}"
        raise MistakeError(written, key_path, message)


@dataclass(frozen=True)
class QuantityKey(Key):
    """A key with a quantity, whose unit may depend on other keys."""

    bounds: Field | None = None  # range, where it is the same for every unit

    def values(self) -> dict[str, Any]:
        """Return the JSON Schema of the quantity."""
        return QUANTITY_SCHEMA

    def read(self, problems: Problems, key_path: str, written: WrittenValue, unit: str) -> float:
        """Return the quantity in SI."""
        value: float = placed(written, key_path, quantity.read, written.value, unit)
        if self.bounds is None or self.bounds.contains(value):
            return value
        raise MistakeError(written, key_path, f"found {value:.6g}; allowed: {self.bounds.allowed(value)}")


@dataclass(frozen=True)
class RangeKey(Key):
    """A key with the two ends of a range, which are read as the values of an axis."""

    def values(self) -> dict[str, Any]:
        """Return the JSON Schema of the range."""
        return PAIR_SCHEMA | {"items": QUANTITY_SCHEMA}

    def read(self, problems: Problems, key_path: str, written: WrittenValue, unit: str) -> WrittenValue:
        """Return the ends as they are written."""
        if isinstance(written.value, list) and len(written.value) == 2:
            return written
        raise MistakeError(written, key_path, f"found {quoted(written.value)}{self.missing}")


@dataclass(frozen=True)
class EntriesKey(Key):
    """A key with at least one entry; keys of entries are names or paths of the grid."""

    entry: Mapping[str, Any] = field(default_factory=dict)  # JSON Schema of a value

    def values(self) -> dict[str, Any]:
        """Return the JSON Schema of the entries."""
        return entries_schema(self.entry)

    def read(self, problems: Problems, key_path: str, written: WrittenValue, unit: str) -> WrittenValue:
        """Return the entries with their positions."""
        if written.entries:
            return written
        raise MistakeError(written, key_path, f"found {quoted(written.value)}{self.missing}")


_ADDED_KEY = Key(ADDED, "do not write it: run.json lists the added cases here", {"type": "object"}, internal=True)


def cases_key(low: int, high: int) -> CountKey:
    """Return the key for the number of cases that a search may add, from `low` to `high`."""
    text = "largest number of cases to add, a whole number" + (f" of at least {low}" if low > 1 else "")
    missing = "; write the largest number of cases"
    return CountKey("cases", text, low=low, high=high, required=True, missing=missing)


class KeySection(NamedTuple):
    """A section with keys of its own."""

    name: str
    text: str  # what it is
    example: str  # its content in a grid
    keys: tuple[Key, ...]
    conditions: Mapping[str, Any] = {}  # further JSON Schema
    adds_cases: bool = True

    @property
    def known(self) -> tuple[str, ...]:
        """Return the keys that a user may write."""
        return tuple(key.name for key in self.keys if not key.internal)

    @property
    def all_keys(self) -> tuple[Key, ...]:
        """Return all keys, including those that a run writes."""
        return (*self.keys, *((_ADDED_KEY,) if self.adds_cases else ()))

    @property
    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the section."""
        required = [key.name for key in self.keys if key.required]
        return {
            "description": self.text,
            "type": "object",
            **({"required": required} if required else {}),
            "additionalProperties": False,
            "properties": {key.name: key.schema for key in self.all_keys},
            **self.conditions,
        }

    def find(self, problems: Problems, root: WrittenValue) -> WrittenValue | None:
        """Return the section, or None if it is missing or unreadable; report unknown keys in it."""
        section: WrittenValue | None = root.value.get(self.name)
        if section is None:
            return None
        if not isinstance(section.value, dict):
            message = f"found {quoted(section.value)}; expected a section such as {self.example}"
            problems.add(section, self.name, message)
            return None
        report_unknown_keys(problems, self.name, section, self.known, {key.name for key in self.all_keys})
        return section

    def value(self, problems: Problems, section: WrittenValue, name: str, unit: str = "1") -> Any:
        """Return the value of one key or its default; None, with a problem, if it is missing or wrong.

        unit : SI unit, for a quantity
        """
        key, key_path = next(key for key in self.keys if key.name == name), f"{self.name}.{name}"
        written = section.value.get(name)
        if written is not None:
            with problems.reporting():
                return key.read(problems, key_path, written, unit)
            return None
        if key.required or key.missing:
            problems.add(section, key_path, f"is missing{key.missing}{key.choices_text()}")
        return key.default


class NameSection(NamedTuple):
    """A section whose keys are names or paths of the grid."""

    name: str
    text: str  # what it is
    noun: str  # what it has entries of, in messages
    example: str  # an entry
    entry: Mapping[str, Any]  # JSON Schema of a value

    @property
    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the section."""
        return {"description": self.text, **entries_schema(self.entry)}

    def entries(self, problems: Problems, root: WrittenValue) -> dict[str, WrittenValue]:
        """Return the entries, or {} if the section is missing or empty; an empty section is reported."""
        section: WrittenValue | None = root.value.get(self.name)
        if section is None:
            return {}
        if not section.entries:
            message = f"contains no {self.noun}; for example: `{self.example}`, or leave the key '{self.name}' out"
            problems.add(section, self.name, message)
            return {}
        return dict(section.value)


def report_unknown_keys(
    problems: Problems, key_path: str, section: WrittenValue, known: Collection[str], accepted: Collection[str] = ()
) -> bool:
    """Report keys of the section that are neither known nor accepted, and return whether there are any."""
    unknown = [key for key in section.value if key not in known and key not in accepted]
    for key in unknown:
        message = f"unknown key '{key}'{did_you_mean(key, known)} (allowed: {', '.join(known)})"
        problems.add(section.key_position(key), f"{key_path}.{key}", message)
    return bool(unknown)


def read_quantity(problems: Problems, key_path: str, written: WrittenValue, unit: str) -> float | None:
    """Return a quantity in SI, or None, with a problem, if it is not a quantity of this unit."""
    with problems.reporting():
        value: float = placed(written, key_path, quantity.read, written.value, unit)
        return value
    return None


class ValueReader(NamedTuple):
    """How the values of one key are read."""

    value: Callable[[WrittenValue], Any]  # in SI, or a word; None, and a problem, where it is wrong
    unit: str  # SI; '' for words
    fields: tuple[Field, ...] = ()  # meanings of the key; drawn values must stay within their ranges


def report_mixed_units(problems: Problems, key_path: str, items: Iterable[WrittenValue], unit: str) -> bool:
    """Report numbers without a unit next to others that have one, and return whether there are any.

    `[200 rpm, 500]` would mean 500 rad/s, which is hardly ever intended.
    """
    items = list(items)
    with_unit = (item for item in items if unit not in ("", "1") and quantity.has_unit(item.value))
    item_with_unit = next((item for item in with_unit if not mistake_of(quantity.exact, item.value, unit)), None)
    bare_items = [item for item in items if quantity.is_bare(item.value)] if item_with_unit else []
    for item in bare_items:
        message = (
            f"found {item.value} without a unit next to {quoted(item_with_unit.value if item_with_unit else '')}; "
            f"alone it would mean {item.value} {unit}: write the unit of each, or of none"
        )
        problems.add(item, key_path, message)
    return bool(bare_items)


class Sample(NamedTuple):
    """The section `sample` without its distributions."""

    method: str
    n: int
    seed: int
    points: "np.ndarray"  # (rows, variables) in the open interval (0, 1); the rows of the design
    earlier_values: dict[str, WrittenValue]  # values drawn earlier, which are kept

    def resolved(self) -> dict[str, Any]:
        """Return the section in the form of a grid file."""
        return {"method": self.method} | ({"n": self.n, "seed": self.seed} if self.method != "one-at-a-time" else {})


@dataclass
class Reader:
    """The values of a document, path by path."""

    problems: Problems
    mechanism: Mechanism  # the named mechanism, or the likeliest one
    outline: Outline
    keys_in_use: KeyTable = field(default_factory=dict)  # the keys in use: sections that are left out are missing
    sections: dict[str, WrittenValue] = field(default_factory=dict)
    written: dict[str, WrittenValue] = field(default_factory=dict)  # values of the keys in use
    written_axes: dict[str, WrittenValue] = field(default_factory=dict)
    names: dict[str, frozenset[str]] = field(default_factory=dict)  # path of a law's name -> names in use
    unread_laws: set[str] = field(default_factory=set)  # paths of law names that could not be read
    unread_sections: set[str] = field(default_factory=set)  # paths of sections that could not be read
    values: dict[str, Any] = field(default_factory=dict)  # in SI; includes defaults of words
    axes: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    varied_by: dict[str, str] = field(default_factory=dict)  # varied path -> the section that varies it
    keys_in_plane: Collection[str] = ()  # of a mechanism in space: those of the same mechanism in the plane
    sample: Sample | None = None
    drawn_paths: tuple[str, ...] = ()  # the paths under `sample`
    distributions: dict[str, dict[str, Any]] = field(default_factory=dict)  # of drawn paths, SI
    fits: dict[str, list[Fit]] = field(default_factory=dict)  # path of a clearance -> its fits as written
    labels: dict[str, tuple[str, ...]] = field(default_factory=dict)  # path of an axis -> the labels of its values
    written_columns: dict[str, int] = field(default_factory=dict)  # section of cases -> number of its paths
    case_labels: dict[str, list[str]] = field(default_factory=dict)  # header in the table of cases -> texts of its rows
    # path of a number -> the value taken from a library
    library_numbers: dict[str, LibraryNumber] = field(default_factory=dict)
    figures: dict[str, str] = field(default_factory=dict)  # figure of merit of the cases -> unit
    unrated_figures: dict[str, str] = field(default_factory=dict)  # figure that needs a rating -> what is missing
    limits: dict[str, Any] = field(default_factory=dict)  # as in a resolved grid; see `verdict`
    # path of a limit -> unit in which it is written
    limit_units: dict[str, quantity.WrittenUnit] = field(default_factory=dict)
    searches: Mapping[str, type[Search]] = field(default_factory=dict)  # those that a grid may have, by section
    search: Search | None = None  # that of the grid
    choices: dict[str, Any] = field(default_factory=dict)  # path of a search -> the kind of its values, or its fits
    added_path: str = ""  # the section that contains the added cases
    added_written: dict[str, WrittenValue] = field(default_factory=dict)  # their values, by path
    added_cases: dict[str, list[Any]] = field(default_factory=dict)  # the same, SI
    uncertain: dict[str, dict[str, Any]] = field(default_factory=dict)  # path of a coefficient -> its distribution, SI
    roles: dict[str, str] = field(default_factory=dict)  # varied path -> its role as the grid sets it
    user_figures: dict[str, str] = field(default_factory=dict)  # name -> expression of columns
    warnings: list[str] = field(default_factory=list)  # sentences on what may be meant otherwise
    defined: Definitions = NO_DEFINITIONS
    varied_names: dict[str, VariedName] = field(default_factory=dict)  # path of a name of the library -> it

    def position_of(self, path: str) -> WrittenValue:
        """Return the value whose position locates a mistake at `path`: itself, or the section that lacks it."""
        while path and path not in self.written_axes and path not in self.written and path not in self.sections:
            path = path.rpartition(".")[0]
        return self.written_axes.get(path) or self.written.get(path) or self.sections[path]

    def report(self, path: str, message: str, at: str = "") -> None:
        """Report a mistake at `path`; its position is that of the path `at`, by default the same."""
        self.problems.add(self.position_of(at or path), path, message)

    def require(self, path: str, message: str, at: str = "") -> None:
        """Report a value or a section that is missing, with what to write; see `report`."""
        if not self.is_given(path):
            self.report(path, f"is missing; {message}", at)

    def text(self, path: str, value: Any) -> str:
        """Return a value of `path` as it was written, or in SI if it follows from other values."""
        key = self.keys_in_use.get(path)
        unit = key.fields(self.names)[0].unit if isinstance(key, Number) and key.is_used(self.names) else "1"
        entry = self.written_axes.get(path) or self.written.get(path)
        for item in entry.items if entry else ():
            with suppress(InputError):
                if quantity.read(item.value, unit) == value:
                    return quantity.written_text(item.value, unit)
        return quantity.written_text(float(value), unit)

    def is_given(self, path: str) -> bool:
        """Return whether a value or a section is written or swept."""
        return path in self.written or path in self.written_axes or path in self.sections

    def vary_together(self, *paths: str) -> bool:
        """Return whether these paths vary together, row by row."""
        if any(varied.paths.issuperset(paths) for varied in self.varied_names.values()):
            return True
        dependents = self.defined.dependents
        if all(path in dependents for path in paths):  # both follow one name
            return len({self.defined.varied_in(dependents[path]) for path in paths}) == 1
        sections = {self.varied_by.get(path) for path in paths}
        in_step = (name for name, search in self.searches.items() if search.in_step)
        return len(sections) == 1 and sections.isdisjoint((None, "sweep", *in_step))

    def values_of(self, path: str) -> tuple[Any, ...]:
        """Return every value of `path`: its axis, written value or default, or () if unknown or left out."""
        if path in self.written_axes:
            return self.axes.get(path, ())
        if path in self.defined.dependents:
            return self.defined.possible_values(path, self.axes, self.varied_by)
        if any(path in varied.paths for varied in self.varied_names.values()):
            return tuple(numbers_of_names(path, self.varied_names, self.axes))
        if path in self.values:
            return (self.values[path],)
        key = self.keys_in_use.get(path)
        fields = key.fields(self.names) if isinstance(key, Number) and path not in self.written else ()
        return tuple(field.default for field in fields if field.default is not None)


def make_word_axis(reader: Reader, path: str) -> None:
    """Turn the word at `path`, which is read and not swept, into an axis if the search adds cases with others."""
    if path in reader.written_axes or path not in reader.values:
        return
    if any(search.varies_word(reader, path) for search in reader.searches.values()):
        reader.written_axes[path] = reader.position_of(path).with_value(reader.values[path])
        reader.varied_by[path] = "sweep"
        reader.axes[path] = (reader.values.pop(path),)
        if path in reader.added_written:
            reader.added_cases[path] = [item.value for item in reader.added_written[path].value]


def find_added_cases(reader: Reader, root: WrittenValue) -> None:
    """Record the added cases that the section of a search lists."""
    for name in reader.searches:
        written = root.value.get(name, WrittenValue({})).entries.get(ADDED)
        if written is None:
            continue
        if isinstance(written.value, dict):
            reader.added_path, reader.added_written = f"{name}.{ADDED}", dict(written.value)
        else:
            reader.problems.add(written, f"{name}.{ADDED}", "is a key of run.json only; remove it")


def added_rows(reader: Reader) -> tuple[tuple[Any, ...], ...]:
    """Return the values of every added case, in the order of the axes."""
    if not reader.added_written:
        return ()
    values = [reader.added_cases.get(path, []) for path in reader.axes]
    if set(reader.added_written) != set(reader.axes) or len(set(map(len, values))) > 1:
        position = next(iter(reader.added_written.values()))
        reader.problems.add(position, reader.added_path, "lacks a value of a swept path for some case; remove the key")
        return ()
    return tuple(zip(*values, strict=True))


def check_always_used(reader: Reader, position: WrittenValue, section: str, path: str) -> None:
    """Report a swept key that some of the swept laws do not use, because every added case has a value of each key."""
    key = value_key(reader.keys_in_use, path)
    if isinstance(key, Word):
        return
    for chooser in deciding_paths(key):
        for law in reader.axes.get(chooser, ()):
            if not key.is_used(reader.names | {chooser: frozenset({law})}):
                message = f"{path} is not used by {law}; with `{section}` every law that is tried must use every key"
                reader.problems.add(position, section, f"{message} that is swept")
                return
