"""Other elastic laws for a joint whose material allows several, and whose law is not swept."""

from ... import simulation
from ...language.errors import InputError
from ..blocks.section import Section
from ..data.leading import PEAK
from ..data.study import Joint, Study, joint_of, resolve_cases
from ..laws import elastic_comparison


def sections(study: Study) -> list[Section]:
    """Return one section for each such joint."""
    if study.cases.empty:
        return []
    swept = {axis.path for axis in study.swept()}
    law_keys = ("contact.elastic", "roughness.law")
    joints = [joint for joint in study.joints if swept.isdisjoint(f"joints.{joint.title}.{key}" for key in law_keys)]
    comparisons = {joint: elastic_comparison.compare_allowed_laws(study, joint) for joint in joints}
    return [
        Section(
            f"other_elastic_{joint.name}",
            f"What another elastic law would give in joint {joint.title}",
            comparison.blocks(),
        )
        for joint, comparison in comparisons.items()
        if comparison is not None
    ]


def recommendation_texts(study: Study) -> list[str]:
    """Return the laws that are recommended for each dry joint, by the load of its hardest case."""
    return simulation.recommended_texts(
        recommendation for joint in study.joints for recommendation in _joint_recommendations(study, joint)
    )


def _joint_recommendations(study: Study, joint: Joint) -> list[simulation.Recommendation]:
    if not study.is_driven or not study.has(joint.column(PEAK.figure)):
        return []
    hardest = study.cases[joint.column(PEAK.figure)].idxmax()
    try:
        section = joint_of(resolve_cases(study, [hardest])[0], joint)
    except InputError:  # laws of another version
        return []
    load = elastic_comparison.ideal_load(study, joint, hardest)
    return simulation.recommendations_for(section, load) if section.is_dry else []
