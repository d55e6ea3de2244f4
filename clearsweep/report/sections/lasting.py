"""Wear at a glance: the map of the joint that wears deepest."""

from ..blocks.picture import Picture
from ..blocks.section import Gallery, Section, without_empty
from ..data.study import WEAR_PER_1000_HOURS, Study
from . import maps


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing wears or no case finished."""
    return [] if study.cases.empty else [Section("lasting", "Wear", without_empty([Gallery("", _maps(study))]))]


def _maps(study: Study) -> list[Picture]:
    """Return the map of wear of the joint that wears deepest."""
    wearing = [joint for joint in study.joints if joint.wears and study.has(joint.column(WEAR_PER_1000_HOURS))]
    if not wearing:
        return []
    deepest = max(wearing, key=lambda joint: study.cases.largest(joint.column(WEAR_PER_1000_HOURS)))
    return maps.pictures_over_axes(study, deepest, WEAR_PER_1000_HOURS, "wear depth per 1000 h")
