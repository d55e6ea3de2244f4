"""Samples on the page: spread of the figures, chances, drivers of the spread; and counts of all cases of a run."""

import itertools
from collections import Counter
from typing import NamedTuple

import numpy as np

from ...answers import judged
from ...answers.judged import (
    QUANTILES,
    RANDOM_METHODS,
    STRENGTH_NOTE,
    Estimate,
    direction_verb,
    is_clear,
    variable_correlations,
)
from ...answers.validity import THOUSAND_HOURS
from ...answers.verdict import Limit
from ...language import wording
from ...language.errors import InputError
from ...store import sum_counts
from .. import effects
from ..axis import Axis
from ..blocks.section import Block, Gallery, Note, Picture, Points, Section, Sentences, capitalise, section
from ..blocks.table import Column, Quantity, Table, axis_columns, columns_in_table, columns_of, count_cell
from ..draw import BLUE, INK, RED, comparison, label_with_unit, set_plain_axes
from ..effects import Sample, SingleEffect
from ..plot import Axes
from ..study import Study

MAX_HISTOGRAMS, MAX_BIN_EDGES = 12, 41  # drawn at most
MAX_SCATTER_PLOTS = 4  # seen at once
MAX_SCATTERED = 3  # figures, and variables of each, that are drawn
SCATTER_NOTE = (
    "Each picture shows a figure over one of the variables with the strongest effect. "
    f"{STRENGTH_NOTE} The dashed line is the limit, if one is set."
)
NOTE = (
    "Bars show the share of the cases. Dotted lines are the 5 %, 50 % and 95 % quantiles, the red line is the limit, "
    "if one is set."
)


class LimitedFigure(NamedTuple):
    """A figure of merit with its limits."""

    column: str
    name: str
    unit: str
    limits: tuple[Limit, ...]  # at most one at either end


def sample_sections(study: Study) -> list[Section]:
    """Return the section, or [] if the run has no sample or none of it finished."""
    all_samples = effects.samples_of(study.run)
    samples = [sample for sample in all_samples if sample.is_finished().any()]
    if not samples:
        return []
    if study.run.grid["sample"]["method"] in RANDOM_METHODS:
        if judged.is_one_sample(study.run.grid):
            return []  # they are part of the answer
        blocks: list[Block] = [Points(_spread_sentences(study, samples)), limit_table(study, all_samples)]
        return section("sample", "Probabilistic study", *blocks)
    table_of = index_table if study.run.grid["sample"]["method"] == "saltelli" else effect_table
    try:
        table, sentences = table_of(study, samples)
    except InputError as refusal:
        return section("sample", "What drives the spread", Sentences([f"No sensitivity. {refusal}"]))
    return section("sample", "What drives the spread", Sentences(sentences), table)


def leading_sample_sections(study: Study) -> list[Section]:
    """Return a section on the drivers of the leading figure of a sample, or [] if `sections` returns []."""
    samples = _random_samples(study)
    figures = _scattered_figures(study) if samples else []
    if not figures:
        return []
    sample = _sample_with_largest(samples, figures[0])
    correlated = figure_correlations(study, sample, figures[0].column)
    if not correlated:
        return []
    clear_count = sum(is_clear(partial) for _, _, partial in correlated)
    scatter_plots = _scatter_plots(study, sample, figures[0])[: max(clear_count, 1)]
    for figure in figures[1:]:
        scatter_plots += (
            _scatter_plots(study, _sample_with_largest(samples, figure), figure)[:1] if figure.limits else []
        )
    gallery = Gallery(SCATTER_NOTE, scatter_plots[:MAX_SCATTER_PLOTS], small=True)
    return section("sample-drivers", "What drives the spread", gallery)


