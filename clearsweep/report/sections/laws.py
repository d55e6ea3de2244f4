"""Laws on the page: the choice of a swept law, `check_laws`, elastic laws and elastic links."""

import math

import numpy as np

from ... import simulation
from ...answers.verdict import MARGIN_COLUMN
from ...answers.words import case_margin_text
from ...contracts.case import Case
from ...language import wording
from ..axis import PEAK, Axis
from ..blocks.section import Part, Picture, Points, Section, Sentences, capitalise, section
from ..blocks.table import Column, Quantity, Table, columns_of, count_cell
from ..draw import BLUE, RED, comparison, label_with_unit, set_log_scale
from ..effects import MatchedCases, axis_key, main_effects_of, match_cases, positive_values
from ..laws import compare_allowed_laws, compare_restitutions, compare_swept_laws, compare_verdicts, ideal_load
from ..plot import Axes
from ..study import Joint, Study, answer_of_study, joint_with_laws, known, resolve_cases, worst_case

# Effect of the choice of a swept law: forces under each law, and the spread between laws at otherwise equal values.

#: Paths within a joint that name a law.
LAW_PATHS = (".contact.law", ".contact.elastic", ".roughness.law", ".friction.law")
FIGURES = (("force_peak", "force peak"), ("force_p99", "force p99"), ("force_rms", "force rms"))

MIN_RATIO = 1.05  # median ratio of the peaks under two laws from which the choice matters


def law_choice_sections(study: Study) -> list[Section]:
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
        law_comparison = compare_restitutions(study, axis, joint)
    elif axis.path.endswith((".contact.elastic", ".roughness.law")):
        law_comparison = compare_swept_laws(study, axis, joint)
    verdict = compare_verdicts(study, matched_cases)
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
        has_law = study.cases[axis.path] == law
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
    return Table(f"{axis_key(axis)}_{joint.name}", title, note, columns, rows)


def _ratios(study: Study, matched_cases: MatchedCases, column: str) -> dict[str, float]:
    """Return law -> median ratio of a figure to the median of all laws at otherwise equal values."""
    table = matched_cases.table(positive_values(study, column))
    ratios = table.values / np.nanmedian(table.values, axis=1, keepdims=True)
    return dict(zip(table.levels, np.nanmedian(ratios, axis=0), strict=True))


def _range_cells(values: np.ndarray, unit: str) -> list[Quantity | float]:
    """Return the cells of a figure: its median with its range in words, its smallest and its largest value."""
    known = values[~np.isnan(values)]
    low, median, high = (float(value) for value in np.quantile(known, (0.0, 0.5, 1.0))) if len(known) else [np.nan] * 3
    scale = wording.scale(unit, median)
    range_text = f" ({scale.number_text(low)} to {scale.number_text(high)})" if len(values) > 1 else ""
    return [Quantity(median, scale.text(median) + range_text), low, high]


