"""Figures and limits of a grid: their columns and labels, the limits that each case exceeds, its margin and verdict."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..contracts import catalogue
from ..contracts.catalogue import ENDLESS
from ..contracts.layout import Column, Layout
from ..language import expression, wording

if TYPE_CHECKING:
    import numpy as np  # imported only when cases are assessed


# User-defined figures and limits of a grid: their columns, the limits that a case exceeds, its margin.

EXCEEDED_COLUMN, UNDECIDED_COLUMN, MARGIN_COLUMN = "limits_exceeded", "limits_undecided", "margin"  # columns
KINDS = ("at_most", "at_least")


class Limit(NamedTuple):
    """A bound on a column."""

    column: str
    kind: str  # one of KINDS
    value: float  # SI: unit of the column over that of `times`
    times: str = ""  # another column, of which the bound is a multiple, or ''
    null: str = ""  # meaning of a missing value, see `contracts.layout.Column`

    def bound_text(self, unit: str) -> str:
        """Return the bound in words, for a column in `unit`: 'at most 5 kN', 'at least 2 times NAME'."""
        is_temperature = unit == "K" and self.column.endswith("temperature") and not self.times
        scale = (
            wording.temperature_scale() if is_temperature else wording.scale("1" if self.times else unit, self.value)
        )
        threshold = scale.exact_text(self.value) + (f" times {self.times}" if self.times else "")
        return f"{self.kind.replace('_', ' ')} {threshold}"

    def limit_values(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return the limit of every case, in the unit of the column; not finite for a multiple of a missing value."""
        import numpy as np

        factors = columns[self.times] if self.times else np.ones(len(columns[self.column]))
        with np.errstate(all="ignore"):
            allowed: np.ndarray = self.value * factors
        return allowed

    def is_exceeded(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return a mask of the cases beyond the bound; a value equal to it meets it.

        A missing value that means "infinite" exceeds every upper bound.
        """
        import numpy as np

        values, bounds = columns[self.column], self.limit_values(columns)
        with np.errstate(invalid="ignore"):
            is_beyond: np.ndarray = values > bounds if self.kind == KINDS[0] else values < bounds
        is_beyond &= np.isfinite(values) & np.isfinite(bounds)
        if self.null == ENDLESS and self.kind == KINDS[0]:
            is_beyond |= ~np.isfinite(values)
        return is_beyond

    def is_undecided(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return a mask of the cases that the limit cannot assess: value or bound is missing.

        A missing value that means "nothing to measure" meets every limit, one that means "infinite" every lower bound.
        """
        import numpy as np

        is_missing = ~np.isfinite(columns[self.column])
        has_bound = np.isfinite(self.limit_values(columns))
        undecided: np.ndarray = ~is_missing & ~has_bound if self.null else is_missing | ~has_bound
        return undecided

    def excess(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return by how much each value exceeds the bound, in the column's unit; negative within it, NaN: unknown."""
        import numpy as np

        with np.errstate(all="ignore"):
            distance: np.ndarray = columns[self.column] - self.limit_values(columns)
            return np.where(np.isfinite(distance), distance if self.kind == KINDS[0] else -distance, np.nan)

    def margin(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return the distance within the bound over its size, negative beyond it; NaN: unknown, or a bound of 0."""
        import numpy as np

        largest_float = np.finfo(float).max
        bounds, values = np.abs(self.limit_values(columns)), columns[self.column]
        with np.errstate(all="ignore"):
            distance = self.limit_values(columns) - values
            distance = distance if self.kind == KINDS[0] else -distance
            margin: np.ndarray = np.clip(distance / bounds, -largest_float, largest_float)
        return np.where(np.isfinite(values) & np.isfinite(bounds) & (bounds > 0.0), margin, np.nan)


def units_of(record: Mapping[str, Any]) -> dict[str, str]:
    """Return the SI unit of every column of a run, from its run.json."""
    figure_units = {figure.name: figure.unit for figure in limits_and_figures_of(record).figures}
    return {column["name"]: column["unit"] for column in record["layout"]["columns"]} | figure_units


class UserFigure(NamedTuple):
    """A user-defined figure."""

    name: str
    text: str  # expression of columns
    unit: str  # SI


class LimitsAndFigures(NamedTuple):
    """User-defined figures and limits of a grid."""

    figures: tuple[UserFigure, ...] = ()
    limits: tuple[Limit, ...] = ()

    @property
    def columns(self) -> tuple[Column, ...]:
        """Return the columns that the verdict adds to a summary."""
        figures = [Column(figure.name, figure.unit, f"own figure: {figure.text}") for figure in self.figures]
        if self.limits:
            figures += [
                Column(EXCEEDED_COLUMN, "", _EXCEEDED_DESCRIPTION, "text"),
                Column(UNDECIDED_COLUMN, "", _UNDECIDED_DESCRIPTION, "text"),
                Column(MARGIN_COLUMN, "1", _MARGIN_DESCRIPTION),
            ]
        return tuple(figures)

    def required_columns(self) -> set[str]:
        """Return the columns that the verdict needs."""
        defined = {figure.name for figure in self.figures}
        referenced = {name for figure in self.figures for name in expression.names_in(figure.text)}
        referenced |= {name for limit in self.limits for name in (limit.column, limit.times) if name}
        return referenced - defined

    def evaluate_case(self, summary: Mapping[str, Any], *, failed: bool = False) -> dict[str, Any]:
        """Return the added columns of a case from its `summary`; None for missing values."""
        if not (self.figures or self.limits):
            return {}
        import numpy as np

        known = {name: summary[name] for name in self.required_columns()}
        columns = {name: np.array([np.nan if value is None else value], float) for name, value in known.items()}
        evaluated = self.evaluate(columns, np.array([not failed]))
        return {name: None if values[0] != values[0] else values.tolist()[0] for name, values in evaluated.items()}

    def evaluate(
        self, columns: "Mapping[str, np.ndarray]", is_finished: "np.ndarray | None" = None
    ) -> "dict[str, np.ndarray]":
        """Return the added columns (n,) of cases from their `columns` (n,); NaN or None for missing values.

        is_finished : (n,), default all; of a failed case every limit is undecided and nothing else is known
        """
        import numpy as np

        values, evaluated = dict(columns), dict[str, np.ndarray]()
        for figure in self.figures:
            evaluated[figure.name] = values[figure.name] = expression.value_of(figure.text, values)
        if self.limits:
            assessment = self.assess(values, is_finished)
            evaluated[EXCEEDED_COLUMN] = self._names(assessment.exceeded)
            evaluated[UNDECIDED_COLUMN] = self._names(assessment.undecided)
            evaluated[MARGIN_COLUMN] = assessment.margin
        if is_finished is not None and not is_finished.all():
            for name in evaluated.keys() - {UNDECIDED_COLUMN}:
                values_of_all = evaluated[name].astype(object)
                values_of_all[~is_finished] = None
                evaluated[name] = values_of_all
        return evaluated

    def assess(self, columns: "Mapping[str, np.ndarray]", is_finished: "np.ndarray | None" = None) -> "Assessment":
        """Return how cases compare with each limit; `columns` include the user-defined figures, (n,) each.

        is_finished : (n,), default all
        """
        import numpy as np

        exceeded = np.array([limit.is_exceeded(columns) for limit in self.limits])
        undecided = np.array([limit.is_undecided(columns) for limit in self.limits])
        if is_finished is not None:
            exceeded &= is_finished
            undecided |= ~is_finished
        relative = np.array([limit.margin(columns) for limit in self.limits])
        if is_finished is not None:
            relative = np.where(is_finished, relative, np.nan)
        margin = np.fmin.reduce(relative, axis=0)
        is_beyond, is_open = exceeded.any(axis=0), undecided.any(axis=0)
        margin = np.where((is_open & ~is_beyond) | (is_beyond & ~(margin < 0.0)), np.nan, margin)
        return Assessment(exceeded, undecided, relative, margin)

    def _names(self, masks: "np.ndarray") -> "np.ndarray":
        """Return the columns of the limits whose mask is true, comma separated, for every case; masks : (limits, n)."""
        import numpy as np

        columns = list(dict.fromkeys(limit.column for limit in self.limits))
        of_column = np.array([[limit.column == column for limit in self.limits] for column in columns])
        is_named = (of_column.astype(np.int64) @ masks) > 0
        names = np.array(columns, object)
        patterns, indices = np.unique(is_named, axis=1, return_inverse=True)  # few differ, of many cases
        texts = np.array([",".join(names[pattern]) for pattern in patterns.T], object)
        named: np.ndarray = texts[indices.reshape(-1)]
        return named


class Assessment(NamedTuple):
    """How n cases compare with each of m limits."""

    exceeded: "np.ndarray"  # (m, n) mask
    undecided: "np.ndarray"  # (m, n) mask: value or bound is missing, or the case failed
    relative: "np.ndarray"  # (m, n) distance within the bound over its size; NaN: unknown, or a bound of 0
    margin: "np.ndarray"  # (n,) smallest of these; NaN: undecided, or exceeded though no distance is negative


_EXCEEDED_DESCRIPTION = "columns whose limits the case exceeds, separated by commas"
_UNDECIDED_DESCRIPTION = (
    "columns whose limits cannot be assessed, as the case failed or a figure is null, separated by commas"
)
_MARGIN_DESCRIPTION = (
    "smallest distance within a limit over its size, negative beyond it; null: undecided, or no limit above or below 0 "
    "shows the distance"
)
NO_LIMITS = LimitsAndFigures()


def limits_of(section: Mapping[str, Any], columns: Iterable[Column] = ()) -> tuple[Limit, ...]:
    """Return the limits in a resolved grid: column -> number, or mapping of KINDS and 'times', in SI.

    columns : columns of the summary, with the meaning of missing values
    """
    limits, nulls = [], {column.name: column.null for column in columns}
    for name, threshold in section.items():
        bounds = threshold if isinstance(threshold, Mapping) else {KINDS[0]: threshold}
        times, null = bounds.get("times", ""), nulls.get(name, "")
        limits += [Limit(name, kind, bounds[kind], times, null) for kind in KINDS if kind in bounds]
    return tuple(limits)


def limits_and_figures_of(record: Mapping[str, Any]) -> LimitsAndFigures:
    """Return the limits and the user-defined figures of a run, from its run.json."""
    columns = [Column(**column) for column in record["layout"]["columns"]]
    units = {column.name: column.unit for column in columns}
    limits = limits_of(record.get("limits") or {}, columns)
    return LimitsAndFigures(figures_of(record.get("figures") or {}, units), limits)


def figures_of(section: Mapping[str, str], units: Mapping[str, str]) -> tuple[UserFigure, ...]:
    """Return the user-defined figures of a grid, functions of columns and earlier figures.

    Raise InputError for mistakes.
    """
    known_units, figures = dict(units), []
    for name, text in section.items():
        known_units[name] = expression.unit_of(text, known_units)
        figures.append(UserFigure(name, text, known_units[name]))
    return tuple(figures)


# Labels of columns in words: the same in the last lines of a run and on its page.

#: Figure -> its label, where this is not its name in words.
_LABELS = {
    "error_max": "{output} error",
    "film_loss": "film loss",
    "film_thickness_min": "least film",
    "force_peak_ideal": "ideal peak",
    "force_peak_ratio": "load over ideal peak",
    "impacts_per_rev": "impacts per revolution",
    "life_hours": "life",
    "onset_rate_max": "fastest onset",
    "start_up_time": "start-up time",
    "crank_speed_after": "lowest crank speed after the start",
    "crank_speed_max": "highest crank speed",
    "force_peak_start": "force peak until the start-up time",
    "wear_depth_max": "wear depth",
    "wear_rate_max": "wear rate",
}


def column_label(layout: Layout, name: str) -> str:
    """Return the label of a column, with its joint if there are several; for a user-defined figure, its name."""
    column = next((column for column in layout.columns if column.name == name), None)
    if column is None or not column.figure:
        return re.sub(r"\bum\b", "\u00b5m", name.replace("_", " "))
    label_text = _LABELS.get(column.figure, column.figure.replace("_", " ")).format(output=layout.output)
    is_joint_named = column.joint and len(layout.joints) > 1
    return f"{label_text} ({wording.joint_name(column.joint)})" if is_joint_named else label_text


def limit_label(layout: Layout, limit: Limit, unit: str) -> str:
    """Return a limit in words: 'force peak at most 60 kN', 'load peak at most 2 times the ideal peak'."""
    bound_text = limit.bound_text(unit)
    if limit.times:
        bound_text = bound_text.replace(limit.times, f"the {column_label(layout, limit.times)}")
    return f"{column_label(layout, limit.column)} {bound_text}"


def capitalise(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]


# The judged cases of a run: their varied values as codes, their figures and their verdicts.

MET, EXCEEDED, UNDECIDED = "met", "exceeded", "undecided"  # verdicts of a case
#: Last keys of numerical settings of which the smaller value is the finer one; of all others it is the larger one.
FINER_IF_SMALLER = ("tolerance", "velocity_scale", "v0", "v1", "width", "from")

Key = tuple[int, ...]  # codes of the values at some paths, -1 where the case does not use a path


class Cases:
    """The judged cases of a run, with the codes of their varied values."""

    def __init__(
        self, record: Mapping[str, Any], columns: Mapping[str, Any], own: Sequence[bool] | np.ndarray | None = None
    ):
        """Prepare the cases of a grid.

        record : run.json; columns : (n,) each, by name; own : (n,) mask of the grid's own cases, default all
        """
        self.record = record
        is_own = np.ones(len(columns["case_id"]), bool) if own is None else np.asarray(own, bool)
        self.added_count = int((~is_own).sum())
        self._columns = columns
        self.role_by_path: dict[str, str] = dict(record.get("roles") or {})
        self._rows = np.flatnonzero(is_own)
        self.paths = [path for path in self.role_by_path if self._is_varied(path)]
        self.coarse_rows = np.zeros(0, int)
        numerics = self.paths_of(catalogue.NUMERICS)
        if numerics and len(self._rows):
            self.finest_of, is_finest = _finest(self, numerics)
            self._all_rows = self._rows
            self._rows = self._rows[is_finest]
        self.codes = {path: codes_of(self.values(path)) for path in self.paths if path not in numerics}
        status = self.values("status")
        self.is_finished = np.array([value == "ok" for value in status.tolist()], bool)

    def __len__(self) -> int:
        return len(self._rows)

    def _is_varied(self, path: str) -> bool:
        if path not in self._columns:
            return False
        values = _array(self._columns[path])
        return len(codes_of(values[self._rows] if len(self._rows) else values)[0]) > 1  # a search runs none of its own

    def paths_of(self, *names: str) -> list[str]:
        """Return the varied paths with one of these roles."""
        return [path for path in self.paths if self.role_by_path[path] in names]

    def values(self, name: str) -> np.ndarray:
        """Return a column of the judged cases."""
        return _array(self._columns[name])[self._rows]

    def numbers(self, name: str) -> np.ndarray:
        """Return a figure of the judged cases as floats; NaN where it is missing or the case failed."""
        return np.where(self.is_finished, _floats(self.values(name)), np.nan)

    def figure_of_all(self, name: str) -> np.ndarray:
        """Return a figure of the own cases, coarse ones included, as floats; NaN where it is missing."""
        is_ok = np.array([value == "ok" for value in _array(self._columns["status"])[self._all_rows].tolist()])
        return np.where(is_ok, _floats(_array(self._columns[name])[self._all_rows]), np.nan)

    def values_of_all(self, name: str) -> np.ndarray:
        """Return a column of the own cases, coarse ones included."""
        return _array(self._columns[name])[self._all_rows]

    def rows_of(self, values: Mapping[str, Any]) -> np.ndarray:
        """Return the judged cases (indices) with these values, in the form of the answer; an unused path matches."""
        is_match = np.ones(len(self), bool)
        for path, value in values.items():
            levels, codes = self.codes[path]
            wanted = [code for code, level in enumerate(levels) if named_value(self.record, path, level) == value]
            is_match &= np.isin(codes, [-1, *wanted])
        return np.flatnonzero(is_match)

    def keys(self, paths: Sequence[str]) -> list[Key]:
        """Return the codes of every case at some paths."""
        columns = [self.codes[path][1].tolist() for path in paths]
        return list(zip(*columns, strict=True)) if columns else [()] * len(self)

    def values_at(self, paths: Sequence[str], key: Key) -> dict[str, Any]:
        """Return the values of a key in the form of the answer, without unused paths."""
        return {
            path: named_value(self.record, path, self.codes[path][0][code])
            for path, code in zip(paths, key, strict=True)
            if code >= 0
        }

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """Return the limits of the grid."""
        return limits_and_figures_of(self.record).limits

    @cached_property
    def assessment(self) -> Assessment:
        """Return how the judged cases compare with the limits."""
        names = {name for limit in self.limits for name in (limit.column, limit.times) if name}
        columns = {name: self.numbers(name) for name in names}
        return LimitsAndFigures((), self.limits).assess(columns, self.is_finished)

    @cached_property
    def verdicts(self) -> np.ndarray:
        """Return the verdict of every judged case, (n,)."""
        exceeded, undecided = self.assessment.exceeded.any(axis=0), self.assessment.undecided.any(axis=0)
        return np.where(exceeded, EXCEEDED, np.where(undecided, UNDECIDED, MET))


def _finest(cases: Cases, numerics: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return for every own case the position of the finest case that differs in numerics alone, and a mask of these."""
    others = [path for path in cases.paths if path not in numerics]
    group = combined_codes([codes_of(cases.values(path))[1] for path in others], len(cases))
    fineness = [fineness_of(path, *codes_of(cases.values(path))) for path in numerics]
    order = np.lexsort([*fineness[::-1], group])
    is_last = np.append(np.diff(group[order]) != 0, True)
    finest_of_group = dict(zip(group[order][is_last].tolist(), order[is_last].tolist(), strict=True))
    finest_of = np.array([finest_of_group[number] for number in group.tolist()])
    return finest_of, finest_of == np.arange(len(cases))


def fineness_of(path: str, levels: list, codes: np.ndarray) -> np.ndarray:
    """Return numbers (n,) that increase with the fineness of the values at a numerical path."""
    sign = -1 if path.rpartition(".")[2] in FINER_IF_SMALLER else 1
    return sign * codes


def combined_codes(columns: Sequence[np.ndarray], count: int) -> np.ndarray:
    """Return one number for each case that is equal where all codes are; columns : (n,) each."""
    number = np.zeros(count, np.int64)
    for codes in columns:
        number = number * (int(codes.max(initial=0)) + 2) + codes + 1
        number = np.unique(number, return_inverse=True)[1].reshape(-1)
    return number


def codes_of(values: np.ndarray) -> tuple[list, np.ndarray]:
    """Return the distinct values, numbers ascending, texts in order of appearance, and each value's index; null: -1."""
    if values.dtype.kind in "fiub":
        unique_values, indices = np.unique(values, return_inverse=True)
        is_known = np.isfinite(unique_values.astype(float))
        return unique_values[is_known].tolist(), np.where(is_known[indices], indices, -1).reshape(-1)
    present = [value for value in values.tolist() if not is_null(value)]
    has_text = any(isinstance(value, str) for value in present)
    levels = list(dict.fromkeys(present)) if has_text else sorted(set(present))
    index_of = {value: index for index, value in enumerate(levels)}
    return levels, np.array([-1 if is_null(value) else index_of[value] for value in values.tolist()], int)


def is_null(value: Any) -> bool:
    """Return whether a value is None or NaN."""
    return value is None or (isinstance(value, float) and math.isnan(value))


def named_value(record: Mapping[str, Any], path: str, value: Any) -> Any:
    """Return a varied value as the answer has it: the label or the fit if it has one, a law's name, else SI."""
    for name, labelled in ((record.get("labels") or {}).get(path) or {}).items():
        if labelled == value:
            return name
    for fit in (record.get("fits") or {}).get(path) or ():
        if fit["mean"] == value:
            return fit["name"]
    return plain_value(value)


def plain_value(value: Any) -> Any:
    """Return a value as JSON has it: a word, a truth value or a float."""
    return value if isinstance(value, str | bool) else float(value)


def _array(values: Any) -> np.ndarray:
    return values if isinstance(values, np.ndarray) else np.array(list(values), object)


def _floats(values: np.ndarray) -> np.ndarray:
    if values.dtype.kind == "O":
        return np.array([np.nan if is_null(value) else value for value in values.tolist()], float)
    return values.astype(float)