def _spread_sentences(study: Study, samples: list[Sample]) -> list[str]:
    """Return sentences with median and 90 % range of the leading figure, of limited figures, and of wear."""
    texts, figures = [], limited_figures(study)
    for figure in [figure for figure in figures if figure.limits] or figures[:1]:
        texts += [_spread_sentence(study, sample, figure, sample.figures[figure.column]) for sample in samples]
    for joint in study.joints:
        rate = joint.column("wear_rate_max")
        if joint.wears and study.has(rate):
            wear_figure = LimitedFigure(rate, f"wear depth per 1000 h{study.joint_text(joint, ' ({})')}", "m", ())
            texts += [
                _spread_sentence(study, sample, wear_figure, THOUSAND_HOURS * sample.figures[rate])
                for sample in samples
            ]
    return [text for text in texts if text]


def _spread_sentence(study: Study, sample: Sample, figure: LimitedFigure, values: np.ndarray) -> str:
    """Return the sentence on the spread of a figure's values in a sample; '' if all are null."""
    if not np.isfinite(values).any():
        return ""
    low, median, high = effects.summarise_spread(values).quantiles
    numbers = [low.value, median.value, high.value, *(end for end in median[1:] if np.isfinite(end))]
    texts_of = wording.texts_in_common_unit(numbers, figure.unit)
    interval_text = f" (95 %: {' to '.join(texts_of[3:])})" if len(texts_of) == 5 else ""
    settings = [f"{name} {text}" for name, text in _axis_values(study, sample)]
    setting_text = f" at {', '.join(settings)}" if settings else ""
    low_text, median_text, high_text = texts_of[:3]
    spread = f"90 % of the cases are between {low_text} and {high_text}"
    return f"{capitalise(figure.name)}{setting_text}: median {median_text}{interval_text}; {spread}."


def _axis_values(study: Study, sample: Sample) -> list[tuple[str, str]]:
    """Return name and value of the swept axes at which a sample was drawn."""
    axis_values = [(axis, sample.point.get(axis.path)) for axis in study.swept()]
    return [(axis.name, axis.text(value)) for axis, value in axis_values if value is not None]


def _random_samples(study: Study) -> list[Sample]:
    """Return the samples with finished cases, or [] if their cases are not independent."""
    samples = [sample for sample in effects.samples_of(study.run) if sample.is_finished().any()]
    return samples if samples and study.run.grid["sample"]["method"] in RANDOM_METHODS else []


def folded_sample_sections(study: Study) -> list[Section]:
    """Return a section with spread, drivers and histograms of the figures, or [] if `sections` returns []."""
    samples = _random_samples(study)
    if not samples:
        return []
    all_samples = effects.samples_of(study.run)
    is_one_sample = judged.is_one_sample(study.run.grid)
    scatter_plots = [  # of the first figures but one, which is seen at once
        scatter_plot
        for figure in _scattered_figures(study)[1:]
        for scatter_plot in _scatter_plots(study, _sample_with_largest(samples, figure), figure)
    ]
    histograms = [
        _histogram(study, sample, figure)
        for figure in limited_figures(study)
        for sample in samples
        if np.isfinite(sample.figures[figure.column]).any()
    ]
    blocks: list[Block] = [
        *([limit_table(study, all_samples)] if is_one_sample else []),
        spread_table(study, samples),
        Gallery(SCATTER_NOTE, scatter_plots, small=True),
        rank_table(study, samples),
        Gallery(NOTE, histograms[:MAX_HISTOGRAMS], small=True),
    ]
    return section("sample-spread", "Spread of the figures", *blocks)


def _scattered_figures(study: Study) -> list[LimitedFigure]:
    """Return the figures to draw over the variables, those with a limit first."""
    return sorted(limited_figures(study), key=lambda figure: not figure.limits)[:MAX_SCATTERED]


def _sample_with_largest(samples: list[Sample], figure: LimitedFigure) -> Sample:
    """Return the sample with the largest value of a figure."""
    return max(samples, key=lambda sample: float(np.nan_to_num(sample.figures[figure.column]).max()))


def _scatter_plots(study: Study, sample: Sample, figure: LimitedFigure) -> list[Picture]:
    """Return pictures of a figure over the variables with the strongest correlation."""
    correlated = figure_correlations(study, sample, figure.column)[:MAX_SCATTERED]
    return [_scatter_plot(study, sample, figure, path, partial) for path, _, partial in correlated]


