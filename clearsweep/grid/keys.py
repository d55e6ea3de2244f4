"""The kinds of keys that a grid file has."""

from collections.abc import Callable, Mapping, Set
from typing import NamedTuple

from ..contracts.catalogue import Columns, Field

Condition = tuple[str, frozenset[str]]  # path of a law's name, and the names with which a key is in use
Names = Mapping[str, Set[str]]  # path of a law's name -> the names in play


class Use(NamedTuple):
    """One meaning of a key, and the law names that all have to be chosen for it."""

    field: Field
    when: tuple[Condition, ...] = ()


class Number(NamedTuple):
    """A key that contains a quantity."""

    uses: tuple[Use, ...]
    sweep: bool = True

    def fields(self, names: Names) -> tuple[Field, ...]:
        """Return what the key means with the law names in play; () if it is not in use."""
        return tuple(dict.fromkeys(use.field for use in self.uses if _met(use.when, names)))

    def used(self, names: Names) -> bool:
        """Return whether the key is in use with the law names in play."""
        return bool(self.fields(names))

    def choosers(self) -> tuple[str, ...]:
        """Return the paths of the law names that decide whether and how the key is in use."""
        return tuple(dict.fromkeys(path for use in self.uses for path, _ in use.when))


class Rather(NamedTuple):
    """A conditional default of a Word; paths count if they are written or swept."""

    word: str
    one_of: tuple[str, ...] = ()  # one of these paths is there, if any are named
    all_of: tuple[str, ...] = ()  # all of these are
    none_of: tuple[str, ...] = ()  # none of these is
    unless: Condition = ("", frozenset())  # and none of these law names is in play

    def contains(self, there: Callable[[str], bool], names: Names) -> bool:
        """Return whether it applies, `there` saying of a path whether it is written or swept."""
        present = all(map(there, self.all_of)) and (not self.one_of or any(map(there, self.one_of)))
        path, refused = self.unless
        return present and not any(map(there, self.none_of)) and refused.isdisjoint(names.get(path, ()))


class Word(NamedTuple):
    """A key that contains one of a few words."""

    options: tuple[str, ...]
    text: str
    default: str | None = None
    sweep: bool = False
    noun: str = "word"  # what it is called in messages
    when: tuple[Condition, ...] = ()
    idle: bool = False  # may be written where it is not in use
    rather: Rather | None = None
    refused: Mapping[str, str] = {}  # a word that might be expected here -> why it is not allowed

    def used(self, names: Names) -> bool:
        """Return whether the key is in use with the law names in play."""
        return _met(self.when, names)

    def choosers(self) -> tuple[str, ...]:
        """Return the paths of the law names that decide whether the key is in use."""
        return tuple(path for path, _ in self.when)


class Name(NamedTuple):
    """A key that contains the name of an entry of a library; numbers are put in its place before anything is read."""

    options: tuple[str, ...]
    text: str

    @property
    def sweep(self) -> bool:
        """Return False: it cannot be swept, the numbers in its place can."""
        return False


class Flag(NamedTuple):
    """A key that is true or false; false is the same as absent, unless the key has a default."""

    text: str
    default: bool | None = None  # it is entered, true or false, where there is one

    @property
    def sweep(self) -> bool:
        """Return False: it cannot be swept."""
        return False

    def choosers(self) -> tuple[str, ...]:
        """Return (): no law name decides whether it is in use."""
        return ()


class NameList(NamedTuple):
    """A key that contains a list of names, which are known once the cases are."""

    text: str
    noun: str  # what is expected, in messages
    example: str

    @property
    def sweep(self) -> bool:
        """Return False: it cannot be swept."""
        return False

    def choosers(self) -> tuple[str, ...]:
        """Return (): no law name decides whether it is in use."""
        return ()


class Table(NamedTuple):
    """A key that contains a table, or the name of its file."""

    columns: Columns
    when: tuple[Condition, ...] = ()
    optional: bool = False

    def used(self, names: Names) -> bool:
        """Return whether the key is in use with the law names in play."""
        return _met(self.when, names)

    @property
    def sweep(self) -> bool:
        """Return False: it cannot be swept."""
        return False

    def choosers(self) -> tuple[str, ...]:
        """Return the paths of the law names that decide whether the key is in use."""
        return tuple(path for path, _ in self.when)


def _met(when: tuple[Condition, ...], names: Names) -> bool:
    """Return whether every condition allows one of the names in play; where a section is missing there are none."""
    return all(not wanted.isdisjoint(names.get(path, ())) for path, wanted in when)


class Section(NamedTuple):
    """A key that contains further keys."""

    text: str
    need: str = "required"  # 'required', 'optional', or 'implied': there even if it is not written
    items: int = 0  # of the list in which it is written; 0: it is no list
    alone: tuple[int, ...] = ()  # of a list: by what a single quantity in its place is multiplied for each item
    unless: str = ""  # a section next to it that does in its place
    needs: str = ""  # a section next to the one it is in, without which it is not there


ITEMS = {2: "two", 3: "three"}  # of a list, in words
Shape = dict[str, Section | Word | Number | Flag | Table | Name | NameList]


def value_key(shape: Shape, path: str) -> Word | Number:
    """Return the key at `path`, which contains a word or a quantity; anything else is a mistake of the caller."""
    node = shape[path]
    assert isinstance(node, (Word, Number)), path
    return node


def word_key(shape: Shape, path: str) -> Word:
    """Return the key at `path`, which contains a word; anything else is a mistake of the caller."""
    node = shape[path]
    assert isinstance(node, Word), path
    return node


def section_key(shape: Shape, path: str) -> Section:
    """Return the key at `path`, which contains further keys; anything else is a mistake of the caller."""
    node = shape[path]
    assert isinstance(node, Section), path
    return node
