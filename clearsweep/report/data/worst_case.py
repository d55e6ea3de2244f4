"""The worst case of a run with respect to its grid's question, as in the last lines of the run."""

import numpy as np

from ...judging import case_ranking
from .study import Study


def question(study: Study) -> case_ranking.CaseRanking:
    """Return the ranking of the cases of a study."""
    return case_ranking.ranking_of(study.run.layout, study.limits, study.run.grid)


def worst_case(study: Study) -> tuple[str, case_ranking.Candidate] | None:
    """Return the worst case and the columns to show of it, or None if all are null."""
    lead, cases = question(study), study.cases
    if cases.empty or not lead.candidates or any(name not in cases for name in lead.columns):
        return None
    values, which = lead.worst_values({name: cases[name].to_numpy(float) for name in lead.columns})
    if np.isnan(values).all():
        return None
    badness = lead.badness(values)
    place = int(np.flatnonzero(badness == badness.max())[-1])  # of equal ones the last, as in the last lines of the run
    return cases.index[place], lead.candidates[int(which[place])]