def _scatter_plot(study: Study, sample: Sample, figure: LimitedFigure, path: str, correlation: Estimate) -> Picture:
    """Return one figure over one variable, with its partial rank correlation and its limit."""
    y, x = sample.figures[figure.column], np.asarray(study.run.grid["sample"]["drawn"][path], float)
    axis = next(axis for axis in study.axes if axis.path == path)
    scale = study.scale(figure.column)
    bounds = [limit.value / scale.factor for limit in figure.limits if not limit.times]
    caption = _strength_text(correlation)

    def paint(ax: Axes) -> None:
        comparison.draw_cloud(ax, x, y, None, (axis.name, figure.name), (axis.scale, scale))
        for limit_line in bounds:
            ax.axhline(limit_line, color=RED, linewidth=1.2, linestyle="--")

    title = f"{capitalise(figure.name)} over {axis.name}"
    return Picture(title, caption, f"{title}, {len(y)} cases. {caption}", paint, size=(3.3, 2.8))


def _strength_text(correlation: Estimate) -> str:
    """Return the trend of a figure with a variable in words, with the interval of its strength."""
    ends = [wording.number_text(end, 2) for end in correlation[1:]]
    if not is_clear(correlation):
        return f"No clear trend: partial rank correlation {ends[0]} to {ends[1]} (95 %)."
    low, high = sorted(abs(end) for end in correlation[1:])
    strength, *ends = (wording.number_text(size, 2) for size in (abs(correlation.value), low, high))
    return f"It {direction_verb(correlation.value)}, strength {strength} (95 %: {ends[0]} to {ends[1]})."


def _histogram(study: Study, sample: Sample, figure: LimitedFigure) -> Picture:
    """Return the histogram of one figure, with its quantiles and its limit."""
    values = sample.figures[figure.column]
    values = values[np.isfinite(values)]
    scale = study.scale(figure.column)
    quantiles = tuple(np.quantile(values, QUANTILES))
    settings = [f"{name} {text}" for name, text in _axis_values(study, sample)]
    share_quantiles = zip(QUANTILES, quantiles, strict=True)
    absolute_limits = [limit.value for limit in figure.limits if not limit.times]
    alt = ", ".join(f"{share:.0%} quantile {scale.text(quantile)}" for share, quantile in share_quantiles)

    def paint(ax: Axes) -> None:
        scaled = values / scale.factor
        edges = np.histogram_bin_edges(scaled, "auto" if np.ptp(scaled) > 1e-9 * np.abs(scaled).max() else 1)
        edges = edges if len(edges) <= MAX_BIN_EDGES else np.linspace(edges[0], edges[-1], MAX_BIN_EDGES)
        ax.hist(scaled, edges.tolist(), weights=np.full(len(scaled), 100.0 / len(scaled)), color=BLUE, alpha=0.85)
        for quantile in quantiles:
            ax.axvline(quantile / scale.factor, color=INK, linewidth=0.9, linestyle=":")
        for limit in absolute_limits[:1]:
            ax.axvline(limit / scale.factor, color=RED, linewidth=1.4)
        ax.set_labels(label_with_unit(figure.name, scale), "cases [%]")
        set_plain_axes(ax)

    return Picture(
        capitalise(figure.name),
        "; ".join(settings),
        f"Histogram of {figure.name}, {len(values)} cases. {alt}",
        paint,
        size=(3.3, 2.8),
    )


# Tables of a sample: spread of figures, chance of exceeding limits, variables that drive the spread.


def limited_figures(study: Study) -> list[LimitedFigure]:
    """Return the figures whose spread is shown: the main ones, and those with a limit."""
    name_by_column = dict(columns_in_table(study, "sample"))
    further = [*(study.run.grid.get("figures") or {}), *(limit.column for limit in study.limits)]
    name_by_column |= {column: column.replace("_", " ") for column in further if column not in name_by_column}
    return [
        LimitedFigure(
            column, name, study.unit(column), tuple(limit for limit in study.limits if limit.column == column)
        )
        for column, name in name_by_column.items()
        if study.has(column)
    ]


