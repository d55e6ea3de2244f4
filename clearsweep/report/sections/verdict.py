"""The answer to the question of the grid, and maps and a table of the limits."""

import itertools

import numpy as np

from ...answers import verdict
from ...answers.judged import is_null, named_value
from ...answers.labels import limit_label
from ...answers.words import case_margin_text
from ...language import wording
from ..blocks.case_table import axis_columns
from ..blocks.picture import Picture
from ..blocks.section import Block, Gallery, Points, Section, without_empty
from ..blocks.table import Column, Quantity, Table, count_cell
from ..data.answered import answer_of_study, finished_cases, words_of
from ..data.axis import Axis
from ..data.study import Study, largest, reduce_over_other_axes
from ..draw import heat_map, pass_share
from ..samples import counts
from ..statistics.main_effects import main_effects_of
from . import maps

MAX_MAPS = 3  # pairs of axes at most
NOTE = "Each cell shows its smallest margin in per cent. It passes if all of its cases meet all limits."


def sections(study: Study) -> list[Section]:
    """Return the section."""
    if study.cases.empty:
        count = wording.count_text(len(study.failed), "case")
        lines = [f"None of the {count} finished; the reasons are listed below.", *answer_of_study(study)["sentences"]]
        return [Section("verdict", "Answer", [Points(list(dict.fromkeys(lines)))])]
    blocks: list[Block] = [
        Points(answer_of_study(study)["sentences"]),
        Gallery("", [*_margin_maps(study)[:1], *maps.answer_maps(study)]),
    ]
    return [Section("verdict", "Answer", without_empty(blocks))]


def folded_sections(study: Study) -> list[Section]:
    """Return a section with the table of limits and the maps of further pairs of axes."""
    if study.cases.empty:
        return []
    return [Section("limits-kept", "Limits", without_empty([_table(study), Gallery("", _margin_maps(study)[1:])]))]


def _table(study: Study) -> Table:
    """Return, for each limit, the number of cases that exceed it, and the case with the smallest margin."""
    columns = (
        Column("column", file_only=True),
        Column("limit"),
        Column("cases that exceed it"),
        Column("undecided"),
        Column("of"),
        Column("smallest margin"),
        *axis_columns(study, study.swept()),
        Column("case_id"),
    )
    rows = []
    limit_counts = counts.limit_counts(study)
    for limit, (failing, unknown) in zip(study.limits, limit_counts.by_limit, strict=True):
        values_by_column = counts.limit_columns(study, limit)
        margins, fails = limit.margin(values_by_column), limit.is_exceeded(values_by_column)
        row = _worst_row(margins, fails, limit.excess(values_by_column))
        case_id = study.cases.index[row]
        values = (study.cases.at[case_id, axis.path] for axis in study.swept())
        worst = float(margins[row])
        margin = Quantity(worst, case_margin_text(worst, [limit], limit.column if fails[row] else ""))
        of_cases = (count_cell(failing), count_cell(unknown), count_cell(limit_counts.cases))
        rows.append((limit.column, _limit_text(study, limit), *of_cases, margin, *values, case_id))
    note = (
        "The margin is the distance within the limit over its size. A limit is undecided where its figure is null; a "
        "bound of 0 has no margin."
    )
    return Table("limits_kept", "Limits", note, columns, rows)


def _worst_row(margins: np.ndarray, fails: np.ndarray, excesses: np.ndarray) -> int:
    """Return the worst case of a limit: exceeded without a margin by the largest excess, else the smallest margin."""
    is_bare = fails & ~(margins < 0.0)
    if is_bare.any():
        return int(np.argmax(np.where(is_bare, np.nan_to_num(excesses, nan=np.inf), -np.inf)))
    return int(np.nanargmin(margins)) if np.isfinite(margins).any() else 0


def _limit_text(study: Study, limit: verdict.Limit) -> str:
    """Return a limit in words: 'force peak at most 60 kN'."""
    return limit_label(study.run.layout, limit, study.unit(limit.column))


