"""Tables of a sample: spread of figures, chance of exceeding limits, variables that drive the spread."""

import itertools
from typing import NamedTuple

import numpy as np

from ...answers.probability import Estimate
from ...answers.verdict import Limit
from ...language import wording
from ..blocks.case_table import axis_columns
from ..blocks.table import Column, Quantity, Table, count_cell
from ..data.axis import Axis
from ..data.study import Study
from ..data.table_columns import columns_in_table
from ..statistics import sensitivity
from ..statistics.sensitivity import ChanceShare, Sample, SingleEffect


class LimitedFigure(NamedTuple):
    """A figure of merit with its limits."""

    column: str
    name: str
    unit: str
    limits: tuple[Limit, ...]  # at most one at either end


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
    columns = (
        *figure_columns(study),
        Column("cases"),
        *estimate_columns("mean"),
        *estimate_columns("cv"),
        *estimate_columns("5 % quantile"),
        *estimate_columns("median"),
        *estimate_columns("95 % quantile"),
    )
    rows = []
    for figure in limited_figures(study):
        for sample in samples:
            values = sample.figures[figure.column]
            if np.isfinite(values).any():
                spread = sensitivity.summarise_spread(values)
                head_cells = (figure.name, figure.unit, *point_cells(study, sample), count_cell(spread.cases))
                quantiles = [cell for quantile in spread.quantiles for cell in estimate_cells(quantile, figure.unit)]
                rows.append(
                    (
                        *head_cells,
                        *estimate_cells(spread.mean, figure.unit),
                        *estimate_cells(spread.cv, "1"),
                        *quantiles,
                    )
                )
    note = (
        "Brackets contain the 95 % confidence interval: from the bootstrap for mean and cv (standard deviation over "
        f"mean), from order statistics for quantiles. A dash ({wording.DASH}) marks an end for which there are too few "
        f"cases. {_failed_note(samples)}"
    )
    return Table("distribution", "Spread of the figures", note.strip(), columns, rows)


def limit_table(study: Study, samples: list[Sample]) -> Table:
    """Return the chance of exceeding each limit and, if cases failed, the chance with these counted as failures."""
    failures = any(sample.failed for sample in samples)
    columns = (
        *figure_columns(study),
        Column("limit"),
        Column("cases"),
        *estimate_columns("probability of exceeding it"),
        *(estimate_columns("or of failing") if failures else ()),
    )
    rows = []
    for figure in limited_figures(study):
        for limit, sample in itertools.product(figure.limits, samples):
            is_exceeding = limit.is_exceeded(sample.figures)[sample.is_finished()]
            if len(is_exceeding) or sample.failed:
                head_cells = (figure.name, figure.unit, *point_cells(study, sample))
                limit_text = Quantity(limit.value, limit.bound_text(figure.unit))
                rows.append(
                    (
                        *head_cells,
                        limit_text,
                        *_probability_cells(is_exceeding, _failed_rows(sample), failures=failures),
                    )
                )
    for sample in samples if len(rows) > len(samples) else []:
        head_cells = ("at least one of them", "", *point_cells(study, sample))
        rows.append(
            (
                *head_cells,
                "",
                *_probability_cells(any_limit_exceeded(study, sample), _failed_rows(sample), failures=failures),
            )
        )
    note = (
        "Brackets contain the exact 95 % confidence interval (Clopper and Pearson). A case whose figure is null "
        "does not count as exceeding its limit."
    )
    if failures:
        failed = sum(len(sample.failed) for sample in samples)
        note += (
            f" The first probability leaves out {wording.count_text(failed, 'failed case')}, so it is too low if "
            "violent "
            "cases fail. The second counts failed cases as exceeding every limit."
        )
    return Table("limits", "Probability of exceeding limits", note, columns, rows)


