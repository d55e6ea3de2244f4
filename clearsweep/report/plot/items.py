"""What axes hold: lines, points, areas and texts with their styles, and the sides with their ticks."""

import html
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.ticker import MaxNLocator

from ...language import wording

# Items on axes, and their styles.

PAPER = "#ffffff"  # background


class Stroke(NamedTuple):
    """Style of a line."""

    colour: str
    width: float = 1.5  # points
    dash: str = ""  # lengths of lines and gaps, in widths
    alpha: float = 1.0
    cap: str = "butt"


class MarkerStyle(NamedTuple):
    """Style of points."""

    shape: str
    colour: str
    size: float  # points
    alpha: float = 1.0
    fill_colour: str = ""  # fill colour of an open circle
    edge_width: float = 1.0  # points, for markers drawn as lines


class Item(NamedTuple):
    """One item on the axes, in data coordinates."""

    kind: str  # 'line', 'points', 'area', 'cells', 'ellipse' or 'text'
    x: np.ndarray
    y: np.ndarray
    style: Any
    order: float
    spans_height: bool = False  # y is a share of the height of the axes
    spans_width: bool = False  # x is a share of their width


class LegendEntry(NamedTuple):
    """One row of a legend."""

    name: str
    stroke: Stroke | None = None
    marker_style: MarkerStyle | None = None
    fill_colour: str = ""


class TextStyle(NamedTuple):
    """Style of a text."""

    text: str
    ha: str
    va: str
    size: float
    colour: str
    weight: str
    halo: dict[str, Any] | None = None  # background: facecolor, alpha, pad (points)


class Spines(dict):
    """The four edges; a list selects several."""

    def __getitem__(self, names: Any) -> Any:
        edges = self

        class EdgeSelection:
            """Edges that are changed together."""

            @staticmethod
            def set_visible(visible: bool) -> None:
                """Show or hide the edges."""
                edges.update(dict.fromkeys([names] if isinstance(names, str) else names, visible))

        return EdgeSelection


class Box(NamedTuple):
    """The position of axes on a sheet, in points from its upper left corner."""

    left: float
    top: float
    width: float
    height: float


# Texts as SVG, and their widths, from the widths of DejaVu Sans in thousandths of the font size.

_FIRST_CODE = 32  # code of the first letter of the table
_WIDTH_ROWS = (
    (318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636),
    (636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632),
    (575, 775, 752, 295, 295, 656, 557, 863, 748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685),
    (611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579),
    (278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838),
)
_WIDTHS = [width for row in _WIDTH_ROWS for width in row]
_OTHER_WIDTHS = {
    "\u00a0": 318,
    "°": 500,
    "²": 401,
    "³": 401,
    "⁻": 528,
    "·": 318,
    wording.DASH: 500,
    "\u202f": 200,
    wording.MINUS: 838,
    wording.TIMES: 838,
}
_DEFAULT_WIDTH = 600
INK = "#1f2933"
_FAMILY = "font-family: 'DejaVu Sans', sans-serif"
LINE_HEIGHT = 1.17  # line height over font size


def text_width(text: str, size: float) -> float:
    """Return the width (points) of a text, or of its widest line; size : font size (points)."""
    return max(sum(map(_letter_width, line)) for line in text.split("\n")) * size / 1000.0


def text_height(text: str, size: float) -> float:
    """Return the height of a text in points."""
    return LINE_HEIGHT * size * (text.count("\n") + 1)


def _letter_width(letter: str) -> int:
    index = ord(letter) - _FIRST_CODE
    return _WIDTHS[index] if 0 <= index < len(_WIDTHS) else _OTHER_WIDTHS.get(letter, _DEFAULT_WIDTH)


def text_svg(
    text: str,
    x: float,
    y: float,
    size: float,
    anchor: str,
    *,
    rotation: float = 0.0,
    is_centred: bool = False,
    style: str = "",
) -> str:
    """Return a text as SVG; `is_centred`: y is its centre, not its first baseline; rotation : degrees."""
    if not text:
        return ""
    lines = text.split("\n")
    y = y + (0.36 * size - 0.5 * 1.17 * size * (len(lines) - 1) if is_centred else 0.0)
    transform = f' transform="rotate({rotation:g} {x:.2f} {y:.2f})"' if rotation else ""
    style_text = f"font-size: {size:g}px; {_FAMILY}; text-anchor: {anchor}; {style or f'fill: {INK}'}"
    content = html.escape(lines[0])
    if len(lines) > 1:
        rows = (
            f'<tspan x="{x:.2f}" dy="{1.17 * size if k else 0:.2f}">{html.escape(line)}</tspan>'
            for k, line in enumerate(lines)
        )
        content = "".join(rows)
    return f'<text x="{x:.2f}" y="{y:.2f}"{transform} style="{style_text}">{content}</text>'


# One side of axes: its scale, its limits, its ticks and their labels.

MARGIN = 0.05  # of the data's extent, left free at its ends
_STEPS = [1, 2, 2.5, 5, 10]
_MIN_TICK_DISTANCE = {"x": 30.0, "y": 17.0}  # least distance of ticks, points
MAX_DECADE = 300.0  # powers of ten of a logarithmic axis stay within those of floats
_MAX_TICKS = 9  # largest number of ticks
_MAX_DECADES = 7  # decades up to which each has a tick
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class UnsupportedError(Exception):
    """A drawing that these axes do not support."""


