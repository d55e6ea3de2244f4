"""The sections of the report in the order of the page: each function takes a study and returns non-empty sections."""

from collections.abc import Callable

from ...language import phases
from ..blocks.section import Detail, Section
from ..samples import with_note
from ..study import Study
from .answer import (
    failure_sections,
    folded_verdict_sections,
    reliability_sections,
    summary_sections,
    trust_sections,
    verdict_sections,
)
from .cases import case_sections, explorer_sections, leading_explorer_sections, other_cases_sections
from .drivers import driver_sections, folded_driver_sections, tradeoff_sections, trend_sections
from .identified import folded_identified_sections, identified_sections
from .laws import (
    bending_links_sections,
    elastic_laws_sections,
    elastic_links_sections,
    law_check_sections,
    law_choice_sections,
)
from .maps import curve_sections, deepest_wear_sections, map_sections
from .motion import motion_type_sections, peak_revolution_sections, peak_sections
from .sample import folded_sample_sections, leading_sample_sections, sample_sections
from .searches import folded_optimised_sections, optimised_sections, seek_sections
from .setup import budget_sections, mechanism_sections, setup_sections, tolerance_sections
from .vibration import vibration_sections
from .wear import bearing_sections, film_sections, life_sections, wear_sections

SectionBuilder = Callable[[Study], list[Section]]
UNFOLDED: tuple[SectionBuilder, ...] = (  # seen at once, in the order of the page
    summary_sections,
    verdict_sections,
    seek_sections,
    optimised_sections,
    leading_explorer_sections,
    identified_sections,
    sample_sections,
    case_sections,
    driver_sections,
    leading_sample_sections,
    trust_sections,
    deepest_wear_sections,
)
#: In the second column of a wide page; where no case is played, what drives it is in the first.
SECOND_COLUMN = (*UNFOLDED[UNFOLDED.index(driver_sections) :], leading_explorer_sections)
FOLDED: tuple[tuple[str, tuple[SectionBuilder, ...]], ...] = (  # folded below them, by subject
    (
        "Forces and output",
        (
            folded_verdict_sections,
            folded_optimised_sections,
            reliability_sections,
            curve_sections,
            map_sections,
            folded_driver_sections,
            folded_sample_sections,
            tradeoff_sections,
        ),
    ),
    (
        "Motion",
        (vibration_sections, peak_revolution_sections, other_cases_sections, motion_type_sections, film_sections),
    ),
    ("Wear and life", (bearing_sections, life_sections, wear_sections, trend_sections)),
    (
        "Laws and errors",
        (
            folded_identified_sections,
            tolerance_sections,
            budget_sections,
            law_check_sections,
            law_choice_sections,
            elastic_laws_sections,
            elastic_links_sections,
            bending_links_sections,
        ),
    ),
    ("All cases", (explorer_sections, peak_sections, failure_sections)),
    ("Setup", (mechanism_sections, setup_sections)),
)


def _is_in_second_column(builder: SectionBuilder, earlier: list[Section]) -> bool:
    """Return whether sections belong in the second column of a wide page, after those that are `earlier`."""
    if any(section.key == "optimise" for section in earlier):
        return builder is leading_explorer_sections  # as long as all others
    # a case in motion fills most of a column
    shows_case = any(isinstance(block, Detail) for section in earlier for block in section.blocks)
    return builder in SECOND_COLUMN and (builder is not driver_sections or shows_case)


def all_sections(study: Study) -> list[Section]:
    """Return the non-empty sections of a run."""
    finished_sections: list[Section] = []
    builders = [("", builder) for builder in UNFOLDED]
    builders += [(subject, builder) for subject, folded in FOLDED for builder in folded]
    with phases.phase("preparing the report") as preparing:
        for index, (subject, builder) in enumerate(builders):
            preparing.note(share=index / len(builders))
            nonempty = [section for section in builder(study) if section.blocks]
            in_second_column = _is_in_second_column(builder, finished_sections)
            placed_sections = [section._replace(subject=subject, second=in_second_column) for section in nonempty]
            finished_sections += [with_note(study, section) for section in placed_sections]
    return finished_sections
