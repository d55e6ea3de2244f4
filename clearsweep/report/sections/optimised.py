"""What a run optimised: the best case beside the one that the grid has written, the front, which limits bind."""

from typing import Any

import pandas as pd

from ...language import wording
from ..case_table import axis_columns
from ..picture import Picture
from ..section import Block, Gallery, Section, Sentences, filled
from ..study import Study
from ..table import Column, Table

WIDTH, HEIGHT = 6.5, 4.0  # inches
FRONT = 2  # cases, from which on there is a front to draw


def sections(study: Study) -> list[Section]:
    """Return the section; [] where nothing was optimised, or the run did not come to its end."""
    if "optimise" not in study.run.grid:
        return []
    frame = study.run.optimise
    if frame is None or frame.empty:
        return []
    asked = study.run.grid["optimise"]
    names = [name for sense in ("minimise", "maximise") for name in asked.get(sense, [])]
    rows = [{name: None if pd.isna(each) else each for name, each in row.items()} for row in frame.to_dict("records")]
    blocks: list[Block] = [Sentences(_sentences(study, rows)), Gallery("", _front(study, rows, names))]
    return [Section("optimise", "The best cases", filled([*blocks, _table(study, rows, names)]))]


def _sentences(study: Study, rows: list[dict[str, Any]]) -> list[str]:
    """Return what was found, and which limits bind."""
    looked_at = len(study.cases) + len(study.failed)
    lines = [f"The best case of {looked_at:,} that were tried."]
    if len(rows) > 1:
        lines = [f"The front: {len(rows)} of {looked_at:,} cases; none is worse than another in all objectives."]
    if rows[0]["margin"] is not None and rows[0]["margin"] < 0.0:
        lines.append(f"No case keeps to the limits; this one comes nearest. It exceeds {rows[0]['limiting']}.")
    elif binding := sorted({row["limiting"] for row in rows if row["limiting"]}):
        lines.append(f"The nearest limits are those on {wording.sentence_list(binding)}.")
    return lines


def _table(study: Study, rows: list[dict[str, Any]], names: list[str]) -> Table:
    """Return a row for each of the best cases."""
    columns = (
        *axis_columns(study, study.axes),
        *(Column(name, study.unit(name)) for name in names),
        Column("margin"),
        Column("nearest limit"),
    )
    found = []
    for row in rows:
        numbers = [float("nan") if row[name] is None else row[name] for name in (*names, "margin")]
        found.append((*(row[axis.path] for axis in study.axes), *numbers, row["limiting"] or wording.DASH))
    return Table("optimise", "The best cases", "", columns, found)


def _front(study: Study, rows: list[dict[str, Any]], names: list[str]) -> list[Picture]:
    """Return the front of two objectives among all finished cases."""
    if len(names) != 2 or len(rows) < FRONT:
        return []
    across, up = (study.scale(name) for name in names)

    def paint(ax: Any) -> None:
        every = [study.cases[name].to_numpy() / scale.factor for name, scale in zip(names, (across, up), strict=True)]
        best = [[row[name] / scale.factor for row in rows] for name, scale in zip(names, (across, up), strict=True)]
        ax.plot(*every, ".", color="0.7", markersize=4)
        ax.step(*best, "o-", where="post", markersize=4)
        ax.set_xlabel(f"{names[0]}, {across.unit}")
        ax.set_ylabel(f"{names[1]}, {up.unit}")

    title = "The front of both objectives"
    text = f"{title}: {len(rows)} cases; grey dots are all other finished cases."
    return [Picture(title, "Grey: all cases; line: the front.", text, paint, (WIDTH, HEIGHT))]
