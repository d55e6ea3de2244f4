"""Drawings of a journal in a spatial bearing: its axis, the orbits of its ends, its tilt."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from ...language import wording
from .style import BLUE, GREY, INK, PALE, RED, set_crank_angle_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

END_COLOURS = (BLUE, RED)  # of the end at +z, at -z
MAX_DRAWN_POSITIONS = 24  # number of drawn positions of the axis
CIRCLE_ANGLES = np.linspace(0.0, 2.0 * np.pi, 73)


def draw_axis(ax: Any, journal_ends: np.ndarray, half_lengths: tuple[float, float], clearance: float) -> None:
    """Draw the path of the ends of a journal's axis; journal_ends : (2, n, 3) m, z along the bearing.

    half_lengths : m, half the lengths of journal and bearing.
    """
    radial_scale, axial_scale = wording.scale("m", clearance), wording.scale("m", half_lengths[0])
    circle_x, circle_y = (
        clearance / radial_scale.factor * np.cos(CIRCLE_ANGLES),
        clearance / radial_scale.factor * np.sin(CIRCLE_ANGLES),
    )
    ax.plot(
        [0.0, 0.0], [0.0, 0.0], np.array([-1.2, 1.2]) * half_lengths[1] / axial_scale.factor, color=GREY, linewidth=0.8
    )
    for end, colour, sign in zip(journal_ends, END_COLOURS, (1.0, -1.0), strict=True):
        ax.plot(
            circle_x,
            circle_y,
            np.full(circle_x.size, sign * half_lengths[0] / axial_scale.factor),
            color=INK,
            linewidth=0.8,
        )
        ax.plot(*(end[:, :2].T / radial_scale.factor), end[:, 2] / axial_scale.factor, color=colour, linewidth=0.6)
    for k in np.linspace(0, journal_ends.shape[1] - 1, min(MAX_DRAWN_POSITIONS, journal_ends.shape[1])).astype(int):
        x, y, z = journal_ends[:, k].T
        ax.plot(
            x / radial_scale.factor,
            y / radial_scale.factor,
            z / axial_scale.factor,
            color=PALE,
            linewidth=0.6,
            zorder=0,
        )
    ax.set(
        xlabel=f"x [{radial_scale.unit}]",
        ylabel=f"y [{radial_scale.unit}]",
        zlabel=f"along the bearing [{axial_scale.unit}]",
    )
    ax.set_box_aspect(None, zoom=0.8)  # so that no label is clipped
    ax.tick_params(labelsize=7)
    for side in (ax.xaxis, ax.yaxis, ax.zaxis):
        side.set_major_locator(MaxNLocator(4))


def draw_end_orbits(ax: "Axes", journal_ends: np.ndarray, clearance: float) -> None:
    """Draw the view along the bearing: the orbits (2, n, 3) m of both ends in the clearance circle."""
    scale = wording.scale("m", clearance)
    radius = clearance / scale.factor
    ax.plot(radius * np.cos(CIRCLE_ANGLES), radius * np.sin(CIRCLE_ANGLES), color=INK, linewidth=1.0)
    for end, colour, name in zip(journal_ends, END_COLOURS, ("end +z", "end -z"), strict=True):
        ax.plot(*(end[:, :2].T / scale.factor), color=colour, linewidth=0.5, alpha=0.6, label=name)
    ax.set(aspect="equal", xlabel=f"x [{scale.unit}]", ylabel=f"y [{scale.unit}]")
    ax.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.2)


def draw_tilt(ax: "Axes", angle: np.ndarray, tilt: np.ndarray, limit: float | None) -> None:
    """Draw the tilt (rad) over the crank angle (rad), and the tilt at which the journal jams."""
    ax.plot(np.degrees(angle), np.degrees(tilt), color=BLUE, linewidth=0.8)
    if limit is not None:
        ax.axhline(np.degrees(limit), color=RED, linewidth=1.1, linestyle="--", label="jams")
    ax.set(ylabel="tilt [°]", ylim=(0.0, None))
    set_crank_angle_axis(ax, angle, has_legend=limit is not None)