def spread_table(study: Study, samples: list[Sample]) -> Table:
    """Return mean, variation and quantiles of every figure."""
    columns = [*figure_columns(study), Column("cases")]
    for name in ("mean", "cv", "5 % quantile", "median", "95 % quantile"):
        columns += estimate_columns(name)
    rows = []
    for figure in limited_figures(study):
        for sample in samples:
            values = sample.figures[figure.column]
            if np.isfinite(values).any():
                spread = effects.summarise_spread(values)
                cells = [*estimate_cells(spread.mean, figure.unit), *estimate_cells(spread.cv, "1")]
                cells += [cell for quantile in spread.quantiles for cell in estimate_cells(quantile, figure.unit)]
                rows.append((figure.name, figure.unit, *point_cells(study, sample), count_cell(spread.cases), *cells))
    failed = sum(len(sample.failed) for sample in samples)
    failed_note = f"{wording.count_text(failed, 'failed case')} left out: the figures may be biased." if failed else ""
    note = (
        "Brackets contain the 95 % confidence interval: from the bootstrap for mean and cv (standard deviation over "
        f"mean), from order statistics for quantiles. A dash ({wording.DASH}) marks an end for which there are too few "
        f"cases. {failed_note}"
    )
    return Table("distribution", "Spread of the figures", note.strip(), columns, rows)


def limit_table(study: Study, samples: list[Sample]) -> Table:
    """Return the chance of exceeding each limit and, if cases failed, the chance with these counted as failures."""
    failures = any(sample.failed for sample in samples)
    columns = [*figure_columns(study), *columns_of("limit | cases"), *estimate_columns("probability of exceeding it")]
    columns += estimate_columns("or of failing") if failures else []
    rows = []
    for figure in limited_figures(study):
        for limit, sample in itertools.product(figure.limits, samples):
            is_exceeding = limit.is_exceeded(sample.figures)[sample.is_finished()]
            if len(is_exceeding) or sample.failed:
                limit_cell = Quantity(limit.value, limit.bound_text(figure.unit))
                cells = _probability_cells(is_exceeding, _failed_rows(sample), failures=failures)
                rows.append((figure.name, figure.unit, *point_cells(study, sample), limit_cell, *cells))
    for sample in samples if len(rows) > len(samples) else []:
        cells = _probability_cells(any_limit_exceeded(study, sample), _failed_rows(sample), failures=failures)
        rows.append(("at least one of them", "", *point_cells(study, sample), "", *cells))
    note = (
        "Brackets contain the exact 95 % confidence interval (Clopper and Pearson). A case whose figure is null "
        "does not count as exceeding its limit."
    )
    if failures:
        failed = sum(len(sample.failed) for sample in samples)
        note += (
            f" The first probability leaves out {wording.count_text(failed, 'failed case')}, so it is too low if "
            "violent cases fail. The second counts failed cases as exceeding every limit."
        )
    return Table("limits", "Probability of exceeding limits", note, columns, rows)


def _probability_cells(exceeds: np.ndarray, failed: int, *, failures: bool) -> list[Quantity]:
    """Return the number of cases, the chance of exceeding a limit and, with `failures`, of exceeding it or failing."""
    cells = [count_cell(len(exceeds)), *_chance_cells(exceeds)]
    return [*cells, *_chance_cells(np.append(exceeds, np.ones(failed, bool)))] if failures else cells


def _chance_cells(exceeds: np.ndarray) -> list[Quantity]:
    """Return the cells of the chance of exceeding a limit, unknown without cases."""
    unknown = Estimate(np.nan, np.nan, np.nan)
    return estimate_cells(effects.exceedance_probability(exceeds) if len(exceeds) else unknown, "1")


def _failed_rows(sample: Sample) -> int:
    """Return the number of failed rows of a sample's design."""
    failed = set(sample.failed)
    return sum(case_id in failed for case_id in sample.case_ids)


def any_limit_exceeded(study: Study, sample: Sample) -> np.ndarray:
    """Return a mask of the finished cases of a sample that exceed a limit."""
    exceeds: np.ndarray = np.any([limit.is_exceeded(sample.figures) for limit in study.limits], axis=0)
    return exceeds[sample.is_finished()]


