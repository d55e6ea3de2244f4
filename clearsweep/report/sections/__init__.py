"""The sections of the report, one per module: each takes a study and returns its non-empty sections."""

from collections.abc import Callable

from ...language import phases
from ..blocks.section import Detail, Section
from ..data.study import Study
from ..samples import counts
from . import (
    budget,
    cases,
    curves,
    drivers,
    elastic_laws,
    elastic_links,
    explorer,
    failures,
    films,
    headline,
    identified,
    lasting,
    law_check,
    law_choice,
    life,
    maps,
    mechanism,
    motion_type,
    optimised,
    peak_revolution,
    peaks,
    sample,
    seek,
    setup,
    summary,
    tolerances,
    tradeoffs,
    trends,
    trust,
    verdict,
    wear,
)

SectionBuilder = Callable[[Study], list[Section]]
UNFOLDED: tuple[SectionBuilder, ...] = (  # seen at once, in the order of the page
    summary.sections,
    verdict.sections,
    seek.sections,
    optimised.sections,
    explorer.leading_sections,
    identified.sections,
    sample.sections,
    cases.sections,
    drivers.sections,
    sample.leading_sections,
    trust.sections,
    lasting.sections,
)
#: In the second column of a wide page; where no case is played, what drives it is in the first.
SECOND_COLUMN = (*UNFOLDED[UNFOLDED.index(drivers.sections) :], explorer.leading_sections)
FOLDED: tuple[tuple[str, tuple[SectionBuilder, ...]], ...] = (  # folded below them, by subject
    (
        "Forces and output",
        (
            verdict.folded_sections,
            optimised.folded_sections,
            headline.sections,
            curves.sections,
            maps.sections,
            drivers.folded_sections,
            sample.folded_sections,
            tradeoffs.sections,
        ),
    ),
    (
        "Motion",
        (peak_revolution.sections, cases.other_cases_sections, motion_type.sections, films.sections),
    ),
    ("Wear and life", (life.sections, wear.sections, trends.sections)),
    (
        "Laws and errors",
        (
            identified.folded_sections,
            tolerances.sections,
            budget.sections,
            law_check.sections,
            law_choice.sections,
            elastic_laws.sections,
            elastic_links.sections,
        ),
    ),
    ("All cases", (explorer.sections, peaks.sections, failures.sections)),
    ("Setup", (mechanism.sections, setup.sections)),
)


def _shows_case(section: Section) -> bool:
    """Return whether a section shows a case in motion, which fills most of a column."""
    return any(isinstance(block, Detail) for block in section.blocks)


def _is_in_second_column(builder: SectionBuilder, earlier: list[Section]) -> bool:
    """Return whether sections belong in the second column of a wide page, after those that are `earlier`."""
    if any(section.key == "optimise" for section in earlier):
        return builder is explorer.leading_sections  # as long as all others
    return builder in SECOND_COLUMN and (builder is not drivers.sections or any(map(_shows_case, earlier)))


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
            finished_sections += [counts.with_note(study, section) for section in placed_sections]
    return finished_sections
