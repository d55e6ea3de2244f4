"""The verdict: first the answer to the question of the grid, then the cases that meet or exceed the limits."""

import itertools
import re

import numpy as np

from ...answers import advice, case_ranking, designs, fits, probability, sampled, verdict
from ...answers.cases import MAX_NAMED_AXES
from ...answers.labels import limit_label
from ...language import wording
from ..blocks.case_table import axis_columns
from ..blocks.picture import Picture
from ..blocks.section import Block, Gallery, Points, Section, without_empty
from ..blocks.table import Column, Quantity, Table, count_cell
from ..data.answered import answer_cases, answer_sentences
from ..data.axis import Axis
from ..data.study import Joint, Study, largest, reduce_over_other_axes
from ..data.table_columns import column_label
from ..data.worst_case import case_ranking_of
from ..draw import heat_map, pass_share
from ..samples import counts
from ..samples.sample_tables import any_limit_exceeded
from ..statistics import sensitivity
from ..statistics.main_effects import main_effects_of
from . import law_check, life, maps, optimised
from .seek import safe_value_sentences

MAX_MAPS = 3  # pairs of axes at most
NOTE = "Each cell shows its smallest margin in per cent. It passes if all of its cases meet all limits."


def sections(study: Study) -> list[Section]:
    """Return the section."""
    if study.cases.empty:
        sentence = (
            f"None of the {wording.count_text(len(study.failed), 'case')} finished; the reasons are listed below."
        )
        return [Section("verdict", "Answer", [Points([sentence])])]
    points = [
        *_progress_sentences(study),
        *life.life_sentences(study),
        *safe_value_sentences(study),
        *optimised.best_case_sentences(study),
        *(_probability_sentences(study) if sampled.is_one_sample(study.run.grid) else []),
        *answer_sentences(study),
        *_limit_sentences(study),
        *_advice_sentences(study),
        *law_check.sentences(study),
    ]
    blocks: list[Block] = [Points(points), Gallery("", [*_margin_maps(study)[:1], *maps.answer_maps(study)])]
    return [Section("verdict", "Answer", without_empty(blocks))]


def folded_sections(study: Study) -> list[Section]:
    """Return a section with the table of limits and the maps of further pairs of axes."""
    if study.cases.empty:
        return []
    return [Section("limits-kept", "Limits", without_empty([_table(study), Gallery("", _margin_maps(study)[1:])]))]


def _progress_sentences(study: Study) -> list[str]:
    """Return a sentence with the number of cases of an unfinished run on the page, or [] if none is missing."""
    missing = study.run.grid.get("counts", {}).get("missing", 0)
    if not missing:
        return []
    finished = len(study.cases) + len(study.failed)
    return [f"The run is not finished: this page has {finished} of {wording.count_text(finished + missing, 'case')}."]


def _advice_sentences(study: Study) -> list[str]:
    """Return the limit to add to a grid without limits."""
    if case_ranking_of(study).question not in case_ranking.CONTENT_QUESTIONS:
        return []
    text = advice.suggest_limit(answer_cases(study))
    return [f"{re.sub(r'limits: .*$', lambda found: f'`{found[0]}`', text)}".removesuffix(".") + "."]


def force_ratio_sentences(study: Study) -> list[str]:
    """Return the largest ratio of resultant to ideal forces for each joint."""
    sentences = []
    for joint in study.joints:
        column = joint.column("force_peak_ratio")
        if study.has(column):
            worst = study.cases[column].idxmax()
            setting_text = f", at {study.setting(worst)}" if study.swept() else ""
            columns = [joint.column(name) for name in ("load_peak", "force_peak_ideal", "force_peak_median")]
            load, ideal, *median_texts = study.texts(*((worst, name) for name in columns if study.has(name)))
            sentences.append(
                f"The load{study.joint_text(joint, ' in joint {}')} is at most {study.text(worst, column)} times the "
                f"largest reaction without clearance: {load} against {ideal}{setting_text}. "
                f"{_recurrence_text(study, joint, worst, median_texts)}."
            )
    return sentences


