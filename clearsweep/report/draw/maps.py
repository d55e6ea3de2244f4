"""Maps over two axes: figures, limits and kinds of motion as colours; drawings of kinds of motion."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.patches import Circle, Patch
from matplotlib.ticker import MaxNLocator

from ...language import wording
from ...language.wording import Scale
from ..axis import Axis
from ..statistics.motion import Points, Spectrum
from .style import BLUE, GREY, INK, PALE, RED, draw_colour_bar, label_values, set_log_scale, set_plain_axes, stem_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Heat maps: a figure as colours over two swept axes.

MAX_LABELLED_SHAPE = (9, 8)  # largest rows and columns of a map with numbers in its cells
MAP_SIZE = (3.4, 2.7)  # inches, of a map: small, so that its letters are large on the page
MAP_WIDTH, LETTER_WIDTH = 170.0, 0.62  # points, width of all cells; width of a letter over the font size
MIN_FONT_SIZE, MAX_FONT_SIZE = 6.0, 8.5  # points
MAX_VECTOR_CELLS = 150  # cells above which they are drawn as pixels
CUT_OFF, UNSAFE = "cut\noff", "unsafe"
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
    ax: "Axes", cells: Cells, axes: tuple[Axis, Axis], scale: Scale, name: str, colour_range: tuple[float, float]
) -> None:
    """Draw a figure as colours over two axes.

    colour_range : SI, the ends of the colour scale
    """
    (x_axis, y_axis), scaled_table = axes, cells.values / scale.factor
    low, high = (end / scale.factor for end in colour_range)
    is_logarithmic = low > 0.0 and high > LOG_SCALE_RATIO * low
    norm = LogNorm(low, high) if is_logarithmic else Normalize(low, high)
    ax.set_facecolor("#e8ebee")  # background of cells without a finished case
    edges = [np.arange(size + 1) - 0.5 for size in scaled_table.shape[::-1]]
    mesh = ax.pcolormesh(
        *edges,
        np.ma.masked_invalid(scaled_table),
        norm=norm,
        cmap="viridis",
        rasterized=scaled_table.size > MAX_VECTOR_CELLS,
        edgecolors="face",
        linewidth=0.3,
    )
    if all(size <= limit for size, limit in zip(scaled_table.shape, MAX_LABELLED_SHAPE, strict=True)):
        texts = [
            _cell_text(value, is_unsafe=bool(is_unsafe))
            for value, is_unsafe in zip(scaled_table.flat, cells.is_unsafe.flat, strict=True)
        ]
        font_size = cell_font_size(scaled_table.shape[1], max(len(line) for text in texts for line in text.split("\n")))
        for (row, column), value in np.ndenumerate(scaled_table):
            is_known = np.isfinite(value)
            ax.text(
                column,
                row,
                _cell_text(value, is_unsafe=bool(cells.is_unsafe[row, column])),
                ha="center",
                va="center",
                fontsize=font_size,
                color="white" if is_known and norm(value) < 0.55 else "black",
            )
    label_values(ax.xaxis, x_axis, np.arange(len(x_axis.values), dtype=float))
    label_values(ax.yaxis, y_axis, np.arange(len(y_axis.values), dtype=float))
    ax.set(xlabel=x_axis.label(), ylabel=y_axis.label())
    ax.tick_params(length=0)
    draw_colour_bar(ax, mesh, f"{name} [{scale.unit}]" if scale.unit else name, is_logarithmic=is_logarithmic)


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
RESERVATION_TEXTS = {FAILS_ELSEWHERE: "(ok)", TOLERANCE_OPEN: "open"}
PASS_DOT_COLOUR, FAIL_DOT_COLOUR = "#1f5f86", "#a34a12"


class Dots(NamedTuple):
    """Cases between the cells of a map: (cases,) each."""

    x: np.ndarray  # positions on the first axis
    y: np.ndarray  # and on the second
    failing: np.ndarray  # bool


def draw_margin_cells(
    ax: "Axes", tables: tuple[np.ndarray, np.ndarray, np.ndarray], axes: tuple[Axis, Axis], added_cases: Dots
) -> None:
    """Draw the smallest margin of every cell, and whether the cell fails or passes with a reservation.

    tables : (values of the second axis, of the first) each, NaN without a finished case: smallest margin; 1 where the
    cell fails, else 0; its reservation, a key of RESERVATION_TEXTS or 0.  The cases in `added_cases` are drawn on top.
    """
    (margins, failing, reservations), (x_axis, y_axis) = tables, axes
    ax.set_facecolor(UNKNOWN_COLOUR)
    edges = [np.arange(size + 1) - 0.5 for size in failing.shape[::-1]]
    ax.pcolormesh(
        *edges,
        np.ma.masked_invalid(np.where(failing == 0.0, reservations, FAILING_CODE * failing)),
        cmap=ListedColormap([PASS_COLOUR, PARTLY_COLOUR, UNDECIDED_COLOUR, FAIL_COLOUR]),
        vmin=0.0,
        vmax=FAILING_CODE,
        rasterized=failing.size > MAX_VECTOR_CELLS,
        edgecolors="face",
        linewidth=0.3,
    )
    _draw_border(ax, failing)
    if all(size <= limit for size, limit in zip(failing.shape, MAX_LABELLED_SHAPE, strict=True)):
        for (row, column), is_failing in np.ndenumerate(failing):
            margin = margins[row, column]
            margin_text = wording.number_text(float(100.0 * margin), 2) if np.isfinite(margin) else ""
            verdict_text = (
                wording.DASH
                if np.isnan(is_failing)
                else "no"
                if is_failing
                else RESERVATION_TEXTS.get(float(reservations[row, column]), "ok")
            )
            text = f"{verdict_text}\n{margin_text}".strip()
            ax.text(
                column, row, text, ha="center", va="center", fontsize=cell_font_size(failing.shape[1], 5), color="black"
            )
    for is_failing, colour, marker in ((False, PASS_DOT_COLOUR, "o"), (True, FAIL_DOT_COLOUR, "X")):
        is_matching = added_cases.failing == is_failing
        ax.scatter(
            added_cases.x[is_matching],
            added_cases.y[is_matching],
            s=14,
            c=colour,
            marker=marker,
            linewidths=0.3,
            edgecolors="white",
            rasterized=bool(is_matching.sum() > MAX_VECTOR_CELLS),
        )
    label_values(ax.xaxis, x_axis, np.arange(len(x_axis.values), dtype=float))
    label_values(ax.yaxis, y_axis, np.arange(len(y_axis.values), dtype=float))
    ax.set(xlabel=x_axis.label(), ylabel=y_axis.label())
    ax.tick_params(length=0)


def _draw_border(ax: "Axes", failing: np.ndarray) -> None:
    """Draw the line between neighbours of which one passes and the other fails."""
    rows, columns = np.nonzero(np.abs(np.diff(failing, axis=1)) == 1.0)
    ax.vlines(columns + 0.5, rows - 0.5, rows + 0.5, color=INK, linewidth=1.8)
    rows, columns = np.nonzero(np.abs(np.diff(failing, axis=0)) == 1.0)
    ax.hlines(rows + 0.5, columns - 0.5, columns + 0.5, color=INK, linewidth=1.8)


# Drawings of kinds of motion: points at crank angle 0, spectra, shares, maps of kinds.

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
