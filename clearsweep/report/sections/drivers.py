"""Drivers of the leading figure: medians over the values of each axis, drawn and tabulated."""

import numpy as np

from ...language import wording
from ...language.wording import Scale
from ..blocks.picture import Picture, capital
from ..blocks.section import Gallery, Points, Section, without_empty
from ..blocks.table import Column, Quantity, Table
from ..data.comparable import LEFT_OUT, leaves_out
from ..data.leading import PEAK
from ..data.study import P99_OVER_IDEAL, Joint, Study
from ..data.table_columns import columns_in_table
from ..data.worst_case import question
from ..draw import comparison
from ..draw.comparison import Curve
from ..draw.style import BLUE, JOINT_COLOURS, RED
from ..statistics.main_effects import MainEffect, main_effects_of

_FORCE = ((PEAK.figure, "peak"), ("force_rms", "rms"))
MOST = 4  # axes that are drawn at once, the strongest; the rest is folded
LEAST_SHARE = 0.01  # of the variation: an axis with less is folded, unless it is the only one
OTHERS = 2  # other figures at most whose strongest axis is named
NOTED = 9  # values of an axis up to which the text of a picture gives each median


def sections(study: Study) -> list[Section]:
    """Return the section with pictures of the strongest axes, or [] if no two cases share the value of an axis."""
    if not _comparable(study):
        return []
    points = Points(sentences(study, study.hardest_joint()))
    drawn = Gallery(_note(study), _leading(study)[: _at_once(study)], small=True)
    return [Section("drivers", "What drives it", without_empty([points, drawn]))]


def more(study: Study) -> list[Section]:
    """Return the other axes, the drivers of the force over the ideal reaction, and a table of all main effects."""
    if not _comparable(study):
        return []
    joint, pictures = study.hardest_joint(), _leading(study)[_at_once(study) :]
    if study.has(joint.column(P99_OVER_IDEAL)) and len(study.levels()) > 1 and ideal_varies(study, joint):
        pictures += _pictures(study, ((P99_OVER_IDEAL, "p99 / ideal"),), "p99 / ideal peak")
    return [Section("main-effects", "Main effects", without_empty([Gallery("", pictures, small=True), _table(study)]))]


def sentences(study: Study, joint: Joint) -> list[str]:
    """Return sentences that name the strongest axes for the leading figure of a joint and for its other figures."""
    effects = main_effects_of(study, joint.column(study.lead.figure))
    strong = [effect for effect in effects if effect.clear()]
    weak = [effect.axis.name for effect in effects if not effect.clear()]
    if not strong:
        return _others(study, joint)  # as the answer says
    if len(effects) == 1:  # the answer has its effect
        return _others(study, joint)
    listed = [f"{effect.axis.name} ({wording.percent(effect.share)})" for effect in strong]
    text = f"The variation of the {study.lead.name} is caused by {wording.sentence_list(listed)}."
    if weak:
        text += f" The effect of {wording.sentence_list(weak)} is not clear."
    return [text, *_others(study, joint), *_relative_to_ideal(study, joint)]


def _others(study: Study, joint: Joint) -> list[str]:
    """Return one sentence for each other figure with a clear strongest driver that the answer does not mention."""
    asked, others = question(study).question, dict[str, str]()
    if asked != "film":
        others[joint.column("film_loss")] = "film loss"
    if asked not in ("force", "start-up"):
        others[study.column("error_max")] = f"{study.run.layout.output} error"
    sentences = []
    for column, name in others.items():
        if not column or column not in study.cases or not study.has(column):
            continue
        strongest = main_effects_of(study, column)[0]
        if strongest.clear():
            verb = "varies with" if len(study.levels()) == 1 else "depends most on"
            sentences.append(f"The {name} {verb} {_cause(strongest, study)}.")
    return sentences[:OTHERS]


def _relative_to_ideal(study: Study, joint: Joint) -> list[str]:
    """Return the sentence on the strongest axis for force over ideal reaction, or [] if that reaction is constant."""
    ratio = joint.column("force_peak_ratio")
    if study.lead is not PEAK or not study.has(ratio) or not ideal_varies(study, joint):
        return []
    strongest = main_effects_of(study, ratio)[0]
    if not strongest.clear():
        return []
    return [
        f"The ratio of the peak to that without clearance depends most on {strongest.axis.name}: "
        f"{_span(strongest, wording.Scale(1.0, ''))}."
    ]


def _cause(effect: MainEffect, study: Study) -> str:
    """Return the name of an axis with its smallest and largest median."""
    return f"{effect.axis.name}: {_span(effect, study.scale(effect.column))}"


def _span(effect: MainEffect, scale: wording.Scale) -> str:
    medians = _medians(effect, scale)
    return medians if np.isnan(effect.share) else f"median {medians}"


def _medians(effect: MainEffect, scale: wording.Scale) -> str:
    """Return the smallest and the largest median of an effect, in the order of the axis."""
    low, high = sorted(effect.extremes())
    axis = effect.axis
    first, last = (f"{scale.text(effect.medians[place])} at {axis.text(axis.values[place])}" for place in (low, high))
    return f"{first}, {last}"


def _comparable(study: Study) -> bool:
    """Return whether any axis has a value that several cases share."""
    if study.cases.empty or not study.levels():
        return False
    return study.has(study.hardest_joint().column(study.lead.figure))


def _leading(study: Study) -> list[Picture]:
    if study.lead is PEAK:
        return _pictures(study, _FORCE, "force")
    return _pictures(study, ((study.lead.figure, study.lead.name),), study.lead.name)


