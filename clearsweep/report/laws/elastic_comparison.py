"""Compares the elastic laws in one joint: force over penetration, and the ratios of these forces."""

import numpy as np
import pandas as pd

from ... import simulation
from ...contracts import case
from ...language import wording
from ...language.errors import InputError
from ..blocks.picture import Picture
from ..blocks.section import Part
from ..blocks.table import Column, Table
from ..data.axis import Axis
from ..data.dotted_paths import value_at
from ..data.leading import PEAK
from ..data.study import Joint, Study, joint_of, resolve_cases
from ..draw import comparison

UNKNOWN_LAW_TEXT = "This version does not know every law of this run, so it does not compare their forces."
DEPTHS = (0.1e-6, 1e-6, 5e-6, 10e-6, 20e-6)  # m, at which forces are tabulated
REFERENCE_DEPTH = 1  # index in DEPTHS of the depth by which laws are ordered
VALID_VERDICT = (simulation.SUITABLE, "")  # verdict on a law without objection
CURVE_DEPTHS = np.geomspace(DEPTHS[0], DEPTHS[-1], 25)  # m, at which they are drawn


def compare_swept_laws(study: Study, axis: Axis, joint: Joint) -> Part:
    """Return sentences, picture and table that compare the swept elastic or roughness laws of a joint.

    Each law is evaluated in the case that shares the most other axis values with the case of largest peak force.
    """
    hardest_case_id = study.cases[joint.column(PEAK.figure)].idxmax()
    other_paths = [other.path for other in study.swept() if other is not axis]
    shared_axis_values = pd.Series(0, study.cases.index)
    for path in other_paths:
        shared_axis_values += study.cases[path] == study.cases.at[hardest_case_id, path]
    laws_with_cases = [law for law in axis.values if (study.cases[axis.path] == law).any()]
    closest_case_ids = [shared_axis_values[study.cases[axis.path] == law].idxmax() for law in laws_with_cases]
    try:
        sections = [joint_of(resolved_case, joint) for resolved_case in resolve_cases(study, closest_case_ids)]
    except InputError:
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
    hardest_case_id = study.cases[joint.column(PEAK.figure)].idxmax()
    try:
        section = joint_of(resolve_cases(study, [hardest_case_id])[0], joint)
    except InputError:  # laws of another version
        return None
    sections = simulation.elastic_choices(section)
    verdicts = _verdicts(study, joint, hardest_case_id, section)
    return _law_comparison(joint, sections, [section.elastic_name], verdicts) if len(sections) > 1 else None


def ideal_load(study: Study, joint: Joint, case_id: str) -> float | None:
    """Return the largest reaction (N) of a joint of a case without clearance, or None if it is unknown."""
    column = joint.column("force_peak_ideal")
    load = float(study.cases.at[case_id, column]) if column in study.cases else np.nan
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
    sentences = _sentences(forces, [law for law in ordered_laws if law in valid_laws])
    drawn_laws = [law for law in ordered_laws if law in valid_laws or law in used_laws]
    table = _table(joint, sections, forces, ordered_laws, used_laws, verdicts)
    return Part(
        sentences, [_force_curves({law: sections[law] for law in drawn_laws}, used_laws)] if drawn_laws else [], [table]
    )


def _sentences(forces: dict[str, np.ndarray], valid_laws: list[str]) -> list[str]:
    """Return sentences on the factor between the softest and the stiffest valid law, and between all laws."""
    if len(forces) < 2:
        return []
    values, depth_texts = (
        np.array(list(forces.values())),
        [wording.scale("m", depth).exact_text(depth) for depth in DEPTHS],
    )
    all_laws_factor = wording.number_text(
        float(values.max(axis=0)[REFERENCE_DEPTH] / values.min(axis=0)[REFERENCE_DEPTH])
    )
    doubtful_count = len(forces) - len(valid_laws)
    doubtful_laws_text = "doubtful one" if doubtful_count == 1 else f"{doubtful_count} doubtful ones"
    doubtful_text = f"With the {doubtful_laws_text}, the factor is {all_laws_factor}." if doubtful_count else ""
    if len(valid_laws) < 2:
        validity_text = f"only {valid_laws[0]} is valid" if valid_laws else "none is valid"
        return [
            f"Of {len(forces)} elastic laws {validity_text} in this joint. Their forces differ by a factor of "
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
        f"At a penetration of {depth_texts[REFERENCE_DEPTH]} the {len(valid_laws)} elastic laws that are valid in "
        "this joint differ by a "
        f"factor of {factors[REFERENCE_DEPTH]}: {softest_force} ({valid_laws[0]}) to {stiffest_force} "
        f"({valid_laws[-1]}). "
        f"{doubtful_text}".rstrip(),
        f"Among the valid laws, the factor is {wording.sentence_list(other_factors)}.",
    ]


def _table(
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
    columns = (
        Column("elastic law"),
        Column("used here", file_only=len(used_laws) == len(sections)),
        *(Column(f"at {depth}", "N") for depth in depth_texts),
        Column(f"at {depth_texts[REFERENCE_DEPTH]}, over the softest"),
        Column("valid up to", "m"),
        Column("in this joint"),
    )
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
    """Return the picture of force over penetration of elastic laws: name -> section of the joint with that law."""
    curves = {law: np.array(simulation.elastic_forces(section, CURVE_DEPTHS)) for law, section in sections.items()}
    by_last_force = sorted(curves, key=lambda law: -curves[law][-1])
    drawn_curves = [(law, curves[law], law in used_laws) for law in by_last_force]
    forces = {law: simulation.elastic_forces(section, DEPTHS)[REFERENCE_DEPTH] for law, section in sections.items()}
    softest, stiffest = min(forces, key=forces.__getitem__), max(forces, key=forces.__getitem__)
    depth = wording.scale("m", DEPTHS[REFERENCE_DEPTH]).exact_text(DEPTHS[REFERENCE_DEPTH])
    alt = f"At {depth} {softest} is the softest law and {stiffest} the stiffest."
    if len(forces) < 2:
        alt = f"Force of {softest} against penetration."
    return Picture(
        "Elastic force against penetration",
        "",
        alt,
        lambda ax: comparison.draw_elastic_forces(ax, CURVE_DEPTHS, drawn_curves),
        size=(4.6, 3.4),
    )
