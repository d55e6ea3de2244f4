"""Axes that store lines, points, areas, cells, bars and texts until they are written."""

import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_hex, to_rgba
from matplotlib.patches import Circle, Patch

from .items import PAPER, Box, Item, LegendEntry, MarkerStyle, Side, Spines, Stroke, TextStyle, UnsupportedError

MAX_POINTS, MAX_CORNERS, MAX_CELLS = 4_000, 20_000, 3_000  # above these, a picture has pixels
COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728")  # default colours
_DASHES = {"--": "3.7 1.6", "-.": "6.4 1.6 1 1.6", ":": "1 1.65"}  # for a line one point wide
_FORMAT = re.compile(r"(--|-\.|-|:)?([o.|_sDxX+])?(--|-\.|-|:)?")
_TEXT_OPTIONS = {"ha", "va", "fontsize", "color", "weight", "bbox", "zorder"}


class Axes:
    """Two sides and the items between them; only some methods of matplotlib's axes exist here."""

    def __init__(self, figure: Any):
        """Take the sheet of these axes."""
        self.figure = figure
        self.xaxis, self.yaxis = Side("x"), Side("y")
        self.items: list[Item] = []
        self.legend_entries: list[LegendEntry] = []
        self.spines = Spines(dict.fromkeys(("left", "bottom", "right", "top"), True))
        self.grid_style: dict[str, Any] = {}
        self.face_colour, self.equal_aspect = PAPER, False
        self.legend_options: dict[str, Any] | None = None  # of the legend
        self.line_count = 0

    def __getattr__(self, name: str) -> Any:
        raise UnsupportedError(name)

    def to_points(self, x: Any, y: Any, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return coordinates as points from the sheet's upper left corner."""
        return box.left + self.xaxis.fraction(x) * box.width, box.top + (1.0 - self.yaxis.fraction(y)) * box.height

    def plot(self, *values: Any, label: str | None = None, zorder: float = 2.0, **style: Any) -> list[None]:
        """Draw a line, or points, or both."""
        format_code = values[-1] if isinstance(values[-1], str) else ""
        arrays = [np.asarray(value, float) for value in (values[:-1] if format_code else values)]
        x, y = arrays if len(arrays) == 2 else (np.arange(len(arrays[0]), dtype=float), *arrays)
        spans_height = style.pop("transform", None) == ("x", self)
        if len(arrays) > 2 or x.ndim > 1:
            raise UnsupportedError("plot")
        stroke, marker_style = self._parse_style(format_code, style)
        for k in range(y.shape[1] if y.ndim == 2 else 1):
            column = np.atleast_1d(y[:, k] if y.ndim == 2 else y)
            self._add_line(np.atleast_1d(x), column, stroke, marker_style, zorder, spans_height=spans_height)
        if label and not label.startswith("_"):
            self.legend_entries.append(LegendEntry(label, stroke, marker_style))
        self.line_count += 1
        return [None]

    def _parse_style(self, format_code: str, style: dict[str, Any]) -> tuple[Stroke | None, MarkerStyle | None]:
        parts = _FORMAT.fullmatch(format_code)
        leading_dash, marker, trailing_dash = parts.groups() if parts else (None, None, None)
        full_names = {"lw": "linewidth", "ls": "linestyle", "ms": "markersize", "mew": "markeredgewidth"}
        style = {full_names.get(key, key): value for key, value in style.items()}
        supported = {
            "color",
            "linewidth",
            "linestyle",
            "marker",
            "markersize",
            "markeredgewidth",
            "markerfacecolor",
            "alpha",
        }
        if not {*style} <= supported | {"rasterized", "solid_capstyle"}:
            raise UnsupportedError(f"plot: {sorted(style)}")
        colour = to_hex(style["color"] if style.get("color") is not None else COLOURS[self.line_count % len(COLOURS)])
        marker, alpha = style.get("marker", marker), style.get("alpha") or 1.0
        line_style: Any = style.get("linestyle", (leading_dash or trailing_dash or "") if format_code else "-")
        width = style.get("linewidth", 1.5)
        dash = (
            _DASHES.get(line_style, "") if isinstance(line_style, str) else " ".join(map(str, line_style[1]))
        )  # (offset, lengths)
        stroke = Stroke(colour, width, dash, alpha, style.get("solid_capstyle", "butt"))
        if not marker:
            return (stroke if line_style else None), None
        fill_colour, edge_width = style.get("markerfacecolor", ""), style.get("markeredgewidth", 1.0)
        size = style.get("markersize", 6.0) * (0.5 if marker == "." else 1.0)
        return (stroke if line_style else None), MarkerStyle(
            marker, colour, size, alpha, fill_colour and to_hex(fill_colour), edge_width
        )

    def _add_line(
        self,
        x: np.ndarray,
        y: np.ndarray,
        stroke: Stroke | None,
        marker_style: MarkerStyle | None,
        zorder: float,
        *,
        spans_height: bool,
    ) -> None:
        x, y = np.broadcast_arrays(x, y)
        if len(x) > (MAX_POINTS if marker_style else MAX_CORNERS):
            raise UnsupportedError("many points")
        self.xaxis.extend_data(x)
        if not spans_height:
            self.yaxis.extend_data(y)
        if stroke:
            self.items.append(Item("line", x, y, stroke, zorder, spans_height))
        if marker_style:
            self.items.append(Item("points", x, y, marker_style, zorder, spans_height))

    def step(self, x: Any, y: Any, format_code: str = "-", *, where: str = "pre", **style: Any) -> None:
        """Draw a line of steps, each at the height of the point before it."""
        if where != "post":
            raise UnsupportedError("step")
        stroke, marker_style = self._parse_style(format_code, style)
        x, y = np.asarray(x, float), np.asarray(y, float)
        self._add_line(np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1], stroke, None, 2.0, spans_height=False)
        self._add_line(x, y, None, marker_style, 2.0, spans_height=False)
        self.line_count += 1

    def scatter(self, x: Any, y: Any, s: float = 36.0, c: Any = None, **style: Any) -> ScalarMappable:
        """Draw points, each with the colour of its value."""
        style = {key: value for key, value in style.items() if key not in ("linewidths", "rasterized")}
        zorder, alpha, shape = style.pop("zorder", 1.0), style.pop("alpha", 1.0), style.pop("marker", "o")
        coloured = ScalarMappable(style.pop("norm", None) or Normalize(), style.pop("cmap", None))
        x, y, single_colour = (
            np.asarray(x, float),
            np.asarray(y, float),
            style.pop("color", c if isinstance(c, str) else None),
        )
        style.pop("edgecolors", None)
        if style or len(x) > MAX_POINTS:
            raise UnsupportedError(f"scatter: {sorted(style)}")
        self.xaxis.extend_data(x)
        self.yaxis.extend_data(y)
        size = float(np.sqrt(s)) * (1.0 if shape == "o" else 0.8)
        if single_colour is not None:
            self.items.append(Item("points", x, y, MarkerStyle(shape, to_hex(single_colour), size, alpha), zorder))
            return coloured
        values = np.asarray(c, float)
        coloured.set_array(values)
        coloured.autoscale_None()
        shades = np.round(np.asarray(coloured.norm(values), float) * 63.0) / 63.0
        for shade in np.unique(shades[np.isfinite(shades)]):
            has_shade = shades == shade
            self.items.append(
                Item(
                    "points",
                    x[has_shade],
                    y[has_shade],
                    MarkerStyle(shape, to_hex(coloured.cmap(shade)), size, alpha),
                    zorder,
                )
            )
        return coloured

    def fill_between(
        self, x: Any, low: Any, high: Any, *, color: str, alpha: float = 1.0, linewidth: float = 0.0
    ) -> None:
        """Fill the area between two lines."""
        x, low, high = (np.asarray(array, float) for array in np.broadcast_arrays(x, low, high))
        finite = np.isfinite(low) & np.isfinite(high)
        x, low, high = x[finite], low[finite], high[finite]
        self._add_area(np.r_[x, x[::-1]], np.r_[low, high[::-1]], to_hex(color), alpha)

    def fill(
        self, x: Any, y: Any, *, facecolor: Any, edgecolor: Any, linewidth: float = 1.0, zorder: float = 1.0
    ) -> None:
        """Fill the inside of a closed line, and draw the line."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        *_, alpha = to_rgba(facecolor)
        self._add_area(x, y, to_hex(facecolor), float(alpha), zorder)
        edge = Stroke(to_hex(edgecolor), linewidth)
        self._add_line(np.append(x, x[:1]), np.append(y, y[:1]), edge, None, zorder, spans_height=False)

    def _add_area(self, x: np.ndarray, y: np.ndarray, colour: str, alpha: float, zorder: float = 1.0) -> None:
        self.xaxis.extend_data(x)
        self.yaxis.extend_data(y)
        self.items.append(Item("area", x, y, (colour, alpha), zorder))

    def vlines(self, x: Any, low: Any, high: Any, *, color: str, linewidth: float = 1.5, alpha: float = 1.0) -> None:
        """Draw vertical lines."""
        x, low, high = np.broadcast_arrays(x, low, high)
        self._add_segments(x, x, low, high, Stroke(to_hex(color), linewidth, "", alpha))

    def hlines(self, y: Any, low: Any, high: Any, *, color: str, linewidth: float = 1.5, alpha: float = 1.0) -> None:
        """Draw horizontal lines."""
        y, low, high = np.broadcast_arrays(y, low, high)
        self._add_segments(low, high, y, y, Stroke(to_hex(color), linewidth, "", alpha))

    def _add_segments(self, x0: Any, x1: Any, y0: Any, y1: Any, stroke: Stroke) -> None:
        x, y = (
            np.stack([*np.atleast_1d(*ends), np.full(np.size(ends[0]), np.nan)], -1).ravel()
            for ends in ((x0, x1), (y0, y1))
        )
        self._add_line(x, y, stroke, None, 2.0, spans_height=False)

    def axhline(self, y: float, *, label: str | None = None, **style: Any) -> None:
        """Draw a horizontal line across the axes."""
        self._add_spanning_line(label, np.array([0.0, 1.0]), np.array([y, y], float), style, is_horizontal=True)

    def axvline(self, x: float, *, label: str | None = None, **style: Any) -> None:
        """Draw a vertical line across the axes."""
        self._add_spanning_line(label, np.array([x, x], float), np.array([0.0, 1.0]), style, is_horizontal=False)

    def _add_spanning_line(
        self, label: str | None, x: np.ndarray, y: np.ndarray, style: dict[str, Any], *, is_horizontal: bool
    ) -> None:
        stroke, _ = self._parse_style("", {"color": "#000000", **style})
        (self.yaxis if is_horizontal else self.xaxis).extend_data(y if is_horizontal else x)
        self.items.append(Item("line", x, y, stroke, 2.0, not is_horizontal, is_horizontal))
        if label:
            self.legend_entries.append(LegendEntry(label, stroke))

    def axhspan(self, low: float, high: float, *, color: str, linewidth: float = 0.0, zorder: float = 1.0) -> None:
        """Fill the area between two heights."""
        self.yaxis.extend_data([low, high])
        x, y = np.array([0.0, 1.0, 1.0, 0.0]), np.array([low, low, high, high], float)
        self.items.append(Item("area", x, y, (to_hex(color), 1.0), zorder, spans_width=True))

    def bar(
        self, x: Any, height: Any, width: float = 0.8, bottom: Any = 0.0, *, color: str, label: str = "", **style: Any
    ) -> None:
        """Draw vertical bars."""
        x, height, bottom = (np.array(array, float) for array in np.broadcast_arrays(x, height, bottom))
        self._add_bars(x - 0.5 * width, x + 0.5 * width, bottom, bottom + height, color, style)
        self.yaxis.sticky_ends |= {*bottom.tolist()}
        if label:
            self.legend_entries.append(LegendEntry(label, fill_colour=to_hex(color)))

    def hist(
        self, values: Any, bins: Any, *, weights: Any = None, density: bool = False, color: str, **style: Any
    ) -> None:
        """Draw the number of values between edges."""
        counts, edges = np.histogram(values, bins, weights=weights, density=density)
        self._add_bars(edges[:-1], edges[1:], np.zeros(len(counts)), counts, color, style)
        self.yaxis.sticky_ends.add(0.0)

    def _add_bars(self, left: Any, right: Any, low: Any, high: Any, color: str, style: dict[str, Any]) -> None:
        if not {*style} <= {"alpha", "linewidth"}:
            raise UnsupportedError(f"bars: {sorted(style)}")
        corners = np.stack([left, right, right, left, np.full(len(left), np.nan)], -1)
        heights = np.stack([low, low, high, high, np.full(len(left), np.nan)], -1)
        self._add_area(corners.ravel(), heights.ravel().astype(float), to_hex(color), style.get("alpha", 1.0))

    def pcolormesh(self, x: Any, y: Any, values: Any, **style: Any) -> ScalarMappable:
        """Draw cells between edges, each in the colour of its number; a masked one shows what is behind."""
        norm = style.pop("norm", None) or Normalize(style.pop("vmin", None), style.pop("vmax", None))
        coloured, edge = ScalarMappable(norm, style.pop("cmap", None)), style.pop("edgecolors", "face")
        width = style.pop("linewidth", 0.0)
        style.pop("rasterized", None)
        values = np.ma.masked_invalid(values)
        if style or values.size > MAX_CELLS:
            raise UnsupportedError("cells")
        coloured.set_array(values)
        coloured.autoscale_None()
        x, y = np.asarray(x, float), np.asarray(y, float)
        self.xaxis.extend_data(x)
        self.yaxis.extend_data(y)
        self.xaxis.sticky_ends |= {float(x[0]), float(x[-1])}
        self.yaxis.sticky_ends |= {float(y[0]), float(y[-1])}
        cell_colours, is_masked = np.asarray(coloured.cmap(coloured.norm(values))), np.ma.getmaskarray(values)
        rows, columns = values.shape
        hex_colours = [
            ["" if is_masked[k, m] else to_hex(cell_colours[k, m]) for m in range(columns)] for k in range(rows)
        ]
        self.items.append(Item("cells", x, y, (hex_colours, "" if edge == "face" else to_hex(edge), width), 0.0))
        return coloured

    def text(self, x: float, y: float, text: str, **options: Any) -> None:
        """Write a text at a position."""
        if not {*options} <= _TEXT_OPTIONS:
            raise UnsupportedError(f"text: {sorted(options)}")
        ha, va, size = options.get("ha", "left"), options.get("va", "baseline"), options.get("fontsize", 9.0)
        style = TextStyle(
            text,
            ha,
            va,
            size,
            to_hex(options.get("color", "#1f2933")),
            options.get("weight", "normal"),
            options.get("bbox"),
        )
        self.items.append(Item("text", np.array([x], float), np.array([y], float), style, 3.0))

    def add_patch(self, patch: Patch) -> None:
        """Draw a circle."""
        if type(patch) is not Circle:
            raise UnsupportedError("patch")
        (x, y), radius = patch.center, patch.radius
        self.xaxis.extend_data([x - radius, x + radius])
        self.yaxis.extend_data([y - radius, y + radius])
        face = to_rgba(patch.get_facecolor())
        style = to_hex(face) if face[3] else "none", to_hex(patch.get_edgecolor()), patch.get_linewidth()
        self.items.append(Item("ellipse", np.array([x, radius]), np.array([y, radius]), style, patch.get_zorder()))

    def legend(self, *, handles: Sequence[Any] = (), **options: Any) -> None:
        """Draw the legend: above the axes, to their right, or in their upper left corner."""
        for handle in handles:
            self.legend_entries.append(LegendEntry(handle.get_label(), fill_colour=to_hex(handle.get_facecolor())))
        anchor = options.get("bbox_to_anchor")
        placements = {("lower left", True): "above", ("upper left", True): "right", ("center left", True): "right"}
        placement = "inside" if anchor is None else placements.get((options.get("loc", "best"), True))
        if placement is None or (anchor is None and options.get("loc") != "upper left"):
            raise UnsupportedError("legend")
        self.legend_options = {**options, "placement": placement}

    def set(self, **values: Any) -> None:
        """Set several properties by their names."""
        for name, value in values.items():
            getattr(self, f"set_{name}")(value)

    def set_xlabel(self, label: str) -> None:
        """Set the label of the abscissa."""
        self.xaxis.label = label

    def set_ylabel(self, label: str) -> None:
        """Set the label of the ordinate."""
        self.yaxis.label = label

    def set_xlim(self, low: Any = None, high: Any = None) -> None:
        """Set the ends of the abscissa, one or both."""
        _set_limits(self.xaxis, low, high)

    def set_ylim(self, low: Any = None, high: Any = None) -> None:
        """Set the ends of the ordinate, one or both."""
        _set_limits(self.yaxis, low, high)

    def get_xlim(self) -> tuple[float, float]:
        """Return the ends of the abscissa."""
        return self.xaxis.limits()

    def get_ylim(self) -> tuple[float, float]:
        """Return the ends of the ordinate."""
        return self.yaxis.limits()

    def set_xscale(self, name: str) -> None:
        """Make the abscissa linear or logarithmic."""
        self.xaxis.is_log = name == "log"

    def set_yscale(self, name: str) -> None:
        """Make the ordinate linear or logarithmic; called by name, as `set` and `draw.style` do."""
        self.yaxis.is_log = name == "log"

    def set_xticks(self, ticks: Any, labels: Any = None, **style: Any) -> None:
        """Set the ticks of the abscissa."""
        self.xaxis.set_ticks(ticks, labels, **style)

    def set_yticks(self, ticks: Any, labels: Any = None, **style: Any) -> None:
        """Set the ticks of the ordinate."""
        self.yaxis.set_ticks(ticks, labels, **style)

    def set_aspect(self, aspect: str) -> None:
        """Set equal scales of both sides."""
        self.equal_aspect = aspect == "equal"

    def set_facecolor(self, colour: str) -> None:
        """Fill the axes."""
        self.face_colour = to_hex(colour)

    def set_axisbelow(self, below: bool) -> None:
        """Draw the grid behind all items; this is always the case."""

    def grid(self, *, color: str, linewidth: float, alpha: float = 1.0) -> None:
        """Draw lines at the ticks."""
        self.grid_style = {"colour": to_hex(color), "width": linewidth, "alpha": alpha}

    def tick_params(self, *, axis: str = "both", length: float | None = None, labelsize: float | None = None) -> None:
        """Set the length of ticks and the size of their labels."""
        for side in self._sides(axis):
            side.tick_length = side.tick_length if length is None else length
            side.font_size = side.font_size if labelsize is None else labelsize

    def _sides(self, axis_name: str) -> Iterator[Side]:
        yield from (side for side in (self.xaxis, self.yaxis) if axis_name in ("both", side.axis_name))

    def get_figure(self, *, root: bool = True) -> Any:
        """Return the sheet."""
        return self.figure

    def get_xaxis_transform(self) -> tuple[str, "Axes"]:
        """Return the marker of a transform whose ordinate is a share of the height."""
        return ("x", self)


def _set_limits(side: Side, low: Any, high: Any) -> None:
    low, high = low if isinstance(low, tuple) else (low, high)
    side.fixed_limits = [
        old if new is None else float(new) for old, new in zip(side.fixed_limits, (low, high), strict=True)
    ]