def _recurrence_text(study: Study, joint: Joint, case_id: str, median_texts: list[str]) -> str:
    """Return in words how often the largest peak of a case occurs.

    If there is no period, `median_texts` contains the median peak.
    """
    period = study.cases.at[case_id, "period"] if "period" in study.cases else np.nan
    if period == 1.0:
        return "This motion is periodic, so the peak recurs every revolution"
    if period > 1.0:
        return f"This motion has a period of {period:.0f} revolutions, and the peak recurs in every period"
    if not median_texts or wording.is_missing(study.cases.at[case_id, joint.column("force_peak_median")]):
        return "No period was found in this motion"
    return f"No period was found; the median peak per revolution is {median_texts[0]}"


def _limit_sentences(study: Study) -> list[str]:
    """Return sentences with the number of cases that meet the limits, and the worst and the best margin."""
    if verdict.EXCEEDED not in study.cases:
        return []
    if case_ranking_of(study).question == "life":  # then the answer has the limits
        return [*_probability_sentences(study), *_unassessed_sentences(study)]
    counted_cases = counts.limit_counts(study)
    exceeding, cases_text = counted_cases.exceeding, wording.count_text(counted_cases.cases, "case")
    count_sentence = (
        f"{exceeding} of {cases_text} exceed at least one limit"
        if exceeding
        else f"All of {cases_text} meet the limits"
    )
    is_in_answer = (
        case_ranking_of(study).question == "limits" and len(study.limits) == 1
    )  # then the answer has the limit
    count_sentence += "." if is_in_answer else f": {wording.sentence_list(_limit_texts(study))}."
    if "refine" in study.run.grid:
        count_sentence += (
            " They include cases that refine placed near the boundary, so this count is not a share of designs."
        )
    is_one_sample = sampled.is_one_sample(study.run.grid)
    sentences = [
        count_sentence,
        *([] if is_one_sample else _probability_sentences(study)),
        *_unassessed_sentences(study),
    ]
    if study.has(verdict.MARGIN):
        margins = study.cases[verdict.MARGIN]
        worst, best = margins.idxmin(), margins.idxmax()
        exceeded = study.cases.at[worst, verdict.EXCEEDED]
        exceeded_text = f" ({', '.join(column_label(study, name) for name in exceeded.split(','))})" if exceeded else ""
        extremes = (("Smallest", worst, exceeded_text), ("Largest", best, ""))
        is_best_shown = best != worst and case_ranking_of(study).question != "limits"
        for word, case_id, remark in extremes[: 1 + is_best_shown]:
            margin = verdict.margin_text(
                float(study.cases.at[case_id, verdict.MARGIN]), study.limits, study.cases.at[case_id, verdict.EXCEEDED]
            )
            case_text = f"case {wording.short_id(case_id)}"
            has_many_axes = len(study.swept()) > MAX_NAMED_AXES
            location_text = (
                f" in {case_text}"
                if has_many_axes
                else f"{_setting_text(study, case_id)}, {case_text}"
                if study.swept()
                else ""
            )
            sentences.append(f"{word} margin: {margin}{location_text}{remark}.")
    return sentences


def _limit_texts(study: Study) -> list[str]:
    """Return each limit in words, with the number of cases that exceed it if there are several limits."""
    counts_by_limit = counts.limit_counts(study).by_limit
    if len(counts_by_limit) == 1:
        return [_limit_text(study, study.limits[0])]
    counted_limits = zip(study.limits, counts_by_limit, strict=True)
    return [
        f"{_limit_text(study, limit)} ({wording.count_text(failing, 'case')})" for limit, (failing, _) in counted_limits
    ]


def _probability_sentences(study: Study) -> list[str]:
    """Return a sentence with the chance of exceeding a limit, or [] if the cases are not one random sample."""
    samples = sensitivity.samples_of(study.run)
    if len(samples) != 1 or study.run.grid["sample"]["method"] not in probability.RANDOM_METHODS:
        return []
    estimate = sensitivity.exceedance_probability(any_limit_exceeded(study, samples[0]))
    return [probability.exceedance_sentence(estimate, study.run.grid)]


