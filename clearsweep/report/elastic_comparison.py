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
    return _beside(joint, dict(zip(there, sections, strict=True)), there)


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
    return _beside(joint, sections, [section.elastic_name]) if len(sections) > 1 else None


def _beside(joint: Joint, sections: dict[str, case.Joint], used: list[str]) -> Part:
    """Return sentence, picture and table of elastic laws; `sections`: name -> section of the joint with that law."""
    forces = {law: np.array(simulation.elastic_forces(section, DEPTHS)) for law, section in sections.items()}
    ordered = sorted(forces, key=lambda law: forces[law][FIRST])
    sentences = _sentences(forces, ordered, used)
    return Part(sentences, [_curves(sections, ordered, used)], [_table(joint, sections, forces, ordered, used)])


def _sentences(forces: dict[str, np.ndarray], ordered: list[str], used: list[str]) -> list[str]:
    """Return by which factor the laws differ, from the softest to the stiffest; [] of a single law."""
    if len(forces) < 2:
        return []
    values, at = np.array(list(forces.values())), [wording.scale("m", depth).given(depth) for depth in DEPTHS]
    factors = [wording.plain(factor) for factor in values.max(axis=0) / values.min(axis=0)]
    more = [f"{factor} at {depth}" for k, (factor, depth) in enumerate(zip(factors, at, strict=True)) if k != FIRST]
    least, most = wording.alike((forces[law][FIRST] for law in (ordered[0], ordered[-1])), "N")
    whose = (
        "these elastic laws" if len(used) == len(forces) else f"the {len(forces)} elastic laws that this joint allows"
    )
    return [
        f"At a penetration of {at[FIRST]} {whose} differ by a factor of {factors[FIRST]}: {least} ({ordered[0]}) to "
        f"{most} ({ordered[-1]}); by {wording.sentence_list(more)}."
    ]


def _table(joint: Joint, sections: dict[str, case.Joint], forces: dict, ordered: list[str], used: list[str]) -> Table:
    rows = []
    for law in ordered:
        limit = simulation.penetration_limit(sections[law])
        factor = forces[law][FIRST] / forces[ordered[0]][FIRST]
        chosen = "yes" if law in used else ""
        rows.append((law, chosen, *forces[law], factor, limit if np.isfinite(limit) else np.nan))
    at = [wording.scale("m", depth).given(depth) for depth in DEPTHS]
    columns = (
        Column("elastic law"),
        Column("used here", file_only=len(used) == len(sections)),
        *(Column(f"at {depth}", "N") for depth in at),
        Column(f"at {at[FIRST]}, over the softest"),
        Column("holds up to", "m"),
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
