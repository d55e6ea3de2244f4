"""A map of limits: passing and failing cells in two colours, with a line between them."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.colors import ListedColormap

from ...language import wording
from ..data.axis import Axis
from .heat_map import MAX_LABELLED_SHAPE, MAX_VECTOR_CELLS, cell_font_size
from .style import INK, label_values

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GOOD, BAD, UNKNOWN = "#9fd0e8", "#f2b28c", "#e8ebee"  # pale blue and orange: distinguished by any eye, and in grey


PARTLY = "#dcecf5"  # passes, but its design fails elsewhere
UNDECIDED = "#f5efc4"  # passes at the mean clearance of a fit whose tolerance is not covered; pale yellow
ELSEWHERE, OPEN = 1.0, 2.0  # reservations of a cell that passes
BEYOND = 3.0  # place of a failing cell among the colours
WORDS = {ELSEWHERE: "(ok)", OPEN: "open"}
DOT_GOOD, DOT_BAD = "#1f5f86", "#a34a12"


class Dots(NamedTuple):
    """Cases between the cells of a map: (cases,) each."""

    x: np.ndarray  # positions on the first axis
    y: np.ndarray  # and on the second
    failing: np.ndarray  # bool


def cells(
    ax: "Axes", tables: tuple[np.ndarray, np.ndarray, np.ndarray], axes: tuple[Axis, Axis], between: Dots
) -> None:
    """Draw the smallest margin of every cell, and whether the cell fails or passes with a reservation.

    tables : (values of the second axis, of the first) each, NaN without a finished case: smallest margin; 1 where the
    cell fails, else 0; its reservation, a key of WORDS or 0.  The cases in `between` are drawn on top.
    """
    (margins, failing, reserved), (across, up) = tables, axes
    ax.set_facecolor(UNKNOWN)
    edges = [np.arange(size + 1) - 0.5 for size in failing.shape[::-1]]
    ax.pcolormesh(
        *edges,
        np.ma.masked_invalid(np.where(failing == 0.0, reserved, BEYOND * failing)),
        cmap=ListedColormap([GOOD, PARTLY, UNDECIDED, BAD]),
        vmin=0.0,
        vmax=BEYOND,
        rasterized=failing.size > MAX_VECTOR_CELLS,
        edgecolors="face",
        linewidth=0.3,
    )
    _border(ax, failing)
    if all(size <= most for size, most in zip(failing.shape, MAX_LABELLED_SHAPE, strict=True)):
        for (row, column), fails in np.ndenumerate(failing):
            margin = margins[row, column]
            number = wording.plain(float(100.0 * margin), 2) if np.isfinite(margin) else ""
            word = wording.DASH if np.isnan(fails) else "no" if fails else WORDS.get(float(reserved[row, column]), "ok")
            text = f"{word}\n{number}".strip()
            ax.text(
                column, row, text, ha="center", va="center", fontsize=cell_font_size(failing.shape[1], 5), color="black"
            )
    for fails, colour, mark in ((False, DOT_GOOD, "o"), (True, DOT_BAD, "X")):
        matching = between.failing == fails
        ax.scatter(
            between.x[matching],
            between.y[matching],
            s=14,
            c=colour,
            marker=mark,
            linewidths=0.3,
            edgecolors="white",
            rasterized=bool(matching.sum() > MAX_VECTOR_CELLS),
        )
    label_values(ax.xaxis, across, np.arange(len(across.values), dtype=float))
    label_values(ax.yaxis, up, np.arange(len(up.values), dtype=float))
    ax.set(xlabel=across.label(), ylabel=up.label())
    ax.tick_params(length=0)


def _border(ax: "Axes", failing: np.ndarray) -> None:
    """Draw the line between neighbours of which one passes and the other fails."""
    rows, columns = np.nonzero(np.abs(np.diff(failing, axis=1)) == 1.0)
    ax.vlines(columns + 0.5, rows - 0.5, rows + 0.5, color=INK, linewidth=1.8)
    rows, columns = np.nonzero(np.abs(np.diff(failing, axis=0)) == 1.0)
    ax.hlines(rows + 0.5, columns - 0.5, columns + 0.5, color=INK, linewidth=1.8)
