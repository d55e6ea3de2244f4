"""Results of searches: the limits that `seek` found, and the designs that `optimise` found."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...answers.verdict import EXCEEDED_COLUMN, UNDECIDED_COLUMN, Limit
from ...answers.words import case_margin_text
from ...contracts.case import value_at
from ...language import quantity, wording
from ...language.wording import is_missing
from ...searches import SENSES
from ..axis import Axis, sought_paths
from ..blocks.section import Block, Gallery, Picture, Section, Sentences, capitalise, section
from ..blocks.table import Column, Quantity, Table, axis_columns, column_label, columns_of, count_cell
from ..draw import BLUE, RED, set_plain_axes
from ..plot import Axes
from ..study import Study, answer_of_study

# Result of `seek`: the largest or smallest value that meets the limits, as an interval, for each case.

MIN_ANSWERS_DRAWN = 2  # least number of answers drawn over the other axis


class _Answers(NamedTuple):
    """The answers on one axis."""

    axis: Axis  # axis of the searched value
    other_axes: tuple[Axis, ...]
    is_largest: bool
    rows: list[dict[str, Any]]  # SI, None for null

    @property
    def column(self) -> str:
        """Return the column of the answer."""
        return f"seek.{self.axis.path}"

    def setting_text(self, row: dict[str, Any]) -> str:
        """Return the values of the other axes in words."""
        return ", ".join(f"{axis.name} {axis.text(row[axis.path])}" for axis in self.other_axes)

    def interval_text(self, row: dict[str, Any]) -> str:
        """Return the interval of the limit in words, or '' if the range ends before it."""
        low, high = row["seek_low"], row["seek_high"]
        return "" if low == high else f"between {self.axis.text(low)} and {self.axis.text(high)}"


def seek_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no search is complete."""
    answers = _read_answers(study)
    if answers is None:
        return []
    title = f"The {'largest' if answers.is_largest else 'smallest'} {answers.axis.name} within the limits"
    lines = [
        "The border between safe and unsafe values is an interval. All tested values up to its start meet the limits. "
        "Inside it, some meet them and some do not. At its end, at least two consecutive tested values fail. "
        "Values further away may meet the limits again.",
        "If the motion near the border is chaotic, the interval may be wider than requested.",
    ]
    if answers.axis.labels:  # all fits are tried, and some beyond the border may be safe, too
        lines = [
            "Every fit or group is tested at its largest clearance. The answer is the last one before the first that "
            "fails.",
            *not_monotone_sentences(answers),
        ]
    sentences, pictures = Sentences(lines), Gallery("", _pictures(answers, title))  # the verdict has the answer
    blocks: list[Block] = [sentences, pictures, _interval_table(study, answers), *_nearest_blocks(study, answers)]
    return section("seek", title, *blocks)


