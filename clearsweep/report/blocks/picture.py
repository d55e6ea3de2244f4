"""A picture of the report: its description, its painter, and its form as an inline SVG."""

import functools
import html
import io
import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure

from .. import plot
from ..draw.style import BLUE, GREY, INK, PALE

STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",  # text stays text: searchable, read aloud, small
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.labelsize": 9,
    "legend.fontsize": 8,
    "legend.title_fontsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "axes.linewidth": 0.8,
    "axes.unicode_minus": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.use_mathtext": False,
}


COLUMN_WIDTH = 4.2  # inches, largest width of a picture in one column
LONG_CURVE = 1000  # characters of a curve's coordinates above which they are rounded more
#: Colours of a drawing -> colour variables of the page, which has a dark theme.
THEME_VARIABLES = {INK: "--ink", GREY: "--soft", PALE: "--line", BLUE.lower(): "--curve", "#ffffff": "--paper"}
THEME_VARIABLES["#f3f6f9"] = "--tint"  # the area of a journal
_COLOUR = re.compile(rf"((?:fill|stroke): )({'|'.join(THEME_VARIABLES)})\b")
_WHITE_TEXT = re.compile(r"(?<=; fill: )#ffffff(?=\")")  # white text on a dark cell of a map, in any theme
ANIMATION_TIME = 8  # s, duration of a dot's movement
ToPoints = Callable[[Any], np.ndarray]  # places in a picture's own units -> points from its upper left corner, (n, 2)


class MeasuringCanvas(FigureCanvasBase):
    """The canvas of a picture before it is saved, with one renderer for the text sizes of all pictures.

    A renderer caches text sizes, and the pictures of a page share most of their texts.
    """

    def get_renderer(self) -> RendererAgg:
        """Return the renderer that measures texts."""
        return _renderer(self.figure.dpi)


@functools.cache
def _renderer(dpi: float) -> RendererAgg:
    return RendererAgg(1, 1, dpi)


class Spot(NamedTuple):
    """A region of a picture with a tooltip and a link to its case; in the picture's own units."""

    low: tuple[float, float]  # lower left corner
    high: tuple[float, float]
    text: str
    case_id: str = ""  # '': several cases, or none


class Dot(NamedTuple):
    """A dot that moves over a picture when it is clicked, at constant pace; in the picture's own units."""

    points: np.ndarray  # (n, 2)
    colour: str


class Picture(NamedTuple):
    """One picture before it is drawn: `paint(axes)` draws it on matplotlib axes."""

    title: str
    caption: str
    alt: str  # alternative text for readers who cannot see it
    paint: Callable[[Any], None]
    size: tuple[float, float] = (4.2, 3.1)  # inches
    projection: str | None = None  # 'polar', '3d'; None: a plane
    spots: tuple[Spot, ...] = ()
    dots: tuple[Dot, ...] = ()
    played: bool = False  # whether the player of a page also shows it

    @property
    def is_wide(self) -> bool:
        """Return whether it is too wide for one column of a page or a journal."""
        return self.size[0] > COLUMN_WIDTH


def draw_figure(picture: Picture) -> tuple[Figure, Axes]:
    """Return a picture on a canvas of its size, and its axes."""
    figure = Figure(figsize=picture.size, dpi=150, layout="constrained")
    MeasuringCanvas(figure)
    axes = figure.subplots(subplot_kw={"projection": picture.projection})
    picture.paint(axes)
    return figure, axes


def lay_out_once(figure: Figure) -> None:
    """Lay out a canvas once: saving with a layout engine would draw it twice."""
    engine = figure.get_layout_engine()
    assert engine is not None
    engine.execute(figure)
    figure.set_layout_engine(None)


def draw_svg(picture: Picture, key: str) -> str:
    """Return a picture as an SVG element for a page: no metadata, ids prefixed with `key`, labelled by its text."""
    try:
        svg_text, to_points = _drawn_by_plot(picture, key)
    except plot.UnsupportedError:
        svg_text, to_points = _drawn_by_matplotlib(picture, key)
    svg_text = _COLOUR.sub(_theme_variable, _WHITE_TEXT.sub("white", svg_text))
    if picture.spots:
        svg_text = (
            svg_text.removesuffix("\n").removesuffix("</svg>") + _spot_elements(picture.spots, to_points) + "</svg>\n"
        )
    if picture.dots:
        svg_text = (
            svg_text.removesuffix("\n").removesuffix("</svg>") + _dot_elements(picture, to_points, key) + "</svg>\n"
        )
    role = "group" if any(spot.case_id for spot in picture.spots) else "img"  # an image contains no links
    return svg_text.replace("<svg ", f'<svg role="{role}" aria-label="{html.escape(picture.alt)}" ', 1)