def _probability_cells(exceeds: np.ndarray, failed: int, *, failures: bool) -> list[Quantity]:
    """Return the number of cases, the chance of exceeding a limit and, with `failures`, of exceeding it or failing."""
    none = Estimate(np.nan, np.nan, np.nan)
    cells = [
        count_cell(len(exceeds)),
        *estimate_cells(sensitivity.exceedance_probability(exceeds) if len(exceeds) else none, "1"),
    ]
    if not failures:
        return cells
    exceeds_or_fails = np.append(exceeds, np.ones(failed, bool))
    return [
        *cells,
        *estimate_cells(sensitivity.exceedance_probability(exceeds_or_fails) if len(exceeds_or_fails) else none, "1"),
    ]


def _failed_rows(sample: Sample) -> int:
    """Return the number of failed rows of a sample's design."""
    failed = set(sample.failed)
    return sum(case_id in failed for case_id in sample.case_ids)


def any_limit_exceeded(study: Study, sample: Sample) -> np.ndarray:
    """Return a mask of the finished cases of a sample that exceed a limit."""
    exceeds: np.ndarray = np.any([limit.is_exceeded(sample.figures) for limit in study.limits], axis=0)[
        sample.is_finished()
    ]
    return exceeds


def index_table(study: Study, samples: list[Sample]) -> tuple[Table, list[str]]:
    """Return the Sobol indices of every variable for every figure, and remarks on chaos."""
    columns = (
        Column("figure"),
        *axis_columns(study, _fixed_axes(study)),
        Column("variable"),
        *estimate_columns("first-order index"),
        *estimate_columns("total index"),
        Column("share of chance"),
        Column("chance was", file_only=True),
        Column("verdict"),
    )
    names = variable_names(study)
    rows: list[tuple] = []
    verdicts: dict[str, str] = {}  # chaotic or possibly chaotic figure -> which of these
    measured = False
    for figure in limited_figures(study):
        for sample in samples:
            indices = sensitivity.sobol_indices(sample, figure.column, list(names))
            chance = sensitivity.share_of_chance(sample, figure.column, indices)
            measured |= chance.is_measured
            verdict = _chaos_verdict(chance)
            if verdict:
                verdicts[figure.name] = verdict
            for row_index, index in enumerate(indices):
                head_cells = (figure.name, *point_cells(study, sample), names[index.path])
                cells = (*estimate_cells(index.first, "1"), *estimate_cells(index.total, "1"))
                rows.append((*head_cells, *cells, *_chance_cells(chance, verdict, is_shown=row_index == 0)))
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
    columns = (
        *figure_columns(study),
        Column("variable"),
        Column("at its 5 % quantile"),
        Column("in the middle"),
        Column("at its 95 % quantile"),
        Column("scatter"),
        Column("verdict"),
    )
    names = variable_names(study)
    rows: list[tuple] = []
    chaotic: dict[str, None] = {}  # names of figures, without repetition
    for figure in limited_figures(study):
        for sample in samples:
            for effect in sensitivity.single_effects(sample, figure.column, list(names)):
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


def _chaos_verdict(chance: ChanceShare) -> str:
    if not chance.is_chaotic:
        return ""
    return "chaotic" if chance.is_measured else "may be chaotic"


def _chance_cells(chance: ChanceShare, verdict: str, *, is_shown: bool) -> list[Quantity | str]:
    """Return the share of chance, its source and the verdict; the page shows them once per figure."""
    limit_text = "at most about " if not chance.is_measured and chance.share >= 0.01 else ""
    share = Quantity(chance.share, limit_text + wording.percent_text(chance.share) if is_shown else "")
    return [share, "measured" if chance.is_measured else "bounded", Quantity(verdict, verdict if is_shown else "")]


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
    return [
        Quantity(estimate.value, f"{scale.text(estimate.value)} ({low} to {high})"),
        Quantity(estimate.low, low),
        Quantity(estimate.high, high),
    ]


def _failed_note(samples: list[Sample]) -> str:
    failed = sum(len(sample.failed) for sample in samples)
    return f"{wording.count_text(failed, 'failed case')} left out: the figures may be biased." if failed else ""
