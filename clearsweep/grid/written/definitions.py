"""Reads `define`: user-defined quantities, and expressions of them in place of numbers; and `extends`.

An expression is text that begins with `=`.  It is evaluated first, so that all other readers
see quantities.  If a name varies, the numbers that depend on it are evaluated for every case.
"""

import keyword
import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from ...language import expression, quantity
from ...language.errors import InputError, quoted
from . import AXIS_SECTIONS, EXTENDS, Problems, WrittenValue, read_document, written_of
from .tables import is_table, read_cases

DEFINE = "define"
DEFINE_PREFIX = f"{DEFINE}."
DEFINE_TEXT = "name -> quantity, or `= expression` of other names; numbers in the grid may use these names: `= d / 2`"
MAX_VALUES = 20_000  # of a number that varies with names; beyond, only the ends of the axes are checked
MAX_EVALUATIONS = 200_000  # of names for these values
MAX_LISTED = 6  # names of a circle in a message
#: Sections whose numbers may vary.
_CASE_SECTIONS = ("mechanism", "drive", "loads", "joints", "figures", "simulate", "save", "life", DEFINE)
_TEXT_SECTIONS = ("name", "figures")  # texts in these sections are not expressions of defined quantities
_NAMED_SECTIONS = ("figures", "limits", "roles", "uncertain")  # their keys are names or paths of the grid
_OVER, _SEARCHED = "over", ("largest", "smallest")  # keys of other sections: with entries by path, or with paths


class Definitions(NamedTuple):
    """Defined quantities and the numbers that follow from them, in SI."""

    expression_by_name: Mapping[str, str]  # name -> its expression, '' for a quantity; in order of evaluation
    values: Mapping[str, Fraction]  # as written in the grid
    units: Mapping[str, str]
    names_by_name: Mapping[str, frozenset[str]]  # the names in each expression
    varied_names: frozenset[str] = frozenset()  # names that an axis varies
    invalid: frozenset[str] = frozenset()  # names with an invalid definition
    #: dotted path of a number -> its expression, which contains a varied name
    dependents: Mapping[str, str] = MappingProxyType({})
    #: name -> the varied names in its expression, directly or through other names
    varied_by_name: Mapping[str, frozenset[str]] = MappingProxyType({})

    def with_varied(self, varied_names: frozenset[str]) -> "Definitions":
        """Return the definitions with the names that an axis varies."""
        varied_by_name: dict[str, frozenset[str]] = {}
        for name in self.expression_by_name:  # in order of evaluation
            others = self.names_by_name[name]
            varied_by_name[name] = (others & varied_names).union(*(varied_by_name[other] for other in others))
        return self._replace(varied_names=varied_names, varied_by_name=varied_by_name)

    def values_at(self, point: Mapping[str, Any]) -> dict[str, float]:
        """Return path -> value of the dependent numbers at a point, `define.NAME` -> value."""
        if not self.dependents:
            return {}
        values_by_name = self._values_of_names(point)
        return {
            path: float(expression.exact_value(text, values_by_name)) + 0.0 for path, text in self.dependents.items()
        }

    def _values_of_names(self, point: Mapping[str, Any]) -> dict[str, Fraction]:
        values = dict(self.values)
        values |= {
            name: Fraction(repr(float(point[DEFINE_PREFIX + name])))
            for name in self.varied_names
            if DEFINE_PREFIX + name in point
        }
        for name, text in self.expression_by_name.items():
            if self.varied_by_name.get(name):
                values[name] = expression.exact_value(text, values)
        return values

    def varied_in(self, text: str) -> frozenset[str]:
        """Return the varied names in an expression."""
        names = frozenset(expression.names_in(text, expression.DEFINED))
        return (names & self.varied_names).union(*(self.varied_by_name.get(name, frozenset()) for name in names))

    def add_names(self, text: str, used: set[str]) -> None:
        """Add the names in an expression to `used`, and those that they use."""
        pending = expression.names_in(text, expression.DEFINED) - used
        while pending:
            used |= pending
            pending = {other for name in pending for other in self.names_by_name.get(name, ())} - used

    def needed_definitions(self) -> dict[str, str]:
        """Return `define.NAME` -> grid text of the names that `dependents` needs and that do not vary themselves."""
        used: set[str] = set()
        for text in self.dependents.values():
            self.add_names(text, used)
        names = [name for name in self.expression_by_name if name in used - self.varied_names]
        return {DEFINE_PREFIX + name: self._text(name) for name in names}

    def _text(self, name: str) -> str:
        text = self.expression_by_name[name]
        return f"= {text}" if self.varied_by_name.get(name) else self.grid_text(name)

    def grid_text(self, name: str) -> str:
        """Return the value of a name as grid text: in SI, with its unit."""
        return _quantity_text(self.values[name], self.units[name])

    def possible_values(
        self, path: str, axes: Mapping[str, tuple[Any, ...]], varied_by: Mapping[str, str]
    ) -> tuple[float, ...]:
        """Return the values of a number whose names vary on these axes.

        These are all values, or beyond MAX_VALUES or MAX_EVALUATIONS those at the ends of the axes.
        """
        names = sorted(self.varied_in(self.dependents[path]))
        paths_by_axis: dict[str, list[str]] = {}
        for name in names:
            if DEFINE_PREFIX + name not in axes:
                return ()
            section = varied_by.get(DEFINE_PREFIX + name, "")
            paths_by_axis.setdefault(section if section not in ("sweep", "") else name, []).append(DEFINE_PREFIX + name)
        axis_points = [
            list(zip(*(axes[axis_path] for axis_path in axis_paths), strict=False))
            for axis_paths in paths_by_axis.values()
        ]
        count = math.prod(map(len, axis_points))
        if count > MAX_VALUES or count * sum(map(bool, self.varied_by_name.values())) > MAX_EVALUATIONS:
            axis_points = [[min(values), max(values)] for values in axis_points]
        varied_paths = [axis_path for axis_paths in paths_by_axis.values() for axis_path in axis_paths]
        definitions = self._replace(dependents={path: self.dependents[path]})
        points = (dict(zip(varied_paths, sum(chosen, ()), strict=True)) for chosen in product(*axis_points))
        return tuple(definitions.values_at(point)[path] for point in points)


