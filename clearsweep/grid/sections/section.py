"""Sections that choose cases: a table of keys each, and one reader for all of them.

The JSON Schema and the page of keys follow from the same tables.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from ...contracts.catalogue import Field
from ...language import quantity
from ...language.errors import InputError, nearest, shown
from ..written.document import Problems, WrittenValue

ADDED = "added"  # in a section that adds cases: dotted path -> the values of the added cases
#: JSON Schemas of values in several sections.
QUANTITY = {"$ref": "#/$defs/quantity"}
PAIR = {"type": "array", "minItems": 2, "maxItems": 2}
FIT_NAME = {"fit": {"type": "string", "description": "a clearance fit of ISO 286, such as H7/f7"}}
FIT_FORM: dict[str, Any] = {
    "type": "object",
    "required": ["fit"],
    "additionalProperties": False,
    "properties": FIT_NAME,
}
FITS_FORM: dict[str, Any] = {
    "type": "object",
    "required": ["fits"],
    "additionalProperties": False,
    "properties": {"fits": {"type": "array", "minItems": 1, "items": {"type": "string"}}},
}
NAMES = {"anyOf": [{"type": "string"}, {"type": "array", "minItems": 1, "items": {"type": "string"}}]}


def named_forms(schemas: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the schemas of sections with a single key each: key -> schema of its value."""
    return [
        {"type": "object", "required": [key], "additionalProperties": False, "properties": {key: form}}
        for key, form in schemas.items()
    ]


class Key(NamedTuple):
    """A key of such a section: a word of a few, a whole number, or something that its section reads itself."""

    name: str
    text: str  # its meaning
    words: tuple[str, ...] = ()
    whole: tuple[int, int] | None = None  # smallest and largest whole number
    default: str | int | None = None
    required: bool = False
    missing: str = ""  # what to write where it is missing, of a required word or whole number
    noun: str = ""  # what the words are, in messages
    form: Mapping[str, Any] = {}  # JSON Schema beyond words or whole numbers
    internal: bool = False  # a run writes it, no user

    @property
    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the key."""
        values: dict[str, Any] = {"enum": list(self.words)} if self.words else {}
        values |= {"type": "integer", "minimum": self.whole[0]} if self.whole else {}
        return {"description": self.text, **values, **self.form}


_ADDED_KEY = Key(ADDED, "do not write it: run.json lists the added cases here", form={"type": "object"}, internal=True)


def cases_key(low: int, high: int) -> Key:
    """Return the key for the number of cases that a search may add, from `low` to `high`."""
    text = "most cases to add, a whole number" + (f" of at least {low}" if low > 1 else "")
    return Key("cases", text, whole=(low, high), required=True, missing="; write how many cases there may be")


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
        """Return the keys, those that a run writes included."""
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
        section = section_in(root, self.name)
        if section is None:
            return None
        if not isinstance(section.value, dict):
            sentence = f"found {shown(section.value)}; expected a section such as {self.example}"
            problems.add(section, self.name, sentence)
            return None
        for key in section.value:
            if key not in {known.name for known in self.all_keys}:
                sentence = f"unknown key '{key}'{nearest(key, self.known)} (allowed: {', '.join(self.known)})"
                problems.add(section.key_place(key), f"{self.name}.{key}", sentence)
        return section

    def read(self, problems: Problems, section: WrittenValue) -> dict[str, Any]:
        """Return the words and whole numbers of the section by key, None with a problem if missing or invalid."""
        return {key.name: self._value(problems, section, key) for key in self.keys if key.words or key.whole}

    def _value(self, problems: Problems, section: WrittenValue, key: Key) -> str | int | None:
        """Return a word or a whole number, or None if it is missing or invalid."""
        written, where = section.value.get(key.name), f"{self.name}.{key.name}"
        if written is None:
            if key.required:
                known = f" (known: {', '.join(key.words)})" if key.words else ""
                problems.add(section, where, f"is missing{key.missing}{known}")
            return key.default
        if key.words:
            if written.value in key.words:
                return str(written.value)
            problems.add(written, where, _wrong_word(key, written.value))
            return None
        assert key.whole is not None  # `read` asks for no other key
        low, high = key.whole
        try:
            number = quantity.exact(written.value, "1")
        except InputError as error:
            problems.add(written, where, str(error))
            return None
        if number.denominator == 1 and low <= number <= high:
            return int(number)
        problems.add(written, where, f"found {written.value}; allowed: a whole number from {low} to {high:,}")
        return None


def _wrong_word(key: Key, value: Any) -> str:
    """Return what is wrong with a word."""
    if not key.noun:
        return f"found {shown(value)}; expected {' or '.join(key.words)}"
    suggestion = nearest(value, key.words) if isinstance(value, str) else ""
    return f"unknown {key.noun} {shown(value)}{suggestion} (known: {', '.join(key.words)})"


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
        form = {"type": "object", "minProperties": 1, "additionalProperties": dict(self.entry)}
        return {"description": self.text, **form}

    def entries(self, problems: Problems, root: WrittenValue) -> dict[str, WrittenValue]:
        """Return the entries, {} if the section is missing, or empty, which is reported."""
        section = section_in(root, self.name)
        if section is None:
            return {}
        if not isinstance(section.value, dict) or not section.value:
            sentence = f"contains no {self.noun}; for example: `{self.example}`, or leave the key '{self.name}' out"
            problems.add(section, self.name, sentence)
            return {}
        return dict(section.value)


def section_in(root: WrittenValue, name: str) -> WrittenValue | None:
    """Return the section of that name, or None."""
    return root.value.get(name) if isinstance(root.value, dict) else None


class Reading(NamedTuple):
    """How the values of one key are read."""

    value: Callable[[WrittenValue], Any]  # in SI, or a word; None, and a problem, where it is wrong
    unit: str  # SI; '' for words
    fields: tuple[Field, ...] = ()  # meanings of the key; drawn values must stay within their ranges


def half_bare(problems: Problems, where: str, items: Iterable[WrittenValue], unit: str) -> bool:
    """Report numbers without a unit next to others that have one, and return whether there are any.

    `[200 rpm, 500]` would mean 500 rad/s, which is hardly ever intended.
    """
    items = list(items)
    named = next((item for item in items if _reads(item.value, unit)), None) if unit not in ("", "1") else None
    bare = [item for item in items if quantity.is_bare(item.value)] if named else []
    for item in bare:
        sentence = (
            f"found {item.value} without a unit next to {shown(named.value if named else '')}; alone it would mean "
            f"{item.value} {unit}: write the unit of each, or of none"
        )
        problems.add(item, where, sentence)
    return bool(bare)


def _reads(value: Any, unit: str) -> bool:
    """Return whether a quantity is written with a unit of the right dimension."""
    try:
        return quantity.has_unit(value) and quantity.exact(value, unit) is not None
    except InputError:
        return False