def answer_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return the card of the answer, or [] if there is none."""
    answers = _read_answers(study)
    if answers is None:
        return []
    name = f"{'Largest' if answers.is_largest else 'Smallest'} safe {answers.axis.name}"
    answered = [row for row in answers.rows if row[answers.column] is not None]
    if len(answered) < len(answers.rows) or not answered:
        return [(name, "none", "in the range that was searched")]
    row = (min if answers.is_largest else max)(answered, key=lambda row: row[answers.column])
    return [(name, answers.axis.text(row[answers.column]), _limiting_text(study, answers, row).strip(", "))]


def not_monotone_sentences(answers: _Answers) -> list[str]:
    """Return a sentence for each search in which fits beyond the first failing one meet the limits."""
    return [
        f"The margin is not monotone{f' at {answers.setting_text(row)}' if answers.other_axes else ''}: beyond the "
        f"border, {row['seek_beyond']} also meet the limits."
        for row in answers.rows
        if row.get("seek_beyond")
    ]


def _limiting_text(study: Study, answers: _Answers, row: dict[str, Any]) -> str:
    """Return the limit that determines an answer, and its joint."""
    if not row["limiting"]:
        return ""
    names = wording.sentence_list([column_label(study, name) for name in row["limiting"].split(",")])
    return f", limited by {names}" + (f" at {answers.setting_text(row)}" if answers.other_axes else "")


def _read_answers(study: Study) -> _Answers | None:
    paths, frame = sought_paths(study.run.grid), study.run.seek
    if not paths or frame is None or frame.empty:
        return None
    axis = next(axis for axis in study.axes if axis.path == paths[0])
    others = tuple(axis for axis in study.axes if axis.path not in paths and len(axis.values) > 1)
    rows = _rows_of(frame)
    intervals = [(row["seek_low"], row["seek_high"]) for row in rows if row["seek_low"] != row["seek_high"]]
    while axis.digits < 16 and any(axis.number_text(low) == axis.number_text(high) for low, high in intervals):
        axis = axis._replace(digits=axis.digits + 1)
    return _Answers(axis, others, "largest" in study.run.grid["seek"], rows)


def _interval_table(study: Study, answers: _Answers) -> Table:
    """Return one row for each answer."""
    unit, axis = study.unit(answers.axis.path), answers.axis
    columns = (
        *axis_columns(study, answers.other_axes),
        Column(f"{'largest' if answers.is_largest else 'smallest'} {axis.name}", unit, axis),
        Column("border from", unit, axis),
        Column("to", unit, axis),
        Column("limited by"),
        Column("cases tried"),
    )
    rows = []
    for row in answers.rows:
        values = [np.nan if row[name] is None else row[name] for name in (answers.column, "seek_low", "seek_high")]
        others = (row[other.path] for other in answers.other_axes)
        rows.append((*others, *values, _limit_cell(study, row["limiting"]), count_cell(row["probes"])))
    return Table("seek", "Results of the search", "", columns, rows)


def _limit_cell(
    study: Study, columns: str | None, join: Callable[[list[str]], str] = wording.sentence_list
) -> Quantity:
    """Return the cell of limited columns, separated by commas, in words on the page."""
    names = columns.split(",") if columns else []
    return Quantity(columns or wording.DASH, join([column_label(study, name) for name in names]) or wording.DASH)


def _nearest_blocks(study: Study, answers: _Answers) -> list[Block]:
    """Return the margins of the cases if no value meets the limits, and the other keys that would help."""
    nearest: dict[str, Any] = study.run.grid.get("nearest") or {}
    best, axis = nearest.get("best", []), answers.axis
    if not best:
        return []
    columns = [*axis_columns(study, answers.other_axes), Column(f"best {axis.name}", study.unit(axis.path), axis)]
    columns += columns_of("margin | limited by | would pass with")
    rows = [
        (
            *(case["point"].get(other.path) for other in answers.other_axes),
            case["value"],
            _margin_cell(case["margin"], study.limits),
            _limit_cell(study, case["limiting"]),
            wording.sentence_list([f"{name} {bound}" for name, bound in case["needed"].items()]) or wording.DASH,
        )
        for case in best
    ]
    table = Table("nearest", "How close the cases come to their limits", "", columns, rows)
    return [table, *_key_effect_blocks(answers, nearest, study.limits)]


def _key_effect_blocks(answers: _Answers, nearest: dict[str, Any], limits: Sequence[Limit]) -> list[Block]:
    """Return the other keys that change the margin of the case furthest from its limits."""
    furthest, rows = nearest["furthest"], []
    for effect in nearest["effects"]:
        margins = [_margin_cell(effect[name], limits, "failed") for name in ("lower", "margin", "upper")]
        if len({margin.text for margin in margins}) > 1:
            scale = wording.scale(effect["unit"], effect["value"], speed=effect["path"].endswith("speed"))
            rows.append((effect["path"], Quantity(effect["value"], scale.text(effect["value"])), *margins[::2]))
    if not nearest["effects"]:
        return []
    if not rows:
        return [Sentences(["No other single key of the grid changes the margin."])]
    other_texts = [f"{other.name} {other.text(furthest['point'].get(other.path))}" for other in answers.other_axes]
    setting = ", ".join([*other_texts, f"{answers.axis.name} {answers.axis.text(furthest['value'])}"])
    margin = _margin_cell(furthest["margin"], limits).text
    note = f"One key at a time is changed in the case furthest from its limits ({setting}); its margin is {margin}."
    columns = columns_of("key | value | margin with 10 % less | with 10 % more")
    return [Table("nearest-keys", "Other keys that change the margin", note, columns, rows)]


def _margin_cell(margin: float | None, limits: Sequence[Limit], missing: str = "unknown") -> Quantity:
    """Return a margin in words, or `missing`."""
    text = missing if margin is None else case_margin_text(margin, limits, "")
    return Quantity(text if margin is None else margin, text)


def _pictures(answers: _Answers, title: str) -> list[Picture]:
    """Return the picture of the answers over the other axis, or [] unless there is exactly one, with numbers."""
    rows = [row for row in answers.rows if row[answers.column] is not None]
    if len(answers.other_axes) != 1 or not answers.other_axes[0].is_numeric or len(rows) < MIN_ANSWERS_DRAWN:
        return []
    (other,) = answers.other_axes
    results = sorted((row[other.path], row["seek_low"], row["seek_high"], row[answers.column]) for row in rows)
    answer_texts = "; ".join(f"{other.text(row[0])}: {answers.axis.text(row[3])}" for row in results)

    def paint(ax: Axes) -> None:
        """Draw the intervals that contain the limits, and the answers."""
        x, low, high, answer = np.array(results).T
        x = other.scale.from_si(x)
        low, high, answer = (answers.axis.scale.from_si(values) for values in (low, high, answer))
        ax.vlines(x, low, high, color=BLUE, linewidth=2.0)
        ax.plot(x, answer, "o-", color=BLUE, markersize=4.0, linewidth=0.8)
        ax.set_labels(other.label(), answers.axis.label())
        if low.min() > 0.0:
            ax.set_ylim(0.0, 1.1 * high.max())
        set_plain_axes(ax)

    name = capitalise(f"{title.removeprefix('The ')} over {other.name}")
    caption = "The dot is the last safe value, the bar is the border."
    return [Picture(name, caption, f"{title} over {other.name}. {answer_texts}", paint)]


# Result of `optimise`: the best case and the case as written in the grid, the front, the binding limits.

WIDTH, HEIGHT = 6.5, 4.0  # inches
MAX_ROWS_SHOWN = 8  # rows of the best cases that the page shows at first
MIN_FRONT_CASES = 2  # cases from which a front is drawn


def optimised_sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing was optimised, or the run did not end."""
    result = _best_rows(study)
    if result is None:
        return []
    (rows, names), written_id = result, _case_as_written(study)
    texts = [*_comparison_sentences(study, rows, names, written_id), *_indistinguishable_sentences(study, rows, names)]
    table = _front_table(study, rows, names, written_id)
    blocks: list[Block] = [Sentences(texts), _shorten_table(table)]
    return section("optimise", "The best cases", *blocks)


