"""Elastic laws with each other in one joint: force over penetration, and how far apart they are."""

import numpy as np
import pandas as pd

from .. import simulation
from ..contracts import case
from ..language import wording
from ..language.errors import InputError
from .axis import Axis
from .dotted import dig
from .draw import comparison
from .leading import PEAK
from .picture import Picture
from .section import Part
from .study import Joint, Study, joint_of, resolved
from .table import Column, Table

UNKNOWN = "This version does not know every law of this run: what each by itself would do is not said."
DEPTHS = (0.1e-6, 1e-6, 5e-6, 10e-6, 20e-6)  # m, at which forces are tabulated
FIRST = 1  # place of the depth that the sentence begins with
HOLDING = (simulation.HOLDS, "")  # verdict on a law without objection
CURVE = np.geomspace(DEPTHS[0], DEPTHS[-1], 25)  # m, at which they are drawn


def of_axis(study: Study, axis: Axis, joint: Joint) -> Part:
    """Return what there is to say of the swept elastic or roughness laws of a joint.

    Each is taken in its case closest to the hardest.
    """
    hardest = study.cases[joint.column(PEAK.figure)].idxmax()
    others = [other.path for other in study.swept() if other is not axis]
    alike = pd.Series(0, study.cases.index)
    for path in others:
        alike += study.cases[path] == study.cases.at[hardest, path]
    there = [law for law in axis.values if (study.cases[axis.path] == law).any()]
    closest = [alike[study.cases[axis.path] == law].idxmax() for law in there]
    try:
        sections = [joint_of(alone, joint) for alone in resolved(study, closest)]
    except InputError:
        return Part([UNKNOWN], [], [])
    by_law = dict(zip(there, sections, strict=True))
    cases = dict(zip(there, closest, strict=True))
    words = {law: _words(study, joint, cases[law], by_law[law]).get(law, HOLDING) for law in there}
    return _beside(joint, by_law, there, words)


def of_material(study: Study, joint: Joint) -> Part | None:
    """Return what the elastic laws would give in the hardest case that its material allows; None without one."""
    path = f"joints.{joint.title}.contact.material"
    if dig(study.base, path) is None and not any(axis.path.startswith(path) for axis in study.axes):
        return None
    hardest = study.cases[joint.column(PEAK.figure)].idxmax()
    try:
        section = joint_of(resolved(study, [hardest])[0], joint)
    except InputError:  # laws of another version
        return None
    sections = simulation.elastic_choices(section)
    words = _words(study, joint, hardest, section)
    return _beside(joint, sections, [section.elastic_name], words) if len(sections) > 1 else None


def load_of(study: Study, joint: Joint, case_id: str) -> float | None:
    """Return the largest reaction (N) of a joint of a case without clearance, None where there is none."""
    column = joint.column("force_peak_ideal")
    load = float(study.cases.at[case_id, column]) if column in study.cases else np.nan
    return load if np.isfinite(load) else None


def _words(study: Study, joint: Joint, case_id: str, section: case.Joint) -> dict[str, tuple[str, str]]:
    """Return elastic law -> verdict for a joint of a case, and its reason."""
    return simulation.elastic_words(section, load_of(study, joint, case_id))


def _beside(joint: Joint, sections: dict[str, case.Joint], used: list[str], words: dict[str, tuple[str, str]]) -> Part:
    """Return sentence, picture and table of elastic laws; `sections`: name -> section of the joint with that law.

    words : name -> verdict and reason; valid laws come first and are drawn, and those in use
    """
    forces = {law: np.array(simulation.elastic_forces(section, DEPTHS)) for law, section in sections.items()}
    holding = {law for law in sections if words.get(law, HOLDING)[0] == HOLDING[0]}
    ordered = sorted(forces, key=lambda law: (law not in holding, forces[law][FIRST]))
    sentences = _sentences(forces, [law for law in ordered if law in holding])
    drawn = [law for law in ordered if law in holding or law in used]
    table = _table(joint, sections, forces, ordered, used, words)
    return Part(sentences, [_curves(sections, drawn, used)] if drawn else [], [table])


