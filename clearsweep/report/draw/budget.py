"""Drawing of an error budget: a bar per unknown, from the lowest to the highest change of a figure."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from .style import BLUE, INK, plain_axes


def tornado(ax: Axes, bars: Sequence[tuple[str, float, float, str, str]], name: str) -> None:
    """Draw bars from the bottom up: name, relative change down and up from the base case, settings at both ends."""
    places = np.arange(len(bars))
    down, up = (100.0 * np.array([bar[end] for bar in bars]) for end in (1, 2))
    ax.barh(places, up - down, left=down, height=0.6, color=BLUE, alpha=0.75)
    for place, (_, low, high, at_low, at_high) in zip(places, bars, strict=True):
        if low < 0.0:
            ax.annotate(at_low, (100.0 * low, place), (-3, 0), **_beside("right"))
        if high > 0.0:
            ax.annotate(at_high, (100.0 * high, place), (3, 0), **_beside("left"))
    ax.axvline(0.0, color=INK, linewidth=1.0)
    ax.set_yticks(places, [bar[0].replace(" and ", "\nand ") for bar in bars])
    ax.tick_params(axis="y", length=0)
    ax.use_sticky_edges = False  # of bars: leaves space for the words next to them
    ax.margins(x=0.25)
    ax.set_axisbelow(True)
    ax.set_xlabel(f"change of {name} [%]")
    plain_axes(ax)


def _beside(side: str) -> dict:
    return {"textcoords": "offset points", "ha": side, "va": "center", "fontsize": 7, "color": INK}