def folded_optimised_sections(study: Study) -> list[Section]:
    """Return sections with all best cases, their front, and every case as a line; [] if `sections` returns []."""
    result = _best_rows(study)
    if result is None:
        return []
    rows, names = result
    table = _front_table(study, rows, names, _case_as_written(study))
    full_tables = [table] if len(table.rows) > MAX_ROWS_SHOWN else []
    pictures = [*_front_picture(study, rows, names), *_parallel_coordinates(study, rows, names)]
    return section("optimise-more", "All best cases", *full_tables, Gallery("", pictures))


def _best_rows(study: Study) -> tuple[list[dict[str, Any]], list[str]] | None:
    """Return the best cases as rows and the names of the objectives, or None if there is no answer."""
    if "optimise" not in study.run.grid:
        return None
    frame = study.run.optimise
    if frame is None or frame.empty:
        return None
    names = [name for sense in SENSES for name in study.run.grid["optimise"].get(sense, [])]
    return _rows_of(frame), names


def _rows_of(frame: Any) -> list[dict[str, Any]]:
    """Return the rows of a table of results; None for null."""
    records = frame.to_dict("records")
    return [{name: None if is_missing(value) else value for name, value in row.items()} for row in records]


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
        values = study.cases[axis.path]
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
        best_objective, written_objective = rows[0][name], float(study.cases.at(written_id, name))
        change = f" ({100.0 * (best_objective / written_objective - 1.0):+.3g} %)" if written_objective else ""
        sentences.append(
            f"{name} {study.text(rows[0]['case_id'], name)} instead of {study.text(written_id, name)}{change}"
        )
    return [f"Compared with the case of the grid: {wording.sentence_list(sentences)}."]


