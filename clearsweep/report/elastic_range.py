"""Up to which speed impacts stay elastic: of each joint's own material, in sentences, cards and pictures alike."""

from ..judging import validity
from ..judging.validity import Surfaces
from ..language import wording
from .study import Joint, Study


def surfaces(study: Study) -> dict[str, Surfaces]:
    """Return what is known of the surfaces of every joint, by its name."""
    return validity.surfaces_of(study.run.grid, [joint.name for joint in study.joints])


def limit(study: Study, joint: Joint) -> tuple[str, str]:
    """Return a joint's material and the speed up to which it stays elastic, in words."""
    found = surfaces(study)[joint.name]
    return found.material, wording.scale("m/s", found.elastic_to).given(found.elastic_to, 2)


def limits(study: Study) -> list[tuple[str, float]]:
    """Return every speed (m/s) up to which joints stay elastic: the material, with the joint where they differ."""
    found = surfaces(study)
    if len({(each.material, each.elastic_to) for each in found.values()}) == 1:
        return [(each.material, each.elastic_to) for each in found.values()][:1]
    return [(f"{each.material}, {wording.joint_name(name)}", each.elastic_to) for name, each in found.items()]
