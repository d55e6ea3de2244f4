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
    tradeoffs,
    trends,
    trust,
    verdict,
    wear,
)

Makes = Callable[[Study], list[Section]]
SECTIONS: tuple[Makes, ...] = (  # seen at once, in the order of the page
    summary.sections,
    verdict.sections,
    seek.sections,
    optimised.sections,
    explorer.leading,
    identified.sections,
    sample.sections,
    cases.sections,
    drivers.sections,
    sample.leading,
    trust.sections,
    lasting.sections,
)
#: In the second column of a wide page; where no case is played, what drives it is in the first.
SECOND = (*SECTIONS[SECTIONS.index(drivers.sections) :], explorer.leading)
MORE: tuple[tuple[str, tuple[Makes, ...]], ...] = (  # folded below them, by subject
    (
        "Forces and output",
        (
            verdict.more,
            optimised.more,
            headline.sections,
            curves.sections,
            maps.sections,
            drivers.more,
            sample.more,
            tradeoffs.sections,
        ),
    ),
    (
        "Motion",
        (peak_revolution.sections, cases.others, motion_type.sections, films.sections),
    ),
    ("Wear and life", (life.sections, wear.sections, trends.sections)),
    (
        "Laws and errors",
        (
            identified.more,
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


def _long(section: Section) -> bool:
    """Return whether a section shows a case in motion, which fills most of a column."""
    return any(isinstance(block, Detail) for block in section.blocks)


def _is_second(sections: Makes, listed: list[Section]) -> bool:
    """Return whether sections belong in the second column of a wide page, after those that are `listed`."""
    if any(section.key == "optimise" for section in listed):
        return sections is explorer.leading  # as long as all others
    return sections in SECOND and (sections is not drivers.sections or any(map(_long, listed)))


def of(study: Study) -> list[Section]:
    """Return the non-empty sections of a run."""
    listed: list[Section] = []
    every = [("", sections) for sections in SECTIONS]
    every += [(subject, sections) for subject, folded in MORE for sections in folded]
    with phases.phase("preparing the report") as preparing:
        for number, (subject, sections) in enumerate(every):
            preparing.note(share=number / len(every))
            made = [section for section in sections(study) if section.blocks]
            second = _is_second(sections, listed)
            placed = [section._replace(subject=subject, second=second) for section in made]
            listed += [counts.with_note(study, section) for section in placed]
    return listed
