"""Recommends a law for a joint, and lists the other valid ones: for `list --for`, dry runs, pages and runs."""

from collections.abc import Iterable, Sequence
from os import PathLike
from typing import NamedTuple

import numpy as np

from ... import grid
from ...contracts.case import Case, Joint
from ...language import wording
from ...language.errors import InputError, did_you_mean
from ...mechanics.joints import registry
from ..setup.scene import catalogue
from .advice import (
    DOUBTFUL,
    FAMILY_KEYS,
    RATINGS,
    SUITABLE,
    UNSUITABLE,
    Advice,
    LawAssessment,
    advice,
    advice_for_joint,
)

FAMILIES = ("elastic", "law")  # of which one law each is recommended
MAX_CASES = 25  # of a grid that are looked at
COMPARED_DEPTH = 1e-6  # m, at which the forces of laws are compared
_JOINTS = "{joints}"  # in a text that several joints may share
_CAVEAT = "The load is the largest reaction without clearance; impacts are harder. clearsweep list NAME explains a law."


class Recommendation(NamedTuple):
    """The law of one family that is recommended for a joint."""

    joint: str
    key: str  # 'contact.elastic' or 'contact.law'
    law: str  # '' if none is valid
    reason: str
    law_used: str  # the law in the grid
    rating: str  # of the law in the grid: SUITABLE, DOUBTFUL or UNSUITABLE
    objection: str  # reason of that rating

    def _law_kind(self) -> str:
        return "elastic law" if self.key.endswith("elastic") else "contact law"

    def _law_text(self) -> str:
        """Return the law in words, with the reason."""
        law = f"{self.law} ({self.reason})" if self.law else "none, as none is valid there"
        return f"{self._law_kind()} {law}{', in use' if self.law == self.law_used else ''}"

    def _used_law_text(self) -> str:
        """Return the assessment of the law in use as a sentence."""
        description = f"is {self.rating}" + ("" if self.rating == SUITABLE else f": {self.objection}")
        return f"The {self._law_kind()} in use, {self.law_used}, {description}."


def _recommended_text(laws: Sequence[Recommendation]) -> str:
    """Return the laws that are recommended for the joints _JOINTS, with reasons and the rating of the laws in use."""
    summary = f"Recommended for {_JOINTS}: {'; '.join(recommendation._law_text() for recommendation in laws)}."
    return " ".join(
        [
            summary,
            *(
                recommendation._used_law_text()
                for recommendation in laws
                if recommendation.law != recommendation.law_used
            ),
        ]
    )


def recommended_texts(laws: Iterable[Recommendation]) -> list[str]:
    """Return a line on the laws that are recommended for each joint; joints with the same line share it."""
    by_joint: dict[str, list[Recommendation]] = {}
    for recommendation in laws:
        by_joint.setdefault(recommendation.joint, []).append(recommendation)
    joints_by_text: dict[str, list[str]] = {}
    for joint, joint_laws in by_joint.items():
        joints_by_text.setdefault(_recommended_text(joint_laws), []).append(joint)
    return [text.replace(_JOINTS, wording.sentence_list(joints)) for text, joints in joints_by_text.items()]


def recommendations(case: Case) -> list[Recommendation]:
    """Return the recommendations for each dry joint of a case."""
    return [
        recommendation
        for joint, joint_advice in zip(case.joints, advice(case), strict=True)
        for recommendation in _recommended_for(joint, joint_advice.assessments)
    ]


def recommendations_for(joint: Joint, load: float | None) -> list[Recommendation]:
    """Return the recommendations for a joint under a load (N)."""
    return _recommended_for(joint, advice_for_joint(joint, load).assessments)


def elastic_ratings(joint: Joint, load: float | None) -> dict[str, tuple[str, str]]:
    """Return elastic law -> whether it is valid for a joint under a load (N), and why."""
    return {
        assessment.law: (assessment.rating, assessment.reason)
        for assessment in advice_for_joint(joint, load).assessments
        if assessment.family == "elastic"
    }


def alternatives(case: Case) -> dict[str, list[str]]:
    """Return path of a law's name -> the other laws that are suitable for its joint."""
    names: dict[str, list[str]] = {}
    for joint, joint_advice in zip(case.joints, advice(case), strict=True):
        for assessment in joint_advice.assessments:
            if (
                assessment.family in FAMILIES
                and assessment.rating == SUITABLE
                and assessment.law != _law_used(joint, assessment.family)
            ):
                names.setdefault(f"joints.{joint.name}.{FAMILY_KEYS[assessment.family]}", []).append(assessment.law)
    return names


def advice_text(source: str | PathLike, name: str | None = None) -> str:
    """Return the assessments of the laws for the joints of a grid, or those on the law `name`.

    Only some of many cases are assessed; a law gets its worst assessment over these.  Raises InputError.
    """
    cases = grid.load(source, catalogue())
    sample_indices = np.unique(np.linspace(0, len(cases) - 1, MAX_CASES).round().astype(int)).tolist()
    sampled = [cases.case(index) for index in sample_indices]
    by_case = [advice(case) for case in sampled]
    joints_by_paragraphs: dict[tuple[str, ...], list[str]] = {}  # paragraphs -> the joints they are about
    for number, joint in enumerate(sampled[0].joints):
        text = _paragraphs(joint, [case_advice[number] for case_advice in by_case], name)
        joints_by_paragraphs.setdefault(text, []).append(joint.name)
    lines: list[str] = []
    printed: dict[str, str] = {}  # paragraph on a family of laws -> the joint where it is
    for (conditions, *families), joints in joints_by_paragraphs.items():
        lines.append(f"{', '.join(joints)}: {conditions.replace(_JOINTS, wording.sentence_list(joints))}")
        for paragraph in families:
            first_joint = printed.setdefault(paragraph, joints[0])
            lines.append(
                paragraph if first_joint == joints[0] else f"{paragraph.splitlines()[0]}: as for {first_joint}"
            )
    return "\n\n".join([*lines, _CAVEAT])


