"""User-defined figures and limits of a grid: their columns, the limits that a case exceeds, its margin."""

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..contracts.catalogue import ENDLESS, NOTHING
from ..contracts.layout import Column
from ..language import expression, wording

if TYPE_CHECKING:
    import numpy as np  # imported only when cases are assessed

EXCEEDED, MARGIN = "limits_exceeded", "margin"  # columns
KINDS = ("at_most", "at_least")
SMALL_MARGIN = 0.1  # margins below this are not certain


class Limit(NamedTuple):
    """A bound on a column."""

    column: str
    kind: str  # one of KINDS
    value: float  # SI: unit of the column over that of `times`
    times: str = ""  # another column, of which the bound is a multiple, or ''
    null: str = ""  # meaning of a missing value, see `contracts.layout.Column`

    def bound_text(self, unit: str) -> str:
        """Return the bound in words, for a column in `unit`: 'at most 5 kN', 'at least 2 times NAME'."""
        scale = wording.scale("1" if self.times else unit, self.value)
        threshold = scale.exact_text(self.value) + (f" times {self.times}" if self.times else "")
        return f"{self.kind.replace('_', ' ')} {threshold}"

    def limit_values(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return the limit of every case, in the unit of the column; not finite for a multiple of a missing value."""
        import numpy as np

        factors = columns[self.times] if self.times else np.ones(len(columns[self.column]))
        with np.errstate(all="ignore"):
            allowed: np.ndarray = self.value * factors
        return allowed

    def slack(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return the distance of each case to the bound, in the column's unit, negative beyond it."""
        import numpy as np

        with np.errstate(all="ignore"):
            distance: np.ndarray = self.limit_values(columns) - columns[self.column]
        return distance if self.kind == "at_most" else -distance

    def is_unknown(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return a mask of the cases that cannot be assessed because value or bound is missing or not finite.

        A missing value that means "nothing to measure" meets every limit; one that means "infinite" is assessed.
        """
        import numpy as np

        is_missing = ~np.isfinite(columns[self.column])
        if self.null == NOTHING:
            unknown: np.ndarray = ~is_missing & ~np.isfinite(self.limit_values(columns))
        elif self.null == ENDLESS:
            unknown = ~np.isfinite(self.limit_values(columns))
        else:
            unknown = is_missing | ~np.isfinite(self.limit_values(columns))
        return unknown

    def is_exceeded(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return a mask of the cases that exceed the limit or cannot be assessed."""
        import numpy as np

        is_failing: np.ndarray = (self.slack(columns) < 0.0) | self.is_unknown(columns)
        if self.null == ENDLESS and self.kind == "at_most":
            is_failing |= ~np.isfinite(columns[self.column])
        return is_failing

    def margin(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return the margin of every case: 1 - value / limit, or value / limit - 1 for `at_least`.

        It is NaN for a zero limit.
        """
        import numpy as np

        largest_float = np.finfo(float).max
        with np.errstate(all="ignore"):
            bound_size = np.abs(self.limit_values(columns))
            margin: np.ndarray = np.where(bound_size > 0.0, self.slack(columns) / bound_size, np.nan)
            is_usable = np.isfinite(columns[self.column]) & np.isfinite(bound_size)
        return np.where(is_usable, np.clip(margin, -largest_float, largest_float), np.nan)


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
                Column(EXCEEDED, "", _EXCEEDED_DESCRIPTION, "text"),
                Column(MARGIN, "1", _MARGIN_DESCRIPTION),
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
        if failed:
            return dict.fromkeys(column.name for column in self.columns)
        import numpy as np

        known = {name: summary[name] for name in self.required_columns()}
        evaluated = self.evaluate(
            {name: np.array([np.nan if value is None else value]) for name, value in known.items()}
        )
        return {name: None if values[0] != values[0] else values.tolist()[0] for name, values in evaluated.items()}

    def evaluate(self, columns: "Mapping[str, np.ndarray]") -> "dict[str, np.ndarray]":
        """Return the added columns (n,) of finished cases from their `columns` (n,); NaN for missing values.

        A case that cannot be assessed counts as exceeding its limit, with a missing margin.
        """
        import numpy as np

        values, evaluated = dict(columns), dict[str, np.ndarray]()
        for figure in self.figures:
            evaluated[figure.name] = values[figure.name] = expression.value_of(figure.text, values)
        if self.limits:
            is_beyond = {limit.column: np.zeros(len(values[limit.column]), bool) for limit in self.limits}
            for limit in self.limits:
                is_beyond[limit.column] |= limit.is_exceeded(values)
            is_beyond_table = np.array(list(is_beyond.values()))
            names = np.array(list(is_beyond), object)
            evaluated[EXCEEDED] = np.array(
                [",".join(names[is_beyond_case]) for is_beyond_case in is_beyond_table.T], object
            )
            margins = np.array([limit.margin(values) for limit in self.limits])
            evaluated[MARGIN] = np.where(self.is_unknown(values), np.nan, np.fmin.reduce(margins, axis=0))
        return evaluated

    def is_unknown(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return a mask of the cases that some limit cannot assess; `columns` include the user-defined figures."""
        import numpy as np

        unknown: np.ndarray = np.any([limit.is_unknown(columns) for limit in self.limits], axis=0)
        return unknown


_EXCEEDED_DESCRIPTION = "columns whose limits the case exceeds or that cannot be assessed, separated by commas"
_MARGIN_DESCRIPTION = (
    "smallest of 1 - value/limit (value/limit - 1 for at_least); null: a limit cannot be assessed or has no margin"
)
NO_LIMITS = LimitsAndFigures()


def margin_text(margin: float, limits: Iterable[Limit], exceeded: str) -> str:
    """Return a margin in per cent, or a dash if missing; values above twice the limit also as a multiple of it.

    limits : limits of the grid
    exceeded : columns whose limits the case exceeds, as in EXCEEDED
    """
    exceeded_limits = [limit for limit in limits if limit.column in exceeded.split(",")]
    if not math.isfinite(margin):
        return wording.DASH
    percentage = f"{wording.short_number_text(100.0 * margin, 3)}{wording.BLANK}%"
    if margin < -1.0 and all(limit.kind == "at_most" and limit.value > 0.0 for limit in exceeded_limits):
        return f"{percentage} ({wording.number_text(1.0 - margin, 2)} times the limit)"
    return percentage


def small_margin_sentences(margin: float) -> list[str]:
    """Return the reservation on a margin that is met, but smaller than SMALL_MARGIN; else []."""
    if not 0.0 <= margin < SMALL_MARGIN:
        return []
    return ["Such a small margin is not certain: other contact laws, or higher peaks in longer runs, may use it up."]


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
