"""A drawing of `plot` as a file: its SVG as PDF, as PNG, or as SVG whose letters are outlines, by matplotlib.

Only this module knows matplotlib.  It reads the elements that `plot` writes: rect, path, circle, ellipse, image, text
and groups.
"""

import base64
import io
import re
from typing import Any
from xml.etree import ElementTree

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.image import BboxImage, imread
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, Bbox, TransformedBbox

#: Letters are outlines in an SVG and an embedded TrueType font in a PDF, as journals require.
SETTINGS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "pdf.fonttype": 42,
    "savefig.bbox": None,
    "svg.fonttype": "path",
    "svg.hashsalt": "clearsweep",
    "text.usetex": False,
}
#: Metadata by form: no date, since the bytes depend only on the run, and the mark of `durable.check_output`.
MARKS: dict[str, dict] = {
    "svg": {"Date": None, "Creator": "clearsweep"},
    "pdf": {"CreationDate": None, "Creator": "clearsweep"},
    "png": {"Software": "clearsweep"},
}
_ALIGNMENTS = {"start": "left", "middle": "center", "end": "right"}
_STEPS = re.compile(r"([MLhvlZ])([^MLhvlZ]*)")


def file_bytes(svg: str, form: str, scale: float, dots_per_inch: int) -> bytes:
    """Return a drawing, `scale` times its size, as the bytes of a file of a form of MARKS."""
    root = ElementTree.fromstring(svg)
    width, height = (scale / 72.0 * float(str(root.get(side)).removesuffix("pt")) for side in ("width", "height"))
    stream = io.BytesIO()
    with rc_context(SETTINGS):
        figure = Figure(figsize=(width, height), dpi=dots_per_inch)
        _Drawing(figure, scale).add(root, (0.0, 0.0))
        figure.savefig(stream, format=form, dpi=dots_per_inch, metadata=MARKS[form])
    return stream.getvalue()


class _Drawing:
    """A figure to which the elements of an SVG are added, in their order."""

    def __init__(self, figure: Figure, scale: float):
        self.figure, self.scale = figure, scale
        self.clips: dict[str, Path] = {}
        self.clip: tuple[Path, Affine2D] | None = None
        self.is_smooth, self.count = True, 0

    def add(self, element: ElementTree.Element, origin: tuple[float, float]) -> None:
        """Add an element and those in it; origin : points from the upper left corner."""
        name = element.tag.rpartition("}")[2]
        match name:
            case "svg" | "g":
                self._add_group(element, origin)
            case "clipPath":
                self.clips[f"url(#{element.get('id')})"] = _shape(element[0])
            case "text":
                self._add_text(element, origin)
            case "image":
                self._add_image(element, origin)
            case _:
                self._add_shape(element, origin)

    def _add_group(self, element: ElementTree.Element, origin: tuple[float, float]) -> None:
        outer, was_smooth = self.clip, self.is_smooth
        if moved := re.match(r"translate\(([-\d.]+) ([-\d.]+)\)", element.get("transform", "")):
            origin = origin[0] + float(moved[1]), origin[1] + float(moved[2])
        if clip := self.clips.get(element.get("clip-path", "")):
            self.clip = clip, self._placement(origin)
        self.is_smooth &= element.get("shape-rendering") != "crispEdges"
        for child in element:
            self.add(child, origin)
        self.clip, self.is_smooth = outer, was_smooth

    def _placement(self, origin: tuple[float, float]) -> Any:
        """Return the transform of points from an origin to the canvas."""
        inches = Affine2D().translate(*origin).scale(self.scale / 72.0, -self.scale / 72.0)
        return inches.translate(0.0, self.figure.get_figheight()) + self.figure.dpi_scale_trans

    def _draw(self, artist: Artist) -> None:
        """Draw an artist over all others, within the present clip."""
        self.count += 1
        artist.set_zorder(self.count)
        self.figure.add_artist(artist)
        if self.clip:
            artist.set_clip_path(*self.clip)

    def _add_shape(self, element: ElementTree.Element, origin: tuple[float, float]) -> None:
        style, placement = _style(element), self._placement(origin)
        width = self.scale * float(style.get("stroke-width", 1.0))
        stroke = _colour(style, "stroke")
        if style.get("stroke-linecap") == "round" and "h0" in element.get("d", ""):  # points
            points = np.array([place.split() for place in re.findall(r"M([^h]+)h0", element.get("d", ""))], float)
            line = Line2D(*points.T, linestyle="", marker="o", markersize=width, markeredgewidth=0.0, color=stroke)
            line.set_transform(placement)
            self._draw(line)
            return
        patch = PathPatch(
            _shape(element),
            facecolor=_colour(style, "fill"),
            edgecolor=stroke,
            linewidth=width if stroke != "none" else 0.0,
            capstyle={"round": "round", "square": "projecting"}.get(style.get("stroke-linecap", ""), "butt"),
            joinstyle="round" if style.get("stroke-linejoin") == "round" else "miter",
            antialiased=self.is_smooth,
        )
        if dash := style.get("stroke-dasharray"):
            lengths = [self.scale * float(length) / width for length in dash.split()]  # in line widths
            patch.set_linestyle((0.0, lengths))
        patch.set_transform(placement)
        self._draw(patch)

    def _add_image(self, element: ElementTree.Element, origin: tuple[float, float]) -> None:
        address = element.get("href", "").partition(",")[2]
        x, y, width, height = (float(element.get(name, 0.0)) for name in ("x", "y", "width", "height"))
        corners = self._placement(origin).transform([[x, y + height], [x + width, y]])
        inches = Bbox(corners / self.figure.dpi)
        is_pixelated = "pixelated" in element.get("style", "")
        image = BboxImage(
            TransformedBbox(inches, self.figure.dpi_scale_trans),
            interpolation="nearest" if is_pixelated else "bilinear",
            origin="upper",
        )
        image.set_data(imread(io.BytesIO(base64.b64decode(address))))
        self._draw(image)

    def _add_text(self, element: ElementTree.Element, origin: tuple[float, float]) -> None:
        style = _style(element)
        turn = re.match(r"rotate\(([-\d.]+)", element.get("transform", ""))
        y = float(element.get("y", 0.0))
        for line in list(element) or [element]:
            y += float(line.get("dy", 0.0))
            place = self._placement(origin).transform((float(element.get("x", 0.0)), y)) / self.figure.dpi
            self.count += 1
            self.figure.text(
                float(place[0]),
                float(place[1]),
                line.text or "",
                transform=self.figure.dpi_scale_trans,
                fontsize=self.scale * float(style["font-size"].removesuffix("px")),
                fontweight=style.get("font-weight", "normal"),
                color=_colour(style, "fill"),
                ha=_ALIGNMENTS[style.get("text-anchor", "start")],
                va="baseline",
                rotation=-float(turn[1]) if turn else 0.0,
                rotation_mode="anchor",
                parse_math=False,
                zorder=self.count,
            )