def index_table(study: Study, samples: list[Sample]) -> tuple[Table, list[str]]:
    """Return the Sobol indices of every variable for every figure, and remarks on chaos."""
    columns = [Column("figure"), *axis_columns(study, _fixed_axes(study)), Column("variable")]
    columns += [*estimate_columns("first-order index"), *estimate_columns("total index")]
    columns += columns_of("share of chance | chance was* | verdict")
    names = variable_names(study)
    rows: list[tuple] = []
    verdicts: dict[str, str] = {}  # chaotic or possibly chaotic figure -> which of these
    measured = False
    for figure in limited_figures(study):
        for sample in samples:
            indices = effects.sobol_indices(sample, figure.column, list(names))
            chance = effects.share_of_chance(sample, figure.column, indices)
            measured |= chance.is_measured
            verdict = ("chaotic" if chance.is_measured else "may be chaotic") if chance.is_chaotic else ""
            if verdict:
                verdicts[figure.name] = verdict
            source = "measured" if chance.is_measured else "bounded"
            limit_text = "at most about " if not chance.is_measured and chance.share >= 0.01 else ""
            for row_index, index in enumerate(indices):  # the page shows the share of chance once per figure
                head_cells = (figure.name, *point_cells(study, sample), names[index.path])
                cells = (*estimate_cells(index.first, "1"), *estimate_cells(index.total, "1"))
                texts = (limit_text + wording.percent_text(chance.share), verdict) if row_index == 0 else ("", "")
                share_cells = (Quantity(chance.share, texts[0]), source, Quantity(verdict, texts[1]))
                rows.append((*head_cells, *cells, *share_cells))
    note = (
        "The first-order index is the share of the figure's variance that the variable explains by itself; the total "
        "index includes all its interactions. Brackets contain the bootstrap interval. The share of chance is the "
        "share of the variance that chaos causes. If it is one half or more, the figure is chaotic: a tiny disturbance "
        "changes it as much as the variables do."
    )
    sentences = [
        _chaos_advice([name for name in verdicts if verdicts[name] == verdict], verdict)
        for verdict in dict.fromkeys(verdicts.values())
    ]
    if not measured:
        sentences.append(
            "This run only gives an upper bound of the share of chance: the smallest total index of a variable that "
            "has an effect. A run with `error_check: true` in `simulate` measures the share."
        )
    return Table("sensitivity", "Sobol indices", note, columns, rows), sentences


def effect_table(study: Study, samples: list[Sample]) -> tuple[Table, list[str]]:
    """Return the effect of each single variable on every figure, and remarks on chaos."""
    heads = "variable | at its 5 % quantile | in the middle | at its 95 % quantile | scatter | verdict"
    columns = [*figure_columns(study), *columns_of(heads)]
    names = variable_names(study)
    rows: list[tuple] = []
    chaotic: dict[str, None] = {}  # names of figures, without repetition
    for figure in limited_figures(study):
        for sample in samples:
            for effect in effects.single_effects(sample, figure.column, list(names)):
                if effect.is_chaotic:
                    chaotic[figure.name] = None
                numbers = (effect.low, effect.median, effect.high, effect.scatter)
                texts = wording.texts_in_common_unit(numbers, figure.unit)
                cells = [Quantity(value, text) for value, text in zip(numbers, texts, strict=True)]
                head_cells = (figure.name, figure.unit, *point_cells(study, sample), names[effect.path])
                rows.append((*head_cells, *cells, _scatter_remark(effect)))
    note = (
        "Each variable changes alone, with the others at their medians. The scatter is the change of the figure under "
        "disturbances of 1e-9 of their ranges. With `error_check`, it is the change at a tenth of the tolerance."
    )
    sentences = [_chaos_advice(list(chaotic), "chaotic")] if chaotic else []
    return Table("one_at_a_time", "One-at-a-time effects", note, columns, rows), sentences


