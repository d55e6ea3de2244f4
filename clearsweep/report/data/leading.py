"""The figure of a joint that leads maps, effects and comparisons, according to the grid."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from ...contracts.layout import Layout
from ...judging import labels, order
from ...judging.verdict import Limit


class Lead(NamedTuple):
    """The figure of a joint that leads maps, effects and comparisons."""

    figure: str
    name: str
    smallest: bool = False  # whether the smallest value is the worst


PEAK = Lead("force_peak", "force peak")
LEADS = {
    "life": Lead("life_hours", "life", smallest=True),
    "film": Lead("film_thickness_min", "least film", smallest=True),
}


def led_by(layout: Layout, limits: Iterable[Limit], has: Callable[[str], bool], grid: Mapping[str, Any]) -> Lead:
    """Return the leading figure of a page.

    It is the figure in the first limit on a figure of a joint that any case `has`, or else a default.

    grid : as stored in run.json.
    """
    limits = tuple(limits)
    question = order.lead_of(layout, limits, grid).question
    if question not in ("seek", "limits"):
        return LEADS.get(question, PEAK)
    known = {column.name: column for column in layout.columns}
    for limit in limits:
        column = known.get(limit.column)
        if column and column.joint and column.figure and has(column.name):
            name = labels.label(layout._replace(joints=layout.joints[:1]), column.name)  # without the joint
            return Lead(column.figure, name, limit.kind == "at_least")
    return PEAK
