"""Result of `optimise`: the best case and the case as written in the grid, the front, the binding limits."""

from typing import Any

import numpy as np
import pandas as pd

from ...grid.sections.optimise import SENSES
from ...language import quantity, wording
from ..blocks.case_table import axis_columns
from ..blocks.picture import Picture
from ..blocks.section import Block, Gallery, Section, Sentences, without_empty
from ..blocks.table import Column, Quantity, Table
from ..data.dotted_paths import value_at
from ..data.study import Study
from ..data.table_columns import column_label

WIDTH, HEIGHT = 6.5, 4.0  # inches
AT_ONCE = 8  # rows of the best cases that the page shows at first
FRONT = 2  # cases from which a front is drawn


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing was optimised, or the run did not end."""
    known = _known(study)
    if known is None:
        return []
    (rows, names), start = known, _start(study)
    texts = [*_sentences(study, rows), *_beside_start(study, rows, names, start), *_distinguished(study, rows, names)]
    table = _table(study, rows, names, start)
    blocks: list[Block] = [Sentences(texts), _first(table)]
    return [Section("optimise", "The best cases", without_empty(blocks))]


def ends(study: Study) -> list[tuple[str, str]]:
    """Return each objective and the case in which it is best, or [] without an answer."""
    known = _known(study)
    if known is None:
        return []
    rows, smaller = [row for row in known[0] if row["case_id"] in study.cases.index], _senses(study)[0]
    best_cases = []
    for name in known[1]:
        valued = [row for row in rows if row[name] is not None]
        if valued:
            best = min(valued, key=lambda row: row[name] * (1.0 if name in smaller else -1.0))
            best_cases.append((name, str(best["case_id"])))
    return best_cases


def answers(study: Study) -> list[str]:
    """Return a sentence for each objective on the best case for it."""
    return [
        f"Best {name}: {study.text(case_id, name)} at {study.setting(case_id)}, case {wording.short_id(case_id)}."
        for name, case_id in ends(study)
    ]


def _senses(study: Study) -> list[list[str]]:
    """Return a list of the minimised objectives and a list of the maximised ones."""
    return [study.run.grid["optimise"].get(sense, []) for sense in SENSES]


def more(study: Study) -> list[Section]:
    """Return sections with all best cases, their front, and every case as a line; [] if `sections` returns []."""
    known = _known(study)
    if known is None:
        return []
    rows, names = known
    table = _table(study, rows, names, _start(study))
    whole = [table] if len(table.rows) > AT_ONCE else []
    pictures = [*_front(study, rows, names), *_parallel(study, rows, names)]
    return [Section("optimise-more", "All best cases", without_empty([*whole, Gallery("", pictures)]))]


def _known(study: Study) -> tuple[list[dict[str, Any]], list[str]] | None:
    """Return the best cases as rows and the names of the objectives, or None if there is no answer."""
    if "optimise" not in study.run.grid:
        return None
    frame = study.run.optimise
    if frame is None or frame.empty:
        return None
    names = [name for sense in _senses(study) for name in sense]
    rows = [{name: None if pd.isna(each) else each for name, each in row.items()} for row in frame.to_dict("records")]
    return rows, names


def _first(table: Table) -> Table:
    """Return a table without most rows of a long front: its first rows and others at equal steps."""
    if len(table.rows) <= AT_ONCE:
        return table
    places = np.linspace(0, len(table.rows) - 1, AT_ONCE).round().astype(int)
    note = (
        f"These are {AT_ONCE} of {len(table.rows)} rows, at equal steps. The section below under More lists all rows."
    )
    return table._replace(key="optimise-first", note=note, rows=[table.rows[place] for place in places], is_file=False)


def _start(study: Study) -> str | None:
    """Return the case as written in the grid, or None if it was not tried or failed."""
    same = np.ones(len(study.cases), bool)
    for axis in study.axes:
        written = value_at(study.run.grid, axis.path)
        if isinstance(written, str) and axis.numeric:  # of `define`: with its unit
            written = quantity.value_and_dimension(written)[0]
        if written is None:
            return None
        values = study.cases[axis.path].to_numpy()
        same &= np.isclose(values, written, rtol=1e-9) if axis.numeric else values == written
    return str(study.cases.index[int(np.argmax(same))]) if same.any() else None


def _beside_start(study: Study, rows: list[dict[str, Any]], names: list[str], start: str | None) -> list[str]:
    """Return the improvement of the best case over the case as written in the grid."""
    if start is None or len(rows) > 1:
        return []
    sentences = []
    for name in names:
        best, before = rows[0][name], float(study.cases.at[start, name])
        change = f" ({100.0 * (best / before - 1.0):+.3g} %)" if before else ""
        sentences.append(f"{name} {study.text(rows[0]['case_id'], name)} instead of {study.text(start, name)}{change}")
    return [f"Compared with the case of the grid: {wording.sentence_list(sentences)}."]


def _distinguished(study: Study, rows: list[dict[str, Any]], names: list[str]) -> list[str]:
    """Return, for each objective with an interval, the cases that cannot be distinguished from the best one."""
    lines = []
    for name in names:
        ends = [f"{name}_{end}" for end in ("low", "high")]
        if len(rows) > 1 or rows[0]["case_id"] not in study.cases.index or not all(map(study.has, ends)):
            continue
        low, high = (study.cases[end].to_numpy(float) for end in ends)
        place = study.cases.index.get_loc(rows[0]["case_id"])
        if np.isnan([low[place], high[place]]).any():
            continue
        within = " within the limits" if rows[0]["limiting"] else ""
        feasible = study.cases["limits_exceeded"].to_numpy() == "" if "limits_exceeded" in study.cases else True
        alike = int(np.count_nonzero((low <= high[place]) & (high >= low[place]) & feasible)) - 1
        if rows[0]["margin"] is not None and rows[0]["margin"] < 0.0:
            continue  # no case meets the limits, so none of the others is best either
        own = " to ".join(study.text(rows[0]["case_id"], end) for end in ends)
        lines.append(
            f"The 95 % interval of {name} of the best case is {own}; {wording.count(alike, 'other case')}"
            f"{within} cannot be distinguished from it, as their intervals overlap."
        )
    lines += [
        f"In chaotic motion {name}, the largest peak of a window, is random; {name}_median and {name}_p95 have "
        "intervals."
        for name in names
        if name.endswith("_force_peak") and study.has(f"{name}_median")
    ]
    return lines


def _sentences(study: Study, rows: list[dict[str, Any]]) -> list[str]:
    """Return the best case and the binding limits."""
    looked_at = len(study.cases) + len(study.failed)
    lines = [f"This is the best of {looked_at:,} cases that were tried."]
    if len(rows) > 1:
        lines = [f"The front has {len(rows)} of {looked_at:,} cases; none is worse than another in all objectives."]
    if rows[0]["margin"] is not None and rows[0]["margin"] < 0.0:
        lines.append(f"No case meets the limits; this one comes closest. It exceeds {rows[0]['limiting']}.")
    elif binding := sorted({row["limiting"] for row in rows if row["limiting"]}):
        lines.append(f"The closest limits are those on {wording.sentence_list(binding)}.")
    return lines


def _table(study: Study, rows: list[dict[str, Any]], names: list[str], start: str | None) -> Table:
    """Return a row for each of the best cases, and one for the case as written in the grid."""
    columns = (
        *axis_columns(study, study.axes),
        *(Column(name, study.unit(name)) for name in names),
        Column("margin"),
        Column("nearest limit"),
        Column("case"),
    )
    lines = []
    if start is not None and start not in [row["case_id"] for row in rows]:
        margin = study.cases.at[start, "margin"] if study.has("margin") else float("nan")
        values = [study.cases.at[start, axis.path] for axis in study.axes]
        cells = (*values, *(float(study.cases.at[start, name]) for name in names), float(margin))
        exceeded = study.cases.at[start, "limits_exceeded"] if "limits_exceeded" in study.cases else ""
        lines.append((*cells, _limits(study, exceeded), "as written"))
    for row in rows:
        numbers = [float("nan") if row[name] is None else row[name] for name in (*names, "margin")]
        lines.append((*(row[axis.path] for axis in study.axes), *numbers, _limits(study, row["limiting"]), "best"))
    return Table("optimise", "The best cases", "", columns, lines)


def _limits(study: Study, names: str) -> Quantity:
    """Return the cell of limits by their columns, in words on the page."""
    text = ", ".join(column_label(study, name) for name in names.split(",")) if names else wording.DASH
    return Quantity(names or wording.DASH, text)


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
    return [Picture(title, "Grey dots are all cases; the line is the front.", text, paint, (WIDTH, HEIGHT))]


def _parallel(study: Study, rows: list[dict[str, Any]], names: list[str]) -> list[Picture]:
    """Return every case as a line over its values and objectives, the best ones on top."""
    paths = [axis.path for axis in study.axes if axis.numeric]
    if len(study.cases) < FRONT or not paths:
        return []
    scales = {axis.path: (axis.name, axis.scale) for axis in study.axes if axis.numeric}
    scales |= {name: (name, study.scale(name)) for name in names}
    keys = [*paths, *names]
    table = np.column_stack([study.cases[key].to_numpy(float) for key in keys])
    low, high = np.nanmin(table, axis=0), np.nanmax(table, axis=0)
    places = (table - low) / np.where(high > low, high - low, 1.0)
    best = study.cases.index.isin([row["case_id"] for row in rows])

    def paint(ax: Any) -> None:
        across = np.arange(len(keys))
        ax.plot(across, places[~best].T, color="0.8", linewidth=0.5)
        ax.plot(across, places[best].T, color="C3", linewidth=1.2)
        ends = [[scales[key][1].text(end) for key, end in zip(keys, side, strict=True)] for side in (low, high)]
        labels = [f"{scales[key][0]}\n{least} to {other}" for key, least, other in zip(keys, *ends, strict=True)]
        ax.set_xticks(across, labels, fontsize=7)
        ax.set_yticks([])
        ax.set_xlim(-0.2, len(keys) - 0.8)

    title = "All cases as lines across the axes of variables and objectives"
    text = f"{title}: {int(best.sum())} best of {len(best)} cases."
    return [Picture(title, "Grey lines are all cases, red lines the best.", text, paint, (WIDTH, HEIGHT))]