def _scatter_remark(effect: SingleEffect) -> str:
    """Return the remark on an effect compared with its scatter, or '' if none is needed."""
    if effect.is_chaotic:
        return "chaotic: scatter as large as the effect"
    blurred = effect.blurred()
    return "" if np.isnan(blurred) else f"blurred: scatter is {wording.percent_text(blurred)} of the effect"


def _chaos_advice(figures: list[str], verdict: str) -> str:
    """Return advice on figures that are chaotic or may be."""
    is_plural = len(figures) > 1
    state_text = f"{'are' if is_plural else 'is'} {'' if verdict == 'chaotic' else 'not known to be free of '}"
    state_text += "chaotic here" if verdict == "chaotic" else "chaos here"
    names = wording.sentence_list(figures)
    sentence = f"{names} {state_text}: apparent effects of a variable may be chance."
    return f"{sentence[0].upper()}{sentence[1:]} Use p99 or rms instead of peaks, or a longer run."


def variable_names(study: Study) -> dict[str, str]:
    """Return the drawn paths, each with its name in words."""
    return {path: wording.axis_name(path, len(study.joints)) for path in study.run.grid["sample"]["drawn"]}


def _fixed_axes(study: Study) -> list[Axis]:
    drawn = study.run.grid["sample"]["drawn"]
    return [axis for axis in study.swept() if axis.path not in drawn]


def figure_columns(study: Study) -> list[Column]:
    """Return the columns for figure and the values of the axes that were not drawn."""
    return [Column("figure"), Column("figure unit", file_only=True), *axis_columns(study, _fixed_axes(study))]


def point_cells(study: Study, sample: Sample) -> list[float | str]:
    """Return the values of the axes that were not drawn for a sample."""
    return [sample.point[axis.path] for axis in _fixed_axes(study)]


def estimate_columns(name: str) -> list[Column]:
    """Return the columns of an estimate: one on the page, three in the file."""
    return [Column(name), Column(f"{name}, low", file_only=True), Column(f"{name}, high", file_only=True)]


def estimate_cells(estimate: Estimate, unit: str) -> list[Quantity]:
    """Return an estimate with its interval: one cell on the page, three in the file."""
    scale = wording.scale(unit, [end for end in estimate if np.isfinite(end)])
    low, high = scale.number_text(estimate.low), scale.number_text(estimate.high)
    interval = f" ({low} to {high})" if np.isfinite((estimate.low, estimate.high)).any() else ""
    return [
        Quantity(estimate.value, scale.text(estimate.value) + interval),
        Quantity(estimate.low, low),
        Quantity(estimate.high, high),
    ]


# Table of the variables that drive a random sample: rank correlations, chance of exceeding limits in either half.


def rank_table(study: Study, samples: list[Sample]) -> Table:
    """Return rank correlations of each figure with each drawn variable, the strongest first; empty for few cases."""
    names, drawn = variable_names(study), study.run.grid["sample"]["drawn"]
    has_limits = bool(study.run.grid.get("limits"))
    columns = [*figure_columns(study), Column("variable"), *estimate_columns("rank correlation")]
    columns += estimate_columns("others fixed")
    if has_limits:
        columns += [*estimate_columns("limits exceeded, lower half"), *estimate_columns("upper half")]
    rows = []
    for figure, sample in itertools.product(limited_figures(study), samples):
        for path, simple, partial in figure_correlations(study, sample, figure.column):
            head = (figure.name, figure.unit, *point_cells(study, sample), names[path])
            halves: list[Quantity] = []
            if has_limits:  # chance that a limit is exceeded below and above the median of the variable
                exceeds, values = any_limit_exceeded(study, sample), np.array(drawn[path], float)[sample.is_finished()]
                is_low = values <= np.median(values)
                halves = [*_chance_cells(exceeds[is_low]), *_chance_cells(exceeds[~is_low])]
            rows.append((*head, *estimate_cells(simple, "1"), *estimate_cells(partial, "1"), *halves))
    note = (
        "Spearman's rank correlation is 1 if the figure always rises with the variable, and "
        f'{wording.MINUS}1 if it always falls. Under "others fixed" is the partial rank correlation (PRCC), after '
        "regression on the other variables. Brackets contain the 95 % interval."
    )
    if has_limits:
        note += (
            " The last two columns are the probabilities that a limit is exceeded with the variable below and above "
            "its median."
        )
    return Table("rank_drivers", "What drives the spread", note, columns, rows)


