"""Effect of the other valid laws on the deciding case of a run (`check_laws`), in words."""

import itertools
import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ..language import wording
from .case_ranking import CaseRanking
from .verdict import MARGIN

MAX_NAMED_LAWS = 4  # laws that a sentence names


class LawResult(NamedTuple):
    """The deciding case under one other law."""

    case_id: str
    path: str  # of the law's name
    law: str
    column: str  # of the figure that ranks the cases
    value: float  # SI, nan for null


def law_results(table: Mapping[str, np.ndarray], grid_laws: Mapping[str, str], ranking: CaseRanking) -> list[LawResult]:
    """Return the results of the finished cases that check laws; grid_laws : path -> law of the grid."""
    worst_values, candidate_numbers = ranking.worst_values(table)
    rows = []
    for index, case_id in enumerate(table["case_id"].tolist()):
        laws = {path: table[path][index] for path in grid_laws}
        ((path, law),) = ((path, law) for path, law in laws.items() if law is not None and law != grid_laws[path])
        rows.append(
            LawResult(
                case_id,
                path,
                law,
                ranking.candidates[int(candidate_numbers[index])].columns[0],
                float(worst_values[index]),
            )
        )
    return rows


def law_check_sentence(
    deciding_case: LawResult, rows: list[LawResult], format_value: Callable[[str, float], str]
) -> str:
    """Return a sentence on whether other laws change the verdict on the deciding case.

    format_value : returns a value of a column in words
    """
    sorted_rows = sorted((row for row in rows if not math.isnan(row.value)), key=lambda row: row.value)
    noun = "other valid law" if len(rows) == 1 else "other valid laws"
    subject = f"case {wording.short_id(deciding_case.case_id)} under {len(rows)} {noun}"
    if not sorted_rows or math.isnan(deciding_case.value):
        return f"{subject}: no figure to compare."
    names = _law_names(sorted_rows)
    lowest_text, highest_text, grid_text = (
        _figure_text(row, format_value) for row in (sorted_rows[0], sorted_rows[-1], deciding_case)
    )
    range_text = f"{lowest_text} ({names[0]})" + (f" to {highest_text} ({names[-1]})" if len(sorted_rows) > 1 else "")
    prefix = "margin " if deciding_case.column == MARGIN else ""
    return (
        f"{subject}: {prefix}{range_text}; {grid_text} under the laws of the grid. "
        f"{_verdict_change_sentence(deciding_case, sorted_rows)}"
    )


def _figure_text(row: LawResult, format_value: Callable[[str, float], str]) -> str:
    return (
        f"{wording.short_number_text(100.0 * row.value, 3)} %"
        if row.column == MARGIN
        else format_value(row.column, row.value)
    )


def _law_names(rows: list[LawResult]) -> list[str]:
    """Return the names of the laws, with their joints if several joints have clearance."""
    joints = [row.path.split(".")[1] for row in rows]
    has_several_joints = len({*joints}) > 1
    return [f"{row.law}, {joint}" if has_several_joints else row.law for row, joint in zip(rows, joints, strict=True)]


def _verdict_change_sentence(deciding_case: LawResult, sorted_rows: list[LawResult]) -> str:
    """Return a sentence on whether another law changes the verdict or, without limits, the range of the figure."""
    if deciding_case.column != MARGIN:
        factors = [row.value / deciding_case.value for row in sorted_rows if deciding_case.value]
        if not factors:
            return "The figure is zero under the laws of the grid."
        low, high = (wording.number_text(factor, 3) for factor in (min(factors), max(factors)))
        return f"They give {' to '.join(dict.fromkeys((low, high)))} times the figure under the laws of the grid."
    is_changed = [(row.value >= 0.0) != (deciding_case.value >= 0.0) for row in sorted_rows]
    changing_laws = list(itertools.compress(_law_names(sorted_rows), is_changed))
    if not changing_laws:
        return "No law changes the verdict."
    names = [
        *changing_laws[:MAX_NAMED_LAWS],
        *([f"{len(changing_laws) - MAX_NAMED_LAWS} more"] if len(changing_laws) > MAX_NAMED_LAWS else []),
    ]
    outcome = "exceeds a limit" if deciding_case.value >= 0.0 else "meets the limits"
    return f"The verdict changes: the case {outcome} with {wording.sentence_list(names)}."