def _indistinguishable_sentences(study: Study, rows: list[dict[str, Any]], names: list[str]) -> list[str]:
    """Return, for each objective with an interval, the cases that cannot be distinguished from the best one."""
    lines, row = [], study.cases.row_of(rows[0]["case_id"])
    is_comparable = len(rows) == 1 and row >= 0 and answer_of_study(study).get("best_met", True)
    for name in names if is_comparable else ():  # where no case meets the limits, none of the others is best either
        interval_columns = [f"{name}_{column}" for column in ("low", "high")]
        if not all(map(study.has, interval_columns)):
            continue
        low, high = (study.cases[column] for column in interval_columns)
        if np.isnan([low[row], high[row]]).any():
            continue
        limits_text = " within the limits" if rows[0]["limiting"] else ""
        feasible = np.ones(len(study.cases), bool)
        for column in (EXCEEDED_COLUMN, UNDECIDED_COLUMN) if EXCEEDED_COLUMN in study.cases else ():
            feasible &= study.cases[column] == ""
        overlapping_count = int(np.count_nonzero((low <= high[row]) & (high >= low[row]) & feasible)) - 1
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


def _front_table(study: Study, rows: list[dict[str, Any]], names: list[str], written_id: str | None) -> Table:
    """Return a row for each of the best cases, and one for the case as written in the grid."""
    columns = [
        *axis_columns(study, study.axes),
        *(Column(name, study.unit(name), heading=column_label(study, name)) for name in names),
        *columns_of("margin | nearest limit | case"),
    ]
    lines = []
    if written_id is not None and written_id not in [row["case_id"] for row in rows]:
        margin = study.cases.at(written_id, "margin") if study.has("margin") else float("nan")
        values = [study.cases.at(written_id, axis.path) for axis in study.axes]
        cells = (*values, *(float(study.cases.at(written_id, name)) for name in names), float(margin))
        exceeded = study.cases.at(written_id, EXCEEDED_COLUMN) if EXCEEDED_COLUMN in study.cases else ""
        lines.append((*cells, _limit_cell(study, exceeded, ", ".join), "as written"))
    for row in rows:
        numbers = [float("nan") if row[name] is None else row[name] for name in (*names, "margin")]
        limiting = _limit_cell(study, row["limiting"], ", ".join)
        lines.append((*(row[axis.path] for axis in study.axes), *numbers, limiting, "best"))
    return Table("optimise", "The best cases", "", columns, lines)


def _front_picture(study: Study, rows: list[dict[str, Any]], names: list[str]) -> list[Picture]:
    """Return the front of two objectives among all finished cases."""
    if len(names) != 2 or len(rows) < MIN_FRONT_CASES:
        return []
    x_scale, y_scale = (study.scale(name) for name in names)

    def paint(ax: Axes) -> None:
        x, y = (study.cases[name] / scale.factor for name, scale in zip(names, (x_scale, y_scale), strict=True))
        best_values = [
            [row[name] / scale.factor for row in rows] for name, scale in zip(names, (x_scale, y_scale), strict=True)
        ]
        ax.plot(x, y, marker=".", linestyle="", color="#b3b3b3", markersize=4)
        ax.step(*best_values, color=BLUE, markersize=4)
        ax.set_labels(f"{names[0]}, {x_scale.unit}", f"{names[1]}, {y_scale.unit}")

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
    table = np.column_stack([study.cases[column] for column in columns])
    low, high = np.nanmin(table, axis=0), np.nanmax(table, axis=0)
    fractions = (table - low) / np.where(high > low, high - low, 1.0)
    is_best = np.isin(study.cases.index, [row["case_id"] for row in rows])

    def paint(ax: Axes) -> None:
        positions = np.arange(len(columns))
        ax.plot(positions, fractions[~is_best].T, color="#cccccc", linewidth=0.5)
        ax.plot(positions, fractions[is_best].T, color=RED, linewidth=1.2)
        range_texts = [
            [scales[column][1].text(value) for column, value in zip(columns, bounds, strict=True)]
            for bounds in (low, high)
        ]
        labels = [
            f"{scales[column][0]}\n{smallest} to {largest}"
            for column, smallest, largest in zip(columns, *range_texts, strict=True)
        ]
        ax.xaxis.set_ticks(positions.tolist(), labels)
        ax.xaxis.font_size = 7.0
        ax.yaxis.set_ticks([])
        ax.set_xlim(-0.2, len(columns) - 0.8)

    title = "All cases as lines across the axes of variables and objectives"
    text = f"{title}: {int(is_best.sum())} best of {len(is_best)} cases."
    return [Picture(title, "Grey lines are all cases, red lines the best.", text, paint, (WIDTH, HEIGHT))]
