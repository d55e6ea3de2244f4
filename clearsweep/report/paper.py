"""The figures of a page as files for a paper: as wide as its column or its page, letters and fonts within."""

import contextlib
import io
import os
import re
import unicodedata
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib import rc_context
from matplotlib.text import Text

from ..language import phases
from ..language.errors import InputError
from ..store import durable
from .picture import STYLE, Picture, drawn
from .section import Section
from .table import in_markdown

FORMS = ("svg", "pdf", "png")
COLUMN, PAGE = 85.0, 170.0  # mm: what most journals set a figure in
WIDTHS = {"auto": None, "85": COLUMN, "170": PAGE}
LARGEST_TEXT = 8.0 / 9.0  # of its size on the page, where it is 9 points: journals ask for 6 to 8
HIGHEST = 110.0  # mm, of a figure as wide as a page, unless its rows need more
DOTS = 600  # per inch, of PNG and of what is drawn as pixels within the others
INCH = 25.4  # mm
INDEX = "figures.md"
#: Letters of an SVG are outlines and those of a PDF an embedded TrueType font, as journals ask for.
FONTS: dict[Any, Any] = {"svg.fonttype": "path", "pdf.fonttype": 42, "svg.hashsalt": "paper"}
NO_DATE: dict[str, dict] = {
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
    "png": {},
}  # the same run gives the same bytes


class Wanted(NamedTuple):
    """Where figures go, as what and how wide."""

    directory: Path
    form: str = "svg"  # one of FORMS
    width: str = "auto"  # one of WIDTHS; auto: what takes two columns of the page is as wide as a page


def write(sections: Iterable[Section], wanted: Wanted) -> list[Path]:
    """Write every picture of sections under the name of what it shows, and a list of them; return the files.

    Raises InputError where form or width are none of those there are.
    """
    for given, known, what in ((wanted.form, FORMS, "format"), (wanted.width, WIDTHS, "width")):
        if given not in known:
            raise InputError(f"{what} of figures: found {given!r}; expected one of {', '.join(known)}")
    wanted.directory.mkdir(parents=True, exist_ok=True)
    lines, files = ["| file | figure | what it shows |", "| --- | --- | --- |"], []
    listed, opened = named(sections), phases.innermost()
    for number, (name, picture) in enumerate(listed):
        if opened:
            opened.note(share=number / len(listed))
        file = wanted.directory / f"{name}.{wanted.form}"
        durable.replace(file, image(picture, wanted.form, WIDTHS[wanted.width]))
        files.append(file)
        lines.append(f"| {file.name} | {_cell(picture.title)} | {_cell(f'{picture.caption} {picture.alt}')} |")
    durable.replace(wanted.directory / INDEX, ("\n".join(lines) + "\n").encode())
    return [*files, wanted.directory / INDEX]


def named(sections: Iterable[Section]) -> list[tuple[str, Picture]]:
    """Return every picture with its name, made of the section's key, the case's part and the title, each once."""
    pictures: dict[str, Picture] = {}
    for section in sections:
        for part, picture in section.pictures:
            name = _slug(f"{section.key} {part} {picture.title}")
            again = sum(known == name or re.fullmatch(rf"{name}-\d+", known) is not None for known in pictures)
            pictures[f"{name}-{again + 1}" if again else name] = picture
    return list(pictures.items())


def image(picture: Picture, form: str, width: float | None = None) -> bytes:
    """Return a picture as a file of a form, `width` mm wide; None: a column or a page, by its size on the page."""
    wide = width or (PAGE if picture.wide else COLUMN)
    size = wide / INCH, _height(picture, wide) / INCH
    shrunk = min(LARGEST_TEXT, size[0] / picture.size[0])
    with rc_context({**STYLE, **FONTS}):
        figure, _ = drawn(picture._replace(size=size))
        for text in figure.findobj(Text):
            text.set_fontsize(shrunk * float(text.get_fontsize()))
        stream = io.BytesIO()
        with _undated():
            figure.savefig(stream, format=form, dpi=DOTS, metadata=NO_DATE[form])
    return stream.getvalue()


@contextlib.contextmanager
def _undated() -> Iterator[None]:
    """Hide SOURCE_DATE_EPOCH, which matplotlib reads even where it writes no date."""
    given = os.environ.pop("SOURCE_DATE_EPOCH", None)
    try:
        yield
    finally:
        if given is not None:
            os.environ["SOURCE_DATE_EPOCH"] = given


def _height(picture: Picture, width: float) -> float:
    """Return how high (mm) a picture is that is so wide (mm)."""
    wide, high = picture.size
    return max(min(width * high / wide, HIGHEST), min(width / wide, INCH) * high)


def _slug(words: str) -> str:
    plain = unicodedata.normalize("NFKD", words).encode("ascii", "ignore").decode().lower()
    return re.sub(r"[^a-z0-9]+", "-", plain).strip("-")


def _cell(text: str) -> str:
    return in_markdown(text.strip())
