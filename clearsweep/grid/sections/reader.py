"""State of reading a grid: the values of a document, path by path, as far as they have been read."""

from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from ...contracts.catalogue import Mechanism
from ...contracts.outline import Outline
from ...language import quantity
from ...language.errors import InputError
from ..keys.kinds import Number, Shape
from ..keys.library_names import Taken, VariedMaterial, material_values
from ..library.iso286 import Fit
from ..sections.distributions import Distribution
from ..sections.sample import Sample
from ..written.definitions import NOTHING, Definitions
from ..written.document import Problems, WrittenValue


@dataclass
class Reader:
    """The values of a document, path by path."""

    problems: Problems
    mechanism: Mechanism  # the named mechanism, or the likeliest one
    outline: Outline
    shape: Shape = field(default_factory=dict)  # the keys in use: sections that are left out are missing
    sections: dict[str, WrittenValue] = field(default_factory=dict)
    written: dict[str, WrittenValue] = field(default_factory=dict)  # the values under `shape`
    swept: dict[str, WrittenValue] = field(default_factory=dict)
    names: dict[str, frozenset[str]] = field(default_factory=dict)  # path of a law's name -> names in use
    unsure: set[str] = field(default_factory=set)  # paths of law names that could not be read
    broken: set[str] = field(default_factory=set)  # paths of sections that could not be read
    values: dict[str, Any] = field(default_factory=dict)  # in SI; includes defaults of words
    axes: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    varied_by: dict[str, str] = field(default_factory=dict)  # varied path -> the section that varies it
    sample: Sample | None = None
    drawn: tuple[str, ...] = ()  # the paths under `sample`
    distributions: dict[str, Distribution] = field(default_factory=dict)
    fits: dict[str, list[Fit]] = field(default_factory=dict)  # path of a clearance -> its fits as written
    labels: dict[str, tuple[str, ...]] = field(default_factory=dict)  # path of an axis -> the labels of its values
    library_values: dict[str, Taken] = field(default_factory=dict)  # path of a number -> the value taken from a library
    figures: dict[str, str] = field(default_factory=dict)  # figure of merit of the cases -> unit
    limits: dict[str, Any] = field(default_factory=dict)  # as in a resolved grid; see `verdict`
    searched_fits: tuple[Fit, ...] = ()  # the fits to search, in order of their largest clearances
    seek: Any = None  # `seek.Seek`
    choices: dict[str, str] = field(default_factory=dict)  # path under `optimise` -> kind of its values
    optimise: Any = None  # `optimised.Optimise`
    identify: Any = None  # `identified.Identify`
    refine: Any = None  # `refine.Refine`
    check_laws: bool = False  # the deciding case runs again under other laws
    added_in: str = ""  # the section that contains the added cases
    added_written: dict[str, WrittenValue] = field(default_factory=dict)  # their values, by path
    added_cases: dict[str, list[Any]] = field(default_factory=dict)  # the same, SI
    uncertain: dict[str, dict[str, Any]] = field(default_factory=dict)  # path of a coefficient -> its distribution, SI
    own_figures: dict[str, str] = field(default_factory=dict)  # name -> expression of columns
    defined: Definitions = NOTHING
    materials: dict[str, VariedMaterial] = field(default_factory=dict)  # path of a name -> the material that varies

    def place(self, path: str) -> WrittenValue:
        """Return the value whose position locates a mistake at `path`: its own, or that of the section without it."""
        while path and path not in self.swept and path not in self.written and path not in self.sections:
            path = path.rpartition(".")[0]
        return self.swept.get(path) or self.written.get(path) or self.sections[path]

    def text(self, path: str, value: Any) -> str:
        """Return a value of `path` as it was written, or in SI if it follows from other values."""
        node = self.shape.get(path)
        unit = node.fields(self.names)[0].unit if isinstance(node, Number) and node.used(self.names) else "1"
        location = self.swept.get(path) or self.written.get(path)
        items = [] if location is None else location.value if isinstance(location.value, list) else [location]
        for item in items:
            with suppress(InputError):
                if quantity.read(item.value, unit) == value:
                    return quantity.said(item.value, unit)
        return quantity.said(float(value), unit)

    @property
    def varied_numbers(self) -> set[str]:
        """Return the paths on an axis, and those of numbers that follow from the name of a varied material."""
        return {*self.swept, *(path for material in self.materials.values() for path in material.follow)}

    def is_given(self, path: str) -> bool:
        """Return whether a value or a section is written or swept."""
        return path in self.written or path in self.swept or path in self.sections

    def vary_in_step(self, *paths: str) -> bool:
        """Return whether these paths vary in step, row by row."""
        follow = self.defined.follow
        if all(path in follow for path in paths):  # both follow one name, so they vary together
            return len({self.defined.varied_in(follow[path]) for path in paths}) == 1
        ways = {self.varied_by.get(path) for path in paths}
        return len(ways) == 1 and ways.isdisjoint((None, "sweep", "seek"))

    def values_of(self, path: str) -> tuple[Any, ...]:
        """Return every value of `path`: its axis, written value or default, or () if unknown or left out."""
        if path in self.swept:
            return self.axes.get(path, ())
        if path in self.defined.follow:
            return self.defined.values_reached(path, self.axes, self.varied_by)
        if any(path in material.follow for material in self.materials.values()):
            return tuple(material_values(path, self.materials, self.axes))
        if path in self.values:
            return (self.values[path],)
        node = self.shape.get(path)
        fields = node.fields(self.names) if isinstance(node, Number) and path not in self.written else ()
        return tuple(field.default for field in fields if field.default is not None)
