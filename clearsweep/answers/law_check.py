"""Effect of the other valid laws on the deciding case of a run (`check_laws`)."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..language import wording
from .case_ranking import CaseRanking
from .judged import EXCEEDED, Cases, is_null
from .words import Words

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
        path, law = changed_law({path: table[path][index] for path in grid_laws}, grid_laws)
        column = ranking.candidates[int(candidate_numbers[index])].columns[0]
        rows.append(LawResult(case_id, path, law, column, float(worst_values[index])))
    return rows


def changed_law(laws: Mapping[str, Any], grid_laws: Mapping[str, str]) -> tuple[str, str]:
    """Return path and name of the law of a case that is not the grid's."""
    return next((path, law) for path, law in laws.items() if not is_null(law) and law != grid_laws[path])


def sentence(
    record: Mapping[str, Any], columns: Any, checks: tuple[Mapping[str, str], np.ndarray], words: Words, figure: str
) -> str:
    """Return whether the other laws change the verdict on the deciding case or, without limits, its figure.

    checks : path -> law of the grid, and a mask (n,) of the cases that check laws; figure : the leading column
    """
    grid_laws, is_checked = checks
    rows = np.flatnonzero(is_checked)
    changed = [changed_law({path: columns[path][row] for path in grid_laws}, grid_laws) for row in rows.tolist()]
    several = len({path.split(".")[1] for path, _ in changed}) > 1
    names = [f"{law} ({path.split('.')[1]})" if several else law for path, law in changed]
    count = f"{len(rows)} other valid law{'s' * (len(rows) != 1)}"
    if not words.limits:
        values = columns[figure][rows].astype(float)
        if not np.isfinite(values).any():
            return ""
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        texts = words.figures(figure, [float(values[low]), float(values[high])])
        spread = f"{texts[0]} ({names[low]})" + (f" to {texts[1]} ({names[high]})" if low != high else "")
        return f"The worst case under {count}: {words.figure(figure)} {spread}."
    cases = Cases(record, columns)
    verdicts = cases.verdicts[rows].tolist()
    unchecked = np.flatnonzero(~is_checked).tolist()
    base = next(row for row in unchecked if _is_same(record, columns, (rows[0], row), grid_laws))
    was_exceeded = cases.verdicts[base] == EXCEEDED
    changing = [name for name, verdict in zip(names, verdicts, strict=True) if (verdict == EXCEEDED) != was_exceeded]
    if not changing:
        return f"{count[0].upper()}{count[1:]} do{'es' * (len(rows) == 1)} not change the verdict on the worst case."
    more = [f"{len(changing) - MAX_NAMED_LAWS} more"] if len(changing) > MAX_NAMED_LAWS else []
    outcome = "meets the limits" if was_exceeded else "does not meet the limits"
    return (
        f"The verdict changes: the worst case {outcome} with {wording.sentence_list(changing[:MAX_NAMED_LAWS] + more)}."
    )


def _is_same(record: Mapping[str, Any], columns: Any, rows: tuple[int, int], grid_laws: Mapping[str, str]) -> bool:
    """Return whether two cases agree at all varied paths but the checked laws."""
    row, other = rows
    paths = [path for path in record["units"] if path not in grid_laws]
    return all(
        columns[path][row] == columns[path][other] or (is_null(columns[path][row]) and is_null(columns[path][other]))
        for path in paths
    )