NO_DEFINITIONS = Definitions({}, {}, {}, {})


def resolve_definitions(
    root: WrittenValue, problems: Problems, fixed_paths: frozenset[str] = frozenset()
) -> tuple[WrittenValue, Definitions]:
    """Return the document with expressions evaluated, and the definitions; mistakes go to `problems`.

    The section `define` keeps only the names that an axis varies.  Paths in `fixed_paths` no longer vary.
    """
    sections = root.value
    section = sections.get(DEFINE)
    if section is not None and not section.entries:
        problems.add(section, DEFINE, "is empty; for example: `play: 50 um`, or remove the key")
        section = None
    position_by_varied_path = {path: position for path, position in varied_paths(sections) if path not in fixed_paths}
    written: dict[str, WrittenValue] = section.value if section is not None else {}
    named = {name: entry for name, entry in written.items() if _can_define(section, name, problems)}
    definitions = _evaluate_definitions(named, problems)
    definitions = definitions._replace(invalid=frozenset(written) - definitions.values.keys())
    names = frozenset(
        path.removeprefix(DEFINE_PREFIX)
        for path in position_by_varied_path
        if path.removeprefix(DEFINE_PREFIX) in definitions.values
    )
    definitions = definitions.with_varied(names & definitions.expression_by_name.keys())
    evaluator = _ExpressionEvaluator(problems, definitions, position_by_varied_path)
    evaluator.used |= {
        other for name in definitions.invalid & named.keys() for other in (name, *_names_in_value(named[name]))
    }
    content = {
        key: evaluator.evaluate_tree(entry, key)
        for key, entry in sections.items()
        if key not in (DEFINE, *_TEXT_SECTIONS)
    }
    content |= {key: sections[key] for key in _TEXT_SECTIONS if key in sections}
    if figures := content.get("figures", WrittenValue({})).entries:
        own = {name: entry for name, entry in figures.items() if isinstance(entry.value, dict)}
        evaluated = {name: evaluator.evaluate_tree(entry, f"figures.{name}") for name, entry in own.items()}
        content["figures"] = content["figures"].with_value(figures | evaluated)
    for name, entry in named.items():
        if definitions.expression_by_name.get(name) and DEFINE_PREFIX + name in position_by_varied_path:
            evaluator.refuse_axis(DEFINE_PREFIX + name, entry)
        elif name not in evaluator.used:
            message = "is not used; use it, for example: `clearance: = " + name + "`, or leave it out"
            problems.add(section.key_position(name) if section else entry, DEFINE_PREFIX + name, message)
    if definitions.varied_names and section is not None:
        varied_entries = {
            name: evaluator.replace_expression(named[name], definitions.grid_text(name))
            for name in named
            if name in definitions.varied_names
        }
        content[DEFINE] = section.with_value(varied_entries)
    ordered = {key: content[key] for key in sections if key in content}
    return root.with_value(ordered), definitions._replace(dependents=evaluator.dependents)


