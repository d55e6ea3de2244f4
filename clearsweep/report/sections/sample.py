"""The section on a sample: spread of the figures, probability of exceeding limits, drivers of the spread."""

import numpy as np

from ...answers import judged
from ...answers.judged import QUANTILES, RANDOM_METHODS, STRENGTH_NOTE, Estimate, direction_verb, is_clear
from ...answers.validity import THOUSAND_HOURS
from ...language import wording
from ...language.errors import InputError
from .. import effects
from ..blocks.section import Block, Gallery, Picture, Points, Section, Sentences, capitalise, section
from ..draw import RED, comparison
from ..effects import Sample
from ..plot import Axes
from ..samples import (
    LimitedFigure,
    effect_table,
    figure_correlations,
    index_table,
    limit_table,
    limited_figures,
    rank_table,
    spread_table,
)
from ..study import Study

MAX_HISTOGRAMS = 12  # drawn at most
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
    return section("sample-drivers", "What drives it", gallery)


def _spread_sentences(study: Study, samples: list[Sample]) -> list[str]:
    """Return sentences with median and 90 % range of the leading figure, of limited figures, and of wear."""
    texts = []
    for figure in dict.fromkeys(
        [
            *_scattered_figures(study)[:1],
            *(limited_figure for limited_figure in limited_figures(study) if limited_figure.limits),
        ]
    ):
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
    return Picture(
        capitalise(figure.name),
        "; ".join(settings),
        f"Histogram of {figure.name}, {len(values)} cases. {alt}",
        lambda ax: comparison.draw_histogram(
            ax, values, figure.name, scale, quantiles, absolute_limits[0] if absolute_limits else None
        ),
        size=(3.3, 2.8),
    )
