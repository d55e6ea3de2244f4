"""Drawings of vibration: the shaking force over a turn, its orders, waterfalls, and velocities in zones."""

import itertools
from collections.abc import Sequence

import numpy as np

from ...contracts.vibration import ZONES
from ...language import wording
from ..axis import Axis
from ..plot import Axes, ColourScale
from . import BLUE, GREY, ORANGE, PALE, RED, draw_colour_bar, label_values, label_with_unit, set_plain_axes

ZONE_COLOURS = ("#d9f0d3", "#fff7c4", "#fddbb0", "#f6b8ae")  # of the zones A to D
MIN_AMPLITUDE = 1e-4  # of the largest: smaller amplitudes of a waterfall look alike
MAX_LABELLED_ROWS = 12


def draw_hodograph(ax: Axes, force: np.ndarray, ideal: np.ndarray | None) -> None:
    """Draw the path of the end of the force (2, n) N on the frame, and that without clearance where it is known."""
    scale = wording.scale("N", float(np.abs(force).max()))
    ax.plot(*(force / scale.factor), color=BLUE, linewidth=1.1, label="with clearance")
    if ideal is not None:
        ax.plot(*(ideal / scale.factor), color=RED, linewidth=1.4, linestyle="--", label="ideal")
    ax.plot([0.0], [0.0], "+", color=GREY, markersize=6)
    ax.set_square(1.08 * max(float(np.abs(path).max()) for path in (force, ideal) if path is not None) / scale.factor)
    ax.set_labels(f"force along x [{scale.unit}]", f"force along y [{scale.unit}]")
    set_plain_axes(ax)
    ax.set_legend("above", columns=2)


def draw_orders(
    ax: Axes,
    amplitudes: np.ndarray,
    ideal: np.ndarray | None,
    unit: str,
    name: str,
    marks: Sequence[tuple[float, str]] = (),
) -> None:
    """Draw amplitudes (orders,) over the order of the crank as bars, next to those without clearance.

    marks : orders at which elements of rolling bearings pass, each with its name
    """
    values = [amplitudes] if ideal is None else [amplitudes, ideal]
    scale, width = wording.scale(unit, float(max(map(np.max, values)))), 0.8 / len(values)
    orders = np.arange(1, len(amplitudes) + 1, dtype=float)
    names = ("with clearance", "ideal")
    for k, (heights, colour) in enumerate(zip(values, (BLUE, ORANGE), strict=False)):
        place = orders + (k - 0.5 * (len(values) - 1)) * width
        ax.bar(place, heights / scale.factor, width, color=colour, label=names[k] if values[1:] else "")
    top = max(float(np.max(heights)) for heights in values) / scale.factor
    for order, text in marks:
        if order < len(amplitudes) + 0.6:
            ax.axvline(order, color=RED, linewidth=0.9, linestyle="--")
            ax.text(order, top, text, colour=RED, size=7.0, ha="left", va="top", offset=2.0)
    ax.set_xlim(0.4 if not marks else 0.0, len(amplitudes) + 0.6)
    ax.set_labels("order of the crank [1 / turn]", label_with_unit(name, scale))
    set_plain_axes(ax)
    if values[1:]:
        ax.set_legend("above", columns=2)


def draw_waterfall(ax: Axes, amplitudes: np.ndarray, rows: Sequence[str], labels: tuple[str, str], unit: str) -> None:
    """Draw amplitudes (rows, orders) over the order of the crank as colours, one row for each speed.

    rows : their names; labels : of the rows' side and of the amplitude
    """
    largest = float(np.nanmax(amplitudes))
    scale = wording.scale(unit, largest)
    colours = ColourScale(MIN_AMPLITUDE * largest / scale.factor, largest / scale.factor, is_log=True)
    shown = np.maximum(amplitudes, MIN_AMPLITUDE * largest) / scale.factor
    ax.cells(np.arange(0.5, amplitudes.shape[1] + 1.0), np.arange(-0.5, len(rows)), shown, colours)
    orders = range(1, amplitudes.shape[1] + 1, -(-amplitudes.shape[1] // MAX_LABELLED_ROWS))
    ax.xaxis.set_ticks(list(orders), list(map(str, orders)))
    step = -(-len(rows) // MAX_LABELLED_ROWS)
    ax.yaxis.set_ticks(list(range(0, len(rows), step)), list(rows)[::step])
    ax.set_labels("order of the crank [1 / turn]", labels[0])
    draw_colour_bar(ax, colours, label_with_unit(labels[1], scale))


def draw_zones(ax: Axes, axis: Axis, velocities: Sequence[tuple[str, np.ndarray]], bounds: Sequence[float]) -> None:
    """Draw velocities (values of the axis,) m/s over an axis, with the zones as bands; each with its name."""
    largest = max(float(np.nanmax(values)) for _, values in velocities)
    scale, top = wording.scale("m/s", largest), 1.1 * max(largest, bounds[0])
    edges = [0.0, *[bound for bound in bounds if bound < top], top]
    for k, (low, high) in enumerate(itertools.pairwise(edges)):
        ax.axhspan(low / scale.factor, high / scale.factor, color=ZONE_COLOURS[k], zorder=0.0)
        ax.add_legend_entry(f"zone {ZONES[k]}", ZONE_COLOURS[k])
    positions = np.arange(len(axis.values), dtype=float)
    for (name, values), colour in zip(velocities, (BLUE, GREY), strict=False):
        ax.plot(positions, values / scale.factor, "o-", color=colour, markersize=3.5, label=name)
    label_values(ax.xaxis, axis, positions)
    ax.set_ylim(0.0, top / scale.factor)
    ax.set_labels(axis.label(), f"velocity, rms [{scale.unit}]")
    ax.set_grid(PALE, 0.0)
    set_plain_axes(ax)
    ax.set_legend("above", columns=3)
