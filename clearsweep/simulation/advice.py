"""Compares the laws of the joints of a case by their validity, and recommends some."""

import math
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from os import PathLike
from typing import NamedTuple

import numpy as np

from .. import grid
from ..contracts.case import Case, Joint
from ..contracts.catalogue import Catalogue, Law, Merit
from ..grid import library
from ..language import wording
from ..language.errors import InputError, did_you_mean, similar_words
from ..mechanics import describe
from ..mechanics.describe import WIDTH
from ..mechanics.joints import registry
from ..mechanics.laws.elastic import plane_strain_modulus, relative_radius, static_penetration
from .machine.ideal import ideal_peaks
from .setup.scene import catalogue

# Finds the laws that suit the joints of a case, from the valid ranges that each law declares.

RATINGS = SUITABLE, DOUBTFUL, UNSUITABLE = "suitable", "doubtful", "not here"  # best first
ASSESSED = "elastic", "roughness", "law", "film", "pressure"  # families, in this order
NO_OBJECTION = "no known objection"
RESTITUTION_TOLERANCE = 0.05  # relative error of the restitution that a suitable law reproduces
STIFFNESS_GIVEN = Merit(0, "its stiffness is given in the grid")


class LawAssessment(NamedTuple):
    """The assessment of a law for a joint."""

    family: str
    law: str
    rating: str  # SUITABLE, DOUBTFUL or UNSUITABLE
    reason: str
    merit: Merit | None = None  # rank and reason among suitable laws; None: not ranked


class Advice(NamedTuple):
    """The laws for one joint of a case."""

    joint: str
    conditions: str  # the deciding quantities, in words
    assessments: tuple[LawAssessment, ...]


def advice(case: Case) -> list[Advice]:
    """Return, for each joint of a case, the laws that suit it."""
    peaks = ideal_peaks(case)
    return [advice_for_joint(joint, peaks.get(joint.name_in_machine)) for joint in case.joints]


def laws_text(name: str | None = None) -> str:
    """Return the description of a law, a library, a library entry or a grid key; without a name, a line for each law.

    Raises InputError with the nearest name.
    """
    if name is None:
        lines = [f"  {library_name:10}{', '.join(entries)}" for library_name, entries in library.LIBRARIES.items()]
        indent = " " * len(f"  {'':10}")
        wrapped = [textwrap.fill(line, WIDTH, subsequent_indent=indent, break_on_hyphens=False) for line in lines]
        return "\n".join([describe.law_text(), "", "libraries", *wrapped])
    laws = catalogue()
    if texts := [
        text for text in (library.library_text(name), describe.law_text(name), grid.key_text(name, laws)) if text
    ]:
        return "\n\n".join(texts)
    last_part = name.rpartition(".")[2]
    if text := _column_text(name, laws):
        return text
    similar = similar_words(last_part, (*describe.law_names(), *library.library_names())) or similar_words(
        last_part, grid.key_names(laws)
    )
    suggestion = (
        f"; did you mean '{similar[0]}'?"
        if len(similar) == 1
        else f"; there are {', '.join(similar)}"
        if similar
        else ""
    )
    raise InputError(
        f"list: unknown name '{name}'{suggestion} (`clearsweep list` prints laws and libraries; a key of a grid has a "
        "path such as simulate.tolerance)"
    )


def _column_text(name: str, laws: Catalogue) -> str:
    """Return the description of a column of the summary, such as rod_slider_force_peak or J_force_peak, or ''."""
    for figure in laws.figures:
        subject = name.removesuffix(figure.name).rstrip("_")
        if not name.endswith(figure.name) or bool(subject) == (figure.of == "case"):
            continue
        lines = {
            "meaning": figure.text,
            "unit": figure.unit.replace("{output}", "m or rad"),
            "of": f"the {figure.of}; `limits` accept it",
        }
        texts = (f"  {key:10}{text.replace('{output}', subject)}" for key, text in lines.items())
        return "\n".join([name, *texts])
    return ""


def advice_for_joint(joint: Joint, load: float | None) -> Advice:
    """Return the laws that suit a joint under a load (N), which is None if unknown."""
    dry = (
        (*elastic_assessments(joint, load), *_roughness_assessments(joint, load), *_loss_assessments(joint))
        if joint.is_dry
        else ()
    )
    assessments = (*dry, *_film_assessments(joint, load), *_pressure_assessments(joint, load))
    return Advice(joint.name, _conditions(joint, load), assessments)


