"""Heat maps: the leading figure of each joint over pairs of axes, and more figures over the most important pair.

A cell shows the worst of its cases, because designs must withstand it.  On request, and for figures of which neither
large nor small values are worse, it shows the median.
"""

import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...answers import films
from ...answers.case_ranking import START_UP
from ...answers.verdict import MARGIN
from ...contracts.roles import CONDITION
from ...language import wording
from ..blocks.picture import Picture, Spot, capitalise
from ..blocks.section import Gallery, Section, without_empty
from ..data.answered import answer_of_study, finished_cases
from ..data.axis import Axis
from ..data.comparable import EXCLUDED_STARTS_NOTE, comparable_values, excludes_cut_off_starts
from ..data.dotted_paths import value_at
from ..data.study import (
    P99_OVER_IDEAL,
    REDUCTION_NAMES,
    Joint,
    Study,
    cases_by_cell,
    largest,
    median,
    reduce_over_other_axes,
    smallest,
)
from ..data.worst_case import case_ranking_of
from ..draw import heat_map
from ..statistics.main_effects import main_effects_of
from .drivers import effect_picture, ideal_varies

MAX_SPOTS = 150  # largest number of cells with tooltips; larger maps are pixels
MAX_PAIRS = 6  # heat maps per joint: every pair of up to four axes
WITHOUT_WORSE_DIRECTION = ("contact_fraction", "impacts_per_rev", "restitution")  # figures without a worse direction
LOWER_IS_WORSE_SUFFIXES = ("film_thickness_min", "life_hours", MARGIN)
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


def sections(study: Study) -> list[Section]:
    """Return the heat maps of each joint, or [] if there are no two axes to map over."""
    if study.cases.empty:
        return []
    maps = [figure_map for joint in study.joints for figure_map in _maps(study, joint)]
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
    pictures = [_picture(study, figure_map, _value_range(maps, figure_map.name)) for figure_map in shown]
    return Section(f"maps-{joint.name}", title, without_empty([Gallery(note, pictures)]))


def answer_maps(study: Study) -> list[Picture]:
    """Return the maps of the answer over the leading pair of axes, for runs without limits."""
    if study.cases.empty or study.limits:
        return []
    if case_ranking_of(study).question == "start-up":
        return start_up_maps(study)
    maps = [figure_map for joint in study.joints for figure_map in _maps(study, joint)]
    pictures = [
        (_picture(study, maps[index], _value_range(maps, maps[index].name)), maps[index].joint)
        for index in _answer_map_indices(study, maps)
    ]
    return [
        picture._replace(title=picture.title + study.joint_text(joint, ", joint {}")) for picture, joint in pictures
    ]


def _answer_map_indices(study: Study, maps: list[FigureMap]) -> list[int]:
    """Return the indices of the maps in the answer: that of the leading figure, and of a film that of its loss."""
    if not maps or case_ranking_of(study).question != "film":
        return [0][: len(maps)]
    loss = maps[0].joint.column(films.LOSS)
    return [
        0,
        *(
            index
            for index, figure_map in enumerate(maps)
            if figure_map.column == loss and figure_map.pair == maps[0].pair
        ),
    ]


def start_up_maps(study: Study) -> list[Picture]:
    """Return the start-up time over the two axes with the largest effect, or over the only axis; [] without an axis."""
    if not study.has(START_UP):
        return []
    effects = main_effects_of(study, START_UP)
    if len(effects) < 2:
        return [effect_picture(study, effect, "start-up time") for effect in effects]
    pair = _in_grid_order(study, (effects[0].axis, effects[1].axis))
    times = study.cases[START_UP].to_numpy(float)
    table = reduce_over_other_axes(study, times, pair, largest)
    is_missing = reduce_over_other_axes(study, np.isnan(times).astype(float), pair, largest)
    figure_map = FigureMap(study.joints[0], START_UP, "start-up time", pair, np.where(is_missing == 1.0, np.inf, table))
    return [_picture(study, figure_map, (float(np.nanmin(times)), float(np.nanmax(times))))]


def _maps(study: Study, joint: Joint) -> list[FigureMap]:
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
    further_figures = [
        (joint.column("force_peak"), "force peak"),
        (joint.column("force_peak_ratio"), "load over ideal peak"),
    ]
    further_figures += [(joint.column(P99_OVER_IDEAL), "p99 / ideal peak")] if ideal_varies(study, joint) else []
    further_figures.append((joint.column("impacts_per_rev"), study.onset_name))
    further_figures += [(joint.column(figure), name) for figure, name in FIGURES]
    if joint == study.most_loaded_joint():
        further_figures.append((study.column("error_max"), f"{study.run.layout.output} error"))
    mapped = [(lead, study.lead.name, pair) for pair in pairs]
    mapped += [(column, name, pairs[0]) for column, name in further_figures if study.has(column) and column != lead]
    maps = [FigureMap(joint, *figure_map, _table(study, figure_map[0], figure_map[2])) for figure_map in mapped]
    return [
        figure_map
        for figure_map in maps
        if figure_map.column == lead or np.nanmin(figure_map.table) < np.nanmax(figure_map.table)
    ]


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
    return min(float(np.nanmin(table)) for table in tables), max(float(np.nanmax(table)) for table in tables)


