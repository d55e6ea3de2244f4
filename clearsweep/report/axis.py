"""Axes, cases and figures of a run for display: scales, units, texts, columns read on demand."""

import bisect
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import numpy as np

from .. import grid
from ..answers.ranking import ranking_of
from ..answers.verdict import Limit, column_label
from ..contracts.layout import Layout
from ..grid import Definitions, Fit
from ..language import wording
from ..store import StoredRun

# Axes of a run for display: names, scales and texts of swept values.

CHUNK_VALUES = 65_536  # values looked up together
MIN_DIGITS = 4  # of a swept value, if these distinguish its values
MAX_LISTED_NUMBERS, MAX_LISTED_NAMES = 6, 16  # most values of an axis that a sentence lists
GEOMETRIC_RATIO = 8.0  # of the last value to the first, from which an axis may be logarithmic
MAX_LEVELS = 30  # distinct values of a parallel axis above which it is scattered and its levels are not compared


class Axis(NamedTuple):
    """One swept path and its values: numbers ascend, names are in the order of the grid."""

    path: str
    name: str  # in words
    scale: wording.Scale
    values: tuple  # SI floats or strings
    digits: int  # significant digits that distinguish its values, at least MIN_DIGITS
    is_scattered: bool = False  # shown case by case: few cases share a value; `values` are ascending
    has_written_unit: bool = False  # its scale is the unit written in the grid
    names: Mapping[float, str] = MappingProxyType({})  # value -> its name in the grid: a fit of ISO 286
    labels: Mapping[float, str] = MappingProxyType({})  # value -> the user's own label

    @property
    def is_numeric(self) -> bool:
        """Return whether the values are numbers, not names."""
        return not any(isinstance(value, str) for value in self.values)

    @property
    def is_geometric(self) -> bool:
        """Return whether positive values over a wide range are spaced by factors rather than by differences."""
        if not self.is_numeric or len(self.values) < 2 or self.values[0] <= 0.0:
            return False
        values = np.sort(np.asarray(self.values, float))
        steps, factors = np.diff(values), np.diff(np.log(values))
        is_wide = values[-1] >= GEOMETRIC_RATIO * values[0]
        return bool(is_wide and np.std(factors) / np.mean(factors) < np.std(steps) / np.mean(steps))

    def number_text(self, value: float | str) -> str:
        """Return a value without its unit."""
        return self._named(value, self.scale.exact_number_text)

    def text(self, value: float | str) -> str:
        """Return a value with its unit."""
        return self._named(value, self.scale.exact_text)

    def _named(self, value: float | str, text_of: Callable[[float, int], str]) -> str:
        """Return a value in words, with the name of its fit and its label."""
        if isinstance(value, str):
            return value
        text = text_of(value, self.digits) + (f" ({self.names[value]})" if value in self.names else "")
        return f"{self.labels[value]} ({text})" if value in self.labels else text

    def short_text(self, value: float | str) -> str:
        """Return the name of a value, or its number with few digits, for an axis of a figure."""
        if isinstance(value, str):
            return value
        return (
            self.labels.get(value) or self.names.get(value) or wording.short_number_text(self.scale.from_si(value), 3)
        )

    def values_text(self) -> str:
        """Return the values in a sentence: a few are listed with one unit; of many, the count and both ends."""
        if self.is_scattered or len(self.values) > (MAX_LISTED_NUMBERS if self.is_numeric else MAX_LISTED_NAMES):
            return f"in {self.range_text()}"
        if self.names or self.labels:
            return ", ".join(map(self.text, self.values))
        return self.scale.with_unit(", ".join(self.number_text(value) for value in self.values))

    def range_text(self) -> str:
        """Return the number of values and both ends."""
        return f"{len(self.values)} values, {self.text(self.values[0])} to {self.text(self.values[-1])}"

    def label(self) -> str:
        """Return name and unit, for an axis of a figure."""
        is_named = all(value in self.names or value in self.labels for value in self.values)
        return f"{self.name} [{self.scale.unit}]" if self.scale.unit and not is_named else self.name


