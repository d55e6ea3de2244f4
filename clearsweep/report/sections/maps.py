"""Heat maps: the leading figure of each joint over pairs of axes, and more figures over the most important pair.

A cell shows the worst of its cases, because designs must withstand it.  On request, and for figures of which neither
large nor small values are worse, it shows the median.
"""

import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...judging import designs, films
from ...judging.order import START_UP
from ...judging.verdict import MARGIN
from ...language import wording
from ..blocks.picture import Picture, Spot, capital
from ..blocks.section import Gallery, Section, without_empty
from ..data.axis import Axis
from ..data.comparable import LEFT_OUT, comparable, leaves_out
from ..data.dotted_paths import value_at
from ..data.study import CALLED, P99_OVER_IDEAL, Joint, Study, cells, largest, median, over_other_axes, smallest
from ..data.worst_case import question
from ..draw import heat_map
from ..statistics.main_effects import main_effects_of
from .drivers import ideal_varies, line

SPOTS = 150  # largest number of cells with tooltips; larger maps are pixels
PAIRS = 6  # heat maps per joint: every pair of up to four axes
NO_WORSE = ("contact_fraction", "impacts_per_rev", "restitution")  # figures without a worse direction
LESS_IS_WORSE = ("film_thickness_min", "life_hours", MARGIN)
FIGURES = (  # of a joint
    ("contact_fraction", "time in contact"),
    ("film_thickness_min", "least film"),
    ("film_loss", "loss in the film"),
    ("restitution", "measured restitution"),
)


class Map(NamedTuple):
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
    maps = [each for joint in study.joints for each in _maps(study, joint)]
    return [_section(study, joint, maps) for joint in study.joints]


def _section(study: Study, joint: Joint, maps: list[Map]) -> Section:
    note = "The maps show every pair of swept values; the last ones show more figures of the pair with most effect. "
    worst = "Each cell shows its worst case; for contact time, impacts and restitution it shows the median."
    note += "Each cell shows the median of its cases." if study.typical else worst
    if "refine" in study.run.grid:
        note += " The maps leave out the cases that refine added between the values of the axes."
    note += " Maps of one figure share their colours."
    title = f"Heat maps{study.joint_text(joint, ', joint {}')}"
    places = _first(study, maps) if first(study) else []
    shown = [each for place, each in enumerate(maps) if place not in places and each.joint == joint]
    pictures = [_picture(study, each, _span(maps, each.name)) for each in shown]
    return Section(f"maps-{joint.name}", title, without_empty([Gallery(note, pictures)]))


def first(study: Study) -> list[Picture]:
    """Return the maps of the answer over the leading pair of axes, for runs without limits."""
    if study.cases.empty or study.limits:
        return []
    if question(study).question == "start-up":
        return start_up(study)
    maps = [each for joint in study.joints for each in _maps(study, joint)]
    pictures = [
        (_picture(study, maps[place], _span(maps, maps[place].name)), maps[place].joint)
        for place in _first(study, maps)
    ]
    return [
        picture._replace(title=picture.title + study.joint_text(joint, ", joint {}")) for picture, joint in pictures
    ]


def _first(study: Study, maps: list[Map]) -> list[int]:
    """Return the indices of the maps in the answer: that of the leading figure, and of a film that of its loss."""
    if not maps or question(study).question != "film":
        return [0][: len(maps)]
    loss = maps[0].joint.column(films.LOSS)
    return [0, *(place for place, each in enumerate(maps) if each.column == loss and each.pair == maps[0].pair)]


def start_up(study: Study) -> list[Picture]:
    """Return the start-up time over the two axes with the largest effect, or over the only axis; [] without an axis."""
    if not study.has(START_UP):
        return []
    effects = main_effects_of(study, START_UP)
    if len(effects) < 2:
        return [line(study, effect, "start-up time") for effect in effects]
    pair = _in_order(study, (effects[0].axis, effects[1].axis))
    times = study.cases[START_UP].to_numpy(float)
    table = over_other_axes(study, times, pair, largest)
    missing = over_other_axes(study, np.isnan(times).astype(float), pair, largest)
    shown = Map(study.joints[0], START_UP, "start-up time", pair, np.where(missing == 1.0, np.inf, table))
    return [_picture(study, shown, (float(np.nanmin(times)), float(np.nanmax(times))))]


def _maps(study: Study, joint: Joint) -> list[Map]:
    """Return the leading figure of a joint over every pair of axes, and further ones that vary over the first."""
    lead = joint.column(study.lead.figure)
    if not study.has(lead):
        return []
    ranked = [effect.axis for effect in main_effects_of(study, lead)]
    pairs = [_in_order(study, pair) for pair in itertools.combinations(_leading(study, joint, ranked), 2)][:PAIRS]
    if not pairs:
        return []
    more = [(joint.column("force_peak"), "force peak"), (joint.column("force_peak_ratio"), "load over ideal peak")]
    more += [(joint.column(P99_OVER_IDEAL), "p99 / ideal peak")] if ideal_varies(study, joint) else []
    more.append((joint.column("impacts_per_rev"), study.onset_name))
    more += [(joint.column(figure), name) for figure, name in FIGURES]
    if joint == study.hardest_joint():
        more.append((study.column("error_max"), f"{study.run.layout.output} error"))
    drawn = [(lead, study.lead.name, pair) for pair in pairs]
    drawn += [(column, name, pairs[0]) for column, name in more if study.has(column) and column != lead]
    maps = [Map(joint, *each, _table(study, each[0], each[2])) for each in drawn]
    return [each for each in maps if each.column == lead or np.nanmin(each.table) < np.nanmax(each.table)]


