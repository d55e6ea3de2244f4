"""Result of `seek`: the largest or smallest value that meets the limits, as an interval, for each case."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import pandas as pd

from ...answers.verdict import Limit
from ...answers.words import case_margin_text
from ...language import wording
from ..blocks.case_table import axis_columns
from ..blocks.picture import Picture, capitalise
from ..blocks.section import Block, Gallery, Section, Sentences, without_empty
from ..blocks.table import Column, Quantity, Table, count_cell
from ..data.axis import Axis
from ..data.dotted_paths import first_sought_path, sought_paths
from ..data.study import Study
from ..data.table_columns import column_label
from ..draw import seek as draw

MIN_ANSWERS_DRAWN = 2  # least number of answers drawn over the other axis


class _Answers(NamedTuple):
    """The answers on one axis."""

    axis: Axis  # axis of the searched value
    other_axes: tuple[Axis, ...]
    is_largest: bool
    is_per_case: bool  # whether there is one answer for each case of the other axes
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


def sections(study: Study) -> list[Section]:
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
            "Every fit is tested at its largest clearance. The answer is the last fit before the first fit that fails."
        ]
    sentences, pictures = Sentences(lines), Gallery("", _pictures(answers, title))  # the verdict has the answer
    blocks: list[Block] = [sentences, pictures, _table(study, answers), *_nearest_blocks(study, answers)]
    return [Section("seek", title, without_empty(blocks))]


def answer_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return the card of the answer, or [] if there is none."""
    answers = _read_answers(study)
    if answers is None:
        return []
    superlative = "Largest" if answers.is_largest else "Smallest"
    answered = [row for row in answers.rows if row[answers.column] is not None]
    if len(answered) < len(answers.rows) or not answered:
        return [(f"{superlative} safe {answers.axis.name}", "none", "in the range that was searched")]
    row = (min if answers.is_largest else max)(answered, key=lambda row: row[answers.column])
    return [
        (
            f"{superlative} safe {answers.axis.name}",
            answers.axis.text(row[answers.column]),
            _limiting_text(study, answers, row).strip(", "),
        )
    ]


def _not_monotone_sentences(answers: _Answers) -> list[str]:
    """Return a sentence for each search in which fits beyond the first failing one meet the limits."""
    sentences = []
    for row in answers.rows:
        if row.get("seek_beyond"):
            setting_text = f" at {answers.setting_text(row)}" if answers.other_axes else ""
            sentences.append(
                f"The margin is not monotone{setting_text}: beyond the border, {row['seek_beyond']} also meet the "
                "limits."
            )
    return sentences


def _limiting_text(study: Study, answers: _Answers, row: dict[str, Any]) -> str:
    """Return the limit that determines an answer, and its joint."""
    limiting_columns = row["limiting"].split(",") if row["limiting"] else []
    limiting_text = (
        f", limited by {wording.sentence_list([column_label(study, name) for name in limiting_columns])}"
        if limiting_columns
        else ""
    )
    return (
        f"{limiting_text} at {answers.setting_text(row)}" if answers.other_axes and row["limiting"] else limiting_text
    )


def _read_answers(study: Study) -> _Answers | None:
    path, frame = first_sought_path(study.run.grid), study.run.seek
    if not path or frame is None or frame.empty:
        return None
    by_path = {axis.path: axis for axis in study.axes}
    others = tuple(
        axis for axis in study.axes if axis.path not in sought_paths(study.run.grid) and len(axis.values) > 1
    )
    section = study.run.grid["seek"]
    rows = [
        {name: None if pd.isna(value) else value for name, value in row.items()} for row in frame.to_dict("records")
    ]
    return _Answers(
        _with_distinct_digits(by_path[path], rows), others, "largest" in section, section.get("for") != "all", rows
    )