def _table(study: Study, column: str, pair: tuple[Axis, Axis]) -> np.ndarray:
    return reduce_over_other_axes(study, comparable_values(study, column), pair, _reduction(study, column))


def _reduction(study: Study, column: str) -> Callable[[np.ndarray], float]:
    """Return the reduction of the values of a cell's cases."""
    if study.shows_median or column.endswith(WITHOUT_WORSE_DIRECTION):
        return median
    lead_is_smallest = study.lead.smallest and column.endswith(f"_{study.lead.figure}")
    return smallest if lead_is_smallest or column.endswith(LOWER_IS_WORSE_SUFFIXES) else largest


def pictures_over_axes(study: Study, joint: Joint, figure: str, name: str) -> list[Picture]:
    """Return a figure of a joint over the two axes with the largest effect or the only axis; [] if it does not vary."""
    column = joint.column(figure)
    varies = study.has(column) and study.cases[column].nunique() > 1
    effects = main_effects_of(study, column) if varies else []
    if len(effects) > 1:
        pair = _in_grid_order(study, (effects[0].axis, effects[1].axis))
        table = _table(study, column, pair)
        return [
            _picture(
                study, FigureMap(joint, column, name, pair, table), (float(np.nanmin(table)), float(np.nanmax(table)))
            )
        ]
    return [effect_picture(study, effect, name + study.joint_text(joint, ", joint {}")) for effect in effects]


def _in_grid_order(study: Study, pair: tuple[Axis, Axis]) -> tuple[Axis, Axis]:
    """Return a pair of axes in the order of the grid."""
    x_axis, y_axis = sorted(pair, key=study.axes.index)
    return x_axis, y_axis


def _picture(study: Study, figure_map: FigureMap, value_range: tuple[float, float]) -> Picture:
    (x_axis, y_axis), table = figure_map.pair, figure_map.table
    scale = study.scale(figure_map.column)
    others = [axis.name for axis in study.swept() if axis not in figure_map.pair]
    reduction_name = REDUCTION_NAMES[_reduction(study, figure_map.column)]
    caption = f"{reduction_name} over {wording.sentence_list(others)}." if others else "Each cell is one case."
    finite = table[np.isfinite(table)]
    lowest, highest = (scale.text(value) for value in (finite.min(), finite.max())) if finite.size else ("", "")
    if np.isinf(table).any():
        revolutions = value_at(study.base, "simulate.revolutions")
        end_text = f" after {revolutions:g} revolutions" if isinstance(revolutions, int | float) else ""
        caption += f" In a cell marked as cut off, at least one case ends{end_text}, before the motor's speed."
    unsafe = _unsafe_cells(study, figure_map)
    if unsafe.any():
        criteria = films.criterion_text(finished_cases(study), figure_map.joint.name)
        caption += f" Unsafe: a case of the cell is not {criteria}."
    caption += EXCLUDED_STARTS_NOTE if excludes_cut_off_starts(study, figure_map.column) else ""
    return Picture(
        f"{capitalise(figure_map.name)}: {x_axis.name} {wording.TIMES} {y_axis.name}",
        caption,
        f"Heat map of {figure_map.name} over {x_axis.name} and {y_axis.name}, from {lowest} to {highest}. {caption}",
        lambda ax: heat_map.draw_heat_map(
            ax, heat_map.Cells(table, unsafe), figure_map.pair, scale, figure_map.name, value_range
        ),
        heat_map.SIZE,
        spots=_spots(study, figure_map, scale),
    )


def _unsafe_cells(study: Study, figure_map: FigureMap) -> np.ndarray:
    """Return which cells of a map of a film or of its loss have a case with an unsafe film."""
    is_of_film = figure_map.column.endswith((films.THICKNESS, films.LOSS))
    if not (is_of_film and study.has(figure_map.joint.column(films.LIMIT_FRACTION))):
        return np.zeros(figure_map.table.shape, bool)
    is_unsafe = films.is_unsafe(finished_cases(study)).astype(float)
    unsafe: np.ndarray = reduce_over_other_axes(study, is_unsafe, figure_map.pair, largest) == 1.0
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
            case_id = (
                study.cases.index[cases[values[cases] == value][0]] if reduction is not median or not count_text else ""
            )
            lower_corner, upper_corner = (column - 0.5, row - 0.5), (column + 0.5, row + 0.5)
            spots.append(Spot(lower_corner, upper_corner, f"{scale.text(value)}: {cell_text}{count_text}", case_id))
    return tuple(spots)