def _leading(study: Study, joint: Joint, ranked: list[Axis]) -> list[Axis]:
    """Return axes, those with the largest effect first; of a film the clearance first, operating conditions last."""
    if question(study).question != "film":
        return ranked
    clearance = f"joints.{wording.joint_name(joint.name)}.clearance"
    conditions = designs.divided([axis.path for axis in ranked])[1]
    return sorted(ranked, key=lambda axis: (axis.path != clearance, axis.path in conditions))


def _span(maps: list[Map], name: str) -> tuple[float, float]:
    """Return the ends (SI) of a figure in all of its maps."""
    tables = [each.table for each in maps if each.name == name]
    return min(float(np.nanmin(table)) for table in tables), max(float(np.nanmax(table)) for table in tables)


def _table(study: Study, column: str, pair: tuple[Axis, Axis]) -> np.ndarray:
    return over_other_axes(study, comparable(study, column), pair, _reduced(study, column))


def _reduced(study: Study, column: str) -> Callable[[np.ndarray], float]:
    """Return the reduction of the values of a cell's cases."""
    if study.typical or column.endswith(NO_WORSE):
        return median
    led = study.lead.smallest and column.endswith(f"_{study.lead.figure}")
    return smallest if led or column.endswith(LESS_IS_WORSE) else largest


def over_axes(study: Study, joint: Joint, figure: str, name: str) -> list[Picture]:
    """Return a figure of a joint over the two axes with the largest effect or the only axis; [] if it does not vary."""
    column = joint.column(figure)
    varies = study.has(column) and study.cases[column].nunique() > 1
    effects = main_effects_of(study, column) if varies else []
    if len(effects) > 1:
        pair = _in_order(study, (effects[0].axis, effects[1].axis))
        table = _table(study, column, pair)
        return [
            _picture(study, Map(joint, column, name, pair, table), (float(np.nanmin(table)), float(np.nanmax(table))))
        ]
    return [line(study, effect, name + study.joint_text(joint, ", joint {}")) for effect in effects]


def _in_order(study: Study, pair: tuple[Axis, Axis]) -> tuple[Axis, Axis]:
    """Return a pair of axes in the order of the grid."""
    across, up = sorted(pair, key=study.axes.index)
    return across, up


def _picture(study: Study, shown: Map, span: tuple[float, float]) -> Picture:
    (across, up), table = shown.pair, shown.table
    scale = study.scale(shown.column)
    others = [axis.name for axis in study.swept() if axis not in shown.pair]
    word = CALLED[_reduced(study, shown.column)]
    caption = f"{word} over {wording.sentence_list(others)}." if others else "Each cell is one case."
    known = table[np.isfinite(table)]
    lowest, highest = (scale.text(value) for value in (known.min(), known.max())) if known.size else ("", "")
    if np.isinf(table).any():
        turns = value_at(study.base, "simulate.revolutions")
        after = f" after {turns:g} revolutions" if isinstance(turns, int | float) else ""
        caption += f" In a cell marked as cut off, at least one case ends{after}, before the motor's speed."
    caption += LEFT_OUT if leaves_out(study, shown.column) else ""
    return Picture(
        f"{capital(shown.name)}: {across.name} {wording.TIMES} {up.name}",
        caption,
        f"Heat map of {shown.name} over {across.name} and {up.name}, from {lowest} to {highest}. {caption}",
        lambda ax: heat_map.draw_heat_map(ax, table, shown.pair, scale, shown.name, span),
        heat_map.SIZE,
        spots=_spots(study, shown, scale),
    )


def _spots(study: Study, shown: Map, scale: wording.Scale) -> tuple[Spot, ...]:
    """Return the tooltip of every cell, with its value and position, and the link to its worst or only case."""
    across, up = shown.pair
    if len(across.values) * len(up.values) > SPOTS:
        return ()
    reduced, values = _reduced(study, shown.column), comparable(study, shown.column)
    spots = []
    for place, cases in enumerate(cells(study, values, shown.pair)):
        if len(cases):
            row, column = divmod(place, len(across.values))
            where = f"{across.name} {across.text(across.values[column])}, {up.name} {up.text(up.values[row])}"
            many = f", {CALLED[reduced].lower()} of {len(cases)} cases" if len(cases) > 1 else ""
            value = reduced(values[cases])
            case_id = study.cases.index[cases[values[cases] == value][0]] if reduced is not median or not many else ""
            low, high = (column - 0.5, row - 0.5), (column + 0.5, row + 0.5)
            spots.append(Spot(low, high, f"{scale.text(value)}: {where}{many}", case_id))
    return tuple(spots)
