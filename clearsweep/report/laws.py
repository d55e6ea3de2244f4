"""Comparisons of laws in tables and pictures: elastic laws, restitution, and the designs that meet the limits."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .. import simulation
from ..answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN
from ..contracts import case
from ..contracts.case import value_at
from ..language import wording
from .axis import PEAK, Axis
from .blocks.section import Part, Picture
from .blocks.table import Column, Quantity, Table, columns_of, count_cell
from .draw import BLUE, GREEN, GREY, INK, ORANGE, PALE, PURPLE, RED, comparison, set_plain_axes
from .effects import MatchedCases, MatchedTable, axis_key
from .plot import Axes
from .study import Joint, Study, joint_with_laws, known, resolve_cases

# Compares the elastic laws in one joint: force over penetration, and the ratios of these forces.

UNKNOWN_LAW_TEXT = "Some laws of this run are of another version or of a law file, so their forces are not compared."
DEPTHS = (0.1e-6, 1e-6, 5e-6, 10e-6, 20e-6)  # m, at which forces are tabulated
REFERENCE_DEPTH = 1  # index in DEPTHS of the depth by which laws are ordered
VALID_VERDICT = (simulation.SUITABLE, "")  # verdict on a law without objection
CURVE_DEPTHS = np.geomspace(DEPTHS[0], DEPTHS[-1], 25)  # m, at which they are drawn
CURVE_COLOURS = (BLUE, RED, GREEN, ORANGE, PURPLE, "#56B4E9", INK)  # of many curves; the next seven are dashed
MIN_LABEL_LINES, LABEL_FONT_SIZE = 24, 6.5  # lines available for names next to a drawing; font size, points


def compare_swept_laws(study: Study, axis: Axis, joint: Joint) -> Part:
    """Return sentences, picture and table that compare the swept elastic or roughness laws of a joint.

    Each law is evaluated in the case that shares the most other axis values with the case of largest peak force.
    """
    hardest_case_id = study.cases.worst_case(joint.column(PEAK.figure))
    other_paths = [other.path for other in study.swept() if other is not axis]
    shared_axis_values = np.zeros(len(study.cases), int)
    for path in other_paths:
        shared_axis_values += study.cases[path] == study.cases.at(hardest_case_id, path)
    laws_with_cases = [law for law in axis.values if (study.cases[axis.path] == law).any()]
    closest_case_ids = [
        study.cases.index[np.where(study.cases[axis.path] == law, shared_axis_values, -1).argmax()]
        for law in laws_with_cases
    ]
    sections = known(lambda: [joint_with_laws(case, joint) for case in resolve_cases(study, closest_case_ids)])
    if sections is None:
        return Part([UNKNOWN_LAW_TEXT], [], [])
    section_by_law = dict(zip(laws_with_cases, sections, strict=True))
    verdicts = {
        law: _verdicts(study, joint, case_id, section_by_law[law]).get(law, VALID_VERDICT)
        for law, case_id in zip(laws_with_cases, closest_case_ids, strict=True)
    }
    return _law_comparison(joint, section_by_law, laws_with_cases, verdicts)


def compare_allowed_laws(study: Study, joint: Joint) -> Part | None:
    """Return the comparison of the elastic laws that the joint's material allows, in the case of largest peak force.

    Return None if the joint has no material, or if its material allows only one law.
    """
    path = f"joints.{joint.title}.contact.material"
    if value_at(study.base, path) is None and not any(axis.path.startswith(path) for axis in study.axes):
        return None
    hardest_case_id = study.cases.worst_case(joint.column(PEAK.figure))
    section = known(lambda: joint_with_laws(resolve_cases(study, [hardest_case_id])[0], joint))
    if section is None:
        return None
    sections = simulation.elastic_choices(section)
    verdicts = _verdicts(study, joint, hardest_case_id, section)
    return _law_comparison(joint, sections, [section.elastic_name], verdicts) if len(sections) > 1 else None


def ideal_load(study: Study, joint: Joint, case_id: str) -> float | None:
    """Return the largest reaction (N) of a joint of a case without clearance, or None if it is unknown."""
    column = joint.column("force_peak_ideal")
    load = float(study.cases.at(case_id, column)) if column in study.cases else np.nan
    return load if np.isfinite(load) else None


def _verdicts(study: Study, joint: Joint, case_id: str, section: case.Joint) -> dict[str, tuple[str, str]]:
    """Return elastic law -> verdict for a joint of a case, and its reason."""
    return simulation.elastic_ratings(section, ideal_load(study, joint, case_id))


def _law_comparison(
    joint: Joint, sections: dict[str, case.Joint], used_laws: list[str], verdicts: dict[str, tuple[str, str]]
) -> Part:
    """Return sentences, picture and table of elastic laws; `sections`: name -> section of the joint with that law.

    verdicts : name -> verdict and reason; valid laws come first in the table; valid laws and those in use are drawn
    """
    forces = {law: np.array(simulation.elastic_forces(section, DEPTHS)) for law, section in sections.items()}
    valid_laws = {law for law in sections if verdicts.get(law, VALID_VERDICT)[0] == VALID_VERDICT[0]}
    ordered_laws = sorted(forces, key=lambda law: (law not in valid_laws, forces[law][REFERENCE_DEPTH]))
    sentences = _elastic_sentences(joint.title, forces, [law for law in ordered_laws if law in valid_laws])
    drawn_laws = [law for law in ordered_laws if law in valid_laws or law in used_laws]
    table = _elastic_table(joint, sections, forces, ordered_laws, used_laws, verdicts)
    return Part(
        sentences, [_force_curves({law: sections[law] for law in drawn_laws}, used_laws)] if drawn_laws else [], [table]
    )


def _elastic_sentences(joint: str, forces: dict[str, np.ndarray], valid_laws: list[str]) -> list[str]:
    """Return sentences on the factor between the softest and the stiffest valid law of a joint, and of all laws."""
    if len(forces) < 2:
        return []
    values = np.array(list(forces.values()))
    depth_texts = [wording.scale("m", depth).exact_text(depth) for depth in DEPTHS]
    all_laws_factor = wording.number_text(
        float(values.max(axis=0)[REFERENCE_DEPTH] / values.min(axis=0)[REFERENCE_DEPTH])
    )
    doubtful_count = len(forces) - len(valid_laws)
    doubtful_laws_text = "doubtful one" if doubtful_count == 1 else f"{doubtful_count} doubtful ones"
    doubtful_text = f"With the {doubtful_laws_text}, the factor is {all_laws_factor}." if doubtful_count else ""
    if len(valid_laws) < 2:
        validity_text = f"only {valid_laws[0]} is valid" if valid_laws else "none is valid"
        return [
            f"Of {len(forces)} elastic laws {validity_text} in {joint}. Their forces differ by a factor of "
            f"{all_laws_factor}."
        ]
    valid_forces = np.array([forces[law] for law in valid_laws])
    factors = [wording.number_text(factor) for factor in valid_forces.max(axis=0) / valid_forces.min(axis=0)]
    other_factors = [
        f"{factor} at {depth}"
        for k, (factor, depth) in enumerate(zip(factors, depth_texts, strict=True))
        if k != REFERENCE_DEPTH
    ]
    softest_force, stiffest_force = wording.texts_in_common_unit(
        (forces[law][REFERENCE_DEPTH] for law in (valid_laws[0], valid_laws[-1])), "N"
    )
    return [
        f"The choice among {len(valid_laws)} valid elastic laws changes the force in {joint} up to "
        f"{factors[REFERENCE_DEPTH]} times at a penetration of {depth_texts[REFERENCE_DEPTH]}: {softest_force} "
        f"({valid_laws[0]}) to {stiffest_force} ({valid_laws[-1]}). {doubtful_text}".rstrip(),
        f"Among the valid laws, the factor is {wording.sentence_list(other_factors)}.",
    ]


def _elastic_table(
    joint: Joint,
    sections: dict[str, case.Joint],
    forces: dict,
    ordered_laws: list[str],
    used_laws: list[str],
    verdicts: dict[str, tuple[str, str]],
) -> Table:
    rows = []
    softest = min(forces[law][REFERENCE_DEPTH] for law in ordered_laws)
    for law in ordered_laws:
        limit = simulation.penetration_limit(sections[law])
        is_used_text = "yes" if law in used_laws else ""
        verdict_word, reason = verdicts.get(law, VALID_VERDICT)
        verdict_text = verdict_word if verdict_word == VALID_VERDICT[0] else f"{verdict_word}: {reason}"
        depth_limit = limit if np.isfinite(limit) else np.nan
        rows.append(
            (law, is_used_text, *forces[law], forces[law][REFERENCE_DEPTH] / softest, depth_limit, verdict_text)
        )
    depth_texts = [wording.scale("m", depth).exact_text(depth) for depth in DEPTHS]
    columns = [Column("elastic law"), Column("used here", file_only=len(used_laws) == len(sections))]
    columns += [Column(f"at {depth}", "N") for depth in depth_texts]
    columns += columns_of(f"at {depth_texts[REFERENCE_DEPTH]}, over the softest | valid up to [m] | in this joint")
    note = f'{_joint_text(sections[ordered_laws[0]])}. A dash under "valid up to" means any penetration.'
    title = f"Elastic force against penetration, joint {joint.title}"
    return Table(f"elastic_force_{joint.name}", title, note, columns, rows)


def _joint_text(section: case.Joint) -> str:
    """Return a description of the joint for which the forces are computed."""
    keys_by_word = (("radial clearance", "clearance"), ("bearing radius", "bearing_radius"), ("length", "length"))
    sizes = [(word, getattr(section, key)) for word, key in keys_by_word if getattr(section, key) is not None]
    facts = [f"{word} {wording.scale('m', size).exact_text(size, 4)}" for word, size in sizes]
    materials = section.contact.material
    if materials:
        bodies = {f" of the {body}": material for body, material in materials._asdict().items()}
        if materials.bearing == materials.journal:
            bodies = {"": materials.bearing}
        for owner, material in bodies.items():
            young = wording.scale("Pa", material.young).exact_text(material.young, 4)
            facts.append(f"Young's modulus{owner} {young}, Poisson's ratio{owner} {material.poisson:.4g}")
    return f"In the joint of the hardest case: {', '.join(facts)}"


def _force_curves(sections: dict[str, case.Joint], used_laws: list[str]) -> Picture:
    """Return the picture of force over penetration of elastic laws: name -> section of the joint with that law.

    Laws that are not used are grey, each with its name at the right end.
    """
    curves = {law: np.array(simulation.elastic_forces(section, CURVE_DEPTHS)) for law, section in sections.items()}
    by_last_force = sorted(curves, key=lambda law: -curves[law][-1])
    unused = [(law, curves[law][-1]) for law in by_last_force if law not in used_laws]

    def paint(ax: Axes) -> None:
        scale, used_count = wording.scale("m", CURVE_DEPTHS), 0
        for law in by_last_force:
            style: dict[str, Any] = {"color": PALE, "linewidth": 1.1, "zorder": 1}
            if law in used_laws:
                dash = ("-", "--", ":")[used_count // len(CURVE_COLOURS) % 3]
                colour = CURVE_COLOURS[used_count % len(CURVE_COLOURS)]
                style = {"color": colour, "linestyle": dash, "linewidth": 1.6, "label": law, "zorder": 2}
                used_count += 1
            ax.plot(CURVE_DEPTHS / scale.factor, curves[law], **style)
        ax.set_log("x", "y")
        ax.set_labels(f"penetration [{scale.unit}]", "elastic force [N]")
        ax.xaxis.formatter = ax.yaxis.formatter = lambda value: wording.short_number_text(value, 2)
        _label_curve_ends(ax, CURVE_DEPTHS[-1] / scale.factor, unused)
        set_plain_axes(ax)
        ax.set_legend("inside" if unused else "centre right", sample=2.4)

    forces = {law: simulation.elastic_forces(section, DEPTHS)[REFERENCE_DEPTH] for law, section in sections.items()}
    softest, stiffest = min(forces, key=forces.__getitem__), max(forces, key=forces.__getitem__)
    depth = wording.scale("m", DEPTHS[REFERENCE_DEPTH]).exact_text(DEPTHS[REFERENCE_DEPTH])
    alt = f"At {depth} {softest} is the softest law and {stiffest} the stiffest."
    if len(forces) < 2:
        alt = f"Force of {softest} against penetration."
    return Picture("Elastic force against penetration", "", alt, paint, size=(4.6, 3.4))


def _label_curve_ends(ax: Axes, depth: float, curve_ends: Sequence[tuple[str, float]]) -> None:
    """Label curves at their right ends (at `depth` on the axis, force in N), each label on its own line."""
    curve_ends = sorted(curve_ends, key=lambda end: end[1])
    low, high = np.log(ax.yaxis.limits())
    edge = float(ax.xaxis.fraction(depth))
    spacing = (high - low) / max(len(curve_ends), MIN_LABEL_LINES)
    heights = [float(np.log(force)) for _, force in curve_ends]
    for k in range(1, len(heights)):
        heights[k] = max(heights[k], heights[k - 1] + spacing)
    for k in reversed(range(len(heights))):
        heights[k] = min(heights[k], high - spacing * (len(heights) - k - 0.5))
    for (name, force), height in zip(curve_ends, heights, strict=True):
        place = (1.06, float(np.exp(height)))
        ax.leader((edge, force), place, color=PALE, linewidth=0.5)
        ax.text(*place, name, spans_width=True, va="center", colour=GREY, size=LABEL_FONT_SIZE)


# Specified and effective restitution of laws.

MAX_VALUES = 5  # largest number of displayed values of the restitution, evenly spaced
MIN_DIFFERENCE = 5e-4  # smaller differences of restitution count as equal


class EffectiveRestitution(NamedTuple):
    """Effective restitution of a law in a free impact."""

    law: str
    specified: float  # NaN for a law without this parameter
    effective: float  # NaN if it depends on mass and speed
    measured: float  # median of the cases; NaN without measurement

    @property
    def difference(self) -> float:
        """Return the effective minus the specified restitution."""
        return self.effective - self.specified


def compare_restitutions(study: Study, axis: Axis, joint: Joint) -> Part:
    """Return sentence, picture and table of the swept laws of a joint."""
    # Law and specified restitution of each case
    path = f"joints.{joint.title}.contact.restitution"
    laws = study.cases[axis.path]
    specified = np.asarray(study.cases.get(path, value_at(study.base, path)), float) + np.zeros(len(laws))
    values = np.unique(specified[~np.isnan(specified)])
    evenly = np.linspace(0, max(len(values) - 1, 0), MAX_VALUES).round().astype(int)
    displayed = {None, *(values[np.unique(evenly)] if len(values) else values)}
    points = [(law, None if np.isnan(value) else value) for law, value in zip(laws, specified.tolist(), strict=True)]
    representatives = {point: row for row, point in reversed([*enumerate(points)]) if point[1] in displayed}
    representatives = dict(sorted(representatives.items(), key=lambda entry: entry[1]))
    case_ids = study.cases.index[list(representatives.values())]
    sections = known(lambda: [joint_with_laws(case, joint) for case in resolve_cases(study, case_ids)])
    if sections is None:
        return Part([UNKNOWN_LAW_TEXT], [], [])
    rows = []
    for point, section in zip(representatives, sections, strict=True):
        effective = simulation.restitution(section)
        rows.append(
            EffectiveRestitution(
                point[0],
                section.contact.values.get("restitution", np.nan),
                np.nan if effective is None else effective,
                _measured_restitution(study, joint, np.array([each == point for each in points], bool)),
            )
        )
    rows.sort(key=lambda row: (np.isnan(row.specified), row.specified, axis.values.index(row.law)))
    valued_rows = [row for row in rows if not np.isnan(row.effective)]
    return Part(
        _restitution_sentences(rows),
        [_picture(axis, valued_rows)] if valued_rows else [],
        [_restitution_table(study, axis, joint, rows)],
    )


def _measured_restitution(study: Study, joint: Joint, is_chosen: np.ndarray) -> float:
    """Return the median of the measured restitution of some cases, or NaN if none was measured."""
    if not study.has(joint.column("restitution")):
        return np.nan
    measured = study.cases[joint.column("restitution")][is_chosen]
    known = measured[~np.isnan(measured)]
    return float(np.median(known)) if len(known) else np.nan


def _restitution_table(study: Study, axis: Axis, joint: Joint, rows: list[EffectiveRestitution]) -> Table:
    columns = columns_of(f"{axis.name} | specified | computed | difference")
    cells: list[tuple] = []
    for row in rows:
        difference = f"{row.difference:+.4f}".replace("-", wording.MINUS).replace("+nan", wording.DASH)
        cells.append((row.law, row.specified, row.effective, Quantity(row.difference, difference)))
    if study.has(joint.column("restitution")):
        columns.append(Column("measured here"))
        cells = [(*cell, row.measured) for cell, row in zip(cells, rows, strict=True)]
    note = (
        f"The values follow in closed form for a free impact; the elastic law has no effect. A dash ({wording.DASH}) "
        "means that the law has no restitution, or that it depends on mass and speed (kelvin-voigt and others)."
    )
    key = f"{axis_key(axis)}_restitution"
    return Table(key, "Specified and computed restitution", note, columns, cells)


def _restitution_sentences(rows: list[EffectiveRestitution]) -> list[str]:
    """Return sentences on the largest difference between laws with the same specified restitution."""
    ranges = []
    for specified in {row.specified for row in rows if not np.isnan(row.specified)}:
        known = [row for row in rows if row.specified == specified and not np.isnan(row.effective)]
        if known:
            ordered = sorted(known, key=lambda row: (row.effective, row.law))
            ranges.append((ordered[-1].effective - ordered[0].effective, ordered[0], ordered[-1]))
    if not ranges:
        return []
    widest, lowest, highest = max(ranges, key=lambda entry: (entry[0], entry[1].specified))
    if widest < MIN_DIFFERENCE:
        return [
            "In a free impact these laws do not differ: each gives the specified restitution, or all give the same "
            "value."
        ]
    return [
        f"With a specified restitution of {wording.short_number_text(lowest.specified, 3)}, a free impact has a "
        f"restitution of {wording.number_text(lowest.effective)} ({lowest.law}) to "
        f"{wording.number_text(highest.effective)} ({highest.law})."
    ]


def _picture(axis: Axis, rows: list[EffectiveRestitution]) -> Picture:
    """Return the picture of the specified and the effective restitution by law."""
    names = list(dict.fromkeys(row.law for row in rows))[::-1]

    def paint(ax: Axes) -> None:
        open_circle: dict[str, Any] = {"markerfacecolor": "#ffffff", "color": INK, "markersize": 6}
        for number, row in enumerate(rows):
            position, labels = names.index(row.law), ("", "") if number else ("specified", "computed")
            ends = [row.specified, row.effective]
            ax.plot(ends, [position, position], "-", color=GREY, linewidth=1.2, zorder=1)
            ax.plot(row.specified, position, "o", label=labels[0], **open_circle)
            ax.plot(row.effective, position, "D", color=RED, markersize=4.5, label=labels[1])
        comparison.label_rows(ax, names)
        ax.xaxis.label = "restitution"
        ax.set_legend("above", columns=2)

    texts = "; ".join(f"{row.law}, specified {row.specified:.3g}: {row.effective:.3g}" for row in rows)
    caption = "Computed for a free impact, and compared with the specified restitution."
    size = (4.2, 1.15 + 0.22 * len(names))
    return Picture("Restitution of a free impact", caption, f"Restitution by {axis.name}. {texts}", paint, size)


# Effect of the choice of a law on the designs that meet the limits.


def compare_verdicts(study: Study, matched_cases: MatchedCases) -> Part:
    """Return how the laws on an axis change the verdict at otherwise equal values; an empty Part without limits."""
    if EXCEEDED_COLUMN not in study.cases:
        return Part([], [], [])
    fails = (study.cases[EXCEEDED_COLUMN] != "").astype(float)
    table = matched_cases.table(fails, largest=True)
    if not len(table.groups):
        return Part([], [], [])
    verdict_table = _verdict_table(study, matched_cases, fails, np.isin(matched_cases.groups, table.groups))
    return Part([_sentence(study, matched_cases, table)], [], [verdict_table])


def _sentence(study: Study, matched_cases: MatchedCases, table: MatchedTable) -> str:
    """Return a sentence on the number of designs whose verdict depends on the law, and where."""
    most, least = np.nanmax(table.values, axis=1), np.nanmin(table.values, axis=1)
    changed = np.flatnonzero(most > least)
    designs_text = wording.count_text(len(table.groups), "design")
    if not len(changed):
        common_verdict = "meets the limits" if not most.max() else "exceeds a limit" if least.min() else ""
        reason = (
            f"each {common_verdict} with every law"
            if common_verdict
            else "each meets the limits with all laws, or with none"
        )
        return f"The choice of {matched_cases.axis.name} does not change the verdict on {designs_text}: {reason}."
    meeting, exceeding = (table.levels[table.values[changed[0]] == exceeds].tolist() for exceeds in (0.0, 1.0))
    case_id = study.cases.index[matched_cases.row(table.groups[changed[0]], exceeding[0])]
    setting = study.setting(case_id, omitted_axis=matched_cases.axis)
    setting_text = f" at {setting}" if setting else ""
    example = (
        f"they are met with {wording.sentence_list(meeting)} and exceeded with "
        f"{wording.sentence_list(exceeding)}{setting_text}"
    )
    changed_count = f"{len(changed)} of {designs_text}"
    name = matched_cases.axis.name
    return f"The choice of {name} decides whether {changed_count} meet the limits. For example, {example}."


def _verdict_table(study: Study, matched_cases: MatchedCases, fails: np.ndarray, is_compared: np.ndarray) -> Table:
    """Return, for each law, the number of designs that exceed a limit, and their margins.

    fails : (cases,); is_compared : (pairs,) whether the group of a pair is compared
    """
    rows = []
    for law in matched_cases.axis.values:
        cases = matched_cases.rows[is_compared & (study.cases[matched_cases.axis.path][matched_cases.rows] == law)]
        if len(cases):
            margins = study.cases[MARGIN_COLUMN][cases]
            finite = margins[np.isfinite(margins)]
            margin_cells = (float(finite.min()), float(np.median(finite))) if len(finite) else (np.nan, np.nan)
            rows.append((law, count_cell(len(cases)), count_cell(int(fails[cases].sum())), *margin_cells))
    name = matched_cases.axis.name
    columns = columns_of(f"{name} | designs | that exceed a limit | smallest margin | median margin")
    note = (
        "The table lists the designs that finished with at least two of the laws. The margin is defined as in the "
        "verdict."
    )
    return Table(f"{axis_key(matched_cases.axis)}_verdict", f"The verdict, by {name}", note, columns, rows)
