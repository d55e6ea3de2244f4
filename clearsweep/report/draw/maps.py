"""Maps over two axes: figures, limits and kinds of motion as colours; drawings of kinds of motion."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...language import wording
from ...language.wording import Scale
from ..axis import Axis
from ..plot import Axes, ColourScale, round_ticks
from ..statistics.motion import Points, Spectrum
from . import (
    BLUE,
    GREY,
    INK,
    PALE,
    RED,
    draw_colour_bar,
    label_values,
    label_with_unit,
    set_log_scale,
    set_plain_axes,
    stem_lines,
)

# Heat maps: a figure as colours over two swept axes.

MAX_LABELLED_SHAPE = (9, 8)  # largest rows and columns of a map with numbers in its cells
MAP_SIZE = (3.4, 2.7)  # inches, of a map: small, so that its letters are large on the page
MAP_WIDTH, LETTER_WIDTH = 170.0, 0.62  # points, width of all cells; width of a letter over the font size
MIN_FONT_SIZE, MAX_FONT_SIZE = 6.0, 8.5  # points
CUT_OFF, UNSAFE = "cut\noff", "unsafe"
DARK_FRACTION = 0.55  # of the colours: below it, a text is white
LOG_SCALE_RATIO = 8.0  # ratio of largest to smallest value above which the colours are logarithmic


class Cells(NamedTuple):
    """The cells of a map, of shape (values of the second axis, values of the first)."""

    values: np.ndarray  # SI; NaN without a finished case, infinite if a case does not reach the measured state
    is_unsafe: np.ndarray  # marked as unsafe


def cell_font_size(column_count: int, longest_text: int) -> float:
    """Return the font size (points) of numbers in the cells of a map of SIZE.

    longest_text : characters of the longest text.
    """
    return min(
        max(MAP_WIDTH / (max(column_count, 1) * LETTER_WIDTH * max(longest_text, 1)), MIN_FONT_SIZE), MAX_FONT_SIZE
    )


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
    ax.cells(
        columns, rows, table, colours, edge_colour="#ffffff" if has_texts and colours.is_stepped else "", linewidth=0.8
    )
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

PASS_COLOUR, FAIL_COLOUR, UNKNOWN_COLOUR = (
    "#9fd0e8",
    "#f2b28c",
    "#e8ebee",
)  # pale blue and orange: distinguished by any eye, and in grey
PARTLY_COLOUR = "#dcecf5"  # passes, but its design fails elsewhere
UNDECIDED_COLOUR = "#f5efc4"  # passes at the mean clearance of a fit whose tolerance is not covered; pale yellow
FAILS_ELSEWHERE, TOLERANCE_OPEN = 1.0, 2.0  # reservations of a cell that passes
FAILING_CODE = 3.0  # code of a failing cell
VERDICT_COLOURS = ColourScale(
    -0.5, FAILING_CODE + 0.5, (PASS_COLOUR, PARTLY_COLOUR, UNDECIDED_COLOUR, FAIL_COLOUR), is_stepped=True
)
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
    _draw_border(ax, failing)
    for is_failing, colour, marker, size in ((False, PASS_DOT_COLOUR, "o", 3.7), (True, FAIL_DOT_COLOUR, "X", 3.0)):
        is_matching = added_cases.failing == is_failing
        x, y = added_cases.x[is_matching], added_cases.y[is_matching]
        ax.scatter(x, y, size=size, color=colour, marker=marker)


def _draw_border(ax: Axes, failing: np.ndarray) -> None:
    """Draw the line between neighbours of which one passes and the other fails."""
    rows, columns = np.nonzero(np.abs(np.diff(failing, axis=1)) == 1.0)
    ax.vlines(columns + 0.5, rows - 0.5, rows + 0.5, color=INK, linewidth=1.8)
    rows, columns = np.nonzero(np.abs(np.diff(failing, axis=0)) == 1.0)
    ax.hlines(rows + 0.5, columns - 0.5, columns + 0.5, color=INK, linewidth=1.8)


# Drawings of kinds of motion: points at crank angle 0, spectra, shares, maps of kinds.

MOTION_COLOURS = (BLUE, RED, INK, GREY)  # of motions that coexist
KIND_COLOURS = ("#cfe3f1", "#86b8dc", "#f0c48c", "#e0824a")  # from regular to irregular, distinguishable in grey, too
SHARE_COLOURS = {"free flight": "#f0c48c", "impacts": "#e0824a", "lasting contact": "#86b8dc", "contact": "#86b8dc"}
MAX_ORDER = 40  # crank orders shown in a spectrum
LEGEND = {"column_gap": 1.0, "sample": 1.2}  # in font sizes
PIXEL = 0.75  # points: a pixel of a screen
MIN_AMPLITUDE = 1e-5  # of the largest amplitude, lower limit of the drawing


def draw_bifurcation(ax: Axes, points: Points, coordinate: str, axis: Axis) -> None:
    """Draw one coordinate, 'x' or 'y', of a journal at crank angle 0 of every revolution over the values of an axis.

    The dotted lines are the clearance.
    """
    values, abscissae = {"x": points.x, "y": points.y}[coordinate], axis.scale.from_si(points.value)
    scale = wording.scale("m", [*np.abs(values), *points.clearance])
    if np.isfinite(points.clearance).all():
        for sign in (-1.0, 1.0):
            ax.plot(abscissae, sign * points.clearance / scale.factor, color=GREY, linewidth=0.8, linestyle=":")
    down = points.is_downward
    for name, colour, is_drawn in (("up", BLUE, ~down), ("down", RED, down)) if down.any() else (("", INK, ~down),):
        marks = abscissae[is_drawn], values[is_drawn] / scale.factor
        ax.plot(*marks, "o", color=colour, markersize=PIXEL if not name else 3.0 * PIXEL, label=name)
    if axis.is_geometric:
        set_log_scale(ax, "x")
    ax.set_labels(axis.label(), f"journal {coordinate} [{scale.unit}]")
    set_plain_axes(ax)
    if down.any():
        ax.set_legend("above", columns=2, **LEGEND)


def draw_basins(ax: Axes, places: np.ndarray, motions: np.ndarray, labels: Sequence[str], axes: Sequence[str]) -> None:
    """Draw random starts (n, 2), in clearances, coloured by the number (n,) of the motion that they lead to."""
    for motion, label in enumerate(labels):
        of_motion = places[motions == motion]
        colour = MOTION_COLOURS[motion % len(MOTION_COLOURS)]
        ax.plot(of_motion[:, 0], of_motion[:, 1], "o", color=colour, markersize=3.0, label=label)
    ax.set_square(1.08)
    ax.set_labels(*axes)
    ax.set_legend("above", columns=2, **LEGEND)


def draw_section(ax: Axes, revolution: np.ndarray, x: np.ndarray, y: np.ndarray, clearance: float | None) -> None:
    """Draw positions (m) of a journal at crank angle 0, coloured by the revolution, in the clearance circle."""
    scale = wording.scale("m", [*np.abs(x), *np.abs(y), clearance])
    if clearance is not None:
        ax.circle((0.0, 0.0), clearance / scale.factor, facecolor="#f3f6f9", edgecolor=INK, zorder=0)
    _draw_coloured_points(ax, x / scale.factor, y / scale.factor, revolution)
    half_width = 1.08 * max(float(np.hypot(x, y).max()), clearance or 0.0) / scale.factor
    ax.set_square(half_width)
    ax.set_labels(f"journal x [{scale.unit}]", f"journal y [{scale.unit}]")


def draw_velocities(ax: Axes, revolution: np.ndarray, vx: np.ndarray, vy: np.ndarray) -> None:
    """Draw velocities (m/s) of a journal at crank angle 0, coloured by the revolution."""
    scale = wording.scale("m/s", [*np.abs(vx), *np.abs(vy)])
    _draw_coloured_points(ax, vx / scale.factor, vy / scale.factor, revolution)
    ax.set_labels(f"journal vx [{scale.unit}]", f"journal vy [{scale.unit}]")
    set_plain_axes(ax)


def _draw_coloured_points(ax: Axes, x: np.ndarray, y: np.ndarray, revolution: np.ndarray) -> None:
    colours = ColourScale(float(revolution.min()), float(revolution.max()))
    ax.scatter(x, y, size=3.7, values=revolution, scale=colours, zorder=3)
    draw_colour_bar(ax, colours, "revolution", integers_only=True)
    for side in (ax.xaxis, ax.yaxis):
        side.tick_rule = round_ticks(5)


def draw_spectrum(ax: Axes, actual: Spectrum, ideal: Spectrum | None, unit: str, name: str) -> None:
    """Draw amplitudes (SI) over the crank's orders, with its harmonics marked, and those of the ideal mechanism."""
    max_amplitude = float(actual.amplitude.max())
    scale = wording.scale(unit, max_amplitude)
    in_range = actual.order <= MAX_ORDER
    gridlines = stem_lines(np.arange(1, MAX_ORDER + 1), 0.0, 1.0)
    ax.plot(*gridlines, color=PALE, linewidth=0.5, spans_height=True)
    floor = MIN_AMPLITUDE * max_amplitude / scale.factor
    heights = actual.amplitude[in_range] / scale.factor
    lines = stem_lines(actual.order[in_range], floor, heights.clip(min=floor))
    ax.plot(*lines, color=BLUE, linewidth=1.1, label="with clearance")
    if ideal is not None:
        is_drawn = (ideal.order <= MAX_ORDER) & (ideal.amplitude > MIN_AMPLITUDE * max_amplitude)
        ax.plot(
            ideal.order[is_drawn], ideal.amplitude[is_drawn] / scale.factor, "_", color=RED, markersize=6, label="ideal"
        )
    ax.set_log("y")
    ax.set_xlim(0.0, MAX_ORDER + 0.5)
    ax.set_ylim(floor, 3.0 * max_amplitude / scale.factor)
    ax.set_labels("order of the crank [1 / turn]", f"amplitude of {name} [{scale.unit}]")
    ax.hide_edges("top", "right")
    if ideal is not None:
        ax.set_legend("above", columns=2, **LEGEND)


def draw_shares(ax: Axes, axis: Axis, shares: np.ndarray, names: Sequence[str], colours: Sequence[str]) -> None:
    """Draw stacked bars of shares, (names, values of the axis), one bar per value."""
    positions, bottom = np.arange(len(axis.values), dtype=float), np.zeros(len(axis.values))
    for share, name, colour in zip(shares, names, colours, strict=True):
        ax.bar(positions, 100.0 * share, 0.86, bottom, color=colour, label=name)
        bottom += 100.0 * share
    label_values(ax.xaxis, axis, positions)
    ax.set_labels(axis.label(), "share [%]")
    ax.set_ylim(0.0, 100.0)
    set_plain_axes(ax)
    ax.set_legend("above", columns=4, **LEGEND)


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
