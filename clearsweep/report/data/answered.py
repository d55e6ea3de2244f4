"""The finished cases of a study, prepared for the sentences that answer the question of its grid."""

from collections.abc import Sequence

import numpy as np

from ...answers import answer
from ...answers.cases import FinishedCases, column_texts
from .study import Study
from .worst_case import case_ranking_of


def answer_sentences(study: Study) -> list[str]:
    """Return the sentences that answer the question of the grid, or [] if a figure that ranks cases is not stored."""
    if any(name not in study.cases for name in case_ranking_of(study).columns):
        return []
    return answer.sentences(answer_cases(study))


def answer_cases(study: Study) -> FinishedCases:
    """Return the finished cases of a study for `answers.answer`."""
    axes = {axis.path: axis for axis in study.swept()}
    ids = study.cases.index

    def column(name: str) -> np.ndarray:
        values: np.ndarray = study.cases[name].to_numpy()
        return values

    def describe_value(index: int, path: str) -> tuple[str, str] | None:
        value = study.value(ids[index], path) if path in axes else None
        return None if value is None else (axes[path].name, axes[path].text(value))

    def texts(name: str, values: Sequence[float]) -> list[str]:
        return column_texts(name, study.unit(name), column(name), values)

    return FinishedCases(
        study.run.grid, study.run.layout, case_ranking_of(study), tuple(axes), list(ids), column, texts, describe_value
    )
