"""Table of all cases, which can be sorted, filtered and compared on the page."""

import numpy as np

from ...answers.verdict import MARGIN
from ...grid.sections.optimise import SENSES
from ..blocks.interactive import encode_floats
from ..blocks.section import Block, Interactive, Note, Section
from ..data.axis import Axis
from ..data.study import P99_OVER_IDEAL, Study
from ..data.table_columns import columns_in_table

MAX_CASES = 4_400  # cases: a page stays below 3 MB
LEADING_ROWS = 8  # of the table where it is seen at once
MAX_FIGURES_SHOWN = 5  # figures displayed at first, besides the swept values
TABLES = ("forces", "wear", "output", "certainty")  # tables whose figures are available
LOG_SCALE_RATIO = 8.0  # ratio of largest to smallest value above which an axis is logarithmic


def leading_sections(study: Study) -> list[Section]:
    """Return the section of an optimised run, whose best cases are marked, or [] for other runs."""
    return _sections(study, "Cases that were tried") if _objectives(study) else []


def sections(study: Study) -> list[Section]:
    """Return the section; [] for runs with one case, or if it comes first."""
    return [] if _objectives(study) else _sections(study, "Explore")


def _sections(study: Study, title: str) -> list[Section]:
    if len(study.cases) < 2:
        return []
    case_indices = _displayed_cases(study)
    blocks: list[Block] = []
    if len(case_indices) < len(study.cases):
        blocks.append(
            Note(f"{len(case_indices)} of {len(study.cases)} cases: the worst ones, and others chosen at random.")
        )
    columns = [
        *(_axis_column(study, axis, case_indices) for axis in study.swept()),
        *_figure_columns(study, case_indices),
    ]
    data = {"ids": "".join(study.cases.index[case_indices]), "show": "clearsweep show DIR CASE", "columns": columns}
    if _objectives(study):
        data |= _marks_data(study, case_indices, columns)
    fallback_text = (
        "The tables below contain the same figures. Sorting, filtering and comparing them here needs scripts."
    )
    blocks.append(Interactive("explorer", "all-cases", "All cases, to sort, filter and compare", data, fallback_text))
    return [Section("explore", title, blocks)]


def _objectives(study: Study) -> list[str]:
    """Return the objectives of an optimised run, or [] for other runs."""
    section = study.run.grid.get("optimise") or {}
    return [name for sense in SENSES for name in section.get(sense, []) if study.has(name)]


def _is_best(study: Study) -> np.ndarray:
    """Return the best cases of an optimised run."""
    rows = study.run.optimise if _objectives(study) else None
    is_best: np.ndarray = study.cases.index.isin([] if rows is None else rows["case_id"].tolist())
    return is_best


def _marks_data(study: Study, case_indices: np.ndarray, columns: list[dict]) -> dict:
    """Return the marked cases of an optimised run, and the columns that its points show first.

    With several objectives these are the first two, else the first swept value and the objective.
    """
    swept_columns = [index for index, column in enumerate(columns) if column.get("axis")]
    objective_columns = [index for index, column in enumerate(columns) if column.get("objective")]
    x_column, y_column, *_ = (
        (objective_columns + swept_columns)
        if len(objective_columns) > 1
        else (swept_columns + objective_columns)[:1] + objective_columns
    )
    return {
        "marked": np.flatnonzero(_is_best(study)[case_indices]).tolist(),
        "note": "The best cases are marked.",
        "points": [x_column, y_column, swept_columns[0] if len(objective_columns) > 1 else swept_columns[-1]],
        "rows": LEADING_ROWS,
    }


def _displayed_cases(study: Study) -> np.ndarray:
    """Return the indices of the displayed cases, ascending; ids are hashes, so the first ones are random."""
    if len(study.cases) <= MAX_CASES:
        return np.arange(len(study.cases))
    if _objectives(study):
        return np.union1d(np.flatnonzero(_is_best(study))[: MAX_CASES // 2], np.arange(MAX_CASES // 2))
    lead = study.cases[study.most_loaded_joint().column(study.lead.figure)].to_numpy(float)
    hardest = np.argsort(lead if study.lead.smallest else -lead, kind="stable")[: MAX_CASES // 2]
    return np.union1d(hardest, np.arange(MAX_CASES // 2))


def _axis_column(study: Study, axis: Axis, case_indices: np.ndarray) -> dict:
    values = study.cases[axis.path].iloc[case_indices]
    column = {"name": axis.name, "unit": axis.scale.unit, "axis": True, "drawn": True}
    if axis.is_numeric:
        return column | _encoded_numbers(axis.scale.from_si(values.to_numpy(float)))
    index_of_value = {value: index for index, value in enumerate(axis.values)}
    return column | {
        "words": list(axis.values),
        "values": encode_floats([index_of_value.get(value, np.nan) for value in values]),
    }


def _figure_columns(study: Study, case_indices: np.ndarray) -> list[dict]:
    """Return the figures of all joints and of the mechanism, each once; objectives of an optimised run come first."""
    objectives = _objectives(study)
    headings = {name: name for name in objectives + [MARGIN] * bool(objectives)}  # as the grid has them
    objective_count = len(headings)
    for table in TABLES:
        for name, heading in columns_in_table(study, table):
            headings.setdefault(name, heading)
    lead_column = objectives[0] if objectives else study.most_loaded_joint().column(study.lead.figure)
    names = [name for name in headings if study.has(name)]
    if not objectives:
        names.sort(key=lambda name: name != lead_column)
    drawn_names = {*names[:MAX_FIGURES_SHOWN], *(joint.column(P99_OVER_IDEAL) for joint in study.joints[:1])}
    drawn_names = {*list(headings)[:objective_count]} or drawn_names
    minimised = (study.run.grid.get("optimise") or {}).get(SENSES[0], [])
    columns = []
    for name in names:
        scale = study.scale(name)
        column = {"name": headings[name], "unit": scale.unit, "drawn": name in drawn_names, "lead": name == lead_column}
        column |= {"objective": True, "rising": name in minimised} if name in objectives else {}
        columns.append(column | _encoded_numbers(study.cases[name].to_numpy(float)[case_indices] / scale.factor))
    return columns


def _encoded_numbers(values: np.ndarray) -> dict:
    finite = values[np.isfinite(values)]
    is_wide = finite.size and finite.min() > 0.0 and finite.max() > LOG_SCALE_RATIO * finite.min()
    return {"values": encode_floats(values), "wide": bool(is_wide)}
