"""What axes hold: lines, points, areas and texts with their styles; colour scales; the sides with their ticks."""

import base64
import html
import itertools
import math
import struct
import zlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...language import wording

# Colours of drawings: scales that turn numbers into colours, and images of coloured cells.


def _anchors(codes: str) -> tuple[str, ...]:
    return tuple(f"#{code}" for code in codes.split())


#: Colours at equal distances; those between them are blended.  viridis: van der Walt and Smith 2015, CC0.
VIRIDIS = _anchors(
    "440154 470d60 48186a 482374 472d7b 453781 424086 3e4989 3b528b 375b8d 33638d 2f6b8e 2c728e 297a8e 26828e 23898e "
    "21918c 1f988b 1fa088 22a785 28ae80 32b67a 3fbc73 4ec36b 5ec962 70cf57 84d44b 98d83e addc30 c2df23 d8e219 ece51b "
    "fde725"
)
BLUES = _anchors("f7fbff deebf7 c6dbef 9dcae1 6aaed6 4191c6 2070b4 08509b 08306b")  # Brewer 2003
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


class ColourScale(NamedTuple):
    """Maps numbers from `low` to `high` to colours; numbers beyond the ends have the colour of the end."""

    low: float
    high: float
    colours: tuple[str, ...] = VIRIDIS
    is_log: bool = False
    is_stepped: bool = False  # each colour is that of one of as many equal parts of the range; none is blended

    def fractions(self, values: Any) -> np.ndarray:
        """Return numbers relative to both ends, 0 to 1; NaN where there is none."""
        values, low, high = np.asarray(values, float), self.low, self.high
        if self.is_log:
            with np.errstate(all="ignore"):
                values = np.log(np.where(values > 0.0, values, np.nan))
            low, high = float(np.log(low)), float(np.log(high))
        return np.clip((values - low) / ((high - low) or 1.0), 0.0, 1.0)

    def rgb(self, fractions: np.ndarray) -> np.ndarray:
        """Return the colours (..., 3), uint8, at fractions of the range; those of NaN are the first."""
        anchors = np.array([[int(colour[i : i + 2], 16) for i in (1, 3, 5)] for colour in self.colours], float)
        fractions = np.nan_to_num(fractions)
        if self.is_stepped:
            return anchors[np.minimum((fractions * len(anchors)).astype(int), len(anchors) - 1)].astype(np.uint8)
        places = np.linspace(0.0, 1.0, len(anchors))
        blended = [np.interp(fractions, places, anchors[:, channel]) for channel in range(3)]
        return np.rint(np.stack(blended, -1)).astype(np.uint8)

    def hex_colours(self, fractions: Any) -> list[str]:
        """Return the colours at fractions of the range, as '#rrggbb'."""
        rgb = self.rgb(np.atleast_1d(np.asarray(fractions, float)))
        return [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in rgb.tolist()]


def png_address(pixels: np.ndarray) -> str:
    """Return an image (rows, columns, 4), uint8 RGBA, as the address of a PNG file within the text (RFC 2083)."""
    rows, columns, _ = pixels.shape
    lines = np.concatenate([np.zeros((rows, 1), np.uint8), pixels.reshape(rows, -1)], axis=1)  # filter type 0
    header = struct.pack(">IIBBBBB", columns, rows, 8, 6, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 9)), (b"IEND", b""))
    chunk_texts = (
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )
    body = b"".join(chunk_texts)
    return "data:image/png;base64," + base64.b64encode(PNG_SIGNATURE + body).decode()


# What axes hold: lines, points, areas and texts with their styles, and the sides with their ticks.

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

    shape: str  # one of 'o.|_sDxX+'
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
    is_clipped: bool = True  # at the edges of the axes


class CellStyle(NamedTuple):
    """The numbers of cells, (rows, columns), and their colours; NaN shows what is behind."""

    values: np.ndarray
    scale: ColourScale
    edge_colour: str = ""  # '': no edges
    edge_width: float = 0.0  # points


class LegendEntry(NamedTuple):
    """One row of a legend."""

    name: str
    stroke: Stroke | None = None
    marker_style: MarkerStyle | None = None
    fill_colour: str = ""


class Legend(NamedTuple):
    """The place and the form of a legend."""

    place: str  # 'above', 'right', 'centre right' or 'inside' the axes
    columns: int = 1
    title: str = ""
    sample: float = 2.0  # length of a line's sample, in font sizes
    column_gap: float = 2.0  # in font sizes
    left: float = 0.0  # of a legend above the axes: its left end as a share of their width


class TextStyle(NamedTuple):
    """Style of a text."""

    text: str
    ha: str = "left"
    va: str = "baseline"
    size: float = 9.0  # points
    colour: str = "#1f2933"
    weight: str = "normal"
    has_halo: bool = False  # on a background that hides what is behind it
    offset: float = 0.0  # points to the right of its position


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
        steps = [0.0, *[1.17 * size] * (len(lines) - 1)]
        rows = zip(steps, map(html.escape, lines), strict=True)
        content = "".join(f'<tspan x="{x:.2f}" dy="{step:.2f}">{line}</tspan>' for step, line in rows)
    return f'<text x="{x:.2f}" y="{y:.2f}"{transform} style="{style_text}">{content}</text>'


# One side of axes: its scale, its limits, its ticks and their labels.