def index_on_axis(axis: Axis, values: np.ndarray) -> np.ndarray:
    """Return the index of each value on its axis (0, 1, ...), -1 if it is not on the axis."""
    if not axis.is_numeric:
        index_of = {value: index for index, value in enumerate(axis.values)}
        return np.array([index_of.get(value, -1) for value in values], np.int32)
    axis_values, case_values = np.asarray(axis.values, float), np.asarray(values, float)
    order, indices = np.argsort(axis_values), np.empty(len(case_values), np.int32)
    for start in range(0, len(case_values), CHUNK_VALUES):
        chunk = case_values[start : start + CHUNK_VALUES]
        upper_neighbours = np.searchsorted(axis_values[order], chunk).clip(1, max(len(axis_values) - 1, 1))
        neighbours = order[np.stack([upper_neighbours - 1, upper_neighbours.clip(max=len(axis_values) - 1)])]
        nearest = neighbours[np.abs(axis_values[neighbours] - chunk).argmin(axis=0), np.arange(len(chunk))]
        is_near = np.isclose(axis_values[nearest], chunk, rtol=1e-9, atol=0.0)
        indices[start : start + CHUNK_VALUES] = np.where(is_near, nearest, -1)
    return indices


def axes_of(record: Mapping, tried: dict, units: Mapping[str, str], joints: int) -> tuple[Axis, ...]:
    """Return the axes of a run: swept, parallel, drawn, and `tried` by a search; without values added by `refine`."""
    swept, parallel = record.get("sweep") or {}, (record.get("zip") or {}) | (record.get("cases") or {}) | tried
    drawn_values = (record.get("sample") or {}).get("drawn", {})
    has_candidates = bool((record.get("seek") or {}).get("among"))
    axes = [_axis(path, tuple(values), units.get(path, "1"), joints) for path, values in swept.items()]
    for path, values in (parallel | drawn_values).items():
        distinct_values = tuple(dict.fromkeys(values))
        if path in drawn_values or (path in tried and not has_candidates) or len(distinct_values) > MAX_LEVELS:
            ascending_values = tuple(sorted(distinct_values))
            end_axis = _axis(path, ascending_values[:: max(len(ascending_values) - 1, 1)], units.get(path, "1"), joints)
            axes.append(end_axis._replace(values=ascending_values, digits=MIN_DIGITS, is_scattered=True))
        else:
            axes.append(_axis(path, distinct_values, units.get(path, "1"), joints))
    # Axes with a common unit for axes of the same kind, such as the clearances of several joints
    values_by_quantity: dict[tuple[str, str], list[float]] = {}
    for axis in axes:
        if axis.is_numeric:
            values_by_quantity.setdefault(_quantity_key(axis, units), []).extend(axis.values)
    fits, labels = grid.recorded_fits(record), grid.recorded_labels(record)
    described = []
    for axis in axes:
        (kind, unit), scale = _quantity_key(axis, units), axis.scale
        if axis.is_numeric:
            scale = wording.scale(unit, values_by_quantity[kind, unit], speed=kind == "speed")
        written_scale = wording.written_scale(record.get("written_units", {}).get(axis.path), unit)
        names = {value: label for label, value in labels.get(axis.path, {}).items()}
        with_scale = axis._replace(scale=written_scale or scale, has_written_unit=bool(written_scale), labels=names)
        described.append(_with_fits(with_scale, fits.get(axis.path, ()), drawn=axis.path in drawn_values))
    return tuple(described)


def _quantity_key(axis: Axis, units: Mapping[str, str]) -> tuple[str, str]:
    return axis.path.rsplit(".", 1)[-1], units.get(axis.path, "1")


def _with_fits(axis: Axis, fits: Iterable[Fit], *, drawn: bool) -> Axis:
    """Return an axis that names the fits whose mean clearances are its values, or from which they are `drawn`."""
    names = {fit.mean: fit.name for fit in fits}
    radial_name = wording.name_with_fits(axis.name, names.values())
    if drawn and names:
        name = f"{radial_name} ({wording.sentence_list(list(names.values()))})"
        return axis._replace(name=name, scale=axis.scale if axis.has_written_unit else wording.fit_scale())
    scale = wording.fit_scale() if names and not axis.has_written_unit else axis.scale
    return axis._replace(name=radial_name, names=names, scale=scale)


