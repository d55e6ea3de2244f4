"""Heat maps: the leading figure of each joint over pairs of axes, and more figures over the most important pair.

A cell shows the worst of its cases, because designs must withstand it.  On request, and for figures of which neither
large nor small values are worse, it shows the median.
"""

import itertools
import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...answers import questions
from ...answers.questions import FILM_LIMIT_FRACTION, FILM_LOSS, FILM_THICKNESS, film_criterion_text
from ...answers.ranking import START_UP
from ...answers.verdict import MARGIN_COLUMN, Limit
from ...contracts.case import value_at
from ...contracts.catalogue import CONDITION
from ...language import wording
from ..axis import Axis
from ..blocks.section import Gallery, Picture, Section, Spot, capitalise, section, without_empty
from ..blocks.table import column_label
from ..draw import MAX_LABELLED_TICKS, RED, comparison, draw_colour_bar, label_with_unit, set_log_scale, set_plain_axes
from ..draw.comparison import MAP_SIZE, cell_font_size, draw_cells
from ..effects import main_effects_of
from ..plot import Axes, ColourScale
from ..study import (
    EXCLUDED_STARTS_NOTE,
    P99_OVER_IDEAL,
    REDUCTION_NAMES,
    WEAR_PER_1000_HOURS,
    Joint,
    Study,
    answer_of_study,
    case_ranking_of,
    cases_by_cell,
    comparable_values,
    excludes_cut_off_starts,
    finished_cases,
    reduce_over_other_axes,
)
from .drivers import effect_picture, ideal_varies
from .sample import limit_columns

CUT_OFF, UNSAFE = "cut\noff", "unsafe"
DARK_FRACTION = 0.55  # of the colours: below it, the text of a cell is white
MAX_SPOTS = 150  # largest number of cells with tooltips; larger maps are pixels
MAX_PAIRS = 6  # heat maps per joint: every pair of up to four axes
WITHOUT_WORSE_DIRECTION = ("contact_fraction", "impacts_per_rev", "restitution")  # figures without a worse direction
LOWER_IS_WORSE_SUFFIXES = ("film_thickness_min", "life_hours", MARGIN_COLUMN)
FIGURES = (  # of a joint
    ("contact_fraction", "time in contact"),
    ("film_thickness_min", "least film"),
    ("film_loss", "film loss"),
    ("restitution", "measured restitution"),
)


class FigureMap(NamedTuple):
    """One figure over a pair of axes; `table` has the shape (values of the second axis, values of the first)."""

    joint: Joint
    column: str
    name: str
    pair: tuple[Axis, Axis]
    table: np.ndarray


def map_sections(study: Study) -> list[Section]:
    """Return the heat maps of each joint, or [] if there are no two axes to map over."""
    if study.cases.empty:
        return []
    maps = [figure_map for joint in study.joints for figure_map in _figure_maps(study, joint)]
    return [_section(study, joint, maps) for joint in study.joints]


def _section(study: Study, joint: Joint, maps: list[FigureMap]) -> Section:
    note = "The maps show every pair of swept values; the last ones show more figures of the pair with most effect. "
    worst_note = "Each cell shows its worst case; for contact time, impacts and restitution it shows the median."
    note += "Each cell shows the median of its cases." if study.shows_median else worst_note
    if "refine" in study.run.grid:
        note += " The maps leave out the cases that refine added between the values of the axes."
    note += " Maps of one figure share their colours."
    title = f"Heat maps{study.joint_text(joint, ', joint {}')}"
    answer_indices = _answer_map_indices(study, maps) if answer_maps(study) else []
    shown = [
        figure_map for index, figure_map in enumerate(maps) if index not in answer_indices and figure_map.joint == joint
    ]
    pictures = [_map_picture(study, figure_map, _value_range(maps, figure_map.name)) for figure_map in shown]
    return Section(f"maps-{joint.name}", title, without_empty([Gallery(note, pictures)]))