def _drawn_by_plot(picture: Picture, key: str) -> tuple[str, ToPoints]:
    """Return a picture as SVG drawn by `plot`, and the mapping of its points."""
    sheet = plot.sheet_of(picture.size, picture.projection)
    picture.paint(sheet.axes)
    text, box = sheet.svg(key)

    def to_points(points: Any) -> np.ndarray:
        x, y = np.asarray(points, float).T
        return np.stack(sheet.axes.to_points(x, y, box), -1)

    return text, to_points


def _drawn_by_matplotlib(picture: Picture, key: str) -> tuple[str, ToPoints]:
    """Return a picture as SVG drawn by matplotlib, and the mapping of its points.

    Matplotlib draws spatial pictures, arrows and thousands of points.
    """
    with rc_context({**STYLE, "svg.hashsalt": key}):
        figure, axes = draw_figure(picture)
        lay_out_once(figure)
        stream = io.StringIO()
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = stream.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{key}-\1"', text)
    text = re.sub(r'(href="#|url\(#)', rf"\1{key}-", text)
    text = re.sub(r' (?:d|x|y)="[^"]+"', _round_coordinates, text)
    text = re.sub(r"\s*\n\s*", "\n", text)
    height_points, points_per_pixel = 72.0 * figure.get_figheight(), 72.0 / figure.dpi

    def to_points(points: Any) -> np.ndarray:
        return np.array([0.0, height_points]) + axes.transData.transform(points) * points_per_pixel * np.array(
            [1.0, -1.0]
        )

    return text, to_points


def _spot_elements(spots: tuple[Spot, ...], to_points: ToPoints) -> str:
    """Return spots as SVG elements.

    to_points : maps positions in the picture's own units to points from the upper left corner.
    """
    elements = []
    for spot in spots:
        (left, bottom), (right, top) = to_points([spot.low, spot.high])
        rectangle = (
            f'<rect class="spot" x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" '
            f'height="{bottom - top:.1f}"><title>{html.escape(spot.text)}</title></rect>'
        )
        elements.append(f'<a href="#case-{spot.case_id}">{rectangle}</a>' if spot.case_id else rectangle)
    return "\n".join(elements)


def capitalise(name: str) -> str:
    """Return a name with a capital, for a title; symbols, 'p99' and 'pV', are not changed."""
    return name if name.startswith(("p99", "pV")) else f"{name[0].upper()}{name[1:]}"


def _round_coordinates(attribute: re.Match[str]) -> str:
    """Return coordinates rounded to a hundredth of a point; those of long curves, which fill a page, to a tenth."""
    digits = 1 if len(attribute[0]) > LONG_CURVE else 2
    return re.sub(
        rf"\d+\.\d{{{digits + 1},}}",
        lambda number: f"{float(number[0]):.{digits}f}".rstrip("0").rstrip("."),
        attribute[0],
    )


def _theme_variable(colour: re.Match[str]) -> str:
    """Return a colour of a style as a colour variable of the page."""
    return f"{colour[1]}var({THEME_VARIABLES[colour[2]]}, {colour[2]})"


def _dot_elements(picture: Picture, to_points: ToPoints, key: str) -> str:
    """Return the dots of a picture as SVG: they move once over their positions when the picture is clicked."""
    (width, height), parts = (72.0 * inches for inches in picture.size), []
    for dot in picture.dots:
        coordinates = dict(zip(("cx", "cy"), to_points(dot.points).T, strict=True))
        start_attributes = " ".join(f'{name}="{points[0]:.1f}"' for name, points in coordinates.items())
        animations = "".join(
            f'<animate attributeName="{name}" values="{";".join(f"{x:.1f}" for x in points)}" dur="{ANIMATION_TIME}s" '
            f'begin="{key}-play.click"/>'
            for name, points in coordinates.items()
        )
        parts.append(f'<circle {start_attributes} r="3.5" fill="{dot.colour}">{animations}</circle>')
    click_area = f'<rect id="{key}-play" width="{width:g}" height="{height:g}" fill="none" pointer-events="all"/>'
    return "".join([*parts, click_area])