def _with_distinct_digits(axis: Axis, rows: list[dict[str, Any]]) -> Axis:
    """Return an axis with enough digits to distinguish the ends of intervals."""
    intervals = [(row["seek_low"], row["seek_high"]) for row in rows if row["seek_low"] != row["seek_high"]]
    while axis.digits < 16 and any(axis.number_text(low) == axis.number_text(high) for low, high in intervals):
        axis = axis._replace(digits=axis.digits + 1)
    return axis


def _table(study: Study, answers: _Answers) -> Table:
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
        values = [row[name] for name in (answers.column, "seek_low", "seek_high")]
        rows.append(
            (
                *(row[other.path] for other in answers.other_axes),
                *(float("nan") if value is None else value for value in values),
                _limit_cell(study, row["limiting"]),
                count_cell(row["probes"]),
            )
        )
    return Table("seek", "Results of the search", "", columns, rows)


def _limit_cell(study: Study, columns: str | None) -> Quantity:
    """Return the cell of limited columns, separated by commas, in words on the page."""
    names = columns.split(",") if columns else []
    return Quantity(
        columns or wording.DASH, wording.sentence_list([column_label(study, name) for name in names]) or wording.DASH
    )


def _nearest_blocks(study: Study, answers: _Answers) -> list[Block]:
    """Return the margins of the cases if no value meets the limits, and the other keys that would help."""
    nearest: dict[str, Any] = study.run.grid.get("nearest") or {}
    best, axis = nearest.get("best", []), answers.axis
    if not best:
        return []
    columns = (
        *axis_columns(study, answers.other_axes),
        Column(f"best {axis.name}", study.unit(axis.path), axis),
        Column("margin"),
        Column("limited by"),
        Column("would pass with"),
    )
    rows = [
        (
            *(case["point"].get(other.path) for other in answers.other_axes),
            case["value"],
            _margin_cell(case["margin"], study.limits),
            _limit_cell(study, case["limiting"]),
            _needed_text(case["needed"]) or wording.DASH,
        )
        for case in best
    ]
    blocks: list[Block] = [Table("nearest", "How close the cases come to their limits", "", columns, rows)]
    if nearest["needed"] and len(best) > 1:
        blocks.append(Sentences([f"All of these {len(best)} would pass with {_needed_text(nearest['needed'])}."]))
    return [*blocks, *_key_effect_blocks(answers, nearest, study.limits)]


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
    columns = (Column("key"), Column("value"), Column("margin with 10 % less"), Column("with 10 % more"))
    return [Table("nearest-keys", "Other keys that change the margin", note, columns, rows)]


def _margin_cell(margin: float | None, limits: Sequence[Limit], missing: str = "unknown") -> Quantity:
    """Return a margin in words, or `missing`."""
    text = missing if margin is None else case_margin_text(margin, limits, "")
    return Quantity(text if margin is None else margin, text)


def _needed_text(needed: dict[str, str]) -> str:
    return wording.sentence_list([f"{name} {bound_text}" for name, bound_text in needed.items()])


def _pictures(answers: _Answers, title: str) -> list[Picture]:
    """Return the picture of the answers over the other axis, or [] unless there is exactly one, with numbers."""
    rows = [row for row in answers.rows if row[answers.column] is not None]
    if len(answers.other_axes) != 1 or not answers.other_axes[0].is_numeric or len(rows) < MIN_ANSWERS_DRAWN:
        return []
    (other,) = answers.other_axes
    results = sorted((row[other.path], row["seek_low"], row["seek_high"], row[answers.column]) for row in rows)
    answer_texts = "; ".join(f"{other.text(row[0])}: {answers.axis.text(row[3])}" for row in results)
    return [
        Picture(
            capitalise(f"{title.removeprefix('The ')} over {other.name}"),
            "The dot is the last safe value, the bar is the border.",
            f"{title} over {other.name}. {answer_texts}",
            lambda ax: draw.draw_intervals(ax, results, other, answers.axis),
        )
    ]