def answer_maps(study: Study) -> list[Picture]:
    """Return the maps of the answer over the leading pair of axes, for runs without limits."""
    if study.cases.empty or study.limits:
        return []
    if case_ranking_of(study).question == "start-up":
        return start_up_maps(study)
    maps = [figure_map for joint in study.joints for figure_map in _figure_maps(study, joint)]
    pictures = [
        (_map_picture(study, maps[index], _value_range(maps, maps[index].name)), maps[index].joint)
        for index in _answer_map_indices(study, maps)
    ]
    return [
        picture._replace(title=picture.title + study.joint_text(joint, ", joint {}")) for picture, joint in pictures
    ]


def _answer_map_indices(study: Study, maps: list[FigureMap]) -> list[int]:
    """Return the indices of the maps in the answer: that of the leading figure, and of a film that of its loss."""
    if not maps or case_ranking_of(study).question != "film":
        return [0][: len(maps)]
    loss = maps[0].joint.column(FILM_LOSS)
    pair = maps[0].pair
    return [0, *(index for index, each in enumerate(maps) if each.column == loss and each.pair == pair)]


def start_up_maps(study: Study) -> list[Picture]:
    """Return the start-up time over the two axes with the largest effect, or over the only axis; [] without an axis."""
    if not study.has(START_UP):
        return []
    effects = main_effects_of(study, START_UP)
    if len(effects) < 2:
        return [effect_picture(study, effect, "start-up time") for effect in effects]
    pair = _in_grid_order(study, (effects[0].axis, effects[1].axis))
    times = study.cases[START_UP]
    table = reduce_over_other_axes(study, times, pair, np.max)
    is_missing = reduce_over_other_axes(study, np.isnan(times).astype(float), pair, np.max)
    figure_map = FigureMap(study.joints[0], START_UP, "start-up time", pair, np.where(is_missing == 1.0, np.inf, table))
    return [_map_picture(study, figure_map, (float(np.nanmin(times)), float(np.nanmax(times))))]


def _figure_maps(study: Study, joint: Joint) -> list[FigureMap]:
    """Return the leading figure of a joint over every pair of axes, and further ones that vary over the first."""
    lead = joint.column(study.lead.figure)
    if not study.has(lead):
        return []
    ranked_axes = [effect.axis for effect in main_effects_of(study, lead)]
    pairs = [
        _in_grid_order(study, pair) for pair in itertools.combinations(_mapped_axes(study, joint, ranked_axes), 2)
    ][:MAX_PAIRS]
    if not pairs:
        return []
    further = [(joint.column("force_peak"), "force peak"), (joint.column("force_peak_ratio"), "load over ideal peak")]
    further += [(joint.column(P99_OVER_IDEAL), "p99 / ideal peak")] if ideal_varies(study, joint) else []
    further.append((joint.column("impacts_per_rev"), f"impacts per {study.turn}" if study.is_driven else "impacts"))
    further += [(joint.column(figure), name) for figure, name in FIGURES]
    if joint == study.most_loaded_joint():
        further.append((study.column("error_max"), f"{study.run.layout.output} error"))
    mapped = [(lead, study.lead.name, pair) for pair in pairs]
    mapped += [(column, name, pairs[0]) for column, name in further if study.has(column) and column != lead]
    maps = [FigureMap(joint, *figure_map, _table(study, figure_map[0], figure_map[2])) for figure_map in mapped]
    return [each for each in maps if each.column == lead or np.nanmin(each.table) < np.nanmax(each.table)]


def _mapped_axes(study: Study, joint: Joint, ranked: list[Axis]) -> list[Axis]:
    """Return axes, those with the largest effect first; of a film the clearance first, operating conditions last."""
    if case_ranking_of(study).question != "film":
        return ranked
    clearance_path = f"joints.{wording.joint_name(joint.name)}.clearance"
    conditions = [path for path, role in answer_of_study(study)["roles"].items() if role == CONDITION]
    return sorted(ranked, key=lambda axis: (axis.path != clearance_path, axis.path in conditions))


