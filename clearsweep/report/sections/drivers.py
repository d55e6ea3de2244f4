"""What drives the figures: effects of each axis, trends of wear, one figure over another."""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...answers.judged import Estimate
from ...answers.sentences import deciding_figures
from ...answers.verdict import column_label
from ...language import wording
from ...language.wording import Scale
from ..axis import PEAK, Axis
from ..blocks.section import Gallery, Picture, Points, Section, capitalise, section
from ..blocks.table import Quantity, Table, columns_in_table, columns_of, count_cell
from ..draw import BLUE, JOINT_COLOURS, RED, comparison
from ..draw.comparison import Curve
from ..effects import (
    MainEffect,
    estimate_quantile,
    main_effects_of,
    match_cases,
    positive_values,
    trend_exponent,
    yield_speed_sentence,
)
from ..one_case.joints import deepest_along_axis
from ..plot import Axes
from ..study import (
    EXCLUDED_STARTS_NOTE,
    P99_OVER_IDEAL,
    WEAR_PER_MILLION_STROKES,
    Joint,
    Study,
    answer_of_study,
    excludes_cut_off_starts,
)

# Drivers of the leading figure: medians over the values of each axis, drawn and tabulated.

_FORCE_FIGURES = ((PEAK.figure, "peak"), ("force_rms", "rms"))
MAX_UNFOLDED_AXES = 4  # axes that are drawn at once, the strongest; the rest is folded
MIN_SHARE = 0.05  # of the variation: an axis with less is folded, unless it is the only one
MAX_LISTED_MEDIANS = 9  # values of an axis up to which the text of a picture gives each median


def driver_sections(study: Study) -> list[Section]:
    """Return the section with pictures of the strongest axes, or [] if no two cases share the value of an axis."""
    if not _has_shared_values(study):
        return []
    if deciding := _deciding_column(study):
        effects = main_effects_of(study, deciding)
        pictures = [effect_picture(study, effect, column_label(study.run.layout, deciding)) for effect in effects]
        gallery = Gallery(_scale_note(study), pictures[: _count_strong(effects)], small=True)
    else:
        gallery = Gallery(_note(study), _lead_pictures(study)[: _unfolded_count(study)], small=True)
    return section("drivers", "What drives it", gallery)


def _deciding_column(study: Study) -> str:
    """Return the column of the limit that decides the designs; '' if that is the leading figure, or without limits."""
    answer = answer_of_study(study)
    if not answer.get("designs"):
        return ""
    column = next((name for name in deciding_figures(answer) if study.has(name)), "")
    is_lead = any(column == joint.column(study.lead.figure) for joint in study.joints)
    return "" if is_lead else column


def folded_driver_sections(study: Study) -> list[Section]:
    """Return the other axes, the drivers of the force over the ideal reaction, and a table of all main effects."""
    if not _has_shared_values(study):
        return []
    joint, drawn_count = study.most_loaded_joint(), 0 if _deciding_column(study) else _unfolded_count(study)
    pictures = _lead_pictures(study)[drawn_count:]
    if study.has(joint.column(P99_OVER_IDEAL)) and len(study.levels()) > 1 and ideal_varies(study, joint):
        pictures += _pictures(study, ((P99_OVER_IDEAL, "p99 / ideal"),), "p99 / ideal peak")
    return section("main-effects", "Main effects", Gallery("", pictures, small=True), _effect_table(study))


def _has_shared_values(study: Study) -> bool:
    """Return whether any axis has a value that several cases share."""
    if study.cases.empty or not study.levels():
        return False
    return study.has(study.most_loaded_joint().column(study.lead.figure))


def _lead_pictures(study: Study) -> list[Picture]:
    lead = study.lead
    figures, name = (_FORCE_FIGURES, "force") if lead is PEAK else (((lead.figure, lead.name),), lead.name)
    return _pictures(study, figures, name)


def _unfolded_count(study: Study) -> int:
    """Return how many axes are drawn outside the folded part: those with an effect on the leading figure."""
    return _count_strong(main_effects_of(study, study.most_loaded_joint().column(study.lead.figure)))


def _count_strong(effects: Sequence[MainEffect]) -> int:
    """Return how many axes are drawn at once: those with an effect, at least one."""
    return min(MAX_UNFOLDED_AXES, max(sum(not effect.share < MIN_SHARE for effect in effects), 1))


def ideal_varies(study: Study, joint: Joint) -> bool:
    """Return whether the ideal reaction of a joint varies; if not, force over ideal reaction shows nothing new."""
    return study.cases.varies(joint.column("force_peak_ideal"))


