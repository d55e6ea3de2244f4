"""Maps over two axes: figures, limits and kinds of motion as colours; drawings of kinds of motion."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...contracts.case import Rolling
from ...language import wording
from ...language.wording import Scale
from ..axis import Axis
from ..plot import Axes, ColourScale, multiples_of
from . import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    PALE,
    RED,
    draw_colour_bar,
    label_values,
    label_with_unit,
    set_plain_axes,
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


LONGEST_ARROW = 0.9  # of an element's diameter: drawn length of the largest load
RING_THICKNESS = 0.35  # of an element's diameter, of a ring of unknown bore or outside diameter
SECTORS = 72  # of the circle, in which loads are collected


class LoadedElements(NamedTuple):
    """The elements of a bearing over the saved samples of a case."""

    angles: np.ndarray  # (samples, elements) rad, in the fixed frame
    loads: np.ndarray  # (samples, elements) N

    @property
    def peak(self) -> int:
        """Return the sample with the largest load of an element."""
        return int(self.loads.max(axis=1).argmax())

    def by_sector(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the largest and the mean load (SECTORS,) N of the elements in each sector; nan: none was there."""
        sectors = np.floor(np.mod(self.angles, 2.0 * np.pi) / (2.0 * np.pi) * SECTORS).astype(int) % SECTORS
        counts = np.bincount(sectors.ravel(), minlength=SECTORS)
        largest = np.full(SECTORS, -np.inf)
        np.maximum.at(largest, sectors.ravel(), self.loads.ravel())
        sums = np.bincount(sectors.ravel(), self.loads.ravel(), SECTORS)
        with np.errstate(invalid="ignore"):
            return np.where(counts > 0, largest, np.nan), sums / np.where(counts > 0, counts, np.nan)


def draw_bearing(ax: Axes, bearing: Rolling, angles: np.ndarray, loads: np.ndarray) -> None:
    """Draw the rings and the elements of a bearing at `angles` (Z,) rad, with their `loads` (Z,) N as bars inward."""
    diameter, pitch = 1e3 * bearing.element_diameter, 1e3 * bearing.pitch_diameter
    inner, outer = pitch - diameter, pitch + diameter
    thickness = 2.0 * RING_THICKNESS * diameter
    bore = 1e3 * bearing.bore if bearing.bore else max(inner - thickness, 0.2 * inner)
    outside = 1e3 * bearing.outside_diameter if bearing.outside_diameter else outer + thickness
    for size, face in ((outside, PALE), (outer, "#ffffff"), (inner, PALE), (bore, "#ffffff")):
        ax.circle((0.0, 0.0), 0.5 * size, facecolor=face, edgecolor=GREY, zorder=0.0)
    largest = max(float(loads.max()), np.finfo(float).tiny)
    for angle, load in zip(angles, loads, strict=True):
        direction = np.array([np.cos(angle), np.sin(angle)])
        centre = 0.5 * pitch * direction
        is_loaded = load > 0.0
        face, edge = (BLUE, INK) if is_loaded else ("#ffffff", GREY)
        ax.circle((float(centre[0]), float(centre[1])), 0.5 * diameter, facecolor=face, edgecolor=edge, zorder=1.0)
        if is_loaded:
            ends = np.outer([0.5 * inner, 0.5 * inner - LONGEST_ARROW * diameter * load / largest], direction)
            ax.plot(ends[:, 0], ends[:, 1], color=RED, linewidth=2.6)
    ax.set_square(0.54 * outside)
    ax.set_labels("x [mm]", "y [mm]")
    set_plain_axes(ax)


def draw_load_distribution(ax: Axes, elements: LoadedElements) -> None:
    """Draw the largest and the mean load of the elements over their angle, and the loads at the largest."""
    largest, mean = elements.by_sector()
    scale = wording.scale("N", float(elements.loads.max()))
    angles = (np.arange(SECTORS) + 0.5) * 360.0 / SECTORS
    ax.plot(angles, largest / scale.factor, color=BLUE, linewidth=1.4, label="largest")
    ax.plot(angles, mean / scale.factor, color=ORANGE, linewidth=1.2, linestyle="--", label="mean")
    at_peak = np.degrees(np.mod(elements.angles[elements.peak], 2.0 * np.pi))
    ax.plot(at_peak, elements.loads[elements.peak] / scale.factor, "o", color=RED, markersize=4.0, label="at the peak")
    ax.xaxis.tick_rule = multiples_of(90)
    ax.set_xlim(0.0, 360.0)
    ax.set_ylim(0.0, None)
    ax.set_labels("angle of the element [°]", label_with_unit("load of an element", scale))
    set_plain_axes(ax)
    ax.set_legend("above", columns=3)