def figure_correlations(study: Study, sample: Sample, column: str) -> list[tuple[str, Estimate, Estimate]]:
    """Return variable, rank correlation with a figure, and partial rank correlation, the strongest first.

    Return [] if there are too few cases or the figure is constant.
    """
    drawn = {path: np.asarray(values, float) for path, values in study.run.grid["sample"]["drawn"].items()}
    return variable_correlations(drawn, sample.figures[column])


# Counts on the page of a run: always of all cases, even if the page shows a sample.

#: Sections with counts of all cases, and their other contents; sections without counts have no note.
_NOTES = {
    "verdict": "Counts include all cases. Maps and shares come from the sample, {}.",
    "failures": "The numbers include all cases. The list contains those of the sample, {}.",
    "trust": "Counts of failed cases, and of those beyond the range of a law, include all cases. "
    "The rest comes from the sample, {}.",
    "mechanism": "",
    "setup": "",
}


class LimitCounts(NamedTuple):
    """Counts of finished cases by limits."""

    cases: int
    exceeding: int  # at least one limit
    unknown: int  # cases among them without the figure of a limit
    by_limit: list[tuple[int, int]]  # for each limit: cases that exceed it, and cases among them without its figure


def finished_and_failed(study: Study) -> tuple[int, int]:
    """Return the numbers of finished and of failed cases."""
    marks = study.run.marks()
    if not marks:
        return len(study.cases), len(study.failed)
    return sum(mark["ok"] for mark in marks), sum(mark["failed"] for mark in marks)


def failures_by_status(study: Study) -> Counter[str]:
    """Return the number of failed cases by status."""
    if study.run.marks():
        statuses = summed_counts(study, "statuses")
        del statuses["ok"]
        return statuses
    return Counter(study.failed["status"].tolist())


def limit_counts(study: Study) -> LimitCounts:
    """Return the counts of finished cases that meet the limits of the grid."""
    if study.run.marks():
        total, fails, unjudged = (summed_counts(study, part) for part in ("limits", "fails", "unjudged"))
        by_limit = [(fails[str(index)], unjudged[str(index)]) for index in range(len(study.limits))]
        return LimitCounts(total["cases"], total["any"], total["unknown"], by_limit)
    if not study.limits:
        return LimitCounts(len(study.cases), 0, 0, [])
    columns_by_limit = [limit_columns(study, limit) for limit in study.limits]
    is_exceeding, is_undecided = (
        [getattr(limit, method)(values) for limit, values in zip(study.limits, columns_by_limit, strict=True)]
        for method in ("is_exceeded", "is_undecided")
    )
    return LimitCounts(
        len(study.cases),
        int(np.any(is_exceeding, axis=0).sum()),
        int(np.any(is_undecided, axis=0).sum()),
        [(int(cases.sum()), int(undecided.sum())) for cases, undecided in zip(is_exceeding, is_undecided, strict=True)],
    )


def limit_columns(study: Study, limit: Limit) -> dict[str, np.ndarray]:
    """Return the columns that a limit uses."""
    return {name: study.cases[name] for name in limit.required_columns}


def with_note(study: Study, section: Section) -> Section:
    """Return a section with a note on the cases that its counts cover, if the page shows a sample."""
    if not section.title or not study.run.marks():
        return section
    shown = f"{len(study.cases) + len(study.failed):,} of {sum(finished_and_failed(study)):,} cases"
    text = _NOTES.get(section.key, "Counts and shares come from the sample, {}.").format(shown)
    return section._replace(blocks=[Note(text), *section.blocks]) if text else section


def summed_counts(study: Study, part: str) -> Counter[str]:
    """Return the counts of a part over all cases of a run in blocks."""
    return sum_counts([mark["counts"] for mark in study.run.marks()], part)
