"""Drawing of an error budget: a bar per unknown, from the lowest to the highest change of a figure."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .style import BLUE, INK, set_plain_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_tornado(ax: "Axes", bar_rows: Sequence[tuple[str, float, float, str, str]], name: str) -> None:
    """Draw bars from the bottom up: name, relative change down and up from the base case, settings at both ends."""
    positions = np.arange(len(bar_rows))
    low_changes, high_changes = (100.0 * np.array([bar_row[column] for bar_row in bar_rows]) for column in (1, 2))
    ax.barh(positions, high_changes - low_changes, left=low_changes, height=0.6, color=BLUE, alpha=0.75)
    for position, (_, low, high, low_setting, high_setting) in zip(positions, bar_rows, strict=True):
        if low < 0.0:
            ax.annotate(low_setting, (100.0 * low, position), (-3, 0), **_annotation_style("right"))
        if high > 0.0:
            ax.annotate(high_setting, (100.0 * high, position), (3, 0), **_annotation_style("left"))
    ax.axvline(0.0, color=INK, linewidth=1.0)
    ax.set_yticks(positions, [bar_row[0].replace(" and ", "\nand ") for bar_row in bar_rows])
    ax.tick_params(axis="y", length=0)
    ax.use_sticky_edges = False  # of bars: leaves space for the words next to them
    ax.margins(x=0.25)
    ax.set_axisbelow(True)
    ax.set_xlabel(f"change of {name} [%]")
    set_plain_axes(ax)


def _annotation_style(side: str) -> dict:
    """Return the options of an annotation whose text is aligned to a `side`."""
    return {"textcoords": "offset points", "ha": side, "va": "center", "fontsize": 7, "color": INK}
