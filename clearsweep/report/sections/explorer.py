"""All cases, to be sorted, filtered and compared on the page itself."""

import numpy as np

from ..interactive import packed
from ..section import Block, Interactive, Note, Section
from ..shown import shown
from ..study import RATIO, Axis, Study

MOST = 4_400  # cases: a page stays below 3 MB
DRAWN = 5  # figures that are shown at first, besides the swept values
TABLES = ("forces", "wear", "output", "certainty")  # whose figures are there
WIDE = 8.0  # a figure whose values spread over a larger factor than this is drawn on a logarithmic scale


def sections(study: Study) -> list[Section]:
    """Return the section; [] of runs with one case."""
    if len(study.cases) < 2:
        return []
    kept = _kept(study)
    blocks: list[Block] = []
    if len(kept) < len(study.cases):
        blocks.append(Note(f"{len(kept)} of {len(study.cases)} cases: the worst ones, others drawn by lot."))
    data = {
        "ids": "".join(study.cases.index[kept]),
        "show": "clearsweep show DIR CASE",
        "columns": [*(_axis(study, axis, kept) for axis in study.swept()), *_figures(study, kept)],
    }
    without = "The tables below hold the same figures; sorting, filtering and comparing them here needs scripts."
    blocks.append(Interactive("explorer", "all-cases", "All cases, to sort, filter and compare", data, without))
    return [Section("explore", "Explore", blocks)]


def _kept(study: Study) -> np.ndarray:
    """Return the places of the cases that are shown, ascending; ids are hashes, so that the first of them are a lot."""
    if len(study.cases) <= MOST:
        return np.arange(len(study.cases))
    lead = study.cases[study.hardest_joint().column(study.lead.figure)].to_numpy(float)
    hardest = np.argsort(lead if study.lead.smallest else -lead, kind="stable")[: MOST // 2]
    return np.union1d(hardest, np.arange(MOST // 2))


def _axis(study: Study, axis: Axis, kept: np.ndarray) -> dict:
    values = study.cases[axis.path].iloc[kept]
    column = {"name": axis.name, "unit": axis.scale.unit, "axis": True, "drawn": True}
    if axis.numeric:
        return column | _numbers(axis.scale.of(values.to_numpy(float)))
    places = {value: place for place, value in enumerate(axis.values)}
    return column | {"words": list(axis.values), "values": packed([places.get(value, np.nan) for value in values])}


def _figures(study: Study, kept: np.ndarray) -> list[dict]:
    """Return the figures of all joints and of the mechanism, each once."""
    headings: dict[str, str] = {}
    for table in TABLES:
        for name, heading in shown(study, table):
            headings.setdefault(name, heading)
    lead = study.hardest_joint().column(study.lead.figure)
    first = [name for name in headings if study.has(name)]
    first.sort(key=lambda name: name != lead)
    drawn = {*first[:DRAWN], *(joint.column(RATIO) for joint in study.joints[:1])}
    columns = []
    for name in first:
        scale = study.scale(name)
        column = {"name": headings[name], "unit": scale.unit, "drawn": name in drawn, "lead": name == lead}
        columns.append(column | _numbers(study.cases[name].to_numpy(float)[kept] / scale.factor))
    return columns


def _numbers(values: np.ndarray) -> dict:
    known = values[np.isfinite(values)]
    wide = known.size and known.min() > 0.0 and known.max() > WIDE * known.min()
    return {"values": packed(values), "wide": bool(wide)}