def _sentences(forces: dict[str, np.ndarray], holding: list[str]) -> list[str]:
    """Return by which factor the laws that hold differ, from the softest to the stiffest, then all of them."""
    if len(forces) < 2:
        return []
    values, at = np.array(list(forces.values())), [wording.scale("m", depth).given(depth) for depth in DEPTHS]
    all_laws = wording.plain(float(values.max(axis=0)[FIRST] / values.min(axis=0)[FIRST]))
    doubtful = len(forces) - len(holding)
    rest = f"With the {doubtful} doubtful ones it is {all_laws}." if doubtful else ""
    if len(holding) < 2:
        alone = f"only {holding[0]} is valid" if holding else "none is valid"
        return [f"Of {len(forces)} elastic laws {alone} in this joint; together they differ by a factor of {all_laws}."]
    own = np.array([forces[law] for law in holding])
    factors = [wording.plain(factor) for factor in own.max(axis=0) / own.min(axis=0)]
    more = [f"{factor} at {depth}" for k, (factor, depth) in enumerate(zip(factors, at, strict=True)) if k != FIRST]
    least, most = wording.in_common_unit((forces[law][FIRST] for law in (holding[0], holding[-1])), "N")
    return [
        f"At a penetration of {at[FIRST]} the {len(holding)} elastic laws that hold in this joint differ by a factor "
        f"of {factors[FIRST]}: {least} ({holding[0]}) to {most} ({holding[-1]}). {rest}".rstrip(),
        f"Among those that hold the factor is {wording.sentence_list(more)}.",
    ]


def _table(
    joint: Joint,
    sections: dict[str, case.Joint],
    forces: dict,
    ordered: list[str],
    used: list[str],
    words: dict[str, tuple[str, str]],
) -> Table:
    rows = []
    softest = min(forces[law][FIRST] for law in ordered)
    for law in ordered:
        limit = simulation.penetration_limit(sections[law])
        chosen = "yes" if law in used else ""
        word, reason = words.get(law, HOLDING)
        said = word if word == HOLDING[0] else f"{word}: {reason}"
        deepest = limit if np.isfinite(limit) else np.nan
        rows.append((law, chosen, *forces[law], forces[law][FIRST] / softest, deepest, said))
    at = [wording.scale("m", depth).given(depth) for depth in DEPTHS]
    columns = (
        Column("elastic law"),
        Column("used here", file_only=len(used) == len(sections)),
        *(Column(f"at {depth}", "N") for depth in at),
        Column(f"at {at[FIRST]}, over the softest"),
        Column("holds up to", "m"),
        Column("in this joint"),
    )
    note = f"{_joint_text(sections[ordered[0]])}. Holds up to {wording.DASH}: any penetration."
    title = f"Elastic force over penetration, joint {joint.title}"
    return Table(f"elastic_force_{joint.name}", title, note, columns, rows)


def _joint_text(section: case.Joint) -> str:
    """Return the joint that the forces are of."""
    named = (("radial clearance", "clearance"), ("bearing radius", "bearing_radius"), ("length", "length"))
    sizes = [(word, getattr(section, key)) for word, key in named if getattr(section, key) is not None]
    facts = [f"{word} {wording.scale('m', size).given(size, 4)}" for word, size in sizes]
    materials = section.contact.material
    if materials:
        bodies = {f" of the {body}": material for body, material in materials._asdict().items()}
        if materials.bearing == materials.journal:
            bodies = {"": materials.bearing}
        for whose, material in bodies.items():
            young = wording.scale("Pa", material.young).given(material.young, 4)
            facts.append(f"Young's modulus{whose} {young}, Poisson's ratio{whose} {material.poisson:.4g}")
    return f"In the joint of the hardest case: {', '.join(facts)}"


def _curves(sections: dict[str, case.Joint], ordered: list[str], used: list[str]) -> Picture:
    curves = {law: np.array(simulation.elastic_forces(sections[law], CURVE)) for law in ordered}
    drawn = [(law, curves[law], law in used) for law in sorted(ordered, key=lambda law: -curves[law][-1])]
    alt = f"From {ordered[0]}, the softest at 1 µm, to {ordered[-1]}, the stiffest there."
    return Picture(
        "Elastic force over penetration", "", alt, lambda ax: comparison.elastic(ax, CURVE, drawn), size=(4.6, 3.4)
    )
