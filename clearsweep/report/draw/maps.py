"""Maps over two axes: figures, limits and kinds of motion as colours; drawings of kinds of motion."""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...contracts.case import Rolling
from ...contracts.vibration import ZONES
from ...language import wording
from ...language.wording import Scale
from ..axis import Axis
from ..motion import Points, Spectrum
from ..plot import Axes, ColourScale, multiples_of, round_ticks
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
        heights = ideal.amplitude[is_drawn] / scale.factor
        ax.plot(ideal.order[is_drawn], heights, "_", color=RED, markersize=6, label="ideal")
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


def draw_life(ax: Axes, axis: Axis, lives: Sequence[tuple[str, np.ndarray]]) -> None:
    """Draw lives (values of the axis,) h over the clearance; each with its name, '' if there is one."""
    positions = np.array(axis.values, float) / axis.scale.factor
    for (name, values), colour in zip(lives, (BLUE, ORANGE, RED, GREY), strict=False):
        ax.plot(positions, values, "o-", color=colour, markersize=4.0, label=name)
    if positions.min() < 0.0 < positions.max():
        ax.axvline(0.0, color=GREY, linewidth=0.8, linestyle="--")
    label_values(ax.xaxis, axis, positions)
    ax.set_ylim(0.0, None)
    ax.set_labels(axis.label(), "rating life [h]")
    set_plain_axes(ax)
    if lives[1:]:
        ax.set_legend("above", columns=2)


ZONE_COLOURS = ("#d9f0d3", "#fff7c4", "#fddbb0", "#f6b8ae")  # of the zones A to D
LEAST_AMPLITUDE = 1e-4  # of the largest: smaller amplitudes of a waterfall look alike
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
    colours = ColourScale(LEAST_AMPLITUDE * largest / scale.factor, largest / scale.factor, is_log=True)
    shown = np.maximum(amplitudes, LEAST_AMPLITUDE * largest) / scale.factor
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