def _conditions(joint: Joint, load: float | None) -> str:
    """Return clearance, dimensions, material and load of a joint in words."""
    clearance, diametral = (wording.quantity_text(factor * joint.clearance, "m", 4) for factor in (1.0, 2.0))
    phrases = [f"clearance {clearance}"]
    if joint.bearing_radius is not None:
        phrases = [f"radial clearance {clearance} (diametral {diametral})"]
    for name, size in (("bearing radius", joint.bearing_radius), ("length", joint.length)):
        phrases.append(f"{name} {wording.quantity_text(size, 'm', 4)}" if size else f"no {name}")
    if joint.contact.material:
        phrases.append(f"E* {wording.quantity_text(plane_strain_modulus(joint.contact.material), 'Pa', 4)}")
    else:
        phrases.append("no material")
    phrases.append("load unknown before the run" if load is None else f"load {wording.quantity_text(load, 'N', 4)}")
    arc = half_contact_arc(joint, load)
    return ", ".join(phrases) + (f", half the contact arc {math.degrees(arc):.3g} deg" if arc is not None else "")


def half_contact_arc(joint: Joint, load: float | None) -> float | None:
    """Return half the contact arc (rad) of a bearing under `load` (N), by Hertz's line contact."""
    if load is None or not joint.contact.material or not joint.bearing_radius or not joint.length:
        return None
    area = 4.0 * load / joint.length * relative_radius(joint) / (math.pi * plane_strain_modulus(joint.contact.material))
    return math.asin(min(math.sqrt(area) / joint.bearing_radius, 1.0))


def _doubts(law: Law, joint: Joint, load: float | None) -> list[str]:
    """Return in words the trusted ranges of a law that a joint leaves."""
    slenderness = joint.length / (2.0 * joint.bearing_radius) if joint.length and joint.bearing_radius else None
    case_values = {"arc": half_contact_arc(joint, load), "length": joint.length, "length / diameter": slenderness}
    limits_and_values = [(limit, case_values[limit.path]) for limit in law.trusted]
    violated_limits = [limit for limit, value in limits_and_values if value is not None and not limit.contains(value)]
    ranges = [f" (trusted for {limit.path} {limit.allowed()})" if limit.high else "" for limit in violated_limits]
    doubts = [f"{limit.reason}{trusted_range}" for limit, trusted_range in zip(violated_limits, ranges, strict=True)]
    return ([law.unsound] if law.unsound else []) + doubts


def elastic_assessments(joint: Joint, load: float | None) -> Iterator[LawAssessment]:
    """Yield the assessments of the elastic laws."""
    laws = {law.name: law for law in registry.all_laws() if law.family == "elastic"}
    for name, (candidate, objection) in registry.elastic_candidates(joint).items():
        if objection:
            yield LawAssessment("elastic", name, UNSUITABLE, objection)
            continue
        is_stiffness_given = "stiffness" in candidate.contact.values and any(
            field.name == "stiffness" for field in laws[name].fields
        )
        doubts = [] if is_stiffness_given else _doubts(laws[name], joint, load)
        reason, too_deep = _depth_assessment(candidate, load)
        reason = reason or ("its stiffness is given" if is_stiffness_given else NO_OBJECTION)
        rating = DOUBTFUL if doubts or too_deep else SUITABLE
        merit = STIFFNESS_GIVEN if is_stiffness_given else laws[name].merit
        yield LawAssessment("elastic", name, rating, "; ".join(too_deep + doubts) or reason, merit)


def _depth_assessment(joint: Joint, load: float | None) -> tuple[str, list[str]]:
    """Return the penetration under a joint's load in words ('' without load), and objections if it is too deep."""
    if load is None:
        return "", []
    limit, depth = registry.penetration_limit(joint), static_penetration(registry.compile_contact(joint)[1], load)
    depth_text = f"{wording.quantity_text(depth, 'm')} deep under the load"
    return depth_text, [f"{depth_text}, valid up to {wording.quantity_text(limit, 'm')}"] if depth > limit else []


def _roughness_assessments(joint: Joint, load: float | None) -> Iterator[LawAssessment]:
    """Yield the assessments of the roughness laws if the joint has rough surfaces."""
    roughness = joint.roughness
    if roughness is None or not roughness.values:
        return
    for law in (law for law in registry.all_laws() if law.family == "roughness"):
        reason, too_deep = _depth_assessment(joint._replace(roughness=roughness._replace(law=law.name)), load)
        yield LawAssessment(
            "roughness", law.name, DOUBTFUL if too_deep else SUITABLE, "; ".join(too_deep) or reason or NO_OBJECTION
        )


