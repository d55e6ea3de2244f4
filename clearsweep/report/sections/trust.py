"""Reliability of the figures: failures, ranges of laws, periodicity, convergence, budget of unknowns."""

from markupsafe import Markup

from ..blocks.section import Points, Section, without_empty
from ..data.study import Study
from ..samples import counts
from . import budget, elastic_laws, elastic_links, headline, law_choice

NO_BUDGET = Markup(
    "This page has no error budget, because the run does not vary each unknown separately. "
    "<code>configs/error_budget.yaml</code> shows such a run."
)


def sections(study: Study) -> list[Section]:
    """Return the section."""
    return [Section("trust", "Reliability of the results", without_empty([Points(reliability_points(study))]))]


def reliability_points(study: Study) -> list[str]:
    """Return failures and warnings of the run, then a sentence each on laws, convergence and unknowns."""
    return [*_failure_points(study), *_warnings(study), *([] if study.cases.empty else _finished_case_points(study))]


def _failure_points(study: Study) -> list[str]:
    finished, failed = counts.finished_and_failed(study)
    if not failed or not finished:
        return []
    cases = Markup('<a href="#failures">{} of {} cases failed</a>').format(failed, failed + finished)
    return [cases + ". All results except the list of failures exclude them."]


def _warnings(study: Study) -> list[str]:
    return [Markup("<b>Warning:</b> {}").format(warning) for warning in study.run.grid.get("warnings") or []]


def _finished_case_points(study: Study) -> list[str]:
    periodicity = " ".join(headline.periodicity_sentences(study))
    sentences = [
        *headline.law_range_remarks(study),
        *([periodicity] if periodicity else []),
        *elastic_laws.recommendation_texts(study),
    ]
    for section in (*law_choice.sections(study), *elastic_laws.sections(study)):
        sentences += [_with_link(section, sentence) for sentence in section.sentences[:1]]
    for section in elastic_links.sections(study):
        sentences.append(_with_link(section, " ".join(section.sentences[:2])))
    budget_sections = budget.sections(study)
    budget_points = [_with_link(section, " ".join(section.sentences[1:2])) for section in budget_sections]
    return [*sentences, *(budget_points or [NO_BUDGET])]


def _with_link(section: Section, sentence: str) -> str:
    """Return a sentence of a folded section with a link to it."""
    return Markup('{} <a href="#{}">{}</a>').format(sentence, section.key, "More.")
