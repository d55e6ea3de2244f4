"""Wear, life and films of oil: places, hours to the limit, losses."""

import itertools
from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ... import simulation
from ...answers.ranking import clearance_hours_text
from ...language import wording
from ..axis import Axis
from ..blocks.section import FLAT_SIZE, Block, Detail, Gallery, Note, Picture, Section, Sentences, section
from ..blocks.table import Table, case_table, columns_in_table
from ..draw import BLUE, GREEN, GREY, ORANGE, RED, label_values, label_with_unit, set_plain_axes
from ..one_case.joints import ranking_column, selectable_cases, wear_pictures
from ..plot import Axes
from ..study import WEAR_PER_1000_HOURS, WEAR_PER_MILLION_STROKES, Joint, Study, finished_cases
from .maps import pictures_over_axes

# Wear: the deepest places of each joint, and the wear in every finished case.

WEAR_NOTE = (
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
IN_TEETH = (
    " Of teeth, 0 to 180° are the path of contact of the drive flank, 180 to 360° that of the coast flank, along its "
    "normal. The bearing is the first wheel, the journal the second one, and depths are means over the teeth."
)


def wear_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished or nothing wears."""
    if study.cases.empty:
        return []
    blocks: list[Block] = []
    for joint in study.joints:
        if joint.wears:
            blocks += _deepest_wear_blocks(study, joint)
            maps = [pictures_over_axes(study, joint, figure, name) for figure, name in MAPPED_FIGURES]
            gallery = Gallery(MAPS_NOTE, list(itertools.chain(*maps)))
            blocks += [gallery, Sentences(_coarse_bin_sentences(study, joint)), _table(study, joint)]
    return section("wear", "Wear", *[Note(_note(study)), *blocks] if blocks else [])


def _note(study: Study) -> str:
    slots = any("slot_length" in study.base["joints"].get(joint.title, {}) for joint in study.joints if joint.wears)
    note = WEAR_NOTE + IN_SPACE if any(joint.layout.is_spatial for joint in study.joints) else WEAR_NOTE
    teeth = any(joint.layout.flanked for joint in study.joints if joint.wears)
    return note + IN_SLOT * slots + IN_TEETH * teeth


def _coarse_bin_sentences(study: Study, joint: Joint) -> list[str]:
    """Return a sentence with the number of cases with too coarse bins and a sufficient number of bins, or []."""
    column = joint.column("wear_bins_enough")
    bins = joint.layout.wear_bins
    if not study.has(column) or study.cases.largest(column) <= bins:
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
        f"than five bins. Their depths are means over the bins, not peaks; {remedy}."
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
        "are the share of the time in contact in which the arc was narrower than five bins."
    )


def _deepest_wear_blocks(study: Study, joint: Joint) -> list[Block]:
    """Return the most worn case, and a selector of other cases."""
    column = ranking_column(study, joint)
    if not study.has(column):
        return []
    case_id = study.cases.worst_case(column)
    per_1000_hours, hours = joint.column(WEAR_PER_1000_HOURS), ""  # after which the wear equals the clearance
    if per_1000_hours in study.cases:
        row, depth = study.cases.row_of(case_id), float(study.cases.at(case_id, per_1000_hours))
        hours = clearance_hours_text(finished_cases(study), joint.layout, row, depth)
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
        wear_pictures(study, joint, case_id, study.run.wear(case_id)[joint.name]),
        key=f"wear-{joint.name}",
    )
    selector = selectable_cases(study, joint)
    return [deepest, selector] if selector else [deepest]


# Life of joints: hours to the limit over the swept values, and figures until then.

COLOURS = (RED, BLUE, GREEN)
LIFE_FIGURES = (  # figure, its key in the history of a life, unit, name
    ("wear_depth_max", "wear_depth_max", "m", "wear depth"),
    ("clearance_growth", "clearance", "m", "growth of the clearance"),
    ("force_peak", "force_peak", "N", "force peak"),
)
LIFE_NOTE = (
    "Curves: the cases with the shortest, median and longest life. Points: starts of the simulated blocks. Bars: 95 % "
    "interval of the number of revolutions to the limit, numerical error only. Dotted line: the limit. The map shows, "
    "for each cell, the shortest life of its cases."
)


def life_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case has a life or none finished."""
    joint = next((joint for joint in study.joints if joint.name == study.run.layout.life), None)
    if joint is None or study.cases.empty:
        return []
    return section("life", "Life", Gallery(LIFE_NOTE, _pictures(study, joint)))


def _pictures(study: Study, joint: Joint) -> list[Picture]:
    """Return the life over the axes, and the histories of the shortest, the median and the longest life."""
    hours = joint.column("life_hours")
    ids = study.cases.representative_cases(hours)[::-1] if study.has(hours) else ()
    names = {1: ("the case",), 2: ("shortest", "longest"), 3: ("shortest", "median", "longest")}.get(len(ids), ())
    caption = "; ".join(f"{name}: {study.setting(each) or each}" for name, each in zip(names, ids, strict=True))
    pictures = pictures_over_axes(study, joint, "life_hours", "life")
    for number, (figure, key, unit, title) in enumerate(LIFE_FIGURES if ids else ()):
        curves = [_life_curve(study, joint, name, each, (figure, key)) for name, each in zip(names, ids, strict=True)]
        end_texts = wording.texts_in_common_unit((float(curve.values[-1]) for curve in curves), unit)
        curve_texts = ", ".join(f"{curve.name} {end}" for curve, end in zip(curves, end_texts, strict=True))
        text = f"{title} over revolutions; at the end: {curve_texts}."
        limit = study.run.grid["life"].get("limit") if figure == study.run.grid["life"]["of"] else None
        limit = limit if isinstance(limit, float) else None
        paint = partial(draw_over_revolutions, curves=curves, unit=unit, name=title, limit=limit)
        pictures.append(Picture(f"{title.capitalize()} over revolutions", "" if number else caption, text, paint))
    return pictures


class LifeCurve(NamedTuple):
    """A figure of one case over revolutions."""

    name: str
    revolutions: np.ndarray  # (nodes,) from 0
    values: np.ndarray  # (nodes,) SI
    interval: tuple[float, float] | None = None  # revolutions, of the last node


def draw_over_revolutions(
    ax: Axes, curves: Sequence[LifeCurve], unit: str, name: str, limit: float | None = None
) -> None:
    """Draw a figure (SI, of `unit`) over revolutions, with the interval of each end, and any limit."""
    scale = wording.scale(unit, [*(value for curve in curves for value in curve.values), limit])
    last_revolutions = [curve.revolutions[-1] for curve in curves]
    revolution_scale = wording.scale("revolutions", last_revolutions)
    for curve, colour in zip(curves, COLOURS, strict=False):
        x, y = curve.revolutions / revolution_scale.factor, curve.values / scale.factor
        ax.plot(x, y, color=colour, linewidth=1.4, marker="o", markersize=3, label=curve.name)
        if curve.interval:
            ax.plot(
                np.array(curve.interval) / revolution_scale.factor, [y[-1]] * 2, color=colour, marker="|", linewidth=1.0
            )
    if limit is not None:
        ax.axhline(limit / scale.factor, color=GREY, linewidth=1.0, linestyle=":")
    power_text = revolution_scale.unit.removesuffix("revolutions").rstrip()
    ax.set_labels(f"revolutions [{power_text}]" if power_text else "revolutions", label_with_unit(name, scale))
    ax.set_xlim(0.0, None)
    ax.set_ylim(0.0, None)
    set_plain_axes(ax)
    ax.set_legend("above", columns=3)


def _life_curve(study: Study, joint: Joint, name: str, case_id: str, figure: tuple[str, str]) -> LifeCurve:
    """Return a figure (and its key in the history) of a case; the limited figure has the interval of its end."""
    history = study.run.history(case_id)
    values = np.asarray(history[f"{joint.name}/{figure[1]}"], float)
    interval = None
    if figure[0] == study.run.grid["life"]["of"]:
        low, high = (float(study.cases.at(case_id, joint.column(f"life_{end}"))) for end in ("low", "high"))
        interval = (low, high) if np.isfinite(low) and np.isfinite(high) else None
    plotted = values - values[0] if figure[0] == "clearance_growth" else values
    return LifeCurve(name, np.asarray(history["revolutions"], float), plotted, interval)


# Films of oil: least thickness, losses, and the time in which only the film carries load.

FILM_NOTE = (
    "The film carries the whole load as long as the journal does not touch the bearing. Beyond the valid range of its "
    "law, the film is evaluated at the limit. The least thickness and the loss are those of the recorded window."
)


def film_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished or no joint has a film."""
    blocks: list[Block] = []
    for joint in study.joints if not study.cases.empty else ():
        thinnest = joint.column("film_thickness_min")
        if study.has(thinnest):
            title = f"Film in joint {joint.title}"
            table = case_table(
                study, f"film_{joint.name}", title, columns_in_table(study, "film", joint), thinnest, smallest=True
            )
            blocks.append(table._replace(note=f"{table.note} {FILM_NOTE}"))
    return [Section("film", "Films", blocks)] if blocks else []


LIFE = "life_l10r"
NOTE = (
    "The rating life of a rolling bearing is usually longest at a slightly negative to small clearance. A preload "
    "loads all elements, and in a loose bearing few elements carry all. A class has to leave room for its scatter."
)
MIN_VALUES = 3  # of the clearance, of a picture


def bearing_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no clearance of a rolling bearing with a life is varied."""
    if study.cases.empty:
        return []
    pictures = [picture for joint in study.joints for picture in _life_over_clearance(study, joint)]
    return section("bearings", "Rolling bearings", Gallery(NOTE, pictures)) if pictures else []


def _life_over_clearance(study: Study, joint: Joint) -> Iterator[Picture]:
    """Yield the life of a bearing over its clearance: the shortest and, of several cases at a value, the longest."""
    path, column = f"joints.{joint.title}.clearance", joint.column(LIFE)
    axis: Axis | None = next((axis for axis in study.levels() if axis.path == path), None)
    if axis is None or not study.has(column) or len(axis.values) < MIN_VALUES:
        return
    indices, lives = study.indices_on(axis), study.cases[column]
    groups = [lives[(indices == k) & np.isfinite(lives)] for k in range(len(axis.values))]
    if not all(map(len, groups)):
        return
    shortest, longest = (np.array([function(group) for group in groups]) for function in (np.min, np.max))
    is_spread = bool((longest > shortest).any())
    curves = [("shortest", shortest), ("longest", longest)] if is_spread else [("", shortest)]
    best = int(shortest.argmax())
    text = wording.quantity_text(float(shortest[best]), "h", 4)

    def paint(ax: Axes) -> None:
        positions = np.array(axis.values, float) / axis.scale.factor
        for (name, values), colour in zip(curves, (BLUE, ORANGE), strict=False):
            ax.plot(positions, values, "o-", color=colour, markersize=4.0, label=name)
        if positions.min() < 0.0 < positions.max():
            ax.axvline(0.0, color=GREY, linewidth=0.8, linestyle="--")
        label_values(ax.xaxis, axis, positions)
        ax.set_ylim(0.0, None)
        ax.set_labels(axis.label(), "rating life [h]")
        set_plain_axes(ax)
        if is_spread:
            ax.set_legend("above", columns=2)

    yield Picture(
        f"Rating life over the clearance{study.joint_text(joint, ', joint {}')}",
        "Of all cases at a clearance." if is_spread else "",
        f"Rating life over {axis.name}, longest with {text} at {axis.text(axis.values[best])}.",
        paint,
        FLAT_SIZE,
    )
