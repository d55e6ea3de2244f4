"""The sections of the report, one a module: each takes a study and returns what there is to show, if anything."""

from collections.abc import Callable

from ...language import phases
from ..section import Section
from ..study import Study
from . import (
    budget,
    cases,
    curves,
    drivers,
    elastic_laws,
    explorer,
    failures,
    films,
    headline,
    identified,
    law_choice,
    life,
    maps,
    mechanism,
    motion_type,
    optimised,
    peak_revolution,
    peaks,
    sample,
    setup,
    sought,
    summary,
    tradeoffs,
    trends,
    verdict,
    wear,
)

SECTIONS: tuple[Callable[[Study], list[Section]], ...] = (  # in the order of the page
    summary.sections,
    verdict.sections,
    sought.sections,
    optimised.sections,
    identified.sections,
    mechanism.sections,
    headline.sections,
    budget.sections,
    sample.sections,
    curves.sections,
    peak_revolution.sections,
    cases.sections,
    motion_type.sections,
    films.sections,
    life.sections,
    wear.sections,
    trends.sections,
    drivers.sections,
    maps.sections,
    tradeoffs.sections,
    law_choice.sections,
    elastic_laws.sections,
    explorer.sections,
    peaks.sections,
    failures.sections,
    setup.sections,
)


def of(study: Study) -> list[Section]:
    """Return the sections of a run that have anything to show."""
    found: list[Section] = []
    with phases.phase("preparing the report") as preparing:
        for number, sections in enumerate(SECTIONS):
            preparing.note(share=number / len(SECTIONS))
            found += [section for section in sections(study) if section.blocks]
    return found
