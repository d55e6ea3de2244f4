"""The keys of a grid file; here are their kinds."""

from collections.abc import Callable, Mapping, Set
from typing import Any, NamedTuple

from ...contracts.catalogue import Columns, Field

Condition = tuple[str, frozenset[str]]  # (path of a law's name, the names with which a key is in use)
NamesInUse = Mapping[str, Set[str]]  # path of a law's name -> the names that the grid uses


class Use(NamedTuple):
    """One meaning of a key, and the law names that select it."""

    field: Field
    when: tuple[Condition, ...] = ()


class Number(NamedTuple):
    """A key that contains a quantity."""

    uses: tuple[Use, ...]
    role: str  # one of contracts.roles, where it is varied
    sweep: bool = True

    def fields(self, names: NamesInUse) -> tuple[Field, ...]:
        """Return the meanings of the key with these law names, or () if it is unused."""
        return tuple(dict.fromkeys(key_use.field for key_use in self.uses if _conditions_met(key_use.when, names)))

    def is_used(self, names: NamesInUse) -> bool:
        """Return whether the key is in use with these law names."""
        return bool(self.fields(names))


class ConditionalDefault(NamedTuple):
    """A conditional default of a Word; a path counts if it is written or swept."""

    word: str
    one_of: tuple[str, ...] = ()  # at least one of these paths exists, if any are listed
    all_of: tuple[str, ...] = ()  # all of these paths exist
    none_of: tuple[str, ...] = ()  # none of these paths exists
    unless: Condition = ("", frozenset())  # none of these law names is in use

    def applies(self, is_given: Callable[[str], bool], names: NamesInUse) -> bool:
        """Return whether the default applies; `is_given` returns whether a path is written or swept."""
        is_present = all(map(is_given, self.all_of)) and (not self.one_of or any(map(is_given, self.one_of)))
        path, refused_words = self.unless
        return is_present and not any(map(is_given, self.none_of)) and refused_words.isdisjoint(names.get(path, ()))


class Word(NamedTuple):
    """A key whose value is one of a few words."""

    options: tuple[str, ...]
    text: str
    default: str | None = None
    sweep: bool = False
    noun: str = "word"  # its name in messages
    when: tuple[Condition, ...] = ()
    may_be_unused: bool = False  # may be written even if it is not in use
    conditional_default: ConditionalDefault | None = None
    refused: Mapping[str, str] = {}  # a plausible word -> why it is not allowed
    role: str = ""  # one of contracts.roles, where it can be swept
    other_forms: tuple[Mapping[str, Any], ...] = ()  # JSON Schemas of what may replace it

    def is_used(self, names: NamesInUse) -> bool:
        """Return whether the key is in use with these law names."""
        return _conditions_met(self.when, names)


class Name(NamedTuple):
    """A key whose text decides numbers, as the name of a library's entry; they replace it before all else is read."""

    options: tuple[str, ...]
    text: str
    sweep: bool = False  # names cannot be swept, but the numbers that replace them can


class Flag(NamedTuple):
    """A key whose value is true or false; false means absent, unless the key has a default."""

    text: str
    default: bool | None = None  # with a default, the value is always stored
    sweep: bool = False


class NameList(NamedTuple):
    """A key that contains a list of names, which are known once the cases are known."""

    text: str
    noun: str  # what is expected, in messages
    example: str
    sweep: bool = False


class Table(NamedTuple):
    """A key that contains a table, or the name of its file."""

    columns: Columns
    when: tuple[Condition, ...] = ()
    optional: bool = False
    sweep: bool = False

    def is_used(self, names: NamesInUse) -> bool:
        """Return whether the key is in use with these law names."""
        return _conditions_met(self.when, names)


def _conditions_met(when: tuple[Condition, ...], names: NamesInUse) -> bool:
    """Return whether every condition allows one of the names in use; a missing section has none."""
    return all(not words.isdisjoint(names.get(path, ())) for path, words in when)


class Section(NamedTuple):
    """A key that contains further keys."""

    text: str
    need: str = "required"  # 'required', 'optional', or 'implied': exists even if it is not written
    items: int = 0  # number of items of a list; 0: it is not a list
    scalar_factors: tuple[int, ...] = ()  # of a list: factors that turn a single quantity into the items
    unless: str = ""  # a sibling section that may replace it
    needs: str = ""  # a sibling of its parent section without which it does not exist


COUNT_WORDS = {2: "two", 3: "three"}  # of a list, in words
KeyTable = dict[str, Section | Word | Number | Flag | Table | Name | NameList]


def deciding_paths(key: object) -> tuple[str, ...]:
    """Return the paths of the law names that decide whether a key is in use, and its meaning."""
    conditions = [key_use.when for key_use in key.uses] if isinstance(key, Number) else [getattr(key, "when", ())]
    return tuple(dict.fromkeys(path for when in conditions for path, _ in when))


def has_keys_below(key_table: KeyTable, path: str) -> bool:
    """Return whether there are keys below `path`."""
    return any(nested.rpartition(".")[0] == path for nested in key_table)


def value_key(key_table: KeyTable, path: str) -> Word | Number:
    """Return the key at `path`, a word or a quantity; raise TypeError for any other kind."""
    key = key_table[path]
    assert isinstance(key, (Word, Number)), path
    return key


def word_key(key_table: KeyTable, path: str) -> Word:
    """Return the key at `path`, a word; raise TypeError for any other kind."""
    key = key_table[path]
    assert isinstance(key, Word), path
    return key


def section_key(key_table: KeyTable, path: str) -> Section:
    """Return the key at `path`, a section; raise TypeError for any other kind."""
    key = key_table[path]
    assert isinstance(key, Section), path
    return key