def definitions_of_resolved(resolved: Mapping[str, Any]) -> Definitions:
    """Return the definitions of a grid from `Grid.resolved`, or from a run.json that contains it."""
    names = [name for name in resolved.get("keys", resolved) if name not in ("name", *_NAMED_SECTIONS)]
    grid_sections = {name: resolved[name] for name in names if resolved.get(name)}
    return (
        resolve_definitions(written_of(grid_sections, ""), Problems())[1] if DEFINE in grid_sections else NO_DEFINITIONS
    )


class _ExpressionEvaluator:
    """Replaces expressions by quantities."""

    def __init__(
        self, problems: Problems, definitions: Definitions, position_by_varied_path: Mapping[str, WrittenValue]
    ):
        self.problems, self.definitions, self.position_by_varied_path = problems, definitions, position_by_varied_path
        self.dependents: dict[str, str] = {}
        self.used: set[str] = set()
        #: id of a value -> whether it contains an expression; aliases are visited once
        self.contains_expression: dict[int, bool] = {}

    def evaluate_tree(self, written: WrittenValue, path: str) -> WrittenValue:
        """Return the value at a path with its expressions evaluated."""
        value: Any = written.value
        if not self._has_expression(written):
            return written
        if isinstance(value, dict):
            value = {key: self.evaluate_tree(entry, f"{path}.{key}") for key, entry in value.items()}
        elif isinstance(value, list):
            value = [self.evaluate_tree(entry, f"{path}.{index}") for index, entry in enumerate(value)]
        else:
            return self._evaluate(written, path)
        return written.with_value(value)

    def _has_expression(self, written: WrittenValue) -> bool:
        value = written.value
        if not isinstance(value, dict | list):
            return is_expression(value)
        if id(written) not in self.contains_expression:
            self.contains_expression[id(written)] = False
            self.contains_expression[id(written)] = any(
                map(self._has_expression, value.values() if isinstance(value, dict) else value)
            )
        return self.contains_expression[id(written)]

    def _evaluate(self, written: WrittenValue, path: str) -> WrittenValue:
        text = expression_of(written.value)
        try:
            self.definitions.add_names(text, self.used)
            unit = expression.unit_of(text, self.definitions.units, expression.DEFINED)
            value = expression.exact_value(text, self.definitions.values)
        except InputError as error:
            if not self.definitions.invalid & _names_in_text(text):  # what is wrong there is said there
                self.problems.add(written, path, str(error))
            self.problems.unread.add(path)
            return self.replace_expression(written, "0")
        if path in self.position_by_varied_path:
            self.refuse_axis(path, written)
        if names := self.definitions.varied_in(text):
            if path.split(".", 1)[0] in _CASE_SECTIONS:
                self.dependents[path] = text
            else:
                message = (
                    f"depends on {DEFINE_PREFIX}{min(names)}, which varies; only mechanism, drive, loads, joints "
                    "and figures may depend on it"
                )
                self.problems.add(written, path, message)
        return self.replace_expression(written, _quantity_text(value, unit))

    def refuse_axis(self, path: str, written: WrittenValue) -> None:
        """Report a varied path whose value is an expression."""
        message = (
            f"varies, but its value is the expression {quoted(written.value)}; vary a name in it, or write a number"
        )
        self.problems.add(self.position_by_varied_path[path], path, message)

    def replace_expression(self, written: WrittenValue, value: str) -> WrittenValue:
        """Return the quantity that replaces a written expression."""
        text = written.value if is_expression(written.value) else ""
        return WrittenValue(value, written.origin, written.line, written.column, expression=text)


