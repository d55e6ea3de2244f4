"""Effect of the choice of a swept law: forces under each law, and the spread between laws at otherwise equal values."""

import numpy as np
import pandas as pd

from ...language import wording
from ..blocks.picture import Picture, capitalise
from ..blocks.section import Part, Section
from ..blocks.table import Column, Quantity, Table, count_cell
from ..data.axis import Axis
from ..data.study import Joint, Study
from ..draw import comparison
from ..laws import elastic_comparison, law_verdict, restitution_comparison
from ..statistics.main_effects import main_effects_of
from ..statistics.matching import MatchedCases, axis_key, match_cases

LAW_PATHS = (
    ".contact.law",
    ".contact.elastic",
    ".roughness.law",
    ".friction.law",
)  # paths within a joint that name a law
FIGURES = (("force_peak", "force peak"), ("force_p99", "force p99"), ("force_rms", "force rms"))

MIN_RATIO = 1.05  # median ratio of the peaks under two laws from which the choice matters


def sections(study: Study) -> list[Section]:
    """Return one section for each law that is swept."""
    if study.cases.empty:
        return []
    return [_section(study, axis) for axis in study.swept() if axis.path.endswith(LAW_PATHS)]


def _section(study: Study, axis: Axis) -> Section:
    matched_cases = match_cases(study, axis)
    joint = next(joint for joint in study.joints if axis.path.startswith(f"joints.{joint.title}."))
    spread = _spread_table(study, matched_cases)
    law_comparison = Part([], [], [])
    if axis.path.endswith(".contact.law"):
        law_comparison = restitution_comparison.compare_restitutions(study, axis, joint)
    elif axis.path.endswith((".contact.elastic", ".roughness.law")):
        law_comparison = elastic_comparison.compare_swept_laws(study, axis, joint)
    verdict = law_verdict.compare_verdicts(study, matched_cases)
    strip_plots = [
        _strip_plot(study, axis, joint_of_run, *figure)
        for joint_of_run in study.joints
        for figure in _figures(study, joint_of_run)
    ]
    part = Part(
        [*verdict.sentences, _spread_sentence(study, axis, spread), *law_comparison.sentences],
        [*strip_plots, *law_comparison.pictures],
        [
            *verdict.tables,
            spread,
            *(_force_table(study, matched_cases, joint_of_run) for joint_of_run in study.joints),
            *law_comparison.tables,
        ],
    )
    return Section(axis_key(axis), f"Effect of the choice of {axis.name}", part.blocks())


def _figures(study: Study, joint: Joint) -> list[tuple[str, str]]:
    """Return column and name of the compared forces of a joint; p99 is left out without a drive."""
    columns = [(joint.column(figure), name) for figure, name in FIGURES if study.is_driven or figure != "force_p99"]
    return [(column, name) for column, name in columns if study.has(column)]


def _force_table(study: Study, matched_cases: MatchedCases, joint: Joint) -> Table:
    """Return the table of the forces of one joint, law by law."""
    axis, figures = matched_cases.axis, _figures(study, joint)
    columns = [Column(axis.name), Column("cases")]
    for column, name in figures:
        unit = study.unit(column)
        columns += [
            Column(name, unit),
            Column(f"{name}, smallest", unit, file_only=True),
            Column(f"{name}, largest", unit, file_only=True),
            Column(f"{name.removeprefix('force ')} with other laws"),
        ]
    ratios = {column: _ratios(study, matched_cases, column) for column, _ in figures}
    rows = []
    for law in axis.values:
        has_law = (study.cases[axis.path] == law).to_numpy()
        if has_law.any() and figures:
            cells: list[Quantity | float] = []
            for column, _ in figures:
                range_cells = _range_cells(study.cases[column][has_law], study.unit(column))
                cells += [*range_cells, float(ratios[column].get(law, np.nan))]
            rows.append((law, count_cell(int(has_law.sum())), *cells))
    note = (
        "Each force is the median (smallest to largest) of all finished cases with the law. For the comparison with "
        "other laws, it is divided by the median of all laws at otherwise equal values. The table shows the median of "
        "these ratios."
    )
    title = f"Forces in joint {joint.title}, by {axis.name}"
    return Table(f"{axis_key(axis)}_{joint.name}", title, note, tuple(columns), rows)


def _ratios(study: Study, matched_cases: MatchedCases, column: str) -> pd.Series:
    """Return law -> median ratio of a figure to the median of all laws at otherwise equal values."""
    table = matched_cases.table(study, column)
    return table.div(table.median(axis=1), axis=0).median()


