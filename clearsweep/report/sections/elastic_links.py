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
from ..data.study import Joint, Study, joint_of, resolve_cases

RELATIVE_STEP = 1e-3  # of a penetration, for the slope of the elastic force
MIN_IMPACTS = 0.5  # per revolution: number of impacts from which a joint counts as impacting
STIFFNESS_KEY = "axial_stiffness"
Links = tuple[simulation.ElasticLink, ...]


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no link is elastic."""
    if study.cases.empty or not study.joints:
        return []
    joint = study.most_loaded_joint()
    worst = study.worst(joint)
    try:
        (case,) = resolve_cases(study, [worst])
    except InputError:  # of another version
        return []
    links = simulation.elastic_links(case)
    if not links:
        return []
    stiffness_sentence, estimated_effect = _stiffness_sentences(study, joint, worst, case, links)
    effect = _computed_effect_text(study, joint, worst) or estimated_effect
    sentences = [text for text in (stiffness_sentence, effect, _bending_sentence(links)) if text]
    return [Section("elastic-links", "Elastic links", without_empty([Sentences(sentences), _table(links)]))]


def _stiffness_sentences(study: Study, joint: Joint, worst: str, case: Case, links: Links) -> tuple[str, str]:
    """Return the stiffness of a contact and of its links, and the effect of rigid links on an impact there."""
    links_at_joint, contact = [link for link in links if joint.title in link.joints], joint_of(case, joint)
    depth = float(study.cases.at[worst, joint.column("penetration_max")])
    if not links_at_joint or not contact.is_dry or contact.is_guide or not depth > 0.0:
        return "", ""
    low, high = simulation.elastic_forces(contact, (depth * (1.0 - RELATIVE_STEP), depth * (1.0 + RELATIVE_STEP)))
    stiffness = (high - low) / (2.0 * RELATIVE_STEP * depth)
    stiffness_ratio = stiffness * sum(1.0 / link.stiffness for link in links_at_joint)
    names, verb = (
        wording.sentence_list([link.name for link in links_at_joint]),
        "has" if len(links_at_joint) == 1 else "together have",
    )
    stiffness_sentence = (
        f"In joint {joint.title} the contact stiffness is {_stiffness_text(stiffness)} at the largest penetration, in "
        "case "
        f"{worst[:8]}. Along the line of its pins {names} {verb} a stiffness of "
        f"{_stiffness_text(stiffness / stiffness_ratio)}."
    )
    if study.cases.at[worst, joint.column("impacts_per_rev")] < MIN_IMPACTS:
        return stiffness_sentence, "Journal and bearing hardly separate there, so a rigid link changes the peak little."
    return stiffness_sentence, (
        "Impacts occur there. With rigid links such an impact would be at least "
        f"{wording.number_text(math.sqrt(1.0 + stiffness_ratio), 2)} times as hard: contact and link are two springs "
        "in "
        "series. A "
        f"case with ten times the {STIFFNESS_KEY} shows this effect."
    )


def _stiffness_text(stiffness: float) -> str:
    return f"{wording.number_text(1e-6 * stiffness)}{wording.BLANK}kN/mm"


def _computed_effect_text(study: Study, joint: Joint, worst: str) -> str:
    """Return the peaks of the cases that differ from the worst only in the stiffness of a link in words, or ''."""
    axis = next((axis for axis in study.swept() if axis.path.endswith(f".elastic.{STIFFNESS_KEY}")), None)
    similar_cases = _cases_differing_in(study, axis, worst) if axis is not None and axis.is_numeric else []
    if axis is None or len(similar_cases) < 2:
        return ""
    column = joint.column(PEAK.figure)
    similar_cases.sort(key=lambda case_id: float(study.cases.at[case_id, axis.path]))
    values = [axis.text(study.cases.at[case_id, axis.path]) for case_id in similar_cases]
    peaks = study.texts(*((case_id, column) for case_id in similar_cases))
    pairs = [f"{peak} at {value}" for peak, value in zip(peaks, values, strict=True)]
    return (
        f"With all other values as in this case, the force peak depends on {axis.name}: {wording.sentence_list(pairs)}."
    )


def _cases_differing_in(study: Study, axis: Axis, worst: str) -> list[str]:
    """Return the cases that differ from `worst` in one axis only, including itself."""
    is_similar = np.ones(len(study.cases), dtype=bool)
    for other in study.swept():
        if other.path != axis.path:
            value_indices = study.indices_on(other)
            is_similar &= value_indices == value_indices[study.cases.row_of(worst)]
    return list(study.cases.index[is_similar])


def _bending_sentence(links: Links) -> str:
    """Return the drive frequency relative to the bending of the links, which is neglected."""
    link = max(links, key=lambda link: link.bending)
    return (
        f"The model neglects bending of links. The drive frequency is {wording.number_text(link.bending, 2)} times "
        "the first "
        f"bending frequency of {link.name}, modelled as a round steel bar. Up to 0.2 its deflection is nearly static."
    )


def _table(links: Links) -> Table:
    """Return the table of the links."""
    headings = ("link", "segments")
    columns = (
        *map(Column, headings),
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
