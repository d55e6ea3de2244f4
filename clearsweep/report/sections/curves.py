"""The deciding figures over the crank speed, or over the first numeric axis: one curve for each clearance."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...judging.verdict import Limit
from ...language import wording
from ..blocks.picture import Picture, capital
from ..blocks.section import Gallery, Section, without_empty
from ..data.axis import Axis
from ..data.comparable import LEFT_OUT, comparable, leaves_out
from ..data.study import CALLED, Study, indices_by_value, largest, median, over_other_axes, smallest
from ..data.table_columns import column_label
from ..draw import comparison
from ..draw.comparison import Family
from ..statistics.main_effects import MainEffect, main_effects_of
from . import maps

MOST = 7  # curves side by side that can be distinguished
PICTURES = 6
LEAST = 3  # values that make a curve


class Drawn(NamedTuple):
    """One figure over an axis: a column, its name, and its bound, if any."""

    column: str
    name: str
    limit: Limit | None = None


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no axis has numbers that cases share."""
    across = None if study.cases.empty else _across(study)
    if across is None:
        return []
    second = _beside(study, across)
    pictures = [_picture(study, drawn, across, second) for drawn in _drawn(study)[:PICTURES]]
    note = f"Each point is the {'median' if study.typical else 'worst'} of its cases."
    if any(drawn.limit for drawn in _drawn(study)):
        note += " The horizontal line is the limit."
    if any(leaves_out(study, drawn.column) for drawn in _drawn(study)):
        note += LEFT_OUT
    return [Section("curves", f"Over {across.name}", without_empty([Gallery(note, pictures)]))]


def _across(study: Study) -> Axis | None:
    """Return the crank speed, or the first axis with enough numbers."""
    numeric = [axis for axis in study.levels() if axis.numeric and len(axis.values) >= LEAST]
    return next((axis for axis in numeric if axis.path == "drive.speed"), next(iter(numeric), None))


def _beside(study: Study, across: Axis) -> Axis | None:
    """Return the axis with one curve for each value: a clearance, or the axis with the largest effect on the force."""
    others = [effect.axis for effect in _effects(study)]
    others = [axis for axis in others if axis is not across]
    return next((axis for axis in others if axis.path.endswith(".clearance")), next(iter(others), None))


def _effects(study: Study) -> list[MainEffect]:
    """Return the main effects on the leading figure, the strongest first, or [] if no case has it."""
    column = study.hardest_joint().column(study.lead.figure)
    return main_effects_of(study, column) if study.has(column) else []


def _drawn(study: Study) -> list[Drawn]:
    """Return the limited figures, then the peak of every joint, its ratio to the ideal peak, and the output error."""
    by_column = {limit.column: Drawn(limit.column, column_label(study, limit.column), limit) for limit in study.limits}
    figures = [(joint, figure) for figure in ("force_peak", "force_peak_ratio") for joint in study.joints]
    columns = [joint.column(study.lead.figure) for joint in study.joints]
    columns += [joint.column(figure) for joint, figure in figures] + [study.column("error_max")]
    for column in columns:
        by_column.setdefault(column, Drawn(column, column_label(study, column)))
    return [drawn for drawn in by_column.values() if study.has(drawn.column)]


def _picture(study: Study, drawn: Drawn, across: Axis, second: Axis | None) -> Picture:
    least = drawn.column.endswith(maps.LESS_IS_WORSE) or (drawn.limit is not None and drawn.limit.kind == "at_least")
    values = comparable(study, drawn.column)
    reduced = median if study.typical else smallest if least else largest
    table = _table(study, values, (across, second), reduced)
    kept = np.unique(np.linspace(0, len(table) - 1, min(len(table), MOST)).round().astype(int))
    names = [second.short(second.values[place]) if second else "" for place in kept]
    limit_values = None if drawn.limit is None else _bound(study, drawn.limit, across)
    family = Family(across, second.label() if second else "", names, table[kept], limit_values)
    scale = study.scale(drawn.column)
    ends = " to ".join(scale.text(end) for end in (float(np.nanmin(table)), float(np.nanmax(table))))
    others = [axis.name for axis in study.swept() if axis not in (across, second)]
    word = CALLED[reduced]
    selection_note = (
        f"{len(kept)} of {len(table)} values of {second.name}. " if second and len(kept) < len(table) else ""
    )
    caption = selection_note + (f"{word} over {wording.sentence_list(others)}." if others else "")
    return Picture(
        f"{capital(drawn.name)} over {across.name}",
        caption,
        f"{capital(drawn.name)} over {across.name}{f', a curve for each {second.name}' if second else ''}: {ends}.",
        lambda ax: comparison.draw_family(ax, family, scale, drawn.name),
    )


def _table(
    study: Study, values: np.ndarray, axes: tuple[Axis, Axis | None], reduced: Callable[[np.ndarray], float]
) -> np.ndarray:
    """Return one value for each pair of values of the second and the first axis; one row if there is no second axis."""
    across, second = axes
    if second is not None:
        return over_other_axes(study, values, (across, second), reduced)
    row = np.full((1, len(across.values)), np.nan)
    places = np.where(np.isfinite(values), study.indices_on(across), -1)
    for place, cases in enumerate(indices_by_value(places, len(across.values))):
        if len(cases):
            row[0, place] = reduced(values[cases])
    return row


def _bound(study: Study, limit: Limit, across: Axis) -> np.ndarray:
    """Return the strictest bound (SI) at each value of an axis."""
    known = {name: study.cases[name].to_numpy(float) for name in (limit.column, limit.times) if name}
    strictest = smallest if limit.kind == "at_most" else largest
    bounds: np.ndarray = _table(study, limit.threshold(known), (across, None), strictest)[0]
    return bounds
