"""Sections of the report, their blocks (the page has one macro for each kind), and the page's interactive parts."""

import base64
import functools
import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import ArrayLike

from .picture import Picture
from .table import Table

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
