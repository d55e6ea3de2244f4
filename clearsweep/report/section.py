"""A section of the report, and the blocks of which sections are made; the page has one form for each kind of block."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from .picture import Picture
from .table import Table


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
    """The largest figures at a glance: name, value with unit, what it is compared with."""

    cards: list[tuple[str, str, str]]


class Gallery(NamedTuple):
    """Pictures side by side, under a note on how to read them."""

    note: str
    pictures: list[Picture]
    small: bool = False


class Detail(NamedTuple):
    """One case: why it is shown, its id, its settings in words, its figures (name, value with unit), its pictures."""

    why: str
    case_id: str
    setting: str
    figures: list[tuple[str, str]]
    pictures: list[Picture]
    moving: "Interactive | None" = None
    key: str = "motion"  # of what is shown of it, on this page once for each case
    played: tuple[Picture, ...] = ()  # of what `moving` shows: for files alone


class Facts(NamedTuple):
    """Names and values in two columns, under a heading."""

    title: str
    label: str  # for a reader who cannot see the heading
    rows: list[tuple[str, str]]


class Interactive(NamedTuple):
    """Data for a script of the page, and the text for readers without scripts."""

    kind: str  # 'explorer', 'player' or 'worn': the script of that name
    key: str  # of the data
    label: str  # for a reader who cannot see it
    data: dict[str, Any]  # as JSON contains it
    without: str  # '' where the page shows the same by other means


class Columns(NamedTuple):
    """Blocks in columns side by side, where the page is wide enough."""

    columns: tuple[list["Block"], ...]


Block = Sentences | Points | Note | Cards | Gallery | Detail | Facts | Interactive | Columns | Table


class Section(NamedTuple):
    """One section: its id on the page, its heading ('': none), and what is in it from the top down."""

    key: str
    title: str
    blocks: list[Block]
    subject: str = ""  # under which it is folded at the end of the page; '': seen at once
    second: bool = False  # whether it is in the second column of a wide page

    @property
    def tables(self) -> list[Table]:
        """Return the tables of the section: those that are written as CSV."""
        return [block for block in self.blocks if isinstance(block, Table)]

    @property
    def pictures(self) -> list[tuple[str, Picture]]:
        """Return the pictures of the section, each with the part of it that it is in: '', or a case's."""
        return [picture for block in self.blocks for picture in _pictures(block)]

    @property
    def sentences(self) -> list[str]:
        """Return the paragraphs of the section."""
        return [text for block in self.blocks if isinstance(block, Sentences) for text in block.texts]

    @property
    def moves(self) -> bool:
        """Return whether the section has anything for scripts."""
        return any(
            isinstance(block, Interactive) or (isinstance(block, Detail) and block.moving) for block in self.blocks
        )


class Part(NamedTuple):
    """What a section says about one question."""

    sentences: list[str]
    pictures: list[Picture]
    tables: list[Table]

    def blocks(self) -> list[Block]:
        """Return sentences, pictures and tables in this order, without those that are empty."""
        return filled([Sentences(self.sentences), Gallery("", self.pictures), *self.tables])


def filled(blocks: Iterable[Block]) -> list[Block]:
    """Return the blocks that have anything to show."""
    return [block for block in blocks if _size(block)]


def _pictures(block: Block) -> list[tuple[str, Picture]]:
    match block:
        case Gallery():
            return [("", picture) for picture in block.pictures]
        case Detail():
            return [(block.why, picture) for picture in (*block.pictures, *block.played)]
        case Columns():
            return [inside for column in block.columns for inner in column for inside in _pictures(inner)]
        case _:
            return []


def _size(block: Block) -> int:
    """Return how many things a block shows."""
    match block:
        case Table() | Facts():
            return len(block.rows)
        case Gallery():
            return len(block.pictures)
        case Sentences() | Points():
            return len(block.texts)
        case _:
            return 1
