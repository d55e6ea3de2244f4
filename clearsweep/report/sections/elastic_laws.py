"""Other elastic laws for a joint whose material allows several, and whose law is not swept."""

from .. import elastic_comparison
from ..section import Section
from ..study import Study


def sections(study: Study) -> list[Section]:
    """Return one section for each such joint."""
    if study.cases.empty:
        return []
    swept = {axis.path for axis in study.swept()}
    choices = ("contact.elastic", "roughness.law")
    joints = [joint for joint in study.joints if swept.isdisjoint(f"joints.{joint.title}.{key}" for key in choices)]
    parts = {joint: elastic_comparison.of_material(study, joint) for joint in joints}
    return [
        Section(
            f"other_elastic_{joint.name}",
            f"What another elastic law would give in joint {joint.title}",
            part.blocks(),
        )
        for joint, part in parts.items()
        if part is not None
    ]
