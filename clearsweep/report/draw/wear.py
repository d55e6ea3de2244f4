"""Drawings of wear: depth around a body, along its surface and, for spatial joints, along its axis."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator, MultipleLocator

from ...language import wording
from ...language.wording import Scale
from .style import BLUE, INK, PALE, RED, draw_colour_bar, set_plain_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.projections.polar import PolarAxes

MAX_SECTORS = 180  # of a circle, at most
BODY_STYLES = (("bearing", BLUE, "-"), ("journal", RED, "--"))  # name, colour, line


def draw_around(ax: "PolarAxes", depth: np.ndarray, body: int, scale: Scale, max_depth: float) -> None:
    """Draw the depths (m, one per angular bin) of the bearing (`body` 0) or the journal (1), up to `max_depth` (m).

    The deepest bin is marked, the mean is a dotted circle.
    """
    colour, scaled_depths, drawn_depths = (
        BODY_STYLES[body][1],
        depth / scale.factor,
        deepest_per_sector(depth, MAX_SECTORS) / scale.factor,
    )
    ax.fill(_angles(drawn_depths), drawn_depths, facecolor=(colour, 0.25), edgecolor=colour, linewidth=1.2)
    ax.plot(
        np.linspace(0.0, 2.0 * np.pi, 91), np.full(91, scaled_depths.mean()), color=INK, linewidth=0.9, linestyle=":"
    )
    ax.plot(_angles(scaled_depths)[scaled_depths.argmax()], scaled_depths.max(), "o", color=colour, markersize=4.5)
    ax.set_xticks(np.radians(np.arange(0, 360, 45)))
    ax.set_rlabel_position(22.5)
    ax.yaxis.set_major_locator(MaxNLocator(4))
    ax.set_ylim(0.0, 1.08 * max_depth / scale.factor if max_depth > 0.0 else None)
    ax.tick_params(axis="y", labelsize=7)
    ax.grid(color=PALE, linewidth=0.5)
    ax.set_xlabel(f"depth [{scale.unit}]")


def draw_over_angle(ax: "Axes", depths: tuple[np.ndarray, np.ndarray], scale: Scale) -> None:
    """Draw the depths (m, one per angular bin) of bearing and journal over the angle (rad) in each body's frame."""
    for depth, (name, colour, dash) in zip(
        (deepest_per_sector(depth, MAX_SECTORS) for depth in depths), BODY_STYLES, strict=True
    ):
        ax.plot(
            np.degrees(_angles(depth)), depth / scale.factor, color=colour, linestyle=dash, linewidth=1.2, label=name
        )
    ax.xaxis.set_major_locator(MultipleLocator(90))
    ax.set(xlim=(0.0, 360.0), xlabel="angle on the body [°]", ylabel=f"depth [{scale.unit}]")
    ax.set_ylim(0.0, None)
    set_plain_axes(ax)
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, borderaxespad=0.2)


def draw_unrolled(ax: "Axes", depth: np.ndarray, length: float) -> None:
    """Draw wear depths (bins, length bins) m around a body and along it, unrolled; length : m, of the body."""
    scale, length_scale = wording.scale("m", depth.ravel()), wording.scale("m", length)
    edges = np.linspace(-0.5, 0.5, depth.shape[1] + 1) * length / length_scale.factor
    angles, max_depth = np.linspace(0.0, 360.0, depth.shape[0] + 1), max(depth.max(initial=0.0), np.finfo(float).tiny)
    mesh = ax.pcolormesh(
        angles, edges, depth.T / scale.factor, cmap="viridis", vmin=0.0, vmax=max_depth / scale.factor, rasterized=True
    )
    ax.set(xlabel="angle from the body's x axis [°]", ylabel=f"along the axis [{length_scale.unit}]")
    ax.xaxis.set_major_locator(MultipleLocator(90))
    draw_colour_bar(ax, mesh, f"depth [{scale.unit}]")


def deepest_per_sector(depth: np.ndarray, sectors: int) -> np.ndarray:
    """Return the depths (m) of a body in at most `sectors`: the deepest of adjacent bins."""
    if len(depth) <= sectors:
        return depth
    deepest: np.ndarray = np.maximum.reduceat(depth, np.arange(sectors) * len(depth) // sectors)
    return deepest


def _angles(depth: np.ndarray) -> np.ndarray:
    """Return the centres (rad) of the bins of a body."""
    centres: np.ndarray = (np.arange(len(depth)) + 0.5) * 2.0 * np.pi / len(depth)
    return centres
