"""Drawings that compare cases: effects, strips, curves, clouds, histograms, maps over two axes."""

import re
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
    INK,
    MAX_LABELLED_TICKS,
    RED,
    draw_axis_colour_bar,
    draw_colour_bar,
    label_values,
    label_with_unit,
    set_log_scale,
    set_plain_axes,
)

MAX_BIN_EDGES = 41  # largest number of bin edges of a histogram
MANY_POINTS = 300  # points of a cloud above which they are smaller
MAX_POINTS = 50_000  # points of a cloud above which covered points are omitted
NAMES_LEFT = -0.12  # left end of names above a drawing, as a share of its width
MAX_SIDE_NAME_LENGTH = 10  # letters of a curve's name above which names are placed at the top
GRID_CELLS = 300  # per side of a cloud: each is smaller than a point
LOG_SCALE_RATIO = 8.0  # ratio of largest to smallest value above which an axis is logarithmic


class Curve(NamedTuple):
    """The medians of one figure of one joint over the values of an axis."""

    name: str  # in the legend; '' for none
    colour: str
    has_band: bool  # shaded from the 10th to the 90th percentile, with a solid line
    effect: MainEffect


class CurveFamily(NamedTuple):
    """One figure (SI) over an axis, a curve for each value of another axis, and its limit."""

    axis: Axis
    title: str  # of the legend; '' for none
    names: list[str]  # of the curves
    curves: np.ndarray  # (names, values of the axis)
    limit_values: np.ndarray | None  # (values of the axis,)


def draw_family(ax: Axes, family: CurveFamily, scale: wording.Scale, name: str) -> None:
    """Draw the curves of a family in the unit `scale`, and the limit as a horizontal line."""
    known_values = family.curves[np.isfinite(family.curves)]
    positions = _positions(family.axis)
    colours = ColourScale(0.0, 1.0).hex_colours(np.linspace(0.0, 0.85, len(family.names)))
    for curve, label, colour in zip(family.curves, family.names, colours, strict=True):
        is_known = np.isfinite(curve)
        marker = "o" if len(positions) <= MAX_LABELLED_TICKS else ""
        style: dict[str, Any] = {"marker": marker, "markersize": 3.5, "linewidth": 1.4}
        ax.plot(positions[is_known], curve[is_known] / scale.factor, color=colour, label=label, **style)
    if family.limit_values is not None:
        ax.plot(positions, family.limit_values / scale.factor, color=RED, linewidth=1.4, linestyle="--", label="limit")
        known_values = np.concatenate([known_values, family.limit_values[np.isfinite(family.limit_values)]])
    ax.set_labels(family.axis.label(), label_with_unit(name, scale))
    _label_abscissa(ax, family.axis, positions)
    if known_values.min() > 0.0 and known_values.max() > LOG_SCALE_RATIO * known_values.min():
        set_log_scale(ax, "y")
    elif known_values.min() >= 0.0:
        ax.set_ylim(0.0, 1.08 * known_values.max() / scale.factor or None)
    set_plain_axes(ax)
    if any(family.names):
        if max(map(len, family.names)) > MAX_SIDE_NAME_LENGTH:
            ax.set_legend("above", columns=2, sample=1.4, left=NAMES_LEFT)
        else:
            ax.set_legend("right", title=re.sub(r" (?=[\[(])", "\n", family.title), sample=1.4)


def _label_abscissa(ax: Axes, axis: Axis, positions: np.ndarray) -> None:
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
    positions = tick_positions = _positions(axis)
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
    _label_abscissa(ax, axis, tick_positions)
    if limits[0] > 0.0 and limits[1] > LOG_SCALE_RATIO * limits[0]:
        set_log_scale(ax, "y")
    ax.set_ylim(limits[0] / scale.factor * 0.9, limits[1] / scale.factor * 1.1)
    set_plain_axes(ax)
    if len(curves) > 1:
        ax.set_legend("above", columns=3, column_gap=1.0, sample=1.6, left=NAMES_LEFT)


