"""The sections of the report in the order of the page: each function takes a study and returns non-empty sections."""

from collections.abc import Callable

from ...language import phases
from ..blocks.section import Detail, Section
from ..study import Study
from . import answer, cases, drivers, identified, laws, maps, motion, sample, searches, setup, vibration, wear
from .sample import with_note

SectionBuilder = Callable[[Study], list[Section]]
UNFOLDED: tuple[SectionBuilder, ...] = (  # seen at once, in the order of the page
    answer.summary_sections,
    answer.verdict_sections,
    searches.seek_sections,
    searches.optimised_sections,
    cases.leading_explorer_sections,
    identified.identified_sections,
    sample.sample_sections,
    cases.case_sections,
    drivers.driver_sections,
    sample.leading_sample_sections,
    answer.trust_sections,
    maps.deepest_wear_sections,
)
#: In the second column of a wide page; where no case is played, what drives it is in the first.
SECOND_COLUMN = (*UNFOLDED[UNFOLDED.index(drivers.driver_sections) :], cases.leading_explorer_sections)
FOLDED: tuple[tuple[str, tuple[SectionBuilder, ...]], ...] = (  # folded below them, by subject
    (
        "Forces and output",
        (
            answer.folded_verdict_sections,
            searches.folded_optimised_sections,
            answer.reliability_sections,
            maps.curve_sections,
            maps.map_sections,
            drivers.folded_driver_sections,
            sample.folded_sample_sections,
            drivers.tradeoff_sections,
        ),
    ),
    (
        "Motion",
        (
            vibration.vibration_sections,
            motion.peak_revolution_sections,
            cases.other_cases_sections,
            motion.motion_type_sections,
            wear.film_sections,
        ),
    ),
    ("Wear and life", (wear.bearing_sections, wear.life_sections, wear.wear_sections, drivers.trend_sections)),
    (
        "Laws and errors",
        (
            identified.folded_identified_sections,
            setup.tolerance_sections,
            setup.budget_sections,
            laws.law_check_sections,
            laws.law_choice_sections,
            laws.elastic_laws_sections,
            laws.elastic_links_sections,
            laws.bending_links_sections,
        ),
    ),
    ("All cases", (cases.explorer_sections, motion.peak_sections, answer.failure_sections)),
    ("Setup", (setup.mechanism_sections, setup.setup_sections)),
)


def _is_in_second_column(builder: SectionBuilder, earlier: list[Section]) -> bool:
    """Return whether sections belong in the second column of a wide page, after those that are `earlier`."""
    if any(section.key == "optimise" for section in earlier):
        return builder is cases.leading_explorer_sections  # as long as all others
    # a case in motion fills most of a column
    shows_case = any(isinstance(block, Detail) for section in earlier for block in section.blocks)
    return builder in SECOND_COLUMN and (builder is not drivers.driver_sections or shows_case)


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