def is_expression(value: Any) -> bool:
    """Return whether a value is written as an expression."""
    return isinstance(value, str) and value.lstrip().startswith("=")


def expression_of(written: str) -> str:
    """Return an expression without its equals sign."""
    return written.strip().removeprefix("=").strip()


def _can_define(section: WrittenValue | None, name: str, problems: Problems) -> bool:
    """Return whether a name can be defined; if not, report why."""
    assert section is not None  # it has the name
    if not name.isidentifier() or keyword.iskeyword(name):
        message = "is not a valid name; expected letters, digits and _, and a letter or _ first"
    elif name in expression.FUNCTIONS:
        message = "is a function of expressions; give the quantity another name"
    elif quantity.is_unit(name):
        message = "is a unit; give the quantity another name"
    else:
        return True
    problems.add(section.key_position(name), DEFINE_PREFIX + name, message)
    return False


def _evaluate_definitions(written: Mapping[str, WrittenValue], problems: Problems) -> Definitions:
    """Return the defined quantities in order of evaluation."""
    expression_by_name: dict[str, str] = {}
    values: dict[str, Fraction] = {}
    units: dict[str, str] = {}
    names_by_name = {name: frozenset(_names_in_value(entry) & written.keys()) for name, entry in written.items()}
    definitions = Definitions(expression_by_name, values, units, names_by_name)
    invalid: set[str] = set()

    def evaluate(name: str) -> None:
        entry = written[name]
        text = expression_of(entry.value) if is_expression(entry.value) else ""
        try:
            if text:
                units[name] = expression.unit_of(text, units, expression.DEFINED)
                values[name] = expression.exact_value(text, values)
            else:
                values[name], units[name] = _quantity_of_definition(entry.value)
            expression_by_name[name] = text
        except InputError as error:
            if name not in invalid and not names_by_name[name] & invalid:  # what is wrong there is said there
                problems.add(entry, DEFINE_PREFIX + name, str(error))
            invalid.add(name)

    for names in _evaluation_order(names_by_name):
        if isinstance(names, list):
            listed = names if len(names) <= MAX_LISTED else [*names[: MAX_LISTED - 1], "...", names[-1]]
            message = f"depends on itself: {' -> '.join([*listed, names[0]])}; break the circle"
            problems.add(written[names[0]], DEFINE_PREFIX + names[0], message)
            invalid.update(names)
        else:
            evaluate(names)
    return definitions


def _evaluation_order(names_by_name: Mapping[str, frozenset[str]]) -> Iterator[str | list[str]]:
    """Yield every name after those in its expression; before that, the list of the names of each circle.

    It keeps its own stack, since a chain of names may be longer than the interpreter's.
    """
    done: set[str] = set()
    for root in names_by_name:
        pending = {} if root in done else {root: iter(sorted(names_by_name[root]))}  # in order of their dependence
        while pending:
            name, others = next(reversed(pending.items()))
            other = next(others, None)
            if other is None:
                yield name
                done.add(name)
                del pending[name]
            elif other in pending:
                chain = list(pending)
                yield chain[chain.index(other) :]
            elif other not in done:
                pending[other] = iter(sorted(names_by_name[other]))