def _note(study: Study) -> str:
    note = _scale_note(study, "Panels share their scale.")
    if len(study.joints) > 1 and study.lead is PEAK:
        note += " Solid lines or dots are the peaks of a joint, dashed lines or squares its rms values."
    if excludes_cut_off_starts(study, study.most_loaded_joint().column(study.lead.figure)):
        note += EXCLUDED_STARTS_NOTE
    return note


def _scale_note(study: Study, shared: str = "") -> str:
    """Return what a point is; shared : further words if several axes are drawn."""
    if len(study.swept()) < 2:
        return "Each point is a case."
    note = "Each point is the median over cases that differ in nothing else; the band contains the middle 80 %."
    return f"{note} {shared}".strip()


def _pictures(study: Study, figures: tuple[tuple[str, str], ...], name: str) -> list[Picture]:
    """Return one picture per axis, the strongest first; the first of the `figures`, (figure, name), has a band."""
    leading = study.most_loaded_joint().column(figures[0][0])
    curves: dict[str, list[Curve]] = {effect.axis.path: [] for effect in main_effects_of(study, leading)}
    has_several_joints = len(study.joints) > 1  # then dashes are explained above the pictures
    for joint, joint_colour in zip(study.leading_joints, itertools.cycle(JOINT_COLOURS)):
        for figure, figure_name in figures:
            column, has_band = joint.column(figure), figure == figures[0][0]
            curve_name = (joint.title if has_band else "") if has_several_joints else figure_name
            colour = joint_colour if has_several_joints or has_band else RED
            for effect in main_effects_of(study, column) if study.has(column) else ():
                curves[effect.axis.path].append(Curve(curve_name, colour, has_band, effect))
    edges = [edge for axis_curves in curves.values() for curve in axis_curves for edge in _band_edges(curve)]
    pictures, first_joint = [], study.joint_text(study.leading_joints[0], ", joint {}")
    for axis_curves in filter(None, curves.values()):
        is_lead = axis_curves[0].effect.column.endswith(f"_{study.lead.figure}")
        first_name = (study.lead.name if is_lead else "p99 / ideal") + first_joint
        pictures.append(_picture_over_axis(study, axis_curves, (name, first_name), _value_range(edges)))
    return pictures


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


def _effect_table(study: Study) -> Table:
    """Return the main effect of every axis on the figures of every joint and of the mechanism."""
    columns = columns_of(
        "figure | figure unit* | axis | axis unit* | smallest median | found at | largest median | reached at | factor "
        "| share of the variation"
    )
    lead = study.lead
    figures = {joint.column(lead.figure): lead.name + study.joint_text(joint, " ({})") for joint in study.joints}
    figures |= dict(columns_in_table(study, "effects"))
    rows: list[tuple] = []
    for column, name in figures.items():
        if study.has(column):
            effects = [effect for effect in main_effects_of(study, column) if np.isfinite(effect.medians).any()]
            scale = study.scale(column)
            rows += [_row(study, name, effect, scale) for effect in effects]
    note = (
        "Median over cases that are compared with cases equal in every other value. Share of the variation: the part "
        "of the figure's variance that the axis explains by itself. Interaction and chaos explain the rest."
    )
    return Table("effects", "Main effects", note, columns, rows)


def _row(study: Study, name: str, effect: MainEffect, scale: Scale) -> tuple:
    axis, unit = effect.axis, study.unit(effect.column)
    extreme_cells = []
    for index in (np.nanargmin(effect.medians), np.nanargmax(effect.medians)):
        median, value = float(effect.medians[index]), axis.values[index]
        extreme_cells += [Quantity(median, scale.text(median)), Quantity(value, axis.text(value))]
    share = Quantity(effect.share, wording.percent_text(effect.share))
    return (name, unit, axis.name, study.unit(axis.path), *extreme_cells, effect.factor(), share)


# Comparison with trends of wear in the literature: pairs of cases that differ in one value only.

UNEVEN_RATIO = 1.5  # deepest over mean depth around a body above which its wear is called uneven
MAX_CASES_READ = 200  # cases whose depths round the circle are read; ids are hashes, so the first ones are random
SHOWN, CONTRADICTED, OPEN, NO_CLAIM = "shown", "contradicted", "not decided", "no claim"
NOTE = (
    "The literature finds deeper wear with larger clearance, higher crank speed and lower stiffness, and uneven wear "
    "around the circumference. This section compares the depth per turn of the crank in pairs of cases that differ in "
    "one value only. The interval of the median change shows or contradicts a trend. It assumes no distribution of the "
    "depths. With a probability of 95 % all claims on a joint are judged rightly together (Holm 1979). If an interval "
    "allows both, or the cases are too few for one, the trend remains open. Volume and pressure give the reason. The "
    "volume is the coefficient times the integral of the force over the sliding distance. The depth is this volume "
    "over the area that the contact passes. So a higher pressure alone does not wear deeper. Wear is "
    f"uneven if its deepest place is at least {UNEVEN_RATIO} times as deep as the mean around the body."
)


