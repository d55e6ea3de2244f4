"""Finds the laws that suit the joints of a case, from the valid ranges that each law declares."""

import math
import textwrap
from collections.abc import Iterator
from typing import NamedTuple

from ... import grid
from ...contracts.case import Case, Joint
from ...contracts.catalogue import Law, Merit
from ...grid import library
from ...language import wording
from ...language.errors import InputError, similar_words
from ...mechanics import describe
from ...mechanics.describe import WIDTH
from ...mechanics.joints import registry
from ...mechanics.laws.elastic import plane_strain_modulus, relative_radius, static_penetration
from ..machine.ideal import ideal_peaks
from ..setup.scene import catalogue

RATINGS = SUITABLE, DOUBTFUL, UNSUITABLE = "suitable", "doubtful", "not here"  # best first
FAMILY_KEYS = {
    "elastic": "contact.elastic",
    "roughness": "roughness.law",
    "law": "contact.law",
    "film": "film.law",
    "pressure": "wear.pressure",
}
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
    return [advice_for_joint(joint, peaks.get(joint.name)) for joint in case.joints]


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


def advice_for_joint(joint: Joint, load: float | None) -> Advice:
    """Return the laws that suit a joint under a load (N), which is None if unknown."""
    dry = (
        (*_elastic_assessments(joint, load), *_roughness_assessments(joint, load), *_loss_assessments(joint))
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
    arc = _half_contact_arc(joint, load)
    return ", ".join(phrases) + (f", half the contact arc {math.degrees(arc):.3g} deg" if arc is not None else "")


def _half_contact_arc(joint: Joint, load: float | None) -> float | None:
    """Return half the contact arc (rad) of a bearing under `load` (N), by Hertz's line contact."""
    if load is None or not joint.contact.material or not joint.bearing_radius or not joint.length:
        return None
    area = 4.0 * load / joint.length * relative_radius(joint) / (math.pi * plane_strain_modulus(joint.contact.material))
    return math.asin(min(math.sqrt(area) / joint.bearing_radius, 1.0))


def _doubts(law: Law, joint: Joint, load: float | None) -> list[str]:
    """Return in words the trusted ranges of a law that a joint leaves."""
    slenderness = joint.length / (2.0 * joint.bearing_radius) if joint.length and joint.bearing_radius else None
    case_values = {"arc": _half_contact_arc(joint, load), "length": joint.length, "length / diameter": slenderness}
    limits_and_values = [(limit, case_values[limit.path]) for limit in law.trusted]
    violated_limits = [limit for limit, value in limits_and_values if value is not None and not limit.contains(value)]
    ranges = [f" (trusted for {limit.path} {limit.allowed()})" if limit.high else "" for limit in violated_limits]
    doubts = [f"{limit.reason}{trusted_range}" for limit, trusted_range in zip(violated_limits, ranges, strict=True)]
    return ([law.unsound] if law.unsound else []) + doubts


def _elastic_assessments(joint: Joint, load: float | None) -> Iterator[LawAssessment]:
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
    for law in (law for law in registry.all_laws() if law.family == "law"):
        restitution_of = registry.RECIPES["law", law.name].free_restitution
        field = next((field for field in law.fields if field.name == "restitution"), None)
        if missing := _missing_keys(law, joint):
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


def _missing_keys(law: Law, joint: Joint) -> list[str]:
    """Return the keys, besides the restitution, that a law of the normal force needs and a joint lacks."""
    available = {"restitution", *joint.contact.values, *(("stiffness",) if joint.contact.material else ())}
    required = (field for field in law.fields if field.default is None and not field.optional)
    return [field.name for field in required if field.name not in available]


def _pressure_assessments(joint: Joint, load: float | None) -> Iterator[LawAssessment]:
    """Yield the assessments of the pressure laws of wear if the joint wears."""
    for law in (law for law in registry.all_laws() if law.family == "pressure" and joint.wear):
        modulus = joint.contact.material or (joint.wear and joint.wear.values.get("pressure_modulus"))
        if "modulus" in law.needs and not modulus:
            yield LawAssessment("pressure", law.name, UNSUITABLE, "needs material or pressure_modulus")
            continue
        doubts = _doubts(law, joint, load)
        yield LawAssessment("pressure", law.name, DOUBTFUL if doubts else SUITABLE, "; ".join(doubts) or NO_OBJECTION)