def _margin_maps(study: Study) -> list[Picture]:
    """Return the maps of the smallest margin over the pairs of axes with the largest effect."""
    if verdict.MARGIN not in study.cases or not study.has(verdict.MARGIN):
        return []
    ranked = [effect.axis for effect in main_effects_of(study, verdict.MARGIN)]
    if len(ranked) < 2:
        return []
    pairs = list(itertools.combinations(ranked, 2))[:MAX_MAPS]
    return [_margin_map(study, *sorted(pair, key=study.axes.index)) for pair in pairs]


def _margin_map(study: Study, x_axis: Axis, y_axis: Axis) -> Picture:
    margins = study.cases[verdict.MARGIN].to_numpy(float)
    is_unmet = (study.cases[verdict.EXCEEDED] != "") | (study.cases[verdict.UNDECIDED] != "")
    exceeded = is_unmet.to_numpy(float)
    smallest = -reduce_over_other_axes(study, -margins, (x_axis, y_axis), largest)
    failing = reduce_over_other_axes(study, exceeded, (x_axis, y_axis), largest)
    added_cases = _added_cases(study, exceeded, x_axis, y_axis)
    passing_cells, cells = int((failing == 0.0).sum()), int(np.isfinite(failing).sum())
    others = [axis.name for axis in study.swept() if axis not in (x_axis, y_axis)]
    reservations, remark = _reservations(study, (x_axis, y_axis))
    caption = f"{NOTE} Worst over {wording.sentence_list(others)}." if others else f"{NOTE} Each cell is one case."
    caption += remark
    if len(added_cases.x):
        dots_text = wording.count_text(len(added_cases.x), "dot")
        case_phrase = "is a case" if len(added_cases.x) == 1 else "are cases"
        caption += f" The {dots_text} between cells {case_phrase} that refine added; crosses exceed a limit."
    return Picture(
        f"Within the limits: {x_axis.name} {wording.TIMES} {y_axis.name}",
        caption,
        f"Map of the smallest margin over {x_axis.name} and {y_axis.name}: {passing_cells} of {cells} cells meet all "
        f"limits. {caption}",
        lambda ax: pass_share.draw_margin_cells(ax, (smallest, failing, reservations), (x_axis, y_axis), added_cases),
        heat_map.SIZE,
    )


def _reservations(study: Study, pair: tuple[Axis, Axis]) -> tuple[np.ndarray, str]:
    """Return which cells meet the limits although their design does not meet them everywhere, and the remark on it."""
    answer, cases = answer_of_study(study), finished_cases(study)
    conditions = [path for path, role in answer["roles"].items() if role in ("condition", "model", "uncertainty")]
    codes = np.zeros(len(cases))
    if any(axis.path in conditions for axis in pair):
        for design in answer["designs"]:
            if design["verdict"] != "meets" and design["values"]:
                is_of_design = np.ones(len(cases), bool)
                for path, value in design["values"].items():
                    levels = cases.values_of(path).tolist()
                    named = [None if is_null(level) else named_value(cases.record, path, level) for level in levels]
                    is_of_design &= np.array([name in (None, value) for name in named])
                codes[is_of_design] = pass_share.FAILS_ELSEWHERE
    names = wording.sentence_list([words_of(study).axis_name(path) for path in conditions])
    remark = f" (ok): met here, but not at every {names}." if codes.any() else ""
    return reduce_over_other_axes(study, codes, pair, largest), remark


def _added_cases(study: Study, exceeded: np.ndarray, x_axis: Axis, y_axis: Axis) -> pass_share.Dots:
    """Return the finished cases between the values of two axes, added by `refine`."""
    is_between = (study.indices_on(x_axis) < 0) | (study.indices_on(y_axis) < 0)
    if not is_between.any():
        return pass_share.Dots(np.zeros(0), np.zeros(0), np.zeros(0, bool))
    x, y = (_fractional_index(axis, study.cases[axis.path].to_numpy()[is_between]) for axis in (x_axis, y_axis))
    return pass_share.Dots(x, y, exceeded[is_between] > 0.0)


def _fractional_index(axis: Axis, values: np.ndarray) -> np.ndarray:
    """Return the fractional index of values on an axis: 0.5 is halfway between the first two."""
    if not axis.is_numeric:
        return np.array([axis.values.index(value) for value in values], float)
    order = np.argsort(axis.values)
    return np.interp(values.astype(float), np.array(axis.values)[order], order.astype(float))