def _axis(path: str, values: tuple, unit: str, joints: int) -> Axis:
    numbers = [value for value in values if not isinstance(value, str)]
    values = tuple(sorted(values)) if len(numbers) == len(values) else values
    scale = wording.scale(unit, numbers, speed=path.endswith("speed")) if numbers else wording.Scale(1.0, "")
    digits = MIN_DIGITS
    while digits < 16 and len({scale.exact_number_text(value, digits) for value in numbers}) < len(set(numbers)):
        digits += 1
    return Axis(path, wording.axis_name(path, joints), scale, values, digits)


# Values of nested mappings by dotted path, and the paths that a run searched.


def leaves(tree: Mapping, prefix: str = "") -> list[tuple[str, object]]:
    """Return the leaves of a nested mapping: dotted path, value."""
    pairs: list[tuple[str, object]] = []
    for key, value in tree.items():
        pairs += leaves(value, f"{prefix}{key}.") if isinstance(value, Mapping) else [(f"{prefix}{key}", value)]
    return pairs


def sought_paths(record: Mapping) -> tuple[str, ...]:
    """Return the parallel paths whose largest or smallest value a run searches for."""
    seek = record.get("seek") or {}
    paths = seek.get("largest") or seek.get("smallest") or ()
    return (paths,) if isinstance(paths, str) else tuple(paths)


def tried_paths(record: Mapping) -> tuple[str, ...]:
    """Return the paths whose values were chosen by a search."""
    searched = record.get("optimise") or record.get("identify") or {}
    return sought_paths(record) or tuple(searched.get("over", ()))


# Cases of a run as a table whose columns are read on demand: a page needs only a few of a million cases.

Result = TypeVar("Result")
CACHED_VALUES = 3_000_000  # values in memory, of the latest columns: of a million cases three, of 8 MB each


