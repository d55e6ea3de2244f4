"""Table of all cases, which can be sorted, filtered and compared on the page."""

import numpy as np

from ...grid.sections.optimise import SENSES
from ...judging.verdict import MARGIN
from ..blocks.interactive import encode_floats
from ..blocks.section import Block, Interactive, Note, Section
from ..data.axis import Axis
from ..data.study import P99_OVER_IDEAL, Study
from ..data.table_columns import columns_in_table

MOST = 4_400  # cases: a page stays below 3 MB
LEADING_ROWS = 8  # of the table where it is seen at once
DRAWN = 5  # figures displayed at first, besides the swept values
TABLES = ("forces", "wear", "output", "certainty")  # tables whose figures are available
WIDE = 8.0  # ratio of largest to smallest value above which an axis is logarithmic


def leading(study: Study) -> list[Section]:
    """Return the section of an optimised run, whose best cases are marked, or [] for other runs."""
    return _sections(study, "Cases that were tried") if _objectives(study) else []


def sections(study: Study) -> list[Section]:
    """Return the section; [] for runs with one case, or if it comes first."""
    return [] if _objectives(study) else _sections(study, "Explore")


def _sections(study: Study, title: str) -> list[Section]:
    if len(study.cases) < 2:
        return []
    kept = _kept(study)
    blocks: list[Block] = []
    if len(kept) < len(study.cases):
        blocks.append(Note(f"{len(kept)} of {len(study.cases)} cases: the worst ones, and others chosen at random."))
    columns = [*(_axis(study, axis, kept) for axis in study.swept()), *_figures(study, kept)]
    data = {"ids": "".join(study.cases.index[kept]), "show": "clearsweep show DIR CASE", "columns": columns}
    if _objectives(study):
        data |= _marked(study, kept, columns)
    without = "The tables below contain the same figures. Sorting, filtering and comparing them here needs scripts."
    blocks.append(Interactive("explorer", "all-cases", "All cases, to sort, filter and compare", data, without))
    return [Section("explore", title, blocks)]


def _objectives(study: Study) -> list[str]:
    """Return the objectives of an optimised run, or [] for other runs."""
    asked = study.run.grid.get("optimise") or {}
    return [name for sense in SENSES for name in asked.get(sense, []) if study.has(name)]


def _best(study: Study) -> np.ndarray:
    """Return the best cases of an optimised run."""
    rows = study.run.optimise if _objectives(study) else None
    best: np.ndarray = study.cases.index.isin([] if rows is None else rows["case_id"].tolist())
    return best


def _marked(study: Study, kept: np.ndarray, columns: list[dict]) -> dict:
    """Return the marked cases of an optimised run, and the columns that its points show first.

    With several objectives these are the first two, else the first swept value and the objective.
    """
    swept = [place for place, column in enumerate(columns) if column.get("axis")]
    asked = [place for place, column in enumerate(columns) if column.get("objective")]
    across, up, *_ = (asked + swept) if len(asked) > 1 else (swept + asked)[:1] + asked
    return {
        "marked": np.flatnonzero(_best(study)[kept]).tolist(),
        "note": "The best cases are marked.",
        "points": [across, up, swept[0] if len(asked) > 1 else swept[-1]],
        "rows": LEADING_ROWS,
    }


def _kept(study: Study) -> np.ndarray:
    """Return the indices of the displayed cases, ascending; ids are hashes, so the first ones are random."""
    if len(study.cases) <= MOST:
        return np.arange(len(study.cases))
    if _objectives(study):
        return np.union1d(np.flatnonzero(_best(study))[: MOST // 2], np.arange(MOST // 2))
    lead = study.cases[study.hardest_joint().column(study.lead.figure)].to_numpy(float)
    hardest = np.argsort(lead if study.lead.smallest else -lead, kind="stable")[: MOST // 2]
    return np.union1d(hardest, np.arange(MOST // 2))


def _axis(study: Study, axis: Axis, kept: np.ndarray) -> dict:
    values = study.cases[axis.path].iloc[kept]
    column = {"name": axis.name, "unit": axis.scale.unit, "axis": True, "drawn": True}
    if axis.numeric:
        return column | _numbers(axis.scale.of(values.to_numpy(float)))
    places = {value: place for place, value in enumerate(axis.values)}
    return column | {
        "words": list(axis.values),
        "values": encode_floats([places.get(value, np.nan) for value in values]),
    }


def _figures(study: Study, kept: np.ndarray) -> list[dict]:
    """Return the figures of all joints and of the mechanism, each once; objectives of an optimised run come first."""
    asked = _objectives(study)
    headings = {name: name for name in asked + [MARGIN] * bool(asked)}  # as the grid has them
    leading = len(headings)
    for table in TABLES:
        for name, heading in columns_in_table(study, table):
            headings.setdefault(name, heading)
    lead = asked[0] if asked else study.hardest_joint().column(study.lead.figure)
    first = [name for name in headings if study.has(name)]
    if not asked:
        first.sort(key=lambda name: name != lead)
    drawn = {*first[:DRAWN], *(joint.column(P99_OVER_IDEAL) for joint in study.joints[:1])}
    drawn = {*list(headings)[:leading]} or drawn
    small = (study.run.grid.get("optimise") or {}).get(SENSES[0], [])
    columns = []
    for name in first:
        scale = study.scale(name)
        column = {"name": headings[name], "unit": scale.unit, "drawn": name in drawn, "lead": name == lead}
        column |= {"objective": True, "rising": name in small} if name in asked else {}
        columns.append(column | _numbers(study.cases[name].to_numpy(float)[kept] / scale.factor))
    return columns


def _numbers(values: np.ndarray) -> dict:
    known = values[np.isfinite(values)]
    wide = known.size and known.min() > 0.0 and known.max() > WIDE * known.min()
    return {"values": encode_floats(values), "wide": bool(wide)}
