"""Drawings of lives: a figure of a joint over crank revolutions."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from ...language import wording
from .style import BLUE, GREEN, GREY, RED, plain_axes, with_unit

COLOURS = (RED, BLUE, GREEN)


class DepthCurve(NamedTuple):
    """A figure of one case over revolutions."""

    name: str
    revolutions: np.ndarray  # (nodes,) from 0
    values: np.ndarray  # (nodes,) SI
    interval: tuple[float, float] | None = None  # revolutions, of the last node


def over_revolutions(ax: Axes, courses: Sequence[DepthCurve], unit: str, name: str, limit: float | None = None) -> None:
    """Draw a figure (SI, of `unit`) over revolutions, with the interval of each end, and any limit."""
    scale = wording.scale(unit, [*(value for history in courses for value in history.values), limit])
    ends = [history.revolutions[-1] for history in courses]
    turns = wording.scale("revolutions", ends)
    for history, colour in zip(courses, COLOURS, strict=False):
        x, y = history.revolutions / turns.factor, history.values / scale.factor
        ax.plot(x, y, color=colour, linewidth=1.4, marker="o", markersize=3, label=history.name)
        if history.interval:
            ax.plot(np.array(history.interval) / turns.factor, [y[-1]] * 2, color=colour, marker="|", linewidth=1.0)
    if limit is not None:
        ax.axhline(limit / scale.factor, color=GREY, linewidth=1.0, linestyle=":")
    power = turns.unit.removesuffix("revolutions").rstrip()
    ax.set(xlabel=f"revolutions [{power}]" if power else "revolutions", ylabel=with_unit(name, scale))
    ax.set_xlim(0.0, None)
    ax.set_ylim(0.0, None)
    plain_axes(ax)
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, borderaxespad=0.2)
