"""Wear: the deepest places of each joint, and the wear in every finished case."""

from ... import simulation
from ...answers import wear
from ...language import wording
from ..blocks.case_table import case_table
from ..blocks.picture import Picture
from ..blocks.section import Block, Detail, Gallery, Note, Section, Sentences, without_empty
from ..blocks.table import Table
from ..data.answered import finished_cases
from ..data.study import WEAR_PER_1000_HOURS, WEAR_PER_MILLION_STROKES, Joint, Study
from ..data.table_columns import columns_in_table
from ..one_case import worn
from . import maps

NOTE = (
    "The pictures show the wear depth around each body, in the frame of the body. Angles count counter-clockwise from "
    "its x axis, which points along a crank or rod. Bearing and journal of a case share a scale. The dotted circle is "
    "the mean depth, the dot is the deepest place."
)
MAPS_NOTE = "The axes are the two swept values with the largest effect on the figure. Each cell shows its worst case."
DETAIL_FIGURES = (  # of one case
    (WEAR_PER_1000_HOURS, "per 1000 h"),
    (WEAR_PER_MILLION_STROKES, "per 10⁶ strokes"),
    ("wear_depth_max", "in the window"),
    ("pressure_mean", "pressure mean"),
    ("pressure_peak", "peak"),
    ("pv_peak", "pV peak"),
)
EXTRAPOLATED = (WEAR_PER_1000_HOURS, WEAR_PER_MILLION_STROKES)  # no forecasts beyond the clearance
MAPPED_FIGURES = (
    (WEAR_PER_1000_HOURS, "wear depth per 1000 h"),
    ("pressure_peak", "pressure peak"),
    ("pv_peak", "pV peak"),
)

IN_SPACE = " Maps of joints in space are unrolled: the angle runs across, the body's axis z upwards from its middle."
IN_SLOT = (
    " In a slot, 360° are one circuit of its wall, counter-clockwise from the middle of the end in its direction. Its "
    "journal is a pin."
)


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished or nothing wears."""
    if study.cases.empty:
        return []
    blocks: list[Block] = []
    for joint in study.joints:
        if joint.wears:
            blocks += _deepest_wear_blocks(study, joint)
            blocks += [
                Gallery(MAPS_NOTE, _maps(study, joint)),
                Sentences(_coarse_bin_sentences(study, joint)),
                _table(study, joint),
            ]
    return [Section("wear", "Wear", without_empty([Note(_note(study)), *blocks] if blocks else []))]


def _note(study: Study) -> str:
    slots = any("slot_length" in study.base["joints"].get(joint.title, {}) for joint in study.joints if joint.wears)
    note = NOTE + IN_SPACE if any(joint.is_spatial for joint in study.run.layout.joints) else NOTE
    return note + IN_SLOT if slots else note


def _coarse_bin_sentences(study: Study, joint: Joint) -> list[str]:
    """Return a sentence with the number of cases with too coarse bins and a sufficient number of bins, or []."""
    column = joint.column("wear_bins_enough")
    bins = next(joint_layout.wear_bins for joint_layout in study.run.layout.joints if joint_layout.name == joint.name)
    if not study.has(column) or study.cases[column].max() <= bins:
        return []
    coarse = study.cases[column][study.cases[column] > bins]
    bins_needed, max_bins = int(coarse.max()), simulation.MAX_BINS
    remedy = (
        f"`bins: {bins_needed}` is enough for all"
        if bins_needed <= max_bins
        else f"even {max_bins} bins, the maximum, are too few"
    )
    return [
        f"In joint {joint.title} {bins} bins are too coarse in {len(coarse):,} of "
        f"{wording.count_text(len(study.cases), 'case')}: more than 5 % of the wear comes from contact arcs narrower "
        "than "
        f"five bins. Their depths are means over the bins, not peaks; {remedy}."
    ]


def _table(study: Study, joint: Joint) -> Table:
    """Return the table of the wear of one joint, the deepest first."""
    columns = columns_in_table(study, "wear", joint)
    key, title = f"wear_{joint.name}", f"Wear in joint {joint.title}"
    table = case_table(study, key, title, columns, joint.column("wear_depth_max"))
    return table._replace(
        note=f"{table.note} Depth and volume are those of the recorded window. The depths per 1000 h and "
        "per 10⁶ strokes (turns of the crank) are extrapolated at its wear rate. Pressure and pV are maxima on the "
        "contact arc unless called mean; limits in catalogues refer to force over diameter times length. Narrow arcs "
        "are the share of the wear steps whose contact arc was narrower than five bins."
    )


def _deepest_wear_blocks(study: Study, joint: Joint) -> list[Block]:
    """Return the most worn case, and a selector of other cases."""
    column = worn.ranking_column(study, joint)
    if not study.has(column):
        return []
    case_id = study.cases[column].idxmax()
    hours = _hours_to_clearance(study, joint, case_id)
    figures = [
        (name, joint.column(figure))
        for figure, name in DETAIL_FIGURES
        if study.has(joint.column(figure)) and not (hours and figure in EXTRAPOLATED)
    ]
    deepest = Detail(
        f"Fastest wear, joint {joint.title}",
        case_id,
        study.setting(case_id),
        [
            *([("reaches the clearance after", hours)] if hours else []),
            *((name, study.text(case_id, figure)) for name, figure in figures),
        ],
        worn.wear_pictures(study, joint, case_id, study.run.wear(case_id)[joint.name]),
        key=f"wear-{joint.name}",
    )
    selector = worn.selectable_cases(study, joint)
    return [deepest, selector] if selector else [deepest]


def _hours_to_clearance(study: Study, joint: Joint, case_id: str) -> str:
    """Return the hours after which the wear of a case equals its clearance; '' unless it does within 1000 hours."""
    layout = next(joint_layout for joint_layout in study.run.layout.joints if joint_layout.name == joint.name)
    per_1000_hours = joint.column(WEAR_PER_1000_HOURS)
    if per_1000_hours not in study.cases:
        return ""
    row, depth = int(study.cases.index.get_loc(case_id)), float(study.cases.at[case_id, per_1000_hours])
    return wear.clearance_hours_text(finished_cases(study), layout, row, depth)


def _maps(study: Study, joint: Joint) -> list[Picture]:
    """Return wear depth and wear rate over the most important axes."""
    return [
        picture for figure, name in MAPPED_FIGURES for picture in maps.pictures_over_axes(study, joint, figure, name)
    ]