class Side:
    """The abscissa or the ordinate of axes."""

    def __init__(self, axis_name: str):
        """Take the letter of the side, 'x' or 'y'."""
        self.axis_name, self.label, self.is_log = axis_name, "", False
        self.fixed_limits: list[float | None] = [None, None]  # the limits set by a drawing
        self.data: list[np.ndarray] = []
        self.sticky_ends: set[float] = set()  # ends without margin
        self.locator: Any = None
        self.formatter: Callable[[float, Any], str] | None = None
        self.fixed_ticks: tuple[list[float], list[str] | None] | None = None
        self.label_style: dict[str, Any] = {}  # of the tick labels
        self.tick_length, self.font_size, self.margin = 3.5, 8.0, MARGIN

    def extend_data(self, values: Any) -> None:
        """Extend the data by values; non-finite ones are ignored."""
        values = np.asarray(values, float).ravel()
        self.data.append(values[np.isfinite(values)])

    def get_scale(self) -> str:
        """Return 'log' or 'linear'."""
        return "log" if self.is_log else "linear"

    def limits(self) -> tuple[float, float]:
        """Return both ends: as set, or those of the data with a margin."""
        values = np.concatenate([np.empty(0), *self.data])
        values = values[values > 0.0] if self.is_log else values
        low, high = (float(values.min()), float(values.max())) if len(values) else (1.0 if self.is_log else 0.0, 1.0)
        a, b = (math.log10(low), math.log10(high)) if self.is_log else (low, high)
        margin = self.margin * (b - a) if b > a else 0.05 * (abs(a) or 1.0)
        limits = [
            end if data_end in self.sticky_ends else end + sign * margin
            for end, data_end, sign in ((a, low, -1.0), (b, high, 1.0))
        ]
        limits = [10.0 ** min(max(end, -MAX_DECADE), MAX_DECADE) for end in limits] if self.is_log else limits
        low, high = (
            end if set_limit is None else set_limit for end, set_limit in zip(limits, self.fixed_limits, strict=True)
        )
        return low, high

    def fraction(self, values: Any) -> np.ndarray:
        """Return values relative to both ends, 0 to 1."""
        low, high = self.limits()
        values = np.asarray(values, float)
        if self.is_log:
            with np.errstate(all="ignore"):
                values = np.log10(np.where(values > 0.0, values, np.nan))
            low, high = math.log10(low), math.log10(high)
        return (values - low) / ((high - low) or 1.0)

    def set_major_locator(self, locator: Any) -> None:
        """Take the locator of ticks."""
        self.locator, self.fixed_ticks = locator, None

    def set_minor_locator(self, locator: Any) -> None:
        """Take the locator of minor ticks; it is ignored."""

    def set_major_formatter(self, formatter: Callable[[float, Any], str]) -> None:
        """Take the formatter of tick labels."""
        self.formatter = formatter

    def set_ticks(self, ticks: Sequence[float], labels: Sequence[str] | None = None, **style: Any) -> None:
        """Take ticks and their labels."""
        if not {*style} <= {"rotation", "ha", "rotation_mode", "fontsize"}:
            raise UnsupportedError(f"style of ticks: {style}")
        self.fixed_ticks = (
            [float(position) for position in ticks],
            None if labels is None else [str(label) for label in labels],
        )
        self.label_style, self.font_size = style, style.get("fontsize", self.font_size)

    def ticks(self, length: float) -> list[tuple[float, str]]:
        """Return the ticks within both ends and their labels; length : of the side, in points."""
        low, high = sorted(self.limits())
        if self.fixed_ticks is not None:
            positions, labels = self.fixed_ticks
        else:
            labels = None
            if self.locator is not None:
                positions = [float(value) for value in self.locator.tick_values(low, high)]
            elif self.is_log:
                positions = _decades(low, high)
            else:
                max_ticks = max(2, min(_MAX_TICKS, int(length / _MIN_TICK_DISTANCE[self.axis_name])))
                positions = [float(value) for value in MaxNLocator(max_ticks, steps=_STEPS).tick_values(low, high)]
        names = labels if labels is not None else self._tick_labels(positions)
        tolerance = 1e-9 * (high - low)
        visible_ticks = [
            (position, name)
            for position, name in zip(positions, names, strict=True)
            if low - tolerance <= position <= high + tolerance
        ]
        return visible_ticks

    def _tick_labels(self, positions: Sequence[float]) -> list[str]:
        if self.formatter is not None:
            return [self.formatter(position, None) for position in positions]
        if self.is_log:
            return [f"10{f'{round(math.log10(position))}'.translate(_SUPERSCRIPTS)}" for position in positions]
        step = min((b - a for a, b in itertools.pairwise(positions)), default=1.0) or 1.0
        largest = max(map(abs, positions), default=0.0)
        if largest >= 1e5 or 0.0 < step < 1e-4:
            return [
                wording.short_number_text(position if abs(position) > 1e-9 * largest else 0.0, 4)
                for position in positions
            ]
        digits = next((d for d in range(8) if all(abs(round(p, d) - p) < 1e-6 * step for p in positions)), 8)
        return [f"{position + 0.0:.{digits}f}".replace("-", wording.MINUS) for position in positions]


def _decades(low: float, high: float) -> list[float]:
    """Return the powers of ten between two ends; if they are many, every second or third."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    stride = max(1, math.ceil((last - first + 1) / _MAX_DECADES))
    return [10.0**power for power in range(first, last + 1, stride)]
