"""Drawings of a journal in a spatial bearing: its axis, the orbits of its ends, its tilt."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ...language import wording
from .style import BLUE, GREY, INK, PALE, RED, over_crank

COLOURS = (BLUE, RED)  # of the end at +z, at -z
POSITIONS = 24  # number of drawn positions of the axis
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 73)


def axis(ax: Any, ends: np.ndarray, half: tuple[float, float], clearance: float) -> None:
    """Draw the path of the ends of a journal's axis, ends : (2, n, 3) m in the frame of the bearing, z along it.

    half : m, half the lengths of journal and bearing.
    """
    across, axial = wording.scale("m", clearance), wording.scale("m", half[0])
    c, s = clearance / across.factor * np.cos(CIRCLE), clearance / across.factor * np.sin(CIRCLE)
    ax.plot([0.0, 0.0], [0.0, 0.0], np.array([-1.2, 1.2]) * half[1] / axial.factor, color=GREY, linewidth=0.8)
    for end, colour, sign in zip(ends, COLOURS, (1.0, -1.0), strict=True):
        ax.plot(c, s, np.full(c.size, sign * half[0] / axial.factor), color=INK, linewidth=0.8)
        ax.plot(*(end[:, :2].T / across.factor), end[:, 2] / axial.factor, color=colour, linewidth=0.6)
    for k in np.linspace(0, ends.shape[1] - 1, min(POSITIONS, ends.shape[1])).astype(int):
        x, y, z = ends[:, k].T
        ax.plot(x / across.factor, y / across.factor, z / axial.factor, color=PALE, linewidth=0.6, zorder=0)
    ax.set(xlabel=f"x [{across.unit}]", ylabel=f"y [{across.unit}]", zlabel=f"along the bearing [{axial.unit}]")
    ax.set_box_aspect(None, zoom=0.8)  # so that no label is clipped
    ax.tick_params(labelsize=7)
    for each in (ax.xaxis, ax.yaxis, ax.zaxis):
        each.set_major_locator(MaxNLocator(4))


def face(ax: Axes, ends: np.ndarray, clearance: float) -> None:
    """Draw the view along the bearing: the orbits (2, n, 3) m of both ends in the clearance circle."""
    scale = wording.scale("m", clearance)
    radius = clearance / scale.factor
    ax.plot(radius * np.cos(CIRCLE), radius * np.sin(CIRCLE), color=INK, linewidth=1.0)
    for end, colour, name in zip(ends, COLOURS, ("end +z", "end -z"), strict=True):
        ax.plot(*(end[:, :2].T / scale.factor), color=colour, linewidth=0.5, alpha=0.6, label=name)
    ax.set(aspect="equal", xlabel=f"x [{scale.unit}]", ylabel=f"y [{scale.unit}]")
    ax.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.2)


def tilt(ax: Axes, angle: np.ndarray, tilted: np.ndarray, limit: float | None) -> None:
    """Draw the tilt (rad) over the crank angle (rad), and the tilt at which the journal jams."""
    ax.plot(np.degrees(angle), np.degrees(tilted), color=BLUE, linewidth=0.8)
    if limit is not None:
        ax.axhline(np.degrees(limit), color=RED, linewidth=1.1, linestyle="--", label="jams")
    ax.set(ylabel="tilt [°]", ylim=(0.0, None))
    over_crank(ax, angle, legend=limit is not None)