def _range_cells(values: pd.Series, unit: str) -> list[Quantity | float]:
    """Return the cells of a figure: its median with its range in words, its smallest and its largest value."""
    low, median, high = values.min(), values.median(), values.max()
    scale = wording.scale(unit, median)
    range_text = f" ({scale.number_text(low)} to {scale.number_text(high)})" if len(values) > 1 else ""
    return [Quantity(median, scale.text(median) + range_text), low, high]


def _spread_table(study: Study, matched_cases: MatchedCases) -> Table:
    """Return the table of the factors by which each figure differs between laws at otherwise equal values."""
    rows = []
    for joint in study.joints:
        for column, name in _figures(study, joint):
            table = matched_cases.table(study, column)
            if table.empty:
                continue
            factor = table.max(axis=1) / table.min(axis=1)
            worst = table.loc[factor.idxmax()].dropna()
            weakest, strongest = worst.idxmin(), worst.idxmax()
            setting = study.setting(matched_cases.case_id(factor.idxmax(), weakest), omitted_axis=matched_cases.axis)
            extreme_cells: list[Quantity | str] = []
            extremes = wording.texts_in_common_unit((worst[law] for law in (weakest, strongest)), study.unit(column))
            for law, text in zip((weakest, strongest), extremes, strict=True):
                extreme_cells += [Quantity(worst[law], f"{text}, {law}"), law]
            factors = (float(factor.median()), float(factor.max()))
            rows.append((name, joint.title, count_cell(len(table)), *factors, *extreme_cells, setting))
    columns = (
        Column("figure"),
        Column("joint"),
        Column("comparisons"),
        Column("factor, median"),
        Column("factor, largest"),
        Column("there: from", "N"),
        Column("law of the smallest", file_only=True),
        Column("to", "N"),
        Column("law of the largest", file_only=True),
        Column("at"),
    )
    note = "The factor is the largest over the smallest value among the laws, at otherwise equal values."
    title = f"Spread between the {_plural_name(matched_cases.axis)}"
    return Table(f"{axis_key(matched_cases.axis)}_spread", title, note, columns, rows)


def _spread_sentence(study: Study, axis: Axis, spread: Table) -> str:
    """Return a sentence on the spread in the joint with the largest force."""
    most_loaded = study.most_loaded_joint()
    rows = {name: cells for name, title, *cells in spread.rows if title == most_loaded.title}
    if "force peak" not in rows:
        return f"No two finished cases differ only in the {axis.name}, so this section compares unlike cases."
    factors = [
        f"the {name} by a factor of {wording.number_text(median)} (at most {wording.number_text(largest)})"
        for name, (_, median, largest, *_) in rows.items()
    ]
    joint_text = study.joint_text(most_loaded, " in joint {}")
    comparisons, median, *_ = rows["force peak"]
    sentence = (
        f"At otherwise equal values the choice among {len(axis.values)} {_plural_name(axis)} changes "
        f"{wording.sentence_list(factors)}{joint_text}"
    )
    sentence += f", the median of {comparisons.value} comparisons." if comparisons.value > 1 else "."
    effects = main_effects_of(study, most_loaded.column("force_peak"))
    effect = next((effect for effect in effects if effect.axis is axis), None)
    if effect is not None and effect.verdict != "differs" and median >= MIN_RATIO:
        sentence += (
            " The change of the peak is within the scatter, because a peak is a single event. To compare laws, use "
            "p99 or rms instead."
        )
    return sentence


def _strip_plot(study: Study, axis: Axis, joint: Joint, column: str, name: str) -> Picture:
    """Return the drawing of one point per case, law by law."""
    values = {law: study.cases[column][study.cases[axis.path] == law].dropna().to_numpy() for law in axis.values}
    groups = [(law, points) for law, points in values.items() if len(points)]
    groups.sort(key=lambda group: np.median(group[1]))
    scale = study.scale(column)
    title = f"{capitalise(name)} by {axis.name}{study.joint_text(joint, ', joint {}')}"
    medians = "; ".join(f"{law}: {scale.text(np.median(points))}" for law, points in groups)
    return Picture(
        title,
        "Each point is a case; the bar is the median.",
        f"{title}, medians. {medians}",
        lambda ax: comparison.draw_strip(ax, groups, name, scale),
        size=(4.2, 1.0 + 0.22 * len(groups)),
    )


def _plural_name(axis: Axis) -> str:
    return axis.name.replace("law", "laws", 1)