class Rows:
    """Some cases of a run by case_id, ascending: `index` has these, `rows[column]` an array of a column.

    Numbers are float64, NaN for missing values; texts are objects, None for missing ones.
    """

    def __init__(
        self,
        run: StoredRun,
        ids: np.ndarray,
        is_selected: np.ndarray,
        text_columns: set[str],
        derived: Mapping[str, Callable[["Rows"], np.ndarray]] | None = None,
    ) -> None:
        """Take the case_id of all rows of a summary, the mask of these cases, text and computed columns."""
        self._run, self._text_columns, self._derived = run, text_columns, derived or {}
        self.selected = is_selected  # (rows of the summary,)
        self._selection = slice(None) if is_selected.all() else is_selected
        self.index = ids[self._selection]
        self.columns = [name for name in run.columns if name != "case_id"] + list(self._derived)
        self._names = frozenset(self.columns)
        self.column_cache: OrderedDict[str, np.ndarray] = OrderedDict()
        self._result_cache: dict[Hashable, Any] = {}

    def __len__(self) -> int:
        return len(self.index)

    def __contains__(self, column: str) -> bool:
        return column in self._names

    def __getitem__(self, column: str) -> np.ndarray:
        """Return a column; raise KeyError if it is missing."""
        if column in self.column_cache:
            self.column_cache.move_to_end(column)
            return self.column_cache[column]
        if column not in self:
            raise KeyError(column)
        values = self._derived[column](self) if column in self._derived else self._read(column)
        self.column_cache[column] = values
        while len(self.column_cache) > 1 and len(self.column_cache) * len(self) > CACHED_VALUES:
            self.column_cache.popitem(last=False)
        return values

    def get(self, column: str, default: Any) -> Any:
        """Return a column, or `default` if it is missing."""
        if column in self:
            return self[column]
        return default

    def _read(self, column: str) -> np.ndarray:
        values: np.ndarray = self._run.column(column)[self._selection]
        return values if column in self._text_columns else values.astype(float, copy=False)

    @property
    def empty(self) -> bool:
        """Return whether there are no cases."""
        return not len(self)

    def at(self, case_id: str, column: str) -> Any:
        """Return one value; raise KeyError if the case or the column is missing."""
        if (row := self.row_of(case_id)) < 0:
            raise KeyError(case_id)
        return self[column][row]

    def row_of(self, case_id: str) -> int:
        """Return the row of a case, -1 if it is not among them."""
        row = bisect.bisect_left(range(len(self)), case_id, key=self.index.__getitem__)
        return row if row < len(self) and self.index[row] == case_id else -1

    def largest(self, column: str) -> float:
        """Return the largest value of a figure, or NaN if it has no value or column."""
        if column not in self:
            return np.nan
        return self.cached(("largest", column), lambda: float(np.fmax.reduce(self[column], initial=np.nan)))

    def smallest(self, column: str) -> float:
        """Return the smallest value of a figure, NaN if it has none."""
        return float(np.fmin.reduce(self[column], initial=np.nan))

    def varies(self, column: str) -> bool:
        """Return whether cases differ in a figure."""
        return column in self and self.smallest(column) < self.largest(column)

    def worst_case(self, column: str, *, smallest: bool = False) -> str:
        """Return the case with the largest (or smallest) value of a column, or the first one if none has a value."""
        return str(self.index[self.ordered(column, smallest=smallest)[0]])

    def ordered(self, column: str, *, smallest: bool = False) -> np.ndarray:
        """Return the indices of all cases by the value of a column, descending (or ascending), missing values last."""
        values = self[column]
        return np.argsort(values if smallest else -values, kind="stable")

    def representative_cases(self, column: str) -> tuple[str, ...]:
        """Return the cases with the largest, the median and the smallest value of a column, without repetition."""
        order = self.ordered(column)[: np.count_nonzero(~np.isnan(self[column]))]
        return tuple(self.index[order[k]] for k in dict.fromkeys((0, len(order) // 2, len(order) - 1)) if len(order))

    def cached(self, key: Hashable, compute: Callable[[], Result]) -> Result:
        """Return the result of `compute`, cached by key, for small results that several sections need."""
        if key not in self._result_cache:
            self._result_cache[key] = compute()
        return self._result_cache[key]


def dependent_values(definitions: Definitions, path: str, cases: Rows, base: Mapping) -> np.ndarray:
    """Return a number derived from swept names, for every case."""
    axes = {f"define.{name}": cases[f"define.{name}"] for name in sorted(definitions.varied_names)}
    points = (dict(zip(axes, values, strict=True)) for values in zip(*axes.values(), strict=True))
    return np.array([definitions.values_at(point)[path] for point in points], float)


# The figure of a joint that leads maps, effects and comparisons, according to the grid.


class LeadingFigure(NamedTuple):
    """The figure of a joint that leads maps, effects and comparisons."""

    figure: str
    name: str
    smallest: bool = False  # whether the smallest value is the worst


PEAK = LeadingFigure("force_peak", "force peak")
LEADING_FIGURES = {
    "life": LeadingFigure("life_hours", "life", smallest=True),
    "film": LeadingFigure("film_thickness_min", "least film", smallest=True),
}


def leading_figure(
    layout: Layout, limits: Iterable[Limit], has_figure: Callable[[str], bool], grid: Mapping[str, Any]
) -> LeadingFigure:
    """Return the leading figure of a page.

    It is the figure in the first limit on a figure of a joint that any case has (`has_figure`), or else a default; the
    error of the output where no joint has clearance.

    grid : as stored in run.json.
    """
    if not layout.joints:
        return LeadingFigure("error_max", f"{layout.output} error")
    limits = tuple(limits)
    question = ranking_of(layout, limits, grid).question
    if question not in ("seek", "limits"):
        return LEADING_FIGURES.get(question, PEAK)
    layout_columns = {column.name: column for column in layout.columns}
    for limit in limits:
        column = layout_columns.get(limit.column)
        if column and column.joint and column.figure and has_figure(column.name):
            name = column_label(layout._replace(joints=layout.joints[:1]), column.name)  # without the joint
            return LeadingFigure(column.figure, name, limit.kind == "at_least")
    return PEAK