def _paragraphs(joint: Joint, sampled: Sequence[Advice], name: str | None) -> tuple[str, ...]:
    """Return the paragraphs on a joint in some cases, and on each family of laws.

    `joint` is taken from the first case.
    """
    conditions = dict.fromkeys((sampled[0].conditions, sampled[-1].conditions))
    worst = [_worst(assessments) for assessments in _by_law(sampled).values()]
    if name is not None:
        assessments_of_name = [assessment for assessment in worst if assessment.law == name]
        if not assessments_of_name:
            law_names = dict.fromkeys(assessment.law for assessment in worst)
            raise InputError(f"list: no entry '{name}' there{did_you_mean(name, law_names)}")
        return " ... ".join(conditions), *("\n".join(_rows([assessment])) for assessment in assessments_of_name)
    recommended = _recommended_for(joint, worst)
    lines = [" ... ".join(conditions), *(["", _recommended_text(recommended)] if recommended else [])]
    if force_ratio := _force_ratio_text(
        joint,
        [assessment.law for assessment in worst if assessment.family == "elastic" and assessment.rating == SUITABLE],
    ):
        lines.append(force_ratio)
    families = sorted({assessment.family for assessment in worst}, key=[*FAMILY_KEYS].index)
    rows = (
        "\n".join(_rows([assessment for assessment in worst if assessment.family == family])) for family in families
    )
    return "\n".join(lines), *rows


def _rows(assessments: list[LawAssessment]) -> list[str]:
    """Return lines on the laws of a family: suitable ones row by row, others only by name."""
    is_single = len(assessments) == 1
    listed = [assessment for assessment in assessments if is_single or assessment.rating == SUITABLE]
    width = max((len(assessment.law) for assessment in listed), default=0)
    lines = [
        FAMILY_KEYS[assessments[0].family],
        *(f"  {assessment.law:{width}}  {assessment.rating:8}  {assessment.reason}" for assessment in listed),
    ]
    for rating in () if is_single else (DOUBTFUL, UNSUITABLE):
        if names := [assessment.law for assessment in assessments if assessment.rating == rating]:
            lines.append(f"  {rating}: {', '.join(names)} (clearsweep list NAME --for GRID gives the reason)")
    return lines


def _force_ratio_text(joint: Joint, names: list[str]) -> str:
    """Return in words the factor between the forces of suitable elastic laws, or '' for fewer than two laws."""
    candidates = registry.elastic_candidates(joint)
    forces = {law: registry.elastic_forces(candidates[law][0], [COMPARED_DEPTH])[0] for law in names}
    if len(forces) < 2:
        return ""
    softest, stiffest = min(forces, key=forces.__getitem__), max(forces, key=forces.__getitem__)
    depth_text = wording.quantity_text(COMPARED_DEPTH, "m", 1)
    return (
        f"The {len(forces)} valid elastic laws differ by a factor of "
        f"{wording.number_text(forces[stiffest] / forces[softest])} in force at {depth_text}, from {softest} to "
        f"{stiffest}."
    )


def _recommended_for(joint: Joint, assessments: Iterable[LawAssessment]) -> list[Recommendation]:
    """Return the recommendations for a joint from the assessments of the laws."""
    all_assessments = list(assessments)
    recommended = []
    for family in FAMILIES:
        by_law = {assessment.law: assessment for assessment in all_assessments if assessment.family == family}
        if not by_law or all(
            assessment.reason == _NO_RESTITUTION for assessment in by_law.values() if assessment.rating == SUITABLE
        ):
            continue
        law_used = _law_used(joint, family)
        current_assessment = by_law.get(law_used, LawAssessment(family, law_used, SUITABLE, ""))
        suitable = [assessment for assessment in by_law.values() if assessment.rating == SUITABLE]
        best = min(suitable, key=_rank, default=None)
        law, reason = (best.law, best.merit.reason if best.merit else best.reason) if best else ("", "")
        recommended.append(
            Recommendation(
                joint.name,
                FAMILY_KEYS[family],
                law,
                reason,
                law_used,
                current_assessment.rating,
                current_assessment.reason,
            )
        )
    return recommended


_NO_RESTITUTION = "the joint has no restitution"


def _rank(assessment: LawAssessment) -> int:
    return assessment.merit.rank if assessment.merit else len(RATINGS) + 10


def _law_used(joint: Joint, family: str) -> str:
    return joint.contact.law if family == "law" else joint.contact.elastic or ""


def _by_law(advices: Iterable[Advice]) -> dict[tuple[str, str], list[LawAssessment]]:
    """Return the assessments of each law in some cases."""
    assessments: dict[tuple[str, str], list[LawAssessment]] = {}
    for assessment in (assessment for joint_advice in advices for assessment in joint_advice.assessments):
        assessments.setdefault((assessment.family, assessment.law), []).append(assessment)
    return assessments


def _worst(assessments: list[LawAssessment]) -> LawAssessment:
    """Return the worst assessment of a law, and in how many cases it applies."""
    worst = max(assessments, key=lambda assessment: RATINGS.index(assessment.rating))
    count = sum(assessment.rating == worst.rating for assessment in assessments)
    case_share = f" ({count} of {len(assessments)} cases)" if count < len(assessments) else ""
    return worst._replace(reason=f"{worst.reason}{case_share}")
