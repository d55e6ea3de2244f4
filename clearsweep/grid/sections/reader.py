"""State of reading a grid, path by path, and shared functions of the sections that add cases: the searches."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from ...contracts.catalogue import Mechanism, Outline
from ...contracts.search import Search
from ...language import quantity
from ...language.errors import InputError
from ..keys import KeyTable, Number, Word, value_key
from ..keys.library_names import LibraryNumber, VariedName, numbers_of_names
from ..library.fits import Fit
from ..written.definitions import NO_DEFINITIONS, Definitions
from ..written.document import Problems, WrittenValue
from .axes import Sample
from .distributions import Distribution
from .section import ADDED, section_in


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
    sample: Sample | None = None
    drawn_paths: tuple[str, ...] = ()  # the paths under `sample`
    distributions: dict[str, Distribution] = field(default_factory=dict)
    fits: dict[str, list[Fit]] = field(default_factory=dict)  # path of a clearance -> its fits as written
    labels: dict[str, tuple[str, ...]] = field(default_factory=dict)  # path of an axis -> the labels of its values
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

    def text(self, path: str, value: Any) -> str:
        """Return a value of `path` as it was written, or in SI if it follows from other values."""
        key = self.keys_in_use.get(path)
        unit = key.fields(self.names)[0].unit if isinstance(key, Number) and key.is_used(self.names) else "1"
        entry = self.written_axes.get(path) or self.written.get(path)
        items = [] if entry is None else entry.value if isinstance(entry.value, list) else [entry]
        for item in items:
            with suppress(InputError):
                if quantity.read(item.value, unit) == value:
                    return quantity.written_text(item.value, unit)
        return quantity.written_text(float(value), unit)

    @property
    def varied_numbers(self) -> set[str]:
        """Return the paths on an axis, and the paths of numbers that follow from a name that varies."""
        return {*self.written_axes, *(path for varied in self.varied_names.values() for path in varied.paths)}

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
        position = reader.position_of(path)
        reader.written_axes[path] = WrittenValue(reader.values[path], position.origin, position.line, position.column)
        reader.varied_by[path] = "sweep"
        reader.axes[path] = (reader.values.pop(path),)
        if path in reader.added_written:
            reader.added_cases[path] = [item.value for item in reader.added_written[path].value]


def find_added_cases(reader: Reader, root: WrittenValue) -> None:
    """Record the added cases that the section of a search lists."""
    for name in reader.searches:
        section = section_in(root, name)
        written = section.value.get(ADDED) if section is not None and isinstance(section.value, dict) else None
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
    for chooser in key.deciding_paths():
        for law in reader.axes.get(chooser, ()):
            if not key.is_used(reader.names | {chooser: frozenset({law})}):
                message = f"{path} is not used by {law}; with `{section}` every law that is tried must use every key"
                reader.problems.add(position, section, f"{message} that is swept")
                return
