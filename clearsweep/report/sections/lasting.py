"""Wear and life at a glance: deepest wear, its map, and the life of joints where the verdict does not lead."""

from ...answers import sampled, wear
from ..blocks.picture import Picture
from ..blocks.section import Gallery, Points, Section, without_empty
from ..data.answered import answer_cases
from ..data.study import WEAR_PER_1000_HOURS, Study
from ..data.worst_case import case_ranking_of
from . import life, maps


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing wears or no case finished."""
    if study.cases.empty:
        return []
    life_points = [] if case_ranking_of(study).question == "life" else life.life_sentences(study)
    wear_points = [] if sampled.is_one_sample(study.run.grid) else wear.sentences(answer_cases(study))
    blocks = without_empty([Points([*life_points, *wear_points]), Gallery("", _maps(study))])
    return [Section("lasting", "Wear and life", blocks)]


def _maps(study: Study) -> list[Picture]:
    """Return the map of wear of the joint that wears deepest."""
    wearing = [joint for joint in study.joints if joint.wears and study.has(joint.column(WEAR_PER_1000_HOURS))]
    if not wearing:
        return []
    deepest = max(wearing, key=lambda joint: study.cases.largest(joint.column(WEAR_PER_1000_HOURS)))
    return maps.pictures_over_axes(study, deepest, WEAR_PER_1000_HOURS, "wear depth per 1000 h")
