"""Heat maps: the leading figure of each joint over pairs of axes, and more figures over the pair that matters most.

Of cases that share a cell the worst counts, as designs are made for it; on request, or where there is no worse, the
median.
"""

import itertools

import numpy as np

from ... import wording
from ..draw import comparison
from ..main_effects import main_effects
from ..picture import Picture, Spot, capital
from ..section import Gallery, Section, filled
from ..study import P99, RATIO, Axis, Joint, Study, cells, largest, over_other_axes
from .drivers import ideal_varies

SPOTS = 150  # cells of a map that say what they hold, at most: larger maps are pixels
PAIRS = 6  # heat maps per joint: every pair of up to four axes
NO_WORSE = ("contact_fraction", "impacts_per_rev", "restitution")  # figures of which neither more nor less is worse
FIGURES = (  # of a joint
    ("contact_fraction", "time in contact"),
    ("wear_depth_max", "wear depth"),
    ("restitution", "measured restitution"),
)


def sections(study: Study) -> list[Section]:
    """Return the heat maps of each joint; [] where there are no two axes to map over."""
    if study.cases.empty:
        return []
    return [_section(study, joint) for joint in study.joints]


def _section(study: Study, joint: Joint) -> Section:
    note = "Every pair of swept values; the last maps show further figures over the pair that matters most. "
    if study.lead is P99:
        note += "p99: the force exceeded during 1 % of the time, free flight included."
    worst = "Of the cases of a cell the worst is shown, of times in contact, impacts and restitution the median."
    note += " The median of the cases of a cell is shown." if study.typical else f" {worst}"
    if "refine" in study.run.grid:
        note += " Cases that refine put between the values of the axes are left out."
    title = f"Heat maps{study.where(joint, ', joint {}')}"
    return Section(f"maps-{joint.name}", title, filled([Gallery(note, _pictures(study, joint))]))


def _pictures(study: Study, joint: Joint) -> list[Picture]:
    lead = joint.column(study.lead.figure)
    ranked = [effect.axis for effect in main_effects(study, lead)]
    pairs = [_in_order(study, pair) for pair in itertools.combinations(ranked, 2)][:PAIRS]
    if not pairs or not study.has(lead):
        return []
    more = [(joint.column(RATIO), "p99 / ideal peak")] if ideal_varies(study, joint) else []
    more.append((joint.column("impacts_per_rev"), study.onsets))
    more += [(joint.column(figure), name) for figure, name in FIGURES]
    if joint == study.hardest_joint():
        more.append((study.column("error_max"), f"{study.run.layout.output} error"))
    leading = [_picture(study, lead, study.lead.name, pair) for pair in pairs]
    return leading + [_picture(study, column, name, pairs[0]) for column, name in more if study.has(column)]


def _in_order(study: Study, pair: tuple[Axis, Axis]) -> tuple[Axis, Axis]:
    """Return a pair of axes in the order of the grid."""
    across, up = sorted(pair, key=study.axes.index)
    return across, up


def _picture(study: Study, column: str, name: str, pair: tuple[Axis, Axis]) -> Picture:
    across, up = pair
    values = study.cases[column].to_numpy(float)
    reduced = np.median if study.typical or column.endswith(NO_WORSE) else largest
    table = over_other_axes(study, values, pair, reduced)
    scale = wording.scale(study.unit(column), table[np.isfinite(table)])
    others = [axis.name for axis in study.swept() if axis not in pair]
    word = "Largest" if reduced is largest else "Median"
    caption = f"{word} over {wording.sentence_list(others)}." if others else "One case per cell."
    lowest, highest = (scale.text(value) for value in (np.nanmin(table), np.nanmax(table)))
    return Picture(
        f"{capital(name)}: {across.name} {wording.TIMES} {up.name}",
        caption,
        f"Heat map of {name} over {across.name} and {up.name}, from {lowest} to {highest}. {caption}",
        lambda ax: comparison.heat(ax, table, across, up, scale, name),
        spots=_spots(study, values, pair, scale, worst=reduced is largest),
    )


def _spots(
    study: Study, values: np.ndarray, pair: tuple[Axis, Axis], scale: wording.Scale, *, worst: bool
) -> tuple[Spot, ...]:
    """Return what is said of every cell, its value with its place; it leads to its worst case, or to its only one."""
    across, up = pair
    if len(across.values) * len(up.values) > SPOTS:
        return ()
    spots = []
    for place, cases in enumerate(cells(study, values, pair)):
        if len(cases):
            row, column = divmod(place, len(across.values))
            where = f"{across.name} {across.text(across.values[column])}, {up.name} {up.text(up.values[row])}"
            many = f", {'largest' if worst else 'median'} of {len(cases)} cases" if len(cases) > 1 else ""
            one = study.cases.index[cases[np.argmax(values[cases])]] if worst or len(cases) == 1 else ""
            low, high = (column - 0.5, row - 0.5), (column + 0.5, row + 0.5)
            value = float((np.max if worst else np.median)(values[cases]))
            spots.append(Spot(low, high, f"{scale.text(value)}: {where}{many}", one))
    return tuple(spots)