def _value_range(maps: list[FigureMap], name: str) -> tuple[float, float]:
    """Return the ends (SI) of a figure in all of its maps."""
    tables = [figure_map.table for figure_map in maps if figure_map.name == name]
    tables = [np.where(np.isinf(table), np.nan, table) for table in tables]  # lives without wear
    return min(float(np.nanmin(table)) for table in tables), max(float(np.nanmax(table)) for table in tables)


def _table(study: Study, column: str, pair: tuple[Axis, Axis]) -> np.ndarray:
    return reduce_over_other_axes(study, comparable_values(study, column), pair, _reduction(study, column))


def _reduction(study: Study, column: str) -> Callable[[np.ndarray], float]:
    """Return the reduction of the values of a cell's cases."""
    if study.shows_median or column.endswith(WITHOUT_WORSE_DIRECTION):
        return np.median
    lead_is_smallest = study.lead.smallest and column.endswith(f"_{study.lead.figure}")
    return np.min if lead_is_smallest or column.endswith(LOWER_IS_WORSE_SUFFIXES) else np.max


def pictures_over_axes(study: Study, joint: Joint, figure: str, name: str) -> list[Picture]:
    """Return a figure of a joint over the two axes with the largest effect or the only axis; [] if it does not vary."""
    column = joint.column(figure)
    varies = study.cases.varies(column)
    effects = main_effects_of(study, column) if varies else []
    if len(effects) > 1:
        pair = _in_grid_order(study, (effects[0].axis, effects[1].axis))
        figure_map = FigureMap(joint, column, name, pair, _table(study, column, pair))
        return [_map_picture(study, figure_map, _value_range([figure_map], name))]
    return [effect_picture(study, effect, name + study.joint_text(joint, ", joint {}")) for effect in effects]


def _in_grid_order(study: Study, pair: tuple[Axis, Axis]) -> tuple[Axis, Axis]:
    """Return a pair of axes in the order of the grid."""
    x_axis, y_axis = sorted(pair, key=study.axes.index)
    return x_axis, y_axis


def _map_picture(study: Study, figure_map: FigureMap, value_range: tuple[float, float]) -> Picture:
    (x_axis, y_axis), table = figure_map.pair, figure_map.table
    scale = study.scale(figure_map.column)
    others = [axis.name for axis in study.swept() if axis not in figure_map.pair]
    reduction_name = REDUCTION_NAMES[_reduction(study, figure_map.column)]
    caption = f"{reduction_name} over {wording.sentence_list(others)}." if others else "Each cell is one case."
    finite = table[np.isfinite(table)]
    lowest, highest = (scale.text(value) for value in (finite.min(), finite.max())) if finite.size else ("", "")
    if np.isinf(table).any() and figure_map.column == START_UP:
        revolutions = value_at(study.base, "simulate.revolutions")
        end_text = f" after {revolutions:g} revolutions" if isinstance(revolutions, int | float) else ""
        caption += f" In a cell marked as cut off, at least one case ends{end_text}, before the motor's speed."
    unsafe = _unsafe_cells(study, figure_map)
    if unsafe.any():
        criteria = film_criterion_text(finished_cases(study), figure_map.joint.name)
        caption += f" Unsafe: a case of the cell is not {criteria}."
    caption += EXCLUDED_STARTS_NOTE if excludes_cut_off_starts(study, figure_map.column) else ""

    def paint(ax: Axes) -> None:
        numbers, texts = table / scale.factor, np.empty(table.shape, object)
        low, high = (end / scale.factor for end in value_range)
        colours = ColourScale(low, high, is_log=comparison.needs_log_scale(np.array([low, high])))
        for place, value in np.ndenumerate(numbers):
            number = wording.number_text(value, 3) if np.isfinite(value) else wording.DASH
            infinite = CUT_OFF if figure_map.column == START_UP else wording.UNLIMITED
            texts[place] = infinite if np.isinf(value) else f"{number}\n{UNSAFE}" if unsafe[place] else number
        longest = max((len(line) for text in texts.flat for line in text.split("\n")), default=1)
        is_dark = np.isfinite(numbers) & (colours.fractions(numbers) < DARK_FRACTION)
        size = cell_font_size(table.shape[1], longest)
        draw_cells(ax, numbers, figure_map.pair, colours, texts, size, is_dark)
        draw_colour_bar(ax, colours, label_with_unit(figure_map.name, scale))

    return Picture(
        f"{capitalise(figure_map.name)}: {x_axis.name} {wording.TIMES} {y_axis.name}",
        caption,
        f"Heat map of {figure_map.name} over {x_axis.name} and {y_axis.name}, from {lowest} to {highest}. {caption}",
        paint,
        MAP_SIZE,
        spots=_spots(study, figure_map, scale),
    )


