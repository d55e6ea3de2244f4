"""Selects comparable figures: it leaves out starts that ended before the motor reached its speed."""

import numpy as np

from ...answers.case_ranking import MAX_SPEED, SPEED_AFTER_START, START_UP
from .study import Study
from .worst_case import case_ranking_of

EXCLUDED_STARTS_NOTE = " Starts that were cut off before the motor's speed are left out."


def comparable_values(study: Study, column: str) -> np.ndarray:
    """Return a figure of the finished cases (n,) in SI, NaN for null and for starts that were cut off."""
    values = study.cases[column].to_numpy(float)
    if not excludes_cut_off_starts(study, column):
        return values
    finished = np.where(_is_cut_off(study), np.nan, values)
    return finished if np.isfinite(finished).any() else values


def excludes_cut_off_starts(study: Study, column: str) -> bool:
    """Return whether a figure leaves out starts that were cut off."""
    return column not in (START_UP, MAX_SPEED, SPEED_AFTER_START) and bool(_is_cut_off(study).any())


def _is_cut_off(study: Study) -> np.ndarray:
    """Return which starts did not reach the motor's speed; none if all or nothing starts."""
    count = len(study.cases)
    if case_ranking_of(study).question != "start-up" or not study.has(START_UP):
        return np.zeros(count, bool)
    is_cut_off: np.ndarray = np.isnan(study.cases[START_UP].to_numpy(float))
    return is_cut_off
