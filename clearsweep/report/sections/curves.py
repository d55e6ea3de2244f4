"""The deciding figures over the crank speed, or over the first numeric axis: one curve for each clearance."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...answers.verdict import Limit
from ...language import wording
from ..blocks.picture import Picture, capitalise
from ..blocks.section import Gallery, Section, without_empty
from ..data.axis import Axis
from ..data.comparable import EXCLUDED_STARTS_NOTE, comparable_values, excludes_cut_off_starts
from ..data.study import REDUCTION_NAMES, Study, indices_by_value, largest, median, reduce_over_other_axes, smallest
from ..data.table_columns import column_label
from ..draw import comparison
from ..draw.comparison import CurveFamily
from ..statistics.main_effects import MainEffect, main_effects_of
from . import maps

MAX_CURVES = 7  # curves side by side that can be distinguished
MAX_PICTURES = 6
MIN_VALUES = 3  # values that make a curve


class PlottedFigure(NamedTuple):
    """One figure over an axis: a column, its name, and its limit, if any."""

    column: str
    name: str
    limit: Limit | None = None


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no axis has numbers that cases share."""
    x_axis = None if study.cases.empty else _x_axis(study)
    if x_axis is None:
        return []
    curve_axis = _curve_axis(study, x_axis)
    pictures = [_picture(study, plotted, x_axis, curve_axis) for plotted in _plotted_figures(study)[:MAX_PICTURES]]
    note = f"Each point is the {'median' if study.shows_median else 'worst'} of its cases."
    if any(plotted.limit for plotted in _plotted_figures(study)):
        note += " The horizontal line is the limit."
    if any(excludes_cut_off_starts(study, plotted.column) for plotted in _plotted_figures(study)):
        note += EXCLUDED_STARTS_NOTE
    return [Section("curves", f"Over {x_axis.name}", without_empty([Gallery(note, pictures)]))]


def _x_axis(study: Study) -> Axis | None:
    """Return the crank speed, or the first axis with enough numbers."""
    numeric = [axis for axis in study.levels() if axis.is_numeric and len(axis.values) >= MIN_VALUES]
    return next((axis for axis in numeric if axis.path == "drive.speed"), next(iter(numeric), None))


def _curve_axis(study: Study, x_axis: Axis) -> Axis | None:
    """Return the axis with one curve for each value: a clearance, or the axis with the largest effect on the force."""
    other_axes = [effect.axis for effect in _effects(study)]
    other_axes = [axis for axis in other_axes if axis is not x_axis]
    return next((axis for axis in other_axes if axis.path.endswith(".clearance")), next(iter(other_axes), None))


def _effects(study: Study) -> list[MainEffect]:
    """Return the main effects on the leading figure, the strongest first, or [] if no case has it."""
    column = study.most_loaded_joint().column(study.lead.figure)
    return main_effects_of(study, column) if study.has(column) else []


def _plotted_figures(study: Study) -> list[PlottedFigure]:
    """Return the limited figures, then the peak of every joint, its ratio to the ideal peak, and the output error."""
    by_column = {
        limit.column: PlottedFigure(limit.column, column_label(study, limit.column), limit) for limit in study.limits
    }
    figures = [(joint, figure) for figure in ("force_peak", "force_peak_ratio") for joint in study.joints]
    columns = [joint.column(study.lead.figure) for joint in study.joints]
    columns += [joint.column(figure) for joint, figure in figures] + [study.column("error_max")]
    for column in columns:
        by_column.setdefault(column, PlottedFigure(column, column_label(study, column)))
    return [plotted for plotted in by_column.values() if study.has(plotted.column)]


def _picture(study: Study, plotted: PlottedFigure, x_axis: Axis, curve_axis: Axis | None) -> Picture:
    """Return the picture of one figure over the x axis, with a curve for each shown value of the curve axis."""
    lower_is_worse = plotted.column.endswith(maps.LOWER_IS_WORSE_SUFFIXES) or (
        plotted.limit is not None and plotted.limit.kind == "at_least"
    )
    values = comparable_values(study, plotted.column)
    reduction = median if study.shows_median else smallest if lower_is_worse else largest
    reduced_values = _reduced_values(study, values, (x_axis, curve_axis), reduction)
    row_indices = np.unique(
        np.linspace(0, len(reduced_values) - 1, min(len(reduced_values), MAX_CURVES)).round().astype(int)
    )
    names = [curve_axis.short_text(curve_axis.values[index]) if curve_axis else "" for index in row_indices]
    limit_values = None if plotted.limit is None else _strictest_limit_values(study, plotted.limit, x_axis)
    family = CurveFamily(
        x_axis, curve_axis.label() if curve_axis else "", names, reduced_values[row_indices], limit_values
    )
    scale = study.scale(plotted.column)
    range_text = " to ".join(
        scale.text(value) for value in (float(np.nanmin(reduced_values)), float(np.nanmax(reduced_values)))
    )
    reduced_axis_names = [axis.name for axis in study.swept() if axis not in (x_axis, curve_axis)]
    reduction_name = REDUCTION_NAMES[reduction]
    selection_note = (
        f"{len(row_indices)} of {len(reduced_values)} values of {curve_axis.name}. "
        if curve_axis and len(row_indices) < len(reduced_values)
        else ""
    )
    caption = selection_note + (
        f"{reduction_name} over {wording.sentence_list(reduced_axis_names)}." if reduced_axis_names else ""
    )
    return Picture(
        f"{capitalise(plotted.name)} over {x_axis.name}",
        caption,
        f"{capitalise(plotted.name)} over "
        f"{x_axis.name}{f', a curve for each {curve_axis.name}' if curve_axis else ''}: "
        f"{range_text}.",
        lambda ax: comparison.draw_family(ax, family, scale, plotted.name),
    )


def _reduced_values(
    study: Study, values: np.ndarray, axes: tuple[Axis, Axis | None], reduction: Callable[[np.ndarray], float]
) -> np.ndarray:
    """Return one value for each pair of values of the second and the first axis; one row if there is no second axis."""
    x_axis, curve_axis = axes
    if curve_axis is not None:
        return reduce_over_other_axes(study, values, (x_axis, curve_axis), reduction)
    row = np.full((1, len(x_axis.values)), np.nan)
    value_indices = np.where(np.isfinite(values), study.indices_on(x_axis), -1)
    for index, cases in enumerate(indices_by_value(value_indices, len(x_axis.values))):
        if len(cases):
            row[0, index] = reduction(values[cases])
    return row


def _strictest_limit_values(study: Study, limit: Limit, x_axis: Axis) -> np.ndarray:
    """Return the strictest value (SI) of a limit at each value of an axis."""
    columns = {name: study.cases[name].to_numpy(float) for name in (limit.column, limit.times) if name}
    strictest = smallest if limit.kind == "at_most" else largest
    limit_values: np.ndarray = _reduced_values(study, limit.limit_values(columns), (x_axis, None), strictest)[0]
    return limit_values