def _style(element: ElementTree.Element) -> dict[str, str]:
    """Return the declarations of an element's style."""
    declarations = (text.partition(":") for text in element.get("style", "").split(";") if text.strip())
    return {name.strip(): value.strip() for name, _, value in declarations}


def _colour(style: dict[str, str], name: str) -> Any:
    """Return a colour of a style with its opacity, or 'none'."""
    default = "#000000" if name == "fill" else "none"
    colour = style.get(name, default)
    return "none" if colour == "none" else (colour, float(style.get(f"{name}-opacity", 1.0)))


def _shape(element: ElementTree.Element) -> Path:
    """Return the outline of a rect, circle, ellipse or path, in points."""
    numbers = {name: float(value) for name, value in element.items() if re.fullmatch(r"-?[\d.]+", value)}
    name = element.tag.rpartition("}")[2]
    if name == "path":
        return _path(element.get("d", ""))
    if name == "rect":
        size = Affine2D().scale(numbers["width"], numbers["height"])
        return Path.unit_rectangle().transformed(size.translate(numbers.get("x", 0.0), numbers.get("y", 0.0)))
    radii = (numbers["r"], numbers["r"]) if name == "circle" else (numbers["rx"], numbers["ry"])
    return Path.unit_circle().transformed(Affine2D().scale(*radii).translate(numbers["cx"], numbers["cy"]))


def _path(steps: str) -> Path:
    """Return the path of the steps M, L, h, v, l and Z of SVG."""
    vertices, codes, start, place = [], [], (0.0, 0.0), (0.0, 0.0)
    for step, text in _STEPS.findall(steps):
        numbers = [float(number) for number in text.split()]
        if step in "hvl":
            right, down = (numbers[0] if step in "hl" else 0.0), (numbers[-1] if step in "vl" else 0.0)
            place = place[0] + right, place[1] + down
        else:
            place = start if step == "Z" else (numbers[0], numbers[1])
        start = place if step == "M" else start
        vertices.append(place)
        codes.append({"M": Path.MOVETO, "Z": Path.CLOSEPOLY}.get(step, Path.LINETO))
    return Path(np.array(vertices, float).reshape(-1, 2), codes)
