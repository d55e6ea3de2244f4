"""Drawings of kinds of motion: points at crank angle 0, spectra, shares, maps of kinds."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Circle, Patch
from matplotlib.ticker import MaxNLocator

from ...language import wording
from ..data.axis import Axis
from ..statistics.spectrum import Spectrum
from ..statistics.strobe import Points
from .heat_map import MAX_LABELLED_SHAPE, MAX_VECTOR_CELLS
from .pass_share import UNKNOWN_COLOUR
from .style import BLUE, GREY, INK, PALE, RED, draw_colour_bar, label_values, set_log_scale, set_plain_axes, stem_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KIND_COLOURS = ("#cfe3f1", "#86b8dc", "#f0c48c", "#e0824a")  # from regular to irregular, distinguishable in grey, too
SHARE_COLOURS = {"free flight": "#f0c48c", "impacts": "#e0824a", "lasting contact": "#86b8dc", "contact": "#86b8dc"}
MAX_ORDER = 40  # crank orders shown in a spectrum
MIN_AMPLITUDE = 1e-5  # of the largest amplitude, lower limit of the drawing
LEGEND_ABOVE: dict[str, Any] = {
    "loc": "lower left",
    "bbox_to_anchor": (0.0, 1.0),
    "frameon": False,
    "borderaxespad": 0.2,
    "columnspacing": 1.0,
    "handlelength": 1.2,
}


def draw_bifurcation(ax: "Axes", points: Points, axis: Axis) -> None:
    """Draw journal positions at crank angle 0 of every revolution over the values of an axis, with the clearance."""
    scale = wording.scale("m", [*np.abs(points.x), *np.abs(points.y), *points.clearance])
    abscissae = axis.scale.from_si(points.value)
    style: dict[str, Any] = {"markersize": 2.4, "markeredgewidth": 0, "alpha": 0.7, "rasterized": abscissae.size > 60}
    if np.isfinite(points.clearance).all():
        for sign in (-1.0, 1.0):
            ax.plot(abscissae, sign * points.clearance / scale.factor, color=GREY, linewidth=0.8, linestyle=":")
    for values, name, colour in ((points.x, "x", BLUE), (points.y, "y", RED)):
        ax.plot(abscissae, values / scale.factor, "o", color=colour, label=name, **style)
    distinct_abscissae = np.unique(abscissae)
    if distinct_abscissae.min() > 0.0 and distinct_abscissae.max() >= 8.0 * distinct_abscissae.min():
        set_log_scale(ax, "x")
    ax.set(xlabel=axis.label(), ylabel=f"journal centre [{scale.unit}]")
    set_plain_axes(ax)
    ax.legend(ncols=2, markerscale=2.0, **LEGEND_ABOVE)


def draw_section(ax: "Axes", revolution: np.ndarray, x: np.ndarray, y: np.ndarray, clearance: float | None) -> None:
    """Draw positions (m) of a journal at crank angle 0, coloured by the revolution, in the clearance circle."""
    scale = wording.scale("m", [*np.abs(x), *np.abs(y), clearance])
    if clearance is not None:
        ax.add_patch(Circle((0.0, 0.0), clearance / scale.factor, facecolor="#f3f6f9", edgecolor=INK, zorder=0))
    _draw_coloured_points(ax, x / scale.factor, y / scale.factor, revolution)
    half_width = 1.08 * max(float(np.hypot(x, y).max()), clearance or 0.0) / scale.factor
    ax.set(xlim=(-half_width, half_width), ylim=(-half_width, half_width), aspect="equal")
    ax.set(xlabel=f"journal x [{scale.unit}]", ylabel=f"journal y [{scale.unit}]")


def draw_velocities(ax: "Axes", revolution: np.ndarray, vx: np.ndarray, vy: np.ndarray) -> None:
    """Draw velocities (m/s) of a journal at crank angle 0, coloured by the revolution."""
    scale = wording.scale("m/s", [*np.abs(vx), *np.abs(vy)])
    _draw_coloured_points(ax, vx / scale.factor, vy / scale.factor, revolution)
    ax.set(xlabel=f"journal vx [{scale.unit}]", ylabel=f"journal vy [{scale.unit}]")
    set_plain_axes(ax)


def _draw_coloured_points(ax: "Axes", x: np.ndarray, y: np.ndarray, revolution: np.ndarray) -> None:
    points = ax.scatter(x, y, c=revolution, s=14, cmap="viridis", linewidths=0, zorder=3, rasterized=len(x) > 2000)
    draw_colour_bar(ax, points, "revolution", integers_only=True)
    for side in (ax.xaxis, ax.yaxis):
        side.set_major_locator(MaxNLocator(5))


def draw_spectrum(ax: "Axes", actual: Spectrum, ideal: Spectrum | None, unit: str, name: str) -> None:
    """Draw amplitudes (SI) over the crank's orders, with its harmonics marked, and those of the ideal mechanism."""
    max_amplitude = float(actual.amplitude.max())
    scale = wording.scale(unit, max_amplitude)
    in_range = actual.order <= MAX_ORDER
    gridlines = stem_lines(np.arange(1, MAX_ORDER + 1), 0.0, 1.0)
    ax.plot(*gridlines, transform=ax.get_xaxis_transform(), color=PALE, linewidth=0.5)
    floor = MIN_AMPLITUDE * max_amplitude / scale.factor
    heights = actual.amplitude[in_range] / scale.factor
    lines = stem_lines(actual.order[in_range], floor, heights.clip(min=floor))
    ax.plot(*lines, color=BLUE, linewidth=1.1, label="with clearance")
    if ideal is not None:
        is_drawn = (ideal.order <= MAX_ORDER) & (ideal.amplitude > MIN_AMPLITUDE * max_amplitude)
        ax.plot(
            ideal.order[is_drawn], ideal.amplitude[is_drawn] / scale.factor, "_", color=RED, markersize=6, label="ideal"
        )
    ax.set(yscale="log", xlim=(0.0, MAX_ORDER + 0.5), ylim=(floor, 3.0 * max_amplitude / scale.factor))
    ax.set(xlabel="order of the crank [1 / turn]", ylabel=f"amplitude of {name} [{scale.unit}]")
    ax.spines[["top", "right"]].set_visible(False)
    if ideal is not None:
        ax.legend(ncols=2, **LEGEND_ABOVE)


