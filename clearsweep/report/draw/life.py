"""Drawings of lives: a figure of a joint over crank revolutions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...language import wording
from .style import BLUE, GREEN, GREY, RED, label_with_unit, set_plain_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = (RED, BLUE, GREEN)


class LifeCurve(NamedTuple):
    """A figure of one case over revolutions."""

    name: str
    revolutions: np.ndarray  # (nodes,) from 0
    values: np.ndarray  # (nodes,) SI
    interval: tuple[float, float] | None = None  # revolutions, of the last node


def draw_over_revolutions(
    ax: "Axes", curves: Sequence[LifeCurve], unit: str, name: str, limit: float | None = None
) -> None:
    """Draw a figure (SI, of `unit`) over revolutions, with the interval of each end, and any limit."""
    scale = wording.scale(unit, [*(value for curve in curves for value in curve.values), limit])
    last_revolutions = [curve.revolutions[-1] for curve in curves]
    revolution_scale = wording.scale("revolutions", last_revolutions)
    for curve, colour in zip(curves, COLOURS, strict=False):
        x, y = curve.revolutions / revolution_scale.factor, curve.values / scale.factor
        ax.plot(x, y, color=colour, linewidth=1.4, marker="o", markersize=3, label=curve.name)
        if curve.interval:
            ax.plot(
                np.array(curve.interval) / revolution_scale.factor, [y[-1]] * 2, color=colour, marker="|", linewidth=1.0
            )
    if limit is not None:
        ax.axhline(limit / scale.factor, color=GREY, linewidth=1.0, linestyle=":")
    power_text = revolution_scale.unit.removesuffix("revolutions").rstrip()
    ax.set(xlabel=f"revolutions [{power_text}]" if power_text else "revolutions", ylabel=label_with_unit(name, scale))
    ax.set_xlim(0.0, None)
    ax.set_ylim(0.0, None)
    set_plain_axes(ax)
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, borderaxespad=0.2)
