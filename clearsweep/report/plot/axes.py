"""Axes that store lines, points, areas, cells, bars and texts until they are written."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from .items import PAPER, Box, CellStyle, ColourScale, Item, Legend, LegendEntry, MarkerStyle, Side, Stroke, TextStyle

_DASHES = {"--": "3.7 1.6", "-.": "6.4 1.6 1 1.6", ":": "1 1.65"}  # for a line one point wide
_FORMAT = re.compile(r"([o.|_sDxX+]?)(-?)")


class Axes:
    """Two sides and the items between them."""

    def __init__(self, sheet_size: tuple[float, float]):
        """Take the size of their sheet in inches."""
        self.sheet_size = sheet_size
        self.xaxis, self.yaxis = Side("x"), Side("y")
        self.items: list[Item] = []
        self.legend_entries: list[LegendEntry] = []
        self.edges = {"left", "bottom", "right", "top"}  # those that are drawn
        self.grid_stroke: Stroke | None = None
        self.face_colour, self.equal_aspect = PAPER, False
        self.legend: Legend | None = None
        self.colour_bar: tuple[ColourScale, Side] | None = None  # the colour bar, and its side with ticks

    def to_points(self, x: Any, y: Any, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return coordinates as points from the sheet's upper left corner."""
        return box.left + self.xaxis.fraction(x) * box.width, box.top + (1.0 - self.yaxis.fraction(y)) * box.height

    def plot(
        self,
        x: Any,
        y: Any,
        code: str = "-",
        *,
        color: str,
        linewidth: float = 1.5,
        linestyle: str = "-",
        marker: str = "",
        markersize: float = 6.0,
        markeredgewidth: float = 1.0,
        markerfacecolor: str = "",
        alpha: float = 1.0,
        label: str = "",
        zorder: float = 2.0,
        capstyle: str = "butt",
        spans_height: bool = False,
        spans_width: bool = False,
    ) -> None:
        """Draw a line, or points, or both; y may have a column for each line.

        code : a marker of 'o.|_sDxX+', '-' for a line, or both.  linestyle : '-', '--', '-.', ':', or lengths of lines
        and gaps in line widths; '' for none.  Sizes and widths in points.  spans_height, spans_width : y, x are shares
        of the axes
        """
        parsed = _FORMAT.fullmatch(code)
        if parsed is None:
            raise ValueError(f"format of a line: found {code!r}; expected a marker, '-', or both")
        shape, has_line = marker or parsed[1], bool(parsed[2]) and bool(linestyle)
        dash = _DASHES.get(linestyle, linestyle if linestyle[:1].isdigit() else "")
        stroke = Stroke(color.lower(), linewidth, dash, alpha, capstyle) if has_line else None
        size = markersize * (0.5 if shape == "." else 1.0)
        drawn = MarkerStyle(shape, color.lower(), size, alpha, markerfacecolor.lower(), markeredgewidth)
        marker_style = drawn if shape else None
        x, y = np.atleast_1d(np.asarray(x, float)), np.atleast_1d(np.asarray(y, float))
        for column in y.T if y.ndim == 2 else (y,):
            for kind, style in (("line", stroke), ("points", marker_style)):
                if style:
                    across, up = np.broadcast_arrays(x, column)
                    self._add(kind, across, up, style, zorder, spans_height=spans_height, spans_width=spans_width)
        if label:
            self.legend_entries.append(LegendEntry(label, stroke, marker_style))

    def _add(
        self,
        kind: str,
        x: np.ndarray,
        y: np.ndarray,
        style: Any,
        zorder: float,
        *,
        spans_height: bool = False,
        spans_width: bool = False,
    ) -> None:
        """Add an item, and its places to the data of the sides that it does not span."""
        if not spans_width:
            self.xaxis.extend_data(x)
        if not spans_height:
            self.yaxis.extend_data(y)
        self.items.append(Item(kind, x, y, style, zorder, spans_height, spans_width))

    def step(self, x: Any, y: Any, *, color: str, markersize: float) -> None:
        """Draw points, and a line of steps that continues at the height of each until the next."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        self.plot(np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1], color=color)
        self.plot(x, y, "o", color=color, markersize=markersize)

    def scatter(
        self,
        x: Any,
        y: Any,
        *,
        size: float,
        color: str = "",
        values: Any = None,
        scale: ColourScale | None = None,
        marker: str = "o",
        alpha: float = 1.0,
        zorder: float = 1.0,
    ) -> None:
        """Draw points of a size (points), all in one colour or each in the colour of its value on a scale."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        if scale is None:
            self._add("points", x, y, MarkerStyle(marker, color.lower(), size, alpha), zorder)
            return
        shades = np.round(scale.fractions(values) * 63.0) / 63.0
        known = np.unique(shades[np.isfinite(shades)])
        for shade, colour in zip(known, scale.hex_colours(known), strict=True):
            has_shade = shades == shade
            self._add("points", x[has_shade], y[has_shade], MarkerStyle(marker, colour, size, alpha), zorder)

    def fill_between(self, x: Any, low: Any, high: Any, *, color: str, alpha: float = 1.0) -> None:
        """Fill the area between two lines."""
        x, low, high = (np.asarray(array, float) for array in np.broadcast_arrays(x, low, high))
        finite = np.isfinite(low) & np.isfinite(high)
        x, low, high = x[finite], low[finite], high[finite]
        self._add("area", np.r_[x, x[::-1]], np.r_[low, high[::-1]], (color.lower(), alpha), 1.0)

    def fill(
        self,
        x: Any,
        y: Any,
        *,
        facecolor: str,
        edgecolor: str,
        alpha: float = 1.0,
        linewidth: float = 1.0,
        zorder: float = 1.0,
    ) -> None:
        """Fill the inside of a closed line, with an opacity, and draw the line."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        self._add("area", x, y, (facecolor.lower(), alpha), zorder)
        edge = Stroke(edgecolor.lower(), linewidth)
        self._add("line", np.append(x, x[:1]), np.append(y, y[:1]), edge, zorder)

    def vlines(self, x: Any, low: Any, high: Any, **style: Any) -> None:
        """Draw vertical lines as one line with gaps; style : as for `plot`."""
        self.plot(*_lines_with_gaps(x, low, high), **style)

    def hlines(self, y: Any, low: Any, high: Any, **style: Any) -> None:
        """Draw horizontal lines as one line with gaps; style : as for `plot`."""
        self.plot(*_lines_with_gaps(y, low, high)[::-1], **style)

    def axhline(self, y: float, **style: Any) -> None:
        """Draw a horizontal line across the axes; style : as for `plot`."""
        self.plot([0.0, 1.0], [y, y], spans_width=True, **style)

    def axvline(self, x: float, **style: Any) -> None:
        """Draw a vertical line across the axes; style : as for `plot`."""
        self.plot([x, x], [0.0, 1.0], spans_height=True, **style)

    def axhspan(self, low: float, high: float, *, color: str, zorder: float = 1.0) -> None:
        """Fill the area between two heights."""
        x, y = np.array([0.0, 1.0, 1.0, 0.0]), np.array([low, low, high, high], float)
        self._add("area", x, y, (color.lower(), 1.0), zorder, spans_width=True)

    def bar(self, x: Any, height: Any, width: float = 0.8, bottom: Any = 0.0, *, color: str, label: str = "") -> None:
        """Draw vertical bars."""
        x, height, bottom = (np.array(array, float) for array in np.broadcast_arrays(x, height, bottom))
        self._add_bars(x - 0.5 * width, x + 0.5 * width, bottom, bottom + height, color)
        self.yaxis.sticky_ends |= {*bottom.tolist()}
        if label:
            self.legend_entries.append(LegendEntry(label, fill_colour=color.lower()))

    def barh(
        self, y: np.ndarray, low: np.ndarray, high: np.ndarray, *, height: float, color: str, alpha: float
    ) -> None:
        """Draw horizontal bars from low to high."""
        self._add_bars(low, high, y - 0.5 * height, y + 0.5 * height, color, alpha)

    def hist(
        self, values: Any, bins: Any, *, color: str, weights: Any = None, density: bool = False, alpha: float = 1.0
    ) -> None:
        """Draw the number of values between edges."""
        counts, edges = np.histogram(values, bins, weights=weights, density=density)
        self._add_bars(edges[:-1], edges[1:], np.zeros(len(counts)), counts, color, alpha)
        self.yaxis.sticky_ends.add(0.0)

    def _add_bars(self, left: Any, right: Any, low: Any, high: Any, colour: str, alpha: float = 1.0) -> None:
        gaps = np.full(len(left), np.nan)
        corners = np.stack([left, right, right, left, gaps], -1)
        heights = np.stack([low, low, high, high, gaps], -1)
        self._add("area", corners.ravel().astype(float), heights.ravel().astype(float), (colour.lower(), alpha), 1.0)

    def cells(
        self, x: Any, y: Any, values: Any, scale: ColourScale, *, edge_colour: str = "", linewidth: float = 0.0
    ) -> None:
        """Draw cells between edges at equal distances, each in the colour of its number; NaN shows what is behind.

        x : (columns + 1,), y : (rows + 1,), values : (rows, columns)
        """
        x, y, values = np.asarray(x, float), np.asarray(y, float), np.asarray(values, float)
        self.xaxis.sticky_ends |= {float(x[0]), float(x[-1])}
        self.yaxis.sticky_ends |= {float(y[0]), float(y[-1])}
        self._add("cells", x, y, CellStyle(values, scale, edge_colour.lower(), linewidth), 0.0)

    def text(self, x: float, y: float, text: str, *, spans_width: bool = False, **style: Any) -> None:
        """Write a text at a position; style : fields of TextStyle."""
        item = Item("text", np.array([x], float), np.array([y], float), TextStyle(text, **style), 3.0)
        self.items.append(item._replace(spans_width=spans_width, is_clipped=False))

    def leader(self, start: tuple[float, float], end: tuple[float, float], *, color: str, linewidth: float) -> None:
        """Draw a line, not clipped at the axes; x of both ends is a share of their width."""
        x, y = np.array([start, end], float).T
        self.items.append(Item("line", x, y, Stroke(color.lower(), linewidth), 2.0, spans_width=True, is_clipped=False))

    def circle(
        self,
        centre: tuple[float, float],
        radius: float,
        *,
        edgecolor: str,
        facecolor: str = "none",
        linewidth: float = 1.0,
        zorder: float = 1.0,
    ) -> None:
        """Draw a circle."""
        x, y = centre
        self.xaxis.extend_data([x - radius, x + radius])
        self.yaxis.extend_data([y - radius, y + radius])
        style = facecolor.lower(), edgecolor.lower(), linewidth
        self.items.append(Item("ellipse", np.array([x, radius]), np.array([y, radius]), style, zorder))

    def set_legend(self, place: str, **form: Any) -> None:
        """Show the names of lines, points and areas; form : fields of Legend."""
        self.legend = Legend(place, **form)

    def add_legend_entry(self, name: str, colour: str) -> None:
        """Add the name of a colour."""
        self.legend_entries.append(LegendEntry(name, fill_colour=colour.lower()))

    def add_colour_bar(self, scale: ColourScale, name: str) -> Side:
        """Show the bar of a colour scale to the right of the axes; return its side, for ticks."""
        side = Side("y")
        side.is_log, side.label = scale.is_log, name
        side.set_limits(scale.low, scale.high)
        self.colour_bar = scale, side
        return side

    def set_labels(self, x: str, y: str) -> None:
        """Set the labels of both sides."""
        self.xaxis.label, self.yaxis.label = x, y

    def set_xlim(self, low: float | None, high: float | None) -> None:
        """Set the ends of the abscissa, one or both."""
        self.xaxis.set_limits(low, high)

    def set_ylim(self, low: float | None, high: float | None) -> None:
        """Set the ends of the ordinate, one or both."""
        self.yaxis.set_limits(low, high)

    def set_square(self, half_width: float) -> None:
        """Show a square around the origin, with equal scales."""
        self.set_xlim(-half_width, half_width)
        self.set_ylim(-half_width, half_width)
        self.equal_aspect = True

    def set_log(self, *side_names: str) -> None:
        """Make sides logarithmic: 'x', 'y' or both."""
        for side in (self.xaxis, self.yaxis):
            side.is_log |= side.axis_name in side_names

    def set_tick_length(self, length: float, side_names: Sequence[str] = ("x", "y")) -> None:
        """Set the length of ticks in points."""
        for side in (self.xaxis, self.yaxis):
            side.tick_length = length if side.axis_name in side_names else side.tick_length

    def set_grid(self, color: str, linewidth: float = 0.5, alpha: float = 1.0) -> None:
        """Draw lines at the ticks, behind all items."""
        self.grid_stroke = Stroke(color.lower(), linewidth, alpha=alpha)

    def hide_edges(self, *names: str) -> None:
        """Hide edges: 'left', 'bottom', 'right', 'top'."""
        self.edges -= {*names}


def _lines_with_gaps(place: Any, low: Any, high: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the places, and the heights, of lines from low to high at some places as one line with gaps."""
    places, *heights = np.broadcast_arrays(np.atleast_1d(place), low, high, np.nan)
    return np.stack([places, places, heights[2]], -1).ravel(), np.stack(heights, -1).ravel()
