"""Axes that store lines, points, areas, cells, bars and words until they are written."""

import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_hex, to_rgba
from matplotlib.patches import Circle, Patch

from .items import PAPER, Box, Entry, Item, Marks, Spines, Stroke, Words
from .side import Side, UnsupportedError

MOST_POINTS, MOST_CORNERS, MOST_CELLS = 4_000, 20_000, 3_000  # above these, a picture has pixels
COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728")  # default colours
_DASHES = {"--": "3.7 1.6", "-.": "6.4 1.6 1 1.6", ":": "1 1.65"}  # for a line one point wide
_FORM = re.compile(r"(--|-\.|-|:)?([o.|_sDxX+])?(--|-\.|-|:)?")
_WORDS = {"ha", "va", "fontsize", "color", "weight", "bbox", "zorder"}


class Axes:
    """Two sides and the items between them; only some methods of matplotlib's axes exist here."""

    def __init__(self, figure: Any):
        """Take the sheet of these axes."""
        self.figure = figure
        self.xaxis, self.yaxis = Side("x"), Side("y")
        self.items: list[Item] = []
        self.entries: list[Entry] = []
        self.spines = Spines(dict.fromkeys(("left", "bottom", "right", "top"), True))
        self.ruled: dict[str, Any] = {}
        self.face, self.equal = PAPER, False
        self.key: dict[str, Any] | None = None  # of the legend
        self.lines = 0

    def __getattr__(self, name: str) -> Any:
        raise UnsupportedError(name)

    def points(self, x: Any, y: Any, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return coordinates as points from the sheet's upper left corner."""
        return box.left + self.xaxis.share(x) * box.wide, box.top + (1.0 - self.yaxis.share(y)) * box.high

    def plot(self, *values: Any, label: str | None = None, zorder: float = 2.0, **look: Any) -> list[None]:
        """Draw a line, or points, or both."""
        form = values[-1] if isinstance(values[-1], str) else ""
        arrays = [np.asarray(value, float) for value in (values[:-1] if form else values)]
        x, y = arrays if len(arrays) == 2 else (np.arange(len(arrays[0]), dtype=float), *arrays)
        across = look.pop("transform", None) == ("x", self)
        if len(arrays) > 2 or x.ndim > 1:
            raise UnsupportedError("plot")
        stroke, marks = self._look(form, look)
        for k in range(y.shape[1] if y.ndim == 2 else 1):
            each = np.atleast_1d(y[:, k] if y.ndim == 2 else y)
            self._line(np.atleast_1d(x), each, stroke, marks, zorder, across=across)
        if label and not label.startswith("_"):
            self.entries.append(Entry(label, stroke, marks))
        self.lines += 1
        return [None]

    def _look(self, form: str, look: dict[str, Any]) -> tuple[Stroke | None, Marks | None]:
        parts = _FORM.fullmatch(form)
        before, marker, after = parts.groups() if parts else (None, None, None)
        names = {"lw": "linewidth", "ls": "linestyle", "ms": "markersize", "mew": "markeredgewidth"}
        look = {names.get(key, key): value for key, value in look.items()}
        known = {
            "color",
            "linewidth",
            "linestyle",
            "marker",
            "markersize",
            "markeredgewidth",
            "markerfacecolor",
            "alpha",
        }
        if not {*look} <= known | {"rasterized", "solid_capstyle"}:
            raise UnsupportedError(f"plot: {sorted(look)}")
        colour = to_hex(look["color"] if look.get("color") is not None else COLOURS[self.lines % len(COLOURS)])
        marker, alpha = look.get("marker", marker), look.get("alpha") or 1.0
        style: Any = look.get("linestyle", (before or after or "") if form else "-")
        width = look.get("linewidth", 1.5)
        dash = _DASHES.get(style, "") if isinstance(style, str) else " ".join(map(str, style[1]))  # (offset, lengths)
        stroke = Stroke(colour, width, dash, alpha, look.get("solid_capstyle", "butt"))
        if not marker:
            return (stroke if style else None), None
        filled, edge = look.get("markerfacecolor", ""), look.get("markeredgewidth", 1.0)
        size = look.get("markersize", 6.0) * (0.5 if marker == "." else 1.0)
        return (stroke if style else None), Marks(marker, colour, size, alpha, filled and to_hex(filled), edge)

    def _line(
        self, x: np.ndarray, y: np.ndarray, stroke: Stroke | None, marks: Marks | None, order: float, *, across: bool
    ) -> None:
        x, y = np.broadcast_arrays(x, y)
        if len(x) > (MOST_POINTS if marks else MOST_CORNERS):
            raise UnsupportedError("many points")
        self.xaxis.add(x)
        if not across:
            self.yaxis.add(y)
        if stroke:
            self.items.append(Item("line", x, y, stroke, order, across))
        if marks:
            self.items.append(Item("points", x, y, marks, order, across))

    def step(self, x: Any, y: Any, form: str = "-", *, where: str = "pre", **look: Any) -> None:
        """Draw a line of steps, each at the height of the point before it."""
        if where != "post":
            raise UnsupportedError("step")
        stroke, marks = self._look(form, look)
        x, y = np.asarray(x, float), np.asarray(y, float)
        self._line(np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1], stroke, None, 2.0, across=False)
        self._line(x, y, None, marks, 2.0, across=False)
        self.lines += 1

    def scatter(self, x: Any, y: Any, s: float = 36.0, c: Any = None, **look: Any) -> ScalarMappable:
        """Draw points, each with the colour of its value."""
        look = {key: value for key, value in look.items() if key not in ("linewidths", "rasterized")}
        order, alpha, shape = look.pop("zorder", 1.0), look.pop("alpha", 1.0), look.pop("marker", "o")
        coloured = ScalarMappable(look.pop("norm", None) or Normalize(), look.pop("cmap", None))
        x, y, single = np.asarray(x, float), np.asarray(y, float), look.pop("color", c if isinstance(c, str) else None)
        look.pop("edgecolors", None)
        if look or len(x) > MOST_POINTS:
            raise UnsupportedError(f"scatter: {sorted(look)}")
        self.xaxis.add(x)
        self.yaxis.add(y)
        size = float(np.sqrt(s)) * (1.0 if shape == "o" else 0.8)
        if single is not None:
            self.items.append(Item("points", x, y, Marks(shape, to_hex(single), size, alpha), order))
            return coloured
        values = np.asarray(c, float)
        coloured.set_array(values)
        coloured.autoscale_None()
        shades = np.round(np.asarray(coloured.norm(values), float) * 63.0) / 63.0
        for shade in np.unique(shades[np.isfinite(shades)]):
            matching = shades == shade
            self.items.append(
                Item("points", x[matching], y[matching], Marks(shape, to_hex(coloured.cmap(shade)), size, alpha), order)
            )
        return coloured

    def fill_between(
        self, x: Any, low: Any, high: Any, *, color: str, alpha: float = 1.0, linewidth: float = 0.0
    ) -> None:
        """Fill the area between two lines."""
        x, low, high = (np.asarray(array, float) for array in np.broadcast_arrays(x, low, high))
        finite = np.isfinite(low) & np.isfinite(high)
        x, low, high = x[finite], low[finite], high[finite]
        self._area(np.r_[x, x[::-1]], np.r_[low, high[::-1]], to_hex(color), alpha)

    def fill(
        self, x: Any, y: Any, *, facecolor: Any, edgecolor: Any, linewidth: float = 1.0, zorder: float = 1.0
    ) -> None:
        """Fill the inside of a closed line, and draw the line."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        *_, alpha = to_rgba(facecolor)
        self._area(x, y, to_hex(facecolor), float(alpha), zorder)
        edge = Stroke(to_hex(edgecolor), linewidth)
        self._line(np.append(x, x[:1]), np.append(y, y[:1]), edge, None, zorder, across=False)

    def _area(self, x: np.ndarray, y: np.ndarray, colour: str, alpha: float, order: float = 1.0) -> None:
        self.xaxis.add(x)
        self.yaxis.add(y)
        self.items.append(Item("area", x, y, (colour, alpha), order))

    def vlines(self, x: Any, low: Any, high: Any, *, color: str, linewidth: float = 1.5, alpha: float = 1.0) -> None:
        """Draw vertical lines."""
        x, low, high = np.broadcast_arrays(x, low, high)
        self._apart(x, x, low, high, Stroke(to_hex(color), linewidth, "", alpha))

    def hlines(self, y: Any, low: Any, high: Any, *, color: str, linewidth: float = 1.5, alpha: float = 1.0) -> None:
        """Draw horizontal lines."""
        y, low, high = np.broadcast_arrays(y, low, high)
        self._apart(low, high, y, y, Stroke(to_hex(color), linewidth, "", alpha))

    def _apart(self, x0: Any, x1: Any, y0: Any, y1: Any, stroke: Stroke) -> None:
        x, y = (
            np.stack([*np.atleast_1d(*ends), np.full(np.size(ends[0]), np.nan)], -1).ravel()
            for ends in ((x0, x1), (y0, y1))
        )
        self._line(x, y, stroke, None, 2.0, across=False)

    def axhline(self, y: float, *, label: str | None = None, **look: Any) -> None:
        """Draw a horizontal line across the axes."""
        self._across(label, np.array([0.0, 1.0]), np.array([y, y], float), look, upright=True)

    def axvline(self, x: float, *, label: str | None = None, **look: Any) -> None:
        """Draw a vertical line across the axes."""
        self._across(label, np.array([x, x], float), np.array([0.0, 1.0]), look, upright=False)

    def _across(self, label: str | None, x: np.ndarray, y: np.ndarray, look: dict[str, Any], *, upright: bool) -> None:
        stroke, _ = self._look("", {"color": "#000000", **look})
        (self.yaxis if upright else self.xaxis).add(y if upright else x)
        self.items.append(Item("line", x, y, stroke, 2.0, not upright, upright))
        if label:
            self.entries.append(Entry(label, stroke))

    def axhspan(self, low: float, high: float, *, color: str, linewidth: float = 0.0, zorder: float = 1.0) -> None:
        """Fill the area between two heights."""
        self.yaxis.add([low, high])
        x, y = np.array([0.0, 1.0, 1.0, 0.0]), np.array([low, low, high, high], float)
        self.items.append(Item("area", x, y, (to_hex(color), 1.0), zorder, upright=True))

    def bar(
        self, x: Any, height: Any, width: float = 0.8, bottom: Any = 0.0, *, color: str, label: str = "", **look: Any
    ) -> None:
        """Draw vertical bars."""
        x, height, bottom = (np.array(array, float) for array in np.broadcast_arrays(x, height, bottom))
        self._bars(x - 0.5 * width, x + 0.5 * width, bottom, bottom + height, color, look)
        self.yaxis.sticky |= {*bottom.tolist()}
        if label:
            self.entries.append(Entry(label, fill=to_hex(color)))

    def hist(
        self, values: Any, bins: Any, *, weights: Any = None, density: bool = False, color: str, **look: Any
    ) -> None:
        """Draw the number of values between edges."""
        counts, edges = np.histogram(values, bins, weights=weights, density=density)
        self._bars(edges[:-1], edges[1:], np.zeros(len(counts)), counts, color, look)
        self.yaxis.sticky.add(0.0)

    def _bars(self, left: Any, right: Any, low: Any, high: Any, color: str, look: dict[str, Any]) -> None:
        if not {*look} <= {"alpha", "linewidth"}:
            raise UnsupportedError(f"bars: {sorted(look)}")
        corners = np.stack([left, right, right, left, np.full(len(left), np.nan)], -1)
        heights = np.stack([low, low, high, high, np.full(len(left), np.nan)], -1)
        self._area(corners.ravel(), heights.ravel().astype(float), to_hex(color), look.get("alpha", 1.0))

    def pcolormesh(self, x: Any, y: Any, values: Any, **look: Any) -> ScalarMappable:
        """Draw cells between edges, each in the colour of its number; a masked one shows what is behind."""
        norm = look.pop("norm", None) or Normalize(look.pop("vmin", None), look.pop("vmax", None))
        coloured, edge = ScalarMappable(norm, look.pop("cmap", None)), look.pop("edgecolors", "face")
        width = look.pop("linewidth", 0.0)
        look.pop("rasterized", None)
        values = np.ma.masked_invalid(values)
        if look or values.size > MOST_CELLS:
            raise UnsupportedError("cells")
        coloured.set_array(values)
        coloured.autoscale_None()
        x, y = np.asarray(x, float), np.asarray(y, float)
        self.xaxis.add(x)
        self.yaxis.add(y)
        self.xaxis.sticky |= {float(x[0]), float(x[-1])}
        self.yaxis.sticky |= {float(y[0]), float(y[-1])}
        shown, hidden = np.asarray(coloured.cmap(coloured.norm(values))), np.ma.getmaskarray(values)
        rows, columns = values.shape
        colours = [["" if hidden[k, m] else to_hex(shown[k, m]) for m in range(columns)] for k in range(rows)]
        self.items.append(Item("cells", x, y, (colours, "" if edge == "face" else to_hex(edge), width), 0.0))
        return coloured

    def text(self, x: float, y: float, words: str, **look: Any) -> None:
        """Write a text at a position."""
        if not {*look} <= _WORDS:
            raise UnsupportedError(f"text: {sorted(look)}")
        ha, va, size = look.get("ha", "left"), look.get("va", "baseline"), look.get("fontsize", 9.0)
        style = Words(
            words, ha, va, size, to_hex(look.get("color", "#1f2933")), look.get("weight", "normal"), look.get("bbox")
        )
        self.items.append(Item("words", np.array([x], float), np.array([y], float), style, 3.0))

    def add_patch(self, patch: Patch) -> None:
        """Draw a circle."""
        if type(patch) is not Circle:
            raise UnsupportedError("patch")
        (x, y), radius = patch.center, patch.radius
        self.xaxis.add([x - radius, x + radius])
        self.yaxis.add([y - radius, y + radius])
        face = to_rgba(patch.get_facecolor())
        look = to_hex(face) if face[3] else "none", to_hex(patch.get_edgecolor()), patch.get_linewidth()
        self.items.append(Item("ellipse", np.array([x, radius]), np.array([y, radius]), look, patch.get_zorder()))

    def legend(self, *, handles: Sequence[Any] = (), **look: Any) -> None:
        """Draw the legend: above the axes, to their right, or in their upper left corner."""
        for handle in handles:
            self.entries.append(Entry(handle.get_label(), fill=to_hex(handle.get_facecolor())))
        anchor = look.get("bbox_to_anchor")
        places = {("lower left", True): "above", ("upper left", True): "right", ("center left", True): "right"}
        where = "inside" if anchor is None else places.get((look.get("loc", "best"), True))
        if where is None or (anchor is None and look.get("loc") != "upper left"):
            raise UnsupportedError("legend")
        self.key = {**look, "where": where}

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
        _limit(self.xaxis, low, high)

    def set_ylim(self, low: Any = None, high: Any = None) -> None:
        """Set the ends of the ordinate, one or both."""
        _limit(self.yaxis, low, high)

    def get_xlim(self) -> tuple[float, float]:
        """Return the ends of the abscissa."""
        return self.xaxis.limits()

    def get_ylim(self) -> tuple[float, float]:
        """Return the ends of the ordinate."""
        return self.yaxis.limits()

    def set_xscale(self, name: str) -> None:
        """Make the abscissa linear or logarithmic."""
        self.xaxis.log = name == "log"

    def set_yscale(self, name: str) -> None:
        """Make the ordinate linear or logarithmic."""
        self.yaxis.log = name == "log"

    def set_xticks(self, places: Any, labels: Any = None, **style: Any) -> None:
        """Set the ticks of the abscissa."""
        self.xaxis.set_ticks(places, labels, **style)

    def set_yticks(self, places: Any, labels: Any = None, **style: Any) -> None:
        """Set the ticks of the ordinate."""
        self.yaxis.set_ticks(places, labels, **style)

    def set_aspect(self, aspect: str) -> None:
        """Set equal scales of both sides."""
        self.equal = aspect == "equal"

    def set_facecolor(self, colour: str) -> None:
        """Fill the axes."""
        self.face = to_hex(colour)

    def set_axisbelow(self, below: bool) -> None:
        """Draw the grid behind all items; this is always the case."""

    def grid(self, *, color: str, linewidth: float, alpha: float = 1.0) -> None:
        """Draw lines at the ticks."""
        self.ruled = {"colour": to_hex(color), "width": linewidth, "alpha": alpha}

    def tick_params(self, *, axis: str = "both", length: float | None = None, labelsize: float | None = None) -> None:
        """Set the length of ticks and the size of their labels."""
        for side in self._sides(axis):
            side.tick_length = side.tick_length if length is None else length
            side.size = side.size if labelsize is None else labelsize

    def _sides(self, which: str) -> Iterator[Side]:
        yield from (side for side in (self.xaxis, self.yaxis) if which in ("both", side.axis_name))

    def get_figure(self, *, root: bool = True) -> Any:
        """Return the sheet."""
        return self.figure

    def get_xaxis_transform(self) -> tuple[str, "Axes"]:
        """Return the marker of a transform whose ordinate is a share of the height."""
        return ("x", self)


def _limit(side: Side, low: Any, high: Any) -> None:
    low, high = low if isinstance(low, tuple) else (low, high)
    side.given = [old if new is None else float(new) for old, new in zip(side.given, (low, high), strict=True)]
