"""The deciding case under the other valid laws of its joints, if the grid requests it (`check_laws`)."""

import math

from ...answers import law_check
from ...answers.verdict import MARGIN
from ...answers.words import case_margin_text
from ...language import wording
from ..blocks.section import Points, Section, without_empty
from ..blocks.table import Column, Quantity, Table
from ..data.answered import answer_of_study
from ..data.study import Study
from ..data.worst_case import worst_case


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no law is checked."""
    points = [answer_of_study(study)["laws"]] if answer_of_study(study).get("laws") else []
    return [Section("law_check", "The deciding case under other laws", without_empty([Points(points), _table(study)]))]


def _base_result(study: Study) -> law_check.LawResult | None:
    """Return the worst case of the grid under the laws of the grid, or None if no law is checked."""
    worst = worst_case(study)
    if worst is None:
        return None
    case_id, candidate = worst
    column = candidate.columns[0]
    return law_check.LawResult(case_id, "", "", column, float(study.cases.at[case_id, column]))


def _value_text(study: Study, column: str, value: float) -> str:
    if math.isnan(value):
        return wording.DASH
    if column == MARGIN:
        return case_margin_text(value, study.limits, "" if value >= 0.0 else study.limits[0].column)
    is_hours = column.endswith("_life_hours")
    return (
        f"{wording.number_text(value)}{wording.BLANK}h"
        if is_hours
        else wording.quantity_text(value, study.unit(column))
    )


def _table(study: Study) -> Table:
    """Return the leading figure of the case under each law."""
    base_result = _base_result(study)
    columns = (Column("joint"), Column("law"), Column("of"), Column("figure"), Column("value"), Column("case_id"))
    if base_result is None or not study.law_checks:
        return Table("law_check", "", "", columns, [])
    rows = []
    for row in sorted(study.law_checks, key=lambda row: (math.isnan(row.value), row.value)):
        _, joint, _, family = row.path.split(".")
        value = Quantity(row.value, _value_text(study, row.column, row.value))
        kind = "elastic" if family == "elastic" else "contact"
        rows.append((joint, row.law, kind, row.column.replace("_", " "), value, row.case_id))
    note = (
        f"With the laws of the grid: {_value_text(study, base_result.column, base_result.value)} (case "
        f"{wording.short_id(base_result.case_id)})."
    )
    return Table("law_check", "Results under each other valid law", note, columns, rows)