def draw_strip(ax: Axes, groups: Sequence[tuple[str, np.ndarray]], name: str, scale: Scale) -> None:
    """Draw one row of points (SI, scaled) for each name, from the bottom up, with a bar at its median."""
    for row, (_, values) in enumerate(groups):
        ax.plot(values / scale.factor, np.full(len(values), row), "o", color=BLUE, markersize=4.5, alpha=0.55)
        ax.plot(np.median(values) / scale.factor, row, "|", color=RED, markersize=11, markeredgewidth=2.2)
    all_values = np.concatenate([values for _, values in groups])
    if all_values.min() > 0.0 and all_values.max() > 4.0 * all_values.min():  # else a log axis has no ticks
        set_log_scale(ax, "x")
    label_rows(ax, [group_name for group_name, _ in groups])
    ax.xaxis.label = label_with_unit(name, scale)


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
        draw_axis_colour_bar(ax, axis, colours)
    set_log_scale(ax, *(side for side, values in (("x", x), ("y", y)) if _needs_log_scale(values)))
    ax.set_labels(label_with_unit(names[0], scales[0]), label_with_unit(names[1], scales[1]))
    set_plain_axes(ax)


def without_covered_points(
    x: np.ndarray, y: np.ndarray, colour: tuple[np.ndarray, Axis] | None
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, Axis] | None]:
    """Return the points of `draw_cloud` without covered ones, if they are many."""
    if len(x) <= MAX_POINTS:
        return x, y, colour
    visible = visible_points(*(np.log(values) if _needs_log_scale(values) else values for values in (x, y)))
    return x[visible], y[visible], colour and (colour[0][visible], colour[1])


def _needs_log_scale(values: np.ndarray) -> bool:
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


def draw_histogram(
    ax: Axes, values: np.ndarray, name: str, scale: Scale, marked_values: tuple[float, ...], limit: float | None
) -> None:
    """Draw the distribution of values (SI, scaled), with marked values and a limit."""
    scaled_values = values / scale.factor
    bins = "auto" if np.ptp(scaled_values) > 1e-9 * np.abs(scaled_values).max() else 1
    edges = np.histogram_bin_edges(scaled_values, bins)
    edges = edges if len(edges) <= MAX_BIN_EDGES else np.linspace(edges[0], edges[-1], MAX_BIN_EDGES)
    weights = np.full(len(scaled_values), 100.0 / len(scaled_values))
    ax.hist(scaled_values, edges.tolist(), weights=weights, color=BLUE, alpha=0.85)
    for marked_value in marked_values:
        ax.axvline(marked_value / scale.factor, color=INK, linewidth=0.9, linestyle=":")
    if limit is not None:
        ax.axvline(limit / scale.factor, color=RED, linewidth=1.4)
    ax.set_labels(label_with_unit(name, scale), "cases [%]")
    set_plain_axes(ax)


def _positions(axis: Axis) -> np.ndarray:
    """Return the positions of an axis's values on an abscissa."""
    if not axis.is_numeric:
        return np.arange(len(axis.values), dtype=float)
    return np.asarray(axis.scale.from_si(np.asarray(axis.values, float)))


# Heat maps: a figure as colours over two swept axes.

MAX_LABELLED_SHAPE = (9, 8)  # largest rows and columns of a map with numbers in its cells
MAP_SIZE = (3.4, 2.7)  # inches, of a map: small, so that its letters are large on the page
MAP_WIDTH, LETTER_WIDTH = 170.0, 0.62  # points, width of all cells; width of a letter over the font size
MIN_FONT_SIZE, MAX_FONT_SIZE = 6.0, 8.5  # points
CUT_OFF, UNSAFE = "cut\noff", "unsafe"
DARK_FRACTION = 0.55  # of the colours: below it, a text is white


class Cells(NamedTuple):
    """The cells of a map, of shape (values of the second axis, values of the first)."""

    values: np.ndarray  # SI; NaN without a finished case, infinite if a case does not reach the measured state
    is_unsafe: np.ndarray  # marked as unsafe


def cell_font_size(column_count: int, longest_text: int) -> float:
    """Return the font size (points) of numbers in the cells of a map of SIZE.

    longest_text : characters of the longest text.
    """
    font_size = MAP_WIDTH / (max(column_count, 1) * LETTER_WIDTH * max(longest_text, 1))
    return min(max(font_size, MIN_FONT_SIZE), MAX_FONT_SIZE)


def draw_heat_map(
    ax: Axes, cells: Cells, axes: tuple[Axis, Axis], scale: Scale, name: str, colour_range: tuple[float, float]
) -> None:
    """Draw a figure as colours over two axes.

    colour_range : SI, the ends of the colour scale
    """
    table = cells.values / scale.factor
    low, high = (end / scale.factor for end in colour_range)
    colours = ColourScale(low, high, is_log=low > 0.0 and high > LOG_SCALE_RATIO * low)
    texts = np.empty(table.shape, object)
    for place, value in np.ndenumerate(table):
        texts[place] = _cell_text(value, is_unsafe=bool(cells.is_unsafe[place]))
    longest_text = max((len(line) for text in texts.flat for line in text.split("\n")), default=1)
    is_dark = np.isfinite(table) & (colours.fractions(table) < DARK_FRACTION)
    _draw_cells(ax, table, axes, colours, texts, cell_font_size(table.shape[1], longest_text), is_dark)
    draw_colour_bar(ax, colours, label_with_unit(name, scale))


