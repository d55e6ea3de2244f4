"""A picture of the report: its description, its painter, and its form as an inline SVG."""

import html
import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .. import plot
from ..draw import BLUE, GREY, INK, PALE
from ..plot.items import Box

COLUMN_WIDTH = 4.2  # inches, largest width of a picture in one column
#: Colours of a drawing -> colour variables of the page, which has a dark theme.
THEME_VARIABLES = {INK: "--ink", GREY: "--soft", PALE: "--line", BLUE.lower(): "--curve", "#ffffff": "--paper"}
THEME_VARIABLES["#f3f6f9"] = "--tint"  # the area of a journal
_COLOUR = re.compile(rf"((?:fill|stroke): )({'|'.join(THEME_VARIABLES)})\b")
_WHITE_TEXT = re.compile(r"(?<=; fill: )#ffffff(?=\")")  # white text on a dark cell of a map, in any theme
ANIMATION_TIME = 8  # s, duration of a dot's movement
#: Positions (n, 2) in a picture's own units -> points from its upper left corner, (n, 2).
ToPoints = Callable[[Any], np.ndarray]


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
    """One picture before it is drawn: `paint(axes)` draws it on axes of `plot`."""

    title: str
    caption: str
    alt: str  # alternative text for readers who cannot see it
    paint: Callable[[plot.Axes], None]
    size: tuple[float, float] = (4.2, 3.1)  # inches
    is_polar: bool = False  # its abscissa is an angle
    spots: tuple[Spot, ...] = ()
    dots: tuple[Dot, ...] = ()
    shown_in_player: bool = False  # whether the player of a page also shows it

    @property
    def is_wide(self) -> bool:
        """Return whether it is too wide for one column of a page or a journal."""
        return self.size[0] > COLUMN_WIDTH


def draw_svg(picture: Picture, id_prefix: str) -> str:
    """Return a picture as an SVG element for a page: ids prefixed with `id_prefix`, labelled by its text."""
    sheet, box = painted(picture)
    svg_text = sheet.svg(id_prefix, box)

    def to_points(points: Any) -> np.ndarray:
        x, y = np.asarray(points, float).T
        return np.stack(sheet.axes.to_points(x, y, box), -1)

    svg_text = _COLOUR.sub(_theme_variable, _WHITE_TEXT.sub("white", svg_text)).removesuffix("</svg>\n")
    if picture.spots:
        svg_text += _spot_elements(picture.spots, to_points)
    if picture.dots:
        svg_text += _dot_elements(picture, to_points, id_prefix)
    role = "group" if any(spot.case_id for spot in picture.spots) else "img"  # an image contains no links
    labelled = f'<svg role="{role}" aria-label="{html.escape(picture.alt)}" '
    return svg_text.replace("<svg ", labelled, 1) + "</svg>\n"


def painted(picture: Picture) -> tuple[plot.Sheet, Box]:
    """Return the sheet with a picture, and the position of its axes."""
    sheet = plot.make_sheet(picture.size, is_polar=picture.is_polar)
    picture.paint(sheet.axes)
    return sheet, sheet.box()


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


def _theme_variable(colour: re.Match[str]) -> str:
    """Return a colour of a style as a colour variable of the page."""
    return f"{colour[1]}var({THEME_VARIABLES[colour[2]]}, {colour[2]})"


def _dot_elements(picture: Picture, to_points: ToPoints, id_prefix: str) -> str:
    """Return the dots of a picture as SVG: they move once over their positions when the picture is clicked."""
    (width, height), parts = (72.0 * inches for inches in picture.size), []
    for dot in picture.dots:
        coordinates = dict(zip(("cx", "cy"), to_points(dot.points).T, strict=True))
        start_attributes = " ".join(f'{name}="{points[0]:.1f}"' for name, points in coordinates.items())
        animations = "".join(
            f'<animate attributeName="{name}" values="{";".join(f"{x:.1f}" for x in points)}" dur="{ANIMATION_TIME}s" '
            f'begin="{id_prefix}-play.click"/>'
            for name, points in coordinates.items()
        )
        parts.append(f'<circle {start_attributes} r="3.5" fill="{dot.colour}">{animations}</circle>')
    click_area = f'<rect id="{id_prefix}-play" width="{width:g}" height="{height:g}" fill="none" pointer-events="all"/>'
    return "".join([*parts, click_area])
