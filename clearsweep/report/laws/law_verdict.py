"""Effect of the choice of a law on the designs that meet the limits."""

import numpy as np
import pandas as pd

from ...answers import verdict
from ...language import wording
from ..blocks.section import Part
from ..blocks.table import Column, Table, count_cell
from ..data.study import Study
from ..statistics.matching import MatchedCases, axis_key


def compare_verdicts(study: Study, matched_cases: MatchedCases) -> Part:
    """Return how the laws on an axis change the verdict at otherwise equal values; an empty Part without limits."""
    if verdict.EXCEEDED not in study.cases:
        return Part([], [], [])
    ids = matched_cases.pairs["case_id"]
    exceeds = (study.cases[verdict.EXCEEDED].reindex(ids) != "").to_numpy(float)
    pairs = matched_cases.pairs.assign(fails=exceeds, margin=study.cases[verdict.MARGIN].reindex(ids).to_numpy(float))
    table = pairs.pivot_table(index="group", columns="law", values="fails", aggfunc="max")
    table = table[table.count(axis=1) > 1]
    if table.empty:
        return Part([], [], [])
    compared = pairs[pairs["group"].isin(table.index)]
    return Part([_sentence(study, matched_cases, table)], [], [_table(matched_cases, compared)])


def _sentence(study: Study, matched_cases: MatchedCases, table: pd.DataFrame) -> str:
    """Return a sentence on the number of designs whose verdict depends on the law, and where."""
    changed = table[table.max(axis=1) > table.min(axis=1)]
    designs_text = wording.count_text(len(table), "design")
    if changed.empty:
        common_verdict = "meets the limits" if not table.max().max() else "exceeds a limit" if table.min().min() else ""
        reason = (
            f"each {common_verdict} with every law"
            if common_verdict
            else "each meets the limits with all laws, or with none"
        )
        return f"The choice of {matched_cases.axis.name} does not change the verdict on {designs_text}: {reason}."
    group = changed.index[0]
    row = changed.loc[group].dropna()
    meeting, exceeding = (
        [law for law, exceeds in row.items() if bool(exceeds) is is_exceeding] for is_exceeding in (False, True)
    )
    setting = study.setting(matched_cases.case_id(group, exceeding[0]), omitted_axis=matched_cases.axis)
    setting_text = f" at {setting}" if setting else ""
    example = (
        f"they are met with {wording.sentence_list(meeting)} and exceeded with "
        f"{wording.sentence_list(exceeding)}{setting_text}"
    )
    changed_count = f"{len(changed)} of {designs_text}"
    name = matched_cases.axis.name
    return f"The choice of {name} decides whether {changed_count} meet the limits. For example, {example}."


def _table(matched_cases: MatchedCases, compared: pd.DataFrame) -> Table:
    """Return, for each law, the number of designs that exceed a limit, and their margins."""
    rows = []
    for law in matched_cases.axis.values:
        rows_of_law = compared[compared["law"] == law]
        if len(rows_of_law):
            margins = rows_of_law["margin"].to_numpy()
            finite = margins[np.isfinite(margins)]
            margin_cells = (float(finite.min()), float(np.median(finite))) if len(finite) else (np.nan, np.nan)
            rows.append((law, count_cell(len(rows_of_law)), count_cell(int(rows_of_law["fails"].sum())), *margin_cells))
    headings = ("designs", "that exceed a limit", "smallest margin", "median margin")
    columns = (Column(matched_cases.axis.name), *map(Column, headings))
    note = (
        "The table lists the designs that finished with at least two of the laws. The margin is defined as in the "
        "verdict."
    )
    return Table(
        f"{axis_key(matched_cases.axis)}_verdict", f"The verdict, by {matched_cases.axis.name}", note, columns, rows
    )
