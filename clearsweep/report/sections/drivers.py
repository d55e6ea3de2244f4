"""Drivers of the leading figure: medians over the values of each axis, drawn and tabulated."""

import numpy as np

from ...language import wording
from ...language.wording import Scale
from ..blocks.picture import Picture, capitalise
from ..blocks.section import Gallery, Section, without_empty
from ..blocks.table import Column, Quantity, Table
from ..data.comparable import EXCLUDED_STARTS_NOTE, excludes_cut_off_starts
from ..data.leading import PEAK
from ..data.study import P99_OVER_IDEAL, Joint, Study
from ..data.table_columns import columns_in_table
from ..draw import comparison
from ..draw.comparison import Curve
from ..draw.style import BLUE, JOINT_COLOURS, RED
from ..statistics.main_effects import MainEffect, main_effects_of

_FORCE_FIGURES = ((PEAK.figure, "peak"), ("force_rms", "rms"))
MAX_UNFOLDED_AXES = 4  # axes that are drawn at once, the strongest; the rest is folded
MIN_SHARE = 0.01  # of the variation: an axis with less is folded, unless it is the only one
MAX_LISTED_MEDIANS = 9  # values of an axis up to which the text of a picture gives each median


def sections(study: Study) -> list[Section]:
    """Return the section with pictures of the strongest axes, or [] if no two cases share the value of an axis."""
    if not _has_shared_values(study):
        return []
    gallery = Gallery(_note(study), _lead_pictures(study)[: _unfolded_count(study)], small=True)
    return [Section("drivers", "What drives it", without_empty([gallery]))]


def folded_sections(study: Study) -> list[Section]:
    """Return the other axes, the drivers of the force over the ideal reaction, and a table of all main effects."""
    if not _has_shared_values(study):
        return []
    joint, pictures = study.most_loaded_joint(), _lead_pictures(study)[_unfolded_count(study) :]
    if study.has(joint.column(P99_OVER_IDEAL)) and len(study.levels()) > 1 and ideal_varies(study, joint):
        pictures += _pictures(study, ((P99_OVER_IDEAL, "p99 / ideal"),), "p99 / ideal peak")
    return [Section("main-effects", "Main effects", without_empty([Gallery("", pictures, small=True), _table(study)]))]


def _has_shared_values(study: Study) -> bool:
    """Return whether any axis has a value that several cases share."""
    if study.cases.empty or not study.levels():
        return False
    return study.has(study.most_loaded_joint().column(study.lead.figure))


def _lead_pictures(study: Study) -> list[Picture]:
    if study.lead is PEAK:
        return _pictures(study, _FORCE_FIGURES, "force")
    return _pictures(study, ((study.lead.figure, study.lead.name),), study.lead.name)


def _unfolded_count(study: Study) -> int:
    """Return how many axes are drawn outside the folded part: those with an effect on the leading figure."""
    effects = main_effects_of(study, study.most_loaded_joint().column(study.lead.figure))
    return min(MAX_UNFOLDED_AXES, max(sum(not effect.share < MIN_SHARE for effect in effects), 1))


def ideal_varies(study: Study, joint: Joint) -> bool:
    """Return whether the ideal reaction of a joint varies; if not, force over ideal reaction shows nothing new."""
    column = joint.column("force_peak_ideal")
    return study.has(column) and study.cases[column].nunique() > 1


def _note(study: Study) -> str:
    has_several = len(study.swept()) > 1
    note = (
        "Each point is the median over cases that differ in nothing else; the band contains the middle 80 %. "
        if has_several
        else ""
    )
    note += "Panels share their scale." if has_several else "Each point is a case."
    if len(study.joints) > 1 and study.lead is PEAK:
        note += " Solid lines or dots are the peaks of a joint, dashed lines or squares its rms values."
    if excludes_cut_off_starts(study, study.most_loaded_joint().column(study.lead.figure)):
        note += EXCLUDED_STARTS_NOTE
    return note


def _pictures(study: Study, figures: tuple[tuple[str, str], ...], name: str) -> list[Picture]:
    """Return one picture per axis, the strongest first; the first of the `figures`, (figure, name), has a band."""
    leading = study.most_loaded_joint().column(figures[0][0])
    curves: dict[str, list[Curve]] = {effect.axis.path: [] for effect in main_effects_of(study, leading)}
    for joint_index, joint in enumerate(study.joints):
        for figure_index, (figure, figure_name) in enumerate(figures):
            for curve in _curves(study, joint, joint_index, (figure, figure_name), band=figure_index == 0):
                curves[curve.effect.axis.path].append(curve)
    edges = [edge for axis_curves in curves.values() for curve in axis_curves for edge in _band_edges(curve)]
    return [_picture(study, axis_curves, name, _value_range(edges)) for axis_curves in curves.values() if axis_curves]


