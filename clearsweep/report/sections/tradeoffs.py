"""All cases at a glance: one figure over another, a point for each case."""

from typing import NamedTuple

import numpy as np

from ..blocks.picture import Picture
from ..blocks.section import Gallery, Section, without_empty
from ..data.axis import Axis
from ..data.study import Study
from ..draw import comparison
from ..statistics import elastic_range
from ..statistics.main_effects import main_effects_of


class ScatterPlot(NamedTuple):
    """One figure over another: columns of the summary and their names."""

    title: str
    x: str
    x_name: str
    y: str
    y_name: str
    caption: str


def sections(study: Study) -> list[Section]:
    """Return the clouds of the peak over p99, output error and fastest onset, or [] for few cases."""
    if len(study.cases) < 3 or not study.is_driven:
        return []
    joint = study.most_loaded_joint()
    p99 = joint.column("force_p99")
    peak, onset = joint.column("force_peak"), joint.column("onset_rate_max")
    p99_note = "Cases of equal p99 have different peaks: p99 ignores impacts shorter than 1 % of the time."
    elastic_note = elastic_range.yield_speed_sentence(study, joint)
    scatter_plots = (
        ScatterPlot("Force peak against p99", p99, "force p99", peak, "force peak", p99_note),
        ScatterPlot(
            "Position error against force",
            study.column("error_max"),
            f"{study.run.layout.output} error",
            peak,
            "force peak",
            "Points further down and to the left are better.",
        ),
        ScatterPlot("Force peak against onset rate", onset, "fastest onset", peak, "force peak", elastic_note),
    )
    strongest = next((effect.axis for effect in main_effects_of(study, peak)), None)
    pictures = [
        _picture(study, strongest, scatter_plot)
        for scatter_plot in scatter_plots
        if _varies(study, scatter_plot.x, scatter_plot.y)
    ]
    return [
        Section(
            "tradeoffs", "All cases at a glance", without_empty([Gallery("Each point is a finished case.", pictures)])
        )
    ]


def _varies(study: Study, *columns: str) -> bool:
    """Return whether cases differ in each of some figures."""
    return all(study.has(column) and study.cases[column].min() < study.cases[column].max() for column in columns)


def _picture(study: Study, axis: Axis | None, scatter_plot: ScatterPlot) -> Picture:
    """Return a cloud, coloured by the values of an axis, if any."""
    colour = axis and (study.indices_on(axis), axis)
    x, y = (study.cases[column].to_numpy(float) for column in (scatter_plot.x, scatter_plot.y))
    x, y, colour = comparison.without_covered_points(x, y, colour)
    if colour:
        value_indices = colour[0]
        colour = (np.where(value_indices < 0, np.nan, value_indices), colour[1])
    names, scales = (
        (scatter_plot.x_name, scatter_plot.y_name),
        (study.scale(scatter_plot.x), study.scale(scatter_plot.y)),
    )
    return Picture(
        scatter_plot.title,
        scatter_plot.caption,
        f"Cloud of {len(study.cases)} cases: {scatter_plot.y_name} over {scatter_plot.x_name}.",
        lambda ax: comparison.draw_cloud(ax, x, y, colour, names, scales),
    )