def _at_once(study: Study) -> int:
    """Return how many axes are drawn outside the folded part: those with an effect on the leading figure."""
    effects = main_effects_of(study, study.hardest_joint().column(study.lead.figure))
    return min(MOST, max(sum(not effect.share < LEAST_SHARE for effect in effects), 1))


def ideal_varies(study: Study, joint: Joint) -> bool:
    """Return whether the ideal reaction of a joint varies; if not, force over ideal reaction shows nothing new."""
    column = joint.column("force_peak_ideal")
    return study.has(column) and study.cases[column].nunique() > 1


def _note(study: Study) -> str:
    band = "; the band contains the middle 80 %" if len(study.swept()) > 1 else ""
    note = f"Each point is the median of the cases with that value{band}. Panels share their scale."
    if len(study.joints) > 1 and study.lead is PEAK:
        note += " Solid lines or dots are the peaks of a joint, dashed lines or squares its rms values."
    if leaves_out(study, study.hardest_joint().column(study.lead.figure)):
        note += LEFT_OUT
    return note


def _pictures(study: Study, figures: tuple[tuple[str, str], ...], name: str) -> list[Picture]:
    """Return one picture per axis, the strongest first; the first of the `figures`, (figure, name), has a band."""
    leading = study.hardest_joint().column(figures[0][0])
    curves: dict[str, list[Curve]] = {effect.axis.path: [] for effect in main_effects_of(study, leading)}
    for place, joint in enumerate(study.joints):
        for number, (figure, word) in enumerate(figures):
            for curve in _curves(study, joint, place, (figure, word), band=number == 0):
                curves[curve.effect.axis.path].append(curve)
    edges = [edge for group in curves.values() for curve in group for edge in _edges(curve)]
    return [_picture(study, group, name, _range(edges)) for group in curves.values() if group]


def _curves(study: Study, joint: Joint, place: int, figure: tuple[str, str], *, band: bool) -> list[Curve]:
    """Return the curves of one figure, (figure, name), of the joint with index `place`, one for each axis."""
    several, column = len(study.joints) > 1, joint.column(figure[0])
    if not study.has(column):
        return []
    colour = JOINT_COLOURS[place % 3] if several or band else RED
    dashed = "" if several else figure[1]  # what dashes represent is explained above the pictures
    name = joint.title if several and band else dashed
    return [Curve(name, colour, band, effect) for effect in main_effects_of(study, column)]


def line(study: Study, effect: MainEffect, name: str) -> Picture:
    """Return the picture of a figure over one axis."""
    curve = Curve("", BLUE, True, effect)
    return _picture_over_axis(study, [curve], (name, name), _range(_edges(curve)))


def _edges(curve: Curve) -> list[np.ndarray]:
    return [curve.effect.low, curve.effect.high] if curve.has_band else [curve.effect.medians]


def _range(edges: list[np.ndarray]) -> tuple[float, float]:
    values = np.concatenate(edges)
    values = values[np.isfinite(values)]
    return (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)


def _picture(study: Study, curves: list[Curve], name: str, limits: tuple[float, float]) -> Picture:
    joint = study.joints[0]
    first = study.lead.name if curves[0].effect.column.endswith(f"_{study.lead.figure}") else "p99 / ideal"
    first += study.joint_text(joint, ", joint {}")
    return _picture_over_axis(study, curves, (name, first), limits)


def _picture_over_axis(
    study: Study, curves: list[Curve], names: tuple[str, str], limits: tuple[float, float]
) -> Picture:
    """Return the picture of curves over one axis; `names`: (of all curves together, of the first curve)."""
    (name, first), effect = names, curves[0].effect
    scale, axis, medians = study.scale(effect.column), effect.axis, ""
    if len(axis.values) <= NOTED:
        steps = zip(axis.values, map(scale.text, effect.medians), strict=True)
        medians = "; ".join(f"{axis.text(value)}: {median}" for value, median in steps)
    return Picture(
        f"{capital(name)} over {axis.name}",
        "" if np.isnan(effect.share) else f"{wording.percent(effect.share)} of the variation of {first}",
        f"Median of {first} over {axis.name}. {medians}",
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
    for column, name in _affected(study):
        effects = [effect for effect in main_effects_of(study, column) if np.isfinite(effect.medians).any()]
        scale = study.scale(column)
        rows += [_row(study, name, effect, scale) for effect in effects]
    note = (
        "Median over all finished cases that share a value; the other axes take all their values. Share of the "
        "variation: the part of the variance of the figure's logarithm that the axis explains by itself. Interaction "
        "and chaos explain the rest."
    )
    return Table("effects", "Main effects", note, columns, rows)


def _affected(study: Study) -> list[tuple[str, str]]:
    """Return the figures whose main effects are tabulated: column, name."""
    lead = study.lead
    columns = {joint.column(lead.figure): lead.name + study.joint_text(joint, " ({})") for joint in study.joints}
    columns |= dict(columns_in_table(study, "effects"))
    return [(column, name) for column, name in columns.items() if study.has(column)]


def _row(study: Study, name: str, effect: MainEffect, scale: Scale) -> tuple:
    axis, unit = effect.axis, study.unit(effect.column)
    ends = []
    for place in effect.extremes():
        median, value = float(effect.medians[place]), axis.values[place]
        ends += [Quantity(median, scale.text(median)), Quantity(value, axis.text(value))]
    share = Quantity(effect.share, wording.percent(effect.share))
    return (name, unit, axis.name, study.unit(axis.path), *ends, effect.factor(), share)
