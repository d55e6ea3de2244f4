"""Heat maps: a figure as colours over two swept axes."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.colors import LogNorm, Normalize

from ...language import wording
from ...language.wording import Scale
from ..data.axis import Axis
from .style import draw_colour_bar, label_values

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_LABELLED_SHAPE = (9, 8)  # largest rows and columns of a map with numbers in its cells
SIZE = (3.4, 2.7)  # inches, of a map: small, so that its letters are large on the page
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
