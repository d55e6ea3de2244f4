"""A grid: a YAML file or a dict, checked, in SI; cases are enumerated by index and named by a hash of their values."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

from .. import MODEL_VERSION
from ..answers.verdict import LimitsAndFigures, figures_of, limits_of
from ..contracts.case import Case, LawFile
from ..contracts.catalogue import CHOICE, CONDITION, MODEL, PRECEDENCE, UNCERTAINTY, Outline
from ..contracts.layout import Layout
from ..contracts.search import Search
from . import cases
from .keys import Flag, KeyTable, Name, NameList, Number, Section, Table, Word, deciding_paths, value_key
from .keys.library_names import LibraryNumber, VariedName, put_numbers_of_names, with_names
from .keys.outline import unit_of_number
from .keys.run_keys import CARRIED, DIRECTION, START
from .library.fits import Fit
from .reading.values import WrittenUnit
from .resolve import case_of
from .sections import ADDED
from .sections.named_sections import UNCERTAIN, uncertain_leaves
from .written.definitions import DEFINE_PREFIX, NO_DEFINITIONS, Definitions
from .written.law_files import LAWS, digests_in_use, recorded

#: Changes whenever the format of grid files or of results changes.
SCHEMA_VERSION = 4

_WORST_PATH = "save.worst"  # results of a finished run


class CaseLabels(NamedTuple):
    """Texts in the table of cases that are no values: they ride along into the summary."""

    names: tuple[str, ...]  # headers of their columns
    paths: tuple[str, ...]  # the varied paths of the table
    texts: Mapping[tuple[Any, ...], tuple[str, ...]]  # values at the paths -> text of each name


@dataclass(frozen=True)
class Grid:
    """A checked grid in SI.  `len(grid)` is the number of cases; each is created only on demand."""

    name: str
    source: str | None  # file, None for a dict
    axes: dict[str, tuple[Any, ...]]  # dotted path -> values, SI or law names, in the order of the file
    limits: dict[str, Any]  # column -> largest acceptable value, SI, or a mapping; see `verdict.limits_of`
    figures: dict[str, str]  # user-defined: name -> expression of columns
    _shape: KeyTable
    _values: dict[str, cases.KeyValue]
    _written: frozenset[str]
    _names: dict[str, frozenset[str]]
    _zipped_paths: dict[str, tuple[str, ...]]  # 'zip', 'cases' or 'sample' -> the paths that vary together
    _sample: dict[str, Any]
    _outline: Outline
    fits: dict[str, tuple[Fit, ...]]  # path of a clearance -> its ISO 286 fits as written
    assumed_units: tuple[str, ...] = ()  # paths of quantities written without a unit: SI is assumed
    search: Search | None = None  # adds cases; its axes have the values tried first
    uncertain: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # path of a coefficient -> its spread, SI
    added_cases: tuple[tuple[Any, ...], ...] = ()  # values of the cases outside the product, in the order of `axes`
    library_values: tuple[LibraryNumber, ...] = ()  # numbers that replace names of libraries
    defined: Definitions = NO_DEFINITIONS  # user-defined quantities, and the numbers that depend on varied ones
    written_units: Mapping[str, WrittenUnit] = field(default_factory=dict)  # path -> the unit in which it is written
    labels: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # path -> label of a value -> value, SI
    varied_names: Mapping[str, VariedName] = field(default_factory=dict)  # path of a name of the library -> it
    given_roles: Mapping[str, str] = field(default_factory=dict)  # varied path -> role that the grid sets
    case_labels: Mapping[str, Sequence[str]] = field(default_factory=dict)  # header of `cases` -> texts of its rows
    law_files: tuple[LawFile, ...] = ()  # with laws of one's own
    warnings: tuple[str, ...] = ()  # sentences on what may be meant otherwise
    _layout: Layout | None = None

    @cached_property
    def verdict(self) -> LimitsAndFigures:
        """Return the user-defined figures and the limits."""
        units = {column.name: column.unit for column in self.layout.columns}
        written = {path: unit._asdict() for path, unit in self.written_units.items()}
        return LimitsAndFigures(figures_of(self.figures, units), limits_of(self.limits, self.layout.columns, written))

    @cached_property
    def roles(self) -> dict[str, str]:
        """Return the role of every varied path, one of contracts.roles; a defined quantity has that of its uses.

        In `zip` and `cases` a condition that the choices of its row determine is part of the design: no other row
        runs the design under another one.
        """
        roles = {path: self.role(path) for path in self.axes}
        for paths in (self._zipped_paths.get(section, ()) for section in ("zip", "cases")):
            choices = [path for path in paths if roles[path] == CHOICE]
            designs = list(zip(*(self.axes[path] for path in choices), strict=True))
            for path in paths:
                if not designs or roles[path] not in (CONDITION, MODEL) or path in self.given_roles:
                    continue
                if len(set(zip(designs, self.axes[path], strict=True))) == len(set(designs)):
                    roles[path] = CHOICE
        return roles

    def role(self, path: str) -> str:
        """Return the role of a key that can be varied, one of contracts.roles."""
        drawn = (*self._sample.get("over", {}), *self.uncertain)
        if path in self.given_roles:
            return self.given_roles[path]
        if path in drawn:
            return UNCERTAINTY
        name = path.removeprefix(DEFINE_PREFIX)
        uses = [used for used, text in self.defined.dependents.items() if name in self.defined.varied_in(text)]
        roles = {
            self.given_roles.get(used, value_key(self._shape, used).role)
            for used in uses
            if path.startswith(DEFINE_PREFIX)
        }
        return next((role for role in PRECEDENCE if role in roles), value_key(self._shape, path).role)

    @cached_property
    def labels_by_row(self) -> "CaseLabels":
        """Return the texts that ride along with the rows of the table of cases."""
        paths = self._zipped_paths.get("cases", ()) if self.case_labels else ()
        rows = zip(*(self.axes[path] for path in paths), strict=True)
        texts = zip(*self.case_labels.values(), strict=True)
        return CaseLabels(tuple(self.case_labels), paths, dict(zip(rows, texts, strict=False)))

    @property
    def worst_count(self) -> int:
        """Return the number of worst cases whose revolution with the largest peak is saved."""
        return int(self._values.get(_WORST_PATH, 0))

    @cached_property
    def size(self) -> int:
        """Return the number of cases; unlike `len`, it has no upper bound."""
        return self._product + len(self.added_cases)

    @cached_property
    def _product(self) -> int:
        """Return the number of cases in the product, without added ones."""
        return math.prod(factor.size for factor in self._factors)

    @property
    def layout(self) -> Layout:
        """Return the columns and channels that all cases share."""
        assert self._layout is not None  # `load` has checked it
        return self._layout

    def __len__(self) -> int:
        return self.size

    def point(self, index: int) -> dict[str, cases.KeyValue]:
        """Return dotted path -> value of the swept keys of a case; None for a key that its laws do not use."""
        if not 0 <= index < len(self):
            raise IndexError(f"case {index} of {len(self)}")
        if index >= self._product:
            return dict(zip(self.axes, self.added_cases[index - self._product], strict=True))
        values: dict[str, cases.KeyValue] = dict.fromkeys(self.axes)
        for factor in reversed(self._factors):
            index, k = divmod(index, factor.size)
            values |= factor.point(k, self.axes)
        return values

    def case(self, index: int) -> Case:
        """Return the case at `index` with defaults filled in and only the keys in use."""
        return self.case_at(self.point(index))

    def case_at(self, point: Mapping[str, cases.KeyValue]) -> Case:
        """Return the case at a `point`, dotted path -> value."""
        case = case_of(self.case_tree(point), self._outline)
        earlier = [case_of(self.case_tree(before), self._outline) for before in self.before(point)]
        return case._replace(before=tuple(earlier)) if earlier else case

    def before(self, point: Mapping[str, cases.KeyValue]) -> list[dict[str, cases.KeyValue]]:
        """Return the points before one in its chain, in order; [] where no state is carried.

        A chain takes the values of the carried axis up, then down.
        """
        path = self.chained
        if not path:
            return []
        upward = sorted(self.axes[path])
        directions = self.axes.get(DIRECTION) or (self._values[DIRECTION],)
        steps = [("up", value) for value in upward] if "up" in directions else []
        steps += [("down", value) for value in upward[::-1]] if "down" in directions else []
        here = steps.index((point.get(DIRECTION, directions[0]), point[path]))
        return [{**point, DIRECTION: direction, path: value} for direction, value in steps[:here]]

    @property
    def chained(self) -> str:
        """Return the axis along which the state is carried, '' if none is."""
        return str(self._values.get(CARRIED, "")) if self._values.get(START) == "carried" else ""

    def place_in_chain(self, index: int) -> tuple[tuple[cases.KeyValue, ...], int]:
        """Return what the cases of a chain share, and the number of cases before one in it."""
        point, chain_paths = self.point(index), (self.chained, DIRECTION)
        return tuple(str(value) for path, value in point.items() if path not in chain_paths), len(self.before(point))

    def _identity_text(self, point: Mapping[str, cases.KeyValue]) -> str:
        """Return the text whose hash is the identity of the case at a point; that of a chain has the values before."""
        text = cases.identity_text(self.case_tree(point))
        earlier = [(before[DIRECTION], before[self.chained]) for before in self.before(point)]
        return f"{text}{json.dumps(earlier)}" if earlier else text

    def case_id(self, index: int) -> str:
        """Return the 16 hexadecimal digits that identify a case: a hash of its values and the model version."""
        return cases.identity_of_text(self._identity_text(self.point(index)))

    def without_added(self) -> "Grid":
        """Return the grid without the cases that a run added."""
        return replace(self, added_cases=())

    def with_added(self, points: Sequence[Mapping[str, cases.KeyValue]]) -> "Grid":
        """Return the grid with the cases at these `points` appended."""
        rows = tuple(tuple(point[path] for path in self.axes) for point in points)
        return replace(self, added_cases=(*self.added_cases, *rows))

    def written_case(self, index: int) -> dict[str, Any]:
        """Return the case at `index` in the form of a grid file, in SI; its identity is a hash of this form."""
        return self.case_tree(self.point(index))

    def case_tree(self, point: Mapping[str, cases.KeyValue]) -> dict[str, Any]:
        """Return the case at a `point` in the form of a grid file, in SI."""
        return self._pattern(cases.law_assignment_at(point)).case({**point, **self.defined.values_at(point)})

    def identities(self, indices: range | None = None) -> Iterator[int]:
        """Yield the identity of every case, in order, as a number below 2**64.

        indices : only these cases, a range of step 1; cases before it take no time.
        """
        indices = range(self.size) if indices is None else indices
        if self.chained:
            yield from (cases.identity_number(self._identity_text(self.point(index))) for index in indices)
            return
        texts = cases.IdentityTexts(self._shape, {*self.axes, *self.defined.dependents})
        # not for numbers that may depend on several axes
        product = range(0) if self.defined.dependents else self._product_part(indices)
        for law_assignment, texts_by_path in cases.product_cases(self._factors, self.axes, texts.texts_at, product):
            yield cases.identity_number(self._pattern(law_assignment).identity_template % texts_by_path)
        for point in map(self.point, range(indices.start + len(product), indices.stop)):
            template = self._pattern(cases.law_assignment_at(point)).identity_template
            yield cases.identity_number(template % texts.texts_at({**point, **self.defined.values_at(point)}))

    def law_assignments(self, indices: range | None = None) -> Iterator[cases.LawAssignment]:
        """Yield the swept law names of every case, or of those at `indices`, in order."""
        indices = range(self.size) if indices is None else indices
        yield from (
            names
            for names, _ in cases.product_cases(self._factors, self.axes, lambda _: {}, self._product_part(indices))
        )
        yield from map(cases.law_assignment_at, map(self.point, range(max(indices.start, self._product), indices.stop)))

    def _product_part(self, indices: range) -> range:
        """Return the indices of a range that lie in the product."""
        return range(min(indices.start, self._product), min(indices.stop, self._product))

    @property
    def may_repeat(self) -> bool:
        """Return whether two cases may be equal: numbers that depend on axes may repeat, values of an axis do not."""
        patience = f"simulate.{cases.TIME_BUDGET}" in self.axes
        return bool(self.defined.dependents or self.added_cases or self._zipped_paths or self.varied_names or patience)

    def fixed_settings(self) -> dict[str, Any]:
        """Return the fixed settings of a run directory: dotted path -> value of all keys not swept, `save` included."""
        fixed = {
            path: value
            for path, value in self._fixed_values.items()
            if path not in (f"simulate.{cases.TIME_BUDGET}", _WORST_PATH)
        }
        if self.law_files:
            words = [*fixed.values(), *(value for values in self.axes.values() for value in values)]
            fixed[LAWS] = digests_in_use(self.law_files, words)
        return fixed | {"swept": sorted(self.axes), "model_version": MODEL_VERSION, "schema": SCHEMA_VERSION}

    def resolved(self) -> dict[str, Any]:
        """Return the grid in SI as a dict in the form of its file; `load` reads the same cases from it."""
        variations: dict[str, Any] = {
            section_name: {path: list(self.axes[path]) for path in paths}
            for section_name, paths in self._axes_by_section.items()
        }
        if self._sample:
            variations["sample"] = self._sample | {"drawn": variations["sample"]}
        columns = zip(self.axes, map(list, zip(*self.added_cases, strict=True)), strict=True)
        added_values = {ADDED: dict(columns)} if self.added_cases else {}
        search, searched_paths = self.search, self.search.varied_paths if self.search else ()
        if search:
            variations.pop(search.name, None)
            swept = variations.get("sweep", {})
            variations["sweep"] = {path: values for path, values in swept.items() if path not in searched_paths}
        other_sections: dict[str, Any] = {
            LAWS: [*map(recorded, self.law_files)],
            "limits": self.limits,
            "roles": dict(self.given_roles),
            UNCERTAIN: dict(self.uncertain),
            **({search.name: search.resolved() | added_values or True} if search else {}),
        }
        named = {path for varied in self.varied_names.values() for path in varied.paths}
        sections: dict[str, Any] = {
            path: {} for path, key in self._shape.items() if isinstance(key, Section) and f"{path}.0" not in named
        }
        pairs = tuple(f"{path}." for path in self._list_paths)
        # a list has no gaps: any value fills one
        fillers = {path: values[0] for path, values in self.axes.items() if path.startswith(pairs)}
        start_values = search.start_values if search else {}
        fillers |= {path: value for path, value in start_values.items() if not path.startswith(DEFINE_PREFIX)}
        fillers |= {
            DEFINE_PREFIX + name: self.defined.grid_text(name)
            for name in self.defined.expression_by_name
            if name in self.defined.varied_names
        }
        base = {path: value for path, value in self._fixed_values.items() if not path.startswith(f"{UNCERTAIN}.")}
        base = with_names(base, self.varied_names)
        case_sections = cases.nest(sections | base | fillers, self._list_paths)
        figures = {"figures": {**case_sections.get("figures", {}), **self.figures}}
        case_sections |= figures if figures["figures"] else {}
        further = {name: part for name, part in (variations | other_sections).items() if part}
        return {"name": self.name} | case_sections | further

    def unit(self, path: str) -> str:
        """Return the SI unit of a swept path, '' for the name of a law."""
        key = value_key(self._shape, path)
        if isinstance(key, Word):
            return ""
        return unit_of_number(key, self._names, self._fixed_values.get(f"{path.rpartition('.')[0]}.exponent"))

    @cached_property
    def _patterns(self) -> dict[cases.LawAssignment, cases.CaseTemplate]:
        """Return a cache, swept law names -> shared part of their cases, since there are many cases and few laws."""
        return {}

    def _pattern(self, law_assignment: cases.LawAssignment) -> cases.CaseTemplate:
        """Return the shared part of the cases with these swept law names."""
        if law_assignment not in self._patterns:
            values_in_use = self._values_in_use(dict(law_assignment))
            swept = [path for path in values_in_use if path in self.axes and path not in dict(law_assignment)]
            numbers = {path: self.axes[path][0] for path in swept}
            numbers |= {path: self._values[path] for path in values_in_use if path in self.defined.dependents}
            self._patterns[law_assignment] = cases.CaseTemplate(values_in_use | numbers, numbers, self._list_paths)
        return self._patterns[law_assignment]

    def _used(self, law_by_path: Mapping[str, str]) -> dict[str, cases.KeyValue]:
        """Return path -> value, or default, of every key of the grid in use with these swept law names."""
        names = self._names | {path: frozenset({word}) for path, word in law_by_path.items()}
        used: dict[str, cases.KeyValue] = {}
        for path, key in self._shape.items():
            fields = key.fields(names) if isinstance(key, Number) else ()
            if fields or isinstance(key, (Flag, NameList)) or (isinstance(key, (Word, Table)) and key.is_used(names)):
                value = self._values.get(path, fields[0].default if fields else None)
                used[path] = law_by_path.get(path, value)
        return used

    def _values_in_use(self, law_by_path: Mapping[str, str]) -> dict[str, cases.KeyValue]:
        """Return path -> value of every key of a case with these swept law names."""
        values_in_use = self._used(law_by_path) | ({LAWS: self.law_files} if self.law_files else {})
        return put_numbers_of_names(values_in_use, self.varied_names) | dict(uncertain_leaves(self.uncertain))

    @cached_property
    def _fixed_values(self) -> dict[str, cases.KeyValue]:
        """Return path -> value of all keys that are not swept; for a swept law, only the keys that are written."""
        used, values_in_use = self._used({}), dict[str, cases.KeyValue]()
        for path, key in self._shape.items():
            if isinstance(key, (Section, Name)) or path in self.axes or path in self.defined.dependents:
                continue
            if any(chooser in self.axes for chooser in deciding_paths(key)):
                values_in_use[path] = self._values.get(path) if path in self._written else None
            else:
                values_in_use[path] = used.get(path)
        values_in_use |= dict(uncertain_leaves(self.uncertain))
        base = {
            path: value for path, value in cases.with_dependent_values(values_in_use).items() if path not in self.axes
        }
        return (
            base
            | {path: f"= {text}" for path, text in self.defined.dependents.items()}
            | self.defined.needed_definitions()
        )

    @cached_property
    def _axes_by_section(self) -> dict[str, tuple[str, ...]]:
        """Return section of a grid file -> its axes, for sections with axes."""
        zipped = {path for paths in self._zipped_paths.values() for path in paths}
        swept = tuple(path for path in self.axes if path not in zipped)
        return ({"sweep": swept} if swept else {}) | self._zipped_paths

    @cached_property
    def _factors(self) -> tuple[cases.Factor | cases.ZippedAxes, ...]:
        """Return the factors of the product: zipped axes, sections with swept law names, and every other axis."""
        steps = tuple(cases.zipped_axes(paths, self.axes) for paths in self._zipped_paths.values())
        groups: dict[str, list[str]] = {}
        sweep = self._axes_by_section.get("sweep", ())
        for path in sweep:
            key = value_key(self._shape, path)
            swept = [chooser for chooser in deciding_paths(key) if chooser in sweep]
            joint_axis = path if isinstance(key, Word) else swept[0] if swept else None
            groups.setdefault(joint_axis.rpartition(".")[0] if joint_axis else path, []).append(path)
        return (*(cases.factor_of(paths, self.axes, self._shape, self._names) for paths in groups.values()), *steps)

    @cached_property
    def _list_paths(self) -> tuple[str, ...]:
        """Return the paths of sections that are written as lists."""
        return tuple(path for path, key in self._shape.items() if isinstance(key, Section) and key.items)


def identity(case: Mapping[str, Any]) -> str:
    """Return the identity of a resolved case: 16 hexadecimal digits, from all keys but `save` and time_budget."""
    return cases.identity_of_text(cases.identity_text(case))