def _film_assessments(joint: Joint, load: float | None) -> Iterator[LawAssessment]:
    """Yield the assessments of the film laws if the joint has a film."""
    for law in (law for law in registry.all_laws() if law.family == "film" and joint.film):
        assert joint.length is not None  # a film needs both
        assert joint.bearing_radius is not None
        slenderness = joint.length / (2.0 * joint.bearing_radius)
        violated_limits = [limit for limit in law.ranges if not limit.contains(slenderness)]
        doubts = _doubts(law, joint, load)
        objection = "; ".join(f"{limit.path} {limit.allowed()}: {limit.reason}" for limit in violated_limits)
        rating = UNSUITABLE if objection else DOUBTFUL if doubts else SUITABLE
        yield LawAssessment("film", law.name, rating, objection or "; ".join(doubts) or NO_OBJECTION)


def _loss_assessments(joint: Joint) -> Iterator[LawAssessment]:
    """Yield the assessments of the laws of the normal force, by the restitution of the joint."""
    required = joint.contact.values.get("restitution")
    available = {"restitution", *joint.contact.values, *(("stiffness",) if joint.contact.material else ())}
    for law in (law for law in registry.all_laws() if law.family == "law"):
        restitution_of = registry.RECIPES["law", law.name].free_restitution
        field = next((field for field in law.fields if field.name == "restitution"), None)
        needed = [field.name for field in law.fields if field.default is None and not field.optional]
        if missing := [name for name in needed if name not in available]:
            yield LawAssessment("law", law.name, UNSUITABLE, f"needs {' and '.join(missing)}")
        elif "hertz" in law.needs and joint.contact.elastic != "power":
            yield LawAssessment("law", law.name, UNSUITABLE, "needs elastic: power with the exponent 1.5")
        elif restitution_of is None:
            yield LawAssessment("law", law.name, DOUBTFUL, "its restitution depends on its keys, mass and speed")
        elif required is None:
            yield LawAssessment("law", law.name, DOUBTFUL if field else SUITABLE, "the joint has no restitution")
        elif field and not field.contains(required):
            yield LawAssessment("law", law.name, UNSUITABLE, f"takes a restitution {field.allowed()}")
        else:
            reproduced = float(restitution_of(required))
            rating = SUITABLE if abs(reproduced - required) <= RESTITUTION_TOLERANCE * required else DOUBTFUL
            reason = f"has a restitution of {reproduced:.3g} instead of {required:.3g}"
            yield LawAssessment("law", law.name, rating, reason, law.merit)


def _pressure_assessments(joint: Joint, load: float | None) -> Iterator[LawAssessment]:
    """Yield the assessments of the pressure laws of wear if the joint wears."""
    for law in (law for law in registry.all_laws() if law.family == "pressure" and joint.wear):
        modulus = joint.contact.material or (joint.wear and joint.wear.values.get("pressure_modulus"))
        if "modulus" in law.needs and not modulus:
            yield LawAssessment("pressure", law.name, UNSUITABLE, "needs material or pressure_modulus")
            continue
        doubts = _doubts(law, joint, load)
        yield LawAssessment("pressure", law.name, DOUBTFUL if doubts else SUITABLE, "; ".join(doubts) or NO_OBJECTION)


# Recommends a law for a joint, and lists the other valid ones: for `list --for`, dry runs, pages and runs.

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


def _recommended_text(laws: Sequence[Recommendation]) -> str:
    """Return the laws that are recommended for the joints _JOINTS, with reasons and the rating of the laws in use."""
    recommended, used = [], []
    for each in laws:
        kind = "elastic law" if each.key.endswith("elastic") else "contact law"
        law = f"{each.law} ({each.reason})" if each.law else "none, as none is valid there"
        recommended.append(f"{kind} {law}{', in use' if each.law == each.law_used else ''}")
        if each.law != each.law_used:
            description = f"is {each.rating}" + ("" if each.rating == SUITABLE else f": {each.objection}")
            remedy = f" Write `{each.key}: {each.law}`." if each.law and each.rating != SUITABLE else ""
            used.append(f"The {kind} in use, {each.law_used}, {description}.{remedy}")
    return " ".join([f"Recommended for {_JOINTS}: {'; '.join(recommended)}.", *used])


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
            is_used = assessment.law == _law_used(joint, assessment.family)
            if assessment.family in FAMILIES and assessment.rating == SUITABLE and not is_used:
                names.setdefault(f"joints.{joint.name}.{describe.KEYS[assessment.family]}", []).append(assessment.law)
    return names


