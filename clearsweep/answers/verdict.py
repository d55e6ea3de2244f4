"""Figures and limits of a grid: their columns and labels, the limits that each case exceeds, its margin and verdict."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..contracts.catalogue import ENDLESS
from ..contracts.layout import ORDER, Column, Layout
from ..contracts.vibration import PLACE_FIGURES
from ..language import expression, np, wording
from ..language.quantity import WrittenUnit

EXCEEDED_COLUMN, UNDECIDED_COLUMN, MARGIN_COLUMN = "limits_exceeded", "limits_undecided", "margin"  # columns
KINDS = ("at_most", "at_least")
_FLOORS = {"life_revolutions": "life_low", "life_hours": "life_low_hours"}  # figure -> what it exceeds where missing


@dataclass(frozen=True)
class Limit:
    """A bound on a column."""

    column: str
    kind: str  # one of KINDS
    value: float  # SI: unit of the column over that of `times`
    times: str = ""  # another column, of which the bound is a multiple, or ''
    null: str = ""  # meaning of a missing value, see `contracts.layout.Column`
    floor: str = ""  # another column, which a missing value is known to exceed, or ''
    written: WrittenUnit | None = field(default=None, compare=False)  # the unit in which the grid has it

    @property
    def required_columns(self) -> tuple[str, ...]:
        """Return the columns that decide whether the limit is met."""
        return tuple(name for name in (self.column, self.times, self.floor) if name)

    def bound_text(self, unit: str) -> str:
        """Return the bound in words, for a column in `unit`: 'at most 5 kN', 'at least 2 times NAME'."""
        is_temperature = unit == "K" and self.column.endswith("temperature") and not self.times
        scale = (
            (self.written and wording.written_scale(self.written._asdict(), unit))
            or (is_temperature and wording.temperature_scale())
            or wording.scale("1" if self.times else unit, self.value)
        )
        threshold = scale.exact_text(self.value) + (f" times {self.times}" if self.times else "")
        return f"{self.kind.replace('_', ' ')} {threshold}"

    def limit_values(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return the limit of every case, in the unit of the column; not finite for a multiple of a missing value."""
        factors = columns[self.times] if self.times else np.ones(len(columns[self.column]))
        with np.errstate(all="ignore"):
            allowed: np.ndarray = self.value * factors
        return allowed

    def is_exceeded(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return a mask of the cases beyond the bound; a value equal to it meets it.

        Infinity, and a missing value that means it, exceeds every upper bound, a missing one with a floor above it too.
        """
        values, bounds = columns[self.column], self.limit_values(columns)
        with np.errstate(invalid="ignore"):
            is_beyond: np.ndarray = values > bounds if self.kind == KINDS[0] else values < bounds
        is_beyond &= np.isfinite(bounds)
        if self.null == ENDLESS and self.kind == KINDS[0]:
            is_beyond |= np.isnan(values)
        if self.floor and self.kind == KINDS[0]:
            is_beyond |= self._has_floor_beyond(columns)
        return is_beyond

    def is_undecided(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return a mask of the cases that the limit cannot assess: value or bound is missing.

        A missing value that means "nothing to measure" meets every limit, one that means "infinite" every lower bound.
        One with a floor above the bound is decided.
        """
        is_missing = np.isnan(columns[self.column])
        has_bound = np.isfinite(self.limit_values(columns))
        undecided: np.ndarray = ~is_missing & ~has_bound if self.null else is_missing | ~has_bound
        return undecided & ~self._has_floor_beyond(columns) if self.floor else undecided

    def _has_floor_beyond(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return a mask of the missing values that are known to be above the bound."""
        bounds = self.limit_values(columns)
        is_above: np.ndarray = np.isnan(columns[self.column]) & np.isfinite(bounds) & (columns[self.floor] > bounds)
        return is_above

    def excess(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return by how much each value exceeds the bound, in the column's unit; negative within it, NaN: unknown."""
        with np.errstate(all="ignore"):
            distance: np.ndarray = columns[self.column] - self.limit_values(columns)
            return np.where(np.isfinite(distance), distance if self.kind == KINDS[0] else -distance, np.nan)

    def margin(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return the distance within the bound over its size, negative beyond it; NaN: unknown, or a bound of 0."""
        largest_float, bounds = np.finfo(float).max, np.abs(self.limit_values(columns))
        with np.errstate(all="ignore"):
            margin: np.ndarray = np.clip(-self.excess(columns) / bounds, -largest_float, largest_float)
        return np.where(bounds > 0.0, margin, np.nan)


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
        referenced |= {name for limit in self.limits for name in limit.required_columns}
        return referenced - defined

    def evaluate_case(self, summary: Mapping[str, Any], *, failed: bool = False) -> dict[str, Any]:
        """Return the added columns of a case from its `summary`; None for missing values."""
        if not (self.figures or self.limits):
            return {}

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


def limits_of(
    section: Mapping[str, Any], columns: Iterable[Column] = (), written_units: Mapping[str, Mapping] | None = None
) -> tuple[Limit, ...]:
    """Return the limits in a resolved grid: column -> number, or mapping of KINDS and 'times', in SI.

    columns : columns of the summary, with the meaning of missing values; written_units : as in run.json
    """
    limits, by_name = [], {column.name: column for column in columns}
    for name, threshold in section.items():
        bounds = threshold if isinstance(threshold, Mapping) else {KINDS[0]: threshold}
        unit = (written_units or {}).get(f"limits.{name}")
        written = WrittenUnit(**unit) if unit else None
        column, times = by_name.get(name), bounds.get("times", "")
        null = column.null if column else ""
        floor = f"{column.joint}_{_FLOORS[column.figure]}" if column and column.figure in _FLOORS else ""
        limits += [Limit(name, kind, bounds[kind], times, null, floor, written) for kind in KINDS if kind in bounds]
    return tuple(limits)


def limits_and_figures_of(record: Mapping[str, Any]) -> LimitsAndFigures:
    """Return the limits and the user-defined figures of a run, from its run.json."""
    columns = [Column(**column) for column in record["layout"]["columns"]]
    units = {column.name: column.unit for column in columns}
    limits = limits_of(record.get("limits") or {}, columns, record.get("written_units"))
    return LimitsAndFigures(figures_of(record.get("figures") or {}, units), limits)


def figures_of(section: Mapping[str, Any], units: Mapping[str, str]) -> tuple[UserFigure, ...]:
    """Return the user-defined figures of a grid that are expressions of columns and earlier figures.

    A section is a figure of one's own, which is a column already.  Raise InputError for mistakes.
    """
    known_units, figures = dict(units), []
    for name, text in section.items():
        if not isinstance(text, str):
            continue
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
    "axial_impacts_per_rev": "axial impacts per revolution",
    "film_taylor": "Taylor number of the film",
    "force_peak_million": "force peak of a million revolutions",
    "force_peak_million_high": "force peak of a million revolutions, high",
    "life_hours": "life",
    "life_l10r": "L10r life",
    "life_l10r_revolutions": "L10r life in millions of revolutions",
    "lyapunov_exponent": "Lyapunov exponent",
    "onset_rate_max": "fastest onset",
    "pv_limit_fraction": "time past pv_limit",
    "pv_mean": "pV mean",
    "pv_peak": "pV peak",
    "rhs_evaluations": "evaluations",
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
    if column is None or not column.figure or column.figure in PLACE_FIGURES or ORDER in column.figure:
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
