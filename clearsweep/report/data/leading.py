"""The figure of a joint that leads maps, effects and comparisons, according to the grid."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from ...answers import case_ranking, labels
from ...answers.verdict import Limit
from ...contracts.layout import Layout


class LeadingFigure(NamedTuple):
    """The figure of a joint that leads maps, effects and comparisons."""

    figure: str
    name: str
    smallest: bool = False  # whether the smallest value is the worst


PEAK = LeadingFigure("force_peak", "force peak")
LEADING_FIGURES = {
    "life": LeadingFigure("life_hours", "life", smallest=True),
    "film": LeadingFigure("film_thickness_min", "least film", smallest=True),
}


def leading_figure(
    layout: Layout, limits: Iterable[Limit], has_figure: Callable[[str], bool], grid: Mapping[str, Any]
) -> LeadingFigure:
    """Return the leading figure of a page.

    It is the figure in the first limit on a figure of a joint that any case has (`has_figure`), or else a default.

    grid : as stored in run.json.
    """
    limits = tuple(limits)
    question = case_ranking.ranking_of(layout, limits, grid).question
    if question not in ("seek", "limits"):
        return LEADING_FIGURES.get(question, PEAK)
    layout_columns = {column.name: column for column in layout.columns}
    for limit in limits:
        column = layout_columns.get(limit.column)
        if column and column.joint and column.figure and has_figure(column.name):
            name = labels.column_label(layout._replace(joints=layout.joints[:1]), column.name)  # without the joint
            return LeadingFigure(column.figure, name, limit.kind == "at_least")
    return PEAK
