"""Pictures of the report drawn by matplotlib: files of figures, and what the axes of `plot` cannot draw."""

import functools
import io
import re
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure

from ..draw.style import GREY, INK

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

LONG_CURVE = 1000  # characters of a curve's coordinates above which they are rounded more


class Drawable(Protocol):
    """The fields of a picture that matplotlib needs."""

    @property
    def paint(self) -> Callable[[Any], None]:
        """Return the function that draws on axes."""

    @property
    def size(self) -> tuple[float, float]:
        """Return width and height in inches."""

    @property
    def projection(self) -> str | None:
        """Return the projection of the axes: 'polar', '3d', or None for a plane."""


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


def draw_figure(picture: Drawable) -> tuple[Figure, Axes]:
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


def draw_svg(picture: Drawable, id_prefix: str) -> tuple[str, Callable[[Any], np.ndarray]]:
    """Return a picture as SVG with ids prefixed with `id_prefix`, and the mapping of its own units to points."""
    with rc_context({**STYLE, "svg.hashsalt": id_prefix}):
        figure, axes = draw_figure(picture)
        lay_out_once(figure)
        stream = io.StringIO()
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = stream.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{id_prefix}-\1"', text)
    text = re.sub(r'(href="#|url\(#)', rf"\1{id_prefix}-", text)
    text = re.sub(r' (?:d|x|y)="[^"]+"', _round_coordinates, text)
    text = re.sub(r"\s*\n\s*", "\n", text)
    height_points, points_per_pixel = 72.0 * figure.get_figheight(), 72.0 / figure.dpi

    def to_points(points: Any) -> np.ndarray:
        return np.array([0.0, height_points]) + axes.transData.transform(points) * points_per_pixel * np.array(
            [1.0, -1.0]
        )

    return text, to_points


def _round_coordinates(attribute: re.Match[str]) -> str:
    """Return coordinates rounded to a hundredth of a point; those of long curves, which fill a page, to a tenth."""
    digits = 1 if len(attribute[0]) > LONG_CURVE else 2
    return re.sub(
        rf"\d+\.\d{{{digits + 1},}}",
        lambda number: f"{float(number[0]):.{digits}f}".rstrip("0").rstrip("."),
        attribute[0],
    )
