"""Drawings that compare cases: effects, strips, curves, clouds, histograms, maps over two axes."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...language import wording
from ...language.wording import Scale
from ..axis import Axis
from ..effects import MainEffect
from ..plot import Axes, ColourScale
from . import (
    BLUE,
    MAX_LABELLED_TICKS,
    label_values,
    label_with_unit,
    set_log_scale,
    set_plain_axes,
)

MANY_POINTS = 300  # points of a cloud above which they are smaller
MAX_POINTS = 50_000  # points of a cloud above which covered points are omitted
NAMES_LEFT = -0.12  # left end of names above a drawing, as a share of its width
GRID_CELLS = 300  # per side of a cloud: each is smaller than a point
LOG_SCALE_RATIO = 8.0  # ratio of largest to smallest value above which an axis is logarithmic


class Curve(NamedTuple):
    """The medians of one figure of one joint over the values of an axis."""

    name: str  # in the legend; '' for none
    colour: str
    has_band: bool  # shaded from the 10th to the 90th percentile, with a solid line
    effect: MainEffect


def label_abscissa(ax: Axes, axis: Axis, positions: np.ndarray) -> None:
    """Scale and label the abscissa of an axis: its values if they are few."""
    if axis.is_geometric:
        set_log_scale(ax, "x")
    if not axis.is_numeric or len(positions) <= MAX_LABELLED_TICKS:
        label_values(ax.xaxis, axis, positions)


def draw_effect(
    ax: Axes, curves: Sequence[Curve], scale: wording.Scale, limits: tuple[float, float], name: str
) -> None:
    """Draw medians of a figure, within `limits` (SI), in the unit `scale` over the values of one axis."""
    axis = curves[0].effect.axis
    positions = tick_positions = positions_of(axis)
    has_names = not axis.is_numeric
    has_markers = has_names or len(positions) <= MAX_LABELLED_TICKS
    joint_colours = list(dict.fromkeys(curve.colour for curve in curves if curve.has_band))
    band_alpha = 0.15 if len(curves) <= 2 else 0.06
    for curve in curves:
        low, high = curve.effect.low / scale.factor, curve.effect.high / scale.factor
        if has_names:  # no line between names
            offset = joint_colours.index(curve.colour) if curve.colour in joint_colours else 0
            positions = tick_positions + 0.16 * (offset - 0.5 * (len(joint_colours) - 1))
        marker, line_style = ("o", "-") if curve.has_band else ("s", "--")
        if curve.has_band and has_names:
            ax.vlines(positions, low, high, color=curve.colour, alpha=0.3, linewidth=6)
        elif curve.has_band:
            ax.fill_between(positions, low, high, color=curve.colour, alpha=band_alpha)
        style: dict[str, Any] = {"linestyle": "" if has_names else line_style, "marker": marker if has_markers else ""}
        medians = curve.effect.medians / scale.factor
        ax.plot(positions, medians, color=curve.colour, linewidth=1.5, label=curve.name, markersize=4, **style)
    ax.set_labels(axis.label(), label_with_unit(name, scale))
    if has_names:
        ax.set_xlim(-0.5, len(positions) - 0.5)
    label_abscissa(ax, axis, tick_positions)
    if needs_log_scale(np.array(limits)):
        set_log_scale(ax, "y")
    ax.set_ylim(limits[0] / scale.factor * 0.9, limits[1] / scale.factor * 1.1)
    set_plain_axes(ax)
    if len(curves) > 1:
        ax.set_legend("above", columns=3, column_gap=1.0, sample=1.6, left=NAMES_LEFT)


def label_rows(ax: Axes, names: Sequence[str]) -> None:
    """Label the rows of a drawing, from the bottom up."""
    ax.yaxis.set_ticks(range(len(names)), names)
    ax.set_ylim(-0.6, len(names) - 0.4)
    ax.set_tick_length(0.0, "y")
    set_plain_axes(ax)


def draw_cloud(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    colour: tuple[np.ndarray, Axis] | None,
    names: tuple[str, str],
    scales: tuple[Scale, Scale],
) -> None:
    """Draw one point per case (SI, scaled); `colour` : index of its value on an axis."""
    x, y = x / scales[0].factor, y / scales[1].factor
    style: dict[str, Any] = {"size": 4.0 if len(x) <= MANY_POINTS else 2.4, "alpha": 0.85}
    if colour is None:
        ax.scatter(x, y, color=BLUE, **style)
    else:
        value_indices, axis = colour
        colours = ColourScale(0.0, float(max(len(axis.values) - 1, 1)))
        ax.scatter(x, y, values=value_indices, scale=colours, **style)
        label_values(ax.add_colour_bar(colours, axis.label()), axis, np.arange(len(axis.values), dtype=float))
    set_log_scale(ax, *(side for side, values in (("x", x), ("y", y)) if needs_log_scale(values)))
    ax.set_labels(label_with_unit(names[0], scales[0]), label_with_unit(names[1], scales[1]))
    set_plain_axes(ax)


def without_covered_points(
    x: np.ndarray, y: np.ndarray, colour: tuple[np.ndarray, Axis] | None
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, Axis] | None]:
    """Return the points of `draw_cloud` without covered ones, if they are many."""
    if len(x) <= MAX_POINTS:
        return x, y, colour
    visible = visible_points(*(np.log(values) if needs_log_scale(values) else values for values in (x, y)))
    return x[visible], y[visible], colour and (colour[0][visible], colour[1])


def needs_log_scale(values: np.ndarray) -> bool:
    """Return whether the spread of values requires a logarithmic scale."""
    known = values[np.isfinite(values)]
    return bool(known.size and known.min() > 0.0 and known.max() > LOG_SCALE_RATIO * known.min())


def visible_points(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the indices of points not covered by later ones: the last one in every small cell of the plane."""
    finite = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    cells = np.zeros(len(finite), np.int32)
    for values in (x, y):
        known = values[finite]
        low, high = (known.min(), known.max()) if len(known) else (0.0, 0.0)
        indices = (GRID_CELLS * (known - low) / (high - low or 1.0)).astype(np.int32)
        cells = cells * GRID_CELLS + indices.clip(max=GRID_CELLS - 1)
    _, last_indices = np.unique(cells[::-1], return_index=True)
    return np.sort(finite[len(finite) - 1 - last_indices])