class Claim(NamedTuple):
    """A trend of wear depth with a swept value that the literature names."""

    title: str
    path_endings: tuple[str, ...]  # last parts of the paths concerned
    sign: float  # 1: deeper with a larger value, -1: with a smaller one


CLAIMS = (
    Claim("deeper with larger clearance", ("clearance",), 1.0),
    Claim("deeper with higher crank speed", ("drive.speed",), 1.0),
    Claim("deeper with lower stiffness", ("contact.stiffness", "young"), -1.0),
)
#: Figures that give the reason of a trend: column of a joint, name.
REASONS = (("wear_volume", "volume"), ("pressure_mean", "mean pressure"))


class Answer(NamedTuple):
    """Result of a run for one claim about one joint."""

    title: str
    joint: Joint
    measure: str  # the estimate in words
    estimate: Estimate
    number: int  # of pairs or cases
    counted: str  # which of both
    verdict: str


def trend_sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing wears, nothing turns or no case finished."""
    if study.cases.empty or not study.is_driven:
        return []
    answers: list[Answer] = []
    for joint in study.joints:
        if joint.wears and study.has(joint.column(WEAR_PER_MILLION_STROKES)):
            concerned = [(claim, axis) for claim in CLAIMS for axis in study.levels() if concerns(claim, axis, joint)]
            answers += judged(study, joint, concerned) + _unevenness(study, joint)
            answers += [answer for claim, axis in concerned for answer in _reasons(study, joint, axis)]
    if not answers:
        return []
    return [Section("wear-trends", "Trends of wear", [Points(_points(study, answers)), _trend_table(study, answers)])]


def concerns(claim: Claim, axis: Axis, joint: Joint) -> bool:
    """Return whether a claim is about this axis, in this joint or in the drive."""
    in_scope = axis.path.startswith(f"joints.{joint.title}.") or axis.path == "drive.speed"
    is_positive = axis.is_numeric and min(axis.values) > 0.0
    return in_scope and is_positive and axis.path.endswith(claim.path_endings)


def judged(study: Study, joint: Joint, concerned: list[tuple[Claim, Axis]]) -> list[Answer]:
    """Return the answers to claims, each at the level that Holm's procedure gives it.

    All claims share the probability of error; those that are decided leave it to the others (Holm 1979, Scand. J.
    Stat. 6:65).
    """
    answers: dict[int, Answer] = {}
    while len(answers) < len(concerned):
        remaining = [index for index in range(len(concerned)) if index not in answers]
        tried = {index: _answer_for_axis(study, joint, *concerned[index], len(remaining)) for index in remaining}
        decided = {index: answer for index, answer in tried.items() if answer.verdict != OPEN}
        answers |= decided or tried
    return [answers[index] for index in range(len(concerned))]


def _answer_for_axis(study: Study, joint: Joint, claim: Claim, axis: Axis, claims: int) -> Answer:
    """Return the answer to a claim, one of `claims`, from pairs of cases that differ only in the value of one axis."""
    table = match_cases(study, axis).table(positive_values(study, joint.column(WEAR_PER_MILLION_STROKES)))
    estimate, pairs = trend_exponent(table.levels, table.values, claims)
    bounds = sorted((claim.sign * estimate.low, claim.sign * estimate.high))
    measure = f"factor of the depth for twice the {axis.name}"
    return Answer(claim.title, joint, measure, _doubled(estimate), pairs, "pairs", _verdict(*bounds, border=0.0))


def _doubled(exponent: Estimate) -> Estimate:
    """Return the factor of a figure for twice the value, from its exponent."""
    return Estimate(*(2.0**value for value in exponent))


def _reasons(study: Study, joint: Joint, axis: Axis) -> list[Answer]:
    """Return how volume and pressure change with the value of a claim, which decide nothing."""
    matches, answers = match_cases(study, axis), []
    depth, per_strokes = (
        positive_values(study, joint.column(figure)) for figure in ("wear_depth_max", WEAR_PER_MILLION_STROKES)
    )
    for figure, name in REASONS:
        if not study.has(joint.column(figure)):
            continue
        values = positive_values(study, joint.column(figure))
        values = values * per_strokes / depth if figure == "wear_volume" else values  # of as many turns
        table = matches.table(values)
        estimate, pairs = trend_exponent(table.levels, table.values)
        measure = f"factor for twice the {axis.name}"
        answers.append(Answer(f"{name} with {axis.name}", joint, measure, _doubled(estimate), pairs, "pairs", NO_CLAIM))
    return answers


def _unevenness(study: Study, joint: Joint) -> list[Answer]:
    """Return the unevenness of the wear of each body."""
    most = 0 if joint.layout.flanked else MAX_CASES_READ
    case_ids = study.cases.index[study.cases[joint.column("wear_depth_max")] > 0.0][:most]
    depths = [[deepest_along_axis(depth) for depth in study.run.wear(case_id)[joint.name]] for case_id in case_ids]
    answers = []
    for index, body in enumerate(("bearing", "journal")):
        ratios = np.sort([depth[index].max() / depth[index].mean() for depth in depths if depth[index].max() > 0.0])
        if len(ratios):
            median = estimate_quantile(ratios, 0.5) if len(ratios) > 1 else Estimate(ratios[0], math.nan, math.nan)
            answer = _verdict(median.low, median.high, border=UNEVEN_RATIO)
            title = f"uneven round the {body}"
            answers.append(Answer(title, joint, "deepest over mean depth", median, len(ratios), "cases", answer))
    return answers


def _verdict(low: float, high: float, *, border: float) -> str:
    """Return the verdict on an interval: entirely above a border, below it, or neither."""
    return SHOWN if low > border else CONTRADICTED if high < border else OPEN


def _points(study: Study, answers: list[Answer]) -> list[str]:
    """Return one sentence for each answer."""
    sentences = []
    for verdict_word in (SHOWN, CONTRADICTED, OPEN):
        titles = [
            answer.title + study.joint_text(answer.joint, " ({})")
            for answer in answers
            if answer.verdict == verdict_word
        ]
        sentences += [f"{capitalise(verdict_word)}: {wording.sentence_list(titles)}."] if titles else []
    factors = [
        f"{answer.title}{study.joint_text(answer.joint, ' ({})')} {wording.number_text(answer.estimate.value)}"
        for answer in answers
        if answer.verdict == NO_CLAIM and math.isfinite(answer.estimate.value)
    ]
    return sentences + ([f"Reason, as factors of a doubling: {wording.sentence_list(factors)}."] if factors else [])


def _trend_table(study: Study, answers: list[Answer]) -> Table:
    columns = columns_of("wear is | joint | answer | measured | median | interval from | to | number | of")
    rows = [
        (title, joint.title, verdict, measure, *estimate, count_cell(number), counted)
        for title, joint, measure, estimate, number, counted, verdict in answers
    ]
    return Table("wear_trends", "Trends of wear in this run", NOTE, columns, rows)


# All cases at a glance: one figure over another, a point for each case.


def tradeoff_sections(study: Study) -> list[Section]:
    """Return the clouds of the peak over p99, output error and fastest onset, or [] for few cases."""
    if len(study.cases) < 3 or not study.is_driven or not study.joints:
        return []
    joint = study.most_loaded_joint()
    p99, peak, onset = (joint.column(figure) for figure in ("force_p99", "force_peak", "onset_rate_max"))
    p99_note = "Cases of equal p99 have different peaks: p99 ignores impacts shorter than 1 % of the time."
    error_name, error_note = f"{study.run.layout.output} error", "Points further down and to the left are better."
    clouds = (
        ("Force peak against p99", p99, "force p99", p99_note),
        ("Position error against force", study.column("error_max"), error_name, error_note),
        ("Force peak against onset rate", onset, "fastest onset", yield_speed_sentence(study, joint)),
    )
    strongest = next((effect.axis for effect in main_effects_of(study, peak)), None)
    pictures = [
        Picture(
            title,
            caption,
            f"Cloud of {len(study.cases)} cases: force peak over {name}.",
            _cloud_painter(study, strongest, (column, peak), (name, "force peak")),
        )
        for title, column, name, caption in clouds
        if study.cases.varies(column) and study.cases.varies(peak)
    ]
    return section("tradeoffs", "All cases at a glance", Gallery("Each point is a finished case.", pictures))


def _cloud_painter(
    study: Study, axis: Axis | None, columns: tuple[str, str], names: tuple[str, str]
) -> Callable[[Axes], None]:
    """Return the painter of the second of two columns over the first, coloured by the values of an axis, if any."""
    colour = axis and (study.indices_on(axis), axis)
    x, y = (study.cases[column] for column in columns)
    x, y, colour = comparison.without_covered_points(x, y, colour)
    if colour:
        colour = (np.where(colour[0] < 0, np.nan, colour[0]), colour[1])
    scales = (study.scale(columns[0]), study.scale(columns[1]))
    return lambda ax: comparison.draw_cloud(ax, x, y, colour, names, scales)
