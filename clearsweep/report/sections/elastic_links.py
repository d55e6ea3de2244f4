"""Elastic links: their stiffness and that of the contacts at their pins, and the effect of a rigid link on a peak."""

import math

import numpy as np

from ... import simulation
from ...contracts.case import Case
from ...language import wording
from ...language.errors import InputError
from ..blocks.section import Section, Sentences, without_empty
from ..blocks.table import Column, Table
from ..data.axis import Axis
from ..data.leading import PEAK
from ..data.study import Joint, Study, joint_of, resolved

STEP = 1e-3  # of a penetration, for the slope of the elastic force
IMPACTS = 0.5  # per revolution: number of impacts from which a joint counts as impacting
KEY = "axial_stiffness"
Links = tuple[simulation.ElasticLink, ...]


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no link is elastic."""
    if study.cases.empty or not study.joints:
        return []
    joint = study.hardest_joint()
    worst = study.worst(joint)
    try:
        (case,) = resolved(study, [worst])
    except InputError:  # of another version
        return []
    links = simulation.elastic_links(case)
    if not links:
        return []
    compared, estimated = _stiffness(study, joint, worst, case, links)
    effect = _computed(study, joint, worst) or estimated
    sentences = [text for text in (compared, effect, _neglected(links)) if text]
    return [Section("elastic-links", "Elastic links", without_empty([Sentences(sentences), _table(links)]))]


def _stiffness(study: Study, joint: Joint, worst: str, case: Case, links: Links) -> tuple[str, str]:
    """Return the stiffness of a contact and of its links, and the effect of rigid links on an impact there."""
    at, contact = [link for link in links if joint.title in link.joints], joint_of(case, joint)
    depth = float(study.cases.at[worst, joint.column("penetration_max")])
    if not at or not contact.is_dry or contact.is_guide or not depth > 0.0:
        return "", ""
    low, high = simulation.elastic_forces(contact, (depth * (1.0 - STEP), depth * (1.0 + STEP)))
    stiffness = (high - low) / (2.0 * STEP * depth)
    softness = stiffness * sum(1.0 / link.stiffness for link in at)
    names, verb = wording.sentence_list([link.name for link in at]), "has" if len(at) == 1 else "together have"
    compared = (
        f"In joint {joint.title} the contact stiffness is {_stiff(stiffness)} at the largest penetration, in case "
        f"{worst[:8]}. Along the line of its pins {names} {verb} a stiffness of {_stiff(stiffness / softness)}."
    )
    if study.cases.at[worst, joint.column("impacts_per_rev")] < IMPACTS:
        return compared, "Journal and bearing hardly separate there, so a rigid link changes the peak little."
    return compared, (
        "Impacts occur there. With rigid links such an impact would be at least "
        f"{wording.plain(math.sqrt(1.0 + softness), 2)} times as hard: contact and link are two springs in series. A "
        f"case with ten times the {KEY} shows this effect."
    )


def _stiff(stiffness: float) -> str:
    return f"{wording.plain(1e-6 * stiffness)}{wording.BLANK}kN/mm"


def _computed(study: Study, joint: Joint, worst: str) -> str:
    """Return the peaks of the cases that differ from the worst only in the stiffness of a link in words, or ''."""
    axis = next((axis for axis in study.swept() if axis.path.endswith(f".elastic.{KEY}")), None)
    alike = _alike(study, axis, worst) if axis is not None and axis.numeric else []
    if axis is None or len(alike) < 2:
        return ""
    column = joint.column(PEAK.figure)
    alike.sort(key=lambda case_id: float(study.cases.at[case_id, axis.path]))
    values = [axis.text(study.cases.at[case_id, axis.path]) for case_id in alike]
    peaks = study.texts(*((case_id, column) for case_id in alike))
    pairs = [f"{peak} at {value}" for peak, value in zip(peaks, values, strict=True)]
    return (
        f"With all other values as in this case, the force peak depends on {axis.name}: {wording.sentence_list(pairs)}."
    )


def _alike(study: Study, axis: Axis, worst: str) -> list[str]:
    """Return the cases that differ from `worst` in one axis only, including itself."""
    same = np.ones(len(study.cases), dtype=bool)
    for other in study.swept():
        if other.path != axis.path:
            places = study.indices_on(other)
            same &= places == places[study.cases.row_of(worst)]
    return list(study.cases.index[same])


def _neglected(links: Links) -> str:
    """Return the drive frequency relative to the bending of the links, which is neglected."""
    link = max(links, key=lambda link: link.bending)
    return (
        f"The model neglects bending of links. The drive frequency is {wording.plain(link.bending, 2)} times the first "
        f"bending frequency of {link.name}, modelled as a round steel bar. Up to 0.2 its deflection is nearly static."
    )


def _table(links: Links) -> Table:
    """Return the table of the links."""
    heads = ("link", "segments")
    columns = (
        *map(Column, heads),
        Column("axial stiffness", "N/m"),
        Column("first axial mode", "rad/s"),
        Column("impedance", "N*s/m"),
        Column("speed over first bending mode"),
    )
    rows = [
        (link.name, str(link.segments), link.stiffness, link.first_mode, link.impedance, link.bending) for link in links
    ]
    note = (
        "The case has the largest force peak. Both modes are those of the link alone, a uniform bar with free "
        "ends or pins."
    )
    return Table("elastic_links", "Elastic links", note, columns, rows)