def _draw_cells(
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


def _cell_text(value: float, *, is_unsafe: bool) -> str:
    """Return the text of a cell."""
    if np.isinf(value):
        return CUT_OFF
    number = wording.number_text(value, 3) if np.isfinite(value) else wording.DASH
    return f"{number}\n{UNSAFE}" if is_unsafe else number


# A map of limits: passing and failing cells in two colours, with a line between them.

#: Pale blue and orange: distinguished by any eye, and in grey.
PASS_COLOUR, FAIL_COLOUR, UNKNOWN_COLOUR = "#9fd0e8", "#f2b28c", "#e8ebee"
PARTLY_COLOUR = "#dcecf5"  # passes, but its design fails elsewhere
UNDECIDED_COLOUR = "#f5efc4"  # passes at the mean clearance of a fit whose tolerance is not covered; pale yellow
FAILS_ELSEWHERE, TOLERANCE_OPEN = 1.0, 2.0  # reservations of a cell that passes
FAILING_CODE = 3.0  # code of a failing cell
_PASSING_COLOURS = (PASS_COLOUR, PARTLY_COLOUR, UNDECIDED_COLOUR)
VERDICT_COLOURS = ColourScale(-0.5, FAILING_CODE + 0.5, (*_PASSING_COLOURS, FAIL_COLOUR), is_stepped=True)
RESERVATION_TEXTS = {FAILS_ELSEWHERE: "(ok)", TOLERANCE_OPEN: "open"}
PASS_DOT_COLOUR, FAIL_DOT_COLOUR = "#1f5f86", "#a34a12"


class Dots(NamedTuple):
    """Cases between the cells of a map: (cases,) each."""

    x: np.ndarray  # positions on the first axis
    y: np.ndarray  # and on the second
    failing: np.ndarray  # bool


def draw_margin_cells(
    ax: Axes, tables: tuple[np.ndarray, np.ndarray, np.ndarray], axes: tuple[Axis, Axis], added_cases: Dots
) -> None:
    """Draw the smallest margin of every cell, and whether the cell fails or passes with a reservation.

    tables : (values of the second axis, of the first) each, NaN without a finished case: smallest margin; 1 where the
    cell fails, else 0; its reservation, a key of RESERVATION_TEXTS or 0.  The cases in `added_cases` are drawn on top.
    """
    margins, failing, reservations = tables
    texts = np.empty(failing.shape, object)
    for place, is_failing in np.ndenumerate(failing):
        margin = margins[place]
        margin_text = wording.number_text(float(100.0 * margin), 2) if np.isfinite(margin) else ""
        passing_text = RESERVATION_TEXTS.get(float(reservations[place]), "ok")
        verdict_text = wording.DASH if np.isnan(is_failing) else "no" if is_failing else passing_text
        texts[place] = f"{verdict_text}\n{margin_text}".strip()
    codes = np.where(failing == 0.0, reservations, FAILING_CODE * failing)
    _draw_cells(ax, codes, axes, VERDICT_COLOURS, texts, cell_font_size(failing.shape[1], 5))
    # Draw the line between neighbours of which one passes and the other fails
    rows, columns = np.nonzero(np.abs(np.diff(failing, axis=1)) == 1.0)
    ax.vlines(columns + 0.5, rows - 0.5, rows + 0.5, color=INK, linewidth=1.8)
    rows, columns = np.nonzero(np.abs(np.diff(failing, axis=0)) == 1.0)
    ax.hlines(rows + 0.5, columns - 0.5, columns + 0.5, color=INK, linewidth=1.8)
    for is_failing, colour, marker, size in ((False, PASS_DOT_COLOUR, "o", 3.7), (True, FAIL_DOT_COLOUR, "X", 3.0)):
        is_matching = added_cases.failing == is_failing
        x, y = added_cases.x[is_matching], added_cases.y[is_matching]
        ax.scatter(x, y, size=size, color=colour, marker=marker)


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
    _draw_cells(ax, table, axes, colours, cell_texts, 7.0)
    for kind, name in enumerate(names):
        if (table == kind).any():
            ax.add_legend_entry(name, KIND_COLOURS[kind])
    ax.set_legend("above", columns=4, **LEGEND)