def draw_shares(ax: "Axes", axis: Axis, shares: np.ndarray, names: Sequence[str], colours: Sequence[str]) -> None:
    """Draw stacked bars of shares, (names, values of the axis), one bar per value."""
    positions, bottom = np.arange(len(axis.values), dtype=float), np.zeros(len(axis.values))
    for share, name, colour in zip(shares, names, colours, strict=True):
        ax.bar(positions, 100.0 * share, 0.86, bottom, color=colour, label=name, linewidth=0)
        bottom += 100.0 * share
    label_values(ax.xaxis, axis, positions)
    ax.set(xlabel=axis.label(), ylabel="share [%]", ylim=(0.0, 100.0))
    set_plain_axes(ax)
    ax.legend(ncols=4, **LEGEND_ABOVE)


def draw_kinds(
    ax: "Axes", table: np.ndarray, cell_texts: np.ndarray, axes: tuple[Axis, Axis], names: Sequence[str]
) -> None:
    """Draw the kind of every cell as an index in `names`; cells without a case are NaN.

    `table` : (values of the second axis, values of the first)
    `cell_texts` : texts of the cells in the same shape, drawn if they are few
    """
    x_axis, y_axis = axes
    ax.set_facecolor(UNKNOWN_COLOUR)
    edges = [np.arange(size + 1) - 0.5 for size in table.shape[::-1]]
    ax.pcolormesh(
        *edges,
        np.ma.masked_invalid(table),
        cmap=ListedColormap(KIND_COLOURS[: len(names)]),
        vmin=-0.5,
        vmax=len(names) - 0.5,
        rasterized=table.size > MAX_VECTOR_CELLS,
        edgecolors="white" if table.size <= MAX_LABELLED_SHAPE[0] * MAX_LABELLED_SHAPE[1] else "face",
        linewidth=0.8,
    )
    if all(size <= limit for size, limit in zip(table.shape, MAX_LABELLED_SHAPE, strict=True)):
        for (row, column), text in np.ndenumerate(cell_texts):
            ax.text(column, row, text, ha="center", va="center", fontsize=7, color="black")
    label_values(ax.xaxis, x_axis, np.arange(len(x_axis.values), dtype=float))
    label_values(ax.yaxis, y_axis, np.arange(len(y_axis.values), dtype=float))
    ax.set(xlabel=x_axis.label(), ylabel=y_axis.label())
    ax.tick_params(length=0)
    present_kinds = [kind for kind in range(len(names)) if (table == kind).any()]
    patches = [Patch(color=KIND_COLOURS[kind], label=names[kind]) for kind in present_kinds]
    ax.legend(handles=patches, ncols=4, **LEGEND_ABOVE)