def advice_text(source: str | PathLike, name: str | None = None) -> str:
    """Return the assessments of the laws for the joints of a grid, or those on the law `name`.

    Only some of many cases are assessed; a law gets its worst assessment over these.  Raises InputError.
    """
    cases = grid.load(source, catalogue())
    own_laws = [law for file in cases.law_files for law in file.laws]
    if texts := [describe.text_of(law) for law in own_laws if law.name == name]:
        return "\n\n".join(texts)
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
    own_text = "" if name else describe.own_laws_text(own_laws)
    return "\n\n".join([*lines, *([own_text] if own_text else []), _CAVEAT])


def _paragraphs(joint: Joint, sampled: Sequence[Advice], name: str | None) -> tuple[str, ...]:
    """Return the paragraphs on a joint in some cases, and on each family of laws.

    `joint` is taken from the first case.
    """
    conditions = dict.fromkeys((sampled[0].conditions, sampled[-1].conditions))
    by_law: dict[tuple[str, str], list[LawAssessment]] = {}
    for assessment in (assessment for joint_advice in sampled for assessment in joint_advice.assessments):
        by_law.setdefault((assessment.family, assessment.law), []).append(assessment)
    worst = [_worst(assessments) for assessments in by_law.values()]
    if name is not None:
        assessments_of_name = [assessment for assessment in worst if assessment.law == name]
        if not assessments_of_name:
            law_names = dict.fromkeys(assessment.law for assessment in worst)
            raise InputError(f"list: no entry '{name}' there{did_you_mean(name, law_names)}")
        return " ... ".join(conditions), *("\n".join(_rows([assessment])) for assessment in assessments_of_name)
    recommended = _recommended_for(joint, worst)
    lines = [" ... ".join(conditions), *(["", _recommended_text(recommended)] if recommended else [])]
    suitable = [each.law for each in worst if each.family == "elastic" and each.rating == SUITABLE]
    if force_ratio := _force_ratio_text(joint, suitable):
        lines.append(force_ratio)
    families = sorted({assessment.family for assessment in worst}, key=ASSESSED.index)
    rows = ("\n".join(_rows([each for each in worst if each.family == family])) for family in families)
    return "\n".join(lines), *rows


def _rows(assessments: list[LawAssessment]) -> list[str]:
    """Return lines on the laws of a family: suitable ones row by row, others only by name."""
    is_single = len(assessments) == 1
    listed = [assessment for assessment in assessments if is_single or assessment.rating == SUITABLE]
    width = max((len(assessment.law) for assessment in listed), default=0)
    lines = [
        describe.KEYS[assessments[0].family],
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
        f"The choice among the {len(forces)} valid elastic laws changes the force up to "
        f"{wording.number_text(forces[stiffest] / forces[softest])} times at {depth_text}, from {softest} "
        f"to {stiffest}."
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
        law_used, key = _law_used(joint, family), describe.KEYS[family]
        used = by_law.get(law_used, LawAssessment(family, law_used, SUITABLE, ""))
        suitable = [assessment for assessment in by_law.values() if assessment.rating == SUITABLE]
        best = min(suitable, key=lambda each: each.merit.rank if each.merit else len(RATINGS) + 10, default=None)
        law, reason = (best.law, best.merit.reason if best.merit else best.reason) if best else ("", "")
        recommended.append(Recommendation(joint.name, key, law, reason, law_used, used.rating, used.reason))
    return recommended


_NO_RESTITUTION = "the joint has no restitution"


def _law_used(joint: Joint, family: str) -> str:
    return joint.contact.law if family == "law" else joint.contact.elastic or ""


def _worst(assessments: list[LawAssessment]) -> LawAssessment:
    """Return the worst assessment of a law, and in how many cases it applies."""
    worst = max(assessments, key=lambda assessment: RATINGS.index(assessment.rating))
    count = sum(assessment.rating == worst.rating for assessment in assessments)
    case_share = f" ({count} of {len(assessments)} cases)" if count < len(assessments) else ""
    return worst._replace(reason=f"{worst.reason}{case_share}")
