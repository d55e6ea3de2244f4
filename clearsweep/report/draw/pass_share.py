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