def _unassessed_sentences(study: Study) -> list[str]:
    """Return a sentence with the number of cases without a verdict and the missing figures, or [] for none."""
    limits = counts.limit_counts(study)
    count = limits.unknown
    if not count:
        return []
    names = dict.fromkeys(
        limit.column for limit, (_, unknown) in zip(study.limits, limits.by_limit, strict=True) if unknown
    )
    figures_text = wording.sentence_list([column_label(study, name) for name in names])
    return [
        f"{wording.count_text(count, 'case')} cannot be assessed by {figures_text}: the figure or its limit is null "
        "(infinite, 0/0 "
        "or not computed). Such a case counts as exceeding the limit and has no margin."
    ]


def _setting_text(study: Study, case_id: str) -> str:
    return f" at {study.setting(case_id)}" if study.swept() else ""


def _table(study: Study) -> Table:
    """Return, for each limit, the number of cases that exceed it, and the case with the smallest margin."""
    columns = (
        Column("column", file_only=True),
        Column("limit"),
        Column("cases that exceed it"),
        Column("cannot be assessed"),
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
        row = int(np.nanargmin(margins)) if np.isfinite(margins).any() else int(np.argmax(fails))
        case_id = study.cases.index[row]
        values = (study.cases.at[case_id, axis.path] for axis in study.swept())
        worst = float(margins[row])
        margin = Quantity(worst, verdict.margin_text(worst, [limit], limit.column))
        of_cases = (count_cell(failing), count_cell(unknown), count_cell(limit_counts.cases))
        rows.append((limit.column, _limit_text(study, limit), *of_cases, margin, *values, case_id))
    note = (
        "The margin is 1 - value/limit, for a lower limit value/limit - 1. It is negative if the limit is exceeded. A "
        "case that cannot be assessed, because its figure is null, counts as exceeding the limit."
    )
    return Table("limits_kept", "Limits", note, columns, rows)


def _limit_text(study: Study, limit: verdict.Limit) -> str:
    """Return a limit in words: 'force peak at most 60 kN'."""
    return limit_label(study.run.layout, limit, study.unit(limit.column))


def _margin_maps(study: Study) -> list[Picture]:
    """Return the maps of the smallest margin over the pairs of axes with the largest effect."""
    if verdict.MARGIN not in study.cases or not study.has(verdict.MARGIN):
        return []
    ranked = [effect.axis for effect in main_effects_of(study, verdict.MARGIN)]
    if len(ranked) == 1:
        return []
    pairs = list(itertools.combinations(ranked, 2))[:MAX_MAPS]
    return [_margin_map(study, *sorted(pair, key=study.axes.index)) for pair in pairs]


def _margin_map(study: Study, x_axis: Axis, y_axis: Axis) -> Picture:
    margins = study.cases[verdict.MARGIN].to_numpy(float)
    exceeded = (study.cases[verdict.EXCEEDED] != "").to_numpy(float)
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
    """Return the reservation of each cell, and the remark on it.

    It is `pass_share.FAILS_ELSEWHERE` where the design exceeds a limit under some condition, `TOLERANCE_OPEN` for
    an open fit, else 0.
    """
    cases = answer_cases(study)
    design_groups = designs.designs_of(cases.varied_paths, cases.values_of, len(cases.case_ids))
    codes = np.zeros(len(cases.case_ids))
    if design_groups is not None and any(axis.path in design_groups.condition_paths for axis in pair):
        for margin, case_indices in zip(design_groups.smallest_margins, design_groups.case_indices, strict=True):
            codes[list(case_indices)] = pass_share.FAILS_ELSEWHERE * (margin < 0.0)
    names = [wording.axis_name(path) for path in design_groups.condition_paths] if design_groups is not None else []
    remark = f" (ok): met here, but not at every {wording.sentence_list(names)}." if codes.any() else ""
    fit_states = fits.classify_fits(cases)
    if fit_states is not None and fit_states.undecided and any(axis.path == fit_states.path for axis in pair):
        codes[np.isin(cases.values_of(fit_states.path), [fit["mean"] for fit in fit_states.undecided])] = (
            pass_share.TOLERANCE_OPEN
        )
        remark += " open: met at the mean clearance; an end of the fit's tolerance was not covered."
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
