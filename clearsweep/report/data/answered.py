"""The answer of a study, the same value as in answer.json, and its words."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...answers.cases import FinishedCases
from ...answers.words import Words
from ...store import answer_of
from .study import Study


def answer_of_study(study: Study) -> Mapping[str, Any]:
    """Return the answer of the run of a study."""
    answer: Mapping[str, Any] = study.cases.cached(("answer",), lambda: answer_of(study.run))
    return answer


def words_of(study: Study) -> Words:
    """Return the words of the run of a study."""
    return Words(study.run.grid, study.run.layout, finished_cases(study).values_of)


def finished_cases(study: Study) -> FinishedCases:
    """Return the finished cases of a study as the room of answers reads them."""

    def values(name: str) -> np.ndarray:
        column: np.ndarray = study.cases.index.to_numpy() if name == "case_id" else study.cases[name].to_numpy()
        return column

    return FinishedCases(study.run.grid, study.run.layout, tuple(axis.path for axis in study.swept()), values)