def positions_of(axis: Axis) -> np.ndarray:
    """Return the positions of an axis's values on an abscissa."""
    if not axis.is_numeric:
        return np.arange(len(axis.values), dtype=float)
    return np.asarray(axis.scale.from_si(np.asarray(axis.values, float)))


# Heat maps: a figure as colours over two swept axes.

MAX_LABELLED_SHAPE = (9, 8)  # largest rows and columns of a map with numbers in its cells
MAP_SIZE = (3.4, 2.7)  # inches, of a map: small, so that its letters are large on the page
MAP_WIDTH, LETTER_WIDTH = 170.0, 0.62  # points, width of all cells; width of a letter over the font size
MIN_FONT_SIZE, MAX_FONT_SIZE = 6.0, 8.5  # points


def cell_font_size(column_count: int, longest_text: int) -> float:
    """Return the font size (points) of numbers in the cells of a map of SIZE.

    longest_text : characters of the longest text.
    """
    font_size = MAP_WIDTH / (max(column_count, 1) * LETTER_WIDTH * max(longest_text, 1))
    return min(max(font_size, MIN_FONT_SIZE), MAX_FONT_SIZE)


def draw_cells(
    ax: Axes,
    table: np.ndarray,
    axes: tuple[Axis, Axis],
    colours: ColourScale,
    texts: np.ndarray,
    font_size: float,
    is_dark: np.ndarray | None = None,
) -> None:
    """Draw a map: cells (values of the second axis, of the first) in the colours of their numbers.

    texts : of the cells, drawn if they are few.  is_dark : cells whose text is white.
    """
    ax.face_colour = UNKNOWN_COLOUR
    columns, rows = (np.arange(size + 1) - 0.5 for size in table.shape[::-1])
    has_texts = all(size <= limit for size, limit in zip(table.shape, MAX_LABELLED_SHAPE, strict=True))
    edge_colour = "#ffffff" if has_texts and colours.is_stepped else ""
    ax.cells(columns, rows, table, colours, edge_colour=edge_colour, linewidth=0.8)
    for (row, column), text in np.ndenumerate(texts) if has_texts else ():
        colour = "#ffffff" if is_dark is not None and is_dark[row, column] else "#000000"
        ax.text(column, row, text, ha="center", va="center", size=font_size, colour=colour)
    for side, axis in zip((ax.xaxis, ax.yaxis), axes, strict=True):
        label_values(side, axis, np.arange(len(axis.values), dtype=float))
        side.label, side.tick_length = axis.label(), 0.0


UNKNOWN_COLOUR = "#e8ebee"  # of a cell without a case


# Maps of kinds of motion.

KIND_COLOURS = ("#cfe3f1", "#86b8dc", "#f0c48c", "#e0824a")  # from regular to irregular, distinguishable in grey, too
LEGEND = {"column_gap": 1.0, "sample": 1.2}  # in font sizes


def draw_kinds(
    ax: Axes, table: np.ndarray, cell_texts: np.ndarray, axes: tuple[Axis, Axis], names: Sequence[str]
) -> None:
    """Draw the kind of every cell as an index in `names`; cells without a case are NaN.

    `table` : (values of the second axis, values of the first)
    `cell_texts` : texts of the cells in the same shape, drawn if they are few
    """
    colours = ColourScale(-0.5, len(names) - 0.5, KIND_COLOURS[: len(names)], is_stepped=True)
    draw_cells(ax, table, axes, colours, cell_texts, 7.0)
    for kind, name in enumerate(names):
        if (table == kind).any():
            ax.add_legend_entry(name, KIND_COLOURS[kind])
    ax.set_legend("above", columns=4, **LEGEND)
