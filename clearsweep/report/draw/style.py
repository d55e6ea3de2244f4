"""Shared style of all drawings: colours, axes, ticks and colour bars."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, MultipleLocator, NullLocator

from ...language import wording
from ...language.wording import Scale
from ..axis import Axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import XAxis, YAxis

BLUE, RED, GREEN, ORANGE, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"  # Okabe and Ito 2008
INK, GREY, PALE = "#1f2933", "#6b7785", "#c3ccd5"
JOINT_COLOURS = (BLUE, RED, GREEN)
MAX_LABELLED_TICKS = 9  # axes with more values label only some of them
SLANTED_LABEL_STYLE: dict[str, Any] = {
    "rotation": 40,
    "ha": "right",
    "rotation_mode": "anchor",
}  # names too long to be placed side by side
AXIS_CHARACTERS = 36  # characters that fit side by side below a figure


def set_crank_angle_axis(ax: "Axes", angle: np.ndarray, *, has_legend: bool) -> None:
    """Set up the crank angle as abscissa."""
    degrees = np.round(np.degrees(angle), 3)  # so that full turns end on a tick
    turns = (degrees.max() - degrees.min()) / 360.0 if len(degrees) else 1.0
    step = 90 if turns <= 1.01 else 180 if turns <= 2.5 else 360 * max(1, int(np.ceil(turns / 6)))
    ax.xaxis.set_major_locator(MultipleLocator(step))
    if len(degrees):
        ax.set_xlim(degrees.min(), max(degrees.max(), degrees.min() + 1.0))
    ax.set_xlabel("crank angle [°]")
    set_plain_axes(ax)
    if has_legend:
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, borderaxespad=0.2)


def label_values(side: "XAxis | YAxis", axis: Axis, positions: np.ndarray) -> None:
    """Label the values of a grid axis at their positions; of many numbers, only some."""
    longest_label = max(len(axis.short_text(value)) for value in axis.values)
    if not axis.is_numeric:
        is_slanted = side.axis_name == "x" and len(axis.values) * (longest_label + 2) > AXIS_CHARACTERS
        side.set_ticks(positions, axis.values, **(SLANTED_LABEL_STYLE if is_slanted else {}))
        return
    max_ticks = MAX_LABELLED_TICKS if side.axis_name == "y" else max(2, AXIS_CHARACTERS // (longest_label + 2))
    distances = np.log(positions) if side.get_scale() == "log" else positions
    labelled_indices, min_distance = [0], 0.99 * (distances.max() - distances.min()) / max_ticks
    for k in range(1, len(distances)):
        if abs(distances[k] - distances[labelled_indices[-1]]) >= min_distance:
            labelled_indices.append(k)
    side.set_major_locator(NullLocator())
    side.set_minor_locator(NullLocator())
    side.set_ticks(positions[labelled_indices], [axis.short_text(axis.values[k]) for k in labelled_indices])


def set_log_scale(ax: "Axes", side_name: str) -> None:
    """Make one side, 'x' or 'y', logarithmic, with ticks at 1, 2 and 5."""
    getattr(ax, f"set_{side_name}scale")("log")
    side = getattr(ax, f"{side_name}axis")
    side.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    side.set_major_formatter(FuncFormatter(lambda value, _: wording.short_number_text(value, 2)))
    side.set_minor_locator(NullLocator())


def draw_colour_bar(
    ax: "Axes", mappable: ScalarMappable, name: str, *, is_logarithmic: bool = False, integers_only: bool = False
) -> None:
    """Draw the colour bar of a drawing; `integers_only`: only integers have ticks."""
    colour_bar = ax.figure.colorbar(mappable, ax=ax, fraction=0.05, pad=0.03)
    colour_bar.set_label(name)
    colour_bar.outline.set_visible(False)
    if colour_bar.solids is not None:
        colour_bar.solids.set_rasterized(True)
    if is_logarithmic:
        colour_bar.ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        colour_bar.ax.yaxis.set_minor_locator(NullLocator())
    if integers_only:
        colour_bar.ax.yaxis.set_major_locator(MaxNLocator(6, integer=True))
    colour_bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: wording.short_number_text(value, 3)))


def draw_axis_colour_bar(ax: "Axes", axis: Axis, norm: Normalize) -> None:
    """Draw the colour bar of the values of a grid axis."""
    colour_bar = ax.figure.colorbar(ScalarMappable(norm, "viridis"), ax=ax, fraction=0.05, pad=0.03)
    label_values(colour_bar.ax.yaxis, axis, np.arange(len(axis.values), dtype=float))
    colour_bar.set_label(axis.label())
    colour_bar.outline.set_visible(False)
    if colour_bar.solids is not None:
        colour_bar.solids.set_rasterized(True)


def stem_lines(x: np.ndarray, low: float, high: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of vertical lines at `x` as one line with gaps: one path in the file, not hundreds."""
    lines = np.broadcast_arrays(x, low, high, np.nan)
    return np.stack([lines[0], lines[0], lines[3]], axis=-1).ravel(), np.stack(lines[1:], axis=-1).ravel()


def set_plain_axes(ax: "Axes") -> None:
    """Draw a pale grid in the background, and no line at the top and right."""
    ax.grid(color=PALE, linewidth=0.5, alpha=0.7)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def label_with_unit(name: str, scale: Scale) -> str:
    """Return a name with the unit of its scale, as the label of a drawing's axis."""
    return f"{name} [{scale.unit}]" if scale.unit else name
