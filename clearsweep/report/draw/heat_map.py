"""Heat maps: a figure as colours over two swept axes."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize

from ...language import wording
from ...language.wording import Scale
from ..data.axis import Axis
from .style import colour_bar, name_values

LARGEST_LABELLED = (9, 8)  # largest rows and columns of a map with numbers in its cells
SIZE = (3.4, 2.7)  # inches, of a map: small, so that its letters are large on the page
CELLS_WIDTH, LETTER = 170.0, 0.62  # points, width of all cells; width of a letter over the font size
SMALLEST_LETTERS, LARGEST_LETTERS = 6.0, 8.5  # points
CELLS_VECTOR = 150  # cells above which they are drawn as pixels
CUT_OFF = "cut\noff"
DECADES = 8.0  # ratio of largest to smallest value above which the colours are logarithmic


def letters(columns: int, longest: int) -> float:
    """Return the font size (points) of numbers in the cells of a map of SIZE with so many columns and characters."""
    return min(max(CELLS_WIDTH / (max(columns, 1) * LETTER * max(longest, 1)), SMALLEST_LETTERS), LARGEST_LETTERS)


def heat_map(
    ax: Axes, table: np.ndarray, axes: tuple[Axis, Axis], scale: Scale, name: str, span: tuple[float, float]
) -> None:
    """Draw a figure as colours over two axes.

    `table` : SI, shape (values of the second axis, of the first), NaN without a finished case, infinite if a case does
    not reach the measured state.
    `span` : SI, the ends of the colour scale.
    """
    (across, up), shown = axes, table / scale.factor
    low, high = (end / scale.factor for end in span)
    wide = low > 0.0 and high > DECADES * low
    norm = LogNorm(low, high) if wide else Normalize(low, high)
    ax.set_facecolor("#e8ebee")  # background of cells without a finished case
    edges = [np.arange(size + 1) - 0.5 for size in shown.shape[::-1]]
    mesh = ax.pcolormesh(
        *edges,
        np.ma.masked_invalid(shown),
        norm=norm,
        cmap="viridis",
        rasterized=shown.size > CELLS_VECTOR,
        edgecolors="face",
        linewidth=0.3,
    )
    if all(size <= most for size, most in zip(shown.shape, LARGEST_LABELLED, strict=True)):
        texts = [_number(value) for value in shown.flat]
        size = letters(shown.shape[1], max(len(line) for text in texts for line in text.split("\n")))
        for (row, column), value in np.ndenumerate(shown):
            known = np.isfinite(value)
            ax.text(
                column,
                row,
                _number(value),
                ha="center",
                va="center",
                fontsize=size,
                color="white" if known and norm(value) < 0.55 else "black",
            )
    name_values(ax.xaxis, across, np.arange(len(across.values), dtype=float))
    name_values(ax.yaxis, up, np.arange(len(up.values), dtype=float))
    ax.set(xlabel=across.label(), ylabel=up.label())
    ax.tick_params(length=0)
    colour_bar(ax, mesh, f"{name} [{scale.unit}]" if scale.unit else name, logarithmic=wide)


def _number(value: float) -> str:
    """Return the text of a cell."""
    if np.isinf(value):
        return CUT_OFF
    return wording.plain(value, 3) if np.isfinite(value) else wording.DASH