def _spread_table(study: Study, matched_cases: MatchedCases) -> Table:
    """Return the table of the factors by which each figure differs between laws at otherwise equal values."""
    rows = []
    for joint in study.joints:
        for column, name in _figures(study, joint):
            table = matched_cases.table(positive_values(study, column))
            if not len(table.groups):
                continue
            factor = np.nanmax(table.values, axis=1) / np.nanmin(table.values, axis=1)
            row = int(factor.argmax())
            ends = [pick(table.values[row]) for pick in (np.nanargmin, np.nanargmax)]
            values, laws = table.values[row, ends].tolist(), table.levels[ends].tolist()
            case_id = study.cases.index[matched_cases.row(table.groups[row], laws[0])]
            setting = study.setting(case_id, omitted_axis=matched_cases.axis)
            extreme_cells: list[Quantity | str] = []
            extremes = wording.texts_in_common_unit(values, study.unit(column))
            for value, law, text in zip(values, laws, extremes, strict=True):
                extreme_cells += [Quantity(value, f"{text}, {law}"), law]
            factors = (float(np.median(factor)), float(factor.max()))
            rows.append((name, joint.title, count_cell(len(factor)), *factors, *extreme_cells, setting))
    columns = columns_of(
        "figure | joint | comparisons | factor, median | factor, largest | there: from [N] | law of the smallest* "
        "| to [N] | law of the largest* | at"
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
    known = ~np.isnan(study.cases[column])
    values = {law: study.cases[column][known & (study.cases[axis.path] == law)] for law in axis.values}
    groups = [(law, points) for law, points in values.items() if len(points)]
    groups.sort(key=lambda group: np.median(group[1]))
    scale = study.scale(column)
    title = f"{capitalise(name)} by {axis.name}{study.joint_text(joint, ', joint {}')}"
    medians = "; ".join(f"{law}: {scale.text(np.median(points))}" for law, points in groups)

    def paint(ax: Axes) -> None:
        for row, (_, points) in enumerate(groups):
            ax.plot(points / scale.factor, np.full(len(points), row), "o", color=BLUE, markersize=4.5, alpha=0.55)
            ax.plot(np.median(points) / scale.factor, row, "|", color=RED, markersize=11, markeredgewidth=2.2)
        all_points = np.concatenate([points for _, points in groups])
        if all_points.min() > 0.0 and all_points.max() > 4.0 * all_points.min():  # else a log axis has no ticks
            set_log_scale(ax, "x")
        comparison.label_rows(ax, [law for law, _ in groups])
        ax.xaxis.label = label_with_unit(name, scale)

    return Picture(
        title,
        "Each point is a case; the bar is the median.",
        f"{title}, medians. {medians}",
        paint,
        size=(4.2, 1.0 + 0.22 * len(groups)),
    )


def _plural_name(axis: Axis) -> str:
    return axis.name.replace("law", "laws", 1)


# The deciding case under the other valid laws of its joints, if the grid requests it (`check_laws`).


def law_check_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no law is checked."""
    points = [answer_of_study(study)["laws"]] if answer_of_study(study).get("laws") else []
    return section("law_check", "The deciding case under other laws", Points(points), _law_check_table(study))


def _value_text(study: Study, column: str, value: float) -> str:
    if math.isnan(value):
        return wording.DASH
    if column == MARGIN_COLUMN:
        return case_margin_text(value, study.limits, "" if value >= 0.0 else study.limits[0].column)
    if column.endswith("_life_hours"):
        return f"{wording.number_text(value)}{wording.BLANK}h"
    return wording.quantity_text(value, study.unit(column))


def _law_check_table(study: Study) -> Table:
    """Return the leading figure of the case under each law."""
    worst, columns = worst_case(study), columns_of("joint | law | of | figure | value | case_id")
    if worst is None or not study.law_checks:
        return Table("law_check", "", "", columns, [])
    rows = []
    for row in sorted(study.law_checks, key=lambda row: (math.isnan(row.value), row.value)):
        _, joint, _, family = row.path.split(".")
        value = Quantity(row.value, _value_text(study, row.column, row.value))
        kind = "elastic" if family == "elastic" else "contact"
        rows.append((joint, row.law, kind, row.column.replace("_", " "), value, row.case_id))
    (case_id, candidate) = worst
    column = candidate.columns[0]
    value_text = _value_text(study, column, float(study.cases.at(case_id, column)))
    note = f"With the laws of the grid: {value_text} (case {wording.short_id(case_id)})."
    return Table("law_check", "Results under each other valid law", note, columns, rows)


# Other elastic laws for a joint whose material allows several, and whose law is not swept.


def elastic_laws_sections(study: Study) -> list[Section]:
    """Return one section for each such joint."""
    if study.cases.empty:
        return []
    swept = {axis.path for axis in study.swept()}
    law_keys = ("contact.elastic", "roughness.law")
    joints = [joint for joint in study.joints if swept.isdisjoint(f"joints.{joint.title}.{key}" for key in law_keys)]
    return [
        Section(
            f"other_elastic_{joint.name}", f"What another elastic law would give in joint {joint.title}", part.blocks()
        )
        for joint in joints
        if (part := compare_allowed_laws(study, joint)) is not None
    ]


def recommendation_texts(study: Study) -> list[str]:
    """Return the laws that are recommended for each dry joint, by the load of its hardest case."""
    return simulation.recommended_texts(
        recommendation for joint in study.joints for recommendation in _joint_recommendations(study, joint)
    )


def _joint_recommendations(study: Study, joint: Joint) -> list[simulation.Recommendation]:
    if not study.is_driven or not study.has(joint.column(PEAK.figure)):
        return []
    hardest = study.cases.worst_case(joint.column(PEAK.figure))
    section = known(lambda: joint_with_laws(resolve_cases(study, [hardest])[0], joint))
    load = ideal_load(study, joint, hardest)
    return simulation.recommendations_for(section, load) if section and section.is_dry else []


# Elastic links: their stiffness and that of the contacts at their pins, and the effect of a rigid link on a peak.

RELATIVE_STEP = 1e-3  # of a penetration, for the slope of the elastic force
MIN_IMPACTS = 0.5  # per revolution: number of impacts from which a joint counts as impacting
STIFFNESS_KEY = "axial_stiffness"
Links = tuple[simulation.ElasticLink, ...]


def elastic_links_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no link is elastic."""
    if study.cases.empty or not study.joints:
        return []
    joint = study.most_loaded_joint()
    worst = study.worst(joint)
    case = known(lambda: resolve_cases(study, [worst])[0])
    links = simulation.elastic_links(case) if case else ()
    if not case or not links:
        return []
    stiffness_sentence, estimated_effect = _stiffness_sentences(study, joint, worst, case, links)
    effect = _computed_effect_text(study, joint, worst) or estimated_effect
    sentences = [text for text in (stiffness_sentence, effect, _bending_sentence(links)) if text]
    return section("elastic-links", "Elastic links", Sentences(sentences), _link_table(links))


def _stiffness_sentences(study: Study, joint: Joint, worst: str, case: Case, links: Links) -> tuple[str, str]:
    """Return the stiffness of a contact and of its links, and the effect of rigid links on an impact there."""
    links_at_joint = [link for link in links if joint.title in link.joints]
    contact = known(lambda: joint_with_laws(case, joint))
    depth = float(study.cases.at(worst, joint.column("penetration_max")))
    if not links_at_joint or not contact or not contact.is_dry or contact.is_guide or not depth > 0.0:
        return "", ""
    low, high = simulation.elastic_forces(contact, (depth * (1.0 - RELATIVE_STEP), depth * (1.0 + RELATIVE_STEP)))
    stiffness = (high - low) / (2.0 * RELATIVE_STEP * depth)
    stiffness_ratio = stiffness * sum(1.0 / link.stiffness for link in links_at_joint)
    names = wording.sentence_list([link.name for link in links_at_joint])
    verb = "has" if len(links_at_joint) == 1 else "together have"
    stiffness_sentence = (
        f"In joint {joint.title} the contact stiffness is {_stiffness_text(stiffness)} at the largest penetration, in "
        f"case {worst[:8]}. Along the line of its pins {names} {verb} a stiffness of "
        f"{_stiffness_text(stiffness / stiffness_ratio)}."
    )
    if study.cases.at(worst, joint.column("impacts_per_rev")) < MIN_IMPACTS:
        return stiffness_sentence, "Journal and bearing hardly separate there, so a rigid link changes the peak little."
    return stiffness_sentence, (
        "Impacts occur there. With rigid links such an impact would be at least "
        f"{wording.number_text(math.sqrt(1.0 + stiffness_ratio), 2)} times as hard: contact and link are two springs "
        f"in series. A case with ten times the {STIFFNESS_KEY} shows this effect."
    )


def _stiffness_text(stiffness: float) -> str:
    return f"{wording.number_text(1e-6 * stiffness)}{wording.BLANK}kN/mm"


def _computed_effect_text(study: Study, joint: Joint, worst: str) -> str:
    """Return the peaks of the cases that differ from the worst only in the stiffness of a link in words, or ''."""
    axis = next((axis for axis in study.swept() if axis.path.endswith(f".elastic.{STIFFNESS_KEY}")), None)
    if axis is None or not axis.is_numeric:
        return ""
    is_similar = np.ones(len(study.cases), dtype=bool)
    for other in study.swept():
        if other.path != axis.path:
            value_indices = study.indices_on(other)
            is_similar &= value_indices == value_indices[study.cases.row_of(worst)]
    similar_cases, column = list(study.cases.index[is_similar]), joint.column(PEAK.figure)
    if len(similar_cases) < 2:
        return ""
    similar_cases.sort(key=lambda case_id: float(study.cases.at(case_id, axis.path)))
    values = [axis.text(study.cases.at(case_id, axis.path)) for case_id in similar_cases]
    peaks = study.texts(*((case_id, column) for case_id in similar_cases))
    pairs = [f"{peak} at {value}" for peak, value in zip(peaks, values, strict=True)]
    return (
        f"With all other values as in this case, the force peak depends on {axis.name}: {wording.sentence_list(pairs)}."
    )


def _bending_sentence(links: Links) -> str:
    """Return the drive frequency relative to the bending of the links, which is neglected; '' if all bend."""
    link = max(links, key=lambda link: link.bending)
    if not link.bending:
        return ""
    return (
        f"The model neglects bending of links. The drive frequency is {wording.number_text(link.bending, 2)} times "
        "the first "
        f"bending frequency of {link.name}, modelled as a round steel bar. Up to 0.2 its deflection is nearly static."
    )


def _link_table(links: Links) -> Table:
    """Return the table of the links."""
    columns = columns_of(
        "link | segments | axial stiffness [N/m] | first axial mode [rad/s] | impedance [N*s/m] "
        "| speed over first bending mode"
    )
    rows = [
        (link.name, str(link.segments), link.stiffness, link.first_mode, link.impedance, link.bending) for link in links
    ]
    note = (
        "The case has the largest force peak. Both modes are those of the link alone, a uniform bar with free "
        "ends or pins."
    )
    return Table("elastic_links", "Elastic links", note, columns, rows)


def bending_links_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished or no link bends."""
    columns = [column.name for column in study.run.layout.columns if column.figure == "stress_max"]
    columns = [name for name in columns if study.has(name)]
    if study.cases.empty or not columns:
        return []
    worst_column = max(columns, key=study.cases.largest)
    worst = study.cases.worst_case(worst_column)
    links = known(lambda: simulation.bending_links(resolve_cases(study, [worst])[0]))
    if links is None:
        return []
    hardest = max(links, key=lambda link: link.ratio)
    name = worst_column.removesuffix("_stress_max")
    stress, deflection = (study.text(worst, column) for column in (worst_column, f"{name}_deflection_max"))
    setting = study.setting(worst)
    sentences = [
        f"The largest stress is {stress}, in {name.replace('_', '-')}{f' at {setting}' if setting else ''}. It "
        f"deflects by {deflection} there.",
        f"The drive turns at {wording.number_text(hardest.ratio, 2)} of the first bending rate of {hardest.name}. "
        "Above 0.5 the deflections leave the model.",
    ]
    return section("bending-links", "Links that bend", Sentences(sentences), _table(study, worst, links))


def _table(study: Study, worst: str, links: tuple[simulation.BendingLink, ...]) -> Table:
    """Return the table of the links in the case with the largest stress."""
    columns = columns_of("link | modes | first bending rate [rad/s] | drive over it | deflection [m] | stress [Pa]")
    rows = []
    for link in links:
        name = link.name.replace("-", "_")
        figures = (float(study.cases.at(worst, f"{name}_{figure}")) for figure in ("deflection_max", "stress_max"))
        rows.append((link.name, str(link.modes), link.rate, link.ratio, *figures))
    note = "The case has the largest stress, by bending and normal force at the worst of 11 stations."
    return Table("bending_links", "Links that bend", note, columns, rows)
