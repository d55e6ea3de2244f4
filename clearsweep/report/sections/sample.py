"""The section on a sample: how the figures spread, how likely limits are exceeded, what drives the spread."""

import numpy as np
from matplotlib.axes import Axes

from ...judging.probability import INDEPENDENT
from ...language import wording
from ...language.errors import InputError
from ..blocks.picture import Picture, capital
from ..blocks.section import Block, Gallery, Section, Sentences, filled
from ..data.study import Study
from ..draw import comparison
from ..draw.style import RED
from ..samples.rank_table import correlations, rank_table
from ..samples.sample_tables import Judged, effect_table, index_table, limit_table, limited_figures, spread_table
from ..statistics import sensitivity
from ..statistics.sensitivity import Estimate, Setting

HISTOGRAMS = 12  # drawn at most
SCATTERED = 3  # figures, and variables of each, that are drawn
SCATTER_NOTE = (
    "The figures over the variables that go with them most; in brackets the 95 % interval; dashed: the limit, where "
    "one is set."
)
NOTE = "Share of the cases; dotted: 5 %, 50 % and 95 % quantiles; red: the limit, where one is set."


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if the run has no sample or none of it finished."""
    every = sensitivity.settings(study.run)
    samples = [sample for sample in every if len(sample.failed) < len(set(sample.case_ids))]
    if not samples:
        return []
    if study.run.grid["sample"]["method"] in INDEPENDENT:
        tables: list[Block] = [limit_table(study, every), spread_table(study, samples)]
        return [Section("sample", "Probabilistic study", filled(tables))]
    return [Section("sample", "What drives the spread", filled(_sensitivity(study, samples)))]


def more(study: Study) -> list[Section]:
    """Return what drives the spread of a sample, and the figures as histograms; [] as for `sections`."""
    every = sensitivity.settings(study.run)
    samples = [sample for sample in every if len(sample.failed) < len(set(sample.case_ids))]
    if not samples or study.run.grid["sample"]["method"] not in INDEPENDENT:
        return []
    blocks: list[Block] = [
        Gallery(SCATTER_NOTE, _scatter(study, samples), small=True),
        rank_table(study, samples),
        Gallery(NOTE, _histograms(study, samples), small=True),
    ]
    return [Section("sample-spread", "What drives the spread", filled(blocks))]


def _sensitivity(study: Study, samples: list[Setting]) -> list[Block]:
    """Return what the design was made for, or why there is none of it."""
    table_of = index_table if study.run.grid["sample"]["method"] == "saltelli" else effect_table
    try:
        table, sentences = table_of(study, samples)
    except InputError as refusal:
        return [Sentences([f"No sensitivity. {refusal}"])]
    return [Sentences(sentences), table]


def _scatter(study: Study, samples: list[Setting]) -> list[Picture]:
    """Return the first figures over the variables that go with each most, limited ones first; not of too few cases."""
    figures = sorted(limited_figures(study), key=lambda figure: not figure.limits)[:SCATTERED]
    pictures = []
    for figure in figures:
        sample = max(samples, key=lambda each: float(np.nan_to_num(each.figures[figure.column]).max()))
        correlated = correlations(study, sample, figure.column)[:SCATTERED]
        pictures += [_cloud(study, sample, figure, path, alone) for path, alone, _ in correlated]
    return pictures


def _cloud(study: Study, sample: Setting, figure: Judged, path: str, correlation: Estimate) -> Picture:
    """Return one figure over one variable, with its rank correlation and its limit."""
    y, x = sample.figures[figure.column], np.asarray(study.run.grid["sample"]["drawn"][path], float)
    axis = next(axis for axis in study.axes if axis.path == path)
    scale = wording.scale(figure.unit, y[np.isfinite(y)])
    bounds = [limit.value / scale.factor for limit in figure.limits if not limit.times]
    low, high = (wording.plain(end, 2) for end in correlation[1:])
    said = f"Rank correlation {wording.plain(correlation.value, 2)} ({low} to {high})."

    def paint(ax: Axes) -> None:
        comparison.cloud(ax, x, y, None, (axis.name, figure.name), (axis.scale, scale))
        for limit_line in bounds:
            ax.axhline(limit_line, color=RED, linewidth=1.2, linestyle="--")

    title = f"{capital(figure.name)} over {axis.name}"
    return Picture(title, said, f"{title}, {len(y)} cases. {said}", paint, size=(3.3, 2.8))


def _histograms(study: Study, samples: list[Setting]) -> list[Picture]:
    pictures = [
        _histogram(study, sample, figure)
        for figure in limited_figures(study)
        for sample in samples
        if np.isfinite(sample.figures[figure.column]).any()
    ]
    return pictures[:HISTOGRAMS]


def _histogram(study: Study, sample: Setting, figure: Judged) -> Picture:
    """Return the histogram of one figure, with its quantiles and its limit."""
    values = sample.figures[figure.column]
    values = values[np.isfinite(values)]
    scale = wording.scale(figure.unit, values)
    marks = tuple(np.quantile(values, sensitivity.QUANTILES))
    settings = [
        f"{axis.name} {axis.text(sample.point[axis.path])}"
        for axis in study.swept()
        if sample.point.get(axis.path) is not None
    ]
    quantiles = zip(sensitivity.QUANTILES, marks, strict=True)
    fixed = [limit.value for limit in figure.limits if not limit.times]
    alt = ", ".join(f"{share:.0%} quantile {scale.text(mark)}" for share, mark in quantiles)
    return Picture(
        capital(figure.name),
        "; ".join(settings),
        f"Histogram of {figure.name}, {len(values)} cases. {alt}",
        lambda ax: comparison.histogram(ax, values, figure.name, scale, marks, fixed[0] if fixed else None),
        size=(3.3, 2.8),
    )
