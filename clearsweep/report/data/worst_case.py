"""The worst case of a run with respect to its grid's question, as in the last lines of the run."""

import numpy as np

from ...answers import case_ranking
from .study import Study


def case_ranking_of(study: Study) -> case_ranking.CaseRanking:
    """Return the ranking of the cases of a study."""
    return case_ranking.ranking_of(study.run.layout, study.limits, study.run.grid)


def worst_case(study: Study) -> tuple[str, case_ranking.Candidate] | None:
    """Return the worst case and the columns to show of it, or None if all are null."""
    ranking, cases = case_ranking_of(study), study.cases
    if cases.empty or not ranking.candidates or any(name not in cases for name in ranking.columns):
        return None
    columns = {name: cases[name].to_numpy() for name in ranking.columns}
    values, candidate_indices = ranking.worst_values(columns)
    if np.isnan(values).all():
        return None
    severity = ranking.severity(values, columns)
    row = int(np.flatnonzero(severity == severity.max())[-1])  # of equal ones the last, as in the last lines of the run
    return cases.index[row], ranking.candidates[int(candidate_indices[row])]