MARGIN = 0.05  # of the data's extent, left free at its ends
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_MIN_TICK_DISTANCE = {"x": 30.0, "y": 17.0}  # least distance of ticks, points
MAX_DECADE = 300.0  # powers of ten of a logarithmic axis stay within those of floats
_MAX_TICKS = 9  # largest number of intervals between ticks
_MAX_DECADES = 7  # decades up to which each has a tick
_MAX_SPLIT_DECADES = 4  # decades up to which 2 and 5 have ticks, too
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
TickRule = Callable[[float, float], list[float]]  # both ends -> ticks


def round_ticks(intervals: int, *, integers_only: bool = False) -> TickRule:
    """Return the rule of ticks at round numbers: at most so many intervals, and two ticks or more."""

    def ticks(low: float, high: float) -> list[float]:
        least_step = ((high - low) or 1.0) / intervals
        power = 10.0 ** math.floor(math.log10(least_step))
        steps = [multiple * power * part for part in (0.1, 1.0) for multiple in _STEPS]
        largest = next(k for k, step in enumerate(steps) if step >= (1.0 - 1e-9) * least_step)
        candidates = (
            multiples_of(float(math.ceil(step)) if integers_only else step)(low, high)
            for step in reversed(steps[: largest + 1])
        )
        return next((positions for positions in candidates if len(positions) > 1), [])

    return ticks


def multiples_of(step: float) -> TickRule:
    """Return the rule of ticks at the multiples of a number."""
    return lambda low, high: [step * k for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def decades(low: float, high: float) -> list[float]:
    """Return the powers of ten between two ends; if they are many, every second or third."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    stride = max(1, math.ceil((last - first + 1) / _MAX_DECADES))
    return [10.0**power for power in range(first, last + 1, stride)]


def split_decades(low: float, high: float) -> list[float]:
    """Return 1, 2 and 5 times the powers of ten between two ends; the powers alone if they are many."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    if last - first > _MAX_SPLIT_DECADES:
        return decades(low, high)
    return [multiple * 10.0**power for power in range(first, last + 1) for multiple in (1.0, 2.0, 5.0)]


class Side:
    """The abscissa or the ordinate of axes."""

    def __init__(self, axis_name: str):
        """Take the letter of the side, 'x' or 'y'."""
        self.axis_name, self.label, self.is_log = axis_name, "", False
        self.fixed_limits: list[float | None] = [None, None]  # the limits set by a drawing
        self.data: list[np.ndarray] = []
        self.sticky_ends: set[float] = set()  # ends without margin
        self.tick_rule: TickRule | None = None
        self.formatter: Callable[[float], str] | None = None
        self.fixed_ticks: tuple[list[float], list[str] | None] | None = None
        self.rotation = 0.0  # of the tick labels, degrees
        self.tick_length, self.font_size, self.margin = 3.5, 8.0, MARGIN

    def extend_data(self, values: Any) -> None:
        """Extend the data by values; non-finite ones are ignored."""
        values = np.asarray(values, float).ravel()
        self.data.append(values[np.isfinite(values)])

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
        low, high = (end if fixed is None else fixed for end, fixed in zip(limits, self.fixed_limits, strict=True))
        return low, high

    def set_limits(self, low: float | None, high: float | None) -> None:
        """Set one end or both."""
        ends = zip(self.fixed_limits, (low, high), strict=True)
        self.fixed_limits = [old if new is None else float(new) for old, new in ends]

    def fraction(self, values: Any) -> np.ndarray:
        """Return values relative to both ends, 0 to 1."""
        low, high = self.limits()
        values = np.asarray(values, float)
        if self.is_log:
            with np.errstate(all="ignore"):
                values = np.log10(np.where(values > 0.0, values, np.nan))
            low, high = math.log10(low), math.log10(high)
        return (values - low) / ((high - low) or 1.0)

    def set_ticks(self, ticks: Sequence[float], labels: Sequence[str] | None = None, *, rotation: float = 0.0) -> None:
        """Take ticks, and their labels turned by `rotation` degrees."""
        names = None if labels is None else [str(label) for label in labels]
        self.fixed_ticks, self.rotation = ([float(position) for position in ticks], names), rotation

    def ticks(self, length: float) -> list[tuple[float, str]]:
        """Return the ticks within both ends and their labels; length : of the side, in points."""
        low, high = sorted(self.limits())
        labels = None
        if self.fixed_ticks is not None:
            positions, labels = self.fixed_ticks
        elif self.tick_rule is not None:
            positions = self.tick_rule(low, high)
        elif self.is_log:
            positions = decades(low, high)
        else:
            intervals = max(2, min(_MAX_TICKS, int(length / _MIN_TICK_DISTANCE[self.axis_name])))
            positions = round_ticks(intervals)(low, high)
        names = labels if labels is not None else self._tick_labels(positions)
        margin, named = 1e-9 * (high - low), zip(positions, names, strict=True)
        return [(position, name) for position, name in named if low - margin <= position <= high + margin]

    def _tick_labels(self, positions: Sequence[float]) -> list[str]:
        if self.formatter is not None:
            return [self.formatter(position) for position in positions]
        if self.is_log:
            return [f"10{f'{round(math.log10(position))}'.translate(_SUPERSCRIPTS)}" for position in positions]
        step = min((b - a for a, b in itertools.pairwise(positions)), default=1.0) or 1.0
        largest = max(map(abs, positions), default=0.0)
        if largest >= 1e5 or 0.0 < step < 1e-4:
            rounded = (position if abs(position) > 1e-9 * largest else 0.0 for position in positions)
            return [wording.short_number_text(position, 4) for position in rounded]
        digits = next((d for d in range(8) if all(abs(round(p, d) - p) < 1e-6 * step for p in positions)), 8)
        return [f"{position + 0.0:.{digits}f}".replace("-", wording.MINUS) for position in positions]