def _unsafe_cells(study: Study, figure_map: FigureMap) -> np.ndarray:
    """Return which cells of a map of a film or of its loss have a case with an unsafe film."""
    is_of_film = figure_map.column.endswith((FILM_THICKNESS, FILM_LOSS))
    if not (is_of_film and study.has(figure_map.joint.column(FILM_LIMIT_FRACTION))):
        return np.zeros(figure_map.table.shape, bool)
    is_unsafe = questions.is_unsafe(finished_cases(study)).astype(float)
    unsafe: np.ndarray = reduce_over_other_axes(study, is_unsafe, figure_map.pair, np.max) == 1.0
    return unsafe


def _spots(study: Study, figure_map: FigureMap, scale: wording.Scale) -> tuple[Spot, ...]:
    """Return the tooltip of every cell, with its value and position, and the link to its worst or only case."""
    x_axis, y_axis = figure_map.pair
    if len(x_axis.values) * len(y_axis.values) > MAX_SPOTS:
        return ()
    reduction, values = _reduction(study, figure_map.column), comparable_values(study, figure_map.column)
    spots = []
    for index, cases in enumerate(cases_by_cell(study, values, figure_map.pair)):
        if len(cases):
            row, column = divmod(index, len(x_axis.values))
            cell_text = (
                f"{x_axis.name} {x_axis.text(x_axis.values[column])}, {y_axis.name} {y_axis.text(y_axis.values[row])}"
            )
            count_text = f", {REDUCTION_NAMES[reduction].lower()} of {len(cases)} cases" if len(cases) > 1 else ""
            value = reduction(values[cases])
            is_of_case = reduction is not np.median or not count_text
            case_id = study.cases.index[cases[values[cases] == value][0]] if is_of_case else ""
            lower_corner, upper_corner = (column - 0.5, row - 0.5), (column + 0.5, row + 0.5)
            spots.append(Spot(lower_corner, upper_corner, f"{scale.text(value)}: {cell_text}{count_text}", case_id))
    return tuple(spots)


# The deciding figures over the crank speed, or over the first numeric axis: one curve for each clearance.

MAX_CURVES = 7  # curves side by side that can be distinguished
MAX_PICTURES = 6
MIN_VALUES = 3  # values that make a curve
MAX_SIDE_NAME_LENGTH = 10  # letters of a curve's name above which names are placed at the top


class PlottedFigure(NamedTuple):
    """One figure over an axis: a column, its name, and its limit, if any."""

    column: str
    name: str
    limit: Limit | None = None