def _names_in_value(entry: WrittenValue) -> set[str]:
    """Return the names in a written value; empty if it is not a valid expression."""
    return _names_in_text(expression_of(entry.value)) if is_expression(entry.value) else set()


def _names_in_text(text: str) -> set[str]:
    """Return the names in an expression; empty if it is invalid."""
    try:
        return expression.names_in(text, expression.DEFINED)
    except InputError:
        return set()


def _quantity_of_definition(value: Any) -> tuple[Fraction, str]:
    """Return value (SI) and unit of a written quantity."""
    if isinstance(value, str):
        number, dimension = quantity.value_and_dimension(value)
        return Fraction(repr(number)), quantity.unit_of(dimension)
    if isinstance(value, bool | dict | list) or value is None:
        message = f"found {quoted(value)}; expected a quantity, such as 50 um, or an expression, such as = d / 2"
        raise InputError(message)
    return Fraction(repr(quantity.read(value, "1"))), "1"


def _quantity_text(value: Fraction, unit: str) -> str:
    return f"{float(value) + 0.0!r} {unit}".removesuffix(" 1")


def varied_paths(sections: Mapping[str, WrittenValue]) -> Iterator[tuple[str, WrittenValue]]:
    """Yield the dotted paths that a document varies, each with its position in the document."""
    for section_name in AXIS_SECTIONS:
        section = sections.get(section_name)
        if section is not None and section_name == "cases" and is_table(section):
            silent, table, section = Problems(), section, None
            with silent.reporting():
                section = read_cases(silent, table).columns
        if section is not None:
            yield from ((path, section.key_position(path)) for path in section.entries)
    for section_name, section in sections.items():
        if section_name in (*_CASE_SECTIONS, *_NAMED_SECTIONS):
            continue
        over = section.entries.get(_OVER, WrittenValue({}))
        yield from ((path, over.key_position(path)) for path in over.entries)
        for key in _SEARCHED:
            if written := section.entries.get(key):
                yield from ((entry.value, entry) for entry in written.items if isinstance(entry.value, str))


# ---------------------------------------------------------------------------------------------- extends


def extended(root: WrittenValue, problems: Problems) -> WrittenValue:
    """Return the document merged into the one that its key `extends` names: its values count, sections are merged.

    The file is in the same folder and extends none itself.  Its name is not inherited.
    """
    written = root.value.get(EXTENDS)
    if written is None:
        return root
    own, name = root.without(EXTENDS), written.value
    if not isinstance(name, str) or name in ("", ".", "..") or Path(name).name != name or "\\" in name:
        message = f"found {quoted(name)}; expected the name of a grid file in the same folder, such as base.yaml"
        problems.add(written, EXTENDS, message)
        return own
    file = Path(root.origin).parent / name if root.line else Path(name)
    if file.is_symlink() or (root.line and file.resolve() == Path(root.origin).resolve()):
        problems.add(written, EXTENDS, f"{file} is a link or this file itself; write the name of another file")
        return own
    base = read_document(file, problems)
    if not isinstance(base.value, dict) or EXTENDS in base.value:
        problem = "extends a file itself; one level is allowed" if isinstance(base.value, dict) else "is no grid"
        problems.add(written, EXTENDS, f"{file} {problem}; write its values there")
        return own
    problems.base = name
    return _merged(base.without("name"), own)


def _merged(base: WrittenValue, own: WrittenValue) -> WrittenValue:
    """Return a value over that of a base: sections are merged, null removes a key, everything else replaces it."""
    if not isinstance(base.value, dict) or not isinstance(own.value, dict):
        return own
    values = base.value | {
        key: _merged(base.value[key], value) if key in base.value else value for key, value in own.value.items()
    }
    values = {key: value for key, value in values.items() if value.value is not None or key not in base.value}
    return WrittenValue(values, own.origin, own.line, own.column, base.keys | own.keys)
