"""Pictures, sections and blocks of the report (the page has a macro for each kind), and its interactive parts."""

import base64
import functools
import hashlib
import html
import json
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import ArrayLike

from .. import plot
from ..draw import BLUE, GREY, INK, PALE
from ..plot.items import Box
from .table import Table

COLUMN_WIDTH = 4.2  # inches, largest width of a picture in one column
FLAT_SIZE, SQUARE_SIZE = (4.2, 3.3), (4.2, 3.05)  # inches; a square next to a colour bar is as wide as it is high
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

    svg_text = _COLOUR.sub(
        lambda match: f"{match[1]}var({THEME_VARIABLES[match[2]]}, {match[2]})", _WHITE_TEXT.sub("white", svg_text)
    ).removesuffix("</svg>\n")
    if picture.spots:
        svg_text += _spot_elements(picture.spots, to_points)
    if picture.dots:
        svg_text += _dot_elements(picture, to_points, id_prefix)
    role = "group" if any(spot.case_id for spot in picture.spots) else "img"  # an image contains no links
    labelled = f'<svg role="{role}" aria-label="{html.escape(picture.alt)}" '
    return svg_text.replace("<svg ", labelled, 1) + "</svg>\n"


def painted(picture: Picture) -> tuple[plot.Sheet, Box]:
    """Return the sheet with a picture, and the position of its axes."""
    sheet = plot.Sheet(picture.size)
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


# A section of the report, and its blocks; the page has one macro for each kind of block.


class Sentences(NamedTuple):
    """Paragraphs; text is escaped unless it is Markup."""

    texts: list[str]


class Points(NamedTuple):
    """A list of sentences."""

    texts: list[str]


class Note(NamedTuple):
    """A remark in small print."""

    text: str


class Cards(NamedTuple):
    """The largest figures at a glance: name, value with unit, reference value."""

    cards: list[tuple[str, str, str]]


class Gallery(NamedTuple):
    """Pictures side by side, under a note on how to read them."""

    note: str
    pictures: list[Picture]
    small: bool = False


class Detail(NamedTuple):
    """One case: reason for showing it, id, settings in words, figures (name, value with unit), pictures."""

    reason: str
    case_id: str
    setting: str
    figures: list[tuple[str, str]]
    pictures: list[Picture]
    player: "Interactive | None" = None  # the case in motion
    key: str = "motion"  # prefix of the id of the block on the page
    player_pictures: tuple[Picture, ...] = ()  # shown by the player as well: only for files
    note: str = ""  # below the figures


class Facts(NamedTuple):
    """Names and values in two columns, under a heading."""

    title: str
    label: str  # for readers who cannot see the heading
    rows: list[tuple[str, str]]


class Interactive(NamedTuple):
    """Data for a script of the page, and the text for readers without scripts."""

    kind: str  # 'explorer', 'player' or 'worn': the script of that name
    key: str  # of the data
    label: str  # for readers who cannot see it
    data: dict[str, Any]  # JSON content
    without: str  # '' if the page shows the same by other means


class Columns(NamedTuple):
    """Blocks side by side, if the page is wide enough."""

    columns: tuple[list["Block"], ...]


Block = Sentences | Points | Note | Cards | Gallery | Detail | Facts | Interactive | Columns | Table


class Section(NamedTuple):
    """One section: its id on the page, its heading ('' for none), and its blocks from top to bottom."""

    key: str
    title: str
    blocks: list[Block]
    subject: str = ""  # heading under which it is folded at the end of the page; '': not folded
    second: bool = False  # whether it is in the second column of a wide page

    @property
    def tables(self) -> list[Table]:
        """Return the tables of the section, which are written as CSV."""
        return [block for block in self.blocks if isinstance(block, Table) and block.is_file]

    @property
    def pictures(self) -> list[tuple[str, Picture]]:
        """Return the pictures of the section, each with the case to which it belongs, or '' for none."""
        return [picture for block in self.blocks for picture in _pictures(block)]

    @property
    def sentences(self) -> list[str]:
        """Return the paragraphs of the section."""
        return [text for block in self.blocks if isinstance(block, Sentences) for text in block.texts]

    @property
    def has_scripts(self) -> bool:
        """Return whether the section contains data for scripts."""
        return any(
            isinstance(block, Interactive) or (isinstance(block, Detail) and block.player) for block in self.blocks
        )


class Part(NamedTuple):
    """Result of a section for one question."""

    sentences: list[str]
    pictures: list[Picture]
    tables: list[Table]

    def blocks(self) -> list[Block]:
        """Return sentences, pictures and tables in this order, without empty ones."""
        return without_empty([Sentences(self.sentences), Gallery("", self.pictures), *self.tables])


def section(key: str, title: str, *blocks: Block) -> list[Section]:
    """Return a section of those blocks that are not empty, in a list."""
    return [Section(key, title, without_empty(blocks))]


def without_empty(blocks: Iterable[Block]) -> list[Block]:
    """Return the blocks that are not empty."""
    return [block for block in blocks if _item_count(block)]


def _pictures(block: Block) -> list[tuple[str, Picture]]:
    """Return the pictures of a block, each with the reason for its case, or ''."""
    match block:
        case Gallery():
            return [("", picture) for picture in block.pictures]
        case Detail():
            return [(block.reason, picture) for picture in (*block.pictures, *block.player_pictures)]
        case Columns():
            return [picture for column in block.columns for inner_block in column for picture in _pictures(inner_block)]
        case _:
            return []


def _item_count(block: Block) -> int:
    """Return the number of items in a block."""
    match block:
        case Table() | Facts():
            return len(block.rows)
        case Gallery():
            return len(block.pictures)
        case Sentences() | Points():
            return len(block.texts)
        case _:
            return 1


# The interactive parts of a page: its scripts, and the encoding of their data.
#
# All scripts are inline, so that a page opens without a network; its security policy blocks all others.  uPlot (MIT
# licence, next to it in `vendor`) draws the curves.

FOLDER = Path(__file__).parent
#: Files of the page's one script, in order; those of `vendor` are unmodified.
SCRIPTS = (
    "vendor/uPlot.iife.min.js",
    *(f"script/{name}.js" for name in ("common", "explorer", "player", "worn", "cells", "start")),
)
STYLES = ("vendor/uPlot.min.css",)


class Script(NamedTuple):
    """The script of a page, and its hash in the security policy."""

    text: Markup
    hash: str


@functools.cache
def page_script() -> Script:
    """Return the script of pages with interactive parts."""
    text = "\n".join((FOLDER / name).read_text(encoding="utf-8").strip() for name in SCRIPTS)
    return Script(Markup(text), base64.b64encode(hashlib.sha256(text.encode()).digest()).decode())


def style_sheets() -> Markup:
    """Return the style sheets of the scripts."""
    return Markup("\n".join((FOLDER / name).read_text(encoding="utf-8").strip() for name in STYLES))


def encode_floats(values: ArrayLike) -> str:
    """Return numbers as little-endian 32-bit floats in base 64: seven digits in 5.3 characters."""
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode()


def safe_json(content: dict[str, Any]) -> Markup:
    """Return content as JSON that is safe in a script element for any text."""
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), sort_keys=True, allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace("&", "\\u0026"))