def curve_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no axis has numbers that cases share."""
    numeric = [axis for axis in study.levels() if axis.is_numeric and len(axis.values) >= MIN_VALUES]
    x_axis = next((axis for axis in numeric if axis.path == "drive.speed"), next(iter(numeric), None))
    if study.cases.empty or x_axis is None:
        return []
    column = study.most_loaded_joint().column(study.lead.figure)
    effects = main_effects_of(study, column) if study.has(column) else []
    other_axes = [effect.axis for effect in effects if effect.axis is not x_axis]
    curve_axis = next((axis for axis in other_axes if axis.path.endswith(".clearance")), next(iter(other_axes), None))
    pictures = [
        _curve_picture(study, plotted, x_axis, curve_axis) for plotted in _plotted_figures(study)[:MAX_PICTURES]
    ]
    note = f"Each point is the {'median' if study.shows_median else 'worst'} of its cases."
    if any(plotted.limit for plotted in _plotted_figures(study)):
        note += " The horizontal line is the limit."
    if any(excludes_cut_off_starts(study, plotted.column) for plotted in _plotted_figures(study)):
        note += EXCLUDED_STARTS_NOTE
    return section("curves", f"Over {x_axis.name}", Gallery(note, pictures))


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


def _curve_picture(study: Study, plotted: PlottedFigure, x_axis: Axis, curve_axis: Axis | None) -> Picture:
    """Return the picture of one figure over the x axis, with a curve for each shown value of the curve axis."""
    lower_is_worse = plotted.column.endswith(LOWER_IS_WORSE_SUFFIXES) or (
        plotted.limit is not None and plotted.limit.kind == "at_least"
    )
    values = comparable_values(study, plotted.column)
    reduction = np.median if study.shows_median else np.min if lower_is_worse else np.max
    reduced_values = reduce_over_other_axes(study, values, (x_axis, curve_axis), reduction)
    row_indices = np.unique(
        np.linspace(0, len(reduced_values) - 1, min(len(reduced_values), MAX_CURVES)).round().astype(int)
    )
    names = [curve_axis.short_text(curve_axis.values[index]) if curve_axis else "" for index in row_indices]
    curves, scale = reduced_values[row_indices], study.scale(plotted.column)
    limit_values = np.full(len(x_axis.values), np.nan)
    if plotted.limit is not None:  # its strictest value at each value of the axis
        limits = plotted.limit.limit_values(limit_columns(study, plotted.limit))
        strictest = np.min if plotted.limit.kind == "at_most" else np.max
        limit_values = reduce_over_other_axes(study, limits, (x_axis, None), strictest)[0]

    def paint(ax: Axes) -> None:
        known_values = np.concatenate([curves[np.isfinite(curves)], limit_values[np.isfinite(limit_values)]])
        positions = comparison.positions_of(x_axis)
        colours = ColourScale(0.0, 1.0).hex_colours(np.linspace(0.0, 0.85, len(names)))
        for curve, label, colour in zip(curves, names, colours, strict=True):
            is_known = np.isfinite(curve)
            marker = "o" if len(positions) <= MAX_LABELLED_TICKS else ""
            style: dict[str, Any] = {"marker": marker, "markersize": 3.5, "linewidth": 1.4}
            ax.plot(positions[is_known], curve[is_known] / scale.factor, color=colour, label=label, **style)
        if plotted.limit is not None:
            ax.plot(positions, limit_values / scale.factor, color=RED, linewidth=1.4, linestyle="--", label="limit")
        ax.set_labels(x_axis.label(), label_with_unit(plotted.name, scale))
        comparison.label_abscissa(ax, x_axis, positions)
        if comparison.needs_log_scale(known_values):
            set_log_scale(ax, "y")
        elif known_values.min() >= 0.0:
            ax.set_ylim(0.0, 1.08 * known_values.max() / scale.factor or None)
        set_plain_axes(ax)
        if max(map(len, names)) > MAX_SIDE_NAME_LENGTH:
            ax.set_legend("above", columns=2, sample=1.4, left=comparison.NAMES_LEFT)
        elif curve_axis and any(names):
            ax.set_legend("right", title=re.sub(r" (?=[\[(])", "\n", curve_axis.label()), sample=1.4)

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
        f"{x_axis.name}{f', a curve for each {curve_axis.name}' if curve_axis else ''}: {range_text}.",
        paint,
    )


# Wear at a glance: the map of the joint that wears deepest.


def deepest_wear_sections(study: Study) -> list[Section]:
    """Return the section with the map of the joint that wears deepest, or [] if nothing wears or no case finished."""
    wearing = [joint for joint in study.joints if joint.wears and study.has(joint.column(WEAR_PER_1000_HOURS))]
    if not wearing:
        return []
    deepest = max(wearing, key=lambda joint: study.cases.largest(joint.column(WEAR_PER_1000_HOURS)))
    pictures = pictures_over_axes(study, deepest, WEAR_PER_1000_HOURS, "wear depth per 1000 h")
    return section("lasting", "Wear", Gallery("", pictures))
