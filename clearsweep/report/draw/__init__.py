"""Drawings on given axes, independent of pages and files; here their style: colours, axes, ticks, colour bars."""

import numpy as np

from ...language import wording
from ...language.wording import Scale
from ..axis import Axis
from ..plot import Axes, ColourScale, multiples_of, round_ticks, split_decades
from ..plot.items import Side

BLUE, RED, GREEN, ORANGE, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"  # Okabe and Ito 2008
INK, GREY, PALE = "#1f2933", "#6b7785", "#c3ccd5"
JOINT_COLOURS = (BLUE, RED, GREEN)
MAX_LABELLED_TICKS = 9  # axes with more values label only some of them
SLANTED = 40.0  # degrees, of names too long to be placed side by side
POLAR_SPACE = 1.25  # half side of polar axes over the radius of their rim: space for the angles
AXIS_CHARACTERS = 36  # characters that fit side by side below a figure


def set_crank_angle_axis(ax: Axes, angle: np.ndarray, *, has_legend: bool) -> None:
    """Set up the crank angle as abscissa."""
    degrees = np.round(np.degrees(angle), 3)  # so that full turns end on a tick
    turns = (degrees.max() - degrees.min()) / 360.0 if len(degrees) else 1.0
    step = 90 if turns <= 1.01 else 180 if turns <= 2.5 else 360 * max(1, int(np.ceil(turns / 6)))
    ax.xaxis.tick_rule = multiples_of(step)
    if len(degrees):
        ax.set_xlim(degrees.min(), max(degrees.max(), degrees.min() + 1.0))
    ax.xaxis.label = "crank angle [°]"
    set_plain_axes(ax)
    if has_legend:
        ax.set_legend("above", columns=3)


def label_values(side: Side, axis: Axis, positions: np.ndarray) -> None:
    """Label the values of a grid axis at their positions; of many numbers, only some."""
    longest_label = max(len(axis.short_text(value)) for value in axis.values)
    if not axis.is_numeric:
        is_slanted = side.axis_name == "x" and len(axis.values) * (longest_label + 2) > AXIS_CHARACTERS
        side.set_ticks(positions.tolist(), axis.values, rotation=SLANTED if is_slanted else 0.0)
        return
    max_ticks = MAX_LABELLED_TICKS if side.axis_name == "y" else max(2, AXIS_CHARACTERS // (longest_label + 2))
    distances = np.log(positions) if side.is_log else positions
    labelled_indices, min_distance = [0], 0.99 * (distances.max() - distances.min()) / max_ticks
    for k in range(1, len(distances)):
        if abs(distances[k] - distances[labelled_indices[-1]]) >= min_distance:
            labelled_indices.append(k)
    side.set_ticks(positions[labelled_indices].tolist(), [axis.short_text(axis.values[k]) for k in labelled_indices])


def set_log_scale(ax: Axes, *side_names: str) -> None:
    """Make sides, 'x' or 'y', logarithmic, with ticks at 1, 2 and 5."""
    ax.set_log(*side_names)
    for side in (ax.xaxis, ax.yaxis):
        if side.axis_name in side_names:
            side.tick_rule = split_decades
            side.formatter = lambda value: wording.short_number_text(value, 2)


def draw_colour_bar(ax: Axes, scale: ColourScale, name: str, *, integers_only: bool = False) -> None:
    """Draw the colour bar of a drawing; `integers_only`: only integers have ticks."""
    side = ax.add_colour_bar(scale, name)
    if scale.is_log:
        side.tick_rule = split_decades
    if integers_only:
        side.tick_rule = round_ticks(6, integers_only=True)
    side.formatter = lambda value: wording.short_number_text(value, 3)


def set_plain_axes(ax: Axes) -> None:
    """Draw a pale grid in the background, and no line at the top and right."""
    ax.set_grid(PALE, alpha=0.7)
    ax.hide_edges("top", "right")


def set_polar_axes(ax: Axes, rim: float) -> None:
    """Draw rings and spokes around the origin up to the radius `rim`, in place of edges and ticks.

    Angles count from the right, counter-clockwise.
    """
    ax.set_square(POLAR_SPACE * rim)
    ax.hide_edges("left", "right", "top", "bottom")
    ax.set_tick_length(0.0)
    for side in (ax.xaxis, ax.yaxis):
        side.set_ticks([])
    for radius in round_ticks(4)(0.0, rim):
        if radius > 0.0:
            ax.circle((0.0, 0.0), radius, edgecolor=PALE, linewidth=0.5, zorder=0.0)
            x, y = radius * np.cos(np.radians(22.5)), radius * np.sin(np.radians(22.5))
            ax.text(x, y, wording.short_number_text(radius, 4), va="center", size=7.0)
    for degrees in range(0, 360, 45):
        x, y = rim * np.cos(np.radians(degrees)), rim * np.sin(np.radians(degrees))
        ax.plot([0.0, x], [0.0, y], color=PALE, linewidth=0.5, zorder=0.0)
        anchor = "center" if abs(x) < 0.1 * rim else "left" if x > 0.0 else "right"
        ax.text(1.06 * x, 1.09 * y, f"{degrees}°", ha=anchor, va="center", size=8.0)
    ax.circle((0.0, 0.0), rim, edgecolor=GREY, linewidth=0.8)


def label_with_unit(name: str, scale: Scale) -> str:
    """Return a name with the unit of its scale, as the label of a drawing's axis."""
    return f"{name} [{scale.unit}]" if scale.unit else name
