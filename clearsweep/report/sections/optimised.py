"""Result of `optimise`: the best case and the case as written in the grid, the front, the binding limits."""

from typing import Any

import numpy as np
import pandas as pd

from ...answers.verdict import EXCEEDED, UNDECIDED
from ...grid.sections.optimise import SENSES
from ...language import quantity, wording
from ..blocks.case_table import axis_columns
from ..blocks.picture import Picture
from ..blocks.section import Block, Gallery, Section, Sentences, without_empty
from ..blocks.table import Column, Quantity, Table
from ..data.answered import answer_of_study
from ..data.dotted_paths import value_at
from ..data.study import Study
from ..data.table_columns import column_label

WIDTH, HEIGHT = 6.5, 4.0  # inches
MAX_ROWS_SHOWN = 8  # rows of the best cases that the page shows at first
MIN_FRONT_CASES = 2  # cases from which a front is drawn


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing was optimised, or the run did not end."""
    result = _best_rows(study)
    if result is None:
        return []
    (rows, names), written_id = result, _case_as_written(study)
    texts = [
        *_comparison_sentences(study, rows, names, written_id),
        *_indistinguishable_sentences(study, rows, names),
    ]
    table = _table(study, rows, names, written_id)
    blocks: list[Block] = [Sentences(texts), _shorten_table(table)]
    return [Section("optimise", "The best cases", without_empty(blocks))]


def _objectives_by_sense(study: Study) -> list[list[str]]:
    """Return a list of the minimised objectives and a list of the maximised ones."""
    return [study.run.grid["optimise"].get(sense, []) for sense in SENSES]


def folded_sections(study: Study) -> list[Section]:
    """Return sections with all best cases, their front, and every case as a line; [] if `sections` returns []."""
    result = _best_rows(study)
    if result is None:
        return []
    rows, names = result
    table = _table(study, rows, names, _case_as_written(study))
    full_tables = [table] if len(table.rows) > MAX_ROWS_SHOWN else []
    pictures = [*_front_picture(study, rows, names), *_parallel_coordinates(study, rows, names)]
    return [Section("optimise-more", "All best cases", without_empty([*full_tables, Gallery("", pictures)]))]


def _best_rows(study: Study) -> tuple[list[dict[str, Any]], list[str]] | None:
    """Return the best cases as rows and the names of the objectives, or None if there is no answer."""
    if "optimise" not in study.run.grid:
        return None
    frame = study.run.optimise
    if frame is None or frame.empty:
        return None
    names = [name for sense in _objectives_by_sense(study) for name in sense]
    rows = [
        {name: None if pd.isna(value) else value for name, value in row.items()} for row in frame.to_dict("records")
    ]
    return rows, names


def _shorten_table(table: Table) -> Table:
    """Return a table without most rows of a long front: its first rows and others at equal steps."""
    if len(table.rows) <= MAX_ROWS_SHOWN:
        return table
    row_indices = np.linspace(0, len(table.rows) - 1, MAX_ROWS_SHOWN).round().astype(int)
    note = (
        f"These are {MAX_ROWS_SHOWN} of {len(table.rows)} rows, at equal steps. The section below under More "
        "lists all rows."
    )
    return table._replace(
        key="optimise-first", note=note, rows=[table.rows[index] for index in row_indices], is_file=False
    )


def _case_as_written(study: Study) -> str | None:
    """Return the case as written in the grid, or None if it was not tried or failed."""
    is_same = np.ones(len(study.cases), bool)
    for axis in study.axes:
        written_value = value_at(study.run.grid, axis.path)
        if isinstance(written_value, str) and axis.is_numeric:  # of `define`: with its unit
            written_value = quantity.value_and_dimension(written_value)[0]
        if written_value is None:
            return None
        values = study.cases[axis.path].to_numpy()
        is_same &= np.isclose(values, written_value, rtol=1e-9) if axis.is_numeric else values == written_value
    return str(study.cases.index[int(np.argmax(is_same))]) if is_same.any() else None


def _comparison_sentences(
    study: Study, rows: list[dict[str, Any]], names: list[str], written_id: str | None
) -> list[str]:
    """Return the improvement of the best case over the case as written in the grid."""
    if written_id is None or len(rows) > 1:
        return []
    sentences = []
    for name in names:
        best_objective, written_objective = rows[0][name], float(study.cases.at[written_id, name])
        change = f" ({100.0 * (best_objective / written_objective - 1.0):+.3g} %)" if written_objective else ""
        sentences.append(
            f"{name} {study.text(rows[0]['case_id'], name)} instead of {study.text(written_id, name)}{change}"
        )
    return [f"Compared with the case of the grid: {wording.sentence_list(sentences)}."]


def _indistinguishable_sentences(study: Study, rows: list[dict[str, Any]], names: list[str]) -> list[str]:
    """Return, for each objective with an interval, the cases that cannot be distinguished from the best one."""
    lines = []
    for name in names:
        interval_columns = [f"{name}_{column}" for column in ("low", "high")]
        if len(rows) > 1 or rows[0]["case_id"] not in study.cases.index or not all(map(study.has, interval_columns)):
            continue
        low, high = (study.cases[column].to_numpy(float) for column in interval_columns)
        row = study.cases.index.get_loc(rows[0]["case_id"])
        if np.isnan([low[row], high[row]]).any():
            continue
        limits_text = " within the limits" if rows[0]["limiting"] else ""
        feasible = np.ones(len(study.cases), bool)
        for column in (EXCEEDED, UNDECIDED) if EXCEEDED in study.cases else ():
            feasible &= study.cases[column].to_numpy() == ""
        overlapping_count = int(np.count_nonzero((low <= high[row]) & (high >= low[row]) & feasible)) - 1
        if not answer_of_study(study).get("best_met", True):
            continue  # no case meets the limits, so none of the others is best either
        interval_text = " to ".join(study.text(rows[0]["case_id"], column) for column in interval_columns)
        lines.append(
            f"The 95 % interval of {name} of the best case is {interval_text}; "
            f"{wording.count_text(overlapping_count, 'other case')}"
            f"{limits_text} cannot be distinguished from it, as their intervals overlap."
        )
    lines += [
        f"In chaotic motion {name}, the largest peak of a window, is random; {name}_median and {name}_p95 have "
        "intervals."
        for name in names
        if name.endswith("_force_peak") and study.has(f"{name}_median")
    ]
    return lines


def _table(study: Study, rows: list[dict[str, Any]], names: list[str], written_id: str | None) -> Table:
    """Return a row for each of the best cases, and one for the case as written in the grid."""
    columns = (
        *axis_columns(study, study.axes),
        *(Column(name, study.unit(name), heading=column_label(study, name)) for name in names),
        Column("margin"),
        Column("nearest limit"),
        Column("case"),
    )
    lines = []
    if written_id is not None and written_id not in [row["case_id"] for row in rows]:
        margin = study.cases.at[written_id, "margin"] if study.has("margin") else float("nan")
        values = [study.cases.at[written_id, axis.path] for axis in study.axes]
        cells = (*values, *(float(study.cases.at[written_id, name]) for name in names), float(margin))
        exceeded = study.cases.at[written_id, EXCEEDED] if EXCEEDED in study.cases else ""
        lines.append((*cells, _limits_cell(study, exceeded), "as written"))
    for row in rows:
        numbers = [float("nan") if row[name] is None else row[name] for name in (*names, "margin")]
        lines.append((*(row[axis.path] for axis in study.axes), *numbers, _limits_cell(study, row["limiting"]), "best"))
    return Table("optimise", "The best cases", "", columns, lines)


def _limits_cell(study: Study, names: str) -> Quantity:
    """Return the cell of limits by their columns, in words on the page."""
    return Quantity(names or wording.DASH, ", ".join(_limited_labels(study, names)) if names else wording.DASH)


def _limited_labels(study: Study, names: str) -> list[str]:
    """Return the labels of limited columns, whose names are separated by commas."""
    return [column_label(study, name) for name in names.split(",")]


def _front_picture(study: Study, rows: list[dict[str, Any]], names: list[str]) -> list[Picture]:
    """Return the front of two objectives among all finished cases."""
    if len(names) != 2 or len(rows) < MIN_FRONT_CASES:
        return []
    x_scale, y_scale = (study.scale(name) for name in names)

    def paint(ax: Any) -> None:
        all_values = [
            study.cases[name].to_numpy() / scale.factor for name, scale in zip(names, (x_scale, y_scale), strict=True)
        ]
        best_values = [
            [row[name] / scale.factor for row in rows] for name, scale in zip(names, (x_scale, y_scale), strict=True)
        ]
        ax.plot(*all_values, ".", color="0.7", markersize=4)
        ax.step(*best_values, "o-", where="post", markersize=4)
        ax.set_xlabel(f"{names[0]}, {x_scale.unit}")
        ax.set_ylabel(f"{names[1]}, {y_scale.unit}")

    title = "The front of both objectives"
    text = f"{title}: {len(rows)} cases; grey dots are all other finished cases."
    return [Picture(title, "Grey dots are all cases; the line is the front.", text, paint, (WIDTH, HEIGHT))]


def _parallel_coordinates(study: Study, rows: list[dict[str, Any]], names: list[str]) -> list[Picture]:
    """Return every case as a line over its values and objectives, the best ones on top."""
    paths = [axis.path for axis in study.axes if axis.is_numeric]
    if len(study.cases) < MIN_FRONT_CASES or not paths:
        return []
    scales = {axis.path: (axis.name, axis.scale) for axis in study.axes if axis.is_numeric}
    scales |= {name: (name, study.scale(name)) for name in names}
    columns = [*paths, *names]
    table = np.column_stack([study.cases[column].to_numpy(float) for column in columns])
    low, high = np.nanmin(table, axis=0), np.nanmax(table, axis=0)
    fractions = (table - low) / np.where(high > low, high - low, 1.0)
    is_best = study.cases.index.isin([row["case_id"] for row in rows])

    def paint(ax: Any) -> None:
        positions = np.arange(len(columns))
        ax.plot(positions, fractions[~is_best].T, color="0.8", linewidth=0.5)
        ax.plot(positions, fractions[is_best].T, color="C3", linewidth=1.2)
        range_texts = [
            [scales[column][1].text(value) for column, value in zip(columns, bounds, strict=True)]
            for bounds in (low, high)
        ]
        labels = [
            f"{scales[column][0]}\n{smallest} to {largest}"
            for column, smallest, largest in zip(columns, *range_texts, strict=True)
        ]
        ax.set_xticks(positions, labels, fontsize=7)
        ax.set_yticks([])
        ax.set_xlim(-0.2, len(columns) - 0.8)

    title = "All cases as lines across the axes of variables and objectives"
    text = f"{title}: {int(is_best.sum())} best of {len(is_best)} cases."
    return [Picture(title, "Grey lines are all cases, red lines the best.", text, paint, (WIDTH, HEIGHT))]