def _curves(study: Study, joint: Joint, joint_index: int, figure: tuple[str, str], *, band: bool) -> list[Curve]:
    """Return the curves of one figure, (figure, name), of the joint with index `joint_index`, one for each axis."""
    has_several_joints, column = len(study.joints) > 1, joint.column(figure[0])
    if not study.has(column):
        return []
    colour = JOINT_COLOURS[joint_index % 3] if has_several_joints or band else RED
    dashed_name = "" if has_several_joints else figure[1]  # what dashes represent is explained above the pictures
    name = joint.title if has_several_joints and band else dashed_name
    return [Curve(name, colour, band, effect) for effect in main_effects_of(study, column)]


def effect_picture(study: Study, effect: MainEffect, name: str) -> Picture:
    """Return the picture of a figure over one axis."""
    curve = Curve("", BLUE, True, effect)
    return _picture_over_axis(study, [curve], (name, name), _value_range(_band_edges(curve)))


def _band_edges(curve: Curve) -> list[np.ndarray]:
    return [curve.effect.low, curve.effect.high] if curve.has_band else [curve.effect.medians]


def _value_range(edges: list[np.ndarray]) -> tuple[float, float]:
    values = np.concatenate(edges)
    values = values[np.isfinite(values)]
    return (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)


def _picture(study: Study, curves: list[Curve], name: str, limits: tuple[float, float]) -> Picture:
    joint = study.joints[0]
    first_name = study.lead.name if curves[0].effect.column.endswith(f"_{study.lead.figure}") else "p99 / ideal"
    first_name += study.joint_text(joint, ", joint {}")
    return _picture_over_axis(study, curves, (name, first_name), limits)


def _picture_over_axis(
    study: Study, curves: list[Curve], names: tuple[str, str], limits: tuple[float, float]
) -> Picture:
    """Return the picture of curves over one axis; `names`: (of all curves together, of the first curve)."""
    (name, first_name), effect = names, curves[0].effect
    scale, axis, medians = study.scale(effect.column), effect.axis, ""
    if len(axis.values) <= MAX_LISTED_MEDIANS:
        value_medians = zip(axis.values, map(scale.text, effect.medians), strict=True)
        medians = "; ".join(f"{axis.text(value)}: {median}" for value, median in value_medians)
    return Picture(
        f"{capitalise(name)} over {axis.name}",
        "" if np.isnan(effect.share) else f"{wording.percent_text(effect.share)} of the variation of {first_name}",
        f"Median of {first_name} over {axis.name}. {medians}",
        lambda ax: comparison.draw_effect(ax, curves, scale, limits, name),
        size=(3.3, 2.8),
    )


def _table(study: Study) -> Table:
    """Return the main effect of every axis on the figures of every joint and of the mechanism."""
    columns = (
        Column("figure"),
        Column("figure unit", file_only=True),
        Column("axis"),
        Column("axis unit", file_only=True),
        Column("smallest median"),
        Column("found at"),
        Column("largest median"),
        Column("reached at"),
        Column("factor"),
        Column("share of the variation"),
    )
    rows: list[tuple] = []
    for column, name in _tabulated_figures(study):
        effects = [effect for effect in main_effects_of(study, column) if np.isfinite(effect.medians).any()]
        scale = study.scale(column)
        rows += [_row(study, name, effect, scale) for effect in effects]
    note = (
        "Median over cases that are compared with cases equal in every other value. Share of the "
        "variation: the part of the figure's variance that the axis explains by itself. Interaction "
        "and chaos explain the rest."
    )
    return Table("effects", "Main effects", note, columns, rows)


def _tabulated_figures(study: Study) -> list[tuple[str, str]]:
    """Return the figures whose main effects are tabulated: column, name."""
    lead = study.lead
    columns = {joint.column(lead.figure): lead.name + study.joint_text(joint, " ({})") for joint in study.joints}
    columns |= dict(columns_in_table(study, "effects"))
    return [(column, name) for column, name in columns.items() if study.has(column)]


def _row(study: Study, name: str, effect: MainEffect, scale: Scale) -> tuple:
    axis, unit = effect.axis, study.unit(effect.column)
    extreme_cells = []
    for index in effect.extreme_indices():
        median, value = float(effect.medians[index]), axis.values[index]
        extreme_cells += [Quantity(median, scale.text(median)), Quantity(value, axis.text(value))]
    share = Quantity(effect.share, wording.percent_text(effect.share))
    return (name, unit, axis.name, study.unit(axis.path), *extreme_cells, effect.factor(), share)
